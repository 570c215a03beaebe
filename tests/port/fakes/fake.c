#include "fake.h"

#include <math.h>
#include <string.h>

#ifdef FAKE_G4
#include "stm32g4xx.h"
#define SERIAL fake_USART2
#define SERIAL_STATUS fake_USART2.ISR
#define SERIAL_DATA fake_USART2.TDR
#define SERIAL_READY USART_ISR_TXE
#define SYSTEM_BREAK TIM_SR_SBIF
#define CALIBRATED // its ADCs
#elif defined(FAKE_H7)
#include "stm32h7xx.h"
#define SERIAL fake_USART3
#define SERIAL_STATUS fake_USART3.ISR
#define SERIAL_DATA fake_USART3.TDR
#define SERIAL_READY USART_ISR_TXE_TXFNF
#define SYSTEM_BREAK TIM_SR_SBIF
#define CALIBRATED
#else
#include "stm32f4xx.h"
#define SERIAL fake_USART3
#define SERIAL_STATUS fake_USART3.SR
#define SERIAL_DATA fake_USART3.DR
#define SERIAL_READY USART_SR_TXE
#define SYSTEM_BREAK TIM_SR_BIF
#endif

#ifdef FAKE_H7
#define RESET_CAUSE fake_RCC.RSR
#define RESET_BY_WATCHDOG (RCC_RSR_IWDG1RSTF | RCC_RSR_WWDG1RSTF)
#define RESET_FORGET RCC_RSR_RMVF
#define PLL_ON RCC_CR_PLL1ON
#define CLOCK_WATCH RCC_CR_CSSHSEON
#else
#define RESET_CAUSE fake_RCC.CSR
#define RESET_BY_WATCHDOG (RCC_CSR_IWDGRSTF | RCC_CSR_WWDGRSTF)
#define RESET_FORGET RCC_CSR_RMVF
#define PLL_ON RCC_CR_PLLON
#define CLOCK_WATCH RCC_CR_CSSON
#endif

#define ENTRIES_MAX 65536
#define BDTR_LOCK (3u << 8)
#define TEXT_MAX 4096

TIM_TypeDef fake_TIM1, fake_TIM2;
GPIO_TypeDef fake_GPIOA, fake_GPIOB, fake_GPIOC;
IWDG_TypeDef fake_IWDG;
ADC_TypeDef fake_ADC1, fake_ADC2;
DBGMCU_TypeDef fake_DBGMCU;
FLASH_TypeDef fake_FLASH;
PWR_TypeDef fake_PWR;
RCC_TypeDef fake_RCC;
USART_TypeDef SERIAL;
#ifdef FAKE_G4
ADC_Common_TypeDef fake_ADC12_COMMON;
CORDIC_TypeDef fake_CORDIC;
COMP_TypeDef fake_COMP1, fake_COMP2, fake_COMP4;
OPAMP_TypeDef fake_OPAMP1, fake_OPAMP2, fake_OPAMP3;
DAC_TypeDef fake_DAC3;
SYSCFG_TypeDef fake_SYSCFG;
DMA_Channel_TypeDef fake_DMA1_Channel1, fake_DMA1_Channel2;
DMAMUX_Channel_TypeDef fake_DMAMUX1_Channel0, fake_DMAMUX1_Channel1;
#elif defined(FAKE_H7)
ADC_Common_TypeDef fake_ADC12_COMMON;
SYSCFG_TypeDef fake_SYSCFG;
DMA_Stream_TypeDef fake_DMA1_Stream0;
DMAMUX_Channel_TypeDef fake_DMAMUX1_Channel0;
#else
TIM_TypeDef fake_TIM5, fake_TIM8;
DMA_Stream_TypeDef fake_DMA2_Stream1;
ADC_TypeDef fake_ADC3;
ADC_Common_TypeDef fake_ADC123_COMMON;
#endif

#define COMPARATORS 3

static fake_entry_t entries[ENTRIES_MAX];
static int count;
static int irq_index[128];
static uint32_t irq_priority[128];
static uint32_t irq_mask;
static bool break_active, clock_dead;
#ifdef FAKE_G4
static bool dead_comparator[COMPARATORS];
#endif
static bool bdtr_written; // since the timer's reset
static uint32_t room;
static char text[TEXT_MAX];
static size_t text_length;

#define WIPE(object) memset((void *)&(object), 0, sizeof(object))

void fake_reset(void) {
    WIPE(fake_TIM1);
    WIPE(fake_TIM2);
    WIPE(fake_DBGMCU);
    WIPE(fake_GPIOA);
    WIPE(fake_GPIOB);
    WIPE(fake_GPIOC);
    WIPE(fake_IWDG);
    WIPE(fake_ADC1);
    WIPE(fake_ADC2);
    WIPE(fake_RCC);
    WIPE(fake_FLASH);
    WIPE(SERIAL);
#ifdef FAKE_G4
    WIPE(dead_comparator);
    WIPE(fake_COMP1);
    WIPE(fake_COMP2);
    WIPE(fake_COMP4);
    WIPE(fake_DAC3);
    WIPE(fake_SYSCFG);
    WIPE(fake_DMA1_Channel1);
    WIPE(fake_DMA1_Channel2);
    WIPE(fake_DMAMUX1_Channel1);
    WIPE(fake_DMAMUX1_Channel0);
#endif
#ifdef FAKE_H7
    WIPE(fake_SYSCFG);
    WIPE(fake_PWR);
    WIPE(fake_DMA1_Stream0);
    WIPE(fake_DMAMUX1_Channel0);
    fake_DBGMCU.IDCODE = 0x20036450u; // revision V
#endif
#ifndef CALIBRATED
    WIPE(fake_ADC3);
    WIPE(fake_TIM8);
    WIPE(fake_DMA2_Stream1);
#endif
    count = 0;
    memset(irq_index, -1, sizeof irq_index);
    bdtr_written = false;
    break_active = false;
    clock_dead = false;
    fake_serial_room(TEXT_MAX);
    text_length = 0;
    text[0] = '\0';
}

#ifdef FAKE_G4
#define Q31 2147483648.0
#define RESIDUE 524288.0 // 2^19: what is left of the angle after 24 iterations

static int32_t cordic_argument[2]; // angle over pi, modulus
static int cordic_arguments, cordic_results;

static void model_cordic(const volatile uint32_t *reg, uint32_t value) {
    const uint32_t control = fake_CORDIC.CSR;
    const int wanted = (control & CORDIC_CSR_NARGS) != 0u ? 2 : 1;
    if (reg != &fake_CORDIC.WDATA || (fake_RCC.AHB1ENR & RCC_AHB1ENR_CORDICEN) == 0u) {
        return;
    }
    cordic_argument[cordic_arguments++] = (int32_t)value;
    if (cordic_arguments == wanted) {
        cordic_arguments = 0;
        cordic_results = (control & 15u) == 0u && (control & CORDIC_CSR_NRES) != 0u ? 2 : 0;
    }
}

static uint32_t cordic_result(void) {
    const double pi = 3.14159265358979323846;
    const double angle = floor(cordic_argument[0] / Q31 * pi * RESIDUE) / RESIDUE;
    if (cordic_results == 0 || irq_mask == 0u) { // nothing asked, or somebody may come in between
        return 0xFFFFFFFFu;
    }
    cordic_results--;
    const double one = cordic_argument[1] / Q31;
    return (uint32_t)(int32_t)floor((cordic_results == 1 ? cos(angle) : sin(angle)) * one *
                                    (Q31 - 1.0));
}
#endif

uint32_t fake_read(const volatile uint32_t *reg) {
#ifdef FAKE_G4
    if (reg == &fake_CORDIC.RDATA) {
        return cordic_result();
    }
#endif
    return *reg;
}

#ifdef FAKE_G4
#define NO_CURRENT_COUNT 160u // of DAC3: 129 mV at the amplifiers' inputs

void fake_kill_comparator(int n) {
    dead_comparator[n] = true;
}

// Comparators 1, 2 and 4 against channel 1 and twice channel 2 of DAC3, into TIM1's break.
static void model_comparators(void) {
    COMP_TypeDef *const unit[COMPARATORS] = {&fake_COMP1, &fake_COMP2, &fake_COMP4};
    const uint32_t source[COMPARATORS] = {TIM1_AF1_BKCMP1E, TIM1_AF1_BKCMP2E, TIM1_AF1_BKCMP4E};
    const uint32_t dac[COMPARATORS] = {fake_DAC3.DHR12R1, fake_DAC3.DHR12R2, fake_DAC3.DHR12R2};
    for (int n = 0; n < COMPARATORS; n++) {
        const bool on = (unit[n]->CSR & COMP_CSR_EN) != 0u && !dead_comparator[n];
        const bool high = on && dac[n] < NO_CURRENT_COUNT;
        unit[n]->CSR = (unit[n]->CSR & ~COMP_CSR_VALUE) | (high ? COMP_CSR_VALUE : 0u);
        if (high && (fake_TIM1.AF1 & source[n]) != 0u && (fake_TIM1.BDTR & TIM_BDTR_BKE) != 0u) {
            fake_TIM1.SR |= TIM_SR_BIF;
            fake_TIM1.BDTR &= ~TIM_BDTR_MOE;
        }
    }
}
#endif

static void model_timer(volatile uint32_t *reg, uint32_t before) {
    if (reg == &fake_TIM1.SR) { // flags are cleared by writing 0
        fake_TIM1.SR = (before & fake_TIM1.SR) | (break_active ? TIM_SR_BIF : 0u);
    } else if (reg == &fake_TIM1.BDTR) {
        if (bdtr_written) { // only once after the reset
            fake_TIM1.BDTR = (fake_TIM1.BDTR & ~BDTR_LOCK) | (before & BDTR_LOCK);
        }
        bdtr_written = true;
        if ((before & BDTR_LOCK) != 0u) { // only MOE is left
            fake_TIM1.BDTR = (before & ~TIM_BDTR_MOE) | (fake_TIM1.BDTR & TIM_BDTR_MOE);
        }
        if (break_active) {
            fake_TIM1.BDTR &= ~TIM_BDTR_MOE;
        }
    }
}

static void model_clock(void) {
    if ((fake_RCC.APB2RSTR & RCC_APB2RSTR_TIM1RST) != 0u) {
        WIPE(fake_TIM1);
        bdtr_written = false;
        fake_set_break(break_active);
    }
    fake_RCC.CSR |= (fake_RCC.CSR & RCC_CSR_LSION) << 1;
    if ((RESET_CAUSE & RESET_FORGET) != 0u) {
        RESET_CAUSE &= ~(RESET_BY_WATCHDOG | RESET_FORGET);
    }
#ifdef FAKE_H7
    fake_PWR.CSR1 |= (fake_PWR.CR3 & PWR_CR3_SCUEN) == 0u ? PWR_CSR1_ACTVOSRDY : 0u;
    fake_PWR.D3CR |= PWR_D3CR_VOSRDY;
#endif
    if (clock_dead) {
        return;
    }
    fake_RCC.CR |= (fake_RCC.CR & (RCC_CR_HSEON | PLL_ON)) << 1;
    fake_RCC.CFGR = (fake_RCC.CFGR & ~RCC_CFGR_SWS) | (fake_RCC.CFGR & RCC_CFGR_SW)
                                                          << RCC_CFGR_SWS_Pos;
}

static void model_adcs(volatile uint32_t *reg, uint32_t before) {
#ifdef CALIBRATED
    ADC_TypeDef *const adcs[] = {&fake_ADC1, &fake_ADC2};
    for (int n = 0; n < 2; n++) {
        ADC_TypeDef *adc = adcs[n];
        if (reg == &adc->CR) { // is not taken back by writing 0
            adc->CR |= before & ADC_CR_ADEN;
        }
        const bool on = (adc->CR & ADC_CR_ADEN) != 0u;
        if (!on && (reg == &adc->JSQR || reg == &adc->SMPR1 || reg == &adc->SMPR2 ||
                    reg == &adc->CFGR || reg == &adc->IER)) { // only while it is on
            *reg = before;
        }
        if (reg == &fake_ADC12_COMMON.CCR &&
            (adc->CR & ADC_CR_ADEN) != 0u) { // only while it is off
            *reg = before;
        }
        adc->CR &= ~ADC_CR_ADCAL;
#ifdef FAKE_G4
        if ((adc->CR & ADC_CR_JADSTP) != 0u) { // takes both back
            adc->CR &= ~(ADC_CR_JADSTP | ADC_CR_JADSTART);
        }
#endif
        if (reg == &adc->ISR) { // cleared by writing 1
            adc->ISR = before & ~adc->ISR;
        } else if ((adc->CR & ADC_CR_ADEN) != 0u) {
            adc->ISR |= ADC_ISR_ADRDY;
        }
    }
#else
    if (reg == &fake_ADC1.SR) {
        fake_ADC1.SR &= before;
    }
#endif
}

static void model_serial(volatile uint32_t *reg, uint32_t value) {
    if (reg == &SERIAL_DATA && text_length + 1 < TEXT_MAX) {
        text[text_length++] = (char)value;
        text[text_length] = '\0';
        fake_serial_room(room - 1u);
    }
}

static void model_pins(volatile uint32_t *reg, uint32_t value) {
    GPIO_TypeDef *const ports[] = {&fake_GPIOA, &fake_GPIOB, &fake_GPIOC};
    for (int n = 0; n < 3; n++) {
        if (reg == &ports[n]->BSRR) {
            ports[n]->ODR = (ports[n]->ODR & ~(value >> 16)) | (value & 0xFFFFu);
        }
    }
}

// Without its clock it takes nothing.
static void model_syscfg(volatile uint32_t *reg, uint32_t before) {
#ifdef FAKE_G4
    if (reg == &fake_SYSCFG.CFGR2 && (fake_RCC.APB2ENR & RCC_APB2ENR_SYSCFGEN) == 0u) {
        *reg = before;
    }
#elif defined(FAKE_H7)
    if (reg == &fake_SYSCFG.CFGR && (fake_RCC.APB4ENR & RCC_APB4ENR_SYSCFGEN) == 0u) {
        *reg = before;
    }
#else
    (void)reg;
    (void)before;
#endif
}

void fake_write(volatile uint32_t *reg, const char *name, uint32_t value) {
    const uint32_t before = *reg;
    if (count < ENTRIES_MAX) {
        entries[count++] = (fake_entry_t){reg, value, name};
    }
    *reg = value;
    model_timer(reg, before);
    model_clock();
    model_adcs(reg, before);
    model_serial(reg, value);
    model_pins(reg, value);
    model_syscfg(reg, before);
#ifdef FAKE_G4
    model_comparators();
    model_cordic(reg, value);
#endif
}

int fake_count(void) {
    return count;
}

int fake_first(const volatile uint32_t *reg, uint32_t mask, uint32_t bits, int from) {
    for (int n = from; n >= 0 && n < count; n++) {
        if (entries[n].reg == reg && (entries[n].value & mask) == bits) {
            return n;
        }
    }
    return -1;
}

void NVIC_SetPriority(int irq, uint32_t priority) {
    irq_priority[irq] = priority;
}

void NVIC_EnableIRQ(int irq) {
    irq_index[irq] = count;
}

uint32_t __get_PRIMASK(void) {
    return irq_mask;
}

void __set_PRIMASK(uint32_t mask) {
    irq_mask = mask;
}

void __disable_irq(void) {
    irq_mask = 1u;
}

int fake_irq_enabled(int irq) {
    return irq_index[irq];
}

uint32_t fake_irq_priority(int irq) {
    return irq_priority[irq];
}

void fake_set_break(bool active) {
    break_active = active;
    if (active) {
        fake_TIM1.SR |= TIM_SR_BIF;
        fake_TIM1.BDTR &= ~TIM_BDTR_MOE;
    }
}

// Of the system, behind enable but before filter and polarity.
static void system_break(uint32_t flag) {
    if ((fake_TIM1.BDTR & TIM_BDTR_BKE) != 0u) {
        fake_TIM1.SR |= flag;
        fake_TIM1.BDTR &= ~TIM_BDTR_MOE;
    }
}

void fake_lose_clock(void) {
    if ((fake_RCC.CR & CLOCK_WATCH) != 0u) {
        system_break(SYSTEM_BREAK);
    }
}

#ifdef CALIBRATED
static void system_error(uint32_t enabled) {
    if (enabled != 0u) {
        system_break(SYSTEM_BREAK);
    }
}
#endif

#ifdef FAKE_G4
void fake_lock_up(void) {
    system_error(fake_SYSCFG.CFGR2 & SYSCFG_CFGR2_CLL);
}

void fake_flash_error(void) {
    system_error(fake_SYSCFG.CFGR2 & SYSCFG_CFGR2_ECCL);
}
#elif defined(FAKE_H7)
void fake_lock_up(void) {
    system_error(fake_SYSCFG.CFGR & SYSCFG_CFGR_CM7L);
}

void fake_flash_error(void) {
    system_error(fake_SYSCFG.CFGR & SYSCFG_CFGR_FLASHL);
}
#endif

#ifdef FAKE_G4
// TIM2's compare value comes, and the DMA writes what it points to, which is 0 (its address has only its
// lower half here), to where it points.
static void model_deadline(uint32_t ticks) {
    const uint32_t on = DMA_CCR_EN | DMA_CCR_DIR | DMA_CCR_CIRC | DMA_CCR_PSIZE_1 | DMA_CCR_MSIZE_1;
    const uint32_t clocks = RCC_AHB1ENR_DMA1EN | RCC_AHB1ENR_DMAMUX1EN;
    if (fake_TIM2.CCR1 - fake_TIM2.CNT <= ticks && (fake_TIM2.DIER & TIM_DIER_CC1DE) != 0u &&
        (fake_RCC.AHB1ENR & clocks) == clocks && fake_DMAMUX1_Channel0.CCR == 56u &&
        (fake_DMA1_Channel1.CCR & on) == on && fake_DMA1_Channel1.CNDTR == 1u &&
        fake_DMA1_Channel1.CPAR == (uint32_t)(uintptr_t)&fake_TIM1.BDTR) {
        fake_TIM1.BDTR &= ~TIM_BDTR_MOE;
    }
}
#elif defined(FAKE_H7)
static void model_deadline(uint32_t ticks) {
    const uint32_t on =
        DMA_SxCR_EN | DMA_SxCR_DIR_0 | DMA_SxCR_CIRC | DMA_SxCR_PSIZE_1 | DMA_SxCR_MSIZE_1;
    if (fake_TIM2.CCR1 - fake_TIM2.CNT <= ticks && (fake_TIM2.DIER & TIM_DIER_CC1DE) != 0u &&
        (fake_RCC.AHB1ENR & RCC_AHB1ENR_DMA1EN) != 0u && fake_DMAMUX1_Channel0.CCR == 18u &&
        (fake_DMA1_Stream0.CR & on) == on && fake_DMA1_Stream0.NDTR == 1u &&
        fake_DMA1_Stream0.PAR == (uint32_t)(uintptr_t)&fake_TIM1.BDTR) {
        fake_TIM1.BDTR &= ~TIM_BDTR_MOE;
    }
}
#else
// TIM8 counts half as fast as TIM2, and its wrap asks stream 1 of DMA2 on channel 7.
static void model_deadline(uint32_t ticks) {
    const uint32_t on = DMA_SxCR_EN | DMA_SxCR_DIR_0 | DMA_SxCR_CIRC | DMA_SxCR_PSIZE_1 |
                        DMA_SxCR_MSIZE_1 | 7u << 25;
    const bool runs = (fake_RCC.APB2ENR & RCC_APB2ENR_TIM8EN) != 0u &&
                      (fake_TIM8.CR1 & TIM_CR1_CEN) != 0u && fake_TIM8.PSC == 3u;
    const uint32_t at = fake_TIM8.CNT + (runs ? ticks / 2u : 0u);
    if (at > fake_TIM8.ARR && fake_TIM8.ARR <= 65535u && (fake_TIM8.DIER & TIM_DIER_UDE) != 0u &&
        (fake_RCC.AHB1ENR & RCC_AHB1ENR_DMA2EN) != 0u && (fake_DMA2_Stream1.CR & on) == on &&
        fake_DMA2_Stream1.NDTR == 1u &&
        fake_DMA2_Stream1.PAR == (uint32_t)(uintptr_t)&fake_TIM1.BDTR) {
        fake_TIM1.BDTR &= ~TIM_BDTR_MOE;
    }
    fake_TIM8.CNT = at % (fake_TIM8.ARR + 1u);
}
#endif

void fake_run(uint32_t ticks) {
    if ((fake_TIM2.CR1 & TIM_CR1_CEN) != 0u) {
        model_deadline(ticks);
        fake_TIM2.CNT += ticks;
    }
}

bool fake_watchdog_waits(void) {
#ifdef FAKE_G4
    return (fake_DBGMCU.APB1FZR1 & DBGMCU_APB1FZR1_DBG_IWDG_STOP) != 0u;
#elif defined(FAKE_H7)
    return (fake_DBGMCU.APB4FZ1 & DBGMCU_APB4FZ1_DBG_IWDG1) != 0u;
#else
    return (fake_DBGMCU.APB1FZ & DBGMCU_APB1_FZ_DBG_IWDG_STOP) != 0u;
#endif
}

bool fake_halt(uint32_t ticks) {
#ifdef FAKE_G4
    const bool frozen = (fake_DBGMCU.APB1FZR1 & DBGMCU_APB1FZR1_DBG_TIM2_STOP) != 0u;
    const bool outputs_off = (fake_DBGMCU.APB2FZ & DBGMCU_APB2FZ_DBG_TIM1_STOP) != 0u;
#elif defined(FAKE_H7)
    const bool frozen = (fake_DBGMCU.APB1LFZ1 & DBGMCU_APB1LFZ1_DBG_TIM2) != 0u;
    const bool outputs_off = (fake_DBGMCU.APB2FZ1 & DBGMCU_APB2FZ1_DBG_TIM1) != 0u;
#else
    const bool frozen = (fake_DBGMCU.APB1FZ & DBGMCU_APB1_FZ_DBG_TIM2_STOP) != 0u ||
                        (fake_DBGMCU.APB2FZ & DBGMCU_APB2_FZ_DBG_TIM8_STOP) != 0u;
    const bool outputs_off = (fake_DBGMCU.APB2FZ & DBGMCU_APB2_FZ_DBG_TIM1_STOP) != 0u;
#endif
    if (!frozen) {
        fake_run(ticks);
    }
    return outputs_off && (fake_TIM1.BDTR & TIM_BDTR_OSSI) != 0u;
}

void fake_kill_clock(void) {
    clock_dead = true;
}

void fake_serial_room(uint32_t octets) {
    room = octets;
    SERIAL_STATUS = room > 0u ? SERIAL_READY : 0u;
}

const char *fake_serial_text(void) {
    return text;
}
