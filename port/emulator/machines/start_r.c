/// Cortex-R5F: stack, FPU, and exceptions that end the emulation.
#include "start.h"

// The loader enters here; exceptions use the table at 0.
__attribute__((naked)) void reset_handler(void) {
    __asm__ volatile("ldr sp, =stack_end\n"
                     "mrc p15, 0, r0, c1, c0, 2\n"
                     "orr r0, r0, #0x00F00000\n" // CPACR: coprocessors 10 and 11
                     "mcr p15, 0, r0, c1, c0, 2\n"
                     "isb\n"
                     "mov r0, #0x40000000\n" // FPEXC.EN
                     "vmsr fpexc, r0\n"
                     "b emulator_main\n");
}

__attribute__((section(".vectors"), naked, used)) static void vectors(void) {
    __asm__ volatile("b reset_handler\n"
                     "b stopped\n" // undefined instruction
                     "b stopped\n" // supervisor call: qemu takes the one of semihosting itself
                     "b stopped\n" // prefetch abort
                     "b stopped\n" // data abort
                     "b stopped\n"
                     "b stopped\n" // IRQ
                     "b stopped\n" // FIQ
                     "stopped:\n"
                     "ldr sp, =stack_end\n" // the exception mode has no stack of its own
                     "b emulator_stop\n");
}
