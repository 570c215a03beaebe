/// The parts of the STM32G4 that port/stm32/board.c puts together.
#ifndef LODESTAR_PORT_STM32G4_CHIP_H
#define LODESTAR_PORT_STM32G4_CHIP_H

#include "gpio.h"
#include "reg.h"
#include "serial.h"

#ifndef STM32_BOARD_H
#define STM32_BOARD_H "boards/b_g431b_esc1.h"
#endif
#include STM32_BOARD_H

#include "calls.h"

#define CHIP_F_CPU_Hz 170000000u
#define CHIP_F_PWM_Hz CHIP_F_CPU_Hz    ///< TIM1
#define CHIP_F_STAMP_Hz CHIP_F_CPU_Hz  ///< TIM2
#define CHIP_F_SERIAL_Hz CHIP_F_CPU_Hz ///< USART2
#define CHIP_F_RC_Hz 16000000u ///< of all clocks, if the oscillator or the PLL has not started

/// Core, buses and timers at 170 MHz. False: an oscillator or the PLL does not come.
bool chip_clock_init(void);

/// Amplifiers, comparators and their threshold, if the variant uses the chip's own, and the sources of TIM1's
/// break. After stm32_pwm_reset(), before the break input is armed.
void chip_protection_init(float i_trip_A);

/// True if each of the chip's own comparators trips when its threshold falls below the zero-current signal, and
/// only then.
bool chip_protection_test(void);

/// ADC1 and ADC2, injected and simultaneous, three ranks each, on TIM1's TRGO. False: no answer.
bool chip_adc_init(void);

/// From now on a trigger starts them.
void chip_adc_arm(void);

#if defined(VARIANT_LINK) && VARIANT_DOUBLE_UPDATE
#error "One shunt needs a whole period for its two samples: no VARIANT_DOUBLE_UPDATE"
#endif

/// Call before the next results.
#ifdef VARIANT_LINK
void chip_adc_acknowledge(void);
/// Sequences and triggers with one shunt.
void chip_link_adcs(void);
#else
static inline void chip_adc_acknowledge(void) {
    REG_WRITE(ADC1->ISR, ADC_ISR_JEOC | ADC_ISR_JEOS);
}
#endif

/// Switches the outputs off for good if no interrupt comes for one and a half times the time between two calls.
/// After stm32_stamp_start().
void chip_deadline_init(void);

/// Call in the interrupt: moves the deadline on.
static inline void chip_deadline_move(void) {
    REG_WRITE(TIM2->CCR1, REG_READ(TIM2->CNT) + 3u * (CHIP_F_STAMP_Hz / PORT_F_CALL_Hz) / 2u);
}

/// Break inputs: enabled, polarities of the sources in AF1 and AF2; filter of six equal samples at half the
/// timer's clock: rejects spikes up to 71 ns.
#define CHIP_BREAK_FILTER 4u
#define CHIP_BREAK1_BITS (TIM_BDTR_BKE | TIM_BDTR_BKP | CHIP_BREAK_FILTER << TIM_BDTR_BKF_Pos)
#ifdef VARIANT_BREAK2_PIN
#define CHIP_BREAK_BITS                                                                            \
    (CHIP_BREAK1_BITS | TIM_BDTR_BK2E | TIM_BDTR_BK2P | CHIP_BREAK_FILTER << TIM_BDTR_BK2F_Pos)
#else
#define CHIP_BREAK_BITS CHIP_BREAK1_BITS
#endif

#ifdef VARIANT_LINK
/// ADC clock 42.5 MHz; three cycles from the trigger to the sampling, and 6.5 of that.
#define CHIP_SAMPLE_ns ((3.0f + 6.5f) / 42.5f * 1000.0f)
#else
/// ADC clock 42.5 MHz; 6.5 cycles of sampling, 12.5 of conversion. Until the end of the sampling of rank
/// 2, with three cycles from the trigger to the first sampling.
#define CHIP_SAMPLE_ns ((3.0f + 6.5f + 12.5f + 6.5f) / 42.5f * 1000.0f)
#endif

#endif
