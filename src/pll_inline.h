// One period of the phase-locked loop.
#ifndef LODE_PLL_INLINE_H
#define LODE_PLL_INLINE_H

#include "lodestar/pll.h"

// Gains (P5) for a bandwidth, `x` = 1 - exp(-sigma Ts).
LODE_INLINE lode_pll_gains_t lode_pll_gains_of(const lode_pll_tuning_t *tuning, float x) {
    const float rate = x * x * tuning->inv_ts;
    if (tuning->third_order != 0u) {
        return (lode_pll_gains_t){x * (3.0f - x * (3.0f - x)), 1.5f * (2.0f - x) * rate,
                                  x * rate * tuning->inv_ts};
    }
    return (lode_pll_gains_t){x * (2.0f - x), rate, 0.0f};
}

// `x` of the bandwidth at this speed (P11).
LODE_INLINE float lode_pll_x(const lode_pll_tuning_t *tuning, float omega_rad_s) {
    const float up = (lode_abs(omega_rad_s) - tuning->omega_low) * tuning->inv_span;
    return tuning->x_low + tuning->x_rise * lode_clamp(up, 0.0f, 1.0f);
}

// Gains for the bandwidth at this speed. It changes slowly: every few periods is enough.
LODE_SHARED lode_pll_gains_t lode_pll_gains(const lode_pll_tuning_t *tuning, float omega_rad_s) {
    return lode_pll_gains_of(tuning, lode_pll_x(tuning, omega_rad_s));
}

// The motion from t_k-1 to t_k.
typedef struct {
    float angle_rad;   // angle that the rotor moves by
    float omega_rad_s; // speed at t_k
} lode_pll_motion_t;

// Prediction (paper 1, eq. 19; P2), exact for constant acceleration. Does not change the state.
LODE_INLINE lode_pll_motion_t lode_pll_predict(const lode_pll_t *self,
                                               const lode_pll_tuning_t *tuning) {
    return (lode_pll_motion_t){tuning->ts_s * (self->omega_rad_s + 0.5f * self->rise_rad_s),
                               self->omega_rad_s + self->rise_rad_s};
}

// Moves angle and speed to t_k, to the predicted `frame` and speed, and corrects them by the position error `error_rad` found
// there, which may come from the EMF, from signal injection, or from a weighted sum of both (P4, P6).
LODE_INLINE void lode_pll_correct(lode_pll_t *self, lode_pll_gains_t gains, lode_sincos_t frame,
                                  float omega_rad_s, float error_rad) {
    self->frame = lode_angle_rotate_small(frame, gains.theta * error_rad);
    self->omega_rad_s = omega_rad_s + gains.omega_s * error_rad;
}

// Third order only: corrects the disturbance, and predicts the rise of the speed in the next period from it and from the known
// acceleration `acc_rad_s2` by torque and friction.
LODE_INLINE void lode_pll_correct_disturbance(lode_pll_t *self, const lode_pll_tuning_t *tuning,
                                              lode_pll_gains_t gains, float error_rad,
                                              float acc_rad_s2) {
    const float f = self->f_rad_s2 + gains.f_s2 * error_rad;
    self->f_rad_s2 = f;
    self->rise_rad_s = tuning->ts_s * (f + acc_rad_s2);
}

#endif
