// The drive in RUN: angle, speed, torque, references and what becomes of them at speed; a motor in double behind it.
#include "support/drive_cases.h"

void setUp(void) {}

void tearDown(void) {}

static lode_drive_tuning_t other_tuning;

/// Mean error of the angle under load, in degrees, of a motor whose Lq falls by 5 % per ampere. `hfi`: it injects, but not at this
/// speed.
static double error_of_a_q_axis_that_saturates(float Lq_fall, lode_hfi_mode_t hfi) {
    lode_drive_config_t config = rig_config();
    config.references.Lq_fall = Lq_fall;
    config.hfi.mode = hfi;
    config.hfi.w2_rad_s = 100.0f;
    config.hfi.Lq_i_max_H = 6.0e-3f; // salient enough to inject
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
    CHECK_AT_LEAST(3.0, fabs(error_of_a_q_axis_that_saturates(0.0f, LODE_HFI_OFF)));
    CHECK_AT_MOST(0.3, fabs(error_of_a_q_axis_that_saturates(0.05f, LODE_HFI_OFF)));
    CHECK_AT_MOST(0.3, fabs(error_of_a_q_axis_that_saturates(0.05f, LODE_HFI_ON)));
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

/// Injection alone goes by the inductances themselves. As soon as the EMF has a part in the angle, its flux is corrected.
static void test_a_falling_Lq_turns_the_angle_by_the_emf_only(void) {
    const float weights[] = {1.0f, 0.99f, 0.0f};
    for (int n = 0; n < 6; n++) {
        const bool active = n < 3;
        const float weight = weights[n % 3];
        lode_drive_config_t config = rig_config();
        config.references.Lq_fall = 0.03f;
        config.hfi.mode = LODE_HFI_ON;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        rig.drive.estimator.emf.i_A = (lode_ab_t){0.0f, 6.0f};
        rig.drive.estimator.by.hfi.active = active;
        rig.drive.estimator.by.hfi.weight = weight;
        lode_drive_adapt_saturated_lag(&rig.drive);
        const double turned = fabs((double)rig.drive.estimator.lag.at.sin);
        const bool alone = active && weight >= 1.0f;
        CHECK_AT_LEAST(alone ? 0.0 : 0.05, turned);
        CHECK_AT_MOST(alone ? 0.0 : 0.2, turned);
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

static void test_the_fade_is_quick_where_the_current_is_short(void) {
    uint32_t shorts = 0u;
    float step_A = 0.0f;
    rig_t rig = fresh();
    const float bias_A = tuning.references.id_bias_A;
    TEST_ASSERT_TRUE(bias_A > 0.0f);
    rig_command(&rig, run_at(60.0));
    watch_the_fade(&rig, bias_A, &shorts, &step_A);
    rig_run(&rig, (double)LODE_SLOW_PERIODS * RIG_TS_s);
    TEST_ASSERT_TRUE(shorts <= 4u * LODE_SLOW_PERIODS); // some milliseconds
    TEST_ASSERT_TRUE(step_A < 0.9f * bias_A);           // not in one step
    CHECK_CLOSE(1.0e-6, -bias_A, rig.drive.ref_A.d);
    // Where that moves more than a third of the flux, it fades to the end.
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
        const float times = n < 3 ? 24.0f : 1.0f;
        TEST_ASSERT_EQUAL_FLOAT(0.75f - times * tuning.start.fade_step,
                                lode_drive_faded(&rig.drive));
    }
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

static void test_a_speed_that_is_raised_is_reported(void) {
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

/// On the way back at the first period of START, against a load. `*before`: as in the period before.
static rig_t on_the_way_back(double sign, rig_t *before) {
    rig_t rig = fresh();
    rig.load_Nm = 1.5;
    rig_command(&rig, run_at((float)(80.0 * sign)));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
    rig_run(&rig, 1.0);
    rig_command(&rig, run_at((float)(-80.0 * sign)));
    for (int n = 0; n < 20000 && rig_telemetry(&rig).mode == LODE_MODE_RUN; n++) {
        *before = rig;
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_START);
    return rig;
}

/// Against the load the vector of the way back begins ahead of the rotor by asin(iq/I).
static void test_the_way_back_begins_where_its_current_makes_the_torque(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t before;
        const rig_t rig = on_the_way_back(sign, &before);
        const lode_sincos_t at = rig.drive.state.start.at;
        const lode_sincos_t rotor = lode_sincos(lode_estimator_theta_rad(&rig.drive.estimator));
        const lode_sincos_t ahead = lode_angle_subtract(at, rotor);
        const float wanted = before.drive.i_A.q / rig.drive.tuning->start.current_A;
        CHECK_AT_LEAST(0.02, fabs((double)wanted));
        CHECK_NEAR(1.0e-3, 1.0, hypot((double)at.sin, (double)at.cos));
        CHECK_NEAR(0.05, wanted, ahead.sin);
    }
}

/// (S55), (S56): current control goes on from the voltage that the rotor takes with the vector's current, and the damping from its
/// EMF.
static void test_the_way_back_begins_with_what_its_current_takes(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t before;
        rig_t rig = on_the_way_back(sign, &before);
        const lode_start_t *start = &rig.drive.state.start;
        const lode_sincos_t rotor = lode_sincos(lode_estimator_theta_rad(&rig.drive.estimator));
        const lode_sincos_t ahead = lode_angle_subtract(start->at, rotor);
        const double omega = rig.motor.omega;
        const double id = (double)(start->current_A * ahead.cos);
        const double iq = (double)(start->current_A * ahead.sin);
        // Resistance is left to the integrators: the current comes with their time constant.
        const lode_ab_t u_V = {(float)(0.75 * rig.motor.id - omega * 9.8e-3 * iq),
                               (float)(0.75 * rig.motor.iq + omega * (3.5e-3 * id + 0.142))};
        const lode_dq_t wanted_V = lode_park(u_V, ahead);
        CHECK_NEAR(0.5, wanted_V.d, rig.drive.current.d.integral);
        CHECK_NEAR(0.5, wanted_V.q, rig.drive.current.q.integral);
        const double flux_V = fabs(omega) * (0.142 - 6.3e-3 * id);
        CHECK_NEAR(0.15 * flux_V, flux_V, fabs((double)start->mean_V));
        double most_A = 0.0;
        double most_rad = 0.0;
        for (int n = 0; n < 500; n++) {
            rig_step(&rig);
            most_A = fmax(most_A, hypot(rig.motor.id, rig.motor.iq));
            if (n < 50) { // before the rotor has moved
                most_rad = fmax(most_rad, fabs((double)lode_start_shift_rad(start)));
            }
        }
        rig_expect(&rig, LODE_MODE_START);
        CHECK_AT_MOST(1.03 * (double)start->current_A, most_A);
        CHECK_AT_MOST(0.15, most_rad);
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
        const lode_range_t left = lode_mode_torque_limits(&rig.drive, most);
        CHECK_NEAR(1.0e-3, sign > 0 ? 10.0 : 5.0, left.max);
        CHECK_NEAR(1.0e-3, sign > 0 ? -5.0 : -10.0, left.min);
    }
}

/// They hold from the first period of RUN on, whichever way leads there.
static void test_torque_shares_hold_from_the_beginning_of_RUN(void) {
    for (int flies = 0; flies < 2; flies++) {
        rig_t rig = fresh();
        rig.motor.omega = flies > 0 ? 3.0 * 100.0 : 0.0;
        lode_drive_limit_torques(&rig.drive, 0.5f, 0.25f);
        rig_command(&rig, run_at(100.0));
        TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_RUN, 8.0));
        TEST_ASSERT_EQUAL_INT(flies > 0, rig.motor.omega > 200.0);
        const double most_Nm = (double)lode_references_most_Nm(&tuning.references);
        const lode_range_t limit_Nm = rig.drive.state.run.speed.limit_Nm;
        CHECK_AT_MOST(0.5001 * most_Nm, (double)limit_Nm.max);
        CHECK_AT_LEAST(-0.2501 * most_Nm, (double)limit_Nm.min);
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

/// The terminals are held at what the bus can: no duty leaves 0 .. 1.
static void test_duties_of_an_emf_beyond_the_bus_are_at_the_rails(void) {
    const lode_abc_t one = lode_mode_duties_at((lode_abc_t){0.8f, -0.9f, 0.1f});
    const lode_abc_t other = lode_mode_duties_at((lode_abc_t){-0.8f, 0.9f, 1.1f});
    TEST_ASSERT_TRUE(one.a == 1.0f && one.b == 0.0f);
    CHECK_NEAR(1.0e-6, 0.6, one.c);
    TEST_ASSERT_TRUE(other.a == 0.0f && other.b == 1.0f && other.c == 1.0f);
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

static void test_off_at_speed_switches_off_at_once(void) {
    rig_t rig = running(80.0, 8.0);
    rig_command(&rig, off);
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_expect(&rig, LODE_MODE_OFF);
}

/// (K33): from hand-over to hand-back and behind the reversal the reference has no more than its slopes and its jerk, and begins
/// each time where the rotor is.
static void test_a_jerk_limits_the_reference_of_a_drive(void) {
    lode_drive_config_t config = rig_config();
    config.speed.ramp_rad_s2 = 100.0f;
    config.speed.ramp_down_rad_s2 = 60.0f;
    config.speed.jerk_rad_s3 = 400.0f;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    const double speeds[] = {80.0, 120.0, -80.0};
    const float *const reference = &rig.drive.state.run.speed.reference_rad_s;
    const float *const step = &rig.drive.state.run.speed.step_rad_s;
    for (int k = 0; k < COUNT_OF(speeds); k++) {
        rig_command(&rig, run_at(speeds[k]));
        float last = 0.0f;
        float before = *reference;
        bool runs = false;
        for (int n = 0; n < 30000; n++) {
            const bool ran = runs;
            rig_step(&rig);
            runs = lode_mode(&rig.drive) == LODE_MODE_RUN;
            if (runs && !ran && n > 0) {
                CHECK_NEAR(1.0e-6, 0.0, *step);
            } else if (runs && ran) {
                CHECK_AT_MOST(1.001 * (double)tuning.speed.jerk_step, lode_abs(*step - last));
                CHECK_AT_MOST(1.001 * (double)tuning.speed.ramp_step, lode_abs(*step));
                CHECK_AT_MOST(1.001 * (double)tuning.speed.ramp_step + 1.0e-5,
                              lode_abs(*reference - before));
            } else {
                // starting, or on the way back
            }
            last = *step;
            before = *reference;
        }
        rig_expect(&rig, LODE_MODE_RUN);
        CHECK_NEAR(1.0e-4, speeds[k], *reference);
        check_running(&rig, speeds[k]);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_run_calibrates_starts_and_turns_both_ways);
    RUN_TEST(test_two_shunts_do);
    RUN_TEST(test_speed_control_runs_as_often_as_its_bandwidth_asks);
    RUN_TEST(test_every_rate_of_speed_control_drives);
    RUN_TEST(test_references_follow_the_torque_at_once_at_every_rate);
    RUN_TEST(test_references_weaken_the_field);
    RUN_TEST(test_load_steps_and_speed_changes);
    RUN_TEST(test_the_fade_is_quick_where_the_current_is_short);
    RUN_TEST(test_a_current_is_short_by_both_its_parts);
    RUN_TEST(test_torque_control_follows_torque_and_holds_its_speeds);
    RUN_TEST(test_torque_control_without_a_sensor_stops_by_speed);
    RUN_TEST(test_a_speed_that_is_raised_is_reported);
    RUN_TEST(test_speed_zero_stops_and_switches_off);
    RUN_TEST(test_the_way_back_begins_where_its_current_makes_the_torque);
    RUN_TEST(test_the_way_back_begins_with_what_its_current_takes);
    RUN_TEST(test_gates_off_no_voltage_is_on_its_way);
    RUN_TEST(test_the_voltage_of_a_run_is_ahead_by_one_and_a_half_periods);
    RUN_TEST(test_mail_that_comes_late_ends_the_steady_state);
    RUN_TEST(test_switched_on_it_begins_anew);
    RUN_TEST(test_the_way_back_with_a_small_current);
    RUN_TEST(test_every_slow_job_is_done_once_in_a_round);
    RUN_TEST(test_a_sensor_that_falls_silent_is_none);
    RUN_TEST(test_torque_shares_change_places_at_standstill);
    RUN_TEST(test_torque_shares_hold_from_the_beginning_of_RUN);
    RUN_TEST(test_a_commanded_frame_has_no_speed_of_a_rotor);
    RUN_TEST(test_duties_of_an_emf_beyond_the_bus_are_at_the_rails);
    RUN_TEST(test_a_falling_Lq_that_is_known_leaves_no_error_of_the_angle);
    RUN_TEST(test_current_control_follows_a_falling_Lq);
    RUN_TEST(test_another_tuning_brings_its_own_q_axis);
    RUN_TEST(test_a_falling_Lq_turns_the_angle_by_the_emf_only);
    RUN_TEST(test_reversal);
    RUN_TEST(test_a_jerk_limits_the_reference_of_a_drive);
    RUN_TEST(test_off_at_speed_switches_off_at_once);
    return UNITY_END();
}
