// A value that moves at a bounded rate, and the fade between two values.
#include "support/check.h"

#include "ramp_inline.h"

void setUp(void) {}

void tearDown(void) {}

static void test_ramp_is_a_straight_line_to_its_target(void) {
    float value = -1.0f;
    for (int n = 1; n <= 100; n++) {
        value = lode_ramp(value, 2.0f, 0.125f); // exact in binary
        const double expected = -1.0 + 0.125 * n;
        TEST_ASSERT_EQUAL_DOUBLE(expected < 2.0 ? expected : 2.0, (double)value);
    }
}

static void test_ramp_down(void) {
    float value = 1.0f;
    value = lode_ramp(value, -5.0f, 0.25f);
    TEST_ASSERT_EQUAL_FLOAT(0.75f, value);
    value = lode_ramp(value, -5.0f, 100.0f);
    TEST_ASSERT_EQUAL_FLOAT(-5.0f, value);
    TEST_ASSERT_EQUAL_FLOAT(-5.0f, lode_ramp(value, -6.0f, 0.0f));
}

static void test_ramp_never_overshoots(void) {
    random_t random = random_seed(1);
    for (int i = 0; i < CHECK_TRIES(100000); i++) {
        const float value = random_float(&random, -10.0, 10.0);
        const float target = random_float(&random, -10.0, 10.0);
        const float step = random_float(&random, 0.0, 5.0);
        const float next = lode_ramp(value, target, step);
        // One rounding of a sum up to 10.
        CHECK_AT_MOST((double)step + 1.0e-6, fabs((double)(next - value)));
        CHECK_AT_MOST(fabs((double)(target - value)) + 1.0e-6, fabs((double)(next - value)));
        CHECK_AT_LEAST(-1.0e-6, (double)((next - value) * (target - value)));
    }
}

static void test_a_target_that_is_no_number_is_ignored(void) {
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        TEST_ASSERT_EQUAL_FLOAT(3.0f, lode_ramp(3.0f, check_not_finite[i], 1.0f));
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
    RUN_TEST(test_a_target_that_is_no_number_is_ignored);
    RUN_TEST(test_fade);
    return UNITY_END();
}
