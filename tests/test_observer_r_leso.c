// R-LESO: float64, the C-LESO in the rotor's frame, gain at any frequency, stability with the PLL.
// What holds for every observer is in test_observer.c and test_estimator_kinds.c.
#include <complex.h>

#include "support/check.h"

#include "emf_inline.h"
#include "lodestar/estimator.h"

#include "golden/r_leso.h"

#define TS 2.0e-4

void setUp(void) {}

void tearDown(void) {}

static lode_observer_tuning_t tuned(lode_emf_kind_t kind, double w0) {
    lode_observer_config_t config = {.kind = kind, .w0_rad_s = (float)w0};
    lode_observer_tuning_t tuning;
    lode_observer_design(&config, (float)PAPER_OMEGA_RATED, 100.0f, PAPER_TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_observer_tune(&tuning, &config, 0.0f, PAPER_TS_s));
    return tuning;
}

static double complex feed(lode_observer_t *state, const lode_observer_tuning_t *tuning,
                           double omega, double complex m) {
    const lode_ab_t m_V = {(float)creal(m), (float)cimag(m)};
    const lode_ab_t e = lode_observer_step(state, tuning, m_V, sincos_of(omega * TS), (float)omega);
    return (double)e.alpha + I * (double)e.beta;
}

// --- The filter ----------------------------------------------------------------------------------

/// The input that golden/gen_r_leso.py describes.
static double complex golden_input(double angle, int k) {
    const double chirp = 1.7 * (double)((k % 1000) * (k % 1000));
    return 60.0 * cexp(I * angle) + 3.6 * cexp(-5.0 * I * angle) + 2.4 * cexp(7.0 * I * angle) +
           (2.0 - 1.0 * I) + cos(chirp) + I * sin(0.6 * chirp);
}

static void test_recursion_against_float64(void) {
    for (int i = 0; i < COUNT_OF(r_leso_cases); i++) {
        const r_leso_case_t *g = &r_leso_cases[i];
        const lode_observer_tuning_t tuning = tuned(LODE_EMF_R_LESO, g->w0);
        lode_observer_t state;
        lode_observer_reset(&state);
        double angle = 0.0;
        for (int k = 0; k < R_LESO_STEPS; k++) {
            const double omega = g->w_from + (g->w_to - g->w_from) * k / R_LESO_STEPS;
            angle += omega * TS;
            const double complex e = feed(&state, &tuning, omega, golden_input(angle, k));
            if ((k + 1) % R_LESO_EVERY == 0) {
                // 60 V rounded to 6e-8, held for 1/(w0 Ts) = 25 periods by each of two stages.
                CHECK_NEAR(1.0e-4, g->e_alpha[k / R_LESO_EVERY], creal(e));
                CHECK_NEAR(1.0e-4, g->e_beta[k / R_LESO_EVERY], cimag(e));
            }
        }
    }
}

static void test_in_the_rotors_frame_it_is_the_c_leso(void) {
    // Random inputs, and a speed that jumps about: R on m exp(j angle) is C on m, rotated.
    const lode_observer_tuning_t r_tuning = tuned(LODE_EMF_R_LESO, 1500.0);
    const lode_observer_tuning_t c_tuning = tuned(LODE_EMF_C_LESO, 1500.0);
    lode_observer_t r;
    lode_observer_t c;
    lode_observer_reset(&r);
    lode_observer_reset(&c);
    random_t random = random_seed(11);
    double angle = 0.0;
    double omega = 0.0;
    for (int k = 0; k < 5000; k++) {
        omega = k % 50 == 0 ? random_between(&random, -2500.0, 2500.0) : omega;
        angle += omega * TS;
        const double complex m =
            random_between(&random, -1.0, 1.0) + I * random_between(&random, -1.0, 1.0);
        const double complex in_r = feed(&r, &r_tuning, omega, m * cexp(I * angle));
        const double complex in_c = feed(&c, &c_tuning, 0.0, m);
        CHECK_AT_MOST(2.0e-6, cabs(in_r * cexp(-I * angle) - in_c));
    }
}

static void test_gain_at_any_frequency(void) {
    const double omega = 400.0;
    const double p = exp(-2000.0 * TS);
    const lode_observer_tuning_t tuning = tuned(LODE_EMF_R_LESO, 2000.0);
    for (double f = -4000.0; f <= 4000.0; f += 400.0) { // 400 is the speed itself
        lode_observer_t state;
        lode_observer_reset(&state);
        double complex h = 0.0;
        for (int k = 0; k < 400; k++) {
            const double complex m = cexp(I * f * TS * k);
            h = feed(&state, &tuning, omega, m) / m;
        }
        const double complex stage = (1.0 - p) / (1.0 - p * cexp(I * (omega - f) * TS));
        CHECK_AT_MOST(3.0e-6, cabs(h - stage * stage));
    }
}

// --- With the PLL --------------------------------------------------------------------------------

static void multiply(double *c, int *order, double root) {
    c[*order + 1] = 0.0;
    for (int i = ++*order; i > 0; i--) {
        c[i] -= root * c[i - 1];
    }
}

/// Schur and Cohn: all roots of c[0] z^n + .. + c[n] inside the unit circle.
static bool is_schur(const double *coefficients, int n) {
    double c[8];
    memcpy(c, coefficients, (size_t)(n + 1) * sizeof c[0]);
    for (; n > 0; n--) {
        const double k = c[n] / c[0];
        if (!(fabs(k) < 1.0)) {
            return false;
        }
        double next[8];
        for (int i = 0; i < n; i++) {
            next[i] = c[i] - k * c[n - i];
        }
        memcpy(c, next, sizeof c);
    }
    return true;
}

/// The characteristic polynomial of docs/theory/r_leso.md.
static bool is_stable(double w0, double sigma, double ts, bool third) {
    const double p = exp(-w0 * ts);
    const double s = exp(-sigma * ts);
    const double x = 1.0 - s;
    double c[8] = {1.0};
    int n = 0;
    multiply(c, &n, p);
    multiply(c, &n, p);
    for (int i = 0; i < (third ? 3 : 2); i++) {
        multiply(c, &n, s);
    }
    // p z ((2 - p) z - p)(z - 1) times L2 (z - 1) + L3 z, or x^2.
    const double l2 = third ? 1.5 * (1.0 + s) * x * x : x * x;
    const double l3 = third ? x * x * x : 0.0;
    double d[8] = {p * (2.0 - p), -p * p};
    int m = 1;
    multiply(d, &m, 1.0);
    const double high = third ? l2 + l3 : 0.0;
    const double low = third ? -l2 : l2;
    for (int i = 0; i <= m; i++) { // the product is m + 2 long with its factor z: 4 or 3 of degree
        const int at = n - 1 - m;
        c[at + i] -= low * d[i];
        c[at - 1 + i] -= high * d[i];
    }
    return is_schur(c, n);
}

static double least_w0(double sigma, double ts, bool third) {
    double low = 0.1 * sigma;
    double high = 4.0 * sigma;
    for (int k = 0; k < 50; k++) {
        const double middle = 0.5 * (low + high);
        *(is_stable(middle, sigma, ts, third) ? &high : &low) = middle;
    }
    return high;
}

static void test_least_w0_is_where_the_polynomial_says(void) {
    // sigma Ts, LESO-QPLL, QPLL: the table of docs/theory/r_leso.md, printed to 0.001.
    const double table[][3] = {{0.01, 1.666, 0.323}, {0.02, 1.649, 0.321}, {0.05, 1.600, 0.315},
                               {0.1, 1.527, 0.306},  {0.2, 1.406, 0.290},  {0.3, 1.310, 0.275}};
    for (int k = 0; k < COUNT_OF(table); k++) {
        for (int third = 0; third < 2; third++) {
            const double found = least_w0(1.0, table[k][0], third != 0);
            CHECK_NEAR(6.0e-4, table[k][third != 0 ? 1 : 2], found);
        }
    }
    // Where the period goes to zero, by a line through two of them: the roots of
    // 4 x^3 + 12 x^2 - 6 x - 43 and x^3 + 3 x^2 + 2 x - 1. What is left is of the order (sigma Ts)^2.
    const double x = 1.683582;
    const double y = 0.324718;
    CHECK_NEAR(1.0e-4, 0.0, ((4.0 * x + 12.0) * x - 6.0) * x - 43.0);
    CHECK_NEAR(1.0e-4, 0.0, ((y + 3.0) * y + 2.0) * y - 1.0);
    CHECK_NEAR(1.0e-3, x, 2.0 * least_w0(1.0, 0.01, true) - least_w0(1.0, 0.02, true));
    CHECK_NEAR(1.0e-3, y, 2.0 * least_w0(1.0, 0.01, false) - least_w0(1.0, 0.02, false));
}

static lode_status_t try_pll(double w0, double sigma, bool third) {
    const lode_observer_config_t config = {.kind = LODE_EMF_R_LESO, .w0_rad_s = (float)w0};
    return lode_observer_check_pll(&config, (float)sigma, third);
}

static void test_bandwidth_that_the_pll_asks_for(void) {
    const double least[] = {0.3247, 1.6836};
    for (int third = 0; third < 2; third++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_pll(1.001 * least[third] * 300.0, 300.0, third != 0));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_OBSERVER,
                              try_pll(0.999 * least[third] * 300.0, 300.0, third != 0));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_OBSERVER, try_pll(NAN, 300.0, third != 0));
        for (double sigma_Ts = 0.01; sigma_Ts <= 0.3; sigma_Ts *= 1.3) {
            TEST_ASSERT_TRUE(is_stable(least[third] * sigma_Ts, sigma_Ts, 1.0, third != 0));
        }
    }
    // And the same through the estimator's init.
    const lode_motor_t motor = paper_motor();
    lode_estimator_config_t config = {.emf = {.kind = LODE_EMF_R_LESO, .w0_rad_s = 300.0f},
                                      .pll = {.sigma_rad_s = 180.0f}};
    lode_estimator_tuning_t tuning;
    lode_estimator_design(&config, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_OBSERVER,
                          lode_estimator_tune(&tuning, &config, &motor, PAPER_TS_s));
    config.pll.sigma_rad_s = config.pll.sigma_low_rad_s = 178.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_estimator_tune(&tuning, &config, &motor, PAPER_TS_s));
}

/// How much the swing of the PLL's angle grows from the first 0.2 s to the last of 1 s, after it was put off
/// by 0.02 rad. EMF of 20 V, no current.
static double growth(double w0, double sigma) {
    lode_motor_t motor = paper_motor();
    motor.B_Nms = 0.0f;
    motor.psi_Wb = 0.05f; // of 20 V at 400 rad/s
    lode_estimator_config_t config = {.emf = {.kind = LODE_EMF_R_LESO},
                                      .pll = {.sigma_rad_s = (float)sigma}};
    lode_estimator_tuning_t tuning;
    lode_estimator_design(&config, &motor, PAPER_TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_estimator_tune(&tuning, &config, &motor, PAPER_TS_s));
    lode_estimator_t estimator;
    lode_estimator_reset(&estimator, &tuning);
    const double omega = 400.0;
    double theta = 0.0;
    double rest = 0.0;
    worst_t swing[2] = {{0.0}, {0.0}};
    for (int k = 0; k < 10000; k++) {
        if (k == 5000) {
            tuning.emf.observer = tuned(LODE_EMF_R_LESO, w0);
            estimator.pll.frame = lode_angle_add(estimator.pll.frame, sincos_of(0.02));
        }
        theta = remainder(theta + omega * TS, 2.0 * CHECK_PI);
        const double complex m = 20.0 * I * cexp(I * theta);
        (void)lode_estimator_step(&estimator, &tuning,
                                  (lode_ab_t){(float)creal(m), (float)cimag(m)},
                                  (lode_ab_t){0.0f, 0.0f});
        const lode_sincos_t frame = estimator.pll.frame;
        const double error = angle_error(atan2((double)frame.sin, (double)frame.cos), theta);
        rest = k < 5000 ? error : rest;
        if (k >= 5500 && k < 6500) {
            worst_note(&swing[0], error - rest);
        } else if (k >= 9000) {
            worst_note(&swing[1], error - rest);
        }
    }
    return swing[1].value / swing[0].value;
}

static void test_the_estimator_swings_as_calculated(void) {
    // w0/sigma and the real part of the least damped pole of the polynomial at sigma Ts = 0.01, 1/s: the
    // edge is at 1.666. The peaks lie 0.7 s apart, but for half a swing of 75 ms either way.
    const double table[][2] = {{1.5, 1.339}, {1.6, 0.535}, {1.72, -0.443}, {2.0, -2.754}};
    for (int k = 0; k < COUNT_OF(table); k++) {
        const double rate = log(growth(50.0 * table[k][0], 50.0)) / 0.7;
        CHECK_NEAR(0.11 * fabs(table[k][1]), table[k][1], rate);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_recursion_against_float64);
    RUN_TEST(test_in_the_rotors_frame_it_is_the_c_leso);
    RUN_TEST(test_gain_at_any_frequency);
    RUN_TEST(test_least_w0_is_where_the_polynomial_says);
    RUN_TEST(test_bandwidth_that_the_pll_asks_for);
    RUN_TEST(test_the_estimator_swings_as_calculated);
    return UNITY_END();
}
