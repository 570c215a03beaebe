#include "lodestar/drive.h"

#include <stddef.h>

// With every leg at half duty there is no voltage between the phases.
#define DUTY_IDLE 0.5f
// Sensorless running goes over to the way down from this much above the least speed.
#define HAND_BACK_SHARE 1.15f
#define TELEMETRY_TRIES 3

// The frame in which the currents are controlled, at t_k.
typedef struct {
    lode_sincos_t rotor;
    lode_sincos_t half_turn; // in half a period
    float omega_rad_s;       // at which it turns
    float omega_rotor;       // of the rotor, where the frame is the rotor's; else 0
    lode_dq_t i_A;
} frame_t;

// Who is due in which of LODE_SLOW_PERIODS: about equally dear.
enum {
    TURN_GUARD_AND_LOCK = 0,
    TURN_HOLD = 1, // in START
    TURN_LAG = 3,
    TURN_GUARD_AND_LOSS = 4, // the shape of the dead-time loss
    TURN_GAINS_AND_NOTCHES = 7
};

static lode_mode_t mode_of(const lode_drive_t *self) {
    return (lode_mode_t)self->mode;
}

static void set_mode(lode_drive_t *self, lode_mode_t mode) {
    self->mode = (uint_least8_t)mode;
}

static LODE_COLD void switch_off(lode_drive_t *self, lode_mode_t mode) {
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

void lode_drive_begin(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    *self = (lode_drive_t){.tuning = tuning, .direction = 1.0f};
    switch_off(self, LODE_MODE_OFF);
    lode_sense_reset(&self->sense, &tuning->sense);
    lode_estimator_reset(&self->estimator, &tuning->estimator);
    lode_guard_reset(&self->guard);
}

lode_status_t lode_drive_init(lode_drive_t *self, lode_drive_tuning_t *tuning,
                              const lode_drive_config_t *config) {
    if (self == NULL) {
        return LODE_ERROR_NULL;
    }
    const lode_status_t status = lode_drive_tune(tuning, config);
    if (status == LODE_OK) {
        lode_drive_begin(self, tuning);
    }
    return status;
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
    self->mail = true;
    return LODE_OK;
}

lode_status_t lode_drive_post_tuning(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    if (self == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    LODE_SIGNAL_FENCE();
    self->posted_tuning = tuning;
    LODE_SIGNAL_FENCE();
    self->mail = true;
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
            .theta_rad = lode_estimator_theta_rad(&self->estimator),
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

static LODE_COLD void take_mail(lode_drive_t *self) {
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

// Counts to amperes and volts, and the voltage that really acted over the last period.
LODE_INLINE lode_measurement_t sensed(lode_drive_t *self, const lode_counts_t *counts) {
    if (self->mail) {
        take_mail(self);
    }
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_calibration_t calibration = LODE_CALIBRATION_RUNNING;
    float offset_count = 0.0f;
    if (mode_of(self) == LODE_MODE_CALIBRATE) {
        float worst_count;
        calibration = lode_sense_calibrate(&self->sense, &tuning->sense, counts, &worst_count);
        offset_count = worst_count;
    }
    const lode_sample_t sample =
        lode_sense_step(&self->sense, &tuning->sense, counts, &self->duty_before);
    const lode_ab_t u_V = lode_inverter_realised(&self->inverter, sample.v_bus_V);
    return (lode_measurement_t){sample, u_V, calibration, offset_count};
}

// Angle and speed at t_k.
LODE_INLINE lode_estimate_t estimated(lode_drive_t *self, const lode_measurement_t *m) {
    const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
    if (!self->gates) { // the voltage at open terminals is not known
        lode_estimator_reset(&self->estimator, tuning);
        return (lode_estimate_t){.rotor = {0.0f, 1.0f}};
    }
    return lode_estimator_follow(&self->estimator, tuning, m->u_V, m->sample.i_A);
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
        seen_from(self->u_V, lode_sincos(lode_estimate_theta_rad(est) - self->theta_rad));
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
    set_mode(self, LODE_MODE_RUN);
}

// The way back: a start current ahead of the rotor by the angle at which it makes the torque that the
// present one makes. (In the direction of the present one it might be opposed to the rotor.)
static LODE_COLD void hand_back(lode_drive_t *self, float omega_rad_s, lode_dq_t i_A) {
    const float current_A = self->tuning->start.current_A;
    const float iq = lode_clamp(i_A.q, -current_A, current_A);
    const float turn = lode_atan2(iq, lode_sqrt(current_A * current_A - iq * iq));
    const lode_dq_t u_V = seen_from(self->u_V, lode_sincos(turn));
    self->theta_rad = lode_wrap(lode_estimator_theta_rad(&self->estimator) + turn);
    lode_start_reset(&self->start, self->theta_rad, omega_rad_s, current_A);
    lode_current_reset(&self->current, &self->tuning->current, u_V, (lode_dq_t){current_A, 0.0f},
                       0.0f);
    set_mode(self, LODE_MODE_START);
}

// Too slow to run on, and not about to speed up.
LODE_INLINE bool is_too_slow(const lode_drive_t *self, float omega_rad_s) {
    return !(self->command.speed_rad_s * self->direction > 0.0f) &&
           lode_abs(omega_rad_s) <= HAND_BACK_SHARE * self->tuning->omega_min;
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
    self->theta_rad = lode_start_step(start, tuning, target, current_A, est->e_V);
    if (self->command.mode != LODE_MODE_RUN ||
        (stopping && at_rest && !(start->current_A > 0.0f))) {
        switch_off(self, LODE_MODE_OFF);
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
        set_mode(self, LODE_MODE_CALIBRATE);
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
        set_mode(self, LODE_MODE_OFF);
        self->command.mode =
            self->command.mode == LODE_MODE_CALIBRATE ? LODE_MODE_OFF : self->command.mode;
    } else if (self->command.mode == LODE_MODE_OFF) {
        set_mode(self, LODE_MODE_OFF);
    }
}

// The state machine: at most one transition per period.
static LODE_COLD void follow_command(lode_drive_t *self, lode_calibration_t calibration,
                                     float offset_count, const lode_estimate_t *est) {
    switch (mode_of(self)) {
    case LODE_MODE_OFF:
        follow_off(self);
        break;
    case LODE_MODE_CALIBRATE:
        follow_calibrate(self, calibration, offset_count);
        break;
    case LODE_MODE_VOLTAGE:
    case LODE_MODE_CURRENT:
    case LODE_MODE_RUN:
        if (self->command.mode != mode_of(self)) {
            switch_off(self, LODE_MODE_OFF);
        }
        break;
    case LODE_MODE_START:
        follow_start(self, est);
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

// The frame of VOLTAGE, CURRENT and START: at an angle of its own.
static LODE_COLD frame_t own_frame(lode_drive_t *self, lode_ab_t i_A) {
    float omega = self->start.omega_rad_s;
    const float theta = self->theta_rad;
    if (mode_of(self) != LODE_MODE_START) {
        omega = self->command.omega_rad_s;
        self->theta_rad = lode_wrap(theta + self->tuning->ts_s * omega);
    }
    const lode_sincos_t rotor = lode_sincos(theta);
    const lode_sincos_t half_turn = lode_sincos(0.5f * self->tuning->ts_s * omega);
    return (frame_t){rotor, half_turn, omega, 0.0f, lode_park(i_A, rotor)};
}

static void control_speed(lode_drive_t *self, float omega_rad_s, float load_torque_Nm) {
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

static LODE_COLD void own_references(lode_drive_t *self, float v_bus_V) {
    const lode_mode_t mode = mode_of(self);
    if (mode == LODE_MODE_START) {
        self->ref_A = (lode_dq_t){self->start.current_A, 0.0f};
    } else if (mode == LODE_MODE_CURRENT) {
        self->ref_A = in_circle(self->command.vector, self->tuning->references.i_max_A);
    } else {
        self->u_V = in_circle(self->command.vector, self->tuning->current.circle * v_bus_V);
    }
}

// Duties for the voltage of the frame, turned to where it will stand while they act: one and a half
// periods after the sample.
LODE_INLINE lode_abc_t modulate(lode_drive_t *self, const frame_t *frame, float v_bus_V) {
    const lode_inverter_tuning_t *tuning = &self->tuning->inverter;
    const lode_sincos_t acting = lode_angle_add(frame->rotor, lode_angle_triple(frame->half_turn));
    const lode_modulator_out_t out =
        lode_modulator_step(tuning, self->inverter.loss, lode_park_inverse(self->u_V, acting),
                            v_bus_V, lode_park_inverse(frame->i_A, acting));
    if (self->tuning->sense.windowed) {
        self->duty_before = self->duty;
    }
    self->duty = out.duty;
    lode_inverter_write(&self->inverter, out.realised);
    return out.duty;
}

LODE_INLINE void note_temperature(lode_drive_t *self, const lode_sample_t *sample) {
    self->temperature_degC =
        lode_sense_temperature_degC(&self->tuning->sense, sample->temperature_count);
}

// Whether something is due that comes `turn` periods after every `speed_periods`, a power of two.
LODE_INLINE bool is_turn(const lode_drive_t *self, uint32_t turn) {
    return ((self->steps - turn) & (self->tuning->speed_periods - 1u)) == 0u;
}

LODE_INLINE void watch(lode_drive_t *self, const lode_measurement_t *m, const lode_estimate_t *est,
                       lode_situation_t now) {
    note_temperature(self, &m->sample);
    const lode_condition_t condition = {m->sample.v_bus_V, self->temperature_degC,
                                        self->direction * est->omega_rad_s, est->lock};
    lode_guard_watch(&self->guard, &self->tuning->guard, condition, now);
}

// What follows speed and load. After the duties, which do not wait for it.
LODE_INLINE void adapt(lode_drive_t *self, const lode_measurement_t *m, const lode_estimate_t *est,
                       lode_situation_t now) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float v_bus_V = m->sample.v_bus_V;
    lode_adapt_t part;
    switch (self->steps % LODE_SLOW_PERIODS) {
    case TURN_GUARD_AND_LOCK:
        watch(self, m, est, now);
        if (now.sensorless && is_too_slow(self, est->omega_rad_s)) {
            hand_back(self, est->omega_rad_s, est->i_A);
        }
        part = LODE_ADAPT_LOCK;
        break;
    case TURN_GUARD_AND_LOSS:
        watch(self, m, est, now);
        lode_inverter_adapt(&self->inverter, &tuning->inverter, self->u_V, v_bus_V);
        return;
    case TURN_LAG:
        part = LODE_ADAPT_LAG;
        break;
    case TURN_GAINS_AND_NOTCHES:
        (void)lode_estimator_adapt(&self->estimator, &tuning->estimator, LODE_ADAPT_GAINS);
        part = LODE_ADAPT_NOTCHES;
        break;
    default:
        return;
    }
    (void)lode_estimator_adapt(&self->estimator, &tuning->estimator, part);
}

// Control, modulation and guard of a period with the gates on.
LODE_INLINE lode_abc_t drive_motor(lode_drive_t *self, const lode_measurement_t *m,
                                   const lode_estimate_t *est, bool finite) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float v_bus_V = m->sample.v_bus_V;
    const bool running = mode_of(self) == LODE_MODE_RUN;
    frame_t frame = {est->rotor, est->half_turn, est->omega_rad_s, est->omega_rad_s, est->i_A};
    if (!running) {
        const frame_t own = own_frame(self, m->sample.i_A);
        frame = (frame_t){own.rotor, own.half_turn, own.omega_rad_s, own.omega_rotor, own.i_A};
        own_references(self, v_bus_V);
    }
    self->i_A = frame.i_A;
    // Speed control and, a period later, its current references: at their own rate, and with the usual
    // one, 4 periods, in the turns that are left.
    if (running && is_turn(self, 1u)) {
        control_speed(self, est->omega_rad_s, est->load_torque_Nm);
    }
    if (running && is_turn(self, 2u)) {
        const lode_references_voltage_t voltage = {v_bus_V, self->u_V};
        const lode_references_out_t ref =
            lode_references_step(&self->references, &tuning->references, self->speed.torque_Nm,
                                 est->omega_rad_s, self->start.fade * self->start.id_A, voltage);
        self->ref_A = ref.i_A;
        self->speed.limit_Nm = ref.torque_Nm;
    }
    if (running || mode_of(self) != LODE_MODE_VOLTAGE) {
        self->u_V = lode_current_step(&self->current, &tuning->current, self->ref_A, frame.i_A,
                                      frame.omega_rotor, v_bus_V);
    }
    const lode_abc_t duty = modulate(self, &frame, v_bus_V);
    const lode_situation_t now = {self->mode, running, finite};
    lode_guard_step(&self->guard, &tuning->guard, &m->sample, now);
    adapt(self, m, est, now);
    return duty;
}

// From angle and speed to duties: control, modulation and the last word of the guard.
LODE_INLINE lode_drive_out_t acted(lode_drive_t *self, const lode_measurement_t *m,
                                   const lode_estimate_t *est, bool finite) {
    self->steps++;
    if (mode_of(self) != LODE_MODE_RUN || self->command.mode != LODE_MODE_RUN) {
        // A copy: the estimate itself stays in registers.
        const lode_estimate_t rotor = {.omega_rad_s = est->omega_rad_s,
                                       .rotor = est->rotor,
                                       .i_A = est->i_A,
                                       .e_V = est->e_V,
                                       .lock = est->lock};
        follow_command(self, m->calibration, m->offset_count, &rotor);
    }
    if (self->gates) {
        const lode_abc_t duty = drive_motor(self, m, est, finite);
        if (lode_guard_is_good(&self->guard)) {
            return (lode_drive_out_t){duty, true};
        }
    } else {
        note_temperature(self, &m->sample);
    }
    if (!lode_guard_is_good(&self->guard) && mode_of(self) != LODE_MODE_FAULT) {
        switch_off(self, LODE_MODE_FAULT);
    }
    return (lode_drive_out_t){self->duty, self->gates};
}

lode_measurement_t lode_drive_sense(lode_drive_t *self, const lode_counts_t *counts) {
    return sensed(self, counts);
}

lode_estimate_t lode_drive_estimate(lode_drive_t *self, const lode_measurement_t *measurement) {
    return estimated(self, measurement);
}

// What the gates are driven by is a number. An estimate from outside may not be one; the drive's own
// always is.
static bool is_finite(const lode_estimate_t *est) {
    return lode_abs(est->i_A.d) + lode_abs(est->i_A.q) + lode_abs(est->rotor.cos) +
               lode_abs(est->rotor.sin) + lode_abs(est->omega_rad_s) <=
           FLT_MAX;
}

lode_drive_out_t lode_drive_act(lode_drive_t *self, const lode_measurement_t *measurement,
                                const lode_estimate_t *estimate) {
    return acted(self, measurement, estimate, is_finite(estimate));
}

LODE_HOT lode_drive_out_t lode_drive_step(lode_drive_t *self, const lode_counts_t *counts) {
    const lode_measurement_t measured = sensed(self, counts); // counts -> A, V, realised voltage
    const lode_estimate_t rotor = estimated(self, &measured); // -> angle and speed at t_k
    return acted(self, &measured, &rotor, true);              // -> duties, gates
}
