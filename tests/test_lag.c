// The polynomial of the observer's lag against the exact lag in float64.
#include "support/check.h"

#include <stdlib.h>

#include "lag_inline.h"

void setUp(void) {}

void tearDown(void) {}

typedef struct {
    double R, Lq, ts, w0, omega_max;
} case_t;

// Paper 1's motor up to 2.5 times rated speed, a servo, a drone motor, one without resistance.
static const case_t cases[] = {
    {0.75, 9.8e-3, 2.0e-4, 2000.0, 1178.0},   {0.75, 9.8e-3, 2.0e-4, 600.0, 600.0},
    {0.032, 34.0e-6, 2.5e-5, 9000.0, 9000.0}, {0.0, 5.0e-3, 1.0e-4, 3000.0, 3000.0},
    {4.0, 1.2e-3, 1.0e-4, 4000.0, 2000.0},
};

/// arg(exp(j x) - pole).
static double arg_from(double pole, double x) {
    return atan2(sin(x), cos(x) - pole);
}

/// 2 arg(rho - p) - w Ts - arg Gamma, Gamma = (rho - a)/((mu + j w) b Lq).
static double exact(const case_t *c, double omega) {
    const double mu = c->R / c->Lq;
    const double x = omega * c->ts;
    const double gamma = arg_from(exp(-mu * c->ts), x) - atan2(omega, mu);
    return 2.0 * arg_from(exp(-c->w0 * c->ts), x) - x - gamma;
}

static lode_status_t tune(lode_lag_t *lag, lode_lag_kind_t kind, const case_t *c) {
    lode_motor_t motor = paper_motor();
    motor.Rs_Ohm = (float)c->R;
    motor.Lq_H = (float)c->Lq;
    const lode_emf_config_t config = {.kind = LODE_EMF_C_LESO, .w0_rad_s = (float)c->w0};
    return lode_lag_tune(lag, kind, &config, &motor, (float)c->ts, (float)c->omega_max);
}

static void test_polynomial_is_within_its_tolerance(void) {
    for (int i = 0; i < COUNT_OF(cases); i++) {
        lode_lag_t lag;
        TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &cases[i]));
        for (int k = -1000; k <= 1000; k++) {
            const float omega = (float)(cases[i].omega_max * k / 1000.0);
            // Six terms up to w = w0 leave 6e-6; the documented bound is 1.7e-4.
            CHECK_NEAR(1.0e-5, exact(&cases[i], (double)omega), lode_lag_rad(&lag, omega));
        }
    }
}

static void test_polynomial_of_the_papers_motor_is_ten_times_better(void) {
    // The whole error of the compensated angle is to be 0.02 degree: this part is kept below 0.002.
    lode_lag_t lag;
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &cases[0]));
    for (int k = 1; k <= 500; k++) {
        const float omega = (float)(cases[0].omega_max * k / 500.0);
        CHECK_NEAR(0.002 * CHECK_DEG, exact(&cases[0], (double)omega), lode_lag_rad(&lag, omega));
    }
}

/// It goes through the exact lag at the Chebyshev nodes of the square of the speed, where its error is least.
static void test_polynomial_is_exact_at_the_nodes(void) {
    for (int i = 0; i < COUNT_OF(cases); i++) {
        lode_lag_t lag;
        TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &cases[i]));
        for (int k = 0; k < LODE_LAG_TERMS; k++) {
            const double node = 0.5 - 0.5 * cos(CHECK_PI * (k + 0.5) / LODE_LAG_TERMS);
            const double omega = cases[i].omega_max * sqrt(node);
            CHECK_NEAR(1.0e-6, exact(&cases[i], omega), lode_lag_rad(&lag, (float)omega));
        }
    }
}

static void test_polynomial_is_odd(void) {
    lode_lag_t lag;
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &cases[0]));
    random_t random = random_seed(1);
    for (int k = 0; k < 10000; k++) {
        const float omega = random_float(&random, 0.0, 3000.0);
        TEST_ASSERT_TRUE(lode_lag_rad(&lag, -omega) == -lode_lag_rad(&lag, omega));
    }
    TEST_ASSERT_TRUE(lode_lag_rad(&lag, 0.0f) == 0.0f);
}

static void test_beyond_the_range_it_is_a_straight_line(void) {
    lode_lag_t lag;
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &cases[0]));
    const double end = cases[0].omega_max;
    const double slope = (double)lode_lag_rad(&lag, (float)end) / end;
    for (int k = 1; k <= 20; k++) {
        const float omega = (float)(end * (1.0 + 0.1 * k));
        CHECK_CLOSE(2.0e-6, slope * (double)omega, lode_lag_rad(&lag, omega)); // float rounding
    }
}

static void test_no_compensation(void) {
    lode_lag_t lag;
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_NONE, &cases[0]));
    for (int k = -30; k <= 30; k++) {
        TEST_ASSERT_TRUE(lode_lag_rad(&lag, 100.0f * (float)k) == 0.0f);
    }
}

/// Sine and cosine as an angle and a length.
static double angle_of(lode_sincos_t x) {
    return atan2((double)x.sin, (double)x.cos);
}

static void test_sine_and_cosine_are_those_of_the_polynomial(void) {
    for (int i = 0; i < COUNT_OF(cases); i++) {
        lode_lag_t lag;
        TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &cases[i]));
        const double end = cases[i].omega_max;
        for (int k = -2000; k <= 2000; k++) { // up to where the estimator starts anew
            const float omega = (float)(end * k / 1000.0);
            const lode_sincos_t at = lode_lag_line(&lag, omega).at;
            const double expected = (double)lode_lag_rad(&lag, omega);
            // Past 90 degrees of lag, beyond omega_max only, sine and cosine leave their octant.
            CHECK_NEAR(abs(k) <= 1000 ? 3.0e-7 : 1.0e-4, 0.0, angle_error(expected, angle_of(at)));
            CHECK_NEAR(abs(k) <= 1000 ? 3.0e-7 : 5.0e-4, 1.0,
                       hypot((double)at.sin, (double)at.cos));
        }
    }
}

/// The line's slope is that of the curve, w P(v): P + 2 v P', and P alone beyond the range.
static void test_the_line_has_the_slope_of_the_lag(void) {
    for (int i = 0; i < COUNT_OF(cases); i++) {
        lode_lag_t lag;
        TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &cases[i]));
        for (int k = 1; k <= 120; k++) {
            const double omega = cases[i].omega_max * k / 100.0;
            const double v = fmin(omega * omega * (double)lag.inv_range2, 1.0);
            double value = 0.0;
            double rise = 0.0;
            for (int n = COUNT_OF(lag.coefficient) - 1; n >= 0; n--) {
                rise += n * (double)lag.coefficient[n] * (n > 0 ? pow(v, n) : 0.0);
                value += (double)lag.coefficient[n] * pow(v, n);
            }
            if (k == 100) { // the corner
                continue;
            }
            const lode_lag_line_t line = lode_lag_line(&lag, (float)omega);
            CHECK_NEAR(2.0e-6 * fabs((double)lag.coefficient[0]),
                       value + (k < 100 ? 2.0 * rise : 0.0), line.slope_s);
        }
    }
}

/// Nearby speeds go along the line; a line is far where it would move the lag by more than an eighth of a radian.
static void test_nearby_speeds_go_along_the_line(void) {
    lode_lag_t lag;
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &cases[0]));
    const lode_lag_line_t line = lode_lag_line(&lag, 600.0f);
    const double far_rad_s = 0.125 / fabs((double)line.slope_s);
    for (int sign = -1; sign <= 1; sign += 2) {
        const float near = 600.0f + 16.0f * (float)sign;
        CHECK_NEAR(
            4.0e-5, 0.0,
            angle_error((double)lode_lag_rad(&lag, near), angle_of(lode_lag_near(&line, near))));
        TEST_ASSERT_FALSE(lode_lag_is_far(&line, (float)(600.0 + 0.99 * sign * far_rad_s)));
        TEST_ASSERT_TRUE(lode_lag_is_far(&line, (float)(600.0 + 1.01 * sign * far_rad_s)));
    }
    TEST_ASSERT_TRUE(lode_lag_is_far(&line, NAN));
}

static void test_without_compensation_there_is_nothing_to_rotate_by(void) {
    lode_lag_t lag;
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_NONE, &cases[0]));
    const lode_sincos_t at = lode_lag_line(&lag, -2000.0f).at;
    TEST_ASSERT_TRUE(at.sin == 0.0f && at.cos == 1.0f);
}

/// What is accepted keeps its tolerance up to the very end of its range.
static void test_the_end_of_the_range_is_checked(void) {
    const case_t given = {0.75, 9.8e-3, 2.0e-4, 600.0, 600.0};
    double accepted = 1.0;
    double refused = 0.0;
    lode_lag_t lag;
    for (double times = 1.5; !(refused > 0.0); times *= 1.5) {
        case_t c = given;
        c.omega_max *= times;
        if (tune(&lag, LODE_LAG_EXACT, &c) == LODE_OK) {
            accepted = times;
        } else {
            refused = times;
        }
    }
    for (int n = 0; n < 30; n++) {
        case_t c = given;
        const double times = 0.5 * (accepted + refused);
        c.omega_max *= times;
        const bool taken = tune(&lag, LODE_LAG_EXACT, &c) == LODE_OK;
        accepted = taken ? times : accepted;
        refused = taken ? refused : times;
    }
    case_t last = given;
    last.omega_max *= accepted;
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&lag, LODE_LAG_EXACT, &last));
    const double end_rad =
        exact(&last, last.omega_max) - (double)lode_lag_rad(&lag, (float)last.omega_max);
    CHECK_AT_MOST(1.01 * (double)LODE_LAG_TOLERANCE_rad, fabs(end_rad));
}

static void check_refused(lode_lag_kind_t kind, const case_t *c) {
    lode_lag_t lag;
    memset(&lag, 0x5a, sizeof lag);
    const lode_lag_t before = lag;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_LAG, tune(&lag, kind, c));
    TEST_ASSERT_EQUAL_MEMORY(&before, &lag, sizeof lag);
}

static void test_eq_30_is_the_continuous_lag(void) {
    const lode_motor_t motor = paper_motor();
    const lode_emf_config_t config = {.kind = LODE_EMF_C_LESO, .w0_rad_s = 2000.0f};
    lode_lag_t lag;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_lag_tune(&lag, LODE_LAG_EQ30, &config, &motor, PAPER_TS_s, 1178.0f));
    for (int n = -20; n <= 20; n++) {
        const double omega = 1178.0 * n / 20.0;
        // Paper 1, eq. (30), as 2 atan(w/w0); the polynomial is right to 1e-5 rad.
        CHECK_NEAR(2.0e-5, 2.0 * atan(omega / 2000.0), lode_lag_rad(&lag, (float)omega));
    }
}

static void test_what_cannot_be_fitted_is_refused(void) {
    check_refused((lode_lag_kind_t)9, &cases[0]);
    // A range of 25 times w0: the arc tangent has its bend in the first 2 % of it.
    const case_t steep = {0.75, 9.8e-3, 2.0e-4, 100.0, 2500.0};
    check_refused(LODE_LAG_EXACT, &steep);
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        case_t bad = cases[0];
        bad.omega_max = (double)check_not_finite[i];
        check_refused(LODE_LAG_EXACT, &bad);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_polynomial_is_within_its_tolerance);
    RUN_TEST(test_polynomial_of_the_papers_motor_is_ten_times_better);
    RUN_TEST(test_polynomial_is_exact_at_the_nodes);
    RUN_TEST(test_polynomial_is_odd);
    RUN_TEST(test_beyond_the_range_it_is_a_straight_line);
    RUN_TEST(test_no_compensation);
    RUN_TEST(test_sine_and_cosine_are_those_of_the_polynomial);
    RUN_TEST(test_the_line_has_the_slope_of_the_lag);
    RUN_TEST(test_nearby_speeds_go_along_the_line);
    RUN_TEST(test_without_compensation_there_is_nothing_to_rotate_by);
    RUN_TEST(test_the_end_of_the_range_is_checked);
    RUN_TEST(test_eq_30_is_the_continuous_lag);
    RUN_TEST(test_what_cannot_be_fitted_is_refused);
    return UNITY_END();
}
