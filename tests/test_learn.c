// Lq and psi from where the EMF and injection differ.
#include "support/rig.h"

#include "lodestar/adaptation.h"
#include "lodestar/learn.h"

void setUp(void) {}

void tearDown(void) {}

#define DT_s 2.0e-3f
// Long enough for a measurement: 50 ms that are waited for, 150 ms of samples.
#define MEASURE_STEPS 102

static lode_drive_config_t learning(void) {
    lode_drive_config_t config = rig_config();
    config.hfi.mode = LODE_HFI_ON;
    config.hfi.learn = LODE_ON;
    config.hfi.V_h_V = 25.0f;
    lode_drive_design(&config);
    return config;
}

static lode_learn_tuning_t designed(const lode_drive_config_t *config) {
    lode_learn_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_learn_design(&tuning, config, LODE_AUTO));
    return tuning;
}

/// What a drive sees whose Lq is `Lq_off_H` below the motor's, at 5 A and 200 rad/s.
static lode_telemetry_t seen(float Lq_off_H, float iq_A) {
    return (lode_telemetry_t){
        .mode = LODE_MODE_RUN,
        .injected = 1.0f,
        .lock = 0.9f,
        .omega_rad_s = 200.0f,
        .i_A = {0.0f, iq_A},
        .e_V = {0.0f, 0.142f * 200.0f},
        .emf_error_rad = Lq_off_H * iq_A / 0.142f,
    };
}

/// The same seen for as long as a measurement takes.
static bool measure(lode_learn_t *learn, const lode_learn_tuning_t *tuning,
                    const lode_telemetry_t *now) {
    bool worth = false;
    for (int k = 0; k < MEASURE_STEPS; k++) {
        worth = lode_learn_step(learn, tuning, now, DT_s);
    }
    return worth;
}

static void begin(lode_learn_t *learn, lode_learn_tuning_t *tuning) {
    const lode_drive_config_t config = learning();
    *tuning = designed(&config);
    tuning->droop_s2 = 0.0f; // of a perfect observer
    lode_learn_begin(learn, tuning, &config, NULL);
}

static void test_refusals(void) {
    lode_drive_config_t config = learning();
    lode_learn_tuning_t tuning = {.Ld_H = 7.0f};
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_learn_design(NULL, &config, LODE_ON));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_learn_design(&tuning, NULL, LODE_ON));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, lode_learn_design(&tuning, &config, (lode_choice_t)3));
    config.hfi.learn = LODE_OFF;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_HFI_LEARN, lode_learn_design(&tuning, &config, LODE_ON));
    config.hfi.learn = LODE_ON;
    config.hfi.mode = LODE_HFI_OFF;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_HFI_LEARN, lode_learn_design(&tuning, &config, LODE_ON));
    config.motor.psi_Wb = -1.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_PSI, lode_learn_design(&tuning, &config, LODE_ON));
    CHECK_NEAR(0.0, 7.0, tuning.Ld_H);
}

static void test_limits(void) {
    lode_drive_config_t config = learning();
    lode_learn_tuning_t tuning = designed(&config);
    // Below 1.15 Ld init refuses: 0.41 times Lq here, and the 0.3 times of a more salient one.
    CHECK_NEAR(1.0e-7, 1.01 * 1.15 * 3.5e-3, tuning.Lq_H.min);
    CHECK_NEAR(1.0e-7, 3.0 * 9.8e-3, tuning.Lq_H.max);
    CHECK_NEAR(1.0e-6, 0.7 * 0.142, tuning.psi_Wb.min);
    CHECK_NEAR(1.0e-6, 1.2 * 0.142, tuning.psi_Wb.max);
    config.motor.Lq_H *= 2.0f;
    config.hfi.Lq_i_max_H *= 2.0f;
    config.current.kp_q_V_A *= 2.0f;
    tuning = designed(&config);
    CHECK_NEAR(1.0e-7, 0.3 * 19.6e-3, tuning.Lq_H.min);
    // Hardly more salient than has to be: what is configured is the least.
    config.hfi.Lq_i_max_H = 1.155f * config.motor.Ld_H;
    tuning = designed(&config);
    CHECK_NEAR(0.0, config.motor.Lq_H, tuning.Lq_H.min);
}

/// As for a drive, what is left open is designed.
static void test_an_open_configuration_is_designed(void) {
    lode_drive_config_t open = rig_config();
    open.hfi.mode = LODE_HFI_ON;
    open.hfi.learn = LODE_ON;
    lode_drive_config_t complete = open;
    lode_drive_design(&complete);
    const lode_learn_tuning_t from_open = designed(&open);
    const lode_learn_tuning_t from_complete = designed(&complete);
    TEST_ASSERT_TRUE(complete.hfi.Lq_i_max_H > 0.0f);
    CHECK_NEAR(0.0, from_complete.Lq_H.min, from_open.Lq_H.min);
    CHECK_NEAR(0.0, from_complete.omega_least, from_open.omega_least);
}

static void test_what_was_stored_is_taken_within_limits(void) {
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    begin(&learn, &tuning);
    CHECK_NEAR(0.0, 0.0, learn.now.confidence);
    CHECK_NEAR(1.0e-9, 9.8e-3, learn.now.Lq_H);
    const lode_drive_config_t config = learning();
    const lode_learned_t stored = {8.0e-3f, 0.13f, 0.9f};
    lode_learn_begin(&learn, &tuning, &config, &stored);
    CHECK_NEAR(1.0e-9, 8.0e-3, learn.now.Lq_H);
    CHECK_NEAR(1.0e-6, 0.9, learn.now.confidence);
    const lode_telemetry_t off = {.mode = LODE_MODE_OFF};
    TEST_ASSERT_TRUE(lode_learn_step(&learn, &tuning, &off, DT_s)); // the first tuning has it
    // A memory that was never written holds zeros or ones, and a broken one anything: none of it is taken.
    lode_learned_t erased;
    memset(&erased, 0xff, sizeof erased);
    const lode_learned_t unsound[] = {erased,
                                      {0.0f, 0.0f, 0.0f},
                                      {8.0e-3f, 0.13f, 0.0f},
                                      {8.0e-3f, 0.13f, 1.5f},
                                      {0.99f * tuning.Lq_H.min, 0.13f, 0.9f},
                                      {1.01f * tuning.Lq_H.max, 0.13f, 0.9f},
                                      {8.0e-3f, 0.99f * tuning.psi_Wb.min, 0.9f},
                                      {8.0e-3f, 1.01f * tuning.psi_Wb.max, 0.9f}};
    for (int n = 0; n < COUNT_OF(unsound); n++) {
        lode_learn_begin(&learn, &tuning, &config, &unsound[n]);
        CHECK_NEAR(0.0, (double)config.motor.Lq_H, learn.now.Lq_H);
        CHECK_NEAR(0.0, (double)config.motor.psi_Wb, learn.now.psi_Wb);
        CHECK_NEAR(0.0, 0.0, learn.now.confidence);
        TEST_ASSERT_FALSE(lode_learn_step(&learn, &tuning, &off, DT_s));
    }
}

// (H16), (H17): 0.7 of what the errors show, whatever the sign of the current and injection's share.
static void test_a_measurement_corrects_Lq(void) {
    static const float currents_A[] = {5.0f, -5.0f, 3.0f};
    for (int n = 0; n < COUNT_OF(currents_A); n++) {
        lode_learn_t learn;
        lode_learn_tuning_t tuning;
        begin(&learn, &tuning);
        lode_telemetry_t now = seen(1.0e-3f, currents_A[n]);
        now.injected = n == 2 ? 0.5f : 1.0f;
        now.emf_error_rad *= now.injected;
        TEST_ASSERT_TRUE(measure(&learn, &tuning, &now));
        CHECK_NEAR(1.0e-8, 9.8e-3 + 0.7e-3, learn.now.Lq_H);
        CHECK_NEAR(1.0e-5, 0.142, learn.now.psi_Wb);
    }
}

// What i_d makes of the active flux belongs to it.
static void test_a_measurement_with_current_in_d(void) {
    static const float currents_A[] = {-3.0f, 3.0f};
    for (int n = 0; n < COUNT_OF(currents_A); n++) {
        lode_learn_t learn;
        lode_learn_tuning_t tuning;
        begin(&learn, &tuning);
        lode_telemetry_t now = seen(0.0f, 5.0f);
        const float active_Wb = 0.142f + (3.5e-3f - 9.8e-3f) * currents_A[n];
        now.i_A.d = currents_A[n];
        now.e_V.beta = 200.0f * active_Wb;
        now.emf_error_rad = 1.0e-3f * 5.0f / active_Wb;
        TEST_ASSERT_TRUE(measure(&learn, &tuning, &now));
        CHECK_NEAR(1.0e-8, 9.8e-3 + 0.7e-3, learn.now.Lq_H);
        CHECK_NEAR(1.0e-5, 0.142, learn.now.psi_Wb);
    }
}

/// The least speed, current and lock that a measurement takes are looked at already.
static void test_a_measurement_at_the_least_of_all(void) {
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    begin(&learn, &tuning);
    lode_telemetry_t now = seen(1.0e-3f, tuning.i_least_A);
    now.lock = LODE_LOCK_LOST;
    now.omega_rad_s = -tuning.omega_least;
    TEST_ASSERT_TRUE(measure(&learn, &tuning, &now));
    CHECK_NEAR(1.0e-8, 9.8e-3 + 0.7e-3, learn.now.Lq_H);
    begin(&learn, &tuning);
    now = seen(0.0f, 5.0f);
    now.omega_rad_s = tuning.omega_psi;
    now.e_V.beta = 0.13f * tuning.omega_psi;
    TEST_ASSERT_TRUE(measure(&learn, &tuning, &now));
    CHECK_NEAR(1.0e-5, 0.142 - 0.7 * 0.012, learn.now.psi_Wb);
}

/// Looks that agree raise the confidence by a quarter of what is missing each, one that does not lowers it.
static void test_measurements_converge_and_are_believed(void) {
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    begin(&learn, &tuning);
    const lode_telemetry_t good = seen(0.0f, 5.0f);
    for (int n = 1; n <= 4; n++) {
        (void)measure(&learn, &tuning, &good);
        CHECK_NEAR(1.0e-6, 1.0 - pow(0.75, n), learn.now.confidence);
    }
    begin(&learn, &tuning);
    const lode_telemetry_t half = seen(0.05f * 9.8e-3f, 5.0f);
    (void)measure(&learn, &tuning, &half);
    CHECK_NEAR(1.0e-5, 0.25 * 0.5, learn.now.confidence);
    begin(&learn, &tuning);
    for (int n = 0; n < 12; n++) {
        const lode_telemetry_t now = seen(5.9e-3f - learn.now.Lq_H, 5.0f);
        (void)measure(&learn, &tuning, &now);
    }
    CHECK_NEAR(1.0e-6, 5.9e-3, learn.now.Lq_H);
    TEST_ASSERT_TRUE(learn.now.confidence > 0.9f);
    const lode_telemetry_t other = seen(2.0e-3f, 5.0f);
    const float before = learn.now.confidence;
    (void)measure(&learn, &tuning, &other); // it does not fit any more
    CHECK_NEAR(1.0e-6, 0.75 * (double)before, learn.now.confidence);
}

/// Value and confidence, beside what the adaptation has told and all else that the telemetry has.
static void test_what_was_learned_is_reported(void) {
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    begin(&learn, &tuning);
    const lode_telemetry_t off = seen(1.0e-3f, 5.0f);
    for (int n = 0; n < 20; n++) {
        (void)measure(&learn, &tuning, &off);
    }
    lode_telemetry_t now = off;
    now.motor.psi_Wb = (lode_adapted_t){0.13f, 0.6f};
    lode_telemetry_t wanted = now;
    wanted.motor.Lq_H = (lode_adapted_t){learn.now.Lq_H, learn.now.confidence};
    lode_learn_telemetry(&learn, &now);
    TEST_ASSERT_TRUE(learn.now.Lq_H > 9.8e-3f);
    TEST_ASSERT_EQUAL_MEMORY(&wanted, &now, sizeof now);
}

static void test_limited(void) {
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    begin(&learn, &tuning);
    for (int n = 0; n < 20; n++) {
        lode_telemetry_t now = seen(-4.0e-3f, 5.0f);
        now.e_V.beta = 100.0f;
        (void)measure(&learn, &tuning, &now);
    }
    CHECK_NEAR(0.0, (double)tuning.Lq_H.min, learn.now.Lq_H);
    CHECK_NEAR(0.0, (double)tuning.psi_Wb.max, learn.now.psi_Wb);
}

static void test_frozen_where_not_both_tell_the_position(void) {
    for (int n = 0; n < 6; n++) {
        lode_learn_t learn;
        lode_learn_tuning_t tuning;
        begin(&learn, &tuning);
        lode_telemetry_t now = seen(1.0e-3f, 5.0f);
        lode_telemetry_t bad[6] = {now, now, now, now, now, now};
        bad[0].mode = LODE_MODE_START;
        bad[1].injected = 0.4f;
        bad[2].lock = 0.4f;
        bad[3].omega_rad_s = -60.0f;
        bad[4].i_A.q = 1.7f;
        bad[5].omega_rad_s = NAN;
        for (int k = 0; k < MEASURE_STEPS - 6; k++) {
            TEST_ASSERT_FALSE(lode_learn_step(&learn, &tuning, &now, DT_s));
        }
        TEST_ASSERT_FALSE(lode_learn_step(&learn, &tuning, &bad[n], DT_s));
        for (int k = 0; k < MEASURE_STEPS - 6; k++) { // the measurement begins anew
            TEST_ASSERT_FALSE(lode_learn_step(&learn, &tuning, &now, DT_s));
        }
        CHECK_NEAR(0.0, (double)9.8e-3f, learn.now.Lq_H);
    }
}

// (H18), and below 0.32 of rated speed not at all.
static void test_flux(void) {
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    begin(&learn, &tuning);
    lode_telemetry_t now = seen(0.0f, 5.0f);
    now.i_A.d = 2.0f;
    now.e_V = (lode_ab_t){-200.0f * (0.13f - 2.0f * 6.3e-3f), 0.0f};
    TEST_ASSERT_TRUE(measure(&learn, &tuning, &now));
    CHECK_NEAR(1.0e-5, 0.142 - 0.7 * 0.012, learn.now.psi_Wb);
    TEST_ASSERT_TRUE(measure(&learn, &tuning, &now)); // the next takes 0.7 of what is left
    CHECK_NEAR(1.0e-5, 0.13 + 0.09 * 0.012, learn.now.psi_Wb);
    begin(&learn, &tuning);
    now.omega_rad_s = 140.0f;
    now.e_V.alpha *= 0.7f;
    TEST_ASSERT_FALSE(measure(&learn, &tuning, &now));
    CHECK_NEAR(0.0, (double)0.142f, learn.now.psi_Wb);
    // The observer's part of the amplitude is taken back.
    begin(&learn, &tuning);
    tuning.droop_s2 = 2.5e-7f;
    now = seen(0.0f, 5.0f);
    now.e_V.beta /= 1.01f;
    (void)measure(&learn, &tuning, &now);
    CHECK_NEAR(1.0e-5, 0.142, learn.now.psi_Wb);
}

// The adaptation's: it stays as configured, whatever is stored and seen.
static void test_flux_may_be_somebody_elses(void) {
    const lode_drive_config_t config = learning();
    const lode_learned_t stored = {8.0e-3f, 0.13f, 0.9f};
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_learn_design(&tuning, &config, LODE_OFF));
    lode_learn_begin(&learn, &tuning, &config, &stored);
    lode_telemetry_t now = seen(1.0e-3f, 5.0f);
    now.e_V.beta *= 0.9f;
    TEST_ASSERT_TRUE(measure(&learn, &tuning, &now));
    CHECK_NEAR(1.0e-8, 8.0e-3 + 0.7e-3, learn.now.Lq_H);
    CHECK_NEAR(0.0, (double)config.motor.psi_Wb, learn.now.psi_Wb);
}

static void test_what_is_not_finite_teaches_nothing(void) {
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    begin(&learn, &tuning);
    lode_telemetry_t now = seen(1.0e-3f, 5.0f);
    now.emf_error_rad = NAN;
    TEST_ASSERT_FALSE(measure(&learn, &tuning, &now));
    now = seen(1.0e-3f, 5.0f);
    now.e_V.alpha = INFINITY;
    TEST_ASSERT_FALSE(measure(&learn, &tuning, &now));
    CHECK_NEAR(0.0, (double)9.8e-3f, learn.now.Lq_H);
    now = seen(1.0e-3f, 5.0f);
    TEST_ASSERT_TRUE(measure(&learn, &tuning, &now));
}

static void test_the_tuning_has_what_was_learned(void) {
    lode_learn_t learn;
    lode_learn_tuning_t tuning;
    lode_drive_config_t config = learning();
    begin(&learn, &tuning);
    learn.now = (lode_learned_t){7.0e-3f, 0.135f, 1.0f};
    static lode_drive_tuning_t drive;
    static lode_drive_tuning_t before;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&before, &config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_learn_tune(&learn, &drive, &config));
    CHECK_NEAR(1.0e-7, 3.5e-3 - 7.0e-3, drive.estimator.salient_H);
    CHECK_NEAR(1.0e-6, 0.135, drive.estimator.psi_Wb);
    CHECK_NEAR(1.0e-3, 1.0 / (2.0 * 25.0), drive.estimator.hfi.inv_full);
    CHECK_NEAR(1.0e-6, (double)before.estimator.hfi.omega_high, drive.estimator.hfi.omega_high);
    const lode_telemetry_t off = {.mode = LODE_MODE_OFF};
    TEST_ASSERT_FALSE(lode_learn_step(&learn, &tuning, &off, DT_s)); // it is in use
    learn.now.Lq_H = 3.6e-3f;
    const lode_drive_tuning_t kept = drive;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_HFI_SALIENCY, lode_learn_tune(&learn, &drive, &config));
    TEST_ASSERT_EQUAL_MEMORY(&kept, &drive, sizeof drive);
    TEST_ASSERT_FALSE(lode_learn_step(&learn, &tuning, &off, DT_s)); // nor tried again
}

/// A drive with a wrong Lq under load: the main loop of learn.h.
static void test_a_running_drive_learns(void) {
    static rig_t rig;
    static lode_drive_tuning_t tunings[2];
    lode_learn_t learn;
    lode_drive_config_t config = learning();
    config.motor.Lq_H *= 1.5f;
    config.hfi.Lq_i_max_H *= 1.5f;
    const lode_learn_tuning_t tuning = designed(&config);
    lode_learn_begin(&learn, &tuning, &config, NULL);
    rig_init(&rig, &tunings[0], &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 62.8f});
    int next = 1;
    for (int k = 0; k < (int)(4.5 / RIG_TS_s); k++) {
        rig_step(&rig);
        rig.pull_Nm = k * RIG_TS_s > 3.0 ? 3.0 : 0.0;
        lode_telemetry_t now;
        if (k % 10 == 0 && lode_drive_telemetry(&rig.drive, &now) &&
            lode_learn_step(&learn, &tuning, &now, 10.0f * (float)RIG_TS_s) &&
            lode_drive_tuning_taken(&rig.drive) &&
            lode_learn_tune(&learn, &tunings[next], &config) == LODE_OK) {
            TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &tunings[next]));
            next = 1 - next;
        }
        if (k * RIG_TS_s <= 3.0) { // no load, no q current: nothing shows
            CHECK_NEAR(0.0, (double)config.motor.Lq_H, learn.now.Lq_H);
        }
    }
    rig_expect(&rig, LODE_MODE_RUN);
    CHECK_NEAR(0.02 * 9.8e-3, 9.8e-3, learn.now.Lq_H);
    CHECK_NEAR(0.02 * 0.142, 0.142, learn.now.psi_Wb);
    TEST_ASSERT_TRUE(learn.now.confidence > 0.5f);
}

typedef struct {
    rig_t rig;
    lode_drive_tuning_t commissioned;
    lode_drive_tuning_t learned[2];
    int next; ///< of them
    lode_learn_tuning_t tuning;
    lode_learn_t learn;
    lode_adaptation_t adaptation;
} both_t;

/// The main loop of a drive that learns and adapts.
static void both_run(both_t *self, const lode_drive_config_t *config, double seconds) {
    const float dt_s = 10.0f * (float)RIG_TS_s;
    for (int k = 0; k < (int)(seconds / RIG_TS_s); k++) {
        rig_step(&self->rig);
        lode_telemetry_t now;
        if (k % 10 != 0) {
            continue;
        }
        if (lode_drive_telemetry(&self->rig.drive, &now) &&
            lode_learn_step(&self->learn, &self->tuning, &now, dt_s) &&
            lode_drive_tuning_taken(&self->rig.drive) &&
            lode_learn_tune(&self->learn, &self->learned[self->next], config) == LODE_OK) {
            TEST_ASSERT_TRUE(lode_adaptation_post(&self->adaptation, &self->rig.drive,
                                                  &self->learned[self->next]));
            self->next = 1 - self->next;
        }
        (void)lode_adaptation_step(&self->adaptation, &self->rig.drive);
    }
}

/// Lq, psi and R wrong at once: R at rest under load, then Lq and psi at 600 rpm. None of the three pulls at another.
static void test_learning_beside_the_adaptation(void) {
    static both_t both;
    static const lode_adaptation_config_t choices = {.J = LODE_OFF};
    both = (both_t){.next = 0};
    lode_drive_config_t config = learning();
    config.motor.Lq_H *= 1.5f;
    config.hfi.Lq_i_max_H *= 1.5f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_learn_design(&both.tuning, &config, LODE_OFF));
    lode_learn_begin(&both.learn, &both.tuning, &config, NULL);
    rig_init(&both.rig, &both.commissioned, &config);
    both.rig.motor.psi *= 0.9;
    both.rig.motor.R *= 1.3;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_adaptation_init(&both.adaptation, &choices,
                                                        &both.commissioned, &config.motor, NULL));
    rig_command(&both.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 62.8f});
    both_run(&both, &config, 3.0);
    rig_command(&both.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 0.0f});
    both_run(&both, &config, 2.0);
    const float Lq_H = both.learn.now.Lq_H;
    both.rig.pull_Nm = 3.0;
    both_run(&both, &config, 10.0);
    lode_adaptation_found_t found = lode_adaptation_found(&both.adaptation);
    CHECK_NEAR(0.03, 1.3, (double)(found.Rs_Ohm.value / config.motor.Rs_Ohm));
    TEST_ASSERT_TRUE(found.Rs_Ohm.confidence > 0.5f);
    CHECK_NEAR(0.0, (double)Lq_H, both.learn.now.Lq_H); // no EMF
    rig_command(&both.rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 62.8f});
    both_run(&both, &config, 6.0);
    for (int n = 0; n < 2; n++) { // and they stay
        found = lode_adaptation_found(&both.adaptation);
        CHECK_NEAR(0.03 * 9.8e-3, 9.8e-3, both.learn.now.Lq_H);
        TEST_ASSERT_TRUE(both.learn.now.confidence > 0.5f);
        CHECK_NEAR(0.015, 0.9, (double)(found.psi_Wb.value / config.motor.psi_Wb));
        CHECK_NEAR(0.05, 1.3, (double)(found.Rs_Ohm.value / config.motor.Rs_Ohm));
        CHECK_NEAR(0.0, (double)config.motor.psi_Wb, both.learn.now.psi_Wb);
        both_run(&both, &config, 20.0);
    }
    rig_expect(&both.rig, LODE_MODE_RUN);
    TEST_ASSERT_FLOAT_WITHIN(0.02f, 0.9f,
                             both.rig.drive.tuning->references.psi_Wb / config.motor.psi_Wb);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_refusals);
    RUN_TEST(test_limits);
    RUN_TEST(test_an_open_configuration_is_designed);
    RUN_TEST(test_what_was_stored_is_taken_within_limits);
    RUN_TEST(test_a_measurement_corrects_Lq);
    RUN_TEST(test_a_measurement_with_current_in_d);
    RUN_TEST(test_a_measurement_at_the_least_of_all);
    RUN_TEST(test_measurements_converge_and_are_believed);
    RUN_TEST(test_what_was_learned_is_reported);
    RUN_TEST(test_limited);
    RUN_TEST(test_frozen_where_not_both_tell_the_position);
    RUN_TEST(test_flux);
    RUN_TEST(test_flux_may_be_somebody_elses);
    RUN_TEST(test_what_is_not_finite_teaches_nothing);
    RUN_TEST(test_the_tuning_has_what_was_learned);
    RUN_TEST(test_a_running_drive_learns);
    RUN_TEST(test_learning_beside_the_adaptation);
    return UNITY_END();
}
