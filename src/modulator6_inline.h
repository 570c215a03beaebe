// Voltages of two sets to duties.
#ifndef LODE_MODULATOR6_INLINE_H
#define LODE_MODULATOR6_INLINE_H

#include "lodestar/modulator6.h"
#include "modulator_inline.h"

// Duties for the voltages `v` of the two sets, per bus volt and in stator axes, to act while both carry the
// current `i_A`. Each set is linear up to 1/sqrt(3).
LODE_INLINE lode_modulator6_out_t lode_modulator6_step(const lode_inverter_tuning_t *inverter,
                                                       const lode_dead_time_t *dead_time,
                                                       lode_sets_t v, lode_ab_t i_A, bool free) {
    const lode_modulator_out_t set_1 =
        lode_modulator_step(inverter, dead_time, v.set[0], i_A, free);
    const lode_modulator_phases_t set_2 =
        lode_modulator_set(inverter, dead_time, lode_set2_clarke_inverse(v.set[1]),
                           lode_set2_clarke_inverse(i_A), free);
    const lode_ab_t seen_2 = set_2.as_commanded ? v.set[1] : lode_set2_clarke(set_2.seen);
    return (lode_modulator6_out_t){{{set_1.duty, set_2.duty}}, {{set_1.realised, seen_2}}};
}

#endif
