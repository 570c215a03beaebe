#include "supervise.h"

#include "chip.h"

// LSI / 4 is some 8 kHz.
#define WATCHDOG_DIVIDER 0u
#define WATCHDOG_RELOAD 160u

bool stm32_reset_by_watchdog(void) {
    const bool by_watchdog = (REG_READ(RCC->CSR) & (RCC_CSR_IWDGRSTF | RCC_CSR_WWDGRSTF)) != 0u;
    REG_SET(RCC->CSR, RCC_CSR_RMVF);
    return by_watchdog;
}

void stm32_clock_watch(void) {
    if (VARIANT_HSE_Hz != 0u) {
        REG_SET(RCC->CR, RCC_CR_CSSON);
    }
}

bool stm32_watchdog_init(void) {
    REG_SET(RCC->CSR, RCC_CSR_LSION);
    return reg_await(&RCC->CSR, RCC_CSR_LSIRDY, RCC_CSR_LSIRDY);
}

void stm32_watchdog_start(void) {
    REG_WRITE(IWDG->KR, 0xCCCCu); // starts it, and its clock
    REG_WRITE(IWDG->KR, 0x5555u); // unlocks the next two
    REG_WRITE(IWDG->PR, WATCHDOG_DIVIDER);
    REG_WRITE(IWDG->RLR, WATCHDOG_RELOAD);
    (void)reg_await(&IWDG->SR, UINT32_MAX, 0u); // divider and reload are taken
    stm32_watchdog_feed();
}

void stm32_stamp_start(void) {
    REG_SET(STM32_APB1_CLOCKS, STM32_TIM2_CLOCK);
    REG_WRITE(TIM2->CR1, 0u);
    REG_WRITE(TIM2->PSC, 0u);
    REG_WRITE(TIM2->ARR, UINT32_MAX);
    REG_WRITE(TIM2->EGR, TIM_EGR_UG); // takes the prescaler over
    REG_WRITE(TIM2->CR1, TIM_CR1_CEN);
}
