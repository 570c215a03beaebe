// Sine and cosine by the STM32G4's CORDIC, a model with its residual error, through the core's hook.
#include "chip.h"
#include "fake.h"
#include "support/check.h"

void setUp(void) {}

void tearDown(void) {}

static void test_error_within_the_contract(void) {
    for (int n = -400000; n <= 400000; n++) {
        const float x = (float)n * (n % 2 == 0 ? 1.0e-4f : 6.2e-5f); // beyond six turns
        const lode_sincos_t got = lode_sincos(x);
        CHECK_NEAR(1.0e-5, sin((double)x), got.sin);
        CHECK_NEAR(1.0e-5, cos((double)x), got.cos);
    }
}

static void test_half_turns_and_what_is_no_angle(void) {
    static const float angles[] = {0.0f,
                                   LODE_PI,
                                   -LODE_PI,
                                   3.0f * LODE_PI,
                                   LODE_HALF_PI,
                                   LODE_ANGLE_LIMIT_rad,
                                   -LODE_ANGLE_LIMIT_rad};
    for (int n = 0; n < COUNT_OF(angles); n++) {
        const lode_sincos_t got = lode_sincos(angles[n]);
        CHECK_NEAR(1.0e-5, sin((double)angles[n]), got.sin);
        CHECK_NEAR(1.0e-5, cos((double)angles[n]), got.cos);
    }
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1.0e9f};
    for (int n = 0; n < COUNT_OF(bad); n++) {
        const lode_sincos_t got = lode_sincos(bad[n]);
        CHECK_NEAR(1.0e-5, 0.0, got.sin);
        CHECK_NEAR(1.0e-5, 1.0, got.cos);
    }
}

// The model answers only while the interrupt is masked; the mask is left as it was.
static void test_mask_is_given_back(void) {
    (void)lode_sincos(1.0f);
    TEST_ASSERT_EQUAL_UINT32(0u, __get_PRIMASK());
    __disable_irq();
    (void)lode_sincos(1.0f);
    TEST_ASSERT_EQUAL_UINT32(1u, __get_PRIMASK());
    __set_PRIMASK(0u);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_error_within_the_contract);
    RUN_TEST(test_half_turns_and_what_is_no_angle);
    RUN_TEST(test_mask_is_given_back);
    return UNITY_END();
}
