#include "chip.h"
#include "sampling.h"

#define REVISION_V 0x2003u    // of the chip, the first with the ADC clock halved once more
#define CLOCK_BY_4 3u         // of the bus, and half of that: 25 MHz
#define DUAL_INJECTED 5u      // ADC2 follows ADC1's trigger
#define SAMPLE_8_5 2u         // cycles of 40 ns
#define TWELVE_BITS 2u        // CFGR.RES
#define RANKS 3u              // per ADC: equal lengths end together
#define RISING_EDGE 1u        // of
#define TRIGGER_TIM1_TRGO 0u  // the update event
#define REGULATOR_LOOPS 1000u // 20 us at 400 MHz with a few cycles per loop
#define READY_LOOPS 500u
#define BOOST_25_MHZ (2u << ADC_CR_BOOST_Pos) // above 12.5 MHz, up to 25
#define ON (ADC_CR_ADVREGEN | BOOST_25_MHZ)

// A lock-up of the core, or an uncorrectable flash error, is a break of TIM1 (RM0433,
// SYSCFG_CFGR). Cannot be undone before the next reset.
static void lockup_breaks(void) {
    REG_SET(RCC->APB4ENR, RCC_APB4ENR_SYSCFGEN);
    REG_SET(SYSCFG->CFGR, SYSCFG_CFGR_CM7L | SYSCFG_CFGR_FLASHL);
}

void chip_protection_init(float i_trip_A) {
    (void)i_trip_A; // the driver has its own threshold
    static const stm32_pin_t fault = VARIANT_BREAK_PIN;
    lockup_breaks();
    gpio_pull_up(fault); // open drain, active low
    gpio_alternate(fault);
    REG_WRITE(TIM1->AF1, TIM1_AF1_BKINE | TIM1_AF1_BKINP);
}

bool chip_protection_test(void) {
    return true;
}

static void sequence(ADC_TypeDef *adc, const uint32_t ranks[RANKS], uint32_t trigger) {
    const stm32_sampling_t times = stm32_sampling(ranks, RANKS, SAMPLE_8_5);
    REG_WRITE(adc->PCSEL, 1u << ranks[0] | 1u << ranks[1] | 1u << ranks[2]); // their switches
    REG_WRITE(adc->SMPR1, times.low);
    REG_WRITE(adc->SMPR2, times.high);
    REG_WRITE(adc->CFGR, TWELVE_BITS << ADC_CFGR_RES_Pos);
    REG_WRITE(adc->JSQR, (RANKS - 1u) << ADC_JSQR_JL_Pos | trigger | ranks[0] << ADC_JSQR_JSQ1_Pos |
                             ranks[1] << ADC_JSQR_JSQ2_Pos | ranks[2] << ADC_JSQR_JSQ3_Pos);
}

// Calibrated for offset and linearity.
static bool wake(ADC_TypeDef *adc) {
    REG_WRITE(adc->CR, 0u); // leaves deep power-down
    REG_WRITE(adc->CR, ON);
    stm32_wait(REGULATOR_LOOPS);
    REG_WRITE(adc->CR, ON | ADC_CR_ADCALLIN | ADC_CR_ADCAL);
    const bool ok = reg_await(&adc->CR, ADC_CR_ADCAL, 0u);
    stm32_wait(READY_LOOPS); // some ADC cycles between calibration and enable
    return ok;
}

static bool enable(ADC_TypeDef *adc) {
    REG_WRITE(adc->CR, ON | ADC_CR_ADEN);
    return reg_await(&adc->ISR, ADC_ISR_ADRDY, ADC_ISR_ADRDY);
}

bool chip_adc_init(void) {
    static const uint32_t ranks1[RANKS] = VARIANT_ADC1_RANKS;
    static const uint32_t ranks2[RANKS] = VARIANT_ADC2_RANKS;
    if (REG_READ(DBGMCU->IDCODE) >> 16 < REVISION_V) {
        return false;
    }
    REG_SET(RCC->AHB1ENR, RCC_AHB1ENR_ADC12EN);
    REG_WRITE(ADC12_COMMON->CCR,
              CLOCK_BY_4 << ADC_CCR_CKMODE_Pos | DUAL_INJECTED << ADC_CCR_DUAL_Pos);
    if (!wake(ADC1) || !wake(ADC2)) {
        return false;
    }
    if (!enable(ADC1) || !enable(ADC2)) {
        return false;
    }
    // Only while the ADCs are on, as the STM32G4's manual requires for the same unit.
    sequence(ADC1, ranks1,
             RISING_EDGE << ADC_JSQR_JEXTEN_Pos | TRIGGER_TIM1_TRGO << ADC_JSQR_JEXTSEL_Pos);
    sequence(ADC2, ranks2, 0u);
    REG_WRITE(ADC1->IER, ADC_IER_JEOSIE);
    return true;
}

void chip_adc_arm(void) {
    chip_adc_acknowledge();
    REG_WRITE(ADC1->CR, ON | ADC_CR_JADSTART); // starts both
}
