// Ramps and fades.
#ifndef LODE_RAMP_INLINE_H
#define LODE_RAMP_INLINE_H

#include "lodestar/ramp.h"

// The next value on the way from `value` to `target`, at most `step` >= 0 away. For a NaN target
// the value stays.
static inline float lode_ramp(float value, float target, float step) {
    if (!lode_is_finite(target)) {
        return value;
    }
    return value + lode_clamp(target - value, -step, step);
}

static inline float lode_fade(const lode_fade_t *fade, float x) {
    return lode_clamp((fade->high - x) * fade->slope, 0.0f, 1.0f);
}

#endif
