// GI-LESO: a C-LESO with a band-pass added to its error, which has gain 1 exactly at the rotor's speed (E13) to (E16).
#ifndef LODESTAR_OBSERVER_GI_LESO_H
#define LODESTAR_OBSERVER_GI_LESO_H

#include "observer_common.h"

enum { GI_LESO_ERROR, GI_LESO_B, GI_LESO_L };                    // vectors
enum { GI_LESO_GAIN, GI_LESO_P2, GI_LESO_KAPPA, GI_LESO_WC_TS }; // numbers

#if defined(LODE_OBSERVER_INIT) && !defined(LODE_WITHOUT_GI_LESO)
#define GI_LESO_KAPPA_DEFAULT 2.0f // paper 2, Table II
#define GI_LESO_KAPPA_MAX 7.0f     // below 8 stable at any speed
// Twice paper 2's pi, with which the lag left by a ramp takes a second to fade: 0.9 degrees after 0.4 s.
#define GI_LESO_WC_rad_s LODE_TWO_PI
#define GI_LESO_SIGMA_PER_W0_MAX 0.2f // as C-LESO
#define GI_LESO_LOWEST_DIVISOR 1.0e-3f

static void gi_leso_design(lode_observer_config_t *config, float omega_rated_rad_s,
                           float sigma_rad_s, float ts_s) {
    (void)sigma_rad_s;
    observer_design_w0(config, omega_rated_rad_s, ts_s);
    config->gi_kappa = lode_given_or(config->gi_kappa, GI_LESO_KAPPA_DEFAULT);
    config->gi_wc_rad_s = lode_given_or(config->gi_wc_rad_s, GI_LESO_WC_rad_s);
}

static lode_status_t gi_leso_check(const lode_observer_config_t *config, float ts_s) {
    const bool good = lode_in_range(config->gi_kappa, 0.0f, GI_LESO_KAPPA_MAX) &&
                      lode_in_range(config->gi_wc_rad_s, 0.01f, 100.0f);
    return good ? observer_check_w0(config, ts_s) : LODE_ERROR_EMF_GI;
}

static lode_status_t gi_leso_check_pll(const lode_observer_config_t *config, float sigma_rad_s,
                                       bool third_order) {
    (void)third_order;
    return sigma_rad_s <= GI_LESO_SIGMA_PER_W0_MAX * config->w0_rad_s ? LODE_OK
                                                                      : LODE_ERROR_PLL_OBSERVER;
}

static void gi_leso_tune(float *own, const lode_observer_config_t *config, float notch_rad_s,
                         float ts_s) {
    (void)notch_rad_s;
    const float one_m_p = lode_one_minus_exp(config->w0_rad_s * ts_s);
    own[GI_LESO_GAIN] = one_m_p * one_m_p;
    own[GI_LESO_P2] = (1.0f - one_m_p) * (1.0f - one_m_p);
    own[GI_LESO_KAPPA] = config->gi_kappa;
    own[GI_LESO_WC_TS] = config->gi_wc_rad_s * ts_s;
}

LODE_RAMFUNC static lode_ab_t gi_leso_step(lode_observer_t *self,
                                           const lode_observer_tuning_t *tuning, lode_ab_t m_V,
                                           lode_sincos_t step_angle, float omega_rad_s) {
    (void)omega_rad_s;
    const float *own = tuning->own;
    const lode_ab_t error = lode_ab_add_scaled(lode_ab_subtract(m_V, self->e_V), own[GI_LESO_P2],
                                               self->own[GI_LESO_ERROR]);
    // The band-pass is two coupled integrators, trapezoidal and prewarped as in the SOGI: B' = 2 wc (error - B) - w L, L' = w
    // B. It loses energy whatever the speed does.
    const float g =
        step_angle.sin / lode_max(1.0f + step_angle.cos, GI_LESO_LOWEST_DIVISOR); // tan(w Ts/2)
    const float al = own[GI_LESO_WC_TS] * (1.0f + g * g);
    lode_ab_t *B = &self->own[GI_LESO_B];
    lode_ab_t *L = &self->own[GI_LESO_L];
    const lode_ab_t sum_B = lode_ab_add_scaled(lode_ab_add_scaled(*B, al, error), -g, *L);
    const lode_ab_t band = lode_ab_scale(1.0f / (1.0f + al + g * g), sum_B);
    const lode_ab_t low = lode_ab_add_scaled(*L, g, band);
    *B = lode_ab_add_scaled(lode_ab_scale(-1.0f, *B), 2.0f, band);
    *L = lode_ab_add_scaled(lode_ab_scale(-1.0f, *L), 2.0f, low);
    self->own[GI_LESO_ERROR] = error;
    const lode_ab_t sum = lode_ab_add_scaled(error, own[GI_LESO_KAPPA], band);
    self->e_V = lode_ab_add_scaled(self->e_V, own[GI_LESO_GAIN], sum);
    return self->e_V;
}

static void gi_leso_settle(lode_observer_t *self) {
    self->own[GI_LESO_ERROR] = self->own[GI_LESO_B] = self->own[GI_LESO_L] =
        (lode_ab_t){0.0f, 0.0f};
}

// From e = rho^-1 e + g (1 + kappa) error: the band-pass has gain 1, and its second integrator lags by 90 degrees (E13).
static void gi_leso_begin(lode_observer_t *self, const float *own, lode_sincos_t back) {
    const lode_ab_t moved = lode_ab_subtract(self->e_V, lode_ab_rotate(self->e_V, back));
    const lode_ab_t error =
        lode_ab_scale(1.0f / (own[GI_LESO_GAIN] * (1.0f + own[GI_LESO_KAPPA])), moved);
    const float g = -back.sin / lode_max(1.0f + back.cos, GI_LESO_LOWEST_DIVISOR); // tan(w Ts/2)
    const lode_ab_t B = {error.alpha - g * error.beta, error.beta + g * error.alpha};
    self->own[GI_LESO_ERROR] = error;
    self->own[GI_LESO_B] = B;
    self->own[GI_LESO_L] = (lode_ab_t){B.beta, -B.alpha};
}

// e/m = g rho^2/((rho - 1)(rho - p^2) + g rho), g = (1 - p)^2 (1 + kappa) (E15).
static float gi_leso_lag_rad(const lode_observer_config_t *config, float ts_s, float omega_rad_s) {
    const float angle = omega_rad_s * ts_s;
    const lode_sincos_t rho = lode_sincos(angle);
    const float half = lode_sincos(0.5f * angle).sin;
    const float one_m_p = lode_one_minus_exp(config->w0_rad_s * ts_s);
    const float p = 1.0f - one_m_p;
    const float g = one_m_p * one_m_p * (1.0f + config->gi_kappa);
    const float a = -2.0f * half * half; // rho - 1 = a + j sin
    const float b = 1.0f - p * p + a;    // rho - p^2 = b + j sin
    const float re = a * b - rho.sin * rho.sin + g * rho.cos;
    const float im = rho.sin * (a + b + g);
    return lode_atan2(im, re) - 2.0f * angle;
}

static float gi_leso_droop_s2(const lode_observer_config_t *config) {
    (void)config;
    return 0.0f; // the band-pass keeps it near 1
}

static float gi_leso_delay_s(const lode_observer_config_t *config) {
    return observer_delay_s(2.0f, config->w0_rad_s);
}
#endif

#endif
