/// Calls of the drive by a timer that counts up and down: once per period (VARIANT_F_PWM_Hz), at the lower
/// turning point, or at both turning points if a header has VARIANT_DOUBLE_UPDATE. Include it after the board's
/// header. Accesses no hardware.
#ifndef LODESTAR_PORT_COMMON_CALLS_H
#define LODESTAR_PORT_COMMON_CALLS_H

#include "lodestar/lodestar.h"

#ifndef VARIANT_DOUBLE_UPDATE
#define VARIANT_DOUBLE_UPDATE false
#endif

/// Rate of the calls.
#define PORT_F_CALL_Hz ((VARIANT_DOUBLE_UPDATE ? 2u : 1u) * VARIANT_F_PWM_Hz)

/// Counting direction in the previous call.
typedef enum { PORT_RAN_UNKNOWN, PORT_RAN_UP, PORT_RAN_DOWN } port_ran_t;

/// True if the interrupt comes too late, or the trigger is at the wrong turning point. With one call per period
/// the counter must not run down. With two it runs up after one and down after the next, so that a call that is
/// missing or half a period late is detected.
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
