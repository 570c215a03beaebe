// The currents' plausibility where, as nearly always, nothing is conspicuous.
#ifndef LODE_PLAUSIBILITY_INLINE_H
#define LODE_PLAUSIBILITY_INLINE_H

#include "lodestar/plausibility.h"

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

// One bit for each phase of which something is true.
LODE_INLINE uint32_t lode_plausibility_phases(bool a, bool b, bool c) {
    return (a ? 1u : 0u) + (b ? 2u : 0u) + (c ? 4u : 0u);
}

// In lode_half_waves_t.before, beside the half-waves: enough flowed in this quarter of the turn.
#define LODE_WAVES_FLOWED 0x40u
#define LODE_WAVES_ALL 0x3fu
#define LODE_WAVES_QUARTERS 4u
#define LODE_WAVES_SHIFT 6u // of the quarter, above the half-waves
// Times the least current that is judged by, squared: 0.075 of i_max, in each quarter of a turn that is to tell something.
#define LODE_WAVES_FLOW 2.25f

// The half-waves that three currents have, by their order: a phase has one where its current is at least half of the
// vector's length, within 60 degrees of its axis. At any angle that are two. Bits: three positive ones, three negative ones.
LODE_INLINE uint32_t lode_half_waves_of(bool a_above_b, bool b_above_c, bool c_above_a) {
    static const uint_least8_t has[] = {0u, 0x11u, 0x22u, 0x21u, 0x0cu, 0x14u, 0x0au, 0u};
    return has[lode_plausibility_phases(a_above_b, b_above_c, c_above_a)];
}

// A half-wave was lacking in the turn before.
LODE_INLINE bool lode_half_waves_doubts(const lode_half_waves_t *self) {
    return (~(uint32_t)self->before & LODE_WAVES_ALL) != 0u;
}

// The quarter of the turn, 0 .. 3 in the sense of the rotation, before a look at the currents; from one look to the next
// at most 1.5 rad of it. The half-waves that were seen in the turn that has ended, where one was lacking; else 0.
LODE_INLINE uint32_t lode_half_waves_turn(lode_half_waves_t *self, uint32_t quarter) {
    const uint32_t last = (uint32_t)self->seen >> LODE_WAVES_SHIFT;
    if (quarter == last || (quarter + 1u) % LODE_WAVES_QUARTERS == last) {
        return 0u; // the frame trembles where two quarters meet
    }
    const bool flowed = (self->before & LODE_WAVES_FLOWED) != 0u;
    const uint32_t seen = flowed ? self->seen & LODE_WAVES_ALL : LODE_WAVES_ALL; // it tells nothing
    const bool ends = quarter < last;
    self->seen = (uint_least8_t)((ends ? 0u : seen) | quarter << LODE_WAVES_SHIFT);
    if (ends && seen == LODE_WAVES_ALL) {
        self->before = LODE_WAVES_ALL;
        return 0u;
    }
    self->before = (uint_least8_t)(self->before & ~LODE_WAVES_FLOWED);
    return ends ? seen : 0u;
}

// One look at the currents.
LODE_INLINE void lode_half_waves_note(lode_half_waves_t *self,
                                      const lode_plausibility_tuning_t *tuning,
                                      const int32_t i[LODE_PHASES], float i_A2) {
    if (i_A2 >= tuning->i_min_A2) {
        const uint32_t has = lode_half_waves_of(i[0] > i[1], i[1] > i[2], i[2] > i[0]);
        self->seen = (uint_least8_t)(self->seen | has);
    }
    if (i_A2 >= LODE_WAVES_FLOW * tuning->i_min_A2) {
        self->before = (uint_least8_t)(self->before | LODE_WAVES_FLOWED);
    }
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
