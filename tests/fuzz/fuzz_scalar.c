// Every scalar function: a finite result in its range, whatever goes in.
#include "ramp_inline.h"
#include "sogi_inline.h"
#include "support/fuzz.h"

static void check_angle(float x) {
    FUZZ_CHECK(lode_in_range(x, -LODE_PI, LODE_PI));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    lode_sogi_t sogi;
    lode_sogi_reset(&sogi);
    while (fuzz_more(&in)) {
        const float x = fuzz_float(&in);
        const float y = fuzz_float(&in);
        const lode_sincos_t s = lode_sincos(x);
        FUZZ_CHECK(lode_in_range(s.sin, -1.0f, 1.0f) && lode_in_range(s.cos, -1.0f, 1.0f));
        check_angle(lode_wrap(x));
        check_angle(lode_atan2(y, x));
        FUZZ_CHECK(lode_in_range(lode_one_minus_exp(x), 0.0f, 1.0f));
        FUZZ_CHECK(lode_in_range(lode_clamp(x, -2.0f, 3.0f), -2.0f, 3.0f));
        FUZZ_CHECK(!(lode_sqrt(x) < 0.0f) && !isnan(lode_sqrt(x)));
        float value = 1.0f;
        float rest = 0.0f;
        FUZZ_CHECK(lode_in_range(lode_ramp(&value, &rest, x, 0.5f), -0.5f, 0.5f));
        FUZZ_CHECK(lode_in_range(value, 0.4999999f, 1.5000001f)); // the way is rounded
        const lode_sogi_tuning_t tuning = lode_sogi_tune(x, y);
        const float bounded = lode_clamp(fuzz_float(&in), -1.0e12f, 1.0e12f); // as it asks for
        const lode_sogi_out_t out = lode_sogi_step(&sogi, &tuning, bounded);
        FUZZ_CHECK(lode_is_finite(out.notch) && lode_is_finite(out.in_phase) &&
                   lode_is_finite(out.quadrature));
    }
    return 0;
}
