// A Cortex-R5F that counts around a loop of known length; the exit code says whether it could.
#include <stdbool.h>
#include <stdint.h>

bool counter_start(void);
void run(void);
void _start(void);

#include COUNTER

static uint32_t cycles_of(uint32_t rounds) {
    const uint32_t begin = counter_read();
    for (uint32_t i = 0; i < rounds; i++) {
        __asm__ volatile("nop");
    }
    return counter_read() - begin;
}

// A round is two instructions at least, and with -icount shift=6 an instruction is 64 cycles. Ten times
// the rounds take about ten times the cycles.
void run(void) {
    const bool started = counter_start();
    const uint32_t few = cycles_of(1000);
    const uint32_t many = cycles_of(10000);
    const bool good = started && few >= 2u * 64u * 1000u && many > 9u * few && many < 11u * few;
    uint32_t block[2] = {0x20026u, good ? 0u : 1u}; // semihosting: exit with a code
    register uint32_t operation __asm__("r0") = 0x20u;
    register uint32_t *argument __asm__("r1") = block;
    __asm__ volatile("svc 0x123456" : : "r"(operation), "r"(argument) : "memory");
}

__attribute__((naked, section(".start"))) void _start(void) {
    __asm__ volatile("mov sp, #0x100000\n\tb run");
}
