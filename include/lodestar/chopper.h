/// Brake chopper: a resistor across the bus dissipates what the supply does not take back. The duty of its switch
/// follows the bus voltage, and is reduced before the resistor becomes too hot. It is independent of the drive,
/// because the bus voltage may be too high with the gates off as well. For the PWM interrupt, or a loop that is
/// fast compared with the bus voltage:
///
///     const float v_bus_V = (float)counts.v_bus * v_bus_gain_V_count;
///     board_write_chopper(lode_chopper_step(&chopper, &chopper_tuning, v_bus_V));
///
/// Choice of the values: docs/reactions.md. Equations (L5)-(L7): docs/theory/control.md.
#ifndef LODESTAR_CHOPPER_H
#define LODESTAR_CHOPPER_H

#include "lodestar/ramp.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Configuration of the chopper.
typedef struct {
    /// bus voltage above which the resistor conducts, 1 .. 2000; above the highest voltage of the supply
    float on_V;
    float full_V;  ///< bus voltage with full duty; above on_V and below the guard's limit
    float R_Ohm;   ///< 1e-3 .. 1e5
    float power_W; ///< continuous power rating of the resistor, 1e-3 .. 1e7
    /// thermal time constant of the resistor, 1e-2 .. 1e5: ten times the time for which it withstands ten times
    /// power_W
    float thermal_s;
    float period_s; ///< time between two calls of the step, 1e-6 .. 0.1
} lode_chopper_config_t;

/// All that is derived from the configuration.
typedef struct {
    float on_V;
    float inv_span;   ///< 1/(full_V - on_V), 1/V
    float load;       ///< 1/(R power), 1/V^2
    float weight;     ///< weight of one call in the heat (L6)
    lode_fade_t cool; ///< share of the duty beyond the continuous one, over the heat
} lode_chopper_tuning_t;

typedef struct {
    float heat; ///< temperature rise of the resistor; 1: that at power_W
    float rest; ///< of its last change, too small for a float of that size
} lode_chopper_t;

/// Checks `config` and derives the tuning. Errors: NULL, CHOPPER; `tuning` is then left alone.
lode_status_t lode_chopper_tune(lode_chopper_tuning_t *tuning, const lode_chopper_config_t *config);

/// `heat`: 0 for a cold resistor, 1 if its temperature is not known.
void lode_chopper_reset(lode_chopper_t *self, float heat);

/// On-duty of the switch until the next call, 0 .. 1 (L7). NaN as voltage gives 0.
float lode_chopper_step(lode_chopper_t *self, const lode_chopper_tuning_t *tuning, float v_bus_V);

#ifdef __cplusplus
}
#endif

#endif
