/// Records every write to a register, in order, and models the trip zones with their ways in.
#ifndef FAKES_TI_AM263X_FAKE_H
#define FAKES_TI_AM263X_FAKE_H

#include <stdbool.h>
#include <stdint.h>

/// All registers 0, counters run up, nothing recorded, nothing tripped, fault line high.
void fake_reset(void);
int fake_count(void);
/// Index of the first write to `address` at or after `from` whose bits in `mask` are `bits`; -1: none.
int fake_first(uint32_t address, uint32_t mask, uint32_t bits, int from);
uint32_t fake_get(uint32_t address);
void fake_put(uint32_t address, uint32_t value);
/// Index of reg_interrupts_on() among the writes; -1: never.
int fake_interrupts_on(void);

/// Output of CMPSSB n (the filtered one, either comparator), or the fault line. Acts only by ways that
/// have been set up, from the comparator or pin to the outputs of each ePWM.
void fake_set_comparator(uint32_t n, bool active);
void fake_set_fault(bool active);
/// The one for positive (`high`) or negative currents never acts on its threshold.
void fake_kill_comparator(uint32_t n, bool high);
/// A debugger holds the core.
void fake_set_halted(bool halted);
/// The crystal has stopped.
void fake_set_clock_lost(bool lost);
/// The six pads are the ePWM's and no trip holds them low.
bool fake_gates_on(void);
bool fake_all_tripped(void);

/// The ePWM do not take writes.
void fake_gate_clock(void);
/// Every look at the cycle counter moves it by one microsecond, but for those of a period.
void fake_set_cycles(uint32_t cycles, uint32_t step);
const char *fake_serial_text(void);

#endif
