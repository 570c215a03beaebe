// What the parts of the state machine have of each other: mode.c what all of them do, mode_idle.c with the gates off, mode_start.c
// a start by the vector, mode_inject.c one by injection.
#ifndef LODE_MODE_PARTS_H
#define LODE_MODE_PARTS_H

#include "hfi_inline.h"
#include "mode.h"
#include "scalar_inline.h"
#include "schedule.h"

// A rotor is given up for lost at two thirds of the guard's time.
#define LOST_SHARE 2u
#define LOST_PARTS 3u

// A command to come to rest, or to stay there.
static inline bool lode_mode_is_stop(const lode_drive_t *self) {
    return !(lode_abs(self->command.speed_rad_s) > 0.0f);
}

// By injection, until that is given up: then the vector is turned.
static inline bool lode_mode_finds_at_rest(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return false;
#else
    return lode_hfi_is_on(&self->tuning->estimator.hfi) &&
           self->estimator.by.hfi.step != (uint_least8_t)LODE_HFI_UNDECIDED;
#endif
}

// RUN, about to trip for lost lock.
static inline bool lode_mode_loses_lock(const lode_drive_t *self) {
    const uint32_t least = LOST_SHARE * (uint32_t)self->tuning->guard.lock_looks;
    return LOST_PARTS * (uint32_t)self->guard.lock >= least;
}

static inline void lode_mode_set_duties(lode_drive_t *self, float duty) {
    self->duty = (lode_abc_t){duty, duty, duty};
}

// In mode.c.

void lode_mode_set(lode_drive_t *self, lode_mode_t mode);

// What the guard has counted is gone; what the attempt before has not met stays.
void lode_mode_reset_guard(lode_drive_t *self);

// Current control, at no current.
void lode_mode_take_q_axis(lode_drive_t *self);

// The gates, from OFF or PRECHARGE.
void lode_mode_switch_on(lode_drive_t *self, lode_mode_t mode);

#ifndef LODE_WITHOUT_HANDOVER_RETRY
// The rounds in which RUN proves a start. A rotor that turns the other way than asked for has not started until it is given
// back to the vector.
uint_least16_t lode_mode_rounds_to_prove(const lode_drive_t *self, float omega_rad_s);
#endif

#if !defined(LODE_WITHOUT_FLYING_START) || !defined(LODE_WITHOUT_HFI)
// What follows from where the rotor is and how fast it turns, in RUN, where that was found at once.
void lode_mode_run_at_once(lode_drive_t *self);
#endif

// From the vector of START to RUN.
void lode_mode_hand_over(lode_drive_t *self);

// Why the attempt of a start has failed. With no check it is no fault, and the start goes on.
lode_fault_t lode_mode_unmet(const lode_drive_t *self);

// In mode_start.c.

// A period of START. It measures, judges, aims and hands over in a slot each: one is enough for a period.
void lode_mode_follow_start(lode_drive_t *self, lode_slot_t slot);

void lode_mode_fail_start(lode_drive_t *self, const lode_fault_t *why);

#endif
