/// From reset to main(): the parts common to all machines.
#ifndef EMULATOR_START_H
#define EMULATOR_START_H

#include <stdint.h>

/// Symbols of the linker script.
extern uint32_t stack_end[], data_load[], data_begin[], data_end[], bss_begin[], bss_end[];

int main(void);
void reset_handler(void);
/// Sets up memory, calls main(), and ends the emulation with its return value.
void emulator_main(void);
/// A fault or an unexpected interrupt: exit code 70.
void emulator_stop(void);
/// Interrupt of a machine with a timer; emulator_stop() in an image without one.
void timer_handler(void);

#endif
