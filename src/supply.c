#include "lodestar/supply.h"

#include <stddef.h>

#define CURRENT_MAX_A 1.0e5f
#define CORRECT_s 0.05f // a decade above the periods of the main loop and of speed control
#define CORRECT_MIN_s 1.0e-3f
#define CORRECT_MAX_s 100.0f
#define CORRECTION_MAX 0.25f // for a psi that is 20 % off
#define FOLLOWED_SHARE 0.05f // of the q reference: current control has settled
#define FLUX_MIN_SHARE 0.1f  // of psi: least active flux to divide by
#define BEYOND_SHARE 0.5f    // (L8): of the most torque
// 6/pi: mean sum of the magnitudes of three phase currents over their amplitude.
#define MEAN_ABS 1.90985932f

lode_status_t lode_supply_tune(lode_supply_tuning_t *tuning, const lode_supply_config_t *config,
                               const lode_drive_config_t *drive) {
    if (tuning == NULL || config == NULL || drive == NULL) {
        return LODE_ERROR_NULL;
    }
    const lode_motor_t *motor = &drive->motor;
    const float correct_s = lode_given_or(config->correct_s, CORRECT_s);
    const bool regen_none = lode_in_range(config->regen_A, LODE_NONE, LODE_NONE);
    if (!lode_in_range(config->battery_A, 0.0f, CURRENT_MAX_A) ||
        (!regen_none && !lode_in_range(config->regen_A, 0.0f, CURRENT_MAX_A)) ||
        !lode_in_range(correct_s, CORRECT_MIN_s, CORRECT_MAX_s)) {
        return LODE_ERROR_SUPPLY;
    }
    const float sets = lode_max(motor->sets, 1.0f);
    *tuning = (lode_supply_tuning_t){
        .limit_A = {lode_given_or(config->battery_A, FLT_MAX),
                    regen_none ? 0.0f : lode_given_or(config->regen_A, FLT_MAX)},
        .correct_s = correct_s,
        .power_factor = 1.5f * sets,
        .inv_pole_pairs = 1.0f / motor->pole_pairs,
        .R_Ohm = motor->Rs_Ohm + drive->inverter.r_on_Ohm,
        .drop_V = MEAN_ABS * sets * drive->inverter.v_drop_V,
        .torque_factor = lode_motor_torque_factor(motor),
        .psi_Wb = motor->psi_Wb,
        .salient_H = motor->Ld_H - motor->Lq_H,
        .most_Nm = lode_motor_kt_Nm_A(motor) * drive->inverter.i_max_A,
    };
    return LODE_OK;
}

void lode_supply_reset(lode_supply_t *self) {
    *self = (lode_supply_t){.factor = {1.0f, 1.0f}, .share = {1.0f, 1.0f}};
}

static bool has_gates(const lode_telemetry_t *telemetry) {
    const lode_mode_t mode = telemetry->mode;
    return mode == LODE_MODE_RUN || mode == LODE_MODE_START || mode == LODE_MODE_CURRENT ||
           mode == LODE_MODE_VOLTAGE;
}

static float drop_W(const lode_supply_tuning_t *tuning, lode_dq_t i_A) {
    return tuning->drop_V * lode_sqrt(i_A.d * i_A.d + i_A.q * i_A.q);
}

// (L1)
float lode_supply_current_A(const lode_supply_tuning_t *tuning, const lode_telemetry_t *telemetry) {
    if (!has_gates(telemetry) || !(telemetry->v_bus_V > 0.0f)) {
        return 0.0f;
    }
    const lode_dq_t i_A = telemetry->i_A;
    const lode_dq_t u_V = telemetry->u_V;
    const float motor_W = tuning->power_factor * (u_V.d * i_A.d + u_V.q * i_A.q);
    return (motor_W + drop_W(tuning, i_A)) / telemetry->v_bus_V;
}

// (L2), (L8): torque at which the supply's power is `power_W`, with the losses of the q axis. FLT_MAX: there is none, or it is
// left again within the torque of the moment or a share of `most_Nm`, as the winding then takes more than braking gives.
static float torque_at(const lode_supply_tuning_t *tuning, const lode_telemetry_t *telemetry,
                       float power_W, float sign, float most_Nm) {
    const float omega = lode_abs(telemetry->omega_rad_s) * tuning->inv_pole_pairs;
    const float active = lode_max(tuning->psi_Wb + tuning->salient_H * telemetry->i_A.d,
                                  FLUX_MIN_SHARE * tuning->psi_Wb);
    const float per_A = tuning->torque_factor * active;
    const float loss = tuning->power_factor * tuning->R_Ohm / (per_A * per_A);
    const float given_W = lode_max(power_W, 0.0f);
    const float square = omega * omega + sign * 4.0f * loss * given_W;
    if (square < 0.0f) {
        return FLT_MAX;
    }
    const float sum = omega + lode_sqrt(square);
    const float forward_A = telemetry->omega_rad_s < 0.0f ? -telemetry->i_A.q : telemetry->i_A.q;
    const float reached_Nm = lode_max(sign * per_A * forward_A, BEYOND_SHARE * most_Nm);
    if (sign < 0.0f && sum <= 2.0f * loss * reached_Nm) {
        return FLT_MAX;
    }
    return 2.0f * given_W / lode_max(sum, FLT_MIN);
}

// This limit determines the torque, and current control has settled.
static bool decides(const lode_supply_t *self, const lode_telemetry_t *telemetry, int side,
                    float sign) {
    const float power = sign * telemetry->torque_ref_Nm * telemetry->omega_rad_s;
    const float off_A = lode_abs(telemetry->ref_A.q - telemetry->i_A.q);
    return self->share[side] < 1.0f && telemetry->torque_limited && power > 0.0f &&
           off_A <= FOLLOWED_SHARE * lode_abs(telemetry->ref_A.q);
}

// (L3): change of the factor on the model's torque. The current is a measure where the limit decides, or is exceeded;
// otherwise the factor returns to 1. `torque_W`: power of the model's torque.
static float correction(float before, float error_W, float torque_W, bool known) {
    if (known || !(error_W >= 0.0f)) { // NaN: as if exceeded
        return error_W / lode_max(lode_max(torque_W, lode_abs(error_W)), FLT_MIN);
    }
    return 1.0f - before;
}

// (L4)
static float share_of(lode_supply_t *self, const lode_supply_tuning_t *tuning,
                      const lode_telemetry_t *telemetry, float i_A, float dt_s, int side) {
    const float limit_A = tuning->limit_A[side];
    if (limit_A >= FLT_MAX) {
        return 1.0f;
    }
    const float sign = side == LODE_SUPPLY_DRAWN ? 1.0f : -1.0f;
    const float id_A = telemetry->i_A.d;
    const float lost_W =
        tuning->power_factor * tuning->R_Ohm * id_A * id_A + drop_W(tuning, telemetry->i_A);
    const float power_W = telemetry->v_bus_V * limit_A - sign * lost_W;
    const float most_Nm =
        telemetry->torque_most_Nm > 0.0f ? telemetry->torque_most_Nm : tuning->most_Nm;
    const float torque_Nm = torque_at(tuning, telemetry, power_W, sign, most_Nm);
    const float torque_W = torque_Nm * lode_abs(telemetry->omega_rad_s) * tuning->inv_pole_pairs;
    const float error_W = telemetry->v_bus_V * (limit_A - sign * i_A);
    const float x = lode_one_minus_exp(dt_s / tuning->correct_s);
    const float before = self->factor[side];
    const float change =
        correction(before, error_W, torque_W, decides(self, telemetry, side, sign));
    const float factor =
        lode_clamp(before + x * change, 1.0f - CORRECTION_MAX, 1.0f + CORRECTION_MAX);
    self->factor[side] = factor;
    return lode_clamp(factor * torque_Nm / most_Nm, 0.0f, 1.0f);
}

lode_shares_t lode_supply_step(lode_supply_t *self, const lode_supply_tuning_t *tuning,
                               const lode_telemetry_t *telemetry, float i_A, float dt_s) {
    for (int side = 0; side < LODE_SUPPLY_SIDES; side++) {
        self->share[side] = share_of(self, tuning, telemetry, i_A, dt_s, side);
    }
    return (lode_shares_t){self->share[LODE_SUPPLY_DRAWN], self->share[LODE_SUPPLY_FED_BACK]};
}
