/// The functions that ti/board.c needs of a chip with TI's ePWM, ADC and comparators, and those that it offers.
#ifndef LODESTAR_PORT_TI_PARTS_H
#define LODESTAR_PORT_TI_PARTS_H

#include "lodestar/lodestar.h"

#define CHIP_PHASES 3u

/// Sets up the three ePWM, held off by their trip zones, which are armed and locked. Their clock is stopped.
/// False: period or dead time do not fit, or the ePWM do not respond (if that is detectable).
bool chip_pwm_init(void);
/// Starts their clock: all three start at zero with the same edge.
void chip_pwm_start(void);
/// All six outputs low at once, until chip_pwm_on().
void chip_pwm_off(void);
/// Outputs on, unless a trip is latched.
void chip_pwm_on(void);
/// True: from now on only output B of each switches, high around zero in the same share of the period; false:
/// both again. The trip zones must hold them low meanwhile.
void chip_pwm_low_sides_alone(bool alone);
/// Writes the shadows of the compare registers, which are loaded at the next zero, with double update at the
/// next turning point.
void chip_pwm_write(lode_abc_t duty);
/// True if the shadows of the compare registers hold what was written last.
bool chip_pwm_holds(void);
/// True if a trip is latched; chip_pwm_off() does not count as a trip.
bool chip_pwm_tripped(void);
/// Clears what chip_pwm_tripped() reads. The outputs stay off.
void chip_pwm_clear_trip(void);
/// True if the counter runs down, which it does from the upper turning point on.
bool chip_pwm_counts_down(void);

/// Sets up comparators, fault input and their routes to the trip zones, before those are armed.
void chip_protection_init(float i_trip_A);
/// Thresholds of one phase's comparators, in counts of their DACs.
void chip_comparator_set(uint32_t phase, uint16_t high, uint16_t low);

/// Sets up three ADCs: each converts a current on the same trigger; one then converts the bus, another one a
/// temperature if there is a sensor.
void chip_adc_init(void);
/// Result of the last period; phase 0 .. 2.
uint16_t chip_current(uint32_t phase);
uint16_t chip_bus(void);
/// Count of the temperature; 0 without a sensor.
uint16_t chip_temperature(void);
/// Lets the next result raise the interrupt again, also after a missed one. False: a period passed without its
/// interrupt.
bool chip_adc_acknowledge(void);

/// The gate driver's enable.
void chip_driver_set(bool on);

/// What no chip does: temperature, outputs. Before board_start().
void ti_init(void);
/// Sets the comparators' thresholds for a current of either sign, from the board's values.
void ti_set_trip(float i_trip_A);
/// Enables the gate driver and waits until it is awake.
void ti_driver_enable(void);
/// The work of the end-of-conversion handler.
void ti_period(void);

#endif
