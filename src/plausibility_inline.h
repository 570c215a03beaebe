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

#endif
