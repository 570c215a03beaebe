/// What the common STM32 code must know of the STM32F4.
#ifndef LODESTAR_PORT_STM32_DEVICE_H
#define LODESTAR_PORT_STM32_DEVICE_H

#include "stm32f4xx.h"

/// TIM1's flag of a break that has come.
#define STM32_BREAK_FLAGS TIM_SR_BIF

#ifdef LODE_EMULATED
#define STM32_PERIOD_IRQ 28 ///< TIM2
#define STM32_PERIOD_HANDLER TIM2_IRQHandler
#else
#define STM32_PERIOD_IRQ 18 ///< ADC1, ADC2 and ADC3
#define STM32_PERIOD_HANDLER ADC_IRQHandler
#endif

#endif
