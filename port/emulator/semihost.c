#include "semihost.h"

// Operations and the reason of an ordinary end, of Arm's "Semihosting for AArch32 and AArch64".
#define SYS_WRITE0 0x04u
#define SYS_GET_CMDLINE 0x15u
#define SYS_EXIT_EXTENDED 0x20u
#define APPLICATION_EXIT 0x20026u

#define COMMAND_LINE_MAX 128u
#define FLOAT_MAX 2.0e6f // a thousandth of it still fits 32 bits

static uint32_t request(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
#if defined(__thumb__)
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
#else
    __asm__ volatile("svc 0x123456" : "+r"(r0) : "r"(r1) : "memory", "lr");
#endif
    return r0;
}

void semihost_print(const char *text) {
    (void)request(SYS_WRITE0, text);
}

static void print_digits(uint32_t value, uint32_t least) {
    char text[11];
    char *p = text + sizeof text;
    *--p = '\0';
    for (uint32_t count = 0u; count < least || value > 0u; count++) {
        *--p = (char)('0' + (char)(value % 10u));
        value /= 10u;
    }
    semihost_print(p);
}

void semihost_print_unsigned(uint32_t value) {
    print_digits(value, 1u);
}

void semihost_print_float(float value) {
    const float size = value < 0.0f ? -value : value;
    if (!(size < FLOAT_MAX)) {
        semihost_print("(out of range)");
        return;
    }
    const uint32_t thousandths = (uint32_t)(size * 1000.0f + 0.5f);
    semihost_print(value < 0.0f ? "-" : "");
    print_digits(thousandths / 1000u, 1u);
    semihost_print(".");
    print_digits(thousandths % 1000u, 3u);
}

void semihost_print_hex64(uint64_t value) {
    char text[17];
    for (int32_t k = 15; k >= 0; k--) {
        text[k] = "0123456789abcdef"[value & 15u];
        value >>= 4;
    }
    text[16] = '\0';
    semihost_print(text);
}

// True if `text` begins with the complete `word`.
static bool starts_with(const char *text, const char *word) {
    while (*word != '\0' && *text == *word) {
        text++;
        word++;
    }
    return *word == '\0' && (*text == '\0' || *text == ' ');
}

bool semihost_has_argument(const char *word) {
    static char line[COMMAND_LINE_MAX];
    uint32_t block[2] = {(uint32_t)(uintptr_t)line, COMMAND_LINE_MAX};
    if (request(SYS_GET_CMDLINE, block) != 0u) {
        return false;
    }
    for (const char *p = line; *p != '\0'; p++) {
        if (*p == ' ' &&
            starts_with(p + 1, word)) { // the name of the image is before the first blank
            return true;
        }
    }
    return false;
}

void semihost_exit(int32_t code) {
    const uint32_t block[2] = {APPLICATION_EXIT, (uint32_t)code};
    for (;;) {
        (void)request(SYS_EXIT_EXTENDED, block);
    }
}
