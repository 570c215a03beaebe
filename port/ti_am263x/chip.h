/// The parts of the AM263x that board.c puts together.
#ifndef LODESTAR_PORT_TI_AM263X_CHIP_H
#define LODESTAR_PORT_TI_AM263X_CHIP_H

#include "am263x.h"
#include "figures.h"
#include "reg.h"

#ifndef TI_BOARD_H
#define TI_BOARD_H "boards/generic_am263x.h"
#endif
#include TI_BOARD_H

/// What the boot loader has set up: core and CONTROLSS.
#define CHIP_F_CPU_Hz 400000000u
#define CHIP_F_PWM_Hz 200000000u
#define CHIP_PHASES 3u

/// Converters' clock 50 MHz. Window 140 ns.
#define CHIP_WINDOW_cycles 28u
/// Until the end of the currents' sampling: some cycles from the trigger, then the window.
#define CHIP_SAMPLE_ns 200.0f

/// At least so long, by the core's counter.
void chip_wait_us(uint32_t us);

/// The three ePWM, held off by their trip zones, which are armed and locked. Their clock stands still.
/// False: period or dead time do not fit, or the ePWM do not answer (clock gated, no access).
bool chip_pwm_init(void);
/// Their clock: all three start at zero with the same edge.
void chip_pwm_start(void);
/// All six outputs low at once, until chip_pwm_on().
void chip_pwm_off(void);
/// Outputs on, unless a trip is latched.
void chip_pwm_on(void);
/// Into the compare registers' shadows, taken over at the next zero.
void chip_pwm_write(lode_abc_t duty);
/// A trip has come and not been cleared; chip_pwm_off() is none.
bool chip_pwm_tripped(void);
/// Clears what chip_pwm_tripped() reads. The outputs stay off.
void chip_pwm_clear_trip(void);
/// The counter runs down: the interrupt comes half a period late, or the trigger sits at the wrong end.
bool chip_pwm_counts_down(void);

/// Comparators, fault input and their ways through the crossbars: before the trip zones are armed.
void chip_protection_init(void);

/// Three converters: a current each on the same trigger, the bus after one of them.
void chip_converters_init(void);
/// Result of the last period; phase 0 .. 2.
uint16_t chip_current(uint32_t phase);
uint16_t chip_bus(void);
/// Before the next result may raise the interrupt again; after a missed one too. False: a period has gone
/// by without its interrupt.
bool chip_converters_acknowledge(void);

#endif
