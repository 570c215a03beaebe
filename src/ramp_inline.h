// Ramps and fades.
#ifndef LODE_RAMP_INLINE_H
#define LODE_RAMP_INLINE_H

#include "lodestar/ramp.h"
#include "scalar_inline.h"

// Moves `value` by `step`; with all of the `way`, to the `target`. `rest`: what rounding leaves out of the sum (K35).
LODE_INLINE void lode_ramp_move(float *value, float *rest, float target, float way, float step) {
    if (lode_in_range(step, way, way)) {
        *value = target;
        *rest = 0.0f;
        return;
    }
    lode_add_small(value, rest, step);
}

// Moves `value` towards `target`, by at most `most` >= 0. Returns by how much. With a target that is not finite it stays.
LODE_INLINE float lode_ramp(float *value, float *rest, float target, float most) {
    if (!lode_is_finite(target)) {
        return 0.0f;
    }
    const float way = target - *value - *rest;
    const float step = lode_clamp(way, -most, most);
    lode_ramp_move(value, rest, target, way, step);
    return step;
}

static inline float lode_fade(const lode_fade_t *fade, float x) {
    return lode_clamp((fade->high - x) * fade->slope, 0.0f, 1.0f);
}

#endif
