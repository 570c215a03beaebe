#include "chip.h"

#define BIAS_count 2048u // of DACB: half of the reference, 1.65 V with its gain of 2
#define SETTLE_us 100u   // amplifiers, DACs and the bias's capacitor
#define POWER_UP_us 1000u
// The comparators' filter: eight of ten samples, one every 50 ns: a trip takes 0.4 us of over-current.
#define FILTER_CLOCKS (5u - 1u) // the register holds this minus one
#define FILTER_WINDOW 10u
#define FILTER_THRESHOLD 8u

typedef struct {
    uint32_t base;
    SysCtl_PeripheralPCLOCKCR clock;
    ASysCtl_CMPHPMuxSelect high;
    ASysCtl_CMPLPMuxSelect low;
    XBAR_EPWMMuxConfig way;
    uint32_t way_bit;
} comparator_t;

typedef struct {
    uint32_t adc;
    uint32_t result;
    ADC_Channel channel;
} current_t;

static const comparator_t comparators[CHIP_PHASES] = {VARIANT_COMPARATORS};
static const current_t currents[CHIP_PHASES] = {VARIANT_CURRENTS};

static void amplifiers(void) {
    static const uint32_t amplifier[CHIP_PHASES] = VARIANT_PGA;
    static const SysCtl_PeripheralPCLOCKCR clocks[CHIP_PHASES] = VARIANT_PGA_CLOCKS;
    SysCtl_enablePeripheral(SYSCTL_PERIPH_CLK_DACB);
    DAC_setReferenceVoltage(DACB_BASE, DAC_REF_ADC_VREFHI);
    DAC_setGainMode(DACB_BASE, DAC_GAIN_TWO);
    DAC_setLoadMode(DACB_BASE, DAC_LOAD_SYSCLK);
    DAC_setShadowValue(DACB_BASE, BIAS_count);
    DAC_enableOutput(DACB_BASE);
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        SysCtl_enablePeripheral(clocks[n]);
        PGA_setGain(amplifier[n], PGA_GAIN_12);
        PGA_setFilterResistor(amplifier[n], PGA_LOW_PASS_FILTER_DISABLED);
        PGA_enable(amplifier[n]);
    }
}

void chip_comparator_set(uint32_t phase, uint16_t high, uint16_t low) {
    CMPSS_setDACValueHigh(comparators[phase].base, high);
    CMPSS_setDACValueLow(comparators[phase].base, low);
}

static void comparator_inputs(const comparator_t *c) {
    SysCtl_enablePeripheral(c->clock);
    ASysCtl_selectCMPHPMux(c->high, VARIANT_COMPARATOR_INPUT);
    ASysCtl_selectCMPLPMux(c->low, VARIANT_COMPARATOR_INPUT);
    CMPSS_configDAC(c->base, CMPSS_DACREF_VDDA | CMPSS_DACVAL_SYSCLK | CMPSS_DACSRC_SHDW);
}

// Both signs of the current: above the high threshold, or (inverted) below the low one.
static void comparator(const comparator_t *c) {
    CMPSS_configHighComparator(c->base, CMPSS_INSRC_DAC);
    CMPSS_configLowComparator(c->base, CMPSS_INSRC_DAC | CMPSS_INV_INVERTED);
    CMPSS_configFilterHigh(c->base, FILTER_CLOCKS, FILTER_WINDOW, FILTER_THRESHOLD);
    CMPSS_configFilterLow(c->base, FILTER_CLOCKS, FILTER_WINDOW, FILTER_THRESHOLD);
    CMPSS_configOutputsHigh(c->base, CMPSS_TRIP_FILTER | CMPSS_TRIPOUT_FILTER);
    CMPSS_configOutputsLow(c->base, CMPSS_TRIP_FILTER | CMPSS_TRIPOUT_FILTER);
    CMPSS_enableModule(c->base);
}

void chip_protection_init(float i_trip_A) {
    amplifiers();
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        comparator_inputs(&comparators[n]);
    }
    ti_set_trip(i_trip_A);
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        comparator(&comparators[n]);
    }
    chip_wait_us(SETTLE_us); // the thresholds must settle before they are used
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        CMPSS_initFilterHigh(comparators[n].base);
        CMPSS_initFilterLow(comparators[n].base);
        XBAR_setEPWMMuxConfig(XBAR_TRIP4, comparators[n].way);
        XBAR_enableEPWMMux(XBAR_TRIP4, comparators[n].way_bit);
    }
    GPIO_setPadConfig(VARIANT_FAULT_GPIO, GPIO_PIN_TYPE_PULLUP); // open drain
    GPIO_setQualificationMode(VARIANT_FAULT_GPIO, GPIO_QUAL_ASYNC);
    GPIO_setDirectionMode(VARIANT_FAULT_GPIO, GPIO_DIR_MODE_IN);
    GPIO_setPinConfig(VARIANT_FAULT_PIN);
    XBAR_setInputPin(XBAR_INPUT1, VARIANT_FAULT_GPIO); // input 1 is TZ1, active low
    XBAR_lockInput(XBAR_INPUT1);
}

void chip_adc_init(void) {
    static const SysCtl_PeripheralPCLOCKCR clocks[CHIP_PHASES] = {
        SYSCTL_PERIPH_CLK_ADCA, SYSCTL_PERIPH_CLK_ADCB, SYSCTL_PERIPH_CLK_ADCC};
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        SysCtl_enablePeripheral(clocks[n]);
    }
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        const uint32_t adc = currents[n].adc;
        ADC_setVREF(adc, ADC_REFERENCE_INTERNAL, ADC_REFERENCE_3_3V);
        ADC_setPrescaler(adc, ADC_CLK_DIV_2_0);
        ADC_setInterruptPulseMode(adc, ADC_PULSE_END_OF_CONV);
        ADC_enableConverter(adc);
        ADC_setSOCPriority(adc, ADC_PRI_ALL_HIPRI); // number 0 first
    }
    chip_wait_us(POWER_UP_us);
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        ADC_setupSOC(currents[n].adc, ADC_SOC_NUMBER0, VARIANT_TRIGGER, currents[n].channel,
                     CHIP_WINDOW_cycles);
    }
    ADC_setupSOC(VARIANT_BUS_ADC, ADC_SOC_NUMBER1, VARIANT_TRIGGER, VARIANT_BUS_CHANNEL,
                 CHIP_WINDOW_cycles);
#ifdef VARIANT_T_CHANNEL
    ADC_setupSOC(VARIANT_T_ADC, ADC_SOC_NUMBER1, VARIANT_TRIGGER, VARIANT_T_CHANNEL,
                 CHIP_WINDOW_cycles);
#endif
    ADC_setInterruptSource(VARIANT_BUS_ADC, ADC_INT_NUMBER1, ADC_SOC_NUMBER1);
    ADC_clearInterruptStatus(VARIANT_BUS_ADC, ADC_INT_NUMBER1);
    ADC_enableInterrupt(VARIANT_BUS_ADC, ADC_INT_NUMBER1);
}

LODE_RAMFUNC uint16_t chip_current(uint32_t phase) {
    return ADC_readResult(currents[phase].result, ADC_SOC_NUMBER0);
}

LODE_RAMFUNC uint16_t chip_bus(void) {
    return ADC_readResult(VARIANT_BUS_RESULT, ADC_SOC_NUMBER1);
}

LODE_RAMFUNC uint16_t chip_temperature(void) {
#ifdef VARIANT_T_CHANNEL
    return ADC_readResult(VARIANT_T_RESULT, ADC_SOC_NUMBER1);
#else
    return 0u;
#endif
}

LODE_RAMFUNC bool chip_adc_acknowledge(void) {
    ADC_clearInterruptStatus(VARIANT_BUS_ADC, ADC_INT_NUMBER1);
    const bool missed = ADC_getInterruptOverflowStatus(VARIANT_BUS_ADC, ADC_INT_NUMBER1);
    if (missed) {
        // If it stays set, it blocks every later interrupt.
        ADC_clearInterruptOverflowStatus(VARIANT_BUS_ADC, ADC_INT_NUMBER1);
        ADC_clearInterruptStatus(VARIANT_BUS_ADC, ADC_INT_NUMBER1);
    }
    return !missed;
}
