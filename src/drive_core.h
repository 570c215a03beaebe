// What the drives for three and for six phases share: state machine, estimation, control and guard of a
// period, but not the windings' own sensing and modulation. Included by drive.c and drive6.c.
#ifndef LODESTAR_DRIVE_CORE_H
#define LODESTAR_DRIVE_CORE_H

#include "lodestar/drive.h"

// With every leg at half duty there is no voltage between the phases.
#define LODE_DUTY_IDLE 0.5f
// Sensorless running goes over to the way down from this much above the least speed.
#define HAND_BACK_SHARE 1.15f

// The frame in which the currents are controlled, at t_k.
typedef struct {
    lode_sincos_t rotor;
    lode_sincos_t half_turn; // in half a period
    float omega_rad_s;       // at which it turns
    float omega_rotor;       // of the rotor, where the frame is the rotor's; else 0
    lode_dq_t i_A;
} lode_frame_t;

// Who is due in which of LODE_SLOW_PERIODS: about equally dear.
enum {
    TURN_GUARD_AND_LOCK = 0,
    TURN_HOLD = 1, // in START
    TURN_LAG = 3,
    TURN_XY = 5,             // with six phases: the resonators of the xy plane
    TURN_GUARD_AND_LOSS = 4, // the shape of the dead-time loss
    TURN_GAINS_AND_NOTCHES = 7
};

LODE_INLINE lode_mode_t lode_core_mode(const lode_drive_t *self) {
    return (lode_mode_t)self->mode;
}

LODE_INLINE void lode_core_set_mode(lode_drive_t *self, lode_mode_t mode) {
    self->mode = (uint_least8_t)mode;
}

// Of a configuration what design divides by, in drive_config.c.
lode_status_t lode_core_check_given(const lode_drive_config_t *config);

// The parts off the hot path, in drive_core.c.
void lode_core_take_mail(lode_drive_t *self);
void lode_core_switch_off(lode_drive_t *self, lode_mode_t mode);
void lode_core_follow_command(lode_drive_t *self, lode_calibration_t calibration,
                              float offset_count, const lode_estimate_t *est);
void lode_core_hand_back(lode_drive_t *self, float omega_rad_s, lode_dq_t i_A);
lode_frame_t lode_core_own_frame(lode_drive_t *self, lode_ab_t i_A);
void lode_core_own_references(lode_drive_t *self, float v_bus_V);
void lode_core_control_speed(lode_drive_t *self, float omega_rad_s, float load_torque_Nm);

// Angle and speed at t_k.
LODE_INLINE lode_estimate_t lode_core_estimate(lode_drive_t *self, lode_ab_t u_V, lode_ab_t i_A) {
    const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
    if (!self->gates) { // the voltage at open terminals is not known
        lode_estimator_reset(&self->estimator, tuning);
        return (lode_estimate_t){.rotor = {0.0f, 1.0f}};
    }
    return lode_estimator_follow(&self->estimator, tuning, u_V, i_A);
}

// What the gates are driven by is a number. An estimate from outside may not be one; the drive's own
// always is.
static inline bool lode_core_is_finite(const lode_estimate_t *est) {
    return lode_abs(est->i_A.d) + lode_abs(est->i_A.q) + lode_abs(est->rotor.cos) +
               lode_abs(est->rotor.sin) + lode_abs(est->omega_rad_s) <=
           FLT_MAX;
}

// Too slow to run on, and not about to speed up.
LODE_INLINE bool is_too_slow(const lode_drive_t *self, float omega_rad_s) {
    return !(self->command.speed_rad_s * self->direction > 0.0f) &&
           lode_abs(omega_rad_s) <= HAND_BACK_SHARE * self->tuning->omega_min;
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
    const lode_situation_t here = {now.state, now.sensorless,
                                   now.finite}; // as in lode_guard_step()
    lode_guard_watch(&self->guard, &self->tuning->guard, condition, here);
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
            lode_core_hand_back(self, est->omega_rad_s, est->i_A);
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

// State machine of a period: after it the drive's gates are what this period's shall be.
LODE_INLINE void lode_core_follow(lode_drive_t *self, const lode_measurement_t *m,
                                  const lode_estimate_t *est) {
    self->steps++;
    if (lode_core_mode(self) != LODE_MODE_RUN || self->command.mode != LODE_MODE_RUN) {
        // A copy: the estimate itself stays in registers.
        const lode_estimate_t rotor = {est->omega_rad_s, est->rotor,   est->half_turn,
                                       est->i_A,         est->e_V,     est->load_torque_Nm,
                                       est->lock,        est->reseeded};
        lode_core_follow_command(self, m->calibration, m->offset_count, &rotor);
    }
}

// Speed and current control of a period with the gates on: the voltage of the frame, in self->u_V.
LODE_INLINE lode_frame_t lode_core_control(lode_drive_t *self, const lode_measurement_t *m,
                                           const lode_estimate_t *est) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float v_bus_V = m->sample.v_bus_V;
    const bool running = lode_core_mode(self) == LODE_MODE_RUN;
    lode_frame_t frame = {est->rotor, est->half_turn, est->omega_rad_s, est->omega_rad_s, est->i_A};
    if (!running) {
        const lode_ab_t i_A = {m->sample.i_A.alpha, m->sample.i_A.beta}; // a copy, as above
        const lode_frame_t own = lode_core_own_frame(self, i_A);
        frame = (lode_frame_t){own.rotor, own.half_turn, own.omega_rad_s, own.omega_rotor, own.i_A};
        lode_core_own_references(self, v_bus_V);
    }
    self->i_A = frame.i_A;
    // Speed control and, a period later, its current references: at their own rate, and with the usual
    // one, 4 periods, in the turns that are left.
    if (running && is_turn(self, 1u)) {
        lode_core_control_speed(self, est->omega_rad_s, est->load_torque_Nm);
    }
    if (running && is_turn(self, 2u)) {
        const lode_references_voltage_t voltage = {v_bus_V, self->u_V};
        const lode_references_out_t ref =
            lode_references_step(&self->references, &tuning->references, self->speed.torque_Nm,
                                 est->omega_rad_s, self->start.fade * self->start.id_A, voltage);
        self->ref_A = ref.i_A;
        self->speed.limit_Nm = ref.torque_Nm;
    }
    if (running || lode_core_mode(self) != LODE_MODE_VOLTAGE) {
        self->u_V = lode_current_step(&self->current, &tuning->current, self->ref_A, frame.i_A,
                                      frame.omega_rotor, v_bus_V);
    }
    return frame;
}

// The guard's look at a period with the gates on, and what is due in it of the slow parts. True: the
// gates may stay on.
LODE_INLINE bool lode_core_check(lode_drive_t *self, const lode_measurement_t *m,
                                 const lode_estimate_t *est, bool finite) {
    const lode_situation_t now = {self->mode, lode_core_mode(self) == LODE_MODE_RUN, finite};
    lode_guard_step(&self->guard, &self->tuning->guard, &m->sample, now);
    adapt(self, m, est, now);
    return lode_guard_is_good(&self->guard);
}

// The end of a period that is not driven: by now the gates go off where the guard said so.
LODE_INLINE void lode_core_stand_by(lode_drive_t *self) {
    if (!lode_guard_is_good(&self->guard) && lode_core_mode(self) != LODE_MODE_FAULT) {
        lode_core_switch_off(self, LODE_MODE_FAULT);
    }
}

#endif
