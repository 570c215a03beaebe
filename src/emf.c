#include "lodestar/emf.h"

// Default bandwidth over the rated speed: paper 1 has 2000 rad/s at 471 rad/s.
#define W0_PER_OMEGA_RATED 4.25f
#define W0_TS_DEFAULT_MAX 0.5f
#define W0_TS_MAX 2.0f
// The current may settle to 1 - exp(-1) of its final value within a period, not further.
#define MU_TS_MAX 1.0f

void lode_emf_design(lode_emf_config_t *config, const lode_motor_t *motor, float ts_s) {
    const float w0 =
        lode_min(W0_PER_OMEGA_RATED * motor->omega_rated_rad_s, W0_TS_DEFAULT_MAX / ts_s);
    config->w0_rad_s = lode_given_or(config->w0_rad_s, w0);
}

// Voltage that changes the current by one ampere within a period, 1/b: R/(1 - a), Lq/Ts for R -> 0.
static float volts_per_ampere(const lode_motor_t *motor, float ts_s) {
    const float mu_Ts = motor->Rs_Ohm * ts_s / motor->Lq_H;
    const float decay = lode_one_minus_exp(mu_Ts);
    return decay > 0.0f ? motor->Rs_Ohm / decay : motor->Lq_H / ts_s;
}

lode_status_t lode_emf_tune(lode_emf_tuning_t *tuning, const lode_emf_config_t *config,
                            const lode_motor_t *motor, bool active_flux, float ts_s) {
    if (config->kind != LODE_EMF_C_LESO) {
        return LODE_ERROR_EMF_KIND;
    }
    if (!lode_in_range(config->w0_rad_s, 1.0f, W0_TS_MAX / ts_s)) {
        return LODE_ERROR_EMF_W0;
    }
    if (!(motor->Rs_Ohm * ts_s <= MU_TS_MAX * lode_min(motor->Ld_H, motor->Lq_H))) {
        return LODE_ERROR_MOTOR_PERIOD;
    }
    *tuning = (lode_emf_tuning_t){
        .Rs_Ohm = motor->Rs_Ohm,
        .inv_b = volts_per_ampere(motor, ts_s),
        .one_m_p = lode_one_minus_exp(config->w0_rad_s * ts_s),
        .salient_Ohm = active_flux ? (motor->Ld_H - motor->Lq_H) / ts_s : 0.0f,
    };
    return LODE_OK;
}

void lode_emf_reset(lode_emf_t *self, lode_ab_t i_A) {
    *self = (lode_emf_t){i_A, {0.0f, 0.0f}, {0.0f, 0.0f}};
}

// (Ld - Lq) did/dt on the d axis, at the angle half a period back: the mean over the period.
static lode_ab_t active_flux_emf(const lode_emf_t *self, const lode_emf_tuning_t *tuning,
                                 lode_ab_t i_A, lode_sincos_t rotor, lode_sincos_t half_turn) {
    const lode_sincos_t middle = lode_angle_subtract(rotor, half_turn);
    const lode_sincos_t before = lode_angle_subtract(middle, half_turn);
    const float id = i_A.alpha * rotor.cos + i_A.beta * rotor.sin;
    const float id_before = self->i_A.alpha * before.cos + self->i_A.beta * before.sin;
    const float e_V = tuning->salient_Ohm * (id - id_before);
    return (lode_ab_t){e_V * middle.cos, e_V * middle.sin};
}

LODE_HOT lode_ab_t lode_emf_step(lode_emf_t *self, const lode_emf_tuning_t *tuning, lode_ab_t u_V,
                                 lode_ab_t i_A, lode_sincos_t rotor, lode_sincos_t half_turn,
                                 bool rotor_known) {
    // Dead-beat EMF: u[k-1] - (i[k] - a i[k-1])/b less the active-flux term; (1 - a)/b is R.
    const lode_ab_t salient = active_flux_emf(self, tuning, i_A, rotor, half_turn);
    const lode_ab_t rise = lode_ab_subtract(i_A, self->i_A);
    lode_ab_t m = lode_ab_add_scaled(u_V, rotor_known ? -1.0f : 0.0f, salient);
    m = lode_ab_add_scaled(m, -tuning->Rs_Ohm, self->i_A);
    m = lode_ab_add_scaled(m, -tuning->inv_b, rise);
    self->i_A = i_A;
    // C-LESO with both poles at p = exp(-w0 Ts), current form (paper 1, eqs. 6 and 11).
    self->y_V = lode_ab_add_scaled(self->y_V, tuning->one_m_p, lode_ab_subtract(m, self->y_V));
    self->e_V =
        lode_ab_add_scaled(self->e_V, tuning->one_m_p, lode_ab_subtract(self->y_V, self->e_V));
    return self->e_V;
}

// arg(exp(j turn) - pole) for a real pole, from 1 - pole, without cancellation.
static float arg_from_pole(float one_m_pole, float turn_rad) {
    const float half = lode_sincos(0.5f * turn_rad).sin;
    return lode_atan2(lode_sincos(turn_rad).sin, one_m_pole - 2.0f * half * half);
}

float lode_emf_lag_rad(const lode_emf_config_t *config, const lode_motor_t *motor, float ts_s,
                       float omega_rad_s) {
    const float turn_rad = omega_rad_s * ts_s;
    const float mu = motor->Rs_Ohm / motor->Lq_H;
    const float pole = arg_from_pole(lode_one_minus_exp(config->w0_rad_s * ts_s), turn_rad);
    // The held voltage sees the R-Lq circuit as Gamma = (rho - a)/((mu + j w) b Lq).
    const float gamma =
        arg_from_pole(lode_one_minus_exp(mu * ts_s), turn_rad) - lode_atan2(omega_rad_s, mu);
    return 2.0f * pole - turn_rad - gamma;
}
