/// Back-EMF observers: linear extended state observers on the stator current, in exact discrete form.
///
/// Over one period the R-Lq circuit is solved exactly, which gives the dead-beat EMF m[k]; every
/// observer of both papers is a linear filter of it (docs/theory/emf.md).
#ifndef LODESTAR_EMF_H
#define LODESTAR_EMF_H

#include "lodestar/motor.h"
#include "lodestar/observer.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef lode_observer_config_t lode_emf_config_t;

typedef struct {
    float inv_b;       ///< 1/b, V/A: b is the current that one volt makes in one period
    float a_over_b;    ///< V/A: a is what a period leaves of a current; (1 - a)/b is R
    float salient_Ohm; ///< (Ld - Lq)/Ts; 0 leaves the EMF of a changing active flux in the estimate
    lode_observer_tuning_t observer;
} lode_emf_tuning_t;

typedef struct {
    lode_ab_t i_A; ///< current at t_k, of the last step
    lode_observer_t observer;
} lode_emf_t;

/// Fills every zero field that has a default.
void lode_emf_design(lode_emf_config_t *config, const lode_motor_t *motor, float sigma_rad_s,
                     float ts_s);

lode_status_t lode_emf_tune(lode_emf_tuning_t *tuning, const lode_emf_config_t *config,
                            const lode_motor_t *motor, bool active_flux, float ts_s);

/// Starts from the current `i_A` at t_k with no EMF.
void lode_emf_reset(lode_emf_t *self, lode_ab_t i_A);

/// Exact phase lag of the estimate against the true EMF at t_k in steady rotation, rad, odd in omega.
/// For init and host: it costs three arc tangents.
float lode_emf_lag_rad(const lode_emf_config_t *config, const lode_motor_t *motor, float ts_s,
                       float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
