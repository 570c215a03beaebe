// Three slices count up and down. Their outputs are inverted, so the high sides are on around the upper
// turning point and all low sides around zero: there the compare values are loaded. That instant is t_k. Two
// more slices count as sawtooths: one wraps before t_k by the lead of the ADC and starts it; the other wraps if
// no interrupt has come for one and a half periods, and switches the gates off.
#include "chip.h"

static const uint32_t gpio[CHIP_PHASES] = VARIANT_PWM_GPIOS;
static uint32_t steps;
static uint32_t written[CHIP_PHASES]; // compare values

static uint32_t slice_of(uint32_t pin) {
    return pin / 2u % 8u;
}

static void slice(uint32_t n, uint32_t control, uint32_t top, uint32_t from) {
    reg_write(PWM_CSR(n), control);
    reg_write(PWM_DIV(n), PWM_DIV_1);
    reg_write(PWM_TOP(n), top);
    reg_write(PWM_CTR(n), from);
}

bool chip_pwm_init(void) {
    const uint32_t lead =
        (uint32_t)(int32_t)(CHIP_LEAD_ns * ((float)CHIP_F_SYS_Hz * 1.0e-9f) + 0.5f);
    steps = port_pwm_steps(CHIP_F_PWM_Hz, VARIANT_F_PWM_Hz);
    if (steps == 0u || 3u * steps > UINT16_MAX + 1u) {
        return false;
    }
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        // Zero and top are counted twice: a period is 2 (top + 1).
        slice(slice_of(gpio[n]), PWM_CSR_UP_DOWN | PWM_CSR_A_INVERTED, steps - 1u, 0u);
    }
    slice(CHIP_TRIGGER_SLICE, 0u, 2u * steps - 1u, lead);
    slice(CHIP_DEADLINE_SLICE, 0u, 3u * steps - 1u, 0u);
    chip_pwm_write((lode_abc_t){0.5f, 0.5f, 0.5f}); // no voltage between the phases
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        reg_write(PIN_CTRL(gpio[n]), PIN_PWM);
        reg_write(PAD(gpio[n]), PAD_OUTPUT);
    }
    return true;
}

void chip_pwm_start(void) {
    uint32_t all = 1u << CHIP_TRIGGER_SLICE | 1u << CHIP_DEADLINE_SLICE;
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        all |= 1u << slice_of(gpio[n]);
    }
    reg_write(PWM_EN, all);
}

// High while the counter is at or above the compare value; it never reaches top + 1.
static inline uint32_t compare(float duty) {
    return (uint32_t)(int32_t)((1.0f - duty) * (float)steps + 0.5f);
}

LODE_RAMFUNC void chip_pwm_write(lode_abc_t duty) {
    written[0] = compare(duty.a);
    written[1] = compare(duty.b);
    written[2] = compare(duty.c);
    reg_write(PWM_CC(slice_of(gpio[0])), written[0]);
    reg_write(PWM_CC(slice_of(gpio[1])), written[1]);
    reg_write(PWM_CC(slice_of(gpio[2])), written[2]);
}

LODE_RAMFUNC bool chip_pwm_holds(void) {
    return reg_read(PWM_CC(slice_of(gpio[0]))) == written[0] &&
           reg_read(PWM_CC(slice_of(gpio[1]))) == written[1] &&
           reg_read(PWM_CC(slice_of(gpio[2]))) == written[2];
}

LODE_RAMFUNC void chip_deadline_move(void) {
    reg_write(PWM_CTR(CHIP_DEADLINE_SLICE), 0u);
}
