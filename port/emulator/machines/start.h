/// From reset to main(), and what of it all machines share.
#ifndef EMULATOR_START_H
#define EMULATOR_START_H

#include <stdint.h>

/// Of the linker script.
extern uint32_t stack_end[], data_load[], data_begin[], data_end[], bss_begin[], bss_end[];

int main(void);
void reset_handler(void);
/// Memory, main(), and the end of the emulation with what main() returns.
void emulator_main(void);
/// A fault, or an interrupt that nobody expects: exit code 70.
void emulator_stop(void);
/// Of the machine with a timer; emulator_stop() where an image has none.
void timer_handler(void);

#endif
