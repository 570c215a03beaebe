#include "lodestar/emf.h"

// The current may settle to 1 - exp(-1) of its final value within a period, not further.
#define MU_TS_MAX 1.0f

void lode_emf_design(lode_emf_config_t *config, const lode_motor_t *motor, float sigma_rad_s,
                     float ts_s) {
    lode_leso_design(config, motor->omega_rated_rad_s, sigma_rad_s, ts_s);
}

// Voltage that changes the current by one ampere within a period, 1/b: R/(1 - a), Lq/Ts for R -> 0.
static float volts_per_ampere(const lode_motor_t *motor, float ts_s) {
    const float mu_Ts = motor->Rs_Ohm * ts_s / motor->Lq_H;
    const float decay = lode_one_minus_exp(mu_Ts);
    return decay > 0.0f ? motor->Rs_Ohm / decay : motor->Lq_H / ts_s;
}

lode_status_t lode_emf_tune(lode_emf_tuning_t *tuning, const lode_emf_config_t *config,
                            const lode_motor_t *motor, bool active_flux, float ts_s) {
    lode_leso_tuning_t leso;
    const lode_status_t status = lode_leso_tune(&leso, config, motor->omega_rated_rad_s, ts_s);
    if (status != LODE_OK) {
        return status;
    }
    if (!(motor->Rs_Ohm * ts_s <= MU_TS_MAX * lode_min(motor->Ld_H, motor->Lq_H))) {
        return LODE_ERROR_MOTOR_PERIOD;
    }
    *tuning = (lode_emf_tuning_t){
        .Rs_Ohm = motor->Rs_Ohm,
        .inv_b = volts_per_ampere(motor, ts_s),
        .salient_Ohm = active_flux ? (motor->Ld_H - motor->Lq_H) / ts_s : 0.0f,
        .leso = leso,
    };
    return LODE_OK;
}

void lode_emf_reset(lode_emf_t *self, lode_ab_t i_A) {
    self->i_A = i_A;
    lode_leso_reset(&self->leso);
}

// (Ld - Lq) did/dt on the d axis (E5), at the angle half a period back: the mean over the period.
static lode_ab_t active_flux_emf(const lode_emf_t *self, const lode_emf_tuning_t *tuning,
                                 lode_ab_t i_A, const lode_emf_motion_t *motion) {
    const lode_sincos_t middle = lode_angle_subtract(motion->rotor, motion->half_turn);
    const lode_sincos_t before = lode_angle_subtract(middle, motion->half_turn);
    const float id = lode_park(i_A, motion->rotor).d;
    const float id_before = lode_park(self->i_A, before).d;
    const float e_V = motion->known ? tuning->salient_Ohm * (id - id_before) : 0.0f;
    return (lode_ab_t){e_V * middle.cos, e_V * middle.sin};
}

LODE_HOT lode_ab_t lode_emf_step(lode_emf_t *self, const lode_emf_tuning_t *tuning, lode_ab_t u_V,
                                 lode_ab_t i_A, const lode_emf_motion_t *motion) {
    // Dead-beat EMF (E3): u[k-1] - (i[k] - a i[k-1])/b less the active-flux term; (1 - a)/b is R.
    const lode_ab_t rise = lode_ab_subtract(i_A, self->i_A);
    lode_ab_t m = lode_ab_subtract(u_V, active_flux_emf(self, tuning, i_A, motion));
    m = lode_ab_add_scaled(m, -tuning->Rs_Ohm, self->i_A);
    m = lode_ab_add_scaled(m, -tuning->inv_b, rise);
    self->i_A = i_A;
    return lode_leso_step(&self->leso, &tuning->leso, m, motion->turn, motion->omega_rad_s);
}

float lode_emf_lag_rad(const lode_emf_config_t *config, const lode_motor_t *motor, float ts_s,
                       float omega_rad_s) {
    const float turn_rad = omega_rad_s * ts_s;
    const float mu = motor->Rs_Ohm / motor->Lq_H;
    // The held voltage sees the R-Lq circuit as Gamma = (rho - a)/((mu + j w) b Lq), and the mean of
    // the EMF over the period stands a period behind: m = Gamma exp(-j w Ts) e(t_k).
    const float half = lode_sincos(0.5f * turn_rad).sin;
    const float past_pole = lode_one_minus_exp(mu * ts_s) - 2.0f * half * half;
    const float gamma =
        lode_atan2(lode_sincos(turn_rad).sin, past_pole) - lode_atan2(omega_rad_s, mu);
    return lode_leso_lag_rad(config, ts_s, omega_rad_s) + turn_rad - gamma;
}
