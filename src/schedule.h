// What follows the speed slowly: one job per period, each once in LODE_SLOW_PERIODS, in the order in which
// the results are used. The drive's step and the estimator on its own (replay) go by the same slots. The
// worst-case period is what the interrupt's time must allow for: no slot has two expensive jobs, and those of the
// guard, which now and then has to look more closely, hardly anything else.
#ifndef LODE_SCHEDULE_H
#define LODE_SCHEDULE_H

#include "lodestar/config.h"

#include <stdint.h>

typedef enum {
    // lock quality, amplitude of the EMF, length of the PLL's rotation; does the current move?; RUN: load beyond all
    // the torque
    SLOT_LOCK,
    // guard's slow checks, plausibility of the currents
    SLOT_GUARD,
    // lag of the EMF observer, lead of the duties; flux that the voltage leaves room for; resonators of the xy
    // plane; RUN: flux of the magnets; START: resistance and dead time
    SLOT_LAG,
    // slope of the dead-time error, 1/v_bus; memory unchanged; RUN: half-waves of the currents;
    // START: has the current fallen; is the estimate good enough?
    SLOT_DEAD_TIME,
    // without lock acquisition; gains of the PLL, centres of the notches
    SLOT_GAINS,
    // as SLOT_GUARD
    SLOT_GUARD_2,
    // speed control, id for its torque; START: where the vector goes
    SLOT_SPEED,
    // current references; START: hand-over, or has the current fallen, does the load turn the rotor, half-waves of
    // the currents; plausibility of a second set's currents
    SLOT_REFERENCES,
    SLOT_COUNT = LODE_SLOW_PERIODS
} lode_slot_t;

static inline lode_slot_t lode_slot_of(uint32_t period) {
    const uint32_t slot = period % (uint32_t)SLOT_COUNT;
    return (lode_slot_t)slot;
}

#endif
