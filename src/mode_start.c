#include "mode_parts.h"

#include "estimator_inline.h"
#include "inverter_inline.h"
#include "plausibility_inline.h"
#include "start_inline.h"

#define RESISTANCE_MORE_MAX 0.75f // of the configured one
// Limits of RESISTANCE: WRONG_RESISTANCE times the largest correction makes 2.2 times the configured resistance, and
// WRONG_PER_CALM times calm_V is the voltage that is not modelled. A copper winding that is 100 K hotter has 1.4 times its
// resistance; a current sensor with 0.4 of its gain shows 2.5 times.
#define WRONG_RESISTANCE 1.6f
#define WRONG_PER_CALM 10.0f
// Limit of the flux over the active flux (S34): errors of 10 % in psi, 20 % in Ld, 50 % in R and a microsecond of dead time
// add up to 1.6 times, sensors with 0.4 of their gain make 2.3 to 2.5.
#define WRONG_FLUX 2.0f
// Change of the voltage at the same current over the impedance (S43). Half a dozen rounds turn no rotor so much; sensors
// whose gain falls to 0.6 make 0.67.
#define OTHER_VOLTAGE 0.5f
// Times that limit: sensors whose gain falls to a fifth make no more, so it is a rotor that slips.
#define SLIPS 8.0f
// Least I^2 over the mean square that noise makes of three samples (K39): I is then 24 times the noise of an axis.
#define NOISE_HELD2 48.0f
// Speed over the vector's from which the load turns the rotor (S36): a rotor that swings about the vector is faster by half.
#define MUCH_FASTER 2.0f

#ifndef LODE_WITHOUT_START_MEASUREMENT

// Voltage of dead time and drops, which counts as resistance where it is not corrected.
static float uncorrected_V(const lode_drive_tuning_t *tuning) {
    if (tuning->inverter.correct > 0u) {
        return 0.0f;
    }
#ifdef LODE_WITHOUT_PLAUSIBILITY
    return FLT_MAX; // not known in this build
#else
    return FOUR_PER_PI * tuning->plausibility.taken_V;
#endif
}

// Corrects the inverter's model by what was measured at rest.
static void take_resistance(lode_drive_t *self, const lode_start_found_t *found) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    const float current_A = self->state.start.current_A;
    lode_inverter_correct(&self->inverter, &self->tuning->inverter, found->r_Ohm, found->dead_V,
                          current_A);
    const float more_Ohm = self->inverter.r_more_Ohm;
    const lode_emf_tuning_t *emf = &self->tuning->estimator.emf;
    const float most_Ohm = RESISTANCE_MORE_MAX * (emf->inv_b - emf->a_over_b);
    const float limit_V =
        lode_max(WRONG_RESISTANCE * most_Ohm * current_A, WRONG_PER_CALM * tuning->calm_V) +
        uncorrected_V(self->tuning);
    self->inverter.r_more_Ohm = lode_clamp(more_Ohm, -most_Ohm, most_Ohm);
    if (more_Ohm * current_A > limit_V) { // no winding has so much
        lode_mode_fault(self, LODE_CHECK_RESISTANCE, more_Ohm, limit_V / current_A);
    }
}

#endif

#ifndef LODE_WITHOUT_PLAUSIBILITY

// (S34): the estimate turns with the vector at speed, but with more EMF than any error of the motor's values explains: more
// current flows than is measured. It must last for as long as a lock.
static LODE_NOINLINE void watch_flux(lode_drive_t *self) {
    const lode_start_t *start = &self->state.start;
    const lode_start_tuning_t *tuning = &self->tuning->start;
    const lode_estimator_t *estimator = &self->estimator;
    const float omega = estimator->pll.omega_rad_s;
    uint32_t rounds = 0u;
    if (lode_plausibility_is_on(&self->tuning->plausibility) && estimator->lock < LODE_LOCK_LOST &&
        lode_start_follows(start, tuning, omega, lode_start_slack(start, tuning))) {
        const lode_flux_t flux = lode_estimator_flux(estimator, &self->tuning->estimator);
        const float least_Wb = (1.0f - LODE_START_LOST_MAX) * self->tuning->estimator.psi_Wb;
        const float limit_Wb = WRONG_FLUX * lode_max(flux.expected_Wb, least_Wb);
        rounds = flux.aligned && flux.seen_Wb > limit_Wb ? self->guard.lock + 1u : 0u;
        if (rounds >= tuning->lock_rounds) {
            lode_mode_fault(self, LODE_CHECK_FLUX, flux.seen_Wb, limit_Wb);
        }
    }
    self->guard.lock = (uint_least16_t)rounds;
}

static float measured_A2(const lode_drive_t *self) {
    return lode_ab_length2(self->estimator.emf.i_A);
}

// (S43): the current has fallen and is back, but takes another voltage than before: it is not the current that is measured.
static LODE_NOINLINE void judge_drop(lode_drive_t *self, float change_V) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_emf_tuning_t *emf = &tuning->estimator.emf;
    const lode_start_t *start = &self->state.start;
    const float R_Ohm = emf->inv_b - emf->a_over_b;
    const float X_Ohm =
        start->omega_rad_s * lode_min(tuning->references.Lq_H, 1.0f / tuning->references.inv_Ld);
    const float limit_Ohm = OTHER_VOLTAGE * lode_sqrt(R_Ohm * R_Ohm + X_Ohm * X_Ohm);
    const float change_Ohm = change_V / lode_max(start->current_A, FLT_MIN);
    if (lode_plausibility_has_gain(&tuning->plausibility) && change_Ohm > limit_Ohm &&
        change_Ohm < SLIPS * limit_Ohm) {
        lode_mode_fault(self, LODE_CHECK_RESISTANCE, change_Ohm, limit_Ohm);
    }
}

// SLOT_DEAD_TIME, half a round before and after watch_drop().
static void note_drop(lode_drive_t *self) {
    lode_drop_check(&self->state.start.drop, measured_A2(self));
}

// SLOT_REFERENCES. False: the drive is in FAULT.
static bool watch_drop(lode_drive_t *self) {
    lode_start_t *start = &self->state.start;
    const float ref_A2 = start->current_A * start->current_A;
    const float inv_b = self->tuning->estimator.emf.inv_b;
    const float noise_A2 = self->jump.noise_V2 / (inv_b * inv_b);
    const bool flows =
        ref_A2 >= lode_max(self->tuning->plausibility.i_min_A2, NOISE_HELD2 * noise_A2);
    const lode_dq_t e_V = lode_park(self->estimator.emf.observer.e_V, start->at);
    float change_V = 0.0f;
    if (lode_drop_step(&start->drop, measured_A2(self), flows ? ref_A2 : 0.0f, e_V, &change_V)) {
        judge_drop(self, change_V);
    }
    return self->gates;
}

#endif

// SLOT_LAG: resistance and dead time while the vector rests, then slip and flux by the EMF.
static void measure_start(lode_drive_t *self) {
    if (self->state.start.stage == (uint_least8_t)LODE_START_TURN) {
        lode_start_note_slip(&self->state.start, &self->tuning->start, &self->estimator,
                             &self->tuning->estimator);
#ifndef LODE_WITHOUT_PLAUSIBILITY
        watch_flux(self);
#endif
        return;
    }
#ifndef LODE_WITHOUT_START_MEASUREMENT
    lode_start_found_t found;
    if (lode_start_measure(&self->state.start, &self->tuning->start,
                           self->estimator.emf.observer.e_V, &found)) {
        take_resistance(self, &found);
    }
#endif
}

LODE_NOINLINE void lode_mode_catch_again(lode_drive_t *self, const lode_fault_t *why) {
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    const uint_least8_t failed = self->state.start.failed;
    if (failed < LODE_START_LOSSES_MAX && self->tuning->start.catch_rounds > 0u) {
        lode_mode_end_attempt(self, why, failed + 1u, self->calm);
        return;
    }
#endif
    lode_mode_fault(self, LODE_CHECK_WRONG_WAY, why->measured, why->limit);
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// The report of what is_astray() has found.
static lode_fault_t astray(const lode_drive_t *self) {
    const lode_start_t *start = &self->state.start;
    const float omega = self->estimator.pll.omega_rad_s;
    const bool back = omega * start->omega_target < 0.0f;
    const float most =
        MUCH_FASTER * lode_max(lode_abs(start->omega_rad_s), self->tuning->start.omega_ready);
    return (lode_fault_t){.state = self->mode,
                          .stage = start->stage,
                          .criterion = (uint_least8_t)LODE_CRITERION_SPEED,
                          .measured = back ? -lode_abs(omega) : lode_abs(omega),
                          .limit = back ? 0.0f : most};
}

// (S36), with the lock quality of a hand-over: the load turns the rotor against the command while the vector does not turn
// that way, or much faster than the vector.
static bool is_astray(const lode_drive_t *self) {
    const lode_start_t *start = &self->state.start;
    const float ready = self->tuning->start.omega_ready;
    const float vector = start->omega_rad_s;
    const float omega = self->estimator.pll.omega_rad_s;
    const bool sure = !lode_start_catches(start) && self->estimator.lock >= LODE_LOCK_HANDOVER &&
                      lode_abs(omega) >= ready && lode_abs(start->omega_target) > 0.0f;
    const bool back = omega * start->omega_target < 0.0f && !(omega * vector > 0.0f);
    return sure && (back || lode_abs(omega) > MUCH_FASTER * lode_max(lode_abs(vector), ready));
}

// Called after watch_drop(). The state must last for as long as a lock.
static void watch_load(lode_drive_t *self) {
    const uint32_t rounds = is_astray(self) ? self->guard.speed + 1u : 0u;
    self->guard.speed = (uint_least16_t)rounds;
    if (rounds >= self->tuning->start.lock_rounds) {
        const lode_fault_t why = astray(self);
        lode_mode_catch_again(self, &why);
    }
}

#endif

// SLOT_DEAD_TIME: whether the estimate is good enough to run on.
static void judge_start(lode_drive_t *self) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    const lode_estimator_t *estimator = &self->estimator;
    const bool lost = tuning->lost_per_A * estimator->id_A > LODE_START_LOST_MAX;
    lode_start_judge(&self->state.start, tuning, estimator->pll.omega_rad_s,
                     lost ? 0.0f : estimator->lock);
}

void lode_mode_fail_start(lode_drive_t *self, const lode_fault_t *why) {
    lode_mode_fault(self, LODE_CHECK_START, why->measured, why->limit);
    self->guard.fault.stage = why->stage;
    self->guard.fault.criterion = why->criterion;
}

// An attempt that is not at speed yet has nothing to report; then the one before is reported.
static LODE_NOINLINE void end_start(lode_drive_t *self) {
    const lode_fault_t last = self->guard.fault;
    const lode_fault_t now = lode_mode_unmet(self);
    const bool early = now.criterion < (uint_least8_t)LODE_CRITERION_EMF;
    const bool tells = last.criterion != (uint_least8_t)LODE_CRITERION_NONE;
    lode_mode_fail_start(self, early && tells ? &last : &now);
}

// Keeps the criterion that the failed attempt has not met.
static LODE_NOINLINE void begin_attempt(lode_drive_t *self) {
    self->guard.fault = lode_mode_unmet(self);
    lode_start_again(&self->state.start, &self->tuning->start);
}

// Speed to which the vector turns: with noisy sensors the EMF may stand out of the noise at a higher speed only (S49).
static float final_omega(const lode_drive_t *self) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
#ifdef LODE_WITHOUT_PLAUSIBILITY
    return tuning->omega_handover;
#else
    float omega = tuning->omega_per_noise * lode_sqrt(self->jump.noise_V2);
    if (2.0f * omega > tuning->omega_handover) {
        omega *= 1.0f + lode_start_waited(&self->state.start, tuning);
    }
    return lode_clamp(omega, tuning->omega_handover, tuning->omega_most);
#endif
}

// SLOT_SPEED: where the vector goes.
static void aim_start(lode_drive_t *self) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    lode_start_t *start = &self->state.start;
    if (lode_start_catches(start) || lode_mode_finds_at_rest(self)) {
        return;
    }
    const bool stopping = lode_mode_is_stop(self);
    const bool at_rest = lode_abs(start->omega_rad_s) <= tuning->omega_step;
    const float target = stopping ? 0.0f : lode_sign(self->command.speed_rad_s) * final_omega(self);
    self->start_rounds++;
    const bool failed =
        lode_start_aim(start, tuning, target, stopping && at_rest ? 0.0f : tuning->current_A);
    if (stopping && at_rest && !(start->current_A > 0.0f)) {
        lode_mode_switch_off(self);
    } else if (!stopping && (self->start_rounds > tuning->timeout_rounds ||
                             (failed && lode_start_is_lost(start, tuning)))) {
        end_start(self);
    } else if (failed) {
        begin_attempt(self);
    } else {
        // on its way
    }
}

void lode_mode_follow_start(lode_drive_t *self, lode_slot_t slot) {
    if (self->command.mode != (uint_least8_t)LODE_MODE_RUN) {
        lode_mode_switch_off(self);
    } else if (lode_mode_is_sensored(self)) { // the sensor gives the angle: nothing to start
        lode_mode_hand_over(self);
        self->state.run.fade = 0.0f;
    } else if (slot == SLOT_LAG) {
        measure_start(self);
    } else if (slot == SLOT_DEAD_TIME) {
#ifndef LODE_WITHOUT_PLAUSIBILITY
        note_drop(self);
#endif
        judge_start(self);
    } else if (slot == SLOT_SPEED) {
        aim_start(self);
    } else if (slot == SLOT_REFERENCES &&
               lode_start_is_ready(&self->state.start, &self->tuning->start)) {
        lode_mode_hand_over(self);
#ifndef LODE_WITHOUT_PLAUSIBILITY
    } else if (slot == SLOT_REFERENCES) {
        if (watch_drop(self)) {
            watch_load(self);
        }
#endif
    } else {
        // nothing to judge in this slot
    }
}
