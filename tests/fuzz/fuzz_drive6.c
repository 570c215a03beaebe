// The six-phase drive, from rest or from one that runs, weakens its field, goes on with one set, injects, makes a torque,
// has a sensor or is shorted: any counts, stamps, commands, tunings, torque limits and estimates from outside in any
// order give duties in range, and a picture in numbers.
#include "support/fuzz_loop.h"

#include "lodestar/adaptation6.h"

enum { AT_REST, RUNNING, WEAKENING, ALONE, INJECTING, BY_TORQUE, BY_ENCODER, SHORTED, SNAPSHOTS };

#define PERIODS_MAX 3000u

typedef struct {
    lode_drive6_t drive;
    const lode_drive6_tuning_t *tuning; // with which it began
    plant_t plant;
    plant_truth_t truth;
    fuzz_guide_t guide;
    fuzz_loop_t loop;
} pair_t;

static lode_drive6_tuning_t plain_tuning;
static lode_drive6_tuning_t injecting_tuning;
static fuzz_sensors_t sensors;
static lode_adaptation6_t adaptation;

static plant_config_t plant_config(void) {
    plant_config_t plant = fuzz_plant_config();
    plant.sets = PLANT_SETS;
    plant.Lxy_H = 0.9e-3;
    return plant;
}

static lode_drive6_config_t drive_config(uint16_t choice, uint8_t source, uint8_t answer) {
    lode_drive6_config_t config = {
        .drive = fuzz_drive_config(choice),
        .Lxy_H = 0.9e-3f,
        .source = (lode_source_t)(source % 3u),
        .open_phase = (lode_open_phase_response_t)(answer % 3u),
    };
    config.drive.guard.stamp_per_period = FUZZ_STAMP;
    return config;
}

static lode_telemetry6_t check(const lode_drive6_t *drive, const lode_drive6_out_t *out) {
    lode_telemetry6_t t;
    FUZZ_CHECK(lode_drive6_telemetry(drive, &t));
    fuzz_check_telemetry(&t.drive);
    for (int set = 0; set < LODE_SETS; set++) {
        fuzz_check_out(out->set[set], &t.drive);
    }
    FUZZ_CHECK(lode_is_finite(t.i_xy_A.alpha) && lode_is_finite(t.i_xy_A.beta));
    FUZZ_CHECK(lode_is_finite(t.u_xy_V.alpha) && lode_is_finite(t.u_xy_V.beta));
    FUZZ_CHECK(t.open <= 8u);
    // A set that is left out stays off.
    FUZZ_CHECK(!(t.active == LODE_SETS_ONLY_2 && out->set[0].gates == LODE_GATES_ON));
    FUZZ_CHECK(!(t.active == LODE_SETS_ONLY_1 && out->set[1].gates == LODE_GATES_ON));
    return t;
}

static lode_counts6_t sampled(pair_t *self) {
    plant_counts_t counts[PLANT_SETS];
    plant_sample(&self->plant, counts, &self->truth);
    return (lode_counts6_t){{fuzz_plant_counts(&counts[0]), fuzz_plant_counts(&counts[1])}};
}

// One period of the drive, in one call or with an estimate from outside.
static lode_drive6_out_t drive_step(pair_t *self, const lode_counts6_t *counts) {
    if (self->guide.kind == FUZZ_BY_STEP) {
        return lode_drive6_step(&self->drive, counts);
    }
    const lode_sample6_t sample = lode_drive6_sense(&self->drive, counts);
    const lode_estimate_t own = lode_drive6_estimate(&self->drive, &sample);
    const lode_estimate_t given =
        fuzz_guide_next(&self->guide, &sensors, &own, sample.machine.i_A, &self->truth);
    const bool driven = self->drive.drive.gates;
    const lode_drive6_out_t out = lode_drive6_act(&self->drive, &sample, &given);
    fuzz_check_given(&given, driven, out.set[0].gates);
    fuzz_check_given(&given, driven, out.set[1].gates);
    return out;
}

static void adapt(pair_t *self, lode_telemetry_t *t) {
    (void)lode_adaptation6_step(&adaptation, &self->drive);
    lode_adaptation6_telemetry(&adaptation, t);
    fuzz_check_adapted(&t->motor);
}

static void step(pair_t *self, const lode_counts6_t *counts) {
    const lode_drive6_out_t out = drive_step(self, counts);
    lode_telemetry6_t t = check(&self->drive, &out);
    fuzz_plant_write(&self->plant, 0, out.set[0]);
    fuzz_plant_write(&self->plant, 1, out.set[1]);
    plant_advance(&self->plant);
    fuzz_loop_step(&self->loop, &self->drive.drive, &t.drive);
    if (self->loop.adapts && self->loop.periods % FUZZ_LOOP_PERIODS == 0u) {
        adapt(self, &t.drive);
    }
}

static void run(pair_t *self, uint32_t periods) {
    for (uint32_t n = 0; n < periods; n++) {
        const lode_counts6_t counts = sampled(self);
        step(self, &counts);
    }
}

static void command(pair_t *self, float speed_rad_s) {
    const lode_command_t go = {.mode = LODE_MODE_RUN, .speed_rad_s = speed_rad_s};
    FUZZ_CHECK(fuzz_loop_post(&self->loop, &self->drive.drive, &go) == LODE_OK);
}

static bool runs(const pair_t *self) {
    return self->drive.drive.mode == (uint_least8_t)LODE_MODE_RUN;
}

static pair_t begun(const lode_drive6_tuning_t *tuning) {
    const plant_config_t plant = plant_config();
    pair_t now = {.tuning = tuning};
    fuzz_plant_init(&now.plant, &plant);
    fuzz_loop_init(&now.loop);
    FUZZ_CHECK(lode_drive6_begin(&now.drive, tuning) == LODE_OK);
    return now;
}

static void make(pair_t snapshots[SNAPSHOTS]) {
    pair_t now = begun(&plain_tuning);
    snapshots[AT_REST] = now;
    command(&now, 100.0f);
    run(&now, 10000u);
    FUZZ_CHECK(runs(&now));
    plant_set_load(&now.plant, 2.0);
    run(&now, 1000u);
    snapshots[RUNNING] = now;
    plant_open_phase(&now.plant, 1);
    run(&now, 2000u);
    FUZZ_CHECK(runs(&now) && now.drive.active == (uint_least8_t)LODE_SETS_ONLY_2);
    snapshots[ALONE] = now;
    now = snapshots[RUNNING];
    command(&now, 330.0f);
    run(&now, 15000u);
    FUZZ_CHECK(runs(&now) && now.drive.drive.ref_A.d < -2.0f);
    snapshots[WEAKENING] = now;
}

// Holds the rotor still by injection.
static void make_injecting(pair_t snapshots[SNAPSHOTS]) {
    pair_t now = begun(&injecting_tuning);
    command(&now, 20.0f);
    run(&now, 20000u);
    command(&now, 0.0f);
    run(&now, 10000u);
    FUZZ_CHECK(runs(&now) && now.drive.drive.estimator.by.hfi.active);
    FUZZ_CHECK(fabs(now.truth.omega_e_rad_s) < 5.0);
    snapshots[INJECTING] = now;
}

// A torque; a short circuit at speed; an encoder.
static void make_others(pair_t snapshots[SNAPSHOTS]) {
    pair_t now = snapshots[RUNNING];
    const lode_command_t torque = {.mode = LODE_MODE_RUN,
                                   .speed_rad_s = 250.0f,
                                   .control = LODE_CONTROL_TORQUE,
                                   .torque_Nm = 6.0f,
                                   .active_short = true};
    FUZZ_CHECK(fuzz_loop_post(&now.loop, &now.drive.drive, &torque) == LODE_OK);
    run(&now, 500u);
    FUZZ_CHECK(runs(&now) && now.drive.drive.ref_A.q > 1.0f);
    snapshots[BY_TORQUE] = now;
    for (uint32_t n = 0u; n < 20u; n++) {
        lode_counts6_t counts = sampled(&now);
        counts.set[0].v_bus = 4095u;
        step(&now, &counts);
    }
    FUZZ_CHECK(now.drive.drive.guard.fault.check == (uint_least8_t)LODE_CHECK_OVER_VOLTAGE);
    snapshots[SHORTED] = now;
    now = begun(&plain_tuning);
    now.guide = (fuzz_guide_t){.kind = FUZZ_BY_ENCODER, .lock = 1.0f};
    command(&now, 20.0f);
    run(&now, 5000u);
    FUZZ_CHECK(runs(&now) && now.drive.drive.sensored > 0u);
    snapshots[BY_ENCODER] = now;
}

static void make_all(pair_t snapshots[SNAPSHOTS]) {
    lode_drive6_config_t config =
        drive_config(512u, LODE_SOURCE_VSD, LODE_OPEN_PHASE_GO_ON); // weakens
    FUZZ_CHECK(lode_drive6_tune(&plain_tuning, &config) == LODE_OK);
    config.drive.hfi.mode = LODE_HFI_ON;
    FUZZ_CHECK(lode_drive6_tune(&injecting_tuning, &config) == LODE_OK);
    fuzz_sensors_init(&sensors, &plain_tuning.drive);
    make(snapshots);
    make_injecting(snapshots);
    make_others(snapshots);
}

// Commands, tunings and open phases out of the input. Returns the periods to run for.
static uint32_t choose(pair_t *self, fuzz_t *in, uint8_t what, const lode_drive6_tuning_t *tuning) {
    if (what < 24u) {
        const lode_command_t any = fuzz_command(in);
        (void)fuzz_loop_post(&self->loop, &self->drive.drive, &any);
    } else if (what < 48u) {
        const lode_command_t go = fuzz_run(in, 350.0f);
        (void)fuzz_loop_post(&self->loop, &self->drive.drive, &go);
    } else if (what < 64u) {
        const lode_drive6_tuning_t *next = what % 2u != 0u ? tuning : self->tuning;
        if (self->loop.adapts && what < 56u) {
            (void)lode_adaptation6_post(&adaptation, &self->drive, next);
        } else {
            (void)lode_drive6_post_tuning(&self->drive, next);
        }
    } else if (what < 72u) {
        plant_open_phase(&self->plant, what % 6u);
    } else if (what < 88u) {
        return 8u * (what - 72u);
    }
    fuzz_choose_surroundings(in, what, &self->drive.drive, &self->plant, &self->guide, &self->loop,
                             &self->tuning->drive);
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
    const uint16_t choice = fuzz_word(&in);
    const uint8_t source = fuzz_byte(&in);
    const uint8_t answer = fuzz_byte(&in);
    const lode_drive6_config_t config = drive_config(choice, source, answer);
    lode_drive6_tuning_t tuning;
    FUZZ_CHECK(lode_drive6_tune(&tuning, &config) == LODE_OK);
    const uint8_t begin = fuzz_byte(&in);
    pair_t now = snapshots[begin % SNAPSHOTS];
    const lode_motor_t motor = fuzz_motor();
    const fuzz_adaptation_t by = fuzz_adaptation(&in, begin / SNAPSHOTS);
    FUZZ_CHECK(lode_adaptation6_init(&adaptation, &by.config, now.tuning, &motor,
                                     by.has ? &by.stored : NULL) == LODE_OK);
    uint32_t periods = 0u;
    while (fuzz_more(&in) && periods < PERIODS_MAX) {
        const uint8_t what = fuzz_byte(&in);
        const uint32_t more = choose(&now, &in, what, &tuning);
        run(&now, more);
        lode_counts6_t counts = sampled(&now);
        fuzz_spoil_counts(&in, &counts.set[what % 2u]);
        step(&now, &counts);
        periods += more + 1u;
    }
    return 0;
}
