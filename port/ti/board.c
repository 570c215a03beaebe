/// The functions of board.h that are the same on every chip with TI's ePWM: gates, one period, trips.
#include "board.h"

#include "chip.h"

#include "calls.h"
#include "figures.h"
#include "temperature.h"

#define WAKE_us 1000u       // wake-up time of a gate driver after its enable
#define DRIVER_RESET_us 20u // clears its fault latch: enable low for 8 .. 40 us (DRV8320)
#define TRIP_LATCH_us 2u    // twice the delay of a comparator's filter and the crossbar

// A cycle counter may stop while a debugger halts the core, so the stamp may not show the gap. The overrun
// flags of the ADCs show it.
static bool missed_periods;

// Thresholds of the comparators in counts of their DACs, for a current of either sign.
static uint16_t threshold_high;
static uint16_t threshold_low;

static bool low_sides_alone; // present setting of the ePWM
static port_ran_t ran;       // direction of the first counter in the previous call

void ti_init(void) {
    port_temperature_init();
    low_sides_alone = false;
    ran = PORT_RAN_UNKNOWN;
}

LODE_RAMFUNC void ti_period(void) {
    missed_periods = !chip_adc_acknowledge();
    app_period();
}

LODE_RAMFUNC void board_gates_off(void) {
    chip_pwm_off();
}

LODE_RAMFUNC void board_read(lode_counts_t *counts) {
    *counts = (lode_counts_t){
        .i = {chip_current(0u), chip_current(1u), chip_current(2u)},
        .v_bus = chip_bus(),
        .temperature = port_temperature(chip_temperature()),
        .trip = port_is_wrong_half(&ran, chip_pwm_counts_down()) || chip_pwm_tripped() ||
                missed_periods || !chip_pwm_holds(),
        .stamp = board_cycles(),
    };
}

LODE_RAMFUNC void board_write(const lode_drive_out_t *out) {
    const bool low = out->gates == LODE_GATES_LOW;
    const bool on = out->gates == LODE_GATES_ON || low;
    if (!on || low != low_sides_alone) {
        board_gates_off();
    }
    if (low != low_sides_alone) {
        chip_pwm_low_sides_alone(low);
        low_sides_alone = low;
    }
    chip_pwm_write(out->duty);
    if (on) {
        chip_pwm_on();
    }
}

void ti_set_trip(float i_trip_A) {
    const float trip_A = port_trip_A(i_trip_A, VARIANT_TRIP_MIN_A, VARIANT_TRIP_MAX_A);
    const float span = trip_A / lode_abs(VARIANT_I_GAIN_A_count);
    threshold_high = ti_threshold((VARIANT_I_OFFSET_count + span) * CHIP_DAC_PER_COUNT);
    threshold_low = ti_threshold((VARIANT_I_OFFSET_count - span) * CHIP_DAC_PER_COUNT);
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        chip_comparator_set(n, threshold_high, threshold_low);
    }
}

// Moves the threshold of one comparator across the zero-current signal and back.
static bool trips(uint32_t phase, uint16_t high, uint16_t low) {
    chip_comparator_set(phase, high, low);
    chip_wait_us(TRIP_LATCH_us);
    const bool tripped = chip_pwm_tripped();
    chip_comparator_set(phase, threshold_high, threshold_low);
    chip_wait_us(TRIP_LATCH_us);
    chip_pwm_clear_trip();
    chip_wait_us(TRIP_LATCH_us);
    return tripped && !chip_pwm_tripped();
}

bool board_test_trip(void) {
    board_gates_off();
    bool ok = true;
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        ok = trips(n, 0u, threshold_low) && ok;
        ok = trips(n, threshold_high, TI_DAC_MAX) && ok;
    }
    return ok;
}

void ti_driver_enable(void) {
    chip_driver_set(true);
    chip_wait_us(WAKE_us);
}

// The driver may also latch its faults until its enable has been low.
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
