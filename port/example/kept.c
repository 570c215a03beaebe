#include "kept.h"

/// In memory that start-up code and boot loader do not write; the port defines how it is declared. Without it
/// the count restarts with every reset.
#ifndef APP_NOINIT
#define APP_NOINIT
#endif

#define ARMED 0x41524D44u // unwritten memory holds this value once in 2^32
// Checked with the count: memory that was overwritten during a reset does not match.
#define MAGIC 0x4B455054u

static APP_NOINIT uint32_t resets;
static APP_NOINIT uint32_t check;
static APP_NOINIT uint32_t kept_armed;
static APP_NOINIT lode_attempts_t attempts;

uint32_t kept_watchdog_resets(bool by_watchdog) {
    const bool kept = check == (resets ^ MAGIC);
    const uint32_t before = kept && by_watchdog ? resets : 0u;
    resets = by_watchdog ? before + 1u : 0u;
    check = resets ^ MAGIC;
    return resets;
}

lode_attempts_t *kept_attempts(void) {
    return &attempts;
}

void kept_note_armed(bool armed) {
    kept_armed = armed ? ARMED : 0u;
}

bool kept_was_armed(void) {
    return kept_armed == ARMED;
}
