#include "drive_core.h"

LODE_NOINLINE void lode_core_switch_off(lode_drive_t *self, lode_mode_t mode) {
    lode_core_set_mode(self, mode);
    self->gates = false;
    self->duty = (lode_abc_t){LODE_DUTY_IDLE, LODE_DUTY_IDLE, LODE_DUTY_IDLE};
    const int32_t unsampled = lode_sense_unused(&self->tuning->sense, self->duty);
    self->unsampled = self->unsampled_next = (uint_least8_t)unsampled;
    self->i_A = (lode_dq_t){0.0f, 0.0f};
    self->ref_A = (lode_dq_t){0.0f, 0.0f};
    self->u_V = (lode_dq_t){0.0f, 0.0f};
    lode_inverter_reset(&self->inverter);
}

static void switch_on(lode_drive_t *self, lode_mode_t mode) {
    lode_core_set_mode(self, mode);
    self->gates = true;
    lode_guard_reset(&self->guard);
    lode_pi_reset(&self->current.d, 0.0f);
    lode_pi_reset(&self->current.q, 0.0f);
    if (mode == LODE_MODE_START) {
        lode_start_begin(&self->state.start, &self->tuning->start);
    } else {
        self->state.theta_rad = self->command.theta_rad;
    }
}

static void fault(lode_drive_t *self, lode_check_t check, float measured, float limit) {
    lode_guard_trip(&self->guard, self->mode, check, measured, limit);
}

LODE_NOINLINE void lode_core_take_mail(lode_drive_t *self) {
    self->mail = false;
    if (self->posted_tuning != NULL) {
        self->tuning = self->posted_tuning;
        self->posted_tuning = NULL;
    }
    if (self->command_posted) {
        self->command = self->posted;
        self->command_posted = false;
    }
}

static bool is_stop(const lode_drive_t *self) {
    return !(lode_abs(self->command.speed_rad_s) > 0.0f);
}

// The vector of the last voltage, seen from a frame `turn` ahead of the one it was commanded in.
static lode_dq_t seen_from(lode_dq_t x, lode_sincos_t turn) {
    return lode_park((lode_ab_t){x.d, x.q}, turn);
}

// From the I-f frame into the rotor's: voltage and current vectors stay, only their names change; then
// the start current fades from the d axis.
static void hand_over(lode_drive_t *self, const lode_estimate_t *est) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_sincos_t vector = lode_start_next(&self->state.start, &tuning->start);
    const lode_dq_t u_V = seen_from(self->u_V, lode_angle_subtract(est->rotor, vector));
    lode_current_reset(&self->current, &tuning->current, u_V, est->i_A, est->omega_rad_s);
    const float torque = lode_references_torque_Nm(&tuning->references, est->i_A);
    lode_running_t *run = &self->state.run; // takes the place of the start's
    lode_speed_reset(&run->speed, &tuning->speed, est->omega_rad_s * tuning->inv_pole_pairs, torque,
                     lode_estimator_load_torque_Nm(&self->estimator, &tuning->estimator));
    run->fade = 1.0f;
    run->id_A = est->i_A.d - lode_references_id_A(&tuning->references, torque, est->omega_rad_s);
    lode_references_reset(&run->references, est->i_A.d);
    self->ref_A = est->i_A; // until the speed control's turn
    self->direction = lode_sign(est->omega_rad_s);
    lode_core_set_mode(self, LODE_MODE_RUN);
}

// The way back: a start current ahead of the rotor by the angle at which it makes the torque that the
// present one makes. (In the direction of the present one it might be opposed to the rotor.)
LODE_NOINLINE void lode_core_hand_back(lode_drive_t *self, float omega_rad_s, lode_dq_t i_A) {
    const float current_A = self->tuning->start.current_A;
    const float sine = lode_clamp(i_A.q / current_A, -1.0f, 1.0f);
    const lode_sincos_t turn = {sine, lode_sqrt(1.0f - sine * sine)};
    const lode_dq_t u_V = seen_from(self->u_V, turn);
    lode_start_reset(&self->state.start, lode_angle_add(self->estimator.rotor, turn), omega_rad_s,
                     current_A);
    lode_current_reset(&self->current, &self->tuning->current, u_V, (lode_dq_t){current_A, 0.0f},
                       0.0f);
    lode_core_set_mode(self, LODE_MODE_START);
}

// Decides in one turn and hands over in the next: each is enough for a period.
static void follow_start(lode_drive_t *self, const lode_estimate_t *est) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    lode_start_t *start = &self->state.start;
    if (self->command.mode != LODE_MODE_RUN) {
        lode_core_switch_off(self, LODE_MODE_OFF);
        return;
    }
    if (self->steps % LODE_SLOW_PERIODS == TURN_HAND_OVER) {
        if (lode_start_is_ready(start, tuning)) {
            hand_over(self, est);
        }
        return;
    }
    lode_start_judge(start, tuning, est);
    if (start->catching > 0u) {
        return;
    }
    const bool stopping = is_stop(self);
    const bool at_rest = lode_abs(start->omega_rad_s) <= tuning->omega_step;
    const float target =
        stopping ? 0.0f : lode_sign(self->command.speed_rad_s) * tuning->omega_handover;
    lode_start_aim(start, tuning, target, stopping && at_rest ? 0.0f : tuning->current_A);
    if (stopping && at_rest && !(start->current_A > 0.0f)) {
        lode_core_switch_off(self, LODE_MODE_OFF);
    } else if (!stopping && start->turns > tuning->timeout_turns) {
        fault(self, LODE_CHECK_START, est->lock, LODE_LOCK_HANDOVER);
    }
}

static void follow_off(lode_drive_t *self) {
    const lode_mode_t wanted = self->command.mode;
    if (wanted == LODE_MODE_CALIBRATE ||
        (wanted == LODE_MODE_RUN && !is_stop(self) && !self->calibrated)) {
        lode_sense_begin(&self->state.sums);
        lode_core_set_mode(self, LODE_MODE_CALIBRATE);
    } else if (wanted == LODE_MODE_VOLTAGE || wanted == LODE_MODE_CURRENT) {
        switch_on(self, wanted);
    } else if (wanted == LODE_MODE_RUN && !is_stop(self)) {
        switch_on(self, LODE_MODE_START);
    }
}

static void follow_calibrate(lode_drive_t *self, lode_calibration_t calibration,
                             float offset_count) {
    if (calibration == LODE_CALIBRATION_IMPLAUSIBLE) {
        fault(self, LODE_CHECK_OFFSET, offset_count, self->tuning->sense.i_offset_tol);
    } else if (calibration == LODE_CALIBRATION_DONE) {
        self->calibrated = true;
        lode_core_set_mode(self, LODE_MODE_OFF);
        self->command.mode =
            self->command.mode == LODE_MODE_CALIBRATE ? LODE_MODE_OFF : self->command.mode;
    } else if (self->command.mode == LODE_MODE_OFF) {
        lode_core_set_mode(self, LODE_MODE_OFF);
    }
}

// The state machine: at most one transition per period.
LODE_NOINLINE void lode_core_follow_command(lode_drive_t *self, lode_calibration_t calibration,
                                            float offset_count, const lode_estimate_t *est) {
    switch (lode_core_mode(self)) {
    case LODE_MODE_OFF:
        follow_off(self);
        break;
    case LODE_MODE_CALIBRATE:
        follow_calibrate(self, calibration, offset_count);
        break;
    case LODE_MODE_VOLTAGE:
    case LODE_MODE_CURRENT:
    case LODE_MODE_RUN:
        if (self->command.mode != lode_core_mode(self)) {
            lode_core_switch_off(self, LODE_MODE_OFF);
        }
        break;
    case LODE_MODE_START:
        follow_start(self, est);
        break;
    case LODE_MODE_FAULT:
    default:
        if (self->command.mode == LODE_MODE_OFF && self->command.clear_fault) {
            lode_guard_reset(&self->guard);
            lode_core_switch_off(self, LODE_MODE_OFF);
        }
        break;
    }
}

// A commanded vector, shortened to `radius` where it is longer.
static lode_dq_t in_circle(lode_dq_t x, float radius) {
    const float length = lode_ab_length((lode_ab_t){x.d, x.q});
    const float scale = length > radius ? radius / length : 1.0f;
    return (lode_dq_t){scale * x.d, scale * x.q};
}

// The start's vector one period on. Slow, the estimator has nothing to go by: it is put on the vector
// from time to time.
static lode_own_frame_t start_frame(lode_drive_t *self, lode_ab_t e_V) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    lode_start_t *start = &self->state.start;
    lode_sincos_t half_turn = {0.0f, 1.0f};
    if (start->catching == 0u) {
        half_turn = lode_start_step(start, tuning, e_V);
        if (self->steps % LODE_SLOW_PERIODS == TURN_HOLD &&
            lode_abs(start->omega_rad_s) < tuning->omega_hold) {
            lode_estimator_hold(&self->estimator, &self->tuning->estimator, start->at,
                                start->omega_rad_s);
        }
    }
    self->ref_A = (lode_dq_t){start->current_A, 0.0f};
    return (lode_own_frame_t){lode_start_vector(start, tuning), half_turn};
}

// The frame of VOLTAGE, CURRENT and START, at an angle of its own, and what is asked for in it.
LODE_RAMFUNC lode_own_frame_t lode_core_own_frame(lode_drive_t *self, lode_ab_t e_V,
                                                  float v_bus_V) {
    const lode_mode_t mode = lode_core_mode(self);
    if (mode == LODE_MODE_START) {
        return start_frame(self, e_V);
    }
    if (mode == LODE_MODE_CURRENT) {
        self->ref_A = in_circle(self->command.vector, self->tuning->references.i_max_A);
    } else {
        self->u_V = in_circle(self->command.vector, self->tuning->current.circle * v_bus_V);
    }
    const float advance_rad = self->tuning->ts_s * self->command.speed_rad_s;
    const lode_sincos_t vector = lode_sincos(self->state.theta_rad);
    self->state.theta_rad = lode_wrap(self->state.theta_rad + advance_rad);
    return (lode_own_frame_t){vector, lode_sincos(0.5f * advance_rad)};
}

LODE_RAMFUNC void lode_core_control_speed(lode_drive_t *self, float omega_rad_s,
                                          float load_torque_Nm) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_running_t *run = &self->state.run;
    const float least = tuning->omega_min * tuning->inv_pole_pairs;
    float target = lode_max(self->command.speed_rad_s * self->direction, least) * self->direction;
    if (LODE_RARELY(run->fade > 0.0f)) { // while the start current fades, its speed is held
        target = run->speed.reference_rad_s;
        run->fade = lode_max(run->fade - tuning->start.fade_step, 0.0f);
    }
    (void)lode_speed_step(&run->speed, &tuning->speed, target, omega_rad_s, load_torque_Nm);
}

LODE_NOINLINE void lode_core_examine(lode_drive_t *self, const lode_sample_t *sample, bool finite) {
    const lode_situation_t now = {self->mode, lode_core_mode(self) == LODE_MODE_RUN, finite};
    lode_guard_examine(&self->guard, &self->tuning->guard, sample, now);
}

LODE_NOINLINE void lode_core_count(lode_drive_t *self, lode_condition_t condition) {
    const lode_situation_t now = {self->mode, lode_core_mode(self) == LODE_MODE_RUN, true};
    lode_guard_watch(&self->guard, &self->tuning->guard, condition, now);
}

// The same by the drive's own estimate.
LODE_NOINLINE void lode_core_follow_own(lode_drive_t *self, lode_calibration_t calibration,
                                        float offset_count, float sine, float cosine, float id_A,
                                        float iq_A) {
    const lode_estimator_t *estimator = &self->estimator;
    const lode_estimate_t est = {
        .omega_rad_s = estimator->pll.omega_rad_s,
        .rotor = {sine, cosine},
        .i_A = {id_A, iq_A},
        .e_V = estimator->emf.observer.e_V,
        .load_torque_Nm = lode_estimator_load_torque_Nm(estimator, &self->tuning->estimator),
        .lock = estimator->lock,
    };
    lode_core_follow_command(self, calibration, offset_count, &est);
}
