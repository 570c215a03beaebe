/// The differences of the emulated machines: the caller of the period, and the time base.
#ifndef EMULATOR_MACHINE_H
#define EMULATOR_MACHINE_H

#include <stdbool.h>
#include <stdint.h>

/// In board.c: one period. Called by the timer's interrupt, or by machine_wait() without a timer.
void emulator_period(void);

/// Starts the periods and, with them, a second counter that nothing resets.
void machine_start(void);

/// Waits for the next period. Thread.
void machine_wait(void);

/// The second counter, in parts of a period (PLANT_STAMP_PER_PERIOD); wraps. Without a timer it counts the
/// calls.
uint32_t machine_stamp(void);

/// True if a timer interrupts and another timer gives the stamp.
bool machine_has_timer(void);

/// Number of entries of the period's interrupt, and number of periods of the second counter at the last entry.
/// Thread, between two interrupts.
uint32_t machine_entries(void);
uint32_t machine_elapsed(void);

#endif
