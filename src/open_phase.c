#include "open_phase_inline.h"

#include "scalar_inline.h"

#define PHASES 3
// Asked of a phase, with less of which nothing is told: there are no consequences. Current of a tenth of full load is
// three times that, but an open phase may make it swing.
#define LEAST_SHARE 0.03f // of i_max
// A sixth of a turn (V11), of a half-wave that is asked for during more than a third.
#define ENOUGH 16384u
#define PER_rad 0.95492966f // 3/pi
// ... and for as long as it takes control of the xy plane to bring i_max down to what is doubted of the least current.
#define TIME_CONSTANTS 4.9f // ln(1/(0.25 0.03))
#define LOOKS_MIN 3.0f
#define WHOLE_SET 7

lode_open_phase_tuning_t lode_open_phase_tune(float i_max_A, float xy_rad_s, float look_s) {
    const float looks = lode_max(TIME_CONSTANTS / (xy_rad_s * look_s), LOOKS_MIN);
    return (lode_open_phase_tuning_t){
        .least_A = LEAST_SHARE * i_max_A, .per_rad = PER_rad, .most = 1.0f / looks};
}

void lode_open_phase_reset(lode_open_phase_watch_t *self) {
    *self = (lode_open_phase_watch_t){.doubts = false};
}

static uint_least16_t more(uint_least16_t before, uint_least16_t step) {
    return before < ENOUGH ? (uint_least16_t)(before + step) : before;
}

// One half-wave: what is asked of the phase and what it has, both counted in its direction.
static uint_least16_t lacking(uint_least16_t before, float asked_A, float has_A, float least_A,
                              uint_least16_t step) {
    if (has_A >= LODE_WAVE_HAS * lode_max(asked_A, least_A)) {
        return 0u;
    }
    return asked_A >= least_A && has_A <= LODE_WAVE_LACKS * asked_A ? more(before, step) : before;
}

static lode_abc_t phases_of(int32_t set, lode_ab_t i_A) {
    return set == 0 ? lode_clarke_inverse(i_A) : lode_set2_clarke_inverse(i_A);
}

// What is asked of the phases of a set, of a current that is `length_A` long, and what they have.
static void note_half_waves(lode_lacking_t *set, lode_abc_t asked, lode_abc_t has, float length_A,
                            float least_A, uint_least16_t step) {
    const float asked_A[PHASES] = {asked.a, asked.b, asked.c};
    const float has_A[PHASES] = {has.a, has.b, has.c};
    for (int32_t n = 0; n < PHASES; n++) {
        if (lode_abs(asked_A[n]) >= LODE_WAVE_ASKED * length_A) {
            const bool up = asked_A[n] > 0.0f;
            const float sign = up ? 1.0f : -1.0f;
            uint_least16_t *lacks = &set->lacks[up ? n : n + PHASES];
            *lacks = lacking(*lacks, sign * asked_A[n], sign * has_A[n], least_A, step);
        }
    }
}

static bool is_any(const lode_lacking_t *set) {
    bool any = false;
    for (int32_t n = 0; n < LODE_HALF_WAVES; n++) {
        any = any || set->lacks[n] > 0u;
    }
    return any;
}

// The phase, from 1; 0: none. What both half-waves have been lacking counts as one. A set of which all phases are open
// has had no current at all for as long.
static int32_t found(const lode_lacking_t *set) {
    int32_t phase = 0;
    for (int32_t n = 0; n < PHASES; n++) {
        const uint32_t both = (uint32_t)set->lacks[n] + (uint32_t)set->lacks[n + PHASES];
        phase = both >= ENOUGH ? n + 1 : phase;
    }
    return phase > 0 && set->all >= ENOUGH ? WHOLE_SET : phase;
}

LODE_NOINLINE lode_open_phase_t lode_open_phase_look(lode_open_phase_watch_t *self,
                                                     const lode_open_phase_tuning_t *tuning,
                                                     int32_t set, lode_ab_t i_set_A, lode_ab_t i_A,
                                                     float turn_rad) {
    const float i_A2 = i_A.alpha * i_A.alpha + i_A.beta * i_A.beta;
    const float length_A = lode_sqrt(i_A2);
    const float share = lode_clamp(lode_abs(turn_rad) * tuning->per_rad, 0.0f, tuning->most);
    const uint_least16_t step = (uint_least16_t)((float)ENOUGH * share);
    lode_lacking_t *of_set = &self->set[set];
    of_set->idle = length_A >= tuning->least_A ? (uint_least16_t)0u : more(of_set->idle, step);
    if (of_set->idle >= ENOUGH) { // what was lacking is too long ago
        *of_set = (lode_lacking_t){.all = 0u};
    }
    const float set_A2 = i_set_A.alpha * i_set_A.alpha + i_set_A.beta * i_set_A.beta;
    const float none_A2 = LODE_WAVE_LACKS * LODE_WAVE_LACKS * i_A2;
    of_set->all = set_A2 <= none_A2 ? more(of_set->all, step) : (uint_least16_t)0u;
    note_half_waves(of_set, phases_of(set, i_A), phases_of(set, i_set_A), length_A, tuning->least_A,
                    step);
    const int32_t phase = found(of_set);
    self->doubts = is_any(&self->set[0]) || is_any(&self->set[1]);
    const int32_t number = phase == WHOLE_SET ? WHOLE_SET + set : phase + PHASES * set;
    return (lode_open_phase_t)(phase > 0 ? number : 0);
}
