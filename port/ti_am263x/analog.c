#include "chip.h"

#define SETTLE_us 100u
#define POWER_UP_us 1000u
// The comparators' filter: eight of ten samples, one every 50 ns: a trip takes 0.4 us of over-current.
#define FILTER_CLOCKS (10u - 1u) // the register holds this minus one
#define FILTER FILCTL(10u, 8u)
#define REFERENCES_ON 7u
#define REFERENCES_COMPARED 0x777u // of all five ADCs

typedef struct {
    uint32_t adc;
    uint32_t channel;
    uint32_t comparator;
} current_t;

static const current_t currents[CHIP_PHASES] = {VARIANT_CURRENTS};
static const uint32_t pwm[CHIP_PHASES] = VARIANT_PWM;

void chip_comparator_set(uint32_t phase, uint16_t high, uint16_t low) {
    const uint32_t base = CMPSSB(currents[phase].comparator);
    reg_write16(base + CMPSS_DACHVALS, high);
    reg_write16(base + CMPSS_DACLVALS, low);
}

// Both signs of the current: above the high threshold, or (inverted) below the low one.
static void comparator(uint32_t base) {
    reg_write16(base + CMPSS_HFILCLK, FILTER_CLOCKS);
    reg_write16(base + CMPSS_LFILCLK, FILTER_CLOCKS);
    reg_write16(base + CMPSS_COMPCTL,
                COMPCTL_ON | COMPCTL_HIGH_FILTERED | COMPCTL_LOW_FILTERED_INVERTED);
}

void chip_protection_init(float i_trip_A) {
    uint32_t ways = 0u;
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        // Full scale is VDDA; values act at once.
        reg_write16(CMPSSB(currents[n].comparator) + CMPSS_DACCTL, 0u);
    }
    ti_set_trip(i_trip_A);
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        comparator(CMPSSB(currents[n].comparator));
        ways |= PWMXBAR_CMPSSB(currents[n].comparator);
    }
    chip_wait_us(SETTLE_us); // the thresholds must settle before they are used
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        reg_write16(CMPSSB(currents[n].comparator) + CMPSS_HFILCTL, FILTER | FILCTL_INIT);
        reg_write16(CMPSSB(currents[n].comparator) + CMPSS_LFILCTL, FILTER | FILCTL_INIT);
    }
    reg_write32(PWMXBAR0_G1, ways);
    reg_write32(IOMUX_PAD(VARIANT_FAULT_GPIO), PAD_PULL_UP | PAD_GPIO); // open drain
    reg_write32(INPUTXBAR0_GSEL, 0u);
    reg_write32(INPUTXBAR0_G0, VARIANT_FAULT_GPIO);
    reg_write32(PWMXBAR1_G4, PWMXBAR_INPUT0);
}

void chip_adc_init(void) {
    reg_write32(TOP_KICK0, KICK0_UNLOCK);
    reg_write32(TOP_KICK1, KICK1_UNLOCK);
    reg_write16(TOP_ADC_REFBUF0, REFERENCES_ON);
    reg_write16(TOP_ADC_REFBUF1, REFERENCES_ON);
    reg_write16(TOP_ADC_REFCOMP, REFERENCES_COMPARED);
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        const uint32_t adc = ADC(currents[n].adc);
        reg_write16(adc + ADC_CTL2, ADCCTL2_CLOCK_BY_4);
        reg_write16(adc + ADC_CTL1, ADCCTL1_END_OF_CONVERSION | ADCCTL1_POWER);
        reg_write16(adc + ADC_SOCPRICTL, ADCSOCPRI_ALL); // number 0 first
    }
    chip_wait_us(POWER_UP_us);
    const uint32_t trigger = ADC_TRIGGER_EPWM_SOCA(pwm[0]);
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        reg_write32(ADC(currents[n].adc) + ADC_SOC(0),
                    ADCSOC(trigger, currents[n].channel, CHIP_WINDOW_cycles));
    }
    reg_write32(ADC(VARIANT_BUS_ADC) + ADC_SOC(1),
                ADCSOC(trigger, VARIANT_BUS_CHANNEL, CHIP_WINDOW_cycles));
#ifdef VARIANT_T_CHANNEL
    reg_write32(ADC(VARIANT_T_ADC) + ADC_SOC(1),
                ADCSOC(trigger, VARIANT_T_CHANNEL, CHIP_WINDOW_cycles));
#endif
    reg_write16(ADC(VARIANT_BUS_ADC) + ADC_INTFLGCLR, ADCINT1);
    reg_write16(ADC(VARIANT_BUS_ADC) + ADC_INTSEL1N2, ADCINTSEL_INT1_SOC1);
    reg_write32(INTXBAR0_G2, INTXBAR_ADC_INT1(VARIANT_BUS_ADC));
}

LODE_RAMFUNC uint16_t chip_current(uint32_t phase) {
    return reg_read16(ADC_RESULT(currents[phase].adc, 0));
}

LODE_RAMFUNC uint16_t chip_bus(void) {
    return reg_read16(ADC_RESULT(VARIANT_BUS_ADC, 1));
}

LODE_RAMFUNC uint16_t chip_temperature(void) {
#ifdef VARIANT_T_CHANNEL
    return reg_read16(ADC_RESULT(VARIANT_T_ADC, 1));
#else
    return 0u;
#endif
}

LODE_RAMFUNC bool chip_adc_acknowledge(void) {
    const uint32_t adc = ADC(VARIANT_BUS_ADC);
    reg_write16(adc + ADC_INTFLGCLR, ADCINT1);
    const bool missed = (reg_read16(adc + ADC_INTOVF) & ADCINT1) != 0u;
    if (missed) {
        reg_write16(adc + ADC_INTOVFCLR, ADCINT1); // left set, it blocks every later one
        reg_write16(adc + ADC_INTFLGCLR, ADCINT1);
    }
    return !missed;
}
