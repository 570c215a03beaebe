// The part of commissioning that does not depend on the number of phases.
#ifndef LODE_COMMISSION_MACHINE_H
#define LODE_COMMISSION_MACHINE_H

#include "lodestar/commission.h"
#include "lodestar/vsd.h"

#ifndef LODE_WITHOUT_COMMISSIONING

// Inputs of a period: counts and currents at its beginning, voltages as means over the period before.
typedef struct {
    const lode_counts_t *set[LODE_SETS]; // three phases: the first one only
    lode_ab_t u_V;                       // of the machine, stator axes
    lode_ab_t u_xy_V;
    lode_ab_t i_xy_A;
} lode_commission_period_t;

// `given`: what is known. `designed`: the same, completed, for the drive of lode_commission_blind().
void lode_commission_begin(lode_commission_t *self, lode_drive_t *drive,
                           const lode_drive_config_t *given, const lode_drive_config_t *designed);

// Sets the push of the xy control, by its gain and the largest voltage of the plane.
void lode_commission_push_by(lode_commission_t *self, float kp_Ohm, float most_V);

// The configuration without dead-time correction: the loss of the inverter is to be measured.
lode_drive_config_t lode_commission_blind(const lode_drive_config_t *given);

// After the drive's own step.
void lode_commission_follow(lode_commission_t *self, const lode_commission_period_t *period);

// Writes what was found at standstill into `config`.
void lode_commission_take_standstill(lode_commission_t *self);

// `config` for the run, after `designed` has been made again.
lode_drive_config_t lode_commission_for_run(lode_commission_t *self);

// The tuning for the run was posted, or refused.
void lode_commission_go_on(lode_commission_t *self, lode_status_t status);

#endif

#endif
