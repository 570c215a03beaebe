// Current sensors that come to show another share of the current while a start is under way (S43).
#include "support/check.h"

#include "support/rig.h"

#include <float.h>

void setUp(void) {}

void tearDown(void) {}

static lode_drive_tuning_t tuning;

/// A start whose sensors come to show `gain` of the currents after `rounds` rounds of `stage`, in the period `late` of a round.
/// 20 ms later. `check_gain`: off, or on.
static rig_t after_gain_changes(lode_start_stage_t stage, int rounds, int late, double gain,
                                lode_choice_t check_gain) {
    lode_drive_config_t config = rig_config();
    config.guard.check_gain = check_gain;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    if (check_gain == LODE_ON) {
        tuning.plausibility.jump_V2 = 0.5f * FLT_MAX; // (K38) would come first
    }
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_begin(&rig.drive, &tuning));
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 30.0f});
    const int since = 8 * rounds + late;
    int seen = 0;
    for (int n = 0; n < 10000 && seen < since + 100; n++) {
        const bool starts = rig.drive.mode == (uint_least8_t)LODE_MODE_START;
        const bool there = starts && rig.drive.state.start.stage == (uint_least8_t)stage;
        seen += there || seen > 0 ? 1 : 0;
        lode_counts_t counts = rig_counts(&rig);
        for (int k = 0; k < LODE_PHASES && seen > since; k++) {
            counts.i[k] = rig_count(2048.0 + gain * ((double)counts.i[k] - 2048.0));
        }
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    TEST_ASSERT_EQUAL_INT(since + 100, seen);
    return rig;
}

/// Its fault.
static lode_fault_t gain_changes(lode_start_stage_t stage, int rounds, int late, double gain,
                                 lode_choice_t check_gain) {
    const rig_t rig = after_gain_changes(stage, rounds, late, gain, check_gain);
    return rig_telemetry(&rig).fault;
}

static void test_sensors_that_come_to_show_half_end_the_start(void) {
    const double gains[] = {0.3, 0.4, 0.5};
    for (int late = 0; late < 8; late++) {
        for (int k = 0; k < COUNT_OF(gains); k++) {
            const lode_fault_t turning =
                gain_changes(LODE_START_TURN, 150, late, gains[k], LODE_ON);
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_RESISTANCE", lode_check_name(turning.check));
            TEST_ASSERT_EQUAL_INT(LODE_MODE_START, turning.state);
            TEST_ASSERT_EQUAL_INT(LODE_START_TURN, turning.stage);
            CHECK_AT_LEAST((double)turning.limit, (double)turning.measured);
            CHECK_AT_LEAST(0.5 * 0.75, (double)turning.limit); // half of the impedance
            CHECK_AT_MOST(0.5 * hypot(0.75, 60.0 * 3.5e-3), (double)turning.limit);
        }
        const lode_fault_t rising = gain_changes(LODE_START_HALF, 60, late, 0.4, LODE_ON);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_RESISTANCE", lode_check_name(rising.check));
    }
}

static void test_sensors_that_come_to_show_most_do_not(void) {
    for (int late = 0; late < 8; late++) {
        const double gains[] = {
            0.7, 0.85, 1.0,
            1.5}; // 0.7 falls, and is back with less than half as much voltage again
        for (int k = 0; k < COUNT_OF(gains); k++) {
            TEST_ASSERT_EQUAL_INT(
                LODE_CHECK_NONE, gain_changes(LODE_START_TURN, 150, late, gains[k], LODE_ON).check);
        }
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE,
                          gain_changes(LODE_START_TURN, 150, 0, 0.4, LODE_OFF).check);
}

/// Half of the impedance, with the smaller inductance, at the speed that the vector has by then.
static void test_reactance_counts_where_the_vector_turns(void) {
    const rig_t rig = after_gain_changes(LODE_START_TURN, 500, 0, 0.4, LODE_ON);
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_RESISTANCE", lode_check_name(fault.check));
    const double omega = (double)rig.drive.state.start.omega_rad_s;
    CHECK_AT_LEAST(45.0, omega);
    CHECK_CLOSE(1.0e-3, 0.5 * hypot(0.75, omega * 3.5e-3), fault.limit);
}

/// A current that is back, with an EMF that has changed by so many times the voltage of its impedance.
static lode_check_t found_with_change(double times) {
    rig_t rig = after_gain_changes(LODE_START_TURN, 500, 0, 1.0, LODE_ON);
    lode_start_t *start = &rig.drive.state.start;
    const double Z_Ohm = hypot(0.75, (double)start->omega_rad_s * 3.5e-3);
    const float i_A = start->current_A;
    const lode_dq_t e_V = lode_park(rig.drive.estimator.emf.observer.e_V, start->at);
    start->drop = (lode_drop_t){.e_V = {e_V.d + (float)(times * Z_Ohm) * i_A, e_V.q},
                                .i_A2 = i_A * i_A,
                                .held = 8u,
                                .rounds = 6u};
    for (int n = 0; n < 8; n++) {
        rig_step(&rig);
    }
    return rig_telemetry(&rig).fault.check;
}

/// Sensors that show a fifth of what they did make four times of it, a rotor that slips more.
static void test_a_rotor_that_slips_is_no_sensor_that_changes(void) {
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, found_with_change(0.45));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_RESISTANCE, found_with_change(0.55));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_RESISTANCE, found_with_change(3.9));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, found_with_change(4.1));
}

/// What is that small is not looked at: 24 times the noise of an axis, of which the square has a 12th of the mean (K39).
static void test_a_current_in_the_noise_does_not_fall(void) {
    rig_t rig = after_gain_changes(LODE_START_TURN, 150, 0, 1.0, LODE_ON);
    lode_start_t *start = &rig.drive.state.start;
    const float inv_b = tuning.estimator.emf.inv_b;
    for (int n = 0; n < 80; n++) {
        rig.drive.jump.noise_V2 = inv_b * inv_b * start->current_A * start->current_A / 47.0f;
        rig_step(&rig);
    }
    TEST_ASSERT_EQUAL_UINT(0u, start->drop.held);
    for (int n = 0; n < 80; n++) {
        rig.drive.jump.noise_V2 = inv_b * inv_b * start->current_A * start->current_A / 49.0f;
        rig_step(&rig);
    }
    TEST_ASSERT_EQUAL_UINT(8u, start->drop.held);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_sensors_that_come_to_show_half_end_the_start);
    RUN_TEST(test_sensors_that_come_to_show_most_do_not);
    RUN_TEST(test_reactance_counts_where_the_vector_turns);
    RUN_TEST(test_a_rotor_that_slips_is_no_sensor_that_changes);
    RUN_TEST(test_a_current_in_the_noise_does_not_fall);
    return UNITY_END();
}
