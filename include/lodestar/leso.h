/// The linear extended state observers of both papers as filters of the dead-beat EMF m[k].
///
/// Written on the R-Lq circuit and discretised exactly, every one of them reduces to a filter from
/// m to the estimate e (docs/theory/emf.md). They share one state, so that a drive may hold any.
#ifndef LODESTAR_LESO_H
#define LODESTAR_LESO_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Which filter. GI, FA and the modes of FA can be left out of a build with LODE_WITHOUT_GI_LESO,
/// LODE_WITHOUT_FA_LESO and LODE_WITHOUT_FA_MULTI; init then refuses them. On a Cortex-M4F (gcc 12.2,
/// -O2) that saves 304, 820 and 604 of the 2748 bytes of leso.c.
typedef enum {
    LODE_EMF_C_LESO,  ///< conventional, double pole at w0 (paper 1, eq. 11; E10), current form
    LODE_EMF_GI_LESO, ///< with a generalised integrator at the speed (paper 2, eqs. 29, 30; E13)
    LODE_EMF_FA_LESO, ///< frequency adaptive (paper 2, eqs. 26-28; E17, E18)
    LODE_EMF_FA_MULTI ///< the same with further modes at 0, -5 w and +7 w
} lode_emf_kind_t;

typedef struct {
    lode_emf_kind_t kind;
    float w0_rad_s; ///< C, GI: bandwidth, 1 .. 2/Ts (paper 1, eq. 6); 0: 4.25 times rated speed, at
                    ///< most 0.5/Ts
    float gi_kappa; ///< GI: Kr/w0^2, 0 .. 7; 0: 2
    float gi_wc_rad_s; ///< GI: half width of the integrator, 0.01 .. 100; 0: 2 pi
    float k1_rad2_s2;  ///< FA: 0 .. 1e4 and k2^2/10; 0: first order, which takes no DC in
    float k2_rad_s;    ///< FA: bandwidth, 1 .. 1/Ts; 0: 3 times the PLL's sigma, multi 10 times
} lode_leso_config_t;

typedef struct {
    lode_emf_kind_t kind;
    float ts_s;
    float one_m_p;    ///< C, GI: 1 - exp(-w0 Ts)
    float p2;         ///< GI: exp(-2 w0 Ts)
    float gi_kappa;   ///< GI
    float gi_al;      ///< GI: wc Ts
    float q;          ///< FA: exp(-k2 Ts)
    float sqrt_q;     ///< FA: exp(-k2 Ts/2)
    float k1_Ts2;     ///< FA: k1 Ts^2
    float half_k2_Ts; ///< FA: k2 Ts/2
    float k2_rad_s;   ///< multi
    float omega_low;  ///< multi: speed up to which the further modes stay out
    float inv_span;   ///< multi: 1/(speed from which they are in full - omega_low)
} lode_leso_tuning_t;

typedef struct {
    lode_ab_t e_V; ///< the estimate
    lode_ab_t
        s[3]; ///< C: first stage. GI: error, band-pass. FA: slow mode. Multi: modes 0, -5 w, 7 w
} lode_leso_t;

/// Fills every zero field that has a default.
void lode_leso_design(lode_leso_config_t *config, float omega_rated_rad_s, float sigma_rad_s,
                      float ts_s);

lode_status_t lode_leso_tune(lode_leso_tuning_t *tuning, const lode_leso_config_t *config,
                             float omega_rated_rad_s, float ts_s);

void lode_leso_reset(lode_leso_t *self);

/// Empties what forgets slowly, the band-pass of GI and the further modes of FA; the estimate stays.
void lode_leso_calm(lode_leso_t *self, const lode_leso_tuning_t *tuning);

/// GI, FA with k1 > 0, and the multi-mode FA: the part of lode_leso_step() that is rarely built in.
void lode_leso_step_other(lode_leso_t *self, const lode_leso_tuning_t *tuning, lode_ab_t m_V,
                          lode_sincos_t turn, float omega_rad_s);

/// C-LESO, one period: the estimate from `m_V`.
LODE_INLINE lode_ab_t lode_leso_step_c(lode_leso_t *self, const lode_leso_tuning_t *tuning,
                                       lode_ab_t m_V) {
    // Both poles at p = exp(-w0 Ts), current form (E10).
    const float weight = tuning->one_m_p;
    const lode_ab_t y = lode_ab_add_scaled(self->s[0], weight, lode_ab_subtract(m_V, self->s[0]));
    const lode_ab_t e = lode_ab_add_scaled(self->e_V, weight, lode_ab_subtract(y, self->e_V));
    self->s[0] = y;
    self->e_V = e;
    return e;
}

/// The others. `turn`: the angle w Ts of a period at the speed `omega_rad_s` to which they are tuned.
LODE_INLINE lode_ab_t lode_leso_step_adaptive(lode_leso_t *self, const lode_leso_tuning_t *tuning,
                                              lode_ab_t m_V, lode_sincos_t turn,
                                              float omega_rad_s) {
    if (tuning->kind == LODE_EMF_FA_LESO && !(tuning->k1_Ts2 > 0.0f)) {
        // First order: e = q rho e + (1 - q) m (E17).
        const lode_ab_t turned = lode_ab_turn(self->e_V, turn);
        const lode_ab_t e = lode_ab_add_scaled(m_V, tuning->q, lode_ab_subtract(turned, m_V));
        self->e_V = e;
        return e;
    }
    const lode_ab_t m = {m_V.alpha, m_V.beta}; // copies: they themselves stay in registers
    const lode_sincos_t rho = {turn.sin, turn.cos};
    lode_leso_step_other(self, tuning, m, rho, omega_rad_s);
    return (lode_ab_t){self->e_V.alpha, self->e_V.beta};
}

/// Any of them.
static inline lode_ab_t lode_leso_step(lode_leso_t *self, const lode_leso_tuning_t *tuning,
                                       lode_ab_t m_V, lode_sincos_t turn, float omega_rad_s) {
    return tuning->kind == LODE_EMF_C_LESO
               ? lode_leso_step_c(self, tuning, m_V)
               : lode_leso_step_adaptive(self, tuning, m_V, turn, omega_rad_s);
}

/// Exact phase of e behind m in steady rotation at `omega_rad_s`, rad, odd. For init and host.
float lode_leso_lag_rad(const lode_leso_config_t *config, float ts_s, float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
