/// From torque to current references. Now: id* = 0 with a demagnetising bias at low speed; MTPA and
/// field weakening take their place here.
#ifndef LODESTAR_REFERENCES_H
#define LODESTAR_REFERENCES_H

#include "lodestar/inverter.h"
#include "lodestar/ramp.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float id_bias_A; ///< magnitude of the negative id at low speed, which keeps the phase currents
                     ///< away from the dead band of the inverter; 0: 0.25 i_max; LODE_NONE: none
    float omega_low_rad_s;  ///< electrical speed up to which it is full; 0: 0.2 of rated
    float omega_high_rad_s; ///< from which it is gone; 0: 0.4 of rated
} lode_references_config_t;

typedef struct {
    lode_fade_t fade;
    float id_bias_A;
    float i_max_A;
    float psi_Wb;
    float salient_H;     ///< Ld - Lq
    float torque_factor; ///< 1.5 np
} lode_references_tuning_t;

void lode_references_design(lode_references_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor);

lode_status_t lode_references_tune(lode_references_tuning_t *tuning,
                                   const lode_references_config_t *config,
                                   const lode_inverter_config_t *inverter,
                                   const lode_motor_t *motor);

/// Current references for `torque_Nm` at the electrical speed `omega_rad_s`; `id_add_A` is added to
/// the d axis (the rest of the start current while it fades). Stays within the circle i_max, d first.
lode_dq_t lode_references_step(const lode_references_tuning_t *tuning, float torque_Nm,
                               float omega_rad_s, float id_add_A);

/// Torque that `iq_A` makes with `id_A`, Nm: the inverse of the step without its limits.
float lode_references_torque_Nm(const lode_references_tuning_t *tuning, lode_dq_t i_A);

#ifdef __cplusplus
}
#endif

#endif
