// A value that moves at a bounded rate, and the fade between two values.
#include "support/check.h"

#include "ramp_inline.h"

void setUp(void) {}

void tearDown(void) {}

static void test_ramp_is_a_straight_line_to_its_target(void) {
    float value = -1.0f;
    float rest = 0.0f;
    for (int n = 1; n <= 100; n++) {
        const float step = lode_ramp(&value, &rest, 2.0f, 0.125f); // exact in binary
        const double expected = -1.0 + 0.125 * n;
        TEST_ASSERT_EQUAL_DOUBLE(expected < 2.0 ? expected : 2.0, (double)value);
        TEST_ASSERT_EQUAL_FLOAT(n <= 24 ? 0.125f : 0.0f, step);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, rest);
    }
}

static void test_ramp_down(void) {
    float value = 1.0f;
    float rest = 0.0f;
    TEST_ASSERT_EQUAL_FLOAT(-0.25f, lode_ramp(&value, &rest, -5.0f, 0.25f));
    TEST_ASSERT_EQUAL_FLOAT(0.75f, value);
    TEST_ASSERT_EQUAL_FLOAT(-5.75f, lode_ramp(&value, &rest, -5.0f, 100.0f));
    TEST_ASSERT_EQUAL_FLOAT(-5.0f, value);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_ramp(&value, &rest, -6.0f, 0.0f));
    TEST_ASSERT_EQUAL_FLOAT(-5.0f, value);
}

static void test_ramp_never_overshoots(void) {
    random_t random = random_seed(1);
    for (int i = 0; i < CHECK_TRIES(100000); i++) {
        const float value = random_float(&random, -10.0, 10.0);
        const float target = random_float(&random, -10.0, 10.0);
        const float step = random_float(&random, 0.0, 5.0);
        float next = value;
        float rest = 0.0f;
        (void)lode_ramp(&next, &rest, target, step);
        // One rounding of a sum up to 10.
        CHECK_AT_MOST((double)step + 1.0e-6, fabs((double)(next - value)));
        CHECK_AT_MOST(fabs((double)(target - value)) + 1.0e-6, fabs((double)(next - value)));
        CHECK_AT_LEAST(-1.0e-6, (double)((next - value) * (target - value)));
    }
}

/// (K35): steps of a fifth to five times the value's last digit, 3e-5 at 300.
static void test_no_step_of_a_ramp_is_lost_to_rounding(void) {
    const float steps[] = {6.0e-6f, 2.0e-5f, 4.0e-5f, 1.5e-4f};
    for (int n = 0; n < COUNT_OF(steps); n++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            float value = 300.0f;
            float rest = 0.0f;
            const int calls = 1000000;
            for (int k = 0; k < calls; k++) {
                TEST_ASSERT_EQUAL_FLOAT((float)sign * steps[n],
                                        lode_ramp(&value, &rest, (float)sign * 1000.0f, steps[n]));
            }
            CHECK_NEAR(300.0 + sign * calls * (double)steps[n], 1.0e-4, value);
            CHECK_AT_MOST(1.6e-5, fabs((double)rest));
        }
    }
}

/// The last step is what is left of the way, with what rounding has left out before.
static void test_the_steps_of_a_ramp_add_up_to_its_way(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        const float target = 300.0f + (float)sign * 0.01f;
        float value = 300.0f;
        float rest = 0.0f;
        double sum = 0.0;
        float step;
        do {
            step = lode_ramp(&value, &rest, target, 1.3e-5f);
            sum += (double)step;
        } while (lode_abs(step) > 0.0f);
        CHECK_NEAR(1.0e-8, (double)target - 300.0, sum);
        TEST_ASSERT_EQUAL_FLOAT(target, value);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, rest);
    }
}

static void test_a_target_that_is_no_number_is_ignored(void) {
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        float value = 3.0f;
        float rest = 1.0e-8f;
        TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_ramp(&value, &rest, check_not_finite[i], 1.0f));
        TEST_ASSERT_EQUAL_FLOAT(3.0f, value);
        TEST_ASSERT_EQUAL_FLOAT(1.0e-8f, rest);
    }
}

static void test_fade(void) {
    const lode_fade_t fade = {.high = 6.0f, .slope = 1.0f / (6.0f - 2.0f)};
    TEST_ASSERT_EQUAL_FLOAT(1.0f, lode_fade(&fade, -100.0f));
    TEST_ASSERT_EQUAL_FLOAT(1.0f, lode_fade(&fade, 2.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.75f, lode_fade(&fade, 3.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.5f, lode_fade(&fade, 4.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_fade(&fade, 6.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_fade(&fade, 1.0e30f));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_fade(&fade, NAN));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_ramp_is_a_straight_line_to_its_target);
    RUN_TEST(test_ramp_down);
    RUN_TEST(test_ramp_never_overshoots);
    RUN_TEST(test_no_step_of_a_ramp_is_lost_to_rounding);
    RUN_TEST(test_the_steps_of_a_ramp_add_up_to_its_way);
    RUN_TEST(test_a_target_that_is_no_number_is_ignored);
    RUN_TEST(test_fade);
    return UNITY_END();
}
