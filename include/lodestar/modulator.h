/// Space-vector modulation by the min-max zero sequence, with dead-time correction in the duties.
#ifndef LODESTAR_MODULATOR_H
#define LODESTAR_MODULATOR_H

#include "lodestar/inverter.h"

typedef struct {
    lode_abc_t duty;    ///< on-time of the high sides as a share of the period, in [0, 1]
    lode_ab_t realised; ///< voltage per bus volt that the motor is expected to see of it
} lode_modulator_out_t;

/// Duties for the voltage `u_V` at a bus of `v_bus_V`, to act while the currents are `i_acting_A`.
/// Linear up to v_bus/sqrt(3); beyond, and where the correction reaches past the rails, the duties
/// are clamped and `realised` says what is left. Duties lie on the timer's grid.
lode_modulator_out_t lode_modulator_step(const lode_inverter_tuning_t *inverter, lode_ab_t u_V,
                                         float v_bus_V, lode_ab_t i_acting_A);

#endif
