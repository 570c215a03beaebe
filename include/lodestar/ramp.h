/// A range of values, and a weight that fades between two values.
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

/// Weight 1 below `low`, 0 above `high` (low < high), and linear in between.
typedef struct {
    float high;
    float slope; ///< 1 / (high - low)
} lode_fade_t;

#ifdef __cplusplus
}
#endif

#endif
