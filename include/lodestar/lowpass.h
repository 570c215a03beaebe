/// First-order low-pass, exact for an input held over the period.
#ifndef LODESTAR_LOWPASS_H
#define LODESTAR_LOWPASS_H

#include "lodestar/scalar.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Weight of a new sample: 1 - exp(-ts/tau); 1 (no filter) for tau = 0.
float lode_lowpass_weight(float tau_s, float ts_s);

static inline float lode_lowpass(float value, float weight, float x) {
    return value + weight * (x - value);
}

#ifdef __cplusplus
}
#endif

#endif
