/// The names of ST's stm32f4xx.h that port/stm32f4 uses; see stm32_common.h.
#ifndef FAKES_STM32F4XX_H
#define FAKES_STM32F4XX_H

#include "stm32_common.h"

typedef struct {
    volatile uint32_t SR, CR1, CR2, SMPR1, SMPR2, RESERVED[9], JSQR, JDR1, JDR2, JDR3, JDR4, DR;
} ADC_TypeDef;

typedef struct {
    volatile uint32_t CSR, CCR, CDR;
} ADC_Common_TypeDef;

typedef struct {
    volatile uint32_t CR, NDTR, PAR, M0AR, M1AR, FCR;
} DMA_Stream_TypeDef;

typedef struct {
    volatile uint32_t IDCODE, CR, APB1FZ, APB2FZ;
} DBGMCU_TypeDef;

typedef struct {
    volatile uint32_t ACR;
} FLASH_TypeDef;

typedef struct {
    volatile uint32_t CR, CSR;
} PWR_TypeDef;

typedef struct {
    volatile uint32_t CR, PLLCFGR, CFGR, RESERVED1[6], APB2RSTR, RESERVED4[2], AHB1ENR,
        RESERVED2[3], APB1ENR, APB2ENR, RESERVED3[11], CSR;
} RCC_TypeDef;

typedef struct {
    volatile uint32_t SR, DR, BRR, CR1, CR2, CR3;
} USART_TypeDef;

#define ADC_SR_JEOC (1u << 2)
#define ADC_SR_JSTRT (1u << 3)
#define ADC_CR1_JEOCIE (1u << 7)
#define ADC_CR1_SCAN (1u << 8)
#define ADC_CR2_ADON 1u
#define ADC_CR2_JEXTSEL_Pos 16u
#define ADC_CR2_JEXTEN_Pos 20u
#define ADC_JSQR_JSQ3_Pos 10u
#define ADC_JSQR_JSQ4_Pos 15u
#define ADC_JSQR_JL_Pos 20u
#define ADC_CCR_MULTI_Pos 0u
#define ADC_CCR_ADCPRE_Pos 16u

#define DBGMCU_APB1_FZ_DBG_TIM2_STOP 1u
#define DBGMCU_APB1_FZ_DBG_IWDG_STOP (1u << 12)
#define DBGMCU_APB2_FZ_DBG_TIM1_STOP 1u
#define DBGMCU_APB2_FZ_DBG_TIM8_STOP (1u << 1)
#define DMA_SxCR_EN 1u
#define DMA_SxCR_DIR_0 (1u << 6)
#define DMA_SxCR_CIRC (1u << 8)
#define DMA_SxCR_PSIZE_1 (2u << 11)
#define DMA_SxCR_MSIZE_1 (2u << 13)
#define DMA_SxCR_PL (3u << 16)
#define FLASH_ACR_PRFTEN (1u << 8)
#define FLASH_ACR_ICEN (1u << 9)
#define FLASH_ACR_DCEN (1u << 10)
#define PWR_CR_VOS (1u << 14)

#define RCC_CR_HSEON (1u << 16)
#define RCC_CR_HSERDY (1u << 17)
#define RCC_CR_CSSON (1u << 19)
#define RCC_CR_PLLON (1u << 24)
#define RCC_CR_PLLRDY (1u << 25)
#define RCC_CFGR_SW 3u
#define RCC_CFGR_SW_Pos 0u
#define RCC_CFGR_SWS 12u
#define RCC_CFGR_SWS_Pos 2u
#define RCC_CFGR_PPRE1_Pos 10u
#define RCC_CFGR_PPRE2_Pos 13u
#define RCC_PLLCFGR_PLLM_Pos 0u
#define RCC_PLLCFGR_PLLN_Pos 6u
#define RCC_PLLCFGR_PLLSRC_HSE (1u << 22)
#define RCC_PLLCFGR_PLLQ_Pos 24u
#define RCC_AHB1ENR_GPIOAEN 1u
#define RCC_AHB1ENR_GPIOBEN (1u << 1)
#define RCC_AHB1ENR_GPIOCEN (1u << 2)
#define RCC_AHB1ENR_DMA2EN (1u << 22)
#define RCC_APB1ENR_TIM2EN 1u
#define RCC_APB1ENR_USART3EN (1u << 18)
#define RCC_APB1ENR_PWREN (1u << 28)
#define RCC_APB2RSTR_TIM1RST 1u
#define RCC_APB2ENR_TIM1EN 1u
#define RCC_APB2ENR_TIM8EN (1u << 1)
#define RCC_APB2ENR_ADC1EN (1u << 8)
#define RCC_APB2ENR_ADC2EN (1u << 9)
#define RCC_APB2ENR_ADC3EN (1u << 10)

#define RCC_CSR_RMVF (1u << 24)

#define USART_SR_TXE (1u << 7)
#define USART_CR1_TE (1u << 3)
#define USART_CR1_UE (1u << 13)

#define ADC_IRQn 18
#define TIM2_IRQn 28

#if !defined(__arm__)
extern TIM_TypeDef fake_TIM3, fake_TIM5, fake_TIM8;
extern DMA_Stream_TypeDef fake_DMA2_Stream1;
extern ADC_TypeDef fake_ADC1, fake_ADC2, fake_ADC3;
extern ADC_Common_TypeDef fake_ADC123_COMMON;
extern DBGMCU_TypeDef fake_DBGMCU;
extern FLASH_TypeDef fake_FLASH;
extern PWR_TypeDef fake_PWR;
extern RCC_TypeDef fake_RCC;
extern USART_TypeDef fake_USART3;
#endif

#define TIM1 FAKE_AT(TIM_TypeDef, TIM1, 0x40010000u)
#define TIM3 FAKE_AT(TIM_TypeDef, TIM3, 0x40000400u)
#define TIM5 FAKE_AT(TIM_TypeDef, TIM5, 0x40000C00u)
#define TIM8 FAKE_AT(TIM_TypeDef, TIM8, 0x40010400u)
#define DMA2_Stream1 FAKE_AT(DMA_Stream_TypeDef, DMA2_Stream1, 0x40026428u)
#define GPIOA FAKE_AT(GPIO_TypeDef, GPIOA, 0x40020000u)
#define GPIOB FAKE_AT(GPIO_TypeDef, GPIOB, 0x40020400u)
#define GPIOC FAKE_AT(GPIO_TypeDef, GPIOC, 0x40020800u)
#define ADC1 FAKE_AT(ADC_TypeDef, ADC1, 0x40012000u)
#define ADC2 FAKE_AT(ADC_TypeDef, ADC2, 0x40012100u)
#define ADC3 FAKE_AT(ADC_TypeDef, ADC3, 0x40012200u)
#define ADC123_COMMON FAKE_AT(ADC_Common_TypeDef, ADC123_COMMON, 0x40012300u)
#define DBGMCU FAKE_AT(DBGMCU_TypeDef, DBGMCU, 0xE0042000u)
#define FLASH FAKE_AT(FLASH_TypeDef, FLASH, 0x40023C00u)
#define PWR FAKE_AT(PWR_TypeDef, PWR, 0x40007000u)
#define RCC FAKE_AT(RCC_TypeDef, RCC, 0x40023800u)
#define USART3 FAKE_AT(USART_TypeDef, USART3, 0x40004800u)

#endif
