/// The parts of the RP2350 port, and the values of the chip for common/describe.c.
#ifndef LODESTAR_PORT_RP2350_CHIP_H
#define LODESTAR_PORT_RP2350_CHIP_H

#include "figures.h"
#include "lodestar/lodestar.h"
#include "reg.h"
#include "rp2350.h"

#ifndef RP_BOARD_H
#define RP_BOARD_H "boards/generic_rp2350.h"
#endif
#include RP_BOARD_H

#if !VARIANT_DRIVER_INTERLOCK || !VARIANT_DRIVER_DEAD_TIME || !VARIANT_DRIVER_LATCHED_TRIP
#error                                                                                             \
    "The RP2350 has no dead time and no break input: take a gate driver with interlock, dead time and latched over-current"
#endif
#define VARIANT_LOW_SIDES false // one input per half bridge
#ifdef VARIANT_PRECHARGE_s
#error                                                                                             \
    "One input per half bridge: no low sides alone, so no VARIANT_PRECHARGE_s; take a driver with a charge pump"
#endif

#include "calls.h"
#if VARIANT_DOUBLE_UPDATE
#error                                                                                             \
    "This PWM takes compare values over at zero only, and one ADC has no time for it: no VARIANT_DOUBLE_UPDATE"
#endif

#define CHIP_PHASES 3u
#define CHIP_F_SYS_Hz 150000000u
#define CHIP_F_PWM_Hz CHIP_F_SYS_Hz
#define CHIP_F_STAMP_Hz CHIP_F_SYS_Hz ///< TIMER0
#define CHIP_F_ADC_Hz 48000000u

/// Conversions follow each other every 96 cycles of 48 MHz. The data sheet does not give the sampling instant;
/// a quarter of a conversion after its start is assumed.
#define CHIP_CONVERSION_ns 2000.0f
#define CHIP_APERTURE_ns 500.0f

/// Slices of the PWM without pins, in either package: one triggers the ADC, one is the deadline.
#define CHIP_TRIGGER_SLICE 8u
#define CHIP_DEADLINE_SLICE 9u

#define CHIP_IS_TWO (VARIANT_SENSING == PORT_LOW_SIDE_TWO || VARIANT_SENSING == PORT_IN_LINE_TWO)
/// Sampled one after the other: the currents, then the bus.
#define CHIP_CURRENTS (CHIP_IS_TWO ? 2u : 3u)
#define CHIP_SAMPLES (CHIP_CURRENTS + 1u)
/// The samples of the currents lie evenly around t_k: the last one this long after t_k, the first one as long before.
#define CHIP_SPREAD_ns (0.5f * (float)(CHIP_CURRENTS - 1u) * CHIP_CONVERSION_ns)
/// Amplifiers must have settled this much before t_k.
#define CHIP_LEAD_ns (CHIP_SPREAD_ns + CHIP_APERTURE_ns)
/// Until the end of the last current's sampling.
#define CHIP_SAMPLE_ns (CHIP_SPREAD_ns + CHIP_APERTURE_ns)

/// Core, PWM and serial port at 150 MHz from the crystal, ADC at 48 MHz. The reference clock, and with
/// it the watchdog, stays on the ring oscillator. False: crystal or PLL does not come.
bool chip_clock_init(void);
/// True if the system's PLL has lost lock since the last chip_clock_forget().
bool chip_clock_lost(void);
void chip_clock_forget(void);
/// Takes parts out of reset; those in `fresh` are reset first. False: no response.
bool chip_release(uint32_t fresh, uint32_t others);
/// Waits `us` by the stamp's counter, or by loops before it runs.
void chip_wait_us(uint32_t us);

/// Sets up the slices of the three phases, of the trigger and of the deadline, stopped. False: the period does
/// not fit.
bool chip_pwm_init(void);
/// Starts all slices at once.
void chip_pwm_start(void);
void chip_pwm_write(lode_abc_t duty);
/// True if the compare registers hold what was written last.
bool chip_pwm_holds(void);
/// Call in the interrupt: moves the deadline on.
void chip_deadline_move(void);

/// ADC and the two DMA channels, not yet enabled.
bool chip_adc_init(void);
/// From now on the wraps of the slices take effect.
void chip_adc_arm(void);
/// Takes the samples of this period. False: wrong number of samples.
bool chip_adc_take(uint16_t sample[CHIP_SAMPLES]);
/// Call after the period: waits for the extra conversion and discards it.
void chip_adc_rest(void);

/// Enable, reset and fault pin of the gate driver. Before anything else: enable low.
void chip_driver_init(void);
void chip_gates_off(void);
/// Unless something is latched.
void chip_gates_on(void);
/// True if fault line, deadline or clock loss is latched.
bool chip_tripped(void);
/// Switches the gates off, then clears the latches of driver and chip.
void chip_driver_reset(void);

#endif
