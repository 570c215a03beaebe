// Modulator: any accepted inverter, any voltage, bus and current give duties in range on the grid.
#include "lodestar/modulator.h"
#include "support/fuzz.h"

static void check_duty(const lode_inverter_tuning_t *tuning, float duty) {
    FUZZ_CHECK(lode_in_range(duty, 0.0f, 1.0f));
    if (tuning->ticks > 0.0f) {
        const float ticks = duty * tuning->ticks;
        FUZZ_CHECK(fabsf(ticks - roundf(ticks)) < 0.02f);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    const lode_motor_t motor = fuzz_motor();
    lode_inverter_config_t config = {.v_bus_V = 200.0f,
                                     .i_max_A = 12.0f,
                                     .dead_time_s = fuzz_number(&in, 1.0e-5f),
                                     .v_drop_V = fuzz_number(&in, 3.0f),
                                     .r_on_Ohm = fuzz_number(&in, 0.5f),
                                     .i_dead_A = fuzz_number(&in, 2.0f),
                                     .pwm_ticks = fuzz_number(&in, 65535.0f),
                                     .dead_time_correction = (lode_choice_t)(fuzz_byte(&in) % 3u),
                                     .dead_time_model = (lode_choice_t)(fuzz_byte(&in) % 3u)};
    lode_inverter_tuning_t tuning;
    lode_inverter_design(&config, &motor, 2.0e-4f);
    if (lode_inverter_tune(&tuning, &config, 2.0e-4f) != LODE_OK) {
        return 0;
    }
    lode_inverter_t inverter;
    lode_inverter_reset(&inverter);
    while (fuzz_more(&in)) {
        const lode_ab_t u = {fuzz_number(&in, 300.0f), fuzz_number(&in, 300.0f)};
        const float bus = fuzz_number(&in, 400.0f);
        // Currents come from counts: finite, and never beyond 65535 of 1e4 A, twice.
        const lode_ab_t i = {lode_clamp(fuzz_number(&in, 30.0f), -1.3e9f, 1.3e9f),
                             lode_clamp(fuzz_number(&in, 30.0f), -1.3e9f, 1.3e9f)};
        if ((fuzz_byte(&in) & 1u) != 0u) { // the loss is shaped now and then, for what was then
            const lode_dq_t shaped_V = {fuzz_number(&in, 300.0f), fuzz_number(&in, 300.0f)};
            lode_inverter_adapt(&inverter, &tuning, shaped_V, fuzz_number(&in, 400.0f));
        }
        const lode_modulator_out_t out = lode_modulator_step(&tuning, inverter.loss, u, bus, i);
        check_duty(&tuning, out.duty.a);
        check_duty(&tuning, out.duty.b);
        check_duty(&tuning, out.duty.c);
        FUZZ_CHECK(lode_ab_in_range(out.realised, FLT_MAX));
    }
    return 0;
}
