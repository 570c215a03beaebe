/// Independent watchdog, cycle counter, and what a debugger's halt does; the same in STM32F4 and STM32G4.
#ifndef LODESTAR_PORT_STM32_SUPERVISE_H
#define LODESTAR_PORT_STM32_SUPERVISE_H

#include "reg.h"

/// Some 20 ms (13 .. 38 ms over the tolerance of the STM32F4's LSI). Reset lets the pins float: the gate
/// drivers' pull-downs switch off. False: the watchdog's clock does not run.
bool stm32_watchdog_start(void);

static inline void stm32_watchdog_feed(void) {
    REG_WRITE(IWDG->KR, 0xAAAAu);
}

/// Starts the core's cycle counter (DWT).
void stm32_cycles_start(void);

static inline uint32_t stm32_cycles(void) {
    return REG_READ(DWT->CYCCNT);
}

#endif
