#include "lodestar/drive.h"

#include <stddef.h>

// Periods from the sample to the middle of the period in which its voltage acts.
#define ACTING_PERIODS 1.5f
// With every leg at half duty there is no voltage between the phases.
#define DUTY_IDLE 0.5f
// Beyond any bus: NaN and Inf fall outside.
#define VOLTAGE_LIMIT_V 1.0e5f
// Sensorless running goes over to the way down from this much above the least speed.
#define HAND_BACK_SHARE 1.15f
#define TELEMETRY_TRIES 3

// The frame in which the currents are controlled, at t_k.
typedef struct {
    lode_sincos_t rotor;
    float omega_rad_s; // at which it turns
    float omega_rotor; // of the rotor, where the frame is the rotor's; else 0
    lode_dq_t i_A;
} frame_t;

static lode_mode_t mode_of(const lode_drive_t *self) {
    return (lode_mode_t)self->mode;
}

static void set_mode(lode_drive_t *self, lode_mode_t mode) {
    self->mode = (uint_least8_t)mode;
}

static void switch_off(lode_drive_t *self, lode_mode_t mode) {
    set_mode(self, mode);
    self->gates = false;
    self->duty = (lode_abc_t){DUTY_IDLE, DUTY_IDLE, DUTY_IDLE};
    self->duty_before = self->duty;
    self->i_A = (lode_dq_t){0.0f, 0.0f};
    self->ref_A = (lode_dq_t){0.0f, 0.0f};
    self->u_V = (lode_dq_t){0.0f, 0.0f};
    lode_inverter_reset(&self->inverter);
}

static void switch_on(lode_drive_t *self, lode_mode_t mode) {
    set_mode(self, mode);
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

lode_status_t lode_drive_init(lode_drive_t *self, lode_drive_tuning_t *tuning,
                              const lode_drive_config_t *config) {
    if (self == NULL) {
        return LODE_ERROR_NULL;
    }
    const lode_status_t status = lode_drive_tune(tuning, config);
    if (status != LODE_OK) {
        return status;
    }
    *self = (lode_drive_t){.tuning = tuning, .direction = 1.0f};
    switch_off(self, LODE_MODE_OFF);
    lode_sense_reset(&self->sense, &tuning->sense);
    lode_estimator_reset(&self->estimator, &tuning->estimator);
    lode_guard_reset(&self->guard);
    return LODE_OK;
}

lode_status_t lode_drive_post_command(lode_drive_t *self, const lode_command_t *command) {
    if (self == NULL || command == NULL) {
        return LODE_ERROR_NULL;
    }
    const bool known = command->mode == LODE_MODE_OFF || command->mode == LODE_MODE_CALIBRATE ||
                       command->mode == LODE_MODE_VOLTAGE || command->mode == LODE_MODE_CURRENT ||
                       command->mode == LODE_MODE_RUN;
    if (!known || !lode_is_finite(command->speed_rad_s) || !lode_is_finite(command->vector.d) ||
        !lode_is_finite(command->vector.q) || !lode_is_finite(command->theta_rad) ||
        !lode_is_finite(command->omega_rad_s)) {
        return LODE_ERROR_COMMAND;
    }
    self->command_posted = false;
    LODE_SIGNAL_FENCE();
    self->posted = *command;
    LODE_SIGNAL_FENCE();
    self->command_posted = true;
    return LODE_OK;
}

lode_status_t lode_drive_post_tuning(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    if (self == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    LODE_SIGNAL_FENCE();
    self->posted_tuning = tuning;
    return LODE_OK;
}

bool lode_drive_tuning_taken(const lode_drive_t *self) {
    LODE_SIGNAL_FENCE();
    return self->posted_tuning == NULL;
}

bool lode_drive_telemetry(const lode_drive_t *self, lode_telemetry_t *telemetry) {
    for (int32_t i = 0; i < TELEMETRY_TRIES; i++) {
        const uint32_t steps = self->steps;
        LODE_SIGNAL_FENCE();
        const lode_pll_t *pll = &self->estimator.pll;
        *telemetry = (lode_telemetry_t){
            .steps = steps,
            .mode = mode_of(self),
            .fault = self->guard.fault,
            .duty = self->duty,
            .i_A = self->i_A,
            .ref_A = self->ref_A,
            .u_V = self->u_V,
            .v_bus_V = self->inverter.v_bus_V,
            .temperature_degC = self->temperature_degC,
            .theta_rad = lode_wrap(pll->theta_rad + self->estimator.lag_rad),
            .omega_rad_s = pll->omega_rad_s,
            .speed_ref_rad_s = self->speed.reference_rad_s,
            .load_torque_Nm = self->tuning->estimator.load_per_f_Nm * pll->f_rad_s2,
            .lock = self->estimator.lock,
            .e_V = self->estimator.emf.leso.e_V,
        };
        LODE_SIGNAL_FENCE();
        if (steps == self->steps) {
            return true;
        }
    }
    return false;
}

static void take_mail(lode_drive_t *self) {
    if (self->posted_tuning != NULL) {
        self->tuning = self->posted_tuning;
        self->posted_tuning = NULL;
    }
    if (self->command_posted) {
        self->command = self->posted;
        self->command_posted = false;
    }
}

LODE_HOT lode_measurement_t lode_drive_sense(lode_drive_t *self, const lode_counts_t *counts) {
    take_mail(self);
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_measurement_t m = {.calibration = LODE_CALIBRATION_RUNNING};
    if (mode_of(self) == LODE_MODE_CALIBRATE) {
        m.calibration = lode_sense_calibrate(&self->sense, &tuning->sense, counts, &m.offset_count);
    }
    m.sample = lode_sense_step(&self->sense, &tuning->sense, counts, self->duty_before);
    m.u_V = lode_inverter_realised(&self->inverter, m.sample.v_bus_V);
    return m;
}

LODE_HOT lode_estimate_t lode_drive_estimate(lode_drive_t *self,
                                             const lode_measurement_t *measurement) {
    const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
    if (!self->gates) { // the voltage at open terminals is not known
        lode_estimator_reset(&self->estimator, tuning);
        return (lode_estimate_t){.rotor = {0.0f, 1.0f}};
    }
    return lode_estimator_step(&self->estimator, tuning, measurement->u_V, measurement->sample.i_A);
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
    const lode_dq_t u_V = seen_from(self->u_V, lode_sincos(est->theta_rad - self->theta_rad));
    lode_current_reset(&self->current, &tuning->current, u_V, est->i_A, est->omega_rad_s);
    const float torque = lode_references_torque_Nm(&tuning->references, est->i_A);
    lode_speed_reset(&self->speed, &tuning->speed, est->omega_rad_s * tuning->inv_pole_pairs,
                     torque, est->load_torque_Nm);
    self->start.fade = 1.0f;
    self->start.id_A =
        est->i_A.d - lode_references_step(&tuning->references, torque, est->omega_rad_s, 0.0f).d;
    self->direction = lode_sign(est->omega_rad_s);
    set_mode(self, LODE_MODE_RUN);
}

// The way back: a start current ahead of the rotor by the angle at which it makes the torque that the
// present one makes. (In the direction of the present one it might be opposed to the rotor.)
static void hand_back(lode_drive_t *self, const lode_estimate_t *est) {
    const float current_A = self->tuning->start.current_A;
    const float iq = lode_clamp(est->i_A.q, -current_A, current_A);
    const float turn = lode_atan2(iq, lode_sqrt(current_A * current_A - iq * iq));
    const lode_dq_t u_V = seen_from(self->u_V, lode_sincos(turn));
    self->theta_rad = lode_wrap(est->theta_rad + turn);
    lode_start_reset(&self->start, self->theta_rad, est->omega_rad_s, current_A);
    lode_current_reset(&self->current, &self->tuning->current, u_V, (lode_dq_t){current_A, 0.0f},
                       0.0f);
    set_mode(self, LODE_MODE_START);
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
    self->theta_rad = lode_start_step(start, tuning, target, current_A, est->e_V);
    if (self->command.mode != LODE_MODE_RUN ||
        (stopping && at_rest && !(start->current_A > 0.0f))) {
        switch_off(self, LODE_MODE_OFF);
    } else if (!stopping && start->omega_rad_s * target > 0.0f &&
               lode_start_ready(start, tuning, est)) {
        hand_over(self, est);
    } else if (!stopping && start->periods > tuning->timeout_periods) {
        fault(self, LODE_CHECK_START, est->lock, LODE_LOCK_HANDOVER);
    } else if (lode_abs(start->omega_rad_s) < tuning->omega_hold) {
        lode_estimator_hold(&self->estimator, &self->tuning->estimator, start->theta_rad,
                            start->omega_rad_s);
    }
}

static void follow_run(lode_drive_t *self, const lode_estimate_t *est) {
    if (self->command.mode != LODE_MODE_RUN) {
        switch_off(self, LODE_MODE_OFF);
        return;
    }
    const bool onward = self->command.speed_rad_s * self->direction > 0.0f;
    if (!onward && lode_abs(est->omega_rad_s) <= HAND_BACK_SHARE * self->tuning->omega_min) {
        hand_back(self, est);
    }
}

static void follow_off(lode_drive_t *self) {
    const lode_mode_t wanted = self->command.mode;
    if (wanted == LODE_MODE_CALIBRATE ||
        (wanted == LODE_MODE_RUN && !is_stop(self) && !self->calibrated)) {
        lode_sense_begin(&self->sense);
        set_mode(self, LODE_MODE_CALIBRATE);
    } else if (wanted == LODE_MODE_VOLTAGE || wanted == LODE_MODE_CURRENT) {
        switch_on(self, wanted);
    } else if (wanted == LODE_MODE_RUN && !is_stop(self)) {
        switch_on(self, LODE_MODE_START);
    }
}

static void follow_calibrate(lode_drive_t *self, const lode_measurement_t *m) {
    if (m->calibration == LODE_CALIBRATION_IMPLAUSIBLE) {
        fault(self, LODE_CHECK_OFFSET, m->offset_count, self->tuning->sense.i_offset_tol);
    } else if (m->calibration == LODE_CALIBRATION_DONE) {
        self->calibrated = true;
        set_mode(self, LODE_MODE_OFF);
        self->command.mode =
            self->command.mode == LODE_MODE_CALIBRATE ? LODE_MODE_OFF : self->command.mode;
    } else if (self->command.mode == LODE_MODE_OFF) {
        set_mode(self, LODE_MODE_OFF);
    }
}

// The state machine: at most one transition per period.
static void follow_command(lode_drive_t *self, const lode_measurement_t *m,
                           const lode_estimate_t *est) {
    switch (mode_of(self)) {
    case LODE_MODE_OFF:
        follow_off(self);
        break;
    case LODE_MODE_CALIBRATE:
        follow_calibrate(self, m);
        break;
    case LODE_MODE_VOLTAGE:
    case LODE_MODE_CURRENT:
        if (self->command.mode != mode_of(self)) {
            switch_off(self, LODE_MODE_OFF);
        }
        break;
    case LODE_MODE_START:
        follow_start(self, est);
        break;
    case LODE_MODE_RUN:
        follow_run(self, est);
        break;
    case LODE_MODE_FAULT:
    default:
        if (self->command.mode == LODE_MODE_OFF && self->command.clear_fault) {
            lode_guard_reset(&self->guard);
            switch_off(self, LODE_MODE_OFF);
        }
        break;
    }
}

static frame_t frame_at(float theta_rad, float omega_rad_s, lode_ab_t i_A) {
    const lode_sincos_t rotor = lode_sincos(theta_rad);
    return (frame_t){rotor, omega_rad_s, 0.0f, lode_park(i_A, rotor)};
}

static frame_t control_frame(lode_drive_t *self, const lode_measurement_t *m,
                             const lode_estimate_t *est) {
    const lode_mode_t mode = mode_of(self);
    if (mode == LODE_MODE_RUN) {
        return (frame_t){est->rotor, est->omega_rad_s, est->omega_rad_s, est->i_A};
    }
    if (mode == LODE_MODE_START) {
        return frame_at(self->theta_rad, self->start.omega_rad_s, m->sample.i_A);
    }
    const float omega = self->command.omega_rad_s;
    const float theta = self->theta_rad;
    self->theta_rad = lode_wrap(theta + self->tuning->ts_s * omega);
    return frame_at(theta, omega, m->sample.i_A);
}

static lode_dq_t run_references(lode_drive_t *self, const lode_estimate_t *est) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float least = tuning->omega_min * tuning->inv_pole_pairs;
    // While the start current fades, the speed of the hand-over is held.
    const float wanted =
        lode_max(self->command.speed_rad_s * self->direction, least) * self->direction;
    const float target = self->start.fade > 0.0f ? self->speed.reference_rad_s : wanted;
    const float torque = lode_speed_step(&self->speed, &tuning->speed, target, est->omega_rad_s,
                                         est->load_torque_Nm);
    const float id_add = self->start.fade * self->start.id_A;
    self->start.fade = lode_max(self->start.fade - tuning->start.fade_step, 0.0f);
    return lode_references_step(&tuning->references, torque, est->omega_rad_s, id_add);
}

// A commanded vector, shortened to `radius` where it is longer.
static lode_dq_t in_circle(lode_dq_t x, float radius) {
    const float length = lode_ab_length((lode_ab_t){x.d, x.q});
    const float scale = length > radius ? radius / length : 1.0f;
    return (lode_dq_t){scale * x.d, scale * x.q};
}

static lode_dq_t current_references(lode_drive_t *self, const lode_estimate_t *est) {
    const lode_mode_t mode = mode_of(self);
    if (mode == LODE_MODE_RUN) {
        return run_references(self, est);
    }
    if (mode == LODE_MODE_START) {
        return (lode_dq_t){self->start.current_A, 0.0f};
    }
    return in_circle(self->command.vector, self->tuning->references.i_max_A);
}

static lode_dq_t control(lode_drive_t *self, const frame_t *frame, const lode_measurement_t *m,
                         const lode_estimate_t *est) {
    const float v_bus_V = m->sample.v_bus_V;
    if (mode_of(self) == LODE_MODE_VOLTAGE) {
        return in_circle(self->command.vector, self->tuning->current.circle * v_bus_V);
    }
    self->ref_A = current_references(self, est);
    return lode_current_step(&self->current, &self->tuning->current, self->ref_A, frame->i_A,
                             frame->omega_rotor, v_bus_V);
}

// Duties for the voltage `u_V` of the frame, turned to where it will stand while they act.
static lode_ab_t modulate(lode_drive_t *self, const frame_t *frame, float v_bus_V) {
    const lode_sincos_t ahead =
        lode_sincos(ACTING_PERIODS * self->tuning->ts_s * frame->omega_rad_s);
    const lode_sincos_t acting = lode_angle_add(frame->rotor, ahead);
    const lode_modulator_out_t out =
        lode_modulator_step(&self->tuning->inverter, lode_park_inverse(self->u_V, acting), v_bus_V,
                            lode_park_inverse(frame->i_A, acting));
    self->duty_before = self->duty;
    self->duty = out.duty;
    return out.realised;
}

// What the gates are driven by is a number. An estimate from outside may not be one.
static bool is_finite(const lode_drive_t *self, const frame_t *frame) {
    return lode_ab_in_range((lode_ab_t){self->u_V.d, self->u_V.q}, VOLTAGE_LIMIT_V) &&
           lode_ab_in_range((lode_ab_t){frame->i_A.d, frame->i_A.q}, FLT_MAX) &&
           lode_ab_in_range((lode_ab_t){frame->rotor.cos, frame->rotor.sin}, FLT_MAX) &&
           lode_is_finite(frame->omega_rad_s);
}

LODE_HOT lode_drive_out_t lode_drive_act(lode_drive_t *self, const lode_measurement_t *measurement,
                                         const lode_estimate_t *estimate) {
    self->steps++;
    self->temperature_degC = measurement->sample.temperature_degC;
    follow_command(self, measurement, estimate);
    if (self->gates) {
        const frame_t frame = control_frame(self, measurement, estimate);
        self->i_A = frame.i_A;
        self->u_V = control(self, &frame, measurement, estimate);
        lode_inverter_write(&self->inverter, modulate(self, &frame, measurement->sample.v_bus_V));
        const lode_situation_t now = {
            .state = self->mode,
            .sensorless = mode_of(self) == LODE_MODE_RUN,
            .direction = self->direction,
            .finite = is_finite(self, &frame),
        };
        (void)lode_guard_step(&self->guard, &self->tuning->guard, &measurement->sample, estimate,
                              now);
    }
    const bool faulty = self->guard.fault.check != (uint_least8_t)LODE_CHECK_NONE;
    if (faulty && mode_of(self) != LODE_MODE_FAULT) {
        switch_off(self, LODE_MODE_FAULT);
    }
    return (lode_drive_out_t){self->duty, self->gates};
}

LODE_HOT lode_drive_out_t lode_drive_step(lode_drive_t *self, const lode_counts_t *counts) {
    const lode_measurement_t measurement =
        lode_drive_sense(self, counts); // counts -> A, V, realised voltage
    const lode_estimate_t estimate =
        lode_drive_estimate(self, &measurement);          // -> angle and speed at t_k
    return lode_drive_act(self, &measurement, &estimate); // -> duties, gates
}
