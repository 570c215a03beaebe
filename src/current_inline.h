// Current control of one period.
#ifndef LODE_CURRENT_INLINE_H
#define LODE_CURRENT_INLINE_H

#include "lodestar/current.h"
#include "pi_inline.h"

typedef struct {
    lode_dq_t u_V;
    bool free; // no duty can reach a rail
} lode_current_out_t;

// A period whose voltage may be at the edge of the circle or beyond. One struct: passed one by one, its parts would take 24
// bytes more of the step's stack.
typedef struct {
    lode_dq_t error_A;
    lode_dq_t induced_V;
    float radius_V;
} lode_current_case_t;

// Called by lode_current_step() only.
lode_dq_t lode_current_limit(lode_current_t *self, const lode_current_tuning_t *tuning,
                             const lode_current_case_t *at);

// Takes the q axis' gain from the tuning and its inductance from the motor.
LODE_INLINE void lode_current_renew(lode_current_t *self, const lode_current_tuning_t *tuning,
                                    float Lq_H) {
    self->kp_q_V_A = tuning->q.kp;
    self->Lq_H = Lq_H;
}

LODE_INLINE bool lode_current_is_free(const lode_current_tuning_t *tuning, lode_dq_t u_V,
                                      float v_bus_V) {
    const float radius = tuning->free * v_bus_V;
    return u_V.d * u_V.d + u_V.q * u_V.q <= radius * lode_abs(radius);
}

// Voltage for the references `ref_A` at the currents `i_A`. `ff`: voltage induced by rotation (references_inline.h), zero in a
// frame that is not the rotor's. The integrators follow the voltage inside the circle: what the modulator clamps beyond that is
// only part of the dead-time correction.
LODE_INLINE lode_current_out_t lode_current_step(lode_current_t *self,
                                                 const lode_current_tuning_t *tuning,
                                                 lode_dq_t ref_A, lode_dq_t i_A, lode_dq_t ff,
                                                 float v_bus_V) {
    const lode_dq_t error = {ref_A.d - i_A.d, ref_A.q - i_A.q};
    const lode_pi_tuning_t q = {self->kp_q_V_A, tuning->q.ki_Ts};
    const lode_dq_t unlimited = {lode_pi_output(&self->d, &tuning->d, error.d, ff.d),
                                 lode_pi_output(&self->q, &q, error.q, ff.q)};
    if (lode_current_is_free(tuning, unlimited, v_bus_V)) {
        lode_pi_integrate(&self->d, &tuning->d, error.d);
        lode_pi_integrate(&self->q, &tuning->q, error.q);
        return (lode_current_out_t){unlimited, true};
    }
    const lode_current_case_t edge = {error, ff, tuning->circle * v_bus_V};
    const lode_dq_t u_V =
        lode_current_limit(self, tuning, &edge); // copied, as in estimator_inline.h
    return (lode_current_out_t){{u_V.d, u_V.q}, false};
}

#endif
