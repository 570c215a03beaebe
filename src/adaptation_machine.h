// What of adaptation.h does not depend on the number of phases: what is seen, and what becomes of it.
#ifndef LODE_ADAPTATION_MACHINE_H
#define LODE_ADAPTATION_MACHINE_H

#include "lodestar/adaptation.h"

// As lode_adaptation_init(), which has seen that there are a configuration and a tuning.
lode_status_t lode_adaptation_machine_init(lode_adaptation_machine_t *self,
                                           const lode_adaptation_config_t *config,
                                           const lode_drive_tuning_t *tuning,
                                           const lode_motor_t *motor,
                                           const lode_adaptation_found_t *stored);

// Looks at the drive. `taken`: nothing is posted that it has not taken. True: there is something to post.
bool lode_adaptation_machine_look(lode_adaptation_machine_t *self, const lode_drive_t *drive,
                                  bool taken);

// What is in use, into a copy of a tuning that knows nothing of it.
void lode_adaptation_machine_use(const lode_adaptation_machine_t *self, lode_drive_tuning_t *t);

// The drive will run on this.
void lode_adaptation_machine_posts(lode_adaptation_machine_t *self,
                                   const lode_drive_tuning_t *tuning);

lode_adaptation_found_t lode_adaptation_machine_found(const lode_adaptation_machine_t *self);

void lode_adaptation_machine_tell(const lode_adaptation_machine_t *self,
                                  lode_telemetry_t *telemetry);

#endif
