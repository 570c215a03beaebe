// The guard's fast checks, which usually pass.
#ifndef LODE_GUARD_INLINE_H
#define LODE_GUARD_INLINE_H

#include "lodestar/guard.h"

// Nothing is wrong with a sample: no current beyond the alert, no trip, and in time. Every period.
LODE_INLINE bool lode_guard_all_ok(const lode_guard_t *self, const lode_guard_tuning_t *tuning,
                                   const lode_sample_t *sample) {
    const uint32_t late = sample->stamp - self->stamp - tuning->stamp_min;
    return LODE_USUALLY(!sample->alert) && LODE_USUALLY(!sample->trip) &&
           LODE_USUALLY(late <= tuning->stamp_span);
}

// The stamp of this period, for the next one.
LODE_INLINE void lode_guard_note(lode_guard_t *self, uint32_t stamp) {
    self->stamp = stamp;
}

// Bus and temperature, then lock, speed and direction, within their limits. NaN is not. A small build does
// without this, and counts in every look.
LODE_INLINE bool lode_guard_power_ok(const lode_guard_tuning_t *tuning,
                                     const lode_condition_t *condition) {
#ifdef LODE_SMALL
    (void)tuning;
    (void)condition;
    return false;
#else
    return LODE_USUALLY(condition->v_bus_V <= tuning->v_bus_max) &&
           LODE_USUALLY(condition->v_bus_V >= tuning->v_bus_min) &&
           LODE_USUALLY(condition->temperature_degC <= tuning->temperature_max) &&
           LODE_USUALLY(condition->temperature_degC >= tuning->temperature_min);
#endif
}

LODE_INLINE bool lode_guard_motion_ok(const lode_guard_tuning_t *tuning,
                                      const lode_condition_t *condition) {
    return LODE_USUALLY(condition->lock >= LODE_LOCK_LOST) &&
           LODE_USUALLY(condition->omega_rad_s >= 0.0f) &&
           LODE_USUALLY(condition->omega_rad_s <= tuning->omega_max);
}

// lode_guard_check_slow() would have nothing to do. `sensorless`: the estimator drives the motor.
LODE_INLINE bool lode_guard_slow_ok(const lode_guard_t *self, const lode_guard_tuning_t *tuning,
                                    const lode_condition_t *condition, bool sensorless) {
    return LODE_USUALLY(!self->pending) && lode_guard_power_ok(tuning, condition) &&
           (lode_guard_motion_ok(tuning, condition) || !sensorless);
}

#endif
