#include "rig/rig.h"

#include "lodestar/channel.h"

#include <math.h>
#include <stddef.h>

// Periods per pass of the main loop: a slow round, about 600 passes per second at 5 kHz.
#define MAIN_LOOP_PERIODS LODE_SLOW_PERIODS
// Below this current the chord is not defined.
#define CHORD_LEAST_A 1e-3

static void begin_learning(rig_t *self, const rig_config_t *config) {
    const bool elsewhere = config->adaptation.psi == 1 || config->adaptation.Rs == 1;
    self->learns = lode_learn_design(&self->learn_tuning, &config->drive,
                                     elsewhere ? LODE_OFF : LODE_ON) == LODE_OK;
    if (self->learns) {
        lode_learn_begin(&self->learn, &self->learn_tuning, &config->drive, NULL);
    }
}

/// As in firmware: a tuning other than the one in use or that of the adaptation.
static lode_drive_tuning_t *spare_tuning(rig_t *self) {
    const lode_drive_tuning_t *used =
        self->adapts ? self->adaptation.machine.base : self->three.tuning;
    return &self->three_tuning[used == &self->three_tuning[0] ? 1 : 0];
}

static lode_drive6_tuning_t *spare_tuning6(rig_t *self) {
    const lode_drive6_tuning_t *used = self->adapts ? self->adaptation6.base : self->six.tuning;
    return &self->six_tuning[used == &self->six_tuning[0] ? 1 : 0];
}

static lode_status_t post(rig_t *self, const lode_drive_tuning_t *next) {
    if (self->adapts) {
        self->posts = next;
        return LODE_OK;
    }
    return lode_drive_post_tuning(&self->three, next);
}

static lode_status_t post6(rig_t *self, const lode_drive6_tuning_t *next) {
    if (self->adapts) {
        self->posts6 = next;
        return LODE_OK;
    }
    return lode_drive6_post_tuning(&self->six, next);
}

#define ADAPT_EVERY_s 1e-3 // period of the main loop

static lode_choice_t choice(int on) {
    return on == 1 ? LODE_ON : LODE_OFF;
}

static lode_status_t init_adaptation(rig_t *self, const rig_config_t *config) {
    const rig_adaptation_t *wanted = &config->adaptation;
    self->adapts = wanted->J == 1 || wanted->psi == 1 || wanted->Rs == 1;
    if (!self->adapts) {
        return LODE_OK;
    }
    const lode_adaptation_config_t choices = {choice(wanted->J), choice(wanted->psi),
                                              choice(wanted->Rs)};
    self->adapt_every = (uint32_t)fmax(1.0, round(ADAPT_EVERY_s * (double)config->drive.f_pwm_Hz));
    if (self->sets == PLANT_SETS) {
        lode_drive6_config_t six = rig_config_six(config);
        lode_drive6_design(&six);
        return lode_adaptation6_init(&self->adaptation6, &choices, &self->six_tuning[0],
                                     &six.drive.motor, NULL);
    }
    lode_drive_config_t designed = config->drive;
    lode_drive_design(&designed);
    return lode_adaptation_init(&self->adaptation, &choices, &self->three_tuning[0],
                                &designed.motor, NULL);
}

lode_status_t rig_init(rig_t *self, const rig_config_t *config, const plant_config_t *plant) {
    self->sets = plant->sets == PLANT_SETS ? PLANT_SETS : 1;
    (void)plant_init(&self->plant, plant);
    self->learns = false;
    self->learning = config->drive;
    self->posts = NULL;
    self->posts6 = NULL;
    self->limits = (limits_t){.by_supply = false};
    self->bus = (bus_t){.chops = false};
    if (self->sets == 1) {
        self->drive = &self->three;
        begin_learning(self, config);
        const lode_status_t status =
            lode_drive_init(&self->three, &self->three_tuning[0], &config->drive);
        return status == LODE_OK ? init_adaptation(self, config) : status;
    }
    const lode_drive6_config_t six = rig_config_six(config);
    self->drive = &self->six.drive;
    const lode_status_t status = lode_drive6_init(&self->six, &self->six_tuning[0], &six);
    return status == LODE_OK ? init_adaptation(self, config) : status;
}

static lode_status_t retune_six(rig_t *self, const rig_config_t *config,
                                const lode_motor_t *motor) {
    lode_drive6_config_t six = rig_config_six(config);
    six.drive.motor = *motor;
    lode_drive6_tuning_t *next = spare_tuning6(self);
    const lode_status_t status = lode_drive6_tune(next, &six);
    return status == LODE_OK ? post6(self, next) : status;
}

lode_status_t rig_retune(rig_t *self, const rig_config_t *config, const lode_motor_t *motor) {
    if (self->sets == PLANT_SETS) {
        return retune_six(self, config, motor);
    }
    lode_drive_config_t drive = config->drive;
    drive.motor = *motor;
    lode_drive_tuning_t *next = spare_tuning(self);
    const lode_status_t status = lode_drive_tune(next, &drive);
    if (status != LODE_OK) {
        return status;
    }
    // The learned values are discarded; the limits stay those of the configured motor.
    const lode_learned_t now = {motor->Lq_H, motor->psi_Wb, 0.0f};
    if (self->learns) {
        lode_learn_begin(&self->learn, &self->learn_tuning, &drive, &now);
    }
    return post(self, next);
}

void rig_main_loop(rig_t *self) {
    lode_telemetry_t now;
    const float dt_s = (float)MAIN_LOOP_PERIODS / self->learning.f_pwm_Hz;
    limits_apply(&self->limits, self->drive);
    if (self->posts != NULL && lode_adaptation_post(&self->adaptation, &self->three, self->posts)) {
        self->posts = NULL;
    }
    if (self->posts6 != NULL &&
        lode_adaptation6_post(&self->adaptation6, &self->six, self->posts6)) {
        self->posts6 = NULL;
    }
    if (!self->learns || self->drive->steps % MAIN_LOOP_PERIODS != 0u ||
        !lode_drive_telemetry(self->drive, &now) ||
        !lode_learn_step(&self->learn, &self->learn_tuning, &now, dt_s) || self->posts != NULL) {
        return;
    }
    lode_drive_tuning_t *next = spare_tuning(self);
    if (lode_learn_tune(&self->learn, next, &self->learning) == LODE_OK) {
        (void)post(self, next);
    }
}

double rig_true_Lq_H(const rig_t *self) {
    const plant_motor_t *motor = &self->plant.motor;
    const double iq_A = motor->x.iq_A;
    if (!motor->saturates || fabs(iq_A) < CHORD_LEAST_A) {
        return motor->Lq_H;
    }
    return plant_iron_at(&motor->iron, motor->x.id_A, iq_A).psi_q_Wb / iq_A;
}

void rig_tell(const rig_t *self, lode_telemetry_t *telemetry) {
    (void)lode_drive_telemetry(self->drive, telemetry);
    if (self->adapts && self->sets == PLANT_SETS) {
        lode_adaptation6_telemetry(&self->adaptation6, telemetry);
    } else if (self->adapts) {
        lode_adaptation_telemetry(&self->adaptation, telemetry);
    } else {
        // nothing was learned
    }
    if (self->learns) {
        lode_learn_telemetry(&self->learn, telemetry);
    }
}

// Pointers into `from` become pointers to the same place in `to`.
static const void *moved(rig_t *to, const rig_t *from, const void *pointer) {
    return pointer != NULL ? (const char *)to + ((const char *)pointer - (const char *)from) : NULL;
}

static void move_adaptation(lode_adaptation_machine_t *machine, rig_t *to, const rig_t *from) {
    machine->base = moved(to, from, machine->base);
    machine->posted = moved(to, from, machine->posted);
}

// All tunings belong to the rig or to its adaptation.
void rig_copy(rig_t *to, const rig_t *from) {
    *to = *from;
    to->drive = from->sets == PLANT_SETS ? &to->six.drive : &to->three;
    to->drive->tuning = moved(to, from, from->drive->tuning);
    to->drive->posted_tuning = moved(to, from, from->drive->posted_tuning);
    if (from->sets == PLANT_SETS) {
        to->six.tuning = moved(to, from, from->six.tuning);
        to->six.posted_tuning = moved(to, from, from->six.posted_tuning);
    }
    if (from->adapts && from->sets == PLANT_SETS) {
        to->adaptation6.base = moved(to, from, from->adaptation6.base);
        to->posts6 = moved(to, from, from->posts6);
        move_adaptation(&to->adaptation6.machine, to, from);
    } else if (from->adapts) {
        to->posts = moved(to, from, from->posts);
        move_adaptation(&to->adaptation.machine, to, from);
    } else {
        // no tuning follows
    }
}

lode_counts_t rig_counts(const plant_counts_t *plant) {
    return (lode_counts_t){
        .i = {plant->i[0], plant->i[1], plant->i[2]},
        .v_bus = plant->v_bus,
        .temperature = plant->temperature,
        .trip = plant->trip,
        .stamp = plant->stamp,
    };
}

void rig_write_set(plant_t *plant, int set, const lode_drive_out_t *out) {
    const double duty[PLANT_PHASES] = {(double)out->duty.a, (double)out->duty.b,
                                       (double)out->duty.c};
    plant_write_set(plant, set, duty, (plant_gates_t)out->gates); // the same three values
}

/// lode_drive_step() in its three parts.
static void step_three(rig_t *self, const plant_counts_t *sampled, runner_estimator_t estimate,
                       runner_memory_t *memory, rig_moment_t *now) {
    const lode_counts_t counts = rig_counts(sampled);
    const lode_sample_t sample = lode_drive_sense(&self->three, &counts);
    now->estimate = estimate(&self->three, &sample, &now->truth, memory);
    const lode_drive_out_t out = lode_drive_act(&self->three, &sample, &now->estimate);
    rig_write_set(&self->plant, 0, &out);
}

static void step_six(rig_t *self, const plant_counts_t sampled[PLANT_SETS], rig_moment_t *now) {
    const lode_counts6_t counts = {{rig_counts(&sampled[0]), rig_counts(&sampled[1])}};
    const lode_drive6_out_t out = lode_drive6_step(&self->six, &counts);
    lode_telemetry_t seen;
    (void)lode_drive_telemetry(self->drive, &seen);
    now->estimate = (lode_estimate_t){
        .omega_rad_s = seen.omega_rad_s,
        .rotor = lode_sincos(seen.theta_rad),
        .i_A = seen.i_A,
        .e_V = seen.e_V,
        .load_torque_Nm = seen.load_torque_Nm,
        .lock = seen.lock,
    };
    rig_write_set(&self->plant, 0, &out.set[0]);
    rig_write_set(&self->plant, 1, &out.set[1]);
}

static void adapt(rig_t *self) {
    if (!self->adapts || self->drive->steps % self->adapt_every != 0u) {
        return;
    }
    if (self->sets == PLANT_SETS) {
        (void)lode_adaptation6_step(&self->adaptation6, &self->six);
    } else {
        (void)lode_adaptation_step(&self->adaptation, &self->three);
    }
}

void rig_step(rig_t *self, runner_estimator_t estimate, runner_memory_t *memory,
              rig_moment_t *now) {
    plant_counts_t sampled[PLANT_SETS];
    plant_sample(&self->plant, sampled, &now->truth);
    if (self->bus.chops) {
        plant_write_chopper(&self->plant, bus_chop(&self->bus, sampled[0].v_bus));
    }
    if (self->sets == PLANT_SETS) {
        step_six(self, sampled, now);
    } else {
        step_three(self, sampled, estimate, memory, now);
    }
    adapt(self);
    plant_advance(&self->plant);
}

int rig_found_open(const rig_t *self) {
    return self->sets == PLANT_SETS ? (int)self->six.open : 0;
}

lode_ab_t rig_seen_i_A(const rig_t *self) {
    return (lode_ab_t){lode_channel_read(self->drive, LODE_CHANNEL_I_ALPHA),
                       lode_channel_read(self->drive, LODE_CHANNEL_I_BETA)};
}

lode_ab_t rig_next_u_V(const rig_t *self) {
    if (self->sets == PLANT_SETS) { // of both sets or of the one in use: computed in a copy
        lode_drive6_t next = self->six;
        const lode_counts6_t counts = {{{.v_bus = 0}}};
        return lode_drive6_sense(&next, &counts).u_seen_V;
    }
    return (lode_ab_t){lode_channel_read(self->drive, LODE_CHANNEL_U_ALPHA),
                       lode_channel_read(self->drive, LODE_CHANNEL_U_BETA)};
}

lode_abc_t rig_duty_2(const rig_t *self) {
    return self->sets == PLANT_SETS ? self->six.duty_2 : (lode_abc_t){0.0f, 0.0f, 0.0f};
}
