#include "drive_inline.h"
#include "open_phase_inline.h"
#include "start_inline.h"

// Counts that keep still: share of the flux by which the EMF is off where the bus is not what is read.
#define BUS_SHARE 0.1f
// Currents that keep still. Of the voltage circle: with less EMF there is voltage left to drive the current that is
// asked for.
#define EMF_SHARE 0.8f
// ADC channels that are stuck in a start. Of the configured resistance; of the current; and what each look counts, of enough.
#define HOT_WINDING 2.0f
#define MISSED 0.05f
#define WOUND_UP 0.34f
// A current that changes at once (K38).
#define VOLTAGE_JUMP 2.5f // times what the voltage does
#define TAKEN_JUMP 2.0f   // times what dead time and drops may take of a phase: the least current
#define NOISE_JUMP2 25.0f // squared, times the mean square of what noise makes of it (K39)
#define GONE 0.15f        // of what is asked for
// Half-waves. Of the voltage circle, on which rounding leaves it.
#define ALL_VOLTAGE 0.99f
// Load. Of what limits the torque: the voltage moves that a little in each round.
#define ALL_TORQUE 0.9f
#define FOLLOWED 0.8f // of the current that is asked for
#define FAR_OFF 0.05f // of the speed that is asked for
// Flux. Another one where the EMF is where it should be, there is half of it at least (a rotor that is stopped has less),
// and it is off by more than a tuning and a hot magnet explain.
#define LEAST_FLUX 0.5f
#define ANOTHER_FLUX 0.2f
// Of inductances and resistance, as for (S34) and (K16). Of the drops as of the resistance.
#define L_UNSURE 0.2f
#define R_UNSURE 0.5f
#define FLUX_CURRENT 9.0f // times the least current that is judged by, squared: 0.15 of i_max
#define FLUX_s 0.05f      // longer than a speed that changes fast is behind the EMF
#define FLUX_ROUNDS_MAX 255u

#ifndef LODE_WITHOUT_PLAUSIBILITY

// In FAULT without a short of the drive's own. Where the EMF is above the bus, current flows through the diodes of a
// sound bridge too.
static bool is_open(const lode_drive_t *self) {
    const float emf_V =
        LODE_SQRT3 * self->tuning->references.psi_Wb * lode_abs(self->estimator.pll.omega_rad_s);
    return lode_mode(self) == LODE_MODE_FAULT && !lode_mode_shorts(self) &&
           emf_V <= self->inverter.v_bus_V;
}

#endif

LODE_NOINLINE void lode_drive_diagnose(lode_drive_t *self, const lode_sense_t *sense,
                                       const lode_sample_t *sample) {
    if (self->gates || lode_mode_precharges(self)) {
        lode_guard_diagnose(&self->guard, &self->tuning->guard, sense, &self->tuning->sense, sample,
                            self->mode);
        lode_mode_obey_guard(self);
        return;
    }
#ifndef LODE_WITHOUT_PLAUSIBILITY
    if (is_open(self)) {
        lode_guard_suspect(&self->guard, &self->tuning->guard, &self->tuning->sense, sample);
    }
#endif
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// In seconds, rounds of the slow jobs.
static float rounds_s(const lode_drive_t *self, uint32_t rounds) {
    const uint32_t periods = rounds * LODE_SLOW_PERIODS;
    return (float)periods * self->tuning->estimator.pll.ts_s;
}

// One more round with the same count. True: it has been `limit` of them. 0: it may be any.
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
    // Another bus than the one that is read makes another EMF of the same voltage.
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

// Where the EMF takes the voltage, the current need not follow its reference.
static bool may_follow(const lode_drive_t *self, float omega_rad_s) {
    return self->tuning->references.psi_Wb * lode_abs(omega_rad_s) <
           EMF_SHARE * self->tuning->current.circle * self->inverter.v_bus_V;
}

// At its zero a phase's current asks for the voltage of the inductance: where dead time and drops take more, they
// hold it there.
static lode_hold_t hold_of(const lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float Lq_H = tuning->estimator.emf.inv_b * tuning->estimator.pll.ts_s;
    return (lode_hold_t){.taken_V = tuning->plausibility.taken_V,
                         .x_Ohm = Lq_H * lode_mode_frame_omega(self)};
}

static LODE_NOINLINE void find(lode_drive_t *self, lode_plausibility_t *watch, uint32_t doubt) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float A_per_count = lode_abs(tuning->sense.i_gain);
    lode_finding_t found = lode_plausibility_find(
        watch, &tuning->plausibility, doubt, tuning->guard.lock_looks, hold_of(self), A_per_count);
    if (found.check == LODE_CHECK_CURRENT_STUCK && tuning->sense.two_shunts == 0u &&
        lode_plausibility_is_open(watch, (uint32_t)found.measured, A_per_count)) {
        found.check = LODE_CHECK_OPEN_PHASE; // without noise it keeps its count as well
    }
    if (found.check != LODE_CHECK_NONE) {
        const bool second = watch != &self->plausibility && found.check != LODE_CHECK_CURRENT_SUM;
        const float before = second ? (float)LODE_PHASES : 0.0f;
        lode_mode_fault(self, found.check, found.measured + before, found.limit);
    }
}

// A current that keeps its counts, though it is not what is asked for, and has more voltage than resistance, dead time and the
// EMF of a rotor that follows the start's vector take: so it is of ADC channels that are stuck, for which current control asks for
// ever more, and in a swing for some looks (S44).
static bool is_wound_up(const lode_drive_t *self) {
    const lode_start_t *start = &self->state.start;
    if (lode_mode(self) != LODE_MODE_START || lode_start_catches(start) ||
        lode_estimator_injects(&self->estimator)) {
        return false; // the vector has no current
    }
    const lode_emf_tuning_t *emf = &self->tuning->estimator.emf;
    const lode_references_tuning_t *motor = &self->tuning->references;
    const float current_A = start->current_A;
    const float R_Ohm = emf->inv_b - emf->a_over_b;
    const float flux_Wb = motor->psi_Wb + motor->Lq_H * current_A;
    const float most_V = hold_of(self).taken_V + HOT_WINDING * R_Ohm * current_A +
                         flux_Wb * lode_abs(start->omega_rad_s);
    const lode_dq_t missed_A = {self->ref_A.d - self->i_A.d, self->ref_A.q - self->i_A.q};
    return squared(missed_A) > MISSED * MISSED * current_A * current_A &&
           squared(self->u_V) > most_V * most_V;
}

// By how much the vector has turned since the last look, `looks` times LODE_GUARD_PERIODS ago. The damping of a start may
// turn it back as fast as it turns on: that rests then, and so do the counts. It is known at the looks at set 1.
LODE_INLINE float turn_of(lode_drive_t *self, const lode_plausibility_t *watch, float omega_rad_s,
                          float looks) {
    const uint32_t periods = LODE_GUARD_PERIODS;
    const float look_s = (float)periods * self->tuning->estimator.pll.ts_s;
    const float turn_rad = looks * look_s * omega_rad_s;
    if (lode_mode(self) != LODE_MODE_START) {
        return turn_rad;
    }
    return watch == &self->plausibility ? turn_rad + lode_start_shifted_rad(&self->state.start)
                                        : 0.0f;
}

// Of three that have kept their counts. A current that need not follow may rest at zero for a while, within what dead time
// takes, but not for a turn.
static uint32_t doubt_of_all(const lode_drive_t *self, lode_plausibility_t *watch, uint32_t doubt,
                             bool follows) {
    if (is_wound_up(self)) {
        lode_plausibility_add(watch, &self->tuning->plausibility, WOUND_UP);
    }
    return follows || lode_abs(watch->turn_rad) >= LODE_TWO_PI ? doubt : 0u;
}

// Not LODE_RAMFUNC: one call in many, and small fast memories are full without it.
LODE_NOINLINE void lode_drive_suspect(lode_drive_t *self, lode_plausibility_t *watch,
                                      const int32_t i[LODE_PHASES], float looks) {
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    const float omega = lode_mode_frame_omega(self);
    const float turn_rad = turn_of(self, watch, omega, looks);
    const uint32_t again = lode_plausibility_look(watch, i);
    const bool none = again == LODE_ALL_PHASES;
    const bool follows = may_follow(self, omega);
    const float i_A2 =
        squared(follows || none ? self->ref_A : self->i_A); // what the phases should show
    if (lode_plausibility_is_chance(watch, tuning, again, i_A2)) {
        return;
    }
    uint32_t doubt = lode_plausibility_doubt(watch, tuning, again, i_A2, turn_rad,
                                             lode_abs(self->tuning->sense.i_gain));
    if (none) {
        doubt = doubt_of_all(self, watch, doubt, follows);
    }
    if (doubt > 0u || watch->sum > 0u || !lode_plausibility_sum_ok(tuning, watch->i)) {
        find(self, watch, doubt);
    }
}

// What is asked for, in stator axes.
static lode_ab_t asked_A(const lode_drive_t *self) {
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

// At once where there is voltage for it; within what dead time takes a current may rest at zero, but not for a turn.
static bool should_have_followed(const lode_drive_t *self) {
    const float omega = lode_mode_frame_omega(self);
    const float taken_V = hold_of(self).taken_V;
    return (may_follow(self, omega) && squared(self->u_V) > taken_V * taken_V) ||
           lode_frozen_turned(&self->frozen, rounds_s(self, 1u) * omega);
}

LODE_NOINLINE bool lode_drive_doubt_frozen(lode_drive_t *self) {
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    const bool catches =
        lode_mode(self) == LODE_MODE_START && lode_start_catches(&self->state.start);
    if (lode_mode_is_voltage(self) || catches) { // nothing is asked for, or it has no current
        self->frozen.looks = 0u;
        return true;
    }
    if (lode_frozen_look(&self->frozen, tuning, asked_A(self)) && should_have_followed(self)) {
        lode_mode_fault(self, LODE_CHECK_CURRENT_STUCK, 0.0f, 0.0f);
    }
    return self->gates;
}

// What acts on the current is known: with a lock the observer has the EMF; a wave's current goes by Ld.
static bool tells_jumps(const lode_drive_t *self) {
    const bool vector =
        lode_mode(self) == LODE_MODE_START && !lode_start_catches(&self->state.start);
    const bool runs =
        lode_mode(self) == LODE_MODE_RUN && self->estimator.lock >= LODE_LOCK_HANDOVER;
    return (vector || runs) && !lode_estimator_injects(&self->estimator);
}

// The square of a jump, of that from which it counts and stands out of the noise.
static float share_of_jump(const lode_drive_t *self, float jump_V2) {
    return jump_V2 /
           lode_max(self->tuning->plausibility.jump_V2, NOISE_JUMP2 * self->jump.noise_V2);
}

// What the voltage changes the current by, by the observer's inductance, is far less, and so it is by the smaller one.
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

// Where all of it is less, dead time alone may drive it to and fro; of a larger one, only what is across it.
static bool is_beyond_dead_time(const lode_drive_tuning_t *tuning, lode_ab_t expected_A) {
    const float least_A = TAKEN_JUMP * tuning->plausibility.taken_V / tuning->estimator.emf.inv_b;
    return lode_ab_length2(expected_A) >= least_A * least_A;
}

// Moves the observer's last current, whose share of (E3) is a/b, and the salient one: neither takes the jump for an EMF.
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
    if (!counts || !lode_jump_look(&self->jump, i_A, expected_A, share, starts)) {
        return false;
    }
    estimator->emf.i_A = lode_ab_add_scaled(estimator->emf.i_A, -1.0f / tuning->a_over_b, jump_V);
    estimator->id_A += lode_park(jump_A, lode_estimator_rotor(estimator)).d;
    self->jump.change_V2 = self->jump.noise_V2; // it is no noise
    LODE_SHARED_STORE(self->steady, false);
    return true;
}

// A current that is gone may be that of an open phase too. A start's vector hardly turns, and cannot wait for what tells them
// apart.
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
        // one sample alone
    }
    return self->gates;
}

// An open phase ends in FAULT; 0: there is none.
static bool phases_ok(lode_drive_t *self, uint_least8_t phase) {
    if (phase > 0u) {
        lode_mode_fault(self, LODE_CHECK_OPEN_PHASE, (float)phase, 0.0f);
    }
    return phase == 0u;
}

LODE_NOINLINE bool lode_drive_note_waves(lode_drive_t *self, const int32_t i[LODE_PHASES]) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_start_t *start = &self->state.start;
    if (!lode_plausibility_has_waves(&tuning->plausibility)) {
        return true;
    }
    return phases_ok(self, lode_waves_step(&start->seen.turn.waves, &tuning->plausibility, i,
                                           self->ref_A.d * self->ref_A.d,
                                           rounds_s(self, 1u) * start->omega_rad_s));
}

// Current control has voltage left: it is not behind for want of it.
static bool has_voltage(const lode_drive_t *self) {
    const float most_V = ALL_VOLTAGE * self->tuning->current.circle * self->inverter.v_bus_V;
    return squared(self->u_V) < most_V * most_V;
}

// What current control misses tells of phases: the rotor turns fast enough, the start current has gone, and no wave is injected,
// which the current has besides.
static bool tells_half_waves(const lode_drive_t *self) {
    return lode_abs(self->estimator.pll.omega_rad_s) >= self->tuning->start.omega_ready &&
           !lode_mode_is_sensored(self) && !(self->state.run.fade > 0.0f) &&
           !lode_estimator_injects(&self->estimator);
}

static LODE_NOINLINE bool judge_half_waves(lode_drive_t *self) {
    lode_half_waves_t *waves = &self->state.run.waves;
    if (!tells_half_waves(self)) {
        *waves = (lode_half_waves_t){.idle = 0u}; // what is known of the turn is too little
        return true;
    }
    if (!has_voltage(self)) {
        return true; // what was lacking stays
    }
    const lode_estimator_t *estimator = &self->estimator;
    const lode_sincos_t rotor = lode_estimator_rotor(estimator);
    const lode_half_waves_seen_t seen = {
        .asked_A = lode_park_inverse(self->ref_A, rotor),
        .before_A = lode_park_inverse(waves->asked_A, rotor),
        .i_A = estimator->emf.i_A,
        .beyond_V = lode_estimator_beyond_V(estimator, &self->tuning->estimator),
        .kp_V_A = lode_min(self->tuning->current.d.kp, self->current.kp_q_V_A),
        .turn_rad = rounds_s(self, 1u) * estimator->pll.omega_rad_s,
    };
    return phases_ok(self, lode_half_waves_look(waves, &self->tuning->plausibility.waves, &seen));
}

// What current control misses stands for the current of the xy plane (K25).
LODE_NOINLINE bool lode_drive_watch_half_waves(lode_drive_t *self) {
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    const lode_dq_t ref_A = self->ref_A;
    const lode_dq_t missed_A = {ref_A.d - self->i_A.d, ref_A.q - self->i_A.q};
    lode_half_waves_t *waves = &self->state.run.waves;
    const bool doubts = lode_plausibility_has_waves(tuning) &&
                        lode_half_waves_doubt(waves, &tuning->waves, ref_A, missed_A);
    const bool good = doubts ? judge_half_waves(self) : true;
    waves->asked_A = ref_A;
    return good;
}

// A start that RUN still proves is an attempt that fails by its lock; while its current fades there is less torque. A rotor that
// turns against the command has been caught, and is braked for as long as it takes: no attempt ends that, but its faults.
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

// The most that will be there against the load: all that i_max gives. A speed that falls for want of voltage comes to rest
// where there is enough of it; one that rises for want of it does not.
static float most_against_Nm(const lode_drive_t *self) {
    const lode_references_tuning_t *references = &self->tuning->references;
    const lode_running_t *run = &self->state.run;
    const bool brakes = run->speed.torque_Nm * self->estimator.pll.omega_rad_s < 0.0f;
    return brakes ? lode_references_allowed_Nm(&run->references, references, self->ref_A.d)
                  : references->torque_factor * references->tau_max;
}

// The estimate is sure; neither the application nor temperature or bus limits the torque; and its current flows: where the
// voltage is too little for it, so is the speed.
static bool is_all_torque(const lode_drive_t *self) {
    const float iq_A = self->ref_A.q;
    return self->estimator.lock >= LODE_LOCK_HANDOVER &&
           lode_abs(self->state.run.speed.torque_Nm) >= ALL_TORQUE * most_against_Nm(self) &&
           self->i_A.q * iq_A >= FOLLOWED * iq_A * iq_A;
}

// (K19), (K29). With torque control the speed is the load's.
static LODE_NOINLINE bool judge_load(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_running_t *run = &self->state.run;
    const float omega = self->estimator.pll.omega_rad_s;
    const float way = lode_sign(run->speed.torque_Nm);
    const bool gives_way = way * (run->load.held_rad_s - omega) > 0.0f; // first: it spares the rest
    // An angle that is wrong makes torque against itself. A sensor's is judged by the EMF (encoder.h), that of injection until
    // there is one.
    const bool by_emf = !lode_mode_is_sensored(self) && !lode_estimator_injects(&self->estimator);
    if (!gives_way || !by_emf || lode_mode_is_torque(self) || !is_started(self) ||
        !is_all_torque(self)) {
        run->load = (lode_load_t){.held_rad_s = omega};
        return true;
    }
    const float reference = run->speed.reference_rad_s;
    const float off = way * (reference - omega * tuning->speed.inv_pole_pairs);
    if (lode_load_is_too_large(&run->load, &tuning->plausibility, way, omega) &&
        off > FAR_OFF * lode_abs(reference)) {
        lode_mode_fault(self, LODE_CHECK_OVERLOAD, omega, reference / tuning->speed.inv_pole_pairs);
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

// The EMF is along the rotor's q axis, and off what the speed induces by `least_Wb` at least.
static bool is_another_flux(lode_flux_t flux, float least_Wb) {
    return flux.aligned && flux.seen_Wb >= LEAST_FLUX * flux.expected_Wb &&
           lode_abs(flux.seen_Wb - flux.expected_Wb) >= least_Wb;
}

// Though the angle is right: that of a sensor, or of a QPLL that a wave holds (P25).
static bool may_speed_lag(const lode_drive_t *self) {
    const bool qpll = self->tuning->estimator.pll.third_order == 0u;
    return lode_mode_is_sensored(self) || (qpll && lode_estimator_injects(&self->estimator));
}

// (P26): dead time and drops that are not modelled. A start by injection does not measure them (S14), and does not need the
// EMF for its lock; without injection there is no such speed that they matter at.
static float unsure_dead_V(const lode_drive_t *self) {
    const lode_inverter_tuning_t *inverter = &self->tuning->inverter;
    if (!lode_estimator_injects(&self->estimator)) {
        return 0.0f;
    }
    return DEAD_PER_PHASE *
           (inverter->dead_more_max * self->inverter.v_bus_V + R_UNSURE * inverter->v_drop_V);
}

// (P25): what a tuning and a hot magnet explain of the magnets' flux, and errors of inductances, resistance and dead time,
// which are independent of each other, of the rest.
static float unsure_Wb(const lode_drive_t *self, lode_flux_t flux) {
    const lode_references_tuning_t *motor = &self->tuning->references;
    const lode_emf_tuning_t *emf = &self->tuning->estimator.emf;
    const lode_dq_t i_A = self->i_A;
    const float omega = lode_max(lode_abs(self->estimator.pll.omega_rad_s), FLT_MIN);
    const float L_share = L_UNSURE + motor->Lq_fall * lode_abs(i_A.q);
    const float turned_A = motor->Lq_H * i_A.q * i_A.q / lode_max(flux.expected_Wb, FLT_MIN);
    const float d_Wb = L_share * motor->Ld_H * i_A.d;
    const float q_Wb = L_share * lode_references_salient_H(motor) * turned_A;
    const float r_Wb = R_UNSURE * (emf->inv_b - emf->a_over_b) * i_A.q / omega;
    const float dead_Wb = unsure_dead_V(self) / omega;
    return ANOTHER_FLUX * self->tuning->estimator.psi_Wb +
           lode_sqrt(d_Wb * d_Wb + q_Wb * q_Wb + r_Wb * r_Wb + dead_Wb * dead_Wb);
}

// Though the lock is not lost: where the current makes most of the flux, less of the magnets' takes it little. With hardly any
// current, dead time is as large as what is looked for.
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
    guard->flux_rounds = (uint_least8_t)rounds;
    if (rounds >= FLUX_ROUNDS_MAX || rounds_s(self, rounds) >= FLUX_s) {
        lode_mode_fault(self, LODE_CHECK_FLUX, flux.seen_Wb, flux.expected_Wb);
    }
    return self->gates;
}

// The lock was lost by the EMF's size alone, at every look since it was first found to be.
static void name_lost_lock(lode_drive_t *self) {
    lode_guard_t *guard = &self->guard;
    const lode_flux_t flux = lode_estimator_flux(&self->estimator, &self->tuning->estimator);
    const bool before = guard->flux || guard->lock <= 1u;
    const bool now = is_another_flux(flux, ANOTHER_FLUX * flux.expected_Wb);
    guard->flux = guard->lock > 0u && before && now;
    if (guard->flux && guard->fault.check == (uint_least8_t)LODE_CHECK_LOST_LOCK) {
        guard->fault.check = (uint_least8_t)LODE_CHECK_FLUX;
        guard->fault.measured = flux.seen_Wb;
        guard->fault.limit = flux.expected_Wb;
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

LODE_NOINLINE void lode_drive_check_slow(lode_drive_t *self) {
    const lode_situation_t now = {self->mode, lode_mode(self) == LODE_MODE_RUN};
    lode_guard_check_slow(&self->guard, &self->tuning->guard, lode_drive_condition(self), now);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    lode_mode_prove_start(self);
#endif
#ifndef LODE_WITHOUT_PLAUSIBILITY
    name_lost_lock(self);
#endif
    lode_mode_obey_guard(self);
}
