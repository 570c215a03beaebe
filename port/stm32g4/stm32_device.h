/// What the common STM32 code must know of the STM32G4.
#ifndef LODESTAR_PORT_STM32_DEVICE_H
#define LODESTAR_PORT_STM32_DEVICE_H

#include "stm32g4xx.h"

/// TIM1's flags of a break that has come.
#define STM32_BREAK_FLAGS (TIM_SR_BIF | TIM_SR_B2IF | TIM_SR_SBIF)

/// ADC1 and ADC2 share one interrupt.
#define STM32_PERIOD_IRQ 18
#define STM32_PERIOD_HANDLER ADC1_2_IRQHandler

#endif
