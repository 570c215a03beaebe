// The currents' plausibility where, as nearly always, nothing is conspicuous.
#ifndef LODE_PLAUSIBILITY_INLINE_H
#define LODE_PLAUSIBILITY_INLINE_H

#include "lodestar/plausibility.h"

// Where one was taken from the other two, the sum says nothing.
LODE_INLINE bool lode_plausibility_sum_ok(const lode_plausibility_tuning_t *tuning,
                                          const int32_t i[LODE_PHASES]) {
    const int32_t sum = i[0] + i[1] + i[2];
    return LODE_USUALLY(sum <= tuning->i_sum) && LODE_USUALLY(sum >= -tuning->i_sum);
}

// All three have moved since the last look, none was kept then, and the sum is good: lode_plausibility_step()
// would only note them.
LODE_INLINE bool lode_plausibility_all_move(const lode_plausibility_t *self,
                                            const lode_plausibility_tuning_t *tuning,
                                            const int32_t i[LODE_PHASES]) {
    return LODE_USUALLY(i[0] != self->i[0]) && LODE_USUALLY(i[1] != self->i[1]) &&
           LODE_USUALLY(i[2] != self->i[2]) && LODE_USUALLY(self->kept == 0u) &&
           LODE_USUALLY(self->sum == 0u) && lode_plausibility_sum_ok(tuning, i);
}

LODE_INLINE void lode_plausibility_note(lode_plausibility_t *self, const int32_t i[LODE_PHASES]) {
    self->i[0] = i[0];
    self->i[1] = i[1];
    self->i[2] = i[2];
}

// One bit for each phase of which something is true.
LODE_INLINE uint32_t lode_plausibility_phases(bool a, bool b, bool c) {
    return (a ? 1u : 0u) + (b ? 2u : 0u) + (c ? 4u : 0u);
}

// Those with the same count as at the last look.
LODE_INLINE uint32_t lode_plausibility_kept(const lode_plausibility_t *self,
                                            const int32_t i[LODE_PHASES]) {
    return lode_plausibility_phases(i[0] == self->i[0], i[1] == self->i[1], i[2] == self->i[2]);
}

// Of those that have `kept` their count, which has been noted, the ones that should not have: what is kept
// without current says nothing when one is asked for, nor does a phase that may be open.
LODE_INLINE uint32_t lode_plausibility_judged(const lode_plausibility_t *self,
                                              const lode_plausibility_tuning_t *tuning,
                                              uint32_t kept, float i_A2) {
    const int32_t least = tuning->i_still;
    const int32_t *i = self->i;
    uint32_t judged = i_A2 > tuning->i_min_A2 ? kept : 0u;
    if (least > 0) {
        judged &= lode_plausibility_phases(i[0] >= least || i[0] <= -least,
                                           i[1] >= least || i[1] <= -least,
                                           i[2] >= least || i[2] <= -least);
    }
    return judged;
}

// No phase has kept its count twice in a row, and the sum is good: lode_plausibility_step() would find nothing,
// and note what this does. By chance a phase keeps it once in some hundred looks.
LODE_INLINE bool lode_plausibility_is_chance(lode_plausibility_t *self,
                                             const lode_plausibility_tuning_t *tuning,
                                             const int32_t i[LODE_PHASES], float i_A2) {
    const uint32_t kept = lode_plausibility_kept(self, i);
    if ((kept & self->kept) != 0u || self->sum > 0u || !lode_plausibility_sum_ok(tuning, i)) {
        return false;
    }
    lode_plausibility_note(self, i);
    self->still = (uint_least8_t)lode_plausibility_judged(self, tuning, kept, i_A2);
    self->kept = (uint_least8_t)kept;
    self->turn_rad = 0.0f;
    self->moved_A2 = 0.0f;
    self->i_A2 = i_A2;
    return true;
}

#endif
