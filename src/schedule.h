// The slow jobs: one per period, each once in LODE_SLOW_PERIODS, in the order in which the results are used. The drive's step
// and the estimator on its own (replay) have the same slots. The longest period limits the interrupt rate: so no slot has two
// expensive jobs, and the guard's slots, whose checks sometimes take longer, have hardly anything else.
#ifndef LODE_SCHEDULE_H
#define LODE_SCHEDULE_H

#include "lodestar/config.h"

#include <stdint.h>

typedef enum {
    // lock quality, amplitude of the EMF, length of the PLL's rotation, currents that do not move; RUN: load beyond the
    // largest torque
    SLOT_LOCK,
    // guard's slow checks, plausibility of the currents
    SLOT_GUARD,
    // lag of the EMF observer, lead of the duties; flux that the voltage allows; resonators of the xy plane; RUN: flux of the
    // magnets, currents that are not their references', half-waves of the currents; START: resistance and dead time, slip
    SLOT_LAG,
    // slope of the dead-time error, 1/v_bus; check of the memory; START: fall of the current, quality of the estimate
    SLOT_DEAD_TIME,
    // without lock: acquisition; gains of the PLL, centres of the notches
    SLOT_GAINS,
    // as SLOT_GUARD
    SLOT_GUARD_2,
    // speed control, id for its torque; START: where the vector goes
    SLOT_SPEED,
    // current references; START: hand-over, or fall of the current, rotor turned by the load, half-waves of the currents;
    // plausibility of a second set's currents
    SLOT_REFERENCES,
    SLOT_COUNT = LODE_SLOW_PERIODS
} lode_slot_t;

static inline lode_slot_t lode_slot_of(uint32_t period) {
    const uint32_t slot = period % (uint32_t)SLOT_COUNT;
    return (lode_slot_t)slot;
}

#endif
