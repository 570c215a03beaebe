#include "mode.h"

#include "current_inline.h"
#include "estimator_inline.h"
#include "inverter_inline.h"
#include "plausibility_inline.h"
#include "references_inline.h"
#include "sense_inline.h"
#include "start_inline.h"

#include <stddef.h>

// A rotor that turns is short-circuited while the low sides are on: a fifth of a period bounds its current,
// and is longer than any shunt amplifier takes to settle.
#define DUTY_PRECHARGE 0.8f
// A whole round of the slow jobs knows of a sensor that the last period had; the next one does not.
#define SENSOR_ROUNDS 2u
#define RESISTANCE_MORE_MAX 0.75f // of the configured one
// Times the most that is corrected, so that it is 2.2 times what was configured, and times the voltage at which the
// vector counts as calm, so that it stands out of what nobody knows of the voltage. A winding of copper that is
// 100 K hotter has 1.4 times its resistance; a current sensor with 0.4 of its gain shows 2.5 times.
#define WRONG_RESISTANCE 1.6f
#define WRONG_PER_CALM 10.0f
// Times the active flux: errors of 10 % in psi, 20 % in Ld, 50 % in R and a microsecond of dead time add up to 1.6, with
// 0.4 of the sensors' gain it is 2.3 to 2.5.
#define WRONG_FLUX 2.0f
// Of the impedance, by which the same current then takes another voltage: half a dozen rounds turn no rotor so much, and sensors
// that show 0.6 of what they did make 0.67 of it (S43).
#define OTHER_VOLTAGE 0.5f
// Than the vector: a rotor that swings about it is so by half.
#define MUCH_FASTER 2.0f
#define PROVING_ENDLESS 0xffffu // rounds: 13 s of 40 kHz, and longer than a rotor takes to stop
// A rotor is given up for lost at two thirds of the guard's time; with injection up to twice the speed at which that
// ends: the EMF may have pulled the estimate there.
#define LOST_SHARE 2u
#define LOST_PARTS 3u
#define LOST_SPEED 2.0f
// So often it is looked for again; one loss is forgotten after so many rounds, 3.3 s of 5 kHz.
#define LOSSES_MAX 3u
#define FORGET_ROUNDS 2048u
// Of the largest current of a start that shows polarity by motion: what is along the axis, so that the phases are away
// from their zeros; and what share of the flux it takes or gives at most.
#define ALONG_SHARE 0.33f
#define ALONG_FLUX 0.5f

static void set_mode(lode_drive_t *self, lode_mode_t mode) {
    self->mode = (uint_least8_t)mode;
    self->mode_not = (uint_least8_t)(MODE_BITS ^ (uint32_t)mode);
    self->steady = self->gates && !self->mail && mode == LODE_MODE_RUN &&
                   self->tuning->speed_periods == LODE_SLOW_PERIODS;
}

// Which samples are of use once the sensing, or what acts, has changed.
static void set_omitted(lode_drive_t *self) {
    self->omitted = lode_sense_omit_both(lode_sense_omitted(&self->tuning->sense, self->duty));
}

static void set_duties(lode_drive_t *self, float duty) {
    self->duty = (lode_abc_t){duty, duty, duty};
}

// Gates off, with no voltage on its way.
static LODE_SMALL_CALL void open_gates(lode_drive_t *self, lode_mode_t mode) {
    self->gates = false;
    self->losses = 0u;
    set_duties(self, LODE_DUTY_IDLE);
    set_omitted(self);
    const lode_ab_t none = {0.0f, 0.0f};
    self->inverter.written[0] = self->inverter.written[1] = none;
    set_mode(self, mode);
}

LODE_NOINLINE void lode_mode_switch_off(lode_drive_t *self) {
    open_gates(self, LODE_MODE_OFF);
    self->i_A = (lode_dq_t){0.0f, 0.0f};
    self->ref_A = (lode_dq_t){0.0f, 0.0f};
    self->u_V = (lode_dq_t){0.0f, 0.0f};
    lode_estimator_reset(&self->estimator, &self->tuning->estimator);
}

#if !defined(LODE_WITHOUT_HANDOVER_RETRY) || !defined(LODE_WITHOUT_HFI)

// RUN, about to trip for lost lock.
static bool loses_lock(const lode_drive_t *self) {
    const uint32_t least = LOST_SHARE * self->tuning->guard.lock_looks;
    return LOST_PARTS * (uint32_t)self->guard.lock >= least;
}

#endif

// Why the attempt of a start has failed. With no check it is no fault, and the start goes on.
static LODE_NOINLINE lode_fault_t unmet_now(const lode_drive_t *self) {
    const lode_start_unmet_t unmet = lode_start_unmet(&self->state.start, &self->tuning->start,
                                                      &self->estimator, &self->tuning->estimator);
    return (lode_fault_t){.state = self->mode,
                          .stage = self->state.start.stage,
                          .criterion = (uint_least8_t)unmet.criterion,
                          .measured = unmet.measured,
                          .limit = unmet.limit};
}

// What the guard has counted is gone; what the attempt before has not met stays.
static void reset_guard(lode_drive_t *self) {
    const lode_fault_t last = self->guard.fault;
    lode_guard_reset(&self->guard);
    if (self->losses > 0u) {
        self->guard.fault = last;
    }
}

#ifndef LODE_WITHOUT_HANDOVER_RETRY

LODE_NOINLINE void lode_mode_prove_start(lode_drive_t *self) {
    const uint_least8_t losses = self->losses;
    if (lode_mode(self) == LODE_MODE_RUN && self->state.run.proving > 0u && loses_lock(self) &&
        losses < LODE_START_LOSSES_MAX) {
        self->guard.fault = (lode_fault_t){.state = self->mode,
                                           .criterion = (uint_least8_t)LODE_CRITERION_PROOF,
                                           .measured = self->estimator.lock,
                                           .limit = LODE_LOCK_LOST};
        lode_mode_switch_off(self); // as the command is RUN, for no longer than the next period
        self->losses = (uint_least8_t)(losses + 1u);
    }
}

#endif

LODE_NOINLINE void lode_mode_obey_guard(lode_drive_t *self) {
    if (!lode_guard_is_good(&self->guard)) {
        const uint_least8_t failed = lode_drive_retries(self);
        if (lode_mode(self) == LODE_MODE_START) {
            self->guard.fault.stage = self->state.start.stage;
        }
        open_gates(self, LODE_MODE_FAULT);
        self->losses = failed; // of the start, as long as there is something to read
    }
}

LODE_NOINLINE void lode_mode_fault(lode_drive_t *self, lode_check_t check, float measured,
                                   float limit) {
    lode_guard_trip(&self->guard, self->mode, check, measured, limit);
    lode_mode_obey_guard(self);
}

LODE_NOINLINE void lode_mode_distrust(lode_drive_t *self) {
    const bool mode =
        ((uint32_t)self->mode ^ (uint32_t)self->mode_not) == MODE_BITS && lode_mode_fits(self);
    const bool posted =
        self->command_posted == LODE_POST_NONE || self->command_posted == LODE_POST_FULL;
    const bool command = posted && self->command.check == lode_mode_order_check(&self->command);
    if (!posted) {
        LODE_SHARED_STORE(self->command_posted, LODE_POST_NONE);
    }
    self->command = (lode_order_t){.mode = LODE_MODE_OFF};
    self->command.check = lode_mode_order_check(&self->command);
    lode_mode_fault(self, LODE_CHECK_MEMORY, !command ? 2.0f : (!mode ? 1.0f : 3.0f), 0.0f);
}

LODE_NOINLINE void lode_mode_note_trip(lode_drive_t *self, lode_ab_t i_A) {
    lode_estimator_set_current(&self->estimator, i_A);
    self->i_A = lode_park(i_A, lode_estimator_rotor(&self->estimator));
}

// START goes on with the attempt after those that failed, in what is left of the time; after none it is another start.
static void count_start(lode_drive_t *self) {
#ifdef LODE_WITHOUT_HANDOVER_RETRY
    self->start_rounds = 0u;
#else
    self->start_rounds = self->losses == 0u ? 0u : self->start_rounds;
    self->state.start.failed = self->losses;
#endif
}

// At no current.
static void take_q_axis(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_current_take(&self->current, &tuning->current, tuning->references.Lq_H);
}

static void switch_on(lode_drive_t *self, lode_mode_t mode) {
    const lode_drive_tuning_t *tuning = self->tuning;
    self->gates = true;
    self->sensored = 0u; // until the next estimate says so
    set_duties(self, LODE_DUTY_IDLE);
    reset_guard(self);
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_plausibility_reset(&self->plausibility);
#endif
    lode_estimator_reset(&self->estimator, &tuning->estimator);
    lode_inverter_adapt(&self->inverter, &tuning->inverter, self->u_V);
    take_q_axis(self);
    lode_current_reset(&self->current, (lode_dq_t){0.0f, 0.0f}, (lode_dq_t){0.0f, 0.0f});
    lode_start_begin(&self->state.start, &tuning->start);
    count_start(self);
#ifndef LODE_WITHOUT_COMMISSIONING
    if (mode != LODE_MODE_START) {
        self->state.theta_rad = self->command.theta_rad; // in place of the start's
    }
#endif
    set_mode(self, mode);
}

// What is counted in RUN: the start has counted with the guard's counter of the lock too (S34).
static void begin_counts(lode_drive_t *self) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
#else
    self->guard.lock = 0u;
    self->guard.speed = 0u;
    self->guard.flux_rounds = 0u;
    self->state.run.waves = (lode_half_waves_t){.idle = 0u};
    self->state.run.load = (lode_load_t){.held_rad_s = self->estimator.pll.omega_rad_s};
#endif
}

#ifndef LODE_WITHOUT_HANDOVER_RETRY

// The rounds in which RUN proves a start. A rotor that turns the other way than asked for has not started until it is given
// back to the vector.
static uint_least16_t rounds_to_prove(const lode_drive_t *self, float omega_rad_s) {
    const bool opposite = omega_rad_s * self->command.speed_rad_s < 0.0f;
    return opposite ? PROVING_ENDLESS : self->tuning->start.patience_rounds;
}

#endif

#if !defined(LODE_WITHOUT_FLYING_START) || !defined(LODE_WITHOUT_HFI)

// What follows from where the rotor is and how fast it turns, in RUN, where that was found at once.
static void run_at_once(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_estimator_t *estimator = &self->estimator;
    const float omega = estimator->pll.omega_rad_s;
    lode_running_t *run = &self->state.run; // takes the place of the start's
    lode_speed_reset(&run->speed, &tuning->speed, omega * tuning->speed.inv_pole_pairs, 0.0f,
                     lode_estimator_load_torque_Nm(estimator, &tuning->estimator),
                     lode_references_most_Nm(&tuning->references));
    run->fade = 0.0f;
    run->id_A = 0.0f;
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    run->proving = 0u;
#endif
    begin_counts(self);
    lode_references_reset(&run->references, self->i_A.d);
    self->ref_A = (lode_dq_t){0.0f, 0.0f}; // until SLOT_REFERENCES
    set_mode(self, LODE_MODE_RUN);
}

#endif

LODE_NOINLINE void lode_mode_take_mail(lode_drive_t *self) {
    LODE_SHARED_STORE(self->mail, false);
    LODE_SIGNAL_FENCE();
    if (self->posted_tuning != NULL) {
        self->tuning = self->posted_tuning;
        lode_tuning_take_check(self);
        take_q_axis(self);
        LODE_SHARED_STORE(self->posted_tuning, NULL);
        set_omitted(self);
    }
    if (self->command_posted == LODE_POST_FULL) {
        self->command = self->posted;
        LODE_SHARED_STORE(self->command_posted, LODE_POST_NONE);
    }
}

LODE_NOINLINE bool lode_mode_mail_ok(lode_drive_t *self) {
    LODE_SHARED_STORE(self->mail, true); // or about to be
    LODE_SHARED_STORE(self->steady, false);
    return self->command_posted == LODE_POST_FULL;
}

static bool is_stop(const lode_drive_t *self) {
    return !(lode_abs(self->command.speed_rad_s) > 0.0f);
}

// A vector as seen from a frame that is `ahead` of the one it was given in.
static lode_dq_t in_frame(lode_dq_t x, lode_sincos_t ahead) {
    return lode_park((lode_ab_t){x.d, x.q}, ahead);
}

// From the I-f frame into the rotor's: voltage and current vectors stay, only their names change; then
// the start current fades from the d axis.
static void hand_over(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float omega = self->estimator.pll.omega_rad_s;
    const lode_dq_t i_A = self->i_A;
    const lode_sincos_t rotor = lode_estimator_rotor(&self->estimator);
    const lode_sincos_t vector = lode_start_next(&self->state.start, tuning->estimator.pll.ts_s);
    const lode_dq_t u_V = in_frame(self->u_V, lode_angle_subtract(rotor, vector));
    lode_current_reset(
        &self->current, u_V,
        lode_references_induced_V(&tuning->references, self->current.Lq_H, i_A, omega));
    const float torque = lode_references_torque_Nm(&tuning->references, i_A);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    self->losses = self->state.start.failed;
    const bool caught = lode_start_catches(&self->state.start);
#endif
    lode_running_t *run = &self->state.run; // takes the place of the start's
    lode_speed_reset(&run->speed, &tuning->speed, omega * tuning->speed.inv_pole_pairs, torque,
                     lode_estimator_load_torque_Nm(&self->estimator, &tuning->estimator),
                     lode_references_most_Nm(&tuning->references));
    run->fade = 1.0f;
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    run->proving = caught ? rounds_to_prove(self, omega) : tuning->start.patience_rounds;
#endif
    begin_counts(self);
    run->id_A = i_A.d - lode_references_id_A(&tuning->references, torque, omega);
    lode_references_reset(&run->references, i_A.d);
    self->ref_A = i_A; // until SLOT_REFERENCES
    self->direction = lode_sign(omega);
    set_mode(self, LODE_MODE_RUN);
}

// A start current ahead of the rotor by the angle at which it makes the torque that the present one
// makes. (In the direction of the present one it might be opposed to the rotor.)
LODE_NOINLINE void lode_mode_hand_back(lode_drive_t *self) {
    const float current_A = self->tuning->start.current_A;
    const float sine = lode_clamp(self->i_A.q / current_A, -1.0f, 1.0f);
    const lode_sincos_t ahead = {sine, lode_sqrt(1.0f - sine * sine)};
    const lode_dq_t u_V = in_frame(self->u_V, ahead);
    const lode_sincos_t rotor = lode_estimator_rotor(&self->estimator);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    if (self->state.run.proving == 0u) {
        self->losses = 0u; // else it is the same start
    }
#endif
    lode_start_reset(&self->state.start, lode_angle_add(rotor, ahead),
                     self->estimator.pll.omega_rad_s, current_A);
    count_start(self);
    take_q_axis(self);
    lode_current_reset(&self->current, u_V, (lode_dq_t){0.0f, 0.0f});
    set_mode(self, LODE_MODE_START);
}

// By injection, until that is given up: then the vector is turned.
static bool finds_at_rest(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_HFI
    (void)self;
    return false;
#else
    return lode_hfi_is_on(&self->tuning->estimator.hfi) &&
           self->estimator.by.hfi.step != (uint_least8_t)LODE_HFI_UNDECIDED;
#endif
}

#ifndef LODE_WITHOUT_START_MEASUREMENT

// What the start has found corrects the inverter's model.
static void take_resistance(lode_drive_t *self, const lode_start_found_t *found) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    const float current_A = self->state.start.current_A;
    lode_inverter_correct(&self->inverter, &self->tuning->inverter, found->r_Ohm, found->dead_V,
                          current_A);
    const float more_Ohm = self->inverter.r_more_Ohm;
    const lode_emf_tuning_t *emf = &self->tuning->estimator.emf;
    const float most_Ohm = RESISTANCE_MORE_MAX * (emf->inv_b - emf->a_over_b);
    const float limit_V =
        lode_max(WRONG_RESISTANCE * most_Ohm * current_A, WRONG_PER_CALM * tuning->calm_V);
    self->inverter.r_more_Ohm = lode_clamp(more_Ohm, -most_Ohm, most_Ohm);
    if (more_Ohm * current_A > limit_V) { // no winding has so much
        lode_mode_fault(self, LODE_CHECK_RESISTANCE, more_Ohm, limit_V / current_A);
    }
}

#endif

#ifndef LODE_WITHOUT_PLAUSIBILITY

// An estimate that turns with the vector at speed, and an EMF of a size that no error of the motor's values explains:
// more current flows than is measured (S34). As long as a lock would have to hold.
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
    const lode_ab_t i_A = self->estimator.emf.i_A;
    return i_A.alpha * i_A.alpha + i_A.beta * i_A.beta;
}

// The current has fallen and is back, and with it the EMF has changed: the inverter gives another voltage for what passes for the
// same current (S43).
static LODE_NOINLINE void judge_drop(lode_drive_t *self, float change_V) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_emf_tuning_t *emf = &tuning->estimator.emf;
    const lode_start_t *start = &self->state.start;
    const float R_Ohm = emf->inv_b - emf->a_over_b;
    const float X_Ohm =
        start->omega_rad_s * lode_min(tuning->references.Lq_H, 1.0f / tuning->references.inv_Ld);
    const float limit_Ohm = OTHER_VOLTAGE * lode_sqrt(R_Ohm * R_Ohm + X_Ohm * X_Ohm);
    const float change_Ohm = change_V / lode_max(start->current_A, FLT_MIN);
    if (lode_plausibility_is_on(&tuning->plausibility) && change_Ohm > limit_Ohm) {
        lode_mode_fault(self, LODE_CHECK_RESISTANCE, change_Ohm, limit_Ohm);
    }
}

// SLOT_DEAD_TIME, half a round before and after watch_drop().
static void look_for_drop(lode_drive_t *self) {
    lode_drop_look(&self->state.start.drop, measured_A2(self));
}

// SLOT_REFERENCES. False: the drive is in FAULT.
static bool watch_drop(lode_drive_t *self) {
    lode_start_t *start = &self->state.start;
    const float asked_A2 = start->current_A * start->current_A;
    const bool flows = asked_A2 >= self->tuning->plausibility.i_min_A2;
    const lode_dq_t e_V = lode_park(self->estimator.emf.observer.e_V, start->at);
    float change_V = 0.0f;
    if (lode_drop_step(&start->drop, measured_A2(self), flows ? asked_A2 : 0.0f, e_V, &change_V)) {
        judge_drop(self, change_V);
    }
    return self->gates;
}

#endif

// SLOT_LAG: resistance and dead time, while the vector rests; then what the EMF tells of rotor and flux.
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

#ifndef LODE_WITHOUT_PLAUSIBILITY

#ifndef LODE_WITHOUT_HANDOVER_RETRY

// As is_astray() has found it.
static lode_fault_t astray(const lode_drive_t *self) {
    const lode_start_t *start = &self->state.start;
    const float omega = self->estimator.pll.omega_rad_s;
    const bool back = omega * start->omega_target < 0.0f;
    const float most =
        MUCH_FASTER * lode_max(lode_abs(start->omega_rad_s), self->tuning->start.omega_ready);
    return (lode_fault_t){.state = self->mode,
                          .stage = start->stage,
                          .criterion = (uint_least8_t)LODE_CRITERION_SPEED,
                          .measured = omega,
                          .limit = back ? 0.0f : lode_sign(omega) * most};
}

#endif

// Of a rotor that the load turns faster than the vector can hold: looks for it anew, as one that turns, or has done so often
// enough.
static LODE_NOINLINE void end_attempt(lode_drive_t *self) {
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    const uint_least8_t failed = self->state.start.failed;
    if (failed < LODE_START_LOSSES_MAX && self->tuning->start.catch_rounds > 0u) {
        self->guard.fault = astray(self);
        lode_mode_switch_off(self); // as the command is RUN, for no longer than the next period
        self->losses = (uint_least8_t)(failed + 1u);
        return;
    }
#endif
    lode_mode_fault(self, LODE_CHECK_WRONG_WAY, self->estimator.pll.omega_rad_s, 0.0f);
}

// A sure estimate of a rotor that the load turns: the other way than asked for while the vector does not, or much faster than
// the vector (S36).
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

// After watch_drop(). For as long as a lock would have to hold.
static void watch_load(lode_drive_t *self) {
    const uint32_t rounds = is_astray(self) ? self->guard.speed + 1u : 0u;
    self->guard.speed = (uint_least16_t)rounds;
    if (rounds >= self->tuning->start.lock_rounds) {
        end_attempt(self);
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

static void fail_start(lode_drive_t *self, const lode_fault_t *why) {
    lode_mode_fault(self, LODE_CHECK_START, why->measured, why->limit);
    self->guard.fault.stage = why->stage;
    self->guard.fault.criterion = why->criterion;
}

// An attempt that is not at speed has nothing to say yet: then it is the one before.
static LODE_NOINLINE void end_start(lode_drive_t *self) {
    const lode_fault_t last = self->guard.fault;
    const lode_fault_t now = unmet_now(self);
    const bool early = now.criterion < (uint_least8_t)LODE_CRITERION_EMF;
    const bool tells = last.criterion != (uint_least8_t)LODE_CRITERION_NONE;
    fail_start(self, early && tells ? &last : &now);
}

// What the attempt has not met is kept.
static LODE_NOINLINE void begin_attempt(lode_drive_t *self) {
    self->guard.fault = unmet_now(self);
    lode_start_again(&self->state.start, &self->tuning->start);
}

// SLOT_SPEED: where the vector goes.
static void aim_start(lode_drive_t *self) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    lode_start_t *start = &self->state.start;
    if (lode_start_catches(start) || finds_at_rest(self)) {
        return;
    }
    const bool stopping = is_stop(self);
    const bool at_rest = lode_abs(start->omega_rad_s) <= tuning->omega_step;
    const float target =
        stopping ? 0.0f : lode_sign(self->command.speed_rad_s) * tuning->omega_handover;
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

// Measures, judges, aims and hands over in a slot each: one is enough for a period.
static void follow_start(lode_drive_t *self, lode_slot_t slot) {
    if (self->command.mode != LODE_MODE_RUN) {
        lode_mode_switch_off(self);
    } else if (lode_mode_is_sensored(self)) { // there is nothing to start
        hand_over(self);
        self->state.run.fade = 0.0f;
    } else if (slot == SLOT_LAG) {
        measure_start(self);
    } else if (slot == SLOT_DEAD_TIME) {
#ifndef LODE_WITHOUT_PLAUSIBILITY
        look_for_drop(self);
#endif
        judge_start(self);
    } else if (slot == SLOT_SPEED) {
        aim_start(self);
    } else if (slot == SLOT_REFERENCES &&
               lode_start_is_ready(&self->state.start, &self->tuning->start)) {
        hand_over(self);
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

void lode_mode_follow(lode_drive_t *self) {
    const bool starts = lode_mode(self) == LODE_MODE_START;
    const lode_slot_t slot = lode_slot_of(self->steps);
#ifndef LODE_WITHOUT_PLAUSIBILITY
    if (starts && (slot == SLOT_GUARD || slot == SLOT_GUARD_2)) {
        return; // the guard has enough to do: a period later. 17 cycles of a start's dearest call
    }
#endif
    if (!lode_mode_is_sound(self) || (!starts && !lode_mode_fits(self))) {
        lode_mode_distrust(self); // before a wrong mode is followed
    } else if (starts) {
        follow_start(self, slot);
    } else if (self->command.mode == lode_mode(self)) {
        set_mode(self, lode_mode(self)); // steady again
    } else {
        lode_mode_switch_off(self);
    }
}

// The mode with all gates on that is asked for; OFF: none.
static lode_mode_t driven_mode(const lode_drive_t *self) {
    const lode_mode_t wanted = self->command.mode;
    if (wanted == LODE_MODE_RUN && (!is_stop(self) || finds_at_rest(self))) {
        return LODE_MODE_START;
    }
    return lode_mode_is_commissioning(wanted) ? wanted : LODE_MODE_OFF;
}

// The low sides come with their duties, one period on. False: nothing asks for them.
static bool begins_precharge(lode_drive_t *self, lode_mode_t driven) {
#ifdef LODE_WITHOUT_PRECHARGE
    (void)self;
    (void)driven;
    return false;
#else
    const lode_drive_tuning_t *tuning = self->tuning;
    bool flies = false;
    bool tries = false; // without pulses of the low sides, which would know a rotor that turns
#ifndef LODE_WITHOUT_FLYING_START
    flies = driven == LODE_MODE_START && tuning->fly.share_first > 0.0f;
#else
    (void)driven;
#endif
#ifndef LODE_WITHOUT_SIGNAL_CHECK
    tries = driven == LODE_MODE_START && tuning->signal_check.pulses > 0u && !flies;
#endif
    if (tuning->inverter.precharge_periods == 0u && !flies && !tries) {
        return false;
    }
    self->state.precharge = (lode_precharge_t){
        .part = (uint_least8_t)(flies ? LODE_PRECHARGE_PULSES : LODE_PRECHARGE_CHARGE),
        .rests = (uint_least8_t)(tries ? 1u : 0u)};
    // Those in force when the low sides come: a board may switch them on at once.
    set_duties(self, flies ? 1.0f : lode_min(DUTY_PRECHARGE, tuning->sense.duty_max));
    reset_guard(self);
    set_mode(self, LODE_MODE_PRECHARGE);
    return true;
#endif
}

static void follow_off(lode_drive_t *self) {
    const lode_mode_t driven = driven_mode(self);
    if (self->command.mode == LODE_MODE_CALIBRATE ||
        (driven == LODE_MODE_START && !self->calibrated)) {
        lode_sense_begin(&self->state.sums);
        set_mode(self, LODE_MODE_CALIBRATE);
    } else if (driven != LODE_MODE_OFF && !begins_precharge(self, driven)) {
        switch_on(self, driven);
    } else {
        // it stays off, or the low sides come first
    }
}

#ifndef LODE_WITHOUT_FLYING_START

// RUN by the angle and the speed found. The gates go on two periods from now; until then the terminals are
// open, and the voltage at them is the EMF.
static LODE_NOINLINE void take_flight(lode_drive_t *self, float theta_rad, float omega) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_sincos_t rotor = lode_sincos(theta_rad);
    const lode_sincos_t half = lode_sincos(0.5f * tuning->estimator.pll.ts_s * omega);
    self->u_V = (lode_dq_t){0.0f, tuning->estimator.psi_Wb * omega};
    switch_on(self, LODE_MODE_START);
    lode_estimator_begin_at(&self->estimator, &tuning->estimator, rotor, omega);
    const lode_dq_t emf = {0.0f, self->u_V.q * self->inverter.per_V};
    const lode_sincos_t first = lode_angle_add(rotor, half);
    const lode_sincos_t second = lode_angle_add(first, lode_angle_double(half));
    lode_inverter_write(&self->inverter, self->steps + 1u, lode_park_inverse(emf, first));
    lode_inverter_write(&self->inverter, self->steps, lode_park_inverse(emf, second));
    // A board may switch on at once, before the first duties of its own.
    self->duty = lode_mode_duties_at(lode_clarke_inverse(lode_park_inverse(emf, second)));
    self->i_A = (lode_dq_t){0.0f, 0.0f};
    self->lead = lode_angle_triple(half);
    self->direction = lode_sign(omega);
    run_at_once(self);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    self->state.run.proving = rounds_to_prove(self, self->estimator.pll.omega_rad_s);
#endif
}

// One period of pulses.
static LODE_NOINLINE void fly_on(lode_drive_t *self, const int32_t i[LODE_PHASES]) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const int32_t alpha = 2 * i[0] - i[1] - i[2];
    const int32_t beta = i[1] - i[2];
    const lode_ab_t i_A = {(float)alpha * tuning->sense.alpha_gain,
                           (float)beta * tuning->sense.beta_gain};
    const lode_fly_given_t given = {
        .ts_s = tuning->estimator.pll.ts_s,
        .i_max_A = tuning->references.i_max_A,
        .psi_Wb = tuning->estimator.psi_Wb,
        .Lq_H = tuning->references.Lq_H,
        .inv_Ld = tuning->references.inv_Ld,
        .duty_max = tuning->sense.duty_max,
        .omega_handover = tuning->start.omega_handover,
        .catch_rounds = tuning->start.catch_rounds,
        .v_bus_V = self->inverter.v_bus_V,
        .charge = (1.0f - DUTY_PRECHARGE) * (float)(int32_t)tuning->inverter.precharge_periods,
    };
    lode_fly_step(&self->state.precharge.by.fly, &tuning->fly, i_A, &given);
}

// Pulses. False: there is, or was, nothing to look for.
static LODE_NOINLINE bool follow_flight(lode_drive_t *self, const lode_sample_t *sample) {
    lode_precharge_t *precharge = &self->state.precharge;
    const lode_fly_t *fly = &precharge->by.fly;
    if (precharge->part != (uint_least8_t)LODE_PRECHARGE_PULSES) {
        return false;
    }
    fly_on(self, sample->i);
    set_duties(self,
               lode_clamp(1.0f - fly->share, 0.0f, 1.0f)); // the last word, as in a driven period
    if (fly->stage == (uint_least8_t)LODE_FLY_FOUND) {
        take_flight(self, fly->theta_rad, fly->omega_rad_s); // ends the precharge's state
        return true;
    }
    if (fly->stage == (uint_least8_t)LODE_FLY_SLOW) {
        precharge->rests = fly->rests;
        precharge->part = (uint_least8_t)LODE_PRECHARGE_CHARGE;
        return false;
    }
    return true;
}

#endif

#ifndef LODE_WITHOUT_SIGNAL_CHECK

// One period of it. False: there is, or was, nothing to check. Another attempt goes by the first one's check.
static LODE_NOINLINE bool check_signals(lode_drive_t *self, const lode_sample_t *sample) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_precharge_t *precharge = &self->state.precharge;
    lode_signal_check_t *check = &precharge->by.check;
    if (precharge->part != (uint_least8_t)LODE_PRECHARGE_CHECK) {
        precharge->part = (uint_least8_t)LODE_PRECHARGE_CHECK;
        lode_signal_check_begin(check, &tuning->signal_check,
                                precharge->rests > 0u && self->losses == 0u);
    }
    if (!lode_signal_check_goes_on(check, &tuning->signal_check)) {
        return false;
    }
    const lode_ab_t per_V =
        lode_signal_check_step(check, &tuning->signal_check, &tuning->sense, sample->i);
    self->duty = lode_mode_duties_at(lode_clarke_inverse(per_V));
    const float v_bus_V = self->inverter.v_bus_V;
    const lode_finding_t found =
        lode_signal_check_judge(check, &tuning->signal_check, v_bus_V, tuning->estimator.pll.ts_s);
    // By a bus that is none nothing is known of it: the guard's to say.
    const bool bus = lode_in_range(v_bus_V, tuning->guard.v_bus_min, tuning->guard.v_bus_max);
    if (bus && found.check != LODE_CHECK_NONE) {
        lode_mode_fault(self, found.check, found.measured, found.limit);
    }
    return true;
}

#endif

#ifndef LODE_WITHOUT_PRECHARGE

// START after the check of a rotor that is told salient: with the vector ahead of its axis, if that is known (S40).
static LODE_NOINLINE void switch_on_ahead(lode_drive_t *self, lode_mode_t driven) {
#ifdef LODE_WITHOUT_SIGNAL_CHECK
    switch_on(self, driven);
#else
    const lode_references_tuning_t *motor = &self->tuning->references;
    const lode_sincos_t axis = lode_signal_check_axis(&self->state.precharge.by.check);
    const bool known = lode_abs(axis.sin) + lode_abs(axis.cos) > 0.0f;
    switch_on(self, driven); // ends the precharge's state
    if (driven == LODE_MODE_START && known && motor->Lq_H * motor->inv_Ld > 1.0f) {
        lode_start_lead(&self->state.start, axis, self->command.speed_rad_s);
    }
#endif
}

static void follow_precharge(lode_drive_t *self, const lode_sample_t *sample) {
    const lode_mode_t driven = driven_mode(self);
    if (driven == LODE_MODE_OFF) {
        lode_mode_switch_off(self);
        return;
    }
#ifdef LODE_WITHOUT_FLYING_START
    (void)sample;
#else
    if (follow_flight(self, sample)) {
        return;
    }
#endif
    if (self->state.precharge.periods < self->tuning->inverter.precharge_periods) {
        self->state.precharge.periods++;
        set_duties(self, lode_min(DUTY_PRECHARGE, self->tuning->sense.duty_max));
        return;
    }
#ifndef LODE_WITHOUT_SIGNAL_CHECK
    if (check_signals(self, sample)) {
        return;
    }
#endif
    switch_on_ahead(self, driven);
}

#endif

static void follow_calibrate(lode_drive_t *self, lode_calibration_t calibration,
                             float offset_count) {
    if (calibration == LODE_CALIBRATION_IMPLAUSIBLE) {
        const float limit = (float)self->tuning->sense.offset_tol / (float)LODE_COUNT_FRACTION;
        lode_mode_fault(self, LODE_CHECK_OFFSET, offset_count, limit);
    } else if (calibration == LODE_CALIBRATION_STUCK) {
        lode_mode_fault(self, LODE_CHECK_CURRENT_STUCK, offset_count, 0.0f);
    } else if (calibration == LODE_CALIBRATION_DONE) {
        self->calibrated = true;
        set_mode(self, LODE_MODE_OFF);
        if (self->command.mode == LODE_MODE_CALIBRATE) {
            self->command.mode = LODE_MODE_OFF;
            self->command.check = lode_mode_order_check(&self->command);
        }
    } else if (self->command.mode == LODE_MODE_OFF) {
        set_mode(self, LODE_MODE_OFF);
    } else {
        // more samples are to come
    }
}

// At most one transition per period.
void lode_mode_idle(lode_drive_t *self, lode_words_t tuning, const lode_sample_t *sample,
                    lode_calibration_t calibration, float offset_count) {
    if (!lode_mode_memory_ok(self, tuning)) {
        lode_mode_distrust(self);
        return;
    }
#ifdef LODE_WITHOUT_PRECHARGE
    (void)sample;
#endif
    switch (lode_mode(self)) {
    case LODE_MODE_OFF:
        follow_off(self);
        break;
    case LODE_MODE_CALIBRATE:
        follow_calibrate(self, calibration, offset_count);
        break;
#ifndef LODE_WITHOUT_PRECHARGE
    case LODE_MODE_PRECHARGE:
        follow_precharge(self, sample);
        break;
#endif
    case LODE_MODE_FAULT:
    case LODE_MODE_VOLTAGE: // these have the gates on
    case LODE_MODE_CURRENT:
    case LODE_MODE_START:
    case LODE_MODE_RUN:
    default:
        if (lode_mode_clears_fault(self)) {
            lode_guard_reset(&self->guard);
            lode_mode_switch_off(self);
        }
        break;
    }
}

// Rotation of a frame until the middle of its duties, at `step_rad` per period.
static lode_sincos_t lead_of(float step_rad) {
    return lode_angle_triple(lode_sincos_small(0.5f * step_rad));
}

#ifndef LODE_WITHOUT_COMMISSIONING

// A commanded vector, shortened to `radius` where it is longer.
static lode_dq_t in_circle(lode_dq_t x, float radius) {
    const float length = lode_ab_length((lode_ab_t){x.d, x.q});
    const float scale = length > radius ? radius / length : 1.0f;
    return (lode_dq_t){scale * x.d, scale * x.q};
}

static lode_control_frame_t commanded_frame(lode_drive_t *self) {
    if (lode_mode(self) == LODE_MODE_CURRENT) {
        self->ref_A = in_circle(self->command.value.vector, self->tuning->references.i_max_A);
    } else {
        const float radius_V = self->tuning->current.circle * self->inverter.v_bus_V;
        self->u_V = in_circle(self->command.value.vector, radius_V);
    }
    const float step_rad = self->tuning->estimator.pll.ts_s * self->command.speed_rad_s;
    const lode_sincos_t at = lode_sincos(self->state.theta_rad);
    self->state.theta_rad = lode_wrap(self->state.theta_rad + step_rad);
    return (lode_control_frame_t){at, lode_angle_triple(lode_sincos(0.5f * step_rad))};
}

#endif

// The start's vector one period on.
static lode_control_frame_t start_frame(lode_drive_t *self) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    lode_start_t *start = &self->state.start;
    const lode_ab_t e_V = self->estimator.emf.observer.e_V;
    const float ts_s = self->tuning->estimator.pll.ts_s;
    const float step_rad =
        lode_start_catches(start) ? 0.0f : lode_start_step(start, tuning, e_V, ts_s);
    self->ref_A = (lode_dq_t){start->current_A, 0.0f};
    return (lode_control_frame_t){lode_start_vector(start), lead_of(step_rad)};
}

lode_control_frame_t lode_mode_control_frame(lode_drive_t *self) {
#ifndef LODE_WITHOUT_COMMISSIONING
    if (lode_mode(self) != LODE_MODE_START) {
        return commanded_frame(self);
    }
#endif
    return start_frame(self);
}

// At low speed in START there is no EMF to go by: from time to time the estimator is set to the vector.
bool lode_mode_seed(lode_drive_t *self) {
    const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
    const lode_start_t *start = &self->state.start;
    if (lode_estimator_injects(&self->estimator)) {
        return false; // it goes by injection
    }
    // A vector turns the rotor as fast as it turns itself, whatever the torque.
    const bool held = lode_mode(self) == LODE_MODE_START && !lode_start_catches(start);
    if (held && lode_abs(start->omega_rad_s) < LODE_START_HOLD * self->tuning->start.omega_ready) {
        lode_estimator_hold(&self->estimator, tuning, start->at, start->omega_rad_s);
        return false;
    }
    return lode_estimator_seed(&self->estimator, tuning, held);
}

#ifndef LODE_WITHOUT_HFI

// North is south.
static void turn_round(lode_drive_t *self) {
    lode_estimator_t *estimator = &self->estimator;
    estimator->pll.frame.sin = -estimator->pll.frame.sin;
    estimator->pll.frame.cos = -estimator->pll.frame.cos;
    estimator->id_A = -estimator->id_A;
    lode_hfi_turn_round(&estimator->by.hfi);
    self->i_A = (lode_dq_t){-self->i_A.d, -self->i_A.q};
    self->u_V = (lode_dq_t){-self->u_V.d, -self->u_V.q};
    lode_current_reset(&self->current, self->u_V, (lode_dq_t){0.0f, 0.0f});
}

// Injection found no axis, or nothing tells polarity: the vector finds it, from where it would have begun.
static void give_up(lode_drive_t *self) {
    lode_estimator_restart(&self->estimator, &self->tuning->estimator);
    self->estimator.by.alone.step = (uint_least8_t)LODE_HFI_UNDECIDED;
    lode_current_reset(&self->current, (lode_dq_t){0.0f, 0.0f}, (lode_dq_t){0.0f, 0.0f});
    if (is_stop(self)) { // it would turn the rotor
        const lode_fault_t why = {.stage = self->state.start.stage,
                                  .criterion = (uint_least8_t)LODE_CRITERION_POLARITY,
                                  .measured = self->estimator.lock,
                                  .limit = LODE_LOCK_HANDOVER};
        fail_start(self, &why);
    }
}

// The current of LODE_HFI_PUSH (H25).
static LODE_NOINLINE lode_dq_t pushing_A(lode_drive_t *self) {
    const lode_start_tuning_t *start = &self->tuning->start;
    const lode_hfi_tuning_t *tuning = &self->tuning->estimator.hfi;
    lode_estimator_t *estimator = &self->estimator;
    if (is_stop(self)) { // which a rotor that is pushed would not
        estimator->by.hfi.step = (uint_least8_t)LODE_HFI_UNDECIDED;
        return (lode_dq_t){0.0f, 0.0f};
    }
    const float direction = lode_sign(self->command.speed_rad_s);
    const float step_rad = self->tuning->estimator.pll.ts_s * estimator->pll.omega_rad_s;
    const float share = lode_hfi_push(&estimator->by.hfi, tuning, lode_estimator_rotor(estimator),
                                      direction * step_rad, direction);
    if (estimator->by.hfi.step != (uint_least8_t)LODE_HFI_PUSH) {
        estimator->pll.f_rad_s2 = 0.0f; // from now on the torque is known that it stood for
    }
    const float most_A = start->current_last_A;
    const float along_A =
        lode_min(ALONG_SHARE * most_A, ALONG_FLUX / lode_max(start->lost_per_A, FLT_MIN));
    const float across_A = lode_sqrt(most_A * most_A - along_A * along_A);
    return (lode_dq_t){-along_A, direction * share * across_A};
}

// START, when a rotor that turns has been looked for.
static void find_at_rest(lode_drive_t *self) {
    lode_estimator_t *estimator = &self->estimator;
    lode_hfi_t *hfi = &estimator->by.hfi;
    const lode_hfi_tuning_t *tuning = &self->tuning->estimator.hfi;
    if (!hfi->active) {
        lode_estimator_restart(estimator, &self->tuning->estimator);
        const lode_ab_t i_A = estimator->emf.i_A;
        lode_hfi_begin(hfi, tuning, (lode_dq_t){i_A.alpha, i_A.beta});
    }
    estimator->gains = lode_pll_gains_of(&self->tuning->estimator.pll, tuning->find_gain);
    if (hfi->step == (uint_least8_t)LODE_HFI_RIGHT) {
        run_at_once(self); // it stands still, or nearly so, and the currents are in its frame
        return;
    }
    if (hfi->step == (uint_least8_t)LODE_HFI_PUSH) {
        self->ref_A = pushing_A(self);
    } else {
        const float i_max_A = self->tuning->references.i_max_A;
        self->ref_A = (lode_dq_t){lode_hfi_find(hfi, tuning, i_max_A), 0.0f};
    }
    switch ((lode_hfi_step_t)hfi->step) {
    case LODE_HFI_FIND: // (H14): of third order the loop would wind up its speed, and slip
        estimator->gains = (lode_pll_gains_t){tuning->find_gain, 0.0f, 0.0f};
        estimator->pll.omega_rad_s = 0.0f;
        estimator->pll.f_rad_s2 = 0.0f;
        estimator->pll.rise_rad_s = 0.0f;
        break;
    case LODE_HFI_WRONG: // RUN comes with the next round, and an angle that is right from its start
        turn_round(self);
        hfi->step = (uint_least8_t)LODE_HFI_RIGHT;
        break;
    case LODE_HFI_UNDECIDED:
        give_up(self);
        break;
    case LODE_HFI_NORTH:
    case LODE_HFI_SOUTH:
    case LODE_HFI_PUSH:
    case LODE_HFI_RIGHT: // RUN the same
    default:
        break;
    }
}

// RUN, about to trip for lost lock, at a speed from which injection can find the rotor.
static bool is_lost(const lode_drive_t *self) {
    return loses_lock(self) && self->losses < LOSSES_MAX &&
           lode_abs(self->estimator.pll.omega_rad_s) <
               LOST_SPEED * self->tuning->estimator.hfi.omega_high;
}

// As from OFF, with the gates on: by the EMF of a rotor that turns, else by injection.
static void find_again(lode_drive_t *self) {
    self->losses++;
    self->guard.lock = 0u;
    lode_estimator_restart(&self->estimator, &self->tuning->estimator);
    take_q_axis(self);
    lode_current_reset(&self->current, (lode_dq_t){0.0f, 0.0f}, (lode_dq_t){0.0f, 0.0f});
    lode_start_begin(&self->state.start, &self->tuning->start);
    self->state.start.failed = self->losses;
    self->start_rounds = 0u;
    set_mode(self, LODE_MODE_START);
}

static void inject_running(lode_drive_t *self) {
    lode_estimator_t *estimator = &self->estimator;
    const float omega = estimator->pll.omega_rad_s;
    if (self->losses > 0u && self->steps / LODE_SLOW_PERIODS % FORGET_ROUNDS == 0u) {
        self->losses--;
    }
    if (is_lost(self)) {
        find_again(self);
        return;
    }
    if (lode_hfi_follow(&estimator->by.hfi, &self->tuning->estimator.hfi, self->i_A, omega)) {
        const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
        estimator->gains = lode_pll_gains_of(&tuning->pll, tuning->hfi.find_gain);
        self->direction = lode_sign(omega); // either is as good
    } else {
        lode_estimator_end_injection(estimator, &self->tuning->estimator);
    }
}

LODE_NOINLINE bool lode_mode_inject(lode_drive_t *self) {
    const lode_mode_t mode = lode_mode(self);
    if (mode == LODE_MODE_START && !lode_start_catches(&self->state.start) && finds_at_rest(self)) {
        find_at_rest(self);
    } else if (mode == LODE_MODE_RUN && !lode_mode_is_sensored(self)) {
        inject_running(self);
    } else {
        lode_estimator_end_injection(&self->estimator, &self->tuning->estimator);
    }
    lode_hfi_t *hfi = &self->estimator.by.hfi;
    if (!hfi->active) {
        return false;
    }
    // Where current control is free beside it, the modulator is with the wave.
    hfi->reserve_V = self->tuning->estimator.hfi.V_h_V / self->tuning->current.free;
    lode_estimator_drop_disturbance(&self->estimator, &self->tuning->estimator);
    return true;
}

#endif

LODE_NOINLINE void lode_mode_adopt(lode_drive_t *self, const lode_estimate_t *estimate) {
    self->sensored = estimate->source == LODE_ESTIMATE_SENSOR ? SENSOR_ROUNDS : 0u;
    if (!self->gates || estimate->source == LODE_ESTIMATE_OWN) {
        return;
    }
    lode_estimator_t *own = &self->estimator;
    const float load_per_f = self->tuning->estimator.load_per_f_Nm;
    const float sum = lode_abs(estimate->i_A.d) + lode_abs(estimate->i_A.q) +
                      lode_abs(estimate->rotor.cos) + lode_abs(estimate->rotor.sin) +
                      lode_abs(estimate->omega_rad_s) + lode_abs(estimate->load_torque_Nm) +
                      lode_abs(estimate->e_V.alpha) + lode_abs(estimate->e_V.beta);
    if (!lode_is_finite(sum) || !lode_in_range(estimate->lock, 0.0f, 1.0f)) {
        lode_mode_fault(self, LODE_CHECK_NON_FINITE, 1.0f, 0.0f);
        return;
    }
    const float step_rad = self->tuning->estimator.pll.ts_s * estimate->omega_rad_s;
    own->pll.omega_rad_s = estimate->omega_rad_s;
    lode_estimator_move_lag(own, &self->tuning->estimator, estimate->omega_rad_s);
    own->pll.frame =
        lode_angle_subtract(estimate->rotor, lode_lag_near(&own->lag, own->pll.omega_rad_s));
    own->pll.f_rad_s2 = load_per_f < 0.0f ? estimate->load_torque_Nm / load_per_f : 0.0f;
    own->pll.rise_rad_s = self->tuning->estimator.pll.ts_s * own->pll.f_rad_s2;
    own->id_A = estimate->i_A.d;
    own->emf.observer.e_V = estimate->e_V;
    own->lock = estimate->lock;
    own->locked = estimate->lock >= LODE_LOCK_LOST;
    own->aligned = own->locked;
    own->found = 1u;
#ifndef LODE_WITHOUT_HFI
    lode_estimator_end_injection(own, &self->tuning->estimator); // nothing is to be found by it
    own->by.alone.step = (uint_least8_t)LODE_HFI_UNDECIDED;
#endif
    if (lode_mode_is_sensored(self)) {
        self->direction = lode_sign(estimate->omega_rad_s);
    }
    self->lead = lode_angle_triple(lode_sincos(0.5f * step_rad));
}

lode_estimate_t lode_mode_estimate(const lode_drive_t *self) {
    const lode_estimator_t *estimator = &self->estimator;
    return (lode_estimate_t){
        .omega_rad_s = estimator->pll.omega_rad_s,
        .rotor = lode_estimator_rotor(estimator),
        .i_A = self->i_A,
        .e_V = estimator->emf.observer.e_V,
        .load_torque_Nm = lode_estimator_load_torque_Nm(estimator, &self->tuning->estimator),
        .lock = estimator->lock,
        .source = LODE_ESTIMATE_OWN,
    };
}
