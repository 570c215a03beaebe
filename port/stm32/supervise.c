#include "supervise.h"

#include "chip.h"

// LSI / 4 is about 8 kHz.
#define WATCHDOG_DIVIDER 0u
#define WATCHDOG_RELOAD 160u

bool stm32_reset_by_watchdog(void) {
    const bool by_watchdog = (REG_READ(STM32_RESET_CAUSE) & STM32_RESET_BY_WATCHDOG) != 0u;
    REG_SET(STM32_RESET_CAUSE, STM32_RESET_FORGET);
    return by_watchdog;
}

void stm32_clock_watch(void) {
    if (VARIANT_HSE_Hz != 0u) {
        REG_SET(RCC->CR, STM32_CLOCK_WATCH);
    }
}

bool stm32_watchdog_init(void) {
    REG_SET(RCC->CSR, RCC_CSR_LSION);
    return reg_await(&RCC->CSR, RCC_CSR_LSIRDY, RCC_CSR_LSIRDY);
}

void stm32_watchdog_start(void) {
    REG_WRITE(STM32_WATCHDOG->KR, 0xCCCCu); // starts it, and its clock
    REG_WRITE(STM32_WATCHDOG->KR, 0x5555u); // unlocks the next two
    REG_WRITE(STM32_WATCHDOG->PR, WATCHDOG_DIVIDER);
    REG_WRITE(STM32_WATCHDOG->RLR, WATCHDOG_RELOAD);
    (void)reg_await(&STM32_WATCHDOG->SR, UINT32_MAX, 0u); // divider and reload are taken
    stm32_watchdog_feed();
}

void stm32_stamp_start(void) {
    REG_SET(STM32_APB1_CLOCKS, STM32_TIM2_CLOCK);
    REG_WRITE(TIM2->CR1, 0u);
    REG_WRITE(TIM2->PSC, 0u);
    REG_WRITE(TIM2->ARR, UINT32_MAX);
    REG_WRITE(TIM2->EGR, TIM_EGR_UG); // loads the prescaler
    REG_WRITE(TIM2->CR1, TIM_CR1_CEN);
}
