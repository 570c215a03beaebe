// The PI controller's two halves: what it asks for, and what it makes of what became real.
#ifndef LODE_PI_INLINE_H
#define LODE_PI_INLINE_H

#include "lodestar/pi.h"

static inline void lode_pi_reset(lode_pi_t *self, float integral) {
    self->integral = integral;
}

// What the controller asks for, before any limit.
LODE_INLINE float lode_pi_output(const lode_pi_t *self, const lode_pi_tuning_t *tuning, float error,
                                 float feed_forward) {
    return tuning->kp * error + self->integral + feed_forward;
}

// Integrates the error: for an output that became real in full, inside finite limits.
LODE_INLINE void lode_pi_integrate(lode_pi_t *self, const lode_pi_tuning_t *tuning, float error) {
    self->integral += tuning->ki_Ts * error;
}

// Tells the controller which part of its `output` became real. Inside the limits it integrates the
// error. At a limit the integral moves inwards only, and at least as far as the feed-forward leaves
// room: it does not wind up, and an error of the other sign, or none, takes effect at once.
LODE_SHARED void lode_pi_settle(lode_pi_t *self, const lode_pi_tuning_t *tuning, float error,
                                float feed_forward, float output, float realised) {
    const float next = self->integral + tuning->ki_Ts * error;
    const float headroom = realised - feed_forward;
    const float below = lode_min(lode_min(next, self->integral), headroom);
    const float above = lode_max(lode_max(next, self->integral), headroom);
    const float held = output > realised ? below : (output < realised ? above : next);
    self->integral = lode_is_finite(held) ? held : self->integral;
}

#endif
