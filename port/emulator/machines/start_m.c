/// Cortex-M: vector table and FPU.
#include "start.h"

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define CPACR_FPU_FULL (15u << 20) // coprocessors 10 and 11

typedef union {
    void *stack;
    void (*handler)(void);
} vector_t;

#define EXCEPTIONS 16

__attribute__((weak)) void timer_handler(void) {
    emulator_stop();
}

void reset_handler(void) {
#ifdef __ARM_FP
    CPACR |= CPACR_FPU_FULL; // before any float
    __asm__ volatile("dsb\n isb" ::: "memory");
#endif
    emulator_main();
}

// A vector that is not named is 0; if taken, it ends in the hard fault.
__attribute__((section(".vectors"), used)) static const vector_t vectors[] = {
    [0] = {.stack = stack_end},
    [1] = {.handler = reset_handler},
    [2] = {.handler = emulator_stop}, // NMI
    [3] = {.handler = emulator_stop}, // hard fault
    [4] = {.handler = emulator_stop}, // memory management
    [5] = {.handler = emulator_stop}, // bus fault
    [6] = {.handler = emulator_stop}, // usage fault
    [EXCEPTIONS + MACHINE_IRQ] = {.handler = timer_handler},
};
