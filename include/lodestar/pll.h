/// Phase-locked loops that are observers of the rotor's motion, with gains placed in the z-plane.
///
/// One recursion serves both orders: the QPLL (paper 1, eqs. 13-15) has no disturbance state, the
/// LESO-QPLL (paper 1, eqs. 18-20) has one and is fed with the torque of the measured current.
#ifndef LODESTAR_PLL_H
#define LODESTAR_PLL_H

#include "lodestar/config.h"
#include "lodestar/motor.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LODE_PLL_LESO, ///< third order, disturbance state and torque feed-forward
    LODE_PLL_QPLL  ///< second order
} lode_pll_kind_t;

typedef struct {
    lode_pll_kind_t kind;
    /// triple (double) pole at and above omega_high; 0: scheduled, 0.21 of rated speed
    float sigma_rad_s;
    float sigma_low_rad_s; ///< the same at and below omega_low; 0: as sigma_rad_s if that is given,
                           ///< else 0.11 of rated speed
    float omega_low_rad_s; ///< 0: 0.1 of rated speed
    float omega_high_rad_s; ///< 0: 0.2 of rated speed
} lode_pll_config_t;

typedef struct {
    float ts_s;
    float inv_ts;
    float x_low;  ///< 1 - exp(-sigma Ts) at low speed
    float x_rise; ///< its increase up to omega_high
    float omega_low;
    float inv_span; ///< 1/(omega_high - omega_low)
    bool third_order;
} lode_pll_tuning_t;

typedef struct {
    lode_sincos_t frame; ///< angle of the EMF that it follows, less a quarter turn, at t_k
    float omega_rad_s;   ///< electrical speed at t_k
    float f_rad_s2;      ///< disturbance: -np T_load/J plus whatever the model lacks
    float acc_rad_s2;    ///< known acceleration over the period under way: torque and friction
} lode_pll_t;

/// Fills every zero field that has a default.
void lode_pll_design(lode_pll_config_t *config, float omega_rated_rad_s);

lode_status_t lode_pll_tune(lode_pll_tuning_t *tuning, const lode_pll_config_t *config, float ts_s);

/// Takes up the motion given, with no disturbance.
void lode_pll_reset(lode_pll_t *self, float theta_rad, float omega_rad_s);

/// Gains of one period (P5): what an error moves angle, speed and disturbance by.
typedef struct {
    float theta;   ///< rad per rad
    float omega_s; ///< rad/s per rad
    float f_s2;    ///< rad/s^2 per rad; 0 for the QPLL
} lode_pll_gains_t;

/// Those of the bandwidth that belongs to the speed. It moves slowly: every few periods is enough.
static inline lode_pll_gains_t lode_pll_gains(const lode_pll_tuning_t *tuning, float omega_rad_s) {
    const float up = (lode_abs(omega_rad_s) - tuning->omega_low) * tuning->inv_span;
    const float x = tuning->x_low + tuning->x_rise * lode_clamp(up, 0.0f, 1.0f);
    const float rate = x * x * tuning->inv_ts;
    if (tuning->third_order) {
        return (lode_pll_gains_t){x * (3.0f - x * (3.0f - x)), 1.5f * (2.0f - x) * rate,
                                  x * rate * tuning->inv_ts};
    }
    return (lode_pll_gains_t){x * (2.0f - x), rate, 0.0f};
}

/// The angle by which the rotor moves on from t_k-1 to t_k, and the speed that it has there (paper 1,
/// eq. 19; P2), exact for constant acceleration. The state is not moved yet.
LODE_INLINE float lode_pll_advance_rad(const lode_pll_t *self, const lode_pll_tuning_t *tuning,
                                       float *omega_rad_s) {
    const float step = tuning->ts_s * (self->f_rad_s2 + self->acc_rad_s2);
    *omega_rad_s = self->omega_rad_s + step;
    return tuning->ts_s * (self->omega_rad_s + 0.5f * step);
}

/// Moves angle and speed to t_k, to the predicted `frame` and speed, and corrects them by the position
/// error `error_rad` found there. It may come from the EMF, from signal injection, or from a weighted sum of
/// both (P4, P6).
LODE_INLINE void lode_pll_move(lode_pll_t *self, lode_pll_gains_t gains, lode_sincos_t frame,
                               float omega_rad_s, float error_rad) {
    self->frame = lode_angle_nudged(frame, gains.theta * error_rad);
    self->omega_rad_s = omega_rad_s + gains.omega_s * error_rad;
}

/// Corrects the disturbance: third order only.
LODE_INLINE void lode_pll_disturb(lode_pll_t *self, lode_pll_gains_t gains, float error_rad) {
    self->f_rad_s2 += gains.f_s2 * error_rad;
}

#ifdef __cplusplus
}
#endif

#endif
