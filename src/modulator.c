#include "lodestar/modulator.h"

// Beyond any motor current: keeps NaN and Inf out of the realised voltage.
#define CURRENT_LIMIT_A 1.0e6f

static float on_grid(const lode_inverter_tuning_t *inverter, float duty) {
    // duty is in [0, 1] and ticks at most 65535: the cast is defined.
    return inverter->ticks > 0.0f
               ? (float)(int32_t)(duty * inverter->ticks + 0.5f) * inverter->inv_ticks
               : duty;
}

LODE_HOT lode_modulator_out_t lode_modulator_step(const lode_inverter_tuning_t *inverter,
                                                  lode_ab_t u_V, float v_bus_V,
                                                  lode_ab_t i_acting_A) {
    const float inv_v_bus = 1.0f / lode_max(v_bus_V, inverter->v_min_V);
    const lode_abc_t v = lode_clarke_inverse(lode_ab_scale(inv_v_bus, u_V));
    // The common mode that centres the three (B9): min-max, equal to space-vector modulation.
    const float high = lode_max(lode_max(v.a, v.b), v.c);
    const float low = lode_min(lode_min(v.a, v.b), v.c);
    lode_abc_t loss = {0.0f, 0.0f, 0.0f};
    if ((inverter->correct || inverter->model) && lode_ab_in_range(i_acting_A, CURRENT_LIMIT_A)) {
        const float span = lode_clamp(high - low, 0.0f, 1.0f);
        loss = lode_inverter_loss(inverter, lode_clarke_inverse(i_acting_A), span, inv_v_bus);
    }
    const float added = inverter->correct ? 1.0f : 0.0f;
    const float centre = 0.5f - 0.5f * (high + low);
    const lode_abc_t duty = {
        on_grid(inverter, lode_clamp(v.a + centre + added * loss.a, 0.0f, 1.0f)),
        on_grid(inverter, lode_clamp(v.b + centre + added * loss.b, 0.0f, 1.0f)),
        on_grid(inverter, lode_clamp(v.c + centre + added * loss.c, 0.0f, 1.0f))};
    const lode_abc_t seen = {duty.a - loss.a, duty.b - loss.b, duty.c - loss.c};
    return (lode_modulator_out_t){duty, lode_clarke(seen)};
}
