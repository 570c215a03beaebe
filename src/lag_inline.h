// The observer's lag at a speed.
#ifndef LODE_LAG_INLINE_H
#define LODE_LAG_INLINE_H

#include "lodestar/lag.h"
#include "scalar_inline.h"

// Lag in radians, an odd function. Beyond the fitted range lag over speed stays constant.
LODE_INLINE float lode_lag_rad(const lode_lag_t *lag, float omega_rad_s) {
    const float v = lode_min(omega_rad_s * omega_rad_s * lag->inv_range2, 1.0f);
    const float *c = lag->coefficient;
    const float slope = c[0] + v * (c[1] + v * (c[2] + v * (c[3] + v * (c[4] + v * c[5]))));
    return omega_rad_s * slope;
}

// Tangent to the lag at a speed: the polynomial and its slope in one Horner scheme.
LODE_SHARED lode_lag_line_t lode_lag_line(const lode_lag_t *lag, float omega_rad_s) {
    const float v = omega_rad_s * omega_rad_s * lag->inv_range2;
    const float in = lode_min(v, 1.0f);
    const float *c = lag->coefficient;
    const float b4 = c[4] + in * c[5];
    const float b3 = c[3] + in * b4;
    const float b2 = c[2] + in * b3;
    const float b1 = c[1] + in * b2;
    const float share = c[0] + in * b1;
    const float rise = b1 + in * (b2 + in * (b3 + in * (b4 + in * c[5])));
    const float twice = v < 1.0f ? 2.0f * v : 0.0f;
    // Within the octant up to a lag of 90 degrees, which no observer reaches below omega_max.
    const lode_sincos_t at = lode_angle_double(lode_sincos_octant(0.5f * omega_rad_s * share));
    return (lode_lag_line_t){at, omega_rad_s, share + twice * rise};
}

// Sine and cosine of the lag at a speed nearby, by the tangent. The angle is off by 4e-5 rad for paper 1's motor and a change
// of 16 rad/s, the length by d^2/2 for a change of the lag by d. Without the slope, a lag up to eight periods old doubled the
// error of a drone motor in a load step.
LODE_INLINE lode_sincos_t lode_lag_near(const lode_lag_line_t *line, float omega_rad_s) {
    return lode_angle_rotate_small(line->at, line->slope_s * (omega_rad_s - line->omega_rad_s));
}

// Change of the lag at which the length would be off by more than 0.8 %.
#define LAG_MOVE_MAX_rad 0.125f

LODE_INLINE bool lode_lag_is_far(const lode_lag_line_t *line, float omega_rad_s) {
    return !(lode_abs(line->slope_s * (omega_rad_s - line->omega_rad_s)) <= LAG_MOVE_MAX_rad);
}

#endif
