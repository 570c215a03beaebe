// Shared by the parts of the state machine: mode.c has what is common, mode_idle.c the gates off, mode_start.c the start by
// the vector, mode_inject.c the start by injection.
#ifndef LODE_MODE_PARTS_H
#define LODE_MODE_PARTS_H

#include "guard_inline.h"
#include "hfi_inline.h"
#include "mode.h"
#include "scalar_inline.h"
#include "schedule.h"

// The lock counts as lost at two thirds of the guard's time, before the guard trips.
#define LOST_SHARE 2u
#define LOST_PARTS 3u

// The command is to stop, or to stay at rest.
static inline bool lode_mode_is_stop(const lode_drive_t *self) {
    return !(lode_abs(self->command.speed_rad_s) > 0.0f);
}

// A start uses injection, until that gives up; then the vector turns.
static inline bool lode_mode_finds_at_rest(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return false;
#else
    return lode_hfi_is_on(&self->tuning->estimator.hfi) &&
           self->estimator.by.hfi.step != (uint_least8_t)LODE_HFI_UNDECIDED;
#endif
}

// RUN is about to trip for lost lock.
static inline bool lode_mode_loses_lock(const lode_drive_t *self) {
    const uint32_t least = LOST_SHARE * (uint32_t)self->tuning->guard.lock_checks;
    return LOST_PARTS * (uint32_t)self->guard.lock >= least;
}

// With the gates off: attempts of this start have failed, and another one follows.
static inline bool lode_mode_retries(const lode_drive_t *self) {
    return self->losses > 0u;
}

static inline void lode_mode_set_duties(lode_drive_t *self, float duty) {
    self->duty = (lode_abc_t){duty, duty, duty};
}

// In mode.c.

void lode_mode_set(lode_drive_t *self, lode_mode_t mode);

// Resets what the guard has counted, but keeps what the failed attempt reported.
void lode_mode_reset_guard(lode_drive_t *self);

// Gives current control the q axis as it is at zero current.
void lode_mode_take_q_axis(lode_drive_t *self);

// Switches all gates on, from OFF or PRECHARGE.
void lode_mode_switch_on(lode_drive_t *self, lode_mode_t mode);

#ifndef LODE_WITHOUT_HANDOVER_RETRY
// OFF, from which the next attempt of the start begins. `failed`: attempts that have failed; `calm`: how often the gains of
// its RUN are halved.
void lode_mode_end_attempt(lode_drive_t *self, const lode_fault_t *why, uint32_t failed,
                           uint32_t calm);

// Rounds of RUN after which a start is over (S28). A rotor that turns against the command has not started until it has been
// given back to the vector.
uint_least16_t lode_mode_rounds_to_prove(const lode_drive_t *self, float omega_rad_s);
#endif

#if !defined(LODE_WITHOUT_FLYING_START) || !defined(LODE_WITHOUT_HFI)
// To RUN without a fade, where the rotor's angle and speed are known at once and no start current flows.
void lode_mode_run_at_once(lode_drive_t *self);
#endif

// From the vector of START to RUN.
void lode_mode_hand_over(lode_drive_t *self);

// Why the attempt of a start has failed. `check` stays none: it is no fault, and the start goes on.
lode_fault_t lode_mode_unmet(const lode_drive_t *self);

// In mode_start.c.

// A period of START. To spread the load it measures, judges, aims and hands over in a slot each.
void lode_mode_follow_start(lode_drive_t *self, lode_slot_t slot);

void lode_mode_fail_start(lode_drive_t *self, const lode_fault_t *why);

// The load turns the rotor faster than a start can hold: the next attempt catches it as a rotor that turns. Trips WRONG_WAY
// where no attempt is left.
void lode_mode_catch_again(lode_drive_t *self, const lode_fault_t *why);

#endif
