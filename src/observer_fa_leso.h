// FA-LESO: a pole that turns with the rotor and, with k1 > 0, a second, slow one (E17), (E18).
#ifndef LODESTAR_OBSERVER_FA_LESO_H
#define LODESTAR_OBSERVER_FA_LESO_H

#include "observer_common.h"

enum { FA_LESO_SLOW, FA_LESO_FAST }; // vectors, k1 > 0
// Numbers: k2 and k1 as they enter the recursion.
enum { FA_LESO_Q, FA_LESO_SQRT_Q, FA_LESO_K1_TS2, FA_LESO_HALF_K2_TS, FA_LESO_HALF_TS_s };

/// Step with k1 > 0.
lode_ab_t lode_fa_leso_step_slow(lode_observer_t *self, const lode_observer_tuning_t *tuning,
                                 lode_ab_t m_V, lode_sincos_t step_angle, float omega_rad_s);

LODE_INLINE lode_ab_t fa_leso_step(lode_observer_t *self, const lode_observer_tuning_t *tuning,
                                   lode_ab_t m_V, lode_sincos_t step_angle, float omega_rad_s) {
    if (tuning->own[FA_LESO_K1_TS2] > 0.0f) {
        const lode_ab_t m = {m_V.alpha, m_V.beta}; // copies: the originals stay in registers
        const lode_sincos_t rho = {step_angle.sin, step_angle.cos};
        const lode_ab_t e_V = lode_fa_leso_step_slow(self, tuning, m, rho, omega_rad_s);
        return (lode_ab_t){e_V.alpha, e_V.beta};
    }
    // First order: e = q rho e + (1 - q) m (E17).
    const lode_ab_t rotated = lode_ab_rotate(self->e_V, step_angle);
    const lode_ab_t e =
        lode_ab_add_scaled(m_V, tuning->own[FA_LESO_Q], lode_ab_subtract(rotated, m_V));
    self->e_V = e;
    return e;
}

#if defined(LODE_OBSERVER_INIT) && !defined(LODE_WITHOUT_FA_LESO)
// With a larger k1 the model of observer and PLL together is unstable at low speed: docs/theory/fa_guideline.md.
#define FA_LESO_K2_PER_K1 10.0f
#define FA_LESO_K2_PER_SIGMA 3.0f // a wide margin over 0.549: docs/theory/pll.md
#define FA_LESO_K2_PER_SIGMA_MIN 0.549f

static void fa_leso_design(lode_observer_config_t *config, float omega_rated_rad_s,
                           float sigma_rad_s, float ts_s) {
    (void)omega_rated_rad_s;
    observer_design_k2(config, FA_LESO_K2_PER_SIGMA, sigma_rad_s, ts_s);
}

static lode_status_t fa_leso_check(const lode_observer_config_t *config, float ts_s) {
    const bool good = lode_in_range(config->k1_rad2_s2, 0.0f, 1.0e4f) &&
                      FA_LESO_K2_PER_K1 * config->k1_rad2_s2 <= config->k2_rad_s * config->k2_rad_s;
    return good ? observer_check_k2(config, ts_s) : LODE_ERROR_EMF_FA;
}

static lode_status_t fa_leso_check_pll(const lode_observer_config_t *config, float sigma_rad_s,
                                       bool third_order) {
    const bool good =
        !third_order || config->k2_rad_s >= FA_LESO_K2_PER_SIGMA_MIN * sigma_rad_s; // (P12)
    return good ? LODE_OK : LODE_ERROR_EMF_PLL;
}

static void fa_leso_tune(float *own, const lode_observer_config_t *config, float notch_rad_s,
                         float ts_s) {
    (void)notch_rad_s;
    const float k2_Ts = config->k2_rad_s * ts_s;
    own[FA_LESO_Q] = observer_pole(k2_Ts);
    own[FA_LESO_SQRT_Q] = observer_pole(0.5f * k2_Ts);
    own[FA_LESO_K1_TS2] = config->k1_rad2_s2 * ts_s * ts_s;
    own[FA_LESO_HALF_K2_TS] = 0.5f * k2_Ts;
    own[FA_LESO_HALF_TS_s] = 0.5f * ts_s;
}

static lode_ab_t product(lode_ab_t a, lode_ab_t b) {
    return (lode_ab_t){a.alpha * b.alpha - a.beta * b.beta, a.alpha * b.beta + a.beta * b.alpha};
}

static lode_ab_t quotient(lode_ab_t a, lode_ab_t b) {
    const float inv = 1.0f / lode_max(b.alpha * b.alpha + b.beta * b.beta, FLT_MIN);
    return lode_ab_scale(inv, product(a, (lode_ab_t){b.alpha, -b.beta}));
}

// Second order, k1 > 0, as two modes in parallel: z1 near q rho and z2 = 1 - t near 1, with
// z1 z2 = q rho and (1 - z1) t = d. The slow one starts from zero and stays small.
LODE_RAMFUNC lode_ab_t lode_fa_leso_step_slow(lode_observer_t *self,
                                              const lode_observer_tuning_t *tuning, lode_ab_t m_V,
                                              lode_sincos_t step_angle, float omega_rad_s) {
    const float *own = tuning->own;
    const lode_ab_t one = {1.0f, 0.0f};
    const lode_ab_t q_rho = {own[FA_LESO_Q] * step_angle.cos, own[FA_LESO_Q] * step_angle.sin};
    // d = sqrt(q rho) k1 Ts^2 sinh(x)/x with x = (k2 - j w) Ts/2; sinh(x)/x by its series.
    const float half_angle = own[FA_LESO_HALF_TS_s] * omega_rad_s;
    const lode_ab_t x = {own[FA_LESO_HALF_K2_TS], -half_angle};
    const lode_ab_t x2 = product(x, x);
    const lode_ab_t series =
        lode_ab_add_scaled(one, 1.0f / 6.0f, product(x2, lode_ab_add_scaled(one, 0.05f, x2)));
    const lode_sincos_t half = lode_sincos(half_angle);
    const lode_ab_t root = {own[FA_LESO_SQRT_Q] * half.cos, own[FA_LESO_SQRT_Q] * half.sin};
    const lode_ab_t d = lode_ab_scale(own[FA_LESO_K1_TS2], product(root, series));
    // The smaller root of t^2 - B t + d = 0, B = 1 - q rho + d, as a series in u = d/B^2.
    const lode_ab_t inv_B =
        quotient(one, lode_ab_add_scaled(lode_ab_subtract(one, q_rho), 1.0f, d));
    const lode_ab_t t0 = product(d, inv_B);
    const lode_ab_t u = product(t0, inv_B);
    lode_ab_t sum = lode_ab_add_scaled((lode_ab_t){2.0f, 0.0f}, 5.0f, u);
    sum = lode_ab_add_scaled(one, 1.0f, product(u, sum));
    sum = lode_ab_add_scaled(one, 1.0f, product(u, sum));
    const lode_ab_t t = product(t0, sum);
    const lode_ab_t z2 = lode_ab_subtract(one, t);
    const lode_ab_t z1 = quotient(q_rho, z2);
    // Residues of z ((1 - q)(z - 1) + d)/((z - z1)(z - z2)).
    const float one_m_q = 1.0f - own[FA_LESO_Q];
    const lode_ab_t apart = lode_ab_subtract(z2, z1);
    const lode_ab_t slow_gain = quotient(lode_ab_add_scaled(d, -one_m_q, t), apart);
    const lode_ab_t fast_gain = lode_ab_subtract((lode_ab_t){one_m_q, 0.0f}, slow_gain);
    lode_ab_t *slow = &self->own[FA_LESO_SLOW];
    lode_ab_t *fast = &self->own[FA_LESO_FAST];
    *fast = lode_ab_add_scaled(product(z1, *fast), 1.0f, product(fast_gain, m_V));
    *slow = lode_ab_add_scaled(product(z2, *slow), 1.0f, product(slow_gain, m_V));
    self->e_V = lode_ab_add_scaled(*fast, 1.0f, *slow);
    return self->e_V;
}

static void fa_leso_settle(lode_observer_t *self) {
    self->own[FA_LESO_SLOW] = (lode_ab_t){0.0f, 0.0f};
    self->own[FA_LESO_FAST] = self->e_V;
}

static void fa_leso_begin(lode_observer_t *self, const float *own, lode_sincos_t back) {
    (void)own, (void)back;
    fa_leso_settle(self); // all of the EMF is in the first mode
}

static float fa_leso_lag_rad(const lode_observer_config_t *config, float ts_s, float omega_rad_s) {
    (void)config, (void)ts_s, (void)omega_rad_s;
    return 0.0f; // tuned to the speed itself
}

static float fa_leso_droop_s2(const lode_observer_config_t *config) {
    (void)config;
    return 0.0f;
}

static float fa_leso_delay_s(const lode_observer_config_t *config) {
    return observer_delay_s(OBSERVER_K2_DELAY, config->k2_rad_s);
}
#endif

#endif
