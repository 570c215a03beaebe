// An angle sensor: tracking of fine and of coarse counts, the check by the EMF, and a drive behind it.
#include "support/rig.h"

#include "lodestar/encoder.h"

#include "mode.h"

#define NP 3.0

static lode_drive_tuning_t drive_tuning;

void setUp(void) {
    const lode_drive_config_t drive = rig_config();
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&drive_tuning, &drive));
}

void tearDown(void) {}

static lode_encoder_tuning_t tuned(const lode_encoder_config_t *config) {
    lode_encoder_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_encoder_tune(&tuning, config, &drive_tuning));
    return tuning;
}

// What a sensor with count 0 from angle 0 on says at a mechanical angle.
static uint32_t count_at(double theta_m, uint32_t counts_per_turn) {
    const double turn = theta_m / (2.0 * CHECK_PI);
    return (uint32_t)floor((turn - floor(turn)) * counts_per_turn);
}

static float middle_rad(uint32_t counts_per_turn) {
    return (float)(NP * CHECK_PI / counts_per_turn);
}

static double angle_off(const lode_estimate_t *estimate, double theta_e) {
    return remainder((double)lode_estimate_theta_rad(estimate) - theta_e, 2.0 * CHECK_PI);
}

static void test_bad_configurations_are_refused(void) {
    const lode_encoder_config_t sound = {.counts_per_turn = 4096u};
    const lode_encoder_tuning_t before = tuned(&sound);
    const struct {
        lode_encoder_config_t config;
        lode_status_t status;
    } cases[] = {
        {{.counts_per_turn = 5u}, LODE_ERROR_ENCODER_COUNTS},
        {{.counts_per_turn = 1048577u}, LODE_ERROR_ENCODER_COUNTS},
        {{.counts_per_turn = 64u, .offset_rad = 3.2f}, LODE_ERROR_ENCODER_ANGLE},
        {{.counts_per_turn = 64u, .offset_rad = NAN}, LODE_ERROR_ENCODER_ANGLE},
        {{.counts_per_turn = 64u, .delay_s = 2.1e-3f}, LODE_ERROR_ENCODER_ANGLE},
        {{.counts_per_turn = 64u, .delay_s = -1.0e-6f}, LODE_ERROR_ENCODER_ANGLE},
        {{.counts_per_turn = 64u, .bandwidth_rad_s = 0.5f}, LODE_ERROR_ENCODER_BANDWIDTH},
        {{.counts_per_turn = 64u, .bandwidth_rad_s = 5001.0f}, LODE_ERROR_ENCODER_BANDWIDTH},
        {{.counts_per_turn = 64u, .omega_check_rad_s = 0.5f}, LODE_ERROR_ENCODER_CHECK},
        {{.counts_per_turn = 64u, .check_s = 1.0e-4f}, LODE_ERROR_ENCODER_CHECK},
        {{.counts_per_turn = 64u, .check_s = 11.0f}, LODE_ERROR_ENCODER_CHECK},
    };
    lode_encoder_tuning_t tuning = before;
    for (int n = 0; n < COUNT_OF(cases); n++) {
        TEST_ASSERT_EQUAL_STRING(
            lode_status_name(cases[n].status),
            lode_status_name(lode_encoder_tune(&tuning, &cases[n].config, &drive_tuning)));
    }
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_encoder_tune(NULL, &sound, &drive_tuning));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_encoder_tune(&tuning, NULL, &drive_tuning));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_encoder_tune(&tuning, &sound, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof before);
}

typedef struct {
    double worst_rad, mean_rad;     // of the angle, electrical
    double worst_rad_s, mean_rad_s; // of the electrical speed
} tracked_t;

// A rotor at a constant mechanical speed: errors of the second half of two seconds.
static tracked_t track(const lode_encoder_config_t *config, double omega_m, double age_s) {
    const lode_encoder_tuning_t tuning = tuned(config);
    const double sign = config->reversed ? -1.0 : 1.0;
    const lode_estimate_t own = {.lock = 1.0f, .rotor = {0.0f, 1.0f}};
    lode_encoder_t encoder;
    lode_encoder_reset(&encoder);
    tracked_t out = {0.0, 0.0, 0.0, 0.0};
    const int periods = 10000;
    for (int k = 0; k < periods; k++) {
        const double theta_m = 0.3 + omega_m * RIG_TS_s * k;
        const uint32_t count =
            count_at(sign * (theta_m - omega_m * age_s), config->counts_per_turn);
        const lode_estimate_t e =
            lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, count);
        TEST_ASSERT_EQUAL_INT(tuning.coarse ? LODE_ESTIMATE_EDGES : LODE_ESTIMATE_SENSOR, e.source);
        if (k < periods / 2) {
            continue;
        }
        const double off = angle_off(&e, NP * theta_m);
        const double fast = (double)e.omega_rad_s - NP * omega_m;
        out.worst_rad = fmax(out.worst_rad, fabs(off));
        out.worst_rad_s = fmax(out.worst_rad_s, fabs(fast));
        out.mean_rad += off / (periods / 2.0);
        out.mean_rad_s += fast / (periods / 2.0);
    }
    return out;
}

static void test_a_fine_encoder_is_tracked_to_its_count(void) {
    const double speeds[] = {0.0, 0.02, -1.0, 30.0, -157.0};
    for (int n = 0; n < COUNT_OF(speeds); n++) {
        for (int reversed = 0; reversed < 2; reversed++) {
            const float middle = middle_rad(4096u);
            const lode_encoder_config_t config = {.counts_per_turn = 4096u,
                                                  .reversed = reversed == 1,
                                                  .offset_rad = reversed == 1 ? -middle : middle};
            const tracked_t found = track(&config, speeds[n], 0.0);
            CHECK_AT_MOST(1.1 * 2.0 * NP * CHECK_PI / 4096.0, found.worst_rad);
            CHECK_AT_MOST(1.0, found.worst_rad_s);
        }
    }
}

static void test_the_age_of_a_count_is_made_up_for(void) {
    const lode_encoder_config_t config = {
        .counts_per_turn = 1048576u, .offset_rad = middle_rad(1048576u), .delay_s = 4.0e-5f};
    CHECK_AT_MOST(1.0e-3, track(&config, 157.0, 4.0e-5).worst_rad);
}

static void test_hall_switches_are_followed_by_their_edges(void) {
    // 6 and 20 per electrical turn.
    const uint32_t counts[] = {18u, 60u};
    const double speeds[] = {-157.0, -20.0, 10.0, 62.8};
    for (int c = 0; c < COUNT_OF(counts); c++) {
        const lode_encoder_config_t config = {.counts_per_turn = counts[c],
                                              .offset_rad = middle_rad(counts[c])};
        for (int n = 0; n < COUNT_OF(speeds); n++) {
            const tracked_t found = track(&config, speeds[n], 0.0);
            const double step = NP * fabs(speeds[n]) * RIG_TS_s;
            CHECK_AT_MOST(1.0 * step + 0.5 * CHECK_DEG, found.worst_rad);
            CHECK_AT_MOST(0.1 * step + 0.2 * CHECK_DEG, fabs(found.mean_rad));
            CHECK_AT_MOST(0.01 * NP * fabs(speeds[n]), fabs(found.mean_rad_s));
        }
    }
}

// A pole of (A5) by the share of a count that an edge is off.
static double pole_of(double share) {
    return 0.8 - 0.386 * fmax(0.0, fmin(1.0, (share - 0.25) / 0.75));
}

/// An edge says where the rotor is, and corrects speed and load by its error over the interval: that which the speed
/// makes, within a period of the one measured (A3), (A5).
static void test_an_edge_corrects_speed_and_load_by_its_interval(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 18u, .offset_rad = middle_rad(18u)};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const lode_estimate_t own = {.lock = 1.0f, .rotor = {0.0f, 1.0f}};
    const lode_ab_t i_A = {0.0f, 0.0f};
    const double count_rad = CHECK_PI / 3.0;
    static const double shares[] = {0.0, 0.1, -0.2, 0.6, -0.9};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        for (int k = -1; k <= 1; k++) { // the speed makes 60, 100, 160 periods of 100
            const double made_s = (k < 0 ? 60.0 : (k > 0 ? 160.0 : 100.3)) * RIG_TS_s;
            lode_encoder_t encoder;
            lode_encoder_reset(&encoder);
            (void)lode_encoder_estimate(&encoder, &tuning, &own, i_A, 0u);
            encoder.omega_rad_s = (float)(count_rad / made_s);
            encoder.since_s = (float)(99.0 * RIG_TS_s);
            const double late = 0.5 * RIG_TS_s * encoder.omega_rad_s;
            const double at = (double)encoder.seen_rad + 0.5 * count_rad + late;
            encoder.theta_rad = (float)(at - shares[n] * count_rad - 2.0 * late);
            const double before = (double)encoder.omega_rad_s;
            (void)lode_encoder_estimate(&encoder, &tuning, &own, i_A, 1u);
            const double error = shares[n] * count_rad;
            const double since_s = 100.0 * RIG_TS_s;
            const double tau_s = fmax(since_s - RIG_TS_s, fmin(since_s + RIG_TS_s, made_s));
            const double p = pole_of(fabs(shares[n]));
            const double by = (1.5 - p - 0.5 * p * p) * error / tau_s;
            const double load = (1.0 - p) * (1.0 - p) * error / (tau_s * tau_s);
            CHECK_NEAR(2.0e-4, 0.0, remainder((double)encoder.theta_rad - at, 2.0 * CHECK_PI));
            CHECK_NEAR(0.03, by, (double)encoder.omega_rad_s - before);
            CHECK_NEAR(3.0 + 0.003 * fabs(load), load, encoder.load_rad_s2);
            CHECK_NEAR(0.0, 0.0, encoder.since_s);
        }
    }
}

/// No load is more than twice the drive's own torque.
static void test_a_sensor_that_jumps_tells_no_load_beyond_reason(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 18u, .offset_rad = middle_rad(18u)};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const lode_estimate_t own = {.lock = 1.0f, .rotor = {0.0f, 1.0f}};
    lode_encoder_t encoder;
    lode_encoder_reset(&encoder);
    (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 0u);
    (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 2u);
    const double most =
        2.0 * (double)(drive_tuning.estimator.acc_per_torque * drive_tuning.references.tau_max);
    TEST_ASSERT_TRUE(most > 0.0);
    CHECK_CLOSE(1.0e-5, most, encoder.load_rad_s2);
}

/// Between two edges the rotor follows the torque of the current and the load that is known (A3); the same with a QPLL.
static void test_between_edges_the_speed_follows_the_torque(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 18u, .offset_rad = middle_rad(18u)};
    const lode_drive_config_t drive = rig_config();
    for (int qpll = 0; qpll < 2; qpll++) {
        if (qpll == 1) {
            drive_tuning.estimator.acc_per_torque = 0.0f;
            drive_tuning.estimator.acc_per_omega = 0.0f;
        }
        const lode_encoder_tuning_t tuning = tuned(&config);
        const lode_estimate_t own = {.lock = 1.0f, .rotor = {0.0f, 1.0f}};
        lode_encoder_t encoder;
        lode_encoder_reset(&encoder);
        lode_estimate_t e =
            lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 0u);
        encoder.load_rad_s2 = 100.0f;
        double omega = 0.0;
        const double flux = (double)drive.motor.psi_Wb -
                            2.0 * ((double)drive.motor.Ld_H - (double)drive.motor.Lq_H);
        for (int k = 0; k < 100; k++) { // id -2 A, iq 1.5 A
            const lode_ab_t i_A = lode_park_inverse((lode_dq_t){-2.0f, 1.5f}, e.rotor);
            e = lode_encoder_estimate(&encoder, &tuning, &own, i_A, 0u);
            const double torque =
                1.5 * NP * flux * 1.5 - (qpll == 1 ? 0.0 : (double)drive.motor.B_Nms * omega / NP);
            omega += RIG_TS_s * (100.0 + (k == 0 ? 0.0 : NP / (double)drive.motor.J_kgm2 * torque));
            if (lode_abs(lode_wrap(encoder.theta_rad - encoder.seen_rad)) > 0.45f) {
                break;
            }
        }
        TEST_ASSERT_TRUE(omega > 5.0);
        CHECK_CLOSE(0.05, omega, e.omega_rad_s);
    }
    // A tuning that knows no inertia follows the edges alone.
    drive_tuning.speed.inertia_Nm = 0.0f;
    CHECK_NEAR(0.0, 0.0, tuned(&config).acc_per_torque);
}

/// An edge that is overdue: the speed that the rotor would have if it came now, the angle on its way from the end of the
/// count to its middle, and from there on as if it had come (A4).
static void test_an_edge_that_is_overdue_slows_the_rotor_down(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 18u, .offset_rad = middle_rad(18u)};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const lode_estimate_t own = {.lock = 1.0f, .rotor = {0.0f, 1.0f}};
    const double count_rad = CHECK_PI / 3.0;
    for (int sign = -1; sign <= 1; sign += 2) {
        static const double excess[] = {0.0, 0.2, 0.5, 0.9, 1.1};
        for (int n = 0; n < COUNT_OF(excess); n++) {
            lode_encoder_t encoder;
            lode_encoder_reset(&encoder);
            (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 0u);
            const double omega = 20.0;
            const double step = omega * RIG_TS_s;
            const double since_s = (1.0 + excess[n]) * count_rad / omega;
            const double ahead = (0.5 + excess[n]) * count_rad;
            encoder.omega_rad_s = (float)(sign * omega);
            encoder.since_s = (float)(since_s - RIG_TS_s);
            encoder.theta_rad = (float)((double)encoder.seen_rad + sign * (ahead - step));
            const lode_estimate_t e =
                lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 0u);
            const double off =
                sign * remainder((double)lode_estimate_theta_rad(&e) - (double)encoder.seen_rad,
                                 2.0 * CHECK_PI);
            const double share = fmax(0.0, excess[n] - step / count_rad);
            if (excess[n] > 1.0) {
                CHECK_NEAR(1.0e-4, 0.0, off);
                CHECK_NEAR(0.3, omega - 1.1 * count_rad / since_s, sign * (double)e.omega_rad_s);
                CHECK_NEAR(1.0e-3, count_rad / omega,
                           encoder.since_s); // not beyond what the speed makes
                TEST_ASSERT_TRUE((double)sign * (double)encoder.load_rad_s2 < 0.0);
            } else {
                const double p = pole_of(share);
                const double slower = (1.5 - p - 0.5 * p * p) * share * count_rad / since_s;
                CHECK_NEAR(0.3, omega - slower, sign * (double)e.omega_rad_s);
                CHECK_NEAR(0.01, (0.5 * count_rad + step) * (1.0 - share), off);
                CHECK_NEAR(0.0, (float)(sign * omega), encoder.omega_rad_s);
            }
        }
    }
}

static void test_a_rotor_that_stops_between_two_edges_is_seen_to_stop(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 18u, .offset_rad = middle_rad(18u)};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const lode_estimate_t own = {.lock = 1.0f, .rotor = {0.0f, 1.0f}};
    lode_encoder_t encoder;
    lode_encoder_reset(&encoder);
    lode_estimate_t e = own;
    double theta_m = 0.0;
    for (int k = 0; k < 10000; k++) {
        theta_m += k < 5000 ? 20.0 * RIG_TS_s : 0.0;
        e = lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f},
                                  count_at(theta_m, 18u));
    }
    CHECK_AT_MOST(5.0 * CHECK_PI / 3.0,
                  fabs((double)e.omega_rad_s)); // as (A4): some edges over the time
    CHECK_AT_MOST(CHECK_PI / 3.0, fabs(angle_off(&e, NP * theta_m))); // both within the count
}

/// (A6): between two edges; a load that drives the rotor stays what it is.
static void test_a_load_that_opposes_the_motion_turns_round_with_it(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 18u, .offset_rad = middle_rad(18u)};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const lode_estimate_t own = {.lock = 1.0f, .rotor = {0.0f, 1.0f}};
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int against = 0; against <= 1; against++) {
            const float way = (float)sign;
            lode_encoder_t encoder;
            lode_encoder_reset(&encoder);
            (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 0u);
            encoder.omega_rad_s = way * 0.005f;
            encoder.load_rad_s2 = against == 1 ? -way * 100.0f : way * 100.0f;
            encoder.acc_rad_s2 = -way * 300.0f;
            (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 0u);
            TEST_ASSERT_TRUE(way * encoder.omega_rad_s < 0.0f);
            TEST_ASSERT_EQUAL_FLOAT(way * 100.0f, encoder.load_rad_s2);
        }
    }
}

/// Of coarse counts only the edges show a speed that the EMF can be compared with.
static void test_a_speed_that_no_edge_shows_is_not_checked(void) {
    const lode_encoder_config_t config = {
        .counts_per_turn = 18u, .offset_rad = middle_rad(18u), .omega_check_rad_s = 20.0f};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const lode_estimate_t own = {.lock = 0.1f, .rotor = {0.0f, 1.0f}, .source = LODE_ESTIMATE_OWN};
    const float count_s = (float)(CHECK_PI / 3.0 / 20.0);
    for (int late = 0; late <= 1; late++) {
        lode_encoder_t encoder;
        lode_encoder_reset(&encoder);
        (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 0u);
        encoder.omega_rad_s = 30.0f;
        encoder.since_s = late == 1 ? count_s : count_s - 2.0f * (float)RIG_TS_s;
        const lode_estimate_t e =
            lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 0u);
        TEST_ASSERT_EQUAL_FLOAT(late == 1 ? 1.0f : 0.1f, e.lock);
    }
}

static void test_counts_beyond_a_turn_are_reduced(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 1000u};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const lode_estimate_t own = {.lock = 1.0f, .rotor = {0.0f, 1.0f}};
    const uint32_t counts[] = {250u, 1250u, 4294967250u};
    for (int n = 0; n < COUNT_OF(counts); n++) {
        lode_encoder_t encoder;
        lode_encoder_reset(&encoder);
        const lode_estimate_t e =
            lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, counts[n]);
        const double count = (double)(counts[n] % 1000u);
        CHECK_NEAR(1.0e-5, 0.0, angle_off(&e, NP * 2.0 * CHECK_PI * count / 1000.0));
    }
}

static void test_the_offset_is_found_from_the_own_estimate(void) {
    const lode_encoder_config_t config = {
        .counts_per_turn = 4096u, .offset_rad = -0.4f, .delay_s = 1.0e-4f};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const double offset = 1.1; // the true one
    const uint32_t count = 777u;
    const double theta = NP * 2.0 * CHECK_PI * count / 4096.0 + offset + 300.0 * 1.0e-4;
    const lode_estimate_t own = {.omega_rad_s = 300.0f,
                                 .rotor = {(float)sin(theta), (float)cos(theta)}};
    CHECK_NEAR(1.0e-5, offset, (double)lode_encoder_offset_rad(&tuning, &own, count));
}

// --- A drive behind it --------------------------------------------------------------------------

typedef struct {
    rig_t rig;
    lode_encoder_tuning_t tuning;
    lode_encoder_t encoder;
    double theta_m, before;
    bool stuck;
} shaft_t;

static shaft_t shaft(bool falls_back) {
    const lode_encoder_config_t config = {
        .counts_per_turn = 4096u, .offset_rad = middle_rad(4096u), .falls_back = falls_back};
    shaft_t self = {.tuning = tuned(&config)};
    const lode_drive_config_t drive = rig_config();
    rig_init(&self.rig, &drive_tuning, &drive);
    lode_encoder_reset(&self.encoder);
    return self;
}

static void shaft_step(shaft_t *self) {
    rig_t *rig = &self->rig;
    rig->stamp += 1000u;
    const lode_counts_t counts = rig_counts(rig);
    self->theta_m += remainder(rig->motor.theta - self->before, 2.0 * CHECK_PI) / NP;
    self->before = rig->motor.theta;
    const uint32_t count = self->stuck ? 100u : count_at(self->theta_m, 4096u);
    const lode_sample_t sample = lode_drive_sense(&rig->drive, &counts);
    const lode_estimate_t own = lode_drive_estimate(&rig->drive, &sample);
    const lode_estimate_t e =
        lode_encoder_estimate(&self->encoder, &self->tuning, &own, sample.i_A, count);
    rig->out = lode_drive_act(&rig->drive, &sample, &e);
    rig_move(rig);
}

static void shaft_run(shaft_t *self, double seconds) {
    for (int n = 0; n < (int)(seconds / RIG_TS_s); n++) {
        shaft_step(self);
    }
}

static void check_speed(shaft_t *self, double rad_s) {
    rig_expect(&self->rig, LODE_MODE_RUN);
    CHECK_NEAR(0.2, rad_s, self->rig.motor.omega / NP);
}

static void test_a_drive_holds_zero_speed_and_reverses_through_it(void) {
    shaft_t self = shaft(false);
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 1.0f});
    for (int n = 0; n < 750 && rig_telemetry(&self.rig).mode != LODE_MODE_RUN; n++) { // calibrated
        shaft_step(&self);
    }
    rig_expect(&self.rig, LODE_MODE_RUN);
    CHECK_NEAR(0.0, 0.0, self.rig.drive.state.run.fade); // there was no start
    shaft_run(&self, 2.0);
    check_speed(&self, 1.0);
    TEST_ASSERT_FALSE(rig_telemetry(&self.rig).speed_raised);
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 0.0f});
    shaft_run(&self, 2.0);
    check_speed(&self, 0.0); // it stays on
    TEST_ASSERT_TRUE(self.rig.out.gates);
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = -150.0f});
    shaft_run(&self, 4.0);
    check_speed(&self, -150.0);
    // Torque either way, between the two speeds.
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN,
                                            .control = LODE_CONTROL_TORQUE,
                                            .speed_rad_s = 20.0f,
                                            .torque_Nm = 1.0f});
    TEST_ASSERT_FALSE(rig_telemetry(&self.rig).speed_held);
    shaft_run(&self, 0.1);
    TEST_ASSERT_TRUE(rig_telemetry(&self.rig).speed_held); // outside of both speeds
    while (fabs(self.rig.motor.omega / NP) > 10.0) {
        shaft_step(&self);
    }
    TEST_ASSERT_FALSE(rig_telemetry(&self.rig).speed_held);
    shaft_run(&self, 5.9);
    check_speed(&self, 20.0);
    TEST_ASSERT_TRUE(rig_telemetry(&self.rig).speed_held);
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN,
                                            .control = LODE_CONTROL_TORQUE,
                                            .speed_rad_s = 20.0f,
                                            .torque_Nm = -1.0f});
    shaft_run(&self, 6.0);
    check_speed(&self, -20.0);
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_OFF});
    shaft_step(&self);
    TEST_ASSERT_FALSE(self.rig.out.gates);
}

/// (K42): a rotor that jams. One that is to stand or to creep may be held with all the torque.
static void test_a_rotor_that_jams_is_an_overload(void) {
    const struct {
        float speed_rad_s;
        lode_check_t found;
    } cases[] = {{60.0f, LODE_CHECK_OVERLOAD}, {0.0f, LODE_CHECK_NONE}, {3.0f, LODE_CHECK_NONE}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        shaft_t self = shaft(false);
        rig_command(&self.rig,
                    (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = cases[n].speed_rad_s});
        shaft_run(&self, 2.0);
        check_speed(&self, (double)cases[n].speed_rad_s);
        double all_s = 0.0;
        bool all = false;
        for (int k = 0; k < (int)(4.0 / RIG_TS_s) && self.rig.drive.gates; k++) {
            // moved back until all the torque is asked for, then held, all but for its noise
            self.rig.motor.omega = all ? 0.03 * sin(0.01 * k) : -12.0;
            self.rig.blocked = true;
            shaft_step(&self);
            const lode_dq_t ref_A = self.rig.drive.ref_A;
            all = hypot((double)ref_A.d, (double)ref_A.q) > 10.8;
            all_s += all ? RIG_TS_s : 0.0;
        }
        TEST_ASSERT_EQUAL_STRING(
            lode_check_name(cases[n].found),
            lode_check_name((lode_check_t)rig_telemetry(&self.rig).fault.check));
        CHECK_AT_LEAST(0.09, all_s);
    }
}

/// With a sensor speed 0 is a speed like any other, from OFF too.
static void test_speed_0_from_off_holds_the_rotor(void) {
    shaft_t self = shaft(false);
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 0.0f});
    shaft_run(&self, 1.0);
    rig_expect(&self.rig, LODE_MODE_RUN);
    TEST_ASSERT_TRUE(self.rig.out.gates);
    check_speed(&self, 0.0);
    const float bias_A = drive_tuning.references.id_bias_A;
    TEST_ASSERT_TRUE(bias_A > 0.0f);
    CHECK_NEAR(1.0e-3, -bias_A, self.rig.drive.ref_A.d);
    self.tuning.coarse = true; // no bias with edges (K10)
    shaft_run(&self, 0.01);
    CHECK_NEAR(1.0e-3, 0.0, self.rig.drive.ref_A.d);
    self.tuning.coarse = false;
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_OFF});
    shaft_step(&self);
    TEST_ASSERT_FALSE(self.rig.out.gates);
    shaft_step(&self);
    TEST_ASSERT_TRUE(lode_mode_is_sensored(&self.rig.drive));
    // A sensor that says nothing any more is none in OFF either.
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_OFF});
    rig_run(&self.rig, 3.0 * RIG_TS_s);
    TEST_ASSERT_FALSE(lode_mode_is_sensored(&self.rig.drive));
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 0.0f});
    rig_run(&self.rig, 0.1);
    rig_expect(&self.rig, LODE_MODE_OFF);
}

static void test_a_sensor_that_sticks_trips(void) {
    shaft_t self = shaft(false);
    rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f});
    shaft_run(&self, 3.0);
    check_speed(&self, 100.0);
    self.stuck = true;
    shaft_run(&self, 0.2);
    rig_expect(&self.rig, LODE_MODE_FAULT);
}

/// A sensor that the EMF contradicts for less than the time of the check is trusted; the time begins anew.
static void test_a_short_doubt_is_forgotten(void) {
    const lode_encoder_config_t config = {
        .counts_per_turn = 4096u, .offset_rad = middle_rad(4096u), .check_s = 0.02f};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const int periods = (int)(0.02 / RIG_TS_s + 0.5);
    lode_encoder_t encoder;
    lode_encoder_reset(&encoder);
    double theta = 0.0;
    for (int n = 0; n <= 20 * periods; n++) {
        theta += 100.0 * RIG_TS_s;
        const bool doubt = n > 5 * periods && n % periods != 0;
        const lode_estimate_t own = {.lock = doubt ? 0.0f : LODE_LOCK_LOST};
        (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f},
                                    count_at(theta, 4096u));
        TEST_ASSERT_FALSE(encoder.distrusted);
    }
    int n = 0;
    while (!encoder.distrusted && n < 2 * periods) {
        theta += 100.0 * RIG_TS_s;
        const lode_estimate_t own = {.lock = 0.0f};
        (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f},
                                    count_at(theta, 4096u));
        n++;
    }
    TEST_ASSERT_EQUAL_INT(periods, n);
    // Near standstill the EMF says nothing.
    lode_encoder_reset(&encoder);
    for (n = 0; n < 3 * periods; n++) {
        const lode_estimate_t own = {.lock = 0.0f};
        const lode_estimate_t e =
            lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f}, 7u);
        TEST_ASSERT_FALSE(encoder.distrusted);
        CHECK_NEAR(0.0, 1.0, e.lock);
    }
}

// The sensor slips by a third of an electrical turn, as a loose magnet does.
static void test_a_sensor_that_slips_is_left_for_the_emf(void) {
    for (int falls_back = 0; falls_back < 2; falls_back++) {
        shaft_t self = shaft(falls_back == 1);
        rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f});
        shaft_run(&self, 3.0);
        check_speed(&self, 100.0);
        self.theta_m += 2.0 * CHECK_PI / 3.0 / NP;
        shaft_run(&self, 2.0);
        TEST_ASSERT_TRUE(self.encoder.distrusted);
        if (falls_back == 1) {
            check_speed(&self, 100.0);
            rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 1.0f});
            shaft_run(&self, 3.0);
            TEST_ASSERT_TRUE(rig_telemetry(&self.rig).speed_raised); // sensorless
        } else {
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&self.rig).fault.check);
        }
    }
}

/// One that is wrong from the beginning trips at the first contradiction: another attempt has the same sensor.
static void test_a_sensor_that_is_wrong_in_a_start_trips_at_once(void) {
    for (int way = -1; way <= 1; way++) { // from rest, or turning already
        shaft_t self = shaft(false);
        self.theta_m += CHECK_PI / NP;
        self.rig.motor.omega = 200.0 * way;
        rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f});
        for (int n = 0; n < 20000 && self.rig.drive.mode != LODE_MODE_FAULT; n++) {
            shaft_step(&self);
            TEST_ASSERT_EQUAL_UINT(0u, self.rig.drive.losses);
        }
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&self.rig).fault.check);
    }
}

/// With the gates off the EMF is not seen, and after that it takes a time to be: neither is a sensor that is wrong. But one that is
/// wrong from then on is found.
static void test_a_rotor_that_coasts_is_no_sensor_that_is_wrong(void) {
    for (int wrong = 0; wrong <= 1; wrong++) {
        shaft_t self = shaft(true);
        rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f});
        shaft_run(&self, 3.0);
        check_speed(&self, 100.0);
        rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_OFF});
        shaft_run(&self, 0.3);
        CHECK_AT_LEAST(30.0,
                       self.rig.motor.omega / NP); // it coasts, faster than where it is checked
        TEST_ASSERT_FALSE(self.encoder.distrusted);
        self.theta_m += wrong == 1 ? CHECK_PI / 2.0 / NP : 0.0;
        rig_command(&self.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f});
        shaft_run(&self, 1.0);
        TEST_ASSERT_EQUAL_INT(wrong, self.encoder.distrusted);
    }
}

static void test_what_is_checked_from_where(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 4096u};
    lode_drive_config_t drive = rig_config();
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&drive_tuning, &drive));
    CHECK_NEAR(0.0, (double)drive_tuning.omega_min, (double)tuned(&config).omega_check);
    const lode_encoder_config_t coarse = {.counts_per_turn = 18u};
    CHECK_CLOSE(1.0e-6, 1.5 * (double)drive_tuning.omega_min, tuned(&coarse).omega_check);
    drive.hfi.mode = LODE_HFI_ON; // with which there is no least speed
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&drive_tuning, &drive));
    CHECK_NEAR(0.0, (double)drive_tuning.start.omega_handover, (double)tuned(&config).omega_check);
}

/// As long as observer and lock take from a reset, to the period.
static void test_the_emf_is_given_its_time(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 4096u, .check_s = 0.02f};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const int given = 8 * (int)drive_tuning.estimator.settle_rounds + (int)(0.02 / RIG_TS_s + 0.5);
    CHECK_AT_LEAST(0.015 / RIG_TS_s, 8.0 * (double)drive_tuning.estimator.settle_rounds);
    lode_encoder_t encoder;
    lode_encoder_reset(&encoder);
    double theta = 0.0;
    int since = 0;
    for (int n = 0; n < 200 + given; n++) {
        theta += 100.0 * RIG_TS_s;
        const bool off = n < 200;
        const lode_estimate_t own = {.source = off ? LODE_ESTIMATE_NONE : LODE_ESTIMATE_OWN};
        (void)lode_encoder_estimate(&encoder, &tuning, &own, (lode_ab_t){0.0f, 0.0f},
                                    count_at(theta, 4096u));
        since += off ? 0 : 1;
        TEST_ASSERT_EQUAL_INT(since >= given - 1, encoder.distrusted);
    }
}

// lode_drive_step() knows no sensor: the drive is sensorless again, at once where it has to start.
static void test_the_step_alone_is_sensorless(void) {
    shaft_t self = shaft(false);
    rig_t *rig = &self.rig;
    rig_command(rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f});
    shaft_run(&self, 3.0);
    check_speed(&self, 100.0);
    rig_command(rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 1.0f});
    rig_run(rig, 3.0);
    TEST_ASSERT_TRUE(rig_telemetry(rig).speed_raised);
    check_speed(&self, (double)(drive_tuning.omega_min * drive_tuning.speed.inv_pole_pairs));
    // Switched off by the sensor's calls and on again without them: it is started.
    self = shaft(false);
    rig_command(rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 1.0f});
    shaft_run(&self, 2.0);
    rig_command(rig, (lode_command_t){.mode = LODE_MODE_OFF});
    shaft_step(&self);
    rig_command(rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 80.0f});
    rig_run(rig, 0.05);
    rig_expect(rig, LODE_MODE_START);
    rig_run(rig, 8.0);
    check_speed(&self, 80.0);
}

/// What is given is taken up to its ends, and not beyond.
static void test_every_field_at_its_limits(void) {
    const float ts_s = drive_tuning.estimator.pll.ts_s;
    const struct {
        size_t offset;
        float lo, hi;
    } fields[] = {
        {offsetof(lode_encoder_config_t, offset_rad), -LODE_PI, LODE_PI},
        {offsetof(lode_encoder_config_t, bandwidth_rad_s), 1.0f, 1.0f / ts_s},
        {offsetof(lode_encoder_config_t, omega_check_rad_s), 1.0f, 1.0e6f},
        {offsetof(lode_encoder_config_t, check_s), ts_s, 10.0f},
    };
    for (int n = 0; n < COUNT_OF(fields); n++) {
        const float values[] = {fields[n].lo, fields[n].hi, nextafterf(fields[n].lo, -INFINITY),
                                nextafterf(fields[n].hi, INFINITY)};
        for (int k = 0; k < COUNT_OF(values); k++) {
            lode_encoder_config_t config = {.counts_per_turn = 64u};
            lode_encoder_tuning_t tuning;
            memcpy((char *)&config + fields[n].offset, &values[k], sizeof values[k]);
            TEST_ASSERT_EQUAL_INT(k < 2,
                                  lode_encoder_tune(&tuning, &config, &drive_tuning) == LODE_OK);
        }
    }
    static const uint32_t counts[] = {6u, 1048576u, 5u, 1048577u};
    for (int k = 0; k < COUNT_OF(counts); k++) {
        const lode_encoder_config_t config = {.counts_per_turn = counts[k]};
        lode_encoder_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(k < 2, lode_encoder_tune(&tuning, &config, &drive_tuning) == LODE_OK);
    }
}

/// However the reciprocals and quotients of floats round.
static void test_pole_pairs_and_the_time_of_the_check_are_whole(void) {
    lode_drive_tuning_t drive = drive_tuning;
    for (uint32_t n = 1u; n <= 100u; n++) {
        drive.speed.inv_pole_pairs = 1.0f / (float)n;
        const lode_encoder_config_t config = {.counts_per_turn = 4096u,
                                              .check_s = (float)n * drive.estimator.pll.ts_s};
        lode_encoder_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_encoder_tune(&tuning, &config, &drive));
        TEST_ASSERT_EQUAL_UINT(n, tuning.pole_pairs);
        TEST_ASSERT_EQUAL_UINT(n, tuning.check_periods);
    }
}

/// Both poles of the loop lie at exp(-bandwidth Ts). Inside a count a tenth of its gain acts, beyond it all.
static void test_gains_of_a_fine_encoder(void) {
    const lode_encoder_config_t config = {.counts_per_turn = 4096u, .bandwidth_rad_s = 300.0f};
    const lode_encoder_tuning_t tuning = tuned(&config);
    const double ts_s = RIG_TS_s;
    const double pole = exp(-300.0 * ts_s);
    const double angle = tuning.angle_gain;
    const double speed = tuning.speed_gain;
    CHECK_CLOSE(1.0e-4, pole * pole, 1.0 - angle);
    CHECK_CLOSE(1.0e-4, 2.0 * pole, 2.0 - angle - speed * ts_s);
    static const double offs[] = {0.5, -0.5, 1.0, 3.0, -3.0}; // halves of a count
    const double half = NP * CHECK_PI / 4096.0;
    for (int n = 0; n < COUNT_OF(offs); n++) {
        lode_encoder_t encoder;
        memset(&encoder, 0xff, sizeof encoder);
        lode_encoder_reset(&encoder);
        const lode_estimate_t own = {.lock = 1.0f, .load_torque_Nm = 2.0f};
        const lode_ab_t i_A = {1.5f, -2.5f};
        (void)lode_encoder_estimate(&encoder, &tuning, &own, i_A, 1000u);
        const double middle = encoder.theta_rad;
        encoder.theta_rad = (float)(middle - offs[n] * half);
        const lode_estimate_t e = lode_encoder_estimate(&encoder, &tuning, &own, i_A, 1000u);
        const double inside = fmax(-half, fmin(half, offs[n] * half));
        const double error = offs[n] * half - 0.9 * inside;
        CHECK_NEAR(1.0e-6, angle * error, (double)encoder.theta_rad - middle + offs[n] * half);
        CHECK_NEAR(1.0e-3 * fabs(speed * error), speed * error, encoder.omega_rad_s);
        const lode_dq_t seen = lode_park(i_A, e.rotor);
        CHECK_NEAR(0.0, seen.d, e.i_A.d);
        CHECK_NEAR(0.0, seen.q, e.i_A.q);
        CHECK_NEAR(0.0, 0.0, e.load_torque_Nm);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_a_fine_encoder_is_tracked_to_its_count);
    RUN_TEST(test_the_age_of_a_count_is_made_up_for);
    RUN_TEST(test_hall_switches_are_followed_by_their_edges);
    RUN_TEST(test_an_edge_corrects_speed_and_load_by_its_interval);
    RUN_TEST(test_a_sensor_that_jumps_tells_no_load_beyond_reason);
    RUN_TEST(test_between_edges_the_speed_follows_the_torque);
    RUN_TEST(test_an_edge_that_is_overdue_slows_the_rotor_down);
    RUN_TEST(test_a_rotor_that_stops_between_two_edges_is_seen_to_stop);
    RUN_TEST(test_a_load_that_opposes_the_motion_turns_round_with_it);
    RUN_TEST(test_a_speed_that_no_edge_shows_is_not_checked);
    RUN_TEST(test_counts_beyond_a_turn_are_reduced);
    RUN_TEST(test_the_offset_is_found_from_the_own_estimate);
    RUN_TEST(test_a_drive_holds_zero_speed_and_reverses_through_it);
    RUN_TEST(test_a_rotor_that_jams_is_an_overload);
    RUN_TEST(test_speed_0_from_off_holds_the_rotor);
    RUN_TEST(test_a_sensor_that_sticks_trips);
    RUN_TEST(test_a_short_doubt_is_forgotten);
    RUN_TEST(test_a_sensor_that_slips_is_left_for_the_emf);
    RUN_TEST(test_a_sensor_that_is_wrong_in_a_start_trips_at_once);
    RUN_TEST(test_a_rotor_that_coasts_is_no_sensor_that_is_wrong);
    RUN_TEST(test_what_is_checked_from_where);
    RUN_TEST(test_the_emf_is_given_its_time);
    RUN_TEST(test_the_step_alone_is_sensorless);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_pole_pairs_and_the_time_of_the_check_are_whole);
    RUN_TEST(test_gains_of_a_fine_encoder);
    return UNITY_END();
}
