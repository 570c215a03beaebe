/// PI controller with known feed-forward and anti-windup on the output that was realised.
#ifndef LODESTAR_PI_H
#define LODESTAR_PI_H

#include "lodestar/scalar.h"

typedef struct {
    float kp;    ///< output per error
    float ki_Ts; ///< output per error and period: ki Ts
} lode_pi_tuning_t;

typedef struct {
    float integral; ///< in units of the output
} lode_pi_t;

static inline void lode_pi_reset(lode_pi_t *self, float integral) {
    self->integral = integral;
}

/// What the controller asks for, before any limit.
static inline float lode_pi_output(const lode_pi_t *self, const lode_pi_tuning_t *tuning,
                                   float error, float feed_forward) {
    return tuning->kp * error + self->integral + feed_forward;
}

/// Tells the controller which part of its `output` became real. Not limited, it integrates the
/// error; limited, the integral follows what proportional part and feed-forward leave.
static inline void lode_pi_settle(lode_pi_t *self, const lode_pi_tuning_t *tuning, float error,
                                  float output, float realised) {
    self->integral += tuning->ki_Ts * error + (realised - output);
}

#endif
