// Modulator: any accepted inverter, any voltage, bus and current give duties in range on the grid.
#include "modulator_inline.h"
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
    const float i_most = lode_clamp(fuzz_number(&in, 100.0f), 12.0f, 1.3e9f);
    if (lode_inverter_tune(&tuning, &config, 2.0e-4f) != LODE_OK) {
        return 0;
    }
    lode_inverter_bound_current(&tuning, i_most);
    lode_inverter_t inverter;
    lode_inverter_reset(&inverter);
    while (fuzz_more(&in)) {
        const lode_ab_t u = {fuzz_number(&in, 300.0f), fuzz_number(&in, 300.0f)};
        // The bus too: never below 0.
        const float bus = lode_clamp(fuzz_number(&in, 400.0f), 0.0f, 6.6e8f);
        // Currents come from counts: finite. Beyond the trip the gates are off.
        const lode_ab_t i = {lode_clamp(fuzz_number(&in, 30.0f), -0.5f * i_most, 0.5f * i_most),
                             lode_clamp(fuzz_number(&in, 30.0f), -0.5f * i_most, 0.5f * i_most)};
        lode_inverter_follow_bus(&inverter, &tuning, bus);
        if ((fuzz_byte(&in) & 1u) != 0u) { // the dead-time error follows now and then
            const lode_dq_t then_V = {fuzz_number(&in, 300.0f), fuzz_number(&in, 300.0f)};
            lode_inverter_adapt(&inverter, &tuning, then_V);
        }
        const float radius = tuning.free * bus; // as current control has it
        const bool free = u.alpha * u.alpha + u.beta * u.beta <= radius * lode_abs(radius);
        const lode_modulator_out_t out = lode_modulator_step(
            &tuning, &inverter.dead_time, lode_ab_scale(inverter.per_V, u), i, free);
        check_duty(&tuning, out.duty.a);
        check_duty(&tuning, out.duty.b);
        check_duty(&tuning, out.duty.c);
        FUZZ_CHECK(lode_ab_in_range(out.realised, FLT_MAX));
    }
    return 0;
}
