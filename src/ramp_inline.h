// Ramps and fades.
#ifndef LODE_RAMP_INLINE_H
#define LODE_RAMP_INLINE_H

#include "lodestar/ramp.h"
#include "scalar_inline.h"

// Moves `value` towards `target`, by at most `most` >= 0. Returns by how much. With a target that is not finite it stays.
// `rest`: what rounding leaves out of the sum (K35).
LODE_INLINE float lode_ramp(float *value, float *rest, float target, float most) {
    if (!lode_is_finite(target)) {
        return 0.0f;
    }
    const float way = target - *value - *rest;
    if (lode_abs(way) <= most) {
        *value = target;
        *rest = 0.0f;
        return way;
    }
    const float step = way < 0.0f ? -most : most;
    lode_add_small(value, rest, step);
    return step;
}

static inline float lode_fade(const lode_fade_t *fade, float x) {
    return lode_clamp((fade->high - x) * fade->slope, 0.0f, 1.0f);
}

#endif
