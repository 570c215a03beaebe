/// A value that moves to its target at a bounded rate.
#ifndef LODESTAR_RAMP_H
#define LODESTAR_RAMP_H

#include "lodestar/scalar.h"

#ifdef __cplusplus
extern "C" {
#endif

/// From `min` to `max`.
typedef struct {
    float min;
    float max;
} lode_range_t;

/// The next value on the way from `value` to `target`, at most `step` >= 0 away. For a NaN target
/// the value stays.
static inline float lode_ramp(float value, float target, float step) {
    if (!lode_is_finite(target)) {
        return value;
    }
    return value + lode_clamp(target - value, -step, step);
}

/// The weight of a fade from 1 below `low` to 0 above `high` (low < high), linear between them.
typedef struct {
    float high;
    float slope; ///< 1 / (high - low)
} lode_fade_t;

static inline float lode_fade(const lode_fade_t *fade, float x) {
    return lode_clamp((fade->high - x) * fade->slope, 0.0f, 1.0f);
}

#ifdef __cplusplus
}
#endif

#endif
