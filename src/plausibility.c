#include "lodestar/plausibility.h"

// A phase of amplitude I stays within I (1 - cos(D/2)) of its peak while the vector turns by D: about
// I D^2/8. It counts as stuck once that would have been so many counts, and yet it moved by none.
#define STUCK_COUNTS 8.0f
// Below it dead time may hold a phase at zero for as long.
#define STUCK_SHARE 0.05f // of i_max
#define ALL_STUCK 4.0f // of the same, squared: a tenth of i_max asked for, and no count has moved
#define COUNTER_MAX 65535.0f

lode_status_t lode_plausibility_tune(lode_plausibility_tuning_t *tuning,
                                     const lode_guard_config_t *config, float i_max_A,
                                     const lode_sense_tuning_t *sense, float ts_s) {
    if (config->plausibility != LODE_ON && config->plausibility != LODE_OFF) {
        return LODE_ERROR_CHOICE;
    }
    const bool sums = !lode_in_range(config->i_sum_A, LODE_NONE, LODE_NONE);
    if (sums && !lode_in_range(config->i_sum_A, 1.0e-3f * i_max_A, 10.0f * i_max_A)) {
        return LODE_ERROR_GUARD_CURRENT;
    }
    const uint32_t periods = LODE_GUARD_PERIODS;
    const float look_s = (float)periods * ts_s;
    const float i_gain = lode_abs(sense->i_gain);
    const float stuck_A = 8.0f * STUCK_COUNTS * (float)LODE_COUNT_FRACTION * i_gain;
    const float i_min_A = STUCK_SHARE * i_max_A;
    *tuning = (lode_plausibility_tuning_t){
        .on = config->plausibility == LODE_ON,
        .look_s = look_s,
        .stuck_A2 = stuck_A * stuck_A,
        .i_min_A2 = i_min_A * i_min_A,
        .i_still = 0.0f,
        .i_sum = sums ? config->i_sum_A / i_gain : FLT_MAX,
        .A_per_count = i_gain,
        .sum_looks = (uint32_t)(int32_t)lode_clamp(config->lock_s / look_s, 2.0f, COUNTER_MAX),
    };
    return LODE_OK;
}

void lode_plausibility_reset(lode_plausibility_t *self) {
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        self->i[n] = 0;
        self->turn_rad[n] = 0.0f;
    }
    self->i_A2 = 0.0f;
    self->moved_A2 = 0.0f;
    self->sum = 0u;
}

// None of the counts follows what is asked for: in a start, before the vector turns.
LODE_INLINE bool all_stuck(lode_plausibility_t *self, const lode_plausibility_tuning_t *tuning,
                           const int32_t i[LODE_PHASES], float i_A2) {
    const bool kept = i[0] == self->i[0] && i[1] == self->i[1] && i[2] == self->i[2];
    const float before_A2 = kept ? self->moved_A2 : 0.0f; // it takes a look to follow
    self->moved_A2 = before_A2 + lode_abs(i_A2 - self->i_A2);
    self->i_A2 = i_A2;
    return before_A2 > ALL_STUCK * tuning->i_min_A2;
}

// The phase, from 1, that has kept its count for too long; 0: none. Three looks at least: two may lie on
// either side of a peak.
LODE_INLINE int32_t stuck_phase(lode_plausibility_t *self, const lode_plausibility_tuning_t *tuning,
                                const int32_t i[LODE_PHASES], float i_A2, float turn_rad) {
    // What was kept while there was no current says nothing when one is asked for.
    const bool judged = i_A2 > tuning->i_min_A2;
    int32_t stuck = 0;
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        float turn = -turn_rad; // of one that moves, as nearly all do
        if (LODE_RARELY(i[n] == self->i[n]) && lode_abs((float)i[n]) >= tuning->i_still && judged) {
            turn = self->turn_rad[n] + turn_rad;
            const float turn2 = turn * lode_max(turn, 0.0f);
            stuck = turn2 * turn2 * i_A2 > tuning->stuck_A2 ? n + 1 : stuck;
        }
        self->i[n] = i[n];
        self->turn_rad[n] = turn;
    }
    return stuck;
}

// Not LODE_RAMFUNC: twice in a round, and small fast memories are full.
lode_finding_t lode_plausibility_step(lode_plausibility_t *self,
                                      const lode_plausibility_tuning_t *tuning,
                                      const int32_t i[LODE_PHASES], float i_A2, float turn_rad) {
    const bool all = all_stuck(self, tuning, i, i_A2);
    const int32_t stuck = stuck_phase(self, tuning, i, i_A2, turn_rad);
    if (LODE_RARELY(all) || LODE_RARELY(stuck > 0)) {
        return (lode_finding_t){LODE_CHECK_CURRENT_STUCK, (float)stuck, 0.0f};
    }
    // Where one was taken from the other two, the sum says nothing.
    const float sum = (float)(i[0] + i[1] + i[2]);
    if (LODE_RARELY(lode_abs(sum) > tuning->i_sum)) {
        self->sum = (uint_least16_t)(self->sum + 1u);
        if (self->sum >= tuning->sum_looks) {
            return (lode_finding_t){LODE_CHECK_CURRENT_SUM, sum * tuning->A_per_count,
                                    tuning->i_sum * tuning->A_per_count};
        }
    } else if (LODE_RARELY(self->sum > 0u)) {
        self->sum = (uint_least16_t)(self->sum - 1u);
    }
    return (lode_finding_t){LODE_CHECK_NONE, 0.0f, 0.0f};
}
