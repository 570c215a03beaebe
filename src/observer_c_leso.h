// C-LESO: both poles at p = exp(-w0 Ts), current form (E7) to (E12).
#ifndef LODESTAR_OBSERVER_C_LESO_H
#define LODESTAR_OBSERVER_C_LESO_H

#include "observer_common.h"

enum { C_LESO_Y };           // vector: the first stage's output
enum { C_LESO_ONE_MINUS_P }; // number

LODE_INLINE lode_ab_t c_leso_step(lode_observer_t *self, const lode_observer_tuning_t *tuning,
                                  lode_ab_t m_V, lode_sincos_t step_angle, float omega_rad_s) {
    (void)step_angle, (void)omega_rad_s;
    const float weight = tuning->own[C_LESO_ONE_MINUS_P];
    const lode_ab_t before = self->own[C_LESO_Y];
    const lode_ab_t y = lode_ab_add_scaled(before, weight, lode_ab_subtract(m_V, before));
    const lode_ab_t e = lode_ab_add_scaled(self->e_V, weight, lode_ab_subtract(y, self->e_V));
    self->own[C_LESO_Y] = y;
    self->e_V = e;
    return e;
}

#if defined(LODE_OBSERVER_INIT) && !defined(LODE_WITHOUT_C_LESO)
// The PLL's crossover is near 3 sigma, where each of the two poles costs 31 degrees of its 71 degrees of
// margin if w0 = 5 sigma: docs/theory/pll.md.
#define C_LESO_SIGMA_PER_W0_MAX 0.2f

static void c_leso_design(lode_observer_config_t *config, float omega_rated_rad_s,
                          float sigma_rad_s, float ts_s) {
    (void)sigma_rad_s;
    observer_design_w0(config, omega_rated_rad_s, ts_s);
}

static lode_status_t c_leso_check(const lode_observer_config_t *config, float ts_s) {
    return observer_check_w0(config, ts_s);
}

static lode_status_t c_leso_check_pll(const lode_observer_config_t *config, float sigma_rad_s,
                                      bool third_order) {
    (void)third_order;
    return sigma_rad_s <= C_LESO_SIGMA_PER_W0_MAX * config->w0_rad_s ? LODE_OK
                                                                     : LODE_ERROR_PLL_OBSERVER;
}

static void c_leso_tune(float *own, const lode_observer_config_t *config, float notch_rad_s,
                        float ts_s) {
    (void)notch_rad_s;
    own[C_LESO_ONE_MINUS_P] = lode_one_minus_exp(config->w0_rad_s * ts_s);
}

static void c_leso_settle(lode_observer_t *self) {
    (void)self;
}

// From e = p rho^-1 e + (1 - p) y.
static void c_leso_begin(lode_observer_t *self, const float *own, lode_sincos_t back) {
    const float inv = 1.0f / own[C_LESO_ONE_MINUS_P];
    const lode_ab_t before = lode_ab_rotate(self->e_V, back);
    self->own[C_LESO_Y] = lode_ab_add_scaled(before, inv, lode_ab_subtract(self->e_V, before));
}

// e/m = (1 - p)^2 rho^2/(rho - p)^2 (E11).
static float c_leso_lag_rad(const lode_observer_config_t *config, float ts_s, float omega_rad_s) {
    const float angle = omega_rad_s * ts_s;
    const float one_m_p = lode_one_minus_exp(config->w0_rad_s * ts_s);
    return 2.0f * (observer_arg_from_pole(one_m_p, angle) - angle);
}

// The double pole passes 1/(1 + (w/w0)^2).
static float c_leso_droop_s2(const lode_observer_config_t *config) {
    return 1.0f / (config->w0_rad_s * config->w0_rad_s);
}

static float c_leso_delay_s(const lode_observer_config_t *config) {
    return observer_delay_s(2.0f, config->w0_rad_s);
}
#endif

#endif
