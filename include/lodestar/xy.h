/// Control of the xy currents of a dual three-phase winding, which make losses and no torque: to zero.
///
/// In the frame that turns with -theta, the 5th harmonic stands at +6 w and the 7th at -6 w: a PI
/// controller and one resonator at 6 w per axis hold both (X1).
#ifndef LODESTAR_XY_H
#define LODESTAR_XY_H

#include "lodestar/inverter.h"
#include "lodestar/pi.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float bandwidth_rad_s; ///< of the PI; 0: 0.1/Ts
    /// rate at which the resonators take up the harmonics; 0: a thirtieth of the bandwidth; LODE_NONE:
    /// none
    float resonance_rad_s;
    float voltage_share; ///< of v_bus/sqrt(3) that the plane may use, 0 .. 0.5; 0: 0.1
} lode_xy_config_t;

typedef struct {
    lode_pi_tuning_t pi;
    float bandwidth_rad_s;
    float corner_rad_s; ///< R/L
    float delay_s;      ///< from sample to the middle of the period in which the voltage acts
    float gain_Ohm_s;   ///< 2 L resonance Ts
    float omega6_max;   ///< of the resonance: beyond it the resonators stay out
    float circle;       ///< largest voltage per bus volt
} lode_xy_tuning_t;

/// What a resonator puts in at the present speed: gain per period, and lead over the loop's lag.
typedef struct {
    float gain_Ohm;
    lode_sincos_t lead;
} lode_xy_aim_t;

typedef struct {
    lode_pi_t x;
    lode_pi_t y;
    lode_ab_t resonance_x; ///< state of the x axis, V: turned by 6 w Ts in every period
    lode_ab_t resonance_y;
    lode_xy_aim_t aim;
} lode_xy_t;

void lode_xy_design(lode_xy_config_t *config, float ts_s);

/// `R_Ohm`, `L_H` of the plane: those of a phase, and its leakage inductance.
lode_status_t lode_xy_tune(lode_xy_tuning_t *tuning, const lode_xy_config_t *config, float R_Ohm,
                           float L_H, float ts_s);

void lode_xy_reset(lode_xy_t *self);

/// Follows the speed, now and then.
void lode_xy_adapt(lode_xy_t *self, const lode_xy_tuning_t *tuning, float omega_rad_s);

/// The angle 6 w Ts from half of w Ts.
LODE_INLINE lode_sincos_t lode_xy_turn(lode_sincos_t half_turn) {
    return lode_angle_double(lode_angle_double(lode_angle_triple(half_turn)));
}

/// One axis of a resonator: an undamped pair of poles at exp(+-j 6 w Ts), fed with the error (X2).
LODE_INLINE lode_ab_t lode_xy_resonate(lode_ab_t state, lode_sincos_t turn, float input_V) {
    return lode_ab_turn((lode_ab_t){state.alpha + input_V, state.beta}, turn);
}

/// Voltage against the current `i_A`, both in the frame that turns with -theta. `half_turn`: the angle
/// of half a period.
LODE_INLINE lode_ab_t lode_xy_step(lode_xy_t *self, const lode_xy_tuning_t *tuning, lode_ab_t i_A,
                                   lode_sincos_t half_turn, float v_bus_V) {
    const lode_sincos_t turn = lode_xy_turn(half_turn);
    const lode_sincos_t lead = self->aim.lead;
    const lode_ab_t rx = self->resonance_x;
    const lode_ab_t ry = self->resonance_y;
    const lode_ab_t asked = {
        lode_pi_output(&self->x, &tuning->pi, -i_A.alpha, rx.alpha * lead.cos - rx.beta * lead.sin),
        lode_pi_output(&self->y, &tuning->pi, -i_A.beta, ry.alpha * lead.cos - ry.beta * lead.sin)};
    const float radius = tuning->circle * v_bus_V;
    const float length2 = asked.alpha * asked.alpha + asked.beta * asked.beta;
    float gain = self->aim.gain_Ohm;
    float scale = 1.0f;
    if (length2 <= radius * radius) {
        lode_pi_integrate(&self->x, &tuning->pi, -i_A.alpha);
        lode_pi_integrate(&self->y, &tuning->pi, -i_A.beta);
    } else { // (X4) at the limit nothing is taken in
        gain = 0.0f;
        scale = radius / lode_max(lode_sqrt(length2), FLT_MIN);
    }
    self->resonance_x = lode_xy_resonate(rx, turn, -gain * i_A.alpha);
    self->resonance_y = lode_xy_resonate(ry, turn, -gain * i_A.beta);
    return lode_ab_scale(scale, asked);
}

#ifdef __cplusplus
}
#endif

#endif
