/// Space-vector modulation by the min-max zero sequence, with dead-time correction in the duties.
#ifndef LODESTAR_MODULATOR_H
#define LODESTAR_MODULATOR_H

#include "lodestar/inverter.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lode_abc_t duty;    ///< on-time of the high sides as a share of the period, in [0, 1]
    lode_ab_t realised; ///< voltage per bus volt that the motor is expected to see of it
} lode_modulator_out_t;

#ifdef __cplusplus
}
#endif

#endif
