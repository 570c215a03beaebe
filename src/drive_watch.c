#include "drive_inline.h"
#include "drive_slots_inline.h"
#include "open_phase_inline.h"
#include "start_inline.h"

// Bus reading that stands still: it is wrong if the EMF is off by this share of the flux.
#define BUS_SHARE 0.1f
// Currents that stand still: up to this share of the voltage circle the EMF leaves voltage to drive the reference.
#define EMF_SHARE 0.8f
// (K43): up to this share of it, with psi 20 % too large, the EMF of a rotor without load leaves no voltage.
#define NO_LOAD_SHARE 1.25f
// Stuck ADC channels in a start (S44): hot over configured resistance; control error over current; share of a trip per check.
#define HOT_WINDING 2.0f
#define MISSED 0.05f
#define WOUND_UP 0.34f
#define WINDS_UP 0.05f // with less of the current missed: the voltage rises slowly then
#define ALONG 0.5f     // squared cosine of the angle from the control error to the voltage
// A current that jumps (K38).
#define VOLTAGE_JUMP 2.5f // times the change that the voltage makes
#define TAKEN_JUMP 2.0f   // least current, times what dead time and drops may take from a phase
#define NOISE_JUMP2 25.0f // squared: times the mean square of the noise in the jump (K39)
#define GONE 0.15f        // of the reference
// Half-waves: beyond this share of the voltage circle the voltage counts as used up (rounding).
#define ALL_VOLTAGE 0.99f
// Current control has lost the current (K49): for this long, or longer with up to OFF_UP times as many rounds between in which it
// has not.
#define OFF_s 0.05f
#define OFF_UP 3u
// Load: share of the torque limit, which the voltage moves a little in each round, that counts as all the torque.
#define ALL_TORQUE 0.9f
#define FOLLOWED 0.8f // of the torque current's reference
#define FAR_OFF 0.05f // of the speed reference
// Flux: the EMF is that of another flux where its direction is right, its size at least half (a stopped rotor has less) and at most
// twice (with more, the estimated speed has collapsed), and its error more than a tuning and a hot magnet explain
// (guard.flux_share).
#define LEAST_FLUX 0.5f
#define MOST_FLUX 2.0f
// Uncertainty of the resistance; the drops have it too.
#define R_UNSURE 0.5f
#define FLUX_CURRENT 9.0f   // squared: 3 times the least current to be judged, 0.15 of i_max
#define FLUX_s 0.05f        // longer than a fast speed change makes the estimated speed lag the EMF
#define STOPPED_SHARE 0.25f // (K45): of the speed reference

#ifndef LODE_WITHOUT_PLAUSIBILITY

// Half a turn, where the EMF drives current through the diodes of a healthy bridge too.
static uint32_t half_turn(const lode_drive_t *self) {
    const float omega = self->estimator.pll.omega_rad_s;
    const float emf_V = LODE_SQRT3 * self->tuning->references.psi_Wb * lode_abs(omega);
    const float step_rad = self->tuning->estimator.pll.ts_s * omega;
    return emf_V > self->inverter.v_bus_V ? lode_guard_half_turn(step_rad) : 0u;
}

#endif

LODE_NOINLINE void lode_drive_diagnose(lode_drive_t *self, const lode_sense_t *sense,
                                       const lode_sample_t *sample, lode_shorted_t *shorted) {
    if (self->gates || lode_mode_precharges(self)) {
        lode_guard_diagnose(&self->guard, &self->tuning->guard, sense, &self->tuning->sense, sample,
                            self->mode);
        lode_mode_obey_guard(self);
        return;
    }
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)shorted;
#else
    const bool open = lode_mode(self) == LODE_MODE_FAULT && !lode_mode_shorts(self);
    if (open && !self->guard.fresh) {
        lode_guard_suspect(&self->guard, &self->tuning->guard, &self->tuning->sense, sample,
                           shorted, half_turn(self));
    }
#endif
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// Duration of `rounds` rounds of the slow jobs.
static float rounds_s(const lode_drive_t *self, uint32_t rounds) {
    const uint32_t periods = rounds * LODE_SLOW_PERIODS;
    return (float)periods * self->tuning->estimator.pll.ts_s;
}

// Counts rounds with the same reading. True: `limit` of them in a row; a limit of 0 means no check.
static bool is_still(uint_least16_t *rounds, bool same, uint32_t limit) {
    const bool still = same && limit > 0u;
    *rounds = still ? (uint_least16_t)(*rounds + 1u) : 0u;
    return still && *rounds >= limit;
}

LODE_NOINLINE void lode_drive_count_still(lode_drive_t *self, uint16_t count, float v_bus_V) {
    lode_guard_t *guard = &self->guard;
    const lode_drive_tuning_t *tuning = self->tuning;
    const uint32_t rounds = tuning->guard.still_rounds;
    const uint32_t bus_rounds = tuning->guard.bus_still_rounds;
    const bool same = count == guard->still_count;
    const bool same_bus = lode_in_range(v_bus_V, guard->still_V, guard->still_V);
    guard->still_count = count;
    guard->still_V = v_bus_V;
    if (is_still(&guard->still, same, rounds)) {
        lode_mode_fault(self, LODE_CHECK_TEMPERATURE_STUCK,
                        lode_sense_temperature_degC(&tuning->sense, count), rounds_s(self, rounds));
    }
    // If the bus reading is wrong, so is the voltage computed with it, and the EMF observed from that.
    const lode_flux_t flux = lode_estimator_flux(&self->estimator, &tuning->estimator);
    const bool off = lode_mode(self) == LODE_MODE_RUN &&
                     lode_abs(flux.seen_Wb - flux.expected_Wb) > BUS_SHARE * flux.expected_Wb;
    if (is_still(&guard->bus_still, same_bus && off, bus_rounds)) {
        lode_mode_fault(self, LODE_CHECK_BUS_STUCK, v_bus_V, rounds_s(self, bus_rounds));
    }
}

static float squared(lode_dq_t x) {
    return x.d * x.d + x.q * x.q;
}

// The EMF is below a share of the voltage circle.
static bool is_emf_below(const lode_drive_t *self, float share, float omega_rad_s) {
    return self->tuning->references.psi_Wb * lode_abs(omega_rad_s) <
           share * self->tuning->current.circle * self->inverter.v_bus_V;
}

// Voltage is left to drive the current: it should follow its reference.
static bool may_follow(const lode_drive_t *self, float omega_rad_s) {
    return is_emf_below(self, EMF_SHARE, omega_rad_s);
}

// (K43). Of a current that need not follow: it should turn with its reference nevertheless. A motor without load at the end of
// its voltage has none, and had hardly any before. `i_A2`: the larger of the current and its last move, squared.
static bool should_turn(const lode_drive_t *self, float i_A2, float omega_rad_s) {
    return i_A2 >= self->tuning->plausibility.i_min_A2 || may_follow(self, omega_rad_s) ||
           !is_emf_below(self, NO_LOAD_SHARE, omega_rad_s);
}

// A phase current that crosses zero requires the voltage of the inductance. Where dead time and drops take more, they hold
// the current at zero.
static lode_hold_t hold_of(const lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float Lq_H = tuning->estimator.emf.inv_b * tuning->estimator.pll.ts_s;
    return (lode_hold_t){.taken_V = tuning->plausibility.taken_V,
                         .x_Ohm = Lq_H * lode_mode_frame_omega(self)};
}

// 1 .. 3; 0: all three.
static uint32_t phase_of(lode_finding_t found) {
    return (uint32_t)lode_clamp(found.measured, 0.0f, (float)LODE_PHASES);
}

static LODE_NOINLINE void find(lode_drive_t *self, lode_plausibility_t *watch, uint32_t doubt) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float A_per_count = lode_abs(tuning->sense.i_gain);
    lode_finding_t found = lode_plausibility_find(
        watch, &tuning->plausibility, doubt, tuning->guard.lock_checks, hold_of(self), A_per_count);
    if (found.check == LODE_CHECK_CURRENT_STUCK && tuning->sense.two_shunts == 0u &&
        lode_plausibility_is_open(watch, phase_of(found), A_per_count)) {
        found.check = LODE_CHECK_OPEN_PHASE; // without noise an open phase keeps its count too
    }
    if (found.check != LODE_CHECK_NONE) {
        const bool second = watch != &self->plausibility && found.check != LODE_CHECK_CURRENT_SUM;
        const float number =
            phase_of(found) > 0u ? found.measured + (float)LODE_PHASES : (float)LODE_OPEN_SET_2;
        lode_mode_fault(self, found.check, second ? number : found.measured, found.limit);
    }
}

// The voltage acts along the control error, within 45 degrees.
static bool acts_along(lode_dq_t u_V, lode_dq_t error_A) {
    const float along = u_V.d * error_A.d + u_V.q * error_A.q;
    return along > 0.0f && along * along > ALONG * squared(u_V) * squared(error_A);
}

// (S44). The current keeps its counts off its reference, with more voltage than resistance, dead time and the EMF of a rotor
// that follows the start's vector take: stuck ADC channels, for which current control winds up, or for a few checks a rotor
// that swings.
static float wound_up(const lode_drive_t *self) {
    const lode_start_t *start = &self->state.start;
    if (lode_mode(self) != LODE_MODE_START || lode_start_catches(start) ||
        lode_estimator_injects(&self->estimator)) {
        return 0.0f; // no vector with a current
    }
    const lode_emf_tuning_t *emf = &self->tuning->estimator.emf;
    const lode_references_tuning_t *motor = &self->tuning->references;
    const float current_A = start->current_A;
    const float R_Ohm = emf->inv_b - emf->a_over_b;
    const float flux_Wb = motor->psi_Wb + motor->Lq_H * current_A;
    const float most_V = hold_of(self).taken_V + HOT_WINDING * R_Ohm * current_A +
                         flux_Wb * lode_abs(start->omega_rad_s);
    const lode_dq_t error_A = {self->ref_A.d - self->i_A.d, self->ref_A.q - self->i_A.q};
    const float count_A = (float)LODE_COUNT_FRACTION * self->tuning->sense.i_gain;
    if (!(squared(self->u_V) > most_V * most_V) || !(squared(error_A) > count_A * count_A) ||
        !acts_along(self->u_V, error_A)) {
        return 0.0f;
    }
    return squared(error_A) > MISSED * MISSED * current_A * current_A ? WOUND_UP : WINDS_UP;
}

// Turn of the vector since the last check, `checks` times LODE_GUARD_PERIODS ago. The damping of a start may turn the vector
// back as fast as its speed turns it on; vector and counts then rest.
LODE_INLINE float turn_of(lode_drive_t *self, const lode_plausibility_t *watch, float omega_rad_s,
                          float checks) {
    const uint32_t periods = LODE_GUARD_PERIODS;
    const float interval_s = (float)periods * self->tuning->estimator.pll.ts_s;
    const float turn_rad = checks * interval_s * omega_rad_s;
    if (lode_mode(self) != LODE_MODE_START) {
        return turn_rad;
    }
    const bool second = watch != &self->plausibility;
    return turn_rad + lode_start_shifted_rad(&self->state.start, second);
}

// Decides on three phases that have kept their counts. A current that need not follow may rest at zero for a while, held by
// dead time, but not for a full turn.
static uint32_t doubt_of_all(const lode_drive_t *self, lode_plausibility_t *watch, uint32_t doubt,
                             float omega_rad_s) {
    lode_plausibility_add(watch, &self->tuning->plausibility, wound_up(self));
    const float i_A2 = lode_max(squared(self->i_A), self->frozen.moved_A2);
    const bool turned =
        lode_abs(watch->turn_rad) >= LODE_TWO_PI && should_turn(self, i_A2, omega_rad_s);
    return may_follow(self, omega_rad_s) || turned ? doubt : 0u;
}

// Not LODE_RAMFUNC: rarely called, and small fast memories have no room for it.
LODE_NOINLINE void lode_drive_suspect(lode_drive_t *self, lode_plausibility_t *watch,
                                      const int32_t i[LODE_PHASES], float checks) {
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    const float omega = lode_mode_frame_omega(self);
    const float turn_rad = turn_of(self, watch, omega, checks);
    const uint32_t again = lode_plausibility_check(watch, i);
    const bool none = again == LODE_ALL_PHASES;
    const bool follows = may_follow(self, omega);
    const bool by_reference = follows || none;
    // what the phases should show
    const float i_A2 = squared(by_reference ? self->ref_A : self->i_A);
    if (lode_plausibility_is_chance(watch, tuning, again, i_A2)) {
        return;
    }
    uint32_t doubt = lode_plausibility_doubt(watch, tuning, again, i_A2, turn_rad,
                                             lode_abs(self->tuning->sense.i_gain));
    if (none) {
        doubt = doubt_of_all(self, watch, doubt, omega);
    }
    doubt = lode_plausibility_has_stuck(tuning) ? doubt : 0u;
    if (doubt > 0u || watch->sum > 0u || !lode_plausibility_sum_ok(tuning, watch->i)) {
        find(self, watch, doubt);
    }
}

// Current reference in stator axes.
static lode_ab_t stator_reference(const lode_drive_t *self) {
#ifndef LODE_WITHOUT_COMMISSIONING
    if (lode_mode(self) == LODE_MODE_CURRENT) {
        return lode_park_inverse(self->ref_A, lode_sincos(self->state.theta_rad));
    }
#endif
    const bool vector =
        lode_mode(self) == LODE_MODE_START && !lode_estimator_injects(&self->estimator);
    return lode_park_inverse(self->ref_A, vector ? lode_start_vector(&self->state.start)
                                                 : lode_estimator_rotor(&self->estimator));
}

// A current with enough voltage should follow at once. One held by dead time may rest at zero, but not for a full turn.
static bool should_have_followed(const lode_drive_t *self, const lode_frozen_t *frozen) {
    const float omega = lode_mode_frame_omega(self);
    const float taken_V = hold_of(self).taken_V;
    const float i_A2 = lode_max(lode_ab_length2(frozen->i_A), frozen->moved_A2);
    return (may_follow(self, omega) && squared(self->u_V) > taken_V * taken_V) ||
           (lode_frozen_turned(frozen, rounds_s(self, 1u) * omega) &&
            should_turn(self, i_A2, omega));
}

LODE_NOINLINE bool lode_drive_doubt_frozen(lode_drive_t *self, lode_frozen_t *frozen) {
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    const bool catches =
        lode_mode(self) == LODE_MODE_START && lode_start_catches(&self->state.start);
    if (lode_mode_is_voltage(self) || catches) { // no reference, or no current
        frozen->checks = 0u;
        return false;
    }
    return lode_frozen_check(frozen, tuning, stator_reference(self)) &&
           should_have_followed(self, frozen);
}

// What acts on the current is known: in RUN a lock is needed, with which the observer knows the EMF. Not with injection, whose
// current depends on Ld.
static bool tells_jumps(const lode_drive_t *self) {
    const bool vector =
        lode_mode(self) == LODE_MODE_START && !lode_start_catches(&self->state.start);
    const bool runs =
        lode_mode(self) == LODE_MODE_RUN && self->estimator.lock >= LODE_LOCK_HANDOVER;
    return (vector || runs) && !lode_estimator_injects(&self->estimator);
}

// Squared jump, over the larger of two limits: the fixed one and the one by noise (K39).
static float share_of_jump(const lode_drive_t *self, float jump_V2) {
    return jump_V2 /
           lode_max(self->tuning->plausibility.jump_V2, NOISE_JUMP2 * self->jump.noise_V2);
}

// The jump is far larger than the voltage's change of the current, be it on the observer's Lq or on a smaller Ld.
static bool is_beyond_voltage(const lode_estimator_t *self, const lode_drive_tuning_t *tuning,
                              lode_ab_t i_A, lode_ab_t jump_A) {
    const lode_emf_tuning_t *emf = &tuning->estimator.emf;
    const lode_ab_t change_A =
        lode_ab_subtract(i_A, lode_drive_turned(self, tuning, self->emf.i_A));
    const float smaller = lode_min(1.0f + emf->salient_Ohm / emf->inv_b, 1.0f); // Ld/Lq
    const float least = VOLTAGE_JUMP / smaller;
    return lode_ab_length2(jump_A) >
           least * least * lode_ab_length2(lode_ab_subtract(change_A, jump_A));
}

// Dead time alone may drive a smaller current back and forth; of a larger one it moves only the phase across the vector.
static bool is_beyond_dead_time(const lode_drive_tuning_t *tuning, lode_ab_t expected_A) {
    const float least_A = TAKEN_JUMP * tuning->plausibility.taken_V / tuning->estimator.emf.inv_b;
    return lode_ab_length2(expected_A) >= least_A * least_A;
}

// Shifts the observer's last current, which enters (E3) with the factor a/b, and id of the active flux, so that neither takes
// the jump for an EMF.
LODE_NOINLINE bool lode_drive_note_jump(lode_drive_t *self, lode_ab_t i_A, lode_ab_t jump_V) {
    lode_estimator_t *estimator = &self->estimator;
    const lode_emf_tuning_t *tuning = &self->tuning->estimator.emf;
    const lode_ab_t jump_A = lode_ab_scale(-1.0f / tuning->inv_b, jump_V);
    const lode_ab_t expected_A = lode_ab_subtract(i_A, jump_A);
    const float share = share_of_jump(self, lode_ab_length2(jump_V));
    const bool counts = tells_jumps(self) && share >= 1.0f &&
                        is_beyond_dead_time(self->tuning, expected_A) &&
                        is_beyond_voltage(estimator, self->tuning, i_A, jump_A);
    const bool starts = lode_mode(self) == LODE_MODE_START;
    if (!counts || !lode_jump_check(&self->jump, i_A, expected_A, share, starts)) {
        return false;
    }
    estimator->emf.i_A = lode_ab_add_scaled(estimator->emf.i_A, -1.0f / tuning->a_over_b, jump_V);
    estimator->id_A += lode_park(jump_A, lode_estimator_rotor(estimator)).d;
    self->jump.change_V2 = self->jump.noise_V2; // a jump is not noise
    LODE_SHARED_STORE(self->steady, false);
    return true;
}

// A lost current may also be that of an open phase. In a start the vector hardly turns and control would wind up, so it does
// not wait to tell the two apart.
LODE_NOINLINE bool lode_drive_wait_jump(lode_drive_t *self) {
    const bool starts = lode_mode(self) == LODE_MODE_START;
    const float step_rad =
        lode_abs(self->estimator.pll.omega_rad_s) * self->tuning->estimator.pll.ts_s;
    const bool gone = lode_ab_length2(self->estimator.emf.i_A) < GONE * GONE * squared(self->ref_A);
    const float factor = lode_jump_wait(&self->jump, starts ? LODE_TWO_PI : step_rad, gone);
    LODE_SHARED_STORE(self->steady, false); // until it is over
    if (factor > 0.0f) {
        lode_mode_fault(self, LODE_CHECK_CURRENT_GAIN, factor, 1.0f);
    } else if (factor >= 0.0f) {
        lode_mode_fault(self, LODE_CHECK_CURRENT_STUCK, 0.0f, 0.0f);
    } else {
        // not decided yet, or no fault
    }
    return self->gates;
}

// Goes to FAULT if a phase, counted from 1, is open; 0: none is.
static bool trips_open(lode_drive_t *self, uint_least8_t phase) {
    if (phase > 0u) {
        lode_mode_fault(self, LODE_CHECK_OPEN_PHASE, (float)phase, 0.0f);
    }
    return phase > 0u;
}

LODE_NOINLINE bool lode_drive_note_waves(lode_drive_t *self, const int32_t i[LODE_PHASES]) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_start_t *start = &self->state.start;
    if (!lode_plausibility_has_waves(&tuning->plausibility)) {
        return true;
    }
    return !trips_open(self, lode_waves_step(&start->seen.turn.waves, &tuning->plausibility, i,
                                             self->ref_A.d * self->ref_A.d,
                                             rounds_s(self, 1u) * start->omega_rad_s));
}

// The voltage is not used up, so current control does not lag for want of it.
static bool has_voltage(const lode_drive_t *self) {
    const float most_V = ALL_VOLTAGE * self->tuning->current.circle * self->inverter.v_bus_V;
    return squared(self->u_V) < most_V * most_V;
}

// The control error tells of open phases: the rotor turns fast enough or injection shows its angle, and the start current has
// faded.
static bool shows_half_waves(const lode_drive_t *self) {
    const bool known =
        lode_abs(self->estimator.pll.omega_rad_s) >= self->tuning->start.omega_ready ||
        lode_estimator_injects(&self->estimator);
    return known && !lode_mode_is_sensored(self) && !(self->state.run.fade > 0.0f);
}

// False: the gates are off, in FAULT or for another attempt of a start.
static LODE_NOINLINE bool judge_half_waves(lode_drive_t *self) {
    lode_half_waves_t *waves = &self->state.run.waves;
    if (!shows_half_waves(self)) {
        if (self->guard.lock == 0u) {
            *waves = (lode_half_waves_t){.idle = 0u}; // the turn is not known well enough
        }
        return true; // while the lock is being lost the counts stay (K41)
    }
    if (!has_voltage(self)) {
        return true; // the counts stay
    }
    const lode_estimator_t *estimator = &self->estimator;
    const lode_sincos_t rotor = lode_estimator_rotor(estimator);
    const lode_half_waves_seen_t seen = {
        .ref_A = lode_park_inverse(self->ref_A, rotor),
        .before_A = lode_park_inverse(waves->ref_A, rotor),
        .i_A = lode_park_inverse(self->i_A, rotor), // without the ripple of injection
        .beyond_V = lode_estimator_beyond_V(estimator, &self->tuning->estimator),
        .kp_V_A = lode_min(self->tuning->current.d.kp, self->current.kp_q_V_A),
        .turn_rad = rounds_s(self, 1u) * estimator->pll.omega_rad_s,
    };
    const lode_open_phase_t open =
        lode_half_waves_check(waves, &self->tuning->plausibility.waves, &seen);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    if (lode_mode_doubts_phase(self, open)) {
        return false;
    }
#endif
    return !trips_open(self, open);
}

// The control error takes the place of the xy plane's current of six phases (K25).
LODE_NOINLINE bool lode_drive_watch_half_waves(lode_drive_t *self) {
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    const lode_dq_t ref_A = self->ref_A;
    const lode_dq_t error_A = {ref_A.d - self->i_A.d, ref_A.q - self->i_A.q};
    lode_half_waves_t *waves = &self->state.run.waves;
    const bool doubts = lode_plausibility_has_waves(tuning) &&
                        lode_half_waves_doubt(waves, &tuning->waves, ref_A, error_A);
    if (doubts && !judge_half_waves(self)) {
        return false; // state.run may be gone
    }
    waves->ref_A = ref_A;
    return true;
}

// Squared distance of the current from what its reference allows: its direction, up to i_max (K49).
static float off_A2(const lode_drive_t *self) {
    const lode_dq_t ref_A = self->ref_A;
    const lode_dq_t i_A = self->i_A;
    const float length_A = lode_max(lode_sqrt(squared(ref_A)), FLT_MIN);
    const float along_A = (i_A.d * ref_A.d + i_A.q * ref_A.q) / length_A;
    const float times = lode_clamp(along_A, 0.0f, self->tuning->references.i_max_A) / length_A;
    return squared((lode_dq_t){i_A.d - times * ref_A.d, i_A.q - times * ref_A.q});
}

LODE_NOINLINE bool lode_drive_watch_control(lode_drive_t *self) {
    lode_running_t *run = &self->state.run;
    const float far_A2 = off_A2(self);
    const float most_A2 = self->tuning->plausibility.off_A2;
    const uint32_t before = run->off;
    const uint32_t off = far_A2 > most_A2 ? before + OFF_UP : before - (before > 0u ? 1u : 0u);
    run->off = (uint_least16_t)off;
    if (rounds_s(self, off) < (float)OFF_UP * OFF_s) {
        return true;
    }
    if (!trips_open(self, lode_half_waves_suspect(&run->waves))) {
        lode_mode_fault(self, LODE_CHECK_CURRENT_CONTROL, lode_sqrt(far_A2), lode_sqrt(most_A2));
    }
    return false;
}

// False during a start that RUN has yet to prove (it fails by its lock, or by a phase that seems open), and while its current
// fades and leaves less torque. A caught rotor that turns against the command counts as started: it is braked for as long as
// that takes.
static bool is_started(const lode_drive_t *self) {
    const lode_running_t *run = &self->state.run;
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    const bool back = self->estimator.pll.omega_rad_s * self->command.speed_rad_s < 0.0f;
    if (run->proving > 0u && !back) {
        return false;
    }
#endif
    return !(run->fade > 0.0f);
}

// Largest torque available against the load. Motoring: all of i_max, as a rotor that slows down for want of voltage settles
// where there is enough. Braking: what the voltage leaves now, as a rotor that gets faster loses more of it.
static float most_against_Nm(const lode_drive_t *self) {
    const lode_references_tuning_t *references = &self->tuning->references;
    const lode_running_t *run = &self->state.run;
    const bool brakes = run->speed.torque_Nm * self->estimator.pll.omega_rad_s < 0.0f;
    return brakes ? lode_references_allowed_Nm(&run->references, references, self->ref_A.d)
                  : references->torque_factor * references->tau_max;
}

// The estimate is reliable, the torque reference is at its maximum and not limited by application, temperature or bus, and
// its current flows.
static bool is_all_torque(const lode_drive_t *self) {
    const float iq_A = self->ref_A.q;
    const bool reliable = lode_mode_is_sensored(self) || self->estimator.lock >= LODE_LOCK_HANDOVER;
    return reliable &&
           lode_abs(self->state.run.speed.torque_Nm) >= ALL_TORQUE * most_against_Nm(self) &&
           self->i_A.q * iq_A >= FOLLOWED * iq_A * iq_A;
}

// (K19), (K29), (K42). A wrong angle makes torque in the wrong direction. The angle of a sensor is checked by the EMF
// (encoder.h), that of injection as soon as there is an EMF. But a rotor that stands still does so at any angle.
static bool is_beyond_torque(const lode_drive_t *self, lode_load_t *load, float way, float omega,
                             float reference) {
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    const bool stalls = lode_load_stalls(load, tuning, omega, way * (reference - omega));
    if (lode_mode_is_sensored(self) || lode_estimator_injects(&self->estimator)) {
        load->held_rad_s = omega;
        load->faster = 0u;
        return stalls;
    }
    const bool off = way * (reference - omega) > FAR_OFF * lode_abs(reference);
    return stalls || (lode_load_is_too_large(load, tuning, way, omega) && off);
}

// Not with torque control, where the load decides the speed.
static LODE_NOINLINE bool judge_load(lode_drive_t *self) {
    lode_running_t *run = &self->state.run;
    const float omega = self->estimator.pll.omega_rad_s;
    const float way = lode_sign(run->speed.torque_Nm);
    const bool gives_way = way * (run->load.held_rad_s - omega) > 0.0f;
    const bool rests = lode_abs(omega) < self->tuning->plausibility.stall_rad_s;
    // first: usually neither
    if (!(gives_way || rests) || lode_mode_is_torque(self) || !is_started(self) ||
        !is_all_torque(self)) {
        run->load = (lode_load_t){.held_rad_s = omega};
        return true;
    }
    const float reference = run->speed.reference_rad_s / self->tuning->speed.inv_pole_pairs;
    if (is_beyond_torque(self, &run->load, way, omega, reference)) {
        lode_mode_fault(self, LODE_CHECK_OVERLOAD, omega, reference);
    }
    return self->gates;
}

LODE_NOINLINE bool lode_drive_watch_load(lode_drive_t *self) {
    lode_running_t *run = &self->state.run;
    const lode_range_t limit = run->speed.limit_Nm;
    if (lode_in_range(run->speed.torque_Nm, ALL_TORQUE * limit.min, ALL_TORQUE * limit.max)) {
        // as nearly always
        run->load = (lode_load_t){.held_rad_s = self->estimator.pll.omega_rad_s};
        return true;
    }
    return self->tuning->plausibility.away_rad_s > 0.0f ? judge_load(self) : true;
}

// The EMF is along the rotor's q axis, and its flux is off the expected one by at least `least_Wb`.
static bool is_another_flux(lode_flux_t flux, float least_Wb) {
    return flux.aligned &&
           lode_in_range(flux.seen_Wb, LEAST_FLUX * flux.expected_Wb,
                         MOST_FLUX * flux.expected_Wb) &&
           lode_abs(flux.seen_Wb - flux.expected_Wb) >= least_Wb;
}

// The speed may lag although the angle is right: with a sensor, or with a QPLL held by injection (P25).
static bool may_speed_lag(const lode_drive_t *self) {
    const bool qpll = self->tuning->estimator.pll.third_order == 0u;
    return lode_mode_is_sensored(self) || (qpll && lode_estimator_injects(&self->estimator));
}

#ifndef LODE_WITHOUT_HFI

static bool has_injection(const lode_drive_t *self) {
    return lode_hfi_is_on(&self->tuning->estimator.hfi);
}

#else

static bool has_injection(const lode_drive_t *self) {
    (void)self;
    return false;
}

#endif

// (P26): unmodelled dead time and drops. Only with a drive that injects at low speed: its start does not measure them (S14).
static float unsure_dead_V(const lode_drive_t *self) {
    const lode_inverter_tuning_t *inverter = &self->tuning->inverter;
    if (!has_injection(self)) {
        return 0.0f;
    }
    return DEAD_PER_PHASE *
           (inverter->dead_more_max * self->inverter.v_bus_V + R_UNSURE * inverter->v_drop_V);
}

// (P25): the part of the magnets' flux that a tuning and a hot magnet explain, plus independent errors of inductances,
// resistance and dead time.
static float unsure_Wb(const lode_drive_t *self, lode_flux_t flux) {
    const lode_references_tuning_t *motor = &self->tuning->references;
    const lode_emf_tuning_t *emf = &self->tuning->estimator.emf;
    const lode_dq_t i_A = self->i_A;
    const float omega = lode_max(lode_abs(self->estimator.pll.omega_rad_s), FLT_MIN);
    const float L_share = LODE_L_UNSURE + motor->Lq_fall * lode_abs(i_A.q);
    const float turned_A = motor->Lq_H * i_A.q * i_A.q / lode_max(flux.expected_Wb, FLT_MIN);
    const float d_Wb = L_share * motor->Ld_H * i_A.d;
    const float q_Wb = L_share * lode_references_salient_H(motor) * turned_A;
    const float r_Wb = R_UNSURE * (emf->inv_b - emf->a_over_b) * i_A.q / omega;
    const float dead_Wb = unsure_dead_V(self) / omega;
    return self->tuning->plausibility.flux_share * self->tuning->estimator.psi_Wb +
           lode_sqrt(d_Wb * d_Wb + q_Wb * q_Wb + r_Wb * r_Wb + dead_Wb * dead_Wb);
}

// The lock need not be lost: where the current makes most of the flux, weaker magnets change it little. Not with hardly any
// current, where dead time is as large as the difference in question.
LODE_NOINLINE bool lode_drive_judge_flux(lode_drive_t *self) {
    lode_guard_t *guard = &self->guard;
    const lode_flux_t flux = lode_estimator_flux(&self->estimator, &self->tuning->estimator);
    const float i_A2 = squared(self->i_A);
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    if (!lode_plausibility_is_on(tuning) || may_speed_lag(self) ||
        !(i_A2 >= FLUX_CURRENT * tuning->i_min_A2) || !is_started(self) ||
        !is_another_flux(flux, unsure_Wb(self, flux))) {
        guard->flux_rounds = 0u;
        return true;
    }
    const uint32_t rounds = guard->flux_rounds + 1u;
    guard->flux_rounds = (uint_least16_t)rounds;
    if (rounds_s(self, rounds) >= FLUX_s) {
        lode_mode_fault(self, LODE_CHECK_FLUX, flux.seen_Wb, flux.expected_Wb);
    }
    return self->gates;
}

// (K45): the electrical speed that the EMF's size tells, whatever angle the estimate has, and the reference.
typedef struct {
    float seen_rad_s;
    float wanted_rad_s;
} turning_t;

static turning_t turning(const lode_drive_t *self, lode_flux_t flux) {
    const float omega = lode_abs(self->estimator.pll.omega_rad_s);
    const float reference = self->state.run.speed.reference_rad_s;
    return (turning_t){flux.seen_Wb * omega / lode_max(flux.expected_Wb, FLT_MIN),
                       lode_abs(reference / self->tuning->speed.inv_pole_pairs)};
}

// Counts the checks at which the rotor hardly turns. Not with the angle of a sensor, whose loads are judged by its speed.
static void note_stopped(lode_drive_t *self, turning_t rotor) {
    lode_guard_t *guard = &self->guard;
    const bool looks = self->tuning->plausibility.away_rad_s > 0.0f && !lode_mode_is_sensored(self);
    const bool stands = looks && rotor.seen_rad_s < STOPPED_SHARE * rotor.wanted_rad_s;
    const uint32_t before = guard->lock > 1u ? guard->stopped : 0u;
    guard->stopped = (uint_least16_t)(stands ? before + 1u : before);
}

static void rename_fault(lode_guard_t *guard, lode_check_t check, float measured, float limit) {
    guard->fault.check = (uint_least8_t)check;
    guard->fault.measured = measured;
    guard->fault.limit = limit;
}

// Renames a lost lock: to LODE_CHECK_OVERLOAD if the rotor hardly turns (K45), to LODE_CHECK_OPEN_PHASE if a phase is suspected
// to be open (K41), and to LODE_CHECK_FLUX if the EMF's size alone was wrong at every check since the lock fell.
static void name_lost_lock(lode_drive_t *self) {
    lode_guard_t *guard = &self->guard;
    const lode_flux_t flux = lode_estimator_flux(&self->estimator, &self->tuning->estimator);
    const bool before = guard->flux || guard->lock <= 1u;
    const bool now =
        is_another_flux(flux, self->tuning->plausibility.flux_share * flux.expected_Wb);
    guard->flux = guard->lock > 0u && before && now;
    if (lode_mode(self) != LODE_MODE_RUN) {
        return;
    }
    const turning_t rotor = turning(self, flux);
    note_stopped(self, rotor);
    if (guard->fault.check != (uint_least8_t)LODE_CHECK_LOST_LOCK) {
        return;
    }
    const lode_open_phase_t open = lode_half_waves_suspect(&self->state.run.waves);
    if (lode_guard_saw_rotor_stopped(guard)) {
        rename_fault(guard, LODE_CHECK_OVERLOAD,
                     lode_min(rotor.seen_rad_s, STOPPED_SHARE * rotor.wanted_rad_s),
                     rotor.wanted_rad_s);
    } else if (open > 0u) {
        rename_fault(guard, LODE_CHECK_OPEN_PHASE, (float)open, 0.0f);
    } else if (guard->flux) {
        rename_fault(guard, LODE_CHECK_FLUX, flux.seen_Wb, flux.expected_Wb);
    } else {
        // lost, and nothing tells why
    }
}

#else

bool lode_drive_watch_load(lode_drive_t *self) {
    (void)self;
    return true;
}

bool lode_drive_watch_half_waves(lode_drive_t *self) {
    (void)self;
    return true;
}

#endif

// The order matters: what is about to trip is first an attempt that has failed, else a rotor to look for, else an open phase.
LODE_NOINLINE void lode_drive_check_slow(lode_drive_t *self) {
    const lode_situation_t now = {self->mode, lode_mode(self) == LODE_MODE_RUN};
    lode_guard_check_slow(&self->guard, &self->tuning->guard, lode_drive_condition(self), now);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    lode_mode_prove_start(self);
#endif
#ifndef LODE_WITHOUT_HFI
    lode_mode_find_lost(self);
#endif
#ifndef LODE_WITHOUT_PLAUSIBILITY
    name_lost_lock(self);
#endif
    lode_mode_obey_guard(self);
}
