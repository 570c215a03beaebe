/// Back-EMF observers: linear extended state observers on the stator current, in exact discrete form.
///
/// Over one period the R-Lq circuit is solved exactly, which gives the dead-beat EMF m[k]; every
/// observer of both papers is a linear filter of it (docs/theory/emf.md).
#ifndef LODESTAR_EMF_H
#define LODESTAR_EMF_H

#include "lodestar/leso.h"
#include "lodestar/motor.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef lode_leso_config_t lode_emf_config_t;

typedef struct {
    float inv_b;       ///< 1/b, V/A: b is the current that one volt makes in one period
    float a_over_b;    ///< V/A: a is what a period leaves of a current; (1 - a)/b is R
    float salient_Ohm; ///< (Ld - Lq)/Ts
    bool salient;      ///< false leaves the EMF of a changing active flux in the estimate
    lode_leso_tuning_t leso;
} lode_emf_tuning_t;

typedef struct {
    lode_ab_t i_A; ///< current at t_k-1
    lode_leso_t leso;
} lode_emf_t;

/// Fills every zero field that has a default.
void lode_emf_design(lode_emf_config_t *config, const lode_motor_t *motor, float sigma_rad_s,
                     float ts_s);

lode_status_t lode_emf_tune(lode_emf_tuning_t *tuning, const lode_emf_config_t *config,
                            const lode_motor_t *motor, bool active_flux, float ts_s);

/// Starts from the current `i_A` at t_k with no EMF.
void lode_emf_reset(lode_emf_t *self, lode_ab_t i_A);

/// Dead-beat EMF (E3) of a period: u[k-1] - (i[k] - a i[k-1])/b. `u_V`: mean voltage over
/// [t_k-1, t_k); `i_A`: current at t_k. The EMF of a changing active flux is still in it.
LODE_INLINE lode_ab_t lode_emf_dead_beat(lode_emf_t *self, const lode_emf_tuning_t *tuning,
                                         lode_ab_t u_V, lode_ab_t i_A) {
    lode_ab_t m = lode_ab_add_scaled(u_V, tuning->a_over_b, self->i_A);
    m = lode_ab_add_scaled(m, -tuning->inv_b, i_A);
    self->i_A = i_A;
    return m;
}

/// `m_V` without (Ld - Lq) did/dt on the d axis (E5), at the angle half a period back: the mean over it.
/// `rotor`: predicted rotor angle at t_k; `half_turn`: angle of half a period; `id_before_A`: d-axis
/// current at t_k-1. Where the angle can be trusted.
LODE_INLINE lode_ab_t lode_emf_less_salient(const lode_emf_tuning_t *tuning, lode_ab_t m_V,
                                            lode_ab_t i_A, lode_sincos_t rotor,
                                            lode_sincos_t half_turn, float id_before_A) {
    const lode_sincos_t middle = lode_angle_subtract(rotor, half_turn);
    const float rise_d = lode_park(i_A, rotor).d - id_before_A;
    return lode_ab_add_scaled(m_V, -tuning->salient_Ohm * rise_d,
                              (lode_ab_t){middle.cos, middle.sin});
}

/// What the observer is told about the rotor.
typedef struct {
    lode_sincos_t rotor;     ///< predicted rotor angle at t_k
    lode_sincos_t half_turn; ///< angle of half a period, w Ts/2
    lode_sincos_t turn; ///< angle of a period at the speed to which adaptive observers are tuned
    float omega_rad_s;  ///< that speed
    float id_before_A;  ///< d-axis current at t_k-1
    bool known;         ///< the angle can be trusted with the EMF of the active flux
} lode_emf_motion_t;

/// One whole period. Returns the estimated EMF at t_k, V: it lags the true one by the lag of
/// `lode_lag_t`.
static inline lode_ab_t lode_emf_step(lode_emf_t *self, const lode_emf_tuning_t *tuning,
                                      lode_ab_t u_V, lode_ab_t i_A,
                                      const lode_emf_motion_t *motion) {
    lode_ab_t m = lode_emf_dead_beat(self, tuning, u_V, i_A);
    if (tuning->salient && motion->known) {
        m = lode_emf_less_salient(tuning, m, i_A, motion->rotor, motion->half_turn,
                                  motion->id_before_A);
    }
    return lode_leso_step(&self->leso, &tuning->leso, m, motion->turn, motion->omega_rad_s);
}

/// Exact phase of the estimate behind the true EMF at t_k in steady rotation, rad, odd in omega.
/// For init and host: it costs three arc tangents.
float lode_emf_lag_rad(const lode_emf_config_t *config, const lode_motor_t *motor, float ts_s,
                       float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
