/// Independent watchdog, cause of a reset and time stamp; the same in STM32F4, G4 and H7.
#ifndef LODESTAR_PORT_STM32_SUPERVISE_H
#define LODESTAR_PORT_STM32_SUPERVISE_H

#include "reg.h"

/// A watchdog's flag among the causes of a reset; clears them all.
bool stm32_reset_by_watchdog(void);

/// A crystal that stops is a break of TIM1 and an NMI, and the core goes on with the internal oscillator
/// (clock security system, CSS). Nothing where the board has no crystal.
void stm32_clock_watch(void);

/// The watchdog's clock (LSI). False: it does not run.
bool stm32_watchdog_init(void);

/// Some 20 ms (13 .. 38 ms over the tolerance of the STM32F4's LSI). Reset lets the pins float: the gate
/// drivers' pull-downs switch off. It cannot be stopped again.
void stm32_watchdog_start(void);

static inline void stm32_watchdog_feed(void) {
    REG_WRITE(STM32_WATCHDOG->KR, 0xAAAAu);
}

/// Starts TIM2 as a free-running counter of 32 bits. It runs on while a debugger
/// holds the core: the core's own cycle counter (DWT) stands still then, and the first period after a
/// breakpoint would look like any other.
void stm32_stamp_start(void);

static inline uint32_t stm32_stamp(void) {
    return REG_READ(TIM2->CNT);
}

#endif
