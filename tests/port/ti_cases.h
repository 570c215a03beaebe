/// What the two TI ports have in common, case by case. Included once, by the test of a chip, behind its
/// fake; that test has the functions below, SOURCES, the number of ways of a trip, and where the board has a
/// temperature sensor, PUT_T(count).
#ifndef TI_CASES_H
#define TI_CASES_H

#include "app.h"
#include "board.h"
#include "chip.h"
#include "support/check.h"

#define TRIP_A 1.0e3f // more than any board bears

// One period of the timer and its interrupt.
static void one_period(void);
// The currents of the next period, with i_A in phase a.
static void put_counts(float i_A);
// One of the ways of a trip, on or off.
static void set_source(int n, bool active);
// In the next interrupt, by this check.
static void expect_gates_off_in_one_call(const char *check);

static void gates_on_by_the_drive(void) {
    TEST_ASSERT_TRUE(app_start());
    put_counts(0.0f);
    app_mode = BRINGUP_SIGNS;
    app_armed = 1u;
    for (int n = 0; n < 30000 && !fake_gates_on(); n++) {
        one_period();
        app_poll();
    }
    TEST_ASSERT_TRUE(fake_gates_on());
    // Past the low sides alone, and without a fault they stay on.
    for (uint32_t n = 0; n < (uint32_t)(VARIANT_PRECHARGE_s * (float)VARIANT_F_PWM_Hz) + 4u; n++) {
        one_period();
    }
    TEST_ASSERT_TRUE(fake_gates_on());
}

static void test_active_trip_at_power_up_is_a_failed_init(void) {
    for (int n = 0; n < SOURCES; n++) {
        fake_reset();
        set_source(n, true);
        TEST_ASSERT_FALSE(board_init(TRIP_A));
        TEST_ASSERT_FALSE(fake_gates_on());
    }
}

static void test_over_current_reaches_the_gates_in_the_same_call(void) {
    const float i_trip = 1.5f * lode_min(VARIANT_I_MAX_A, 5.0f); // of the example's motor
    gates_on_by_the_drive();
    put_counts(0.97f * i_trip); // the same, inside the limit
    one_period();
    TEST_ASSERT_TRUE(fake_gates_on());
    put_counts(1.07f * i_trip);
    expect_gates_off_in_one_call("LODE_CHECK_OVER_CURRENT");
}

static void test_hardware_trip_is_a_fault_in_the_same_call(void) {
    for (int n = 0; n < SOURCES; n++) {
        setUp();
        gates_on_by_the_drive();
        one_period();
        TEST_ASSERT_TRUE(fake_gates_on());
        set_source(n, true);
        set_source(n, false);
        expect_gates_off_in_one_call("LODE_CHECK_HARDWARE_TRIP");
    }
}

#ifdef PUT_T
static void put_temperature(float degC) {
    static const float points[][2] = {VARIANT_NTC_POINTS};
    for (int n = 1; n < COUNT_OF(points); n++) {
        if (points[n][0] >= degC) {
            const float part = (degC - points[n - 1][0]) / (points[n][0] - points[n - 1][0]);
            const float R_Ohm = points[n - 1][1] * powf(points[n][1] / points[n - 1][1], part);
            PUT_T((uint32_t)(R_Ohm / (R_Ohm + VARIANT_NTC_FIXED_Ohm) * VARIANT_COUNTS + 0.5f));
            return;
        }
    }
    TEST_FAIL_MESSAGE("beyond the table");
}

static void some_periods(void) {
    for (uint32_t n = 0; n < VARIANT_F_PWM_Hz / 100u; n++) {
        one_period();
    }
}

static void test_over_temperature_switches_off(void) {
    gates_on_by_the_drive();
    put_temperature(VARIANT_T_MAX_degC - 3.0f);
    some_periods();
    TEST_ASSERT_TRUE(fake_gates_on());
    put_temperature(VARIANT_T_MAX_degC + 3.0f);
    some_periods();
    TEST_ASSERT_TRUE(fake_all_tripped());
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OVER_TEMPERATURE",
                             lode_check_name((lode_check_t)app_telemetry().fault.check));
}

static void test_missing_sensor_is_too_hot(void) {
    gates_on_by_the_drive();
    PUT_T(4095u); // pulled up
    some_periods();
    TEST_ASSERT_TRUE(fake_all_tripped());
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OVER_TEMPERATURE",
                             lode_check_name((lode_check_t)app_telemetry().fault.check));
}
#endif

#endif
