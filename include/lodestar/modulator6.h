/// Space-vector modulation of two three-phase sets, with dead-time correction in all six legs.
#ifndef LODESTAR_MODULATOR6_H
#define LODESTAR_MODULATOR6_H

#include "lodestar/modulator.h"
#include "lodestar/vsd.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lode_abc6_t duty;     ///< on-time of the high sides as a share of the period, in [0, 1]
    lode_sets_t realised; ///< voltage per bus volt that each set is expected to see, stator axes
} lode_modulator6_out_t;

/// Part of lode_modulator6_step(): that of set 2.
LODE_INLINE lode_modulator_out_t lode_modulator_set2(const lode_inverter_tuning_t *inverter,
                                                     lode_loss_t shape, lode_ab_t v,
                                                     lode_ab_t i_acting_A) {
    const lode_modulator_phases_t out = lode_modulator_set(
        inverter, shape, lode_set2_clarke_inverse(v), v.alpha * v.alpha + v.beta * v.beta,
        lode_set2_clarke_inverse(i_acting_A));
    return (lode_modulator_out_t){out.duty, out.as_asked ? v : lode_set2_clarke(out.seen)};
}

/// Duties for the voltages `v` of the two sets, per bus volt and in stator axes, to act while the currents
/// of the sets are `i_acting_A`. Each set is linear up to 1/sqrt(3).
LODE_INLINE lode_modulator6_out_t lode_modulator6_sets(const lode_inverter_tuning_t *inverter,
                                                       lode_loss_t shape, lode_sets_t v,
                                                       lode_sets_t i_acting_A) {
    const lode_modulator_out_t set_1 =
        lode_modulator_set1(inverter, shape, v.set[0], i_acting_A.set[0]);
    const lode_modulator_out_t set_2 =
        lode_modulator_set2(inverter, shape, v.set[1], i_acting_A.set[1]);
    return (lode_modulator6_out_t){{{set_1.duty, set_2.duty}}, {{set_1.realised, set_2.realised}}};
}

/// The same for the voltages `u_V` at a bus of `v_bus_V`.
LODE_INLINE lode_modulator6_out_t lode_modulator6_step(const lode_inverter_tuning_t *inverter,
                                                       lode_loss_t shape, lode_sets_t u_V,
                                                       float v_bus_V, lode_sets_t i_acting_A) {
    const float per_bus = lode_modulator_per_bus(inverter, v_bus_V);
    const lode_sets_t v = {
        {lode_ab_scale(per_bus, u_V.set[0]), lode_ab_scale(per_bus, u_V.set[1])}};
    return lode_modulator6_sets(inverter, shape, v, i_acting_A);
}

#ifdef __cplusplus
}
#endif

#endif
