// Control of the xy plane, one period.
#ifndef LODE_XY_INLINE_H
#define LODE_XY_INLINE_H

#include "lodestar/xy.h"
#include "pi_inline.h"

// One axis of a resonator: an undamped pole pair at exp(+-j 6 w Ts), fed with the error (X2).
LODE_INLINE lode_ab_t lode_xy_resonate(lode_ab_t state, lode_sincos_t step, float input_V) {
    return lode_ab_rotate((lode_ab_t){state.alpha + input_V, state.beta}, step);
}

// Voltage that opposes the current `i_A`, both in the frame that turns with -theta.
LODE_INLINE lode_ab_t lode_xy_step(lode_xy_t *self, const lode_xy_tuning_t *tuning, lode_ab_t i_A,
                                   float v_bus_V) {
    const lode_sincos_t step = self->aim.step;
    const lode_sincos_t lead = self->aim.lead;
    const lode_ab_t rx = self->resonance_x;
    const lode_ab_t ry = self->resonance_y;
    const lode_ab_t unlimited = {
        lode_pi_output(&self->x, &tuning->pi, -i_A.alpha, rx.alpha * lead.cos - rx.beta * lead.sin),
        lode_pi_output(&self->y, &tuning->pi, -i_A.beta, ry.alpha * lead.cos - ry.beta * lead.sin)};
    const float radius = tuning->circle * v_bus_V;
    const float length2 = unlimited.alpha * unlimited.alpha + unlimited.beta * unlimited.beta;
    float gain = self->aim.gain_Ohm;
    float scale = 1.0f;
    if (length2 <= radius * radius) {
        lode_pi_integrate(&self->x, &tuning->pi, -i_A.alpha);
        lode_pi_integrate(&self->y, &tuning->pi, -i_A.beta);
    } else { // (X4) at the limit nothing is integrated
        gain = 0.0f;
        scale = radius / lode_max(lode_sqrt(length2), FLT_MIN);
    }
    self->resonance_x = lode_xy_resonate(rx, step, -gain * i_A.alpha);
    self->resonance_y = lode_xy_resonate(ry, step, -gain * i_A.beta);
    return lode_ab_scale(scale, unlimited);
}

#endif
