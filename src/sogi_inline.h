// The second-order generalised integrator, one sample.
#ifndef LODE_SOGI_INLINE_H
#define LODE_SOGI_INLINE_H

#include "lodestar/sogi.h"
#include "scalar_inline.h"

// lode_sogi_tune() for a `width` of 0 .. 2 and a `centre` of 0 .. LODE_SOGI_CENTRE_MAX_rad.
LODE_INLINE lode_sogi_tuning_t lode_sogi_tune_within(float width, float centre) {
    const lode_sincos_t quarter = lode_sincos_octant(0.25f * centre);
    const lode_sincos_t half = lode_angle_add(quarter, quarter);
    const float g = half.sin / half.cos;
    return (lode_sogi_tuning_t){width, g, 1.0f / (1.0f + g * (width + g))};
}

// Finite for every input within +-1e12 rad, V or A.
LODE_INLINE lode_sogi_out_t lode_sogi_step(lode_sogi_t *self, const lode_sogi_tuning_t *tuning,
                                           float x) {
    // Trapezoidal solution (B7) of: band' = wn (x - k band - low), low' = wn band.
    const float g = tuning->g;
    const float high = (x - (tuning->width + g) * self->band - self->low) * tuning->inv_sum;
    const float rise = g * high;
    const float band = self->band + rise;
    const float climb = g * band;
    const float low = self->low + climb;
    self->band = band + rise;
    self->low = low + climb;
    const float in_phase = tuning->width * band;
    return (lode_sogi_out_t){x - in_phase, in_phase, tuning->width * low};
}

#endif
