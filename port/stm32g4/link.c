#include "link.h"

#include "chip.h"

#ifdef VARIANT_LINK

#include "board.h"
#include "figures.h"
#include "pwm.h"

#define TRGO_OC4REF (7u << 4)              // TIM1_CR2.MMS
#define TRGO2_OC5REF_OR_OC6REF (14u << 20) // .MMS2: a rising edge of either
#define PWM_MODE_1 6u                      // high below the compare value: rises in the second half
#define BURST_CCR1_TO_3 (13u | 2u << 8)    // TIM1_DCR: from the 13th register on, three
#define REQUEST_TIM1_CH4 45u               // RM0440, DMAMUX: assignment of requests
#define TRIGGER_TIM1_TRGO 0u
#define TRIGGER_TIM1_TRGO2 8u
#define RISING_EDGE 1u
#define NEXT_ns 500u // before t_k: rising edges for the next period, and the bus's conversion
// If the edges leave no room the samples are useless, but they must still come in order.
#define SAMPLE_BLIND_1 0.6f
#define SAMPLE_BLIND_2 0.9f

uint32_t chip_link_rise[3];

static lode_single_shunt_t shunt;
static lode_single_shunt_tuning_t tuning;
static lode_single_shunt_plan_t plan; // for the next period
// Both samples of the last period are there, and its edges were those of the plan.
static bool complete;

static uint32_t compare(float edge) {
    return (uint32_t)(int32_t)((1.0f - edge) * (float)REG_READ(TIM1->ARR) + 0.5f);
}

// Counter value for a share of the period in its second half, while the counter runs down. A compare value of ARR would keep
// the output active for the whole period, without an edge (RM0440, centre-aligned mode).
static uint32_t instant(float share) {
    const uint32_t most = REG_READ(TIM1->ARR) - 1u;
    const uint32_t down =
        (uint32_t)(int32_t)(2.0f * (1.0f - share) * (float)REG_READ(TIM1->ARR) + 0.5f);
    return down < most ? down : most;
}

static void put_rise(lode_abc_t rise) {
    chip_link_rise[0] = compare(rise.a);
    chip_link_rise[1] = compare(rise.b);
    chip_link_rise[2] = compare(rise.c);
}

static void timer_init(void) {
    REG_WRITE(TIM1->RCR, 0u); // update at both turning points
    REG_WRITE(TIM1->CR2, TRGO_OC4REF | TRGO2_OC5REF_OR_OC6REF);
    REG_SET(TIM1->CCMR2, PWM_MODE_1 << TIM_CCMR2_OC4M_Pos | TIM_CCMR2_OC4PE);
    REG_WRITE(TIM1->CCMR3, PWM_MODE_1 << TIM_CCMR3_OC5M_Pos | TIM_CCMR3_OC5PE |
                               PWM_MODE_1 << TIM_CCMR3_OC6M_Pos | TIM_CCMR3_OC6PE);
    REG_WRITE(TIM1->CCR4, NEXT_ns * (CHIP_F_PWM_Hz / 1000000u) / 1000u);
    REG_WRITE(TIM1->CCR5, instant(SAMPLE_BLIND_1));
    REG_WRITE(TIM1->CCR6, instant(SAMPLE_BLIND_2));
    REG_WRITE(TIM1->DCR, BURST_CCR1_TO_3);
    REG_WRITE(TIM1->EGR, TIM_EGR_UG); // loads all preloaded registers
    REG_WRITE(TIM1->SR, 0u);
}

static void dma_init(void) {
    REG_SET(RCC->AHB1ENR, RCC_AHB1ENR_DMA1EN | RCC_AHB1ENR_DMAMUX1EN);
    REG_WRITE(DMAMUX1_Channel1->CCR, REQUEST_TIM1_CH4);
    REG_WRITE(DMA1_Channel2->CPAR, (uint32_t)(uintptr_t)&TIM1->DMAR);
    REG_WRITE(DMA1_Channel2->CMAR, (uint32_t)(uintptr_t)chip_link_rise);
    REG_WRITE(DMA1_Channel2->CNDTR, 3u);
    // Memory to peripheral, words, always the same three, with the highest priority.
    REG_WRITE(DMA1_Channel2->CCR, DMA_CCR_DIR | DMA_CCR_CIRC | DMA_CCR_MINC | DMA_CCR_PSIZE_1 |
                                      DMA_CCR_MSIZE_1 | DMA_CCR_PL | DMA_CCR_EN);
    REG_SET(TIM1->DIER, TIM_DIER_CC4DE); // the flag comes while the counter runs down
}

bool chip_link_init(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    const lode_motor_t motor = app_motor();
    const lode_single_shunt_config_t wanted = port_link_config(
        &config, VARIANT_SETTLE_ns, CHIP_SAMPLE_ns, 0.5f * (motor.Ld_H + motor.Lq_H));
    if (lode_single_shunt_tune(&tuning, &wanted) != LODE_OK) {
        return false;
    }
    lode_single_shunt_reset(&shunt);
    plan = lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.5f, 0.5f, 0.5f}, LODE_GATES_OFF);
    put_rise(plan.rise);
    complete = false;
    timer_init();
    dma_init();
    return true;
}

// ADC1: the link, one conversion per trigger. ADC2: bus and temperature, whose end is the interrupt.
void chip_link_adcs(void) {
    const uint32_t link = VARIANT_LINK_CHANNEL;
    REG_WRITE(ADC1->CFGR, ADC_CFGR_JDISCEN);
    REG_WRITE(ADC1->JSQR, 1u << ADC_JSQR_JL_Pos | RISING_EDGE << ADC_JSQR_JEXTEN_Pos |
                              TRIGGER_TIM1_TRGO2 << ADC_JSQR_JEXTSEL_Pos |
                              link << ADC_JSQR_JSQ1_Pos | link << ADC_JSQR_JSQ2_Pos);
    REG_WRITE(ADC2->JSQR, 1u << ADC_JSQR_JL_Pos | RISING_EDGE << ADC_JSQR_JEXTEN_Pos |
                              TRIGGER_TIM1_TRGO << ADC_JSQR_JEXTSEL_Pos |
                              VARIANT_BUS_CHANNEL << ADC_JSQR_JSQ1_Pos |
                              VARIANT_T_CHANNEL << ADC_JSQR_JSQ2_Pos);
    REG_WRITE(ADC2->IER, ADC_IER_JEOSIE);
}

// The interrupt runs the code below from flash, as it does src/single_shunt.c: the 10 KB of CCM SRAM hold
// little more than the step.

// After a missed trigger the next sample would count as the first one from then on, so restart the sequence.
static void restart_adc_sequence(void) {
    REG_WRITE(ADC1->CR, ADC_CR_ADVREGEN | ADC_CR_JADSTP);
    (void)reg_await(&ADC1->CR, ADC_CR_JADSTP | ADC_CR_JADSTART, 0u);
    REG_WRITE(ADC1->CR, ADC_CR_ADVREGEN | ADC_CR_JADSTART);
}

void chip_adc_acknowledge(void) {
    REG_WRITE(ADC2->ISR, ADC_ISR_JEOC | ADC_ISR_JEOS);
    const bool sampled = (REG_READ(ADC1->ISR) & ADC_ISR_JEOS) != 0u;
    if (!sampled) {
        restart_adc_sequence();
    }
    complete = sampled && stm32_pwm_holds(chip_link_rise); // the DMA has written them
    REG_WRITE(ADC1->ISR, ADC_ISR_JEOC | ADC_ISR_JEOS);
    // Written before the upper turning point, which loads them.
    REG_WRITE(TIM1->CCR1, compare(plan.fall.a));
    REG_WRITE(TIM1->CCR2, compare(plan.fall.b));
    REG_WRITE(TIM1->CCR3, compare(plan.fall.c));
    REG_WRITE(TIM1->CCR5, instant(plan.blind ? SAMPLE_BLIND_1 : plan.sample[0]));
    REG_WRITE(TIM1->CCR6, instant(plan.blind ? SAMPLE_BLIND_2 : plan.sample[1]));
}

bool chip_link_read(uint16_t count[3]) {
    const lode_drive_t *drive = app_drive();
    const uint16_t link[2] = {(uint16_t)REG_READ(ADC1->JDR1), (uint16_t)REG_READ(ADC1->JDR2)};
    lode_single_shunt_read(&shunt, &tuning, link, drive->sense.offset[0], drive->inverter.v_bus_V,
                           count);
    return complete;
}

void chip_link_write(const lode_drive_out_t *out) {
    plan = lode_single_shunt_write(&shunt, &tuning, out->duty, out->gates);
    put_rise(plan.rise);
}

#endif
