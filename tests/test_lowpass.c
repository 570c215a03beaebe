// First-order low-pass: exact for an input held over the period.
#include "support/check.h"

#include "lodestar/lowpass.h"

void setUp(void) {}

void tearDown(void) {}

static void test_step_response_is_the_continuous_one(void) {
    const double taus[] = {2.0e-5, 2.0e-4, 1.0e-3, 0.05};
    for (int i = 0; i < COUNT_OF(taus); i++) {
        const float weight = lode_lowpass_weight((float)taus[i], 2.0e-4f);
        float value = 1.0f;
        for (int n = 1; n <= 1000; n++) {
            value = lode_lowpass(value, weight, -3.0f);
            // The filter settles within half a last place of its step over the weight.
            CHECK_NEAR(2.0e-7 / (double)weight + 2.0e-6, -3.0 + 4.0 * exp(-2.0e-4 * n / taus[i]),
                       value);
        }
    }
}

static void test_weight(void) {
    // 1 - exp(-ts/tau): Ts = tau gives 0.6321205588.
    CHECK_CLOSE(5.0e-7, 0.6321205588, lode_lowpass_weight(1.0e-3f, 1.0e-3f));
    CHECK_CLOSE(5.0e-7, -expm1(-2.0e-4 / 5.0e-3), lode_lowpass_weight(5.0e-3f, 2.0e-4f));
    TEST_ASSERT_EQUAL_FLOAT(1.0f, lode_lowpass_weight(0.0f, 2.0e-4f));
}

static void test_no_filter_passes_all(void) {
    TEST_ASSERT_EQUAL_FLOAT(7.0f, lode_lowpass(-2.0f, lode_lowpass_weight(0.0f, 1.0e-4f), 7.0f));
}

static void test_gain_at_a_frequency(void) {
    // |H| = w / |1 - (1 - w) exp(-j W)| of the exact recursion.
    const double weight = (double)lode_lowpass_weight(1.0e-3f, 2.0e-4f);
    const double turn = 0.3;
    const double re = 1.0 - (1.0 - weight) * cos(turn);
    const double im = (1.0 - weight) * sin(turn);
    float value = 0.0f;
    double peak = 0.0;
    for (int n = 0; n < 5000; n++) {
        value = lode_lowpass(value, (float)weight, (float)cos(turn * n));
        peak = n > 1000 ? fmax(peak, fabs((double)value)) : 0.0;
    }
    // 4000 samples at an incommensurate angle come within 1e-5 of the crest.
    CHECK_NEAR(2.0e-5, weight / sqrt(re * re + im * im), peak);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_step_response_is_the_continuous_one);
    RUN_TEST(test_weight);
    RUN_TEST(test_no_filter_passes_all);
    RUN_TEST(test_gain_at_a_frequency);
    return UNITY_END();
}
