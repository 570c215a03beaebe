// Noise of the current sensors, and the speed to which the vector of a start turns (S49).
#include "support/check.h"

#include "emf_inline.h"
#include "support/rig.h"

void setUp(void) {}

void tearDown(void) {}

static lode_drive_tuning_t tuning;

/// Of white noise on each axis of a current that rests: root of the mean square of the estimated EMF's.
static double emf_noise_V(double w0, double ts, double noise_A) {
    lode_emf_config_t config = {.kind = LODE_EMF_C_LESO, .w0_rad_s = (float)w0};
    const lode_motor_t motor = paper_motor();
    lode_emf_design(&config, &motor, 100.0f, (float)ts);
    lode_emf_tuning_t emf_tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_emf_tune(&emf_tuning, &config, &motor, 0.0f, true, (float)ts));
    lode_emf_t emf;
    lode_emf_reset(&emf, (lode_ab_t){0.0f, 0.0f});
    random_t random = random_seed(49u);
    const double half = noise_A * sqrt(3.0); // of an even distribution
    double sum_V2 = 0.0;
    const int count = CHECK_TRIES(100000);
    for (int k = 0; k < count; k++) {
        const lode_ab_t i = {random_float(&random, -half, half),
                             random_float(&random, -half, half)};
        const lode_ab_t m = lode_emf_dead_beat(&emf, &emf_tuning, (lode_ab_t){0.0f, 0.0f}, i);
        const lode_ab_t e = lode_observer_step(&emf.observer, &emf_tuning.observer, m,
                                               (lode_sincos_t){0.0f, 1.0f}, 0.0f);
        sum_V2 += (double)e.alpha * (double)e.alpha;
    }
    return sqrt(sum_V2 / count);
}

/// Lq/Ts sigma sqrt(2 (1-p)^3/(1+p)^3), p = exp(-w0 Ts).
static void test_what_noise_of_the_currents_makes_of_the_emf(void) {
    const double w0[] = {500.0, 2000.0, 7000.0};
    for (int k = 0; k < COUNT_OF(w0); k++) {
        const double p = exp(-w0[k] * 2.0e-4);
        const double filters = (1.0 - p) / (1.0 + p);
        const double wanted = 9.8e-3 / 2.0e-4 * 0.05 * sqrt(2.0 * filters * filters * filters);
        CHECK_CLOSE(0.05, wanted, emf_noise_V(w0[k], 2.0e-4, 0.05));
    }
}

/// Ten times that over psi, by the mean square of three samples, 12 of those of an axis.
static void test_speed_by_noise_is_that_of_the_observer(void) {
    lode_drive_config_t config = rig_config();
    config.motor.omega_rated_rad_s = 2000.0f / 4.25f;
    config.estimator.emf.w0_rad_s = 2000.0f;
    lode_drive_t drive;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&drive, &tuning, &config));
    CHECK_CLOSE(1.0e-4, 2.52095, tuning.start.omega_per_noise);
    CHECK_CLOSE(1.0e-6, 2.5 * (double)tuning.start.omega_handover, tuning.start.omega_most);
    config.start.omega_handover_rad_s = 90.0f; // which is meant
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&drive, &tuning, &config));
    TEST_ASSERT_EQUAL_FLOAT(90.0f, tuning.start.omega_most);
}

/// Half of base speed bounds it too, but not below the speed of the hand-over.
static void test_speed_by_noise_leaves_half_of_the_speeds(void) {
    lode_drive_config_t config = rig_config();
    config.motor.omega_rated_rad_s = 3.0f * 47.0f;
    config.inverter.dead_time_s = 0.0f;
    lode_drive_t drive;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&drive, &tuning, &config));
    const double handover = (double)tuning.start.omega_handover;
    CHECK_CLOSE(1.0e-6, fmax(0.5 * 141.0, handover), tuning.start.omega_most);
    CHECK_AT_MOST(2.4 * handover, (double)tuning.start.omega_most);
}

/// The start's target, over the speed of the hand-over, with so many times the noise that makes just that; of an attempt that
/// has waited for its lock for a share of its time.
static double target_of(double direction, double times, double waited) {
    lode_drive_config_t config = rig_config();
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig,
                (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = (float)(30.0 * direction)});
    lode_start_t *start = &rig.drive.state.start;
    for (int n = 0; n < 10000 && !(rig.drive.mode == (uint_least8_t)LODE_MODE_START &&
                                   start->stage == (uint_least8_t)LODE_START_TURN);
         n++) {
        rig_step(&rig);
    }
    const float handover = tuning.start.omega_handover;
    const float noise_V = (float)times * handover / tuning.start.omega_per_noise;
    rig.blocked = true;
    start->locked = 0u;
    for (int n = 0; n < 8; n++) {
        rig.drive.jump.noise_V2 = noise_V * noise_V;
        rig_step(&rig);
    }
    // By the profile to that speed, and so to one that rises with it.
    for (int k = 0; k < 20 && waited > 0.0; k++) {
        const float most = lode_max(lode_abs(start->omega_target), handover);
        const float profile = tuning.start.still_rounds + most / (8.0f * tuning.start.omega_step);
        const float patience = lode_max(profile, (float)tuning.start.patience_rounds);
        start->attempt = (uint_least16_t)(profile + (float)waited * patience);
        for (int n = 0; n < 8; n++) {
            rig.drive.jump.noise_V2 = noise_V * noise_V;
            rig_step(&rig);
        }
    }
    rig_expect(&rig, LODE_MODE_START);
    return (double)start->omega_target / (double)handover;
}

static void test_noise_raises_the_speed_of_a_start(void) {
    for (double sign = -1.0; sign <= 1.0; sign += 2.0) {
        CHECK_NEAR(1.0e-6, sign * 1.0, target_of(sign, 0.0, 0.0));
        CHECK_NEAR(1.0e-6, sign * 1.0, target_of(sign, 0.9, 0.0));
        CHECK_NEAR(0.05, sign * 1.6, target_of(sign, 1.6, 0.0));
        CHECK_NEAR(1.0e-6, sign * 2.5, target_of(sign, 9.0, 0.0));
    }
}

static void test_a_vector_that_waits_for_its_lock_turns_faster(void) {
    CHECK_NEAR(0.06, 1.5 * 1.4, target_of(1.0, 1.4, 0.5));
    CHECK_NEAR(0.04, 1.5 * 0.8, target_of(1.0, 0.8, 0.5));
    CHECK_NEAR(1.0e-6, 1.0, target_of(1.0, 0.45, 0.9)); // the clean board of a user
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_what_noise_of_the_currents_makes_of_the_emf);
    RUN_TEST(test_speed_by_noise_is_that_of_the_observer);
    RUN_TEST(test_speed_by_noise_leaves_half_of_the_speeds);
    RUN_TEST(test_noise_raises_the_speed_of_a_start);
    RUN_TEST(test_a_vector_that_waits_for_its_lock_turns_faster);
    return UNITY_END();
}
