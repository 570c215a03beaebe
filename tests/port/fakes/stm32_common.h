/// Hand-written stand-ins for the names of ST's device headers that the ports use, same in both families.
/// Layout and bits are the reference manuals' (RM0440, RM0090). Compiled for Arm they sit at the chip's
/// addresses, so that a complete image links without ST's files; on the host they are objects whose
/// writes are recorded (fake.h).
#ifndef FAKES_STM32_COMMON_H
#define FAKES_STM32_COMMON_H

#include <stdint.h>

typedef struct {
    volatile uint32_t CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, PSC, ARR, RCR, CCR1,
        CCR2, CCR3, CCR4, BDTR, CCR5, CCR6, CCMR3, RESERVED1[3], AF1, AF2, RESERVED2[221], DCR,
        DMAR;
} TIM_TypeDef;

typedef struct {
    volatile uint32_t MODER, OTYPER, OSPEEDR, PUPDR, IDR, ODR, BSRR, LCKR, AFR[2];
} GPIO_TypeDef;

typedef struct {
    volatile uint32_t KR, PR, RLR, SR;
} IWDG_TypeDef;

#define TIM_CR1_CEN 1u
#define TIM_CR1_DIR (1u << 4)
#define TIM_CR1_CMS_0 (1u << 5)
#define TIM_CR1_ARPE (1u << 7)
#define TIM_CR2_MMS_1 (2u << 4)
#define TIM_DIER_UIE 1u
#define TIM_DIER_UDE (1u << 8)
#define TIM_DIER_CC1DE (1u << 9)
#define TIM_DIER_CC4DE (1u << 12)
#define TIM_SR_BIF (1u << 7)
#define TIM_EGR_UG 1u
#define TIM_CCMR1_OC1PE (1u << 3)
#define TIM_CCMR1_OC1M_0 (1u << 4)
#define TIM_CCMR1_OC1M_1 (2u << 4)
#define TIM_CCMR1_OC1M_2 (4u << 4)
#define TIM_CCMR1_OC2PE (1u << 11)
#define TIM_CCMR1_OC2M_0 (1u << 12)
#define TIM_CCMR1_OC2M_1 (2u << 12)
#define TIM_CCMR1_OC2M_2 (4u << 12)
#define TIM_CCMR2_OC3PE (1u << 3)
#define TIM_CCMR2_OC4PE (1u << 11)
#define TIM_CCMR2_OC4M_Pos 12u
#define TIM_CCMR3_OC5PE (1u << 3)
#define TIM_CCMR3_OC5M_Pos 4u
#define TIM_CCMR3_OC6PE (1u << 11)
#define TIM_CCMR3_OC6M_Pos 12u
#define TIM_CCMR2_OC3M_0 (1u << 4)
#define TIM_CCMR2_OC3M_1 (2u << 4)
#define TIM_CCMR2_OC3M_2 (4u << 4)
#define TIM_CCER_CC1E 1u
#define TIM_CCER_CC1NE (1u << 2)
#define TIM_CCER_CC2E (1u << 4)
#define TIM_CCER_CC2NE (1u << 6)
#define TIM_CCER_CC3E (1u << 8)
#define TIM_CCER_CC3NE (1u << 10)
#define TIM_BDTR_LOCK_1 (2u << 8)
#define TIM_BDTR_OSSI (1u << 10)
#define TIM_BDTR_OSSR (1u << 11)
#define TIM_BDTR_BKE (1u << 12)
#define TIM_BDTR_BKP (1u << 13)
#define TIM_BDTR_MOE (1u << 15)

#define RCC_CSR_LSION 1u
#define RCC_CSR_LSIRDY (1u << 1)
#define RCC_CSR_IWDGRSTF (1u << 29)
#define RCC_CSR_WWDGRSTF (1u << 30)

#if defined(__arm__)
#define FAKE_AT(type, name, address) ((type *)(address))
static inline void NVIC_SetPriority(int irq, uint32_t priority) {
    ((volatile uint_least8_t *)0xE000E400u)[irq] = (uint_least8_t)(priority << 4);
}
static inline void NVIC_EnableIRQ(int irq) {
    ((volatile uint32_t *)0xE000E100u)[irq / 32] = 1u << (irq % 32);
}
static inline uint32_t __get_PRIMASK(void) {
    uint32_t mask;
    __asm volatile("mrs %0, primask" : "=r"(mask));
    return mask;
}
static inline void __set_PRIMASK(uint32_t mask) {
    __asm volatile("msr primask, %0" ::"r"(mask) : "memory");
}
static inline void __disable_irq(void) {
    __asm volatile("cpsid i" ::: "memory");
}
#else
#include "fake.h"
#define FAKE_AT(type, name, address) (&fake_##name)
#define REG_READ(reg) fake_read(&(reg))
#define REG_WRITE(reg, value) fake_write(&(reg), #reg, (uint32_t)(value))
void NVIC_SetPriority(int irq, uint32_t priority);
void NVIC_EnableIRQ(int irq);
uint32_t __get_PRIMASK(void);
void __set_PRIMASK(uint32_t mask);
void __disable_irq(void);
extern TIM_TypeDef fake_TIM1, fake_TIM2;
extern GPIO_TypeDef fake_GPIOA, fake_GPIOB, fake_GPIOC;
extern IWDG_TypeDef fake_IWDG;
#endif

#define IWDG FAKE_AT(IWDG_TypeDef, IWDG, 0x40003000u)
#define TIM2 FAKE_AT(TIM_TypeDef, TIM2, 0x40000000u)

#endif
