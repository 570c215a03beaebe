/// Records every write of a port to a register, in order, and models what the hardware answers: ready
/// flags, flags cleared by writing, the timer's lock (which only the first write after its reset sets) and
/// its break input.
#ifndef FAKES_FAKE_H
#define FAKES_FAKE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    const volatile uint32_t *reg;
    uint32_t value;
    const char *name; ///< as the port spells it
} fake_entry_t;

/// All registers 0, nothing recorded, every oscillator alive, break input inactive.
void fake_reset(void);

uint32_t fake_read(const volatile uint32_t *reg);
void fake_write(volatile uint32_t *reg, const char *name, uint32_t value);

/// Number of writes so far.
int fake_count(void);
/// Index of the first write to `reg` at or after `from` whose bits in `mask` are `bits`; -1: none.
int fake_first(const volatile uint32_t *reg, uint32_t mask, uint32_t bits, int from);
/// Index of the interrupt's enable among the writes; -1: never.
int fake_irq_enabled(int irq);
uint32_t fake_irq_priority(int irq);

/// The break input's level. Active: the outputs are off, as the hardware does it, and stay off.
void fake_set_break(bool active);
/// So many ticks of TIM2 go by without an interrupt.
void fake_run(uint32_t ticks);
/// A debugger holds the core for so many ticks of TIM2, which counts them unless it is frozen; TIM1 does
/// not. True: TIM1 drives its outputs inactive meanwhile.
bool fake_halt(uint32_t ticks);
/// The watchdog waits while a debugger holds the core.
bool fake_watchdog_waits(void);
/// The crystal stops, the core locks up, the flash has an error: a break where the port has connected it.
void fake_lose_clock(void);
void fake_lock_up(void);
void fake_flash_error(void);
/// One of the comparators 1, 2, 4 (n = 0 .. 2) never acts; STM32G4.
void fake_kill_comparator(int n);
/// The oscillators never get ready.
void fake_kill_clock(void);
/// The transmitter takes this many more octets.
void fake_serial_room(uint32_t octets);
/// What came out of it.
const char *fake_serial_text(void);

#endif
