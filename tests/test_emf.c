// Back-EMF observer against float64: recursion, lag, active flux, limits of its configuration.
#include "support/fields.h"

#include "emf_inline.h"
#include "golden/emf.h"

void setUp(void) {}

void tearDown(void) {}

static lode_motor_t motor_of(const emf_case_t *golden) {
    lode_motor_t motor = paper_motor();
    motor.Rs_Ohm = (float)golden->Rs_Ohm;
    motor.Ld_H = (float)golden->Ld_H;
    motor.Lq_H = (float)golden->Lq_H;
    motor.psi_Wb = (float)golden->psi_Wb;
    return motor;
}

static lode_emf_tuning_t tuned(const lode_motor_t *motor, double w0, bool active_flux, double ts) {
    lode_emf_config_t config = {.kind = LODE_EMF_C_LESO, .w0_rad_s = (float)w0};
    lode_emf_design(&config, motor, 100.0f, (float)ts);
    lode_emf_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_emf_tune(&tuning, &config, motor, 0.0f, active_flux, (float)ts));
    return tuning;
}

/// One step with the rotor at `theta`, turning by w Ts = `turn`: what the estimator makes of the parts.
static lode_ab_t step(lode_emf_t *emf, const lode_emf_tuning_t *tuning, lode_ab_t u, lode_ab_t i,
                      double theta, double turn, bool known) {
    const float id_before = lode_park(emf->i_A, sincos_of(theta - turn)).d;
    lode_ab_t m = lode_emf_dead_beat(emf, tuning, u, i);
    if (known) {
        const float rise = lode_park(i, sincos_of(theta)).d - id_before;
        m = lode_emf_less_salient(tuning, m, rise, sincos_of(theta - 0.5 * turn));
    }
    return lode_observer_step(&emf->observer, &tuning->observer, m, sincos_of(turn),
                              (float)(turn / 2.0e-4));
}

static void check_golden(const emf_case_t *g) {
    const lode_motor_t motor = motor_of(g);
    const lode_emf_tuning_t tuning = tuned(&motor, g->w0_rad_s, g->active_flux != 0, g->ts_s);
    lode_emf_t emf;
    lode_emf_reset(&emf, (lode_ab_t){0.0f, 0.0f});
    for (int k = 0; k < EMF_STEPS; k++) {
        const lode_ab_t u = {(float)g->u_alpha[k], (float)g->u_beta[k]};
        const lode_ab_t i = {(float)g->i_alpha[k], (float)g->i_beta[k]};
        const lode_ab_t e = step(&emf, &tuning, u, i, g->theta[k], g->omega_rad_s * g->ts_s, true);
        // Currents of float resolution, times Lq/Ts or 1/b, become voltage noise: 1e-6 of the
        // greatest voltage that a current change stands for.
        const double scale = (double)tuning.inv_b * hypot(g->i_alpha[k], g->i_beta[k]) +
                             hypot(g->u_alpha[k], g->u_beta[k]) +
                             hypot(g->e_alpha[k], g->e_beta[k]);
        CHECK_NEAR(1.0e-6 * scale, g->e_alpha[k], e.alpha);
        CHECK_NEAR(1.0e-6 * scale, g->e_beta[k], e.beta);
    }
}

static void test_observer_against_float64(void) {
    for (int i = 0; i < COUNT_OF(emf_cases); i++) {
        check_golden(&emf_cases[i]);
    }
}

static double lag_of(double R, double Lq, double ts, double w0, double omega) {
    lode_motor_t motor = paper_motor();
    motor.Rs_Ohm = (float)R;
    motor.Lq_H = (float)Lq;
    const lode_emf_config_t config = {.kind = LODE_EMF_C_LESO, .w0_rad_s = (float)w0};
    return (double)lode_emf_lag_rad(&config, &motor, (float)ts, (float)omega);
}

static void test_lag_of_the_simulated_observer(void) {
    for (int i = 0; i < COUNT_OF(lag_cases); i++) {
        const lag_case_t *g = &lag_cases[i];
        // Three arc tangents of 1e-6 each.
        CHECK_NEAR(4.0e-6, g->lag_rad,
                   lag_of(g->Rs_Ohm, g->Lq_H, g->ts_s, g->w0_rad_s, g->omega_rad_s));
    }
}

static void test_lag_of_the_papers_motor(void) {
    // Degrees, computed independently and printed to 0.001.
    const double table[][2] = {
        {100.0, 1.643}, {300.0, 4.926}, {900.0, 14.685}, {1500.0, 24.169}, {3000.0, 45.768}};
    for (int i = 0; i < COUNT_OF(table); i++) {
        const double omega = paper_omega(table[i][0]);
        const double lag = lag_of(0.75, 9.8e-3, 2.0e-4, 2000.0, omega);
        CHECK_NEAR(6.0e-4, table[i][1], lag / CHECK_DEG);
        // Near what eq. (30) says of the continuous observer: 2 atan(w/w0), less a tenth.
        CHECK_CLOSE(0.1, 2.0 * atan(omega / 2000.0), lag);
    }
}

static void test_lag_is_odd(void) {
    for (int rpm = 50; rpm <= 4000; rpm += 50) {
        const double omega = paper_omega((double)rpm);
        CHECK_NEAR(1.0e-7, -lag_of(0.75, 9.8e-3, 2.0e-4, 2000.0, omega),
                   lag_of(0.75, 9.8e-3, 2.0e-4, 2000.0, -omega));
    }
    CHECK_NEAR(1.0e-7, 0.0, lag_of(0.75, 9.8e-3, 2.0e-4, 2000.0, 0.0));
}

static void test_gain_at_standstill_is_one(void) {
    // A constant EMF of (30, -12) V against no voltage: the steady current is -e/R.
    const lode_motor_t motor = paper_motor();
    const lode_emf_tuning_t tuning = tuned(&motor, 2000.0, true, 2.0e-4);
    lode_emf_t emf;
    const lode_ab_t i = {(float)(-30.0 / 0.75), (float)(12.0 / 0.75)};
    lode_emf_reset(&emf, i);
    lode_ab_t e = {0.0f, 0.0f};
    for (int k = 1; k <= 200; k++) {
        e = step(&emf, &tuning, (lode_ab_t){0.0f, 0.0f}, i, 0.0, 0.0, true);
        // Double pole p, step response 1 - p^n (1 + n (1 - p)).
        const double p = exp(-0.4);
        const double rise = 1.0 - pow(p, k) * (1.0 + k * (1.0 - p));
        CHECK_NEAR(2.0e-5, 30.0 * rise, e.alpha); // 6e-7 of 30 V
        CHECK_NEAR(2.0e-5, -12.0 * rise, e.beta);
    }
}

static void test_reset_starts_from_the_current(void) {
    lode_emf_t emf;
    memset(&emf, 0xff, sizeof emf); // all NaN
    lode_emf_reset(&emf, (lode_ab_t){-7.0f, 8.0f});
    const lode_emf_t expected = {.i_A = {-7.0f, 8.0f}};
    TEST_ASSERT_EQUAL_MEMORY(&expected, &emf, sizeof emf);
}

static void test_observer_is_linear(void) {
    const lode_motor_t motor = paper_motor();
    const lode_emf_tuning_t tuning = tuned(&motor, 1500.0, true, 2.0e-4);
    random_t random = random_seed(1);
    lode_emf_t one;
    lode_emf_t two;
    lode_emf_reset(&one, (lode_ab_t){0.0f, 0.0f});
    lode_emf_reset(&two, (lode_ab_t){0.0f, 0.0f});
    for (int k = 0; k < 1000; k++) {
        const lode_ab_t u = {random_float(&random, -100.0, 100.0),
                             random_float(&random, -100.0, 100.0)};
        const lode_ab_t i = {random_float(&random, -10.0, 10.0),
                             random_float(&random, -10.0, 10.0)};
        const double theta = random_between(&random, -3.0, 3.0);
        const lode_ab_t a = step(&one, &tuning, u, i, theta, 0.04, true);
        // A factor of -4 is exact in binary.
        const lode_ab_t b = step(&two, &tuning, lode_ab_scale(-4.0f, u), lode_ab_scale(-4.0f, i),
                                 theta, 0.04, true);
        TEST_ASSERT_TRUE(b.alpha == -4.0f * a.alpha && b.beta == -4.0f * a.beta);
    }
}

static void test_active_flux_can_be_left_in(void) {
    lode_motor_t motor = paper_motor();
    CHECK_NEAR(0.0, 0.0, tuned(&motor, 2000.0, false, 2.0e-4).salient_Ohm);
    CHECK_CLOSE(1.0e-6, -6.3e-3 / 2.0e-4, tuned(&motor, 2000.0, true, 2.0e-4).salient_Ohm);
    motor.Ld_H = motor.Lq_H;
    CHECK_NEAR(0.0, 0.0, tuned(&motor, 2000.0, true, 2.0e-4).salient_Ohm);
}

static void test_without_an_angle_the_active_flux_stays_in(void) {
    // An angle that is not known yet must not put a term of its own into the estimate.
    const lode_motor_t motor = paper_motor();
    const lode_emf_tuning_t with = tuned(&motor, 2000.0, true, 2.0e-4);
    const lode_emf_tuning_t without = tuned(&motor, 2000.0, false, 2.0e-4);
    lode_emf_t one;
    lode_emf_t two;
    lode_emf_reset(&one, (lode_ab_t){0.0f, 0.0f});
    lode_emf_reset(&two, (lode_ab_t){0.0f, 0.0f});
    random_t random = random_seed(3);
    for (int k = 0; k < 1000; k++) {
        const lode_ab_t u = {random_float(&random, -100.0, 100.0),
                             random_float(&random, -100.0, 100.0)};
        const lode_ab_t i = {random_float(&random, -10.0, 10.0),
                             random_float(&random, -10.0, 10.0)};
        const double theta = random_between(&random, -3.0, 3.0);
        const lode_ab_t a = step(&one, &with, u, i, theta, 0.04, false);
        const lode_ab_t b = step(&two, &without, u, i, theta, 0.04, true);
        TEST_ASSERT_TRUE(a.alpha == b.alpha && a.beta == b.beta);
    }
}

/// Completed but for the bandwidth.
static lode_emf_config_t with_bandwidth(float w0_rad_s) {
    const lode_motor_t motor = paper_motor();
    lode_emf_config_t config = {.kind = LODE_EMF_C_LESO};
    lode_emf_design(&config, &motor, 100.0f, PAPER_TS_s);
    config.w0_rad_s = w0_rad_s;
    return config;
}

static lode_status_t try_with(const lode_emf_config_t *config, const lode_motor_t *motor) {
    lode_emf_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_emf_tuning_t before = tuning;
    const lode_status_t status = lode_emf_tune(&tuning, config, motor, 0.0f, true, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_emf_config_t config = with_bandwidth(2000.0f);
    field_set(&config, offset, value);
    const lode_motor_t motor = paper_motor();
    return try_with(&config, &motor);
}

static void test_bandwidth_at_its_limits(void) {
    static const field_t field = {FIELD(lode_emf_config_t, w0_rad_s), .lo = 1.0f, .hi = 1.0e4f,
                                  .computed = true, .error = LODE_ERROR_EMF_W0}; // 2/Ts
    field_check(&field, try_one);
}

static void test_kind_is_an_enumerator(void) {
    const lode_motor_t motor = paper_motor();
    lode_emf_config_t config = with_bandwidth(2000.0f);
    config.kind = (lode_emf_kind_t)77;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_EMF_KIND, try_with(&config, &motor));
}

static void test_a_current_that_settles_within_a_period_is_refused(void) {
    const lode_emf_config_t config = with_bandwidth(2000.0f);
    lode_motor_t motor = paper_motor();
    motor.Rs_Ohm = 60.0f; // Ld/R = 58 us of a period of 200 us
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_PERIOD, try_with(&config, &motor));
    motor.Rs_Ohm = 0.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_with(&config, &motor));
}

static void test_design_fills_the_bandwidth(void) {
    const lode_motor_t motor = paper_motor();
    lode_emf_config_t config = {.kind = LODE_EMF_C_LESO, .w0_rad_s = 0.0f};
    lode_emf_design(&config, &motor, 100.0f, 1.0e-4f);
    CHECK_CLOSE(1.0e-6, 4.25 * PAPER_OMEGA_RATED, config.w0_rad_s);
    config.w0_rad_s = 0.0f;
    // Not less at few periods per turn, up to what is accepted: a slower one turns with the EMF's size (E29).
    lode_emf_design(&config, &motor, 100.0f, 9.0e-4f);
    CHECK_CLOSE(1.0e-6, 4.25 * PAPER_OMEGA_RATED, config.w0_rad_s);
    config.w0_rad_s = 0.0f;
    lode_emf_design(&config, &motor, 100.0f, 1.0e-3f);
    CHECK_CLOSE(1.0e-6, 2000.0, config.w0_rad_s);
    config.w0_rad_s = 123.0f;
    lode_emf_design(&config, &motor, 100.0f, 1.0e-4f);
    TEST_ASSERT_EQUAL_FLOAT(123.0f, config.w0_rad_s);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_observer_against_float64);
    RUN_TEST(test_lag_of_the_simulated_observer);
    RUN_TEST(test_lag_of_the_papers_motor);
    RUN_TEST(test_lag_is_odd);
    RUN_TEST(test_gain_at_standstill_is_one);
    RUN_TEST(test_reset_starts_from_the_current);
    RUN_TEST(test_observer_is_linear);
    RUN_TEST(test_active_flux_can_be_left_in);
    RUN_TEST(test_without_an_angle_the_active_flux_stays_in);
    RUN_TEST(test_bandwidth_at_its_limits);
    RUN_TEST(test_kind_is_an_enumerator);
    RUN_TEST(test_a_current_that_settles_within_a_period_is_refused);
    RUN_TEST(test_design_fills_the_bandwidth);
    return UNITY_END();
}
