/// The parts of the STM32H7 that port/stm32/board.c puts together.
#ifndef LODESTAR_PORT_STM32H7_CHIP_H
#define LODESTAR_PORT_STM32H7_CHIP_H

#include "gpio.h"
#include "reg.h"
#include "serial.h"

#ifndef STM32_BOARD_H
#define STM32_BOARD_H "boards/generic_h743.h"
#endif
#include STM32_BOARD_H

#include "calls.h"

#define CHIP_F_CPU_Hz 400000000u
#define CHIP_F_PWM_Hz 200000000u      ///< TIM1
#define CHIP_F_STAMP_Hz CHIP_F_PWM_Hz ///< TIM2
#define CHIP_F_SERIAL_Hz 100000000u   ///< USART3
#define CHIP_F_RC_Hz 64000000u ///< of all clocks, if the oscillator or the PLL has not started

/// Core 400 MHz, buses 200 MHz, timers 200 MHz; instruction cache on. False: an oscillator, the regulator or
/// the PLL does not come.
bool chip_clock_init(void);

/// The sources of TIM1's break. After stm32_pwm_reset(), before the break input is armed.
void chip_protection_init(float i_trip_A);

/// Always true: the driver's fault output cannot be activated by software.
bool chip_protection_test(void);

/// ADC1 and ADC2, injected and simultaneous, three ranks each, on TIM1's TRGO. False: no answer, or a chip of
/// revision Y, whose ADCs have another clock tree.
bool chip_adc_init(void);

/// From now on a trigger starts them.
void chip_adc_arm(void);

/// Call before the next results.
static inline void chip_adc_acknowledge(void) {
    REG_WRITE(ADC1->ISR, ADC_ISR_JEOC | ADC_ISR_JEOS);
}

/// Switches the outputs off for good if no interrupt comes for one and a half times the time between two calls.
/// After stm32_stamp_start().
void chip_deadline_init(void);

/// Call in the interrupt: moves the deadline on.
static inline void chip_deadline_move(void) {
    REG_WRITE(TIM2->CCR1, REG_READ(TIM2->CNT) + 3u * (CHIP_F_STAMP_Hz / PORT_F_CALL_Hz) / 2u);
}

/// Break input: enabled, polarity of the pin in AF1; filter of six equal samples at half the timer's clock:
/// rejects spikes up to 60 ns.
#define CHIP_BREAK_FILTER 4u
#define CHIP_BREAK_BITS (TIM_BDTR_BKE | TIM_BDTR_BKP | CHIP_BREAK_FILTER << TIM_BDTR_BKF_Pos)

/// ADC clock 25 MHz; 8.5 cycles of sampling, 6.5 of conversion to 12 bits. Until the end of the sampling of
/// rank 2, with three cycles from the trigger to the first sampling.
#define CHIP_SAMPLE_ns ((3.0f + 8.5f + 6.5f + 8.5f) / 25.0f * 1000.0f)

#endif
