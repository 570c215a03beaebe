/// What the emulated machines differ in: who calls the period, and how time is told.
#ifndef EMULATOR_MACHINE_H
#define EMULATOR_MACHINE_H

#include <stdbool.h>
#include <stdint.h>

/// Of board.c: one period. Called by the timer's interrupt, or by machine_wait() where there is none.
void emulator_period(void);

/// Starts the periods and, with them, a second counter that nothing resets.
void machine_start(void);

/// Waits for the next period. Thread.
void machine_wait(void);

/// That counter, in parts of a period (PLANT_STAMP_PER_PERIOD); wraps. Where there is no timer it is made
/// of the calls.
uint32_t machine_stamp(void);

/// True where a timer interrupts, and the stamp is another timer's.
bool machine_has_timer(void);

/// How often the period's interrupt was entered, and how many periods the second counter had seen when
/// it was entered last. Thread, between two interrupts.
uint32_t machine_entries(void);
uint32_t machine_elapsed(void);

#endif
