/// What lies between a duty and the voltage at the motor: dead time, on-state drops, the timer's
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
    /// on-state threshold of switch and diode: 0.7 to 1.5 for IGBTs; 0 for MOSFETs that take over from their body diodes
    float v_drop_V;
    float r_on_Ohm; ///< on-state slope: counts as winding resistance
    float i_dead_A; ///< below this phase current the effect of dead time fades in proportion: the
                    ///< ripple reverses the current within the period. At full modulation; it falls
                    ///< with the modulation, as the ripple does. 0: v_bus Ts/(4 (Ld + Lq))
    float pwm_ticks;                    ///< timer steps from duty 0 to 1; 0: not quantised
    lode_choice_t dead_time_correction; ///< correct in the duties; auto: where there is a dead time
    /// without the correction: subtract the loss from the observer's voltage; auto: off
    lode_choice_t dead_time_model;
    /// low sides only, for a fifth of each period, before all gates go on: charges bootstrap capacitors; 0: none
    float precharge_s;
    /// two calls in a carrier period, each of which sees half of its edges, and so half of the loss by dead time. Needs currents that are sensed at the upper turning point, too; auto: off
    lode_choice_t double_update;
} lode_inverter_config_t;

/// Carrier frequency, Hz: how often a second a leg loses its dead time. `f_step_Hz`: rate of the calls, twice that with
/// double update.
static inline float lode_inverter_carrier_Hz(const lode_inverter_config_t *config,
                                             float f_step_Hz) {
    return config->double_update == LODE_ON ? 0.5f * f_step_Hz : f_step_Hz;
}

typedef struct {
    float v_min_V;   ///< smallest bus voltage used as a divisor
    float dead_duty; ///< share of the period lost to dead time; this and the next 0: not looked at
    float dead_more_max; ///< of what may be measured beyond it
    float v_drop_V;
    float i_dead_min_A;  ///< at no modulation
    float i_dead_span_A; ///< added at full modulation
    float ticks;
    float inv_ticks;
    float
        free; ///< volts per bus volt up to which no duty can reach a rail; -1: the dead-time error is
              ///< taken out of the observer's voltage instead of being added
    uint32_t precharge_periods;
    uint_least16_t correct; ///< 1: the dead-time error is added to the duties
    uint_least16_t grid;    ///< 1: duties lie on the timer's steps
} lode_inverter_tuning_t;

/// The duty that a phase loses at its current: in proportion up to i_dead, constant beyond.
typedef struct {
    float slope_A; ///< half the duty lost per ampere below i_dead
    float i_dead_A;
} lode_dead_time_t;

/// The duties on their way. Call k writes what acts over [t_k+1, t_k+2); the current sampled by call
/// k+2 is the first that has seen it in full.
typedef struct {
    lode_ab_t written[2]; ///< volts per bus volt, by even and by odd calls
    float v_bus_V;        ///< bus voltage sampled at the start of the period under way
    float per_V;          ///< 1/v_bus
    lode_dead_time_t dead_time;
#ifndef LODE_WITHOUT_START_MEASUREMENT
    float
        dead_more; ///< share of the period lost beyond lode_inverter_tuning_t.dead_duty, as measured
    float r_more_Ohm; ///< resistance beyond the configured one, as measured
#endif
} lode_inverter_t;

/// Fills every zero field that has a default.
void lode_inverter_design(lode_inverter_config_t *config, const lode_motor_t *motor, float ts_s);

/// The fields without default, which others are designed from; part of lode_inverter_tune().
lode_status_t lode_inverter_check_given(const lode_inverter_config_t *config);

/// What dead time, with another 1.5 us of it, and drops may take of a phase at the nominal bus, corrected or not.
float lode_inverter_taken_V(const lode_inverter_config_t *config, float ts_s);

lode_status_t lode_inverter_tune(lode_inverter_tuning_t *tuning,
                                 const lode_inverter_config_t *config, float ts_s);

/// Takes of `free` what the dead-time error loses to rounding at phase currents up to `i_A`, which are
/// large beside i_dead.
void lode_inverter_bound_current(lode_inverter_tuning_t *tuning, float i_A);

/// Takes what has been measured at the current `current_A`, of what is not reckoned with yet: resistance, and
/// voltage along the current that does not depend on its length.
void lode_inverter_correct(lode_inverter_t *self, const lode_inverter_tuning_t *tuning, float r_Ohm,
                           float dead_V, float current_A);

/// No voltage on its way.
void lode_inverter_reset(lode_inverter_t *self);

#ifdef __cplusplus
}
#endif

#endif
