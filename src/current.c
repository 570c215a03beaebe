#include "current_inline.h"

// Crossover of the loop over 1/Ts: 1.5 periods of delay leave 73 degrees of phase margin.
#define BANDWIDTH_TS 0.2f
#define BANDWIDTH_TS_MAX 0.4f // phase margin 56 degrees
#define GAIN_MARGIN 2.0f
#define VOLTAGE_USE_MAX 1.1547f // 2/sqrt(3): the corners of the hexagon
#define D_SHARE 0.9f            // leaves the q axis 44 % of the circle
// At the limits of current and voltage nearly all flux may be on the q axis, which is voltage on the d axis. With 0.9 of the
// circle a motor with an MTPV range lost control of id on the way into that range.
#define D_SHARE_WEAKENED 0.97f
#define Q_MOST                                                                                     \
    0.9f // closer to the edge, the voltage left for d changes too fast with the EMF (K32)
#define Q_SHARE 0.1f        // left for the q axis to control its current while braking (K32)
#define INTEGRAL_MOST 1.25f // of the circle (K52)

void lode_current_design(lode_current_config_t *config, const lode_motor_t *motor, float ts_s) {
    config->bandwidth_rad_s = lode_given_or(config->bandwidth_rad_s, BANDWIDTH_TS / ts_s);
    // Pole-zero cancellation: the zero of the controller at R/L.
    const float bandwidth = config->bandwidth_rad_s;
    config->kp_d_V_A = lode_given_or(config->kp_d_V_A, bandwidth * motor->Ld_H);
    config->kp_q_V_A = lode_given_or(config->kp_q_V_A, bandwidth * motor->Lq_H);
    config->ki_d_V_As = lode_given_or(config->ki_d_V_As, bandwidth * motor->Rs_Ohm);
    config->ki_q_V_As = lode_given_or(config->ki_q_V_As, bandwidth * motor->Rs_Ohm);
    config->voltage_use = lode_given_or(config->voltage_use, LODE_VOLTAGE_USE);
}

// (K4): Jury's conditions on z^3 + c2 z^2 + c1 z + c0 = (z - a) z (z - 1) + b (kp (z - 1) + ki Ts): the R-L circuit held over
// the period, the voltage one period late. With 0 < a <= 1 and kp > 0 the conditions on c0 alone and at -1 follow from the last
// one.
static bool is_stable(float kp, float ki_Ts, float R, float L, float ts_s) {
    const float rise = lode_one_minus_exp(R * ts_s / L);
    const float b = rise > 0.0f ? rise / R : ts_s / L;
    const float c2 = rise - 2.0f;
    const float c1 = 1.0f - rise + b * kp;
    const float c0 = b * (ki_Ts - kp);
    return ki_Ts >= 0.0f && 1.0f - c0 * c0 > lode_abs(c0 * c2 - c1);
}

static bool is_sound(float kp, float ki, float R, float L, float ts_s) {
    return lode_in_range(kp, 1.0e-6f, 1.001f * BANDWIDTH_TS_MAX * L / ts_s) &&
           is_stable(GAIN_MARGIN * kp, GAIN_MARGIN * ki * ts_s, R, L, ts_s);
}

lode_status_t lode_current_tune(lode_current_tuning_t *tuning, const lode_current_config_t *config,
                                const lode_motor_t *motor, float ts_s) {
    if (!lode_in_range(config->bandwidth_rad_s, 1.0f, BANDWIDTH_TS_MAX / ts_s)) {
        return LODE_ERROR_CURRENT_BANDWIDTH;
    }
    if (!is_sound(config->kp_d_V_A, config->ki_d_V_As, motor->Rs_Ohm, motor->Ld_H, ts_s) ||
        !is_sound(config->kp_q_V_A, config->ki_q_V_As, motor->Rs_Ohm, motor->Lq_H, ts_s)) {
        return LODE_ERROR_CURRENT_GAINS;
    }
    if (!lode_in_range(config->voltage_use, 0.1f, VOLTAGE_USE_MAX)) {
        return LODE_ERROR_CURRENT_VOLTAGE;
    }
    *tuning = (lode_current_tuning_t){
        .d = {config->kp_d_V_A, config->ki_d_V_As * ts_s},
        .q = {config->kp_q_V_A, config->ki_q_V_As * ts_s},
        .circle = config->voltage_use / LODE_SQRT3,
        .free = D_SHARE * lode_min(config->voltage_use, 1.0f) / LODE_SQRT3,
    };
    return LODE_OK;
}

void lode_current_take(lode_current_t *self, const lode_current_tuning_t *tuning, float Lq_H) {
    lode_current_renew(self, tuning, Lq_H);
}

void lode_current_saturate(lode_current_t *self, const lode_current_tuning_t *tuning, float Lq_H,
                           float fall, float iq_A, float ref_A) {
    const float at = lode_max(1.0f + fall * lode_abs(iq_A), 1.0f); // 1 also if the current is NaN
    const float to = lode_max(1.0f + fall * lode_abs(ref_A), 1.0f);
    const float both = 1.0f / (at * to); // (K20), (K21)
    const float larger = both * lode_min(at, to);
    self->kp_q_V_A = tuning->q.kp * (iq_A * ref_A < 0.0f ? larger : both);
    self->Lq_H = Lq_H * larger;
}

void lode_current_reset(lode_current_t *self, lode_dq_t u_V, lode_dq_t induced_V) {
    lode_pi_reset(&self->d, u_V.d - induced_V.d);
    lode_pi_reset(&self->q, u_V.q - induced_V.q);
}

// Voltage that `other_V` on the other axis leaves of the circle.
static float left_V(float radius_V, float other_V) {
    return lode_sqrt(lode_max(radius_V * radius_V - other_V * other_V, 0.0f));
}

// What the controller asks for, without an integral that the circle cannot explain (K52). NaN stays: the guard sees it.
static float asked_V(lode_pi_t *self, const lode_pi_tuning_t *tuning, float error_A,
                     float induced_V, float radius_V) {
    if (lode_abs(self->integral) > INTEGRAL_MOST * radius_V) {
        lode_pi_reset(self, 0.0f);
    }
    return lode_pi_output(self, tuning, error_A, induced_V);
}

// Not LODE_RAMFUNC: only with the voltage used up, and small fast memories have no room for it.
LODE_NOINLINE lode_dq_t lode_current_limit(lode_current_t *self,
                                           const lode_current_tuning_t *tuning,
                                           const lode_current_case_t *at) {
    const lode_pi_tuning_t q = {self->kp_q_V_A, tuning->q.ki_Ts};
    const float radius_V = lode_max(at->radius_V, 0.0f);
    const lode_dq_t asked = {
        asked_V(&self->d, &tuning->d, at->error_A.d, at->induced_V.d, radius_V),
        asked_V(&self->q, &q, at->error_A.q, at->induced_V.q, radius_V)};
    // d first: it holds the flux. When braking, it leaves q the EMF and some more (K32).
    const bool weakens = tuning->weakens != 0u;
    const float d_share_V = radius_V * (weakens ? D_SHARE_WEAKENED : D_SHARE);
    float d_max_V = d_share_V;
    if (!weakens && at->induced_V.d > 0.0f) {
        const float q_V =
            lode_min(lode_abs(at->induced_V.q) + Q_SHARE * radius_V, Q_MOST * radius_V);
        d_max_V = lode_min(d_max_V, left_V(radius_V, q_V));
    }
    const float ud_V = lode_clamp(asked.d, -d_share_V, d_max_V);
    const float q_max_V = left_V(radius_V, ud_V);
    const lode_dq_t u_V = {ud_V, lode_clamp(asked.q, -q_max_V, q_max_V)};
    lode_pi_settle(&self->d, &tuning->d, at->error_A.d, at->induced_V.d, asked.d, u_V.d);
    lode_pi_settle(&self->q, &q, at->error_A.q, at->induced_V.q, asked.q, u_V.q);
    return u_V;
}
