/// Space-vector modulation with a min-max zero sequence and dead-time correction in the duties.
#ifndef LODESTAR_MODULATOR_H
#define LODESTAR_MODULATOR_H

#include "lodestar/inverter.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Result for one period.
typedef struct {
    lode_abc_t duty;    ///< on-time of the high sides as a share of the period, in [0, 1]
    lode_ab_t realised; ///< expected voltage at the motor per bus volt
} lode_modulator_out_t;

#ifdef __cplusplus
}
#endif

#endif
