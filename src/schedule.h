// What follows the speed slowly: one job per period, each once in LODE_SLOW_PERIODS, in the order in which
// the results are used. The drive's step and the estimator on its own (replay) go by the same slots.
#ifndef LODE_SCHEDULE_H
#define LODE_SCHEDULE_H

#include "lodestar/config.h"

#include <stdint.h>

typedef enum {
    SLOT_LOCK,       // lock quality, amplitude of the EMF, length of the PLL's rotation
    SLOT_NOTCHES,    // centres; guard
    SLOT_GAINS,      // of the PLL, of the xy resonators; without lock acquisition first
    SLOT_LAG,        // of the EMF observer; lead of the duties
    SLOT_DEAD_TIME,  // slope of the dead-time error, 1/v_bus; memory unchanged
    SLOT_GUARD,      // again
    SLOT_SPEED,      // speed control; START: is the estimate good enough?
    SLOT_REFERENCES, // current references; START: hand-over
    SLOT_COUNT = LODE_SLOW_PERIODS
} lode_slot_t;

static inline lode_slot_t lode_slot_of(uint32_t period) {
    return (lode_slot_t)(period % (uint32_t)SLOT_COUNT);
}

#endif
