// One ADC. A wrap of the trigger slice makes the DMA write the word that starts it. It converts its inputs one
// after the other until the interrupt after the last one stops it. By then it has started one more conversion,
// which is discarded.
#include "chip.h"

#define TRIGGER_CHANNEL 0u
#define DEADLINE_CHANNEL 1u
#define FIRST_GPIO 26u // ADC0
#define IDLE ADC_CS_EN
#define FIFO (ADC_FCS_EN | CHIP_SAMPLES << ADC_FCS_THRESHOLD_Pos)
// A conversion takes 2 us, 300 cycles; a poll takes about ten.
#define REST_POLLS 100u

// From input 0 on. In RAM, so that the DMA does not wait for the flash.
static uint32_t start_word =
    ADC_CS_EN | ADC_CS_START_MANY | ((1u << CHIP_SAMPLES) - 1u) << ADC_CS_ROUND_Pos;
static uint32_t deadline_word = PIN_SIO | PIN_OUT_LOW;

bool chip_adc_init(void) {
    for (uint32_t n = 0u; n < CHIP_SAMPLES; n++) {
        reg_write(PAD(FIRST_GPIO + n), PAD_ANALOG);
    }
    reg_write(ADC_CS, IDLE);
    reg_write(ADC_DIV, 0u); // one conversion after the other
    reg_write(ADC_FCS, FIFO | ADC_FCS_OVER | ADC_FCS_UNDER);
    reg_write(ADC_INTE, ADC_INTE_FIFO);
    return reg_await(ADC_CS, ADC_CS_READY, ADC_CS_READY);
}

static void channel(uint32_t n, const uint32_t *word, uint32_t to, uint32_t slice) {
    reg_write(DMA_READ(n), reg_address_of(word));
    reg_write(DMA_WRITE(n), to);
    reg_write(DMA_COUNT(n), DMA_COUNT_ENDLESS);
    reg_write(DMA_CTRL(n), DMA_WORD_PER_WRAP(n, slice));
}

void chip_adc_arm(void) {
    channel(TRIGGER_CHANNEL, &start_word, ADC_CS, CHIP_TRIGGER_SLICE);
    channel(DEADLINE_CHANNEL, &deadline_word, PIN_CTRL(VARIANT_ENABLE_GPIO), CHIP_DEADLINE_SLICE);
}

LODE_RAMFUNC bool chip_adc_take(uint16_t sample[CHIP_SAMPLES]) {
    reg_write(ADC_CS, IDLE);
    const uint32_t status = reg_read(ADC_FCS);
    for (uint32_t n = 0u; n < CHIP_SAMPLES; n++) {
        sample[n] = (uint16_t)(reg_read(ADC_FIFO) & 0xFFFu);
    }
    // One more sample if the interrupt came late; a full FIFO if it has not come for a while.
    return (status & ADC_FCS_OVER) == 0u && ADC_FCS_LEVEL(status) - CHIP_SAMPLES <= 1u;
}

LODE_RAMFUNC void chip_adc_rest(void) {
    uint32_t polls = 0u;
    while ((reg_read(ADC_CS) & ADC_CS_READY) == 0u && polls < REST_POLLS) {
        polls++;
    }
    for (uint32_t n = 0u; n < ADC_FIFO_DEPTH && (reg_read(ADC_FCS) & ADC_FCS_EMPTY) == 0u; n++) {
        (void)reg_read(ADC_FIFO);
    }
    reg_write(ADC_FCS, FIFO | ADC_FCS_OVER | ADC_FCS_UNDER);
}
