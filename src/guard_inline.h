// The guard's checks on their usual path, where all is well.
#ifndef LODE_GUARD_INLINE_H
#define LODE_GUARD_INLINE_H

#include "lodestar/guard.h"

// Every period: no current beyond the alert, no trip, and in time.
LODE_INLINE bool lode_guard_all_ok(const lode_guard_t *self, const lode_guard_tuning_t *tuning,
                                   const lode_sample_t *sample) {
    const uint32_t late = sample->stamp - self->stamp - tuning->stamp_min;
    return !sample->alert && !sample->trip && late <= tuning->stamp_span;
}

// The stamp of this period, for the next one.
LODE_INLINE void lode_guard_note(lode_guard_t *self, uint32_t stamp) {
    self->stamp = stamp;
}

// The check that is under way has found a lost lock at most.
LODE_INLINE bool lode_guard_found_nothing_else(const lode_guard_t *self) {
    const uint32_t found = self->fault.check;
    return found == (uint32_t)LODE_CHECK_NONE || found == (uint32_t)LODE_CHECK_LOST_LOCK;
}

// (K45): of so many checks of a lock that is being lost, the rotor hardly turned at one.
#define LODE_STOPPED_CHECKS 4u

LODE_INLINE bool lode_guard_saw_rotor_stopped(const lode_guard_t *self) {
    return self->stopped > 0u && LODE_STOPPED_CHECKS * self->stopped >= self->lock;
}

// Takes that lost lock back: the drive does something about it.
LODE_INLINE void lode_guard_withdraw(lode_guard_t *self) {
    if (!lode_guard_is_good(self)) {
        self->fault.check = (uint_least8_t)LODE_CHECK_NONE;
        self->trips = (uint_least16_t)(self->trips - 1u);
    }
}

// Bus and temperature (here), lock, speed and direction (below) are within their limits; NaN is not. A small build omits this
// and counts at every check.
LODE_INLINE bool lode_guard_power_ok(const lode_guard_tuning_t *tuning,
                                     const lode_condition_t *condition) {
#ifdef LODE_SMALL
    (void)tuning;
    (void)condition;
    return false;
#else
    return condition->v_bus_V <= tuning->v_bus_max && condition->v_bus_V >= tuning->v_bus_min &&
           condition->temperature_degC <= tuning->temperature_max &&
           condition->temperature_degC >= tuning->temperature_min;
#endif
}

LODE_INLINE bool lode_guard_motion_ok(const lode_guard_tuning_t *tuning,
                                      const lode_condition_t *condition) {
    // the hint saves 7 cycles of the worst-case call of c_leso_qpll, 3 of the mean
    return LODE_USUALLY(condition->lock >= LODE_LOCK_LOST && condition->omega_rad_s >= 0.0f &&
                        condition->omega_rad_s <= tuning->omega_max);
}

// lode_guard_check_slow() would have nothing to do. `runs`: RUN, by whatever angle.
LODE_INLINE bool lode_guard_slow_ok(const lode_guard_t *self, const lode_guard_tuning_t *tuning,
                                    const lode_condition_t *condition, bool runs) {
    return !self->pending && lode_guard_power_ok(tuning, condition) &&
           (lode_guard_motion_ok(tuning, condition) || !runs);
}

#endif
