#include "open_phase_inline.h"

// Of the largest mean magnitude: noise and offset of a phase without current. Sound phases are equal.
#define OPEN_SHARE 0.15f
// So few samples are too few to compare: more than one electrical period then.
#define SAMPLES_MIN 16u
#define PHASES 6
#define WHOLE_SET_1 7u
#define WHOLE_SET_2 8u

void lode_open_phase_reset(lode_open_phase_watch_t *self) {
    *self = (lode_open_phase_watch_t){.positive = true};
}

static float largest(lode_abc_t x) {
    return lode_max(lode_max(x.a, x.b), x.c);
}

static float smallest(lode_abc_t x) {
    return lode_min(lode_min(x.a, x.b), x.c);
}

// The phase with the least current, from 1: while one is open, a phase beside it carries little, too.
static LODE_NOINLINE lode_open_phase_t idlest(const lode_abc6_t *sum) {
    const float sums[PHASES] = {sum->set[0].a, sum->set[0].b, sum->set[0].c,
                                sum->set[1].a, sum->set[1].b, sum->set[1].c};
    int32_t phase = 0;
    for (int32_t n = 1; n < PHASES; n++) {
        phase = sums[n] < sums[phase] ? n : phase;
    }
    return (lode_open_phase_t)(phase + 1);
}

static lode_open_phase_t found(const lode_open_phase_watch_t *self,
                               const lode_open_phase_tuning_t *tuning) {
    const float most_1 = largest(self->sum.set[0]);
    const float most_2 = largest(self->sum.set[1]);
    const float most = lode_max(most_1, most_2);
    const float limit = OPEN_SHARE * most;
    if (!(most >= tuning->i_min * 0.5f * (float)self->samples)) {
        return 0u;
    }
    if (!(lode_min(smallest(self->sum.set[0]), smallest(self->sum.set[1])) <= limit)) {
        return 0u;
    }
    if (most_1 <= limit || most_2 <= limit) {
        return most_1 <= limit ? WHOLE_SET_1 : WHOLE_SET_2;
    }
    return idlest(&self->sum);
}

LODE_RAMFUNC LODE_NOINLINE lode_open_phase_t
lode_open_phase_judge(lode_open_phase_watch_t *self, const lode_open_phase_tuning_t *tuning) {
    if (self->samples < SAMPLES_MIN) {
        return 0u;
    }
    const lode_open_phase_t open = found(self, tuning);
    const bool again = open == self->suspect;
    const lode_abc_t none = {0.0f, 0.0f, 0.0f};
    self->sum.set[0] = none; // one by one: no call of memset()
    self->sum.set[1] = none;
    self->samples = 0u;
    self->suspect = open;
    return again ? open : 0u;
}
