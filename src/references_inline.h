// One call of the current references: id* = 0 with its bias is inline, the rest is not.
#ifndef LODE_REFERENCES_INLINE_H
#define LODE_REFERENCES_INLINE_H

#include "lodestar/references.h"
#include "ramp_inline.h"

// All but id* = 0 comes in three parts: in one, it would make one period in a round much longer than the others. First part,
// for field weakening: the flux that the voltage allows.
void lode_references_find_flux(lode_references_t *self, const lode_references_tuning_t *tuning,
                               float omega_rad_s, lode_references_voltage_t voltage);
// Second part: id for the torque alone, plus `id_add_A`.
void lode_references_find_id(lode_references_t *self, const lode_references_tuning_t *tuning,
                             float torque_Nm, float omega_rad_s, float id_add_A, float v_bus_V);
// Last part: the currents for the torque, with that flux and that id.
lode_references_out_t lode_references_optimal(lode_references_t *self,
                                              const lode_references_tuning_t *tuning,
                                              float torque_Nm, float omega_rad_s, float v_bus_V);

#define ACTIVE_FLUX_MIN_SHARE 0.1f // of psi: least active flux as a divisor

// Voltage induced by rotation at the currents `i_A`, with the present `Lq_H`: decoupling and EMF feed-forward of current
// control (K1).
LODE_INLINE lode_dq_t lode_references_induced_V(const lode_references_tuning_t *tuning, float Lq_H,
                                                lode_dq_t i_A, float omega_rad_s) {
    return (lode_dq_t){-omega_rad_s * Lq_H * i_A.q,
                       omega_rad_s * (tuning->Ld_H * i_A.d + tuning->psi_Wb)};
}

// Ld - Lq at zero current.
LODE_INLINE float lode_references_salient_H(const lode_references_tuning_t *tuning) {
    return tuning->Ld_H - tuning->Lq_H;
}

// With an id so positive that a salient rotor has no torque left, the divisor stays positive and the current limit acts.
LODE_INLINE float lode_references_active_flux(const lode_references_tuning_t *tuning, float salient,
                                              float id_A) {
    return lode_max(tuning->psi_Wb + salient * id_A, ACTIVE_FLUX_MIN_SHARE * tuning->psi_Wb);
}

LODE_INLINE bool lode_references_has(const lode_references_tuning_t *tuning, int option) {
    return (tuning->options & (uint32_t)option) != 0u;
}

LODE_INLINE bool lode_references_weakens(const lode_references_tuning_t *tuning) {
#if defined(LODE_WITHOUT_OPTIMAL_REFERENCES) || defined(LODE_WITHOUT_FIELD_WEAKENING)
    (void)tuning;
    return false;
#else
    return lode_references_has(tuning, LODE_REFERENCES_WEAKEN);
#endif
}

// First part: what limits the flux, at the electrical speed `omega_rad_s`.
LODE_INLINE void lode_references_limit(lode_references_t *self,
                                       const lode_references_tuning_t *tuning, float omega_rad_s,
                                       lode_references_voltage_t voltage) {
#ifdef LODE_WITHOUT_OPTIMAL_REFERENCES
    (void)self;
    (void)tuning;
    (void)omega_rad_s;
    (void)voltage;
#else
    if (lode_references_weakens(tuning)) {
        lode_references_find_flux(self, tuning, omega_rad_s, voltage);
    }
#endif
}

// Second part: id for `torque_Nm` alone; `id_add_A` is added to it (the rest of the start current while it fades).
LODE_INLINE void lode_references_free(lode_references_t *self,
                                      const lode_references_tuning_t *tuning, float torque_Nm,
                                      float omega_rad_s, float id_add_A, float v_bus_V) {
#ifdef LODE_WITHOUT_OPTIMAL_REFERENCES
    (void)self;
    (void)tuning;
    (void)torque_Nm;
    (void)omega_rad_s;
    (void)id_add_A;
    (void)v_bus_V;
#else
    if (tuning->options != 0u) {
        lode_references_find_id(self, tuning, torque_Nm, omega_rad_s, id_add_A, v_bus_V);
    }
#endif
}

// Last part: the currents for `torque_Nm`. They stay within the circle i_max, d first.
LODE_INLINE lode_references_out_t lode_references_finish(lode_references_t *self,
                                                         const lode_references_tuning_t *tuning,
                                                         float torque_Nm, float omega_rad_s,
                                                         float id_add_A, float v_bus_V) {
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (tuning->options != 0u) {
        return lode_references_optimal(self, tuning, torque_Nm, omega_rad_s, v_bus_V);
    }
#endif
    (void)self;
    (void)v_bus_V;
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

// Flux that a saturated q axis lacks compared with the Lq at zero current (R2).
LODE_INLINE float lode_references_lacking_Wb(const lode_references_tuning_t *tuning, float iq_A) {
    const float less = tuning->Lq_fall * lode_abs(iq_A);
    return tuning->Lq_H * iq_A * less / (1.0f + less);
}

// The observer uses the Lq at zero current. With the present Lq the active flux is further ahead, by (R17): returns `at` turned
// by that angle.
LODE_INLINE lode_sincos_t lode_references_saturated(const lode_references_tuning_t *tuning,
                                                    lode_sincos_t at, lode_dq_t i_A) {
    const float psi_a =
        lode_references_active_flux(tuning, lode_references_salient_H(tuning), i_A.d);
    const float x = lode_clamp(lode_references_lacking_Wb(tuning, i_A.q) / psi_a, -1.0f, 1.0f);
    const float scale = 1.0f / lode_sqrt(1.0f + x * x);
    return lode_angle_add(at, (lode_sincos_t){scale * x, scale});
}

// All three parts in one call.
LODE_INLINE lode_references_out_t lode_references_step(lode_references_t *self,
                                                       const lode_references_tuning_t *tuning,
                                                       float torque_Nm, float omega_rad_s,
                                                       float id_add_A,
                                                       lode_references_voltage_t voltage) {
    lode_references_limit(self, tuning, omega_rad_s, voltage);
    lode_references_free(self, tuning, torque_Nm, omega_rad_s, id_add_A, voltage.v_bus_V);
    return lode_references_finish(self, tuning, torque_Nm, omega_rad_s, id_add_A, voltage.v_bus_V);
}

#endif
