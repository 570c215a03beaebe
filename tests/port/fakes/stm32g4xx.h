/// The names of ST's stm32g4xx.h that port/stm32g4 uses; see stm32_common.h.
#ifndef FAKES_STM32G4XX_H
#define FAKES_STM32G4XX_H

#include "stm32_common.h"

typedef struct {
    volatile uint32_t ISR, IER, CR, CFGR, CFGR2, SMPR1, SMPR2, RESERVED1[12], JSQR, RESERVED2[12],
        JDR1, JDR2, JDR3, JDR4;
} ADC_TypeDef;

typedef struct {
    volatile uint32_t CSR, RESERVED, CCR, CDR;
} ADC_Common_TypeDef;

typedef struct {
    volatile uint32_t CSR;
} COMP_TypeDef;

typedef struct {
    volatile uint32_t CSR, WDATA, RDATA;
} CORDIC_TypeDef;

typedef struct {
    volatile uint32_t CSR;
} OPAMP_TypeDef;

typedef struct {
    volatile uint32_t CR, SWTRIGR, DHR12R1, DHR12L1, DHR8R1, DHR12R2, RESERVED[9], MCR;
} DAC_TypeDef;

typedef struct {
    volatile uint32_t CCR, CNDTR, CPAR, CMAR;
} DMA_Channel_TypeDef;

typedef struct {
    volatile uint32_t CCR;
} DMAMUX_Channel_TypeDef;

typedef struct {
    volatile uint32_t IDCODE, CR, APB1FZR1, APB1FZR2, APB2FZ;
} DBGMCU_TypeDef;

typedef struct {
    volatile uint32_t ACR;
} FLASH_TypeDef;

typedef struct {
    volatile uint32_t CR1, CR2, CR3, RESERVED[29], CR5;
} PWR_TypeDef;

typedef struct {
    volatile uint32_t CR, ICSCR, CFGR, PLLCFGR, RESERVED1[12], APB2RSTR, RESERVED4, AHB1ENR,
        AHB2ENR, RESERVED2[2], APB1ENR1, APB1ENR2, APB2ENR, RESERVED3[12], CSR;
} RCC_TypeDef;

typedef struct {
    volatile uint32_t MEMRMP, CFGR1, EXTICR[4], SCSR, CFGR2;
} SYSCFG_TypeDef;

typedef struct {
    volatile uint32_t CR1, CR2, CR3, BRR, GTPR, RTOR, RQR, ISR, ICR, RDR, TDR;
} USART_TypeDef;

#define TIM_SR_B2IF (1u << 8)
#define TIM_SR_SBIF (1u << 13)
#define TIM_BDTR_BKF_Pos 16u
#define TIM_BDTR_BK2F_Pos 20u
#define TIM_BDTR_BK2E (1u << 24)
#define TIM_BDTR_BK2P (1u << 25)
#define TIM1_AF1_BKINE 1u
#define TIM1_AF1_BKCMP1E (1u << 1)
#define TIM1_AF1_BKCMP2E (1u << 2)
#define TIM1_AF1_BKCMP4E (1u << 4)
#define TIM1_AF1_BKINP (1u << 9)
#define TIM1_AF2_BK2INE 1u
#define TIM1_AF2_BK2INP (1u << 9)

#define ADC_ISR_ADRDY 1u
#define ADC_ISR_JEOC (1u << 5)
#define ADC_ISR_JEOS (1u << 6)
#define ADC_IER_JEOSIE (1u << 6)
#define ADC_CR_ADEN 1u
#define ADC_CR_JADSTART (1u << 3)
#define ADC_CR_JADSTP (1u << 5)
#define ADC_CR_ADVREGEN (1u << 28)
#define ADC_CR_ADCAL (1u << 31)
#define ADC_CFGR_JDISCEN (1u << 20)
#define ADC_JSQR_JL_Pos 0u
#define ADC_JSQR_JEXTSEL_Pos 2u
#define ADC_JSQR_JEXTEN_Pos 7u
#define ADC_JSQR_JSQ1_Pos 9u
#define ADC_JSQR_JSQ2_Pos 15u
#define ADC_JSQR_JSQ3_Pos 21u
#define ADC_CCR_DUAL_Pos 0u
#define ADC_CCR_CKMODE_Pos 16u

#define COMP_CSR_EN 1u
#define COMP_CSR_INMSEL_Pos 4u
#define COMP_CSR_VALUE (1u << 30)
#define OPAMP_CSR_OPAMPxEN 1u
#define OPAMP_CSR_VMSEL_Pos 5u
#define OPAMP_CSR_HIGHSPEEDEN (1u << 7)
#define OPAMP_CSR_PGGAIN_Pos 14u
#define DAC_CR_EN1 1u
#define DAC_CR_EN2 (1u << 16)
#define DAC_MCR_MODE1_Pos 0u
#define DAC_MCR_HFSEL_Pos 14u
#define DAC_MCR_MODE2_Pos 16u

#define CORDIC_CSR_FUNC_Pos 0u
#define CORDIC_CSR_PRECISION_Pos 4u
#define CORDIC_CSR_NRES (1u << 19)
#define CORDIC_CSR_NARGS (1u << 20)

#define DMA_CCR_EN 1u
#define DMA_CCR_DIR (1u << 4)
#define DMA_CCR_CIRC (1u << 5)
#define DMA_CCR_MINC (1u << 7)
#define DMA_CCR_PSIZE_1 (2u << 8)
#define DMA_CCR_MSIZE_1 (2u << 10)
#define DMA_CCR_PL (3u << 12)
#define DBGMCU_APB1FZR1_DBG_TIM2_STOP 1u
#define DBGMCU_APB1FZR1_DBG_IWDG_STOP (1u << 12)
#define DBGMCU_APB2FZ_DBG_TIM1_STOP (1u << 11)
#define FLASH_ACR_LATENCY 15u
#define FLASH_ACR_PRFTEN (1u << 8)
#define FLASH_ACR_ICEN (1u << 9)
#define FLASH_ACR_DCEN (1u << 10)
#define PWR_CR3_UCPD_DBDIS (1u << 14)
#define PWR_CR5_R1MODE (1u << 8)

#define RCC_CR_HSEON (1u << 16)
#define RCC_CR_HSERDY (1u << 17)
#define RCC_CR_CSSON (1u << 19)
#define RCC_CR_PLLON (1u << 24)
#define RCC_CR_PLLRDY (1u << 25)
#define RCC_CFGR_SW 3u
#define RCC_CFGR_SW_Pos 0u
#define RCC_CFGR_SWS 12u
#define RCC_CFGR_SWS_Pos 2u
#define RCC_CFGR_HPRE (15u << 4)
#define RCC_CFGR_HPRE_Pos 4u
#define RCC_CFGR_PPRE1 (7u << 8)
#define RCC_CFGR_PPRE2 (7u << 11)
#define RCC_PLLCFGR_PLLSRC_Pos 0u
#define RCC_PLLCFGR_PLLM_Pos 4u
#define RCC_PLLCFGR_PLLN_Pos 8u
#define RCC_PLLCFGR_PLLREN (1u << 24)
#define RCC_AHB1ENR_DMA1EN 1u
#define RCC_AHB1ENR_DMAMUX1EN (1u << 2)
#define RCC_AHB1ENR_CORDICEN (1u << 3)
#define RCC_AHB2ENR_GPIOAEN 1u
#define RCC_AHB2ENR_GPIOBEN (1u << 1)
#define RCC_AHB2ENR_GPIOCEN (1u << 2)
#define RCC_AHB2ENR_ADC12EN (1u << 13)
#define RCC_AHB2ENR_DAC3EN (1u << 18)
#define RCC_APB1ENR1_TIM2EN 1u
#define RCC_APB1ENR1_USART2EN (1u << 17)
#define RCC_APB1ENR1_PWREN (1u << 28)
#define RCC_APB2RSTR_TIM1RST (1u << 11)
#define RCC_APB2ENR_SYSCFGEN 1u
#define RCC_APB2ENR_TIM1EN (1u << 11)

#define RCC_CSR_RMVF (1u << 23)

#define SYSCFG_CFGR2_CLL 1u
#define SYSCFG_CFGR2_ECCL (1u << 3)

#define USART_CR1_UE 1u
#define USART_CR1_TE (1u << 3)
#define USART_CR1_FIFOEN (1u << 29)
#define USART_ISR_TXE (1u << 7)

#define ADC1_2_IRQn 18

#if !defined(__arm__)
extern ADC_TypeDef fake_ADC1, fake_ADC2;
extern ADC_Common_TypeDef fake_ADC12_COMMON;
extern CORDIC_TypeDef fake_CORDIC;
extern COMP_TypeDef fake_COMP1, fake_COMP2, fake_COMP4;
extern OPAMP_TypeDef fake_OPAMP1, fake_OPAMP2, fake_OPAMP3;
extern DAC_TypeDef fake_DAC3;
extern DMA_Channel_TypeDef fake_DMA1_Channel1, fake_DMA1_Channel2;
extern DMAMUX_Channel_TypeDef fake_DMAMUX1_Channel0, fake_DMAMUX1_Channel1;
extern DBGMCU_TypeDef fake_DBGMCU;
extern FLASH_TypeDef fake_FLASH;
extern PWR_TypeDef fake_PWR;
extern RCC_TypeDef fake_RCC;
extern SYSCFG_TypeDef fake_SYSCFG;
extern USART_TypeDef fake_USART2;
#endif

#define TIM1 FAKE_AT(TIM_TypeDef, TIM1, 0x40012C00u)
#define GPIOA FAKE_AT(GPIO_TypeDef, GPIOA, 0x48000000u)
#define GPIOB FAKE_AT(GPIO_TypeDef, GPIOB, 0x48000400u)
#define GPIOC FAKE_AT(GPIO_TypeDef, GPIOC, 0x48000800u)
#define ADC1 FAKE_AT(ADC_TypeDef, ADC1, 0x50000000u)
#define ADC2 FAKE_AT(ADC_TypeDef, ADC2, 0x50000100u)
#define ADC12_COMMON FAKE_AT(ADC_Common_TypeDef, ADC12_COMMON, 0x50000300u)
#define COMP1 FAKE_AT(COMP_TypeDef, COMP1, 0x40010200u)
#define COMP2 FAKE_AT(COMP_TypeDef, COMP2, 0x40010204u)
#define COMP4 FAKE_AT(COMP_TypeDef, COMP4, 0x4001020Cu)
#define CORDIC FAKE_AT(CORDIC_TypeDef, CORDIC, 0x40020C00u)
#define OPAMP1 FAKE_AT(OPAMP_TypeDef, OPAMP1, 0x40010300u)
#define OPAMP2 FAKE_AT(OPAMP_TypeDef, OPAMP2, 0x40010304u)
#define OPAMP3 FAKE_AT(OPAMP_TypeDef, OPAMP3, 0x40010308u)
#define DAC3 FAKE_AT(DAC_TypeDef, DAC3, 0x50001000u)
#define DMA1_Channel1 FAKE_AT(DMA_Channel_TypeDef, DMA1_Channel1, 0x40020008u)
#define DMA1_Channel2 FAKE_AT(DMA_Channel_TypeDef, DMA1_Channel2, 0x4002001Cu)
#define DMAMUX1_Channel1 FAKE_AT(DMAMUX_Channel_TypeDef, DMAMUX1_Channel1, 0x40020804u)
#define DMAMUX1_Channel0 FAKE_AT(DMAMUX_Channel_TypeDef, DMAMUX1_Channel0, 0x40020800u)
#define DBGMCU FAKE_AT(DBGMCU_TypeDef, DBGMCU, 0xE0042000u)
#define FLASH FAKE_AT(FLASH_TypeDef, FLASH, 0x40022000u)
#define PWR FAKE_AT(PWR_TypeDef, PWR, 0x40007000u)
#define RCC FAKE_AT(RCC_TypeDef, RCC, 0x40021000u)
#define SYSCFG FAKE_AT(SYSCFG_TypeDef, SYSCFG, 0x40010000u)
#define USART2 FAKE_AT(USART_TypeDef, USART2, 0x40004400u)

#endif
