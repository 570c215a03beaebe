// Motor parameters: range checks, and conversions by hand-computed values and round trips.
#include "support/fields.h"

#include "lodestar/motor.h"

void setUp(void) {}

void tearDown(void) {}

// One float product and one quotient of rounded constants.
#define ROUNDING 5.0e-7

static lode_status_t try_one(size_t offset, float value) {
    lode_motor_t motor = paper_motor();
    field_set(&motor, offset, value);
    return lode_motor_check(&motor);
}

static void test_every_field_at_its_limits(void) {
    static const field_t fields[] = {
        {FIELD(lode_motor_t, Rs_Ohm), .lo = 0.0f, .hi = 1.0e3f, .error = LODE_ERROR_MOTOR_RS},
        {FIELD(lode_motor_t, Ld_H), .lo = 1.0e-7f, .hi = 10.0f, .error = LODE_ERROR_MOTOR_LD},
        {FIELD(lode_motor_t, Lq_H), .lo = 1.0e-7f, .hi = 10.0f, .error = LODE_ERROR_MOTOR_LQ},
        {FIELD(lode_motor_t, psi_Wb), .lo = 1.0e-6f, .hi = 100.0f, .error = LODE_ERROR_MOTOR_PSI},
        {FIELD(lode_motor_t, J_kgm2), .lo = 1.0e-9f, .hi = 1.0e4f, .error = LODE_ERROR_MOTOR_J},
        {FIELD(lode_motor_t, B_Nms), .lo = 0.0f, .hi = 1.0e3f, .error = LODE_ERROR_MOTOR_B},
        {FIELD(lode_motor_t, omega_rated_rad_s), .lo = 1.0f, .hi = 1.0e5f,
         .error = LODE_ERROR_MOTOR_OMEGA, .zero_is_auto = true},
    };
    field_check_all(fields, COUNT_OF(fields), try_one);
}

static void test_pole_pairs_are_a_whole_number(void) {
    const float good[] = {1.0f, 2.0f, 21.0f, 100.0f};
    const float bad[] = {0.0f,   -1.0f,   0.5f, 1.5f,     2.999f,   101.0f,
                         100.5f, FLT_MAX, NAN,  INFINITY, -INFINITY};
    const size_t offset = offsetof(lode_motor_t, pole_pairs);
    for (int i = 0; i < COUNT_OF(good); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, good[i]));
    }
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_POLE_PAIRS, try_one(offset, bad[i]));
    }
}

static void test_sets_are_one_or_two(void) {
    const size_t offset = offsetof(lode_motor_t, sets);
    const float good[] = {0.0f, 1.0f, 2.0f};
    const float bad[] = {-1.0f, 0.5f, 1.5f, 3.0f, NAN, INFINITY};
    for (int i = 0; i < COUNT_OF(good); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, good[i]));
    }
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_SETS, try_one(offset, bad[i]));
    }
    lode_motor_t motor = paper_motor();
    motor.sets = 2.0f;
    CHECK_CLOSE(ROUNDING, 2.0 * 0.639, lode_motor_kt_Nm_A(&motor));
}

static void test_null_is_refused(void) {
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_motor_check(NULL));
}

static void test_torque_and_active_flux(void) {
    const lode_motor_t motor = paper_motor();
    // 1.5 * 3 * 0.142 Nm/A.
    CHECK_CLOSE(ROUNDING, 0.639, lode_motor_kt_Nm_A(&motor));
    // To 157 rad/s of the shaft with 7.668 Nm.
    CHECK_CLOSE(ROUNDING, 0.0174 * PAPER_OMEGA_RATED / 3.0 / (12.0 * 0.639),
                lode_motor_run_up_s(&motor, 12.0f));
    // (3.5 mH - 9.8 mH) * -2 A + 0.142 Vs.
    CHECK_CLOSE(ROUNDING, 0.1546, lode_motor_active_flux_Wb(&motor, -2.0f));
    // 4.5 * 0.1546 * 7.
    CHECK_CLOSE(ROUNDING, 4.8699, lode_motor_torque_Nm(&motor, (lode_dq_t){-2.0f, 7.0f}));
    CHECK_CLOSE(ROUNDING, -4.8699, lode_motor_torque_Nm(&motor, (lode_dq_t){-2.0f, -7.0f}));
    CHECK_CLOSE(ROUNDING, 4.5 * (0.142 - 6.3e-3 * 3.0) * 7.0,
                lode_motor_torque_Nm(&motor, (lode_dq_t){3.0f, 7.0f}));
}

static void test_resistance_and_inductance_of_a_phase(void) {
    CHECK_CLOSE(ROUNDING, 0.75, lode_phase_from_line_line(1.5f));
    CHECK_CLOSE(ROUNDING, 1.5, lode_phase_from_winding(1.5f, LODE_STAR));
    CHECK_CLOSE(ROUNDING, 0.5, lode_phase_from_winding(1.5f, LODE_DELTA));
    // Three 1.5 Ohm windings in delta show 1.5 || 3.0 = 1.0 Ohm between terminals.
    CHECK_CLOSE(ROUNDING, lode_phase_from_winding(1.5f, LODE_DELTA),
                lode_phase_from_line_line(1.0f));
    // Two 1.5 Ohm windings of a star in series.
    CHECK_CLOSE(ROUNDING, lode_phase_from_winding(1.5f, LODE_STAR),
                lode_phase_from_line_line(3.0f));
}

static void test_voltage_constants_of_the_papers_motor(void) {
    // 1000 rpm and 3 pole pairs are 314.15927 rad/s: 44.610616 V peak per phase, 77.267854 V peak
    // and 54.636624 V RMS line to line; 12.9420 rpm per volt; 50 Hz make 0.89221231 V/Hz.
    CHECK_CLOSE(1.0e-6, 0.142, lode_psi_from_Vrms_krpm(54.636624f, 3.0f));
    CHECK_CLOSE(1.0e-6, 0.142, lode_psi_from_KV((float)(1000.0 / 77.267854), 3.0f));
    CHECK_CLOSE(1.0e-6, 0.142, lode_psi_from_V_Hz(0.89221231f));
    CHECK_CLOSE(1.0e-6, 0.142, lode_psi_from_kt(0.639f, 3.0f));
    CHECK_CLOSE(1.0e-6, 54.636624, lode_psi_to_Vrms_krpm(0.142f, 3.0f));
    CHECK_CLOSE(1.0e-6, 1000.0 / 77.267854, lode_psi_to_KV(0.142f, 3.0f));
    CHECK_CLOSE(1.0e-6, 0.89221231, lode_psi_to_V_Hz(0.142f));
}

static void test_voltage_constants_are_inverses(void) {
    random_t random = random_seed(1);
    for (int i = 0; i < 1000; i++) {
        const float psi = (float)pow(10.0, random_between(&random, -6.0, 2.0));
        const float pole_pairs = (float)(1 + (int)random_between(&random, 0.0, 99.99));
        CHECK_CLOSE(ROUNDING, psi, lode_psi_from_V_Hz(lode_psi_to_V_Hz(psi)));
        CHECK_CLOSE(ROUNDING, psi, lode_psi_from_KV(lode_psi_to_KV(psi, pole_pairs), pole_pairs));
        CHECK_CLOSE(ROUNDING, psi,
                    lode_psi_from_Vrms_krpm(lode_psi_to_Vrms_krpm(psi, pole_pairs), pole_pairs));
        lode_motor_t motor = paper_motor();
        motor.psi_Wb = psi;
        motor.pole_pairs = pole_pairs;
        CHECK_CLOSE(ROUNDING, psi, lode_psi_from_kt(lode_motor_kt_Nm_A(&motor), pole_pairs));
    }
}

static void test_speeds(void) {
    // 1500 rpm, 3 pole pairs: 75 Hz.
    CHECK_CLOSE(ROUNDING, 2.0 * CHECK_PI * 75.0, lode_omega_from_rpm(1500.0f, 3.0f));
    CHECK_CLOSE(ROUNDING, -1500.0, lode_omega_to_rpm((float)(-2.0 * CHECK_PI * 75.0), 3.0f));
    CHECK_CLOSE(ROUNDING, 12345.0, lode_omega_to_rpm(lode_omega_from_rpm(12345.0f, 7.0f), 7.0f));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_pole_pairs_are_a_whole_number);
    RUN_TEST(test_sets_are_one_or_two);
    RUN_TEST(test_null_is_refused);
    RUN_TEST(test_torque_and_active_flux);
    RUN_TEST(test_resistance_and_inductance_of_a_phase);
    RUN_TEST(test_voltage_constants_of_the_papers_motor);
    RUN_TEST(test_voltage_constants_are_inverses);
    RUN_TEST(test_speeds);
    return UNITY_END();
}
