#include "lodestar/modulator.h"

static float on_grid(const lode_inverter_tuning_t *inverter, float duty) {
    const float inside = lode_clamp(duty, 0.0f, 1.0f);
    // `inside` is in [0, 1] and ticks at most 65535: the cast is defined.
    return inverter->ticks > 0.0f
               ? (float)(int32_t)(inside * inverter->ticks + 0.5f) * inverter->inv_ticks
               : inside;
}

LODE_RAMFUNC lode_modulator_phases_t lode_modulator_limit(const lode_inverter_tuning_t *inverter,
                                                      lode_abc_t duty, lode_abc_t loss) {
    const lode_abc_t made = {on_grid(inverter, duty.a), on_grid(inverter, duty.b),
                             on_grid(inverter, duty.c)};
    return (lode_modulator_phases_t){
        made, {made.a - loss.a, made.b - loss.b, made.c - loss.c}, false};
}
