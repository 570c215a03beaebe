/// Phase-locked loops that are observers of the rotor's motion, with gains placed in the z-plane.
///
/// One recursion serves both orders: the QPLL (paper 1, eqs. 13-15) has no disturbance state, the
/// LESO-QPLL (paper 1, eqs. 18-20) has one and is fed with the torque of the measured current.
#ifndef LODESTAR_PLL_H
#define LODESTAR_PLL_H

#include "lodestar/config.h"
#include "lodestar/motor.h"
#include "lodestar/status.h"

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
    float theta_rad;   ///< angle of the EMF that it follows, less a quarter turn, at t_k
    float omega_rad_s; ///< electrical speed at t_k
    float f_rad_s2;    ///< disturbance: -np T_load/J plus whatever the model lacks
    float acc_rad_s2;  ///< known acceleration over the period under way: torque and friction
} lode_pll_t;

/// Fills every zero field that has a default.
void lode_pll_design(lode_pll_config_t *config, float omega_rated_rad_s);

lode_status_t lode_pll_tune(lode_pll_tuning_t *tuning, const lode_pll_config_t *config, float ts_s);

/// Takes up the motion given, with no disturbance.
void lode_pll_reset(lode_pll_t *self, float theta_rad, float omega_rad_s);

/// Moves the state from t_k-1 to t_k (paper 1, eq. 19; P2), exact for constant acceleration.
static inline void lode_pll_predict(lode_pll_t *self, const lode_pll_tuning_t *tuning) {
    const float step = tuning->ts_s * (self->f_rad_s2 + self->acc_rad_s2);
    self->theta_rad =
        lode_wrap_once(self->theta_rad + tuning->ts_s * (self->omega_rad_s + 0.5f * step));
    self->omega_rad_s += step;
}

/// Corrects the state by the position error `error_rad` found at t_k. It may come from the EMF, from
/// signal injection, or from a weighted sum of both (P4, P6).
static inline void lode_pll_correct(lode_pll_t *self, const lode_pll_tuning_t *tuning,
                                    float error_rad) {
    const float up = (lode_abs(self->omega_rad_s) - tuning->omega_low) * tuning->inv_span;
    const float x = tuning->x_low + tuning->x_rise * lode_clamp(up, 0.0f, 1.0f);
    if (tuning->third_order) {
        const float rate = x * x * error_rad * tuning->inv_ts;
        self->theta_rad = lode_wrap_once(self->theta_rad + x * (3.0f - x * (3.0f - x)) * error_rad);
        self->omega_rad_s += 1.5f * (2.0f - x) * rate;
        self->f_rad_s2 += x * rate * tuning->inv_ts;
    } else {
        self->theta_rad = lode_wrap_once(self->theta_rad + x * (2.0f - x) * error_rad);
        self->omega_rad_s += x * x * error_rad * tuning->inv_ts;
        self->f_rad_s2 = 0.0f; // no state of this order, whatever stood there
    }
}

#endif
