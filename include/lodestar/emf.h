/// Back-EMF observers: linear extended state observers on the stator current, in exact discrete form.
///
/// Over one period the R-Lq circuit is solved exactly, which gives the dead-beat EMF m[k]; every
/// observer of both papers is a linear filter of it (docs/theory/emf.md).
#ifndef LODESTAR_EMF_H
#define LODESTAR_EMF_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/motor.h"
#include "lodestar/status.h"

/// Which filter. All share state and call; those to come take their place here.
typedef enum {
    LODE_EMF_C_LESO ///< conventional LESO (paper 1, eq. 11), current form
} lode_emf_kind_t;

typedef struct {
    lode_emf_kind_t kind;
    float
        w0_rad_s; ///< bandwidth, 1 .. 2/Ts (paper 1, eq. 6); 0: 4 times the rated speed, at most 0.5/Ts
} lode_emf_config_t;

typedef struct {
    float Rs_Ohm;
    float inv_b;       ///< 1/b, V/A: b is the current that one volt makes in one period
    float one_m_p;     ///< 1 - exp(-w0 Ts)
    float salient_Ohm; ///< (Ld - Lq)/Ts; 0 leaves the EMF of a changing active flux in the estimate
} lode_emf_tuning_t;

typedef struct {
    lode_ab_t i_A; ///< current at t_k-1
    lode_ab_t y_V; ///< first stage
    lode_ab_t e_V; ///< the estimate
} lode_emf_t;

/// Fills every zero field that has a default.
void lode_emf_design(lode_emf_config_t *config, const lode_motor_t *motor, float ts_s);

lode_status_t lode_emf_tune(lode_emf_tuning_t *tuning, const lode_emf_config_t *config,
                            const lode_motor_t *motor, bool active_flux, float ts_s);

/// Starts from the current `i_A` at t_k with no EMF.
void lode_emf_reset(lode_emf_t *self, lode_ab_t i_A);

/// One period. `u_V`: mean voltage over [t_k-1, t_k); `i_A`: current at t_k; `rotor`: the predicted
/// rotor angle at t_k; `half_turn`: the angle of half a period, w Ts/2; `rotor_known`: whether that
/// angle can be trusted with the EMF of the active flux.
/// Returns the estimated EMF at t_k, V: it lags the true one by the lag of `lode_lag_t`.
lode_ab_t lode_emf_step(lode_emf_t *self, const lode_emf_tuning_t *tuning, lode_ab_t u_V,
                        lode_ab_t i_A, lode_sincos_t rotor, lode_sincos_t half_turn,
                        bool rotor_known);

/// Exact phase of the estimate behind the true EMF at t_k in steady rotation, rad, odd in omega.
/// For init and host: it costs three arc tangents.
float lode_emf_lag_rad(const lode_emf_config_t *config, const lode_motor_t *motor, float ts_s,
                       float omega_rad_s);

#endif
