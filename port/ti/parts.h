/// What ti/board.c needs of a chip with TI's ePWM, ADC and comparators, and what it offers.
#ifndef LODESTAR_PORT_TI_PARTS_H
#define LODESTAR_PORT_TI_PARTS_H

#include "lodestar/lodestar.h"

#define CHIP_PHASES 3u

/// The three ePWM, held off by their trip zones, which are armed and locked. Their clock stands still.
/// False: period or dead time do not fit, or the ePWM do not answer where that can be seen.
bool chip_pwm_init(void);
/// Their clock: all three start at zero with the same edge.
void chip_pwm_start(void);
/// All six outputs low at once, until chip_pwm_on().
void chip_pwm_off(void);
/// Outputs on, unless a trip is latched.
void chip_pwm_on(void);
/// From now on only output B of each, high around zero in the same share of the period; false: both again. The
/// trip zones must hold them low meanwhile.
void chip_pwm_low_sides_alone(bool alone);
/// Into the compare registers' shadows, taken over at the next zero, with double update at the next turning point.
void chip_pwm_write(lode_abc_t duty);
/// A trip has come and not been cleared; chip_pwm_off() is none.
bool chip_pwm_tripped(void);
/// Clears what chip_pwm_tripped() reads. The outputs stay off.
void chip_pwm_clear_trip(void);
/// The counter runs down: from the upper turning point on.
bool chip_pwm_counts_down(void);

/// Comparators, fault input and their ways to the trip zones: before those are armed.
void chip_protection_init(float i_trip_A);
/// Thresholds of one phase's comparators, in counts of their DACs.
void chip_comparator_set(uint32_t phase, uint16_t high, uint16_t low);

/// Three ADCs: a current each on the same trigger, the bus after one of them, a temperature, where there
/// is one, after another.
void chip_converters_init(void);
/// Result of the last period; phase 0 .. 2.
uint16_t chip_current(uint32_t phase);
uint16_t chip_bus(void);
/// 0 without a sensor.
uint16_t chip_temperature(void);
/// Before the next result may raise the interrupt again; after a missed one too. False: a period has gone
/// by without its interrupt.
bool chip_converters_acknowledge(void);

/// The gate driver's enable.
void chip_driver_set(bool on);

/// What no chip does: temperature, outputs. Before board_start().
void ti_init(void);
/// Sets the comparators' thresholds for a current of either sign, by the board's figures.
void ti_set_trip(float i_trip_A);
/// Enables the gate driver and waits until it is awake.
void ti_driver_enable(void);
/// What the handler of the end of conversion does.
void ti_period(void);

#endif
