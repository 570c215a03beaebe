/// How often a timer that counts up and down calls the drive: once in its period (VARIANT_F_PWM_Hz), at the lower
/// turning point, or at both of them where a header has VARIANT_DOUBLE_UPDATE. Behind the board's header. No
/// hardware in here.
#ifndef LODESTAR_PORT_COMMON_CALLS_H
#define LODESTAR_PORT_COMMON_CALLS_H

#include "lodestar/lodestar.h"

#ifndef VARIANT_DOUBLE_UPDATE
#define VARIANT_DOUBLE_UPDATE false
#endif

/// Of the calls.
#define PORT_F_CALL_Hz ((VARIANT_DOUBLE_UPDATE ? 2u : 1u) * VARIANT_F_PWM_Hz)

/// How the counter ran in the call before.
typedef enum { PORT_RAN_UNKNOWN, PORT_RAN_UP, PORT_RAN_DOWN } port_ran_t;

/// True: the interrupt comes too late, or the trigger sits at the wrong end. With one call the counter must not run
/// down; with two it runs up after one and down after the next, so one that is missing or late by a half shows.
LODE_INLINE bool port_is_wrong_half(port_ran_t *before, bool counts_down) {
    if (!VARIANT_DOUBLE_UPDATE) {
        (void)before;
        return counts_down;
    }
    const port_ran_t now = counts_down ? PORT_RAN_DOWN : PORT_RAN_UP;
    const bool again = now == *before;
    *before = now;
    return again;
}

#endif
