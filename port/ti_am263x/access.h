/// The accesses on the chip: loads and stores, and two of the core's own.
#ifndef LODESTAR_PORT_TI_AM263X_ACCESS_H
#define LODESTAR_PORT_TI_AM263X_ACCESS_H

static inline uint16_t reg_read16(uint32_t address) {
    return *(volatile uint16_t *)address;
}

static inline void reg_write16(uint32_t address, uint32_t value) {
    *(volatile uint16_t *)address = (uint16_t)value;
}

static inline uint32_t reg_read32(uint32_t address) {
    return *(volatile uint32_t *)address;
}

static inline void reg_write32(uint32_t address, uint32_t value) {
    *(volatile uint32_t *)address = value;
}

/// The core's cycle counter (PMU), started by startup.S.
static inline uint32_t reg_cycles(void) {
    uint32_t cycles;
    __asm volatile("mrc p15, 0, %0, c9, c13, 0" : "=r"(cycles));
    return cycles;
}

static inline void reg_interrupts_on(void) {
    __asm volatile("cpsie i" ::: "memory");
}

#endif
