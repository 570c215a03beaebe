/// What is known beyond a reset of the chip, but not beyond a loss of power.
#ifndef LODESTAR_PORT_KEPT_H
#define LODESTAR_PORT_KEPT_H

#include <stdbool.h>
#include <stdint.h>

/// Number of resets by the watchdog since power, reset pin or debugger started the chip. Thread, once,
/// first of all; `by_watchdog`: this start is one more of them.
uint32_t kept_watchdog_resets(bool by_watchdog);

#endif
