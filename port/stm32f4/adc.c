#include "chip.h"
#include "sampling.h"

#define CLOCK_BY_4 1u        // APB2/4: 21 MHz of at most 36
#define TRIPLE_INJECTED 21u  // ADC2 and ADC3 follow ADC1's trigger
#define SAMPLE_15 1u         // cycles of 48 ns
#define RISING_EDGE 1u       // of
#define TRIGGER_TIM1_TRGO 1u // the update event
#define RANKS 2u
#define STABLE_LOOPS 200u // 3 us at 168 MHz with a few cycles per loop

// With a length of two the ranks are the sequence's third and fourth; their results are JDR1 and JDR2.
static void set_up(ADC_TypeDef *adc, const uint32_t ranks[RANKS], uint32_t cr2) {
    const stm32_sampling_t times = stm32_sampling(ranks, RANKS, SAMPLE_15);
    REG_WRITE(adc->SMPR1, times.high); // reversed compared with other families
    REG_WRITE(adc->SMPR2, times.low);
    REG_WRITE(adc->JSQR, (RANKS - 1u) << ADC_JSQR_JL_Pos | ranks[0] << ADC_JSQR_JSQ3_Pos |
                             ranks[1] << ADC_JSQR_JSQ4_Pos);
    REG_WRITE(adc->CR1, ADC_CR1_SCAN);
    REG_WRITE(adc->CR2, ADC_CR2_ADON | cr2);
}

void chip_protection_init(float i_trip_A) {
    (void)i_trip_A; // the driver has its own threshold
    static const stm32_pin_t fault = VARIANT_BREAK_PIN;
    gpio_pull_up(fault); // open drain, active low
    gpio_alternate(fault);
}

bool chip_protection_test(void) {
    return true;
}

bool chip_adc_init(void) {
    static const uint32_t ranks1[RANKS] = VARIANT_ADC1_RANKS;
    static const uint32_t ranks2[RANKS] = VARIANT_ADC2_RANKS;
    static const uint32_t ranks3[RANKS] = VARIANT_ADC3_RANKS;
    REG_SET(RCC->APB2ENR, RCC_APB2ENR_ADC1EN | RCC_APB2ENR_ADC2EN | RCC_APB2ENR_ADC3EN);
    REG_WRITE(ADC123_COMMON->CCR,
              CLOCK_BY_4 << ADC_CCR_ADCPRE_Pos | TRIPLE_INJECTED << ADC_CCR_MULTI_Pos);
    set_up(ADC2, ranks2, 0u);
    set_up(ADC3, ranks3, 0u);
    set_up(ADC1, ranks1,
           RISING_EDGE << ADC_CR2_JEXTEN_Pos | TRIGGER_TIM1_TRGO << ADC_CR2_JEXTSEL_Pos);
    stm32_wait(STABLE_LOOPS);
    return true;
}

void chip_adc_arm(void) {
    chip_adc_acknowledge();
    REG_SET(ADC1->CR1, ADC_CR1_JEOCIE);
}
