#include "lodestar/adaptation6.h"
#include "adaptation_machine.h"

#include <stddef.h>

lode_status_t lode_adaptation6_init(lode_adaptation6_t *self,
                                    const lode_adaptation_config_t *config,
                                    const lode_drive6_tuning_t *tuning, const lode_motor_t *motor,
                                    const lode_adaptation_found_t *stored) {
    if (self == NULL || config == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    const lode_status_t status =
        lode_adaptation_machine_init(&self->machine, config, &tuning->drive, motor, stored);
    if (status == LODE_OK) {
        self->base = tuning;
    }
    return status;
}

// Copies the base, with all values in use, to the one of the two tunings that was not posted last. R, psi and J also hold for
// one set alone (O9).
static void post(lode_adaptation6_t *self, lode_drive6_t *drive) {
    lode_drive6_tuning_t *next =
        &self->tuning[self->machine.posted == &self->tuning[0].drive ? 1 : 0];
    *next = *self->base;
    lode_adaptation_machine_use(&self->machine, &next->drive);
    lode_adaptation_machine_use(&self->machine, &next->alone);
    lode_adaptation_machine_posts(&self->machine, &next->drive);
    (void)lode_drive6_post_tuning(drive, next);
}

bool lode_adaptation6_step(lode_adaptation6_t *self, lode_drive6_t *drive) {
    const bool due = lode_adaptation_machine_step(&self->machine, &drive->drive,
                                                  lode_drive6_tuning_taken(drive));
    if (due) {
        post(self, drive);
    }
    return due;
}

bool lode_adaptation6_post(lode_adaptation6_t *self, lode_drive6_t *drive,
                           const lode_drive6_tuning_t *tuning) {
    if (!lode_drive6_tuning_taken(drive)) {
        return false; // the drive may still run on the one that would be written
    }
    self->base = tuning;
    self->machine.base = &tuning->drive;
    post(self, drive);
    return true;
}

lode_adaptation_found_t lode_adaptation6_found(const lode_adaptation6_t *self) {
    return lode_adaptation_machine_found(&self->machine);
}

void lode_adaptation6_telemetry(const lode_adaptation6_t *self, lode_telemetry_t *telemetry) {
    lode_adaptation_machine_telemetry(&self->machine, telemetry);
}
