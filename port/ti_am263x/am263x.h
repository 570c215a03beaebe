/// Addresses and bits of the AM263x that this port uses: AM263x TRM (SPRUJ17) and register addendum.
/// CONTROLSS has C2000's ePWM, ADC and CMPSS at byte addresses, without EALLOW.
#ifndef LODESTAR_PORT_TI_AM263X_AM263X_H
#define LODESTAR_PORT_TI_AM263X_AM263X_H

// ePWM, 16-bit registers.
#define EPWM(n) (0x50000000u + 0x1000u * (uint32_t)(n))
#define EPWM_TBCTL 0x000u
#define EPWM_TBCTR 0x008u
#define EPWM_TBSTS 0x00Au
#define EPWM_CMPCTL 0x010u
#define EPWM_DBCTL 0x018u
#define EPWM_AQCTLA 0x080u
#define EPWM_AQCTLB 0x084u
#define EPWM_AQSFRC 0x08Eu
#define EPWM_AQCSFRC 0x092u
#define EPWM_DBRED 0x0A2u
#define EPWM_DBFED 0x0A6u
#define EPWM_TBPRD 0x0C6u
#define EPWM_CMPA 0x0D6u // above its high-resolution half
#define EPWM_TZSEL 0x100u
#define EPWM_TZDCSEL 0x104u
#define EPWM_TZCTL 0x108u
#define EPWM_TZFLG 0x126u
#define EPWM_TZOSTFLG 0x12Au
#define EPWM_TZCLR 0x12Eu
#define EPWM_TZOSTCLR 0x132u
#define EPWM_TZFRC 0x136u
#define EPWM_ETSEL 0x148u
#define EPWM_ETPS 0x14Cu
#define EPWM_DCTRIPSEL 0x180u
#define EPWM_DCACTL 0x186u
#define EPWM_DCBCTL 0x188u
#define EPWM_LOCK 0x1F4u // 32 bits

#define TBCTL_UP_DOWN 0x0002u
#define TBCTL_PERIOD_AT_ONCE 0x0008u
#define TBCTL_FREE_RUN 0x8000u
#define TBSTS_UP 0x0001u
#define AQCTL_HIGH_AT_CMPA_UP 0x0020u
#define AQCTL_LOW_AT_CMPA_DOWN 0x0040u
#define AQCTL_LOW_AT_CMPA_UP 0x0010u
#define AQCTL_HIGH_AT_CMPA_DOWN 0x0080u
#define AQSFRC_AT_ONCE 0x00C0u // AQCSFRC acts when it is written
#define AQCSFRC_A_LOW 0x0001u
#define DBCTL_BOTH_EDGES 0x0003u
#define DBCTL_COMPLEMENT 0x0008u // B inverted; A is the input of both edges
#define TZ_OST5 0x1000u          // lost clock
#define TZ_OST6 0x2000u          // halted core
#define TZ_DCAEVT1 0x4000u
#define TZ_DCBEVT1 0x8000u
#define TZCTL_A_LOW 0x0002u
#define TZCTL_B_LOW 0x0008u
#define TZDCSEL_A1_HIGH 0x0002u // DCAEVT1 while DCAH is high
#define TZDCSEL_B1_LOW 0x0040u  // DCBEVT1 while DCBH is low
#define TZFLG_OST 0x0004u
#define TZFLG_DCAEVT1 0x0008u
#define TZFLG_DCBEVT1 0x0020u
#define TZOST_OST5 0x0010u
#define TZOST_OST6 0x0020u
#define TZOST_DCAEVT1 0x0040u
#define TZOST_DCBEVT1 0x0080u
#define TZFRC_OST 0x0004u
#define CMPCTL_AT_ZERO 0x0000u
#define CMPCTL_AT_ZERO_AND_PERIOD 0x0002u
#define ETSEL_SOCA_AT_ZERO 0x0900u
#define ETSEL_SOCA_AT_ZERO_AND_PERIOD 0x0B00u
#define ETPS_SOCA_EVERY 0x0100u
#define DCTRIPSEL_AH_1_BH_2 0x0100u // TRIPIN1 and TRIPIN2
#define DCCTL_EVT1_ASYNC 0x0002u
#define LOCK_TRIP_ZONE_AND_COMPARE 0xA5A50014u // key, groups

// ADCs, 16-bit registers but for the SOCs.
#define ADC(n) (0x502C0000u + 0x1000u * (uint32_t)(n))
#define ADC_RESULT(n, soc) (0x50100000u + 0x1000u * (uint32_t)(n) + 2u * (uint32_t)(soc))
#define ADC_CTL1 0x000u
#define ADC_CTL2 0x002u
#define ADC_INTFLGCLR 0x008u
#define ADC_INTOVF 0x00Au
#define ADC_INTOVFCLR 0x00Cu
#define ADC_INTSEL1N2 0x00Eu
#define ADC_SOCPRICTL 0x012u
#define ADC_SOC(soc) (0x020u + 4u * (uint32_t)(soc))
#define ADCCTL1_END_OF_CONVERSION 0x0004u
#define ADCCTL1_POWER 0x0080u
#define ADCCTL2_CLOCK_BY_4 0x0006u
#define ADCINT1 0x0001u
#define ADCINTSEL_INT1_SOC1 0x0021u
#define ADCSOCPRI_ALL 0x0010u
#define ADC_TRIGGER_EPWM_SOCA(n) (8u + 2u * (uint32_t)(n))
#define ADCSOC(trigger, channel, window) ((trigger) << 20 | (channel) << 15 | ((window)-1u))

// Comparators with both inputs on one pin.
#define CMPSSB(n) (0x50220000u + 0x1000u * (uint32_t)(n))
#define CMPSS_COMPCTL 0x000u
#define CMPSS_DACCTL 0x008u
#define CMPSS_DACHVALS 0x00Cu
#define CMPSS_DACLVALS 0x024u
#define CMPSS_LFILCTL 0x02Cu
#define CMPSS_LFILCLK 0x02Eu
#define CMPSS_HFILCTL 0x030u
#define CMPSS_HFILCLK 0x032u
#define COMPCTL_ON 0x8000u
#define COMPCTL_HIGH_FILTERED 0x0028u
#define COMPCTL_LOW_FILTERED_INVERTED 0x2A00u
#define FILCTL_INIT 0x8000u
#define FILCTL(window, threshold) (((window)-1u) << 4 | ((threshold)-1u) << 9)

// Crossbars and CONTROLSS_CTRL.
#define INPUTXBAR0_GSEL 0x502D0100u
#define INPUTXBAR0_G0 0x502D0104u // GPIO number
#define PWMXBAR0_G1 0x502D1104u   // output 0 is TRIPIN1; group 1 is CMPSSB
#define PWMXBAR1_G4 0x502D1150u   // output 1 is TRIPIN2; group 4 is INPUTXBAR
#define PWMXBAR_CMPSSB(n) (3u << (2u * (uint32_t)(n)))
#define PWMXBAR_INPUT0 0x1u
#define INTXBAR0_G2 0x502D5108u // output 0; group 2 is ADC
#define INTXBAR_ADC_INT1(n) (1u << (5u * (uint32_t)(n)))
#define CONTROLSS_CLKSYNC 0x502F0010u // a bit per ePWM
// The core whose halt reaches this ePWM as TZ6 and emulation mode; 0 (none) after reset.
#define CONTROLSS_EPWM_HALTEN(n) (0x502F0500u + 4u * (uint32_t)(n))
#define HALTEN_R5SS0_CORE0 0x1u
#define CONTROLSS_KICK0 0x502F1008u
#define CONTROLSS_KICK1 0x502F100Cu
#define TOP_ADC_REFBUF0 0x50D80C00u
#define TOP_ADC_REFBUF1 0x50D80C04u
#define TOP_ADC_REFCOMP 0x50D80C08u
#define TOP_KICK0 0x50D81008u
#define TOP_KICK1 0x50D8100Cu
#define KICK0_UNLOCK 0x01234567u
#define KICK1_UNLOCK 0x0FEDCBA8u

// Pads: one register per GPIO number, in its order.
#define IOMUX_PAD(gpio) (0x53100000u + 4u * (uint32_t)(gpio))
#define IOMUX_KICK0 0x53100298u
#define IOMUX_KICK1 0x5310029Cu
#define IOMUX_KICK0_UNLOCK 0x83E70B13u
#define IOMUX_KICK1_UNLOCK 0x95A4F1E0u
#define PAD_OUTPUT 0x500u // function 0, no pull, output enabled
#define PAD_GPIO 7u
#define PAD_PULL_UP 0x200u // bit 8 clear: pulls work; bit 9: up

// GPIO: banks of 32.
#define GPIO_DIR(gpio) (0x52000010u + 0x28u * ((uint32_t)(gpio) / 32u))
#define GPIO_SET(gpio) (0x52000018u + 0x28u * ((uint32_t)(gpio) / 32u))
#define GPIO_CLEAR(gpio) (0x5200001Cu + 0x28u * ((uint32_t)(gpio) / 32u))
#define GPIO_BIT(gpio) (1u << ((uint32_t)(gpio) % 32u))

// Interrupt controller, watchdog, serial port.
#define VIM_IRQVEC 0x50F00018u
#define VIM_STS(n) (0x50F00404u + 0x20u * ((uint32_t)(n) / 32u))
#define VIM_ENABLE(n) (0x50F00408u + 0x20u * ((uint32_t)(n) / 32u))
#define VIM_MAP(n) (0x50F00418u + 0x20u * ((uint32_t)(n) / 32u))
#define VIM_TYPE(n) (0x50F0041Cu + 0x20u * ((uint32_t)(n) / 32u))
#define VIM_PRIORITY(n) (0x50F01000u + 4u * (uint32_t)(n))
#define VIM_VECTOR(n) (0x50F02000u + 4u * (uint32_t)(n))
#define VIM_BIT(n) (1u << ((uint32_t)(n) % 32u))
#define IRQ_CONTROLSS_INTXBAR0 146u

#define TOP_RCM_WARM_RST_CAUSE 0x5320000Cu
#define TOP_RCM_WARM_RST_CAUSE_CLR 0x53200010u
#define TOP_RCM_KICK0 0x53201008u
#define TOP_RCM_KICK1 0x5320100Cu
#define RST_CAUSE_FORGET 7u
#define RST_CAUSE_WATCHDOGS 0x1Eu // of the four cores

#define WDT_ENABLE 0x52100090u
#define WDT_PRELOAD 0x52100094u
#define WDT_KEY 0x5210009Cu
#define WDT_REACTION 0x521000A4u
#define WDT_WINDOW 0x521000A8u
#define WDT_ENABLE_KEY 0xA98559DAu
#define WDT_REACTION_RESET 0x5u
#define WDT_WINDOW_ALL 0x5u

#define UART0 0x52300000u
#define UART_THR 0x00u
#define UART_DLL 0x00u
#define UART_DLH 0x04u
#define UART_FCR 0x08u
#define UART_LCR 0x0Cu
#define UART_LSR 0x14u
#define UART_MDR1 0x20u
#define UART_SSR 0x44u
#define UART_LCR_DIVISOR 0x83u
#define UART_LCR_8N1 0x03u
#define UART_MDR1_OFF 7u
#define UART_MDR1_ON 0u
#define UART_SSR_TX_FULL 0x1u

#endif
