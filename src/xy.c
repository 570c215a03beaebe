#include "lodestar/xy.h"

#include "pi_inline.h"
#include "scalar_inline.h"

// Crossover over 1/Ts: half of the dq plane's, because the leakage inductance is known less well.
#define BANDWIDTH_TS 0.1f
#define BANDWIDTH_TS_MAX 0.4f
// The resonators are slow compared with their loop.
#define RESONANCE_SHARE (1.0f / 30.0f)
#define RESONANCE_SHARE_MAX 0.25f
// Enough for 6 % of 5th and 7th harmonic each, at the speed at which the EMF takes 80 % of the circle.
#define VOLTAGE_SHARE 0.1f
// Largest 6 w Ts for a resonator: a quarter of the sampling rate.
#define TURN_MAX_rad 1.57f
// Largest R/(L 6 w), at low speed, to which the resonators' lead follows the PI's integrator.
#define CORNER_MAX 4.0f

void lode_xy_design(lode_xy_config_t *config, float ts_s) {
    config->bandwidth_rad_s = lode_given_or(config->bandwidth_rad_s, BANDWIDTH_TS / ts_s);
    config->resonance_rad_s =
        lode_given_or(config->resonance_rad_s, RESONANCE_SHARE * config->bandwidth_rad_s);
    config->voltage_share = lode_given_or(config->voltage_share, VOLTAGE_SHARE);
}

lode_status_t lode_xy_tune(lode_xy_tuning_t *tuning, const lode_xy_config_t *config, float R_Ohm,
                           float L_H, float ts_s) {
    if (!lode_in_range(L_H, 1.0e-7f, 10.0f)) {
        return LODE_ERROR_XY_INDUCTANCE;
    }
    if (!lode_in_range(config->bandwidth_rad_s, 1.0f, BANDWIDTH_TS_MAX / ts_s) ||
        !lode_is_none_or_in(config->resonance_rad_s, 0.0f,
                            RESONANCE_SHARE_MAX * config->bandwidth_rad_s)) {
        return LODE_ERROR_XY_BANDWIDTH;
    }
    if (!lode_in_range(config->voltage_share, 0.0f, 0.5f)) {
        return LODE_ERROR_XY_VOLTAGE;
    }
    *tuning = (lode_xy_tuning_t){
        .pi = {config->bandwidth_rad_s * L_H, config->bandwidth_rad_s * R_Ohm * ts_s},
        .bandwidth_rad_s = config->bandwidth_rad_s,
        .corner_rad_s = R_Ohm / L_H,
        .ts_s = ts_s,
        .gain_Ohm_s = 2.0f * L_H * lode_max(config->resonance_rad_s, 0.0f) * ts_s,
        .omega6_max = TURN_MAX_rad / ts_s,
        .circle = config->voltage_share / LODE_SQRT3,
    };
    return LODE_OK;
}

void lode_xy_reset(lode_xy_t *self) {
    *self = (lode_xy_t){.aim.gain_Ohm = 0.0f}; // the first adaptation places the resonators
}

LODE_RAMFUNC void lode_xy_adapt(lode_xy_t *self, const lode_xy_tuning_t *tuning,
                                float omega_rad_s) {
    const float size = lode_max(6.0f * lode_abs(omega_rad_s), 1.0f);
    if (!(size <= tuning->omega6_max)) {
        const lode_ab_t none = {0.0f, 0.0f};
        self->aim.gain_Ohm = 0.0f;
        self->resonance_x = self->resonance_y = none;
        return;
    }
    const float sign = lode_sign(omega_rad_s);
    const float omega6 = sign * size;
    const lode_sincos_t half = lode_sincos_octant(0.5f * omega6 * tuning->ts_s);
    self->aim.step = lode_angle_double(half);
    // The PI loop responds to a voltage at 6 w with the current 1/(L d), d below. So the resonator leads by the angle of d, and
    // its gain keeps the convergence rate (X3). The voltage is late by 1.5 periods.
    const lode_sincos_t late = lode_angle_add(self->aim.step, half);
    const lode_ab_t loop = {tuning->bandwidth_rad_s - omega6 * late.sin, omega6 * late.cos};
    // d = (1 - j r) loop with r = corner/omega6, here times `w`, so that one division is enough.
    const float corner = sign * tuning->corner_rad_s;
    const float w = lode_max(size, tuning->corner_rad_s * (1.0f / CORNER_MAX));
    const lode_ab_t d = {w * loop.alpha + corner * loop.beta, w * loop.beta - corner * loop.alpha};
    const float length = lode_max(lode_ab_length(d), FLT_MIN);
    const float inv = 1.0f / (w * length);
    self->aim.gain_Ohm = tuning->gain_Ohm_s * length * (length * inv);
    self->aim.lead = (lode_sincos_t){d.beta * (w * inv), d.alpha * (w * inv)};
}
