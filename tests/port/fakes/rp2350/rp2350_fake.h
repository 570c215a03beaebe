/// Records every write to a register, in order, and models what the chip and a gate driver behind it do:
/// resets, clocks, the ADC's round and its FIFO, the two DMA channels, pins and the driver's latch.
#ifndef FAKES_RP2350_FAKE_H
#define FAKES_RP2350_FAKE_H

#include <stdbool.h>
#include <stdint.h>

/// As after power-up, nothing recorded; crystal alive, no fault, all pads isolated.
void fake_reset(void);
int fake_count(void);
/// Index of the first write to `address` at or after `from` whose bits in `mask` are `bits`; -1: none.
int fake_first(uint32_t address, uint32_t mask, uint32_t bits, int from);
uint32_t fake_get(uint32_t address);
void fake_put(uint32_t address, uint32_t value);

/// What the ADC's inputs 0 .. 3 show.
void fake_set_input(uint32_t n, uint32_t count);
/// The trigger slice wraps. True: the ADC has gone through its round, and the interrupt is there.
bool fake_trigger(void);
/// This long without an interrupt, in cycles; a debugger may hold the core.
void fake_halt(uint32_t cycles);
/// Over-current at the driver: it switches off and holds its fault line until it is reset.
void fake_set_fault(bool active);
void fake_kill_crystal(void);
/// All half bridges switch: driver awake and not latched, its enable high at the pin.
bool fake_gates_on(void);
/// The slice's pin is the PWM's output.
bool fake_is_pwm(uint32_t gpio);
const char *fake_serial_text(void);

#endif
