#include "estimator_inline.h"
#include "start_inline.h"
#include "start_parts.h"

#define CATCH_PARTS 5u // while catching, the lock must hold for catch_rounds over this
// Current that is left at the end of an attempt at speed without a lock (S17): share of the attempt's current or of
// twice the start current, whichever is smaller. It takes less than a third of a salient rotor's flux.
#define CURRENT_LEFT 0.3f
// Least weight of the EMF's magnitude in the swing signal (S19). A rotor that needs so much current lags by 90 degrees.
// There the load angle cancels from the weighted mean at the weight 1/(1 + c), with c = (Lq - Ld) I/psi of about 1.
#define BY_SIZE_MIN 0.5f
// Last attempt (S32): where the vector takes at most all of the flux (plus 1 % for rounding), a round with a lock
// counts twice, and the speed may differ from the vector's by twice as much.
#define LOST_LAST 1.01f
#define WEIGHT_LAST 2u
// (S42): a rotor that follows has at least SLIP_SHARE of its EMF: 0.75 at the lowest speed that (S8) allows, 0.6 if magnets
// and current sensors are each a tenth off. With both inductances 20 % off the current takes SLIP_LOST times the share of the
// flux that is calculated. Where less than SLIP_FLUX is left, following cannot be told from slipping.
#define SLIP_SHARE 0.6f
#define SLIP_LOST 1.4f
#define SLIP_FLUX 0.2f
// A rotor slips if it lacks this EMF for more than patience_rounds/SLIP_PART and for SLIP_rad radians of its natural
// swing, which is half a swing with ten times the inertia.
#define SLIP_PART 2u
#define SLIP_rad 10.0f
#define SLIPS_MAX 65535u
// current_last_A over current_A from which a slip makes the next attempt take current_last_A at once (S42). A round
// rotor's ratio, at most 1/CURRENT_SHARE = 1.43, stays below.
#define MUCH_MORE 1.5f

// Measurement at rest: mean of 20 ms in which the rotor rests, after 10 ms in which observer and current settle.
#define CALM_PART 20u   // patience_rounds over this: 20 ms
#define SETTLE_PART 15u // dwell_rounds over this: 10 ms
// Largest deviation of the voltage along the vector from its mean, in calm_V, for the first and second half of the
// dwell. If the rotor does not come to rest, the voltage must stay within it for STEADY_TIMES the time of a calm mean
// and STEADY_rad radians of the swing, in which a falling rotor passes 90 degrees (S30).
#define STEADY_EARLY 0.5f
#define STEADY_LATE 2.0f
#define STEADY_TIMES 2u
#define STEADY_rad 2.0f
// Weights of the two means in (S33): calm_V over their standard deviation, squared. A mean is sure if the rotor is at rest.
// At half of the current it is so only after SWUNG_rad of its natural swing: until then it may move slowly.
#define WEIGHT_SURE 16.0f
#define WEIGHT_LOOSE 0.44f
#define SWUNG_rad 5.0f

// Enters a stage and clears what the previous one measured: both share a union.
static void enter(lode_start_t *self, uint_least8_t stage) {
    self->stage = stage;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    self->drop = (lode_drop_t){.rounds = 0u};
#endif
    if (stage == (uint_least8_t)LODE_START_TURN) {
#ifndef LODE_WITHOUT_PLAUSIBILITY // only the plausibility checks use these
        self->seen.turn.waves = (lode_waves_t){.turn_rad = 0.0f};
        const float shift_rad = lode_start_shift_rad(self);
        self->seen.turn.shift_rad[0] = shift_rad;
        self->seen.turn.shift_rad[1] = shift_rad;
#endif
    } else {
        self->seen.rest = (lode_start_rest_t){.sum_V = 0.0f};
    }
}

void lode_start_reset(lode_start_t *self, lode_sincos_t at, float omega_rad_s, float current_A) {
    *self = (lode_start_t){.at = at,
                           .omega_rad_s = omega_rad_s,
                           .current_A = current_A,
                           .omega_target = omega_rad_s,
                           .current_target = current_A};
    enter(self, (uint_least8_t)LODE_START_TURN);
}

// Gain of the damping with its bounds (S15), (S16), and what it takes for a swing (S19).
static void set_damping(lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float most =
        lode_min(tuning->damping_A / lode_max(self->current_A, FLT_MIN),
                 tuning->damping_rad_s / lode_max(lode_abs(self->omega_rad_s), FLT_MIN));
    self->give = lode_min(tuning->damping, most);
    const float speed = self->omega_rad_s / (LODE_START_HOLD * tuning->omega_ready);
    self->by_size = lode_clamp(speed, -1.0f, 1.0f) *
                    lode_max(1.0f - tuning->lost_per_A * self->current_A, BY_SIZE_MIN);
}

void lode_start_settle(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V) {
    set_damping(self, tuning);
    self->mean_V = lode_start_across_V(self, e_V);
    self->swing_V = 0.0f;
}

// Stage that follows the measurement, or begins an attempt without one (S47).
static uint_least8_t last_stage(const lode_start_tuning_t *tuning) {
    return (uint_least8_t)(tuning->align_rounds > 0.0f ? LODE_START_ALIGN : LODE_START_TURN);
}

// First stage of an attempt that does not begin by catching a turning rotor.
static uint_least8_t first_stage(const lode_start_tuning_t *tuning) {
#ifndef LODE_WITHOUT_START_MEASUREMENT
    if (tuning->dwell_rounds > 0u) {
        return (uint_least8_t)LODE_START_HALF;
    }
#endif
    return last_stage(tuning);
}

void lode_start_begin(lode_start_t *self, const lode_start_tuning_t *tuning) {
    lode_start_reset(self, (lode_sincos_t){0.0f, 1.0f}, 0.0f, 0.0f);
    self->attempt = tuning->catch_rounds;
    enter(self, self->attempt > 0u ? (uint_least8_t)LODE_START_CATCH : first_stage(tuning));
}

void lode_start_lead(lode_start_t *self, lode_sincos_t axis, float direction) {
    const lode_sincos_t ahead = {lode_sign(direction) * 0.5f * LODE_SQRT3, -0.5f}; // 120 degrees
    self->at = lode_angle_add(axis, ahead);
    self->stands = 1u;
}

static float profile_rounds(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float step = lode_start_ease(self) * tuning->omega_step;
    const float omega = lode_max(lode_abs(self->omega_target), tuning->omega_handover);
    const float rise = tuning->current_A / tuning->current_step;
    const float later = self->failed > 0u ? (1.0f / LODE_START_LATER_RISE - 1.0f) * rise : 0.0f;
    return tuning->still_rounds + (omega / step + later) / (float)LODE_SLOW_PERIODS;
}

// Rounds for which an attempt waits for its lock after the profile (S9).
static float waiting_rounds(const lode_start_tuning_t *tuning, float profile) {
    return lode_max(profile, (float)tuning->patience_rounds);
}

float lode_start_waited(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float profile = profile_rounds(self, tuning);
    const float late = (float)(int32_t)self->attempt - profile;
    return lode_clamp(late / waiting_rounds(tuning, profile), 0.0f, 1.0f);
}

// Reference of the current in the present stage: half of it for the first measurement, then all of it. At hand-over
// speed it falls as long as no lock is found (S17).
static float current_now_A(const lode_start_t *self, const lode_start_tuning_t *tuning,
                           float most_A) {
#ifndef LODE_WITHOUT_START_MEASUREMENT
    if (self->stage == (uint_least8_t)LODE_START_HALF) {
        return LEVEL_SHARE * most_A;
    }
#endif
    if (lode_abs(self->omega_rad_s) < tuning->omega_handover) {
        return most_A;
    }
    const float left_A = CURRENT_LEFT * lode_min(most_A, CURRENT_LAST * tuning->current_A);
    return most_A - lode_start_waited(self, tuning) * (most_A - left_A);
}

// Radians omega_n t of the rotor's swing in so many rounds. swing_weight is nearly SWING_CORNER omega_n Ts.
static float swung_rad(const lode_start_tuning_t *tuning, float rounds) {
    return rounds * (float)LODE_SLOW_PERIODS / SWING_CORNER * tuning->swing_weight;
}

static bool slips(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    return SLIP_PART * (uint32_t)self->slips > tuning->patience_rounds &&
           swung_rad(tuning, (float)(int32_t)self->slips) >= SLIP_rad;
}

void lode_start_note_slip(lode_start_t *self, const lode_start_tuning_t *tuning,
                          const lode_estimator_t *estimator,
                          const lode_estimator_tuning_t *estimator_tuning) {
    const float vector_rad_s = lode_sign(self->omega_target) * self->omega_rad_s;
    const float left = 1.0f - SLIP_LOST * tuning->lost_per_A * self->current_A;
    if (!(vector_rad_s >= tuning->omega_ready && left >= SLIP_FLUX)) {
        return;
    }
    // Undoes the observer's attenuation of an EMF that turns with the vector.
    const float taken = lode_estimator_droop(estimator_tuning, vector_rad_s);
    const float emf_V = taken * lode_ab_length(estimator->emf.observer.e_V);
    if (!(emf_V >= SLIP_SHARE * left * vector_rad_s * estimator_tuning->psi_Wb)) {
        self->slips = (uint_least16_t)(self->slips < SLIPS_MAX ? self->slips + 1u : SLIPS_MAX);
    } else if (self->slips > 0u) {
        self->slips--;
    } else {
        // it follows
    }
}

bool lode_start_is_lost(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    return self->failed >= LODE_START_FAILED_MAX && slips(self, tuning);
}

// Counts a round. True: the time of the attempt is over (S9), or the rotor slips (S42).
static bool is_spent(lode_start_t *self, const lode_start_tuning_t *tuning) {
    if (!(lode_abs(self->omega_target) > 0.0f)) {
        self->attempt = 0u;
        self->slips = 0u;
        return false;
    }
    self->attempt++;
    const float rounds = (float)(int32_t)self->attempt;
    if (rounds <= tuning->still_rounds) {
        return false; // still in the profile; saves a division
    }
    if (slips(self, tuning)) {
        return true;
    }
    const float profile = profile_rounds(self, tuning);
    return rounds > profile + waiting_rounds(tuning, profile);
}

// A rotor that fell out of step with the turning vector only shakes. The next attempt begins at rest, on a phase axis
// for the measurement, 120 degrees ahead of where the first one began (S41). After a slip it takes the last attempt's
// current at once, if that is much more (S42).
void lode_start_again(lode_start_t *self, const lode_start_tuning_t *tuning) {
    const bool much = tuning->current_last_A > MUCH_MORE * tuning->current_A;
    self->more = much && slips(self, tuning) ? 1u : 0u;
    self->attempt = 0u;
    self->slips = 0u;
    self->at = (lode_sincos_t){lode_sign(self->omega_target) * 0.5f * LODE_SQRT3, -0.5f};
    self->omega_rad_s = 0.0f;
    self->current_A = 0.0f;
    self->stands = 0u; // the rotor may be at any angle now
    self->failed = self->failed == 0u ? 1u : LODE_START_FAILED_MAX;
    enter(self, first_stage(tuning));
}

#ifndef LODE_WITHOUT_START_MEASUREMENT

// (S33): most likely voltages of resistance and dead time at all of the current, given the means at half of it and at all of
// it, and how well both are known without them.
static lode_start_found_t found_at_rest(const lode_start_t *self,
                                        const lode_start_tuning_t *tuning) {
    const lode_start_rest_t *rest = &self->seen.rest;
    const float half_V = rest->half_weight * rest->half_V;
    const float full_V = rest->weight * rest->sum_V;
    const float by_r = LEVEL_SHARE * half_V + full_V;
    const float by_dead = half_V + full_V;
    const float both = LEVEL_SHARE * rest->half_weight + rest->weight;
    const float r = tuning->r_known + LEVEL_SHARE * LEVEL_SHARE * rest->half_weight + rest->weight;
    const float dead = tuning->dead_known + rest->half_weight + rest->weight;
    const float per = 1.0f / (r * dead - both * both);
    return (lode_start_found_t){.r_Ohm = per * (by_r * dead - by_dead * both) / self->current_A,
                                .dead_V = per * (by_dead * r - by_r * both)};
}

// Adds the voltage of one round, in the frame of the axis at which the vector waits: dead time acts along this phase
// axis wherever the damping has turned the vector. A rotor that falls past 90 degrees has its growing EMF along the
// axis and none across it; then the sum starts again. In the second half of the dwell the limit is wide enough for the
// ripple of a rotor that swings (S30).
static void add_at_rest(lode_start_rest_t *rest, const lode_start_tuning_t *tuning,
                        lode_dq_t axis_V) {
    const bool late = rest->dwelt > tuning->dwell_rounds / 2u;
    const float steady_V = (late ? STEADY_LATE : STEADY_EARLY) * tuning->calm_V;
    if (lode_abs(axis_V.d * rest->summed - rest->sum_V) > steady_V * rest->summed) {
        rest->sum_V = 0.0f;
        rest->summed = 0.0f;
        rest->calm = 0u;
    }
    rest->sum_V += axis_V.d;
    rest->summed += 1.0f;
    rest->calm = (uint_least16_t)(rest->calm + (lode_abs(axis_V.q) <= tuning->calm_V ? 1u : 0u));
}

// Ends the dwell at the present current with a mean of this weight; 0: without. The vector waits at both currents in any
// case: the rotor has to follow all of the current, and needs time to come to rest.
static LODE_NOINLINE void end_dwell(lode_start_t *self, const lode_start_tuning_t *tuning,
                                    float weight) {
    lode_start_rest_t *rest = &self->seen.rest;
    const bool known = weight > 0.0f;
    const float mean_V = rest->sum_V / lode_max(rest->summed, 1.0f);
    if (self->stage == (uint_least8_t)LODE_START_HALF) {
        enter(self, (uint_least8_t)(known ? LODE_START_FULL : LODE_START_ALONE));
        rest->half_V = known ? mean_V : 0.0f;
        rest->half_weight = weight;
    } else if (known || self->stage == (uint_least8_t)LODE_START_FULL) {
        rest->sum_V = mean_V;
        rest->weight = weight;
        // Not by enter(): both means are still needed.
        self->stage = (uint_least8_t)LODE_START_FOUND;
    } else {
        enter(self, last_stage(tuning));
    }
}

// The mean is known although the rotor still swings (S30).
static bool is_steady(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float summed = self->seen.rest.summed;
    const uint32_t least = STEADY_TIMES * (tuning->patience_rounds / CALM_PART);
    return summed >= (float)least && swung_rad(tuning, summed) >= STEADY_rad;
}

// Weight of the mean at the present current; 0: the rotor moves. `calm`: for 20 ms there was no EMF across the vector.
static float weight_of(const lode_start_t *self, const lode_start_tuning_t *tuning, bool calm) {
    const bool sure = self->stage != (uint_least8_t)LODE_START_HALF ||
                      swung_rad(tuning, (float)self->seen.rest.dwelt) >= SWUNG_rad;
    if (calm && sure) {
        return WEIGHT_SURE;
    }
    return calm || is_steady(self, tuning) ? WEIGHT_LOOSE : 0.0f;
}

// One round at the present current. The result is computed in the next round, to spread the load.
static void watch_at_rest(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V) {
    lode_start_rest_t *rest = &self->seen.rest;
    rest->dwelt++;
    if (SETTLE_PART * rest->dwelt > tuning->dwell_rounds) {
        add_at_rest(rest, tuning, lode_park(e_V, self->at));
    }
    const bool calm = CALM_PART * (rest->calm + 1u) > tuning->patience_rounds;
    if (calm || rest->dwelt >= tuning->dwell_rounds) {
        end_dwell(self, tuning, weight_of(self, tuning, calm));
    }
}

bool lode_start_measure(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V,
                        lode_start_found_t *found) {
    if (self->stage == (uint_least8_t)LODE_START_FOUND) {
        *found = found_at_rest(self, tuning);
        enter(self, last_stage(tuning));
        return true;
    }
    if (self->stage < (uint_least8_t)LODE_START_ALIGN && self->current_A > 0.0f &&
        !(self->current_A < self->current_target)) {
        watch_at_rest(self, tuning, e_V);
    }
    return false;
}

#endif

// Share of the steepest ramp for the present speed (S35). To stop, the vector keeps the attempt's ramp: the rotor
// follows it already.
static float ramp_share(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float ease = lode_start_ease(self);
#ifdef LODE_WITHOUT_GENTLE_START
    (void)tuning;
    return ease;
#else
    const float at_rest = tuning->omega_handover * (1.0f / STEEP);
    const float gentle = tuning->steepens * (at_rest + lode_abs(self->omega_rad_s));
    return lode_abs(self->omega_target) > 0.0f ? lode_min(ease, gentle) : ease;
#endif
}

// Counts a round in which the vector stands at its axis with all of its current (S47). Such rounds do not count towards
// the attempt's time, and only the first attempt aligns.
static bool aligns(lode_start_t *self, const lode_start_tuning_t *tuning) {
    if (self->stage != (uint_least8_t)LODE_START_ALIGN || self->current_A < self->current_target) {
        return false;
    }
    lode_start_rest_t *rest = &self->seen.rest;
    rest->dwelt++;
    if (self->failed > 0u || (float)rest->dwelt >= tuning->align_rounds) {
        enter(self, (uint_least8_t)LODE_START_TURN);
    }
    return true;
}

bool lode_start_aim(lode_start_t *self, const lode_start_tuning_t *tuning, float omega_target_rad_s,
                    float current_A) {
    float most_A = current_A;
    self->omega_target = omega_target_rad_s;
    if (current_A > 0.0f) {
        const bool more = self->failed >= LODE_START_FAILED_MAX || self->more != 0u;
        most_A = more ? tuning->current_last_A : current_A;
    } else {
        self->stands = 0u;
        if (self->stage < (uint_least8_t)LODE_START_TURN) {
            enter(self, (uint_least8_t)LODE_START_TURN); // a stop ends what runs at rest
        }
    }
    self->current_target = current_now_A(self, tuning, most_A);
    // Whatever it has become, it is not beyond that of the last attempt.
    self->current_A = lode_min(self->current_A, tuning->current_last_A);
    self->omega_step = tuning->omega_step * ramp_share(self, tuning);
    // Removes the rounding error of the rotations since the last call.
    self->at = lode_angle_normalise(self->at);
    set_damping(self, tuning);
    return !aligns(self, tuning) && is_spent(self, tuning);
}

// Weight of a round with a lock on the vector (S32): with no attempt left, a lock that is lost again is no worse than none.
static uint32_t lock_weight(const lode_start_t *self, const lode_start_tuning_t *tuning) {
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    if (self->failed >= LODE_START_FAILED_MAX && !lode_start_catches(self) &&
        tuning->lost_per_A * tuning->current_last_A <= LOST_LAST) {
        return WEIGHT_LAST;
    }
#else
    (void)self;
    (void)tuning;
#endif
    return 1u;
}

void lode_start_judge(lode_start_t *self, const lode_start_tuning_t *tuning, float omega_rad_s,
                      float lock) {
    const bool catching = lode_start_catches(self);
    const float slack = lode_start_slack(self, tuning);
    const uint32_t weight = lock_weight(self, tuning);
    const bool arrived = lode_start_follows(self, tuning, omega_rad_s, (float)weight * slack);
    const bool sound = (catching || arrived) && lock >= LODE_LOCK_HANDOVER &&
                       lode_abs(omega_rad_s) >= tuning->omega_ready - slack;
    self->locked = (uint_least16_t)(sound ? self->locked + weight : 0u);
    if (catching && self->attempt > 1u) {
        self->attempt--;
    } else if (catching && !sound) { // no turning rotor found: start with the vector
        self->attempt = 0u;
        self->locked = 0u;
        enter(self, first_stage(tuning));
    } else {
        // the vector turns: lode_start_aim() counts the time; or a rotor is just being caught
    }
}

bool lode_start_is_ready(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const uint32_t caught = tuning->catch_rounds / CATCH_PARTS + 1u;
    return self->locked >= (lode_start_catches(self) ? caught : tuning->lock_rounds);
}

static lode_start_unmet_t unmet(lode_criterion_t criterion, float measured, float limit) {
    return (lode_start_unmet_t){criterion, measured, limit};
}

// Converts the rounds that met the criterion, and those needed, to times.
static lode_start_unmet_t unmet_for(lode_criterion_t criterion, uint32_t rounds, uint32_t needed,
                                    float round_s) {
    const float measured_s = (float)(int32_t)rounds * round_s;
    const float limit_s = (float)(int32_t)needed * round_s;
    return unmet(criterion, measured_s, limit_s);
}

// While the vector waits with all of its current.
static lode_start_unmet_t unmet_at_rest(const lode_start_t *self, const lode_start_tuning_t *tuning,
                                        float round_s) {
    if (self->stage == (uint_least8_t)LODE_START_ALIGN) {
        const float stood_s = (float)self->seen.rest.dwelt * round_s;
        return unmet(LODE_CRITERION_REST, stood_s, tuning->align_rounds * round_s);
    }
#ifndef LODE_WITHOUT_START_MEASUREMENT
    const uint32_t calm = self->seen.rest.calm;
    const uint32_t least = tuning->patience_rounds / CALM_PART;
    if (calm < least) {
        return unmet_for(LODE_CRITERION_REST, calm, least, round_s);
    }
#else
    (void)self;
    (void)round_s;
#endif
    return unmet(LODE_CRITERION_RAMP, 0.0f, tuning->omega_ready);
}

// At speed, by the conditions of lode_start_judge(). Speeds are compared in the direction of the vector.
static lode_start_unmet_t unmet_at_speed(const lode_start_t *self,
                                         const lode_start_tuning_t *tuning,
                                         const lode_estimator_t *estimator, float round_s) {
    const float sign = lode_sign(self->omega_rad_s);
    const float vector = lode_abs(self->omega_rad_s);
    const float omega = sign * estimator->pll.omega_rad_s;
    const float slack = lode_start_slack(self, tuning);
    const float off = (float)lock_weight(self, tuning) * slack;
    const float least = lode_max(vector - off, tuning->omega_ready - slack);
    const float lost = tuning->lost_per_A * estimator->id_A;
    if (!(omega >= least)) {
        return unmet(LODE_CRITERION_SPEED, estimator->pll.omega_rad_s, sign * least);
    }
    if (!(omega <= vector + off)) {
        return unmet(LODE_CRITERION_SPEED, estimator->pll.omega_rad_s, sign * (vector + off));
    }
    if (lost > LODE_START_LOST_MAX) {
        return unmet(LODE_CRITERION_FLUX, lost, LODE_START_LOST_MAX);
    }
    if (!(estimator->lock >= LODE_LOCK_HANDOVER)) {
        return unmet(LODE_CRITERION_LOCK, estimator->lock, LODE_LOCK_HANDOVER);
    }
    return unmet_for(LODE_CRITERION_HOLD, self->locked, tuning->lock_rounds, round_s);
}

LODE_NOINLINE lode_start_unmet_t lode_start_unmet(const lode_start_t *self,
                                                  const lode_start_tuning_t *tuning,
                                                  const lode_estimator_t *estimator,
                                                  const lode_estimator_tuning_t *estimator_tuning) {
    const float round_s = (float)LODE_SLOW_PERIODS * estimator_tuning->pll.ts_s;
    if (self->current_A < self->current_target) {
        return unmet(LODE_CRITERION_CURRENT, self->current_A, self->current_target);
    }
    if (self->stage != (uint_least8_t)LODE_START_TURN) {
        return unmet_at_rest(self, tuning, round_s);
    }
    const float vector_rad_s = lode_sign(self->omega_target) * self->omega_rad_s;
    if (!(vector_rad_s >= tuning->omega_ready)) {
        return unmet(LODE_CRITERION_RAMP, vector_rad_s, tuning->omega_ready);
    }
    const float omega = estimator->pll.omega_rad_s;
    // (S39), with the observer's attenuation undone.
    const float taken = lode_estimator_droop(estimator_tuning, omega);
    const float emf_V = taken * lode_ab_length(estimator->emf.observer.e_V);
    const float least_V = (1.0f - LODE_START_LOST_MAX) * (1.0f - LODE_START_TOLERANCE) *
                          vector_rad_s * estimator_tuning->psi_Wb;
    if (!(emf_V >= least_V)) {
        return unmet(LODE_CRITERION_EMF, emf_V, least_V);
    }
    return unmet_at_speed(self, tuning, estimator, round_s);
}

#define NAME(value)                                                                                \
    case value:                                                                                    \
        return #value

const char *lode_start_stage_name(lode_start_stage_t stage) {
    switch (stage) {
        NAME(LODE_START_NONE);
        NAME(LODE_START_CATCH);
        NAME(LODE_START_HALF);
        NAME(LODE_START_FULL);
        NAME(LODE_START_ALONE);
        NAME(LODE_START_FOUND);
        NAME(LODE_START_ALIGN);
        NAME(LODE_START_TURN);
    default:
        return "LODE_START_UNKNOWN";
    }
}

const char *lode_criterion_name(lode_criterion_t criterion) {
    switch (criterion) {
        NAME(LODE_CRITERION_NONE);
        NAME(LODE_CRITERION_CURRENT);
        NAME(LODE_CRITERION_REST);
        NAME(LODE_CRITERION_RAMP);
        NAME(LODE_CRITERION_EMF);
        NAME(LODE_CRITERION_SPEED);
        NAME(LODE_CRITERION_FLUX);
        NAME(LODE_CRITERION_LOCK);
        NAME(LODE_CRITERION_HOLD);
        NAME(LODE_CRITERION_PROOF);
        NAME(LODE_CRITERION_POLARITY);
        NAME(LODE_CRITERION_OPEN_PHASE);
    case LODE_CRITERION_COUNT:
    default:
        return "LODE_CRITERION_UNKNOWN";
    }
}
