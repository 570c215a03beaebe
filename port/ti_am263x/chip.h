/// The parts of the AM263x that board.c and ti/board.c put together.
#ifndef LODESTAR_PORT_TI_AM263X_CHIP_H
#define LODESTAR_PORT_TI_AM263X_CHIP_H

#include "am263x.h"
#include "counts.h"
#include "parts.h"
#include "reg.h"

#ifndef TI_BOARD_H
#define TI_BOARD_H "boards/generic_am263x.h"
#endif
#include TI_BOARD_H

#include "calls.h"

/// Clocks set up by the boot loader: core and CONTROLSS.
#define CHIP_F_CPU_Hz 400000000u
#define CHIP_F_PWM_Hz 200000000u
#define CHIP_F_STAMP_Hz CHIP_F_CPU_Hz ///< the core's cycle counter

/// ADC clock 50 MHz. Window 140 ns.
#define CHIP_WINDOW_cycles 28u
/// Until the end of the currents' sampling: some cycles from the trigger, then the window.
#define CHIP_SAMPLE_ns 200.0f

/// Full scale of ADCs and comparators differ.
#define CHIP_DAC_PER_COUNT (VARIANT_V_REF_V / VARIANT_V_DAC_V)

/// Waits at least this long, by the core's counter.
void chip_wait_us(uint32_t us);

#endif
