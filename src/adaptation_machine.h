// The part of the adaptation that does not depend on the number of phases.
#ifndef LODE_ADAPTATION_MACHINE_H
#define LODE_ADAPTATION_MACHINE_H

#include "lodestar/adaptation.h"

// As lode_adaptation_init(), which has checked that there are a configuration and a tuning.
lode_status_t lode_adaptation_machine_init(lode_adaptation_machine_t *self,
                                           const lode_adaptation_config_t *config,
                                           const lode_drive_tuning_t *tuning,
                                           const lode_motor_t *motor,
                                           const lode_adaptation_found_t *stored);

// Evaluates the drive's present state. `taken`: the drive has taken every posted tuning. True: a new one is to be posted.
bool lode_adaptation_machine_step(lode_adaptation_machine_t *self, const lode_drive_t *drive,
                                  bool taken);

// Writes the values in use into a copy of the base.
void lode_adaptation_machine_use(const lode_adaptation_machine_t *self, lode_drive_tuning_t *t);

// `tuning` is posted: the drive will run on it.
void lode_adaptation_machine_posts(lode_adaptation_machine_t *self,
                                   const lode_drive_tuning_t *tuning);

lode_adaptation_found_t lode_adaptation_machine_found(const lode_adaptation_machine_t *self);

void lode_adaptation_machine_telemetry(const lode_adaptation_machine_t *self,
                                       lode_telemetry_t *telemetry);

#endif
