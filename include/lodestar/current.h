/// Current control in the rotor frame: PI, decoupling, EMF feed-forward, voltage circle.
#ifndef LODESTAR_CURRENT_H
#define LODESTAR_CURRENT_H

#include "lodestar/frames.h"
#include "lodestar/inverter.h"
#include "lodestar/motor.h"
#include "lodestar/pi.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float bandwidth_rad_s; ///< places kp = L bandwidth, ki = R bandwidth; 0: 0.2/Ts
    float kp_d_V_A;        ///< 0: from the bandwidth
    float kp_q_V_A;
    float ki_d_V_As;
    float ki_q_V_As;
    float voltage_use; ///< share of v_bus/sqrt(3) that may be used; 0: 0.95, the rest is for the
                       ///< dead-time correction
} lode_current_config_t;

typedef struct {
    lode_pi_tuning_t d;
    lode_pi_tuning_t q;
    float Ld_H;
    float Lq_H;
    float psi_Wb;
    float circle;  ///< radius of the voltage circle per bus volt
    float d_share; ///< of the circle that the d axis may take, so that q keeps headroom
} lode_current_tuning_t;

typedef struct {
    lode_pi_t d;
    lode_pi_t q;
} lode_current_t;

void lode_current_design(lode_current_config_t *config, const lode_motor_t *motor, float ts_s);

lode_status_t lode_current_tune(lode_current_tuning_t *tuning, const lode_current_config_t *config,
                                const lode_motor_t *motor, float ts_s);

/// Puts the integrators where the output is `u_V` without control error: for a bumpless start of
/// control, or a change of frame, at the currents `i_A` and the electrical speed `omega_rad_s`.
void lode_current_reset(lode_current_t *self, const lode_current_tuning_t *tuning, lode_dq_t u_V,
                        lode_dq_t i_A, float omega_rad_s);

/// What rotation induces: decoupling and EMF feed-forward.
LODE_INLINE lode_dq_t lode_current_induced_V(const lode_current_tuning_t *tuning, lode_dq_t i_A,
                                             float omega_rad_s) {
    return (lode_dq_t){-omega_rad_s * tuning->Lq_H * i_A.q,
                       omega_rad_s * (tuning->Ld_H * i_A.d + tuning->psi_Wb)};
}

/// Part of lode_current_step(), which alone calls it: the voltage `asked_V` lies at the edge of the
/// circle or beyond.
lode_dq_t lode_current_limit(lode_current_t *self, const lode_current_tuning_t *tuning,
                             lode_dq_t error_A, lode_dq_t induced_V, lode_dq_t asked_V,
                             float radius_V);

/// Voltage for the references `ref_A` at the currents `i_A`. `omega_rad_s`: electrical speed of the
/// rotor for decoupling and EMF feed-forward, 0 in a frame that is not the rotor's. Integrates on the
/// voltage inside the circle: what the modulator clamps beyond that is the dead-time correction's only.
LODE_INLINE lode_dq_t lode_current_step(lode_current_t *self, const lode_current_tuning_t *tuning,
                                        lode_dq_t ref_A, lode_dq_t i_A, float omega_rad_s,
                                        float v_bus_V) {
    const lode_dq_t ff = lode_current_induced_V(tuning, i_A, omega_rad_s);
    const lode_dq_t error = {ref_A.d - i_A.d, ref_A.q - i_A.q};
    const lode_dq_t asked = {lode_pi_output(&self->d, &tuning->d, error.d, ff.d),
                             lode_pi_output(&self->q, &tuning->q, error.q, ff.q)};
    // The circle (K5): radius per bus volt. What lies within the share of it that d may take needs no
    // further look.
    const float radius = tuning->circle * v_bus_V;
    const float near = tuning->d_share * radius;
    if (LODE_USUALLY(asked.d * asked.d + asked.q * asked.q <= near * near)) {
        lode_pi_integrate(&self->d, &tuning->d, error.d);
        lode_pi_integrate(&self->q, &tuning->q, error.q);
        return asked;
    }
    return lode_current_limit(self, tuning, error, ff, asked, radius);
}

#ifdef __cplusplus
}
#endif

#endif
