/// The names of ST's stm32h7xx.h that port/stm32h7 uses; see stm32_common.h.
#ifndef FAKES_STM32H7XX_H
#define FAKES_STM32H7XX_H

#include "stm32_common.h"

typedef struct {
    volatile uint32_t ISR, IER, CR, CFGR, CFGR2, SMPR1, SMPR2, PCSEL, RESERVED1[11], JSQR,
        RESERVED2[12], JDR1, JDR2, JDR3, JDR4;
} ADC_TypeDef;

typedef struct {
    volatile uint32_t CSR, RESERVED, CCR, CDR;
} ADC_Common_TypeDef;

typedef struct {
    volatile uint32_t CR, NDTR, PAR, M0AR, M1AR, FCR;
} DMA_Stream_TypeDef;

typedef struct {
    volatile uint32_t CCR;
} DMAMUX_Channel_TypeDef;

typedef struct {
    volatile uint32_t IDCODE, CR, RESERVED1[13], APB1LFZ1, RESERVED2[3], APB2FZ1, RESERVED3,
        APB4FZ1;
} DBGMCU_TypeDef;

typedef struct {
    volatile uint32_t ACR;
} FLASH_TypeDef;

typedef struct {
    volatile uint32_t CR1, CSR1, CR2, CR3, CPUCR, RESERVED, D3CR;
} PWR_TypeDef;

typedef struct {
    volatile uint32_t CR, HSICFGR, CRRCR, CSICFGR, CFGR, RESERVED1, D1CFGR, D2CFGR, D3CFGR,
        RESERVED2, PLLCKSELR, PLLCFGR, PLL1DIVR, RESERVED3[16], CSR, RESERVED4[8], APB2RSTR,
        RESERVED5[13], RSR, AHB3ENR, AHB1ENR, AHB2ENR, AHB4ENR, APB3ENR, APB1LENR, APB1HENR,
        APB2ENR, APB4ENR;
} RCC_TypeDef;

typedef struct {
    volatile uint32_t RESERVED1, PMCR, EXTICR[4], CFGR;
} SYSCFG_TypeDef;

typedef struct {
    volatile uint32_t CR1, CR2, CR3, BRR, GTPR, RTOR, RQR, ISR, ICR, RDR, TDR;
} USART_TypeDef;

#define TIM_SR_B2IF (1u << 8)
#define TIM_SR_SBIF (1u << 13)
#define TIM_BDTR_BKF_Pos 16u
#define TIM1_AF1_BKINE 1u
#define TIM1_AF1_BKINP (1u << 9)

#define ADC_ISR_ADRDY 1u
#define ADC_ISR_JEOC (1u << 5)
#define ADC_ISR_JEOS (1u << 6)
#define ADC_IER_JEOSIE (1u << 6)
#define ADC_CR_ADEN 1u
#define ADC_CR_JADSTART (1u << 3)
#define ADC_CR_BOOST_Pos 8u
#define ADC_CR_ADCALLIN (1u << 16)
#define ADC_CR_ADVREGEN (1u << 28)
#define ADC_CR_ADCAL (1u << 31)
#define ADC_CFGR_RES_Pos 2u
#define ADC_JSQR_JL_Pos 0u
#define ADC_JSQR_JEXTSEL_Pos 2u
#define ADC_JSQR_JEXTEN_Pos 7u
#define ADC_JSQR_JSQ1_Pos 9u
#define ADC_JSQR_JSQ2_Pos 15u
#define ADC_JSQR_JSQ3_Pos 21u
#define ADC_CCR_DUAL_Pos 0u
#define ADC_CCR_CKMODE_Pos 16u

#define DMA_SxCR_EN 1u
#define DMA_SxCR_DIR_0 (1u << 6)
#define DMA_SxCR_CIRC (1u << 8)
#define DMA_SxCR_PSIZE_1 (2u << 11)
#define DMA_SxCR_MSIZE_1 (2u << 13)
#define DMA_SxCR_PL (3u << 16)
#define DBGMCU_APB1LFZ1_DBG_TIM2 1u
#define DBGMCU_APB2FZ1_DBG_TIM1 1u
#define DBGMCU_APB4FZ1_DBG_IWDG1 (1u << 18)
#define FLASH_ACR_WRHIGHFREQ_Pos 4u
#define PWR_CR3_LDOEN (1u << 1)
#define PWR_CR3_SCUEN (1u << 2)
#define PWR_CSR1_ACTVOSRDY (1u << 13)
#define PWR_D3CR_VOSRDY (1u << 13)
#define PWR_D3CR_VOS (3u << 14)
#define PWR_D3CR_VOS_Pos 14u

#define RCC_CR_HSEON (1u << 16)
#define RCC_CR_HSERDY (1u << 17)
#define RCC_CR_CSSHSEON (1u << 19)
#define RCC_CR_PLL1ON (1u << 24)
#define RCC_CR_PLL1RDY (1u << 25)
#define RCC_CFGR_SW 7u
#define RCC_CFGR_SW_Pos 0u
#define RCC_CFGR_SWS (7u << 3)
#define RCC_CFGR_SWS_Pos 3u
#define RCC_D1CFGR_HPRE_Pos 0u
#define RCC_D1CFGR_D1PPRE_Pos 4u
#define RCC_D2CFGR_D2PPRE1_Pos 4u
#define RCC_D2CFGR_D2PPRE2_Pos 8u
#define RCC_D3CFGR_D3PPRE_Pos 4u
#define RCC_PLLCKSELR_DIVM1_Pos 4u
#define RCC_PLLCFGR_PLL1RGE_Pos 2u
#define RCC_PLLCFGR_DIVP1EN (1u << 16)
#define RCC_PLL1DIVR_N1_Pos 0u
#define RCC_PLL1DIVR_P1_Pos 9u
#define RCC_AHB1ENR_DMA1EN 1u
#define RCC_AHB1ENR_ADC12EN (1u << 5)
#define RCC_AHB4ENR_GPIOAEN 1u
#define RCC_AHB4ENR_GPIOBEN (1u << 1)
#define RCC_AHB4ENR_GPIOCEN (1u << 2)
#define RCC_APB1LENR_TIM2EN 1u
#define RCC_APB1LENR_USART3EN (1u << 18)
#define RCC_APB2RSTR_TIM1RST 1u
#define RCC_APB2ENR_TIM1EN 1u
#define RCC_APB4ENR_SYSCFGEN (1u << 1)
#define RCC_RSR_RMVF (1u << 16)
#define RCC_RSR_IWDG1RSTF (1u << 26)
#define RCC_RSR_WWDG1RSTF (1u << 28)

#define SYSCFG_CFGR_FLASHL (1u << 3)
#define SYSCFG_CFGR_CM7L (1u << 6)

#define USART_CR1_UE 1u
#define USART_CR1_TE (1u << 3)
#define USART_CR1_FIFOEN (1u << 29)
#define USART_ISR_TXE_TXFNF (1u << 7)

#define ADC_IRQn 18

#if !defined(__arm__)
extern ADC_TypeDef fake_ADC1, fake_ADC2;
extern ADC_Common_TypeDef fake_ADC12_COMMON;
extern DMA_Stream_TypeDef fake_DMA1_Stream0;
extern DMAMUX_Channel_TypeDef fake_DMAMUX1_Channel0;
extern DBGMCU_TypeDef fake_DBGMCU;
extern FLASH_TypeDef fake_FLASH;
extern PWR_TypeDef fake_PWR;
extern RCC_TypeDef fake_RCC;
extern SYSCFG_TypeDef fake_SYSCFG;
extern USART_TypeDef fake_USART3;
#endif

#define TIM1 FAKE_AT(TIM_TypeDef, TIM1, 0x40010000u)
#define IWDG1 FAKE_AT(IWDG_TypeDef, IWDG, 0x58004800u)
#define GPIOA FAKE_AT(GPIO_TypeDef, GPIOA, 0x58020000u)
#define GPIOB FAKE_AT(GPIO_TypeDef, GPIOB, 0x58020400u)
#define GPIOC FAKE_AT(GPIO_TypeDef, GPIOC, 0x58020800u)
#define ADC1 FAKE_AT(ADC_TypeDef, ADC1, 0x40022000u)
#define ADC2 FAKE_AT(ADC_TypeDef, ADC2, 0x40022100u)
#define ADC12_COMMON FAKE_AT(ADC_Common_TypeDef, ADC12_COMMON, 0x40022300u)
#define DMA1_Stream0 FAKE_AT(DMA_Stream_TypeDef, DMA1_Stream0, 0x40020010u)
#define DMAMUX1_Channel0 FAKE_AT(DMAMUX_Channel_TypeDef, DMAMUX1_Channel0, 0x40020800u)
#define DBGMCU FAKE_AT(DBGMCU_TypeDef, DBGMCU, 0x5C001000u)
#define FLASH FAKE_AT(FLASH_TypeDef, FLASH, 0x52002000u)
#define PWR FAKE_AT(PWR_TypeDef, PWR, 0x58024800u)
#define RCC FAKE_AT(RCC_TypeDef, RCC, 0x58024400u)
#define SYSCFG FAKE_AT(SYSCFG_TypeDef, SYSCFG, 0x58000400u)
#define USART3 FAKE_AT(USART_TypeDef, USART3, 0x40004800u)

#endif
