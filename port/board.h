/// The interface of a board to a drive: the functions that a port implements, one board per image.
///
/// Each contract says who calls the function and when. "Interrupt": from the handler of the period
/// only. "Thread": from main() only, which the interrupt may preempt.
///
/// The port's handler of the end of conversion clears its flag and calls app_period(), nothing else.
#ifndef LODESTAR_PORT_BOARD_H
#define LODESTAR_PORT_BOARD_H

#include "lodestar/lodestar.h"

/// Fills in the values of the board: f_pwm_Hz, inverter and sense. The application fills in the motor.
/// Thread, before board_init(). Touches no hardware.
void board_describe(lode_drive_config_t *config);

/// True if a watchdog has reset the chip, not power, reset pin or debugger. Thread, once, first of all.
bool board_reset_by_watchdog(void);

/// Clocks, serial port, PWM timer, ADC, comparator or break input. Leaves the gates off, the
/// interrupt masked, the trip path armed and the watchdog off. Thread, once. `i_trip_A`: amplitude of a phase
/// current at which the hardware shall switch off; a board that can set it uses it within its own limits.
/// False: the hardware does not respond as expected, and the gates must never go on; board_send() works as far
/// as possible.
bool board_init(float i_trip_A);

/// Starts PWM, ADC, interrupt and watchdog. The gates stay off. Thread, once.
void board_start(void);

/// The samples of the start of this period. Interrupt, first call. Must not wait for a conversion: the
/// interrupt comes when the last one is done. Reports as a trip what the board itself finds wrong: a break, a late
/// interrupt, compare registers that do not hold the values that board_write() wrote.
void board_read(lode_counts_t *counts);

/// Writes the compare values into the shadow registers, to act from the next period on; with LODE_GATES_OFF
/// switches all six switches off at once, before anything else. Interrupt, last call. Must not switch the gates
/// on while the trip is latched. LODE_GATES_LOW: low sides only, each in its share of the period around t_k; a
/// board that cannot do this switches all off, leaves inverter.precharge_s at 0, and start.pulses off. On and off may
/// alternate from one period to the next: the gates must follow within a period.
void board_write(const lode_drive_out_t *out);

/// Switches all six switches off at once. From anywhere, also from fault handlers and before board_init(). Must
/// need no interrupt and hardly any stack.
void board_gates_off(void);

/// Clears a latched hardware trip. Thread. False: its cause is still there.
bool board_clear_trip(void);

/// Switches the gates off and makes every comparator of the trip path act once, by moving its threshold
/// across the zero-current signal. Thread, without current. False: one of them does not reach the gates.
/// Also true if no threshold of the board can be moved: the trip source is then the driver.
bool board_test_trip(void);

/// Restarts the watchdog, whose time-out switches the gates off. Thread, and only after the period's
/// interrupt has come again: a stopped interrupt must starve it.
void board_feed_watchdog(void);

/// A free-running counter, which wraps; a period is guard.stamp_per_period of its counts. Preferably one that
/// keeps running while a debugger halts the core: otherwise the drive does not detect the halt. From anywhere.
uint32_t board_cycles(void);

/// Puts up to `count` octets (values 0 .. 255) into the transmitter; returns the number taken. Thread. Must not
/// wait.
uint32_t board_send(const uint16_t *octets, uint32_t count);

/// Part of the application (port/example/app.c): one period, from board_read() to board_write().
void app_period(void);

/// Part of the application: the motor's data, for a board that extrapolates samples to t_k. From board_init() on.
lode_motor_t app_motor(void);

/// Part of the application: the drive, for a board that derives three currents from one shunt and needs offset
/// and bus voltage. Interrupt, read only.
const lode_drive_t *app_drive(void);

#endif
