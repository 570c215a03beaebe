#include "kept.h"

/// Where start-up code and boot loader leave memory as it is; the port says how that is written. Without
/// it the count begins anew with every reset.
#ifndef APP_NOINIT
#define APP_NOINIT
#endif

#define MAGIC 0x4B455054u // with the count: memory that no reset has left untouched does not match

static APP_NOINIT uint32_t resets;
static APP_NOINIT uint32_t check;

uint32_t kept_watchdog_resets(bool by_watchdog) {
    const bool kept = check == (resets ^ MAGIC);
    const uint32_t before = kept && by_watchdog ? resets : 0u;
    resets = by_watchdog ? before + 1u : 0u;
    check = resets ^ MAGIC;
    return resets;
}
