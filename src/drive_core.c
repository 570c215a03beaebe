#include "drive_core.h"

#include <stddef.h>

LODE_COLD void lode_core_switch_off(lode_drive_t *self, lode_mode_t mode) {
    lode_core_set_mode(self, mode);
    self->gates = false;
    self->duty = (lode_abc_t){LODE_DUTY_IDLE, LODE_DUTY_IDLE, LODE_DUTY_IDLE};
    self->duty_before = self->duty;
    self->i_A = (lode_dq_t){0.0f, 0.0f};
    self->ref_A = (lode_dq_t){0.0f, 0.0f};
    self->u_V = (lode_dq_t){0.0f, 0.0f};
    lode_inverter_reset(&self->inverter);
}

static void switch_on(lode_drive_t *self, lode_mode_t mode) {
    lode_core_set_mode(self, mode);
    self->gates = true;
    self->theta_rad = self->command.theta_rad;
    lode_guard_reset(&self->guard);
    lode_pi_reset(&self->current.d, 0.0f);
    lode_pi_reset(&self->current.q, 0.0f);
    lode_start_begin(&self->start, &self->tuning->start);
}

static void fault(lode_drive_t *self, lode_check_t check, float measured, float limit) {
    lode_guard_trip(&self->guard, self->mode, check, measured, limit);
}

LODE_COLD void lode_core_take_mail(lode_drive_t *self) {
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
    const lode_dq_t u_V =
        seen_from(self->u_V, lode_angle_subtract(est->rotor, lode_start_vector(&self->start)));
    lode_current_reset(&self->current, &tuning->current, u_V, est->i_A, est->omega_rad_s);
    const float torque = lode_references_torque_Nm(&tuning->references, est->i_A);
    lode_speed_reset(&self->speed, &tuning->speed, est->omega_rad_s * tuning->inv_pole_pairs,
                     torque, lode_estimator_load_torque_Nm(&self->estimator, &tuning->estimator));
    self->start.fade = 1.0f;
    self->start.id_A =
        est->i_A.d - lode_references_id_A(&tuning->references, torque, est->omega_rad_s);
    lode_references_reset(&self->references, est->i_A.d);
    self->ref_A = est->i_A; // until the speed control's turn
    self->direction = lode_sign(est->omega_rad_s);
    lode_core_set_mode(self, LODE_MODE_RUN);
}

// The way back: a start current ahead of the rotor by the angle at which it makes the torque that the
// present one makes. (In the direction of the present one it might be opposed to the rotor.)
LODE_COLD void lode_core_hand_back(lode_drive_t *self, float omega_rad_s, lode_dq_t i_A) {
    const float current_A = self->tuning->start.current_A;
    const float iq = lode_clamp(i_A.q, -current_A, current_A);
    const float turn = lode_atan2(iq, lode_sqrt(current_A * current_A - iq * iq));
    const lode_dq_t u_V = seen_from(self->u_V, lode_sincos(turn));
    lode_start_reset(&self->start, lode_estimator_theta_rad(&self->estimator) + turn, omega_rad_s,
                     current_A);
    lode_current_reset(&self->current, &self->tuning->current, u_V, (lode_dq_t){current_A, 0.0f},
                       0.0f);
    lode_core_set_mode(self, LODE_MODE_START);
}

// Slow in START the estimator has nothing to go by: it is put on the vector from time to time.
static bool is_held(const lode_drive_t *self) {
    return lode_abs(self->start.omega_rad_s) < self->tuning->start.omega_hold &&
           self->steps % LODE_SLOW_PERIODS == TURN_HOLD;
}

static void follow_start(lode_drive_t *self, const lode_estimate_t *est) {
    const lode_start_tuning_t *tuning = &self->tuning->start;
    lode_start_t *start = &self->start;
    if (start->catching > 0u && self->command.mode == LODE_MODE_RUN) {
        if (lode_start_catch(start, tuning, est)) {
            hand_over(self, est);
        }
        return;
    }
    const bool stopping = is_stop(self);
    const bool at_rest = lode_abs(start->omega_rad_s) <= tuning->omega_step;
    const float target =
        stopping ? 0.0f : lode_sign(self->command.speed_rad_s) * tuning->omega_handover;
    const float current_A = stopping && at_rest ? 0.0f : tuning->current_A;
    (void)lode_start_step(start, tuning, target, current_A, est->e_V);
    if (self->command.mode != LODE_MODE_RUN ||
        (stopping && at_rest && !(start->current_A > 0.0f))) {
        lode_core_switch_off(self, LODE_MODE_OFF);
    } else if (!stopping && start->omega_rad_s * target > 0.0f &&
               lode_start_ready(start, tuning, est)) {
        hand_over(self, est);
    } else if (!stopping && start->periods > tuning->timeout_periods) {
        fault(self, LODE_CHECK_START, est->lock, LODE_LOCK_HANDOVER);
    } else if (is_held(self)) {
        lode_estimator_hold(&self->estimator, &self->tuning->estimator, start->theta_rad,
                            start->omega_rad_s);
    }
}

static void follow_off(lode_drive_t *self) {
    const lode_mode_t wanted = self->command.mode;
    if (wanted == LODE_MODE_CALIBRATE ||
        (wanted == LODE_MODE_RUN && !is_stop(self) && !self->calibrated)) {
        lode_sense_begin(&self->sense);
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
LODE_COLD void lode_core_follow_command(lode_drive_t *self, lode_calibration_t calibration,
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

// The frame of VOLTAGE, CURRENT and START: at an angle of its own.
LODE_COLD lode_frame_t lode_core_own_frame(lode_drive_t *self, lode_ab_t i_A) {
    const float ts_s = self->tuning->ts_s;
    if (lode_core_mode(self) == LODE_MODE_START) {
        const float omega = self->start.omega_rad_s;
        const lode_sincos_t vector = lode_start_vector(&self->start);
        const lode_sincos_t half_turn = lode_sincos_small(0.5f * ts_s * omega);
        return (lode_frame_t){vector, half_turn, omega, 0.0f, lode_park(i_A, vector)};
    }
    const float omega = self->command.omega_rad_s;
    const lode_sincos_t vector = lode_sincos(self->theta_rad);
    self->theta_rad = lode_wrap(self->theta_rad + ts_s * omega);
    return (lode_frame_t){vector, lode_sincos(0.5f * ts_s * omega), omega, 0.0f,
                          lode_park(i_A, vector)};
}

LODE_HOT void lode_core_control_speed(lode_drive_t *self, float omega_rad_s, float load_torque_Nm) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float least = tuning->omega_min * tuning->inv_pole_pairs;
    // While the start current fades, the speed of the hand-over is held.
    const float wanted =
        lode_max(self->command.speed_rad_s * self->direction, least) * self->direction;
    const float target = self->start.fade > 0.0f ? self->speed.reference_rad_s : wanted;
    (void)lode_speed_step(&self->speed, &tuning->speed, target, omega_rad_s, load_torque_Nm);
    self->start.fade = lode_max(self->start.fade - tuning->start.fade_step, 0.0f);
}

// A commanded vector, shortened to `radius` where it is longer.
static lode_dq_t in_circle(lode_dq_t x, float radius) {
    const float length = lode_ab_length((lode_ab_t){x.d, x.q});
    const float scale = length > radius ? radius / length : 1.0f;
    return (lode_dq_t){scale * x.d, scale * x.q};
}

LODE_COLD void lode_core_own_references(lode_drive_t *self, float v_bus_V) {
    const lode_mode_t mode = lode_core_mode(self);
    if (mode == LODE_MODE_START) {
        self->ref_A = (lode_dq_t){self->start.current_A, 0.0f};
    } else if (mode == LODE_MODE_CURRENT) {
        self->ref_A = in_circle(self->command.vector, self->tuning->references.i_max_A);
    } else {
        self->u_V = in_circle(self->command.vector, self->tuning->current.circle * v_bus_V);
    }
}
