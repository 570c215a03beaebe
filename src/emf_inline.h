// The EMF part of the step: voltage and current to dead-beat EMF, and that to the observer's estimate.
#ifndef LODESTAR_EMF_INLINE_H
#define LODESTAR_EMF_INLINE_H

#include "lodestar/emf.h"
#include "observer_inline.h"

// Dead-beat EMF (E3) of a period: u[k-1] - (i[k] - a i[k-1])/b. `u_V`: mean voltage over [t_k-1, t_k); `i_A`: current at t_k.
// It includes the EMF of a changing active flux.
LODE_INLINE lode_ab_t lode_emf_dead_beat(lode_emf_t *self, const lode_emf_tuning_t *tuning,
                                         lode_ab_t u_V, lode_ab_t i_A) {
    lode_ab_t m = lode_ab_add_scaled(u_V, tuning->a_over_b, self->i_A);
    m = lode_ab_add_scaled(m, -tuning->inv_b, i_A);
    self->i_A = i_A;
    return m;
}

// Innovation of the observer: dead-beat EMF of the present period minus the last estimate. Call before lode_emf_dead_beat().
LODE_INLINE lode_ab_t lode_emf_innovation(const lode_emf_t *self, const lode_emf_tuning_t *tuning,
                                          lode_ab_t u_V, lode_ab_t i_A) {
    const lode_ab_t m = lode_ab_add_scaled(u_V, tuning->a_over_b, self->i_A);
    return lode_ab_subtract(lode_ab_add_scaled(m, -tuning->inv_b, i_A), self->observer.e_V);
}

// `m_V` without (Ld - Lq) did/dt on the d axis, as a mean over the period (E5). `rise_A`: change of id in the period; `middle`:
// predicted rotor angle in its middle. Only where the angle is reliable.
LODE_INLINE lode_ab_t lode_emf_less_salient(const lode_emf_tuning_t *tuning, lode_ab_t m_V,
                                            float rise_A, lode_sincos_t middle) {
    return lode_ab_add_scaled(m_V, -tuning->salient_Ohm * rise_A,
                              (lode_ab_t){middle.cos, middle.sin});
}

#endif
