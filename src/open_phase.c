#include "open_phase_inline.h"

#include "scalar_inline.h"

#define PHASES 3
// Least current requested from a phase; with less, nothing can be told. At a tenth of full load the current is three times
// that, but an open phase may make it swing.
#define LEAST_SHARE 0.03f // of i_max
// A sixth of a turn (V11), in units of the counters; a half-wave is requested for more than a third of a turn.
#define ENOUGH 16384u
#define PER_rad 0.95492966f // 3/pi
// ... and the time in which control of the xy plane brings i_max down to what (V10) detects at the least request.
#define TIME_CONSTANTS 4.9f // ln(1/(0.25 0.03))
#define CHECKS_MIN 3.0f
// Three phases: a load that throws a light rotor makes current control lag for this long (K27).
#define LACKING_s 2.0e-3f
// Share of the current: if a phase carries more of it in the other direction, it is not dead, and current control lags by
// nearly half a turn (K24).
#define AGAINST 0.75f
// Share of the voltage that current control adds for the missing current: this much of it drives no current (K28).
#define UNANSWERED 0.25f
// Scales the difference of the other two phases to the component at right angles to a phase (K30).
#define ACROSS (1.0f / LODE_SQRT3)
// Turn per check above which the previous reference belongs to another half-wave: fewer than 3.5 checks in its 140 degrees.
#define OLD_rad 0.7f
// Weight of a check of a half-wave that was missing once and has not flowed since (K27).
#define NOT_HAD (1.0f / 12.0f)
#define WHOLE_SET ((int32_t)LODE_OPEN_SET_1)

lode_open_phase_tuning_t lode_open_phase_tune(float i_max_A, float xy_rad_s, float interval_s) {
    const float checks = lode_max(TIME_CONSTANTS / (xy_rad_s * interval_s), CHECKS_MIN);
    return (lode_open_phase_tuning_t){
        .least_A = LEAST_SHARE * i_max_A, .per_rad = PER_rad, .most = 1.0f / checks};
}

lode_open_phase_tuning_t lode_half_waves_tune(float i_max_A, float control_rad_s,
                                              float interval_s) {
    lode_open_phase_tuning_t tuning = lode_open_phase_tune(i_max_A, control_rad_s, interval_s);
    tuning.most = lode_min(tuning.most, interval_s / LACKING_s);
    return tuning;
}

void lode_open_phase_reset(lode_open_phase_watch_t *self) {
    *self = (lode_open_phase_watch_t){.doubts = false};
}

static uint_least16_t more(uint_least16_t before, uint_least16_t step) {
    return before < ENOUGH ? (uint_least16_t)(before + step) : before;
}

// Counts one half-wave; requested and measured current are positive in its direction.
static uint_least16_t lacking(uint_least16_t before, float ref_A, float i_A, float least_A,
                              uint_least16_t step) {
    if (i_A >= LODE_WAVE_HAS * lode_max(ref_A, least_A)) {
        return 0u;
    }
    return ref_A >= least_A && i_A <= LODE_WAVE_LACKS * ref_A ? more(before, step) : before;
}

static lode_abc_t phases_of(int32_t set, lode_ab_t i_A) {
    return set == 0 ? lode_clarke_inverse(i_A) : lode_set2_clarke_inverse(i_A);
}

// Counts the half-waves of a set; `length_A`: length of the requested current vector.
static void note_half_waves(lode_half_waves_t *waves, lode_abc_t ref, lode_abc_t i, float length_A,
                            float least_A, uint_least16_t step) {
    const float ref_A[PHASES] = {ref.a, ref.b, ref.c};
    const float i_A[PHASES] = {i.a, i.b, i.c};
    for (int32_t n = 0; n < PHASES; n++) {
        if (lode_abs(ref_A[n]) >= LODE_WAVE_REF * length_A) {
            const bool up = ref_A[n] > 0.0f;
            const float sign = up ? 1.0f : -1.0f;
            uint_least16_t *lacks = &waves->lacks[up ? n : n + PHASES];
            *lacks = lacking(*lacks, sign * ref_A[n], sign * i_A[n], least_A, step);
        }
    }
}

// Both half-waves of a phase, added up.
static uint32_t both_of(const lode_half_waves_t *waves, int32_t phase) {
    return (uint32_t)waves->lacks[phase] + (uint32_t)waves->lacks[phase + PHASES];
}

static bool is_any(const lode_half_waves_t *waves) {
    return both_of(waves, 0) + both_of(waves, 1) + both_of(waves, 2) > 0u;
}

// The phase, from 1; 0: none.
static int32_t phase_of(const lode_half_waves_t *waves) {
    int32_t phase = 0;
    for (int32_t n = 0; n < PHASES; n++) {
        phase = both_of(waves, n) >= ENOUGH ? n + 1 : phase;
    }
    return phase;
}

// What one check counts, where ENOUGH is a fault.
static uint_least16_t step_of(const lode_open_phase_tuning_t *tuning, float turn_rad) {
    const float share = lode_clamp(lode_abs(turn_rad) * tuning->per_rad, 0.0f, tuning->most);
    return (uint_least16_t)((float)ENOUGH * share);
}

// True: so little current has been requested for so long that the counts are out of date. A fault that makes the torque swing
// leaves pauses of up to a quarter of a turn (K26).
static bool is_idle(lode_half_waves_t *waves, bool little, uint_least16_t step) {
    waves->idle = little ? more(waves->idle, (uint_least16_t)(step / 2u)) : (uint_least16_t)0u;
    return waves->idle >= ENOUGH;
}

LODE_NOINLINE lode_open_phase_t lode_open_phase_check(lode_open_phase_watch_t *self,
                                                      const lode_open_phase_tuning_t *tuning,
                                                      int32_t set, lode_ab_t i_set_A, lode_ab_t i_A,
                                                      float turn_rad) {
    const float i_A2 = i_A.alpha * i_A.alpha + i_A.beta * i_A.beta;
    const float length_A = lode_sqrt(i_A2);
    const uint_least16_t step = step_of(tuning, turn_rad);
    lode_lacking_t *of_set = &self->set[set];
    if (is_idle(&of_set->waves, length_A < tuning->least_A, step)) {
        *of_set = (lode_lacking_t){.all = 0u};
    }
    const float set_A2 = i_set_A.alpha * i_set_A.alpha + i_set_A.beta * i_set_A.beta;
    const float none_A2 = LODE_WAVE_LACKS * LODE_WAVE_LACKS * i_A2;
    of_set->all = set_A2 <= none_A2 ? more(of_set->all, step) : (uint_least16_t)0u;
    note_half_waves(&of_set->waves, phases_of(set, i_A), phases_of(set, i_set_A), length_A,
                    tuning->least_A, step);
    const int32_t open = phase_of(&of_set->waves);
    // A set is open as a whole if all of it has been without current for as long.
    const int32_t phase = open > 0 && of_set->all >= ENOUGH ? WHOLE_SET : open;
    self->doubts = is_any(&self->set[0].waves) || is_any(&self->set[1].waves);
    const int32_t number = phase == WHOLE_SET ? WHOLE_SET + set : phase + PHASES * set;
    return (lode_open_phase_t)(phase > 0 ? number : 0);
}

// One check of three phases.
typedef struct {
    float least_A;   // least request that tells anything
    float ref_A;     // least request for a phase to be judged
    float seen_A;    // least current of a half-wave that flows
    float against_A; // largest current the other way of a dead phase
    float kp_V_A;
    uint_least16_t step;
    uint_least16_t not_had; // weight of a check without the half-wave
} limits_t;

// One phase.
typedef struct {
    float ref_A;
    float before_A;
    float i_A;
    float beyond_V;
    float across_V; // the same at right angles to the phase's axis
} phase_t;

static phase_t turned_over(phase_t x) {
    return (phase_t){-x.ref_A, -x.before_A, -x.i_A, -x.beyond_V, x.across_V};
}

// (K24), (K28), (K30); all quantities are positive in the direction of the requested half-wave.
static bool is_lacking(const limits_t *limits, phase_t x) {
    const float ref_A = lode_min(x.ref_A, x.before_A);
    return x.ref_A >= limits->ref_A && ref_A >= limits->least_A &&
           x.i_A <= LODE_WAVE_LACKS * ref_A && x.i_A >= -limits->against_A &&
           x.beyond_V >= UNANSWERED * limits->kp_V_A * (ref_A - x.i_A) &&
           x.beyond_V >= lode_abs(x.across_V);
}

static uint_least16_t *half_wave_of(lode_half_waves_t *waves, int32_t phase, bool up) {
    return &waves->lacks[up ? phase : phase + PHASES];
}

// A half-wave that was missing once counts on until it flows (K27).
static uint_least16_t go_on(uint_least16_t before, uint_least16_t step) {
    return before > 0u ? more(before, step) : before;
}

// One phase: the requested half-wave may be missing. A half-wave that flows is not, requested or not: a dead switch lets none
// through, whatever the reference does (K26).
static void note_phase(lode_half_waves_t *waves, const limits_t *limits, int32_t phase, phase_t x) {
    const bool up = x.ref_A > 0.0f;
    uint_least16_t *driven = half_wave_of(waves, phase, up);
    uint_least16_t *other = half_wave_of(waves, phase, !up);
    const bool lacks = is_lacking(limits, up ? x : turned_over(x));
    *driven = lacks ? more(*driven, limits->step) : go_on(*driven, limits->not_had);
    *other = go_on(*other, limits->not_had);
    if (lode_abs(x.i_A) >= limits->seen_A) {
        *half_wave_of(waves, phase, x.i_A > 0.0f) = 0u;
    }
}

// The phase, from 1, with one half-wave missing for long enough, if the other two count less than half of it: while current
// control lags, they count as much (K27). 0: none.
static int32_t alone_of(const lode_half_waves_t *waves) {
    int32_t phase = 0;
    int32_t doubted = 0;
    for (int32_t n = 0; n < PHASES; n++) {
        const uint32_t most =
            waves->lacks[n] > waves->lacks[n + PHASES] ? waves->lacks[n] : waves->lacks[n + PHASES];
        phase = most >= ENOUGH ? n + 1 : phase;
        doubted += both_of(waves, n) >= ENOUGH / 2u ? 1 : 0;
    }
    return doubted == 1 ? phase : 0;
}

LODE_NOINLINE lode_open_phase_t lode_half_waves_suspect(const lode_half_waves_t *self) {
    int32_t phase = 0;
    for (int32_t n = 0; n < PHASES; n++) {
        const uint32_t own = both_of(self, n) / 2u;
        const bool most =
            both_of(self, (n + 1) % PHASES) < own && both_of(self, (n + 2) % PHASES) < own;
        phase = most && own >= ENOUGH / 8u ? n + 1 : phase;
    }
    return (lode_open_phase_t)phase;
}

static float length_of(lode_ab_t x) {
    return lode_sqrt(x.alpha * x.alpha + x.beta * x.beta);
}

LODE_NOINLINE lode_open_phase_t lode_half_waves_check(lode_half_waves_t *self,
                                                      const lode_open_phase_tuning_t *tuning,
                                                      const lode_half_waves_seen_t *seen) {
    const float least_A = tuning->least_A;
    const float length_A = length_of(seen->ref_A);
    const float flows_A = length_of(seen->i_A);
    const uint_least16_t step = step_of(tuning, seen->turn_rad);
    if (is_idle(self, length_A < least_A, step)) {
        *self = (lode_half_waves_t){.idle = 0u};
    }
    // If no current flows, control lags in all phases.
    const uint_least16_t counted = flows_A >= least_A ? step : (uint_least16_t)0u;
    const float not_had = NOT_HAD * (float)counted;
    const limits_t limits = {.least_A = least_A,
                             .ref_A = lode_max(LODE_WAVE_REF * length_A, least_A),
                             .seen_A = lode_max(LODE_WAVE_HAS * least_A, LODE_WAVE_LACKS * flows_A),
                             .against_A = lode_max(AGAINST * flows_A, least_A),
                             .kp_V_A = seen->kp_V_A,
                             .step = counted,
                             .not_had = (uint_least16_t)not_had};
    const bool old = lode_abs(seen->turn_rad) > OLD_rad;
    const lode_abc_t ref = lode_clarke_inverse(seen->ref_A);
    const lode_abc_t before = lode_clarke_inverse(old ? seen->ref_A : seen->before_A);
    const lode_abc_t i = lode_clarke_inverse(seen->i_A);
    const lode_abc_t beyond = lode_clarke_inverse(seen->beyond_V);
    const lode_abc_t across = {ACROSS * (beyond.b - beyond.c), ACROSS * (beyond.c - beyond.a),
                               ACROSS * (beyond.a - beyond.b)};
    const phase_t of[PHASES] = {{ref.a, before.a, i.a, beyond.a, across.a},
                                {ref.b, before.b, i.b, beyond.b, across.b},
                                {ref.c, before.c, i.c, beyond.c, across.c}};
    for (int32_t n = 0; n < PHASES; n++) {
        note_phase(self, &limits, n, of[n]);
    }
    self->doubts = is_any(self) ? 1u : 0u;
    return (lode_open_phase_t)alone_of(self);
}
