#include "lodestar/supervisor.h"
#include "scalar_inline.h"

#include <float.h>
#include <stddef.h>

// Checks the count: memory of zeros or ones does not match, nor the content after power-up, except once in 2^32.
#define KEPT_MAGIC UINT32_C(0x4C6F5375)

#define WAIT_s 1.0f // the cause may vanish, and most rotors slow down
#define WAIT_MAX_s 1.0e4f
#define GOOD_s 10.0f // longer than a start with its ramp
#define GOOD_MAX_s 1.0e5f
#define TIME_MIN_s 1.0e-3f
// Shorts in the models of eight motors took up to four times the periods that are counted.
#define LOOK_TIMES 5u
#define LESS_EMF 0.9f // of the bus: EMF at which the short ends, clear of noise and ripple

#ifdef LODE_WITHOUT_ACTIVE_SHORT
#define IS_SHORT_BUILT_IN false
#else
#define IS_SHORT_BUILT_IN true
#endif

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
    const lode_references_tuning_t *motor = &tuning->references;
    const lode_choice_t choice = config->active_short;
    const float wait_s = lode_given_or(config->wait_s, WAIT_s);
    const float good_s = lode_given_or(config->good_s, GOOD_s);
    if (!are_reactions(config) || !lode_in_range(wait_s, TIME_MIN_s, WAIT_MAX_s) ||
        !lode_in_range(good_s, TIME_MIN_s, GOOD_MAX_s) || !lode_is_choice(choice)) {
        return LODE_ERROR_SUPERVISOR;
    }
    const bool can = IS_SHORT_BUILT_IN && motor->psi_Wb <= motor->Ld_H * motor->i_max_A;
    if (choice == LODE_ON && !can) {
        return LODE_ERROR_ACTIVE_SHORT;
    }
    *self = (lode_supervisor_t){.config = config,
                                .tuning = tuning,
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

// Bus and power stage are within their limits again.
static bool is_over(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    const lode_guard_tuning_t *limits = &self->tuning->guard;
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
    return count > most; // used up by resets
}

// The peak of the line-to-line EMF is above the bus, so that the diodes would conduct.
static bool generates(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    const float emf_V =
        LODE_SQRT3 * self->tuning->references.psi_Wb * lode_abs(telemetry->omega_rad_s);
    const float share = self->shorts ? LESS_EMF : 1.0f;
    return self->config->active_short == LODE_ON && emf_V > share * telemetry->v_bus_V;
}

// Whether the motor is to be shorted after a fault. With the gates off the speed is unknown; a vector that turns has started
// from rest.
static bool shorts_next(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    if (telemetry->mode == LODE_MODE_RUN) {
        return generates(self, telemetry);
    }
    return self->shorts &&
           !(telemetry->mode == LODE_MODE_START && telemetry->start_stage > LODE_START_CATCH);
}

// The guard has had the time to find a shorted switch. What it counts is there for a part of each turn only, of a rotor whose EMF
// is above the bus.
static bool has_waited(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    const float flux_Wb = LODE_SQRT3 * lode_max(self->tuning->references.psi_Wb, FLT_MIN);
    const float least_rad_s = telemetry->v_bus_V / flux_Wb;
    const float omega = lode_max(lode_abs(telemetry->omega_rad_s), least_rad_s);
    const uint32_t counted = (uint32_t)self->tuning->guard.bus_periods + LODE_GUARD_DECAY_PERIODS +
                             lode_guard_half_turn(self->tuning->estimator.pll.ts_s * omega);
    return telemetry->steps - self->faulted_at > LOOK_TIMES * counted;
}

// In FAULT: whether all low sides on are better than none. With a shorted low side they turn the short circuit of one phase
// into one of all three, with less current and no DC. With a shorted high side they would short the bus.
static bool shorts_after(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    const uint32_t check = telemetry->fault.check;
    if (check == (uint32_t)LODE_CHECK_SWITCH_SHORTED) {
        return self->config->active_short == LODE_ON && telemetry->fault.measured < 0.0f;
    }
    if (lode_guard_suspects(check) && !has_waited(self, telemetry)) {
        return false;
    }
    return self->shorts && check != (uint32_t)LODE_CHECK_HARDWARE_TRIP;
}

// The command, with an active short if it has one itself or `shorts` is set.
static lode_command_t with_short(lode_command_t command, bool shorts) {
#ifdef LODE_WITHOUT_ACTIVE_SHORT
    (void)shorts;
    return command;
#else
    lode_command_t changed = command;
    changed.active_short = command.active_short || shorts;
    return changed;
#endif
}

// In FAULT, with an attempt left: it is time for that.
static bool is_time(const lode_supervisor_t *self, const lode_telemetry_t *telemetry) {
    return reaction_to(self, telemetry->fault) == LODE_REACTION_RIDE_THROUGH
               ? is_over(self, telemetry)
               : self->time_s >= self->wait_s;
}

// `goes_on`: otherwise it begins anew.
static void count_time(lode_supervisor_t *self, bool goes_on, float dt_s) {
    if (goes_on) {
        lode_add_small(&self->time_s, &self->rest_s, dt_s);
    } else {
        self->time_s = 0.0f;
        self->rest_s = 0.0f;
    }
}

// OFF; it clears the fault when it is time for an attempt.
static lode_command_t after_fault(lode_supervisor_t *self, const lode_telemetry_t *telemetry,
                                  float dt_s) {
    if (self->posted && self->posted_at == telemetry->steps) { // a loop faster than the interrupt
        return (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true};
    }
    count_time(self, self->waits, dt_s);
    const bool now = !lode_supervisor_is_latched(self, telemetry) && is_time(self, telemetry);
    if (now) {
        count_one(self->attempts);
    }
    self->waits = !now;
    self->posted = now;
    self->posted_at = telemetry->steps;
    const lode_command_t command = {.mode = LODE_MODE_OFF, .clear_fault = now};
    return with_short(command, !now && shorts_after(self, telemetry));
}

// OFF is commanded. Without clear_fault a fault and its active short stay.
static lode_command_t off(lode_supervisor_t *self, const lode_telemetry_t *telemetry,
                          lode_command_t wanted) {
    if (wanted.clear_fault) {
        set_count(self->attempts, 0u);
    }
    self->waits = false;
    count_time(self, false, 0.0f);
    return with_short(wanted, telemetry->mode == LODE_MODE_FAULT && shorts_after(self, telemetry));
}

lode_command_t lode_supervisor_step(lode_supervisor_t *self, const lode_telemetry_t *telemetry,
                                    lode_command_t wanted, float dt_s) {
    const bool fault = telemetry->mode == LODE_MODE_FAULT;
    const bool runs = telemetry->mode == LODE_MODE_RUN;
    if (fault && !(self->faulted && self->trips == telemetry->trips)) {
        self->faulted_at = telemetry->steps;
    }
    self->faulted = fault;
    self->trips = telemetry->trips;
    self->shorts = shorts_next(self, telemetry);
    if (wanted.mode == LODE_MODE_OFF) {
        return off(self, telemetry, wanted);
    }
    if (fault) {
        return after_fault(self, telemetry, dt_s);
    }
    count_time(self, runs && !self->waits, dt_s);
    self->waits = false;
    if (self->time_s >= self->good_s) {
        set_count(self->attempts, 0u);
    }
    if (lode_supervisor_is_latched(self, telemetry)) {
        return (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = false};
    }
    return with_short(wanted, self->shorts);
}
