/// The parts of the STM32F4 that port/stm32/board.c puts together.
#ifndef LODESTAR_PORT_STM32F4_CHIP_H
#define LODESTAR_PORT_STM32F4_CHIP_H

#include "gpio.h"
#include "reg.h"
#include "serial.h"

#ifndef STM32_BOARD_H
#define STM32_BOARD_H "boards/generic_f405.h"
#endif
#include STM32_BOARD_H

#include "calls.h"

#define CHIP_F_CPU_Hz 168000000u
#define CHIP_F_PWM_Hz CHIP_F_CPU_Hz ///< TIM1
#define CHIP_F_SERIAL_Hz 42000000u  ///< APB1: USART3
#define CHIP_F_RC_Hz 16000000u      ///< of all clocks, if the oscillator or the PLL has not started
#define CHIP_F_STAMP_Hz 84000000u   ///< TIM2: twice APB1, half the core

/// Core 168 MHz, APB1 42 MHz, APB2 84 MHz. False: an oscillator or the PLL does not come.
bool chip_clock_init(void);

/// The break input's pin. Before the break input is armed.
void chip_protection_init(float i_trip_A);

/// Always true: the driver's fault output cannot be activated by software.
bool chip_protection_test(void);

/// ADC1, ADC2 and ADC3, injected and simultaneous, two ranks each, on TIM1's TRGO. Always true: no failure is
/// detectable here.
bool chip_adc_init(void);

/// From now on a trigger raises the interrupt.
void chip_adc_arm(void);

/// Call before the next results.
static inline void chip_adc_acknowledge(void) {
    REG_WRITE(ADC1->SR, ~(uint32_t)(ADC_SR_JEOC | ADC_SR_JSTRT));
}

/// Switches the outputs off for good if no interrupt comes for one and a half times the time between two calls.
void chip_deadline_init(void);

/// Call in the interrupt: moves the deadline on.
static inline void chip_deadline_move(void) {
    REG_WRITE(TIM8->CNT, 0u);
}

/// BKP = 0: the fault input is active low. This timer has no filter on it.
#define CHIP_BREAK_BITS TIM_BDTR_BKE

/// ADC clock 21 MHz; 15 cycles of sampling, three from the trigger to it.
#define CHIP_SAMPLE_ns ((3.0f + 15.0f) / 21.0f * 1000.0f)

#endif
