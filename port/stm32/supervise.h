/// Independent watchdog, cause of a reset and time stamp; the same in STM32F4, G4 and H7.
#ifndef LODESTAR_PORT_STM32_SUPERVISE_H
#define LODESTAR_PORT_STM32_SUPERVISE_H

#include "reg.h"

/// True if a watchdog is among the causes of the reset; clears all causes.
bool stm32_reset_by_watchdog(void);

/// A crystal that stops causes a break of TIM1 and an NMI, and the core continues with the internal oscillator
/// (clock security system, CSS). Does nothing if the board has no crystal.
void stm32_clock_watch(void);

/// Starts the watchdog's clock (LSI). False: it does not run.
bool stm32_watchdog_init(void);

/// Starts the watchdog: about 20 ms (13 .. 38 ms over the tolerance of the STM32F4's LSI). A reset lets the
/// pins float, so that the gate drivers' pull-downs switch off. It cannot be stopped again.
void stm32_watchdog_start(void);

static inline void stm32_watchdog_feed(void) {
    REG_WRITE(STM32_WATCHDOG->KR, 0xAAAAu);
}

/// Starts TIM2 as a free-running counter of 32 bits. It keeps running while a debugger halts the core. The
/// core's own cycle counter (DWT) stops then, and the first period after a breakpoint would look like any
/// other.
void stm32_stamp_start(void);

static inline uint32_t stm32_stamp(void) {
    return REG_READ(TIM2->CNT);
}

#endif
