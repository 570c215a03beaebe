#include "chip.h"
#include "figures.h"
#include "pwm.h"
#include "sampling.h"

#define CLOCK_BY_4 3u         // 42.5 MHz; at most 52 with two ADCs in use
#define DUAL_INJECTED 5u      // ADC2 follows ADC1's trigger
#define SAMPLE_6_5 1u         // cycles of 23.5 ns
#define RANKS 3u              // per ADC: equal lengths end together
#define RISING_EDGE 1u        // of
#define TRIGGER_TIM1_TRGO 0u  // the update event
#define REGULATOR_LOOPS 1000u // 20 us at 170 MHz with a few cycles per loop
#define READY_LOOPS 100u

// A lock-up of the core, or an uncorrectable flash error, is a break of TIM1 (RM0440,
// SYSCFG_CFGR2). Cannot be undone before the next reset.
static void lockup_breaks(void) {
    REG_SET(RCC->APB2ENR, RCC_APB2ENR_SYSCFGEN);
    REG_SET(SYSCFG->CFGR2, SYSCFG_CFGR2_CLL | SYSCFG_CFGR2_ECCL);
}

#ifdef VARIANT_INTERNAL_ANALOG

#define AMPLIFIER_PGA 2u     // VMSEL
#define GAIN_16_BIASED 0x0Bu // PGGAIN: 16, low end of the divider on VINM0
#define MINUS_DAC3 4u        // INMSEL: channel 1 for comparator 1, channel 2 for 2 and 4
#define DAC_INTERNAL 3u      // MODE: to the chip only, no buffer
#define DAC_FAST 2u          // HFSEL: AHB above 160 MHz
#define DAC_RANGE 4095.0f
// 20 us at 170 MHz; DAC, comparator and break filter together take about 2 us
#define DAC_LOOPS 1000u

static void amplifier(OPAMP_TypeDef *unit) {
    REG_WRITE(unit->CSR, AMPLIFIER_PGA << OPAMP_CSR_VMSEL_Pos |
                             GAIN_16_BIASED << OPAMP_CSR_PGGAIN_Pos | OPAMP_CSR_HIGHSPEEDEN);
    REG_SET(unit->CSR, OPAMP_CSR_OPAMPxEN);
}

static void comparator(COMP_TypeDef *unit) {
    REG_WRITE(unit->CSR, MINUS_DAC3 << COMP_CSR_INMSEL_Pos | COMP_CSR_EN);
}

static uint32_t threshold; // count of DAC3

void chip_protection_init(float i_trip_A) {
    const float trip_A = port_trip_A(i_trip_A, VARIANT_TRIP_MIN_A, VARIANT_TRIP_MAX_A);
    threshold = (uint32_t)(int32_t)(VARIANT_TRIP_V(trip_A) / VARIANT_V_REF_V * DAC_RANGE + 0.5f);
    lockup_breaks(); // also clocks amplifiers and comparators
    REG_SET(RCC->AHB2ENR, RCC_AHB2ENR_DAC3EN);
    amplifier(OPAMP1);
    amplifier(OPAMP2);
    amplifier(OPAMP3);
    REG_WRITE(DAC3->MCR, DAC_FAST << DAC_MCR_HFSEL_Pos | DAC_INTERNAL << DAC_MCR_MODE1_Pos |
                             DAC_INTERNAL << DAC_MCR_MODE2_Pos);
    REG_WRITE(DAC3->CR, DAC_CR_EN1 | DAC_CR_EN2);
    REG_WRITE(DAC3->DHR12R1, threshold);
    REG_WRITE(DAC3->DHR12R2, threshold);
    stm32_wait(REGULATOR_LOOPS); // the threshold must settle before it is compared
    comparator(COMP1);
    comparator(COMP2);
    comparator(COMP4);
    REG_WRITE(TIM1->AF1, TIM1_AF1_BKCMP1E | TIM1_AF1_BKCMP2E | TIM1_AF1_BKCMP4E);
}

static bool is_high(const COMP_TypeDef *unit) {
    return (REG_READ(unit->CSR) & COMP_CSR_VALUE) != 0u;
}

bool chip_protection_test(void) {
    REG_WRITE(DAC3->DHR12R1, 0u);
    stm32_wait(DAC_LOOPS);
    const bool first = stm32_pwm_tripped() && is_high(COMP1) && !is_high(COMP2) && !is_high(COMP4);
    REG_WRITE(DAC3->DHR12R1, threshold);
    stm32_wait(DAC_LOOPS);
    const bool cleared = stm32_pwm_clear_trip();
    REG_WRITE(DAC3->DHR12R2, 0u);
    stm32_wait(DAC_LOOPS);
    const bool others = stm32_pwm_tripped() && !is_high(COMP1) && is_high(COMP2) && is_high(COMP4);
    REG_WRITE(DAC3->DHR12R2, threshold);
    stm32_wait(DAC_LOOPS);
    return stm32_pwm_clear_trip() && first && cleared && others;
}

#else

static void break_pin(stm32_pin_t pin) {
    gpio_pull_up(pin); // active low: a broken wire would not trip, the board's own pull-up decides
    gpio_alternate(pin);
}

void chip_protection_init(float i_trip_A) {
    (void)i_trip_A; // the driver has its own threshold
    static const stm32_pin_t pin = VARIANT_BREAK_PIN;
    lockup_breaks();
    break_pin(pin);
    REG_WRITE(TIM1->AF1, TIM1_AF1_BKINE | TIM1_AF1_BKINP); // the pin is active low
#ifdef VARIANT_BREAK2_PIN
    static const stm32_pin_t pin2 = VARIANT_BREAK2_PIN;
    break_pin(pin2);
    REG_WRITE(TIM1->AF2, TIM1_AF2_BK2INE | TIM1_AF2_BK2INP);
#endif
}

bool chip_protection_test(void) {
    return true; // the driver's fault output cannot be activated by software
}

#endif

static bool wake(ADC_TypeDef *adc) {
    REG_WRITE(adc->CR, 0u); // leaves deep power-down
    REG_WRITE(adc->CR, ADC_CR_ADVREGEN);
    stm32_wait(REGULATOR_LOOPS);
    REG_WRITE(adc->CR, ADC_CR_ADVREGEN | ADC_CR_ADCAL);
    const bool ok = reg_await(&adc->CR, ADC_CR_ADCAL, 0u);
    stm32_wait(READY_LOOPS); // four ADC cycles between calibration and enable
    return ok;
}

static bool enable(ADC_TypeDef *adc) {
    REG_WRITE(adc->CR, ADC_CR_ADVREGEN | ADC_CR_ADEN);
    return reg_await(&adc->ISR, ADC_ISR_ADRDY, ADC_ISR_ADRDY);
}

static void sampling(ADC_TypeDef *adc, const uint32_t *channels, uint32_t count) {
    const stm32_sampling_t times = stm32_sampling(channels, count, SAMPLE_6_5);
    REG_WRITE(adc->SMPR1, times.low);
    REG_WRITE(adc->SMPR2, times.high);
}

#ifdef VARIANT_LINK

#define MODE 0u // each ADC on its own trigger

static void sequences(void) {
    static const uint32_t link[] = {VARIANT_LINK_CHANNEL};
    static const uint32_t slow[] = {VARIANT_BUS_CHANNEL, VARIANT_T_CHANNEL};
    sampling(ADC1, link, 1u);
    sampling(ADC2, slow, 2u);
    chip_link_adcs();
}

#else

#define MODE DUAL_INJECTED

static void sequence(ADC_TypeDef *adc, const uint32_t ranks[RANKS], uint32_t trigger) {
    sampling(adc, ranks, RANKS);
    REG_WRITE(adc->JSQR, (RANKS - 1u) << ADC_JSQR_JL_Pos | trigger | ranks[0] << ADC_JSQR_JSQ1_Pos |
                             ranks[1] << ADC_JSQR_JSQ2_Pos | ranks[2] << ADC_JSQR_JSQ3_Pos);
}

static void sequences(void) {
    static const uint32_t ranks1[RANKS] = VARIANT_ADC1_RANKS;
    static const uint32_t ranks2[RANKS] = VARIANT_ADC2_RANKS;
    sequence(ADC1, ranks1,
             RISING_EDGE << ADC_JSQR_JEXTEN_Pos | TRIGGER_TIM1_TRGO << ADC_JSQR_JEXTSEL_Pos);
    sequence(ADC2, ranks2, 0u);
    REG_WRITE(ADC1->IER, ADC_IER_JEOSIE);
}

#endif

bool chip_adc_init(void) {
    REG_SET(RCC->AHB2ENR, RCC_AHB2ENR_ADC12EN);
    REG_WRITE(ADC12_COMMON->CCR, CLOCK_BY_4 << ADC_CCR_CKMODE_Pos); // the clock of the calibration
    if (!wake(ADC1) || !wake(ADC2)) {
        return false;
    }
    REG_WRITE(ADC12_COMMON->CCR,
              CLOCK_BY_4 << ADC_CCR_CKMODE_Pos | MODE << ADC_CCR_DUAL_Pos); // while both are off
    if (!enable(ADC1) || !enable(ADC2)) {
        return false;
    }
    sequences(); // only while the ADC is on (RM0440, constraints when writing the ADC control bits)
    return true;
}

void chip_adc_arm(void) {
    chip_adc_acknowledge();
    REG_WRITE(ADC1->CR, ADC_CR_ADVREGEN | ADC_CR_JADSTART); // starts both of a dual mode
#ifdef VARIANT_LINK
    REG_WRITE(ADC2->CR, ADC_CR_ADVREGEN | ADC_CR_JADSTART);
#endif
}
