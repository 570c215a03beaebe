#include "lodestar/restart.h"

void lode_restart_begin(lode_restart_t *self, uint_least8_t count) {
    *self = (lode_restart_t){.count = count, .time_s = 0.0f};
}

// In FAULT: whether the wait for an attempt is over.
static bool is_time(lode_restart_t *self, const lode_restart_config_t *config, lode_fault_t fault,
                    float dt_s) {
    const bool may = (config->again & LODE_RESTART_AFTER(fault.check)) != 0u;
    if (!may || self->count >= config->attempts) {
        return false;
    }
    self->time_s += dt_s;
    return self->time_s >= config->wait_s;
}

lode_command_t lode_restart_step(lode_restart_t *self, const lode_restart_config_t *config,
                                 const lode_telemetry_t *telemetry, lode_command_t wanted,
                                 float dt_s) {
    if (wanted.mode == LODE_MODE_OFF) {
        self->count = wanted.clear_fault ? (uint_least8_t)0u : self->count;
        self->time_s = 0.0f;
        return wanted;
    }
    if (telemetry->mode == LODE_MODE_FAULT) {
        const bool now = is_time(self, config, telemetry->fault, dt_s);
        if (now) {
            self->count = (uint_least8_t)(self->count + 1u);
            self->time_s = 0.0f;
        }
        return (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = now};
    }
    self->time_s = telemetry->mode == LODE_MODE_RUN ? self->time_s + dt_s : 0.0f;
    if (self->time_s >= config->good_s) {
        self->count = 0u;
        self->time_s = config->good_s;
    }
    return wanted;
}
