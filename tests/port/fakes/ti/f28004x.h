/// What the fake driverlib has recorded, and the hardware behind it: trip zones with their ways in.
#ifndef FAKES_TI_F28004X_H
#define FAKES_TI_F28004X_H

#include "driverlib.h"

#define FAKE_ANY 0xFFFFFFFFu ///< any value of an argument

/// Nothing recorded, clocks alive, nothing tripped.
void fake_reset(void);
int fake_count(void);
/// Index of the first call of `name` at or after `from` whose first arguments are a, b, c; -1: none.
int fake_first(const char *name, uint32_t a, uint32_t b, uint32_t c, int from);
/// The same, last one; and the arguments of a call.
int fake_last(const char *name, uint32_t a, uint32_t b, uint32_t c);
const uint32_t *fake_arguments(int index);

/// A comparator's output, or the driver's nFAULT. Acts only by ways that have been set up, from the pin
/// or amplifier to the outputs of each ePWM.
void fake_set_comparator(uint32_t cmpss, bool active);
void fake_set_fault(bool active);
/// The chip's own: a crystal that has stopped (TZ5), a core held by a debugger (TZ6).
void fake_set_clock_lost(bool lost);
void fake_set_halted(bool halted);
/// The one for positive (`high`) or negative currents never acts on its threshold.
void fake_kill_comparator(uint32_t cmpss, bool high);
/// The six pins are the ePWM's and no trip holds them low.
bool fake_gates_on(void);
/// All three ePWM are held by their one-shot trips.
bool fake_all_tripped(void);

void fake_set_result(uint32_t base, ADC_SOCNumber number, uint16_t count);
void fake_set_cycles(uint32_t cycles);
void fake_set_direction(uint16_t direction);
void fake_set_overflow(void);
void fake_kill_clock(void);
void fake_set_reset_cause(uint32_t causes);
void fake_serial_room(uint32_t octets);
const char *fake_serial_text(void);
/// What stands registered for an interrupt.
typedef void (*fake_handler_t)(void);
fake_handler_t fake_handler(uint32_t number);

#endif
