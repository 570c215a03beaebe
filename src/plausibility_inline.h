// Plausibility of the phase currents: the fast part, for periods in which nothing is conspicuous.
#ifndef LODE_PLAUSIBILITY_INLINE_H
#define LODE_PLAUSIBILITY_INLINE_H

#include "lodestar/plausibility.h"

#include <float.h>

// The phase currents are checked.
LODE_INLINE bool lode_plausibility_is_on(const lode_plausibility_tuning_t *tuning) {
    return tuning->i_sum >= 0;
}

// Counts that keep still are checked, and vectors.
LODE_INLINE bool lode_plausibility_has_stuck(const lode_plausibility_tuning_t *tuning) {
    return tuning->frozen_A2 >= 0.0f;
}

// Currents that change by a factor are checked: (K38), (S43), and the wave of injection (H29).
LODE_INLINE bool lode_plausibility_has_gain(const lode_plausibility_tuning_t *tuning) {
    return tuning->jump_V2 < FLT_MAX;
}

// The half-waves of three phases are checked, in START and in RUN.
LODE_INLINE bool lode_plausibility_has_waves(const lode_plausibility_tuning_t *tuning) {
    return tuning->per_wave_A > 0.0f;
}

// With one phase computed from the other two, the sum is always zero.
LODE_INLINE bool lode_plausibility_sum_ok(const lode_plausibility_tuning_t *tuning,
                                          const int32_t i[LODE_PHASES]) {
    const int32_t sum = i[0] + i[1] + i[2];
    return sum <= tuning->i_sum && sum >= -tuning->i_sum;
}

// All three have moved since the last check, and the sum is good: it is enough to note them.
LODE_INLINE bool lode_plausibility_all_move(const lode_plausibility_t *self,
                                            const lode_plausibility_tuning_t *tuning,
                                            const int32_t i[LODE_PHASES]) {
    return i[0] != self->i[0] && i[1] != self->i[1] && i[2] != self->i[2] && self->sum == 0u &&
           lode_plausibility_sum_ok(tuning, i);
}

// Notes the counts, and which phases have kept theirs.
LODE_INLINE void lode_plausibility_note(lode_plausibility_t *self, const int32_t i[LODE_PHASES],
                                        uint32_t kept) {
    self->i[0] = i[0];
    self->i[1] = i[1];
    self->i[2] = i[2];
    self->kept = (uint_least8_t)kept;
}

#define LODE_ALL_PHASES ((1u << LODE_PHASES) - 1u)

// One bit per phase.
LODE_INLINE uint32_t lode_plausibility_phases(bool a, bool b, bool c) {
    return (a ? 1u : 0u) + (b ? 2u : 0u) + (c ? 4u : 0u);
}

// One check of the currents `i`, 1/256 count. Returns the phases that had the same count at the last check and at the one
// before, one bit each.
LODE_INLINE uint32_t lode_plausibility_check(lode_plausibility_t *self,
                                             const int32_t i[LODE_PHASES]) {
    const uint32_t kept =
        lode_plausibility_phases(i[0] == self->i[0], i[1] == self->i[1], i[2] == self->i[2]);
    const uint32_t again = kept & self->kept;
    lode_plausibility_note(self, i, kept);
    return again;
}

#define LODE_NOISE_WEIGHT 0.03125f // per check: a mean over some 32 checks, 256 periods

// SLOT_LOCK (K39).
LODE_INLINE void lode_jump_note_noise(lode_jump_t *self) {
    self->noise_V2 += LODE_NOISE_WEIGHT * (self->change_V2 - self->noise_V2);
}

// The current vector has moved by more than noise moves a frozen one; it is noted.
LODE_INLINE bool lode_frozen_moves(lode_frozen_t *self, const lode_plausibility_tuning_t *tuning,
                                   lode_ab_t i_A) {
    const float alpha = i_A.alpha - self->i_A.alpha;
    const float beta = i_A.beta - self->i_A.beta;
    const float moved_A2 = alpha * alpha + beta * beta;
    if (moved_A2 <= tuning->frozen_A2) {
        return false;
    }
    self->moved_A2 = moved_A2;
    self->i_A = i_A;
    self->checks = 0u;
    return true;
}

// After a check: no phase has kept its count twice in a row, and the sum is good, so nothing is suspected. A phase keeps its
// count by chance once in some hundred checks.
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
