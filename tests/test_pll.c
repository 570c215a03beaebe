// Position PLLs: golden trajectories, tracking errors of paper 1's Table 1, poles, disturbance.
#include "support/fields.h"

#include "golden/pll.h"
#include "pll_inline.h"

#include <complex.h>

void setUp(void) {}

void tearDown(void) {}

/// One sigma at all speeds.
static lode_pll_tuning_t tuned(lode_pll_kind_t kind, double ts, double sigma) {
    const lode_pll_config_t config = {.kind = kind,
                                      .sigma_rad_s = (float)sigma,
                                      .sigma_low_rad_s = (float)sigma,
                                      .omega_low_rad_s = 10.0f,
                                      .omega_high_rad_s = 20.0f};
    lode_pll_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_pll_tune(&tuning, &config, (float)ts));
    return tuning;
}

/// The angle of the state.
static double theta_of(const lode_pll_t *pll) {
    return atan2((double)pll->frame.sin, (double)pll->frame.cos);
}

/// Where the state will stand in the next period, before it is corrected.
typedef struct {
    lode_sincos_t frame;
    float omega;
    double theta;
} prediction_t;

static prediction_t predicted(const lode_pll_t *pll, const lode_pll_tuning_t *tuning) {
    const lode_pll_motion_t motion = lode_pll_predict(pll, tuning);
    prediction_t next = {.omega = motion.omega_rad_s};
    next.frame = lode_angle_add(pll->frame, lode_sincos(motion.angle_rad));
    next.theta = atan2((double)next.frame.sin, (double)next.frame.cos);
    return next;
}

/// Corrects by `error`, with the gains of the speed that is predicted; `acc_rad_s2` is known.
static void correct(lode_pll_t *pll, const lode_pll_tuning_t *tuning, prediction_t next,
                    float error, float acc_rad_s2) {
    const lode_pll_gains_t gains = lode_pll_gains(tuning, next.omega);
    lode_pll_correct(pll, gains, next.frame, next.omega, error);
    lode_pll_correct_disturbance(pll, tuning, gains, error, acc_rad_s2);
}

static void check_golden(const pll_case_t *golden) {
    const lode_pll_tuning_t tuning = tuned(golden->third_order ? LODE_PLL_LESO : LODE_PLL_QPLL,
                                           golden->ts_s, golden->sigma_rad_s);
    lode_pll_t pll;
    lode_pll_reset(&pll, 0.0f, (float)golden->omega_rad_s);
    const float known = golden->third_order ? (float)golden->torque_rad_s2 : 0.0f;
    pll.rise_rad_s = tuning.ts_s * known;
    double theta = 0.4;
    double omega = golden->omega_rad_s;
    for (int k = 0; k < PLL_STEPS; k++) {
        const double acc = golden->torque_rad_s2 - (k >= 200 ? golden->load_rad_s2 : 0.0);
        theta += golden->ts_s * omega + 0.5 * golden->ts_s * golden->ts_s * acc;
        omega += golden->ts_s * acc;
        const prediction_t next = predicted(&pll, &tuning);
        const double error = sin(theta - next.theta);
        // The state moves by the arc tangent of the correction, the vectors by the correction itself.
        lode_pll_gains_t gains = lode_pll_gains(&tuning, next.omega);
        gains.theta = (float)(tan((double)gains.theta * error) / error);
        lode_pll_correct(&pll, gains, next.frame, next.omega, (float)error);
        lode_pll_correct_disturbance(&pll, &tuning, gains, (float)error, known);
        if ((k + 1) % PLL_EVERY == 0) {
            const int row = k / PLL_EVERY;
            // The loop holds the float state at the angle to its resolution near pi, 2.4e-7,
            // times a few steps' noise; speed and disturbance amplify it by 3 sigma and sigma^2.
            const double noise = 3.0e-6;
            const double sigma = golden->sigma_rad_s;
            CHECK_NEAR(noise, 0.0, angle_error(golden->theta[row], theta_of(&pll)));
            CHECK_NEAR(noise * 3.0 * sigma + 5.0e-4, golden->omega[row], pll.omega_rad_s);
            CHECK_NEAR(noise * 3.0 * sigma * sigma + 0.02, golden->f[row], pll.f_rad_s2);
        }
    }
}

static void test_both_orders_against_float64(void) {
    for (int i = 0; i < COUNT_OF(pll_cases); i++) {
        check_golden(&pll_cases[i]);
    }
}

/// Error theta - th' of the prediction after `steps` at the acceleration r, without torque known.
static double ramp_error(const lode_pll_tuning_t *tuning, double ts, double r, int steps) {
    lode_pll_t pll;
    lode_pll_reset(&pll, 0.0f, 100.0f);
    double theta = 0.0;
    double omega = 100.0;
    double error = 0.0;
    for (int k = 0; k < steps; k++) {
        theta += ts * omega + 0.5 * ts * ts * r;
        omega += ts * r;
        const prediction_t next = predicted(&pll, tuning);
        error = angle_error(theta, next.theta);
        correct(&pll, tuning, next, (float)error, 0.0f);
    }
    return error;
}

static void test_tracking_errors_of_table_1(void) {
    const double ts = 2.0e-4;
    const double sigma = 150.0;
    const lode_pll_tuning_t qpll = tuned(LODE_PLL_QPLL, ts, sigma);
    const lode_pll_tuning_t leso = tuned(LODE_PLL_LESO, ts, sigma);
    // A constant speed leaves no error; 1e-5: rounding of the wrapped angle.
    CHECK_NEAR(1.0e-5, 0.0, ramp_error(&qpll, ts, 0.0, 3000));
    CHECK_NEAR(1.0e-5, 0.0, ramp_error(&leso, ts, 0.0, 3000));
    for (int sign = -1; sign <= 1; sign += 2) {
        const double r = sign * 628.0;
        const double x = 1.0 - exp(-sigma * ts);
        const double error = ramp_error(&qpll, ts, r, 3000);
        // In the z-plane: r Ts = (1-s)^2 er/Ts each period. Float noise again.
        CHECK_NEAR(2.0e-5, r * ts * ts / (x * x), error);
        // Paper 1, Table 1: r/Ki, Ki = sigma^2; sampling makes it 3 % more at sigma Ts = 0.03.
        CHECK_CLOSE(0.05, r / (sigma * sigma), error);
        CHECK_NEAR(2.0e-5, 0.0, ramp_error(&leso, ts, r, 3000));
    }
}

/// Free response to a start angle of 1 mrad: a correction moves the angle by its arc tangent, which
/// is the correction itself to 1e-7 of it.
static void free_response(const lode_pll_tuning_t *tuning, double *angle, int count) {
    lode_pll_t pll;
    lode_pll_reset(&pll, 1.0e-3f, 0.0f);
    for (int k = 0; k < count; k++) {
        const prediction_t next = predicted(&pll, tuning);
        correct(&pll, tuning, next, (float)-next.theta, 0.0f);
        angle[k] = theta_of(&pll);
    }
}

static void test_poles_lie_at_exp_minus_sigma_Ts(void) {
    const double sigmas[] = {20.0, 100.0, 150.0, 400.0, 1400.0};
    for (int i = 0; i < COUNT_OF(sigmas); i++) {
        const double s = exp(-sigmas[i] * 2.0e-4);
        double a[100];
        const lode_pll_tuning_t qpll = tuned(LODE_PLL_QPLL, 2.0e-4, sigmas[i]);
        free_response(&qpll, a, COUNT_OF(a));
        for (int k = 2; k < COUNT_OF(a); k++) {
            // (z - s)^2; four terms of up to 2e-3 rounded to 6e-8 of that.
            CHECK_NEAR(5.0e-10, 0.0, a[k] - 2.0 * s * a[k - 1] + s * s * a[k - 2]);
        }
        const lode_pll_tuning_t leso = tuned(LODE_PLL_LESO, 2.0e-4, sigmas[i]);
        free_response(&leso, a, COUNT_OF(a));
        for (int k = 3; k < COUNT_OF(a); k++) {
            CHECK_NEAR(1.0e-9, 0.0,
                       a[k] - 3.0 * s * a[k - 1] + 3.0 * s * s * a[k - 2] - s * s * s * a[k - 3]);
        }
    }
}

/// How much faster the error falls in one period at this speed: the product of the poles is what
/// the correction leaves of the angle, 1 - (1 - s^n).
static double pole_at(const lode_pll_tuning_t *tuning, double omega) {
    lode_pll_t pll;
    lode_pll_reset(&pll, 0.0f, (float)omega);
    lode_pll_correct(&pll, lode_pll_gains(tuning, (float)omega), pll.frame, (float)omega, 0.01f);
    const double left = 1.0 - tan(theta_of(&pll)) / 0.01; // moved by the arc tangent
    return tuning->third_order != 0u ? cbrt(left) : sqrt(left);
}

static void test_bandwidth_is_scheduled_with_speed(void) {
    const double ts = 2.0e-4;
    lode_pll_config_t config = {.sigma_rad_s = 300.0f,
                                .sigma_low_rad_s = 50.0f,
                                .omega_low_rad_s = 40.0f,
                                .omega_high_rad_s = 200.0f};
    const lode_pll_kind_t kinds[] = {LODE_PLL_LESO, LODE_PLL_QPLL};
    for (int i = 0; i < COUNT_OF(kinds); i++) {
        config.kind = kinds[i];
        lode_pll_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_pll_tune(&tuning, &config, (float)ts));
        for (int sign = -1; sign <= 1; sign += 2) {
            // A correction of 0.01 rad carries 1e-7 relative.
            CHECK_NEAR(2.0e-6, exp(-50.0 * ts), pole_at(&tuning, 0.0));
            CHECK_NEAR(2.0e-6, exp(-50.0 * ts), pole_at(&tuning, 40.0 * sign));
            CHECK_NEAR(2.0e-6, exp(-300.0 * ts), pole_at(&tuning, 200.0 * sign));
            CHECK_NEAR(2.0e-6, exp(-300.0 * ts), pole_at(&tuning, 5000.0 * sign));
            // Between them straight in 1 - s.
            CHECK_NEAR(2.0e-6, 0.75 * exp(-50.0 * ts) + 0.25 * exp(-300.0 * ts),
                       pole_at(&tuning, 80.0 * sign));
        }
    }
}

static void test_gains_place_all_poles_at_s(void) {
    const double ts = 2.0e-4;
    random_t random = random_seed(2);
    for (int n = 0; n < 2000; n++) {
        const double low = random_between(&random, 5.0, 700.0);
        const double high = random_between(&random, low, 1490.0);
        const lode_pll_config_t config = {.kind = n % 2 == 0 ? LODE_PLL_LESO : LODE_PLL_QPLL,
                                          .sigma_rad_s = (float)high,
                                          .sigma_low_rad_s = (float)low,
                                          .omega_low_rad_s = 40.0f,
                                          .omega_high_rad_s = 200.0f};
        lode_pll_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_pll_tune(&tuning, &config, (float)ts));
        const double omega = random_between(&random, -300.0, 300.0);
        const double share = fmax(0.0, fmin(1.0, (fabs(omega) - 40.0) / 160.0));
        const double s = (1.0 - share) * exp(-low * ts) + share * exp(-high * ts);
        const lode_pll_gains_t gains = lode_pll_gains(&tuning, (float)omega);
        // (z - s)^3 and (z - s)^2; 1 - s is down to 1e-3 and goes in up to its third power.
        if (n % 2 == 0) {
            CHECK_CLOSE(1.0e-5, 1.0 - s * s * s, gains.theta);
            CHECK_CLOSE(1.0e-5, 1.5 * (1.0 - s) * (1.0 - s) * (1.0 + s) / ts, gains.omega_s);
            CHECK_CLOSE(1.0e-5, pow((1.0 - s) / ts, 3.0) * ts, gains.f_s2);
        } else {
            CHECK_CLOSE(1.0e-5, 1.0 - s * s, gains.theta);
            CHECK_CLOSE(1.0e-5, (1.0 - s) * (1.0 - s) / ts, gains.omega_s);
            TEST_ASSERT_TRUE(gains.f_s2 == 0.0f);
        }
    }
}

static void test_gains_of_any_speed_lie_between_the_two(void) {
    const lode_pll_config_t config = {.sigma_rad_s = 300.0f,
                                      .sigma_low_rad_s = 50.0f,
                                      .omega_low_rad_s = 40.0f,
                                      .omega_high_rad_s = 200.0f};
    lode_pll_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_pll_tune(&tuning, &config, PAPER_TS_s));
    const lode_pll_gains_t least = lode_pll_gains(&tuning, 0.0f);
    const lode_pll_gains_t most = lode_pll_gains(&tuning, 1000.0f);
    random_t random = random_seed(3);
    for (int n = 0; n < 100000; n++) {
        const float omega =
            n < COUNT_OF(check_odd_floats) ? check_odd_floats[n] : random_any(&random);
        const lode_pll_gains_t gains = lode_pll_gains(&tuning, omega);
        TEST_ASSERT_TRUE(lode_in_range(gains.theta, least.theta, most.theta));
        TEST_ASSERT_TRUE(lode_in_range(gains.omega_s, least.omega_s, most.omega_s));
        TEST_ASSERT_TRUE(lode_in_range(gains.f_s2, least.f_s2, most.f_s2));
    }
}

static void test_the_prediction_is_the_motion_of_a_period(void) {
    const lode_pll_tuning_t tuning = tuned(LODE_PLL_LESO, 2.0e-4, 100.0);
    random_t random = random_seed(4);
    for (int n = 0; n < 10000; n++) {
        lode_pll_t pll;
        lode_pll_reset(&pll, 0.5f, random_float(&random, -2500.0, 2500.0));
        pll.rise_rad_s = random_float(&random, -0.8, 0.8);
        const lode_pll_t before = pll;
        const lode_pll_motion_t motion = lode_pll_predict(&pll, &tuning);
        const double acc = (double)pll.rise_rad_s / 2.0e-4;
        // Constant acceleration, exactly; floats of 0.5 rad and 2500 rad/s.
        CHECK_NEAR(1.0e-7, 2.0e-4 * (double)pll.omega_rad_s + 2.0e-8 * acc, motion.angle_rad);
        CHECK_NEAR(3.0e-4, (double)pll.omega_rad_s + 2.0e-4 * acc, motion.omega_rad_s);
        TEST_ASSERT_EQUAL_MEMORY(&before, &pll, sizeof pll); // nothing moved yet
    }
}

static void test_disturbance_is_the_load_torque(void) {
    const lode_motor_t motor = paper_motor();
    const double np = (double)motor.pole_pairs;
    const double J = (double)motor.J_kgm2;
    const lode_pll_tuning_t tuning = tuned(LODE_PLL_LESO, 2.0e-4, 100.0);
    for (int sign = -1; sign <= 1; sign += 2) {
        const double load = sign * 5.0;
        const double torque = sign * 3.5;
        lode_pll_t pll;
        lode_pll_reset(&pll, 0.0f, 200.0f);
        const float known = (float)(np / J * torque);
        pll.rise_rad_s = tuning.ts_s * known;
        double theta = 0.0;
        double omega = 200.0;
        for (int k = 0; k < 1500; k++) {
            const double acc = np / J * (torque - load);
            theta += 2.0e-4 * omega + 2.0e-8 * acc;
            omega += 2.0e-4 * acc;
            const prediction_t next = predicted(&pll, &tuning);
            correct(&pll, &tuning, next, (float)angle_error(theta, next.theta), known);
        }
        CHECK_CLOSE(2.0e-3, -np * load / J, pll.f_rad_s2); // 30 time constants; float noise
        CHECK_NEAR(0.01, omega, pll.omega_rad_s);
    }
}

static void test_motion_mirrored_gives_states_mirrored(void) {
    const lode_pll_kind_t kinds[] = {LODE_PLL_LESO, LODE_PLL_QPLL};
    for (int i = 0; i < COUNT_OF(kinds); i++) {
        const lode_pll_tuning_t tuning = tuned(kinds[i], 2.0e-4, 150.0);
        lode_pll_t ahead;
        lode_pll_t back;
        lode_pll_reset(&ahead, 1.0f, 50.0f);
        lode_pll_reset(&back, -1.0f, -50.0f);
        random_t random = random_seed(1);
        for (int k = 0; k < 2000; k++) {
            const float error = random_float(&random, -0.2, 0.2);
            correct(&ahead, &tuning, predicted(&ahead, &tuning), error, 0.0f);
            correct(&back, &tuning, predicted(&back, &tuning), -error, 0.0f);
            TEST_ASSERT_TRUE(ahead.frame.sin == -back.frame.sin);
            TEST_ASSERT_TRUE(ahead.frame.cos == back.frame.cos);
            TEST_ASSERT_TRUE(ahead.omega_rad_s == -back.omega_rad_s);
            TEST_ASSERT_TRUE(ahead.f_rad_s2 == -back.f_rad_s2);
        }
    }
}

static void test_reset_takes_up_a_motion(void) {
    lode_pll_t pll = {
        .frame = {9.0f, NAN}, .omega_rad_s = NAN, .f_rad_s2 = 1.0f, .rise_rad_s = 2.0f};
    lode_pll_reset(&pll, 7.0f, -33.0f);
    CHECK_NEAR(1.0e-6, 7.0 - 2.0 * CHECK_PI, theta_of(&pll));
    TEST_ASSERT_EQUAL_FLOAT(-33.0f, pll.omega_rad_s);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, pll.f_rad_s2);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, pll.rise_rad_s);
}

static lode_pll_config_t sound_config(void) {
    return (lode_pll_config_t){.kind = LODE_PLL_LESO,
                               .sigma_rad_s = 150.0f,
                               .sigma_low_rad_s = 60.0f,
                               .omega_low_rad_s = 40.0f,
                               .omega_high_rad_s = 200.0f};
}

static lode_status_t try_config(const lode_pll_config_t *config) {
    lode_pll_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_pll_tuning_t before = tuning;
    const lode_status_t status = lode_pll_tune(&tuning, config, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_pll_config_t config = sound_config();
    field_set(&config, offset, value);
    return try_config(&config);
}

static void test_every_field_at_its_limits(void) {
    // sigma: 1 .. 0.3/Ts = 1500, above the low one; the schedule rises.
    static const field_t fields[] = {
        {FIELD(lode_pll_config_t, sigma_rad_s), .lo = 60.0f, .hi = 1500.0f, .computed = true,
         .error = LODE_ERROR_PLL_SIGMA},
        {FIELD(lode_pll_config_t, sigma_low_rad_s), .lo = 1.0f, .hi = 150.0f,
         .error = LODE_ERROR_PLL_SIGMA},
        {FIELD(lode_pll_config_t, omega_low_rad_s), .lo = 0.0f, .hi = 199.9f, .coupled = true,
         .computed = true, .error = LODE_ERROR_PLL_SCHEDULE},
    };
    field_check(&fields[0], try_one);
    field_check(&fields[1], try_one);
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        field_refused(&fields[2], try_one, check_not_finite[i]);
    }
    field_accepted(&fields[2], try_one, 0.0f);
    field_accepted(&fields[2], try_one, 199.9f);
    field_refused(&fields[2], try_one, -0.01f);
    field_refused(&fields[2], try_one, 200.0f);
    field_refused(&fields[2], try_one, 200.1f);
    const size_t high = offsetof(lode_pll_config_t, omega_high_rad_s);
    const float bad[] = {40.0f, 39.0f, 0.0f, -1.0f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_SCHEDULE, try_one(high, bad[i]));
    }
    // A span whose reciprocal is no number.
    lode_pll_config_t tiny = sound_config();
    tiny.omega_low_rad_s = 0.0f;
    tiny.omega_high_rad_s = 1.0e-40f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_SCHEDULE, try_config(&tiny));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(high, 40.1f));
}

static void test_kind_is_an_enumerator(void) {
    lode_pll_config_t config = sound_config();
    config.kind = (lode_pll_kind_t)2;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_KIND, try_config(&config));
    config.kind = LODE_PLL_QPLL;
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_config(&config));
}

/// One bandwidth alone is that of all speeds, down to the least one that is accepted.
static void test_a_bandwidth_that_is_given_is_that_of_all_speeds(void) {
    const float sigmas[] = {1.0f, 150.0f};
    for (int n = 0; n < COUNT_OF(sigmas); n++) {
        lode_pll_config_t config = {.sigma_rad_s = sigmas[n]};
        lode_pll_design(&config, 471.0f, PAPER_TS_s);
        CHECK_NEAR(0.0, sigmas[n], config.sigma_rad_s);
        CHECK_NEAR(0.0, sigmas[n], config.sigma_low_rad_s);
    }
}

static void test_design_fills_what_is_open(void) {
    lode_pll_config_t config = {.kind = LODE_PLL_LESO};
    lode_pll_design(&config, 471.239f, 2.0e-4f);
    // As documented: 0.21 and 0.11 of the rated speed, between 0.1 and 0.2 of it; two digits.
    CHECK_CLOSE(0.025, 0.21 * 471.239, config.sigma_rad_s);
    CHECK_CLOSE(0.05, 0.11 * 471.239, config.sigma_low_rad_s);
    CHECK_CLOSE(1.0e-6, 47.1239, config.omega_low_rad_s);
    CHECK_CLOSE(1.0e-6, 94.2478, config.omega_high_rad_s);
    lode_pll_config_t second = {.kind = LODE_PLL_QPLL}; // (P22)
    lode_pll_design(&second, 471.239f, 2.0e-4f);
    CHECK_CLOSE(1.0e-6, 1.65 * (double)config.sigma_rad_s, second.sigma_rad_s);
    CHECK_CLOSE(1.0e-6, 1.65 * (double)config.sigma_low_rad_s, second.sigma_low_rad_s);
    // At a rated speed of 0.49 rad a period, bounded by what the largest default of w0 bears (P10).
    lode_pll_config_t quick = {.kind = LODE_PLL_LESO};
    lode_pll_design(&quick, 2450.0f, 2.0e-4f);
    CHECK_CLOSE(1.1e-3, 0.1 / 2.0e-4, quick.sigma_rad_s);
    lode_pll_config_t given = {.sigma_rad_s = 150.0f};
    lode_pll_design(&given, 471.239f, 2.0e-4f);
    TEST_ASSERT_EQUAL_FLOAT(150.0f, given.sigma_rad_s);
    TEST_ASSERT_EQUAL_FLOAT(150.0f, given.sigma_low_rad_s);
    // Each default by itself is a value that is accepted.
    lode_pll_config_t low = {.sigma_low_rad_s = 1.5f * config.sigma_rad_s};
    lode_pll_design(&low, 471.239f, 2.0e-4f);
    TEST_ASSERT_EQUAL_FLOAT(low.sigma_low_rad_s, low.sigma_rad_s);
    lode_pll_config_t slow = {.sigma_low_rad_s = 20.0f};
    lode_pll_design(&slow, 471.239f, 2.0e-4f);
    TEST_ASSERT_EQUAL_FLOAT(config.sigma_rad_s, slow.sigma_rad_s);
    const lode_pll_config_t all = sound_config();
    lode_pll_config_t kept = all;
    lode_pll_design(&kept, 471.239f, 2.0e-4f);
    TEST_ASSERT_EQUAL_MEMORY(&all, &kept, sizeof all);
}

/// Distance of -1 from what a narrow notch at w makes of the open loop (3 s^2 + 3 s + 1)/s^3, or (2 s + 1)/s^2, s = jw/sigma:
/// a circle through 0 and the loop's response there. Below 0: it lies inside, and the loop is unstable.
static double distance(lode_pll_kind_t kind, double w_per_sigma) {
    const double complex s = I * w_per_sigma;
    const double complex loop = kind == LODE_PLL_QPLL ? (2.0 * s + 1.0) / (s * s)
                                                      : (3.0 * s * s + 3.0 * s + 1.0) / (s * s * s);
    return cabs(-1.0 - 0.5 * loop) - 0.5 * cabs(loop);
}

/// (P31)
static void test_least_frequency_of_a_notch(void) {
    const double of_limit[] = {1.7320508, 1.0};
    const double kept[] = {0.33, 0.29};
    const lode_pll_kind_t kinds[] = {LODE_PLL_LESO, LODE_PLL_QPLL};
    for (int n = 0; n < COUNT_OF(kinds); n++) {
        const lode_pll_config_t config = {
            .kind = kinds[n], .sigma_rad_s = 200.0f, .sigma_low_rad_s = 100.0f};
        const double per_sigma = (double)lode_pll_notch_rad_s(&config) / 200.0;
        CHECK_NEAR(1.0e-6, 0.0, distance(kinds[n], of_limit[n]));
        CHECK_NEAR(0.005, kept[n], distance(kinds[n], per_sigma));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_both_orders_against_float64);
    RUN_TEST(test_tracking_errors_of_table_1);
    RUN_TEST(test_poles_lie_at_exp_minus_sigma_Ts);
    RUN_TEST(test_bandwidth_is_scheduled_with_speed);
    RUN_TEST(test_gains_place_all_poles_at_s);
    RUN_TEST(test_gains_of_any_speed_lie_between_the_two);
    RUN_TEST(test_the_prediction_is_the_motion_of_a_period);
    RUN_TEST(test_disturbance_is_the_load_torque);
    RUN_TEST(test_motion_mirrored_gives_states_mirrored);
    RUN_TEST(test_reset_takes_up_a_motion);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_kind_is_an_enumerator);
    RUN_TEST(test_a_bandwidth_that_is_given_is_that_of_all_speeds);
    RUN_TEST(test_design_fills_what_is_open);
    RUN_TEST(test_least_frequency_of_a_notch);
    return UNITY_END();
}
