// The voltage that acted, and the duty lost to dead time and drops.
#ifndef LODE_INVERTER_INLINE_H
#define LODE_INVERTER_INLINE_H

#include "lodestar/inverter.h"

// After a larger relative change of the bus voltage within a period, 1/v_bus is divided anew.
#define LODE_BUS_STEP_MAX 0.25f

// Voltage along the current vector, averaged over its directions, per volt that each phase loses.
#define FOUR_PER_PI (4.0f / LODE_PI)
#define DEAD_PER_PHASE (4.0f / 3.0f) // voltage along a phase axis per volt that each phase loses

// Call at t_k before lode_inverter_follow_bus() and _write(): the mean voltage over [t_k-1, t_k), V, from the duty that call
// k-2 wrote (same parity) and the bus sampled at t_k-1 (C7).
LODE_INLINE lode_ab_t lode_inverter_realised(const lode_inverter_t *self, uint32_t call) {
    return lode_ab_scale(self->v_bus_V, self->written[call % 2u]);
}

// `u_V` minus the drop across the resistance that exceeds the configured one. `i_A`: at t_k-1.
LODE_INLINE lode_ab_t lode_inverter_less_drop(const lode_inverter_t *self, lode_ab_t u_V,
                                              lode_ab_t i_A) {
#ifdef LODE_WITHOUT_START_MEASUREMENT
    (void)self;
    (void)i_A;
    return u_V;
#else
    return lode_ab_add_scaled(u_V, -self->r_more_Ohm, i_A);
#endif
}

LODE_INLINE void lode_inverter_divide(lode_inverter_t *self, const lode_inverter_tuning_t *tuning) {
    self->per_V = 1.0f / lode_max(self->v_bus_V, tuning->v_min_V);
}

// Takes the bus voltage sampled now. Its reciprocal follows by one Newton step, whose error is the square of the relative
// change: 0.01 % after 1 %.
LODE_INLINE void lode_inverter_follow_bus(lode_inverter_t *self,
                                          const lode_inverter_tuning_t *tuning, float v_bus_V) {
    const float off = 1.0f - v_bus_V * self->per_V;
    self->v_bus_V = v_bus_V;
    self->per_V += self->per_V * off;
    if (!(lode_abs(off) <= LODE_BUS_STEP_MAX)) {
        lode_inverter_divide(self, tuning);
    }
}

// Notes the voltage that call k has written, per bus volt.
LODE_INLINE void lode_inverter_write(lode_inverter_t *self, uint32_t call, lode_ab_t realised) {
    self->written[call % 2u] = realised;
}

// Course of the dead-time error over the current at a modulation `span`, largest less smallest duty, 0 .. 1 (I4). Both change
// slowly.
LODE_INLINE lode_dead_time_t lode_inverter_dead_time(const lode_inverter_tuning_t *tuning,
                                                     float dead_more, float span, float per_V) {
    const float i_dead = tuning->i_dead_min_A + tuning->i_dead_span_A * span;
    return (lode_dead_time_t){
        0.5f * (tuning->dead_duty + dead_more + tuning->v_drop_V * per_V) / i_dead, i_dead};
}

// Duty that a phase loses at the current `i_A` (I3): |i + i_dead| - |i - i_dead| is twice the current clamped to i_dead.
LODE_INLINE float lode_inverter_error(const lode_dead_time_t *dead_time, float i_A) {
    return dead_time->slope_A *
           (lode_abs(i_A + dead_time->i_dead_A) - lode_abs(i_A - dead_time->i_dead_A));
}

#ifndef LODE_WITHOUT_START_MEASUREMENT

// Beyond this multiple of the configured resistance no start takes over a measured one, nor a new tuning what is left of it.
#define LODE_R_MORE_MAX 2.0f

// What a start has measured is within its limits. NaN is not. `R_Ohm`: configured resistance.
LODE_INLINE bool lode_inverter_is_sound(const lode_inverter_t *self,
                                        const lode_inverter_tuning_t *tuning, float R_Ohm) {
    return lode_abs(self->dead_more) <= tuning->dead_more_max &&
           lode_abs(self->r_more_Ohm) <= LODE_R_MORE_MAX * R_Ohm;
}

#endif

// Adapts to the modulation of the voltage `u_V`, and divides by the bus voltage anew. Once in LODE_SLOW_PERIODS.
LODE_SHARED void lode_inverter_adapt(lode_inverter_t *self, const lode_inverter_tuning_t *tuning,
                                     lode_dq_t u_V) {
    lode_inverter_divide(self, tuning);
    // largest less smallest duty: at most sqrt(3) times the amplitude
    const float u = lode_sqrt(u_V.d * u_V.d + u_V.q * u_V.q);
    const float span = lode_clamp(LODE_SQRT3 * u * self->per_V, 0.0f, 1.0f);
#ifdef LODE_WITHOUT_START_MEASUREMENT
    const float dead_more = 0.0f;
#else
    const float dead_more = self->dead_more;
#endif
    self->dead_time = lode_inverter_dead_time(tuning, dead_more, span, self->per_V);
}

#endif
