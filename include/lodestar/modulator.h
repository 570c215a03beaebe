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

/// What becomes of the phases of one set.
typedef struct {
    lode_abc_t duty;
    lode_abc_t seen; ///< by the motor, where the voltage is not `as_asked`
    bool as_asked;
} lode_modulator_phases_t;

/// Parts of lode_modulator_step() and lode_modulator6_step(), which alone call them. Duties that may be at
/// a rail, lie on the timer's grid, or lose `loss` of what they say.
lode_modulator_phases_t lode_modulator_limit(const lode_inverter_tuning_t *inverter,
                                             lode_abc_t duty, lode_abc_t loss);

/// Loss of duty in the phases at the currents `i_A`.
LODE_INLINE lode_abc_t lode_modulator_loss(lode_loss_t shape, lode_abc_t i_A) {
    return (lode_abc_t){lode_inverter_loss(shape, i_A.a), lode_inverter_loss(shape, i_A.b),
                        lode_inverter_loss(shape, i_A.c)};
}

/// Duties for the phase voltages `v`, per bus volt, that sum to zero.
LODE_INLINE lode_abc_t lode_modulator_duties(lode_abc_t v) {
    // The common mode that centres the three (B9), half of the middle one, equals space-vector
    // modulation. They sum to zero, so the middle one is the smallest by magnitude.
    const float ab = lode_abs(v.a) < lode_abs(v.b) ? v.a : v.b;
    const float middle = lode_abs(v.c) < lode_abs(ab) ? v.c : ab;
    const float centre = 0.5f + 0.5f * middle;
    return (lode_abc_t){v.a + centre, v.b + centre, v.c + centre};
}

/// The whole of one set, whose phase voltages are `v_abc`; `v2`: square of their vector's length.
LODE_INLINE lode_modulator_phases_t lode_modulator_set(const lode_inverter_tuning_t *inverter,
                                                       lode_loss_t shape, lode_abc_t v_abc,
                                                       float v2, lode_abc_t i_acting_A) {
    lode_abc_t duty = lode_modulator_duties(v_abc);
    lode_abc_t loss = {0.0f, 0.0f, 0.0f};
    if (inverter->correct) {
        loss = lode_modulator_loss(shape, i_acting_A);
        duty = (lode_abc_t){duty.a + loss.a, duty.b + loss.b, duty.c + loss.c};
    }
    if (LODE_USUALLY(v2 <= inverter->v2_free)) {
        return (lode_modulator_phases_t){duty, duty, true};
    }
    if (inverter->model) {
        loss = lode_modulator_loss(shape, i_acting_A);
    }
    return lode_modulator_limit(inverter, duty, loss);
}

/// That of set 1, or of the only one.
LODE_INLINE lode_modulator_out_t lode_modulator_set1(const lode_inverter_tuning_t *inverter,
                                                     lode_loss_t shape, lode_ab_t v,
                                                     lode_ab_t i_acting_A) {
    const lode_modulator_phases_t out =
        lode_modulator_set(inverter, shape, lode_clarke_inverse(v),
                           v.alpha * v.alpha + v.beta * v.beta, lode_clarke_inverse(i_acting_A));
    return (lode_modulator_out_t){out.duty, out.as_asked ? v : lode_clarke(out.seen)};
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
