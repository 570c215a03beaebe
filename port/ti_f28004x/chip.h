/// The parts of the F28004x that board.c puts together. TI's driverlib does every access.
#ifndef LODESTAR_PORT_TI_F28004X_CHIP_H
#define LODESTAR_PORT_TI_F28004X_CHIP_H

#include "device.h"
#include "driverlib.h"
#include "figures.h"

#ifndef TI_BOARD_H
#define TI_BOARD_H "boards/launchxl_f280049c_drv8320rs.h"
#endif
#include TI_BOARD_H

#define CHIP_F_CPU_Hz 100000000u
#define CHIP_PHASES 3u

/// ADC clock 50 MHz. The window is twice the 75 ns that the converter needs: the amplifier drives it.
#define CHIP_WINDOW_cycles 20u
/// Until the end of the currents' sampling: some cycles from the trigger, then the window.
#define CHIP_SAMPLE_ns 250.0f

/// SysCtl_delay() takes 5 cycles per count at 100 MHz.
#define CHIP_DELAY_us(us) ((uint32_t)(us)*20u)

/// The three ePWM, held off by their trip zones, which are armed and locked. Their clock stands still.
/// False: period or dead time do not fit.
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

/// Amplifiers with their bias, then comparators and the X-BAR: before the PWM's trip zones are armed.
void chip_protection_init(void);

/// ADCA, ADCB, ADCC: a current each on the same trigger, the bus after one of them.
void chip_converters_init(void);
/// Result of the last period; phase 0 .. 2.
uint16_t chip_current(uint32_t phase);
uint16_t chip_bus(void);
/// Before the next result may raise the interrupt again; after a missed one too.
void chip_converters_acknowledge(void);

#endif
