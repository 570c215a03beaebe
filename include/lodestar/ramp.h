/// Ranges, and weights that fade between two values.
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

/// The weight of a fade from 1 below `low` to 0 above `high` (low < high), linear between them.
typedef struct {
    float high;
    float slope; ///< 1 / (high - low)
} lode_fade_t;

#ifdef __cplusplus
}
#endif

#endif
