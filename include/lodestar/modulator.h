/// Space-vector modulation by the min-max zero sequence, with dead-time correction in the duties.
#ifndef LODESTAR_MODULATOR_H
#define LODESTAR_MODULATOR_H

#include "lodestar/inverter.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lode_abc_t duty;    ///< on-time of the high sides as a share of the period, in [0, 1]
    lode_ab_t realised; ///< voltage per bus volt that the motor is expected to see of it
} lode_modulator_out_t;

/// Part of lode_modulator_step(), which alone calls it: duties at a rail, on the timer's grid, or with
/// a loss to be reckoned with.
lode_modulator_out_t lode_modulator_limit(const lode_inverter_tuning_t *inverter, lode_abc_t duty,
                                          lode_abc_t loss);

/// Parts of lode_modulator_step() and lode_modulator6_step(), which alone call them. Loss of duty in
/// the phases at the currents `i_A`, where something is made of it.
LODE_INLINE lode_abc_t lode_modulator_loss(const lode_inverter_tuning_t *inverter,
                                           lode_loss_t shape, lode_abc_t i_A) {
    lode_abc_t loss = {0.0f, 0.0f, 0.0f};
    if (inverter->correct || inverter->model) {
        loss = (lode_abc_t){lode_inverter_loss(shape, i_A.a), lode_inverter_loss(shape, i_A.b),
                            lode_inverter_loss(shape, i_A.c)};
    }
    return loss;
}

/// Duties for the phase voltages `v`, per bus volt, that sum to zero.
LODE_INLINE lode_abc_t lode_modulator_duties(const lode_inverter_tuning_t *inverter, lode_abc_t v,
                                             lode_abc_t loss) {
    // The common mode that centres the three (B9), half of the middle one, equals space-vector
    // modulation. They sum to zero, so the middle one is the smallest by magnitude.
    const float ab = lode_abs(v.a) < lode_abs(v.b) ? v.a : v.b;
    const float middle = lode_abs(v.c) < lode_abs(ab) ? v.c : ab;
    const float centre = 0.5f + 0.5f * middle;
    lode_abc_t duty = {v.a + centre, v.b + centre, v.c + centre};
    if (inverter->correct) {
        duty = (lode_abc_t){duty.a + loss.a, duty.b + loss.b, duty.c + loss.c};
    }
    return duty;
}

/// Whether those for the vector `v` need no limit, and the voltage will be what was asked.
LODE_INLINE bool lode_modulator_is_free(const lode_inverter_tuning_t *inverter, lode_ab_t v) {
    return inverter->plain && v.alpha * v.alpha + v.beta * v.beta <= inverter->v2_free;
}

/// The whole for a voltage `v` per bus volt.
LODE_INLINE lode_modulator_out_t lode_modulator_set1(const lode_inverter_tuning_t *inverter,
                                                     lode_loss_t shape, lode_ab_t v,
                                                     lode_ab_t i_acting_A) {
    const lode_abc_t loss = lode_modulator_loss(inverter, shape, lode_clarke_inverse(i_acting_A));
    const lode_abc_t duty = lode_modulator_duties(inverter, lode_clarke_inverse(v), loss);
    if (lode_modulator_is_free(inverter, v)) {
        return (lode_modulator_out_t){duty, v};
    }
    return lode_modulator_limit(inverter, duty, loss);
}

/// What a bus volt is divided by.
LODE_INLINE float lode_modulator_per_bus(const lode_inverter_tuning_t *inverter, float v_bus_V) {
    return 1.0f / lode_max(v_bus_V, inverter->v_min_V);
}

/// Duties for the voltage `u_V` at a bus of `v_bus_V`, to act while the currents are `i_acting_A`.
/// Linear up to 1/sqrt(3) of the bus; beyond, and where the correction reaches past the rails, the
/// duties are clamped and `realised` says what is left. Duties lie on the timer's grid. The currents
/// must be finite.
LODE_INLINE lode_modulator_out_t lode_modulator_step(const lode_inverter_tuning_t *inverter,
                                                     lode_loss_t shape, lode_ab_t u_V,
                                                     float v_bus_V, lode_ab_t i_acting_A) {
    const lode_ab_t v = lode_ab_scale(lode_modulator_per_bus(inverter, v_bus_V), u_V);
    return lode_modulator_set1(inverter, shape, v, i_acting_A);
}

#ifdef __cplusplus
}
#endif

#endif
