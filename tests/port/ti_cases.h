/// What the two TI ports have in common, case by case. Included once, by the test of a chip, behind its
/// fake; that test has the functions below, SOURCES, the number of ways of a trip, and where the board has a
/// temperature sensor, PUT_T(count).
#ifndef TI_CASES_H
#define TI_CASES_H

#include "app.h"
#include "board.h"
#include "chip.h"
#include "figures.h"
#include "support/check.h"

#ifndef VARIANT_SENSING
#define VARIANT_SENSING PORT_LOW_SIDE_THREE
#endif

#define TRIP_A 1.0e3f // more than any board bears
#define IN_LINE (VARIANT_SENSING == PORT_IN_LINE_THREE || VARIANT_SENSING == PORT_IN_LINE_TWO)

// From one call to the next, and its interrupt.
static void one_period(void);
// To the counters' next turning point, without an interrupt.
static void next_turn(void);
static bool counts_down;
// By what the port has set: at the turning point that has come the ADCs are triggered, and ePWM x takes its
// compare value over, which is this one.
static bool is_triggered(void);
static bool is_taken_over(int x);
static uint32_t compare_shadow(int x);
static void change_compare(int x);
// The currents of the next period, with i_A in phase a.
static void put_counts(float i_A);
// One of the ways of a trip, on or off.
static void set_source(int n, bool active);
// In the next interrupt, by this check.
static void expect_gates_off_in_one_call(const char *check);

static uint32_t acting[3];

static void next_call(void) {
    do {
        next_turn();
        for (int x = 0; x < 3; x++) {
            acting[x] = is_taken_over(x) ? compare_shadow(x) : acting[x];
        }
    } while (!is_triggered());
}

#include "calls_cases.h"

static void gates_on_by_the_drive(void) {
    TEST_ASSERT_TRUE(app_start());
    put_counts(0.0f);
    app_mode = BRINGUP_SIGNS;
    app_armed = 1u;
    for (int n = 0; n < 60000 && !fake_gates_on(); n++) {
        one_period();
        app_poll();
    }
    TEST_ASSERT_TRUE(fake_gates_on());
    // Past the low sides alone, and without a fault they stay on.
    for (uint32_t n = 0; n < (uint32_t)(VARIANT_PRECHARGE_s * (float)PORT_F_CALL_Hz) + 4u; n++) {
        one_period();
    }
    TEST_ASSERT_TRUE(fake_gates_on());
}

// What a call writes acts from the next one on, in each half by itself. No value meets a turning point at which
// another one is taken over.
static void test_each_call_has_its_own_pulse(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    next_call();
    int upper = 0;
    for (int k = 0; k < COUNT_OF(duty_of_call); k++) {
        board_write(&(lode_drive_out_t){.duty = duty_of_call[k], .gates = LODE_GATES_ON});
        next_call();
        upper += counts_down ? 1 : 0;
        const float wanted[3] = {duty_of_call[k].a, duty_of_call[k].b, duty_of_call[k].c};
        for (int x = 0; x < 3; x++) {
            CHECK_NEAR(1.0 / STEPS, wanted[x], (double)(STEPS - acting[x]) / STEPS);
            TEST_ASSERT_TRUE(acting[x] >= 1u && acting[x] <= STEPS);
            TEST_ASSERT_TRUE(!VARIANT_DOUBLE_UPDATE || acting[x] < STEPS);
        }
    }
    TEST_ASSERT_EQUAL_INT(VARIANT_DOUBLE_UPDATE ? COUNT_OF(duty_of_call) / 2 : 0, upper);
}

// At the upper turning point no low side is on.
static void test_double_update_with_low_side_shunts_is_refused(void) {
    TEST_ASSERT_FALSE(app_start());
    TEST_ASSERT_EQUAL_STRING("LODE_ERROR_DOUBLE_UPDATE", lode_status_name(app_status()));
    for (int n = 0; n < 10; n++) {
        app_poll();
    }
    TEST_ASSERT_NOT_NULL(strstr(SERIAL_TEXT, "START FAIL LODE_ERROR_DOUBLE_UPDATE 0\r\n"));
    TEST_ASSERT_FALSE(fake_gates_on());
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
    for (uint32_t n = 0; n < PORT_F_CALL_Hz / 100u; n++) {
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
