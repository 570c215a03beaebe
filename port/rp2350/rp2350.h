/// Registers of the RP2350 that the port uses, by address. Facts from the data sheet and the register
/// headers that Raspberry Pi publishes; names are this port's.
#ifndef LODESTAR_PORT_RP2350_REGISTERS_H
#define LODESTAR_PORT_RP2350_REGISTERS_H

// Subsystem resets: 1 holds in reset.
#define RESETS_RESET 0x40020000u
#define RESETS_DONE 0x40020008u
#define RESET_ADC (1u << 0)
#define RESET_DMA (1u << 2)
#define RESET_IO_BANK0 (1u << 6)
#define RESET_PADS_BANK0 (1u << 9)
#define RESET_PLL_SYS (1u << 14)
#define RESET_PLL_USB (1u << 15)
#define RESET_PWM (1u << 16)
#define RESET_TIMER0 (1u << 23)
#define RESET_UART0 (1u << 26)

// Clocks. The glitchless ones show their source, one bit each, in SELECTED.
#define CLK_REF_CTRL 0x40010030u
#define CLK_REF_SELECTED 0x40010038u
#define CLK_REF_SOURCE 3u // 0: the ring oscillator
#define CLK_SYS_CTRL 0x4001003Cu
#define CLK_SYS_DIV 0x40010040u
#define CLK_SYS_SELECTED 0x40010044u
#define CLK_SYS_FROM_REF 0u
#define CLK_SYS_FROM_AUX 1u
#define CLK_SYS_SOURCE 1u
#define CLK_SYS_AUX_PLL 0u // the other bits: the system's PLL
#define CLK_PERI_CTRL 0x40010048u
#define CLK_ADC_CTRL 0x4001006Cu
#define CLK_ENABLE (1u << 11) // source 0: the system clock for CLK_PERI, the USB PLL for CLK_ADC
#define CLK_DIV_1 (1u << 16)

#define XOSC_CTRL 0x40048000u
#define XOSC_ENABLE_1_15_MHZ 0x00FABAA0u
#define XOSC_STATUS 0x40048004u
#define XOSC_STABLE (1u << 31)
#define XOSC_STARTUP 0x4004800Cu

#define PLL_SYS 0x40050000u
#define PLL_USB 0x40058000u
#define PLL_CS 0x00u
#define PLL_CS_LOCK (1u << 31)
#define PLL_CS_REFDIV_1 1u
#define PLL_PWR 0x04u
#define PLL_PWR_DOWN 0x2Du
#define PLL_PWR_POSTDIV_DOWN 0x0Cu // the post divider, and a part that this PLL does not have
#define PLL_PWR_UP 0x04u
#define PLL_FBDIV 0x08u
#define PLL_PRIM 0x0Cu
#define PLL_PRIM_DIV(first, second) ((first) << 16 | (second) << 12)
#define PLL_INTR 0x10u
#define PLL_INTR_LOCK_LOST 1u

// Microseconds for the watchdog, from the reference clock.
#define TICKS_WATCHDOG_CTRL 0x40108030u
#define TICKS_WATCHDOG_CYCLES 0x40108034u
#define TICKS_ENABLE 1u
#define PSM_WDSEL 0x40018008u
#define PSM_WDSEL_ALL_BUT_OSCILLATORS 0x01FFFFF3u
#define WATCHDOG_CTRL 0x400D8000u
#define WATCHDOG_CTRL_ENABLE (1u << 30)
#define WATCHDOG_LOAD 0x400D8004u
#define WATCHDOG_REASON 0x400D8008u
#define WATCHDOG_REASON_TIMER 1u

// SIO: pins 0 .. 31.
#define GPIO_IN 0xD0000004u
#define GPIO_OUT 0xD0000010u
#define GPIO_OUT_SET 0xD0000018u
#define GPIO_OUT_CLR 0xD0000020u
#define GPIO_OE_SET 0xD0000038u

#define PIN_CTRL(gpio) (0x40028004u + 8u * (gpio))
#define PIN_UART 2u
#define PIN_PWM 4u
#define PIN_SIO 5u
#define PIN_OUT_LOW (2u << 12) // overrides the function
// Edges are stored until cleared by writing 1.
#define PIN_EVENTS(gpio) (0x40028230u + 4u * ((gpio) / 8u))
#define PIN_EVENT_FELL(gpio) (4u << (4u * ((gpio) % 8u)))

#define PAD(gpio) (0x40038004u + 4u * (gpio))
#define PAD_OUTPUT 0x12u          // 4 mA, Schmitt trigger; neither isolated nor pulled
#define PAD_INPUT_PULLED_UP 0x4Au // input on
#define PAD_ANALOG 0x80u          // output off, input off, no pull

#define PWM_CSR(slice) (0x400A8000u + 20u * (slice))
#define PWM_CSR_UP_DOWN (1u << 1)
#define PWM_CSR_A_INVERTED (1u << 2)
#define PWM_DIV(slice) (PWM_CSR(slice) + 0x04u)
#define PWM_DIV_1 (1u << 4)
#define PWM_CTR(slice) (PWM_CSR(slice) + 0x08u)
#define PWM_CC(slice) (PWM_CSR(slice) + 0x0Cu)
#define PWM_TOP(slice) (PWM_CSR(slice) + 0x10u)
#define PWM_EN 0x400A80F0u

#define ADC_CS 0x400A0000u
#define ADC_CS_EN (1u << 0)
#define ADC_CS_START_MANY (1u << 3)
#define ADC_CS_READY (1u << 8)
#define ADC_CS_FIRST_Pos 12u
#define ADC_CS_ROUND_Pos 16u
#define ADC_FCS 0x400A0008u
#define ADC_FCS_EN (1u << 0)
#define ADC_FCS_EMPTY (1u << 8)
#define ADC_FCS_UNDER (1u << 10) // this and the next: cleared by writing 1
#define ADC_FCS_OVER (1u << 11)
#define ADC_FCS_LEVEL(fcs) ((fcs) >> 16 & 15u)
#define ADC_FCS_THRESHOLD_Pos 24u
#define ADC_FIFO 0x400A000Cu
#define ADC_FIFO_DEPTH 8u
#define ADC_DIV 0x400A0010u
#define ADC_INTE 0x400A0018u
#define ADC_INTE_FIFO 1u

#define DMA_READ(channel) (0x50000000u + 64u * (channel))
#define DMA_WRITE(channel) (DMA_READ(channel) + 0x04u)
#define DMA_COUNT(channel) (DMA_READ(channel) + 0x08u)
#define DMA_COUNT_ENDLESS 0xF0000001u
#define DMA_CTRL(channel) (DMA_READ(channel) + 0x0Cu) // writing starts it
// One word for each wrap of a slice, with high priority, to and from fixed addresses; chained to itself, which
// means not chained.
#define DMA_WORD_PER_WRAP(channel, slice)                                                          \
    (1u | 1u << 1 | 2u << 2 | (channel) << 13 | (32u + (slice)) << 17)

#define TIMER0_RAWL 0x400B0028u
#define TIMER0_DBGPAUSE 0x400B002Cu
#define TIMER0_SOURCE 0x400B0038u
#define TIMER_SOURCE_SYSTEM 1u

#define UART0_DR 0x40070000u
#define UART0_FR 0x40070018u
#define UART_FR_TX_FULL (1u << 5)
#define UART0_IBRD 0x40070024u
#define UART0_FBRD 0x40070028u
#define UART0_LCR 0x4007002Cu
#define UART_LCR_8N1_FIFO 0x70u
#define UART0_CR 0x40070030u
#define UART_CR_TX 0x101u

#define NVIC_ENABLE_1 0xE000E104u // 32 .. 63
#define NVIC_PRIORITY(irq) (0xE000E400u + ((irq) & ~3u))
#define IRQ_ADC_FIFO 35u

#endif
