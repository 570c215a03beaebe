/// A board that does nothing: copy this folder and fill in each function. It compiles, and its gates stay
/// off. board.h has the contract of each function.
#include "board.h"

/// f_pwm, bus voltage and largest current, dead time, drops, timer steps; gains, offset and range of the
/// sensors; guard.stamp_per_period = cycles of board_cycles() per call. With a timer that calls at both turning
/// points, f_pwm is the rate of the calls, and inverter.double_update is on.
void board_describe(lode_drive_config_t *config) {
    config->f_pwm_Hz = 20.0e3f;
    config->inverter = (lode_inverter_config_t){.v_bus_V = 24.0f, .i_max_A = 10.0f};
    config->sense = (lode_sense_config_t){.i_gain_A_count = 1.0f / 128.0f,
                                          .i_offset_count = 2048.0f,
                                          .v_bus_gain_V_count = 40.0f / 4096.0f};
}

/// The reset controller's flags, then clear them.
bool board_reset_by_watchdog(void) {
    return false;
}

/// Clocks; timer centre-aligned, compare preloaded, dead time, break input; ADC on the timer's
/// trigger; serial port as early as possible. Gate pins last. False if any of these is missing.
bool board_init(float i_trip_A) {
    (void)i_trip_A;
    return false;
}

/// Watchdog; then arm the ADC, enable the interrupt, start the timer: in this order.
void board_start(void) {}

/// Read the result registers; trip = the timer's break flag, or compare registers that do not hold what was
/// written last; stamp = board_cycles().
void board_read(lode_counts_t *counts) {
    *counts = (lode_counts_t){.stamp = board_cycles()};
}

/// With gates off: board_gates_off() first. Then duties to the preload registers. With gates on, and no
/// trip latched: outputs on, within a period. LODE_GATES_LOW: the low sides alone; a board that cannot do this
/// keeps all off, and sets start.pulses off.
void board_write(const lode_drive_out_t *out) {
    if (out->gates != LODE_GATES_ON) {
        board_gates_off();
    }
}

/// One write to the timer's master output enable.
void board_gates_off(void) {}

/// Clear the break flag; false if it is set again.
bool board_clear_trip(void) {
    return false;
}

/// Move each comparator's threshold across the zero-current signal; false if the break flag is not set. True if
/// the trip comes from a driver's fault pin.
bool board_test_trip(void) {
    return false;
}

/// One write to the watchdog.
void board_feed_watchdog(void) {}

/// The core's cycle counter.
uint32_t board_cycles(void) {
    return 0u;
}

/// Put octets into the transmitter's register or ring while there is room.
uint32_t board_send(const uint16_t *octets, uint32_t count) {
    (void)octets;
    (void)count;
    return 0u;
}

/// Your handler of the end of conversion: clear its flag, then app_period().
void end_of_conversion_handler(void);
void end_of_conversion_handler(void) {
    app_period();
}
