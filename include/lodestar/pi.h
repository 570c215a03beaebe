/// PI controller with feed-forward, and anti-windup by the output that was realised.
#ifndef LODESTAR_PI_H
#define LODESTAR_PI_H

#include "lodestar/scalar.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float kp;    ///< output per error
    float ki_Ts; ///< ki Ts: output per error and period
} lode_pi_tuning_t;

typedef struct {
    float integral; ///< in units of the output
} lode_pi_t;

#ifdef __cplusplus
}
#endif

#endif
