#include "board.h"

#include "chip.h"

#define UART_CLOCK_Hz 48000000u
#define BAUD 115200u
#define DIVISOR ((UART_CLOCK_Hz + 8u * BAUD) / (16u * BAUD))
#define UART_FIFO_ON 7u
// 25 MHz from the crystal; the counter's low 13 bits are fixed: (61 + 1) of 0.33 ms, 20 ms.
#define WATCHDOG_PRELOAD 61u

void irq_handler(void);

void chip_wait_us(uint32_t us) {
    const uint32_t from = reg_cycles();
    while (reg_cycles() - from < us * (CHIP_F_CPU_Hz / 1000000u)) {
    }
}

static void driver_init(void) {
    reg_write32(IOMUX_KICK0, IOMUX_KICK0_UNLOCK);
    reg_write32(IOMUX_KICK1, IOMUX_KICK1_UNLOCK);
    chip_driver_set(false);
    const uint32_t dir = reg_read32(GPIO_DIR(VARIANT_ENABLE_GPIO));
    reg_write32(GPIO_DIR(VARIANT_ENABLE_GPIO), dir & ~GPIO_BIT(VARIANT_ENABLE_GPIO));
    reg_write32(IOMUX_PAD(VARIANT_ENABLE_GPIO), PAD_OUTPUT | PAD_GPIO);
}

void chip_driver_set(bool on) {
    const uint32_t address = on ? GPIO_SET(VARIANT_ENABLE_GPIO) : GPIO_CLEAR(VARIANT_ENABLE_GPIO);
    reg_write32(address, GPIO_BIT(VARIANT_ENABLE_GPIO));
}

static void pwm_pins_init(void) {
    static const uint32_t pads[] = VARIANT_PWM_PADS;
    for (uint32_t n = 0u; n < sizeof pads / sizeof pads[0]; n++) {
        reg_write32(IOMUX_PAD(pads[n]), PAD_OUTPUT);
    }
}

static void serial_init(void) {
    reg_write32(UART0 + UART_MDR1, UART_MDR1_OFF);
    reg_write32(UART0 + UART_LCR, UART_LCR_DIVISOR);
    reg_write32(UART0 + UART_DLL, DIVISOR & 0xFFu);
    reg_write32(UART0 + UART_DLH, DIVISOR >> 8);
    reg_write32(UART0 + UART_LCR, UART_LCR_8N1);
    reg_write32(UART0 + UART_FCR, UART_FIFO_ON);
    reg_write32(UART0 + UART_MDR1, UART_MDR1_ON);
    reg_write32(IOMUX_PAD(VARIANT_TX_PAD), PAD_OUTPUT);
}

static void watchdog_start(void) {
    reg_write32(WDT_PRELOAD, WATCHDOG_PRELOAD);
    reg_write32(WDT_REACTION, WDT_REACTION_RESET); // pins float: pull-downs switch off
    reg_write32(WDT_WINDOW, WDT_WINDOW_ALL);
    reg_write32(WDT_ENABLE, WDT_ENABLE_KEY);
    board_feed_watchdog();
}

bool board_reset_by_watchdog(void) {
    const uint32_t cause = reg_read32(TOP_RCM_WARM_RST_CAUSE);
    reg_write32(TOP_RCM_KICK0, KICK0_UNLOCK);
    reg_write32(TOP_RCM_KICK1, KICK1_UNLOCK);
    reg_write32(TOP_RCM_WARM_RST_CAUSE_CLR, RST_CAUSE_FORGET);
    return (cause & RST_CAUSE_WATCHDOGS) != 0u;
}

bool board_init(float i_trip_A) {
    driver_init();
    serial_init(); // needed to report a failure
    chip_protection_init(i_trip_A);
    if (!chip_pwm_init()) {
        return false;
    }
    chip_adc_init();
    ti_init();
    pwm_pins_init(); // only now, when the trip zones hold the outputs low
    ti_driver_enable();
    return board_clear_trip();
}

void board_start(void) {
    const uint32_t irq = IRQ_CONTROLSS_INTXBAR0;
    watchdog_start();
    (void)chip_adc_acknowledge();
    reg_write32(VIM_MAP(irq), reg_read32(VIM_MAP(irq)) & ~VIM_BIT(irq));  // IRQ
    reg_write32(VIM_TYPE(irq), reg_read32(VIM_TYPE(irq)) | VIM_BIT(irq)); // pulse
    reg_write32(VIM_PRIORITY(irq), 0u);
    reg_write32(VIM_STS(irq), VIM_BIT(irq));
    reg_write32(VIM_ENABLE(irq), VIM_BIT(irq));
    reg_interrupts_on();
    chip_pwm_start();
}

/// The only interrupt in use; startup.S has saved the registers that the compiler may use, FPU included.
LODE_RAMFUNC void irq_handler(void) {
    (void)reg_read32(VIM_IRQVEC); // takes it
    reg_write32(VIM_STS(IRQ_CONTROLSS_INTXBAR0), VIM_BIT(IRQ_CONTROLSS_INTXBAR0));
    ti_period();
    reg_write32(VIM_IRQVEC, 0u); // done
}

void board_feed_watchdog(void) {
    reg_write32(WDT_KEY, 0xE51Au);
    reg_write32(WDT_KEY, 0xA35Cu);
}

LODE_RAMFUNC uint32_t board_cycles(void) {
    return reg_cycles();
}

uint32_t board_send(const uint16_t *octets, uint32_t count) {
    uint32_t taken = 0u;
    while (taken < count && (reg_read32(UART0 + UART_SSR) & UART_SSR_TX_FULL) == 0u) {
        reg_write32(UART0 + UART_THR, octets[taken]);
        taken++;
    }
    return taken;
}
