// The currents' plausibility where, as nearly always, nothing is conspicuous.
#ifndef LODE_PLAUSIBILITY_INLINE_H
#define LODE_PLAUSIBILITY_INLINE_H

#include "lodestar/plausibility.h"

// The currents are looked at.
LODE_INLINE bool lode_plausibility_is_on(const lode_plausibility_tuning_t *tuning) {
    return tuning->i_sum >= 0;
}

// And so are the half-waves of three phases, in START and in RUN.
LODE_INLINE bool lode_plausibility_has_waves(const lode_plausibility_tuning_t *tuning) {
    return tuning->per_wave_A > 0.0f;
}

// Where one was taken from the other two, the sum says nothing.
LODE_INLINE bool lode_plausibility_sum_ok(const lode_plausibility_tuning_t *tuning,
                                          const int32_t i[LODE_PHASES]) {
    const int32_t sum = i[0] + i[1] + i[2];
    return sum <= tuning->i_sum && sum >= -tuning->i_sum;
}

// All three have moved since the last look, and the sum is good: there is nothing but to note them.
LODE_INLINE bool lode_plausibility_all_move(const lode_plausibility_t *self,
                                            const lode_plausibility_tuning_t *tuning,
                                            const int32_t i[LODE_PHASES]) {
    return i[0] != self->i[0] && i[1] != self->i[1] && i[2] != self->i[2] && self->sum == 0u &&
           lode_plausibility_sum_ok(tuning, i);
}

// The counts, and which phases have kept theirs.
LODE_INLINE void lode_plausibility_note(lode_plausibility_t *self, const int32_t i[LODE_PHASES],
                                        uint32_t kept) {
    self->i[0] = i[0];
    self->i[1] = i[1];
    self->i[2] = i[2];
    self->kept = (uint_least8_t)kept;
}

#define LODE_ALL_PHASES ((1u << LODE_PHASES) - 1u)

// One bit for each phase of which something is true.
LODE_INLINE uint32_t lode_plausibility_phases(bool a, bool b, bool c) {
    return (a ? 1u : 0u) + (b ? 2u : 0u) + (c ? 4u : 0u);
}

// One look at the currents `i`, 1/256 count. The phases that have the same count as at the last look, and had it at
// the one before, a bit each.
LODE_INLINE uint32_t lode_plausibility_look(lode_plausibility_t *self,
                                            const int32_t i[LODE_PHASES]) {
    const uint32_t kept =
        lode_plausibility_phases(i[0] == self->i[0], i[1] == self->i[1], i[2] == self->i[2]);
    const uint32_t again = kept & self->kept;
    lode_plausibility_note(self, i, kept);
    return again;
}

#define LODE_NOISE_WEIGHT 0.03125f // of a look: the mean of some 32, 256 periods

// SLOT_LOCK (K39).
LODE_INLINE void lode_jump_note_noise(lode_jump_t *self) {
    self->noise_V2 += LODE_NOISE_WEIGHT * (self->change_V2 - self->noise_V2);
}

// The current vector has moved by more than noise moves one that is frozen: it is noted.
LODE_INLINE bool lode_frozen_moves(lode_frozen_t *self, const lode_plausibility_tuning_t *tuning,
                                   lode_ab_t i_A) {
    const float alpha = i_A.alpha - self->i_A.alpha;
    const float beta = i_A.beta - self->i_A.beta;
    if (alpha * alpha + beta * beta <= tuning->frozen_A2) {
        return false;
    }
    self->i_A = i_A;
    self->looks = 0u;
    return true;
}

// After a look: no phase has kept its count twice in a row, and the sum is good, so there is nothing to doubt. By
// chance a phase keeps it once in some hundred looks.
LODE_INLINE bool lode_plausibility_is_chance(lode_plausibility_t *self,
                                             const lode_plausibility_tuning_t *tuning,
                                             uint32_t again, float i_A2) {
    if (again > 0u || self->sum > 0u || !lode_plausibility_sum_ok(tuning, self->i)) {
        return false;
    }
    self->still = self->kept;
    self->turn_rad = 0.0f;
    self->moved_A2 = 0.0f;
    self->i_A2 = i_A2;
    return true;
}

#endif
