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

/// Part of lode_modulator6_step(): that of set 2, in whose own axes the limit is.
LODE_INLINE lode_modulator_out_t lode_modulator_set2(const lode_inverter_tuning_t *inverter,
                                                     lode_loss_t shape, lode_ab_t v,
                                                     lode_ab_t i_acting_A) {
    const lode_abc_t loss =
        lode_modulator_loss(inverter, shape, lode_set2_clarke_inverse(i_acting_A));
    const lode_abc_t duty = lode_modulator_duties(inverter, lode_set2_clarke_inverse(v), loss);
    if (lode_modulator_is_free(inverter, v)) {
        return (lode_modulator_out_t){duty, v};
    }
    const lode_modulator_out_t limited = lode_modulator_limit(inverter, duty, loss);
    return (lode_modulator_out_t){limited.duty, lode_set2_to_stator(limited.realised)};
}

/// Duties for the voltages of the two sets, `u_V` in stator axes, at a bus of `v_bus_V`, to act while the
/// currents of the sets are `i_acting_A`. Each set is linear up to v_bus/sqrt(3).
LODE_INLINE lode_modulator6_out_t lode_modulator6_step(const lode_inverter_tuning_t *inverter,
                                                       lode_loss_t shape, lode_sets_t u_V,
                                                       float v_bus_V, lode_sets_t i_acting_A) {
    const float per_bus = lode_modulator_per_bus(inverter, v_bus_V);
    const lode_modulator_out_t set_1 =
        lode_modulator_set1(inverter, shape, lode_ab_scale(per_bus, u_V.set[0]), i_acting_A.set[0]);
    const lode_modulator_out_t set_2 =
        lode_modulator_set2(inverter, shape, lode_ab_scale(per_bus, u_V.set[1]), i_acting_A.set[1]);
    return (lode_modulator6_out_t){{{set_1.duty, set_2.duty}}, {{set_1.realised, set_2.realised}}};
}

#ifdef __cplusplus
}
#endif

#endif
