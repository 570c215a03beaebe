/// From the boot ROM to main(): memory, FPU, vector table. Needs no vendor code.
#include <stdint.h>

#include "board.h"
#include "rp2350.h"

// Symbols of the linker script.
extern uint32_t stack_end[], data_load[], data_begin[], data_end[], bss_begin[], bss_end[];
extern uint32_t hot_load[], hot_begin[], hot_end[];

#define VTOR (*(volatile uint32_t *)0xE000ED08u)
#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define CPACR_FPU_FULL (15u << 20) // coprocessors 10 and 11

int main(void);
void reset_handler(void);
void run(void);
void stop_handler(void);
void adc_fifo_handler(void);

typedef union {
    void *stack;
    void (*handler)(void);
} vector_t;

#define EXCEPTIONS 16u
#define INTERRUPTS 52u

// A vector that is not named here is 0; if taken, it ends in the hard fault.
__attribute__((section(".vectors"),
               used)) static const vector_t vectors[EXCEPTIONS + INTERRUPTS] = {
    [0] = {.stack = stack_end},
    [1] = {.handler = reset_handler},
    [2] = {.handler = stop_handler}, // NMI
    [3] = {.handler = stop_handler}, // hard fault
    [4] = {.handler = stop_handler}, // memory management
    [5] = {.handler = stop_handler}, // bus fault
    [6] = {.handler = stop_handler}, // usage fault
    [7] = {.handler = stop_handler}, // secure fault
    [EXCEPTIONS + IRQ_ADC_FIFO] = {.handler = adc_fifo_handler},
};

// The boot ROM needs this in the first 4 KB to recognise a program: an image for Arm, run in place, with its
// vectors at its start (data sheet, minimum image definition).
__attribute__((section(".image_def"), used)) static const uint32_t image_def[] = {
    0xFFFFDED3u, // begin of a block
    0x10210142u, // item: executable, secure, Arm, RP2350
    0x000001FFu, // last item
    0x00000000u, // the only block
    0xAB123579u, // end
};

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

/// Uses the image's own stack, without the stack limit of the boot ROM.
__attribute__((naked)) void reset_handler(void) {
    __asm volatile("movs r0, #0\n msr msplim, r0\n ldr r0, =stack_end\n msr msp, r0\n b run");
}

void run(void) {
    VTOR = (uint32_t)vectors;
    CPACR |= CPACR_FPU_FULL; // before any float; lazy stacking is the reset state
    __asm volatile("dsb\n isb" ::: "memory");
    copy(data_begin, data_end, data_load);
    copy(hot_begin, hot_end, hot_load);
    clear(bss_begin, bss_end);
    (void)main();
    stop_handler();
}

/// Faults and unexpected interrupts: gates off, then the watchdog resets.
void stop_handler(void) {
    board_gates_off();
    for (;;) {
    }
}
