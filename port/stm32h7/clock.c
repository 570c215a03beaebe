#include "chip.h"
#include "supervise.h"

#define HSI_Hz 64000000u
#define PLL_INPUT_Hz 2000000u
#define PLL_INPUT_2_4_MHZ 1u
#define PLL_N 400u // VCO 800 MHz; P = 2 gives 400 MHz
#define PLL_P 2u
#define PLL_SOURCE_HSE 2u
#define SWITCH_PLL 3u
#define SCALE_1 3u           // VOS1: up to 400 MHz
#define FLASH_WAIT_STATES 2u // 200 MHz of bus in scale 1
#define FLASH_SIGNAL_DELAY 2u
#define AHB_BY_2 8u
#define APB_BY_2 4u

// Of the core (Cortex-M7): invalidate all, then on.
#define SCB_ICIALLU_AT 0xE000EF50u
#define SCB_CCR_AT 0xE000ED14u
#define SCB_CCR_ICACHE (1u << 17)

// Code outside the ITCM runs from flash. The data cache stays off: data are in the DTCM, which is not cached,
// and DMA buffers need no cache maintenance.
static void instruction_cache_on(void) {
#ifdef __arm__
    *(volatile uint32_t *)SCB_ICIALLU_AT = 0u;
    __asm volatile("dsb\n isb" ::: "memory");
    *(volatile uint32_t *)SCB_CCR_AT |= SCB_CCR_ICACHE;
    __asm volatile("dsb\n isb" ::: "memory");
#endif
}

// The regulator's supply is fixed by the first write to CR3, before any other scale.
static bool core_voltage(void) {
    REG_CHANGE(PWR->CR3, PWR_CR3_SCUEN, PWR_CR3_LDOEN);
    const bool ok = reg_await(&PWR->CSR1, PWR_CSR1_ACTVOSRDY, PWR_CSR1_ACTVOSRDY);
    REG_CHANGE(PWR->D3CR, PWR_D3CR_VOS, SCALE_1 << PWR_D3CR_VOS_Pos);
    return reg_await(&PWR->D3CR, PWR_D3CR_VOSRDY, PWR_D3CR_VOSRDY) && ok;
}

static void dividers(void) {
    REG_WRITE(RCC->D1CFGR, AHB_BY_2 << RCC_D1CFGR_HPRE_Pos | APB_BY_2 << RCC_D1CFGR_D1PPRE_Pos);
    REG_WRITE(RCC->D2CFGR, APB_BY_2 << RCC_D2CFGR_D2PPRE1_Pos | APB_BY_2 << RCC_D2CFGR_D2PPRE2_Pos);
    REG_WRITE(RCC->D3CFGR, APB_BY_2 << RCC_D3CFGR_D3PPRE_Pos);
}

bool chip_clock_init(void) {
    instruction_cache_on();
    bool ok = core_voltage();
    if (VARIANT_HSE_Hz != 0u) {
        REG_SET(RCC->CR, RCC_CR_HSEON);
        ok = reg_await(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY) && ok;
    }
    const uint32_t source_Hz = VARIANT_HSE_Hz != 0u ? VARIANT_HSE_Hz : HSI_Hz;
    REG_WRITE(RCC->PLLCKSELR, source_Hz / PLL_INPUT_Hz << RCC_PLLCKSELR_DIVM1_Pos |
                                  (VARIANT_HSE_Hz != 0u ? PLL_SOURCE_HSE : 0u));
    REG_WRITE(RCC->PLLCFGR,
              PLL_INPUT_2_4_MHZ << RCC_PLLCFGR_PLL1RGE_Pos | RCC_PLLCFGR_DIVP1EN); // wide VCO
    REG_WRITE(RCC->PLL1DIVR, (PLL_N - 1u) << RCC_PLL1DIVR_N1_Pos | (PLL_P - 1u)
                                                                       << RCC_PLL1DIVR_P1_Pos);
    REG_SET(RCC->CR, RCC_CR_PLL1ON);
    if (!reg_await(&RCC->CR, RCC_CR_PLL1RDY, RCC_CR_PLL1RDY) || !ok) {
        return false;
    }
    // Set wait states and dividers before the switch, so that no bus is ever too fast.
    const uint32_t access = FLASH_WAIT_STATES | FLASH_SIGNAL_DELAY << FLASH_ACR_WRHIGHFREQ_Pos;
    REG_WRITE(FLASH->ACR, access);
    ok = reg_await(&FLASH->ACR, UINT32_MAX, access);
    dividers();
    REG_CHANGE(RCC->CFGR, RCC_CFGR_SW, SWITCH_PLL << RCC_CFGR_SW_Pos);
    ok = reg_await(&RCC->CFGR, RCC_CFGR_SWS, SWITCH_PLL << RCC_CFGR_SWS_Pos) && ok;
    stm32_clock_watch();
    return ok;
}
