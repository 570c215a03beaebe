/// Accesses to registers on the chip.
#ifndef LODESTAR_PORT_RP2350_ACCESS_H
#define LODESTAR_PORT_RP2350_ACCESS_H

#include <stdint.h>

static inline uint32_t reg_read(uint32_t address) {
    return *(volatile uint32_t *)address;
}

static inline void reg_write(uint32_t address, uint32_t value) {
    *(volatile uint32_t *)address = value;
}

/// Address of the chip for the DMA.
static inline uint32_t reg_address_of(const uint32_t *word) {
    return (uint32_t)word;
}

#endif
