/// Space-vector modulation of two three-phase sets, with dead-time correction in all six legs.
#ifndef LODESTAR_MODULATOR6_H
#define LODESTAR_MODULATOR6_H

#include "lodestar/modulator.h"
#include "lodestar/vsd.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Result for one period.
typedef struct {
    lode_abc6_t duty;     ///< on-time of the high sides as a share of the period, in [0, 1]
    lode_sets_t realised; ///< expected voltage at each set per bus volt, stator axes
} lode_modulator6_out_t;

#ifdef __cplusplus
}
#endif

#endif
