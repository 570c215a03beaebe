#include "lodestar/drive6.h"

#include "drive_core.h"

#define TELEMETRY_TRIES 3

static lode_active_t active_of(const lode_drive6_t *self) {
    return (lode_active_t)self->active;
}

static LODE_NOINLINE void rest(lode_drive6_t *self) {
    self->duty_2 = (lode_abc_t){LODE_DUTY_IDLE, LODE_DUTY_IDLE, LODE_DUTY_IDLE};
    const int32_t unsampled = lode_sense_unused(&self->drive.tuning->sense, self->duty_2);
    self->unsampled_2 = self->unsampled_next_2 = (uint_least8_t)unsampled;
    self->u_xy_V = (lode_ab_t){0.0f, 0.0f};
    lode_inverter_reset(&self->inverter_2);
    lode_xy_reset(&self->xy);
    lode_open_phase_reset(&self->watch);
}

// Both sets, or the one that is left.
static void use(lode_drive6_t *self, lode_active_t active) {
    self->active = (uint_least8_t)active;
    self->drive.tuning = active == LODE_SETS_BOTH ? &self->tuning->drive : &self->tuning->alone;
}

void lode_drive6_begin(lode_drive6_t *self, const lode_drive6_tuning_t *tuning) {
    *self = (lode_drive6_t){.tuning = tuning};
    lode_drive_begin(&self->drive, &tuning->drive);
    lode_sense_reset(&self->sense_2, &tuning->drive.sense);
    rest(self);
}

lode_status_t lode_drive6_init(lode_drive6_t *self, lode_drive6_tuning_t *tuning,
                               const lode_drive6_config_t *config) {
    if (self == NULL) {
        return LODE_ERROR_NULL;
    }
    const lode_status_t status = lode_drive6_tune(tuning, config);
    if (status == LODE_OK) {
        lode_drive6_begin(self, tuning);
    }
    return status;
}

lode_status_t lode_drive6_post_tuning(lode_drive6_t *self, const lode_drive6_tuning_t *tuning) {
    if (self == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    LODE_SIGNAL_FENCE();
    self->posted_tuning = tuning;
    LODE_SIGNAL_FENCE();
    self->drive.mail = true;
    return LODE_OK;
}

bool lode_drive6_tuning_taken(const lode_drive6_t *self) {
    LODE_SIGNAL_FENCE();
    return self->posted_tuning == NULL;
}

bool lode_drive6_telemetry(const lode_drive6_t *self, lode_telemetry6_t *telemetry) {
    for (int32_t i = 0; i < TELEMETRY_TRIES; i++) {
        const bool whole = lode_drive_telemetry(&self->drive, &telemetry->drive);
        telemetry->duty_2 = self->duty_2;
        telemetry->i_xy_A = self->i_xy_A;
        telemetry->u_xy_V = self->u_xy_V;
        telemetry->active = active_of(self);
        telemetry->open = self->open;
        LODE_SIGNAL_FENCE();
        if (whole && telemetry->drive.steps == self->drive.steps) {
            return true;
        }
    }
    return false;
}

static LODE_NOINLINE void take_mail(lode_drive6_t *self) {
    lode_core_take_mail(&self->drive);
    if (self->posted_tuning != NULL) {
        self->tuning = self->posted_tuning;
        self->posted_tuning = NULL;
        use(self, active_of(self));
    }
    // A repaired phase is believed when the drive is at rest and asked to forget.
    const lode_order_t *command = &self->drive.command;
    if (command->mode == LODE_MODE_OFF && command->clear_fault && !self->drive.gates) {
        self->open = 0u;
        use(self, LODE_SETS_BOTH);
    }
}

// Both sets, until both are done.
static LODE_NOINLINE lode_calibration_t calibrated(lode_drive6_t *self, const lode_counts6_t *counts,
                                               float *worst_count) {
    const lode_sense_tuning_t *tuning = &self->drive.tuning->sense;
    if (self->drive.state.sums.samples == 0u) {
        lode_sense_begin(&self->sums_2);
    }
    float worst_1;
    float worst_2;
    const lode_calibration_t first = lode_sense_calibrate(
        &self->drive.sense, &self->drive.state.sums, tuning, &counts->set[0], &worst_1);
    const lode_calibration_t second =
        lode_sense_calibrate(&self->sense_2, &self->sums_2, tuning, &counts->set[1], &worst_2);
    *worst_count = lode_abs(worst_1) > lode_abs(worst_2) ? worst_1 : worst_2;
    return first == LODE_CALIBRATION_IMPLAUSIBLE ? first : second;
}

// The start, which has little EMF to go by, is left to both sets: with 6 % of harmonics in one of them it
// does not get through.
LODE_INLINE bool sees_one_set(const lode_drive6_t *self) {
    return self->tuning->source != LODE_SOURCE_VSD &&
           self->active == (uint_least8_t)LODE_SETS_BOTH &&
           lode_core_mode(&self->drive) == LODE_MODE_RUN;
}

// Without an index, which would put both into memory.
LODE_INLINE lode_ab_t of_set(const lode_sets_t *sets, bool first) {
    return first ? (lode_ab_t){sets->set[0].alpha, sets->set[0].beta}
                 : (lode_ab_t){sets->set[1].alpha, sets->set[1].beta};
}

LODE_INLINE lode_measurement6_t measured(lode_drive6_t *self, const lode_counts6_t *counts) {
    if (self->drive.mail) {
        take_mail(self);
    }
    lode_drive_t *drive = &self->drive;
    const lode_sense_tuning_t *tuning = &drive->tuning->sense;
    lode_measurement6_t x;
    x.m.calibration = LODE_CALIBRATION_RUNNING;
    x.m.offset_count = 0.0f;
    if (LODE_RARELY(!drive->gates) && lode_core_mode(drive) == LODE_MODE_CALIBRATE) {
        float worst_count;
        x.m.calibration = calibrated(self, counts, &worst_count);
        x.m.offset_count = worst_count;
    }
    const lode_sample_t first =
        lode_sense_glance(&drive->sense, tuning, &counts->set[0], drive->unsampled);
    const lode_abc_t i_2 = lode_sense_currents(&self->sense_2, &counts->set[1], self->unsampled_2);
    const lode_sample_t second = lode_sense_sample(tuning, &counts->set[1], i_2);
    const lode_sets_t u_V = {{lode_inverter_realised(&drive->inverter, first.v_bus_V),
                              lode_inverter_realised(&self->inverter_2, first.v_bus_V)}};
    x.watched = LODE_USUALLY(self->active == (uint_least8_t)LODE_SETS_BOTH) &&
                LODE_USUALLY(self->tuning->open_phase != LODE_OPEN_PHASE_IGNORE) &&
                LODE_USUALLY(lode_core_mode(drive) == LODE_MODE_RUN);
    if (x.watched) {
        lode_open_phase_note(&self->watch, &first.i_abc_A, &second.i_abc_A);
    }
    x.i_A.set[0] = first.i_A;
    x.i_A.set[1] = lode_set2_clarke_scaled(i_2, tuning->alpha_gain, tuning->beta_gain);
    x.m.sample.v_bus_V = first.v_bus_V;
    x.m.sample.alert = (bool)(first.alert | second.alert);
    self->i_xy_A = lode_vsd_xy(x.i_A);
    if (LODE_USUALLY(self->active == (uint_least8_t)LODE_SETS_BOTH)) {
        x.m.sample.i_A = lode_vsd_ab(x.i_A);
        x.m.u_V = lode_vsd_ab(u_V);
    } else {
        const bool first_alone = self->active == (uint_least8_t)LODE_SETS_ONLY_1;
        x.m.sample.i_A = of_set(&x.i_A, first_alone);
        x.m.u_V = of_set(&u_V, first_alone);
    }
    x.u_seen_V = x.m.u_V;
    x.i_seen_A = x.m.sample.i_A;
    if (sees_one_set(self)) {
        x.u_seen_V = of_set(&u_V, self->tuning->source == LODE_SOURCE_SET_1);
        x.i_seen_A = of_set(&x.i_A, self->tuning->source == LODE_SOURCE_SET_1);
    }
    return x;
}

// Angle and speed at t_k; the current in the rotor's frame is the one that is controlled.
LODE_INLINE lode_estimate_t estimated(lode_drive6_t *self, const lode_measurement6_t *x) {
    const lode_estimate_t seen = lode_core_estimate(&self->drive, x->u_seen_V, x->i_seen_A);
    // Not a changed copy: that would go through memory.
    return (lode_estimate_t){.omega_rad_s = seen.omega_rad_s,
                             .rotor = seen.rotor,
                             .half_turn = seen.half_turn,
                             .i_A = lode_park(x->m.sample.i_A, seen.rotor),
                             .e_V = seen.e_V,
                             .load_torque_Nm = seen.load_torque_Nm,
                             .lock = seen.lock,
                             .reseeded = seen.reseeded};
}

// One set goes on alone: its currents are twice those of both.
static LODE_NOINLINE void go_on_alone(lode_drive6_t *self, lode_active_t active, lode_ab_t i_A,
                                  lode_sincos_t rotor, float omega_rad_s) {
    lode_drive_t *drive = &self->drive;
    use(self, active);
    lode_estimator_rewire(&drive->estimator, i_A);
    drive->i_A = lode_park(i_A, rotor);
    lode_current_reset(&drive->current, &drive->tuning->current, drive->u_V, drive->i_A,
                       omega_rad_s);
    lode_references_reset(&drive->state.run.references, drive->i_A.d);
    drive->ref_A = drive->i_A; // until the speed control's turn
    lode_xy_reset(&self->xy);
    self->u_xy_V = (lode_ab_t){0.0f, 0.0f};
}

// `i_A`: of the other set.
static LODE_NOINLINE void answer(lode_drive6_t *self, lode_open_phase_t open, lode_ab_t i_A,
                             lode_sincos_t rotor, float omega_rad_s) {
    self->open = open;
    if (self->tuning->open_phase == LODE_OPEN_PHASE_TRIP) {
        lode_guard_trip(&self->drive.guard, self->drive.mode, LODE_CHECK_OPEN_PHASE, (float)open,
                        0.0f);
    } else {
        const bool in_1 = lode_open_phase_set(open) == 0;
        go_on_alone(self, in_1 ? LODE_SETS_ONLY_2 : LODE_SETS_ONLY_1, i_A, rotor, omega_rad_s);
    }
}

LODE_INLINE void watch_phases(lode_drive6_t *self, const lode_measurement6_t *x,
                              const lode_estimate_t *est) {
    if (!x->watched) {
        return;
    }
    const lode_open_phase_t open =
        lode_open_phase_step(&self->watch, &self->tuning->watch, est->rotor.sin);
    if (open > 0u) {
        const lode_sincos_t rotor = {est->rotor.sin,
                                     est->rotor.cos}; // a copy: it stays in registers
        answer(self, open, of_set(&x->i_A, lode_open_phase_set(open) == 1), rotor,
               est->omega_rad_s);
    }
}

// Voltages of both sets while the duties act, one and a half periods after the sample.
LODE_INLINE lode_sets_t voltages(lode_drive6_t *self, const lode_frame_t *frame,
                                 lode_sincos_t acting, float v_bus_V) {
    lode_ab_t xy = {0.0f, 0.0f};
    if (LODE_USUALLY(self->active == (uint_least8_t)LODE_SETS_BOTH)) {
        self->u_xy_V =
            lode_xy_step(&self->xy, &self->tuning->xy, lode_ab_turn(self->i_xy_A, frame->rotor),
                         frame->half_turn, v_bus_V);
        const lode_dq_t turned = lode_park(self->u_xy_V, acting);
        xy = (lode_ab_t){turned.d, turned.q};
    }
    return lode_vsd_sets(lode_park_inverse(self->drive.u_V, acting), xy);
}

LODE_INLINE lode_abc6_t modulate(lode_drive6_t *self, const lode_frame_t *frame, float v_bus_V,
                                 float per_bus) {
    lode_drive_t *drive = &self->drive;
    const lode_sincos_t acting = lode_angle_add(frame->rotor, lode_angle_triple(frame->half_turn));
    const lode_sets_t u_V = voltages(self, frame, acting, v_bus_V);
    const lode_sets_t v = {
        {lode_ab_scale(per_bus, u_V.set[0]), lode_ab_scale(per_bus, u_V.set[1])}};
    const lode_ab_t i_A = lode_park_inverse(frame->i_A, acting);
    const lode_modulator6_out_t out = lode_modulator6_sets(
        &drive->tuning->inverter, drive->inverter.loss, v, (lode_sets_t){{i_A, i_A}});
    if (LODE_RARELY(drive->tuning->sense.windowed)) {
        const lode_sense_tuning_t *tuning = &drive->tuning->sense;
        drive->unsampled = drive->unsampled_next;
        self->unsampled_2 = self->unsampled_next_2;
        drive->unsampled_next = (uint_least8_t)lode_sense_unused(tuning, out.duty.set[0]);
        self->unsampled_next_2 = (uint_least8_t)lode_sense_unused(tuning, out.duty.set[1]);
    }
    drive->duty = out.duty.set[0];
    self->duty_2 = out.duty.set[1];
    lode_inverter_write(&drive->inverter, out.realised.set[0]);
    lode_inverter_write(&self->inverter_2, out.realised.set[1]);
    return out.duty;
}

// All of both sets' samples in one. The machine is checked by set 1, unless only set 2 is beyond its limit.
static LODE_NOINLINE lode_sample_t sampled(const lode_drive6_t *self, const lode_counts6_t *counts) {
    const lode_drive_t *drive = &self->drive;
    const lode_sense_tuning_t *tuning = &drive->tuning->sense;
    lode_sample_t both = lode_sense_step(&drive->sense, tuning, &counts->set[0], drive->unsampled);
    const lode_sample_t second =
        lode_sense_step(&self->sense_2, tuning, &counts->set[1], self->unsampled_2);
    const bool hotter_2 =
        (second.temperature_count > both.temperature_count) == (tuning->temperature_gain > 0.0f);
    if (second.alert && !both.alert) {
        both.i_abc_A = second.i_abc_A;
    }
    both.temperature_count = hotter_2 ? second.temperature_count : both.temperature_count;
    both.trip = (bool)(both.trip | second.trip);
    both.alert = (bool)(both.alert | second.alert);
    both.railed = (bool)(both.railed | second.railed);
    return both;
}

// Something is wrong with this period: the samples are made once more, rather than kept at hand in all of
// them.
static LODE_NOINLINE void examine(lode_drive6_t *self, const lode_counts6_t *counts) {
    const lode_sample_t both = sampled(self, counts);
    lode_core_examine(&self->drive, &both, true);
}

// The guard's look at what must not wait. `counts`: NULL where the estimate came from outside.
LODE_INLINE void glance(lode_drive6_t *self, const lode_period_t *p, const lode_counts6_t *counts) {
    lode_drive_t *drive = &self->drive;
    const bool own = counts != NULL;
    const bool finite = own || lode_core_is_finite(p->est);
    if (LODE_RARELY(!finite) || LODE_RARELY(!lode_core_is_usual(drive, p))) {
        if (own) {
            examine(self, counts);
        } else {
            lode_core_examine(drive, &p->m->sample, finite);
        }
    }
    drive->guard.stamp = stamp_of(p);
}

// From angle and speed to duties: control, modulation and the last word of the guard.
LODE_INLINE lode_drive6_out_t acted(lode_drive6_t *self, const lode_measurement6_t *x,
                                    const lode_estimate_t *rotor, const lode_counts6_t *counts) {
    lode_drive_t *drive = &self->drive;
    const bool own = counts != NULL;
    const lode_period_t period = {&x->m, rotor, own ? &counts->set[0] : NULL,
                                  own ? &counts->set[1] : NULL};
    // Divided while the state machine decides.
    const float per_bus = lode_modulator_per_bus(&drive->tuning->inverter, x->m.sample.v_bus_V);
    lode_core_follow(drive, &period);
    if (LODE_USUALLY(drive->gates)) {
        glance(self, &period, counts);
        const lode_frame_t frame = lode_core_control(drive, &period);
        const lode_abc6_t duty = modulate(self, &frame, x->m.sample.v_bus_V, per_bus);
        watch_phases(self, x, rotor);
        if (drive->steps % LODE_SLOW_PERIODS == TURN_XY) {
            lode_xy_adapt(&self->xy, &self->tuning->xy, frame.omega_rad_s);
        }
        lode_core_adapt(drive, &period);
        if (LODE_USUALLY(lode_guard_is_good(&drive->guard))) {
            return (lode_drive6_out_t){
                {{duty.set[0], self->active != (uint_least8_t)LODE_SETS_ONLY_2},
                 {duty.set[1], self->active != (uint_least8_t)LODE_SETS_ONLY_1}}};
        }
    } else {
        note_temperature(drive, &period);
    }
    lode_core_stand_by(drive);
    rest(self);
    return (lode_drive6_out_t){{{drive->duty, drive->gates}, {self->duty_2, drive->gates}}};
}

lode_measurement6_t lode_drive6_sense(lode_drive6_t *self, const lode_counts6_t *counts) {
    lode_measurement6_t x = measured(self, counts);
    const lode_ab_t i_A = x.m.sample.i_A;
    x.m.sample = sampled(self, counts);
    x.m.sample.i_A = i_A;
    return x;
}

lode_estimate_t lode_drive6_estimate(lode_drive6_t *self, const lode_measurement6_t *measurement) {
    return estimated(self, measurement);
}

lode_drive6_out_t lode_drive6_act(lode_drive6_t *self, const lode_measurement6_t *measurement,
                                  const lode_estimate_t *estimate) {
    return acted(self, measurement, estimate, NULL);
}

LODE_RAMFUNC lode_drive6_out_t lode_drive6_step(lode_drive6_t *self, const lode_counts6_t *counts) {
    const lode_measurement6_t x = measured(self, counts);
    const lode_estimate_t rotor = estimated(self, &x);
    return acted(self, &x, &rotor, counts);
}
