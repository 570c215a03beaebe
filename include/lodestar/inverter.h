/// What stands between a duty and the voltage at the motor: dead time, on-state drops, the timer's
/// grid, and the two periods from the call that writes a duty to the call that sees its effect.
#ifndef LODESTAR_INVERTER_H
#define LODESTAR_INVERTER_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/motor.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float v_bus_V; ///< nominal bus voltage, 1 .. 2000
    float i_max_A; ///< highest amplitude of the phase current that the drive may command
    /// both switches of a leg off, per edge; turn-on minus turn-off delay included
    float dead_time_s;
    float v_drop_V; ///< on-state threshold of switch and diode
    float r_on_Ohm; ///< on-state slope: counts as winding resistance
    float i_dead_A; ///< below this phase current the effect of dead time fades, proportionally: the
                    ///< ripple reverses the current within the period. At full modulation; it falls
                    ///< with the modulation, as the ripple does. 0: v_bus Ts/(4 (Ld + Lq))
    float pwm_ticks;                    ///< timer steps from duty 0 to 1; 0: not quantised
    lode_choice_t dead_time_correction; ///< correct in the duties; auto: where there is a dead time
    /// without the correction: take the loss out of the observer's voltage; auto: no
    lode_choice_t dead_time_model;
} lode_inverter_config_t;

typedef struct {
    float ts_s;
    float v_min_V;   ///< least bus voltage that is divided by
    float dead_duty; ///< share of the period lost to dead time
    float v_drop_V;
    float i_dead_min_A;  ///< at no modulation
    float i_dead_span_A; ///< added at full modulation
    float ticks;         ///< 0: not quantised
    float inv_ticks;
    float v2_free; ///< (volts per bus volt)^2 up to which no duty can reach a rail; -1: none
    bool correct;  ///< loss added to the duties
    bool model;    ///< loss taken out of the observer's voltage instead
    bool plain;    ///< no timer's grid and no model: up to v2_free the voltage is what was asked
} lode_inverter_tuning_t;

typedef struct {
    float half_per_A; ///< half the duty lost per ampere below i_dead
    float i_dead_A;
} lode_loss_t;

/// The duties on their way. Call k writes what acts over [t_k+1, t_k+2); the current sampled by call
/// k+2 is the first that has seen it in full.
typedef struct {
    lode_ab_t written; ///< by the last call, volts per bus volt
    lode_ab_t acting;  ///< by the call before it: this acts until the next sample
    float v_bus_V;     ///< bus voltage sampled at the start of the period under way
    lode_loss_t loss;
} lode_inverter_t;

/// Fills every zero field that has a default.
void lode_inverter_design(lode_inverter_config_t *config, const lode_motor_t *motor, float ts_s);

/// The fields without default, which others are designed from; part of lode_inverter_tune().
lode_status_t lode_inverter_check_given(const lode_inverter_config_t *config);

lode_status_t lode_inverter_tune(lode_inverter_tuning_t *tuning,
                                 const lode_inverter_config_t *config, float ts_s);

/// No voltage on its way.
void lode_inverter_reset(lode_inverter_t *self);

/// Called at t_k before anything is written: the mean voltage over [t_k-1, t_k), V, from the duty
/// written by call k-2 and the bus sampled at t_k-1. Takes in the bus voltage sampled now.
LODE_INLINE lode_ab_t lode_inverter_realised(lode_inverter_t *self, float v_bus_V) {
    const lode_ab_t u_V = lode_ab_scale(self->v_bus_V, self->acting);
    self->acting = self->written;
    self->v_bus_V = v_bus_V;
    return u_V;
}

/// Notes what call k has written.
static inline void lode_inverter_write(lode_inverter_t *self, lode_ab_t realised) {
    self->written = realised;
}

/// How the loss follows the current at a modulation and bus voltage: `span`: largest less smallest
/// duty, 0 .. 1. Both move slowly.
static inline lode_loss_t lode_inverter_shape(const lode_inverter_tuning_t *tuning, float span,
                                              float inv_v_bus) {
    const float i_dead = tuning->i_dead_min_A + tuning->i_dead_span_A * span;
    return (lode_loss_t){0.5f * (tuning->dead_duty + tuning->v_drop_V * inv_v_bus) / i_dead,
                         i_dead};
}

/// Loss of duty in a phase at the current `i_A`: dead time and drops. Proportional to the current up to
/// i_dead, constant beyond: |i + i_dead| - |i - i_dead| is twice the clamped current.
LODE_INLINE float lode_inverter_loss(lode_loss_t shape, float i_A) {
    return shape.half_per_A * (lode_abs(i_A + shape.i_dead_A) - lode_abs(i_A - shape.i_dead_A));
}

/// Follows the modulation by the voltage `u_V` at the bus `v_bus_V`.
void lode_inverter_adapt(lode_inverter_t *self, const lode_inverter_tuning_t *tuning, lode_dq_t u_V,
                         float v_bus_V);

#ifdef __cplusplus
}
#endif

#endif
