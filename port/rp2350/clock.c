#include "chip.h"

// 12 MHz x 125 / 5 / 2 and 12 MHz x 100 / 5 / 5.
#define SYS_FEEDBACK (1500000000u / VARIANT_XOSC_Hz)
#define USB_FEEDBACK (1200000000u / VARIANT_XOSC_Hz)
#define STARTUP_DELAY (VARIANT_XOSC_Hz / 1000u * 4u / 256u) // 4 ms
#define WAIT_LOOPS_us 150u

bool chip_release(uint32_t fresh, uint32_t others) {
    reg_set(RESETS_RESET, fresh);
    reg_clear(RESETS_RESET, fresh | others);
    return reg_await(RESETS_DONE, fresh | others, fresh | others);
}

static bool pll(uint32_t base, uint32_t feedback, uint32_t dividers) {
    reg_write(base + PLL_PWR, PLL_PWR_DOWN);
    reg_write(base + PLL_CS, PLL_CS_REFDIV_1);
    reg_write(base + PLL_FBDIV, feedback);
    reg_write(base + PLL_PWR, PLL_PWR_POSTDIV_DOWN);
    const bool locked = reg_await(base + PLL_CS, PLL_CS_LOCK, PLL_CS_LOCK);
    reg_write(base + PLL_PRIM, dividers);
    reg_write(base + PLL_PWR, PLL_PWR_UP);
    return locked;
}

// The auxiliary source must not change while it is in use.
static bool system_from(uint32_t source) {
    reg_write(CLK_SYS_CTRL, (reg_read(CLK_SYS_CTRL) & ~CLK_SYS_SOURCE) | source);
    return reg_await(CLK_SYS_SELECTED, 1u << source, 1u << source);
}

bool chip_clock_init(void) {
    reg_clear(CLK_REF_CTRL, CLK_REF_SOURCE); // the ring oscillator
    bool ok = reg_await(CLK_REF_SELECTED, 1u, 1u) && system_from(CLK_SYS_FROM_REF);
    reg_write(CLK_SYS_CTRL, CLK_SYS_AUX_PLL);
    reg_write(CLK_PERI_CTRL, CLK_ENABLE);
    reg_write(XOSC_STARTUP, STARTUP_DELAY);
    reg_write(XOSC_CTRL, XOSC_ENABLE_1_15_MHZ);
    ok = ok && reg_await(XOSC_STATUS, XOSC_STABLE, XOSC_STABLE);
    ok = ok && chip_release(RESET_PLL_SYS | RESET_PLL_USB, 0u);
    ok = ok && pll(PLL_SYS, SYS_FEEDBACK, PLL_PRIM_DIV(5u, 2u));
    ok = ok && pll(PLL_USB, USB_FEEDBACK, PLL_PRIM_DIV(5u, 5u));
    if (!ok) {
        return false;
    }
    reg_write(CLK_SYS_DIV, CLK_DIV_1);
    reg_write(CLK_ADC_CTRL, CLK_ENABLE);
    chip_clock_forget();
    return system_from(CLK_SYS_FROM_AUX);
}

LODE_RAMFUNC bool chip_clock_lost(void) {
    return (reg_read(PLL_SYS + PLL_INTR) & PLL_INTR_LOCK_LOST) != 0u;
}

void chip_clock_forget(void) {
    reg_write(PLL_SYS + PLL_INTR, PLL_INTR_LOCK_LOST);
}

void chip_wait_us(uint32_t us) {
    for (volatile uint32_t n = 0u; n < us * WAIT_LOOPS_us / 5u; n++) { // five cycles or more each
    }
}
