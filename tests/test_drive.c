// The drive: modes, commands, tunings, faults, telemetry, and a motor in double behind it.
#include "support/rig.h"

#include "design/tuning_fields.h"
#include "drive_inline.h"
#include "inverter_inline.h"
#include "lodestar/channel.h"
#include "lodestar/drive6.h"
#include "mode.h"
#include "start_inline.h"

#include <stdlib.h>

void setUp(void) {}

void tearDown(void) {}

static lode_drive_tuning_t tuning;
static lode_drive_tuning_t other_tuning;

static rig_t fresh(void) {
    const lode_drive_config_t config = rig_config();
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    return rig;
}

static const lode_command_t off = {.mode = LODE_MODE_OFF};
static const lode_command_t clear = {.mode = LODE_MODE_OFF, .clear_fault = true};

/// Sensorless running at a mechanical speed.
static lode_command_t run_at(double speed) {
    return (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = (float)speed};
}

/// Steps until `mode`, at most `seconds`; false if it never comes.
static bool reach(rig_t *rig, lode_mode_t mode, double seconds) {
    for (int n = 0; n < (int)(seconds / RIG_TS_s); n++) {
        rig_step(rig);
        if (rig_telemetry(rig).mode == mode) {
            return true;
        }
    }
    return false;
}

/// From here the first vector of a start (S40) hardly swings the rotor, in either direction.
#define CALM_rad CHECK_PI

/// Into RUN at a mechanical speed.
static void run_up(rig_t *rig, double speed, double within_s) {
    rig_command(rig, run_at(speed));
    TEST_ASSERT_TRUE(reach(rig, LODE_MODE_RUN, within_s));
}

/// A fresh one that runs.
static rig_t running(double speed, double within_s) {
    rig_t rig = fresh();
    run_up(&rig, speed, within_s);
    return rig;
}

/// One that runs and has nothing else to look at in a period than its slot.
static rig_t steady(void) {
    lode_drive_config_t config = rig_config();
    config.motor.omega_rated_rad_s = 300.0f; // speed control in its slot is enough
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 80.0, 8.0);
    rig_run(&rig, 0.5);
    TEST_ASSERT_TRUE(rig.drive.steady);
    return rig;
}

// --- Off, calibration -------------------------------------------------------------------------

static bool is_idle(lode_drive_out_t out) {
    return !out.gates && out.duty.a == 0.5f && out.duty.b == 0.5f && out.duty.c == 0.5f;
}

static void test_init_is_at_rest_and_idempotent(void) {
    rig_t rig = fresh();
    const rig_t first = rig;
    rig_expect(&rig, LODE_MODE_OFF);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, rig.drive.direction);
    TEST_ASSERT_EQUAL_UINT32(0, rig_telemetry(&rig).steps);
    rig_command(&rig, run_at(100.0));
    rig_run(&rig, 1.0);
    const lode_drive_config_t config = rig_config();
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&rig.drive, &tuning, &config));
    TEST_ASSERT_EQUAL_MEMORY(&first.drive, &rig.drive, sizeof rig.drive);
}

static void test_one_tuning_serves_two_drives(void) {
    rig_t rig = fresh();
    lode_drive_t other;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_begin(&other, &tuning));
    lode_telemetry_t mine;
    lode_telemetry_t its;
    TEST_ASSERT_TRUE(lode_drive_telemetry(&rig.drive, &mine));
    TEST_ASSERT_TRUE(lode_drive_telemetry(&other, &its));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, its.mode);
    TEST_ASSERT_EQUAL_UINT32(mine.steps, its.steps);
    TEST_ASSERT_EQUAL_FLOAT(mine.duty.a, its.duty.a);
    TEST_ASSERT_EQUAL_FLOAT(mine.theta_rad, its.theta_rad);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, its.fault.check);
}

static void test_off_stays_off(void) {
    rig_t rig = fresh();
    rig.trip = true; // the power stage may say what it likes
    for (int n = 0; n < 1000; n++) {
        rig_step(&rig);
        TEST_ASSERT_TRUE(is_idle(rig.out));
    }
    rig_expect(&rig, LODE_MODE_OFF);
    TEST_ASSERT_EQUAL_UINT32(1000, rig_telemetry(&rig).steps);
}

static void test_calibration_measures_offsets_with_gates_off(void) {
    rig_t rig = fresh();
    rig.offset[0] = 20.0;
    rig.offset[1] = -35.0;
    rig.offset[2] = 4.0;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    for (int n = 0; n < 400; n++) { // of the 500 of 0.1 s
        rig_step(&rig);
        TEST_ASSERT_TRUE(is_idle(rig.out));
        rig_expect(&rig, LODE_MODE_CALIBRATE);
    }
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.1));
    const int32_t offsets[] = {2068, 2013, 2052};
    for (int n = 0; n < 3; n++) {
        TEST_ASSERT_EQUAL_INT(offsets[n] * LODE_COUNT_FRACTION, rig.drive.sense.offset[n]);
    }
    rig_run(&rig, 0.2); // once
    rig_expect(&rig, LODE_MODE_OFF);
}

static void test_an_implausible_offset_is_a_fault(void) {
    rig_t rig = fresh();
    rig.offset[1] = -300.0;
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_FAULT, 0.2));
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OFFSET, fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_CALIBRATE, fault.state);
    CHECK_NEAR(0.01, -300.0, fault.measured);
    CHECK_NEAR(0.01, (double)tuning.sense.offset_tol / (double)LODE_COUNT_FRACTION, fault.limit);
    TEST_ASSERT_TRUE(is_idle(rig.out));
}

static void test_off_interrupts_a_calibration(void) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    rig_run(&rig, 0.05);
    rig_command(&rig, off);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
}

// --- Bootstrap capacitors ---------------------------------------------------------------------

#define PRECHARGE_PERIODS 50

static rig_t precharging(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.precharge_s = (float)(PRECHARGE_PERIODS * RIG_TS_s);
    config.start.pulses = LODE_OFF;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.blocked = true;
    return rig;
}

static bool is_low(lode_drive_out_t out, float duty) {
    return out.gates == LODE_GATES_LOW && out.duty.a == duty && out.duty.b == duty &&
           out.duty.c == duty;
}

static void test_low_sides_come_before_all_gates(void) {
    static const lode_command_t commands[] = {
        {.mode = LODE_MODE_VOLTAGE, .vector = {3.0f, 0.0f}},
        {.mode = LODE_MODE_CURRENT, .vector = {1.0f, 0.0f}},
        {.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f},
    };
    static const lode_mode_t modes[] = {LODE_MODE_VOLTAGE, LODE_MODE_CURRENT, LODE_MODE_START};
    for (int n = 0; n < COUNT_OF(commands); n++) {
        rig_t rig = precharging();
        rig_command(&rig, commands[n]);
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
        // The duties come first, so that no other ones act while the low sides are on.
        TEST_ASSERT_EQUAL_INT(LODE_GATES_OFF, rig.out.gates);
        TEST_ASSERT_EQUAL_FLOAT(0.8f, rig.out.duty.a);
        for (int k = 0; k < PRECHARGE_PERIODS; k++) {
            rig_step(&rig);
            TEST_ASSERT_TRUE(is_low(rig.out, 0.8f));
            rig_expect(&rig, LODE_MODE_PRECHARGE);
        }
        rig_step(&rig);
        rig_expect(&rig, modes[n]);
        TEST_ASSERT_TRUE(is_idle(rig.out)); // no voltage in the first period with all gates on
        rig_step(&rig);
        TEST_ASSERT_EQUAL_INT(LODE_GATES_ON, rig.out.gates);
    }
}

static void test_low_sides_stay_on_no_longer_than_commanded(void) {
    rig_t rig = precharging();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE});
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
    rig_run(&rig, 10.0 * RIG_TS_s);
    rig_command(&rig, off);
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_expect(&rig, LODE_MODE_OFF);
    rig_command(&rig, run_at(100.0)); // calibrates first, and then from the beginning
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
    rig_command(&rig, run_at(0.0));
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
}

static void test_low_sides_are_guarded(void) {
    for (int trip = 0; trip < 2; trip++) {
        rig_t rig = precharging();
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE});
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
        rig_step(&rig);
        rig.trip = trip == 0;
        rig.offset[1] = trip == 0 ? 0.0 : 1500.0; // 18.75 A of 18
        rig_step(&rig);
        TEST_ASSERT_TRUE(is_idle(rig.out));
        rig_expect(&rig, LODE_MODE_FAULT);
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_INT(trip == 0 ? LODE_CHECK_HARDWARE_TRIP : LODE_CHECK_OVER_CURRENT,
                              fault.check);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_PRECHARGE, fault.state);
    }
}

// A low side that is on for too short a time could not be watched.
static void test_low_sides_are_on_for_the_sampling_window(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.precharge_s = 0.01f;
    config.sense.duty_max = 0.75f;
    config.current.voltage_use = 0.5f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE});
    rig_run(&rig, 5.0 * RIG_TS_s);
    TEST_ASSERT_TRUE(is_low(rig.out, 0.75f));
}

// --- Voltage and current at a given angle -----------------------------------------------------

static void test_voltage_vector_at_an_angle(void) {
    for (int n = 0; n < 12; n++) {
        rig_t rig = fresh();
        rig.blocked = true;
        const double theta = n * CHECK_PI / 6.0;
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE,
                                           .vector = {3.0f, -2.0f},
                                           .theta_rad = (float)theta});
        rig_run(&rig, 0.01);
        TEST_ASSERT_TRUE(rig.out.gates);
        const lode_ab_t u = lode_clarke(rig.out.duty);
        // (3 - 2j) exp(j theta) V of 200 V; float rounding.
        CHECK_NEAR(5.0e-4, 3.0 * cos(theta) + 2.0 * sin(theta), 200.0f * u.alpha);
        CHECK_NEAR(5.0e-4, 3.0 * sin(theta) - 2.0 * cos(theta), 200.0f * u.beta);
    }
}

static void test_turning_voltage_is_ahead_by_one_and_a_half_periods(void) {
    rig_t rig = fresh();
    const double omega = -400.0;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE,
                                       .vector = {5.0f, 0.0f},
                                       .theta_rad = 1.0f,
                                       .omega_rad_s = (float)omega});
    // A current of 5 A along alpha tells where the frame stands at the sample.
    const lode_counts_t counts = {.i = {2448, 1848, 1848}, .v_bus = 2000};
    double before = 0.0;
    (void)lode_drive_step(&rig.drive, &counts); // switches the gates on
    for (int n = 0; n < 200; n++) {
        const lode_drive_out_t out = lode_drive_step(&rig.drive, &counts);
        const lode_telemetry_t t = rig_telemetry(&rig);
        const double frame = -atan2((double)t.i_A.q, (double)t.i_A.d);
        const lode_ab_t u = lode_clarke(out.duty);
        const double voltage = atan2((double)u.beta, (double)u.alpha);
        // The duties act from one to two periods after the sample; float rounding of a 2.5 % duty.
        CHECK_NEAR(2.0e-5, 0.0, angle_error(voltage - frame, 1.5 * omega * RIG_TS_s));
        if (n > 0) {
            CHECK_NEAR(2.0e-5, 0.0, angle_error(frame - before, omega * RIG_TS_s));
        }
        before = frame;
    }
}

static void test_the_frame_stands_at_its_angle_when_the_mode_is_entered(void) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE,
                                       .vector = {5.0f, 0.0f},
                                       .theta_rad = 1.0f,
                                       .omega_rad_s = 1000.0f});
    const lode_counts_t counts = {.i = {2448, 1848, 1848}, .v_bus = 2000};
    TEST_ASSERT_FALSE(lode_drive_step(&rig.drive, &counts).gates);
    TEST_ASSERT_TRUE(
        lode_drive_step(&rig.drive, &counts).gates); // the first period with the gates on
    const lode_telemetry_t t = rig_telemetry(&rig);
    CHECK_NEAR(1.0e-5, 1.0, -atan2((double)t.i_A.q, (double)t.i_A.d));
}

static void test_voltage_stays_in_the_circle(void) {
    rig_t rig = fresh();
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE, .vector = {1.0e6f, -1.0e6f}});
    rig_run(&rig, 0.001);
    TEST_ASSERT_TRUE(rig.out.gates);
    const lode_abc_t d = rig.out.duty;
    TEST_ASSERT_TRUE(d.a >= 0.0f && d.a <= 1.0f && d.b >= 0.0f && d.b <= 1.0f && d.c >= 0.0f &&
                     d.c <= 1.0f);
}

static void test_current_vector_at_an_angle(void) {
    for (int n = 0; n < 6; n++) {
        rig_t rig = fresh();
        rig.blocked = true;
        const double theta = n * CHECK_PI / 3.0;
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT,
                                           .vector = {4.0f, 1.0f},
                                           .theta_rad = (float)theta});
        rig_run(&rig, 0.3);
        const lode_ab_t i = ipmsm_current(&rig.motor);
        // A converter's step is 12.5 mA.
        CHECK_NEAR(0.03, 4.0 * cos(theta) - sin(theta), i.alpha);
        CHECK_NEAR(0.03, 4.0 * sin(theta) + cos(theta), i.beta);
        const lode_telemetry_t t = rig_telemetry(&rig);
        CHECK_NEAR(0.03, 4.0, t.i_A.d);
        CHECK_NEAR(0.03, 1.0, t.i_A.q);
        TEST_ASSERT_EQUAL_FLOAT(4.0f, t.ref_A.d);
    }
}

static void test_current_command_is_limited(void) {
    rig_t rig = fresh();
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {50.0f, 0.0f}});
    rig_run(&rig, 0.3);
    CHECK_NEAR(0.05, 12.0, lode_ab_length(ipmsm_current(&rig.motor)));
    // A vector of both components too.
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {50.0f, 50.0f}});
    rig_run(&rig, 0.3);
    CHECK_AT_MOST(12.05, lode_ab_length(ipmsm_current(&rig.motor)));
}

// --- Sensorless running -----------------------------------------------------------------------

static void check_running_within(rig_t *rig, double speed, double most_deg) {
    worst_t angle = {0.0};
    worst_t off_speed = {0.0};
    for (int n = 0; n < 1000; n++) {
        rig_step(rig);
        worst_note(&angle, rig->angle_error);
        worst_note(&off_speed, rig->motor.omega / 3.0 - speed);
    }
    rig_expect(rig, LODE_MODE_RUN);
    CHECK_AT_MOST(most_deg * CHECK_DEG, angle.value);
    CHECK_AT_MOST(0.01 * fabs(speed), off_speed.value);
    CHECK_AT_LEAST(0.7, rig_telemetry(rig).lock);
}

static void check_running(rig_t *rig, double speed) {
    check_running_within(rig, speed, 1.0); // counts of 12.5 mA move it
}

/// Mean error of the angle under load, in degrees, of a motor whose Lq falls by 5 % per ampere.
static double error_of_a_q_axis_that_saturates(float Lq_fall) {
    lode_drive_config_t config = rig_config();
    config.references.Lq_fall = Lq_fall;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 100.0, 8.0);
    rig_run(&rig, 1.0);
    double sum = 0.0;
    for (int n = 0; n < 20000; n++) {
        rig.load_Nm = fmin(3.0, 3.0e-4 * n);
        rig.motor.Lq = 9.8e-3 / (1.0 + 0.05 * fabs(rig.motor.iq));
        rig_step(&rig);
        sum += n < 15000 ? 0.0 : rig.angle_error;
    }
    rig_expect(&rig, LODE_MODE_RUN);
    CHECK_AT_LEAST(4.0, rig.motor.iq);
    return sum / 5000.0 / CHECK_DEG;
}

static void test_a_falling_Lq_that_is_known_leaves_no_error_of_the_angle(void) {
    CHECK_AT_LEAST(3.0, fabs(error_of_a_q_axis_that_saturates(0.0f)));
    CHECK_AT_MOST(0.3, fabs(error_of_a_q_axis_that_saturates(0.05f)));
}

static void check_q_axis(const rig_t *rig, double Lq_H, double kp_V_A) {
    CHECK_CLOSE(0.02, Lq_H, rig->drive.current.Lq_H);
    CHECK_CLOSE(0.02, kp_V_A, rig->drive.current.kp_q_V_A);
}

/// In RUN as it saturates (K20), (K21), and as it is at no current in what follows.
static void test_current_control_follows_a_falling_Lq(void) {
    lode_drive_config_t config = rig_config();
    config.references.Lq_fall = 0.05f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    const double Lq_H = (double)config.motor.Lq_H;
    const double kp_V_A = (double)tuning.current.q.kp;
    run_up(&rig, 100.0, 8.0);
    for (int n = 0; n < 15000; n++) {
        rig.load_Nm = fmin(3.0, 3.0e-4 * n);
        rig.motor.Lq = 9.8e-3 / (1.0 + 0.05 * fabs(rig.motor.iq));
        rig_step(&rig);
    }
    const double share = 1.0 / (1.0 + 0.05 * fabs(rig.motor.iq));
    CHECK_AT_MOST(0.85, share);
    check_q_axis(&rig, share * Lq_H, share * share * kp_V_A);
    lode_mode_hand_back(&rig.drive);
    check_q_axis(&rig, Lq_H, kp_V_A);
}

static void test_another_tuning_brings_its_own_q_axis(void) {
    rig_t rig = fresh();
    run_up(&rig, 100.0, 8.0);
    check_q_axis(&rig, 9.8e-3, (double)tuning.current.q.kp);
    lode_drive_config_t config = rig_config();
    config.motor.Lq_H = 8.0e-3f;
    lode_drive_tuning_t other;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other, &config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other));
    rig_step(&rig);
    check_q_axis(&rig, 8.0e-3, (double)other.current.q.kp);
}

/// With injection, which may have learned the present Lq, the angle is left alone.
static void test_a_falling_Lq_turns_no_angle_with_injection(void) {
    for (int injects = 0; injects <= 1; injects++) {
        lode_drive_config_t config = rig_config();
        config.references.Lq_fall = 0.03f;
        config.hfi.mode = injects != 0 ? LODE_HFI_ON : LODE_HFI_OFF;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        rig.drive.estimator.emf.i_A = (lode_ab_t){0.0f, 6.0f};
        lode_drive_adapt_saturated_lag(&rig.drive);
        const double turned = fabs((double)rig.drive.estimator.lag.at.sin);
        CHECK_AT_LEAST(injects != 0 ? 0.0 : 0.05, turned);
        CHECK_AT_MOST(injects != 0 ? 0.0 : 0.2, turned);
    }
}

static void test_run_calibrates_starts_and_turns_both_ways(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig.load_Nm = 1.0;
        rig_command(&rig, run_at(100.0 * sign));
        rig_step(&rig);
        rig_expect(&rig, LODE_MODE_CALIBRATE);
        TEST_ASSERT_TRUE(is_idle(rig.out));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.2));
        TEST_ASSERT_TRUE(is_idle(rig.out));
        rig_step(&rig);
        TEST_ASSERT_TRUE(rig.out.gates); // in the period after
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
        rig_run(&rig, 2.0);
        check_running(&rig, 100.0 * sign);
        const lode_telemetry_t t = rig_telemetry(&rig);
        CHECK_NEAR(0.2, ipmsm_torque(&rig.motor) - 7.5e-4 * 100.0 * sign, t.load_torque_Nm);
        CHECK_NEAR(0.5, 200.0, t.v_bus_V);
        CHECK_NEAR(0.1, 100.0 * sign, t.speed_ref_rad_s);
    }
}

static void test_two_shunts_do(void) {
    lode_drive_config_t config = rig_config();
    config.sense.shunts = LODE_SHUNTS_TWO;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 100.0, 8.0);
    rig_run(&rig, 2.0);
    check_running(&rig, 100.0);
}

/// (S8): a d current that takes more than 0.4 of the flux falls before the hand-over.
static void test_hand_over_waits_for_the_flux_of_a_salient_rotor(void) {
    lode_drive_config_t config = rig_config();
    config.start.current_A = 12.0f;
    rig_t rig;
    rig_init(&rig, &other_tuning, &config);
    run_up(&rig, 100.0, 8.0);
    const double most_A = 0.4 * 0.142 / 6.3e-3;
    CHECK_AT_MOST(1.05 * most_A, rig.motor.id);
    CHECK_AT_MOST(rig.motor.id, 0.8 * most_A); // and no later than the lock takes
}

/// With a speed loop of so many rad/s, of which the PLL allows as much.
static lode_drive_config_t with_speed_bandwidth(float bandwidth) {
    lode_drive_config_t config = rig_config();
    config.motor.omega_rated_rad_s = 400.0f;
    config.speed.bandwidth_rad_s = bandwidth;
    config.speed.gain_rise = 1.0f;
    config.estimator.pll.sigma_rad_s = 300.0f;
    config.start.omega_handover_rad_s = 100.0f; // where there is EMF enough for so wide a PLL
    return config;
}

static void test_speed_control_runs_as_often_as_its_bandwidth_asks(void) {
    // Once in eight periods, unless they are more than a tenth of the loop's time constant.
    const float bandwidths[] = {10.0f, 62.0f, 63.0f, 124.0f, 126.0f, 249.0f, 251.0f};
    const uint32_t periods[] = {8u, 8u, 4u, 4u, 2u, 2u, 1u};
    for (int n = 0; n < COUNT_OF(bandwidths); n++) {
        const lode_drive_config_t config = with_speed_bandwidth(bandwidths[n]);
        TEST_ASSERT_EQUAL_STRING("LODE_OK",
                                 lode_status_name(lode_drive_tune(&other_tuning, &config)));
        TEST_ASSERT_EQUAL_UINT32(periods[n], other_tuning.speed_periods);
    }
    // The gains rise with the PLL's: what counts is the fastest loop.
    lode_drive_config_t config = with_speed_bandwidth(40.0f);
    config.speed.gain_rise = 2.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    TEST_ASSERT_EQUAL_UINT32(4u, other_tuning.speed_periods);
    // Or more than an eighth of a turn at rated speed: 491 rad/s at 5 kHz.
    const float rated[] = {480.0f, 490.0f, 492.0f, 600.0f};
    const uint32_t by_rated[] = {8u, 8u, 4u, 4u};
    for (int n = 0; n < COUNT_OF(rated); n++) {
        config = with_speed_bandwidth(10.0f);
        config.motor.omega_rated_rad_s = rated[n];
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
        TEST_ASSERT_EQUAL_UINT32(by_rated[n], other_tuning.speed_periods);
    }
    // Faster PWM has the slow rate by default.
    const float rates[] = {1.0e4f, 2.0e4f, 1.0e5f};
    for (int n = 0; n < COUNT_OF(rates); n++) {
        config = rig_config();
        config.f_pwm_Hz = rates[n];
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
        TEST_ASSERT_EQUAL_UINT32(LODE_SLOW_PERIODS, other_tuning.speed_periods);
    }
    // Or in every period, as the papers have it, if that is asked for.
    config.speed.every_period = LODE_ON;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    TEST_ASSERT_EQUAL_UINT32(1u, other_tuning.speed_periods);
}

static void test_every_rate_of_speed_control_drives(void) {
    for (uint32_t periods = LODE_SLOW_PERIODS; periods > 0u; periods /= 2u) {
        const lode_drive_config_t config = with_speed_bandwidth(280.0f / (float)periods);
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        TEST_ASSERT_EQUAL_UINT32(periods, tuning.speed_periods);
        rig_command(&rig, run_at(60.0));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
        rig_run(&rig, 1.0);
        // The reference changes once in so many periods, by the ramp of as many.
        rig_command(&rig, run_at(100.0));
        rig_run(&rig, 0.02);
        uint32_t changes = 0u;
        const float first = rig_telemetry(&rig).speed_ref_rad_s;
        float before = first;
        for (uint32_t n = 0u; n < 80u; n++) {
            rig_step(&rig);
            const float now = rig_telemetry(&rig).speed_ref_rad_s;
            changes += now > before ? 1u : 0u;
            before = now;
        }
        TEST_ASSERT_EQUAL_UINT32(80u / periods, changes);
        CHECK_CLOSE(1.0e-3, 80.0 / periods * (double)tuning.speed.ramp_step, before - first);
        rig_run(&rig, 3.0);
        rig.load_Nm = 2.0;
        rig_run(&rig, 2.0);
        check_running(&rig, 100.0);
    }
}

/// The references follow a new torque in the period after it, or in the same one: id for it, too.
static void test_references_follow_the_torque_at_once_at_every_rate(void) {
    for (uint32_t periods = LODE_SLOW_PERIODS; periods > 0u; periods /= 2u) {
        lode_drive_config_t config = with_speed_bandwidth(280.0f / (float)periods);
        config.references.kind = LODE_REFERENCES_MTPA;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        run_up(&rig, 60.0, 8.0);
        rig_run(&rig, 1.0);
        rig.load_Nm = 2.0;
        rig_run(&rig, 1.0);
        rig_command(&rig, run_at(100.0));
        rig_run(&rig, 0.02);
        float torque_Nm = rig_telemetry(&rig).torque_ref_Nm;
        float iq_A = rig_telemetry(&rig).ref_A.q;
        uint32_t changed = 0u;
        uint32_t followed = 0u;
        for (uint32_t n = 1u; n <= 64u; n++) {
            rig_step(&rig);
            const lode_telemetry_t t = rig_telemetry(&rig);
            changed = t.torque_ref_Nm > torque_Nm || t.torque_ref_Nm < torque_Nm ? n : changed;
            if (t.ref_A.q > iq_A || t.ref_A.q < iq_A) {
                TEST_ASSERT_TRUE(changed > 0u && n - changed <= (periods > 1u ? 1u : 0u));
                followed++;
            }
            torque_Nm = t.torque_ref_Nm;
            iq_A = t.ref_A.q;
        }
        CHECK_AT_LEAST(64u / periods - 2u, followed);
        rig_run(&rig, 2.0);
        // The least current for a torque: id (id + psi/(Ld - Lq)) = iq iq, (R3).
        const lode_dq_t i_A = rig_telemetry(&rig).ref_A;
        const double half = 0.5 * 0.142 / 6.3e-3;
        CHECK_NEAR(0.1, half - sqrt(half * half + (double)(i_A.q * i_A.q)), i_A.d);
    }
}

/// In its three slots, and all at once.
static void test_references_weaken_the_field(void) {
    const lode_choice_t every_period[] = {LODE_OFF, LODE_ON};
    for (int n = 0; n < COUNT_OF(every_period); n++) {
        lode_drive_config_t config = with_speed_bandwidth(35.0f);
        config.speed.every_period = every_period[n];
        config.references.field_weakening = LODE_ON;
        config.references.voltage_use = 0.5f;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        TEST_ASSERT_EQUAL_UINT32(n == 0 ? LODE_SLOW_PERIODS : 1u, tuning.speed_periods);
        rig_command(&rig, run_at(150.0));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
        rig_run(&rig, 4.0);
        check_running(&rig, 150.0);
        const lode_telemetry_t at = rig_telemetry(&rig);
        const double use_V = (double)(tuning.references.circle * at.v_bus_V);
        CHECK_CLOSE(0.02, use_V, hypot((double)at.u_V.d, (double)at.u_V.q));
        CHECK_AT_MOST(-3.0, at.i_A.d);
    }
}

static void test_load_steps_and_speed_changes(void) {
    rig_t rig = running(60.0, 8.0);
    rig_run(&rig, 1.5);
    check_running(&rig, 60.0);
    rig.load_Nm = 5.0;
    rig_run(&rig, 2.0);
    check_running(&rig, 60.0);
    rig_command(&rig, run_at(150.0));
    rig_run(&rig, 2.5);
    check_running(&rig, 150.0);
    rig.load_Nm = 0.0;
    rig_run(&rig, 2.0);
    check_running(&rig, 150.0);
}

// From RUN until the start current has faded: periods in which the reference is shorter than `short_A`, and its
// largest step.
static void watch_the_fade(rig_t *rig, float short_A, uint32_t *shorts, float *step_A) {
    *shorts = 0u;
    *step_A = 0.0f;
    TEST_ASSERT_TRUE(reach(rig, LODE_MODE_RUN, 8.0));
    float before_A = rig->drive.ref_A.d;
    while (rig->drive.state.run.fade > 0.0f) {
        rig_step(rig);
        const lode_dq_t i_A = rig->drive.ref_A;
        *shorts += hypotf(i_A.d, i_A.q) < short_A ? 1u : 0u;
        *step_A = fmaxf(*step_A, fabsf(i_A.d - before_A));
        before_A = i_A.d;
    }
    rig_expect(rig, LODE_MODE_RUN);
}

static void test_the_fade_leaves_out_short_currents(void) {
    uint32_t shorts = 0u;
    float step_A = 0.0f;
    rig_t rig = fresh();
    const float bias_A = tuning.references.id_bias_A;
    TEST_ASSERT_TRUE(bias_A > 0.0f);
    rig_command(&rig, run_at(60.0));
    watch_the_fade(&rig, bias_A, &shorts, &step_A);
    rig_run(&rig, (double)LODE_SLOW_PERIODS * RIG_TS_s);
    TEST_ASSERT_TRUE(shorts <= LODE_SLOW_PERIODS); // a round has seen one
    CHECK_CLOSE(1.0e-6, -bias_A, rig.drive.ref_A.d);
    // Where that moves more than a third of the flux at once, it fades to the end.
    lode_drive_config_t config = rig_config();
    config.references.id_bias_A = 1.5f * bias_A;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(60.0));
    watch_the_fade(&rig, bias_A, &shorts, &step_A);
    TEST_ASSERT_TRUE(shorts > 4u * LODE_SLOW_PERIODS);
    TEST_ASSERT_TRUE(step_A < 0.2f * bias_A);
    // So it does where no bias asks for it.
    config = rig_config();
    config.references.id_bias_A = LODE_NONE;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(60.0));
    watch_the_fade(&rig, bias_A, &shorts, &step_A);
    TEST_ASSERT_TRUE(shorts > 4u * LODE_SLOW_PERIODS);
    TEST_ASSERT_TRUE(step_A < 0.2f * bias_A);
}

/// Shorter than the bias is what is shorter as a vector.
static void test_a_current_is_short_by_both_its_parts(void) {
    rig_t rig = fresh();
    const float bias_A = tuning.references.id_bias_A;
    const float d[] = {0.9f, 0.2f, 0.6f, 0.9f};
    const float q[] = {0.2f, 0.9f, 0.6f, 0.9f};
    rig.drive.state.run.fade = 0.75f;
    for (int n = 0; n < COUNT_OF(d); n++) {
        rig.drive.ref_A = (lode_dq_t){d[n] * bias_A, -q[n] * bias_A};
        const float left = n < 3 ? 0.0f : 0.75f - tuning.start.fade_step;
        TEST_ASSERT_EQUAL_FLOAT(left, lode_drive_faded(&rig.drive));
    }
}

static lode_command_t torque_of(double torque, double speed) {
    return (lode_command_t){.mode = LODE_MODE_RUN,
                            .speed_rad_s = (float)speed,
                            .control = LODE_CONTROL_TORQUE,
                            .torque_Nm = (float)torque};
}

static void test_torque_control_follows_torque_and_holds_its_speeds(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig.load_Nm = 1.0;
        rig_command(&rig, torque_of(1.5 * sign, 150.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
        rig_run(&rig, 0.5); // the start current has faded
        for (int n = 0; n < 1000; n++) {
            rig_step(&rig);
            CHECK_NEAR(0.03, 1.5 * sign, ipmsm_torque(&rig.motor));
        }
        CHECK_NEAR(1.0e-6, 1.5 * sign, rig_telemetry(&rig).torque_ref_Nm);
        TEST_ASSERT_FALSE(rig_telemetry(&rig).torque_limited);
        rig_run(&rig, 6.0);
        check_running(&rig, 150.0 * sign); // no faster: the torque is the load's
        TEST_ASSERT_TRUE(fabs(ipmsm_torque(&rig.motor)) < 1.2);
        rig_command(&rig, torque_of(-2.0 * sign, 150.0 * sign)); // brakes
        rig_run(&rig, 0.2);
        CHECK_NEAR(0.03, -2.0 * sign, ipmsm_torque(&rig.motor));
        rig_run(&rig, 4.0);
        check_running(&rig, (double)(tuning.omega_min * tuning.speed.inv_pole_pairs) * sign);
        TEST_ASSERT_FALSE(rig_telemetry(&rig).speed_raised);
        // Speed control goes on from there.
        rig_command(&rig, torque_of(1.0e3 * sign, 150.0 * sign));
        rig_run(&rig, 0.1);
        for (int n = 0; n < 100; n++) {
            rig_step(&rig);
            const lode_telemetry_t t = rig_telemetry(&rig);
            TEST_ASSERT_TRUE(t.torque_limited);
            CHECK_CLOSE(0.01, (double)t.torque_most_Nm, sign * (double)t.torque_ref_Nm);
        }
        rig_command(&rig, run_at(80.0 * sign));
        rig_run(&rig, 3.0);
        check_running(&rig, 80.0 * sign);
        // The other way: against its direction it is stopped as by speed control.
        rig_command(&rig, torque_of(-1.5 * sign, -100.0 * sign));
        rig_run(&rig, 14.0);
        check_running(&rig, -100.0 * sign);
    }
}

/// Without a sensor it goes down the ramp to the least speed, however low that is, where the speed allowed is none or one
/// against its direction: the torque does not count.
static void test_torque_control_without_a_sensor_stops_by_speed(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = running(100.0 * sign, 8.0);
        other_tuning = tuning;
        rig.drive.tuning = &other_tuning;
        const double speeds[] = {0.0, -100.0 * sign};
        for (int n = 0; n < 2 * COUNT_OF(speeds); n++) {
            other_tuning.omega_min = n % 2 == 0 ? tuning.omega_min : 0.5f;
            const float least = other_tuning.omega_min * tuning.speed.inv_pole_pairs;
            rig_command(&rig, torque_of(-1.5 * sign, speeds[n / 2]));
            lode_mode_take_mail(&rig.drive);
            CHECK_NEAR(0.0, sign * (double)least,
                       lode_drive_other_target(&rig.drive, 300.0f * (float)sign, 0.0f));
        }
    }
}

static void test_a_speed_that_is_raised_is_told(void) {
    rig_t rig = running(1.0, 8.0);
    rig_run(&rig, 3.0);
    TEST_ASSERT_TRUE(rig_telemetry(&rig).speed_raised);
    // At the least speed the resistance counts, which the start has measured.
    check_running_within(&rig, (double)(tuning.omega_min * tuning.speed.inv_pole_pairs), 1.5);
    // Neither the least speed itself, nor a stop, which goes through it, nor any above.
    const double speeds[] = {(double)(tuning.omega_min * tuning.speed.inv_pole_pairs), 0.0, 60.0};
    for (int n = 0; n < COUNT_OF(speeds); n++) {
        rig_t other = rig;
        rig_command(&other, run_at(speeds[n]));
        rig_step(&other);
        rig_expect(&other, LODE_MODE_RUN);
        TEST_ASSERT_FALSE(rig_telemetry(&other).speed_raised);
    }
}

static void test_speed_zero_stops_and_switches_off(void) {
    rig_t rig = fresh();
    rig.load_Nm = 0.5;
    run_up(&rig, 80.0, 8.0);
    rig_run(&rig, 1.0);
    rig_command(&rig, run_at(0.0));
    double last_A = 0.0;
    for (int n = 0; n < 25000 && rig_telemetry(&rig).mode != LODE_MODE_OFF; n++) {
        last_A = hypot(rig.motor.id, rig.motor.iq);
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_OFF);
    CHECK_AT_MOST(0.5, last_A); // the current has fallen before the gates open
    TEST_ASSERT_TRUE(is_idle(rig.out));
    CHECK_NEAR(10.0, 0.0, rig.motor.omega / 3.0); // down on the vector, not coasting
    rig_run(&rig, 1.0);
    rig_expect(&rig, LODE_MODE_OFF);
    rig_command(&rig, run_at(80.0));
    rig_step(&rig);
    TEST_ASSERT_FALSE(rig_telemetry(&rig).mode == LODE_MODE_CALIBRATE); // that has been done
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
}

/// Against the load the vector of the way back begins ahead of the rotor by asin(iq/I).
static void test_the_way_back_begins_where_its_current_makes_the_torque(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig.load_Nm = 1.5;
        rig_command(&rig, run_at(80.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
        rig_run(&rig, 1.0);
        rig_command(&rig, run_at(-80.0 * sign));
        float iq_A = 0.0f;
        int periods = 0;
        while (rig_telemetry(&rig).mode == LODE_MODE_RUN && periods < 20000) {
            iq_A = rig.drive.i_A.q;
            rig_step(&rig);
            periods++;
        }
        rig_expect(&rig, LODE_MODE_START);
        const lode_sincos_t at = rig.drive.state.start.at;
        const lode_sincos_t rotor = lode_sincos(lode_estimator_theta_rad(&rig.drive.estimator));
        const lode_sincos_t ahead = lode_angle_subtract(at, rotor);
        const lode_dq_t u_V = lode_park((lode_ab_t){rig.drive.u_V.d, rig.drive.u_V.q}, ahead);
        CHECK_AT_LEAST(3.0,
                       hypot((double)u_V.d, (double)u_V.q)); // which current control goes on from
        CHECK_NEAR(1.0e-2, u_V.d, rig.drive.current.d.integral);
        CHECK_NEAR(1.0e-2, u_V.q, rig.drive.current.q.integral);
        const float wanted = iq_A / rig.drive.tuning->start.current_A;
        CHECK_AT_LEAST(0.02, fabs((double)wanted));
        CHECK_NEAR(1.0e-3, 1.0, hypot((double)at.sin, (double)at.cos));
        CHECK_NEAR(0.05, wanted, ahead.sin);
    }
}

/// With the gates off no voltage is on its way, whatever was written last.
static void test_gates_off_no_voltage_is_on_its_way(void) {
    rig_t rig = running(80.0, 8.0);
    rig_run(&rig, 1.0);
    for (uint32_t n = 0u; n < 2u; n++) {
        const lode_ab_t u_V = lode_inverter_realised(&rig.drive.inverter, rig.drive.steps + n);
        CHECK_AT_LEAST(5.0, hypot((double)u_V.alpha, (double)u_V.beta));
    }
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF});
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
    for (uint32_t n = 0u; n < 2u; n++) {
        const lode_ab_t u_V = lode_inverter_realised(&rig.drive.inverter, rig.drive.steps + n);
        CHECK_NEAR(0.0, 0.0, u_V.alpha);
        CHECK_NEAR(0.0, 0.0, u_V.beta);
    }
}

/// A command that is posted while the interrupt is at its end is not passed over in the next period.
static void test_mail_that_comes_late_ends_the_steady_state(void) {
    rig_t rig = steady();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF});
    lode_mode_follow(&rig.drive); // as the interrupt that it came into
    TEST_ASSERT_FALSE(rig.drive.steady);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
}

/// The duties act from one to two periods after the sample: the voltage stands ahead of where it was computed by as much as
/// the rotor turns in one and a half.
static void test_the_voltage_of_a_run_is_ahead_by_one_and_a_half_periods(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = running(150.0 * sign, 8.0);
        rig_run(&rig, 2.0);
        for (int n = 0; n < 100; n++) {
            rig_step(&rig);
            const lode_telemetry_t t = rig_telemetry(&rig);
            const lode_ab_t u = lode_clarke(rig.out.duty);
            const double computed = (double)t.theta_rad + atan2((double)t.u_V.q, (double)t.u_V.d);
            const double put_out = atan2((double)u.beta, (double)u.alpha);
            CHECK_NEAR(2.0e-3, 0.0,
                       angle_error(put_out - computed, 1.5 * (double)t.omega_rad_s * RIG_TS_s));
        }
    }
}

/// Of a rotor that turns at `omega` rad/s before the command comes.
static rig_t coasting(double omega) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.2));
    rig.motor.omega = 3.0 * omega;
    return rig;
}

/// What the drive did, or met, before it was switched on says nothing about this time.
static void begins_anew(lode_choice_t pulses) {
    lode_drive_config_t config = rig_config();
    rig_t clean;
    config.start.pulses = pulses;
    rig_init(&clean, &tuning, &config);
    rig_command(&clean, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    TEST_ASSERT_TRUE(reach(&clean, LODE_MODE_OFF, 0.2));
    rig_t rig = clean;
    lode_drive_t *drive = &rig.drive;
    drive->guard.lock = drive->guard.speed = drive->guard.bus = 5u;
    memset(&drive->plausibility, 0x11, sizeof drive->plausibility);
    drive->estimator.lock = 0.5f;
    drive->estimator.id_A = 3.0f;
    drive->estimator.emf.observer.e_V = (lode_ab_t){5.0f, -3.0f};
    drive->current.d.integral = 4.0f;
    drive->current.q.integral = -4.0f;
    rig_command(&clean, run_at(80.0));
    rig_command(&rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&clean, LODE_MODE_START, 0.2));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.2));
    TEST_ASSERT_EQUAL_MEMORY(&clean.drive.guard, &drive->guard, sizeof drive->guard);
    TEST_ASSERT_EQUAL_MEMORY(&clean.drive.plausibility, &drive->plausibility,
                             sizeof drive->plausibility);
    TEST_ASSERT_EQUAL_MEMORY(&clean.drive.estimator, &drive->estimator, sizeof drive->estimator);
    TEST_ASSERT_EQUAL_MEMORY(&clean.drive.current, &drive->current, sizeof drive->current);
    CHECK_NEAR(0.0, 0.0, drive->current.d.integral);
    CHECK_NEAR(0.0, 0.0, drive->current.q.integral);
    TEST_ASSERT_EQUAL_MEMORY(&clean.drive.state.start, &drive->state.start,
                             sizeof drive->state.start);
}

static void test_switched_on_it_begins_anew(void) {
    begins_anew(LODE_OFF);
    begins_anew(LODE_ON); // after pulses
}

/// Volts by which the voltage leaves its turn in this period.
static double jump_of(rig_t *rig) {
    const lode_ab_t before = lode_clarke(rig->applied);
    rig_step(rig);
    const lode_ab_t now = lode_clarke(rig->applied);
    const lode_ab_t turned = lode_park_inverse((lode_dq_t){before.alpha, before.beta},
                                               lode_sincos((float)(rig->motor.omega * RIG_TS_s)));
    return (double)PAPER_V_BUS *
           hypot((double)(now.alpha - turned.alpha), (double)(now.beta - turned.beta));
}

/// From the start to the run the voltage does not jump: current control goes on from what both frames call the same, and
/// until the references' slot from the current that there is.
static void test_no_jump_at_hand_over(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig.load_Nm = 0.8;
        rig_command(&rig, run_at(80.0 * sign));
        double jump_V = 0.0;
        for (int n = 0; n < 40000 && rig_telemetry(&rig).mode != LODE_MODE_RUN; n++) {
            jump_V = jump_of(&rig);
        }
        rig_expect(&rig, LODE_MODE_RUN);
        const lode_running_t *run = &rig.drive.state.run;
        const lode_dq_t i_A = rig.drive.ref_A;
        CHECK_NEAR(0.3, rig.motor.id, i_A.d); // 8 A in a frame that is 2 degrees off
        CHECK_NEAR(0.3, rig.motor.iq, i_A.q);
        CHECK_NEAR(0.0, i_A.d, run->references.id_A);
        CHECK_NEAR(0.0, 1.0, run->fade);
        CHECK_NEAR(1.0, rig.motor.omega / 3.0, lode_drive_speed_ref_rad_s(&rig.drive));
        CHECK_NEAR(0.15, ipmsm_torque(&rig.motor), run->speed.torque_Nm);
        for (int n = 0; n < 2; n++) {
            jump_V = fmax(jump_V, jump_of(&rig));
        }
        CHECK_AT_MOST(1.0, jump_V);
    }
}

/// Of a start current that is less than the torque asks for, all is ahead of the rotor.
static void test_the_way_back_with_a_small_current(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_drive_config_t config = rig_config();
        rig_t rig = fresh();
        rig_command(&rig, run_at(80.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
        rig_run(&rig, 1.0);
        config.start.current_A = 1.0f;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
        rig.load_Nm = 1.5; // of 0.64 Nm per ampere
        rig_run(&rig, 1.0);
        rig_command(&rig, run_at(-80.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 5.0));
        const lode_sincos_t at = rig.drive.state.start.at;
        const lode_sincos_t rotor = lode_sincos(lode_estimator_theta_rad(&rig.drive.estimator));
        const lode_sincos_t ahead = lode_angle_subtract(at, rotor);
        CHECK_NEAR(1.0e-3, 1.0, hypot((double)at.sin, (double)at.cos));
        CHECK_NEAR(0.05, 1.0, fabs((double)ahead.sin));
    }
}

/// A period has one of the slow jobs: each of them is done once in a round, that of RUN and those of all modes.
static void test_every_slow_job_is_done_once_in_a_round(void) {
    rig_t rig = steady();
    rig_command(&rig, run_at(150.0)); // all that follows the speed is on its way
    rig_run(&rig, 0.05);
    const lode_drive_t *drive = &rig.drive;
    uint32_t speeds = 0u;
    uint32_t lags = 0u;
    uint32_t leads = 0u;
    const uint32_t word = drive->watch.word;
    TEST_ASSERT_TRUE(word + 2u < (uint32_t)(sizeof tuning / sizeof(uint32_t)));
    for (uint32_t n = 0u; n < LODE_SLOW_PERIODS; n++) {
        const lode_drive_t before = *drive;
        // Of one call: a second one in the same period takes the ramp two steps on.
        rig_step(&rig);
        const float ramp = before.tuning->speed.ramp_step;
        const float moved =
            drive->state.run.speed.reference_rad_s - before.state.run.speed.reference_rad_s;
        speeds += (uint32_t)(moved / ramp + 0.5f);
        lags += drive->estimator.lag.omega_rad_s != before.estimator.lag.omega_rad_s ? 1u : 0u;
        leads += drive->lead.sin != before.lead.sin ? 1u : 0u;
    }
    TEST_ASSERT_EQUAL_UINT32(1u, speeds);
    TEST_ASSERT_EQUAL_UINT32(1u, lags);
    TEST_ASSERT_EQUAL_UINT32(1u, leads);
    TEST_ASSERT_EQUAL_UINT32(word + 1u, drive->watch.word);
}

/// A sensor that says nothing any more is none after two rounds.
static void test_a_sensor_that_falls_silent_is_none(void) {
    rig_t rig = running(80.0, 8.0);
    rig_run(&rig, 1.0);
    const lode_counts_t counts = rig_counts(&rig);
    const lode_sample_t m = lode_drive_sense(&rig.drive, &counts);
    lode_estimate_t e = lode_drive_estimate(&rig.drive, &m);
    e.source = LODE_ESTIMATE_SENSOR;
    rig.out = lode_drive_act(&rig.drive, &m, &e);
    rig_move(&rig);
    TEST_ASSERT_TRUE(lode_mode_is_sensored(&rig.drive));
    rig_run(&rig, 2.0 * (double)LODE_SLOW_PERIODS * RIG_TS_s);
    TEST_ASSERT_FALSE(lode_mode_is_sensored(&rig.drive));
}

/// Shares of the torque go by the way the rotor turns, however slowly: forwards the first is upwards.
static void test_torque_shares_change_places_at_standstill(void) {
    rig_t rig = fresh();
    const lode_range_t most = {-10.0f, 10.0f};
    lode_drive_limit_torques(&rig.drive, 1.0f, 0.5f);
    for (int sign = -1; sign <= 1; sign += 2) {
        rig.drive.estimator.pll.omega_rad_s = 0.1f * (float)sign;
        const lode_range_t left = lode_drive_torque_limits(&rig.drive, most);
        CHECK_NEAR(1.0e-3, sign > 0 ? 10.0 : 5.0, left.max);
        CHECK_NEAR(1.0e-3, sign > 0 ? -5.0 : -10.0, left.min);
    }
}

/// A commanded frame is no rotor's: nothing is induced in it that current control could know of.
static void test_a_commanded_frame_has_no_speed_of_a_rotor(void) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){
                          .mode = LODE_MODE_CURRENT, .vector = {2.0f, 0.0f}, .omega_rad_s = 50.0f});
    rig_run(&rig, 0.1);
    const lode_sample_t sample = {.i_A = {1.0f, 0.0f}};
    CHECK_NEAR(0.0, 0.0, lode_drive_control_frame(&rig.drive, &sample).omega_rotor);
}

/// The duties of a start too act one and a half periods after the sample: its vector is led by what it turns until then.
static void test_the_vector_of_a_start_is_led_by_one_and_a_half_periods(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig_command(&rig, run_at(80.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.5));
        for (int n = 0; n < 20000 && fabs((double)rig.drive.state.start.omega_rad_s) < 20.0; n++) {
            rig_step(&rig);
        }
        rig_expect(&rig, LODE_MODE_START);
        lode_drive_t drive = rig.drive;
        const lode_sincos_t lead = lode_mode_control_frame(&drive).lead;
        CHECK_CLOSE(0.01, 1.5 * RIG_TS_s * (double)drive.state.start.omega_rad_s,
                    atan2((double)lead.sin, (double)lead.cos));
    }
}

/// Any one bit of an order that flips shows in its check, whatever the others are.
static void test_every_bit_of_an_order_counts(void) {
    random_t random = random_seed(7);
    for (int n = 0; n < 20; n++) {
        uint32_t bits[4];
        for (int k = 0; k < 4; k++) {
            bits[k] = random_bits(&random);
        }
        for (int bit = -1; bit < 128 + 3 + 3; bit++) { // four floats, the modes, the flags
            static uint_least16_t check;
            lode_order_t order = {.mode = (lode_mode_t)(n % 7), .flags = (uint_least8_t)(n % 8)};
            uint32_t flipped[4];
            for (int k = 0; k < 4; k++) {
                flipped[k] = bits[k] ^ (bit >= 0 && bit / 32 == k ? 1u << bit % 32 : 0u);
            }
            memcpy(&order.speed_rad_s, &flipped[0], sizeof flipped[0]);
            memcpy(&order.theta_rad, &flipped[1], sizeof flipped[1]);
            memcpy(&order.value.vector, &flipped[2], 2u * sizeof flipped[2]);
            order.mode ^= bit >= 128 && bit < 131 ? 1u << (bit - 128) : 0u;
            if (bit >= 131) {
                order.flags = (uint_least8_t)(order.flags ^ 1u << (bit - 131));
            }
            if (bit < 0) {
                check = lode_mode_order_check(&order);
            } else {
                TEST_ASSERT_TRUE(lode_mode_order_check(&order) != check);
            }
        }
    }
}

/// The terminals are held at what the bus can: no duty leaves 0 .. 1.
static void test_duties_of_an_emf_beyond_the_bus_are_at_the_rails(void) {
    const lode_abc_t one = lode_mode_duties_at((lode_abc_t){0.8f, -0.9f, 0.1f});
    const lode_abc_t other = lode_mode_duties_at((lode_abc_t){-0.8f, 0.9f, 1.1f});
    TEST_ASSERT_TRUE(one.a == 1.0f && one.b == 0.0f);
    CHECK_NEAR(1.0e-6, 0.6, one.c);
    TEST_ASSERT_TRUE(other.a == 0.0f && other.b == 1.0f && other.c == 1.0f);
}

/// A start whose rotor does not follow is given up in the first round beyond its time, and sooner where the EMF says so (S42).
static void test_a_start_has_its_time(void) {
    for (int seen = 0; seen <= 1; seen++) {
        rig_t rig = fresh();
        rig_command(&rig, run_at(80.0));
        rig.blocked = true;
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.5));
        for (uint32_t n = 0u; n < 500000u && rig.drive.mode == LODE_MODE_START; n++) {
            rig_step(&rig);
            rig.drive.state.start.slips = seen == 0 ? 0u : rig.drive.state.start.slips;
        }
        const uint32_t last = rig.drive.tuning->start.timeout_rounds + 1u;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&rig).fault.check);
        if (seen == 0) {
            TEST_ASSERT_EQUAL_UINT32(last, rig.drive.start_rounds);
        } else {
            CHECK_AT_MOST(0.8 * last, (double)rig.drive.start_rounds);
        }
    }
}

/// The start of a rig that comes to no hand-over.
static lode_telemetry_t failed_start(rig_t *rig) {
    rig_command(rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(rig, LODE_MODE_FAULT, 40.0));
    const lode_telemetry_t t = rig_telemetry(rig);
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_START", lode_check_name((lode_check_t)t.fault.check));
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_START", lode_mode_name((lode_mode_t)t.fault.state));
    TEST_ASSERT_EQUAL_INT(LODE_START_NONE, t.start_stage);
    return t;
}

static void check_why(const lode_fault_t *why, const char *stage, const char *criterion) {
    TEST_ASSERT_EQUAL_STRING(stage, lode_start_stage_name((lode_start_stage_t)why->stage));
    TEST_ASSERT_EQUAL_STRING(criterion, lode_criterion_name((lode_criterion_t)why->criterion));
    const bool above = why->criterion == (uint_least8_t)LODE_CRITERION_FLUX;
    TEST_ASSERT_TRUE(above ? why->measured > why->limit : why->measured < why->limit);
}

/// A jammed rotor, and one whose load is too large, make no EMF. Each attempt says so as it fails, and the start goes on.
static void test_a_rotor_that_does_not_follow_is_told_by_its_emf(void) {
    for (int jams = 0; jams <= 1; jams++) {
        rig_t rig = fresh();
        rig.blocked = jams == 1;
        rig.load_Nm = 10.0;
        rig_command(&rig, run_at(80.0));
        for (uint_least8_t failed = 1u; failed <= 2u; failed++) {
            while (rig_telemetry(&rig).retries < failed) {
                rig_step(&rig);
            }
            const lode_telemetry_t t = rig_telemetry(&rig);
            rig_expect(&rig, LODE_MODE_START);
            TEST_ASSERT_EQUAL_INT(LODE_START_HALF, t.start_stage);
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, t.fault.check);
            check_why(&t.fault, "LODE_START_TURN", "LODE_CRITERION_EMF");
        }
        if (jams == 1) { // of an attempt that is at speed it is told what it does not meet itself
            rig.drive.guard.fault.criterion = (uint_least8_t)LODE_CRITERION_PROOF;
        }
        const lode_telemetry_t t = failed_start(&rig);
        check_why(&t.fault, "LODE_START_TURN", "LODE_CRITERION_EMF");
        CHECK_CLOSE(1.0e-6, 0.45 * 0.142 * (double)tuning.start.omega_handover, t.fault.limit);
        TEST_ASSERT_EQUAL_UINT(2u, t.retries);
        rig_command(&rig, clear);
        rig_run(&rig, 0.01);
        TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
        TEST_ASSERT_EQUAL_INT(LODE_CRITERION_NONE, rig_telemetry(&rig).fault.criterion);
    }
}

/// A psi in the configuration that is half as large again as the magnets' leaves an EMF, but no lock.
static void test_a_wrong_psi_is_told_by_the_lock(void) {
    rig_t rig = fresh();
    rig.motor.psi *= 0.7;
    const lode_telemetry_t t = failed_start(&rig);
    check_why(&t.fault, "LODE_START_TURN", "LODE_CRITERION_LOCK");
    TEST_ASSERT_EQUAL_FLOAT(LODE_LOCK_HANDOVER, t.fault.limit);
}

/// A time-out that is too short, wherever it falls; and where it falls on an attempt that is not at speed yet, it is the one
/// before that tells why.
static void test_a_start_with_too_little_time_tells_where_it_was(void) {
    static const struct {
        float timeout_s;
        const char *stage;
        const char *criterion;
    } cases[] = {
        {0.05f, "LODE_START_HALF", "LODE_CRITERION_CURRENT"},
        {0.1f, "LODE_START_HALF", "LODE_CRITERION_REST"},
        {0.2f, "LODE_START_FULL", "LODE_CRITERION_CURRENT"},
        {0.6f, "LODE_START_TURN", "LODE_CRITERION_RAMP"},
        {1.5f, "LODE_START_TURN", "LODE_CRITERION_EMF"},
        {3.0f, "LODE_START_TURN", "LODE_CRITERION_EMF"}, // the second attempt's ramp
    };
    for (int k = 0; k < COUNT_OF(cases); k++) {
        lode_drive_config_t config = rig_config();
        config.start.timeout_s = cases[k].timeout_s;
        config.start.lock_s = 0.04f;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        rig.blocked = true;
        const lode_telemetry_t t = failed_start(&rig);
        check_why(&t.fault, cases[k].stage, cases[k].criterion);
        TEST_ASSERT_EQUAL_UINT(k == COUNT_OF(cases) - 1 ? 1u : 0u, t.retries);
    }
}

/// Any check that trips in START tells the stage; one that trips in RUN has none.
static void test_a_trip_in_a_start_tells_the_stage(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(80.0));
    lode_start_stage_t before = LODE_START_NONE;
    unsigned seen = 0u;
    for (int n = 0; n < 100000 && rig_telemetry(&rig).mode != LODE_MODE_RUN; n++) {
        const lode_start_stage_t stage = rig_telemetry(&rig).start_stage;
        if (stage != before && stage != LODE_START_NONE) {
            rig_t tripped = rig;
            tripped.trip = true;
            rig_step(&tripped);
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, rig_telemetry(&tripped).fault.check);
            TEST_ASSERT_EQUAL_INT(stage, rig_telemetry(&tripped).fault.stage);
            TEST_ASSERT_EQUAL_INT(LODE_CRITERION_NONE, rig_telemetry(&tripped).fault.criterion);
            seen++;
        }
        before = stage;
        rig_step(&rig);
    }
    TEST_ASSERT_EQUAL_UINT(5u, seen); // all but LODE_START_ALONE
    rig.trip = true;
    rig_step(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_START_NONE, rig_telemetry(&rig).fault.stage);
}

/// Of a mode that has its gates off no period is driven, though it be whole: each of its words has changed.
static void test_a_driven_mode_that_became_another_trips_at_once(void) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {2.0f, 0.0f}});
    rig_run(&rig, 0.1);
    rig.drive.mode = (uint_least8_t)LODE_MODE_OFF;
    rig.drive.mode_not = (uint_least8_t)(MODE_BITS ^ (uint32_t)LODE_MODE_OFF);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_MEMORY, rig_telemetry(&rig).fault.check);
}

/// Mail is read once, and the drive is steady again.
static void test_mail_is_read_once(void) {
    rig_t rig = steady();
    rig_command(&rig, run_at(90.0));
    TEST_ASSERT_TRUE(rig.drive.mail);
    TEST_ASSERT_FALSE(rig.drive.steady);
    rig_step(&rig);
    TEST_ASSERT_FALSE(rig.drive.mail);
    TEST_ASSERT_TRUE(rig.drive.steady);
    TEST_ASSERT_EQUAL_FLOAT(90.0f, rig.drive.command.speed_rad_s);
}

/// The current that trips is the one that telemetry tells.
static void test_the_current_of_a_trip_is_told(void) {
    rig_t rig = running(80.0, 8.0);
    rig_run(&rig, 1.0);
    rig.motor.id = -25.0;
    rig.motor.iq = 3.0;
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_FAULT);
    const lode_telemetry_t t = rig_telemetry(&rig);
    CHECK_NEAR(1.0, -25.0, t.i_A.d); // the angle is a period old
    CHECK_NEAR(0.1, hypot(25.0, 3.0), hypot((double)t.i_A.d, (double)t.i_A.q));
    // In the channels of a recorder too.
    CHECK_NEAR(0.1, hypot(25.0, 3.0),
               hypot((double)lode_channel_read(&rig.drive, LODE_CHANNEL_I_ALPHA),
                     (double)lode_channel_read(&rig.drive, LODE_CHANNEL_I_BETA)));
}

/// The rotor at `theta`, the vector of a start when its current begins. Until it turns it stands, or sweeps where `sweeps`.
static double first_vector(lode_drive_config_t config, double theta, float direction, bool sweeps) {
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.motor.theta = theta;
    rig_command(&rig, run_at(80.0f * direction));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 1.0));
    const lode_start_t *start = &rig.drive.state.start;
    while (!(start->current_A > 0.0f)) {
        rig_step(&rig);
    }
    const double first = atan2((double)start->at.sin, (double)start->at.cos);
    double moved = 0.0;
    while (start->stage != (uint_least8_t)LODE_START_TURN) {
        rig_step(&rig);
        rig_expect(&rig, LODE_MODE_START);
        const double now = atan2((double)start->at.sin, (double)start->at.cos);
        moved = fmax(moved, fabs(angle_error(now, first)));
    }
    TEST_ASSERT_EQUAL_INT(sweeps, moved > 1.0);
    TEST_ASSERT_TRUE(sweeps || moved < 1.0e-3);
    return first;
}

/// (S40). From every angle, with either polarity and direction: the first vector is 90 to 150 degrees ahead of the rotor's
/// d axis, or of its opposite. Not so of a rotor that is told round or with the larger Ld, or without the signal check.
static void test_the_first_vector_leads_the_axis_of_a_salient_rotor(void) {
    for (int k = 0; k < 24; k++) {
        const double theta = (k + 0.3) * CHECK_PI / 12.0;
        for (int sign = -1; sign <= 1; sign += 2) {
            const double at = first_vector(rig_config(), theta, (float)sign, false);
            const double lead = remainder(sign * (at - theta) - 2.0 * CHECK_PI / 3.0, CHECK_PI);
            CHECK_NEAR(31.0 * CHECK_PI / 180.0, 0.0, lead);
        }
    }
    lode_drive_config_t config = rig_config();
    config.start.signal_check = LODE_OFF;
    CHECK_NEAR(0.1, 0.0, first_vector(config, 1.5, 1.0f, true));
    config = rig_config();
    config.motor.Ld_H = config.motor.Lq_H;
    CHECK_NEAR(0.1, 0.0, first_vector(config, 1.5, 1.0f, true));
}

/// A winding of twice the resistance is corrected by as much as one may be warmer, and no more: 0.75 of it. Two rest
/// positions in three at least let it be measured; with one current alone, what no dead time has counts as resistance.
static void test_much_resistance_is_corrected_in_part(void) {
    int measured = 0;
    for (int k = 0; k < 12; k++) {
        rig_t rig = fresh();
        const double R = rig.motor.R;
        rig.motor.R = 2.0 * R;
        rig.motor.theta = (double)k * CHECK_PI / 6.0;
        run_up(&rig, 80.0, 8.0);
        const double more_Ohm = (double)rig.drive.inverter.r_more_Ohm;
        CHECK_AT_MOST(0.7501 * R, more_Ohm);
        measured += more_Ohm > 0.65 * R ? 1 : 0;
    }
    CHECK_AT_LEAST(8.0, (double)measured);
}

/// A flag of the mailbox that is neither full nor empty trips; then the mailbox is empty, the command is OFF, and all is as
/// after any other fault.
static void test_after_a_mailbox_that_lies_the_drive_can_be_started_again(void) {
    rig_t rig = running(80.0, 8.0);
    rig.drive.command_posted = (uint_least8_t)(LODE_POST_FULL ^ 4u);
    rig_run(&rig, 16.0 * RIG_TS_s);
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_MEMORY, fault.check);
    CHECK_NEAR(0.0, 2.0, fault.measured);
    CHECK_NEAR(0.0, 0.0, fault.limit);
    TEST_ASSERT_EQUAL_INT(LODE_POST_NONE, rig.drive.command_posted);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig.drive.command.mode);
    TEST_ASSERT_EQUAL_UINT(lode_mode_order_check(&rig.drive.command), rig.drive.command.check);
    rig_command(&rig, clear);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
    run_up(&rig, 80.0, 8.0);
}

/// A post that the flags hide from a steady drive is found within a round.
static void test_a_post_that_is_not_told_is_found(void) {
    rig_t rig = steady();
    rig_command(&rig, off);
    rig.drive.mail = false;
    rig.drive.steady = true;
    rig_run(&rig, 2.0 * (double)LODE_SLOW_PERIODS * RIG_TS_s);
    rig_expect(&rig, LODE_MODE_OFF);
}

/// What the guard had counted before the low sides come does not count.
static void test_the_guard_counts_anew_from_the_low_sides_on(void) {
    rig_t rig = coasting(0.0);
    rig.drive.guard.bus = rig.drive.guard.rail = 3u;
    rig_command(&rig, run_at(80.0));
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_PRECHARGE);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.bus);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.rail);
}

static void test_reversal(void) {
    rig_t rig = fresh();
    rig.load_Nm = 0.5;
    run_up(&rig, 80.0, 8.0);
    rig_run(&rig, 1.5);
    check_running(&rig, 80.0);
    rig_command(&rig, run_at(-80.0));
    rig_run(&rig, 6.0);
    check_running(&rig, -80.0);
}

static void test_a_rotor_that_turns_already_is_taken_over(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = fresh();
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.2));
        rig.motor.omega = 3.0 * 80.0 * sign; // coasting
        rig_command(&rig, run_at(80.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.1)); // no I-f start in so short a time
        CHECK_AT_LEAST(70.0, sign * rig.motor.omega / 3.0);
        rig_run(&rig, 2.0);
        check_running(&rig, 80.0 * sign);
    }
}

static void test_pulses_find_a_rotor_that_turns(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = coasting(150.0 * sign);
        double most = 0.0;
        rig_command(&rig, run_at(150.0 * sign));
        rig_step(&rig);
        rig_expect(&rig, LODE_MODE_PRECHARGE);
        // No pulse by the duties that are in force when the low sides come.
        TEST_ASSERT_TRUE(rig.out.gates == LODE_GATES_OFF && !(rig.out.duty.a < 1.0f));
        for (int k = 0; k < 100 && rig_telemetry(&rig).mode == LODE_MODE_PRECHARGE; k++) {
            rig_step(&rig);
        }
        rig_expect(&rig, LODE_MODE_RUN);
        TEST_ASSERT_EQUAL_INT(LODE_GATES_OFF, rig.out.gates);
        CHECK_NEAR(5.0, 450.0 * sign, rig.drive.estimator.pll.omega_rad_s);
        for (int k = 0; k < 8; k++) { // the first duties are the EMF's
            rig_step(&rig);
            TEST_ASSERT_EQUAL_INT(LODE_GATES_ON, rig.out.gates);
            CHECK_NEAR(0.03, 0.0, rig.angle_error);
            if (!(fabs((double)rig.drive.ref_A.q) > 0.0)) { // until speed control asks for torque
                most = fmax(most, fmax(fabs(rig.motor.id), fabs(rig.motor.iq)));
            }
        }
        CHECK_NEAR(0.1, 0.0, most);
        rig_run(&rig, 2.0);
        check_running(&rig, 150.0 * sign);
    }
}

/// A rotor that was found by pulses is run from its EMF: no current, and neither torque nor a fade of a start that never was.
/// Until the first duties act the voltage at the terminals is the EMF, in the middle of each period.
static void test_a_flight_begins_with_the_emf(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = coasting(150.0 * sign);
        const lode_drive_t *drive = &rig.drive;
        rig_command(&rig, run_at(120.0 * sign));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
        // What the run before left where the pulses have nothing.
        memset((char *)&rig.drive.state + sizeof rig.drive.state.precharge, 0x41,
               sizeof rig.drive.state - sizeof rig.drive.state.precharge);
        rig.drive.ref_A = rig.drive.i_A = (lode_dq_t){-3.0f, 4.0f};
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.2));
        const lode_running_t *run = &drive->state.run;
        const double emf_V = 0.142 * rig.motor.omega;
        CHECK_NEAR(0.0, 0.0, drive->u_V.d);
        CHECK_CLOSE(0.01, emf_V, drive->u_V.q);
        CHECK_NEAR(0.0, 0.0, drive->i_A.d);
        CHECK_NEAR(0.0, 0.0, drive->i_A.q);
        CHECK_NEAR(0.0, 0.0, drive->ref_A.d);
        CHECK_NEAR(0.0, 0.0, drive->ref_A.q);
        CHECK_NEAR(0.0, 0.0, run->fade);
        CHECK_NEAR(0.0, 0.0, run->id_A);
        CHECK_NEAR(0.0, 0.0, run->references.id_A);
        CHECK_NEAR(0.0, 0.0, run->speed.torque_Nm);
        CHECK_CLOSE(0.01, rig.motor.omega / 3.0, lode_drive_speed_ref_rad_s(drive));
        for (int n = 0; n < 2; n++) {
            const lode_ab_t u_V =
                lode_inverter_realised(&drive->inverter, drive->steps + (uint32_t)n);
            const double middle = rig.motor.theta + ((double)n - 0.5) * RIG_TS_s * rig.motor.omega;
            CHECK_NEAR(0.02 * fabs(emf_V), -emf_V * sin(middle), u_V.alpha);
            CHECK_NEAR(0.02 * fabs(emf_V), emf_V * cos(middle), u_V.beta);
        }
    }
}

static void test_off_ends_the_pulses(void) {
    rig_t rig = coasting(150.0);
    rig_command(&rig, run_at(150.0));
    rig_run(&rig, 5.0 * RIG_TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_GATES_LOW, rig.out.gates);
    rig_command(&rig, off);
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_expect(&rig, LODE_MODE_OFF);
}

/// Before a start: `swapped`: the sensors of phases a and b; the bus as sampled. Until the start or a fault; periods with all
/// gates on.
static int driven_before(rig_t *rig, bool swapped, bool bus) {
    int driven = 0;
    for (int n = 0; n < 1000 && rig->drive.mode != (uint_least8_t)LODE_MODE_START &&
                    rig->drive.mode != (uint_least8_t)LODE_MODE_FAULT;
         n++) {
        lode_counts_t counts = rig_counts(rig);
        const uint16_t a = counts.i[0];
        counts.i[0] = swapped ? counts.i[1] : a;
        counts.i[1] = swapped ? a : counts.i[1];
        counts.v_bus = bus ? counts.v_bus : (uint16_t)0u;
        rig->out = lode_drive_step(&rig->drive, &counts);
        driven +=
            rig->drive.mode == (uint_least8_t)LODE_MODE_PRECHARGE && rig->out.gates == LODE_GATES_ON
                ? 1
                : 0;
        rig_move(rig);
        CHECK_AT_MOST(0.4 * 12.0, hypot(rig->motor.id, rig->motor.iq));
    }
    return driven;
}

#define PULSE_PERIODS 4 // with the gates on, of each of six pulses

/// (S37), before the first attempt and without turning the rotor.
static void test_a_start_tries_bridge_and_sensors(void) {
    rig_t rig = fresh();
    const double theta = rig.motor.theta;
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_EQUAL_INT(6 * PULSE_PERIODS, driven_before(&rig, false, true));
    rig_expect(&rig, LODE_MODE_START);
    CHECK_NEAR(1.0 * CHECK_DEG, theta, rig.motor.theta);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
}

static void test_swapped_sensors_end_the_start_before_it_begins(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_EQUAL_INT(6 * PULSE_PERIODS, driven_before(&rig, true, true));
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_SIGNALS", lode_check_name(fault.check));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_PRECHARGE, fault.state);
    TEST_ASSERT_TRUE(fault.measured < fault.limit);
    TEST_ASSERT_TRUE(is_idle(rig.out));
}

/// Switched off; of another attempt; and by a bus that is none, which the guard names in START.
static void test_starts_that_try_nothing(void) {
    lode_drive_config_t config = rig_config();
    config.start.signal_check = LODE_OFF;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_EQUAL_INT(0, driven_before(&rig, true, true));
    rig_expect(&rig, LODE_MODE_START);
    rig_t again = fresh();
    rig_command(&again, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&again, LODE_MODE_PRECHARGE, 0.2));
    again.drive.losses = 1u;
    TEST_ASSERT_EQUAL_INT(0, driven_before(&again, true, true));
    rig_expect(&again, LODE_MODE_START);
    rig_t dark = fresh();
    rig_command(&dark, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&dark, LODE_MODE_PRECHARGE, 0.2));
    TEST_ASSERT_EQUAL_INT(6 * PULSE_PERIODS, driven_before(&dark, true, false));
    rig_expect(&dark, LODE_MODE_START);
}

// Whatever a memory that has flipped says of the share.
static void test_duties_of_pulses_stay_in_range(void) {
    const float shares[] = {1.5f, -0.5f, NAN, INFINITY, -INFINITY};
    rig_t searching = coasting(150.0);
    rig_command(&searching, run_at(150.0));
    TEST_ASSERT_TRUE(reach(&searching, LODE_MODE_PRECHARGE, 0.2));
    rig_run(&searching, 2.0 * RIG_TS_s);
    for (int k = 0; k < COUNT_OF(shares); k++) {
        rig_t rig = searching;
        rig.drive.state.precharge.by.fly.share = shares[k];
        rig.drive.state.precharge.by.fly.wait = 2u; // it stays for a period
        rig_step(&rig);
        TEST_ASSERT_TRUE(rig.out.duty.a >= 0.0f && rig.out.duty.a <= 1.0f);
        TEST_ASSERT_EQUAL_FLOAT(rig.out.duty.a, rig.out.duty.b);
        TEST_ASSERT_EQUAL_FLOAT(rig.out.duty.a, rig.out.duty.c);
    }
}

/// Pulses that find a rotor go on for as long as the low sides are on in the time that the capacitors have: 0.2 of it.
static void test_capacitors_are_charged_by_the_pulses_themselves(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.precharge_s = (float)(200.0 * RIG_TS_s);
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.2));
    rig.motor.omega = 3.0 * 150.0;
    rig_command(&rig, run_at(120.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
    double on = 0.0;
    double before = 0.0; // the coasting that follows has none
    for (int n = 0; n < 2000 && rig_telemetry(&rig).mode == LODE_MODE_PRECHARGE; n++) {
        before = on;
        rig_step(&rig);
        on += rig_telemetry(&rig).mode == LODE_MODE_PRECHARGE ? 1.0 - (double)rig.out.duty.a : 0.0;
    }
    rig_expect(&rig, LODE_MODE_RUN);
    CHECK_NEAR(0.6, 40.3, on);
    CHECK_NEAR(0.0, on, before);
}

static void test_capacitors_are_charged_after_pulses_that_find_nothing(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.precharge_s = (float)(PRECHARGE_PERIODS * RIG_TS_s);
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.blocked = true;
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
    int charged = 0;
    for (int k = 0; k < 400 && rig_telemetry(&rig).mode == LODE_MODE_PRECHARGE; k++) {
        rig_step(&rig);
        charged += is_low(rig.out, 0.8f) ? 1 : 0;
    }
    rig_expect(&rig, LODE_MODE_START);
    TEST_ASSERT_EQUAL_INT(PRECHARGE_PERIODS, charged);
}

static void test_off_at_speed_switches_off_at_once(void) {
    rig_t rig = running(80.0, 8.0);
    rig_command(&rig, off);
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_expect(&rig, LODE_MODE_OFF);
}

static void test_a_blocked_rotor_ends_in_a_start_fault(void) {
    rig_t rig = fresh();
    rig.blocked = true;
    rig_command(&rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_FAULT, 30.0)); // three attempts
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_START", lode_check_name((lode_check_t)fault.check));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_START, fault.state);
    TEST_ASSERT_TRUE(is_idle(rig.out));
}

// --- Commands ---------------------------------------------------------------------------------

static void test_bad_commands_are_refused_and_change_nothing(void) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    const lode_drive_t before = rig.drive;
    const int modes[] = {LODE_MODE_START, LODE_MODE_FAULT, 7, -1, 1000};
    for (int i = 0; i < COUNT_OF(modes); i++) {
        const lode_command_t command = {.mode = (lode_mode_t)modes[i]};
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_COMMAND, lode_drive_post_command(&rig.drive, &command));
    }
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        for (int field = 0; field < 6; field++) {
            lode_command_t command = {.mode = LODE_MODE_CURRENT};
            float *const values[] = {&command.speed_rad_s, &command.vector.d,
                                     &command.vector.q,    &command.theta_rad,
                                     &command.omega_rad_s, &command.torque_Nm};
            *values[field] = check_not_finite[i];
            TEST_ASSERT_EQUAL_INT(LODE_ERROR_COMMAND,
                                  lode_drive_post_command(&rig.drive, &command));
        }
    }
    lode_command_t command = run_at(80.0);
    command.control = (lode_control_t)2;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_COMMAND, lode_drive_post_command(&rig.drive, &command));
    // More than the estimator is made for: refused in either direction. Not looked at by other modes.
    const double most = 0.5 * (double)tuning.estimator.omega_limit / 3.0;
    for (int sign = -1; sign <= 1; sign += 2) {
        command = run_at(1.001 * sign * most);
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_COMMAND_SPEED,
                              lode_drive_post_command(&rig.drive, &command));
    }
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_post_command(&rig.drive, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_post_command(NULL, &off));
    TEST_ASSERT_EQUAL_MEMORY(&before, &rig.drive, sizeof before);
    command = (lode_command_t){.mode = LODE_MODE_CURRENT, .speed_rad_s = (float)(2.0 * most)};
    rig_command(&rig, command);
    rig_command(&rig, run_at(0.999 * most));
}

/// The smaller limit counts, in torque control too, and what was commanded before goes on.
static void test_a_speed_that_cannot_be_had_is_refused(void) {
    for (int by = 0; by < 4; by++) {
        const bool by_guard = by % 2 == 1;
        lode_drive_config_t config = rig_config();
        config.estimator.omega_max_rad_s = by_guard ? 900.0f : 600.0f;
        config.guard.omega_max_rad_s = by_guard ? 600.0f : 900.0f;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        run_up(&rig, 100.0, 8.0);
        const int signs[] = {-1, 1};
        for (int n = 0; n < COUNT_OF(signs); n++) {
            lode_command_t command = run_at(signs[n] * 201.0);
            command.control = by < 2 ? LODE_CONTROL_SPEED : LODE_CONTROL_TORQUE;
            TEST_ASSERT_EQUAL_STRING(
                "LODE_ERROR_COMMAND_SPEED",
                lode_status_name(lode_drive_post_command(&rig.drive, &command)));
        }
        rig_run(&rig, 2.0);
        check_running(&rig, 100.0);
        rig_command(&rig, run_at(199.0));
    }
}

static void test_commands_wait_for_the_next_period_and_the_last_counts(void) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE, .vector = {2.0f, 0.0f}});
    rig_expect(&rig, LODE_MODE_OFF);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_VOLTAGE);
    rig_step(&rig);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, rig_telemetry(&rig).u_V.d);
    // The vector follows a new command without leaving the mode.
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE, .vector = {4.0f, 0.0f}});
    rig_step(&rig);
    TEST_ASSERT_TRUE(rig.out.gates);
    TEST_ASSERT_EQUAL_FLOAT(4.0f, rig_telemetry(&rig).u_V.d);
}

static void test_a_command_that_comes_within_a_period_waits_for_the_next(void) {
    // From an interrupt of higher priority, behind the place where the step takes the mail.
    rig_t rig = running(60.0, 3.0);
    rig_command(&rig, off);
    lode_mode_follow(&rig.drive);
    rig_expect(&rig, LODE_MODE_RUN);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
    TEST_ASSERT_TRUE(is_idle(rig.out));
}

static void test_huge_commands_give_duties(void) {
    const float huge[] = {FLT_MAX, -FLT_MAX, 1.0e20f};
    for (int i = 0; i < COUNT_OF(huge); i++) {
        const lode_mode_t modes[] = {LODE_MODE_VOLTAGE, LODE_MODE_CURRENT, LODE_MODE_RUN};
        for (int m = 0; m < COUNT_OF(modes); m++) {
            rig_t rig = fresh();
            rig.blocked = true;
            rig_command(&rig, (lode_command_t){.mode = modes[m],
                                               .torque_Nm = huge[i],
                                               .control = LODE_CONTROL_TORQUE,
                                               .speed_rad_s = modes[m] == LODE_MODE_RUN
                                                                  ? copysignf(150.0f, huge[i])
                                                                  : huge[i],
                                               .vector = {huge[i], huge[i]},
                                               .theta_rad = huge[i],
                                               .omega_rad_s = huge[i]});
            for (int n = 0; n < 2000; n++) {
                rig_step(&rig);
                const lode_abc_t d = rig.out.duty;
                TEST_ASSERT_TRUE(lode_in_range(d.a, 0.0f, 1.0f) && lode_in_range(d.b, 0.0f, 1.0f) &&
                                 lode_in_range(d.c, 0.0f, 1.0f));
            }
        }
    }
}

// --- Tunings ----------------------------------------------------------------------------------

static void test_the_same_tuning_changes_nothing(void) {
    rig_t one = running(90.0, 8.0);
    rig_t two = one;
    other_tuning = tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&two.drive, &other_tuning));
    for (int n = 0; n < 5000; n++) {
        rig_step(&one);
        rig_step(&two);
        TEST_ASSERT_EQUAL_MEMORY(&one.out.duty, &two.out.duty, sizeof one.out.duty);
    }
    TEST_ASSERT_TRUE(lode_drive_tuning_taken(&two.drive));
    TEST_ASSERT_TRUE(two.drive.tuning == &other_tuning);
}

static void test_a_new_tuning_is_taken_at_a_period(void) {
    rig_t rig = running(90.0, 8.0);
    rig_run(&rig, 2.0);
    lode_drive_config_t config = rig_config();
    config.estimator.pll.kind = LODE_PLL_QPLL;
    config.current.voltage_use = 0.8f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    TEST_ASSERT_TRUE(lode_drive_tuning_taken(&rig.drive));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    TEST_ASSERT_FALSE(lode_drive_tuning_taken(&rig.drive));
    TEST_ASSERT_TRUE(rig.drive.tuning == &tuning);
    rig_step(&rig);
    TEST_ASSERT_TRUE(lode_drive_tuning_taken(&rig.drive));
    TEST_ASSERT_TRUE(rig.drive.tuning == &other_tuning);
    rig_run(&rig, 2.0);
    check_running(&rig, 90.0);                                         // all states went on
    TEST_ASSERT_EQUAL_FLOAT(0.0f, rig_telemetry(&rig).load_torque_Nm); // the QPLL has none
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_post_tuning(&rig.drive, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_post_tuning(NULL, &tuning));
}

/// Holds 4 A along the axis of `phase`, so that its duty is the longest, with the phase not sampled.
static rig_t holding_without(int phase, const lode_drive_config_t *config) {
    rig_t rig;
    rig_init(&rig, &tuning, config);
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT,
                                       .vector = {4.0f, 0.0f},
                                       .theta_rad = (float)(phase * 2.0 * CHECK_PI / 3.0)});
    rig_run(&rig, 0.2);
    TEST_ASSERT_TRUE(rig.out.gates);
    return rig;
}

/// A call with 18.75 A of 18 A in one phase.
static bool trips(rig_t *rig, int phase) {
    lode_counts_t counts = rig_counts(rig);
    counts.i[phase] = 2048u + 1500u;
    const bool gates = lode_drive_step(&rig->drive, &counts).gates;
    TEST_ASSERT_EQUAL_INT(gates ? LODE_CHECK_NONE : LODE_CHECK_OVER_CURRENT,
                          rig->drive.guard.fault.check);
    return !gates;
}

static void test_a_tuning_that_samples_all_phases_watches_all(void) {
    lode_drive_config_t windowed[2] = {rig_config(), rig_config()};
    windowed[0].sense.duty_max = 0.5f;
    windowed[1].sense.shunts = LODE_SHUNTS_TWO;
    const lode_drive_config_t all = rig_config();
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &all));
    for (int n = 0; n < 4; n++) {
        const int phase = n < 3 ? n : 2;
        rig_t rig = holding_without(phase, &windowed[n / 3]);
        rig_t unseen = rig;
        TEST_ASSERT_FALSE(trips(&unseen, phase)); // its sample is of no use
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
        rig_step(&rig);
        for (int later = 0; later < 20; later++) {
            rig_t seen = rig;
            TEST_ASSERT_TRUE(trips(&seen, phase));
            rig_step(&rig);
        }
        TEST_ASSERT_TRUE(rig.out.gates);
    }
}

static void test_a_tuning_with_windows_leaves_out_what_is_not_sampled(void) {
    lode_drive_config_t config = rig_config();
    config.sense.duty_max = 0.5f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    const lode_drive_config_t all = rig_config();
    for (int phase = 0; phase < 3; phase++) {
        rig_t rig = holding_without(phase, &all);
        rig_t seen = rig;
        TEST_ASSERT_TRUE(trips(&seen, phase));
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
        rig_step(&rig);
        for (int later = 0; later < 20; later++) {
            rig_t unseen = rig;
            TEST_ASSERT_FALSE(trips(&unseen, phase));
            rig_step(&rig);
        }
    }
}

#define PLACE_FLOAT(type, member) offsetof(lode_drive_tuning_t, member),
#define PLACE_INTEGER(type, member)
#define PLACE_WHOLE(type, member)
#define PLACE_OBSERVER(place, member) PLACE_FLOAT(float, member)
#define PLACE(kind, type, member) PLACE_##kind(type, member)
static const size_t floats_of_a_tuning[] = {TUNING_FIELDS(PLACE)};

#define NAME_FLOAT(type, member) #member,
#define NAME_INTEGER(type, member)
#define NAME_WHOLE(type, member)
#define NAME_OBSERVER(place, member) NAME_FLOAT(float, member)
#define NAME(kind, type, member) NAME_##kind(type, member)
static const char *const names_of_a_tuning[] = {TUNING_FIELDS(NAME)};

/// A period with whatever a tuning may hold: with the gates on a duty is a duty, with them off idle.
static bool driven_by_duties(rig_t *rig) {
    rig_step(rig);
    const lode_abc_t d = rig->out.duty;
    return (rig->out.gates && lode_in_range(d.a, 0.0f, 1.0f) && lode_in_range(d.b, 0.0f, 1.0f) &&
            lode_in_range(d.c, 0.0f, 1.0f)) ||
           is_idle(rig->out);
}

/// The same drive while one float of its tuning has changed by itself; how many of them tripped for what is no duty.
static int trips_of_bad_floats(const rig_t *sound) {
    const lode_drive_tuning_t good = *sound->drive.tuning;
    int tripped = 0;
    for (int n = 0; n < COUNT_OF(floats_of_a_tuning) * COUNT_OF(check_not_finite); n++) {
        const int field = n / COUNT_OF(check_not_finite);
        rig_t rig = *sound;
        other_tuning = good;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
        rig_step(&rig);
        memcpy((char *)&other_tuning + floats_of_a_tuning[field],
               &check_not_finite[n % COUNT_OF(check_not_finite)], sizeof(float));
        for (int k = 0; k < 100; k++) {
            TEST_ASSERT_TRUE_MESSAGE(driven_by_duties(&rig), names_of_a_tuning[field]);
        }
        tripped += rig_telemetry(&rig).fault.check == LODE_CHECK_NON_FINITE ? 1 : 0;
        // Nothing of it stays once the tuning is sound again.
        rig.motor = sound->motor;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &tuning));
        rig_command(&rig, clear);
        rig_run(&rig, 0.002);
        rig.motor.omega = 0.0;
        rig.blocked = true;
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
        rig_run(&rig, 0.05);
        rig_expect(&rig, LODE_MODE_CURRENT);
        CHECK_NEAR(0.05, 4.0, ipmsm_current(&rig.motor).alpha);
    }
    return tripped;
}

static void test_a_float_of_a_tuning_that_is_no_number_makes_no_duty(void) {
    for (int grid = 0; grid < 2; grid++) {
        lode_drive_config_t config = rig_config();
        config.inverter.pwm_ticks = grid == 0 ? 0.0f : 8400.0f;
        config.inverter.dead_time_s = 2.0e-6f;
        config.guard.v_bus_max_V = 400.0f;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        const lode_command_t commands[] = {
            {.mode = LODE_MODE_VOLTAGE, .vector = {5.0f, 0.0f}, .omega_rad_s = 100.0f},
            {.mode = LODE_MODE_CURRENT, .vector = {3.0f, 0.0f}, .omega_rad_s = 10.0f},
            run_at(100.0)};
        for (int c = 0; c < COUNT_OF(commands); c++) {
            rig_command(&rig, off);
            rig_run(&rig, 0.01);
            rig.motor.omega = 0.0;
            rig_command(&rig, commands[c]);
            rig_run(&rig, 0.15);
            TEST_ASSERT_TRUE(c == 2 || rig.out.gates);
            if (c == 2) {
                TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 8.0));
                rig_run(&rig, 0.1);
                CHECK_AT_LEAST(1, trips_of_bad_floats(&rig));
                TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
                rig_run(&rig, 0.5);
            }
            CHECK_AT_LEAST(1, trips_of_bad_floats(&rig));
        }
    }
}

static void test_a_grid_that_is_no_number_trips_in_the_same_call(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.pwm_ticks = 8400.0f;
    rig_t rig = holding_without(0, &config);
    tuning.inverter.inv_ticks = NAN; // by itself: the post refuses it
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NON_FINITE, rig_telemetry(&rig).fault.check);
    CHECK_NEAR(0.0, 1.0, rig_telemetry(&rig).fault.measured);
    CHECK_NEAR(0.0, 0.0, rig_telemetry(&rig).fault.limit);
}

#define INTEGER_FLOAT(type, member)
#define INTEGER_INTEGER(type, member) offsetof(lode_drive_tuning_t, member),
#define INTEGER_WHOLE(type, member) INTEGER_INTEGER(type, member)
#define INTEGER_OBSERVER(place, member)
#define INTEGER_PLACE(kind, type, member) INTEGER_##kind(type, member)
static const size_t integers_of_a_tuning[] = {TUNING_FIELDS(INTEGER_PLACE)};

/// Nothing of such a tuning is taken, neither running nor at the beginning.
static void test_a_tuning_with_a_float_that_is_no_number_is_refused(void) {
    const rig_t sound = running(90.0, 8.0);
    for (int n = 0; n < COUNT_OF(floats_of_a_tuning) * COUNT_OF(check_not_finite); n++) {
        const int field = n / COUNT_OF(check_not_finite);
        other_tuning = tuning;
        memcpy((char *)&other_tuning + floats_of_a_tuning[field],
               &check_not_finite[n % COUNT_OF(check_not_finite)], sizeof(float));
        rig_t rig = sound;
        TEST_ASSERT_EQUAL_STRING_MESSAGE(
            "LODE_ERROR_TUNING",
            lode_status_name(lode_drive_post_tuning(&rig.drive, &other_tuning)),
            names_of_a_tuning[field]);
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_TUNING, lode_drive_begin(&rig.drive, &other_tuning));
        TEST_ASSERT_EQUAL_MEMORY(&sound.drive, &rig.drive, sizeof rig.drive);
    }
}

static void test_an_integer_of_a_tuning_may_be_any(void) {
    rig_t rig = fresh();
    for (int n = 0; n < COUNT_OF(integers_of_a_tuning); n++) {
        other_tuning = tuning;
        const size_t word = integers_of_a_tuning[n] / sizeof(uint32_t) * sizeof(uint32_t);
        memset((char *)&other_tuning + word, 0xff, sizeof(uint32_t));
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    }
}

static void test_a_refused_tuning_leaves_the_one_that_waits(void) {
    rig_t rig = fresh();
    other_tuning = tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    lode_drive_tuning_t bad = tuning;
    bad.references.i_max_A = NAN;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_TUNING, lode_drive_post_tuning(&rig.drive, &bad));
    rig_run(&rig, 0.1);
    TEST_ASSERT_TRUE(rig.drive.tuning == &other_tuning);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
}

// --- The bus ----------------------------------------------------------------------------------

static void test_a_bus_that_jumps_is_divided_by_at_once(void) {
    lode_drive_config_t config = rig_config();
    config.guard.v_bus_max_V = 409.0f;
    config.guard.v_bus_min_V = 1.0f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE, .vector = {9.0f, 0.0f}});
    rig_run(&rig, 0.01);
    // Doubled, halved, and there again, in every slot of the slow jobs.
    const uint16_t buses[] = {4000u, 2000u, 1000u, 2000u, 4000u, 1000u, 2000u};
    for (int n = 0; n < 7 * 9; n++) {
        lode_counts_t counts = rig_counts(&rig);
        counts.v_bus = buses[n % COUNT_OF(buses)];
        rig.out = lode_drive_step(&rig.drive, &counts);
        TEST_ASSERT_TRUE(rig.out.gates);
        CHECK_NEAR(1.0e-4, 9.0, 0.1f * (float)counts.v_bus * lode_clarke(rig.out.duty).alpha);
    }
}

static void test_a_bus_without_reading_stays_in_range(void) {
    lode_drive_config_t config = rig_config();
    config.guard.v_bus_max_V = 409.0f;
    config.guard.bus_s = 0.1f;
    config.guard.plausibility = LODE_OFF; // the motor stands still in this
    rig_t start;
    rig_init(&start, &tuning, &config);
    run_up(&start, 100.0, 8.0);
    rig_run(&start, 1.0);
    for (int slot = 0; slot < (int)LODE_SLOW_PERIODS; slot++) {
        rig_step(&start);
        rig_t rig = start;
        random_t random = random_seed((uint32_t)slot);
        for (int n = 0; n < 80; n++) { // 16 ms of the 100 ms that it takes to trip
            lode_counts_t counts = rig_counts(&rig);
            // None, then anything, then falling towards none.
            counts.v_bus = 0u;
            if (n >= 60) {
                counts.v_bus = (uint16_t)(2000u >> ((n - 60) / 2));
            } else if (n >= 20) {
                counts.v_bus = (uint16_t)(random_bits(&random) % 4096u);
            }
            rig.out = lode_drive_step(&rig.drive, &counts);
            TEST_ASSERT_TRUE(rig.out.gates);
            TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.a, 0.0f, 1.0f));
            TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.b, 0.0f, 1.0f));
            TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.c, 0.0f, 1.0f));
        }
    }
}

// --- Faults -----------------------------------------------------------------------------------

/// A rig that holds 4 A at an angle.
static rig_t holding(void) {
    rig_t rig = fresh();
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
    rig_run(&rig, 0.1);
    TEST_ASSERT_TRUE(rig.out.gates);
    return rig;
}

static void test_over_current_of_either_sign_in_the_same_call(void) {
    for (int phase = 0; phase < 3; phase++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            rig_t rig = holding();
            lode_counts_t counts = rig_counts(&rig);
            counts.i[phase] = (uint16_t)(2048 + sign * 1500); // 18.75 A of 18 A
            const lode_drive_out_t out = lode_drive_step(&rig.drive, &counts);
            TEST_ASSERT_TRUE(is_idle(out));
            const lode_fault_t fault = rig_telemetry(&rig).fault;
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, fault.check);
            TEST_ASSERT_EQUAL_INT(LODE_MODE_CURRENT, fault.state);
            CHECK_NEAR(1.0e-3, sign * 18.75, fault.measured);
            CHECK_NEAR(1.0e-3, 18.0, fault.limit);
            rig_expect(&rig, LODE_MODE_FAULT);
        }
    }
}

static void test_hardware_trip_in_the_same_call(void) {
    rig_t rig = holding();
    rig.trip = true;
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, rig_telemetry(&rig).fault.check);
}

static bool is_shorted(lode_drive_out_t out) {
    return out.gates == LODE_GATES_LOW && out.duty.a == 0.0f && out.duty.b == 0.0f &&
           out.duty.c == 0.0f;
}

/// Low sides on from the call of the fault on, until somebody says otherwise.
static void test_a_fault_shorts_the_motor_where_that_is_commanded(void) {
    rig_t rig = holding();
    rig_command(&rig, (lode_command_t){
                          .mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}, .active_short = true});
    rig_run(&rig, 0.01);
    TEST_ASSERT_EQUAL_INT(LODE_GATES_ON, rig.out.gates);
    rig.sag_V = 150.0;
    for (int n = 0; n < 100 && rig.out.gates == LODE_GATES_ON; n++) {
        rig_step(&rig);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_UNDER_VOLTAGE, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_TRUE(is_shorted(rig.out));
    rig_run(&rig, 0.01);
    TEST_ASSERT_TRUE(is_shorted(rig.out));
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF});
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .active_short = true});
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_shorted(rig.out));
    rig_command(&rig,
                (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true, .active_short = true});
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out)); // OFF is off
    rig_expect(&rig, LODE_MODE_OFF);
}

/// A switch may be shorted: the low sides come only when somebody has looked at it, and says OFF.
static void test_a_trip_by_current_shorts_nothing_by_itself(void) {
    for (int by_hardware = 0; by_hardware <= 1; by_hardware++) {
        rig_t rig = holding();
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT,
                                           .vector = {4.0f, 0.0f},
                                           .active_short = true});
        rig_run(&rig, 0.01);
        lode_counts_t counts = rig_counts(&rig);
        counts.trip = by_hardware == 1;
        counts.i[0] = by_hardware == 1 ? counts.i[0] : 548u;
        TEST_ASSERT_TRUE(is_idle(lode_drive_step(&rig.drive, &counts)));
        counts.i[0] = 2048u;
        TEST_ASSERT_TRUE(is_idle(lode_drive_step(&rig.drive, &counts)));
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .active_short = true});
        TEST_ASSERT_TRUE(is_shorted(lode_drive_step(&rig.drive, &counts)));
    }
}

/// The current of phase a, 18.75 A of 18 A, that flows on after a trip for so many periods: the check.
static uint32_t after_current(rig_t *rig, int sign, int periods) {
    lode_counts_t counts = rig_counts(rig);
    counts.i[0] = (uint16_t)(2048 + sign * 1500);
    counts.i[1] = counts.i[2] = (uint16_t)(2048 - sign * 750);
    for (int n = 0; n < periods; n++) {
        (void)lode_drive_step(&rig->drive, &counts);
    }
    return rig_telemetry(rig).fault.check;
}

/// A sound bridge stops the current; 1 ms is five periods, and the decay four more.
static void test_a_current_that_flows_on_is_a_shorted_switch(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = holding();
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, sign, 9));
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, sign, 1));
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        CHECK_NEAR(1.0e-3, sign * 18.75, fault.measured);
        CHECK_NEAR(1.0e-3, 18.0, fault.limit);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_CURRENT, fault.state);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, -sign, 20));
        CHECK_NEAR(1.0e-3, sign * 18.75, rig_telemetry(&rig).fault.measured);
    }
    rig_t rig = holding();
    rig.trip = true;
    rig_step(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, 1, 9));
    CHECK_NEAR(1.0e-3, 18.0, rig_telemetry(&rig).fault.limit);
}

/// A fault of 62 A and more is beyond what 12 bits show: the phase in the middle still tells the side.
static void test_samples_at_the_rails_tell_the_side_too(void) {
    for (int high = 0; high <= 1; high++) {
        rig_t rig = holding();
        rig.trip = true;
        rig_step(&rig);
        rig.trip = false;
        lode_counts_t counts = rig_counts(&rig);
        counts.i[0] = high == 1 ? 0u : 4095u;
        counts.i[1] = high == 1 ? 4095u : 0u;
        counts.i[2] = high == 1 ? 1548u : 2548u;
        for (int n = 0; n < 9; n++) {
            (void)lode_drive_step(&rig.drive, &counts);
        }
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, fault.check);
        TEST_ASSERT_TRUE(high == 1 ? fault.measured > 25.0f : fault.measured < -25.0f);
    }
}

/// A side that changes, or a current in two phases alone, is no shorted switch.
static void test_a_shorted_switch_shows_one_side(void) {
    rig_t rig = holding();
    (void)after_current(&rig, 1, 1);
    for (int n = 0; n < 10; n++) {
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, n % 2 == 0 ? 1 : -1, 8));
    }
    rig = holding();
    (void)after_current(&rig, 1, 1);
    const lode_counts_t sound = rig_counts(&rig);
    for (int k = -1; k <= 1; k++) { // the third one has a little by its offset
        rig_t two_phases = rig;
        lode_counts_t counts = sound;
        counts.i[0] = 3548u;
        counts.i[1] = 548u;
        counts.i[2] = (uint16_t)(2048 + 20 * k);
        for (int n = 0; n < 50; n++) {
            (void)lode_drive_step(&two_phases.drive, &counts);
        }
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, rig_telemetry(&two_phases).fault.check);
    }
}

static void test_other_currents_with_the_gates_off_are_no_shorted_switch(void) {
    rig_t rig = holding();
    rig.trip = true;
    rig_run(&rig, 0.01); // a trip input that stays, without current
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, rig_telemetry(&rig).fault.check);
    rig = holding();
    rig.sag_V = 150.0;
    rig_run(&rig, 0.01); // of another cause
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_UNDER_VOLTAGE, after_current(&rig, 1, 50));
    rig = holding();
    (void)after_current(&rig, 1, 1);
    rig.drive.estimator.pll.omega_rad_s = 900.0f; // 221 V between the lines, by the diodes
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, 1, 50));
    rig.drive.estimator.pll.omega_rad_s = -800.0f; // 197 V of 200 V
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, after_current(&rig, 1, 10));
    rig = holding();
    (void)after_current(&rig, 1, 1);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .active_short = true});
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, after_current(&rig, 1, 50)); // its own
    rig = fresh();
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, after_current(&rig, 1, 50)); // OFF
}

static void test_a_single_sample_at_the_rail_passes(void) {
    lode_drive_config_t config = rig_config();
    config.guard.i_trip_A = 2047.0f * (float)RIG_GAIN_A; // what the highest count says
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
    rig_run(&rig, 0.1);
    lode_counts_t counts = rig_counts(&rig);
    counts.i[0] = 4095u;
    TEST_ASSERT_TRUE(lode_drive_step(&rig.drive, &counts).gates);
    rig_run(&rig, 0.1);
    rig_expect(&rig, LODE_MODE_CURRENT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    for (int n = 0; n < 10; n++) { // of the 5 periods in 1 ms
        (void)lode_drive_step(&rig.drive, &counts);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_RAIL, rig_telemetry(&rig).fault.check);
}

static void test_a_call_that_is_late_trips_at_once(void) {
    lode_drive_config_t config = rig_config();
    config.guard.stamp_per_period = 1000.0f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
    rig_run(&rig, 0.1);
    TEST_ASSERT_TRUE(rig.out.gates);
    rig.stamp += 1000u; // one was left out
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_TIMING, fault.check);
    TEST_ASSERT_EQUAL_FLOAT(2000.0f, fault.measured);
}

static void test_bus_out_of_range_trips_after_its_debounce(void) {
    const uint16_t buses[] = {2600, 1100}; // 260 V of 250 V, 110 V of 120 V
    const lode_check_t checks[] = {LODE_CHECK_OVER_VOLTAGE, LODE_CHECK_UNDER_VOLTAGE};
    for (int i = 0; i < COUNT_OF(buses); i++) {
        rig_t rig = holding();
        lode_counts_t counts = rig_counts(&rig);
        counts.v_bus = buses[i];
        // 1 ms are two looks of the slow checks, each 0.8 ms: one is under way.
        int periods = 1;
        while (lode_drive_step(&rig.drive, &counts).gates && periods < 100) {
            periods++;
        }
        CHECK_AT_LEAST(0.5 * LODE_SLOW_PERIODS + 1.0, periods);
        CHECK_AT_MOST(LODE_SLOW_PERIODS, periods);
        TEST_ASSERT_EQUAL_INT(checks[i], rig_telemetry(&rig).fault.check);
    }
}

static void test_a_fault_stays_until_it_is_cleared(void) {
    rig_t rig = holding();
    rig.trip = true;
    rig_step(&rig);
    rig.trip = false;
    const lode_fault_t first = rig_telemetry(&rig).fault;
    const lode_command_t commands[] = {
        off,
        run_at(50.0),
        {.mode = LODE_MODE_CURRENT, .vector = {1.0f, 0.0f}},
        {.mode = LODE_MODE_CALIBRATE},
        {.mode = LODE_MODE_RUN, .speed_rad_s = 50.0f, .clear_fault = true}};
    for (int i = 0; i < COUNT_OF(commands); i++) {
        rig_command(&rig, commands[i]);
        rig_run(&rig, 0.3);
        rig_expect(&rig, LODE_MODE_FAULT);
        TEST_ASSERT_TRUE(is_idle(rig.out));
        const lode_fault_t now = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_INT(first.check, now.check);
        TEST_ASSERT_EQUAL_INT(first.state, now.state);
        TEST_ASSERT_TRUE(first.measured == now.measured && first.limit == now.limit);
    }
    rig_command(&rig, clear);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {1.0f, 0.0f}});
    rig_step(&rig);
    rig_step(&rig);
    TEST_ASSERT_TRUE(rig.out.gates);
}

/// One bit of the drive flips, `offset` bytes from its beginning. Gates off within a round, and the fault says
/// what it was.
static void check_flip(const rig_t *sound, size_t offset, int bit, float which) {
    rig_t rig = *sound;
    const lode_mode_t before = rig_telemetry(&rig).mode;
    unsigned char *octet = (unsigned char *)&rig.drive + offset;
    *octet = (unsigned char)(*octet ^ (1u << bit));
    for (uint32_t k = 0; k <= LODE_SLOW_PERIODS; k++) {
        rig_step(&rig);
    }
    char text[60];
    (void)snprintf(text, sizeof text, "%s, byte %d, bit %d", lode_mode_name(before), (int)offset,
                   bit);
    const lode_telemetry_t after = rig_telemetry(&rig);
    TEST_ASSERT_TRUE_MESSAGE(is_idle(rig.out), text);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("LODE_CHECK_MEMORY", lode_check_name(after.fault.check), text);
    TEST_ASSERT_TRUE_MESSAGE(after.fault.measured == which, text);
    rig_command(&rig, clear);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_OFF);
}

static void test_a_mode_or_command_that_changes_by_itself_trips(void) {
    rig_t rigs[4];
    rigs[0] = fresh();
    rigs[1] = fresh();
    rig_command(&rigs[1], (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    rig_step(&rigs[1]);
    rigs[2] = holding();
    rigs[3] = fresh();
    rig_command(&rigs[3], run_at(100.0));
    TEST_ASSERT_TRUE(reach(&rigs[3], LODE_MODE_RUN, 8.0));
    for (int n = 0; n < COUNT_OF(rigs); n++) {
        for (int bit = 0; bit < 8; bit++) {
            check_flip(&rigs[n], offsetof(lode_drive_t, mode), bit, 1.0f);
            check_flip(&rigs[n], offsetof(lode_drive_t, mode_not), bit, 1.0f);
        }
        check_flip(&rigs[n], offsetof(lode_drive_t, gates), 0, 1.0f);
        if (n < 3) { // running, the flag is set
            check_flip(&rigs[n], offsetof(lode_drive_t, steady), 0, 1.0f);
        }
        const size_t order = offsetof(lode_drive_t, command);
        const size_t speed = order + offsetof(lode_order_t, speed_rad_s);
        const size_t value = order + offsetof(lode_order_t, value);
        for (int bit = 0; bit < 32; bit++) {
            check_flip(&rigs[n], speed + (size_t)bit / 8u, bit % 8, 2.0f);
            check_flip(&rigs[n], value + (size_t)bit / 8u, bit % 8, 2.0f);
        }
        for (int bit = 0; bit < 8; bit++) {
            check_flip(&rigs[n], order + offsetof(lode_order_t, flags), bit, 2.0f);
        }
        for (int bit = 0; bit < 8; bit++) {
            check_flip(&rigs[n], offsetof(lode_drive_t, command_posted), bit, 2.0f);
        }
    }
}

/// A bit of the mailbox flips between a post and the call that takes it: the command is followed, or the drive
/// says that it is lost.
static void test_a_posted_command_is_not_lost_by_a_flip(void) {
    const lode_command_t calibrate = {.mode = LODE_MODE_CALIBRATE};
    for (int bit = 0; bit < 8; bit++) {
        rig_t rig = fresh();
        rig_command(&rig, calibrate);
        unsigned char *flag = (unsigned char *)&rig.drive.command_posted;
        *flag = (unsigned char)(*flag ^ (1u << bit));
        rig_step(&rig);
        rig_step(&rig);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_MEMORY",
                                 lode_check_name(rig_telemetry(&rig).fault.check));
    }
    rig_t rig = fresh();
    rig_command(&rig, calibrate);
    rig.drive.mail = false;
    rig_step(&rig);
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_CALIBRATE);
    rig = fresh();
    rig_command(&rig, calibrate);
    rig.drive.mail = false;
    rig.drive.mode = (uint_least8_t)LODE_MODE_START;
    rig_step(&rig); // what is wrong besides is named
    TEST_ASSERT_TRUE(rig_telemetry(&rig).fault.measured == 1.0f);
    rig = fresh();
    run_up(&rig, 100.0, 8.0);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF});
    rig.drive.mail = false;
    for (uint32_t n = 0; n <= 2u * LODE_SLOW_PERIODS; n++) {
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_OFF);
}

/// A bit of a word of the tuning in use flips, in another octet from word to word, and stays so for `time_s`.
static lode_fault_t after_flip(const rig_t *sound, size_t word, double time_s) {
    rig_t rig = *sound;
    unsigned char *octet =
        (unsigned char *)&other_tuning + word * sizeof(float) + word % sizeof(float);
    const unsigned bit = 1u << word / sizeof(float) % 8u;
    *octet = (unsigned char)(*octet ^ bit);
    rig_run(&rig, time_s);
    *octet = (unsigned char)(*octet ^ bit);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    return rig_telemetry(&rig).fault;
}

#define WORDS_OF_A_TUNING (sizeof other_tuning / sizeof(float))

static bool is_of_the_guard(size_t word) {
    const size_t from = offsetof(lode_drive_tuning_t, guard);
    return word * sizeof(float) - from < sizeof other_tuning.guard; // wraps round below it
}

/// Standing, a word is looked at in each period, running in every eighth.
static void test_a_tuning_that_changes_by_itself_trips(void) {
    for (int running = 0; running < 2; running++) {
        rig_t rig = fresh();
        other_tuning = *rig.drive.tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
        rig_step(&rig);
        if (running == 1) {
            rig_command(&rig, run_at(100.0));
            TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
            rig_run(&rig, 0.5);
        }
        const uint32_t periods = running == 1 ? LODE_SLOW_PERIODS : 1u;
        const double walk_s = (double)((WORDS_OF_A_TUNING + 2) * periods) * (double)PAPER_TS_s;
        const rig_t sound = rig;
        rig_run(&rig, 5.0 * walk_s);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
        for (size_t word = 0; word < WORDS_OF_A_TUNING; word += running == 1 ? 7 : 1) {
            const lode_fault_t fault = after_flip(&sound, word, 2.0 * walk_s);
            if (is_of_the_guard(word) && fault.check != (uint_least8_t)LODE_CHECK_MEMORY) {
                TEST_ASSERT_TRUE(fault.check != (uint_least8_t)LODE_CHECK_NONE);
                continue; // a limit that is passed trips at once
            }
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_MEMORY", lode_check_name(fault.check));
            TEST_ASSERT_TRUE(fault.measured == 3.0f);
        }
    }
}

/// Two of its bits flip while nothing is driven.
static void check_pair(const rig_t *sound, uint32_t a, uint32_t b) {
    rig_t rig = *sound;
    unsigned char *octets = (unsigned char *)&other_tuning;
    octets[a / 8u] = (unsigned char)(octets[a / 8u] ^ 1u << a % 8u);
    octets[b / 8u] = (unsigned char)(octets[b / 8u] ^ 1u << b % 8u);
    rig_run(&rig, 2.0 * (double)(WORDS_OF_A_TUNING + 2) * RIG_TS_s);
    octets[a / 8u] = (unsigned char)(octets[a / 8u] ^ 1u << a % 8u);
    octets[b / 8u] = (unsigned char)(octets[b / 8u] ^ 1u << b % 8u);
    TEST_ASSERT_EQUAL_STRING(a == b ? "LODE_CHECK_NONE" : "LODE_CHECK_MEMORY",
                             lode_check_name(rig_telemetry(&rig).fault.check));
}

static void test_two_bits_of_a_tuning_that_change_by_themselves_trip(void) {
    rig_t rig = fresh();
    other_tuning = tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    rig_step(&rig);
    check_pair(&rig, 0u, 0u);
    random_t random = random_seed(9u);
    const uint32_t bits = 32u * (uint32_t)WORDS_OF_A_TUNING;
    for (int n = 0; n < 300; n++) {
        const uint32_t a = random_bits(&random) % bits;
        check_pair(&rig, a, (a + 1u + random_bits(&random) % (bits - 1u)) % bits);
    }
    for (uint32_t bit = 0; bit < 32u; bit++) { // in the next word beside it
        check_pair(&rig, 320u + bit, 351u + bit);
        check_pair(&rig, 320u + bit, 352u + bit);
        check_pair(&rig, 320u + bit, 353u + bit);
    }
}

/// Of two in a row only the second is taken, with its own check.
static void test_a_tuning_posted_twice_is_watched_by_its_own_check(void) {
    rig_t rig = fresh();
    lode_drive_config_t config = rig_config();
    config.speed.ramp_rad_s2 = 100.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, rig.drive.tuning));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    rig_run(&rig, 0.2);
    TEST_ASSERT_TRUE(rig.drive.tuning == &other_tuning);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
}

#define WORDS_OF_SIX_PHASES (sizeof(lode_drive6_tuning_t) / sizeof(uint32_t))
#define BITS_OF_A_CHECK 32u

static uint32_t check_of(const uint32_t words[], size_t count) {
    lode_drive_t drive;
    lode_tuning_post_check(&drive, (lode_words_t){(const unsigned char *)words, (uint32_t)count});
    return drive.posted_check;
}

static void test_the_check_is_the_remainder_of_its_polynomial(void) {
    uint32_t words[10];
    random_t random = random_seed(1u);
    for (int n = 0; n < 100; n++) {
        uint32_t crc = 0xffffffffu;
        for (int w = 0; w < COUNT_OF(words); w++) {
            words[w] = random_bits(&random);
            for (int bit = 0; bit < 32; bit++) {
                const uint32_t out = (crc ^ words[w] >> bit) & 1u;
                crc = crc >> 1 ^ out * 0x98880000u; // x^12 + x^8 + x^4 + x^3 + 1, x^31 at the right
            }
        }
        TEST_ASSERT_EQUAL_HEX32(crc, check_of(words, COUNT_OF(words)));
    }
}

/// By what each bit of the words changes the check, then each of the check itself.
static void find_changes(uint32_t changes[]) {
    static uint32_t words[WORDS_OF_SIX_PHASES];
    const uint32_t check = check_of(words, WORDS_OF_SIX_PHASES);
    for (size_t bit = 0; bit < 32u * WORDS_OF_SIX_PHASES; bit++) {
        words[bit / 32u] = 1u << bit % 32u;
        changes[bit] = check ^ check_of(words, WORDS_OF_SIX_PHASES);
        words[bit / 32u] = 0u;
    }
    for (uint32_t bit = 0; bit < BITS_OF_A_CHECK; bit++) {
        changes[32u * WORDS_OF_SIX_PHASES + bit] = 1u << bit;
    }
}

static int by_size(const void *a, const void *b) {
    const uint32_t x = *(const uint32_t *)a;
    const uint32_t y = *(const uint32_t *)b;
    return x < y ? -1 : (x > y ? 1 : 0);
}

/// Any two: no two bits change the check alike. Any odd number: each changes an odd number of its bits.
static void test_the_check_finds_any_three_bits_of_six_phases(void) {
    static uint32_t changes[32u * WORDS_OF_SIX_PHASES + BITS_OF_A_CHECK];
    find_changes(changes);
    qsort(changes, COUNT_OF(changes), sizeof changes[0], by_size);
    for (int n = 0; n < COUNT_OF(changes); n++) {
        uint32_t odd = 0u;
        for (uint32_t left = changes[n]; left > 0u; left >>= 1) {
            odd ^= left & 1u;
        }
        TEST_ASSERT_EQUAL_UINT32(1u, odd);
        TEST_ASSERT_TRUE(n == 0 || changes[n] > changes[n - 1]);
    }
}

/// Of a burst the first and the last bit have flipped, and any between.
static void test_the_check_finds_bursts_of_a_word(void) {
    uint32_t words[20] = {0u};
    const uint32_t check = check_of(words, COUNT_OF(words));
    random_t random = random_seed(3u);
    for (int n = 0; n < 50000; n++) {
        const uint32_t length = 1u + random_bits(&random) % 32u;
        const uint32_t ends = 1u | 1u << (length - 1u);
        const uint64_t burst = (random_bits(&random) >> (32u - length)) | ends;
        const uint32_t from = random_bits(&random) % (32u * 19u);
        const uint64_t moved = burst << from % 32u;
        words[from / 32u] = (uint32_t)moved;
        words[from / 32u + 1u] = (uint32_t)(moved >> 32);
        TEST_ASSERT_TRUE(check_of(words, COUNT_OF(words)) != check);
        words[from / 32u] = words[from / 32u + 1u] = 0u;
    }
}

static void test_after_a_trip_the_telemetry_keeps_what_the_drive_was_doing(void) {
    rig_t rig = fresh();
    rig.load_Nm = 1.0;
    run_up(&rig, 100.0, 8.0);
    rig_run(&rig, 1.0);
    const lode_telemetry_t before = rig_telemetry(&rig);
    rig.trip = true;
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_run(&rig, 0.1);
    const lode_telemetry_t after = rig_telemetry(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_FAULT, after.mode);
    TEST_ASSERT_TRUE(lode_abs(before.i_A.q) > 1.0f && lode_abs(before.u_V.q) > 10.0f);
    // Within what a period moves them.
    CHECK_NEAR(0.5, before.i_A.q, after.i_A.q);
    CHECK_NEAR(0.5, before.ref_A.q, after.ref_A.q);
    CHECK_NEAR(5.0, before.u_V.q, after.u_V.q);
    CHECK_CLOSE(0.01, before.omega_rad_s, after.omega_rad_s);
    CHECK_NEAR(0.5, before.load_torque_Nm, after.load_torque_Nm);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, after.duty.a); // but the legs stand idle
    TEST_ASSERT_TRUE(after.steps > before.steps + 400u);
    rig.trip = false;
    rig_command(&rig, clear);
    rig_step(&rig);
    const lode_telemetry_t cleared = rig_telemetry(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, cleared.mode);
    const float zeros[] = {cleared.i_A.d, cleared.i_A.q,       cleared.ref_A.d,
                           cleared.u_V.d, cleared.u_V.q,       cleared.ref_A.q,
                           cleared.lock,  cleared.omega_rad_s, cleared.load_torque_Nm};
    for (int n = 0; n < COUNT_OF(zeros); n++) {
        TEST_ASSERT_TRUE(zeros[n] == 0.0f);
    }
}

/// Runs with the converters of `stuck` (1 to 3, 4: all) at `held` until the gates go off: how long that took, and
/// the largest current.
static void run_stuck(rig_t *rig, int stuck, const lode_counts_t *held, double *time_s,
                      double *most_A) {
    *time_s = 0.0;
    *most_A = 0.0;
    while (rig->out.gates && *time_s < 0.2) {
        rig->stamp += 1000u;
        lode_counts_t counts = rig_counts(rig);
        for (int n = 0; n < 3; n++) {
            counts.i[n] = stuck == n + 1 || stuck == 4 ? held->i[n] : counts.i[n];
        }
        rig->out = lode_drive_step(&rig->drive, &counts);
        rig_move(rig);
        *most_A = fmax(*most_A, (double)lode_ab_length(ipmsm_current(&rig->motor)));
        *time_s += RIG_TS_s;
    }
}

/// From any instant of an electrical period, which takes 105 steps.
static void test_a_stuck_converter_trips_before_the_current_is_large(void) {
    rig_t running = fresh();
    running.load_Nm = 1.5;
    run_up(&running, 100.0, 8.0);
    rig_run(&running, 1.0);
    for (int instant = 0; instant < 105; instant += 3) {
        rig_run(&running, 3.0 * RIG_TS_s);
        const lode_counts_t held = rig_counts(&running);
        for (int stuck = 1; stuck <= 4; stuck++) {
            rig_t rig = running;
            double time_s;
            double most_A;
            run_stuck(&rig, stuck, &held, &time_s, &most_A);
            TEST_ASSERT_EQUAL_STRING(
                "LODE_CHECK_CURRENT_STUCK",
                lode_check_name((lode_check_t)rig_telemetry(&rig).fault.check));
            // One alone may take the reference down with it, for a while.
            CHECK_AT_MOST(stuck <= 3 ? 16.0e-3 : 5.0e-3, time_s);
            CHECK_AT_MOST(0.5 * 12.0, most_A);
        }
    }
}

/// Degrees by which a current of `i_A` that is asked for turns before a phase that rests at zero counts as stuck; the
/// other two move.
static double degrees_until_stuck(rig_t rig, double i_A, double omega) {
    const double look_deg = omega * LODE_GUARD_PERIODS * RIG_TS_s / CHECK_DEG;
    rig.drive.ref_A = (lode_dq_t){0.0f, (float)i_A};
    rig.drive.estimator.pll.omega_rad_s = (float)omega;
    lode_plausibility_reset(&rig.drive.plausibility);
    int looks = 0;
    while (rig.drive.mode == (uint_least8_t)LODE_MODE_RUN && looks * look_deg < 360.0) {
        const int32_t i[LODE_PHASES] = {0, 20000 + 100 * looks, -20000 - 100 * looks};
        lode_drive_suspect(&rig.drive, &rig.drive.plausibility, i, 1.0f);
        looks++;
    }
    return looks * look_deg;
}

/// Dead time and drops hold a phase at zero where its current asks for less voltage than they take: it may rest longer.
static void test_what_dead_time_and_drops_hold_is_not_stuck(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.dead_time_s = 2.0e-6f;
    config.inverter.v_drop_V = 0.8f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 100.0, 8.0);
    const double more_V = 200.0 * (double)tuning.inverter.dead_more_max;
    TEST_ASSERT_TRUE(more_V > 0.5);
    const double taken_V = 2.0e-6 * 5.0e3 * 200.0 + more_V + 2.0 * 0.8;
    const double omegas[] = {60.0, 120.0};
    for (int n = 0; n < COUNT_OF(omegas); n++) {
        const double i_A = taken_V / (9.8e-3 * omegas[n]);
        const double held = degrees_until_stuck(rig, 0.93 * i_A, omegas[n]);
        const double free = degrees_until_stuck(rig, 1.07 * i_A, omegas[n]);
        CHECK_NEAR(20.0, 90.0, held);
        CHECK_NEAR(20.0, 60.0, free);
        CHECK_AT_LEAST(20.0, held - free);
    }
}

/// Sums of the currents that are wrong in one look of `every`, after one that was wrong and `sound` that were not: looks
/// until it trips, at most 1000.
static uint32_t looks_of_wrong_sums(rig_t rig, uint32_t every, uint32_t sound) {
    uint32_t look = 0u;
    lode_plausibility_reset(&rig.drive.plausibility);
    while (rig.drive.mode == (uint_least8_t)LODE_MODE_RUN && look < 1000u) {
        const bool now = look == 0u || (look > sound && look % every == 0u);
        const int32_t wrong = now ? 2 * tuning.plausibility.i_sum : 0;
        const int32_t moves = (int32_t)(look % 2u);
        const int32_t i[LODE_PHASES] = {20000 + wrong + moves, -10000 - moves, -10000 + moves};
        lode_drive_suspect(&rig.drive, &rig.drive.plausibility, i, 1.0f);
        look++;
    }
    return look;
}

static void test_a_wrong_sum_of_the_currents_trips_where_it_persists(void) {
    const rig_t rig = running(100.0, 8.0);
    const uint32_t looks = rig.drive.tuning->guard.lock_looks;
    TEST_ASSERT_EQUAL_UINT32(looks, looks_of_wrong_sums(rig, 1u, 0u));
    TEST_ASSERT_EQUAL_UINT32(looks + 11u, looks_of_wrong_sums(rig, 1u, 10u));
    TEST_ASSERT_EQUAL_UINT32(1000u, looks_of_wrong_sums(rig, 2u, 0u));
    TEST_ASSERT_EQUAL_UINT32(1000u, looks_of_wrong_sums(rig, 3u, 0u));
}

/// Looks at currents of a start that stand still until they count as stuck, at most 40. The vector turns by `turn_rad` from
/// one to the next, its damping takes `back` of that from it. Before, currents that moved while the damping went through
/// `before_rad` of its range.
static int looks_until_stuck(rig_t rig, float turn_rad, float back, float before_rad) {
    lode_start_t *start = &rig.drive.state.start;
    int32_t i[LODE_PHASES] = {60000, -25000, -35000};
    start->omega_rad_s = turn_rad / (float)(LODE_GUARD_PERIODS * RIG_TS_s);
    rig.drive.ref_A = (lode_dq_t){4.0f, 0.0f};
    lode_plausibility_reset(&rig.drive.plausibility);
    start->give = 1.0f;
    start->swing_V = 0.0f;
    for (int n = 0; n < 8; n++) {
        start->swing_V += before_rad / 8.0f;
        i[0] += 100;
        i[1] -= n % 2 == 0 ? 0 : 30; // now and then one keeps its count
        i[2] = -i[0] - i[1];
        lode_drive_suspect(&rig.drive, &rig.drive.plausibility, i, 1.0f);
    }
    int looks = 0;
    while (rig.drive.mode == (uint_least8_t)LODE_MODE_START && looks < 40) {
        start->swing_V += looks > 0 ? back * turn_rad : 0.0f;
        lode_drive_suspect(&rig.drive, &rig.drive.plausibility, i, 1.0f);
        looks++;
    }
    return looks;
}

/// While its damping turns the vector of a start back as fast as it turns on, the currents rest.
static void test_currents_that_rest_by_the_damping_are_not_stuck(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(100.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.2));
    for (int n = 0; n < 10000 && rig.drive.state.start.stage != (uint_least8_t)LODE_START_TURN;
         n++) {
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_START);
    const float turn_rad = 0.01f;
    const int without = looks_until_stuck(rig, turn_rad, 0.0f, 0.0f);
    CHECK_AT_MOST(20, without);
    CHECK_AT_LEAST(4, without);
    TEST_ASSERT_EQUAL_INT(40, looks_until_stuck(rig, turn_rad, 1.0f, 0.0f));
    // What it did before they rested does not count.
    TEST_ASSERT_EQUAL_INT(without, looks_until_stuck(rig, turn_rad, 0.0f, 0.2f));
    TEST_ASSERT_EQUAL_INT(without, looks_until_stuck(rig, turn_rad, 0.0f, -0.2f));
}

/// Where the EMF takes the voltage the current need not follow: that none does is no converter's fault.
static void test_a_current_that_the_voltage_does_not_allow_is_not_missed(void) {
    const rig_t running_rig = running(100.0, 8.0);
    const double circle_V = (double)(tuning.current.circle * 200.0f);
    for (int above = 0; above <= 1; above++) {
        rig_t rig = running_rig;
        rig.drive.i_A = (lode_dq_t){0.0f, 0.0f};
        rig.drive.estimator.pll.omega_rad_s =
            (float)((above == 1 ? 0.82 : 0.78) * circle_V / 0.142);
        lode_plausibility_reset(&rig.drive.plausibility);
        for (int look = 0; look < 20; look++) {
            const int32_t none[LODE_PHASES] = {0, 0, 0};
            rig.drive.ref_A = (lode_dq_t){0.0f, 4.0f + 0.5f * (float)(look % 2)};
            lode_drive_suspect(&rig.drive, &rig.drive.plausibility, none, 1.0f);
        }
        TEST_ASSERT_EQUAL_STRING(above == 1 ? "LODE_CHECK_NONE" : "LODE_CHECK_CURRENT_STUCK",
                                 lode_check_name((lode_check_t)rig_telemetry(&rig).fault.check));
    }
}

/// Makes `check` trip a drive that runs; `counts` are those of the period.
static void provoke(lode_check_t check, rig_t *rig, lode_counts_t *counts) {
    lode_guard_tuning_t *guard = &other_tuning.guard;
    counts->trip = check == LODE_CHECK_HARDWARE_TRIP;
    counts->i[0] = check == LODE_CHECK_OVER_CURRENT ? 400u : counts->i[0];
    counts->i[0] = check == LODE_CHECK_CURRENT_RAIL ? 4095u : counts->i[0];
    counts->v_bus = check == LODE_CHECK_OVER_VOLTAGE ? 2600u : counts->v_bus;
    counts->v_bus = check == LODE_CHECK_UNDER_VOLTAGE ? 1100u : counts->v_bus;
    counts->temperature = check == LODE_CHECK_OVER_TEMPERATURE ? 2000u : 500u;
    counts->stamp += check == LODE_CHECK_TIMING ? 1000u : 0u;
    guard->omega_max = check == LODE_CHECK_OVER_SPEED ? 1.0f : guard->omega_max;
    rig->drive.direction = check == LODE_CHECK_WRONG_WAY ? -1.0f : rig->drive.direction;
    rig->drive.estimator.lock = check == LODE_CHECK_LOST_LOCK ? 0.2f : rig->drive.estimator.lock;
    other_tuning.inverter.inv_ticks =
        check == LODE_CHECK_NON_FINITE ? NAN : other_tuning.inverter.inv_ticks;
}

/// The row of the fault, in telemetry and in the channels of ring and scope, is that of a drive at work.
static void test_the_row_of_every_fault_keeps_the_values_of_its_step(void) {
    lode_drive_config_t config = rig_config();
    config.guard.stamp_per_period = 1000.0f;
    config.guard.i_trip_A = 20.0f;
    config.sense.temperature_gain_degC_count = 0.1f;
    config.inverter.pwm_ticks = 8400.0f;
    rig_t running;
    rig_init(&running, &tuning, &config);
    running.motor.theta = CALM_rad;
    running.load_Nm = 1.0;
    run_up(&running, 100.0, 8.0);
    rig_run(&running, 1.0);
    for (int check = LODE_CHECK_HARDWARE_TRIP; check <= LODE_CHECK_WRONG_WAY; check++) {
        rig_t rig = running;
        other_tuning = tuning;
        // Whatever the rail is called: the trip's own limit is beyond it.
        other_tuning.guard.i_trip = check == LODE_CHECK_CURRENT_RAIL ? 30.0f : tuning.guard.i_trip;
        rig.drive.tuning = &other_tuning;
        lode_telemetry_t before = rig_telemetry(&rig);
        for (int n = 0; n < 200 && rig.out.gates; n++) {
            rig.stamp += 1000u;
            lode_counts_t counts = rig_counts(&rig);
            provoke((lode_check_t)check, &rig, &counts);
            before = rig_telemetry(&rig);
            rig.out = lode_drive_step(&rig.drive, &counts);
            rig_move(&rig);
        }
        const lode_telemetry_t row = rig_telemetry(&rig);
        TEST_ASSERT_EQUAL_STRING(lode_check_name((lode_check_t)check),
                                 lode_check_name((lode_check_t)row.fault.check));
        const char *name = lode_check_name((lode_check_t)check);
        TEST_ASSERT_TRUE_MESSAGE(lode_abs(row.i_A.q) > 0.5f, name);
        TEST_ASSERT_TRUE_MESSAGE(lode_abs(row.ref_A.q) > 0.1f, name);
        TEST_ASSERT_TRUE_MESSAGE(lode_abs(row.u_V.q) > 10.0f, name);
        TEST_ASSERT_TRUE_MESSAGE(lode_abs(row.u_V.q - before.u_V.q) < 10.0f, name);
        TEST_ASSERT_TRUE_MESSAGE(row.v_bus_V > 100.0f && row.omega_rad_s > 200.0f, name);
        const lode_channel_t alpha = LODE_CHANNEL_I_ALPHA;
        const lode_channel_t beta = LODE_CHANNEL_I_BETA;
        const lode_ab_t i_A = {lode_channel_read(&rig.drive, alpha),
                               lode_channel_read(&rig.drive, beta)};
        TEST_ASSERT_TRUE_MESSAGE(lode_ab_length(i_A) > 0.5f, name);
    }
}

/// Steps in RUN with an estimate of the host's own until the gates go off; how many it took.
static int steps_until_off(rig_t *rig, float lock, float omega_share, int limit) {
    for (int n = 1; n <= limit; n++) {
        const lode_counts_t counts = rig_counts(rig);
        const lode_sample_t m = lode_drive_sense(&rig->drive, &counts);
        lode_estimate_t e = lode_drive_estimate(&rig->drive, &m);
        e.source = LODE_ESTIMATE_EXTERNAL;
        e.lock = lock;
        e.omega_rad_s *= omega_share;
        rig->out = lode_drive_act(&rig->drive, &m, &e);
        if (!rig->out.gates) {
            return n;
        }
        rig_move(rig);
    }
    return limit + 1;
}

static void test_lost_lock_and_wrong_way_trip_in_20_ms(void) {
    rig_t rig = running(100.0, 8.0);
    rig_run(&rig, 1.0);
    rig_t lost = rig;
    CHECK_AT_MOST(100, steps_until_off(&lost, 0.3f, 1.0f, 1000));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&lost).fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, rig_telemetry(&lost).fault.state);
    rig_t wrong = rig;
    CHECK_AT_MOST(100, steps_until_off(&wrong, 0.9f, -1.0f, 1000));
    rig_t fast = rig;
    CHECK_AT_MOST(100, steps_until_off(&fast, 0.9f, 10.0f, 1000));
    rig_t sound = rig;
    TEST_ASSERT_EQUAL_INT(1001, steps_until_off(&sound, 0.9f, 1.0f, 1000));
}

/// One that has just handed over, by a start that looks for no rotor that turns already.
static rig_t handed_over(void) {
    lode_drive_config_t config = rig_config();
    config.start.pulses = LODE_OFF;
    config.start.catch_s = LODE_NONE;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 80.0, 8.0);
    return rig;
}

/// Loses the lock, and with it the gates without a fault; the next attempt begins from rest.
static void lose_an_attempt(rig_t *rig, unsigned attempt) {
    const int looks = (int)(tuning.guard.lock_looks * LODE_GUARD_PERIODS);
    const int steps = steps_until_off(rig, 0.3f, 1.0f, 1000);
    CHECK_NEAR(2.0 * LODE_GUARD_PERIODS, 2.0 / 3.0 * looks, steps);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig_telemetry(rig).mode);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(rig).fault.check);
    TEST_ASSERT_TRUE(is_idle(rig->out));
    TEST_ASSERT_EQUAL_UINT(attempt, rig_telemetry(rig).retries);
    rig->motor.omega = 0.0;
    TEST_ASSERT_TRUE(reach(rig, LODE_MODE_START, 0.1));
    const lode_fault_t why =
        rig_telemetry(rig).fault; // of the attempt, while the next one is under way
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, why.state);
    check_why(&why, "LODE_START_NONE", "LODE_CRITERION_PROOF");
    TEST_ASSERT_EQUAL_FLOAT(LODE_LOCK_LOST, why.limit);
    TEST_ASSERT_EQUAL_UINT(attempt, rig_telemetry(rig).retries);
    TEST_ASSERT_EQUAL_UINT(attempt, rig->drive.state.start.failed);
}

/// (S28). Three attempts, the last one once more, then the fault.
static void test_a_lock_lost_right_after_the_hand_over_is_an_attempt(void) {
    rig_t rig = handed_over();
    TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
    for (unsigned attempt = 1u; attempt <= 3u; attempt++) {
        lose_an_attempt(&rig, attempt);
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
        TEST_ASSERT_EQUAL_UINT(attempt, rig_telemetry(&rig).retries);
    }
    rig_t steady_rig = rig;
    rig_run(&steady_rig, 1.0);
    TEST_ASSERT_EQUAL_UINT(3u, rig_telemetry(&steady_rig).retries); // of the last start
    (void)steps_until_off(&rig, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, rig_telemetry(&rig).fault.state);
}

/// (S28). What the attempts before have used up is gone; after a commanded OFF and in a reversal it is another start.
static void test_all_attempts_of_a_start_have_one_time(void) {
    rig_t rig = handed_over();
    const uint32_t first = rig.drive.start_rounds;
    CHECK_AT_LEAST(100.0, (double)first);
    lose_an_attempt(&rig, 1u);
    CHECK_AT_LEAST((double)first, (double)rig.drive.start_rounds);
    rig_t late = rig;
    late.drive.start_rounds = tuning.start.timeout_rounds - 100u;
    TEST_ASSERT_TRUE(reach(&late, LODE_MODE_FAULT, 0.5));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&late).fault.check);
    const lode_fault_t why = rig_telemetry(&late).fault;
    check_why(&why, "LODE_START_NONE", "LODE_CRITERION_PROOF");
    TEST_ASSERT_EQUAL_UINT(1u, rig_telemetry(&late).retries);
    rig_t again = rig;
    rig_command(&again, off);
    TEST_ASSERT_TRUE(reach(&again, LODE_MODE_OFF, 0.01));
    rig_command(&again, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&again, LODE_MODE_START, 0.2));
    TEST_ASSERT_EQUAL_UINT32(0u, again.drive.start_rounds);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    rig_run(&rig, 0.5);
    rig_command(&rig, run_at(-80.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 4.0));
    TEST_ASSERT_EQUAL_UINT32(0u, rig.drive.start_rounds);
}

/// To the last round.
static void test_a_start_is_proven_to_the_round(void) {
    rig_t rig = handed_over();
    rig.drive.guard.lock = (uint_least16_t)tuning.guard.lock_looks;
    rig.drive.losses = 1u;
    for (int left = 0; left <= 1; left++) {
        rig_t lost = rig;
        lost.drive.state.run.proving = (uint_least16_t)left;
        rig_t back = lost;
        lode_mode_prove_start(&lost.drive);
        TEST_ASSERT_EQUAL_INT(left == 1 ? LODE_MODE_OFF : LODE_MODE_RUN, lost.drive.mode);
        lode_mode_hand_back(&back.drive);
        TEST_ASSERT_EQUAL_UINT(left, back.drive.losses);
        TEST_ASSERT_EQUAL_UINT(left, back.drive.state.start.failed);
    }
}

/// Periods of a start with an estimate of this speed, of that of hand-over, and a vector of that, until its attempt ends; 0: it
/// does not.
static int periods_until_it_ends(rig_t *rig, float omega, float vector, float lock) {
    const float ready = tuning.start.omega_ready;
    for (int n = 1; n <= 4000; n++) {
        rig->drive.estimator.pll.omega_rad_s = omega * ready;
        rig->drive.estimator.lock = lock;
        rig->drive.state.start.omega_rad_s = vector * ready;
        rig->drive.state.start.locked = 0u;
        rig_step(rig);
        if (rig->drive.mode != (uint_least8_t)LODE_MODE_START) {
            return n;
        }
    }
    return 0;
}

/// A start towards a positive speed, its vector on its way, after so many attempts that failed.
static rig_t on_its_way(const lode_drive_config_t *config, uint_least8_t failed) {
    rig_t rig;
    rig_init(&rig, &tuning, config);
    rig.motor.theta = CALM_rad;
    rig_command(&rig, run_at(80.0));
    for (int n = 0; n < 20000 && !(rig.drive.mode == (uint_least8_t)LODE_MODE_START &&
                                   rig.drive.state.start.omega_rad_s > 1.0f);
         n++) {
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_START);
    rig.drive.state.start.failed = failed;
    return rig;
}

/// (S36). Where the estimate is sure, and the rotor turns against a vector that does not turn its way, or much faster.
static void test_a_rotor_that_the_load_turns_ends_the_attempt(void) {
    const struct {
        float omega, vector, lock;
        bool ends;
        float most; // speed with which it would not have ended
    } table[] = {
        {-1.3f, 0.0f, 0.9f, true, 0.0f},   {-1.3f, 0.5f, 0.9f, true, 0.0f},
        {-1.3f, -0.1f, 0.9f, false, 0.0f}, {-0.7f, 0.5f, 0.9f, false, 0.0f},
        {-1.3f, 0.5f, 0.5f, false, 0.0f},  {2.3f, 0.5f, 0.9f, true, 2.0f},
        {1.7f, 0.5f, 0.9f, false, 0.0f},   {3.3f, 1.5f, 0.9f, true, 3.0f},
        {2.7f, 1.5f, 0.9f, false, 0.0f},   {-2.3f, -0.5f, 0.9f, true, 0.0f},
        {-1.7f, -0.5f, 0.9f, false, 0.0f}, // given back, and not held
    };
    const lode_drive_config_t config = rig_config();
    for (int n = 0; n < COUNT_OF(table); n++) {
        rig_t rig = on_its_way(&config, 1u);
        const int rounds = (int)tuning.start.lock_rounds;
        const int periods =
            periods_until_it_ends(&rig, table[n].omega, table[n].vector, table[n].lock);
        if (table[n].ends) {
            CHECK_NEAR(3.5, 8.0 * rounds - 3.5,
                       periods); // the last round, wherever the first began
            rig_expect(&rig, LODE_MODE_OFF);
            TEST_ASSERT_EQUAL_UINT(2u, rig.drive.losses);
            const lode_fault_t why = rig_telemetry(&rig).fault;
            const double ready = (double)tuning.start.omega_ready;
            TEST_ASSERT_EQUAL_STRING("LODE_CRITERION_SPEED",
                                     lode_criterion_name((lode_criterion_t)why.criterion));
            CHECK_NEAR(0.2 * ready, (double)table[n].omega * ready, why.measured);
            CHECK_NEAR(0.02 * ready, (double)table[n].most * ready, why.limit);
        } else {
            TEST_ASSERT_EQUAL_INT(0, periods);
        }
    }
}

/// A stop is no attempt.
static void test_a_rotor_that_the_load_turns_does_not_end_a_stop(void) {
    const lode_drive_config_t config = rig_config();
    rig_t rig = on_its_way(&config, 1u);
    rig_command(&rig, run_at(0.0));
    TEST_ASSERT_EQUAL_INT(0, periods_until_it_ends(&rig, -2.3f, 0.5f, 0.9f));
}

/// After the last attempt, and where nobody looks for a rotor that turns, it is a fault.
static void test_a_rotor_that_the_load_turns_on_and_on_is_a_fault(void) {
    for (int catches = 0; catches <= 1; catches++) {
        lode_drive_config_t config = rig_config();
        config.start.catch_s = catches == 1 ? config.start.catch_s : LODE_NONE;
        rig_t rig = on_its_way(&config, catches == 1 ? 3u : 0u);
        CHECK_AT_LEAST(1, periods_until_it_ends(&rig, -2.0f, 0.5f, 0.9f));
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_WRONG_WAY", lode_check_name(fault.check));
        CHECK_CLOSE(0.2, -2.0 * (double)tuning.start.omega_ready, fault.measured);
        CHECK_NEAR(0.0, 0.0, fault.limit);
    }
}

/// A hoist whose brake is open from the beginning: nothing holds its load while the offsets are calibrated.
static void test_a_hoist_with_an_open_brake_is_caught_and_started(void) {
    for (int pull = -4; pull <= 4; pull++) {
        rig_t rig = fresh();
        rig.pull_Nm = (double)pull;
        rig_command(&rig, run_at(60.0));
        rig_run(&rig, 12.0);
        rig_expect(&rig, LODE_MODE_RUN);
        CHECK_NEAR(1.0, 60.0, rig.motor.omega / 3.0);
    }
}

/// A start is proven by a rotor that turns as it is asked to: one that is caught as it turns the other way is still of the same
/// start when it is given back.
static void test_a_rotor_that_turns_the_other_way_has_not_started(void) {
    for (int n = 0; n < 6; n++) {
        const int way = n % 3 - 1; // 0: by so little that it is hardly any
        lode_drive_config_t config = rig_config();
        config.start.pulses = n < 3 ? LODE_AUTO : LODE_OFF; // else it is caught with currents
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        TEST_ASSERT_EQUAL_UINT(n < 3 ? 6u : 0u, tuning.signal_check.pulses); // after those alone
        const double patience = tuning.start.patience_rounds;
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
        rig_run(&rig, 0.15);
        rig.motor.omega = 200.0;
        rig_command(&rig, run_at(way == 0 ? 0.001 : 60.0 * way));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.1));
        rig.drive.losses = 1u;
        CHECK_NEAR(way < 0 ? 1.0 : patience, way < 0 ? 65535.0 : 0.0, rig.drive.state.run.proving);
        rig_run(&rig, 0.5);
        if (way < 0) {
            TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 4.0));
            TEST_ASSERT_EQUAL_UINT(1u, rig.drive.state.start.failed);
        }
    }
}

/// A stop that comes while a rotor is caught is no speed the other way.
static void test_a_rotor_that_is_caught_for_a_stop_has_patience(void) {
    lode_drive_config_t config = rig_config();
    config.start.pulses = LODE_OFF;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    rig_run(&rig, 0.15);
    rig.motor.omega = -200.0;
    rig_command(&rig, run_at(60.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.1));
    rig_command(&rig, run_at(0.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 0.1));
    TEST_ASSERT_EQUAL_UINT(tuning.start.patience_rounds, rig.drive.state.run.proving);
}

/// The last attempt, repeated, has a ramp of a quarter again.
static void test_the_last_attempt_is_repeated_faster(void) {
    rig_t rig = handed_over();
    const float ease[] = {0.25f, 0.0625f, 0.25f};
    for (unsigned attempt = 1u; attempt <= 3u; attempt++) {
        lose_an_attempt(&rig, attempt);
        TEST_ASSERT_EQUAL_FLOAT(ease[attempt - 1u], lode_start_ease(&rig.drive.state.start));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    }
}

static void test_a_start_that_is_over_is_no_attempt(void) {
    const rig_t rig = handed_over();
    rig_t early = rig;
    rig_run(&early, 0.37);
    (void)steps_until_off(&early, 0.3f, 1.0f, 1000);

    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig_telemetry(&early).mode);
    rig_t late = rig;
    rig_run(&late, 0.4);
    (void)steps_until_off(&late, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&late).fault.check);
    rig_t fast = rig; // any other fault is one
    (void)steps_until_off(&fast, 0.9f, 10.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_FAULT, rig_telemetry(&fast).mode);
}

static void test_a_commanded_off_forgets_the_attempts(void) {
    rig_t rig = handed_over();
    lose_an_attempt(&rig, 1u);
    rig_command(&rig, off);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.01));
    TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
    rig_command(&rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.2));
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.state.start.failed);
    TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&rig).retries);
    TEST_ASSERT_EQUAL_INT(LODE_CRITERION_NONE, rig_telemetry(&rig).fault.criterion);
}

/// An attempt that fails in START counts as one that fails after it, and a reversal is another start. Where the last
/// one, repeated, does not come up, that is the end.
static void test_attempts_that_fail_in_the_start_count(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 0.2));
    rig.drive.state.start.failed = 2u;
    TEST_ASSERT_EQUAL_UINT(2u, rig_telemetry(&rig).retries);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    TEST_ASSERT_EQUAL_UINT(2u, rig_telemetry(&rig).retries);
    rig_t reversed = rig;
    lose_an_attempt(&rig, 3u);
    rig_t stuck = rig;
    stuck.blocked = true;
    TEST_ASSERT_TRUE(reach(&stuck, LODE_MODE_FAULT, 30.0));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&stuck).fault.check);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    (void)steps_until_off(&rig, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&rig).fault.check);
    rig_run(&reversed, 0.5);
    rig_command(&reversed, run_at(-80.0));
    TEST_ASSERT_TRUE(reach(&reversed, LODE_MODE_START, 4.0));
    TEST_ASSERT_TRUE(reach(&reversed, LODE_MODE_RUN, 4.0));
    TEST_ASSERT_EQUAL_UINT(0u, rig_telemetry(&reversed).retries);
}

/// Given back to the vector before the start is over it is the same start; after, another one.
static void test_a_way_back_before_the_start_is_over_is_of_the_same_start(void) {
    rig_t rig = handed_over();
    lose_an_attempt(&rig, 1u);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 20.0));
    for (int late = 0; late <= 1; late++) {
        rig_t back = rig;
        rig_run(&back, late == 1 ? 0.41 : 0.0);
        rig_expect(&back, LODE_MODE_RUN);
        lode_mode_hand_back(&back.drive);
        TEST_ASSERT_EQUAL_UINT(late == 1 ? 0u : 1u, rig_telemetry(&back).retries);
        TEST_ASSERT_EQUAL_UINT(late == 1 ? 0u : 1u, back.drive.state.start.failed);
    }
}

/// A rotor that pulses have found may be lost as soon.
static void test_a_lock_lost_right_after_the_pulses_is_an_attempt(void) {
    rig_t rig = coasting(80.0);
    run_up(&rig, 80.0, 0.2);
    TEST_ASSERT_TRUE(rig.drive.steps < 3000u); // no start by a vector is so quick
    rig_t late = rig;
    (void)steps_until_off(&rig, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, rig_telemetry(&rig).mode);
    TEST_ASSERT_EQUAL_UINT(1u, rig_telemetry(&rig).retries);
    rig_run(&late, 0.41);
    (void)steps_until_off(&late, 0.3f, 1.0f, 1000);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&late).fault.check);
}

/// Magnets that have lost `share` of their flux: the fault, within 100 ms.
static lode_fault_t with_less_flux(rig_t rig, double share) {
    rig.motor.psi *= 1.0 - share;
    rig_run(&rig, 0.1);
    return rig_telemetry(&rig).fault;
}

static void test_another_flux_is_named(void) {
    rig_t rig = fresh();
    rig.load_Nm = 0.5;
    run_up(&rig, 100.0, 8.0);
    rig_run(&rig, 1.0);
    const lode_fault_t weak = with_less_flux(rig, 0.35);
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_FLUX", lode_check_name(weak.check));
    CHECK_CLOSE(0.05, 0.65 * rig.motor.psi, weak.measured);
    CHECK_CLOSE(0.05, rig.motor.psi, weak.limit);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_less_flux(rig, 0.1).check);
    // Nearly none is no motor's, and a rotor that is stopped has none.
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, with_less_flux(rig, 0.8).check);
    rig.blocked = true;
    rig.motor.omega = 0.0;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, with_less_flux(rig, 0.0).check);
}

/// Loses the lock while the observer's EMF has `size` times what the speed induces. For the first `aside` looks it stands
/// 45 degrees beside the rotor's q axis, then along it. The check that trips.
static lode_check_t by_emf_aside(rig_t rig, uint32_t aside, float size) {
    lode_estimator_t *estimator = &rig.drive.estimator;
    uint32_t look = 0u;
    while (rig.drive.mode == (uint_least8_t)LODE_MODE_RUN && look < 1000u) {
        const float taken = 1.0f + estimator->pll.omega_rad_s * estimator->pll.omega_rad_s *
                                       tuning.estimator.droop_s2;
        const float e_V = size * (float)rig.motor.psi * estimator->pll.omega_rad_s / taken;
        const float off_rad = look < aside ? 0.7854f : 0.0f;
        const lode_dq_t at = {-e_V * sinf(off_rad), e_V * cosf(off_rad)};
        estimator->emf.observer.e_V = lode_park_inverse(at, estimator->pll.frame);
        estimator->lock = 0.0f;
        estimator->id_A = 0.0f;
        lode_drive_check_slow(&rig.drive);
        look++;
    }
    return (lode_check_t)rig_telemetry(&rig).fault.check;
}

/// Lost lock is that of another flux where the EMF was along the rotor at every look, and off by a fifth at least.
static void test_another_flux_is_one_at_every_look(void) {
    rig_t rig = running(100.0, 8.0);
    rig_run(&rig, 0.5); // the start is over
    const uint32_t looks = rig.drive.tuning->guard.lock_looks;
    TEST_ASSERT_TRUE(looks > 6u);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_emf_aside(rig, 0u, 1.5f));
    for (uint32_t aside = 1u; aside <= 4u; aside++) {
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, by_emf_aside(rig, aside, 1.5f));
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, by_emf_aside(rig, looks, 1.5f));
    const float sizes[] = {0.45f, 0.55f, 0.77f, 0.83f, 1.17f, 1.23f};
    const bool other[] = {false, true, true, false, false, true};
    for (int n = 0; n < COUNT_OF(sizes); n++) {
        TEST_ASSERT_EQUAL_INT(other[n] ? LODE_CHECK_FLUX : LODE_CHECK_LOST_LOCK,
                              by_emf_aside(rig, 0u, sizes[n]));
    }
}

/// What the observer's lag takes from the EMF, a fifth of it here, is no flux that is missing.
static void test_the_observers_lag_is_no_other_flux(void) {
    lode_drive_config_t config = rig_config();
    config.estimator.emf.w0_rad_s = 670.0f;
    config.estimator.omega_max_rad_s = 450.0f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 100.0, 8.0);
    rig_run(&rig, 1.0);
    CHECK_CLOSE(0.01, 1.2, 1.0f + 300.0f * 300.0f * tuning.estimator.droop_s2);
    rig.motor.psi *= 0.65;
    rig_run(&rig, 0.1);
    const lode_fault_t weak = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_FLUX", lode_check_name(weak.check));
    CHECK_CLOSE(0.05, rig.motor.psi, weak.measured);
}

/// A start of a motor with `times` the configured resistance.
static lode_fault_t with_resistance(double times, double theta_rad) {
    rig_t rig = fresh();
    rig.motor.R *= times;
    rig.motor.theta = theta_rad;
    rig_command(&rig, run_at(100.0));
    rig_run(&rig, 2.0);
    return rig_telemetry(&rig).fault;
}

/// Where the rotor came to rest in time: in a third of its positions at least. With one current alone some of it counts as
/// dead time's.
static void test_a_resistance_of_no_winding_ends_the_start(void) {
    int ended = 0;
    for (int k = 0; k < 12; k++) {
        const double theta_rad = (double)k * CHECK_PI / 6.0;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_resistance(1.6, theta_rad).check);
        const lode_fault_t wrong = with_resistance(2.6, theta_rad);
        if (wrong.check != LODE_CHECK_NONE) {
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_RESISTANCE", lode_check_name(wrong.check));
            TEST_ASSERT_EQUAL_INT(LODE_MODE_START, wrong.state);
            CHECK_AT_LEAST(1.2 * 0.75, (double)wrong.measured);
            CHECK_AT_MOST(1.1 * 1.6 * 0.75, (double)wrong.measured);
            CHECK_CLOSE(0.01, 1.2 * 0.75, wrong.limit);
            ended++;
        }
    }
    CHECK_AT_LEAST(4.0, (double)ended);
}

/// A start of which nothing is measured at rest, with sensors that show `gain` of the currents.
static lode_fault_t with_gains(double gain, lode_choice_t plausibility) {
    lode_drive_config_t config = rig_config();
    config.start.signal_check = LODE_OFF; // which finds it before
    config.start.measure = LODE_OFF;
    config.guard.plausibility = plausibility;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(100.0));
    for (int n = 0; n < 7500 && rig_telemetry(&rig).mode != LODE_MODE_FAULT; n++) {
        lode_counts_t counts = rig_counts(&rig);
        for (int k = 0; k < LODE_PHASES; k++) {
            counts.i[k] = rig_count(2048.0 + gain * ((double)counts.i[k] - 2048.0));
        }
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    return rig_telemetry(&rig).fault;
}

/// (S34)
static void test_more_current_than_is_measured_ends_the_start(void) {
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_gains(1.0, LODE_ON).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_gains(0.8, LODE_ON).check);
    const lode_fault_t wrong = with_gains(0.4, LODE_ON);
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_FLUX", lode_check_name(wrong.check));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_START, wrong.state);
    CHECK_AT_LEAST((double)wrong.limit, (double)wrong.measured);
    TEST_ASSERT_NOT_EQUAL(LODE_CHECK_FLUX, with_gains(0.4, LODE_OFF).check);
}

/// How many rounds the vector of a start turns on with the observer's EMF at `times` of what the motor's own flux induces,
/// `off_rad` beside the rotor's q axis, at `share` of the vector's speed, with a d current that leaves `left` of the
/// flux. The check that ended it, or none after 1000.
typedef struct {
    uint32_t rounds;
    lode_check_t check;
} rounds_t;

static rounds_t by_flux(rig_t rig, float times, float off_rad, float share, float left) {
    lode_drive_t *drive = &rig.drive;
    lode_estimator_t *estimator = &drive->estimator;
    const lode_estimator_tuning_t *own = &drive->tuning->estimator;
    const float lock = estimator->lock;
    rounds_t seen = {0u, LODE_CHECK_NONE};
    drive->state.start.omega_rad_s = drive->tuning->start.omega_handover;
    const float omega = share * drive->tuning->start.omega_handover;
    while (drive->mode == (uint_least8_t)LODE_MODE_START && seen.rounds < 1000u) {
        const float e_V = times * own->psi_Wb * omega / (1.0f + omega * omega * own->droop_s2);
        const lode_dq_t at = {-e_V * sinf(off_rad), e_V * cosf(off_rad)};
        estimator->emf.observer.e_V = lode_park_inverse(at, estimator->pll.frame);
        estimator->pll.omega_rad_s = omega;
        estimator->id_A = (left - 1.0f) * own->psi_Wb / own->salient_H;
        estimator->lock = lock;
        drive->steps = (uint32_t)SLOT_LAG;
        lode_mode_follow(drive);
        seen.rounds++;
    }
    seen.check = (lode_check_t)rig_telemetry(&rig).fault.check;
    return seen;
}

/// (S34): twice the active flux, of which 0.6 of the magnets' is expected at least, for as long as a lock would have to
/// hold, and of a rotor that follows.
static void test_a_flux_of_no_motor_is_one_for_as_long_as_a_lock(void) {
    rig_t rig = fresh();
    rig_command(&rig, run_at(100.0));
    while (rig.drive.mode != (uint_least8_t)LODE_MODE_START ||
           rig.drive.state.start.stage != (uint_least8_t)LODE_START_TURN) {
        rig_step(&rig);
    }
    const float whole = 1.0f;
    rig.drive.estimator.lock = 0.99f * LODE_LOCK_LOST;
    const rounds_t wrong = by_flux(rig, 2.02f, 0.0f, 1.0f, whole);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, wrong.check);
    TEST_ASSERT_EQUAL_UINT32(tuning.start.lock_rounds, wrong.rounds);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 1.98f, 0.0f, 1.0f, whole).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_flux(rig, 1.42f, 0.0f, 1.0f, 0.7f).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 1.38f, 0.0f, 1.0f, 0.7f).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_flux(rig, 1.22f, 0.0f, 1.0f, 0.2f).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 1.18f, 0.0f, 1.0f, 0.2f).check);
    rig_t locked = rig; // by the next round its lock may have gone
    locked.drive.estimator.lock = LODE_LOCK_LOST;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(locked, 2.2f, 0.0f, 1.0f, whole).check);
    // 25 degrees beside, and a quarter of the speed.
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_flux(rig, 2.2f, 0.44f, 1.0f, whole).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 2.2f, 0.46f, 1.0f, whole).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, by_flux(rig, 2.2f, 0.0f, 1.24f, whole).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, by_flux(rig, 2.2f, 0.0f, 1.26f, whole).check);
    // It begins anew.
    rig.drive.guard.lock = (uint_least16_t)(tuning.start.lock_rounds - 1u);
    (void)by_flux(rig, 1.0f, 0.0f, 1.0f, whole);
    TEST_ASSERT_EQUAL_UINT32(1u, by_flux(rig, 2.2f, 0.0f, 1.0f, whole).rounds);
    lode_drive_t *drive = &rig.drive;
    drive->state.start.omega_rad_s = 0.9f * tuning.start.omega_ready;
    drive->steps = (uint32_t)SLOT_LAG;
    lode_mode_follow(drive);
    TEST_ASSERT_EQUAL_UINT32(0u, drive->guard.lock);
}

/// With the winding that is configured, one 30 % warmer and one colder, from 12 rest positions: at least one start in three
/// lets the rotor come to rest in time, and what is measured then is 0.1 of it off, root of the mean square (S30).
static void test_a_resistance_that_is_measured_is_right(void) {
    const double times[] = {0.7, 1.0, 1.3};
    double square = 0.0;
    int measured = 0;
    for (int n = 0; n < 3 * 12; n++) {
        rig_t rig = fresh();
        const double R = rig.motor.R;
        rig.motor.R = times[n / 12] * R;
        rig.motor.theta = (double)(n % 12) * CHECK_PI / 6.0;
        run_up(&rig, 80.0, 8.0);
        const double more = (double)rig.drive.inverter.r_more_Ohm / R;
        if (fabs(more) > 0.0) {
            const double error = more - (times[n / 12] - 1.0);
            square += error * error;
            measured++;
        }
    }
    CHECK_AT_LEAST(12.0, (double)measured);
    CHECK_AT_MOST(0.1, sqrt(square / (double)measured));
}

/// A start in which one phase has no positive current, as with a dead high switch.
static lode_fault_t with_a_dead_switch(int phase, uint32_t noise) {
    lode_drive_config_t config = rig_config();
    config.guard.i_sum_A =
        LODE_NONE; // only the counts are changed here: of a real one the sum is zero
    config.start.signal_check = LODE_OFF; // which finds it before
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(100.0));
    for (int n = 0; n < 10000 && rig_telemetry(&rig).mode != LODE_MODE_RUN; n++) {
        lode_counts_t counts = rig_counts(&rig);
        if (phase >= 0 && counts.i[phase] > 2048u) {
            noise = noise * 1664525u + 1013904223u;
            counts.i[phase] = (uint16_t)(2048u + (noise >> 30)); // 1.1 counts rms
        }
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    return rig_telemetry(&rig).fault;
}

/// In RUN one phase shows nothing of its current, as if it were open, and the others share what it lacks. Until the drive
/// trips, or for half a second. The load takes a third of i_max.
static lode_fault_t with_an_open_phase(int phase, double after_s, lode_choice_t plausibility,
                                       double *took_s) {
    lode_drive_config_t config = rig_config();
    config.guard.i_sum_A = LODE_NONE; // of a real one the sum is zero
    config.guard.plausibility = plausibility;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.load_Nm = 2.0;
    rig_command(&rig, run_at(150.0));
    rig_run(&rig, after_s);
    rig_expect(&rig, LODE_MODE_RUN);
    *took_s = 0.0;
    while (*took_s < 0.5 && rig_telemetry(&rig).mode == LODE_MODE_RUN) {
        lode_counts_t counts = rig_counts(&rig);
        if (phase >= 0) {
            const uint16_t lacks = counts.i[phase];
            counts.i[phase] = (uint16_t)(2047 + (int)(*took_s / RIG_TS_s) % 3);
            counts.i[(phase + 1) % 3] = (uint16_t)(counts.i[(phase + 1) % 3] + (lacks - 2048) / 2);
            counts.i[(phase + 2) % 3] = (uint16_t)(counts.i[(phase + 2) % 3] + (lacks - 2048) / 2);
        }
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
        *took_s += RIG_TS_s;
    }
    return rig_telemetry(&rig).fault;
}

/// A turn takes 14 ms.
static void test_a_phase_that_opens_in_run_is_found(void) {
    double took_s;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_an_open_phase(-1, 4.0, LODE_ON, &took_s).check);
    for (int n = 0; n < 12; n++) {
        const int phase = n % LODE_PHASES;
        const double after_s = 4.0 + 1.2e-3 * n;
        const lode_fault_t fault = with_an_open_phase(phase, after_s, LODE_ON, &took_s);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE", lode_check_name(fault.check));
        TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, fault.state);
        CHECK_NEAR(0.0, phase + 1, fault.measured);
        CHECK_AT_MOST(0.05, took_s);
        TEST_ASSERT_NOT_EQUAL(LODE_CHECK_OPEN_PHASE,
                              with_an_open_phase(phase, after_s, LODE_OFF, &took_s).check);
    }
}

/// What a start or an earlier run has left of the counts is not RUN's.
static void test_the_hand_over_begins_the_counts_of_run(void) {
    rig_t rig = fresh();
    static const lode_half_waves_t lacking = {.lacks = {0u, 9000u}, .idle = 7u, .doubts = true};
    static const lode_half_waves_t none_lacking = {.idle = 0u};
    rig_command(&rig, run_at(100.0));
    for (int n = 0; n < 20000 && rig.drive.mode != (uint_least8_t)LODE_MODE_RUN; n++) {
        rig.drive.guard.lock = 7u;
        rig.drive.guard.speed = 1u;
        rig.drive.guard.flux_rounds = 1u;
        if (offsetof(lode_running_t, waves) >= sizeof(lode_start_t)) { // beyond the start's state
            rig.drive.state.run.waves = lacking;
        }
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_RUN);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.lock);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.speed);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.flux_rounds);
    TEST_ASSERT_EQUAL_FLOAT(rig.drive.estimator.pll.omega_rad_s, rig.drive.state.run.held_rad_s);
    lode_half_waves_t waves = rig.drive.state.run.waves;
    waves.asked_A = (lode_dq_t){0.0f, 0.0f}; // which the next look goes by
    TEST_ASSERT_EQUAL_MEMORY(&none_lacking, &waves, sizeof none_lacking);
}

static void test_half_waves_are_looked_at_with_and_without_field_weakening(void) {
    for (int k = 0; k < 2; k++) {
        lode_drive_config_t config = rig_config();
        config.references.field_weakening = k == 0 ? LODE_OFF : LODE_ON;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        run_up(&rig, 100.0, 8.0);
        rig_run(&rig, 0.5);
        for (int n = 0; n < 1000 && rig.drive.mode == (uint_least8_t)LODE_MODE_RUN; n++) {
            // Enough is lacking of the positive half-wave of phase 2, unless it is there now.
            rig.drive.state.run.waves = (lode_half_waves_t){.lacks = {0u, 16384u}, .doubts = true};
            rig_step(&rig);
        }
        const lode_fault_t fault = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE", lode_check_name(fault.check));
        CHECK_NEAR(0.0, 2.0, fault.measured);
        TEST_ASSERT_EQUAL_INT(LODE_GATES_OFF, rig.out.gates);
    }
}

/// One look at half-waves, of half of i_max, with the frame at `angle_rad`. Phase 2 has no positive one.
static void look_without_a_half_wave(lode_drive_t *drive, double angle_rad) {
    const float i_A = 0.5f * rig_config().inverter.i_max_A;
    drive->ref_A = (lode_dq_t){-0.6f * i_A, 0.8f * i_A};
    drive->estimator.pll.frame =
        (lode_sincos_t){.sin = (float)sin(angle_rad), .cos = (float)cos(angle_rad)};
    const lode_sincos_t rotor = lode_estimator_rotor(&drive->estimator);
    lode_ab_t current_A = lode_park_inverse(drive->ref_A, rotor);
    const lode_ab_t axis = {-0.5f, 0.8660254f};
    const float lost_A = fmaxf(axis.alpha * current_A.alpha + axis.beta * current_A.beta, 0.0f);
    current_A.alpha -= lost_A * axis.alpha;
    current_A.beta -= lost_A * axis.beta;
    drive->estimator.emf.i_A = current_A;
    drive->i_A = lode_park(current_A, rotor);
    // The voltage that current control adds for it makes no current: the observer takes it for EMF.
    drive->estimator.emf.observer.e_V = (lode_ab_t){0.0f, 0.0f};
    const lode_ab_t magnets_V = lode_estimator_beyond_V(&drive->estimator, &tuning.estimator);
    const float added_V = drive->current.kp_q_V_A * lost_A;
    drive->estimator.emf.observer.e_V =
        (lode_ab_t){added_V * axis.alpha - magnets_V.alpha, added_V * axis.beta - magnets_V.beta};
    const bool on = lode_drive_watch_half_waves(drive);
    TEST_ASSERT_EQUAL(drive->gates, on);
}

/// Turns of a rotor at `omega` until the half-wave is found, from `from_rad` on; 4: it is not.
static double turns_until_found(rig_t rig, float omega, double from_rad) {
    lode_drive_t *drive = &rig.drive;
    const double look_rad = 8.0 * RIG_TS_s * (double)omega;
    double turned_rad = 0.0;
    drive->estimator.pll.omega_rad_s = omega;
    drive->estimator.lag.omega_rad_s = omega;
    while (drive->mode == (uint_least8_t)LODE_MODE_RUN && fabs(turned_rad) < 8.0 * CHECK_PI) {
        turned_rad += look_rad;
        look_without_a_half_wave(drive, from_rad + turned_rad);
    }
    if (drive->mode == (uint_least8_t)LODE_MODE_RUN) {
        return 4.0;
    }
    const lode_fault_t fault = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE", lode_check_name(fault.check));
    CHECK_NEAR(0.0, 2.0, fault.measured);
    CHECK_NEAR(0.0, 0.0, fault.limit);
    return fabs(turned_rad) / (2.0 * CHECK_PI);
}

static rig_t running_with_voltage(void) {
    rig_t rig = running(100.0, 8.0);
    rig.drive.state.run.fade = 0.0f;
    rig.drive.state.run.waves = (lode_half_waves_t){.idle = 0u};
    rig.drive.u_V = (lode_dq_t){0.0f, 0.0f};
    return rig;
}

static void test_a_half_wave_is_found_within_1_2_turns_either_way(void) {
    const rig_t rig = running_with_voltage();
    const float ready = tuning.start.omega_ready;
    for (int n = 0; n < 24; n++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const float way = (float)sign;
            CHECK_AT_MOST(1.2, turns_until_found(rig, way * ready, (double)n));
            CHECK_AT_MOST(1.2, turns_until_found(rig, 3.0f * way * ready, (double)n));
        }
    }
}

/// What is known of the turn is too little below the speed at which the estimator may take over, of a sensor's angle, and
/// while the start's current fades; without voltage left current control is behind for that.
static void test_turns_that_tell_of_no_half_wave(void) {
    const float ready = tuning.start.omega_ready;
    const double none = 4.0;
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = running_with_voltage();
        const float omega = 2.0f * ready * (float)sign;
        CHECK_AT_MOST(1.2, turns_until_found(rig, omega, 0.0));
        CHECK_NEAR(0.0, none, turns_until_found(rig, 0.499f * omega, 0.0));
        rig.drive.sensored = 2u;
        CHECK_NEAR(0.0, none, turns_until_found(rig, omega, 0.0));
        rig.drive.sensored = 0u;
        rig.drive.state.run.fade = 0.01f;
        CHECK_NEAR(0.0, none, turns_until_found(rig, omega, 0.0));
        rig.drive.state.run.fade = 0.0f;
        const float circle_V = tuning.current.circle * rig.drive.inverter.v_bus_V;
        rig.drive.u_V = (lode_dq_t){-0.6f * 0.995f * circle_V, 0.8f * 0.995f * circle_V};
        CHECK_NEAR(0.0, none, turns_until_found(rig, omega, 0.0));
        rig.drive.u_V = (lode_dq_t){-0.6f * 0.985f * circle_V, 0.8f * 0.985f * circle_V};
        CHECK_AT_MOST(1.2, turns_until_found(rig, omega, 0.0));
    }
}

/// What was lacking before is forgotten where nothing can be told.
static void test_a_turn_that_tells_nothing_forgets(void) {
    static const lode_half_waves_t none_lacking = {.idle = 0u};
    rig_t rig = running_with_voltage();
    rig.drive.state.run.waves = (lode_half_waves_t){.lacks = {0u, 9000u}, .doubts = true};
    rig.drive.estimator.pll.omega_rad_s = 0.5f * tuning.start.omega_ready;
    TEST_ASSERT_TRUE(lode_drive_watch_half_waves(&rig.drive));
    lode_half_waves_t waves = rig.drive.state.run.waves;
    waves.asked_A = (lode_dq_t){0.0f, 0.0f}; // which the next look goes by
    TEST_ASSERT_EQUAL_MEMORY(&none_lacking, &waves, sizeof none_lacking);
}

static void test_a_dead_switch_ends_the_start(void) {
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_a_dead_switch(-1, 0u).check);
    for (int n = 0; n < 4 * LODE_PHASES; n++) {
        const int phase = n % LODE_PHASES;
        const lode_fault_t dead = with_a_dead_switch(phase, (uint32_t)n);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE", lode_check_name(dead.check));
        TEST_ASSERT_TRUE(dead.measured == (float)(phase + 1));
        CHECK_NEAR(0.0, 0.0, dead.limit);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_START, dead.state);
    }
}

/// Noise of a count in some phases (a bit each) while the offsets are calibrated.
static lode_telemetry_t with_noise(unsigned noisy) {
    lode_drive_config_t config = rig_config();
    config.sense.i_noise_count = 0.5f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    for (unsigned n = 0; n < 600; n++) {
        lode_counts_t counts = rig_counts(&rig);
        for (unsigned k = 0; k < 3; k++) {
            counts.i[k] = (uint16_t)(counts.i[k] + (noisy >> k & n & 1u));
        }
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    return rig_telemetry(&rig);
}

static void test_a_current_without_its_noise_is_refused_at_calibration(void) {
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, with_noise(7u).mode);
    for (unsigned noisy = 0; noisy < 7; noisy++) {
        const lode_fault_t fault = with_noise(noisy).fault;
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_STUCK", lode_check_name(fault.check));
        TEST_ASSERT_EQUAL_INT(LODE_MODE_CALIBRATE, fault.state);
        const float first = (noisy & 1u) == 0u ? 1.0f : ((noisy & 2u) == 0u ? 2.0f : 3.0f);
        TEST_ASSERT_TRUE(fault.measured == first && fault.limit == 0.0f);
    }
}

/// 0.3 s with a bus that reads `share` of what it is, and moves by a count every round or not.
static lode_fault_t with_bus(rig_t rig, double share, bool moves) {
    for (uint32_t n = 0; n < 1500u; n++) {
        lode_counts_t counts = rig_counts(&rig);
        const uint32_t noise = moves ? n / LODE_SLOW_PERIODS % 2u : 0u;
        counts.v_bus = (uint16_t)((uint32_t)rig_count(share * counts.v_bus) + noise);
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    return rig_telemetry(&rig).fault;
}

static void test_a_bus_that_stands_still_trips_where_the_emf_has_moved(void) {
    lode_drive_config_t config = rig_config();
    config.guard.bus_still_s = 0.1f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.load_Nm = 0.5;
    run_up(&rig, 100.0, 8.0);
    rig_run(&rig, 1.0);
    const double shares[] = {1.18, 0.85}; // the bus has sagged, or risen
    for (int n = 0; n < COUNT_OF(shares); n++) {
        const lode_fault_t stuck = with_bus(rig, shares[n], false);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_BUS_STUCK", lode_check_name(stuck.check));
        CHECK_CLOSE(0.2, shares[n] * (double)PAPER_V_BUS, stuck.measured);
        CHECK_CLOSE(1.0e-4, 62 * 8 * RIG_TS_s, stuck.limit); // whole rounds
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_bus(rig, shares[n], true).check);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_bus(rig, 1.0, false).check);
}

// --- A load beyond all torque, and another flux with a lock that is not lost --------------------

/// Of i_max, Nm.
#define ALL_Nm (1.5 * 3.0 * 0.142 * 12.0)

/// One that has run for so long that its start is proven.
static rig_t proven(const lode_drive_config_t *config, double speed) {
    rig_t rig;
    rig_init(&rig, &tuning, config);
    rig.motor.theta = CALM_rad;
    run_up(&rig, speed, 8.0);
    rig_run(&rig, 1.0);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.state.run.proving);
    return rig;
}

/// (K19): the load turns it back, or on, while it runs either way. The rotor still turns as it should.
static void test_a_load_beyond_all_torque_is_named_within_100_ms(void) {
    const lode_drive_config_t config = rig_config();
    for (int way = -1; way <= 1; way += 2) {
        const rig_t runs = proven(&config, 100.0 * way);
        for (int pull = -1; pull <= 1; pull += 2) {
            rig_t rig = runs;
            rig.pull_Nm = 2.0 * ALL_Nm * pull;
            rig_run(&rig, 0.1);
            const lode_fault_t fault = rig_telemetry(&rig).fault;
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OVERLOAD", lode_check_name(fault.check));
            TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, fault.state);
            CHECK_CLOSE(1.0e-3, 300.0 * way, fault.limit);
            CHECK_AT_LEAST(0.05 * 300.0, (double)((float)pull * (fault.limit - fault.measured)));
            CHECK_AT_LEAST(0.0, (double)(fault.measured * (float)way));
        }
    }
}

/// A second of it. The check, or none.
static lode_check_t after_a_second(rig_t rig, double pull_Nm) {
    rig.pull_Nm = pull_Nm;
    rig_run(&rig, 1.0);
    return (lode_check_t)rig_telemetry(&rig).fault.check;
}

static void test_a_load_that_can_be_held_is_none_beyond_all_torque(void) {
    lode_drive_config_t config = rig_config();
    const rig_t rig = proven(&config, 100.0);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, after_a_second(rig, 0.9 * ALL_Nm));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, after_a_second(rig, -0.9 * ALL_Nm));
    // From one end to the other, with all the torque that is left beside such a load.
    rig_t slams = rig;
    slams.load_Nm = 0.6 * ALL_Nm;
    for (int n = 0; n < 4; n++) {
        rig_command(&slams, run_at(n % 2 == 0 ? 150.0 : 60.0));
        rig_run(&slams, 0.5);
        rig_expect(&slams, LODE_MODE_RUN);
    }
    // Where nobody wants it to be looked at, it ends as it did.
    config.guard.overload_s = LODE_NONE;
    const lode_check_t other = after_a_second(proven(&config, 100.0), 2.0 * ALL_Nm);
    TEST_ASSERT_NOT_EQUAL(LODE_CHECK_OVERLOAD, other);
    TEST_ASSERT_NOT_EQUAL(LODE_CHECK_NONE, other);
}

/// A limit of the application's, and torque control: what the load does then is wanted.
static void test_less_than_all_torque_may_slip(void) {
    const lode_drive_config_t config = rig_config();
    rig_t limited = proven(&config, 100.0);
    lode_drive_limit_torque(&limited.drive, 0.3f);
    limited.pull_Nm = 0.6 * ALL_Nm;
    rig_run(&limited, 0.15);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&limited).fault.check);
    CHECK_AT_MOST(80.0 * 3.0, limited.motor.omega); // it has
    rig_t torque = proven(&config, 100.0);
    rig_command(&torque, torque_of(1.2 * ALL_Nm, 140.0));
    torque.pull_Nm = 2.0 * ALL_Nm;
    rig_run(&torque, 0.15);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&torque).fault.check);
    CHECK_AT_MOST(80.0 * 3.0, torque.motor.omega);
}

/// A drive of which all torque is asked for, and whose speed has been moved by far. `way`: of the rotor; `sense`: of the torque.
static rig_t overloaded(rig_t rig, float way, float sense) {
    lode_drive_t *drive = &rig.drive;
    lode_running_t *run = &drive->state.run;
    const float omega = 300.0f * way;
    drive->estimator.pll.omega_rad_s = omega;
    drive->estimator.lock = 1.0f;
    run->held_rad_s = omega + 1000.0f * sense;
    run->speed.reference_rad_s = 100.0f * way + 50.0f * sense;
    run->speed.limit_Nm = (lode_range_t){(float)-ALL_Nm, (float)ALL_Nm};
    run->speed.torque_Nm = (float)ALL_Nm * sense;
    drive->ref_A = (lode_dq_t){0.0f, 12.0f * sense};
    drive->i_A = drive->ref_A;
    return rig;
}

static lode_check_t trips_by(rig_t rig) {
    const bool on = lode_drive_watch_load(&rig.drive);
    TEST_ASSERT_EQUAL_INT(rig.drive.gates, on);
    return (lode_check_t)rig.drive.guard.fault.check;
}

/// Each of them alone tells that it may be something else than the load.
static void test_what_may_be_else_than_the_load(void) {
    const lode_drive_config_t config = rig_config();
    const rig_t runs = proven(&config, 100.0);
    for (int n = 0; n < 4; n++) {
        const rig_t bad = overloaded(runs, n % 2 == 0 ? 1.0f : -1.0f, n < 2 ? 1.0f : -1.0f);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVERLOAD, trips_by(bad));
        rig_t rig = bad;
        rig.drive.estimator.lock = LODE_LOCK_HANDOVER; // just enough
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVERLOAD, trips_by(rig));
        rig.drive.estimator.lock = 0.99f * LODE_LOCK_HANDOVER;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        TEST_ASSERT_TRUE(lode_drive_watch_load(&rig.drive));
        rig.drive.estimator.lock = 1.0f; // what the speed did before does not count
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        rig = bad; // voltage, temperature or somebody limits the torque
        rig.drive.state.run.speed.limit_Nm = (lode_range_t){-6.5f, 6.5f};
        rig.drive.state.run.speed.torque_Nm = n < 2 ? 6.5f : -6.5f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        rig = bad; // the voltage is too little for the current
        rig.drive.i_A.q *= 0.79f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        rig = bad;
        rig.drive.state.run.speed.torque_Nm *= 0.89f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        CHECK_CLOSE(1.0e-6, 300.0, fabs((double)rig.drive.estimator.pll.omega_rad_s));
        rig = bad;
        rig.drive.state.run.fade = 0.1f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        rig = bad;
        rig.drive.state.run.proving = 1u;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        rig = bad;
        rig.drive.command.flags |= (uint_least8_t)LODE_ORDER_TORQUE;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        rig = bad; // its angle may be wrong
        rig.drive.sensored = 1u;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        rig = bad;
        rig.drive.estimator.by.hfi.active = true;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
        rig = bad; // so little may be a large inertia's
        rig.drive.state.run.speed.reference_rad_s = 100.0f * (n % 2 == 0 ? 1.0f : -1.0f);
        rig.drive.state.run.speed.reference_rad_s *= n == 0 || n == 3 ? 1.04f : 0.96f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, trips_by(rig));
    }
}

/// 3 mNm, 0.3 W of a mechanical power.
static void test_all_torque_of_a_small_motor_is_all_of_it(void) {
    const lode_drive_config_t config = rig_config();
    const rig_t runs = proven(&config, 100.0);
    other_tuning = tuning;
    other_tuning.references.tau_max *= 0.0004f;
    for (int sense = -1; sense <= 1; sense += 2) {
        rig_t rig = overloaded(runs, (float)sense, (float)sense);
        rig.drive.tuning = &other_tuning;
        rig.drive.state.run.speed.limit_Nm =
            (lode_range_t){(float)(-0.0004 * ALL_Nm), (float)(0.0004 * ALL_Nm)};
        rig.drive.state.run.speed.torque_Nm *= 0.0004f;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVERLOAD, trips_by(rig));
    }
}

/// Where the voltage limits the torque, a rotor that slows down comes to where there is more of it; one that is turned on does
/// not.
static void test_a_torque_that_the_voltage_limits_is_all_of_it_for_a_brake(void) {
    lode_drive_config_t config = rig_config();
    config.references.field_weakening = LODE_ON;
    const rig_t runs = proven(&config, 100.0);
    for (int sense = -1; sense <= 1; sense += 2) {
        rig_t rig = overloaded(runs, 1.0f, (float)sense);
        rig.drive.ref_A = (lode_dq_t){-11.0f, 4.0f * (float)sense};
        rig.drive.i_A = rig.drive.ref_A;
        const float most_Nm =
            lode_references_allowed_Nm(&rig.drive.state.run.references, &tuning.references, -11.0f);
        CHECK_AT_MOST(0.85 * ALL_Nm, (double)most_Nm);
        rig.drive.state.run.speed.limit_Nm = (lode_range_t){-most_Nm, most_Nm};
        rig.drive.state.run.speed.torque_Nm = most_Nm * (float)sense;
        TEST_ASSERT_EQUAL_INT(sense < 0 ? LODE_CHECK_OVERLOAD : LODE_CHECK_NONE, trips_by(rig));
    }
}

/// Too little for the lock to be lost, and more than a tuning explains (P25).
static void test_another_flux_is_named_though_the_lock_holds(void) {
    lode_drive_config_t config = rig_config();
    rig_t rig = proven(&config, 100.0);
    rig.load_Nm = 3.0;
    rig_run(&rig, 1.0);
    const double more[] = {0.27, -0.3}; // (P25) is 0.24 here
    for (int n = 0; n < COUNT_OF(more); n++) {
        const lode_fault_t fault = with_less_flux(rig, more[n]);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_FLUX", lode_check_name(fault.check));
        TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, fault.state);
        CHECK_CLOSE(0.06, (1.0 - more[n]) * rig.motor.psi, fault.measured);
        CHECK_CLOSE(0.06, rig.motor.psi, fault.limit);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_less_flux(rig, 0.15).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_less_flux(rig, -0.15).check);
    rig_t idle = proven(&config, 100.0); // with as little current it may be the inverter
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_less_flux(idle, 0.25).check);
    config.guard.plausibility = LODE_OFF;
    rig_t unwatched = proven(&config, 100.0);
    unwatched.load_Nm = 3.0;
    rig_run(&unwatched, 1.0);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, with_less_flux(unwatched, 0.25).check);
}

/// How many rounds it takes with the observer's EMF at `times` what the speed induces; 0: more than 1000.
static uint32_t flux_rounds(rig_t rig, float times, lode_dq_t i_A, bool proves) {
    lode_drive_t *drive = &rig.drive;
    lode_estimator_t *estimator = &drive->estimator;
    const lode_estimator_tuning_t *own = &drive->tuning->estimator;
    const float omega = 300.0f;
    const float active_Wb = own->psi_Wb + own->salient_H * i_A.d;
    const float e_V = times * active_Wb * omega / (1.0f + omega * omega * own->droop_s2);
    estimator->pll.omega_rad_s = omega;
    estimator->emf.observer.e_V = lode_park_inverse((lode_dq_t){0.0f, e_V}, estimator->pll.frame);
    estimator->id_A = i_A.d;
    estimator->lock = 0.6f;
    drive->i_A = i_A;
    drive->state.run.proving = proves ? 1u : 0u;
    for (uint32_t n = 1u; n <= 1000u; n++) {
        if (!lode_drive_watch_flux(drive)) {
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_FLUX, drive->guard.fault.check);
            return n;
        }
    }
    return 0u;
}

/// (P25)
static void test_another_flux_is_as_large_as_no_error_and_lasts(void) {
    lode_drive_config_t config = rig_config();
    const rig_t rig = proven(&config, 100.0);
    const lode_dq_t none = {0.0f, 1.9f};
    const uint32_t rounds = (uint32_t)(0.05 / (8.0 * RIG_TS_s)) + 1u;
    TEST_ASSERT_EQUAL_UINT32(rounds, flux_rounds(rig, 0.77f, none, false));
    TEST_ASSERT_EQUAL_UINT32(rounds, flux_rounds(rig, 1.23f, none, false));
    TEST_ASSERT_EQUAL_UINT32(0u, flux_rounds(rig, 0.81f, none, false));
    TEST_ASSERT_EQUAL_UINT32(0u, flux_rounds(rig, 0.77f, (lode_dq_t){0.0f, 1.7f}, false));
    TEST_ASSERT_EQUAL_UINT32(rounds, flux_rounds(rig, 0.77f, (lode_dq_t){-1.9f, 0.0f}, false));
    TEST_ASSERT_EQUAL_UINT32(0u, flux_rounds(rig, 0.77f, none, true));
    TEST_ASSERT_EQUAL_UINT32(0u, flux_rounds(rig, 0.45f, none, false));
    // With i_d = -6 A, i_q = 8 A the current has 0.27 of the flux, and errors of it explain 0.1 of psi.
    const lode_dq_t much = {-6.0f, 8.0f};
    const double active = 1.0 + 6.3e-3 * 6.0 / 0.142;
    const double d = 0.2 * 3.5e-3 * 6.0 / 0.142;
    const double q = 0.2 * 6.3e-3 * 9.8e-3 * 64.0 / (active * 0.142) / 0.142;
    const double r = 0.5 * 0.75 * 8.0 / 300.0 / 0.142;
    const double least = (0.2 + sqrt(d * d + q * q + r * r)) / active;
    TEST_ASSERT_EQUAL_UINT32(rounds, flux_rounds(rig, (float)(1.0 - 1.01 * least), much, false));
    TEST_ASSERT_EQUAL_UINT32(0u, flux_rounds(rig, (float)(1.0 - 0.99 * least), much, false));
    // It begins anew.
    rig_t again = rig;
    again.drive.guard.flux_rounds = (uint_least8_t)(rounds - 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, flux_rounds(again, 0.77f, none, false));
    TEST_ASSERT_EQUAL_UINT32(0u, flux_rounds(again, 0.81f, none, false));
    again.drive.estimator.lock = 1.0f;
    (void)lode_drive_watch_flux(&again.drive);
    TEST_ASSERT_EQUAL_UINT32(0u, again.drive.guard.flux_rounds);
    // Where rounds are short, as many as the counter holds.
    lode_drive_tuning_t quick = *rig.drive.tuning;
    quick.estimator.pll.ts_s = 1.0e-5f;
    rig_t fast = rig;
    fast.drive.tuning = &quick;
    TEST_ASSERT_EQUAL_UINT32(255u, flux_rounds(fast, 0.77f, none, false));
    // The speed of a sensor may lag, and that of a QPLL whose angle comes from injection.
    rig_t sensed = rig;
    sensed.drive.sensored = 1u;
    TEST_ASSERT_EQUAL_UINT32(0u, flux_rounds(sensed, 0.77f, none, false));
    lode_drive_tuning_t qpll = *rig.drive.tuning;
    qpll.estimator.pll.third_order = 0u;
    for (int n = 0; n < 4; n++) {
        rig_t wave = rig;
        wave.drive.estimator.by.hfi.active = n % 2 == 1;
        wave.drive.tuning = n < 2 ? rig.drive.tuning : &qpll;
        TEST_ASSERT_EQUAL_UINT32(n < 3 ? rounds : 0u, flux_rounds(wave, 0.77f, none, false));
    }
}

// --- The step as a whole ----------------------------------------------------------------------

static void test_an_estimate_that_is_no_number_trips_in_the_same_call(void) {
    rig_t start = running(60.0, 3.0);
    for (int field = -1; field < 18; field++) { // -1: the same without the fault
        rig_t rig = start;
        const lode_counts_t counts = rig_counts(&rig);
        const lode_sample_t m = lode_drive_sense(&rig.drive, &counts);
        lode_estimate_t e = lode_drive_estimate(&rig.drive, &m);
        e.source = LODE_ESTIMATE_EXTERNAL;
        float *const fields[] = {&e.omega_rad_s,    &e.rotor.sin, &e.rotor.cos, &e.i_A.d, &e.i_A.q,
                                 &e.load_torque_Nm, &e.e_V.alpha, &e.e_V.beta,  &e.lock};
        if (field >= 0) {
            *fields[field % 9] = field < 9 ? NAN : INFINITY;
        }
        const lode_drive_out_t out = lode_drive_act(&rig.drive, &m, &e);
        TEST_ASSERT_EQUAL_INT(field < 0, out.gates);
        TEST_ASSERT_EQUAL_INT(field < 0 ? LODE_CHECK_NONE : LODE_CHECK_NON_FINITE,
                              rig.drive.guard.fault.check);
        TEST_ASSERT_TRUE(lode_in_range(out.duty.a, 0.0f, 1.0f));
    }
}

/// An estimate of somebody else's is the drive's own from then on: what it would tell of itself is what it was told.
static void test_an_estimate_that_is_taken_over_is_the_own_one(void) {
    rig_t rig = running(60.0, 3.0);
    lode_drive_t *drive = &rig.drive;
    const float ts_s = drive->tuning->estimator.pll.ts_s;
    const float locks[] = {0.0f, LODE_LOCK_LOST, 0.9f};
    for (int n = 0; n < COUNT_OF(locks); n++) {
        drive->estimator.found = 0u;
        drive->estimator.aligned = n == 0;
        const lode_estimate_t told = {.source = LODE_ESTIMATE_EXTERNAL,
                                      .omega_rad_s = 500.0f,
                                      .rotor = lode_sincos(2.0f),
                                      .i_A = {-1.5f, 2.5f},
                                      .e_V = {-60.0f, 35.0f},
                                      .load_torque_Nm = 1.25f,
                                      .lock = locks[n]};
        lode_mode_adopt(drive, &told);
        const lode_estimate_t own = lode_mode_estimate(drive);
        CHECK_NEAR(1.0e-6, told.rotor.sin, own.rotor.sin);
        CHECK_NEAR(1.0e-6, told.rotor.cos, own.rotor.cos);
        CHECK_NEAR(0.0, told.omega_rad_s, own.omega_rad_s);
        CHECK_NEAR(0.0, told.e_V.alpha, own.e_V.alpha);
        CHECK_NEAR(0.0, told.e_V.beta, own.e_V.beta);
        CHECK_NEAR(1.0e-6, told.load_torque_Nm, own.load_torque_Nm);
        CHECK_NEAR(0.0, told.lock, own.lock);
        CHECK_NEAR(0.0, told.i_A.d, drive->estimator.id_A);
        CHECK_CLOSE(1.0e-6, (double)(ts_s * drive->estimator.pll.f_rad_s2),
                    drive->estimator.pll.rise_rad_s);
        TEST_ASSERT_EQUAL_INT(n > 0, drive->estimator.locked);
        TEST_ASSERT_EQUAL_INT(n > 0, drive->estimator.aligned);
        TEST_ASSERT_EQUAL_UINT(1u, drive->estimator.found);
    }
}

/// Numbers whose sum is none are no motor's, and so is a lock beyond one.
static void test_an_estimate_of_no_motor_trips(void) {
    rig_t start = running(60.0, 3.0);
    for (int k = 1; k <= 8; k++) {
        rig_t rig = start;
        lode_estimate_t e = lode_mode_estimate(&rig.drive);
        e.source = LODE_ESTIMATE_EXTERNAL;
        float *const fields[] = {&e.i_A.d,       &e.i_A.q,          &e.rotor.cos, &e.rotor.sin,
                                 &e.omega_rad_s, &e.load_torque_Nm, &e.e_V.alpha, &e.e_V.beta};
        if (k < 8) {
            *fields[0] = *fields[k] = 3.0e38f;
        } else {
            e.lock = nextafterf(1.0f, 2.0f);
        }
        lode_mode_adopt(&rig.drive, &e);
        const lode_fault_t *fault = &rig.drive.guard.fault;
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NON_FINITE, fault->check);
        CHECK_NEAR(0.0, 1.0, fault->measured);
        CHECK_NEAR(0.0, 0.0, fault->limit);
    }
}

/// With the PLL `kind`: the estimate of the QPLL has no load torque in it.
static void drive_by_an_encoder(lode_pll_kind_t kind) {
    lode_drive_config_t config = rig_config();
    config.estimator.pll.kind = kind;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 60.0, 3.0);
    rig_run(&rig, 1.0);
    for (int n = 0; n < 5000; n++) { // an encoder mounted 10 degrees ahead
        const lode_counts_t counts = rig_counts(&rig);
        const lode_sample_t m = lode_drive_sense(&rig.drive, &counts);
        lode_estimate_t e = lode_drive_estimate(&rig.drive, &m);
        e.source = LODE_ESTIMATE_EXTERNAL;
        e.rotor = sincos_of(rig.motor.theta + 10.0 * CHECK_DEG);
        e.omega_rad_s = (float)rig.motor.omega;
        e.i_A = lode_park(m.i_A, e.rotor);
        e.load_torque_Nm = 0.25f;
        e.lock = 0.875f;
        const double theta = rig.motor.theta;
        rig.out = lode_drive_act(&rig.drive, &m, &e);
        TEST_ASSERT_TRUE(rig.out.gates);
        const lode_telemetry_t t = rig_telemetry(&rig);
        CHECK_NEAR(1.0e-3, 10.0 * CHECK_DEG, angle_error((double)t.theta_rad, theta));
        CHECK_CLOSE(1.0e-6, rig.motor.omega, t.omega_rad_s);
        CHECK_CLOSE(1.0e-6, (double)e.i_A.q, t.i_A.q);
        CHECK_NEAR(0.1, kind == LODE_PLL_LESO ? 0.25 : 0.0, t.load_torque_Nm);
        rig_move(&rig);
    }
    CHECK_CLOSE(0.01, 60.0, rig.motor.omega / 3.0);
}

static void test_an_estimate_of_the_hosts_own_is_taken_over(void) {
    drive_by_an_encoder(LODE_PLL_LESO);
    drive_by_an_encoder(LODE_PLL_QPLL);
}

static void test_the_lock_of_an_external_estimate_counts(void) {
    const float locks[] = {LODE_LOCK_LOST, nextafterf(LODE_LOCK_LOST, 0.0f), 1.0f};
    rig_t rig = running(60.0, 3.0);
    for (int n = 0; n < COUNT_OF(locks); n++) {
        const lode_counts_t counts = rig_counts(&rig);
        const lode_sample_t m = lode_drive_sense(&rig.drive, &counts);
        lode_estimate_t e = lode_drive_estimate(&rig.drive, &m);
        e.source = LODE_ESTIMATE_EXTERNAL;
        e.lock = locks[n];
        (void)lode_drive_act(&rig.drive, &m, &e);
        TEST_ASSERT_EQUAL(locks[n] >= LODE_LOCK_LOST, rig.drive.estimator.locked);
    }
}

static void test_a_voltage_that_is_none_trips_in_the_same_call(void) {
    // A bus that the host made up asks for 3 MV of the bus that there is: that is no duty.
    rig_t rig = running(60.0, 3.0);
    const lode_counts_t counts = rig_counts(&rig);
    lode_sample_t m = lode_drive_sense(&rig.drive, &counts);
    lode_estimate_t e = lode_drive_estimate(&rig.drive, &m);
    m.v_bus_V = 1.0e7f;
    e.source = LODE_ESTIMATE_EXTERNAL;
    e.omega_rad_s = 1.0e6f;
    TEST_ASSERT_TRUE(is_idle(lode_drive_act(&rig.drive, &m, &e)));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NON_FINITE, rig_telemetry(&rig).fault.check);
}

static void test_a_bus_and_a_speed_of_no_motor_stay_in_range_and_trip(void) {
    // The voltage lies in the circle of that bus, so the duties are duties; bus and speed trip in time.
    rig_t rig = running(60.0, 3.0);
    lode_counts_t counts = rig_counts(&rig);
    counts.v_bus = 65535u;
    int periods = 0;
    do {
        const lode_sample_t m = lode_drive_sense(&rig.drive, &counts);
        lode_estimate_t e = lode_drive_estimate(&rig.drive, &m);
        e.source = LODE_ESTIMATE_EXTERNAL;
        e.omega_rad_s = 1.0e9f;
        rig.out = lode_drive_act(&rig.drive, &m, &e);
        TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.a, 0.0f, 1.0f));
        TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.b, 0.0f, 1.0f));
        TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.c, 0.0f, 1.0f));
        periods++;
    } while (rig.out.gates && periods < 100);
    CHECK_AT_MOST(LODE_SLOW_PERIODS, periods); // two looks of the slow checks
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_VOLTAGE, rig_telemetry(&rig).fault.check);
}

/// Half a second with a temperature whose count moves once in `every` periods; 0: never.
static lode_fault_t after_temperature(rig_t rig, uint32_t every) {
    for (uint32_t n = 0; n < 2500u; n++) {
        lode_counts_t counts = rig_counts(&rig);
        counts.temperature = (uint16_t)(500u + (every > 0u ? n / every % 2u : 0u));
        rig.stamp += 1000u;
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    return rig_telemetry(&rig).fault;
}

static void test_a_temperature_that_stands_still_trips_where_it_should_not(void) {
    lode_drive_config_t config = rig_config();
    config.sense.temperature_gain_degC_count = 0.1f;
    config.guard.temperature_still_s = 0.1f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(100.0));
    for (uint32_t n = 0; n < 40000u && !rig.drive.steady; n++) {
        lode_counts_t counts = rig_counts(&rig);
        counts.temperature = (uint16_t)(500u + n / 8u % 2u);
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
    }
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, rig_telemetry(&rig).mode);
    const lode_fault_t stuck = after_temperature(rig, 0u);
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_TEMPERATURE_STUCK", lode_check_name(stuck.check));
    CHECK_CLOSE(1.0e-3, 50.0, stuck.measured);
    CHECK_CLOSE(1.0e-4, 62 * 8 * 2.0e-4, stuck.limit); // whole rounds
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, after_temperature(rig, 8u).check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, after_temperature(rig, 400u).check); // 80 ms
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_TEMPERATURE_STUCK, after_temperature(rig, 600u).check);
    // From the first look at the last count on: within one round, and then so many.
    (void)after_temperature(rig, 8u);
    uint32_t periods = 0u;
    while (rig.out.gates) {
        lode_counts_t counts = rig_counts(&rig);
        counts.temperature = 777u;
        rig.stamp += 1000u;
        rig.out = lode_drive_step(&rig.drive, &counts);
        rig_move(&rig);
        periods++;
    }
    TEST_ASSERT_TRUE(periods > 62u * LODE_SLOW_PERIODS && periods <= 63u * LODE_SLOW_PERIODS);
}

/// The same fault by the step and by its three calls: the same record, in the same period.
static void expect_same_fault(const rig_t *before, const lode_counts_t *counts, int limit) {
    lode_drive_t one = before->drive;
    lode_drive_t two = before->drive;
    bool on = true;
    for (int n = 0; n < limit && on; n++) {
        const lode_sample_t m = lode_drive_sense(&two, counts);
        const lode_estimate_t e = lode_drive_estimate(&two, &m);
        on = lode_drive_step(&one, counts).gates;
        TEST_ASSERT_EQUAL_INT(on, lode_drive_act(&two, &m, &e).gates);
    }
    TEST_ASSERT_FALSE(on);
    TEST_ASSERT_TRUE(one.guard.fault.check != LODE_CHECK_NONE);
    TEST_ASSERT_EQUAL_MEMORY(&one.guard.fault, &two.guard.fault, sizeof one.guard.fault);
}

static void test_the_step_is_three_calls_in_a_row(void) {
    rig_t one = fresh();
    rig_t two = one;
    rig_command(&one, run_at(70.0));
    rig_command(&two, run_at(70.0));
    for (int n = 0; n < 15000; n++) {
        const lode_counts_t counts = rig_counts(&one);
        one.out = lode_drive_step(&one.drive, &counts);
        const lode_sample_t m = lode_drive_sense(&two.drive, &counts);
        const lode_estimate_t e = lode_drive_estimate(&two.drive, &m);
        two.out = lode_drive_act(&two.drive, &m, &e);
        TEST_ASSERT_EQUAL_MEMORY(&one.out.duty, &two.out.duty, sizeof one.out.duty);
        TEST_ASSERT_EQUAL_INT(one.out.gates, two.out.gates);
        rig_move(&one);
    }
    rig_expect(&one, LODE_MODE_RUN);
    lode_counts_t railed = rig_counts(&one);
    railed.i[1] = 4095u;
    expect_same_fault(&one, &railed, 10);
    lode_counts_t over = rig_counts(&one);
    over.i[2] = 2048u + 1900u; // 24 A, not at the rail
    expect_same_fault(&one, &over, 1);
    lode_counts_t tripped = rig_counts(&one);
    tripped.trip = true;
    expect_same_fault(&one, &tripped, 1);
}

static void test_two_drives_share_nothing(void) {
    lode_drive_config_t config = rig_config();
    static rig_t alone[2];
    static rig_t together[2];
    static lode_drive_tuning_t tunings[2];
    for (int i = 0; i < 2; i++) {
        config.estimator.pll.kind = i == 0 ? LODE_PLL_LESO : LODE_PLL_QPLL;
        rig_init(&alone[i], &tunings[i], &config);
        rig_command(&alone[i], run_at(i == 0 ? 90.0 : -60.0));
        alone[i].load_Nm = 1.0 + i;
        together[i] = alone[i];
    }
    for (int i = 0; i < 2; i++) {
        rig_run(&alone[i], 3.0);
    }
    for (int n = 0; n < 15000; n++) {
        rig_step(&together[n % 2]);
        rig_step(&together[1 - n % 2]);
    }
    for (int i = 0; i < 2; i++) {
        rig_expect(&alone[i], LODE_MODE_RUN);
        const lode_telemetry_t a = rig_telemetry(&alone[i]);
        const lode_telemetry_t b = rig_telemetry(&together[i]);
        TEST_ASSERT_EQUAL_UINT32(a.steps, b.steps);
        TEST_ASSERT_EQUAL_INT(a.fault.check, b.fault.check);
        // All that follows is floats: no padding, which may hold anything.
        const size_t numbers = offsetof(lode_telemetry_t, duty);
        TEST_ASSERT_EQUAL_MEMORY((const char *)&a + numbers, (const char *)&b + numbers,
                                 sizeof a - numbers);
        TEST_ASSERT_TRUE(alone[i].motor.theta == together[i].motor.theta);
    }
}

static bool is_finite_picture(const lode_telemetry_t *t) {
    const float values[] = {t->duty.a,          t->duty.b,          t->duty.c,    t->i_A.d,
                            t->i_A.q,           t->ref_A.d,         t->ref_A.q,   t->u_V.d,
                            t->u_V.q,           t->v_bus_V,         t->theta_rad, t->omega_rad_s,
                            t->speed_ref_rad_s, t->load_torque_Nm,  t->lock,      t->e_V.alpha,
                            t->e_V.beta,        t->temperature_degC};
    bool finite = true;
    for (int i = 0; i < COUNT_OF(values); i++) {
        finite = finite && lode_is_finite(values[i]);
    }
    return finite;
}

static void test_any_counts_give_duties_on_the_grid(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.pwm_ticks = 8400.0f;
    config.inverter.dead_time_s = 4.0e-6f;
    config.guard.i_trip_A = 25.0f; // as far as the sensor goes
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    random_t random = random_seed(1);
    const lode_mode_t modes[] = {LODE_MODE_OFF, LODE_MODE_CALIBRATE, LODE_MODE_VOLTAGE,
                                 LODE_MODE_CURRENT, LODE_MODE_RUN};
    for (int n = 0; n < 200000; n++) {
        if (n % 50 == 0) {
            rig_command(&rig, (lode_command_t){.mode = modes[random_bits(&random) % 5u],
                                               .speed_rad_s = random_float(&random, -300.0, 300.0),
                                               .vector = {random_float(&random, -50.0, 50.0), 3.0f},
                                               .omega_rad_s = random_float(&random, -2.0e3, 2.0e3),
                                               .clear_fault = true});
        }
        const uint32_t spread = n % 3 == 0 ? 4096u : 512u;
        lode_counts_t counts = {.v_bus = (uint16_t)(1500u + random_bits(&random) % spread),
                                .trip = random_bits(&random) % 997u == 0u};
        for (int i = 0; i < 3; i++) {
            counts.i[i] = (uint16_t)(2048u - spread / 4u + random_bits(&random) % (spread / 2u));
        }
        const lode_drive_out_t out = lode_drive_step(&rig.drive, &counts);
        TEST_ASSERT_TRUE(lode_in_range(out.duty.a, 0.0f, 1.0f) &&
                         lode_in_range(out.duty.b, 0.0f, 1.0f) &&
                         lode_in_range(out.duty.c, 0.0f, 1.0f));
        CHECK_NEAR(0.01, round((double)out.duty.a * 8400.0), (double)out.duty.a * 8400.0);
        const lode_telemetry_t t = rig_telemetry(&rig);
        TEST_ASSERT_TRUE(is_finite_picture(&t));
    }
}

static void test_telemetry_is_what_was_put_out(void) {
    rig_t rig = holding();
    const uint32_t before = rig_telemetry(&rig).steps;
    for (int n = 0; n < 20; n++) {
        rig_step(&rig);
        const lode_telemetry_t t = rig_telemetry(&rig);
        TEST_ASSERT_EQUAL_MEMORY(&rig.out.duty, &t.duty, sizeof t.duty);
        TEST_ASSERT_EQUAL_UINT32(rig.drive.steps, t.steps);
        TEST_ASSERT_EQUAL_UINT32(before + 1u + (uint32_t)n, t.steps);
        CHECK_NEAR(0.05, 200.0, t.v_bus_V);
    }
}

static void test_the_temperature_is_told_in_every_mode(void) {
    lode_drive_config_t config = rig_config();
    config.sense.temperature_gain_degC_count = 0.1f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    const lode_command_t commands[] = {off, {.mode = LODE_MODE_CALIBRATE}, run_at(100.0)};
    for (int n = 0; n < COUNT_OF(commands); n++) {
        rig_command(&rig, commands[n]);
        for (int k = 0; k < 50; k++) {
            lode_counts_t counts = rig_counts(&rig);
            counts.temperature = (uint16_t)(400 + 100 * n);
            rig.out = lode_drive_step(&rig.drive, &counts);
            rig_move(&rig);
        }
        CHECK_NEAR(1.0e-3, 40.0 + 10.0 * n, rig_telemetry(&rig).temperature_degC);
    }
}

static void test_telemetry_of_speed_control_is_nothing_without_it(void) {
    rig_t rig = holding();
    const lode_telemetry_t t = rig_telemetry(&rig);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, t.torque_ref_Nm);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, t.torque_most_Nm);
    TEST_ASSERT_FALSE(t.torque_limited);
    TEST_ASSERT_FALSE(t.speed_raised);
}

/// An estimate that stands beside the rotor shows it by the EMF across its axis.
static void test_telemetry_tells_the_position_error_by_the_emf(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        const rig_t rig = running(100.0 * sign, 8.0);
        CHECK_NEAR(0.05, 0.0, rig_telemetry(&rig).emf_error_rad);
        for (int ahead = -1; ahead <= 1; ahead += 2) {
            rig_t off_axis = rig;
            lode_pll_t *pll = &off_axis.drive.estimator.pll;
            pll->frame = lode_angle_add(pll->frame, lode_sincos(0.2f * (float)ahead));
            const lode_telemetry_t t = rig_telemetry(&off_axis);
            CHECK_NEAR(0.05, -0.2 * ahead, t.emf_error_rad);
            CHECK_NEAR(0.0, 0.0, t.injected);
            CHECK_NEAR(0.0, 0.0, t.injection_error_rad);
        }
    }
}

static void test_telemetry_tells_the_position_error_by_injection(void) {
    lode_drive_config_t config = rig_config();
    config.hfi.mode = LODE_HFI_ON;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.drive.estimator.by.hfi.active = true;
    rig.drive.estimator.by.hfi.weight = 0.75f;
    rig.drive.estimator.by.hfi.error = -0.125f;
    CHECK_NEAR(0.0, 0.75, rig_telemetry(&rig).injected);
    CHECK_NEAR(0.0, -0.125, rig_telemetry(&rig).injection_error_rad);
}

static void test_names_of_modes(void) {
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_OFF", lode_mode_name(LODE_MODE_OFF));
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_RUN", lode_mode_name(LODE_MODE_RUN));
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_FAULT", lode_mode_name(LODE_MODE_FAULT));
    for (int i = 0; i <= (int)LODE_MODE_PRECHARGE; i++) {
        for (int j = 0; j < i; j++) {
            TEST_ASSERT_TRUE(
                strcmp(lode_mode_name((lode_mode_t)i), lode_mode_name((lode_mode_t)j)) != 0);
        }
    }
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_UNKNOWN", lode_mode_name((lode_mode_t)77));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_init_is_at_rest_and_idempotent);
    RUN_TEST(test_one_tuning_serves_two_drives);
    RUN_TEST(test_off_stays_off);
    RUN_TEST(test_calibration_measures_offsets_with_gates_off);
    RUN_TEST(test_an_implausible_offset_is_a_fault);
    RUN_TEST(test_off_interrupts_a_calibration);
    RUN_TEST(test_low_sides_come_before_all_gates);
    RUN_TEST(test_low_sides_stay_on_no_longer_than_commanded);
    RUN_TEST(test_low_sides_are_guarded);
    RUN_TEST(test_low_sides_are_on_for_the_sampling_window);
    RUN_TEST(test_voltage_vector_at_an_angle);
    RUN_TEST(test_turning_voltage_is_ahead_by_one_and_a_half_periods);
    RUN_TEST(test_the_frame_stands_at_its_angle_when_the_mode_is_entered);
    RUN_TEST(test_voltage_stays_in_the_circle);
    RUN_TEST(test_current_vector_at_an_angle);
    RUN_TEST(test_current_command_is_limited);
    RUN_TEST(test_run_calibrates_starts_and_turns_both_ways);
    RUN_TEST(test_two_shunts_do);
    RUN_TEST(test_hand_over_waits_for_the_flux_of_a_salient_rotor);
    RUN_TEST(test_speed_control_runs_as_often_as_its_bandwidth_asks);
    RUN_TEST(test_every_rate_of_speed_control_drives);
    RUN_TEST(test_references_follow_the_torque_at_once_at_every_rate);
    RUN_TEST(test_references_weaken_the_field);
    RUN_TEST(test_load_steps_and_speed_changes);
    RUN_TEST(test_the_fade_leaves_out_short_currents);
    RUN_TEST(test_a_current_is_short_by_both_its_parts);
    RUN_TEST(test_torque_control_follows_torque_and_holds_its_speeds);
    RUN_TEST(test_torque_control_without_a_sensor_stops_by_speed);
    RUN_TEST(test_a_speed_that_is_raised_is_told);
    RUN_TEST(test_speed_zero_stops_and_switches_off);
    RUN_TEST(test_the_way_back_begins_where_its_current_makes_the_torque);
    RUN_TEST(test_gates_off_no_voltage_is_on_its_way);
    RUN_TEST(test_the_voltage_of_a_run_is_ahead_by_one_and_a_half_periods);
    RUN_TEST(test_mail_that_comes_late_ends_the_steady_state);
    RUN_TEST(test_switched_on_it_begins_anew);
    RUN_TEST(test_no_jump_at_hand_over);
    RUN_TEST(test_the_way_back_with_a_small_current);
    RUN_TEST(test_every_slow_job_is_done_once_in_a_round);
    RUN_TEST(test_a_sensor_that_falls_silent_is_none);
    RUN_TEST(test_torque_shares_change_places_at_standstill);
    RUN_TEST(test_a_commanded_frame_has_no_speed_of_a_rotor);
    RUN_TEST(test_the_vector_of_a_start_is_led_by_one_and_a_half_periods);
    RUN_TEST(test_every_bit_of_an_order_counts);
    RUN_TEST(test_duties_of_an_emf_beyond_the_bus_are_at_the_rails);
    RUN_TEST(test_a_start_has_its_time);
    RUN_TEST(test_a_rotor_that_does_not_follow_is_told_by_its_emf);
    RUN_TEST(test_a_wrong_psi_is_told_by_the_lock);
    RUN_TEST(test_a_start_with_too_little_time_tells_where_it_was);
    RUN_TEST(test_a_trip_in_a_start_tells_the_stage);
    RUN_TEST(test_a_driven_mode_that_became_another_trips_at_once);
    RUN_TEST(test_mail_is_read_once);
    RUN_TEST(test_the_current_of_a_trip_is_told);
    RUN_TEST(test_much_resistance_is_corrected_in_part);
    RUN_TEST(test_the_first_vector_leads_the_axis_of_a_salient_rotor);
    RUN_TEST(test_after_a_mailbox_that_lies_the_drive_can_be_started_again);
    RUN_TEST(test_a_post_that_is_not_told_is_found);
    RUN_TEST(test_the_guard_counts_anew_from_the_low_sides_on);
    RUN_TEST(test_a_falling_Lq_that_is_known_leaves_no_error_of_the_angle);
    RUN_TEST(test_current_control_follows_a_falling_Lq);
    RUN_TEST(test_another_tuning_brings_its_own_q_axis);
    RUN_TEST(test_a_falling_Lq_turns_no_angle_with_injection);
    RUN_TEST(test_reversal);
    RUN_TEST(test_a_rotor_that_turns_already_is_taken_over);
    RUN_TEST(test_pulses_find_a_rotor_that_turns);
    RUN_TEST(test_a_flight_begins_with_the_emf);
    RUN_TEST(test_off_ends_the_pulses);
    RUN_TEST(test_a_start_tries_bridge_and_sensors);
    RUN_TEST(test_swapped_sensors_end_the_start_before_it_begins);
    RUN_TEST(test_starts_that_try_nothing);
    RUN_TEST(test_duties_of_pulses_stay_in_range);
    RUN_TEST(test_capacitors_are_charged_by_the_pulses_themselves);
    RUN_TEST(test_capacitors_are_charged_after_pulses_that_find_nothing);
    RUN_TEST(test_off_at_speed_switches_off_at_once);
    RUN_TEST(test_a_blocked_rotor_ends_in_a_start_fault);
    RUN_TEST(test_bad_commands_are_refused_and_change_nothing);
    RUN_TEST(test_a_speed_that_cannot_be_had_is_refused);
    RUN_TEST(test_commands_wait_for_the_next_period_and_the_last_counts);
    RUN_TEST(test_a_command_that_comes_within_a_period_waits_for_the_next);
    RUN_TEST(test_huge_commands_give_duties);
    RUN_TEST(test_the_same_tuning_changes_nothing);
    RUN_TEST(test_a_new_tuning_is_taken_at_a_period);
    RUN_TEST(test_a_tuning_that_samples_all_phases_watches_all);
    RUN_TEST(test_a_tuning_with_windows_leaves_out_what_is_not_sampled);
    RUN_TEST(test_a_float_of_a_tuning_that_is_no_number_makes_no_duty);
    RUN_TEST(test_a_grid_that_is_no_number_trips_in_the_same_call);
    RUN_TEST(test_a_tuning_with_a_float_that_is_no_number_is_refused);
    RUN_TEST(test_an_integer_of_a_tuning_may_be_any);
    RUN_TEST(test_a_refused_tuning_leaves_the_one_that_waits);
    RUN_TEST(test_a_bus_that_jumps_is_divided_by_at_once);
    RUN_TEST(test_a_bus_without_reading_stays_in_range);
    RUN_TEST(test_over_current_of_either_sign_in_the_same_call);
    RUN_TEST(test_hardware_trip_in_the_same_call);
    RUN_TEST(test_a_fault_shorts_the_motor_where_that_is_commanded);
    RUN_TEST(test_a_trip_by_current_shorts_nothing_by_itself);
    RUN_TEST(test_a_current_that_flows_on_is_a_shorted_switch);
    RUN_TEST(test_samples_at_the_rails_tell_the_side_too);
    RUN_TEST(test_a_shorted_switch_shows_one_side);
    RUN_TEST(test_other_currents_with_the_gates_off_are_no_shorted_switch);
    RUN_TEST(test_a_single_sample_at_the_rail_passes);
    RUN_TEST(test_a_call_that_is_late_trips_at_once);
    RUN_TEST(test_bus_out_of_range_trips_after_its_debounce);
    RUN_TEST(test_a_fault_stays_until_it_is_cleared);
    RUN_TEST(test_a_mode_or_command_that_changes_by_itself_trips);
    RUN_TEST(test_a_posted_command_is_not_lost_by_a_flip);
    RUN_TEST(test_a_tuning_that_changes_by_itself_trips);
    RUN_TEST(test_two_bits_of_a_tuning_that_change_by_themselves_trip);
    RUN_TEST(test_a_tuning_posted_twice_is_watched_by_its_own_check);
    RUN_TEST(test_the_check_is_the_remainder_of_its_polynomial);
    RUN_TEST(test_the_check_finds_any_three_bits_of_six_phases);
    RUN_TEST(test_the_check_finds_bursts_of_a_word);
    RUN_TEST(test_after_a_trip_the_telemetry_keeps_what_the_drive_was_doing);
    RUN_TEST(test_a_stuck_converter_trips_before_the_current_is_large);
    RUN_TEST(test_what_dead_time_and_drops_hold_is_not_stuck);
    RUN_TEST(test_a_wrong_sum_of_the_currents_trips_where_it_persists);
    RUN_TEST(test_currents_that_rest_by_the_damping_are_not_stuck);
    RUN_TEST(test_a_current_that_the_voltage_does_not_allow_is_not_missed);
    RUN_TEST(test_the_row_of_every_fault_keeps_the_values_of_its_step);
    RUN_TEST(test_lost_lock_and_wrong_way_trip_in_20_ms);
    RUN_TEST(test_a_lock_lost_right_after_the_hand_over_is_an_attempt);
    RUN_TEST(test_all_attempts_of_a_start_have_one_time);
    RUN_TEST(test_a_start_is_proven_to_the_round);
    RUN_TEST(test_a_rotor_that_the_load_turns_ends_the_attempt);
    RUN_TEST(test_a_rotor_that_the_load_turns_does_not_end_a_stop);
    RUN_TEST(test_a_rotor_that_the_load_turns_on_and_on_is_a_fault);
    RUN_TEST(test_a_hoist_with_an_open_brake_is_caught_and_started);
    RUN_TEST(test_a_rotor_that_turns_the_other_way_has_not_started);
    RUN_TEST(test_a_rotor_that_is_caught_for_a_stop_has_patience);
    RUN_TEST(test_the_last_attempt_is_repeated_faster);
    RUN_TEST(test_a_start_that_is_over_is_no_attempt);
    RUN_TEST(test_a_commanded_off_forgets_the_attempts);
    RUN_TEST(test_attempts_that_fail_in_the_start_count);
    RUN_TEST(test_a_way_back_before_the_start_is_over_is_of_the_same_start);
    RUN_TEST(test_a_lock_lost_right_after_the_pulses_is_an_attempt);
    RUN_TEST(test_another_flux_is_named);
    RUN_TEST(test_another_flux_is_one_at_every_look);
    RUN_TEST(test_the_observers_lag_is_no_other_flux);
    RUN_TEST(test_a_dead_switch_ends_the_start);
    RUN_TEST(test_a_phase_that_opens_in_run_is_found);
    RUN_TEST(test_the_hand_over_begins_the_counts_of_run);
    RUN_TEST(test_half_waves_are_looked_at_with_and_without_field_weakening);
    RUN_TEST(test_turns_that_tell_of_no_half_wave);
    RUN_TEST(test_a_half_wave_is_found_within_1_2_turns_either_way);
    RUN_TEST(test_a_turn_that_tells_nothing_forgets);
    RUN_TEST(test_a_current_without_its_noise_is_refused_at_calibration);
    RUN_TEST(test_a_resistance_of_no_winding_ends_the_start);
    RUN_TEST(test_more_current_than_is_measured_ends_the_start);
    RUN_TEST(test_a_flux_of_no_motor_is_one_for_as_long_as_a_lock);
    RUN_TEST(test_a_resistance_that_is_measured_is_right);
    RUN_TEST(test_a_bus_that_stands_still_trips_where_the_emf_has_moved);
    RUN_TEST(test_a_load_beyond_all_torque_is_named_within_100_ms);
    RUN_TEST(test_a_load_that_can_be_held_is_none_beyond_all_torque);
    RUN_TEST(test_less_than_all_torque_may_slip);
    RUN_TEST(test_what_may_be_else_than_the_load);
    RUN_TEST(test_all_torque_of_a_small_motor_is_all_of_it);
    RUN_TEST(test_a_torque_that_the_voltage_limits_is_all_of_it_for_a_brake);
    RUN_TEST(test_another_flux_is_named_though_the_lock_holds);
    RUN_TEST(test_another_flux_is_as_large_as_no_error_and_lasts);
    RUN_TEST(test_an_estimate_that_is_no_number_trips_in_the_same_call);
    RUN_TEST(test_an_estimate_that_is_taken_over_is_the_own_one);
    RUN_TEST(test_an_estimate_of_no_motor_trips);
    RUN_TEST(test_an_estimate_of_the_hosts_own_is_taken_over);
    RUN_TEST(test_the_lock_of_an_external_estimate_counts);
    RUN_TEST(test_a_voltage_that_is_none_trips_in_the_same_call);
    RUN_TEST(test_a_bus_and_a_speed_of_no_motor_stay_in_range_and_trip);
    RUN_TEST(test_a_temperature_that_stands_still_trips_where_it_should_not);
    RUN_TEST(test_the_step_is_three_calls_in_a_row);
    RUN_TEST(test_two_drives_share_nothing);
    RUN_TEST(test_any_counts_give_duties_on_the_grid);
    RUN_TEST(test_telemetry_is_what_was_put_out);
    RUN_TEST(test_the_temperature_is_told_in_every_mode);
    RUN_TEST(test_telemetry_of_speed_control_is_nothing_without_it);
    RUN_TEST(test_telemetry_tells_the_position_error_by_the_emf);
    RUN_TEST(test_telemetry_tells_the_position_error_by_injection);
    RUN_TEST(test_names_of_modes);
    return UNITY_END();
}
