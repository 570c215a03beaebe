/// A motor behind a fuzzed drive: so that it starts, runs, weakens its field and hands back before and
/// while the input's commands, tunings, stamps and counts come in between.
#ifndef SUPPORT_FUZZ_PLANT_H
#define SUPPORT_FUZZ_PLANT_H

#include "support/fuzz_drive.h"

#include "plant/plant.h"

/// Counts of the stamp per period, in every drive here.
#define FUZZ_STAMP 1000.0f

/// The plant of fuzz_drive_config().
static inline plant_config_t fuzz_plant_config(void) {
    plant_config_t plant = plant_config_jiang2022();
    plant.level = PLANT_AVERAGED;
    plant.keeps_accounts = false;
    plant.dead_time_s = 0.0;
    plant.pwm_ticks = 0;
    plant.i_A_per_count = 0.0125;
    plant.stamp_Hz = (double)FUZZ_STAMP / plant.period_s;
    return plant;
}

static inline void fuzz_plant_init(plant_t *plant, const plant_config_t *config) {
    FUZZ_CHECK(plant_init(plant, config) == NULL);
}

static inline lode_counts_t fuzz_plant_counts(const plant_counts_t *from) {
    return (lode_counts_t){.i = {from->i[0], from->i[1], from->i[2]},
                           .v_bus = from->v_bus,
                           .temperature = from->temperature,
                           .trip = from->trip,
                           .stamp = from->stamp};
}

static inline void fuzz_plant_write(plant_t *plant, int set, lode_drive_out_t out) {
    const double duty[PLANT_PHASES] = {(double)out.duty.a, (double)out.duty.b, (double)out.duty.c};
    plant_write_set(plant, set, duty, (plant_gates_t)out.gates); // the same three
}

/// What the input does to the counts of a period: mostly nothing.
static inline void fuzz_spoil_counts(fuzz_t *in, lode_counts_t *counts) {
    const uint8_t kind = fuzz_byte(in);
    if (kind < 8u) {
        const uint32_t stamp = counts->stamp;
        *counts = fuzz_counts(in);
        counts->stamp = stamp;
    } else if (kind < 24u) {
        counts->i[kind % 3u] = fuzz_word(in);
    } else if (kind < 32u) {
        counts->v_bus = fuzz_word(in) & 0x0FFFu;
    } else if (kind < 36u) {
        counts->stamp += (uint32_t)fuzz_word(in) << (kind % 16u);
    }
}

/// A command that a user would give: another speed, the other way, a torque, a stop.
static inline lode_command_t fuzz_run(fuzz_t *in, float most_rad_s) {
    const float share = (float)(int16_t)fuzz_word(in) / 32768.0f;
    const uint8_t flags = fuzz_byte(in);
    const bool stop = (flags & 3u) == 0u;
    lode_command_t x = {.mode = LODE_MODE_RUN,
                        .speed_rad_s = stop ? 0.0f : share * most_rad_s,
                        .active_short = (flags & 64u) != 0u};
    if ((flags & 128u) != 0u) {
        x.control = LODE_CONTROL_TORQUE;
        x.torque_Nm = 6.0f * (float)(int16_t)fuzz_word(in) / 32768.0f;
    }
    return x;
}

#endif
