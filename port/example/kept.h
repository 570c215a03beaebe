/// What is known beyond a reset of the chip, but not beyond a loss of power.
#ifndef LODESTAR_PORT_KEPT_H
#define LODESTAR_PORT_KEPT_H

#include "lodestar/supervisor.h"

/// Number of resets by the watchdog since power, reset pin or debugger started the chip. Thread, once,
/// first of all; `by_watchdog`: this start is one more of them.
uint32_t kept_watchdog_resets(bool by_watchdog);

/// The supervisor's count of new starts. What a power-up leaves there counts as none.
lode_attempts_t *kept_attempts(void);

/// Thread. Whether the motor runs because somebody has armed it, for the start after a reset by the watchdog.
void kept_note_armed(bool armed);

/// What was noted last; false where nothing was since power came.
bool kept_was_armed(void);

#endif
