// FA-LESO with further modes: a bank of rotating modes that share one error. Offset and the 5th and 7th harmonic of the EMF end
// up in modes of their own, which leak away at low speed (E19), (E32).
#ifndef LODESTAR_OBSERVER_FA_MULTI_H
#define LODESTAR_OBSERVER_FA_MULTI_H

#include "observer_common.h"

enum { FA_MULTI_ZERO, FA_MULTI_FIFTH, FA_MULTI_SEVENTH }; // vectors: modes 0, -5 w, 7 w
// Numbers. INV_NOTCH: 1/(the least frequency of a notch).
enum { FA_MULTI_Q, FA_MULTI_TS_s, FA_MULTI_K2, FA_MULTI_INV_NOTCH };

#if defined(LODE_OBSERVER_INIT) && !defined(LODE_WITHOUT_FA_MULTI)
#define FA_MULTI_K2_PER_SIGMA 10.0f
#define FA_MULTI_K2_PER_SIGMA_MIN                                                                  \
    0.6f                         // over 0.561, where the further modes blend in: docs/theory/pll.md
#define FA_MULTI_ZERO_ORDER 1.0f // in the rotor's frame
#define FA_MULTI_HARMONIC_ORDER 6.0f
#define FA_MULTI_INV_SPAN 2.5f // blended in up to 1.4 times the least frequency
#define FA_MULTI_KH_MAX_rad_s 20.0f
#define FA_MULTI_KH_SHARE 0.15f // of the speed
#define FA_MULTI_LEAK_rad_s 20.0f

static void fa_multi_design(lode_observer_config_t *config, float omega_rated_rad_s,
                            float sigma_rad_s, float ts_s) {
    (void)omega_rated_rad_s;
    observer_design_k2(config, FA_MULTI_K2_PER_SIGMA, sigma_rad_s, ts_s);
}

static lode_status_t fa_multi_check(const lode_observer_config_t *config, float ts_s) {
    return observer_check_k2(config, ts_s);
}

static lode_status_t fa_multi_check_pll(const lode_observer_config_t *config, float sigma_rad_s,
                                        bool third_order) {
    const bool good = !third_order || config->k2_rad_s >= FA_MULTI_K2_PER_SIGMA_MIN * sigma_rad_s;
    return good ? LODE_OK : LODE_ERROR_EMF_PLL;
}

static void fa_multi_tune(float *own, const lode_observer_config_t *config, float notch_rad_s,
                          float ts_s) {
    own[FA_MULTI_Q] = observer_pole(config->k2_rad_s * ts_s);
    own[FA_MULTI_TS_s] = ts_s;
    own[FA_MULTI_K2] = config->k2_rad_s;
    own[FA_MULTI_INV_NOTCH] = 1.0f / lode_max(notch_rad_s, FLT_MIN);
}

// Weight of the modes of this order.
static float fa_multi_weight(const float *own, float order, float speed_rad_s) {
    const float over = order * speed_rad_s * own[FA_MULTI_INV_NOTCH] - 1.0f;
    return lode_clamp(over * FA_MULTI_INV_SPAN, 0.0f, 1.0f);
}

// What is left of a mode after a period.
static float fa_multi_kept(const float *own, float weight) {
    return 1.0f - (1.0f - weight) * lode_min(FA_MULTI_LEAK_rad_s * own[FA_MULTI_TS_s], 1.0f);
}

// mode + gain (1 + j lead) error.
static lode_ab_t fa_multi_corrected(lode_ab_t mode, float gain, float lead, lode_ab_t error) {
    return (lode_ab_t){mode.alpha + gain * (error.alpha - lead * error.beta),
                       mode.beta + gain * (error.beta + lead * error.alpha)};
}

LODE_RAMFUNC static lode_ab_t fa_multi_step(lode_observer_t *self,
                                            const lode_observer_tuning_t *tuning, lode_ab_t m_V,
                                            lode_sincos_t step_angle, float omega_rad_s) {
    const float *own = tuning->own;
    const float speed = lode_abs(omega_rad_s);
    const float by_zero = fa_multi_weight(own, FA_MULTI_ZERO_ORDER, speed);
    const float by_others = fa_multi_weight(own, FA_MULTI_HARMONIC_ORDER, speed);
    const float keep = fa_multi_kept(own, by_others);
    const lode_sincos_t angle2 = lode_angle_add(step_angle, step_angle);
    const lode_sincos_t angle4 = lode_angle_add(angle2, angle2);
    const lode_sincos_t angle5 = lode_angle_add(angle4, step_angle);
    const lode_sincos_t angle7 = lode_angle_add(angle5, angle2);
    const lode_ab_t main = lode_ab_rotate(self->e_V, step_angle);
    const lode_ab_t zero = lode_ab_scale(fa_multi_kept(own, by_zero), self->own[FA_MULTI_ZERO]);
    const lode_ab_t fifth = lode_ab_scale(
        keep, lode_ab_rotate(self->own[FA_MULTI_FIFTH], (lode_sincos_t){-angle5.sin, angle5.cos}));
    const lode_ab_t seventh =
        lode_ab_scale(keep, lode_ab_rotate(self->own[FA_MULTI_SEVENTH], angle7));
    const lode_ab_t error = {m_V.alpha - main.alpha - zero.alpha - fifth.alpha - seventh.alpha,
                             m_V.beta - main.beta - zero.beta - fifth.beta - seventh.beta};
    // Relative to the first mode each further mode turns at wm - w, so the first one answers it with the lag k2/(wm - w).
    const float kh = lode_min(FA_MULTI_KH_MAX_rad_s, FA_MULTI_KH_SHARE * speed);
    const float gain = kh * own[FA_MULTI_TS_s];
    const float lead = by_others > 0.0f ? own[FA_MULTI_K2] / omega_rad_s : 0.0f;
    self->e_V = lode_ab_add_scaled(main, 1.0f - own[FA_MULTI_Q], error);
    self->own[FA_MULTI_ZERO] = fa_multi_corrected(zero, 0.5f * by_zero * gain, lead, error);
    self->own[FA_MULTI_FIFTH] =
        fa_multi_corrected(fifth, by_others * gain, lead * (1.0f / 6.0f), error);
    self->own[FA_MULTI_SEVENTH] =
        fa_multi_corrected(seventh, by_others * gain, lead * (-1.0f / 6.0f), error);
    return self->e_V;
}

static void fa_multi_settle(lode_observer_t *self) {
    self->own[FA_MULTI_ZERO] = self->own[FA_MULTI_FIFTH] = self->own[FA_MULTI_SEVENTH] =
        (lode_ab_t){0.0f, 0.0f};
}

static void fa_multi_begin(lode_observer_t *self, const float *own, lode_sincos_t back) {
    (void)own, (void)back;
    fa_multi_settle(self); // all of the EMF is in the first mode
}

static float fa_multi_lag_rad(const lode_observer_config_t *config, float ts_s, float omega_rad_s) {
    (void)config, (void)ts_s, (void)omega_rad_s;
    return 0.0f; // tuned to the speed itself
}

static float fa_multi_droop_s2(const lode_observer_config_t *config) {
    (void)config;
    return 0.0f;
}

static float fa_multi_delay_s(const lode_observer_config_t *config) {
    return observer_delay_s(OBSERVER_K2_DELAY, config->k2_rad_s);
}
#endif

#endif
