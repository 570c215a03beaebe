// R-LESO: a C-LESO in the rotor's frame. Both poles at p rho, p = exp(-w0 Ts), rho = exp(j w Ts):
// (E22) to (E28), docs/theory/r_leso.md.
#ifndef LODESTAR_OBSERVER_R_LESO_H
#define LODESTAR_OBSERVER_R_LESO_H

#include "observer_common.h"

enum { R_LESO_Y }; // vector: the first stage's output
enum { R_LESO_P }; // number

// Either stage is x = p rho x + (1 - p) input (E23).
LODE_INLINE lode_ab_t r_leso_step(lode_observer_t *self, const lode_observer_tuning_t *tuning,
                                  lode_ab_t m_V, lode_sincos_t step_angle, float omega_rad_s) {
    (void)omega_rad_s;
    const float p = tuning->own[R_LESO_P];
    const lode_ab_t y_before = lode_ab_rotate(self->own[R_LESO_Y], step_angle);
    const lode_ab_t y = lode_ab_add_scaled(m_V, p, lode_ab_subtract(y_before, m_V));
    const lode_ab_t e_before = lode_ab_rotate(self->e_V, step_angle);
    const lode_ab_t e = lode_ab_add_scaled(y, p, lode_ab_subtract(e_before, y));
    self->own[R_LESO_Y] = y;
    self->e_V = e;
    return e;
}

#if defined(LODE_OBSERVER_INIT) && !defined(LODE_WITHOUT_R_LESO)
// Stability limits with the speed fed back: (E27), (E28).
#define R_LESO_W0_PER_SIGMA_MIN 1.684f
#define R_LESO_W0_PER_SIGMA_MIN_QPLL 0.325f
#define R_LESO_DELAY 2.4f // tuned by the PLL's speed (P32)

static void r_leso_design(lode_observer_config_t *config, float omega_rated_rad_s,
                          float sigma_rad_s, float ts_s) {
    (void)sigma_rad_s;
    observer_design_w0(config, omega_rated_rad_s, ts_s);
}

static lode_status_t r_leso_check(const lode_observer_config_t *config, float ts_s) {
    return observer_check_w0(config, ts_s);
}

static lode_status_t r_leso_check_pll(const lode_observer_config_t *config, float sigma_rad_s,
                                      bool third_order) {
    const float least = third_order ? R_LESO_W0_PER_SIGMA_MIN : R_LESO_W0_PER_SIGMA_MIN_QPLL;
    return config->w0_rad_s >= least * sigma_rad_s ? LODE_OK : LODE_ERROR_PLL_OBSERVER;
}

static void r_leso_tune(float *own, const lode_observer_config_t *config, float notch_rad_s,
                        float ts_s) {
    (void)notch_rad_s;
    own[R_LESO_P] = observer_pole(config->w0_rad_s * ts_s);
}

static void r_leso_settle(lode_observer_t *self) {
    (void)self; // nothing to do: fades with w0
}

static void r_leso_begin(lode_observer_t *self, const float *own, lode_sincos_t back) {
    (void)own, (void)back;
    self->own[R_LESO_Y] = self->e_V; // gain 1 at the speed
}

static float r_leso_lag_rad(const lode_observer_config_t *config, float ts_s, float omega_rad_s) {
    (void)config, (void)ts_s, (void)omega_rad_s;
    return 0.0f; // tuned to the speed itself (E24)
}

static float r_leso_droop_s2(const lode_observer_config_t *config) {
    (void)config;
    return 0.0f;
}

static float r_leso_delay_s(const lode_observer_config_t *config) {
    return observer_delay_s(R_LESO_DELAY, config->w0_rad_s);
}
#endif

#endif
