#include "lodestar/leso.h"

// Default bandwidth over the rated speed: paper 1 has 2000 rad/s at 471 rad/s.
#define W0_PER_OMEGA_RATED 4.25f
#define W0_TS_DEFAULT_MAX 0.5f
#define W0_TS_MAX 2.0f
#define GI_KAPPA 2.0f     // paper 2, Table II
#define GI_KAPPA_MAX 7.0f // stable at every speed below 8
// Twice paper 2's: with pi the lag that a ramp leaves takes a second to go, 0.9 degrees after 0.4 s.
#define GI_WC_rad_s LODE_TWO_PI
// With more k1 the joint model with the PLL is unstable at low speed: docs/theory/fa_guideline.md.
#define K2_PER_K1 10.0f
#define LOWEST_DIVISOR 1.0e-3f
#define K2_PER_SIGMA 3.0f // a comfortable margin over 0.549: docs/theory/pll.md
#define K2_PER_SIGMA_MULTI 10.0f
#define K2_TS_MAX 1.0f
// The further modes hunt below 0.3 of rated speed.
#define MULTI_LOW_SHARE 0.25f
#define MULTI_HIGH_SHARE 0.35f
#define MULTI_KH_MAX_rad_s 20.0f
#define MULTI_KH_SHARE 0.15f // of the speed
#define MULTI_LEAK_rad_s 20.0f

void lode_leso_design(lode_leso_config_t *config, float omega_rated_rad_s, float sigma_rad_s,
                      float ts_s) {
    const float w0 = lode_min(W0_PER_OMEGA_RATED * omega_rated_rad_s, W0_TS_DEFAULT_MAX / ts_s);
    config->w0_rad_s = lode_given_or(config->w0_rad_s, w0);
    config->gi_kappa = lode_given_or(config->gi_kappa, GI_KAPPA);
    config->gi_wc_rad_s = lode_given_or(config->gi_wc_rad_s, GI_WC_rad_s);
    const bool multi = config->kind == LODE_EMF_FA_MULTI;
    const float k2 = (multi ? K2_PER_SIGMA_MULTI : K2_PER_SIGMA) * sigma_rad_s;
    config->k2_rad_s = lode_given_or(config->k2_rad_s, lode_min(k2, K2_TS_MAX / ts_s));
}

static bool is_built_in(lode_emf_kind_t kind) {
    switch (kind) {
    case LODE_EMF_C_LESO:
#ifndef LODE_WITHOUT_GI_LESO
    case LODE_EMF_GI_LESO:
#endif
#ifndef LODE_WITHOUT_FA_LESO
    case LODE_EMF_FA_LESO:
#endif
#ifndef LODE_WITHOUT_FA_MULTI
    case LODE_EMF_FA_MULTI:
#endif
        return true;
    default:
        return false;
    }
}

lode_status_t lode_leso_tune(lode_leso_tuning_t *tuning, const lode_leso_config_t *config,
                             float omega_rated_rad_s, float ts_s) {
    if (!is_built_in(config->kind)) {
        return LODE_ERROR_EMF_KIND;
    }
    if (!lode_in_range(config->w0_rad_s, 1.0f, W0_TS_MAX / ts_s)) {
        return LODE_ERROR_EMF_W0;
    }
    if (!lode_in_range(config->gi_kappa, 0.0f, GI_KAPPA_MAX) ||
        !lode_in_range(config->gi_wc_rad_s, 0.01f, 100.0f)) {
        return LODE_ERROR_EMF_GI;
    }
    if (!lode_in_range(config->k1_rad2_s2, 0.0f, 1.0e4f) ||
        !lode_in_range(config->k2_rad_s, 1.0f, 1.001f * K2_TS_MAX / ts_s) ||
        !(K2_PER_K1 * config->k1_rad2_s2 <= config->k2_rad_s * config->k2_rad_s)) {
        return LODE_ERROR_EMF_FA;
    }
    const float one_m_p = lode_one_minus_exp(config->w0_rad_s * ts_s);
    const float k2_Ts = config->k2_rad_s * ts_s;
    *tuning = (lode_leso_tuning_t){
        .kind = config->kind,
        .ts_s = ts_s,
        .one_m_p = one_m_p,
        .p2 = (1.0f - one_m_p) * (1.0f - one_m_p),
        .gi_kappa = config->gi_kappa,
        .gi_al = config->gi_wc_rad_s * ts_s,
        .q = 1.0f - lode_one_minus_exp(k2_Ts),
        .sqrt_q = 1.0f - lode_one_minus_exp(0.5f * k2_Ts),
        .k1_Ts2 = config->k1_rad2_s2 * ts_s * ts_s,
        .half_k2_Ts = 0.5f * k2_Ts,
        .k2_rad_s = config->k2_rad_s,
        .omega_low = MULTI_LOW_SHARE * omega_rated_rad_s,
        .inv_span = 1.0f / ((MULTI_HIGH_SHARE - MULTI_LOW_SHARE) * omega_rated_rad_s),
    };
    return LODE_OK;
}

void lode_leso_reset(lode_leso_t *self) {
    *self = (lode_leso_t){{0.0f, 0.0f}, {{0.0f, 0.0f}, {0.0f, 0.0f}, {0.0f, 0.0f}}};
}

void lode_leso_calm(lode_leso_t *self, const lode_leso_tuning_t *tuning) {
    const lode_ab_t none = {0.0f, 0.0f};
    if (tuning->kind == LODE_EMF_GI_LESO || tuning->kind == LODE_EMF_FA_MULTI) {
        self->s[0] = self->s[1] = self->s[2] = none;
    } else if (tuning->kind == LODE_EMF_FA_LESO) {
        self->s[0] = none;
        self->s[1] = self->e_V;
    }
}

#ifndef LODE_WITHOUT_GI_LESO
// C-LESO whose error passes, on top, a band-pass that has gain 1 exactly at the speed.
static void step_gi(lode_leso_t *self, const lode_leso_tuning_t *tuning, lode_ab_t m,
                    lode_sincos_t turn) {
    const lode_ab_t error =
        lode_ab_add_scaled(lode_ab_subtract(m, self->e_V), tuning->p2, self->s[0]);
    // The band-pass as two integrators that exchange their content, trapezoidal and prewarped, as in
    // the SOGI: B' = 2 wc (error - B) - w L, L' = w B. It loses energy at any course of the speed.
    const float g = turn.sin / lode_max(1.0f + turn.cos, LOWEST_DIVISOR); // tan(w Ts/2)
    const float al = tuning->gi_al * (1.0f + g * g);
    lode_ab_t *B = &self->s[1];
    lode_ab_t *L = &self->s[2];
    const lode_ab_t sum_B = lode_ab_add_scaled(lode_ab_add_scaled(*B, al, error), -g, *L);
    const lode_ab_t band = lode_ab_scale(1.0f / (1.0f + al + g * g), sum_B);
    const lode_ab_t low = lode_ab_add_scaled(*L, g, band);
    *B = lode_ab_add_scaled(lode_ab_scale(-1.0f, *B), 2.0f, band);
    *L = lode_ab_add_scaled(lode_ab_scale(-1.0f, *L), 2.0f, low);
    self->s[0] = error;
    const float gain = tuning->one_m_p * tuning->one_m_p;
    const lode_ab_t sum = lode_ab_add_scaled(error, tuning->gi_kappa, band);
    self->e_V = lode_ab_add_scaled(self->e_V, gain, sum);
}
#endif

#ifndef LODE_WITHOUT_FA_LESO
static lode_ab_t product(lode_ab_t a, lode_ab_t b) {
    return (lode_ab_t){a.alpha * b.alpha - a.beta * b.beta, a.alpha * b.beta + a.beta * b.alpha};
}

static lode_ab_t quotient(lode_ab_t a, lode_ab_t b) {
    const float inv = 1.0f / lode_max(b.alpha * b.alpha + b.beta * b.beta, FLT_MIN);
    return lode_ab_scale(inv, product(a, (lode_ab_t){b.alpha, -b.beta}));
}

// Second order, k1 > 0, as two modes in parallel: z1 near q rho and z2 = 1 - t near 1, with
// z1 z2 = q rho and (1 - z1) t = d. The slow one starts from zero and stays small.
static void step_fa_slow(lode_leso_t *self, const lode_leso_tuning_t *tuning, lode_ab_t m,
                         lode_sincos_t turn, float omega_rad_s) {
    const lode_ab_t one = {1.0f, 0.0f};
    const lode_ab_t q_rho = {tuning->q * turn.cos, tuning->q * turn.sin};
    // d = sqrt(q rho) k1 Ts^2 sinh(x)/x with x = (k2 - j w) Ts/2; sinh(x)/x by its series.
    const lode_ab_t x = {tuning->half_k2_Ts, -0.5f * tuning->ts_s * omega_rad_s};
    const lode_ab_t x2 = product(x, x);
    const lode_ab_t series =
        lode_ab_add_scaled(one, 1.0f / 6.0f, product(x2, lode_ab_add_scaled(one, 0.05f, x2)));
    const lode_sincos_t half = lode_sincos(0.5f * tuning->ts_s * omega_rad_s);
    const lode_ab_t root = {tuning->sqrt_q * half.cos, tuning->sqrt_q * half.sin};
    const lode_ab_t d = lode_ab_scale(tuning->k1_Ts2, product(root, series));
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
    const float one_m_q = 1.0f - tuning->q;
    const lode_ab_t apart = lode_ab_subtract(z2, z1);
    const lode_ab_t slow_gain = quotient(lode_ab_add_scaled(d, -one_m_q, t), apart);
    const lode_ab_t fast_gain = lode_ab_subtract((lode_ab_t){one_m_q, 0.0f}, slow_gain);
    lode_ab_t *slow = &self->s[0];
    lode_ab_t *fast = &self->s[1];
    *fast = lode_ab_add_scaled(product(z1, *fast), 1.0f, product(fast_gain, m));
    *slow = lode_ab_add_scaled(product(z2, *slow), 1.0f, product(slow_gain, m));
    self->e_V = lode_ab_add_scaled(*fast, 1.0f, *slow);
}
#endif

#ifndef LODE_WITHOUT_FA_MULTI
// mode + gain (1 + j lead) error.
static lode_ab_t corrected(lode_ab_t mode, float gain, float lead, lode_ab_t error) {
    return (lode_ab_t){mode.alpha + gain * (error.alpha - lead * error.beta),
                       mode.beta + gain * (error.beta + lead * error.alpha)};
}

// A bank of rotating modes that share one error. Offset and the 5th and 7th harmonic of the EMF end
// up in modes of their own; below omega_low those leak away.
static void step_multi(lode_leso_t *self, const lode_leso_tuning_t *tuning, lode_ab_t m,
                       lode_sincos_t turn, float omega_rad_s) {
    const float speed = lode_abs(omega_rad_s);
    const float in = lode_clamp((speed - tuning->omega_low) * tuning->inv_span, 0.0f, 1.0f);
    const float keep = 1.0f - (1.0f - in) * lode_min(MULTI_LEAK_rad_s * tuning->ts_s, 1.0f);
    const lode_sincos_t turn2 = lode_angle_add(turn, turn);
    const lode_sincos_t turn4 = lode_angle_add(turn2, turn2);
    const lode_sincos_t turn5 = lode_angle_add(turn4, turn);
    const lode_sincos_t turn7 = lode_angle_add(turn5, turn2);
    const lode_ab_t main = lode_ab_turn(self->e_V, turn);
    const lode_ab_t zero = lode_ab_scale(keep, self->s[0]);
    const lode_ab_t fifth =
        lode_ab_scale(keep, lode_ab_turn(self->s[1], (lode_sincos_t){-turn5.sin, turn5.cos}));
    const lode_ab_t seventh = lode_ab_scale(keep, lode_ab_turn(self->s[2], turn7));
    const lode_ab_t error = {m.alpha - main.alpha - zero.alpha - fifth.alpha - seventh.alpha,
                             m.beta - main.beta - zero.beta - fifth.beta - seventh.beta};
    // Each further mode turns at wm - w against the first, which answers with lag k2/(wm - w).
    const float gain = in * lode_min(MULTI_KH_MAX_rad_s, MULTI_KH_SHARE * speed) * tuning->ts_s;
    const float lead = in > 0.0f ? tuning->k2_rad_s / omega_rad_s : 0.0f;
    self->e_V = lode_ab_add_scaled(main, 1.0f - tuning->q, error);
    self->s[0] = corrected(zero, 0.5f * gain, lead, error);
    self->s[1] = corrected(fifth, gain, lead * (1.0f / 6.0f), error);
    self->s[2] = corrected(seventh, gain, lead * (-1.0f / 6.0f), error);
}
#endif

LODE_RAMFUNC void lode_leso_step_other(lode_leso_t *self, const lode_leso_tuning_t *tuning,
                                   lode_ab_t m_V, lode_sincos_t turn, float omega_rad_s) {
    (void)self, (void)m_V, (void)turn, (void)omega_rad_s;
    switch (tuning->kind) {
#ifndef LODE_WITHOUT_GI_LESO
    case LODE_EMF_GI_LESO:
        step_gi(self, tuning, m_V, turn);
        break;
#endif
#ifndef LODE_WITHOUT_FA_LESO
    case LODE_EMF_FA_LESO:
        step_fa_slow(self, tuning, m_V, turn, omega_rad_s);
        break;
#endif
#ifndef LODE_WITHOUT_FA_MULTI
    case LODE_EMF_FA_MULTI:
        step_multi(self, tuning, m_V, turn, omega_rad_s);
        break;
#endif
    case LODE_EMF_C_LESO:
    default:
        break;
    }
}

// arg(exp(j turn) - pole) for a real pole, from 1 - pole, without cancellation.
static float arg_from_pole(float one_m_pole, float turn_rad) {
    const float half = lode_sincos(0.5f * turn_rad).sin;
    return lode_atan2(lode_sincos(turn_rad).sin, one_m_pole - 2.0f * half * half);
}

// C: e/m = (1 - p)^2 rho^2/(rho - p)^2.
static float lag_c(float one_m_p, float turn_rad) {
    return 2.0f * (arg_from_pole(one_m_p, turn_rad) - turn_rad);
}

// GI: e/m = g rho^2/((rho - 1)(rho - p^2) + g rho), g = (1 - p)^2 (1 + kappa).
static float lag_gi(float one_m_p, float kappa, float turn_rad) {
    const lode_sincos_t rho = lode_sincos(turn_rad);
    const float half = lode_sincos(0.5f * turn_rad).sin;
    const float p = 1.0f - one_m_p;
    const float g = one_m_p * one_m_p * (1.0f + kappa);
    const float a = -2.0f * half * half; // rho - 1 = a + j sin
    const float b = 1.0f - p * p + a;    // rho - p^2 = b + j sin
    const float re = a * b - rho.sin * rho.sin + g * rho.cos;
    const float im = rho.sin * (a + b + g);
    return lode_atan2(im, re) - 2.0f * turn_rad;
}

float lode_leso_lag_rad(const lode_leso_config_t *config, float ts_s, float omega_rad_s) {
    const float turn_rad = omega_rad_s * ts_s;
    const float one_m_p = lode_one_minus_exp(config->w0_rad_s * ts_s);
    switch (config->kind) {
    case LODE_EMF_GI_LESO:
        return lag_gi(one_m_p, config->gi_kappa, turn_rad);
    case LODE_EMF_FA_LESO:
    case LODE_EMF_FA_MULTI:
        return 0.0f; // tuned to the speed itself
    case LODE_EMF_C_LESO:
    default:
        return lag_c(one_m_p, turn_rad);
    }
}
