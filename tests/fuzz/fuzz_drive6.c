// The six-phase drive, from rest or from one that runs, weakens its field or goes on with one set: any
// counts, stamps, commands and tunings in any order give duties in range, and a picture in numbers.
#include "support/fuzz_plant.h"

#include "lodestar/drive6.h"

enum { AT_REST, RUNNING, WEAKENING, ALONE, SNAPSHOTS };

#define PERIODS_MAX 3000u

typedef struct {
    lode_drive6_t drive;
    plant_t plant;
} pair_t;

static lode_drive6_tuning_t own_tuning;

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

static void check(const lode_drive6_t *drive, const lode_drive6_out_t *out) {
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
    FUZZ_CHECK(!(t.active == LODE_SETS_ONLY_2 && out->set[0].gates));
    FUZZ_CHECK(!(t.active == LODE_SETS_ONLY_1 && out->set[1].gates));
}

static lode_counts6_t sampled(pair_t *self) {
    plant_counts_t counts[PLANT_SETS];
    plant_sample(&self->plant, counts, NULL);
    return (lode_counts6_t){{fuzz_plant_counts(&counts[0]), fuzz_plant_counts(&counts[1])}};
}

static void step(pair_t *self, const lode_counts6_t *counts) {
    const lode_drive6_out_t out = lode_drive6_step(&self->drive, counts);
    check(&self->drive, &out);
    fuzz_plant_write(&self->plant, 0, out.set[0]);
    fuzz_plant_write(&self->plant, 1, out.set[1]);
    plant_advance(&self->plant);
}

static void run(pair_t *self, uint32_t periods) {
    for (uint32_t n = 0; n < periods; n++) {
        const lode_counts6_t counts = sampled(self);
        step(self, &counts);
    }
}

static void command(pair_t *self, float speed_rad_s) {
    const lode_command_t go = {.mode = LODE_MODE_RUN, .speed_rad_s = speed_rad_s};
    FUZZ_CHECK(lode_drive_post_command(&self->drive.drive, &go) == LODE_OK);
}

static bool runs(const pair_t *self) {
    return self->drive.drive.mode == (uint_least8_t)LODE_MODE_RUN;
}

static void make(pair_t snapshots[SNAPSHOTS]) {
    const lode_drive6_config_t config =
        drive_config(512u, LODE_SOURCE_VSD, LODE_OPEN_PHASE_GO_ON); // weakens
    const plant_config_t plant = plant_config();
    pair_t now;
    fuzz_plant_init(&now.plant, &plant);
    FUZZ_CHECK(lode_drive6_init(&now.drive, &own_tuning, &config) == LODE_OK);
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

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static pair_t snapshots[SNAPSHOTS];
    static bool made;
    if (!made) {
        make(snapshots);
        made = true;
    }
    fuzz_t in = {data, size};
    const uint16_t choice = fuzz_word(&in);
    const uint8_t source = fuzz_byte(&in);
    const uint8_t answer = fuzz_byte(&in);
    const lode_drive6_config_t config = drive_config(choice, source, answer);
    lode_drive6_tuning_t tuning;
    FUZZ_CHECK(lode_drive6_tune(&tuning, &config) == LODE_OK);
    pair_t now = snapshots[fuzz_byte(&in) % SNAPSHOTS];
    uint32_t periods = 0u;
    while (fuzz_more(&in) && periods < PERIODS_MAX) {
        const uint8_t what = fuzz_byte(&in);
        if (what < 24u) {
            const lode_command_t any = fuzz_command(&in);
            (void)lode_drive_post_command(&now.drive.drive, &any);
        } else if (what < 48u) {
            const lode_command_t go = fuzz_run(&in, 350.0f);
            (void)lode_drive_post_command(&now.drive.drive, &go);
        } else if (what < 64u) {
            (void)lode_drive6_post_tuning(&now.drive, what % 2u != 0u ? &tuning : &own_tuning);
        } else if (what < 72u) {
            plant_open_phase(&now.plant, what % 6u);
        } else if (what < 88u) {
            run(&now, 8u * (what - 72u));
            periods += 8u * (what - 72u);
        }
        lode_counts6_t counts = sampled(&now);
        fuzz_spoil_counts(&in, &counts.set[what % 2u]);
        step(&now, &counts);
        periods++;
    }
    return 0;
}
