#include "modulator_inline.h"

static float limited(const lode_inverter_tuning_t *inverter, float duty) {
    const float inside = lode_clamp(duty, 0.0f, 1.0f);
    return inverter->grid != 0u ? lode_modulator_on_grid(inverter, inside) : inside;
}

LODE_RAMFUNC LODE_NOINLINE lode_modulator_phases_t
lode_modulator_limit(const lode_inverter_tuning_t *inverter, const lode_dead_time_t *dead_time,
                     const lode_modulator_case_t *at) {
    lode_abc_t duty = lode_modulator_duties(at->v);
    const lode_abc_t error = lode_modulator_errors(dead_time, at->i_A);
    if (inverter->correct != 0u) {
        duty = (lode_abc_t){duty.a + error.a, duty.b + error.b, duty.c + error.c};
    }
    const lode_abc_t made = {limited(inverter, duty.a), limited(inverter, duty.b),
                             limited(inverter, duty.c)};
    return (lode_modulator_phases_t){
        made, {made.a - error.a, made.b - error.b, made.c - error.c}, false};
}
