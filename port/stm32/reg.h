/// Every access of the STM32 ports to a register. On the chip they are plain loads and stores. A device header
/// may define REG_READ and REG_WRITE itself; that of the tests does, to record the order.
#ifndef LODESTAR_PORT_STM32_REG_H
#define LODESTAR_PORT_STM32_REG_H

#include <stdbool.h>
#include <stdint.h>

#include "stm32_device.h"

#ifndef REG_WRITE
#define REG_READ(reg) (reg)
#define REG_WRITE(reg, value) ((reg) = (value))
#endif

#define REG_SET(reg, bits) REG_WRITE(reg, REG_READ(reg) | (bits))
#define REG_CLEAR(reg, bits) REG_WRITE(reg, REG_READ(reg) & ~(uint32_t)(bits))
/// Writes `value` into the bits of `mask`.
#define REG_CHANGE(reg, mask, value) REG_WRITE(reg, (REG_READ(reg) & ~(uint32_t)(mask)) | (value))

/// Polls of a ready flag before the hardware counts as failed: a crystal takes milliseconds, and a poll about
/// ten cycles at 16 MHz.
#define REG_POLLS 200000u

/// Waits until the bits of `mask` read `bits`; false if they do not in time.
static inline bool reg_await(const volatile uint32_t *reg, uint32_t mask, uint32_t bits) {
    uint32_t polls = 0u;
    while ((REG_READ(*reg) & mask) != bits && polls < REG_POLLS) {
        polls++;
    }
    return polls < REG_POLLS;
}

/// Waits at least this many loops of a few cycles each.
static inline void stm32_wait(uint32_t loops) {
    for (volatile uint32_t n = 0u; n < loops; n++) {
    }
}

#endif
