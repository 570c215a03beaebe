#include "mode_parts.h"

#include "estimator_inline.h"
#include "inverter_inline.h"
#include "open_phase_inline.h"
#include "references_inline.h"
#include "sense_inline.h"
#include "speed_inline.h"
#include "start_inline.h"

#include <stddef.h>

// A sensor's estimate counts as present in the whole round of slow jobs that follows it.
#define SENSOR_ROUNDS 2u
// Sum of all magnitudes of an external estimate, in SI units: far beyond any motor, and products of such numbers are finite.
#define ESTIMATE_MOST 1.0e6f

void lode_mode_set(lode_drive_t *self, lode_mode_t mode) {
    self->mode = (uint_least8_t)mode;
    self->mode_not = (uint_least8_t)(MODE_BITS ^ (uint32_t)mode);
    self->steady = self->gates && !self->mail && mode == LODE_MODE_RUN &&
                   self->tuning->speed_periods == LODE_SLOW_PERIODS;
}

// The samples to leave out, after a change of the sensing or of the duties that act.
static void set_omitted(lode_drive_t *self) {
    self->omitted = lode_sense_omit_both(lode_sense_omitted(&self->tuning->sense, self->duty));
}

// Gates off, no voltage pending.
static LODE_SMALL_CALL void open_gates(lode_drive_t *self, lode_mode_t mode) {
    self->gates = false;
    self->losses = 0u;
    self->calm = 0u;
    lode_mode_set_duties(self, LODE_DUTY_IDLE);
    set_omitted(self);
    const lode_ab_t none = {0.0f, 0.0f};
    self->inverter.written[0] = self->inverter.written[1] = none;
    lode_mode_set(self, mode);
}

LODE_NOINLINE void lode_mode_switch_off(lode_drive_t *self) {
    open_gates(self, LODE_MODE_OFF);
    self->i_A = (lode_dq_t){0.0f, 0.0f};
    self->ref_A = (lode_dq_t){0.0f, 0.0f};
    self->u_V = (lode_dq_t){0.0f, 0.0f};
    lode_estimator_reset(&self->estimator, &self->tuning->estimator);
}

LODE_NOINLINE lode_fault_t lode_mode_unmet(const lode_drive_t *self) {
    const lode_start_unmet_t unmet = lode_start_unmet(&self->state.start, &self->tuning->start,
                                                      &self->estimator, &self->tuning->estimator);
    return (lode_fault_t){.state = self->mode,
                          .stage = self->state.start.stage,
                          .criterion = (uint_least8_t)unmet.criterion,
                          .measured = unmet.measured,
                          .limit = unmet.limit};
}

void lode_mode_reset_guard(lode_drive_t *self) {
    const lode_fault_t last = self->guard.fault;
    lode_guard_reset(&self->guard);
    if (lode_mode_retries(self)) {
        self->guard.fault = last;
    }
}

#ifndef LODE_WITHOUT_HANDOVER_RETRY

LODE_NOINLINE void lode_mode_end_attempt(lode_drive_t *self, const lode_fault_t *why,
                                         uint32_t failed, uint32_t calm) {
    self->guard.fault = *why;
    lode_mode_switch_off(self); // lasts for one period, as long as the command is RUN
    self->losses = (uint_least8_t)failed;
    self->calm = (uint_least8_t)calm;
}

// Ends an attempt that RUN has not proven yet; the start begins again (S28). False: there is none, it was the last one, or an
// encoder gives the angle.
static bool try_again(lode_drive_t *self, lode_criterion_t criterion, float measured, float limit) {
    // An encoder would be as wrong in the next attempt. (The coarse speed of Hall switches contradicts the EMF for a moment only.)
    const bool by_encoder = lode_mode_is_sensored(self) && !self->edges;
    const lode_running_t *run = &self->state.run;
    if (run->proving == 0u || by_encoder || self->losses >= LODE_START_LOSSES_MAX) {
        return false;
    }
    const lode_fault_t why = {.state = self->mode,
                              .criterion = (uint_least8_t)criterion,
                              .measured = measured,
                              .limit = limit};
    lode_guard_withdraw(&self->guard);
    // (K51): the gains may have lost the rotor.
    lode_mode_end_attempt(self, &why, self->losses + 1u, lode_speed_calmer(run->speed.calmed));
    return true;
}

LODE_NOINLINE bool lode_mode_doubts_phase(lode_drive_t *self, uint_least8_t phase) {
#ifdef LODE_WITHOUT_SIGNAL_CHECK
    (void)self, (void)phase;
    return false;
#else
    const bool checked = self->tuning->signal_check.pulses > 0u;
    return phase > 0u && checked && self->state.run.proving != LODE_PROVING_ENDLESS &&
           try_again(self, LODE_CRITERION_OPEN_PHASE, (float)phase, 0.0f);
#endif
}

// The phase that seems to be open, from 1 (K41); 0: none.
static uint_least8_t suspected(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    return 0u;
#else
    return lode_half_waves_suspect(&self->state.run.waves);
#endif
}

LODE_NOINLINE void lode_mode_prove_start(lode_drive_t *self) {
    if (lode_mode(self) == LODE_MODE_RUN && lode_guard_found_nothing_else(&self->guard) &&
        lode_mode_loses_lock(self) && !lode_mode_doubts_phase(self, suspected(self))) {
        (void)try_again(self, LODE_CRITERION_PROOF, self->estimator.lock, LODE_LOCK_LOST);
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
        self->guard.fresh = true;
        self->losses = failed; // failed attempts stay readable with the fault
    }
}

LODE_NOINLINE void lode_mode_fault(lode_drive_t *self, lode_check_t check, float measured,
                                   float limit) {
    lode_guard_trip(&self->guard, self->mode, check, measured, limit);
    lode_mode_obey_guard(self);
}

void lode_mode_trip_memory(lode_drive_t *self, lode_memory_t corrupted) {
    lode_mode_fault(self, LODE_CHECK_MEMORY, (float)corrupted, 0.0f);
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
    self->command = (lode_order_t){.mode = (uint_least8_t)LODE_MODE_OFF};
    self->command.check = lode_mode_order_check(&self->command);
    self->direction = lode_sign(self->direction);
    const lode_memory_t other = mode ? LODE_MEMORY_TUNING : LODE_MEMORY_MODE;
    lode_mode_trip_memory(self, command ? other : LODE_MEMORY_COMMAND);
}

// Not LODE_RAMFUNC, like the check that follows: small fast memories have no room for it.
LODE_NOINLINE bool lode_mode_motion_ok(lode_drive_t *self) {
    if (lode_estimator_motion_ok(&self->estimator, &self->tuning->estimator)) {
        return true;
    }
    lode_mode_trip_memory(self, LODE_MEMORY_ESTIMATE);
    return false;
}

static bool limits_are_sound(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_TORQUE_LIMITS
    (void)self;
    return true;
#else
    return lode_mode_share_is_sound(self->torque_share[0]) &&
           lode_mode_share_is_sound(self->torque_share[1]);
#endif
}

LODE_NOINLINE bool lode_mode_speed_ok(lode_drive_t *self) {
    if (!limits_are_sound(self)) {
        lode_mode_trip_memory(self, LODE_MEMORY_TORQUE_LIMIT);
        return false;
    }
    const lode_speed_t *speed = &self->state.run.speed;
    if (!lode_speed_is_whole(speed) || !lode_speed_left_ok(speed)) {
        lode_mode_trip_memory(self, LODE_MEMORY_SPEED_CONTROL);
        return false;
    }
    return true;
}

LODE_NOINLINE void lode_mode_lose_rotor(lode_drive_t *self) {
    const uint32_t checks = self->tuning->guard.lock_checks;
    const uint32_t least = (LOST_SHARE * checks + LOST_PARTS - 1u) / LOST_PARTS;
    self->guard.lock = (uint_least16_t)(self->guard.lock < least ? least : self->guard.lock);
}

LODE_NOINLINE void lode_mode_note_trip(lode_drive_t *self, lode_ab_t i_A) {
    lode_estimator_set_current(&self->estimator, i_A);
    self->i_A = lode_park(i_A, lode_estimator_rotor(&self->estimator));
}

// The start goes on with the attempt after those that failed, in the time that is left. Without such attempts it is a new one.
static void take_up_attempts(lode_drive_t *self) {
#ifdef LODE_WITHOUT_HANDOVER_RETRY
    self->start_rounds = 0u;
#else
    self->start_rounds = lode_mode_retries(self) ? self->start_rounds : 0u;
    self->state.start.failed = self->losses;
#endif
}

void lode_mode_take_q_axis(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_current_take(&self->current, &tuning->current, tuning->references.Lq_H);
}

void lode_mode_switch_on(lode_drive_t *self, lode_mode_t mode) {
    const lode_drive_tuning_t *tuning = self->tuning;
    self->gates = true;
    self->sensored = 0u; // until the next external estimate
    lode_mode_set_duties(self, LODE_DUTY_IDLE);
    lode_mode_reset_guard(self);
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_plausibility_reset(&self->plausibility);
    self->frozen.checks = 0u;
    self->jump = (lode_jump_t){.stage = (uint_least8_t)LODE_JUMP_NONE};
#endif
    lode_estimator_reset(&self->estimator, &tuning->estimator);
    lode_inverter_adapt(&self->inverter, &tuning->inverter, self->u_V);
    lode_mode_take_q_axis(self);
    lode_current_reset(&self->current, (lode_dq_t){0.0f, 0.0f}, (lode_dq_t){0.0f, 0.0f});
    lode_start_begin(&self->state.start, &tuning->start);
    take_up_attempts(self);
#ifndef LODE_WITHOUT_COMMISSIONING
    if (mode != LODE_MODE_START) {
        self->state.theta_rad = self->command.theta_rad; // shares its memory with the start
    }
#endif
    lode_mode_set(self, mode);
}

// Resets the counters of RUN: the start uses those of lock and speed too (S34), (S36).
static void begin_counts(lode_drive_t *self) {
    self->guard.lock = 0u;
    self->guard.speed = 0u;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    self->guard.flux_rounds = 0u;
    self->state.run.off = 0u;
    self->state.run.waves = (lode_half_waves_t){.idle = 0u};
    self->state.run.load = (lode_load_t){.held_rad_s = self->estimator.pll.omega_rad_s};
#endif
}

#ifndef LODE_WITHOUT_HANDOVER_RETRY

uint_least16_t lode_mode_rounds_to_prove(const lode_drive_t *self, float omega_rad_s) {
    const bool opposite = omega_rad_s * self->command.speed_rad_s < 0.0f;
    return opposite ? LODE_PROVING_ENDLESS : self->tuning->start.patience_rounds;
}

#endif

// Speed control at the beginning of RUN, which overwrites state.start: at the estimated speed.
static void begin_speed(lode_drive_t *self, float torque_Nm) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_estimator_t *estimator = &self->estimator;
    lode_speed_t *speed = &self->state.run.speed;
    lode_speed_reset(speed, &tuning->speed,
                     estimator->pll.omega_rad_s * tuning->speed.inv_pole_pairs, torque_Nm,
                     lode_estimator_load_torque_Nm(estimator, &tuning->estimator),
                     lode_references_most_Nm(&tuning->references));
    speed->limit_Nm = lode_mode_torque_limits(self, speed->limit_Nm);
    speed->calmed = self->calm;
}

#if !defined(LODE_WITHOUT_FLYING_START) || !defined(LODE_WITHOUT_HFI)

void lode_mode_run_at_once(lode_drive_t *self) {
    begin_speed(self, 0.0f); // from here on, state.start is gone
    lode_running_t *run = &self->state.run;
    run->fade = 0.0f;
    run->id_A = 0.0f;
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    run->proving = 0u; // nothing to prove with injection; a flying start sets it
#endif
    begin_counts(self);
    lode_references_reset(&run->references, self->i_A.d);
    self->ref_A = (lode_dq_t){0.0f, 0.0f}; // until SLOT_REFERENCES
    lode_mode_set(self, LODE_MODE_RUN);
}

#endif

float lode_mode_most_rad_s(const lode_drive_tuning_t *tuning) {
    const float estimator = tuning->estimator.omega_limit / LODE_ALIAS_SHARE;
    return lode_min(estimator, tuning->guard.omega_max) * tuning->speed.inv_pole_pairs;
}

// A speed that may no longer be commanded becomes the largest one. A corrupted command stays as it is, for the memory check.
static void bound_command(lode_drive_t *self) {
    const float most = lode_mode_most_rad_s(self->tuning);
    lode_order_t *order = &self->command;
    if (order->mode == (uint_least8_t)LODE_MODE_RUN && lode_abs(order->speed_rad_s) > most &&
        lode_mode_order_check(order) == order->check) {
        order->speed_rad_s = lode_clamp(order->speed_rad_s, -most, most);
        order->check = lode_mode_order_check(order);
    }
}

// What was measured beyond the configured values is less where these have come closer. Where nothing was measured, the new
// ones count as they are.
static void keep_measured(lode_inverter_t *inverter, const lode_drive_tuning_t *before,
                          const lode_drive_tuning_t *now) {
#ifdef LODE_WITHOUT_START_MEASUREMENT
    (void)inverter;
    (void)before;
    (void)now;
#else
    if (!(lode_abs(inverter->dead_more) + lode_abs(inverter->r_more_Ohm) > 0.0f)) {
        return;
    }
    const float more = now->inverter.dead_more_max;
    const float longer = now->inverter.dead_duty - before->inverter.dead_duty;
    inverter->dead_more = lode_clamp(inverter->dead_more - longer, -more, more);
    const float r_more_Ohm = inverter->r_more_Ohm - (now->start.R_Ohm - before->start.R_Ohm);
    const float most_Ohm = LODE_R_MORE_MAX * now->start.R_Ohm;
    inverter->r_more_Ohm = lode_clamp(r_more_Ohm, -most_Ohm, most_Ohm);
#endif
}

void lode_mode_retune_ramp(lode_drive_t *self, const lode_drive_tuning_t *before) {
#ifdef LODE_WITHOUT_SHAPED_RAMP
    (void)self;
    (void)before;
#else
    const lode_drive_tuning_t *now = self->tuning;
    const float longer = (float)now->speed_periods / (float)before->speed_periods;
    lode_speed_t *speed = &self->state.run.speed;
    // The slope goes on, in steps of another length; without a limit of the jerk nothing is left over of it.
    speed->step_rad_s = now->speed.jerk_step > 0.0f ? longer * speed->step_rad_s : 0.0f;
#endif
}

static void retune_run(lode_drive_t *self, const lode_drive_tuning_t *before) {
    const lode_drive_tuning_t *now = self->tuning;
    lode_running_t *run = &self->state.run;
    const float most = now->estimator.omega_limit * now->speed.inv_pole_pairs;
    lode_speed_bound(&run->speed, most);
    if (before->references.options == 0u) { // they were not kept up to date
        lode_references_reset(&run->references, self->ref_A.d);
    }
    lode_mode_retune_ramp(self, before);
}

void lode_mode_retune(lode_drive_t *self, const lode_drive_tuning_t *before) {
    if (self->gates) { // otherwise it begins anew, and FAULT keeps what it was at the trip
        lode_estimator_retune(&self->estimator, &before->estimator, &self->tuning->estimator);
    }
    keep_measured(&self->inverter, before, self->tuning);
    bound_command(self);
    if (lode_mode(self) == LODE_MODE_RUN) {
        retune_run(self, before);
    }
}

// Clears a fault once: a later one stays while the same command lasts, as that is not OFF.
static bool clear_at_once(lode_drive_t *self) {
    if (self->command.mode == (uint_least8_t)LODE_MODE_OFF || !lode_mode_clears(&self->command)) {
        return false;
    }
    if (lode_mode(self) == LODE_MODE_FAULT) {
        lode_guard_reset(&self->guard);
        lode_mode_switch_off(self);
    }
    return true;
}

LODE_NOINLINE bool lode_mode_take_mail(lode_drive_t *self) {
    bool clears = false;
    LODE_SHARED_STORE(self->mail, false);
    LODE_SIGNAL_FENCE();
    if (self->posted_tuning != NULL) {
        const lode_drive_tuning_t *before = self->tuning;
        self->tuning = self->posted_tuning;
        lode_tuning_take_check(self);
        lode_mode_retune(self, before);
        lode_mode_take_q_axis(self);
        LODE_SHARED_STORE(self->posted_tuning, NULL);
        set_omitted(self);
    }
    if (self->command_posted == LODE_POST_FULL) {
        self->command = self->posted;
        bound_command(self);     // it was checked against the tuning of that moment
        self->posted.flags = 0u; // clears no other fault
        LODE_SHARED_STORE(self->command_posted, LODE_POST_NONE);
        clears = clear_at_once(self);
    }
    return clears;
}

LODE_NOINLINE bool lode_mode_mail_ok(lode_drive_t *self) {
    LODE_SHARED_STORE(self->mail, true); // was lost, or is about to be set
    LODE_SHARED_STORE(self->steady, false);
    return self->command_posted == LODE_POST_FULL;
}

// A vector, seen from a frame that is `ahead` of its own.
static lode_dq_t in_frame(lode_dq_t x, lode_sincos_t ahead) {
    return lode_park((lode_ab_t){x.d, x.q}, ahead);
}

// From the I-f frame to the rotor's (S10): voltage and current stay, only their components change. The start current then
// fades.
void lode_mode_hand_over(lode_drive_t *self) {
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
    begin_speed(self, torque); // from here on, state.start is gone
    lode_running_t *run = &self->state.run;
    run->fade = 1.0f;
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    run->proving = caught ? lode_mode_rounds_to_prove(self, omega) : tuning->start.patience_rounds;
#endif
    begin_counts(self);
    run->id_A = i_A.d - lode_references_id_A(&tuning->references, torque, omega);
    lode_references_reset(&run->references, i_A.d);
    self->ref_A = i_A; // until SLOT_REFERENCES
    self->direction = lode_sign(omega);
    lode_mode_set(self, LODE_MODE_RUN);
}

// (S56): the EMF in stator axes, with the flux that the d current of the vector, `id_A`, will leave.
static lode_ab_t emf_with(const lode_drive_t *self, lode_sincos_t rotor, float id_A) {
    const float salient_H = lode_references_salient_H(&self->tuning->references);
    const float more_V = self->estimator.pll.omega_rad_s * salient_H * (id_A - self->i_A.d);
    const lode_ab_t e_V = self->estimator.emf.observer.e_V;
    return lode_ab_add_scaled(e_V, more_V, (lode_ab_t){-rotor.sin, rotor.cos});
}

// (S11): the start current is placed ahead of the rotor by the angle at which it makes the present torque. (In the direction
// of the present current it might oppose the rotor.)
LODE_NOINLINE void lode_mode_hand_back(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float current_A = tuning->start.current_A;
    const float omega = self->estimator.pll.omega_rad_s;
    const float sine = lode_clamp(self->i_A.q / current_A, -1.0f, 1.0f);
    const lode_sincos_t ahead = {sine, lode_sqrt(1.0f - sine * sine)};
    const lode_dq_t next_A = {current_A * ahead.cos, current_A * ahead.sin};
    // (S55): START feeds nothing forward. Its integrators take over what RUN has fed forward, for the vector's current.
    const lode_dq_t induced_V =
        lode_references_induced_V(&tuning->references, self->current.Lq_H, next_A, omega);
    const lode_dq_t held_V = {self->current.d.integral + induced_V.d,
                              self->current.q.integral + induced_V.q};
    const lode_sincos_t rotor = lode_estimator_rotor(&self->estimator);
    const lode_ab_t e_V = emf_with(self, rotor, next_A.d);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    if (self->state.run.proving == 0u) {
        self->losses = 0u; // otherwise it is still the same start
    }
#endif
    self->calm = self->state.run.speed.calmed;
    self->guard.lock = 0u;
    self->guard.speed = 0u; // of RUN; (S34) and (S36) count with them
    lode_start_reset(&self->state.start, lode_angle_add(rotor, ahead), omega, current_A);
    lode_start_settle(&self->state.start, &tuning->start, e_V);
    take_up_attempts(self);
    lode_mode_take_q_axis(self);
    lode_current_reset(&self->current, in_frame(held_V, ahead), (lode_dq_t){0.0f, 0.0f});
    lode_mode_set(self, LODE_MODE_START);
}

void lode_mode_follow(lode_drive_t *self) {
    const bool starts = lode_mode(self) == LODE_MODE_START;
    const lode_slot_t slot = lode_slot_of(self->steps);
#ifndef LODE_WITHOUT_PLAUSIBILITY
    if (starts && (slot == SLOT_GUARD || slot == SLOT_GUARD_2)) {
        return; // the guard's slots are long: saves 17 cycles of a start's worst case. The other slots check and follow
    }
#endif
    if (!lode_mode_is_sound(self) || (!starts && !lode_mode_fits(self))) {
        lode_mode_distrust(self); // before a wrong mode acts
    } else if (starts) {
        lode_mode_follow_start(self, slot);
    } else if (self->command.mode == self->mode) {
        lode_mode_set(self, lode_mode(self)); // sets `steady` again
    } else {
        lode_mode_switch_off(self);
    }
}

// Rotation of a frame from t_k to the middle of the period in which its duties act, 1.5 periods of `step_rad`.
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

// Moves the start's vector on by a period.
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

// At low speed in START the EMF is too small to use: once per round the estimator is set to the vector.
bool lode_mode_seed(lode_drive_t *self) {
    const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
    const lode_start_t *start = &self->state.start;
    if (lode_estimator_injects(&self->estimator)) {
        return false; // injection gives the angle
    }
    // The rotor turns as fast as the vector, whatever the torque.
    const bool held = lode_mode(self) == LODE_MODE_START && !lode_start_catches(start);
    if (held && lode_abs(start->omega_rad_s) < LODE_START_HOLD * self->tuning->start.omega_ready) {
        lode_estimator_hold(&self->estimator, tuning, start->at, start->omega_rad_s);
        return false;
    }
    return lode_estimator_seed(&self->estimator, tuning, held);
}

LODE_NOINLINE void lode_mode_adopt(lode_drive_t *self, const lode_estimate_t *estimate) {
    self->edges = estimate->source == LODE_ESTIMATE_EDGES;
    self->sensored = self->edges || estimate->source == LODE_ESTIMATE_SENSOR ? SENSOR_ROUNDS : 0u;
    if (!self->gates || estimate->source == LODE_ESTIMATE_OWN ||
        estimate->source == LODE_ESTIMATE_NONE) {
        return;
    }
    lode_estimator_t *own = &self->estimator;
    const float load_per_f = self->tuning->estimator.load_per_f_Nm;
    const float sum = lode_abs(estimate->i_A.d) + lode_abs(estimate->i_A.q) +
                      lode_abs(estimate->rotor.cos) + lode_abs(estimate->rotor.sin) +
                      lode_abs(estimate->omega_rad_s) + lode_abs(estimate->load_torque_Nm) +
                      lode_abs(estimate->e_V.alpha) + lode_abs(estimate->e_V.beta);
    if (!(sum <= ESTIMATE_MOST) || !lode_in_range(estimate->lock, 0.0f, 1.0f)) {
        lode_mode_fault(self, LODE_CHECK_NON_FINITE, 1.0f, 0.0f);
        return;
    }
    // The observer's lag is known up to this speed, which is beyond that of OVER_SPEED by default. A sensor's count may be
    // wrong for a moment: there the guard's counter decides.
    const float most = self->tuning->estimator.omega_limit;
    const bool external = estimate->source == LODE_ESTIMATE_EXTERNAL;
    if (external && lode_abs(estimate->omega_rad_s) > most) {
        lode_mode_fault(self, LODE_CHECK_OVER_SPEED, self->direction * estimate->omega_rad_s, most);
        return;
    }
    own->pll.omega_rad_s = lode_clamp(estimate->omega_rad_s, -most, most);
    const float step_rad = self->tuning->estimator.pll.ts_s * own->pll.omega_rad_s;
    lode_estimator_forget_motion(own);
    lode_estimator_move_lag(own, &self->tuning->estimator, own->pll.omega_rad_s);
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
    lode_estimator_end_injection(own, &self->tuning->estimator); // nothing is left to find
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
        .source = LODE_ESTIMATE_NONE,
    };
}
