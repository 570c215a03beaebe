// Current sensors that all come to show another share of the current at once (K38).
#include "support/check.h"
#include "support/drive_cases.h"

#include "plausibility_inline.h"

#include <float.h>

void setUp(void) {}

void tearDown(void) {}

// --- The checks ------------------------------------------------------------------------------------

static lode_ab_t vector(double length, double angle) {
    return (lode_ab_t){(float)(length * cos(angle)), (float)(length * sin(angle))};
}

/// In a period in which a whole turn has told enough.
static double waited(lode_jump_t *jump) {
    return (double)lode_jump_wait(jump, 6.3f, true);
}

/// The factor that stays; below 0: none does. `size`: of the next sample, squared; 0: it is not looked at.
static double factor_of(lode_ab_t i_A, lode_ab_t expected_A, double size, bool starts) {
    lode_jump_t jump = {.stage = (uint_least8_t)LODE_JUMP_NONE};
    if (!lode_jump_check(&jump, i_A, expected_A, 9.0f, starts)) {
        TEST_ASSERT_EQUAL_UINT(LODE_JUMP_NONE, jump.stage);
        return -1.0;
    }
    TEST_ASSERT_TRUE(waited(&jump) < 0.0); // the same period
    if (size >= 1.0) {
        (void)lode_jump_check(&jump, expected_A, i_A, (float)size, starts);
    }
    return waited(&jump);
}

static void test_a_factor_that_stays_is_found(void) {
    const double factors[] = {0.15, 0.3, 0.5, 0.7, 0.74, 1.26, 1.5, 2.5};
    for (int k = 0; k < COUNT_OF(factors); k++) {
        for (double angle = -3.0; angle < 3.2; angle += 0.7) {
            const lode_ab_t expected_A = vector(5.0, angle);
            const lode_ab_t i_A = vector(5.0 * factors[k], angle + 0.09);
            CHECK_NEAR(1.0 / 60.0, factors[k], factor_of(i_A, expected_A, 0.0, false));
            const bool less = factors[k] < 1.0;
            CHECK_NEAR(1.0 / 60.0, less ? factors[k] : -1.0, factor_of(i_A, expected_A, 0.0, true));
        }
    }
    for (int starts = 0; starts <= 1;
         starts++) { // and both bounds themselves, of small currents too
        const lode_ab_t four_A = {0.0f, 0.25f};
        CHECK_NEAR(1.0e-6, 0.75, factor_of((lode_ab_t){0.0f, 0.1875f}, four_A, 0.0, starts > 0));
        CHECK_NEAR(1.0e-6, starts > 0 ? -1.0 : 1.25,
                   factor_of((lode_ab_t){0.0f, 0.3125f}, four_A, 0.0, starts > 0));
    }
    const lode_ab_t expected_A = vector(5.0, 1.0); // the largest that is told
    CHECK_NEAR(1.0e-6, 255.0 / 64.0, factor_of(vector(50.0, 1.0), expected_A, 0.0, false));
}

static void test_what_is_no_factor(void) {
    const lode_ab_t expected_A = vector(5.0, 2.0);
    for (int starts = 0; starts <= 1; starts++) {
        const lode_ab_t others[] = {
            vector(5.0 * 0.76, 2.0),
            vector(5.0 * 1.24, 2.0), // near enough
            vector(2.5, 2.0 + 0.11),
            vector(2.5, 2.0 - 0.11),     // turned, as of an open phase
            vector(2.5, 2.0 + CHECK_PI), // back to front
            {NAN, 1.0f},
        };
        for (int k = 0; k < COUNT_OF(others); k++) {
            TEST_ASSERT_TRUE(factor_of(others[k], expected_A, 0.0, starts > 0) < 0.0);
        }
        TEST_ASSERT_TRUE(factor_of(vector(2.5, 2.0), (lode_ab_t){NAN, 0.0f}, 0.0, starts > 0) <
                         0.0);
        TEST_ASSERT_TRUE(factor_of(vector(2.5, 2.0), vector(0.0, 0.0), 0.0, starts > 0) < 0.0);
        TEST_ASSERT_TRUE(factor_of(vector(0.0, 0.0), vector(0.0, 0.0), 0.0, starts > 0) < 0.0);
        // Gone, whichever way what is left of it points.
        CHECK_NEAR(0.0, 0.0, factor_of(vector(0.49, -1.0), expected_A, 0.0, starts > 0));
        TEST_ASSERT_TRUE(factor_of(vector(0.51, -1.0), expected_A, 0.0, starts > 0) < 0.0);
    }
}

/// One that goes back by half of it or more is none; and until 64 periods later nothing is.
static void test_one_sample_is_no_factor(void) {
    const lode_ab_t expected_A = vector(5.0, 1.0);
    const lode_ab_t i_A = vector(2.0, 1.0);
    CHECK_NEAR(0.02, 0.4, factor_of(i_A, expected_A, 2.2, false)); // a quarter of 9 is 2.25
    TEST_ASSERT_TRUE(factor_of(i_A, expected_A, 2.25, false) < 0.0);
    lode_jump_t jump = {.stage = (uint_least8_t)LODE_JUMP_NONE};
    TEST_ASSERT_TRUE(lode_jump_check(&jump, i_A, expected_A, 9.0f, false));
    TEST_ASSERT_FALSE(lode_jump_check(&jump, i_A, expected_A, 9.0f, false)); // in the same period
    (void)waited(&jump);
    TEST_ASSERT_TRUE(lode_jump_check(&jump, expected_A, i_A, 9.0f, false)); // tells nothing either
    int rests = 0;
    while (jump.stage != (uint_least8_t)LODE_JUMP_NONE && rests < 1000) {
        TEST_ASSERT_TRUE(waited(&jump) < 0.0);
        rests++;
        TEST_ASSERT_TRUE(jump.stage == (uint_least8_t)LODE_JUMP_NONE ||
                         !lode_jump_check(&jump, i_A, expected_A, 9.0f, false));
    }
    TEST_ASSERT_EQUAL_INT(62, rests);
    TEST_ASSERT_TRUE(lode_jump_check(&jump, i_A, expected_A, 9.0f, false));
}

/// Periods until a current that is gone counts as one, at `turn_rad` in each, or comes back with `back` of them; 0: it does not
/// count.
static int periods_until_gone(double turn_rad, int back) {
    lode_jump_t jump = {.stage = (uint_least8_t)LODE_JUMP_NONE};
    TEST_ASSERT_TRUE(lode_jump_check(&jump, vector(0.1, 2.0), vector(5.0, -1.0), 9.0f, false));
    int periods = 0;
    (void)lode_jump_wait(&jump, (float)turn_rad, true); // its own
    while (jump.stage != (uint_least8_t)LODE_JUMP_NONE && periods < 1000) {
        periods++;
        if (lode_jump_wait(&jump, (float)turn_rad, periods != back) >= 0.0f) {
            return periods;
        }
    }
    TEST_ASSERT_EQUAL_UINT(LODE_JUMP_NONE, jump.stage); // and checks again
    return 0;
}

/// By 20 degrees.
static void test_a_current_is_gone_once_it_should_have_come_back(void) {
    TEST_ASSERT_EQUAL_INT(1, periods_until_gone(0.36, 0));
    TEST_ASSERT_EQUAL_INT(2, periods_until_gone(0.34, 0));
    TEST_ASSERT_EQUAL_INT(8, periods_until_gone(0.35 / 7.5, 0));
    TEST_ASSERT_EQUAL_INT(0, periods_until_gone(0.35 / 7.5, 8));
    TEST_ASSERT_EQUAL_INT(8, periods_until_gone(0.35 / 7.5, 9));
    TEST_ASSERT_EQUAL_INT(127, periods_until_gone(0.35 / 126.5, 0));
    TEST_ASSERT_EQUAL_INT(0, periods_until_gone(0.35 / 127.5, 0));
}

static void test_how_much_is_looked_at(void) {
    lode_plausibility_tuning_t of;
    lode_guard_config_t config = {.plausibility = LODE_ON, .check_gain = LODE_ON};
    lode_plausibility_tune_voltages(&of, &config, 12.0f, 400.0f, 5.0f);
    CHECK_CLOSE(1.0e-6, 20.0 * 20.0, of.jump_V2); // 0.05 of i_max
    CHECK_NEAR(0.0, 5.0, of.taken_V);
    CHECK_CLOSE(1.0e-6, 3.6 * 3.6, of.off_A2); // 0.3 of i_max
    lode_plausibility_tune_voltages(&of, &config, 12.0f, 10.0f, 5.0f);
    CHECK_CLOSE(1.0e-6, 6.0 * 6.0, of.off_A2); // 5 V may move it by half of i_max
    config.plausibility = LODE_OFF;
    lode_plausibility_tune_voltages(&of, &config, 12.0f, 400.0f, 5.0f);
    TEST_ASSERT_TRUE(of.jump_V2 >= FLT_MAX);
    TEST_ASSERT_TRUE(of.off_A2 >= FLT_MAX);
    config = (lode_guard_config_t){.plausibility = LODE_ON, .check_gain = LODE_OFF};
    lode_plausibility_tune_voltages(&of, &config, 12.0f, 400.0f, 5.0f);
    TEST_ASSERT_TRUE(of.jump_V2 >= FLT_MAX);
}

// --- The drive ------------------------------------------------------------------------------------

/// Steps with ADC channels that show `gain` of the currents, for `periods`, or until the gates go off; the largest true current.
static int steps_with_gain(rig_t *rig, double gain, int periods, double *most_A) {
    int n = 0;
    for (; n < periods && rig->out.gates; n++) {
        rig->stamp += 1000u;
        lode_counts_t counts = rig_counts(rig);
        for (int k = 0; k < LODE_PHASES; k++) {
            counts.i[k] = rig_count(2048.0 + gain * ((double)counts.i[k] - 2048.0));
        }
        rig->out = lode_drive_step(&rig->drive, &counts);
        rig_move(rig);
        *most_A = fmax(*most_A, (double)lode_ab_length(ipmsm_current(&rig->motor)));
    }
    return n;
}

/// Of four uniform deviates.
static double noise(random_t *random, double sigma) {
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        sum += random_between(random, -1.0, 1.0);
    }
    return sigma * sqrt(0.75) * sum;
}

/// Steps with noise of `sigma_A` in each phase, for `periods` or until the gates go off. `measured`: or as if there were none.
static int steps_with_noise(rig_t *rig, random_t *random, double sigma_A, int periods,
                            bool measured) {
    int n = 0;
    for (; n < periods && rig->out.gates; n++) {
        rig->stamp += 1000u;
        lode_counts_t counts = rig_counts(rig);
        for (int k = 0; k < LODE_PHASES; k++) {
            counts.i[k] = rig_count((double)counts.i[k] + noise(random, sigma_A / RIG_GAIN_A));
        }
        if (!measured) {
            rig->drive.jump.noise_V2 = 0.0f;
        }
        rig->out = lode_drive_step(&rig->drive, &counts);
        rig_move(rig);
    }
    return n;
}

static rig_t loaded(double speed, double load_Nm) {
    lode_drive_config_t config = rig_config();
    config.motor.omega_rated_rad_s = 300.0f; // speed control in its slot is enough
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig.load_Nm = load_Nm;
    run_up(&rig, speed, 8.0);
    rig_run(&rig, 1.0);
    TEST_ASSERT_TRUE(rig.drive.steady);
    return rig;
}

/// With the next sample, from any instant of a turn, and the current is still what it was.
static void test_gains_that_change_at_once_trip_in_run(void) {
    const double gains[] = {0.3, 0.4, 0.5, 0.6, 1.5, 2.0};
    const double speeds[] = {40.0, 100.0, -100.0};
    for (int s = 0; s < COUNT_OF(speeds); s++) {
        rig_t before = loaded(speeds[s], 3.0);
        for (int instant = 0; instant < 35; instant++) {
            rig_run(&before, 3.0 * RIG_TS_s);
            for (int k = 0; k < COUNT_OF(gains); k++) {
                rig_t rig = before;
                double most_A = (double)lode_ab_length(ipmsm_current(&rig.motor));
                const double was_A = most_A;
                TEST_ASSERT_EQUAL_INT(2, steps_with_gain(&rig, gains[k], 100, &most_A));
                const lode_fault_t fault = rig_telemetry(&rig).fault;
                TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_GAIN",
                                         lode_check_name((lode_check_t)fault.check));
                CHECK_NEAR(0.06 * gains[k], gains[k], fault.measured);
                CHECK_NEAR(0.0, 1.0, fault.limit);
                CHECK_AT_MOST(1.25 * was_A, most_A);
            }
        }
    }
}

/// Without noise too, and before it is large.
static void test_currents_that_are_gone_trip_in_run(void) {
    const double speeds[] = {60.0, 100.0, -100.0};
    for (int s = 0; s < COUNT_OF(speeds); s++) {
        rig_t before = loaded(speeds[s], 3.0);
        for (int instant = 0; instant < 35; instant++) {
            rig_run(&before, 3.0 * RIG_TS_s);
            rig_t rig = before;
            double most_A = 0.0;
            const double step_rad = fabs(speeds[s]) * 3.0 * RIG_TS_s;
            const int periods = steps_with_gain(&rig, 0.0, 100, &most_A);
            // What the estimator makes of no current moves its speed.
            CHECK_NEAR(1.0 + 0.35 * 0.35 / step_rad, 1.5 + 0.35 / step_rad, periods);
            const lode_fault_t fault = rig_telemetry(&rig).fault;
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_STUCK",
                                     lode_check_name((lode_check_t)fault.check));
            CHECK_AT_MOST(s == 0 ? 15.0 : 12.0, most_A); // of 12
            rig_t back = before;                         // a part of it is: a phase has opened
            TEST_ASSERT_EQUAL_INT(2, steps_with_gain(&back, 0.0, 2, &most_A));
            TEST_ASSERT_EQUAL_INT(periods, steps_with_gain(&back, 0.3, periods, &most_A));
        }
    }
}

/// Neither a fault nor an EMF that is off: the estimator leaves it out, of a salient rotor too.
static void test_one_bad_sample_of_all_currents_is_let_pass(void) {
    rig_t before = loaded(100.0, 3.0);
    TEST_ASSERT_TRUE(before.drive.tuning->estimator.emf.salient_Ohm < -1.0f);
    const double gains[] = {0.4, 2.0};
    for (int instant = 0; instant < 35; instant++) {
        rig_run(&before, 3.0 * RIG_TS_s);
        rig_t sound = before;
        double most_A = 0.0;
        (void)steps_with_gain(&sound, 1.0, 1, &most_A);
        const lode_ab_t e_V = sound.drive.estimator.emf.observer.e_V;
        for (int k = 0; k < COUNT_OF(gains); k++) {
            rig_t rig = before;
            (void)steps_with_gain(&rig, gains[k], 1, &most_A);
            const lode_ab_t seen_V = rig.drive.estimator.emf.observer.e_V;
            const double E_V = (double)lode_ab_length(e_V);
            CHECK_NEAR(0.03 * E_V, (double)e_V.alpha, seen_V.alpha);
            CHECK_NEAR(0.03 * E_V, (double)e_V.beta, seen_V.beta);
            double worst = 0.0;
            for (int n = 0; n < 200; n++) {
                rig_step(&rig);
                worst = fmax(worst, fabs(rig.angle_error));
            }
            rig_expect(&rig, LODE_MODE_RUN);
            CHECK_AT_MOST(fabs(before.angle_error) + 1.5 * CHECK_DEG, worst);
            TEST_ASSERT_TRUE(rig.drive.steady);
        }
        rig_t gone = before; // that may be of an open phase
        (void)steps_with_gain(&gone, 0.0, 1, &most_A);
        rig_run(&gone, 0.02);
        rig_expect(&gone, LODE_MODE_RUN);
    }
}

/// Where there is just enough of it to be looked at, too.
static void test_one_bad_sample_of_little_current_is_let_pass(void) {
    rig_t before = loaded(100.0, 1.6);
    random_t random = random_seed(3u);
    int looked = 0;
    for (int instant = 0; instant < 400; instant++) {
        TEST_ASSERT_EQUAL_INT(3, steps_with_noise(&before, &random, 0.015, 3, true));
        rig_t rig = before;
        double most_A = 0.0;
        (void)steps_with_gain(&rig, random_between(&random, 0.6, 0.74), 1, &most_A);
        looked += rig.drive.jump.stage != (uint_least8_t)LODE_JUMP_NONE ? 1 : 0;
        (void)steps_with_noise(&rig, &random, 0.015, 100, true);
        rig_expect(&rig, LODE_MODE_RUN);
    }
    CHECK_AT_LEAST(50.0, (double)looked);
}

/// A bus that is another than the one that is read acts in all periods.
static void test_a_voltage_that_nobody_knows_of_is_no_gain(void) {
    rig_t before = loaded(100.0, 3.0);
    for (int instant = 0; instant < 35; instant++) {
        rig_run(&before, 3.0 * RIG_TS_s);
        for (int back = 0; back <= 1; back++) {
            rig_t rig = before;
            for (int n = 0; n < 100 && rig.out.gates; n++) {
                lode_counts_t counts = rig_counts(&rig);
                rig.stamp += 1000u;
                counts.v_bus = rig_count((back > 0 ? 1.3 : 0.75) * (double)counts.v_bus);
                rig.out = lode_drive_step(&rig.drive, &counts);
                rig_move(&rig);
            }
            TEST_ASSERT_TRUE(rig_telemetry(&rig).fault.check != LODE_CHECK_CURRENT_GAIN);
        }
    }
}

/// Whether a jump to 0.4 of the current is one, as noted by hand: by the voltage that would do it, over what voltage and EMF do.
static bool is_noted(lode_drive_t drive, double expected_A, double by_voltage_A) {
    const lode_emf_tuning_t *emf = &drive.tuning->estimator.emf;
    const float jump_A = (float)(-0.6 * expected_A);
    const lode_ab_t i_A = {(float)(0.4 * expected_A), 0.0f};
    drive.estimator.pll.omega_rad_s = 0.0f;
    drive.estimator.emf.i_A = (lode_ab_t){(float)(expected_A - by_voltage_A), 0.0f};
    return lode_drive_note_jump(&drive, i_A, (lode_ab_t){-jump_A * emf->inv_b, 0.0f});
}

/// Not with a lock that is lost, in another mode, while a start looks for a rotor, with a wave, nor off.
static void test_what_is_not_judged_by_a_gain(void) {
    const rig_t before = loaded(100.0, 3.0);
    double most_A = 0.0;
    rig_t lost = before;
    lost.drive.estimator.lock = 0.69f;
    TEST_ASSERT_TRUE(steps_with_gain(&lost, 0.4, 3, &most_A) == 3 && lost.out.gates);
    rig_t held = before;
    held.drive.estimator.lock = LODE_LOCK_HANDOVER;
    TEST_ASSERT_EQUAL_INT(2, steps_with_gain(&held, 0.4, 3, &most_A));
    lode_drive_tuning_t without = *before.drive.tuning;
    without.plausibility.jump_V2 = FLT_MAX;
    rig_t off_ = before;
    off_.drive.tuning = &without;
    TEST_ASSERT_TRUE(steps_with_gain(&off_, 0.4, 3, &most_A) == 3 && off_.out.gates);

    lode_drive_t drive = before.drive;
    TEST_ASSERT_TRUE(is_noted(drive, 8.0, 0.0));
    drive.estimator.by.hfi.active = true;
    TEST_ASSERT_FALSE(is_noted(drive, 8.0, 0.0));
    drive = before.drive;
    const lode_mode_t modes[] = {LODE_MODE_OFF, LODE_MODE_VOLTAGE, LODE_MODE_CURRENT,
                                 LODE_MODE_CALIBRATE};
    for (int k = 0; k < COUNT_OF(modes); k++) {
        drive.mode = (uint_least8_t)modes[k];
        TEST_ASSERT_FALSE(is_noted(drive, 8.0, 0.0));
    }
    drive.mode = (uint_least8_t)LODE_MODE_START;
    drive.state.start.stage = (uint_least8_t)LODE_START_CATCH;
    TEST_ASSERT_FALSE(is_noted(drive, 8.0, 0.0));
    drive.state.start.stage = (uint_least8_t)LODE_START_TURN;
    TEST_ASSERT_TRUE(is_noted(drive, 8.0, 0.0));
}

/// The observer's last current, by b/a, and that of the d axis.
static void test_a_jump_is_taken_out_of_the_last_current(void) {
    lode_drive_t drive = loaded(100.0, 3.0).drive;
    const lode_emf_tuning_t *emf = &drive.tuning->estimator.emf;
    const lode_sincos_t rotor = lode_estimator_rotor(&drive.estimator);
    const lode_ab_t jump_A = {-1.5f * rotor.cos + 2.0f * rotor.sin,
                              -1.5f * rotor.sin - 2.0f * rotor.cos};
    const lode_ab_t i_A = lode_ab_scale(-1.0f, jump_A); // half of what it was
    const lode_ab_t last_A = lode_ab_scale(-2.0f, jump_A);
    const float id_A = drive.estimator.id_A;
    drive.estimator.emf.i_A = last_A;
    TEST_ASSERT_TRUE(lode_drive_note_jump(&drive, i_A, lode_ab_scale(-emf->inv_b, jump_A)));
    TEST_ASSERT_FALSE(drive.steady);
    CHECK_NEAR(1.0e-5, (double)id_A - 1.5, drive.estimator.id_A);
    const double share = (double)(emf->inv_b / emf->a_over_b);
    CHECK_NEAR(1.0e-5, (double)last_A.alpha + share * (double)jump_A.alpha,
               drive.estimator.emf.i_A.alpha);
    CHECK_NEAR(1.0e-5, (double)last_A.beta + share * (double)jump_A.beta,
               drive.estimator.emf.i_A.beta);
}

/// 0.05 of i_max of 12 A; and 2.5 times what the voltage does through the smaller inductance.
static void test_how_far_a_current_jumps(void) {
    lode_drive_t drive = loaded(100.0, 3.0).drive;
    const lode_emf_tuning_t *emf = &drive.tuning->estimator.emf;
    TEST_ASSERT_FALSE(is_noted(drive, 0.59 / 0.6, 0.0));
    TEST_ASSERT_TRUE(is_noted(drive, 0.61 / 0.6, 0.0));
    const double Ld_per_Lq = 1.0 + (double)(emf->salient_Ohm / emf->inv_b);
    CHECK_AT_MOST(0.8, Ld_per_Lq);
    const double most_A = 0.6 * 8.0 * Ld_per_Lq / 2.5;
    for (int sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_TRUE(is_noted(drive, 8.0, sign * 0.99 * most_A));
        TEST_ASSERT_FALSE(is_noted(drive, 8.0, sign * 1.01 * most_A));
    }
    lode_drive_tuning_t tuned = *drive.tuning; // a current that dead time may drive in a period
    drive.tuning = &tuned;
    tuned.plausibility.taken_V = 2.0f * emf->inv_b;
    TEST_ASSERT_FALSE(is_noted(drive, 3.99, 0.0));
    TEST_ASSERT_TRUE(is_noted(drive, 4.01, 0.0));
    tuned.plausibility.taken_V = 0.0f;
    drive.mode = (uint_least8_t)LODE_MODE_START;
    drive.state.start.stage = (uint_least8_t)LODE_START_TURN;
    TEST_ASSERT_FALSE(is_noted(drive, 0.59 / 0.6, 0.0));
    TEST_ASSERT_TRUE(is_noted(drive, 0.61 / 0.6, 0.0));
}

// --- Noise (K39) ----------------------------------------------------------------------------------

/// A 32nd each time.
static void test_noise_is_a_mean_square(void) {
    lode_jump_t jump = {.change_V2 = 100.0f};
    lode_jump_note_noise(&jump);
    CHECK_NEAR(1.0e-6, 3.125, jump.noise_V2);
    for (int n = 1; n < 64; n++) {
        lode_jump_note_noise(&jump);
    }
    CHECK_NEAR(1.0e-3, 100.0 * (1.0 - pow(31.0 / 32.0, 64.0)), jump.noise_V2);
}

/// The squares of the three samples of a difference: 8 of those of a phase.
static void test_noise_is_measured(void) {
    rig_t rig = loaded(100.0, 3.0);
    random_t random = random_seed(39u);
    const double inv_b = (double)tuning.estimator.emf.inv_b;
    double sum_A2 = 0.0;
    const int times = 40;
    for (int k = 0; k < times; k++) {
        TEST_ASSERT_EQUAL_INT(256, steps_with_noise(&rig, &random, 0.1, 256, true));
        sum_A2 += (double)rig.drive.jump.noise_V2 / (inv_b * inv_b);
    }
    CHECK_CLOSE(0.15, 8.0 * 0.1 * 0.1, sum_A2 / times);
}

/// Another start begins without it, and without a jump that was under way.
static void test_noise_is_forgotten_with_the_gates(void) {
    rig_t rig = loaded(100.0, 3.0);
    random_t random = random_seed(5u);
    (void)steps_with_noise(&rig, &random, 0.3, 500, true);
    CHECK_AT_LEAST(1.0, (double)rig.drive.jump.noise_V2);
    rig.drive.jump.stage = (uint_least8_t)LODE_JUMP_RESTS;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF});
    rig_run(&rig, 3.0);
    rig_expect(&rig, LODE_MODE_OFF);
    rig.drive.jump.stage = (uint_least8_t)LODE_JUMP_RESTS;
    rig_command(&rig, run_at(30.0));
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 1.0));
    CHECK_NEAR(0.0, 0.0, rig.drive.jump.noise_V2);
    TEST_ASSERT_EQUAL_UINT(LODE_JUMP_NONE, rig.drive.jump.stage);
}

/// 5 % of i_max; where it was not known, it passed for a gain.
static void test_noise_is_no_gain(void) {
    rig_t before = loaded(100.0, 1.0);
    for (uint64_t seed = 1u; seed <= 3u; seed++) {
        random_t random = random_seed(seed);
        rig_t rig = before;
        (void)steps_with_noise(&rig, &random, 0.12, 1000, true); // as it comes up
        TEST_ASSERT_EQUAL_INT(20000, steps_with_noise(&rig, &random, 0.6, 20000, true));
        rig_expect(&rig, LODE_MODE_RUN);
        rig_t untold = before;
        random = random_seed(seed);
        CHECK_AT_MOST(19999, steps_with_noise(&untold, &random, 0.6, 20000, false));
    }
}

/// Nor that one falls in a start, where (S43) looks at smaller currents.
static void test_noise_does_not_end_a_start(void) {
    int ended = 0;
    for (uint64_t seed = 1u; seed <= 12u; seed++) {
        for (int measured = 0; measured <= 1; measured++) {
            random_t random = random_seed(seed);
            rig_t rig = fresh();
            rig_command(&rig, run_at(40.0));
            TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_START, 1.0));
            rig_step(&rig); // the gates come on
            (void)steps_with_noise(&rig, &random, 0.3, 20000, measured > 0);
            TEST_ASSERT_TRUE(measured == 0 || rig.out.gates);
            ended += measured == 0 && !rig.out.gates ? 1 : 0;
        }
    }
    CHECK_AT_LEAST(1, ended);
}

/// Of what stands out of it.
static void test_gains_are_found_in_noise(void) {
    rig_t before = loaded(100.0, 4.5);
    random_t random = random_seed(7u);
    TEST_ASSERT_EQUAL_INT(2000, steps_with_noise(&before, &random, 0.12, 2000, true));
    double most_A = 0.0;
    TEST_ASSERT_EQUAL_INT(2, steps_with_gain(&before, 0.4, 100, &most_A));
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_GAIN",
                             lode_check_name((lode_check_t)rig_telemetry(&before).fault.check));
    // Five times the root of the mean square, to a hair.
    lode_drive_t drive = loaded(100.0, 3.0).drive;
    const double inv_b = (double)tuning.estimator.emf.inv_b;
    drive.jump.noise_V2 = (float)(inv_b * inv_b * 0.16);
    TEST_ASSERT_FALSE(is_noted(drive, 1.99 / 0.6, 0.0));
    TEST_ASSERT_TRUE(is_noted(drive, 2.01 / 0.6, 0.0));
}

// --------------------------------------------------------------------------------------------------

/// The vector of a start; with sensors that show nothing all ADC channels are stuck.
static void test_gains_that_change_at_once_end_a_start(void) {
    const lode_start_stage_t stages[] = {LODE_START_FULL, LODE_START_TURN};
    const double gains[] = {0.0, 0.02, 0.3, 0.5};
    for (int s = 0; s < COUNT_OF(stages); s++) {
        rig_t before = fresh();
        rig_command(&before, run_at(30.0));
        TEST_ASSERT_TRUE(reach(&before, LODE_MODE_START, 1.0));
        for (int n = 0; n < 20000 && rig_telemetry(&before).start_stage != stages[s]; n++) {
            rig_step(&before);
        }
        rig_run(&before, 0.05);
        TEST_ASSERT_EQUAL_INT(stages[s], rig_telemetry(&before).start_stage);
        for (int instant = 0; instant < 16; instant++) {
            rig_step(&before);
            for (int k = 0; k < COUNT_OF(gains); k++) {
                rig_t rig = before;
                double most_A = 0.0;
                const double was_A = (double)lode_ab_length(ipmsm_current(&rig.motor));
                TEST_ASSERT_EQUAL_INT(2, steps_with_gain(&rig, gains[k], 100, &most_A));
                const char *expected =
                    gains[k] < 0.1 ? "LODE_CHECK_CURRENT_STUCK" : "LODE_CHECK_CURRENT_GAIN";
                const lode_fault_t fault = rig_telemetry(&rig).fault;
                TEST_ASSERT_EQUAL_STRING(expected, lode_check_name((lode_check_t)fault.check));
                CHECK_NEAR(0.0, gains[k] < 0.1 ? 0.0 : 1.0, fault.limit);
                CHECK_NEAR(0.05, gains[k] < 0.1 ? 0.0 : gains[k], fault.measured);
                CHECK_AT_MOST(1.25 * was_A, most_A);
            }
            rig_t more = before;
            double most_A = 0.0;
            TEST_ASSERT_EQUAL_INT(20, steps_with_gain(&more, 1.6, 20, &most_A));
        }
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_factor_that_stays_is_found);
    RUN_TEST(test_what_is_no_factor);
    RUN_TEST(test_one_sample_is_no_factor);
    RUN_TEST(test_a_current_is_gone_once_it_should_have_come_back);
    RUN_TEST(test_how_much_is_looked_at);
    RUN_TEST(test_gains_that_change_at_once_trip_in_run);
    RUN_TEST(test_currents_that_are_gone_trip_in_run);
    RUN_TEST(test_one_bad_sample_of_all_currents_is_let_pass);
    RUN_TEST(test_one_bad_sample_of_little_current_is_let_pass);
    RUN_TEST(test_a_voltage_that_nobody_knows_of_is_no_gain);
    RUN_TEST(test_what_is_not_judged_by_a_gain);
    RUN_TEST(test_a_jump_is_taken_out_of_the_last_current);
    RUN_TEST(test_how_far_a_current_jumps);
    RUN_TEST(test_noise_is_a_mean_square);
    RUN_TEST(test_noise_is_measured);
    RUN_TEST(test_noise_is_forgotten_with_the_gates);
    RUN_TEST(test_noise_is_no_gain);
    RUN_TEST(test_noise_does_not_end_a_start);
    RUN_TEST(test_gains_are_found_in_noise);
    RUN_TEST(test_gains_that_change_at_once_end_a_start);
    return UNITY_END();
}
