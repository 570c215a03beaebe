/// From reset to main(): memory, FPU, vector table. Needs no vendor code.
#include <stdint.h>

#include "board.h"
#include "stm32_device.h"

// Symbols of the linker script.
extern uint32_t stack_end[], data_load[], data_begin[], data_end[], bss_begin[], bss_end[];
extern uint32_t hot_load[], hot_begin[], hot_end[];

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define CPACR_FPU_FULL (15u << 20) // coprocessors 10 and 11

int main(void);
void reset_handler(void);
void stop_handler(void);
/// The one interrupt in use, by its name in ST's tables.
void STM32_PERIOD_HANDLER(void);

static void copy(uint32_t *to, const uint32_t *to_end, const uint32_t *from) {
    while (to < to_end) {
        *to++ = *from++;
    }
}

static void clear(uint32_t *to, const uint32_t *to_end) {
    while (to < to_end) {
        *to++ = 0u;
    }
}

void reset_handler(void) {
    CPACR |= CPACR_FPU_FULL; // before any float; lazy stacking is the reset state
    __asm volatile("dsb\n isb" ::: "memory");
    copy(data_begin, data_end, data_load);
    copy(hot_begin, hot_end, hot_load);
    clear(bss_begin, bss_end);
    __asm volatile("dsb\n isb" ::: "memory"); // code has been written
    (void)main();
    stop_handler();
}

/// Faults and unexpected interrupts: gates off, then the watchdog resets.
void stop_handler(void) {
    board_gates_off();
    for (;;) {
    }
}

typedef union {
    void *stack;
    void (*handler)(void);
} vector_t;

#define EXCEPTIONS 16

// A vector that is not named here is 0; if taken, it ends in the hard fault.
__attribute__((section(".vectors"), used)) static const vector_t vectors[] = {
    [0] = {.stack = stack_end},
    [1] = {.handler = reset_handler},
    [2] = {.handler = stop_handler}, // NMI
    [3] = {.handler = stop_handler}, // hard fault
    [4] = {.handler = stop_handler}, // memory management
    [5] = {.handler = stop_handler}, // bus fault
    [6] = {.handler = stop_handler}, // usage fault
    [EXCEPTIONS + STM32_PERIOD_IRQ] = {.handler = STM32_PERIOD_HANDLER},
};
