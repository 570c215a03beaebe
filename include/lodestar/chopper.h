/// Brake chopper: a resistor across the bus dissipates what the supply does not take back. The duty of its switch
/// follows the bus voltage, and falls before the resistor is too hot. It is independent of the drive: a bus can be
/// too high with the gates off. For the PWM interrupt, or a loop that is fast compared with the bus voltage:
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
        on_V; ///< bus voltage from which the resistor conducts, 1 .. 2000: above the supply's highest
    float full_V;  ///< from which it conducts all the time, above on_V: below the guard's limit
    float R_Ohm;   ///< 1e-3 .. 1e5
    float power_W; ///< continuous power rating of the resistor, 1e-3 .. 1e7
    float
        thermal_s; ///< its thermal time constant, 1e-2 .. 1e5: ten times as long as it withstands ten times power_W
    float period_s; ///< between two calls of the step, 1e-6 .. 0.1
} lode_chopper_config_t;

typedef struct {
    float on_V;
    float inv_span;   ///< 1/V
    float load;       ///< 1/(R power), 1/V^2
    float weight;     ///< of one call in the heat
    lode_fade_t cool; ///< how much of the duty above the continuous one the heat allows
} lode_chopper_tuning_t;

typedef struct {
    float heat; ///< temperature rise of the resistor; 1: that of power_W
} lode_chopper_t;

/// LODE_ERROR_CHOPPER where a field is out of range; `tuning` is then unchanged.
lode_status_t lode_chopper_tune(lode_chopper_tuning_t *tuning, const lode_chopper_config_t *config);

/// `heat`: 0 for a cold resistor; 1 where it is not known to be cold.
void lode_chopper_reset(lode_chopper_t *self, float heat);

/// On-duty of the switch until the next call, 0 .. 1. A voltage that is not a number: 0.
float lode_chopper_step(lode_chopper_t *self, const lode_chopper_tuning_t *tuning, float v_bus_V);

#ifdef __cplusplus
}
#endif

#endif
