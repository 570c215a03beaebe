#include "lodestar/references.h"

// At 471 rad/s rated: full below 94, gone above 188 rad/s. Narrower, a load step from no load at a
// quarter of rated speed met all three currents in the dead band: 11 degrees of error instead of 4.
#define OMEGA_LOW_SHARE 0.2f
#define OMEGA_HIGH_SHARE 0.4f
#define BIAS_SHARE 0.25f // of i_max: 3 A of 12 A leaves no phase at zero for long

void lode_references_design(lode_references_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor) {
    config->id_bias_A = lode_given_or(config->id_bias_A, BIAS_SHARE * inverter->i_max_A);
    config->omega_low_rad_s =
        lode_given_or(config->omega_low_rad_s, OMEGA_LOW_SHARE * motor->omega_rated_rad_s);
    config->omega_high_rad_s =
        lode_given_or(config->omega_high_rad_s, OMEGA_HIGH_SHARE * motor->omega_rated_rad_s);
}

lode_status_t lode_references_tune(lode_references_tuning_t *tuning,
                                   const lode_references_config_t *config,
                                   const lode_inverter_config_t *inverter,
                                   const lode_motor_t *motor) {
    const float span = config->omega_high_rad_s - config->omega_low_rad_s;
    if (!(config->id_bias_A <= inverter->i_max_A) || !lode_is_finite(config->id_bias_A) ||
        !(span > 0.0f) || !lode_is_finite(span)) {
        return LODE_ERROR_ID_BIAS;
    }
    *tuning = (lode_references_tuning_t){
        .fade = {config->omega_high_rad_s, 1.0f / span},
        .id_bias_A = lode_max(config->id_bias_A, 0.0f),
        .i_max_A = inverter->i_max_A,
        .psi_Wb = motor->psi_Wb,
        .salient_H = motor->Ld_H - motor->Lq_H,
        .torque_factor = lode_motor_torque_factor(motor),
    };
    return LODE_OK;
}

static float torque_per_iq(const lode_references_tuning_t *tuning, float id_A) {
    return tuning->torque_factor * (tuning->psi_Wb + tuning->salient_H * id_A);
}

LODE_HOT lode_dq_t lode_references_step(const lode_references_tuning_t *tuning, float torque_Nm,
                                        float omega_rad_s, float id_add_A) {
    const float i_max = tuning->i_max_A;
    const float bias = tuning->id_bias_A * lode_fade(&tuning->fade, lode_abs(omega_rad_s));
    const float id = lode_clamp(id_add_A - bias, -i_max, i_max);
    const float iq_max = lode_sqrt(i_max * i_max - id * id);
    // An id so positive that a salient rotor has no torque left is met at the current limit.
    const float per_iq = lode_max(torque_per_iq(tuning, id), 0.1f * torque_per_iq(tuning, 0.0f));
    return (lode_dq_t){id, lode_clamp(torque_Nm / per_iq, -iq_max, iq_max)};
}

float lode_references_torque_Nm(const lode_references_tuning_t *tuning, lode_dq_t i_A) {
    return torque_per_iq(tuning, i_A.d) * i_A.q;
}
