// The host tool's loop models against the firmware itself, against closed forms and the papers.
#include "support/check.h"

#include <complex.h>

#include "analyse/joint.h"
#include "analyse/loop.h"
#include "analyse/margins.h"
#include "analyse/observer.h"
#include "analyse/polynomial.h"
#include "design/guide.h"
#include "design/limits.h"
#include "emf_inline.h"
#include "sogi_inline.h"

void setUp(void) {}

void tearDown(void) {}

#define TS 2.0e-4

// ---- Numerics -------------------------------------------------------------------------------------

static void test_eigenvalues_of_random_matrices(void) {
    random_t random = random_seed(5);
    for (int n = 1; n <= 16; n++) {
        matrix_t a;
        matrix_t copy;
        double complex value[MATRIX_MAX];
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < n; k++) {
                a[i][k] =
                    random_between(&random, -1.0, 1.0) + I * random_between(&random, -1.0, 1.0);
                copy[i][k] = a[i][k];
            }
        }
        TEST_ASSERT_TRUE(matrix_eigenvalues(n, a, value));
        for (int v = 0; v < n; v++) {
            // Each one makes the matrix singular: inverse iteration from a shift beside it grows by
            // the reciprocal of the shift.
            matrix_t shifted;
            double complex x[MATRIX_MAX];
            for (int i = 0; i < n; i++) {
                for (int k = 0; k < n; k++) {
                    shifted[i][k] = copy[i][k] - (i == k ? value[v] + 1.0e-8 : 0.0);
                }
                x[i] = 1.0 + 0.1 * i;
            }
            TEST_ASSERT_TRUE(matrix_solve(n, shifted, x));
            double length = 0.0;
            for (int i = 0; i < n; i++) {
                length = fmax(length, cabs(x[i]));
            }
            CHECK_AT_LEAST(1.0e6, length);
        }
    }
}

static void test_quotients_are_those_of_c(void) {
    random_t random = random_seed(6);
    for (int k = 0; k < 1000; k++) {
        const double size = pow(10.0, random_between(&random, -140.0, 140.0));
        const double complex a = 3.0 * size + I * size * random_between(&random, -1.0, 1.0);
        const double complex b = cexp(I * random_between(&random, -4.0, 4.0)) * size;
        CHECK_AT_MOST(1.0e-14, cabs(quotient(a, b) / (a / b) - 1.0));
    }
}

static void test_roots_come_back_from_their_polynomial(void) {
    // Of size 1 to 1e3 and a pair, as loops have them.
    polynomial_t p = {0, {1.0}};
    const double real[] = {-1.0, -30.0, -1000.0};
    for (int k = 0; k < 3; k++) {
        const polynomial_t factor = {1, {-real[k], 1.0}};
        p = polynomial_product(&p, &factor);
    }
    const polynomial_t pair = {2, {25.0 * 25.0 + 600.0 * 600.0, 50.0, 1.0}};
    p = polynomial_product(&p, &pair);
    double complex roots[MATRIX_MAX];
    TEST_ASSERT_TRUE(polynomial_roots(&p, roots));
    const double complex wanted[] = {-1.0, -30.0, -1000.0, -25.0 + 600.0 * I, -25.0 - 600.0 * I};
    for (int k = 0; k < 5; k++) {
        double nearest = HUGE_VAL;
        for (int n = 0; n < 5; n++) {
            nearest = fmin(nearest, cabs(roots[n] - wanted[k]));
        }
        CHECK_AT_MOST(1.0e-9 * cabs(wanted[k]) + 1.0e-9, nearest);
    }
}

static void test_generalised_routh_condition(void) {
    TEST_ASSERT_EQUAL_INT(0, limits_routh_wrong(20000));
    // Paper 2, eq. (24): k1, k2 > 0 suffice whatever the speed.
    TEST_ASSERT_TRUE(routh_complex_second_order(314.0, -1000.0, 31.4, 0.0));
    TEST_ASSERT_TRUE(!routh_complex_second_order(314.0, -1000.0, -0.1, 0.0));
    TEST_ASSERT_TRUE(!routh_complex_second_order(-1.0, 0.0, 31.4, 0.0));
    // (s + 1 - j)(s + 2 + 3j): both parts matter; (s + 1 - j)(s - 0.1 + 3j) is not stable.
    TEST_ASSERT_TRUE(routh_complex_second_order(3.0, 2.0, 5.0, 1.0));
    TEST_ASSERT_TRUE(!routh_complex_second_order(0.9, 2.0, 2.9, 3.1));
}

// ---- Observers ------------------------------------------------------------------------------------

typedef struct {
    const char *name;
    lode_emf_kind_t kind;
    float k1, k2;
} kind_t;

static const kind_t kinds[] = {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    {name, LODE_EMF_##ID, 0.0f, LODE_EMF_##ID == LODE_EMF_FA_LESO ? 300.0f : 1000.0f},
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    {"fa-leso, k1", LODE_EMF_FA_LESO, 31.4f, 314.0f},
};

static lode_estimator_config_t config_of(const kind_t *kind, lode_pll_kind_t pll, float sigma) {
    lode_motor_t motor = paper_motor();
    lode_estimator_config_t config = {
        .emf = {.kind = kind->kind,
                .w0_rad_s = 2000.0f,
                .gi_wc_rad_s = LODE_PI, // paper 2, Table II
                .k1_rad2_s2 = kind->k1,
                .k2_rad_s = kind->k2},
        .pll = {.kind = pll, .sigma_rad_s = sigma},
    };
    lode_estimator_design(&config, &motor, PAPER_TS_s);
    return config;
}

static lode_estimator_tuning_t tuning_of(const lode_estimator_config_t *config) {
    lode_motor_t motor = paper_motor();
    motor.B_Nms = 0.0f; // the torque feed-forward then has nothing to say without current
    lode_estimator_tuning_t tuning;
    TEST_ASSERT_EQUAL_STRING(
        "LODE_OK", lode_status_name(lode_estimator_tune(&tuning, config, &motor, PAPER_TS_s)));
    return tuning;
}

/// The model's matrices step for step beside lode_observer_step().
static void check_observer(const kind_t *kind, double omega) {
    const lode_estimator_config_t config = config_of(kind, LODE_PLL_LESO, 100.0f);
    const lode_observer_tuning_t leso = tuning_of(&config).emf.observer;
    const observer_t o = observer_make(&leso, TS, omega);
    double complex x[OBSERVER_MODES_MAX] = {0.0};
    lode_observer_t state;
    lode_observer_reset(&state);
    random_t random = random_seed(9);
    worst_t worst = {0.0};
    for (int k = 0; k < 400; k++) {
        const double complex m =
            random_between(&random, -1.0, 1.0) + I * random_between(&random, -1.0, 1.0);
        double complex next[OBSERVER_MODES_MAX] = {0.0};
        double complex e = 0.0;
        for (int i = 0; i < o.modes; i++) {
            next[i] = o.b[i] * m;
            for (int n = 0; n < o.modes; n++) {
                next[i] += o.a[i][n] * x[n];
            }
            e += o.c[i] * next[i];
        }
        memcpy(x, next, sizeof x);
        const lode_ab_t is =
            lode_observer_step(&state, &leso, (lode_ab_t){(float)creal(m), (float)cimag(m)},
                               sincos_of(omega * TS), (float)omega);
        worst_note(&worst, (double)is.alpha - creal(e));
        worst_note(&worst, (double)is.beta - cimag(e));
    }
    // Floats of size 1, each step rounding by 1e-7, remembered over up to 100 steps.
    CHECK_AT_MOST(2.0e-5, worst.value);
}

static void test_observer_matrices_are_the_firmware(void) {
    const double omegas[] = {-471.0, 30.0, 140.0, 471.0, 1000.0};
    for (int k = 0; k < COUNT_OF(kinds); k++) {
        for (int w = 0; w < COUNT_OF(omegas); w++) {
            check_observer(&kinds[k], omegas[w]);
        }
    }
}

static void test_observer_responses_against_closed_forms(void) {
    const double w = 314.0;
    const double p = exp(-2000.0 * TS);
    const double q = exp(-300.0 * TS);
    const double complex rho = cexp(I * w * TS);
    for (double f = -2000.0; f <= 2000.0; f += 250.0) {
        const double complex z = cexp(I * f * TS);
        const double complex c = (1.0 - p) / (1.0 - p / z);
        const double complex fa = (1.0 - q) / (1.0 - q * rho / z);
        const double complex wanted[] = {[LODE_EMF_C_LESO] = c * c, [LODE_EMF_FA_LESO] = fa};
        for (int k = LODE_EMF_C_LESO; k <= LODE_EMF_FA_LESO; k += LODE_EMF_FA_LESO) {
            const lode_estimator_config_t config = config_of(&kinds[k], LODE_PLL_LESO, 100.0f);
            const lode_observer_tuning_t leso = tuning_of(&config).emf.observer;
            const observer_t o = observer_make(&leso, TS, w);
            // The coefficients are floats: 1e-7 of 1 - p, 1 - q.
            CHECK_AT_MOST(1.0e-5, cabs(observer_response(&o, z) - wanted[k]));
        }
    }
    // GI at the speed it is tuned to: (E15), whatever the width of its band.
    const lode_estimator_config_t config =
        config_of(&kinds[LODE_EMF_GI_LESO], LODE_PLL_LESO, 100.0f);
    const lode_observer_tuning_t leso = tuning_of(&config).emf.observer;
    const observer_t gi = observer_make(&leso, TS, w);
    const double g = (1.0 - p) * (1.0 - p) * 3.0;
    const double complex at = g * rho * rho / ((rho - 1.0) * (rho - p * p) + g * rho);
    // Its width is a float's 6e-8 over 6e-4.
    CHECK_AT_MOST(1.0e-4, cabs(observer_response(&gi, rho) - at));
}

static void test_no_response_is_above_the_peak(void) {
    const double w = 314.0;
    for (int k = 0; k < COUNT_OF(kinds); k++) {
        lode_estimator_config_t config = config_of(&kinds[k], LODE_PLL_LESO, 100.0f);
        config.emf.gi_wc_rad_s =
            60.0f; // with the narrower ones it rings for longer than is waited for
        config.emf.k1_rad2_s2 *= 200.0f;
        const lode_observer_tuning_t leso = tuning_of(&config).emf.observer;
        observer_t o = observer_make(&leso, TS, w);
        const double peak = observer_peak(&o, o.b);
        double largest = 0.0;
        for (double angle = -LODE_PI; angle <= (double)LODE_PI; angle += 1.0e-3) {
            largest = fmax(largest, cabs(observer_response(&o, cexp(I * angle))));
        }
        CHECK_AT_LEAST(largest, peak);
        CHECK_AT_MOST(3.0 * largest, peak);
        // None for an observer that grows.
        for (int i = 0; i < o.modes; i++) {
            o.a[i][i] += i == 0 ? 2.0 : 0.0;
        }
        TEST_ASSERT_FALSE(isfinite(observer_peak(&o, o.b)));
    }
}

// ---- The joint loop -------------------------------------------------------------------------------

/// Characteristic polynomial of FA-LESO (k1 = 0) and PLL, docs (G8) and (G9), at z.
static double complex characteristic(double k2, double sigma, bool third, double complex z) {
    const double q = exp(-k2 * TS);
    const double s = exp(-sigma * TS);
    const double x = 1.0 - s;
    const double complex n = z - 1.0;
    if (third) {
        const double l2 = 1.5 * x * x * (2.0 - x);
        const double l3 = x * x * x;
        return (z - q) * (z - s) * (z - s) * (z - s) - q * z * n * (l2 * n + l3 * z);
    }
    return (z - q) * (z - s) * (z - s) - q * x * x * z * n;
}

static void test_poles_are_roots_of_the_derived_polynomial(void) {
    const float k2s[] = {60.0f, 150.0f, 300.0f, 2000.0f};
    for (int third = 0; third < 2; third++) {
        for (int k = 0; k < COUNT_OF(k2s); k++) {
            const kind_t kind = {"FA", LODE_EMF_FA_LESO, 0.0f, k2s[k]};
            const lode_estimator_config_t config =
                config_of(&kind, third ? LODE_PLL_LESO : LODE_PLL_QPLL, 100.0f);
            const lode_estimator_tuning_t tuning = tuning_of(&config);
            const joint_t joint = joint_make(&tuning, 200.0);
            double complex poles[JOINT_STATES_MAX];
            const int count = joint_poles(&joint, poles);
            // Amplitude at q, and the shared ones; all but the amplitude are roots.
            TEST_ASSERT_EQUAL_INT(third ? 5 : 4, count);
            int roots = 0;
            for (int n = 0; n < count; n++) {
                const double complex z = cexp(poles[n] * TS);
                const double complex step = 1.0e-4 * (z - 1.0);
                const double complex here = characteristic((double)k2s[k], 100.0, third, z);
                const double complex there = characteristic((double)k2s[k], 100.0, third, z + step);
                const double distance = cabs(here) * cabs(step) / cabs(there - here);
                // Floats of the tuning move a pole by some 1e-6 of its distance from 1.
                roots += distance < 1.0e-4 * cabs(z - 1.0) ? 1 : 0;
            }
            TEST_ASSERT_EQUAL_INT(third ? 4 : 3, roots);
        }
    }
}

/// Schur and Cohn: all roots of a real polynomial inside the unit circle. Independent of any root
/// finder.
static bool is_schur(const double *coefficient, int degree) {
    double c[8];
    memcpy(c, coefficient, sizeof(double) * (size_t)(degree + 1));
    for (int n = degree; n > 0; n--) {
        double next[8];
        if (!(fabs(c[0]) < fabs(c[n]))) {
            return false;
        }
        for (int k = 0; k < n; k++) {
            next[k] = c[n] * c[k + 1] - c[0] * c[n - 1 - k];
        }
        memcpy(c, next, sizeof(double) * (size_t)n);
    }
    return true;
}

/// (G8) by coefficients of z.
static bool stable_by_schur(double k2_per_sigma, double sigma_Ts) {
    const double q = exp(-k2_per_sigma * sigma_Ts);
    const double s = exp(-sigma_Ts);
    const double x = 1.0 - s;
    const double l2 = 1.5 * x * x * (2.0 - x);
    const double l3 = x * x * x;
    // (z - q)(z - s)^3 - q (l2 (z^3 - 2 z^2 + z) + l3 (z^3 - z^2))
    const double c[] = {q * s * s * s, -(s * s * s + 3.0 * q * s * s) - q * l2,
                        3.0 * s * s + 3.0 * q * s + q * (2.0 * l2 + l3),
                        -(3.0 * s + q) - q * (l2 + l3), 1.0};
    return is_schur(c, 4);
}

static void test_least_k2_is_where_the_polynomial_says(void) {
    const double sigmas[] = {50.0, 100.0, 250.0, 500.0, 1000.0, 1500.0};
    for (int k = 0; k < COUNT_OF(sigmas); k++) {
        double low = 0.3;
        double high = 1.0;
        for (int n = 0; n < 50; n++) {
            const double middle = 0.5 * (low + high);
            *(stable_by_schur(middle, sigmas[k] * TS) ? &high : &low) = middle;
        }
        const lode_estimator_config_t config =
            config_of(&kinds[LODE_EMF_FA_LESO], LODE_PLL_LESO, 100.0f);
        const lode_estimator_tuning_t tuning = tuning_of(&config);
        const double found = guide_k2_limit(&tuning, &config.emf, 471.0, sigmas[k]);
        // Floats of the tuning: 1e-7 of 1 against the loop's 1 - s >= 0.01.
        CHECK_CLOSE(1.0e-4, high, found);
        // It falls from the continuous limit, 3/4 (sqrt(3) - 1) = 0.549, by about 0.22 sigma Ts.
        const double theory = 0.75 * (sqrt(3.0) - 1.0);
        CHECK_AT_MOST(theory, found);
        CHECK_NEAR(0.025, theory - 0.2 * sigmas[k] * TS, found);
    }
}

static void test_with_the_qpll_every_k2_is_stable(void) {
    const double sigmas[] = {10.0, 100.0, 1000.0, 1500.0};
    const lode_estimator_config_t config =
        config_of(&kinds[LODE_EMF_FA_LESO], LODE_PLL_QPLL, 100.0f);
    const lode_estimator_tuning_t tuning = tuning_of(&config);
    for (int k = 0; k < COUNT_OF(sigmas); k++) {
        for (double k2 = 1.0; k2 <= 5000.0; k2 *= 1.7) {
            const lode_estimator_tuning_t a = joint_with_sigma(&tuning, sigmas[k]);
            const lode_estimator_tuning_t b = joint_with_k2(&a, &config.emf, k2);
            const joint_t joint = joint_make(&b, 471.0);
            CHECK_AT_MOST(1.0 - 1.0e-9, joint_radius(&joint));
        }
    }
}

// ---- The joint loop against the firmware ------------------------------------------------------------

/// A turning EMF without current, and the firmware that watches it.
typedef struct {
    double theta, omega;
    lode_estimator_tuning_t tuning;
    lode_estimator_t estimator;
} bench_t;

static double bench_step(bench_t *b, double complex deviation) {
    b->theta = remainder(b->theta + b->omega * TS, 2.0 * CHECK_PI);
    const double complex m = 20.0 * I * cexp(I * b->theta) * (1.0 + deviation);
    (void)lode_estimator_step(&b->estimator, &b->tuning,
                              (lode_ab_t){(float)creal(m), (float)cimag(m)},
                              (lode_ab_t){0.0f, 0.0f});
    const lode_sincos_t frame = b->estimator.pll.frame;
    return angle_error(atan2((double)frame.sin, (double)frame.cos), b->theta);
}

/// Settled: what the observer's lag leaves.
static double bench_settle(bench_t *b, const lode_estimator_tuning_t *tuning, double omega) {
    *b = (bench_t){.theta = 0.4, .omega = omega, .tuning = *tuning};
    // The amplitude is held, so that the level says nothing of the lock.
    b->tuning.psi_Wb = (float)(20.0 / omega);
    lode_estimator_reset(&b->estimator, &b->tuning);
    lode_estimator_hold(&b->estimator, &b->tuning, lode_sincos((float)b->theta), (float)omega);
    for (int k = 0; k < 10000; k++) {
        (void)bench_step(b, 0.0);
    }
    double sum = 0.0;
    for (int k = 0; k < 1000; k++) {
        sum += bench_step(b, 0.0);
    }
    return sum / 1000.0;
}

/// An angle that is put off by 0.02 rad comes back as the model says, within a share of that.
static void check_return(const lode_estimator_tuning_t *tuning, double omega, double share) {
    const double off = 0.02;
    bench_t bench;
    const double rest = bench_settle(&bench, tuning, omega);
    const joint_t joint = joint_make(tuning, omega);
    const joint_input_t none = {0.0, 0.0};
    double x[2][JOINT_STATES_MAX] = {{0.0}};
    x[0][joint.pll] = off;
    bench.estimator.pll.frame = lode_angle_add(bench.estimator.pll.frame, lode_sincos((float)off));
    worst_t worst = {0.0};
    for (int k = 0; k < 1500; k++) { // 0.3 s
        joint_step(&joint, &none, x[k % 2], x[1 - k % 2]);
        worst_note(&worst, bench_step(&bench, 0.0) - rest - x[1 - k % 2][joint.pll]);
    }
    CHECK_AT_MOST(share * off, worst.value);
}

static void test_the_firmware_returns_as_the_model_says(void) {
    const double omegas[] = {120.0, 471.0};
    for (int k = 0; k < COUNT_OF(kinds); k++) {
        for (int third = 0; third < 2; third++) {
            for (int w = 0; w < COUNT_OF(omegas); w++) {
                lode_estimator_config_t config =
                    config_of(&kinds[k], third ? LODE_PLL_LESO : LODE_PLL_QPLL, 60.0f);
                lode_estimator_tuning_t tuning = tuning_of(&config);
                // The sine's curvature leaves off^2/6, 0.01 %; the speed swings by 1 % and moves what
                // depends on it. With k1 the slow mode, of 12 to 30 s, has not settled in the two
                // seconds before, and carries up to k1/(k2 w) of the estimate.
                const double share = kinds[k].k1 > 0.0f ? 0.02 : 0.006;
                check_return(&tuning, omegas[w], share);
                config.notch_k = 0.5f; // in from 60 rad/s on, in full from 80
                config.w_filter_rad_s = 60.0f;
                tuning = tuning_of(&config);
                check_return(&tuning, omegas[w], share);
            }
        }
    }
}

/// Rate and frequency of a swing, from its zeros and from the growth between its extremes.
static double complex measured_pole(bench_t *bench, double rest, double seconds) {
    double first_zero = -1.0;
    double last_zero = 0.0;
    int zeros = 0;
    double peak = 0.0;
    double first_peak = 0.0;
    double first_at = 0.0;
    double peak_at = 0.0;
    double last_peak = 0.0;
    double last_at = 0.0;
    double before = bench_step(bench, 0.0) - rest;
    for (double t = TS; t < seconds; t += TS) {
        const double now = bench_step(bench, 0.0) - rest;
        if (fabs(now) > peak) {
            peak = fabs(now);
            peak_at = t;
        }
        if ((before < 0.0) != (now < 0.0)) {
            const double at = t - TS * now / (now - before);
            if (zeros > 1 && first_peak <= 0.0) {
                first_peak = peak;
                first_at = peak_at;
            }
            last_peak = zeros > 1 ? peak : 0.0;
            last_at = peak_at;
            first_zero = zeros == 0 ? at : first_zero;
            last_zero = at;
            zeros++;
            peak = 0.0;
        }
        before = now;
    }
    return log(last_peak / first_peak) / (last_at - first_at) +
           I * CHECK_PI * (zeros - 1) / (last_zero - first_zero);
}

/// Settles with one tuning, then swings with another. Returns what is measured.
static void check_swing(const lode_estimator_tuning_t *rest_tuning,
                        const lode_estimator_tuning_t *tuning, double omega, double wait_s) {
    bench_t bench;
    const joint_t joint = joint_make(tuning, omega);
    double complex poles[JOINT_STATES_MAX];
    TEST_ASSERT_TRUE(joint_poles(&joint, poles) > 0);
    const double rest = bench_settle(&bench, rest_tuning, omega);
    const float psi = bench.tuning.psi_Wb;
    bench.tuning = *tuning;
    bench.tuning.psi_Wb = psi;
    bench.estimator.pll.frame = lode_angle_add(bench.estimator.pll.frame, lode_sincos(0.02f));
    for (double t = 0.0; t < wait_s; t += TS) { // what is better damped dies first
        (void)bench_step(&bench, 0.0);
    }
    const double complex swing = measured_pole(&bench, rest, 0.6);
    // Peaks are read from samples that lie up to half a period beside them: at the 190 degrees per
    // ms of the fastest swing here 1.5 % low, over 0.5 s and more 0.03/s; floats of the angle add
    // as much. The swing's own size of 0.02 rad bends it by 1e-4.
    CHECK_NEAR(0.1, creal(poles[0]), creal(swing));
    CHECK_CLOSE(0.003, fabs(cimag(poles[0])), cimag(swing));
}

static void test_swings_decay_and_grow_as_the_poles_say(void) {
    const lode_estimator_config_t config =
        config_of(&kinds[LODE_EMF_FA_LESO], LODE_PLL_LESO, 100.0f);
    const lode_estimator_tuning_t fa = tuning_of(&config);
    const double omegas[] = {120.0, 471.0};
    for (int w = 0; w < COUNT_OF(omegas); w++) {
        // Just above the least k2, and below it, where init refuses: there it grows.
        const lode_estimator_tuning_t damped = joint_with_k2(&fa, &config.emf, 62.0);
        check_swing(&fa, &damped, omegas[w], 0.1);
        const lode_estimator_tuning_t growing = joint_with_k2(&fa, &config.emf, 50.0);
        const joint_t joint = joint_make(&growing, omegas[w]);
        CHECK_AT_LEAST(1.0001, joint_radius(&joint));
        TEST_ASSERT_FALSE(joint_is_stable(&joint));
        check_swing(&fa, &growing, omegas[w], 0.1);
    }
}

static void test_gi_holds_with_the_speed_fed_back(void) {
    // Its band-pass rings at minus the speed too, which shows at twice the speed in the angle and in
    // the speed that tunes it. Built of two integrators that exchange their content it loses energy
    // whatever that speed does: no sigma that init accepts makes the joint loop grow.
    lode_estimator_config_t config = config_of(&kinds[LODE_EMF_GI_LESO], LODE_PLL_LESO, 80.0f);
    config.emf.gi_wc_rad_s = LODE_PI; // paper 2's
    const lode_estimator_tuning_t slow = tuning_of(&config);
    const double sigmas[] = {80.0, 150.0, 250.0, 400.0};
    const double omegas[] = {94.0, 471.0, 942.0};
    for (int s = 0; s < COUNT_OF(sigmas); s++) {
        for (int w = 0; w < COUNT_OF(omegas); w++) {
            const lode_estimator_tuning_t tuning = joint_with_sigma(&slow, sigmas[s]);
            const joint_t joint = joint_make(&tuning, omegas[w]);
            CHECK_AT_MOST(1.0, joint_radius(&joint));
            TEST_ASSERT_TRUE(joint_is_stable(&joint));
        }
    }
}

/// Both ways to the same answer, from where the loop is stable to where it is not.
static void test_powers_tell_the_stable_loops(void) {
    const double omegas[] = {9.0, 100.0, 471.0};
    for (int k = 0; k < COUNT_OF(kinds); k++) {
        lode_estimator_config_t config = config_of(&kinds[k], LODE_PLL_LESO, 100.0f);
        config.notch_k = 0.5f;
        const lode_estimator_tuning_t tuning = tuning_of(&config);
        for (int w = 0; w < COUNT_OF(omegas); w++) {
            joint_t joint = joint_make(&tuning, omegas[w]);
            for (double sigma = 2.0; sigma < 4000.0; sigma *= 1.3) {
                const lode_estimator_tuning_t t = joint_with_sigma(&tuning, sigma);
                const joint_t made = joint_make(&t, omegas[w]);
                joint_retune(&joint, &t, omegas[w]);
                TEST_ASSERT_TRUE(joint_radius(&joint) == joint_radius(&made));
                TEST_ASSERT_TRUE(joint_is_stable(&joint) == (joint_radius(&joint) < 1.0));
            }
        }
    }
}

static void test_margins_end_where_the_joint_loop_does(void) {
    // Two ways to the same edge: Nyquist's curve of the open loop, and the poles of the whole. For
    // observers that rotate with the speed, which that edge is made of.
    const lode_emf_kind_t rotating[] = {LODE_EMF_FA_LESO, LODE_EMF_R_LESO};
    const double omegas[] = {100.0, 471.0};
    for (int k = 0; k < COUNT_OF(rotating); k++) {
        for (int w = 0; w < COUNT_OF(omegas); w++) {
            lode_drive_config_t drive = {.f_pwm_Hz = 5000.0f, .motor = paper_motor()};
            const kind_t kind = {"", rotating[k], 0.0f, 100.0f};
            drive.estimator = config_of(&kind, LODE_PLL_LESO, 100.0f);
            drive.estimator.emf.w0_rad_s = 600.0f;
            const lode_estimator_tuning_t tuning = tuning_of(&drive.estimator);
            const margins_t margins = margins_at(&drive, omegas[w]);
            TEST_ASSERT_TRUE(margins_phase_deg(&drive, omegas[w]) == margins.phase_deg);
            const double limit = margins.sigma_limit_rad_s;
            CHECK_AT_LEAST(100.0, limit);
            for (int side = -1; side <= 1; side += 2) { // 1.5 %: the coarse steps of the sweep
                const lode_estimator_tuning_t t =
                    joint_with_sigma(&tuning, limit * (1.0 + 0.015 * side));
                const joint_t joint = joint_make(&t, omegas[w]);
                TEST_ASSERT_TRUE((joint_radius(&joint) < 1.0) == (side < 0));
            }
        }
    }
}

static void test_ripple_of_harmonics_is_the_models(void) {
    const double omega = 200.0;
    const lode_estimator_config_t config =
        config_of(&kinds[LODE_EMF_FA_LESO], LODE_PLL_LESO, 100.0f);
    const lode_estimator_tuning_t tuning = tuning_of(&config);
    const joint_t joint = joint_make(&tuning, omega);
    for (int order = -5; order <= 7; order += 12) {
        bench_t bench;
        const double rest = bench_settle(&bench, &tuning, omega);
        const double share = 0.02;
        const double complex z = cexp(6.0 * I * omega * TS);
        const double model = cabs(joint_angle_response(&joint, z, 1.0, order > 0 ? -I : I));
        double complex sum = 0.0;
        const int periods = 10; // of 6 w: 26.18 samples each, with whole samples over ten of them
        const int count = (int)(periods * 2.0 * CHECK_PI / (6.0 * omega * TS) + 0.5);
        for (int k = 0; k < 4000 + count; k++) {
            const double angle = (order - 1) * omega * TS * k;
            const double now = bench_step(&bench, share * cexp(I * angle)) - rest;
            sum += k < 4000 ? 0.0 : now * cexp(-6.0 * I * omega * TS * k);
        }
        // 2 % of harmonic in a detector that divides by the length: second order in it.
        CHECK_CLOSE(0.03, share * model, 2.0 * cabs(sum) / count);
    }
}

static void test_an_acceleration_passes_as_the_model_says(void) {
    const double omega = 300.0;
    const double acceleration = 400.0;
    for (int third = 0; third < 2; third++) {
        const lode_estimator_config_t config =
            config_of(&kinds[LODE_EMF_FA_LESO], third ? LODE_PLL_LESO : LODE_PLL_QPLL, 100.0f);
        const lode_estimator_tuning_t tuning = tuning_of(&config);
        const joint_t joint = joint_make(&tuning, omega);
        const joint_input_t input = {acceleration, 0.0};
        double x[2][JOINT_STATES_MAX] = {{0.0}};
        bench_t bench;
        const double rest = bench_settle(&bench, &tuning, omega);
        worst_t worst = {0.0};
        worst_t peak = {0.0};
        for (int k = 0; k < 500; k++) {
            bench.theta += 0.5 * TS * TS * acceleration;
            const double error = bench_step(&bench, 0.0) - rest;
            bench.omega += TS * acceleration;
            joint_step(&joint, &input, x[k % 2], x[1 - k % 2]);
            worst_note(&worst, error - x[1 - k % 2][joint.pll]);
            worst_note(&peak, error);
        }
        CHECK_AT_LEAST(0.02, peak.value); // 1.5 and 4 degrees: there is something to compare
        CHECK_AT_MOST(0.01 * peak.value, worst.value);
    }
}

// ---- The papers -------------------------------------------------------------------------------------

static void test_table_2_of_paper_1(void) {
    // Printed: sigma, crossover, margin, dominant poles; k 0.1, notch at 600 rad/s.
    const double printed[][5] = {{80.0, 244.0, 68.0, -26.8, 587.7},
                                 {120.0, 365.0, 66.0, -22.9, 583.2},
                                 {160.0, 478.0, 58.0, -18.3, 580.1}};
    for (int k = 0; k < COUNT_OF(printed); k++) {
        const loop_ratio_t notch = loop_notch(0.1, 600.0);
        const loop_ratio_t pll = loop_pll(printed[k][0], true);
        const loop_ratio_t loop = loop_product(&notch, &pll);
        const loop_metrics_t m = loop_metrics(&loop, 10.0, 1.0e4);
        const double complex pole = loop_dominant(&loop);
        // Half a digit of print; the paper cut off 58.53 degrees, 22.96 and 580.04 rad/s or rounded
        // on the way, so up to a digit there.
        CHECK_NEAR(0.5, printed[k][1], m.crossover_rad_s);
        CHECK_NEAR(0.55, printed[k][2], m.phase_deg);
        CHECK_NEAR(0.07, printed[k][3], creal(pole));
        CHECK_NEAR(0.1, printed[k][4], cimag(pole));
    }
}

static void test_sampled_loops_approach_the_continuous_ones(void) {
    // The difference falls with the period: a twentieth of it at a twentieth.
    for (int third = 0; third < 2; third++) {
        const loop_ratio_t theory_notch = loop_notch(0.5, 900.0);
        const loop_ratio_t theory_pll = loop_pll(100.0, third);
        const loop_ratio_t theory = loop_product(&theory_notch, &theory_pll);
        double before = 0.0;
        for (double ts = 2.0e-4; ts > 0.9e-5; ts /= 20.0) {
            const loop_ratio_t notch = loop_notch_sampled(0.5, 900.0, ts);
            const loop_ratio_t pll = loop_pll_sampled(100.0, third, ts);
            const loop_ratio_t loop = loop_product(&notch, &pll);
            const double off = cabs(loop_at(&loop, 150.0) / loop_at(&theory, 150.0) - 1.0);
            CHECK_AT_MOST(0.1, off);
            if (before > 0.0) {
                CHECK_CLOSE(0.2, before / 20.0, off);
            }
            before = off;
        }
    }
}

static void test_sampled_notch_is_the_firmware(void) {
    // Its gain at some frequencies, by running lode_sogi_step().
    const double centre = 900.0;
    const double at[] = {300.0, 850.0, 900.0, 2000.0};
    const loop_ratio_t notch = loop_notch_sampled(0.5, centre, TS);
    for (int k = 0; k < COUNT_OF(at); k++) {
        const lode_sogi_tuning_t tuning = lode_sogi_tune(0.5f, (float)(centre * TS));
        lode_sogi_t state;
        lode_sogi_reset(&state);
        double complex sum = 0.0;
        const int count = (int)(20.0 * 2.0 * CHECK_PI / (at[k] * TS) + 0.5);
        for (int n = 0; n < 3000 + count; n++) {
            const lode_sogi_out_t out = lode_sogi_step(&state, &tuning, (float)cos(at[k] * TS * n));
            sum += n < 3000 ? 0.0 : (double)out.notch * cexp(-I * at[k] * TS * n);
        }
        // 20 periods end within half a sample: 1e-2 of a period in 20.
        CHECK_AT_MOST(5.0e-3, cabs(2.0 * sum / count - loop_at(&notch, at[k])));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_eigenvalues_of_random_matrices);
    RUN_TEST(test_quotients_are_those_of_c);
    RUN_TEST(test_roots_come_back_from_their_polynomial);
    RUN_TEST(test_generalised_routh_condition);
    RUN_TEST(test_observer_matrices_are_the_firmware);
    RUN_TEST(test_observer_responses_against_closed_forms);
    RUN_TEST(test_no_response_is_above_the_peak);
    RUN_TEST(test_poles_are_roots_of_the_derived_polynomial);
    RUN_TEST(test_least_k2_is_where_the_polynomial_says);
    RUN_TEST(test_with_the_qpll_every_k2_is_stable);
    RUN_TEST(test_the_firmware_returns_as_the_model_says);
    RUN_TEST(test_swings_decay_and_grow_as_the_poles_say);
    RUN_TEST(test_gi_holds_with_the_speed_fed_back);
    RUN_TEST(test_powers_tell_the_stable_loops);
    RUN_TEST(test_margins_end_where_the_joint_loop_does);
    RUN_TEST(test_ripple_of_harmonics_is_the_models);
    RUN_TEST(test_an_acceleration_passes_as_the_model_says);
    RUN_TEST(test_table_2_of_paper_1);
    RUN_TEST(test_sampled_loops_approach_the_continuous_ones);
    RUN_TEST(test_sampled_notch_is_the_firmware);
    return UNITY_END();
}
