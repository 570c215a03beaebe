// One call of the current references: plain id* = 0 with its bias here, the rest out of line.
#ifndef LODE_REFERENCES_INLINE_H
#define LODE_REFERENCES_INLINE_H

#include "lodestar/references.h"
#include "ramp_inline.h"

// Part of lode_references_step(), which alone calls it: everything but plain id* = 0.
lode_references_out_t lode_references_optimal(lode_references_t *self,
                                              const lode_references_tuning_t *tuning,
                                              float torque_Nm, float omega_rad_s, float id_add_A,
                                              lode_references_voltage_t voltage);

#define ACTIVE_FLUX_MIN_SHARE 0.1f // of psi: least active flux that is divided by

// What rotation induces at the currents `i_A`: decoupling and EMF feed-forward of current control (K2).
LODE_INLINE lode_dq_t lode_references_induced_V(const lode_references_tuning_t *tuning,
                                                lode_dq_t i_A, float omega_rad_s) {
    return (lode_dq_t){-omega_rad_s * tuning->Lq_H * i_A.q,
                       omega_rad_s * (tuning->Ld_H * i_A.d + tuning->psi_Wb)};
}

// At no current.
LODE_INLINE float lode_references_salient_H(const lode_references_tuning_t *tuning) {
    return tuning->Ld_H - tuning->Lq_H;
}

// An id so positive that a salient rotor has no torque left is met at the current limit.
LODE_INLINE float lode_references_active_flux(const lode_references_tuning_t *tuning, float salient,
                                              float id_A) {
    return lode_max(tuning->psi_Wb + salient * id_A, ACTIVE_FLUX_MIN_SHARE * tuning->psi_Wb);
}

// Current references for `torque_Nm` at the electrical speed `omega_rad_s`; `id_add_A` is added to
// the d axis (the rest of the start current while it fades). Stays within the circle i_max, d first.
LODE_INLINE lode_references_out_t lode_references_step(lode_references_t *self,
                                                       const lode_references_tuning_t *tuning,
                                                       float torque_Nm, float omega_rad_s,
                                                       float id_add_A,
                                                       lode_references_voltage_t voltage) {
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (tuning->options != 0u) {
        return lode_references_optimal(self, tuning, torque_Nm, omega_rad_s, id_add_A, voltage);
    }
#endif
    (void)self;
    (void)voltage;
    const float i_max = tuning->i_max_A;
    const float bias = tuning->id_bias_A * lode_fade(&tuning->fade, lode_abs(omega_rad_s));
    const float id = lode_clamp(id_add_A - bias, -i_max, i_max);
    const float iq_max = lode_sqrt(i_max * i_max - id * id);
    const float per_iq = tuning->torque_factor *
                         lode_references_active_flux(tuning, lode_references_salient_H(tuning), id);
    const float limit = per_iq * iq_max;
    return (lode_references_out_t){{id, lode_clamp(torque_Nm / per_iq, -iq_max, iq_max)},
                                   {-limit, limit}};
}

#endif
