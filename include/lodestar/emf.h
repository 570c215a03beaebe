/// Back-EMF observers: linear extended state observers on the stator current, with exact discretisation.
///
/// The R-Lq circuit is solved exactly over one period, which gives the dead-beat EMF m[k]. Every observer of both
/// papers is a linear filter of m (docs/theory/emf.md).
#ifndef LODESTAR_EMF_H
#define LODESTAR_EMF_H

#include "lodestar/motor.h"
#include "lodestar/observer.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef lode_observer_config_t lode_emf_config_t;

/// All that is derived from the configuration.
typedef struct {
    float inv_b;    ///< 1/b, V/A; b: current that one volt drives in one period
    float a_over_b; ///< V/A; a: share of a current that is left after one period; (1 - a)/b is R
    /// (Ld - Lq)/Ts; 0: the EMF of a changing active flux remains in the estimate
    float salient_Ohm;
    lode_observer_tuning_t observer;
} lode_emf_tuning_t;

/// State of the observer.
typedef struct {
    lode_ab_t i_A; ///< current at t_k in the last step
    lode_observer_t observer;
} lode_emf_t;

/// Fills every zero field that has a default.
void lode_emf_design(lode_emf_config_t *config, const lode_motor_t *motor, float sigma_rad_s,
                     float ts_s);

/// Checks a completed configuration and derives the tuning. `notch_rad_s`: as for lode_observer_tune(). `active_flux`:
/// compensate the EMF of a changing active flux.
lode_status_t lode_emf_tune(lode_emf_tuning_t *tuning, const lode_emf_config_t *config,
                            const lode_motor_t *motor, float notch_rad_s, bool active_flux,
                            float ts_s);

/// Starts from the current `i_A` at t_k and no EMF.
void lode_emf_reset(lode_emf_t *self, lode_ab_t i_A);

/// Exact phase lag of the estimate against the true EMF at t_k in steady rotation, rad; odd in omega. For init and
/// host: it takes three arc tangents.
float lode_emf_lag_rad(const lode_emf_config_t *config, const lode_motor_t *motor, float ts_s,
                       float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
