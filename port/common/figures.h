/// Calculations for a three-phase PWM with low-side shunts, for any chip. Accesses no hardware.
///
/// The timer counts up and down. The low side of a phase is on for (1 - duty)/2 of the period before t_k
/// and as long after it.
#ifndef LODESTAR_PORT_COMMON_FIGURES_H
#define LODESTAR_PORT_COMMON_FIGURES_H

#include "lodestar/lodestar.h"

/// Timer steps from duty 0 to 1; 0 if they do not fit in 16 bits.
uint32_t port_pwm_steps(uint32_t f_timer_Hz, uint32_t f_pwm_Hz);

/// Largest duty with which a low-side shunt can still be sampled. `settle_ns`: from the low side's
/// turn-on to a settled amplifier, dead time included. `sample_ns`: from t_k to the end of the last
/// current's sampling.
float port_duty_max(float f_pwm_Hz, float settle_ns, float sample_ns);

/// How a board measures its phase currents: docs/porting.md, "Sensing".
typedef enum {
    PORT_LOW_SIDE_THREE, ///< shunts in series with all three low sides
    PORT_LOW_SIDE_TWO,   ///< in series with the low sides of a and b
    PORT_IN_LINE_THREE,  ///< in the phases themselves: measured in any switching state
    PORT_IN_LINE_TWO,    ///< in a and b
    PORT_LINK_ONE        ///< one in the DC link
} port_sensing_t;

/// Fills in `sense.shunts`, `sense.duty_max` and `current.voltage_use`; inverter and f_pwm_Hz must be set.
/// `settle_ns`, `sample_ns`: as below, unused with in-line shunts.
void port_sensing(lode_drive_config_t *config, port_sensing_t sensing, float settle_ns,
                  float sample_ns);

/// One shunt in the DC link of a drive; `settle_ns` from any edge on.
lode_single_shunt_config_t port_link_config(const lode_drive_config_t *config, float settle_ns,
                                            float sample_ns, float L_H);

/// A trip threshold between the minimum for the offsets and the maximum of board and amplifier.
float port_trip_A(float wanted_A, float least_A, float most_A);

/// Largest share of the voltage circle with which the second largest duty stays at or below `duty_max`,
/// so that two phases can be sampled at any angle; at most the default of the library; 0 if there is none.
/// Subtract from `duty_max` what the dead-time correction may add to a duty.
float port_voltage_use(float duty_max);

#endif
