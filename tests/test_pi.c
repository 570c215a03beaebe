// PI controller: closed-form responses and anti-windup on the realised output.
#include "support/check.h"

#include "pi_inline.h"

void setUp(void) {}

void tearDown(void) {}

static void test_step_response_is_a_straight_line(void) {
    const lode_pi_tuning_t tuning = {.kp = 2.5f, .ki_Ts = 0.03f};
    lode_pi_t pi;
    lode_pi_reset(&pi, 1.0f);
    for (int n = 0; n < 1000; n++) {
        const float error = -0.4f;
        const float feed_forward = 7.0f;
        const float output = lode_pi_output(&pi, &tuning, error, feed_forward);
        // A thousand float additions of 0.012 to numbers up to 12.
        CHECK_NEAR(5.0e-4, 1.0 - 0.4 * 2.5 + 7.0 - 0.4 * 0.03 * n, output);
        lode_pi_settle(&pi, &tuning, error, feed_forward, output, output);
    }
}

static void test_output_leaves_the_state_alone(void) {
    const lode_pi_tuning_t tuning = {.kp = 2.0f, .ki_Ts = 0.5f};
    lode_pi_t pi;
    lode_pi_reset(&pi, 3.0f);
    TEST_ASSERT_TRUE(lode_pi_output(&pi, &tuning, 1.0f, 0.0f) == 5.0f);
    TEST_ASSERT_TRUE(lode_pi_output(&pi, &tuning, 1.0f, 0.0f) == 5.0f);
}

/// One period against a limit of +-10; returns the realised output.
static float limited(lode_pi_t *pi, const lode_pi_tuning_t *tuning, float error, float ff) {
    const float output = lode_pi_output(pi, tuning, error, ff);
    const float realised = lode_clamp(output, -10.0f, 10.0f);
    lode_pi_settle(pi, tuning, error, ff, output, realised);
    return realised;
}

static void test_no_windup_in_one_second_of_saturation(void) {
    const lode_pi_tuning_t tuning = {.kp = 2.0f, .ki_Ts = 0.01f};
    for (int sign = -1; sign <= 1; sign += 2) {
        const float s = (float)sign;
        lode_pi_t pi;
        lode_pi_reset(&pi, 0.0f);
        for (int n = 0; n < 5000; n++) {
            TEST_ASSERT_EQUAL_FLOAT(10.0f * s, limited(&pi, &tuning, 50.0f * s, 3.0f * s));
        }
        // An unlimited integral would stand at 2500; no state needs more than limit, kp e and
        // feed-forward together.
        CHECK_AT_MOST(10.0 + 100.0 + 3.0, fabs((double)pi.integral));
        // At the first error of the other sign the output leaves the limit.
        CHECK_AT_MOST(10.0 - 1.0, s * limited(&pi, &tuning, -1.0f * s, 3.0f * s));
    }
}

static void test_release_from_saturation_does_not_kick(void) {
    // The reference comes back to where the output at the limit has brought the plant: the error
    // is gone at once. What kp e held at the limit must not turn into its opposite.
    const lode_pi_tuning_t tuning = {.kp = 2.0f, .ki_Ts = 0.01f};
    for (int sign = -1; sign <= 1; sign += 2) {
        const float s = (float)sign;
        lode_pi_t pi;
        lode_pi_reset(&pi, 0.0f);
        for (int n = 0; n < 5000; n++) {
            (void)limited(&pi, &tuning, 50.0f * s, 0.0f);
        }
        CHECK_AT_LEAST(0.0, s * limited(&pi, &tuning, 0.0f, 0.0f));
    }
}

static void test_integral_never_takes_in_the_feed_forward(void) {
    // Output saturated by the feed-forward alone: when it goes, nothing of it must be left.
    const lode_pi_tuning_t tuning = {.kp = 1.0f, .ki_Ts = 0.1f};
    lode_pi_t pi;
    lode_pi_reset(&pi, 0.0f);
    for (int n = 0; n < 100; n++) {
        (void)limited(&pi, &tuning, 0.0f, 25.0f);
    }
    // The limit less the feed-forward, -15, and the output at the limit without a jump. A hundred
    // periods at ki Ts/kp = 0.1 leave 3e-5 of the 15.
    CHECK_NEAR(1.0e-3, -15.0, pi.integral);
    CHECK_NEAR(1.0e-3, 10.0, limited(&pi, &tuning, 0.0f, 25.0f));
}

static void test_closed_loop_around_an_integrator(void) {
    // x += u: with kp = 0.3, ki Ts = 0.0225 both poles are at z = 0.85; the response of the
    // linear recursion itself is the reference.
    const lode_pi_tuning_t tuning = {.kp = 0.3f, .ki_Ts = 0.0225f};
    lode_pi_t pi;
    lode_pi_reset(&pi, 0.0f);
    float x = 0.0f;
    double integral = 0.0;
    double y = 0.0;
    for (int n = 0; n < 200; n++) {
        const float error = 1.0f - x;
        const float u = lode_pi_output(&pi, &tuning, error, 0.0f);
        lode_pi_settle(&pi, &tuning, error, 0.0f, u, u);
        const double e = 1.0 - y;
        y += 0.3 * e + integral;
        integral += 0.0225 * e;
        x += u;
        CHECK_NEAR(2.0e-6, y, x);
    }
    CHECK_NEAR(1.0e-4, 1.0, x);
}

static void test_integrating_is_settling_inside_the_limits(void) {
    random_t random = random_seed(1);
    for (int n = 0; n < 100000; n++) {
        const lode_pi_tuning_t tuning = {.kp = random_float(&random, 0.0, 10.0),
                                         .ki_Ts = random_float(&random, 0.0, 1.0)};
        lode_pi_t one;
        lode_pi_reset(&one, random_float(&random, -100.0, 100.0));
        lode_pi_t two = one;
        const float error = random_float(&random, -20.0, 20.0);
        const float ff = random_float(&random, -50.0, 50.0);
        const float output = lode_pi_output(&one, &tuning, error, ff);
        lode_pi_settle(&one, &tuning, error, ff, output, output);
        lode_pi_integrate(&two, &tuning, error);
        TEST_ASSERT_TRUE(one.integral == two.integral);
    }
}

static void test_reset_is_idempotent(void) {
    lode_pi_t pi;
    lode_pi_reset(&pi, -4.0f);
    lode_pi_reset(&pi, -4.0f);
    TEST_ASSERT_TRUE(pi.integral == -4.0f);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_step_response_is_a_straight_line);
    RUN_TEST(test_output_leaves_the_state_alone);
    RUN_TEST(test_no_windup_in_one_second_of_saturation);
    RUN_TEST(test_release_from_saturation_does_not_kick);
    RUN_TEST(test_integral_never_takes_in_the_feed_forward);
    RUN_TEST(test_closed_loop_around_an_integrator);
    RUN_TEST(test_integrating_is_settling_inside_the_limits);
    RUN_TEST(test_reset_is_idempotent);
    return UNITY_END();
}
