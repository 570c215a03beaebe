#include "estimator_inline.h"
#include "start_parts.h"

#define CATCH_PARTS 5u // the lock must hold for this part of the time
// Of the current, by the end of an attempt at speed without a lock, and of twice the start current at most: what is left of
// that takes less than a third of a salient rotor's flux.
#define CURRENT_LEFT 0.3f
// Share of the EMF's size in the swing, at least: at 90 degrees of lag, where a rotor is that needs so much current,
// what the size and the EMF across the vector show of the angle cancels at 1/(1 + c), with c about 1.
#define BY_SIZE_MIN 0.5f
// In the last attempt, of a vector that takes at most all of the flux (a hundredth more is rounding), a round with a
// lock counts as so many, and the speed may be so many times as far off the vector's (S32).
#define LOST_LAST 1.01f
#define WEIGHT_LAST 2u
// Of the EMF of a rotor that follows: one that is as slow as (S8) allows has 0.75 of it, with magnets and current sensors that are
// a tenth off each 0.6. The current takes up to SLIP_LOST of what the configured inductances say of the flux, with both inductances 20 %
// off; where less than SLIP_FLUX is left a rotor that follows is not known from one that does not (S42).
#define SLIP_SHARE 0.6f
#define SLIP_LOST 1.4f
#define SLIP_FLUX 0.2f
// A rotor slips that lacks this EMF for so much of the patience, and so many radians of its swing: half of one with ten times
// the inertia.
#define SLIP_PART 2u
#define SLIP_rad 10.0f
#define SLIPS_MAX 65535u
// Times the current: beyond the 1/CURRENT_SHARE that the last attempt has of it where no reluctance bounds the start current.
#define MUCH_MORE 1.5f

// Measuring resistance and dead time: mean of 20 ms in which the rotor rests, after 10 ms in which observer and
// current settle.
#define CALM_PART 20u   // of the patience
#define SETTLE_PART 15u // of the dwell
// What a voltage along the vector may be off its mean, in the first half of the dwell and in the second, in calm
// voltages; and the time for which it must be, where the rotor does not come to rest: twice that of a calm mean, and so
// many radians of the swing, in which a rotor that falls passes the right angle (S30).
#define STEADY_EARLY 0.5f
#define STEADY_LATE 2.0f
#define STEADY_TIMES 2u
#define STEADY_rad 2.0f
// Where one current alone is measured with, half of its voltage counts as resistance's, the other half as dead time's.
#define HALF_OF_FULL 0.75f
#define FULL_OF_HALF 1.5f

// What is seen of the stage before is forgotten.
static void enter(lode_start_t *self, uint_least8_t stage) {
    self->stage = stage;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    self->drop = (lode_drop_t){.rounds = 0u};
#endif
    if (stage == (uint_least8_t)LODE_START_TURN) {
#ifndef LODE_WITHOUT_PLAUSIBILITY // which alone looks at what turns
        self->seen.turn.waves = (lode_waves_t){.turn_rad = 0.0f};
        self->seen.turn.shift_rad = lode_start_shift_rad(self);
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

// After the measurement, if there is one (S47).
static uint_least8_t last_stage(const lode_start_tuning_t *tuning) {
    return (uint_least8_t)(tuning->align_rounds > 0.0f ? LODE_START_ALIGN : LODE_START_TURN);
}

// Without looking for a rotor that turns.
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
    return tuning->still_rounds + omega / ((float)LODE_SLOW_PERIODS * step);
}

// After the profile.
static float waiting_rounds(const lode_start_tuning_t *tuning, float profile) {
    return lode_max(profile, (float)tuning->patience_rounds);
}

float lode_start_waited(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float profile = profile_rounds(self, tuning);
    const float late = (float)(int32_t)self->attempt - profile;
    return lode_clamp(late / waiting_rounds(tuning, profile), 0.0f, 1.0f);
}

// Of the current of an attempt what it takes now: the half that is measured with, all of it, and of a vector at speed
// that finds no lock less and less (S17).
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

// Radians of the rotor's swing, with the configured inertia, in so many rounds. The weight of the swing's filter is nearly its
// corner times a period.
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
    const float vector = lode_sign(self->omega_target) * self->omega_rad_s;
    const float left = 1.0f - SLIP_LOST * tuning->lost_per_A * self->current_A;
    if (!(vector >= tuning->omega_ready && left >= SLIP_FLUX)) {
        return;
    }
    // What the observer takes of the amplitude of an EMF that turns with the vector.
    const float taken = lode_estimator_droop(estimator_tuning, vector);
    const float emf_V = taken * lode_ab_length(estimator->emf.observer.e_V);
    if (!(emf_V >= SLIP_SHARE * left * vector * estimator_tuning->psi_Wb)) {
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

// Counts a round. True: the attempt has had its time, or the rotor slips.
static bool is_spent(lode_start_t *self, const lode_start_tuning_t *tuning) {
    if (!(lode_abs(self->omega_target) > 0.0f)) {
        self->attempt = 0u;
        self->slips = 0u;
        return false;
    }
    self->attempt++;
    const float rounds = (float)(int32_t)self->attempt;
    if (rounds <= tuning->still_rounds) {
        return false; // the profile alone takes longer; spares a division
    }
    if (slips(self, tuning)) {
        return true;
    }
    const float profile = profile_rounds(self, tuning);
    return rounds > profile + waiting_rounds(tuning, profile);
}

// A rotor that fell out of step with the turning vector only shakes: the next attempt begins at rest, on a phase for
// the measurement, and 120 degrees on from where the first one began (S41). If it slipped, and the last attempt's current is much more,
// it has that at once (S42).
void lode_start_again(lode_start_t *self, const lode_start_tuning_t *tuning) {
    const bool much = tuning->current_last_A > MUCH_MORE * tuning->current_A;
    self->more = much && slips(self, tuning) ? 1u : 0u;
    self->attempt = 0u;
    self->slips = 0u;
    self->at = (lode_sincos_t){lode_sign(self->omega_target) * 0.5f * LODE_SQRT3, -0.5f};
    self->omega_rad_s = 0.0f;
    self->current_A = 0.0f;
    self->stands = 0u; // the rotor is anywhere now
    self->failed = self->failed == 0u ? 1u : LODE_START_FAILED_MAX;
    enter(self, first_stage(tuning));
}

#ifndef LODE_WITHOUT_START_MEASUREMENT

// (S13), (S14): from the voltages along half and all of the current.
static lode_start_found_t found_at_rest(const lode_start_t *self) {
    const float mean_V = self->seen.rest.sum_V;
    const float r_Ohm =
        (mean_V - self->seen.rest.along_V) / ((1.0f - LEVEL_SHARE) * self->current_A);
    return (lode_start_found_t){.r_Ohm = r_Ohm, .dead_V = mean_V - r_Ohm * self->current_A};
}

// One round's voltage, in the axis at which the vector waits. Resistance shows along the current, dead time along the phase
// of the axis, whatever the damping adds to that. A rotor that falls past a right angle to the vector shows nothing
// across it, but along it, and ever more: then the sum begins anew. In the second half of the dwell it takes the ripple of
// a swing for no such change (S30).
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

// The voltage with the present current is known, or is not: the rotor has its time to come to rest at both, as it is
// all of the current that it is to follow. Of the current at which it did not, the voltage follows from that of the
// other one (S33).
static LODE_NOINLINE void end_dwell(lode_start_t *self, const lode_start_tuning_t *tuning,
                                    bool known) {
    lode_start_rest_t *rest = &self->seen.rest;
    const float mean_V = rest->sum_V / lode_max(rest->summed, 1.0f);
    if (self->stage == (uint_least8_t)LODE_START_HALF) {
        enter(self, (uint_least8_t)(known ? LODE_START_FULL : LODE_START_ALONE));
        rest->along_V = mean_V;
    } else if (known || self->stage == (uint_least8_t)LODE_START_FULL) {
        rest->sum_V = known ? mean_V : FULL_OF_HALF * rest->along_V;
        if (self->stage == (uint_least8_t)LODE_START_ALONE) {
            rest->along_V = HALF_OF_FULL * mean_V;
        }
        self->stage = (uint_least8_t)LODE_START_FOUND;
    } else {
        enter(self, last_stage(tuning));
    }
}

// The mean of a swing is known.
static bool is_steady(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float summed = self->seen.rest.summed;
    const uint32_t least = STEADY_TIMES * (tuning->patience_rounds / CALM_PART);
    return summed >= (float)least && swung_rad(tuning, summed) >= STEADY_rad;
}

// One round with the present current. What it makes known is worked out in the next round, by a call of its own.
static void watch_at_rest(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V) {
    lode_start_rest_t *rest = &self->seen.rest;
    rest->dwelt++;
    if (SETTLE_PART * rest->dwelt > tuning->dwell_rounds) {
        add_at_rest(rest, tuning, lode_park(e_V, self->at));
    }
    const bool calm = CALM_PART * (rest->calm + 1u) > tuning->patience_rounds;
    if (calm || rest->dwelt >= tuning->dwell_rounds) {
        end_dwell(self, tuning, calm || is_steady(self, tuning));
    }
}

bool lode_start_measure(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V,
                        lode_start_found_t *found) {
    if (self->stage == (uint_least8_t)LODE_START_FOUND) {
        *found = found_at_rest(self);
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

// Share of the steepest ramp that the vector has now (S35). A rotor that is stopped has followed it.
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

// Counts a round in which the vector stands at its axis with all of its current, which is none of the attempt's time; of the
// first attempt alone (S47).
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
            enter(self, (uint_least8_t)LODE_START_TURN); // a stop ends what is done at rest
        }
    }
    self->current_target = current_now_A(self, tuning, most_A);
    self->omega_step = tuning->omega_step * ramp_share(self, tuning);
    self->at =
        lode_angle_normalise(self->at); // what the periods in between have left of its length
    const float most =
        lode_min(tuning->damping_A / lode_max(self->current_A, FLT_MIN),
                 tuning->damping_rad_s / lode_max(lode_abs(self->omega_rad_s), FLT_MIN));
    self->give = lode_min(tuning->damping, most);
    const float speed = self->omega_rad_s / (LODE_START_HOLD * tuning->omega_ready);
    self->by_size = lode_clamp(speed, -1.0f, 1.0f) *
                    lode_max(1.0f - tuning->lost_per_A * self->current_A, BY_SIZE_MIN);
    return !aligns(self, tuning) && is_spent(self, tuning);
}

// What a round with a lock counts on the vector. A lock that goes again is no worse than none where no attempt is
// left (S32).
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
    } else if (catching) { // the vector begins
        self->attempt = 0u;
        self->locked = 0u;
        enter(self, first_stage(tuning));
    } else {
        // on the vector
    }
}

bool lode_start_is_ready(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const uint32_t caught = tuning->catch_rounds / CATCH_PARTS + 1u;
    return self->locked >= (lode_start_catches(self) ? caught : tuning->lock_rounds);
}

static lode_start_unmet_t unmet(lode_criterion_t criterion, float measured, float limit) {
    return (lode_start_unmet_t){criterion, measured, limit};
}

// In how many of the `rounds` that are needed it was so, as times.
static lode_start_unmet_t unmet_for(lode_criterion_t criterion, uint32_t rounds, uint32_t needed,
                                    float round_s) {
    const float measured_s = (float)(int32_t)rounds * round_s;
    const float limit_s = (float)(int32_t)needed * round_s;
    return unmet(criterion, measured_s, limit_s);
}

// While the vector waits with all of its current, for rounds of `round_s`.
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

// At speed, by what lode_start_judge() goes by. Speeds are counted in the direction of the vector.
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
    const float vector = lode_sign(self->omega_target) * self->omega_rad_s;
    if (!(vector >= tuning->omega_ready)) {
        return unmet(LODE_CRITERION_RAMP, vector, tuning->omega_ready);
    }
    const float omega = estimator->pll.omega_rad_s;
    // (S39), with what the observer takes of the amplitude
    const float taken = lode_estimator_droop(estimator_tuning, omega);
    const float emf_V = taken * lode_ab_length(estimator->emf.observer.e_V);
    const float least_V = (1.0f - LODE_START_LOST_MAX) * (1.0f - LODE_START_TOLERANCE) * vector *
                          estimator_tuning->psi_Wb;
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
    case LODE_CRITERION_COUNT:
    default:
        return "LODE_CRITERION_UNKNOWN";
    }
}
