#include "plausibility_inline.h"

// A phase current of amplitude I stays within I (1 - cos(D/2)) of its peak, about I D^2/8, while the vector turns by D. It
// counts as stuck where that would have been 8 counts and it has not moved by one.
#define STUCK_COUNTS 8.0f
#define STUCK (8.0f * STUCK_COUNTS * (float)LODE_COUNT_FRACTION) // for I D^2, 1/256 count
// If all three stand still, one of them is far from its peak and should have moved by at least I D sqrt(3)/2. The limit is 32
// counts, as a change of the amplitude may cancel a few.
#define ALL_TURN 3.0f // (64/32 sqrt(3)/2)^2
// Below it dead time may hold a phase at zero for as long.
#define STUCK_SHARE 0.05f // of i_max
#define ALL_STUCK 4.0f    // squared: the reference moved by 0.1 i_max from zero, no count did
// Or by 0.05 i_max at a larger current, whose square changes by twice the product of the two.
#define ALL_MOVED 2.0f
// If the current squared changes by more than this share between two checks, that may hold a phase still while the vector
// turns, but hardly for an eighth of a turn.
#define STEADY_SHARE 0.5f
#define EIGHTH_rad 0.7853982f
// A smaller change may do so by chance. Three measured phases tell this from a stuck ADC channel: they still sum to zero within
// their gain errors, until the true current of that channel has moved by more. With one phase computed from the others, a sixth
// of a turn is required, longer than chance lasts.
#define BALANCE_COUNTS 4.0f
#define BALANCE_SHARE 0.02f // of the current: 1.4 times the rms sum error of gains that are 2 % off
#define SIXTH_rad 1.0471976f
// Dead time may hold a phase near zero for up to a sixth of a turn. The other two then sum to zero within their gain errors,
// which they do not if an ADC channel is stuck there. With one phase computed from the others this cannot be told.
#define QUARTER_rad 1.5707963f
#define CLAMPED_SHARE 0.05f // of the current
// Turn that one check adds at most while one or two phases stand still: at high speed the checks are far apart, and a current
// with ripple may have the same count at three of them.
#define COUNTED_MAX_rad 0.2617994f
// Gain errors of 4 %, with the 1.7-fold current of a set with an open phase, make 0.07.
#define OPEN_SHARE 0.2f // of the current
// Largest offset error of a phase without current.
#define OPEN_COUNTS 4.0f
// (K36). Noise of a count in each phase moves a frozen vector by up to 8/3 of a count from where it was noted.
#define FROZEN_COUNTS 3.0f
// The phase that moves most has 32 of these.
#define MOVES_COUNTS 37.0f
// Flag next to the bits of the phases that stand still: the amplitude has changed since then.
#define CHANGING 8u
#define WAVE_CURRENT 4.0f // squared, times the least current: a reference of 0.1 i_max
#define WAVE_SHARE 0.5f   // of the reference
// Turn per round. Faster than that, current control may not hold the current while a rotor falls out of step.
#define WAVE_STEP_rad 0.3f
#define WAVE_TURN_rad 6.9115f // 1.1 turns
#define WAVES_ALL 0x3fu
#define SUM_MAX 1.0e9f // 1/256 count: no ADC has so many

// (S43), squared: a current held within a fifth of its reference for so many rounds falls by a quarter, and at the next check
// is still 0.15 low. With gains of one half, current control has brought it back this far by then.
#define LEAST_HELD 0.64f
#define MOST_HELD 1.44f
#define HELD_ROUNDS 8u
#define FALLEN 0.5625f
#define AWAY 0.7225f
// Rounds, counted from 2, in which current control restores the current and the EMF observer settles.
#define BACK_ROUNDS 5u

#define OFF_SHARE 0.3f // (K49), of i_max

// (K38)
#define JUMP_SHARE 0.05f  // of i_max
#define JUMP_SINE2 0.01f  // squared sine: a gain turns the vector by 5.7 degrees at most
#define JUMP_NONE 0.01f   // squared, of the expected current: nothing is left
#define JUMP_FACTOR 0.25f // a gain closer to 1 does not count
#define JUMP_BACK 0.25f   // squared, of the jump: at the next sample it goes back
// A phase that has opened shows a quarter of its current again: sin(0.35 - 0.1).
#define JUMP_TURN_rad 0.35f
#define JUMP_GONE_PERIODS 127u // time limit for that turn
#define JUMP_REST_PERIODS 62u
#define JUMP_BYTE 255u // largest value of its byte counters

// Range of flux_share, and what no flux exceeds: not checked.
#define FLUX_LEAST 0.1f
#define FLUX_MOST 1.0f
#define FLUX_ANY 1.0e6f
#define OVERLOAD_MAX_s 10.0f
// Share of the acceleration of a free rotor by all the torque (K19): a load that is hardly larger than the torque, or one with
// ripple, may move the speed this fast.
#define AWAY_SHARE 0.1f
// Of rated speed. Gain errors of the current sensors make the estimated speed swing twice per turn, by more than all the torque
// changes that of a heavy rotor in overload_s.
#define AWAY_LEAST 0.05f
// (K42): least time, in overload_s, and speed, of rated. In the time that a free rotor with the configured J takes to rated
// speed, one with ten times J and 0.8 of the passive load at i_max/1.5 gets beyond it.
#define STALL_TIMES 3.0f
#define STALL_SPEED 0.03f
#define ROUNDS_MAX 65535.0f
// (K29), braking: multiple of overload_s, three time constants of a slow PLL, after which a rotor under full braking torque no
// longer seems to get faster; and share of the threshold of (K19), above noise.
#define FASTER_TIMES 2.0f
#define FASTER_SHARE 0.1f
#define FASTER_MAX 65535u

lode_status_t lode_plausibility_tune(lode_plausibility_tuning_t *tuning,
                                     const lode_guard_config_t *config, float i_max_A,
                                     const lode_sense_tuning_t *sense) {
    if (!lode_is_on_or_off(config->plausibility) || !lode_is_on_or_off(config->check_stuck) ||
        !lode_is_on_or_off(config->check_gain) || !lode_is_on_or_off(config->check_half_waves)) {
        return LODE_ERROR_CHOICE;
    }
    const bool flux = !lode_is_none(config->flux_share);
    if (flux && !lode_in_range(config->flux_share, FLUX_LEAST, FLUX_MOST)) {
        return LODE_ERROR_GUARD_FLUX;
    }
    const bool on = config->plausibility == LODE_ON;
#ifdef LODE_WITHOUT_PLAUSIBILITY
    if (on || config->check_stuck == LODE_ON || config->check_gain == LODE_ON ||
        config->check_half_waves == LODE_ON) {
        return LODE_ERROR_CHOICE;
    }
    if (flux) {
        return LODE_ERROR_GUARD_FLUX;
    }
#endif
    const bool sums = !lode_is_none(config->i_sum_A);
    if (sums && !lode_in_range(config->i_sum_A, 1.0e-3f * i_max_A, 10.0f * i_max_A)) {
        return LODE_ERROR_GUARD_CURRENT;
    }
    const float i_min_A = STUCK_SHARE * i_max_A;
    const float i_sum =
        sums ? lode_min(config->i_sum_A / lode_abs(sense->i_gain), SUM_MAX) : SUM_MAX;
    const float count_A = (float)LODE_COUNT_FRACTION * lode_abs(sense->i_gain);
    const float frozen_A = FROZEN_COUNTS * count_A;
    const float moves_A = lode_max(MOVES_COUNTS * count_A, i_min_A);
    *tuning = (lode_plausibility_tuning_t){
        .frozen_A2 = on && config->check_stuck == LODE_ON ? frozen_A * frozen_A : -1.0f,
        .moves_A2 = moves_A * moves_A,
        .i_min_A2 = i_min_A * i_min_A,
        .i_still = 0,
        .i_sum = on ? (int32_t)i_sum : -1,
        .per_wave_A =
            on && config->check_half_waves == LODE_ON ? WAVE_SHARE / lode_abs(sense->i_gain) : 0.0f,
        .flux_share = on && flux ? config->flux_share : FLUX_ANY,
    };
    return LODE_OK;
}

lode_status_t lode_plausibility_tune_load(lode_plausibility_tuning_t *tuning,
                                          const lode_guard_config_t *config, float rise_rad_s2,
                                          float omega_rated_rad_s, float ts_s) {
    const bool none = lode_is_none(config->overload_s);
    if (!none && !lode_in_range(config->overload_s, ts_s, OVERLOAD_MAX_s)) {
        return LODE_ERROR_GUARD_TIME;
    }
#ifdef LODE_WITHOUT_PLAUSIBILITY
    if (!none) {
        return LODE_ERROR_GUARD_TIME;
    }
#endif
    const float round_s = (float)LODE_SLOW_PERIODS * ts_s;
    const bool watched = !none && config->plausibility == LODE_ON;
    const float away_rad_s =
        lode_max(config->overload_s * rise_rad_s2, AWAY_LEAST * omega_rated_rad_s);
    tuning->away_rad_s = watched ? away_rad_s : 0.0f;
    tuning->away_step = AWAY_SHARE * round_s * rise_rad_s2;
    const float rated_s = omega_rated_rad_s / lode_max(rise_rad_s2, FLT_MIN);
    const float stall_s = lode_max(STALL_TIMES * config->overload_s, rated_s);
    const float rounds = lode_clamp(stall_s / round_s, 1.0f, ROUNDS_MAX);
    tuning->stall_rad_s = STALL_SPEED * omega_rated_rad_s;
    tuning->stall_rounds = watched ? (uint32_t)rounds : 0u;
    return LODE_OK;
}

void lode_plausibility_tune_voltages(lode_plausibility_tuning_t *tuning,
                                     const lode_guard_config_t *config, float i_max_A,
                                     float i_max_V, float taken_V) {
    const bool on = config->plausibility == LODE_ON;
    const float jump_V = JUMP_SHARE * i_max_V;
    const float taken = taken_V / i_max_V;
    const float off_A = lode_max(OFF_SHARE, taken) * i_max_A;
    tuning->taken_V = taken_V;
    tuning->jump_V2 = on && config->check_gain == LODE_ON ? jump_V * jump_V : FLT_MAX;
    tuning->off_A2 = on ? off_A * off_A : FLT_MAX;
}

// (K29). The step of (K19) is AWAY_SHARE of a free rotor's change of speed by all the torque in a round.
static bool is_faster_for_long(const lode_load_t *self, const lode_plausibility_tuning_t *tuning) {
    return (float)self->faster * tuning->away_step >=
           FASTER_TIMES * AWAY_SHARE * tuning->away_rad_s;
}

bool lode_load_is_too_large(lode_load_t *self, const lode_plausibility_tuning_t *tuning,
                            float sense, float omega_rad_s) {
    const float away = sense * (self->held_rad_s - omega_rad_s);
    if (!(away > 0.0f)) {
        self->held_rad_s = omega_rad_s;
        self->faster = 0u;
        return false;
    }
    if (!(sense * omega_rad_s < 0.0f)) { // the rotor slows down
        self->held_rad_s -= sense * lode_min(away, tuning->away_step);
        self->faster = 0u;
        return away > tuning->away_rad_s;
    }
    if (self->faster < FASTER_MAX) {
        self->faster++;
    }
    const float share = is_faster_for_long(self, tuning) ? FASTER_SHARE : 1.0f;
    return away > share * tuning->away_rad_s;
}

bool lode_load_stalls(lode_load_t *self, const lode_plausibility_tuning_t *tuning,
                      float omega_rad_s, float missing_rad_s) {
    const bool stands =
        lode_abs(omega_rad_s) < tuning->stall_rad_s && missing_rad_s > tuning->stall_rad_s;
    self->stalled = stands ? (uint_least16_t)(self->stalled + 1u) : 0u;
    return stands && self->stalled >= tuning->stall_rounds;
}

void lode_plausibility_reset(lode_plausibility_t *self) {
    *self = (lode_plausibility_t){.i = {0, 0, 0}};
}

static int32_t sum_of(const int32_t i[LODE_PHASES]) {
    return i[0] + i[1] + i[2];
}

// The three currents sum to zero, within counts and, for their gain errors, a share of the current.
static bool is_balanced(const lode_plausibility_t *self, float share, float A_per_count) {
    const float counts = BALANCE_COUNTS * (float)LODE_COUNT_FRACTION;
    const float beyond = lode_max(lode_abs((float)sum_of(self->i)) - counts, 0.0f);
    const float beyond_A = beyond * A_per_count;
    return beyond_A * beyond_A <= share * share * self->i_A2;
}

// Dead time may be what holds the only phase near zero, if the voltage that the current requires there is less than dead time
// takes. The other two then change together, or not at all at their peak.
static bool is_clamped(const lode_plausibility_t *self, const lode_plausibility_tuning_t *tuning,
                       uint32_t still, lode_hold_t hold, float A_per_count) {
    const int32_t *i = self->i;
    const float i_A2 = self->i_A2;
    const float near = lode_sqrt(tuning->i_min_A2) / A_per_count;
    const uint32_t at_zero =
        lode_plausibility_phases(lode_abs((float)i[0]) <= near, lode_abs((float)i[1]) <= near,
                                 lode_abs((float)i[2]) <= near);
    const bool one = at_zero != 0u && (at_zero & (at_zero - 1u)) == 0u;
    return one && (still == at_zero || still == LODE_ALL_PHASES) &&
           hold.x_Ohm * hold.x_Ohm * i_A2 <= hold.taken_V * hold.taken_V &&
           is_balanced(self, CLAMPED_SHARE, A_per_count);
}

// Turn for which a single phase may keep its count without being stuck.
static float least_rad(const lode_plausibility_t *self, bool changes, bool clamped,
                       float A_per_count) {
    if (clamped) {
        return QUARTER_rad;
    }
    const float changed_rad = changes ? EIGHTH_rad : 0.0f;
    return is_balanced(self, BALANCE_SHARE, A_per_count) ? SIXTH_rad : changed_rad;
}

// The vector has turned far enough, while some phases kept their counts, to show one of them as stuck.
static bool shows_one(const lode_plausibility_t *self, float A_per_count) {
    const float turn2 = self->turn_rad * self->turn_rad;
    const float stuck_A = STUCK * A_per_count;
    return turn2 * turn2 * self->i_A2 > stuck_A * stuck_A;
}

// The same for all three phases.
static bool all_turned(float i_A2, float turn_rad, float A_per_count) {
    const float stuck_A = STUCK * A_per_count;
    return ALL_TURN * turn_rad * turn_rad * i_A2 > stuck_A * stuck_A;
}

bool lode_plausibility_none_flows(const lode_plausibility_tuning_t *tuning, float i_A2,
                                  float turn_rad, float A_per_count) {
    return i_A2 > tuning->i_min_A2 && all_turned(i_A2, turn_rad, A_per_count);
}

// Phases that have kept their counts over such a turn and that only a stuck ADC channel explains.
static uint32_t stuck_phases(const lode_plausibility_t *self,
                             const lode_plausibility_tuning_t *tuning, uint32_t still,
                             lode_hold_t hold, float A_per_count) {
    if (still == 0u) {
        return 0u;
    }
    const float turn_rad = lode_abs(self->turn_rad);
    const bool changes = (self->still & CHANGING) != 0u;
    const bool clamped = is_clamped(self, tuning, still, hold, A_per_count);
    if (still == LODE_ALL_PHASES) {
        const bool waits = changes && turn_rad < EIGHTH_rad;
        return waits || (clamped && !shows_one(self, A_per_count)) ? 0u : still;
    }
    return turn_rad >= least_rad(self, changes, clamped, A_per_count) ? still : 0u;
}

// Number of the first of the phases, from 1; 0: all three.
static float number_of(uint32_t phases) {
    if (phases == LODE_ALL_PHASES) {
        return 0.0f;
    }
    return (phases & 1u) != 0u ? 1.0f : ((phases & 2u) != 0u ? 2.0f : 3.0f);
}

uint_least8_t lode_waves_step(lode_waves_t *self, const lode_plausibility_tuning_t *tuning,
                              const int32_t i[LODE_PHASES], float i_A2, float turn_rad) {
    if (!(i_A2 >= WAVE_CURRENT * tuning->i_min_A2) || !(lode_abs(turn_rad) <= WAVE_STEP_rad)) {
        *self = (lode_waves_t){.turn_rad = 0.0f};
        return 0u;
    }
    const int32_t least = (int32_t)lode_min(lode_sqrt(i_A2) * tuning->per_wave_A, SUM_MAX);
    const uint32_t up = lode_plausibility_phases(i[0] > least, i[1] > least, i[2] > least);
    const uint32_t down = lode_plausibility_phases(i[0] < -least, i[1] < -least, i[2] < -least);
    const uint32_t seen = self->seen | up | down << LODE_PHASES;
    self->seen = (uint_least8_t)seen;
    self->turn_rad += turn_rad;
    if (lode_abs(self->turn_rad) < WAVE_TURN_rad) {
        return 0u;
    }
    const uint32_t lacking = WAVES_ALL & ~seen;
    const uint32_t twice = lacking & self->lacking;
    *self = (lode_waves_t){.lacking = (uint_least8_t)lacking};
    const uint32_t phases = LODE_ALL_PHASES & (twice | twice >> LODE_PHASES);
    return (uint_least8_t)(phases > 0u ? number_of(phases) : 0.0f);
}

void lode_drop_check(lode_drop_t *self, float i_A2) {
    if (self->rounds == 1u) {
        self->rounds = i_A2 < AWAY * self->i_A2 ? 2u : 0u;
    } else if (self->rounds == 0u && self->held >= HELD_ROUNDS && i_A2 < FALLEN * self->i_A2) {
        self->rounds = 1u;
    } else {
        // the current is there, or its fall is already noted
    }
}

bool lode_drop_step(lode_drop_t *self, float i_A2, float ref_A2, lode_dq_t e_V, float *change_V) {
    lode_drop_check(self, i_A2);
    const uint32_t since = self->rounds;
    if (since > 0u && since <= BACK_ROUNDS) {
        self->rounds = (uint_least8_t)(since > 1u ? since + 1u : since);
        return false;
    }
    const bool held = lode_in_range(i_A2, LEAST_HELD * ref_A2, MOST_HELD * ref_A2);
    const bool back = since > 0u && i_A2 > AWAY * self->i_A2;
    const uint32_t before = self->held;
    const uint32_t rounds = back || !held ? 0u : before + 1u;
    if (back) { // spares the root otherwise
        const lode_ab_t change = {e_V.d - self->e_V.d, e_V.q - self->e_V.q};
        *change_V = lode_ab_length(change);
    }
    self->e_V = e_V;
    self->i_A2 = i_A2;
    self->held = (uint_least8_t)(rounds < HELD_ROUNDS ? rounds : HELD_ROUNDS);
    self->rounds = 0u;
    return back;
}

bool lode_frozen_check(lode_frozen_t *self, const lode_plausibility_tuning_t *tuning,
                       lode_ab_t ref_A) {
    const uint32_t before = self->checks;
    if (before == 0u) {
        self->ref_A = ref_A;
        self->way_A = (lode_ab_t){0.0f, 0.0f};
    }
    self->checks = (uint_least16_t)(before < LODE_FROZEN_CHECKS ? before + 1u : before);
    const lode_ab_t way_A = lode_ab_subtract(ref_A, self->ref_A);
    const bool moved = lode_ab_length2(way_A) >= tuning->moves_A2;
    // Control moves the current within one interval. A reference that goes the other way meanwhile may meet it on its way back.
    const bool same_way = way_A.alpha * self->way_A.alpha + way_A.beta * self->way_A.beta > 0.0f;
    self->way_A = moved ? way_A : (lode_ab_t){0.0f, 0.0f};
    return moved && same_way;
}

bool lode_frozen_turned(const lode_frozen_t *self, float turn_rad) {
    return ((float)self->checks - 1.0f) * lode_abs(turn_rad) >= LODE_TWO_PI;
}

// Gain: measured over expected current. Negative: close to 1, or the vector has turned.
static float factor_of(lode_ab_t i_A, lode_ab_t expected_A) {
    const float i_A2 = lode_ab_length2(i_A);
    const float expected_A2 = lode_ab_length2(expected_A);
    if (i_A2 < JUMP_NONE * expected_A2) {
        return 0.0f;
    }
    const float along = i_A.alpha * expected_A.alpha + i_A.beta * expected_A.beta;
    const float across = i_A.alpha * expected_A.beta - i_A.beta * expected_A.alpha;
    const bool same = along > 0.0f && across * across <= JUMP_SINE2 * i_A2 * expected_A2;
    const float factor = along / lode_max(expected_A2, FLT_MIN);
    return same && lode_abs(factor - 1.0f) >= JUMP_FACTOR ? factor : -1.0f;
}

static void enter_jump(lode_jump_t *self, lode_jump_stage_t stage) {
    self->stage = (uint_least8_t)stage;
    self->periods = 0u;
}

bool lode_jump_check(lode_jump_t *self, lode_ab_t i_A, lode_ab_t expected_A, float size,
                     bool starts) {
    if (self->stage == (uint_least8_t)LODE_JUMP_SECOND && size >= JUMP_BACK * (float)self->size) {
        enter_jump(self, LODE_JUMP_RESTS); // one bad sample, or an unmodelled voltage
        return true;
    }
    const float factor = factor_of(i_A, expected_A);
    if (self->stage != (uint_least8_t)LODE_JUMP_NONE || factor < 0.0f ||
        (starts && factor > 1.0f)) {
        return false;
    }
    const float steps = lode_min(factor * (float)LODE_JUMP_ONE, (float)JUMP_BYTE);
    self->factor = (uint_least8_t)steps;
    self->size = (uint_least8_t)lode_min(size, (float)JUMP_BYTE);
    enter_jump(self, LODE_JUMP_NEW);
    return true;
}

// A lost current has not come back while the vector turned far enough.
static bool is_gone_for_good(lode_jump_t *self, float turn_rad, bool gone) {
    self->periods = (uint_least8_t)(self->periods + 1u);
    if (!gone || self->periods > JUMP_GONE_PERIODS) {
        enter_jump(self, LODE_JUMP_RESTS);
        return false;
    }
    return (float)self->periods * turn_rad >= JUMP_TURN_rad;
}

float lode_jump_wait(lode_jump_t *self, float turn_rad, bool gone) {
    switch ((lode_jump_stage_t)self->stage) {
    case LODE_JUMP_NEW:
        enter_jump(self, LODE_JUMP_SECOND);
        return -1.0f;
    case LODE_JUMP_SECOND:
        if (self->factor > 0u) {
            return (float)self->factor / (float)LODE_JUMP_ONE;
        }
        enter_jump(self, LODE_JUMP_GONE);
        return is_gone_for_good(self, turn_rad, gone) ? 0.0f : -1.0f;
    case LODE_JUMP_GONE:
        return is_gone_for_good(self, turn_rad, gone) ? 0.0f : -1.0f;
    case LODE_JUMP_RESTS:
    case LODE_JUMP_NONE:
    default:
        self->periods = (uint_least8_t)(self->periods + 1u);
        if (self->periods >= JUMP_REST_PERIODS) {
            enter_jump(self, LODE_JUMP_NONE);
        }
        return -1.0f;
    }
}

// With an open phase the other two currents sum to zero within their gain errors, with a stuck ADC channel they do not.
static bool is_open_balanced(const int32_t i[LODE_PHASES], float i_A2, float A_per_count) {
    const float sum_A = (float)sum_of(i) * A_per_count;
    return sum_A * sum_A <= OPEN_SHARE * OPEN_SHARE * i_A2;
}

// Phases that have kept their count `again` and should not have. Without current, or at the check at which the reference
// appears, an unchanged count says nothing; nor does that of a phase that may be open.
LODE_INLINE uint32_t judged_phases(const lode_plausibility_t *self,
                                   const lode_plausibility_tuning_t *tuning, uint32_t again,
                                   float i_A2, float A_per_count) {
    const int32_t *i = self->i;
    const bool may_be_open = tuning->i_still > 0 && is_open_balanced(i, i_A2, A_per_count);
    const int32_t least = may_be_open ? tuning->i_still : 0;
    const bool enough = i_A2 > tuning->i_min_A2 && self->i_A2 > tuning->i_min_A2;
    const uint32_t flows =
        lode_plausibility_phases(i[0] >= least || i[0] <= -least, i[1] >= least || i[1] <= -least,
                                 i[2] >= least || i[2] <= -least);
    return enough ? again & flows : 0u;
}

// Change of the squared reference that no current follows. At a large current a small change of the reference makes a large one
// of its square, and the EMF of a rotor that swings may hold the current for so long.
static float moved_most_A2(const lode_plausibility_tuning_t *tuning, float i_A2) {
    return lode_max(ALL_STUCK * tuning->i_min_A2, ALL_MOVED * lode_sqrt(tuning->i_min_A2 * i_A2));
}

// At least three checks, as two may lie on either side of a peak.
uint32_t lode_plausibility_doubt(lode_plausibility_t *self,
                                 const lode_plausibility_tuning_t *tuning, uint32_t again,
                                 float i_A2, float turn_rad, float A_per_count) {
    const float change_A2 = lode_abs(i_A2 - self->i_A2);
    const uint32_t still = judged_phases(self, tuning, again, i_A2, A_per_count) & self->still;
    const bool changes = (self->still & CHANGING) != 0u || !(change_A2 <= STEADY_SHARE * i_A2);
    const bool all = again == LODE_ALL_PHASES;
    const bool none_follows = all && self->moved_A2 > moved_most_A2(tuning, i_A2);
    self->moved_A2 = all ? self->moved_A2 + change_A2 : 0.0f;
    self->i_A2 = i_A2;
    const float counted_rad = still == LODE_ALL_PHASES
                                  ? turn_rad
                                  : lode_clamp(turn_rad, -COUNTED_MAX_rad, COUNTED_MAX_rad);
    self->turn_rad = still > 0u ? self->turn_rad + counted_rad : 0.0f;
    self->still = (uint_least8_t)(still > 0u ? still + (changes ? CHANGING : 0u) : self->kept);
    const bool turned = still == LODE_ALL_PHASES ? all_turned(i_A2, self->turn_rad, A_per_count)
                                                 : shows_one(self, A_per_count);
    return (turned ? still : 0u) + (none_follows ? LODE_NONE_FOLLOWS : 0u);
}

void lode_plausibility_add(lode_plausibility_t *self, const lode_plausibility_tuning_t *tuning,
                           float share) {
    self->moved_A2 += share * moved_most_A2(tuning, self->i_A2);
}

// With a channel stuck at zero, its true current would be missing in the sum.
bool lode_plausibility_is_open(const lode_plausibility_t *self, uint32_t phase, float A_per_count) {
    const float most = OPEN_COUNTS * (float)LODE_COUNT_FRACTION;
    return phase >= 1u && phase <= (uint32_t)LODE_PHASES &&
           lode_abs((float)self->i[phase - 1u]) <= most &&
           is_balanced(self, CLAMPED_SHARE, A_per_count);
}

lode_finding_t lode_plausibility_find(lode_plausibility_t *self,
                                      const lode_plausibility_tuning_t *tuning, uint32_t doubt,
                                      uint32_t sum_checks, lode_hold_t hold, float A_per_count) {
    const uint32_t stuck = stuck_phases(self, tuning, doubt & LODE_ALL_PHASES, hold, A_per_count);
    const bool none_follows = (doubt & LODE_NONE_FOLLOWS) != 0u;
    if (none_follows || stuck > 0u) {
        const float which = none_follows ? 0.0f : number_of(stuck);
        return (lode_finding_t){LODE_CHECK_CURRENT_STUCK, which, 0.0f};
    }
    if (lode_plausibility_sum_ok(tuning, self->i)) {
        self->sum = self->sum > 0u ? (uint_least16_t)(self->sum - 1u) : 0u;
    } else {
        self->sum = (uint_least16_t)(self->sum + 1u);
        if (self->sum >= sum_checks) {
            const float sum = (float)sum_of(self->i);
            return (lode_finding_t){LODE_CHECK_CURRENT_SUM, sum * A_per_count,
                                    (float)tuning->i_sum * A_per_count};
        }
    }
    return (lode_finding_t){LODE_CHECK_NONE, 0.0f, 0.0f};
}
