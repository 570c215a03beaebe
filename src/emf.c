#include "lodestar/emf.h"

// Within a period the current may settle to at most 1 - exp(-1) of its final value.
#define MU_TS_MAX 1.0f

void lode_emf_design(lode_emf_config_t *config, const lode_motor_t *motor, float sigma_rad_s,
                     float ts_s) {
    lode_observer_design(config, motor->omega_rated_rad_s, sigma_rad_s, ts_s);
}

// Voltage that changes the current by one ampere within a period, 1/b: R/(1 - a), Lq/Ts for R -> 0.
static float volts_per_ampere(const lode_motor_t *motor, float ts_s) {
    const float mu_Ts = motor->Rs_Ohm * ts_s / motor->Lq_H;
    const float decay = lode_one_minus_exp(mu_Ts);
    return decay > 0.0f ? motor->Rs_Ohm / decay : motor->Lq_H / ts_s;
}

lode_status_t lode_emf_tune(lode_emf_tuning_t *tuning, const lode_emf_config_t *config,
                            const lode_motor_t *motor, float notch_rad_s, bool active_flux,
                            float ts_s) {
    lode_observer_tuning_t observer;
    const lode_status_t status = lode_observer_tune(&observer, config, notch_rad_s, ts_s);
    if (status != LODE_OK) {
        return status;
    }
    if (!(motor->Rs_Ohm * ts_s <= MU_TS_MAX * lode_min(motor->Ld_H, motor->Lq_H))) {
        return LODE_ERROR_MOTOR_PERIOD;
    }
    const float inv_b = volts_per_ampere(motor, ts_s);
    *tuning = (lode_emf_tuning_t){
        .inv_b = inv_b,
        .a_over_b = inv_b - motor->Rs_Ohm,
        .salient_Ohm = active_flux ? (motor->Ld_H - motor->Lq_H) / ts_s : 0.0f,
        .observer = observer,
    };
    return LODE_OK;
}

void lode_emf_reset(lode_emf_t *self, lode_ab_t i_A) {
    self->i_A = i_A;
    lode_observer_reset(&self->observer);
}

float lode_emf_lag_rad(const lode_emf_config_t *config, const lode_motor_t *motor, float ts_s,
                       float omega_rad_s) {
    const float step_rad = omega_rad_s * ts_s;
    const float mu = motor->Rs_Ohm / motor->Lq_H;
    // The voltage is held over the period, so the R-Lq circuit appears as Gamma = (rho - a)/((mu + j w) b Lq), and the mean of
    // the EMF over the period lags by a period: m = Gamma exp(-j w Ts) e(t_k).
    const float half = lode_sincos(0.5f * step_rad).sin;
    const float past_pole = lode_one_minus_exp(mu * ts_s) - 2.0f * half * half;
    const float gamma =
        lode_atan2(lode_sincos(step_rad).sin, past_pole) - lode_atan2(omega_rad_s, mu);
    return lode_observer_lag_rad(config, ts_s, omega_rad_s) + step_rad - gamma;
}
