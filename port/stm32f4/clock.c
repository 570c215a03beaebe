#include "chip.h"
#include "supervise.h"

#define HSI_Hz 16000000u
#define PLL_INPUT_Hz 1000000u // 1 .. 2 MHz
#define PLL_N 336u            // VCO 336 MHz; P = 2 (code 0) makes 168 MHz, Q = 7 makes 48 MHz
#define PLL_Q 7u
#define SWITCH_PLL 2u
#define FLASH_WAIT_STATES 5u // 168 MHz at 2.7 .. 3.6 V
#define APB_BY_4 5u
#define APB_BY_2 4u

bool chip_clock_init(void) {
    bool ok = true;
    REG_SET(RCC->APB1ENR, RCC_APB1ENR_PWREN);
    REG_SET(PWR->CR, PWR_CR_VOS); // scale 1: more than 144 MHz
    REG_WRITE(FLASH->ACR, FLASH_WAIT_STATES | FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN);
    if (VARIANT_HSE_Hz != 0u) {
        REG_SET(RCC->CR, RCC_CR_HSEON);
        ok = reg_await(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY);
    }
    const uint32_t source_Hz = VARIANT_HSE_Hz != 0u ? VARIANT_HSE_Hz : HSI_Hz;
    REG_WRITE(RCC->PLLCFGR, source_Hz / PLL_INPUT_Hz << RCC_PLLCFGR_PLLM_Pos |
                                PLL_N << RCC_PLLCFGR_PLLN_Pos | PLL_Q << RCC_PLLCFGR_PLLQ_Pos |
                                (VARIANT_HSE_Hz != 0u ? RCC_PLLCFGR_PLLSRC_HSE : 0u));
    REG_SET(RCC->CR, RCC_CR_PLLON);
    if (!reg_await(&RCC->CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY) || !ok) {
        return false;
    }
    // Set the dividers before the switch, so that no bus is ever too fast.
    REG_WRITE(RCC->CFGR, APB_BY_4 << RCC_CFGR_PPRE1_Pos | APB_BY_2 << RCC_CFGR_PPRE2_Pos);
    REG_CHANGE(RCC->CFGR, RCC_CFGR_SW, SWITCH_PLL << RCC_CFGR_SW_Pos);
    const bool switched = reg_await(&RCC->CFGR, RCC_CFGR_SWS, SWITCH_PLL << RCC_CFGR_SWS_Pos);
    stm32_clock_watch();
    return switched;
}
