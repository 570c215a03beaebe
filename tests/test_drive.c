// The drive: modes, commands, tunings, the step as a whole, telemetry; a motor in double behind it.
#include "support/drive_cases.h"

void setUp(void) {}

void tearDown(void) {}

static lode_drive_tuning_t other_tuning;

// --- Off, calibration -------------------------------------------------------------------------

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

static rig_t precharging(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.precharge_s = (float)(PRECHARGE_PERIODS * RIG_TS_s);
    config.start.pulses = LODE_OFF;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.blocked = true;
    return rig;
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

/// What another command needs first, as the offsets for RUN, is not left out.
static void test_another_command_begins_from_off(void) {
    rig_t rig = precharging();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT});
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_PRECHARGE, 0.2));
    rig_run(&rig, 10.0 * RIG_TS_s);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_VOLTAGE});
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_PRECHARGE);
    rig_run(&rig, (PRECHARGE_PERIODS - 1) * RIG_TS_s);
    rig_expect(&rig, LODE_MODE_PRECHARGE);
    rig_command(&rig, run_at(100.0));
    rig_step(&rig);
    TEST_ASSERT_TRUE(is_idle(rig.out));
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_CALIBRATE);
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 1.0));
    TEST_ASSERT_TRUE(lode_drive_knows(&rig.drive, LODE_KNOWN_OFFSETS));
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
        // An ADC count is 12.5 mA.
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
    // A vector, or the speed of its frame, that is beyond any motor; an angle that has no digits left within a turn.
    const float most_of[] = {LODE_COMMAND_MAX, LODE_COMMAND_MAX, LODE_COMMAND_MAX,
                             LODE_ANGLE_LIMIT_rad};
    for (int field = 0; field < COUNT_OF(most_of); field++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            lode_command_t command = {.mode = LODE_MODE_VOLTAGE};
            float *const values[] = {&command.vector.d, &command.vector.q, &command.omega_rad_s,
                                     &command.theta_rad};
            *values[field] = (float)sign * 1.0001f * most_of[field];
            TEST_ASSERT_EQUAL_INT(LODE_ERROR_COMMAND,
                                  lode_drive_post_command(&rig.drive, &command));
            rig_t other = rig;
            *values[field] = (float)sign * most_of[field];
            rig_command(&other, command);
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

/// The limit itself is allowed, in whatever order it was computed.
static void test_the_largest_speed_is_allowed(void) {
    random_t random = random_seed(7);
    for (int n = 0; n < CHECK_TRIES(300); n++) {
        lode_drive_config_t config = rig_config();
        config.motor.pole_pairs = floorf(random_float(&random, 1.0, 30.0));
        config.estimator.omega_max_rad_s = random_float(&random, 600.0, 900.0);
        config.guard.omega_max_rad_s = 1000.0f;
        static lode_drive_tuning_t some;
        rig_t rig;
        rig_init(&rig, &some, &config);
        const float most = config.estimator.omega_max_rad_s / config.motor.pole_pairs;
        rig_command(&rig, run_at((double)most));
        rig_command(&rig, run_at(-(double)most));
        const lode_command_t more = run_at(1.00001 * (double)most);
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_COMMAND_SPEED, lode_drive_post_command(&rig.drive, &more));
    }
}

/// A command that the tuning in force allows, and a tuning that does not: taken in the same period, in either order.
static void test_a_command_meets_the_limits_of_the_tuning_that_comes_with_it(void) {
    for (int order = 0; order < 2; order++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            lode_drive_config_t config = rig_config();
            rig_t rig;
            rig_init(&rig, &tuning, &config);
            run_up(&rig, 100.0, 8.0);
            config.estimator.omega_max_rad_s = 500.0f;
            lode_drive_tuning_t slower;
            TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&slower, &config));
            const lode_command_t command = run_at(sign * 300.0);
            if (order == 0) {
                rig_command(&rig, command);
            }
            TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &slower));
            if (order == 1) {
                rig_command(&rig, command);
            }
            rig_step(&rig);
            CHECK_NEAR(1.0e-3, sign * 500.0 / 3.0, rig.drive.command.speed_rad_s);
            rig_run(&rig, 6.0);
            check_running(&rig, sign * 500.0 / 3.0);
        }
    }
}

/// A command whose bits have changed since it was posted keeps the check that tells so.
static void test_a_corrupted_command_is_not_made_whole_by_a_limit(void) {
    lode_drive_config_t config = rig_config();
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 100.0, 8.0);
    rig_command(&rig, run_at(100.0));
    rig.drive.posted.speed_rad_s = 1.0e9f;
    rig_run(&rig, 2.0 * LODE_SLOW_PERIODS * RIG_TS_s);
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_MEMORY", lode_check_name(rig_telemetry(&rig).fault.check));
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
            const float most = copysignf(LODE_COMMAND_MAX, huge[i]);
            rig_command(&rig,
                        (lode_command_t){.mode = modes[m],
                                         .torque_Nm = huge[i],
                                         .control = LODE_CONTROL_TORQUE,
                                         .speed_rad_s = modes[m] == LODE_MODE_RUN
                                                            ? copysignf(150.0f, huge[i])
                                                            : huge[i],
                                         .vector = {most, most},
                                         .theta_rad = copysignf(LODE_ANGLE_LIMIT_rad, huge[i]),
                                         .omega_rad_s = most});
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

static void check_goes_on(rig_t *rig) {
    double worst = 0.0;
    for (int n = 0; n < 1000; n++) {
        rig_step(rig);
        worst = fmax(worst, fabs(rig->angle_error));
    }
    check_running(rig, 157.0);
    CHECK_AT_MOST(1.5 * CHECK_DEG, worst);
}

/// With 3 Nm at 1500 rpm, from any observer to any other.
static void test_another_observer_goes_on_with_the_rotor(void) {
    for (int from = 0; from < (int)LODE_EMF_KINDS; from++) {
        lode_drive_config_t config = rig_config();
        config.estimator.emf.kind = (lode_emf_kind_t)from;
        rig_t before;
        rig_init(&before, &tuning, &config);
        run_up(&before, 157.0, 8.0);
        before.load_Nm = 3.0;
        rig_run(&before, 2.0);
        for (int to = 0; to < (int)LODE_EMF_KINDS; to++) {
            rig_t rig = before;
            config.estimator.emf.kind = (lode_emf_kind_t)to;
            TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
            TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
            rig_step(&rig);
            const lode_estimator_t *estimator = &rig.drive.estimator;
            const double e_V = (double)lode_ab_length(estimator->emf.observer.e_V);
            const double w = (double)estimator->pll.omega_rad_s;
            const double flux = 0.142 + (3.5e-3 - 9.8e-3) * (double)estimator->id_A;
            const double droop = 1.0 + w * w * (double)other_tuning.estimator.droop_s2;
            CHECK_CLOSE(0.02, w * flux / droop, e_V);
            CHECK_CLOSE(0.02, 1.0, -(double)estimator->per_V * e_V);
            check_goes_on(&rig);
        }
    }
}

static void goes_on_with(rig_t rig, const lode_drive_config_t *config) {
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    check_goes_on(&rig);
}

/// The same observer with another lag, or tuned by a filtered speed, which nothing has kept up to date.
static void test_the_same_observer_with_other_parameters_goes_on_with_the_rotor(void) {
    for (int kind = 0; kind < (int)LODE_EMF_KINDS; kind++) {
        lode_drive_config_t config = rig_config();
        config.estimator.emf.kind = (lode_emf_kind_t)kind;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        run_up(&rig, 157.0, 8.0);
        rig.load_Nm = 3.0;
        rig_run(&rig, 2.0);
        lode_drive_config_t slower = config;
        lode_drive_design(&slower);
        slower.estimator.emf.w0_rad_s *= 0.7f;
        slower.estimator.emf.gi_kappa *= 2.0f;
        goes_on_with(rig, &slower);
        config.estimator.w_filter_rad_s = 50.0f;
        goes_on_with(rig, &config);
        config.estimator.emf.kind = (lode_emf_kind_t)((kind + 1) % (int)LODE_EMF_KINDS);
        goes_on_with(rig, &config);
    }
}

/// A filtered speed that the old tuning has kept up to date goes on, and is not that of the PLL with its noise.
static void test_a_filtered_speed_outlives_its_tuning(void) {
    lode_drive_config_t config = rig_config();
    for (int filtered = 0; filtered <= 1; filtered++) {
        config.estimator.w_filter_rad_s = filtered != 0 ? 50.0f : 0.0f;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        run_up(&rig, 157.0, 8.0);
        rig.drive.estimator.omega_tune = 600.0f;
        config.estimator.w_filter_rad_s = 50.0f;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
        lode_estimator_retune(&rig.drive.estimator, &tuning.estimator, &other_tuning.estimator);
        const float expected = filtered != 0 ? 600.0f : rig.drive.estimator.pll.omega_rad_s;
        TEST_ASSERT_EQUAL_FLOAT(expected, rig.drive.estimator.omega_tune);
    }
}

/// What the start has measured beyond the configured resistance and dead time is less beyond larger ones.
static void test_what_was_measured_counts_from_the_new_tuning(void) {
    rig_t rig = running(90.0, 8.0);
    lode_inverter_t *inverter = &rig.drive.inverter;
    inverter->r_more_Ohm = 0.3f;
    inverter->dead_more = 2.0e-3f;
    lode_drive_config_t config = rig_config();
    config.motor.Rs_Ohm += 0.2f;
    config.inverter.r_on_Ohm += 0.05f;
    config.inverter.dead_time_s += 0.5e-6f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    const float longer = other_tuning.inverter.dead_duty - tuning.inverter.dead_duty;
    CHECK_AT_LEAST(1.0e-4, (double)longer);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    rig_step(&rig);
    CHECK_NEAR(1.0e-6, 0.05, inverter->r_more_Ohm);
    CHECK_NEAR(1.0e-7, 2.0e-3 - (double)longer, inverter->dead_more);
    // not beyond one that the adaptation has posted
    lode_drive_tuning_t adapted = other_tuning;
    adapted.estimator.emf.a_over_b -= 0.1f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &adapted));
    rig_step(&rig);
    CHECK_NEAR(1.0e-6, 0.05, inverter->r_more_Ohm);
}

/// A command that a new tuning would refuse becomes the largest one that it accepts.
static void test_a_command_beyond_a_new_limit_is_bounded(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = running(80.0 * sign, 8.0);
        rig_command(&rig, run_at(157.0 * sign));
        rig_step(&rig);
        lode_drive_config_t config = rig_config();
        config.guard.omega_max_rad_s = 400.0f;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
        rig_step(&rig);
        CHECK_CLOSE(1.0e-6, sign * 400.0 / 3.0, rig.drive.command.speed_rad_s);
        rig_run(&rig, 0.5);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig.drive.guard.fault.check);
    }
}

/// The cause that is named is the rotor, which is too fast, or cannot be followed, and not the memory.
static void test_a_rotor_beyond_a_new_limit(void) {
    rig_t rig = running(157.0, 8.0);
    rig_run(&rig, 2.0);
    check_running(&rig, 157.0);
    for (int n = 0; n < 2; n++) {
        rig_t fast = rig;
        lode_drive_config_t config = rig_config();
        config.guard.omega_max_rad_s = 230.0f;
        config.estimator.omega_max_rad_s = n == 0 ? 0.0f : 230.0f; // follows up to twice that
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&fast.drive, &other_tuning));
        rig_run(&fast, 0.02);
        TEST_ASSERT_EQUAL_STRING(n == 0 ? "LODE_CHECK_OVER_SPEED" : "LODE_CHECK_LOST_LOCK",
                                 lode_check_name((lode_check_t)fast.drive.guard.fault.check));
    }
}

/// id, which nothing follows without MTPA or field weakening, is not the start's.
static void test_optimal_references_begin_with_the_present_current(void) {
    rig_t rig = running(90.0, 8.0);
    rig.load_Nm = 3.0;
    rig_run(&rig, 1.0);
    lode_drive_config_t config = rig_config();
    config.references.kind = LODE_REFERENCES_MTPA;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    for (int n = 0; n < (int)LODE_SLOW_PERIODS; n++) {
        rig_t next = rig;
        for (int k = 0; k < n; k++) {
            rig_step(&next);
        }
        const double before_A = (double)next.drive.ref_A.d;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&next.drive, &other_tuning));
        for (int k = 0; k < 2 * (int)LODE_SLOW_PERIODS; k++) {
            rig_step(&next);
            CHECK_AT_MOST(before_A + 0.01, (double)next.drive.ref_A.d);
        }
        rig_run(&next, 1.0);
        check_running(&next, 90.0);
        CHECK_AT_MOST(-0.5, (double)next.drive.ref_A.d);
    }
}

/// What a ramp with a limit of the jerk was doing is over when a tuning without one comes.
static void test_a_ramp_without_jerk_leaves_none(void) {
    lode_drive_config_t config = rig_config();
    lode_drive_tuning_t shaped;
    config.speed.ramp_rad_s2 = 40.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    config.speed.jerk_rad_s3 = 40.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&shaped, &config));
    rig_t rig;
    rig_init(&rig, &shaped, &config);
    run_up(&rig, 30.0, 8.0);
    rig_command(&rig, run_at(110.0));
    rig_run(&rig, 1.5);
    // The same one again leaves the slope.
    rig_t same = rig;
    lode_drive_tuning_t again = shaped;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&same.drive, &again));
    const lode_speed_t *speed = &same.drive.state.run.speed;
    const lode_speed_t before = *speed;
    rig_step(&same);
    CHECK_AT_LEAST(1.0e-3, (double)speed->step_rad_s);
    CHECK_NEAR(2.0 * (double)shaped.speed.jerk_step, (double)before.step_rad_s, speed->step_rad_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    rig_step(&rig);
    CHECK_NEAR(0.0, 0.0, rig.drive.state.run.speed.step_rad_s);
    rig_run(&rig, 3.0);
    check_running(&rig, 110.0);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &shaped));
    for (int n = 0; n < 10000; n++) {
        rig_step(&rig);
        CHECK_NEAR(1.0e-3, 110.0, rig_telemetry(&rig).speed_ref_rad_s);
    }
}

/// A slope that the jerk has built up goes on, however often speed control is called from now on.
static void test_a_slope_goes_on_at_another_rate(void) {
    for (int faster = 0; faster < 2; faster++) {
        lode_drive_config_t config = rig_config();
        config.motor.omega_rated_rad_s = 300.0f; // speed control once per round
        config.speed.ramp_rad_s2 = 100.0f;
        config.speed.jerk_rad_s3 = 200.0f;
        lode_drive_tuning_t slow;
        lode_drive_tuning_t fast;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&slow, &config));
        config.speed.every_period = LODE_ON;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&fast, &config));
        TEST_ASSERT_EQUAL_UINT32(LODE_SLOW_PERIODS * fast.speed_periods, slow.speed_periods);
        config.speed.every_period = faster > 0 ? LODE_OFF : LODE_ON;
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        run_up(&rig, 30.0, 8.0);
        rig_command(&rig, run_at(110.0));
        while (rig_telemetry(&rig).speed_ref_rad_s < 70.0f) {
            rig_step(&rig);
        }
        TEST_ASSERT_EQUAL_INT(LODE_OK,
                              lode_drive_post_tuning(&rig.drive, faster > 0 ? &fast : &slow));
        for (int n = 0; n < 200; n++) {
            const double before = (double)rig_telemetry(&rig).speed_ref_rad_s;
            rig_run(&rig, LODE_SLOW_PERIODS * RIG_TS_s);
            const double now = (double)rig_telemetry(&rig).speed_ref_rad_s;
            CHECK_AT_MOST(100.1, (now - before) / (LODE_SLOW_PERIODS * RIG_TS_s));
            CHECK_AT_LEAST(n < 5 ? 95.0 : 0.0, (now - before) / (LODE_SLOW_PERIODS * RIG_TS_s));
            CHECK_AT_MOST(110.0, now);
        }
        rig_run(&rig, 1.0);
        check_running(&rig, 110.0);
    }
}

/// What is called of a drive that has not begun, or whose init has failed, says so; the step is not to be called.
static void test_a_drive_that_has_not_begun(void) {
    lode_drive_t drive;
    memset(&drive, 0, sizeof drive);
    const lode_drive_config_t nothing = {.f_pwm_Hz = 0.0f};
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_F_PWM, lode_drive_init(&drive, &other_tuning, &nothing));
    lode_telemetry_t t;
    TEST_ASSERT_FALSE(lode_drive_telemetry(&drive, &t));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_post_command(&drive, &off));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_begin(NULL, &tuning));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_begin(&drive, NULL));
}

/// An estimate of gates that are off says nothing of a rotor that is driven.
static void test_an_estimate_of_nothing_is_not_taken_over(void) {
    rig_t one = running(80.0, 8.0);
    rig_t two = one;
    const lode_counts_t counts = rig_counts(&one);
    const lode_sample_t first = lode_drive_sense(&one.drive, &counts);
    const lode_sample_t second = lode_drive_sense(&two.drive, &counts);
    lode_estimate_t estimate = lode_drive_estimate(&one.drive, &first);
    (void)lode_drive_act(&one.drive, &first, &estimate);
    estimate = lode_drive_estimate(&two.drive, &second);
    estimate.source = LODE_ESTIMATE_NONE;
    (void)lode_drive_act(&two.drive, &second, &estimate);
    TEST_ASSERT_EQUAL_MEMORY(&one.drive, &two.drive, sizeof one.drive);
}

/// A start has its own states, which a new tuning leaves.
static void test_a_tuning_leaves_a_start_as_it_is(void) {
    rig_t one = fresh();
    rig_command(&one, run_at(80.0));
    TEST_ASSERT_TRUE(reach(&one, LODE_MODE_START, 1.0));
    for (int n = 0; n < 3000 && one.drive.mode == (uint_least8_t)LODE_MODE_START; n++) {
        rig_step(&one);
        if (n % 100 == 0) {
            rig_t two = one;
            rig_t three = one;
            other_tuning = tuning;
            TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&two.drive, &other_tuning));
            rig_step(&two);
            rig_step(&three);
            TEST_ASSERT_EQUAL_MEMORY(&three.drive.state, &two.drive.state, sizeof two.drive.state);
        }
    }
}

/// Where the EMF alone is enough, injection that is taken away is over, and with it the voltage that it kept.
static void test_injection_that_a_tuning_has_not_ends(void) {
    lode_drive_config_t config = rig_config();
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other_tuning, &config));
    config.hfi.mode = LODE_HFI_ON;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(36.0));
    rig_run(&rig, 6.0);
    check_running(&rig, 36.0);
    TEST_ASSERT_TRUE(rig_telemetry(&rig).injected > 0.0f);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &other_tuning));
    rig_step(&rig);
    TEST_ASSERT_FALSE(lode_estimator_injects(&rig.drive.estimator));
    rig_run(&rig, 2.0);
    check_running(&rig, 36.0);
    CHECK_NEAR(0.0, 0.0, rig_telemetry(&rig).injected);
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
        const lode_estimate_t external = {.source = LODE_ESTIMATE_EXTERNAL,
                                          .omega_rad_s = 500.0f,
                                          .rotor = lode_sincos(2.0f),
                                          .i_A = {-1.5f, 2.5f},
                                          .e_V = {-60.0f, 35.0f},
                                          .load_torque_Nm = 1.25f,
                                          .lock = locks[n]};
        lode_mode_adopt(drive, &external);
        const lode_estimate_t own = lode_mode_estimate(drive);
        CHECK_NEAR(1.0e-6, external.rotor.sin, own.rotor.sin);
        CHECK_NEAR(1.0e-6, external.rotor.cos, own.rotor.cos);
        CHECK_NEAR(0.0, external.omega_rad_s, own.omega_rad_s);
        CHECK_NEAR(0.0, external.e_V.alpha, own.e_V.alpha);
        CHECK_NEAR(0.0, external.e_V.beta, own.e_V.beta);
        CHECK_NEAR(1.0e-6, external.load_torque_Nm, own.load_torque_Nm);
        CHECK_NEAR(0.0, external.lock, own.lock);
        CHECK_NEAR(0.0, external.i_A.d, drive->estimator.id_A);
        CHECK_CLOSE(1.0e-6, (double)(ts_s * drive->estimator.pll.f_rad_s2),
                    drive->estimator.pll.rise_rad_s);
        TEST_ASSERT_EQUAL_INT(n > 0, drive->estimator.locked);
        TEST_ASSERT_EQUAL_INT(n > 0, drive->estimator.aligned);
        TEST_ASSERT_EQUAL_UINT(1u, drive->estimator.found);
    }
}

/// Numbers beyond a million, or whose sum is, are no motor's, and neither is a lock beyond one.
static void test_an_estimate_of_no_motor_trips(void) {
    rig_t start = running(60.0, 3.0);
    for (int k = 0; k <= 16; k++) {
        rig_t rig = start;
        lode_estimate_t e = lode_mode_estimate(&rig.drive);
        e.source = LODE_ESTIMATE_EXTERNAL;
        float *const fields[] = {&e.i_A.d,       &e.i_A.q,          &e.rotor.cos, &e.rotor.sin,
                                 &e.omega_rad_s, &e.load_torque_Nm, &e.e_V.alpha, &e.e_V.beta};
        if (k < 8) {
            *fields[k] = -1.0e6f;
        } else if (k < 16) {
            *fields[0] = *fields[k - 8] = k == 8 ? INFINITY : 3.0e38f; // the sum is infinite
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

/// The observer's lag is known up to that speed only.
static void test_an_estimate_beyond_all_speed_trips_at_once(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = running(60.0, 3.0);
        const float limit = rig.drive.tuning->estimator.omega_limit;
        const float told[] = {limit, nextafterf(limit, INFINITY), 9.0e5f};
        for (int k = 0; k < COUNT_OF(told); k++) {
            rig_t now = rig;
            const lode_counts_t counts = rig_counts(&now);
            const lode_sample_t m = lode_drive_sense(&now.drive, &counts);
            lode_estimate_t e = lode_drive_estimate(&now.drive, &m);
            e.source = LODE_ESTIMATE_EXTERNAL;
            e.omega_rad_s = told[k] * (float)sign;
            now.out = lode_drive_act(&now.drive, &m, &e);
            const lode_telemetry_t t = rig_telemetry(&now);
            TEST_ASSERT_TRUE(lode_is_finite(t.emf_error_rad) && lode_is_finite(t.theta_rad));
            TEST_ASSERT_EQUAL_INT(k == 0, now.out.gates);
            if (k > 0) {
                TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_SPEED, t.fault.check);
                CHECK_NEAR(0.0, (double)told[k] * sign, t.fault.measured);
                CHECK_NEAR(0.0, (double)limit, t.fault.limit);
            }
        }
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

/// A sensor's count that is wrong for a moment: the speed counts as the limit, and the guard counts.
static void test_a_sensor_beyond_all_speed_counts_as_the_limit(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = running(60.0, 3.0);
        const lode_counts_t counts = rig_counts(&rig);
        const lode_sample_t m = lode_drive_sense(&rig.drive, &counts);
        lode_estimate_t e = lode_drive_estimate(&rig.drive, &m);
        e.source = LODE_ESTIMATE_SENSOR;
        e.omega_rad_s = 9.0e5f * (float)sign;
        rig.out = lode_drive_act(&rig.drive, &m, &e);
        const lode_telemetry_t t = rig_telemetry(&rig);
        TEST_ASSERT_TRUE(rig.out.gates);
        TEST_ASSERT_TRUE(lode_is_finite(t.emf_error_rad) && lode_is_finite(t.theta_rad));
        CHECK_NEAR(1.0, (double)rig.drive.tuning->estimator.omega_limit * sign, t.omega_rad_s);
    }
}

static void test_a_voltage_that_is_none_trips_in_the_same_call(void) {
    // With a bus that the host made up, the EMF of a speed that the bus does not allow asks for a voltage that is no duty.
    rig_t rig = running(60.0, 3.0);
    const lode_counts_t counts = rig_counts(&rig);
    lode_sample_t m = lode_drive_sense(&rig.drive, &counts);
    lode_estimate_t e = lode_drive_estimate(&rig.drive, &m);
    m.v_bus_V = 1.0e7f;
    e.source = LODE_ESTIMATE_EXTERNAL;
    e.omega_rad_s = rig.drive.tuning->estimator.omega_limit;
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
        e.omega_rad_s = rig.drive.tuning->estimator.omega_limit;
        rig.out = lode_drive_act(&rig.drive, &m, &e);
        TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.a, 0.0f, 1.0f));
        TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.b, 0.0f, 1.0f));
        TEST_ASSERT_TRUE(lode_in_range(rig.out.duty.c, 0.0f, 1.0f));
        periods++;
    } while (rig.out.gates && periods < 100);
    CHECK_AT_MOST(LODE_SLOW_PERIODS, periods); // two looks of the slow checks
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_VOLTAGE, rig_telemetry(&rig).fault.check);
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
            rig_command(&rig, clear); // with the next one, which comes before it is taken
            rig_command(&rig,
                        (lode_command_t){.mode = modes[random_bits(&random) % 5u],
                                         .speed_rad_s = random_float(&random, -300.0, 300.0),
                                         .vector = {random_float(&random, -50.0, 50.0), 3.0f},
                                         .omega_rad_s = random_float(&random, -2.0e3, 2.0e3)});
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

static void test_the_temperature_is_reported_in_every_mode(void) {
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
    RUN_TEST(test_another_command_begins_from_off);
    RUN_TEST(test_low_sides_are_guarded);
    RUN_TEST(test_low_sides_are_on_for_the_sampling_window);
    RUN_TEST(test_voltage_vector_at_an_angle);
    RUN_TEST(test_turning_voltage_is_ahead_by_one_and_a_half_periods);
    RUN_TEST(test_the_frame_stands_at_its_angle_when_the_mode_is_entered);
    RUN_TEST(test_voltage_stays_in_the_circle);
    RUN_TEST(test_current_vector_at_an_angle);
    RUN_TEST(test_current_command_is_limited);
    RUN_TEST(test_bad_commands_are_refused_and_change_nothing);
    RUN_TEST(test_the_largest_speed_is_allowed);
    RUN_TEST(test_a_command_meets_the_limits_of_the_tuning_that_comes_with_it);
    RUN_TEST(test_a_corrupted_command_is_not_made_whole_by_a_limit);
    RUN_TEST(test_a_speed_that_cannot_be_had_is_refused);
    RUN_TEST(test_commands_wait_for_the_next_period_and_the_last_counts);
    RUN_TEST(test_a_command_that_comes_within_a_period_waits_for_the_next);
    RUN_TEST(test_huge_commands_give_duties);
    RUN_TEST(test_the_same_tuning_changes_nothing);
    RUN_TEST(test_a_new_tuning_is_taken_at_a_period);
    RUN_TEST(test_another_observer_goes_on_with_the_rotor);
    RUN_TEST(test_the_same_observer_with_other_parameters_goes_on_with_the_rotor);
    RUN_TEST(test_a_filtered_speed_outlives_its_tuning);
    RUN_TEST(test_what_was_measured_counts_from_the_new_tuning);
    RUN_TEST(test_a_command_beyond_a_new_limit_is_bounded);
    RUN_TEST(test_a_rotor_beyond_a_new_limit);
    RUN_TEST(test_optimal_references_begin_with_the_present_current);
    RUN_TEST(test_a_ramp_without_jerk_leaves_none);
    RUN_TEST(test_a_slope_goes_on_at_another_rate);
    RUN_TEST(test_a_drive_that_has_not_begun);
    RUN_TEST(test_an_estimate_of_nothing_is_not_taken_over);
    RUN_TEST(test_a_tuning_leaves_a_start_as_it_is);
    RUN_TEST(test_injection_that_a_tuning_has_not_ends);
    RUN_TEST(test_a_tuning_that_samples_all_phases_watches_all);
    RUN_TEST(test_a_tuning_with_windows_leaves_out_what_is_not_sampled);
    RUN_TEST(test_a_refused_tuning_leaves_the_one_that_waits);
    RUN_TEST(test_a_bus_that_jumps_is_divided_by_at_once);
    RUN_TEST(test_a_bus_without_reading_stays_in_range);
    RUN_TEST(test_an_estimate_that_is_no_number_trips_in_the_same_call);
    RUN_TEST(test_an_estimate_that_is_taken_over_is_the_own_one);
    RUN_TEST(test_an_estimate_of_no_motor_trips);
    RUN_TEST(test_an_estimate_beyond_all_speed_trips_at_once);
    RUN_TEST(test_a_sensor_beyond_all_speed_counts_as_the_limit);
    RUN_TEST(test_an_estimate_of_the_hosts_own_is_taken_over);
    RUN_TEST(test_the_lock_of_an_external_estimate_counts);
    RUN_TEST(test_a_voltage_that_is_none_trips_in_the_same_call);
    RUN_TEST(test_a_bus_and_a_speed_of_no_motor_stay_in_range_and_trip);
    RUN_TEST(test_the_step_is_three_calls_in_a_row);
    RUN_TEST(test_two_drives_share_nothing);
    RUN_TEST(test_any_counts_give_duties_on_the_grid);
    RUN_TEST(test_telemetry_is_what_was_put_out);
    RUN_TEST(test_the_temperature_is_reported_in_every_mode);
    RUN_TEST(test_telemetry_of_speed_control_is_nothing_without_it);
    RUN_TEST(test_telemetry_tells_the_position_error_by_the_emf);
    RUN_TEST(test_telemetry_tells_the_position_error_by_injection);
    RUN_TEST(test_names_of_modes);
    return UNITY_END();
}
