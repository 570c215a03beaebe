/// The functions of board.h that are the same on every chip with TI's ePWM: gates, one period, trips.
#include "board.h"

#include "chip.h"

#define WAKE_us 1000u       // of a gate driver, after its enable
#define DRIVER_RESET_us 20u // its fault latch: enable low for 8 .. 40 us (DRV8320)
#define TRIP_LATCH_us 2u    // a comparator's filter and the crossbar, twice over

// A cycle counter may stand still while a debugger holds the core, so the stamp may not show the gap: the
// converters do, whose results nobody has taken.
static bool missed_periods;

LODE_RAMFUNC void ti_period(void) {
    missed_periods = !chip_converters_acknowledge();
    app_period();
}

LODE_RAMFUNC void board_gates_off(void) {
    chip_pwm_off();
}

LODE_RAMFUNC void board_read(lode_counts_t *counts) {
    *counts = (lode_counts_t){
        .i = {chip_current(0u), chip_current(1u), chip_current(2u)},
        .v_bus = chip_bus(),
        .trip = chip_pwm_tripped() || chip_pwm_counts_down() || missed_periods,
        .stamp = board_cycles(),
    };
}

LODE_RAMFUNC void board_write(const lode_drive_out_t *out) {
    if (!out->gates) {
        board_gates_off();
    }
    chip_pwm_write(out->duty);
    if (out->gates) {
        chip_pwm_on();
    }
}

void ti_driver_enable(void) {
    chip_driver_set(true);
    chip_wait_us(WAKE_us);
}

// The driver may latch its faults too, until its enable has been low.
bool board_clear_trip(void) {
    if (chip_pwm_tripped()) {
        board_gates_off();
        chip_driver_set(false);
        chip_wait_us(DRIVER_RESET_us);
        ti_driver_enable();
    }
    chip_pwm_clear_trip();
    chip_wait_us(TRIP_LATCH_us);
    return !chip_pwm_tripped(); // an active source has latched it again
}
