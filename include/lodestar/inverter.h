/// From a duty to the voltage at the motor: dead time, on-state drops, timer resolution, and the two periods
/// between the call that writes a duty and the call that sees its effect. docs/theory/inverter.md.
#ifndef LODESTAR_INVERTER_H
#define LODESTAR_INVERTER_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/motor.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Properties of the power stage. A field that is 0 gets its default from lode_inverter_design().
typedef struct {
    float v_bus_V; ///< nominal bus voltage, 1 .. 2000
    float i_max_A; ///< largest phase current amplitude that the drive may command
    /// time per edge for which both switches of a leg are off, including turn-on minus turn-off delay; 0: none
    float dead_time_s;
    /// on-state threshold of switch and diode: 0.7 to 1.5 for IGBTs, 0 for MOSFETs that take over from their body
    /// diodes
    float v_drop_V;
    float r_on_Ohm; ///< on-state slope; is added to the winding resistance
    /// phase current, at full modulation, below which the effect of dead time fades in proportion to the current,
    /// because the ripple reverses the current within the period. It falls with the modulation, as the ripple does.
    /// 0: v_bus Ts/(4 (Ld + Lq))
    float i_dead_A;
    float pwm_ticks;                    ///< timer steps from duty 0 to 1; 0: not quantised
    lode_choice_t dead_time_correction; ///< correct dead time in the duties; auto: on
    /// without that correction: subtract the lost voltage from the observer's voltage; auto: off
    lode_choice_t dead_time_model;
    /// time for which the low sides alone are on for a fifth of each period before all gates go on: charges
    /// bootstrap capacitors; 0: none
    float precharge_s;
    /// two control periods per carrier period. Each sees half of the edges, and so half of the dead-time loss.
    /// Requires current samples at the upper turning point too; auto: off
    lode_choice_t double_update;
} lode_inverter_config_t;

/// Carrier frequency, Hz: how often per second a leg loses its dead time. `f_step_Hz`: rate of the step, which is
/// twice the carrier frequency with double update.
static inline float lode_inverter_carrier_Hz(const lode_inverter_config_t *config,
                                             float f_step_Hz) {
    return config->double_update == LODE_ON ? 0.5f * f_step_Hz : f_step_Hz;
}

/// All that is derived from the configuration.
typedef struct {
    float v_min_V; ///< smallest bus voltage used as a divisor
    float
        dead_duty; ///< share of the period lost to dead time; 0 if it is neither corrected nor modelled
    float dead_more_max; ///< largest additional share that the start may measure; 0 likewise
    float v_drop_V;      ///< 0 likewise
    float i_dead_min_A;  ///< i_dead at no modulation
    float i_dead_span_A; ///< increase of i_dead up to full modulation
    float ticks;         ///< pwm_ticks; 0: not quantised
    float inv_ticks;
    /// voltage per bus volt up to which no duty can reach a rail; -1: the dead-time error is subtracted from the
    /// observer's voltage instead of being corrected in the duties
    float free;
    uint32_t precharge_periods; ///< duration of PRECHARGE, control periods
    uint_least16_t correct;     ///< 1: the dead-time error is corrected in the duties
    uint_least16_t grid;        ///< 1: duties are rounded to the timer's steps
} lode_inverter_tuning_t;

/// Duty that a phase loses at its current: proportional up to i_dead, constant beyond (I3), (I4).
typedef struct {
    float slope_A; ///< half of the lost duty per ampere below i_dead
    float i_dead_A;
} lode_dead_time_t;

/// State. Call k writes the duties that act over [t_k+1, t_k+2). The current sampled by call k+2 is the first one
/// on which they have acted in full.
typedef struct {
    lode_ab_t written[2]; ///< voltages per bus volt, written by even and by odd calls
    float v_bus_V;        ///< bus voltage at t_k
    float per_V;          ///< 1/v_bus, with v_bus at least v_min_V
    lode_dead_time_t dead_time;
#ifndef LODE_WITHOUT_START_MEASUREMENT
    /// measured share of the period lost beyond lode_inverter_tuning_t.dead_duty
    float dead_more;
    float r_more_Ohm; ///< measured resistance beyond the configured one
#endif
} lode_inverter_t;

/// Fills every zero field that has a default.
void lode_inverter_design(lode_inverter_config_t *config, const lode_motor_t *motor, float ts_s);

/// Checks the fields without a default, on which other defaults depend. A part of lode_inverter_tune().
lode_status_t lode_inverter_check_given(const lode_inverter_config_t *config);

/// Voltage that dead time plus 1.5 us, and drops, may take from a phase at the nominal bus, whether corrected or
/// not.
float lode_inverter_taken_V(const lode_inverter_config_t *config, float ts_s);

/// Checks a completed configuration and derives the tuning. `ts_s`: control period. On any error `tuning` is left
/// alone.
lode_status_t lode_inverter_tune(lode_inverter_tuning_t *tuning,
                                 const lode_inverter_config_t *config, float ts_s);

/// Reduces `free` by the rounding error of the dead-time correction at phase currents up to `i_A` (large compared
/// with i_dead).
void lode_inverter_bound_current(lode_inverter_tuning_t *tuning, float i_A);

/// Adds what was measured at the current `current_A` to the correction: the resistance `r_Ohm` that was not yet
/// accounted for, and the voltage `dead_V` along the current that does not depend on its amplitude (S13), (S14).
void lode_inverter_correct(lode_inverter_t *self, const lode_inverter_tuning_t *tuning, float r_Ohm,
                           float dead_V, float current_A);

/// Clears the state: no voltage has been written.
void lode_inverter_reset(lode_inverter_t *self);

#ifdef __cplusplus
}
#endif

#endif
