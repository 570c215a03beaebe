#include "lodestar/supervisor.h"

#include <stddef.h>

// With the count: neither memory of nothing but zeros or ones matches, nor what a power-up leaves, but once in 2^32.
#define KEPT_MAGIC UINT32_C(0x4C6F5375)

#define WAIT_s 1.0f // lets the cause die down, and most rotors slow down
#define WAIT_MAX_s 1.0e4f
#define GOOD_s 10.0f // longer than a start and its ramp take
#define GOOD_MAX_s 1.0e5f
#define TIME_MIN_s 1.0e-3f

static void set_count(lode_attempts_t *attempts, uint32_t count) {
    attempts->count = count;
    attempts->check = count ^ KEPT_MAGIC;
}

static uint32_t count_of(const lode_attempts_t *attempts) {
    return attempts->check == (attempts->count ^ KEPT_MAGIC) ? attempts->count : 0u;
}

static void count_one(lode_attempts_t *attempts) {
    const uint32_t count = count_of(attempts);
    set_count(attempts, count < UINT32_MAX ? count + 1u : count);
}

static bool are_reactions(const lode_supervisor_config_t *config) {
    bool good = true;
    for (uint32_t n = 0u; n < (uint32_t)LODE_CHECK_COUNT; n++) {
        const lode_reaction_t reaction = config->reaction[n];
        good = good && (reaction == LODE_REACTION_LATCH || reaction == LODE_REACTION_AGAIN ||
                        reaction == LODE_REACTION_RIDE_THROUGH);
    }
    return good;
}

lode_status_t lode_supervisor_init(lode_supervisor_t *self, const lode_supervisor_config_t *config,
                                   const lode_drive_tuning_t *tuning, lode_attempts_t *attempts,
                                   bool by_reset) {
    if (self == NULL || config == NULL || tuning == NULL || attempts == NULL) {
        return LODE_ERROR_NULL;
    }
    const float wait_s = lode_given_or(config->wait_s, WAIT_s);
    const float good_s = lode_given_or(config->good_s, GOOD_s);
    if (!are_reactions(config) || !lode_in_range(wait_s, TIME_MIN_s, WAIT_MAX_s) ||
        !lode_in_range(good_s, TIME_MIN_s, GOOD_MAX_s)) {
        return LODE_ERROR_SUPERVISOR;
    }
    *self = (lode_supervisor_t){.config = config,
                                .limits = &tuning->guard,
                                .attempts = attempts,
                                .wait_s = wait_s,
                                .good_s = good_s};
    set_count(attempts, count_of(attempts));
    if (by_reset) {
        count_one(attempts);
    }
    return LODE_OK;
}

static lode_reaction_t reaction_to(const lode_supervisor_t *self, lode_fault_t fault) {
    const uint32_t check = fault.check;
    return check < (uint32_t)LODE_CHECK_COUNT ? self->config->reaction[check] : LODE_REACTION_LATCH;
}

// The bus has recovered, and the power stage has cooled down.
static bool is_over(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    const lode_guard_tuning_t *limits = self->limits;
    return lode_in_range(telemetry->v_bus_V, limits->v_bus_min, limits->v_bus_max) &&
           lode_in_range(telemetry->temperature_degC, limits->temperature_min,
                         limits->temperature_max);
}

bool lode_supervisor_is_latched(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    const uint32_t count = count_of(self->attempts);
    const uint32_t most = self->config->attempts;
    if (telemetry->mode == LODE_MODE_FAULT) {
        return count >= most || reaction_to(self, telemetry->fault) == LODE_REACTION_LATCH;
    }
    return count > most; // resets have used them up
}

// In FAULT, with an attempt left: whether it is time for it.
static bool is_time(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    return reaction_to(self, telemetry->fault) == LODE_REACTION_RIDE_THROUGH
               ? is_over(self, telemetry)
               : self->time_s >= self->wait_s;
}

// OFF, with which the fault is cleared when it is time for an attempt.
static lode_command_t after_fault(lode_supervisor_t *self, const lode_telemetry_t *telemetry,
                                  float dt_s) {
    if (self->asked && self->asked_at == telemetry->steps) { // a loop faster than the interrupt
        return (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true};
    }
    self->time_s = self->faulted ? self->time_s + dt_s : 0.0f;
    const bool now = !lode_supervisor_is_latched(self, telemetry) && is_time(self, telemetry);
    if (now) {
        count_one(self->attempts);
    }
    self->faulted = !now;
    self->asked = now;
    self->asked_at = telemetry->steps;
    return (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = now};
}

lode_command_t lode_supervisor_step(lode_supervisor_t *self, const lode_telemetry_t *telemetry,
                                    lode_command_t wanted, float dt_s) {
    if (wanted.mode == LODE_MODE_OFF) {
        if (wanted.clear_fault) {
            set_count(self->attempts, 0u);
        }
        self->faulted = false;
        self->time_s = 0.0f;
        return wanted;
    }
    if (telemetry->mode == LODE_MODE_FAULT) {
        return after_fault(self, telemetry, dt_s);
    }
    const bool runs = telemetry->mode == LODE_MODE_RUN;
    self->time_s = runs && !self->faulted ? self->time_s + dt_s : 0.0f;
    self->faulted = false;
    if (self->time_s >= self->good_s) {
        set_count(self->attempts, 0u);
        self->time_s = self->good_s;
    }
    return lode_supervisor_is_latched(self, telemetry)
               ? (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = false}
               : wanted;
}
