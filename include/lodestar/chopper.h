/// Brake chopper: a resistor across the bus burns what the supply does not take back. The duty of its switch
/// follows the bus voltage, and falls before the resistor is too hot. It knows nothing of the drive: a bus can be
/// too high with the gates off. For the PWM interrupt, or for a loop that is fast for the bus:
///
///     const float v_bus_V = (float)counts.v_bus * v_bus_gain_V_count;
///     board_write_chopper(lode_chopper_step(&chopper, &chopper_tuning, v_bus_V));
///
/// docs/reactions.md says how to choose its values, docs/theory/control.md has the equations.
#ifndef LODESTAR_CHOPPER_H
#define LODESTAR_CHOPPER_H

#include "lodestar/ramp.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float
        on_V; ///< bus voltage from which the resistor conducts, 1 .. 2000: above all that the mains make
    float full_V;  ///< from which it conducts all the time, above on_V: below the guard's limit
    float R_Ohm;   ///< 1e-3 .. 1e5
    float power_W; ///< what the resistor bears for ever, 1e-3 .. 1e7
    float
        thermal_s; ///< its thermal time constant, 1e-2 .. 1e5: ten times what it bears ten times power_W for
    float period_s; ///< between two calls of the step, 1e-6 .. 0.1
} lode_chopper_config_t;

typedef struct {
    float on_V;
    float inv_span;   ///< 1/V
    float load;       ///< 1/(R power), 1/V^2
    float weight;     ///< of one call in the heat
    lode_fade_t cool; ///< what the heat leaves of the duty beyond that which is borne for ever
} lode_chopper_tuning_t;

typedef struct {
    float heat; ///< of the resistor over its surroundings; 1: what power_W leads to
} lode_chopper_t;

/// LODE_ERROR_CHOPPER where a field is out of range; `tuning` is then left alone.
lode_status_t lode_chopper_tune(lode_chopper_tuning_t *tuning, const lode_chopper_config_t *config);

/// A cold resistor: `heat` 0. What is not known to be cold begins at 1.
void lode_chopper_reset(lode_chopper_t *self, float heat);

/// On-duty of the switch until the next call, 0 .. 1. A voltage that is no number: 0.
float lode_chopper_step(lode_chopper_t *self, const lode_chopper_tuning_t *tuning, float v_bus_V);

#ifdef __cplusplus
}
#endif

#endif
