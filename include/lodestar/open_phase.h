/// Finds a phase that carries no current while the others of the machine do: a broken wire, a switch
/// that stays off.
#ifndef LODESTAR_OPEN_PHASE_H
#define LODESTAR_OPEN_PHASE_H

#include "lodestar/status.h"
#include "lodestar/vsd.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Open phases by number: 0 none, 1 .. 3 of set 1, 4 .. 6 of set 2, 7 and 8 all of set 1 and of set 2.
typedef uint_least8_t lode_open_phase_t;

/// The set that an open phase belongs to, 0 or 1.
static inline int32_t lode_open_phase_set(lode_open_phase_t open) {
    return open <= 3u || open == 7u ? 0 : 1;
}

typedef struct {
    float i_min_A; ///< mean of a phase current's magnitude below which nothing can be told
} lode_open_phase_tuning_t;

typedef struct {
    lode_abc6_t sum_A;         ///< of the currents' magnitudes, since the electrical period began
    uint_least16_t samples;    ///< of both sets
    lode_open_phase_t suspect; ///< found in the last electrical period
    bool positive;             ///< sine of the rotor angle in the last call
} lode_open_phase_watch_t;

void lode_open_phase_reset(lode_open_phase_watch_t *self);

/// Part of lode_open_phase_step(), which alone calls it: an electrical period is over.
lode_open_phase_t lode_open_phase_judge(lode_open_phase_watch_t *self,
                                        const lode_open_phase_tuning_t *tuning);

LODE_INLINE void lode_open_phase_add(lode_abc_t *sum_A, const lode_abc_t *i_A) {
    sum_A->a += lode_abs(i_A->a);
    sum_A->b += lode_abs(i_A->b);
    sum_A->c += lode_abs(i_A->c);
}

/// Takes in the phase currents of both sets, one set at a time: half the work.
LODE_INLINE void lode_open_phase_note(lode_open_phase_watch_t *self, const lode_abc_t *set_1_A,
                                      const lode_abc_t *set_2_A) {
    if (self->samples % 2u == 0u) {
        lode_open_phase_add(&self->sum_A.set[0], set_1_A);
    } else {
        lode_open_phase_add(&self->sum_A.set[1], set_2_A);
    }
    self->samples = (uint_least16_t)(self->samples + 1u);
}

/// After lode_open_phase_note(), at the rotor angle of sine `rotor_sin`. Returns a phase that has been
/// open for two whole electrical periods: the third since it opened at the latest.
LODE_INLINE lode_open_phase_t lode_open_phase_step(lode_open_phase_watch_t *self,
                                                   const lode_open_phase_tuning_t *tuning,
                                                   float rotor_sin) {
    const bool before = self->positive;
    self->positive = rotor_sin >= 0.0f;
    return self->positive && !before ? lode_open_phase_judge(self, tuning) : (lode_open_phase_t)0u;
}

#ifdef __cplusplus
}
#endif

#endif
