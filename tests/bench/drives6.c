#include "drives6.h"

#define LIKE(name) BENCH_##name,
static const int32_t like[BENCH6_CASE_COUNT] = {BENCH_CASES6(LIKE)};

lode_drive6_t bench6_drive[BENCH6_CASE_COUNT];
static lode_drive6_tuning_t tuning[BENCH6_CASE_COUNT];

int32_t bench6_like(int32_t number) {
    return like[number];
}

lode_drive6_config_t bench6_config(int32_t number) {
    lode_drive6_config_t config = {.drive = bench_config(like[number]), .Lxy_H = BENCH_LXY_H};
    config.drive.motor.J_kgm2 *= (float)LODE_SETS;
    config.drive.speed.ki_Nm *= (float)LODE_SETS;
    return config;
}

bool bench6_begin(int32_t number) {
    const lode_drive6_config_t config = bench6_config(number);
    const lode_command_t run = {.mode = LODE_MODE_RUN,
                                .speed_rad_s = BENCH_OMEGA_rad_s / BENCH_POLE_PAIRS};
    lode_drive6_t *drive = &bench6_drive[number];
    return lode_drive6_init(drive, &tuning[number], &config) == LODE_OK &&
           lode_drive_post_command(&drive->drive, &run) == LODE_OK;
}

uint32_t bench6_digest(lode_drive6_out_t out) {
    return bench_digest(out.set[0]) + 7u * bench_digest(out.set[1]);
}
