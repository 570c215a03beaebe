#include "rig/reactions.h"

#include <math.h>

#define LOOP_s 1e-3 // period of the main loop

static float float_or_0(double x) {
    return isnan(x) ? 0.0f : (float)x;
}

lode_status_t reactions_init(reactions_t *self, const rig_config_t *config,
                             const lode_drive_t *drive) {
    const rig_supervisor_t *given = &config->supervisor;
    const double f_Hz = (double)config->drive.f_pwm_Hz;
    *self = (reactions_t){.every = (uint32_t)fmax(1.0, round(LOOP_s * f_Hz))};
    self->dt_s = (float)((double)self->every / f_Hz);
    self->config = (lode_supervisor_config_t){
        .attempts = (uint_least8_t)(isnan(given->attempts) ? 0.0 : given->attempts),
        .wait_s = float_or_0(given->wait_s),
        .good_s = float_or_0(given->good_s),
        .active_short = (lode_choice_t)given->active_short,
    };
    self->on = self->config.active_short == LODE_ON;
    for (int k = 0; k < LODE_CHECK_COUNT; ++k) {
        self->config.reaction[k] = (lode_reaction_t)given->reaction[k];
        self->on = self->on || self->config.reaction[k] != LODE_REACTION_LATCH;
    }
    (void)lode_fault_log_init(&self->log, self->rows, REACTIONS_FAULTS, 1);
    return lode_supervisor_init(&self->supervisor, &self->config, drive->tuning, &self->attempts,
                                false);
}

void reactions_step(reactions_t *self, lode_drive_t *drive, lode_command_t wanted) {
    lode_telemetry_t now;
    if (drive->steps % self->every != 0u || !lode_drive_telemetry(drive, &now)) {
        return;
    }
    (void)lode_fault_log_step(&self->log, &now);
    if (self->on) {
        const lode_command_t command =
            lode_supervisor_step(&self->supervisor, &now, wanted, self->dt_s);
        (void)lode_drive_post_command(drive, &command);
    }
}
