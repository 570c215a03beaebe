// The whole drive, from rest or from one that runs, weakens its field, slows down, injects, makes a torque, has a
// sensor or is shorted: any counts, stamps, commands, tunings, torque limits and estimates from outside in any order
// give duties in range, and a picture in numbers. The main loop adapts, learns and limits the torque.
#include "support/fuzz_loop.h"

#include "lodestar/learn.h"

enum {
    AT_REST,
    STARTING,
    RUNNING,
    WEAKENING,
    SLOWING,
    INJECTING,
    SEARCHING,
    LEARNING,
    BY_TORQUE,
    BY_ENCODER,
    BY_HALL,
    SHORTED,
    SNAPSHOTS
};

#define PERIODS_MAX 3000u

typedef struct {
    lode_drive_t drive;
    const lode_drive_tuning_t *tuning; // with which it began
    plant_t plant;
    plant_truth_t truth;
    fuzz_guide_t guide;
    fuzz_loop_t loop;
    bool learns;
    lode_learn_t learn;
} pair_t;

static lode_drive_tuning_t plain_tuning;
static lode_drive_tuning_t injecting_tuning;
static fuzz_sensors_t sensors;
static lode_adaptation_t adaptation;
static lode_drive_config_t learning_config;
static lode_learn_tuning_t learn_tuning;
static lode_drive_tuning_t learned_tuning[2];
static uint32_t learned; // tunings of them that were posted

// One period of the drive, in one call or with an estimate from outside.
static lode_drive_out_t drive_step(pair_t *self, const lode_counts_t *counts) {
    if (self->guide.kind == FUZZ_BY_STEP) {
        return lode_drive_step(&self->drive, counts);
    }
    const lode_sample_t sample = lode_drive_sense(&self->drive, counts);
    const lode_estimate_t own = lode_drive_estimate(&self->drive, &sample);
    const lode_estimate_t given =
        fuzz_guide_next(&self->guide, &sensors, &own, sample.i_A, &self->truth);
    const bool driven = self->drive.gates;
    const lode_drive_out_t out = lode_drive_act(&self->drive, &sample, &given);
    fuzz_check_given(&given, driven, out.gates);
    return out;
}

static void adapt(pair_t *self, lode_telemetry_t *t) {
    (void)lode_adaptation_step(&adaptation, &self->drive);
    lode_adaptation_telemetry(&adaptation, t);
    fuzz_check_adapted(&t->motor);
}

// Whatever was learned, a tuning can be made for it.
static void learn(pair_t *self, const lode_telemetry_t *t) {
    const bool news = lode_learn_step(&self->learn, &learn_tuning, t, FUZZ_LOOP_s);
    const lode_learned_t *now = &self->learn.now;
    FUZZ_CHECK(lode_in_range(now->Lq_H, learn_tuning.Lq_H.min, learn_tuning.Lq_H.max));
    FUZZ_CHECK(lode_in_range(now->psi_Wb, learn_tuning.psi_Wb.min, learn_tuning.psi_Wb.max));
    FUZZ_CHECK(lode_in_range(now->confidence, 0.0f, 1.0f));
    if (news && lode_drive_tuning_taken(&self->drive)) {
        lode_drive_tuning_t *next = &learned_tuning[learned % 2u];
        FUZZ_CHECK(lode_learn_tune(&self->learn, next, &learning_config) == LODE_OK);
        FUZZ_CHECK(lode_drive_post_tuning(&self->drive, next) == LODE_OK);
        learned++;
    }
}

// One period: what the drive does of `counts`, which the motor may have seen.
static void step(pair_t *self, const lode_counts_t *counts) {
    const lode_drive_out_t out = drive_step(self, counts);
    lode_telemetry_t t;
    FUZZ_CHECK(lode_drive_telemetry(&self->drive, &t));
    fuzz_check_out(out, &t);
    fuzz_check_telemetry(&t);
    fuzz_plant_write(&self->plant, 0, out);
    plant_advance(&self->plant);
    fuzz_loop_step(&self->loop, &self->drive, &t);
    if (self->loop.adapts && self->loop.periods % FUZZ_LOOP_PERIODS == 0u) {
        adapt(self, &t);
    }
    if (self->learns && self->loop.periods % FUZZ_LOOP_PERIODS == 0u) {
        learn(self, &t);
    }
}

static lode_counts_t sampled(pair_t *self) {
    plant_counts_t counts[PLANT_SETS];
    plant_sample(&self->plant, counts, &self->truth);
    return fuzz_plant_counts(&counts[0]);
}

static void run(pair_t *self, uint32_t periods) {
    for (uint32_t n = 0; n < periods; n++) {
        const lode_counts_t counts = sampled(self);
        step(self, &counts);
    }
}

static void command(pair_t *self, float speed_rad_s) {
    const lode_command_t go = {.mode = LODE_MODE_RUN, .speed_rad_s = speed_rad_s};
    FUZZ_CHECK(fuzz_loop_post(&self->loop, &self->drive, &go) == LODE_OK);
}

static lode_mode_t mode(const pair_t *self) {
    return (lode_mode_t)self->drive.mode;
}

static pair_t begun(const lode_drive_tuning_t *tuning) {
    const plant_config_t plant = fuzz_plant_config();
    pair_t now = {.tuning = tuning};
    fuzz_plant_init(&now.plant, &plant);
    fuzz_loop_init(&now.loop);
    FUZZ_CHECK(lode_drive_begin(&now.drive, tuning) == LODE_OK);
    return now;
}

// From standstill through all that a day brings.
static void make(pair_t snapshots[SNAPSHOTS]) {
    pair_t now = begun(&plain_tuning);
    snapshots[AT_REST] = now;
    command(&now, 100.0f);
    run(&now, 1500u);
    FUZZ_CHECK(mode(&now) == LODE_MODE_START);
    snapshots[STARTING] = now;
    run(&now, 8000u);
    FUZZ_CHECK(mode(&now) == LODE_MODE_RUN);
    snapshots[RUNNING] = now;
    command(&now, 340.0f);
    run(&now, 15000u);
    FUZZ_CHECK(mode(&now) == LODE_MODE_RUN && now.drive.ref_A.d < -2.0f);
    snapshots[WEAKENING] = now;
    now = snapshots[RUNNING];
    command(&now, -100.0f);
    for (uint32_t n = 0u; n < 20000u && mode(&now) == LODE_MODE_RUN; n++) {
        run(&now, 1u);
    }
    FUZZ_CHECK(mode(&now) == LODE_MODE_START); // handed back
    snapshots[SLOWING] = now;
}

// Holds the rotor still by injection, and looks for it.
static void make_injecting(pair_t snapshots[SNAPSHOTS]) {
    pair_t now = begun(&injecting_tuning);
    command(&now, 20.0f);
    for (uint32_t n = 0u; n < 20000u && !now.drive.estimator.by.hfi.active; n++) {
        run(&now, 1u);
    }
    run(&now, 50u);
    FUZZ_CHECK(mode(&now) == LODE_MODE_START && now.drive.estimator.by.hfi.active);
    snapshots[SEARCHING] = now;
    run(&now, 20000u);
    command(&now, 0.0f);
    run(&now, 10000u);
    FUZZ_CHECK(mode(&now) == LODE_MODE_RUN && now.drive.estimator.by.hfi.active);
    FUZZ_CHECK(fabs(now.truth.omega_e_rad_s) < 5.0);
    snapshots[INJECTING] = now;
}

// Learns where the EMF and injection both tell the position: a measurement has begun.
static void make_learning(pair_t snapshots[SNAPSHOTS]) {
    pair_t now = snapshots[INJECTING];
    command(&now, 30.0f);
    plant_set_load(&now.plant, 3.0);
    run(&now, 5000u);
    now.learns = true;
    const lode_motor_t motor = fuzz_motor();
    const lode_learned_t stored = {0.9f * motor.Lq_H, motor.psi_Wb, 0.5f};
    lode_learn_begin(&now.learn, &learn_tuning, &learning_config, &stored);
    run(&now, 700u);
    FUZZ_CHECK(mode(&now) == LODE_MODE_RUN && now.learn.samples > 20.0f);
    snapshots[LEARNING] = now;
    run(&now, 1000u);
    FUZZ_CHECK(learned > 0u);
}

// A torque; a short circuit at speed.
static void make_others(pair_t snapshots[SNAPSHOTS]) {
    pair_t now = snapshots[RUNNING];
    const lode_command_t torque = {.mode = LODE_MODE_RUN,
                                   .speed_rad_s = 250.0f,
                                   .control = LODE_CONTROL_TORQUE,
                                   .torque_Nm = 3.0f,
                                   .active_short = true};
    FUZZ_CHECK(fuzz_loop_post(&now.loop, &now.drive, &torque) == LODE_OK);
    run(&now, 500u);
    FUZZ_CHECK(mode(&now) == LODE_MODE_RUN && now.drive.ref_A.q > 1.0f);
    snapshots[BY_TORQUE] = now;
    for (uint32_t n = 0u; n < 20u; n++) {
        lode_counts_t counts = sampled(&now);
        counts.v_bus = 4095u;
        step(&now, &counts);
    }
    FUZZ_CHECK(now.drive.guard.fault.check == (uint_least8_t)LODE_CHECK_OVER_VOLTAGE);
    snapshots[SHORTED] = now;
}

static pair_t guided(uint8_t kind) {
    pair_t now = begun(&plain_tuning);
    now.guide = (fuzz_guide_t){.kind = kind, .lock = 1.0f};
    command(&now, 20.0f);
    run(&now, 5000u);
    FUZZ_CHECK(mode(&now) == LODE_MODE_RUN && now.drive.sensored > 0u);
    return now;
}

static void make_all(pair_t snapshots[SNAPSHOTS]) {
    lode_drive_config_t config = fuzz_drive_config(512u | 256u); // weakens, MTPA
    config.guard.stamp_per_period = FUZZ_STAMP;
    FUZZ_CHECK(lode_drive_tune(&plain_tuning, &config) == LODE_OK);
    config.hfi.mode = LODE_HFI_ON;
    config.hfi.learn = LODE_ON;
    FUZZ_CHECK(lode_drive_tune(&injecting_tuning, &config) == LODE_OK);
    learning_config = config;
    lode_drive_design(&learning_config);
    FUZZ_CHECK(lode_learn_design(&learn_tuning, &config, LODE_AUTO) == LODE_OK);
    fuzz_sensors_init(&sensors, &plain_tuning);
    make(snapshots);
    make_injecting(snapshots);
    make_learning(snapshots);
    make_others(snapshots);
    snapshots[BY_ENCODER] = guided(FUZZ_BY_ENCODER);
    snapshots[BY_HALL] = guided(FUZZ_BY_HALL);
}

// Commands and tunings out of the input. Returns the periods to run for.
static uint32_t choose(pair_t *self, fuzz_t *in, uint8_t what, const lode_drive_tuning_t *tuning) {
    if (what < 24u) {
        const lode_command_t any = fuzz_command(in);
        (void)fuzz_loop_post(&self->loop, &self->drive, &any);
    } else if (what < 48u) {
        const lode_command_t go = fuzz_run(in, 350.0f);
        (void)fuzz_loop_post(&self->loop, &self->drive, &go);
    } else if (what < 64u) {
        const lode_drive_tuning_t *next = what % 2u != 0u ? tuning : self->tuning;
        if (self->loop.adapts && what < 56u) {
            (void)lode_adaptation_post(&adaptation, &self->drive, next);
        } else {
            (void)lode_drive_post_tuning(&self->drive, next);
        }
    } else if (what < 80u) {
        return 8u * (what - 64u);
    }
    fuzz_choose_surroundings(in, what, &self->drive, &self->plant, &self->guide, &self->loop,
                             self->tuning);
    return 0u;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static pair_t snapshots[SNAPSHOTS];
    static bool made;
    if (!made) {
        make_all(snapshots);
        made = true;
    }
    fuzz_t in = {data, size};
    lode_drive_config_t config = fuzz_drive_config(fuzz_word(&in));
    config.guard.stamp_per_period = FUZZ_STAMP;
    lode_drive_tuning_t tuning;
    FUZZ_CHECK(lode_drive_tune(&tuning, &config) == LODE_OK);
    const uint8_t begin = fuzz_byte(&in);
    pair_t now = snapshots[begin % SNAPSHOTS];
    const lode_motor_t motor = fuzz_motor();
    const fuzz_adaptation_t by = fuzz_adaptation(&in, begin / SNAPSHOTS);
    FUZZ_CHECK(lode_adaptation_init(&adaptation, &by.config, now.tuning, &motor,
                                    by.has ? &by.stored : NULL) == LODE_OK);
    uint32_t periods = 0u;
    while (fuzz_more(&in) && periods < PERIODS_MAX) {
        const uint32_t more = choose(&now, &in, fuzz_byte(&in), &tuning);
        run(&now, more);
        lode_counts_t counts = sampled(&now);
        fuzz_spoil_counts(&in, &counts);
        step(&now, &counts);
        periods += more + 1u;
    }
    return 0;
}
