/// The parts of the F28004x that board.c and ti/board.c put together. TI's driverlib does every access.
#ifndef LODESTAR_PORT_TI_F28004X_CHIP_H
#define LODESTAR_PORT_TI_F28004X_CHIP_H

#include "counts.h"
#include "device.h"
#include "driverlib.h"
#include "parts.h"

#ifndef TI_BOARD_H
#define TI_BOARD_H "boards/launchxl_f280049c_drv8320rs.h"
#endif
#include TI_BOARD_H

#include "calls.h"

#define CHIP_F_CPU_Hz 100000000u
#define CHIP_F_PWM_Hz CHIP_F_CPU_Hz
#define CHIP_F_STAMP_Hz CHIP_F_CPU_Hz ///< CPU timer 1

/// ADC clock 50 MHz. The window is twice the 75 ns that the ADC needs, because the amplifier drives it.
#define CHIP_WINDOW_cycles 20u
/// Until the end of the currents' sampling: some cycles from the trigger, then the window.
#define CHIP_SAMPLE_ns 250.0f

/// ADCs and comparators have the same full scale.
#define CHIP_DAC_PER_COUNT 1.0f

/// SysCtl_delay() takes 5 cycles per count at 100 MHz.
LODE_INLINE void chip_wait_us(uint32_t us) {
    SysCtl_delay(us * 20u);
}

#endif
