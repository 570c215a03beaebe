#include "chip.h"
#include "supervise.h"

#define HSI_Hz 16000000u
#define PLL_INPUT_Hz 4000000u // 2.66 .. 16 MHz; divides every source in use
#define PLL_N 85u             // 340 MHz; R = 2 gives 170 MHz
#define PLL_SOURCE_HSI 2u
#define PLL_SOURCE_HSE 3u
#define SWITCH_PLL 3u
#define FLASH_WAIT_STATES 4u // 170 MHz in range 1 boost
#define HALF_SPEED 8u        // HPRE: AHB = SYSCLK/2
#define BOOST_LOOPS 100u     // at least 1 us at half speed

bool chip_clock_init(void) {
    REG_SET(RCC->APB1ENR1, RCC_APB1ENR1_PWREN);
    // Pull-downs for a USB-C port with a dead battery, on PB4 and PB6 after a reset (RM0440, PWR_CR3).
    REG_SET(PWR->CR3, PWR_CR3_UCPD_DBDIS);
    REG_CLEAR(PWR->CR5, PWR_CR5_R1MODE); // boost: more than 150 MHz
    REG_CHANGE(FLASH->ACR, FLASH_ACR_LATENCY, FLASH_WAIT_STATES);
    bool ok = reg_await(&FLASH->ACR, FLASH_ACR_LATENCY, FLASH_WAIT_STATES);
    REG_SET(FLASH->ACR, FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN);
    if (VARIANT_HSE_Hz != 0u) {
        REG_SET(RCC->CR, RCC_CR_HSEON);
        ok = reg_await(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY) && ok;
    }
    const uint32_t source_Hz = VARIANT_HSE_Hz != 0u ? VARIANT_HSE_Hz : HSI_Hz;
    const uint32_t source = VARIANT_HSE_Hz != 0u ? PLL_SOURCE_HSE : PLL_SOURCE_HSI;
    REG_WRITE(RCC->PLLCFGR, source << RCC_PLLCFGR_PLLSRC_Pos |
                                (source_Hz / PLL_INPUT_Hz - 1u) << RCC_PLLCFGR_PLLM_Pos |
                                PLL_N << RCC_PLLCFGR_PLLN_Pos | RCC_PLLCFGR_PLLREN);
    REG_SET(RCC->CR, RCC_CR_PLLON);
    if (!reg_await(&RCC->CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY) || !ok) {
        return false;
    }
    // Above 80 MHz the bus clock is raised in two steps.
    REG_CHANGE(RCC->CFGR, RCC_CFGR_HPRE, HALF_SPEED << RCC_CFGR_HPRE_Pos);
    REG_CHANGE(RCC->CFGR, RCC_CFGR_SW, SWITCH_PLL << RCC_CFGR_SW_Pos);
    ok = reg_await(&RCC->CFGR, RCC_CFGR_SWS, SWITCH_PLL << RCC_CFGR_SWS_Pos);
    stm32_wait(BOOST_LOOPS);
    REG_CLEAR(RCC->CFGR, RCC_CFGR_HPRE | RCC_CFGR_PPRE1 | RCC_CFGR_PPRE2);
    stm32_clock_watch();
    return ok;
}
