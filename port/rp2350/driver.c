// The gate driver: enable, reset and fault. The override of the enable pin is the latch of the deadline. The
// stored edge of the fault line is the latch of an over-current, to which the driver itself has already
// responded.
#include "chip.h"

#define WAKE_us 1000u // wake-up time of a driver after its reset
#define RESET_us 20u  // reset of its latch: the DRV83xx need 8 .. 40 us

#define ENABLE (1u << VARIANT_ENABLE_GPIO)
#define RESET (1u << VARIANT_RESET_GPIO)
#define FAULT (1u << VARIANT_FAULT_GPIO)

void chip_driver_init(void) {
    reg_write(GPIO_OUT_CLR, ENABLE | RESET);
    reg_write(GPIO_OE_SET, ENABLE | RESET);
    reg_write(PIN_CTRL(VARIANT_ENABLE_GPIO), PIN_SIO);
    reg_write(PIN_CTRL(VARIANT_RESET_GPIO), PIN_SIO);
    reg_write(PIN_CTRL(VARIANT_FAULT_GPIO), PIN_SIO);
    reg_write(PAD(VARIANT_ENABLE_GPIO), PAD_OUTPUT);
    reg_write(PAD(VARIANT_RESET_GPIO), PAD_OUTPUT);
    reg_write(PAD(VARIANT_FAULT_GPIO), PAD_INPUT_PULLED_UP);
}

LODE_RAMFUNC void chip_gates_off(void) {
    reg_write(GPIO_OUT_CLR, ENABLE);
}

LODE_RAMFUNC bool chip_tripped(void) {
    return (reg_read(PIN_EVENTS(VARIANT_FAULT_GPIO)) & PIN_EVENT_FELL(VARIANT_FAULT_GPIO)) != 0u ||
           (reg_read(GPIO_IN) & FAULT) == 0u ||
           reg_read(PIN_CTRL(VARIANT_ENABLE_GPIO)) != PIN_SIO || chip_clock_lost();
}

LODE_RAMFUNC void chip_gates_on(void) {
    if (!chip_tripped()) {
        reg_write(GPIO_OUT_SET, ENABLE);
    }
}

void chip_driver_reset(void) {
    chip_gates_off();
    reg_write(GPIO_OUT_CLR, RESET);
    chip_wait_us(RESET_us);
    reg_write(GPIO_OUT_SET, RESET);
    chip_wait_us(WAKE_us);
    reg_write(PIN_CTRL(VARIANT_ENABLE_GPIO), PIN_SIO);
    reg_write(PIN_EVENTS(VARIANT_FAULT_GPIO), PIN_EVENT_FELL(VARIANT_FAULT_GPIO));
    chip_clock_forget();
}
