#include "start.h"

#include <stdlib.h>

#include "semihost.h"

#define EXIT_STOPPED 70 // EX_SOFTWARE of sysexits.h

/// The end of the C library's exit(), after it has written the remaining output.
__attribute__((noreturn)) void _exit(int code);
void _exit(int code) {
    semihost_exit(code);
}

void emulator_main(void) {
    const uint32_t *from = data_load;
    for (uint32_t *p = data_begin; p != data_end; p++) {
        *p = *from++;
    }
    for (uint32_t *p = bss_begin; p != bss_end; p++) {
        *p = 0u;
    }
    exit(main());
}

void emulator_stop(void) {
    semihost_print("FAIL processor fault\n");
    semihost_exit(EXIT_STOPPED);
}
