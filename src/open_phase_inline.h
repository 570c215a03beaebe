// Watching for an open phase, one period.
#ifndef LODE_OPEN_PHASE_INLINE_H
#define LODE_OPEN_PHASE_INLINE_H

#include "lodestar/open_phase.h"

// Part of lode_open_phase_step(), which alone calls it: an electrical period is over.
lode_open_phase_t lode_open_phase_judge(lode_open_phase_watch_t *self,
                                        const lode_open_phase_tuning_t *tuning);

LODE_INLINE void lode_open_phase_add(lode_abc_t *sum, const int32_t i[3]) {
    sum->a += lode_abs((float)i[0]);
    sum->b += lode_abs((float)i[1]);
    sum->c += lode_abs((float)i[2]);
}

// Takes in the phase currents of both sets, one set at a time: half the work.
LODE_INLINE void lode_open_phase_note(lode_open_phase_watch_t *self, const int32_t set_1[3],
                                      const int32_t set_2[3]) {
    if (self->samples % 2u == 0u) {
        lode_open_phase_add(&self->sum.set[0], set_1);
    } else {
        lode_open_phase_add(&self->sum.set[1], set_2);
    }
    self->samples = (uint_least16_t)(self->samples + 1u);
}

// A rotor at rest whose angle is noise about 0 does not turn.
#define TURNED_SINE 0.5f

// After lode_open_phase_note(), at the rotor angle of sine `rotor_sin`. Returns a phase that has been
// open for two whole electrical periods: the third since it opened at the latest.
LODE_INLINE lode_open_phase_t lode_open_phase_step(lode_open_phase_watch_t *self,
                                                   const lode_open_phase_tuning_t *tuning,
                                                   float rotor_sin) {
    const bool before = self->positive;
    self->positive = rotor_sin >= (before ? -TURNED_SINE : TURNED_SINE);
    return self->positive && !before ? lode_open_phase_judge(self, tuning) : (lode_open_phase_t)0u;
}

#endif
