/// Values that survive a reset of the chip, but not a loss of power.
#ifndef LODESTAR_PORT_KEPT_H
#define LODESTAR_PORT_KEPT_H

#include "lodestar/supervisor.h"

/// Number of resets by the watchdog since power, reset pin or debugger started the chip. Thread, once,
/// first of all; `by_watchdog`: this start is one more of them.
uint32_t kept_watchdog_resets(bool by_watchdog);

/// The supervisor's count of new starts; 0 after a power-up.
lode_attempts_t *kept_attempts(void);

/// Thread. Notes whether the motor is armed and runs, for the start after a reset by the watchdog.
void kept_note_armed(bool armed);

/// The last note; false if there was none since power-up.
bool kept_was_armed(void);

#endif
