// The lag's part of the step.
#ifndef LODESTAR_LAG_INLINE_H
#define LODESTAR_LAG_INLINE_H

#include "lodestar/lag.h"

// Sine and cosine of the lag at a speed nearby. What the line leaves of the lag's curve: 4e-5 rad for
// paper 1's motor and a move of 16 rad/s; of the length d^2/2 for a move of the lag by d.
LODE_INLINE lode_sincos_t lode_lag_near(const lode_lag_line_t *line, float omega_rad_s) {
    const float move = line->slope_s * (omega_rad_s - line->omega_rad_s);
    return (lode_sincos_t){line->at.sin + line->at.cos * move, line->at.cos - line->at.sin * move};
}

// A line so far from its point that the length would be off by more than 0.8 %.
#define LODE_LAG_MOVE_MAX_rad 0.125f

LODE_INLINE bool lode_lag_is_far(const lode_lag_line_t *line, float omega_rad_s) {
    return !(lode_abs(line->slope_s * (omega_rad_s - line->omega_rad_s)) <= LODE_LAG_MOVE_MAX_rad);
}

#endif
