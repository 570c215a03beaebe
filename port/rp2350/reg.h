/// Every access of the RP2350 port to a register goes by address through these functions. The tests replace
/// them, to record the order.
#ifndef LODESTAR_PORT_RP2350_REG_H
#define LODESTAR_PORT_RP2350_REG_H

#include <stdbool.h>
#include <stdint.h>

#ifndef RP_REG_H
#define RP_REG_H "access.h"
#endif
#include RP_REG_H

/// Polls of a ready flag before the hardware counts as failed: a crystal takes milliseconds, and a poll about
/// ten cycles at about 10 MHz.
#define REG_POLLS 200000u

static inline void reg_set(uint32_t address, uint32_t bits) {
    reg_write(address, reg_read(address) | bits);
}

static inline void reg_clear(uint32_t address, uint32_t bits) {
    reg_write(address, reg_read(address) & ~bits);
}

/// Waits until the bits of `mask` read `bits`; false if they do not in time.
static inline bool reg_await(uint32_t address, uint32_t mask, uint32_t bits) {
    uint32_t polls = 0u;
    while ((reg_read(address) & mask) != bits && polls < REG_POLLS) {
        polls++;
    }
    return polls < REG_POLLS;
}

#endif
