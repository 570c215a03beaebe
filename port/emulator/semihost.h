/// Text, arguments and exit code through the debugger, which is qemu here.
#ifndef EMULATOR_SEMIHOST_H
#define EMULATOR_SEMIHOST_H

#include <stdbool.h>
#include <stdint.h>

void semihost_print(const char *text);
void semihost_print_unsigned(uint32_t value);
/// Three decimals; |value| below 2e6.
void semihost_print_float(float value);
/// Sixteen hexadecimal digits.
void semihost_print_hex64(uint64_t value);

/// True if `word` was given to port/emulator/run after the image.
bool semihost_has_argument(const char *word);

/// Ends the emulation with this exit code.
__attribute__((noreturn)) void semihost_exit(int32_t code);

#endif
