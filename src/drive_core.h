// What the drives for three and for six phases share: state machine, estimation, control and guard of a
// period, but not the windings' own sensing and modulation. Included by drive.c and drive6.c.
#ifndef LODESTAR_DRIVE_CORE_H
#define LODESTAR_DRIVE_CORE_H

#include "estimator_inline.h"
#include "lodestar/drive.h"

#include <stddef.h>

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

// Where VOLTAGE, CURRENT and START control the currents. Four floats are returned in registers.
typedef struct {
    lode_sincos_t at;
    lode_sincos_t half_turn;
} lode_own_frame_t;

// A period for those who look at it late: after estimation, after control. What only they need they read
// themselves, so that it takes no register before.
typedef struct {
    const lode_measurement_t *m;
    const lode_estimate_t *est;
    const lode_counts_t *counts;   // from which both were made; NULL: they came from outside
    const lode_counts_t *counts_2; // of set 2, or NULL
} lode_period_t;

LODE_INLINE uint32_t stamp_of(const lode_period_t *p) {
    return p->counts != NULL ? p->counts->stamp : p->m->sample.stamp;
}

LODE_INLINE bool is_tripped(const lode_period_t *p) {
    if (p->counts == NULL) {
        return p->m->sample.trip;
    }
    return p->counts->trip || (p->counts_2 != NULL && p->counts_2->trip);
}

// Of the hotter set.
LODE_INLINE float temperature_degC(const lode_sense_tuning_t *tuning, const lode_period_t *p) {
    if (p->counts == NULL) {
        return lode_sense_temperature_degC(tuning, p->m->sample.temperature_count);
    }
    const float first = lode_sense_temperature_degC(tuning, p->counts->temperature);
    return p->counts_2 == NULL
               ? first
               : lode_max(first, lode_sense_temperature_degC(tuning, p->counts_2->temperature));
}

LODE_INLINE float omega_of(const lode_drive_t *self, const lode_period_t *p) {
    return p->counts != NULL ? self->estimator.pll.omega_rad_s : p->est->omega_rad_s;
}

LODE_INLINE float lock_of(const lode_drive_t *self, const lode_period_t *p) {
    return p->counts != NULL ? self->estimator.lock : p->est->lock;
}

LODE_INLINE float load_torque_Nm(const lode_drive_t *self, const lode_period_t *p) {
    return p->counts != NULL
               ? lode_estimator_load_torque_Nm(&self->estimator, &self->tuning->estimator)
               : p->est->load_torque_Nm;
}

// Who is due in which of LODE_SLOW_PERIODS: about equally dear. Speed control has two of the others, and
// its references two.
enum {
    TURN_LOCK = 0,
    TURN_HOLD = 1, // in START
    TURN_SEED = 2, // without lock
    TURN_GUARD_AND_LAG = 3,
    TURN_LOSS = 4,  // the shape of the dead-time loss; gains where there are notches
    TURN_XY = 4,    // with six phases: the resonators of the xy plane
    TURN_START = 5, // its profile and its judgement of the estimate
    TURN_HAND_OVER = 6,
    TURN_GUARD_AND_NOTCHES = 7 // or gains
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
void lode_core_follow_own(lode_drive_t *self, lode_calibration_t calibration, float offset_count,
                          float sine, float cosine, float id_A, float iq_A);
void lode_core_hand_back(lode_drive_t *self, float omega_rad_s, lode_dq_t i_A);
lode_own_frame_t lode_core_own_frame(lode_drive_t *self, lode_ab_t e_V, float v_bus_V);
void lode_core_count(lode_drive_t *self, lode_condition_t condition);
void lode_core_examine(lode_drive_t *self, const lode_sample_t *sample, bool finite);
void lode_core_control_speed(lode_drive_t *self, float omega_rad_s, float load_torque_Nm);

// Angle and speed at t_k.
LODE_INLINE lode_estimate_t lode_core_estimate(lode_drive_t *self, lode_ab_t u_V, lode_ab_t i_A) {
    const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
    if (LODE_RARELY(!self->gates)) { // the voltage at open terminals is not known
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

LODE_INLINE void note_temperature(lode_drive_t *self, const lode_period_t *p) {
    self->temperature_degC = temperature_degC(&self->tuning->sense, p);
}

// Whether something is due that comes `turn` periods after every `speed_periods`, a power of two.
LODE_INLINE bool is_turn(const lode_drive_t *self, uint32_t turn) {
    return ((self->steps - turn) & (self->tuning->speed_periods - 1u)) == 0u;
}

LODE_INLINE void watch(lode_drive_t *self, const lode_period_t *p) {
    note_temperature(self, p);
    const lode_condition_t condition = {p->m->sample.v_bus_V, self->temperature_degC,
                                        self->direction * omega_of(self, p), lock_of(self, p)};
    if (LODE_RARELY(!lode_guard_is_at_ease(&self->guard, &self->tuning->guard, &condition))) {
        const lode_condition_t seen = {condition.v_bus_V, condition.temperature_degC,
                                       condition.omega_rad_s, condition.lock}; // a copy, as below
        lode_core_count(self, seen);
    }
}

// What follows speed and load. After the duties, which do not wait for it.
LODE_INLINE void lode_core_adapt(lode_drive_t *self, const lode_period_t *p) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_estimator_t *estimator = &self->estimator;
    switch (self->steps % LODE_SLOW_PERIODS) {
    case TURN_LOCK:
        if (lode_core_mode(self) == LODE_MODE_RUN && is_too_slow(self, omega_of(self, p))) {
            lode_core_hand_back(self, omega_of(self, p), self->i_A);
        }
        lode_estimator_adapt_lock(estimator, &tuning->estimator);
        break;
    case TURN_SEED:
        if (LODE_RARELY(!estimator->locked)) {
            (void)lode_estimator_adapt_seed(estimator, &tuning->estimator);
        }
        break;
    case TURN_GUARD_AND_LAG:
        watch(self, p);
        lode_estimator_adapt_lag(estimator, &tuning->estimator);
        break;
    case TURN_LOSS:
        lode_inverter_adapt(&self->inverter, &tuning->inverter, self->u_V, p->m->sample.v_bus_V);
        if (tuning->estimator.notched) {
            lode_estimator_adapt_gains(estimator, &tuning->estimator);
        }
        break;
    case TURN_GUARD_AND_NOTCHES:
        watch(self, p);
        if (tuning->estimator.notched) {
            lode_estimator_adapt_notches(estimator, &tuning->estimator);
        } else {
            lode_estimator_adapt_gains(estimator, &tuning->estimator);
        }
        break;
    default:
        break;
    }
}

// In START with nothing to decide.
LODE_INLINE bool is_starting(const lode_drive_t *self) {
    const uint32_t turn = self->steps % LODE_SLOW_PERIODS;
    return lode_core_mode(self) == LODE_MODE_START && self->command.mode == LODE_MODE_RUN &&
           turn != TURN_START && turn != TURN_HAND_OVER;
}

// State machine of a period: after it the drive's gates are what this period's shall be.
LODE_INLINE void lode_core_follow(lode_drive_t *self, const lode_period_t *p) {
    self->steps++;
    if ((LODE_RARELY(lode_core_mode(self) != LODE_MODE_RUN) ||
         LODE_RARELY(self->command.mode != LODE_MODE_RUN)) &&
        !is_starting(self)) {
        const lode_estimate_t *est = p->est;
        if (p->counts == NULL) {
            lode_core_follow_command(self, p->m->calibration, p->m->offset_count, est);
        } else { // by parts: the estimate itself stays in registers
            lode_core_follow_own(self, p->m->calibration, p->m->offset_count, est->rotor.sin,
                                 est->rotor.cos, est->i_A.d, est->i_A.q);
        }
    }
}

// Speed and current control of a period with the gates on: the voltage of the frame, in self->u_V.
LODE_INLINE lode_frame_t lode_core_control(lode_drive_t *self, const lode_period_t *p) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_measurement_t *m = p->m;
    const lode_estimate_t *est = p->est;
    const float v_bus_V = m->sample.v_bus_V;
    const bool running = lode_core_mode(self) == LODE_MODE_RUN;
    lode_frame_t frame = {est->rotor, est->half_turn, est->omega_rad_s, est->omega_rad_s, est->i_A};
    if (LODE_RARELY(!running)) {
        const lode_ab_t e_V = p->counts != NULL ? self->estimator.emf.observer.e_V : est->e_V;
        const lode_own_frame_t own = lode_core_own_frame(self, e_V, v_bus_V);
        const lode_ab_t i_A = {m->sample.i_A.alpha, m->sample.i_A.beta}; // a copy, as above
        const bool starting = lode_core_mode(self) == LODE_MODE_START;
        const float omega = starting ? self->state.start.omega_rad_s : self->command.speed_rad_s;
        frame = (lode_frame_t){own.at, own.half_turn, omega, 0.0f, lode_park(i_A, own.at)};
    }
    self->i_A = frame.i_A;
    // Speed control and, a period later, its current references: at their own rate, and with the usual
    // one, 4 periods, in the turns that are left.
    if (running && is_turn(self, 1u)) {
        lode_core_control_speed(self, est->omega_rad_s, load_torque_Nm(self, p));
    }
    if (running && is_turn(self, 2u)) {
        lode_running_t *run = &self->state.run;
        const lode_references_voltage_t voltage = {v_bus_V, {self->u_V.d, self->u_V.q}};
        const lode_references_out_t ref =
            lode_references_step(&run->references, &tuning->references, run->speed.torque_Nm,
                                 est->omega_rad_s, run->fade * run->id_A, voltage);
        self->ref_A = (lode_dq_t){ref.i_A.d, ref.i_A.q};
        run->speed.limit_Nm = (lode_range_t){ref.torque_Nm.min, ref.torque_Nm.max};
    }
    if (running || lode_core_mode(self) != LODE_MODE_VOLTAGE) {
        self->u_V = lode_current_step(&self->current, &tuning->current, self->ref_A, frame.i_A,
                                      frame.omega_rotor, v_bus_V);
    }
    return frame;
}

// Whether the guard lets a period with the gates on pass at a glance; else lode_core_examine() is due.
LODE_INLINE bool lode_core_is_usual(const lode_drive_t *self, const lode_period_t *p) {
    return lode_guard_is_usual(&self->guard, &self->tuning->guard, is_tripped(p),
                               p->m->sample.alert, stamp_of(p));
}

// The end of a period that is not driven: by now the gates go off where the guard said so.
LODE_INLINE void lode_core_stand_by(lode_drive_t *self) {
    if (!lode_guard_is_good(&self->guard) && lode_core_mode(self) != LODE_MODE_FAULT) {
        lode_core_switch_off(self, LODE_MODE_FAULT);
    }
}

#endif
