#include "lodestar/open_phase.h"

// Of the largest mean magnitude: noise and offset of a phase without current. Sound phases are equal.
#define OPEN_SHARE 0.15f
// So few samples are no electrical period but noise about the angle 0.
#define SAMPLES_MIN 16u
#define WHOLE_SET 7u

void lode_open_phase_reset(lode_open_phase_watch_t *self) {
    *self = (lode_open_phase_watch_t){.positive = true};
}

static float largest(lode_abc_t x) {
    return lode_max(lode_max(x.a, x.b), x.c);
}

// The one phase below `limit`, from 1; 0: none.
static lode_open_phase_t idle_phase(lode_abc_t sum_A, float limit) {
    return sum_A.a <= limit ? 1u : (sum_A.b <= limit ? 2u : (sum_A.c <= limit ? 3u : 0u));
}

static lode_open_phase_t found(const lode_open_phase_watch_t *self,
                               const lode_open_phase_tuning_t *tuning) {
    const float most_1 = largest(self->sum_A.set[0]);
    const float most_2 = largest(self->sum_A.set[1]);
    const float most = lode_max(most_1, most_2);
    if (!(most >= tuning->i_min_A * 0.5f * (float)self->samples)) {
        return 0u;
    }
    const float limit = OPEN_SHARE * most;
    if (most_1 <= limit) {
        return WHOLE_SET;
    }
    if (most_2 <= limit) {
        return WHOLE_SET + 1u;
    }
    const lode_open_phase_t in_1 = idle_phase(self->sum_A.set[0], limit);
    const lode_open_phase_t in_2 = idle_phase(self->sum_A.set[1], limit);
    return in_1 > 0u ? in_1 : (lode_open_phase_t)(in_2 > 0u ? in_2 + 3u : 0u);
}

LODE_HOT LODE_COLD lode_open_phase_t lode_open_phase_judge(lode_open_phase_watch_t *self,
                                                           const lode_open_phase_tuning_t *tuning) {
    if (self->samples < SAMPLES_MIN) {
        return 0u;
    }
    const lode_open_phase_t open = found(self, tuning);
    const bool again = open == self->suspect;
    lode_open_phase_reset(self);
    self->suspect = open;
    return again ? open : 0u;
}
