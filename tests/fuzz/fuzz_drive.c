// The whole drive, from rest or from one that runs, weakens its field or slows down: any counts, stamps,
// commands and tunings in any order give duties in range, and a picture in numbers.
#include "support/fuzz_plant.h"

enum { AT_REST, STARTING, RUNNING, WEAKENING, SLOWING, SNAPSHOTS };

#define PERIODS_MAX 3000u

typedef struct {
    lode_drive_t drive;
    plant_t plant;
} pair_t;

static lode_drive_tuning_t own_tuning;

// One period: what the drive does of `counts`, which the motor may have seen.
static void step(pair_t *self, const lode_counts_t *counts) {
    const lode_drive_out_t out = lode_drive_step(&self->drive, counts);
    lode_telemetry_t t;
    FUZZ_CHECK(lode_drive_telemetry(&self->drive, &t));
    fuzz_check_out(out, &t);
    fuzz_check_telemetry(&t);
    fuzz_plant_write(&self->plant, 0, out);
    plant_advance(&self->plant);
}

static lode_counts_t sampled(pair_t *self) {
    plant_counts_t counts[PLANT_SETS];
    plant_sample(&self->plant, counts, NULL);
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
    FUZZ_CHECK(lode_drive_post_command(&self->drive, &go) == LODE_OK);
}

static lode_mode_t mode(const pair_t *self) {
    return (lode_mode_t)self->drive.mode;
}

// From standstill through all that a day brings.
static void make(pair_t snapshots[SNAPSHOTS]) {
    lode_drive_config_t config = fuzz_drive_config(512u | 256u); // weakens, MTPA
    config.guard.stamp_per_period = FUZZ_STAMP;
    const plant_config_t plant = fuzz_plant_config();
    pair_t now;
    fuzz_plant_init(&now.plant, &plant);
    FUZZ_CHECK(lode_drive_init(&now.drive, &own_tuning, &config) == LODE_OK);
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

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static pair_t snapshots[SNAPSHOTS];
    static bool made;
    if (!made) {
        make(snapshots);
        made = true;
    }
    fuzz_t in = {data, size};
    lode_drive_config_t config = fuzz_drive_config(fuzz_word(&in));
    config.guard.stamp_per_period = FUZZ_STAMP;
    lode_drive_tuning_t tuning;
    FUZZ_CHECK(lode_drive_tune(&tuning, &config) == LODE_OK);
    pair_t now = snapshots[fuzz_byte(&in) % SNAPSHOTS];
    uint32_t periods = 0u;
    while (fuzz_more(&in) && periods < PERIODS_MAX) {
        const uint8_t what = fuzz_byte(&in);
        if (what < 24u) {
            const lode_command_t any = fuzz_command(&in);
            (void)lode_drive_post_command(&now.drive, &any);
        } else if (what < 48u) {
            const lode_command_t go = fuzz_run(&in, 350.0f);
            (void)lode_drive_post_command(&now.drive, &go);
        } else if (what < 64u) {
            (void)lode_drive_post_tuning(&now.drive, what % 2u != 0u ? &tuning : &own_tuning);
        } else if (what < 80u) {
            run(&now, 8u * (what - 64u));
            periods += 8u * (what - 64u);
        }
        lode_counts_t counts = sampled(&now);
        fuzz_spoil_counts(&in, &counts);
        step(&now, &counts);
        periods++;
    }
    return 0;
}
