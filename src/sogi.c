#include "lodestar/sogi.h"

void lode_sogi_reset(lode_sogi_t *self) {
    *self = (lode_sogi_t){0.0f, 0.0f};
}

// Beyond any signal: its resonance, at most 1/k, stays finite.
#define INPUT_LIMIT 1.0e12f

LODE_HOT lode_sogi_out_t lode_sogi_step(lode_sogi_t *self, float k, float wn_Ts, float x) {
    const float width = lode_clamp(k, 0.001f, 2.0f);
    const float centre = lode_clamp(wn_Ts, LODE_SOGI_CENTRE_MIN_rad, LODE_SOGI_CENTRE_MAX_rad);
    const lode_sincos_t half = lode_sincos(0.5f * centre);
    const float g = half.sin / half.cos; // the prewarped integrator gain, tan(wn Ts/2)
    // Trapezoidal solution (B7) of: band' = wn (x - k band - low), low' = wn band.
    const float high = (x - (width + g) * self->band - self->low) / (1.0f + g * (width + g));
    const float band = self->band + g * high;
    const float low = self->low + g * band;
    if (!lode_in_range(x, -INPUT_LIMIT, INPUT_LIMIT) || !lode_is_finite(low)) {
        lode_sogi_reset(self);
        return (lode_sogi_out_t){0.0f, 0.0f, 0.0f};
    }
    self->band = band + g * high;
    self->low = low + g * band;
    return (lode_sogi_out_t){x - width * band, width * band, width * low};
}
