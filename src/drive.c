#include "drive_core.h"

#define TELEMETRY_TRIES 3

void lode_drive_begin(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    *self = (lode_drive_t){.tuning = tuning, .direction = 1.0f};
    lode_core_switch_off(self, LODE_MODE_OFF);
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
    self->posted = (lode_order_t){
        .vector = command->vector,
        .theta_rad = command->theta_rad,
        .speed_rad_s = command->mode == LODE_MODE_RUN ? command->speed_rad_s : command->omega_rad_s,
        .mode = command->mode,
        .clear_fault = command->clear_fault,
    };
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
            .mode = lode_core_mode(self),
            .fault = self->guard.fault,
            .duty = self->duty,
            .i_A = self->i_A,
            .ref_A = self->ref_A,
            .u_V = self->u_V,
            .v_bus_V = self->inverter.v_bus_V,
            .temperature_degC = self->temperature_degC,
            .theta_rad = lode_estimator_theta_rad(&self->estimator),
            .omega_rad_s = pll->omega_rad_s,
            .speed_ref_rad_s = lode_drive_speed_ref_rad_s(self),
            .load_torque_Nm = self->tuning->estimator.load_per_f_Nm * pll->f_rad_s2,
            .lock = self->estimator.lock,
            .e_V = self->estimator.emf.observer.e_V,
        };
        LODE_SIGNAL_FENCE();
        if (steps == self->steps) {
            return true;
        }
    }
    return false;
}

// Counts to amperes and volts, and the voltage that really acted over the last period.
LODE_INLINE lode_measurement_t sensed(lode_drive_t *self, const lode_counts_t *counts) {
    if (self->mail) {
        lode_core_take_mail(self);
    }
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_calibration_t calibration = LODE_CALIBRATION_RUNNING;
    float offset_count = 0.0f;
    if (LODE_RARELY(!self->gates) && lode_core_mode(self) == LODE_MODE_CALIBRATE) {
        float worst_count;
        calibration = lode_sense_calibrate(&self->sense, &self->state.sums, &tuning->sense, counts,
                                           &worst_count);
        offset_count = worst_count;
    }
    const lode_sample_t sample =
        lode_sense_glance(&self->sense, &tuning->sense, counts, self->unsampled);
    const lode_ab_t u_V = lode_inverter_realised(&self->inverter, sample.v_bus_V);
    return (lode_measurement_t){sample, u_V, calibration, offset_count};
}

// Duties for the voltage of the frame, turned to where it will stand while they act: one and a half
// periods after the sample.
LODE_INLINE lode_abc_t modulate(lode_drive_t *self, const lode_frame_t *frame, float per_bus) {
    const lode_inverter_tuning_t *tuning = &self->tuning->inverter;
    const lode_sincos_t acting = lode_angle_add(frame->rotor, lode_angle_triple(frame->half_turn));
    const lode_ab_t v = lode_ab_scale(per_bus, lode_park_inverse(self->u_V, acting));
    const lode_modulator_out_t out =
        lode_modulator_set1(tuning, self->inverter.loss, v, lode_park_inverse(frame->i_A, acting));
    if (LODE_RARELY(self->tuning->sense.windowed)) {
        self->unsampled = self->unsampled_next;
        self->unsampled_next = (uint_least8_t)lode_sense_unused(&self->tuning->sense, out.duty);
    }
    self->duty = out.duty;
    lode_inverter_write(&self->inverter, out.realised);
    return out.duty;
}

// Something is wrong with this period: its sample is made once more, rather than kept at hand in all of
// them.
static LODE_NOINLINE void examine(lode_drive_t *self, const lode_counts_t *counts) {
    const lode_sample_t sample =
        lode_sense_step(&self->sense, &self->tuning->sense, counts, self->unsampled);
    lode_core_examine(self, &sample, true);
}

// The guard's look at what must not wait.
LODE_INLINE void glance(lode_drive_t *self, const lode_period_t *p) {
    const bool own = p->counts != NULL;
    const bool finite = own || lode_core_is_finite(p->est);
    if (LODE_RARELY(!finite) || LODE_RARELY(!lode_core_is_usual(self, p))) {
        if (own) {
            examine(self, p->counts);
        } else {
            lode_core_examine(self, &p->m->sample, finite);
        }
    }
    self->guard.stamp = stamp_of(p);
}

// From angle and speed to duties: control, modulation and the last word of the guard.
LODE_INLINE lode_drive_out_t acted(lode_drive_t *self, const lode_period_t *p) {
    // Divided while the state machine decides.
    const float per_bus = lode_modulator_per_bus(&self->tuning->inverter, p->m->sample.v_bus_V);
    lode_core_follow(self, p);
    if (LODE_USUALLY(self->gates)) {
        glance(self, p);
        const lode_frame_t frame = lode_core_control(self, p);
        const lode_abc_t duty = modulate(self, &frame, per_bus);
        lode_core_adapt(self, p);
        if (LODE_USUALLY(lode_guard_is_good(&self->guard))) {
            return (lode_drive_out_t){duty, true};
        }
    } else {
        note_temperature(self, p);
    }
    lode_core_stand_by(self);
    return (lode_drive_out_t){self->duty, self->gates};
}

lode_measurement_t lode_drive_sense(lode_drive_t *self, const lode_counts_t *counts) {
    lode_measurement_t measurement = sensed(self, counts);
    lode_sample_t *sample = &measurement.sample;
    sample->railed =
        sample->alert && lode_sense_railed(&self->tuning->sense, counts, self->unsampled);
    return measurement;
}

lode_estimate_t lode_drive_estimate(lode_drive_t *self, const lode_measurement_t *measurement) {
    return lode_core_estimate(self, measurement->u_V, measurement->sample.i_A);
}

lode_drive_out_t lode_drive_act(lode_drive_t *self, const lode_measurement_t *measurement,
                                const lode_estimate_t *estimate) {
    const lode_period_t period = {measurement, estimate, NULL, NULL};
    return acted(self, &period);
}

LODE_RAMFUNC lode_drive_out_t lode_drive_step(lode_drive_t *self, const lode_counts_t *counts) {
    const lode_measurement_t measured = sensed(self, counts); // counts -> A, V, realised voltage
    const lode_estimate_t rotor =
        lode_core_estimate(self, measured.u_V, measured.sample.i_A); // -> angle and speed at t_k
    const lode_period_t period = {&measured, &rotor, counts, NULL};
    return acted(self, &period); // -> duties, gates
}
