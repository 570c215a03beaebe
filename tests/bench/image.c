/// The image whose instructions are counted: one function bench_<case>(call) per case, each with ONE
/// call of what it is named for, fed from the recording of record.c. No motor model runs in it.
#include "image.h"

static lode_drive_out_t out[BENCH_CASE_COUNT];
static bool refused;

#define STEP(name, ...)                                                                            \
    void bench_step_##name(uint32_t call);                                                         \
    void bench_step_##name(uint32_t call) {                                                        \
        out[BENCH_##name] = lode_drive_step(&bench_drive[BENCH_##name],                            \
                                            &bench_counted[BENCH_##name][call % BENCH_ROWS]);      \
    }
BENCH_CASES(STEP)

void setup(void) {
    refused = !bench_blocks_setup();
    for (int32_t n = 0; n < BENCH_CASE_COUNT; n++) {
        refused = !bench_begin(n) || refused;
        for (int32_t k = 0; k < bench_settle(n); k++) {
            out[n] = lode_drive_step(&bench_drive[n], &bench_settling[n][k]);
        }
        bench_settled(n);
    }
}

static uint32_t check_drive(int32_t number) {
    lode_telemetry_t telemetry;
    (void)lode_drive_telemetry(&bench_drive[number], &telemetry);
    const uint32_t calls = telemetry.steps - (uint32_t)bench_settle(number);
    if (calls > BENCH_ROWS) {
        return 2u;
    }
    const bench_truth_t *truth = &bench_truth[number][calls];
    if (telemetry.mode != truth->mode) {
        return 3u;
    }
    if (bench_digest(out[number]) != truth->digest) {
        return 4u;
    }
    const bool good = telemetry.mode != LODE_MODE_RUN ||
                      bench_estimate_is_good(number, &telemetry, truth->theta_rad);
    return good ? 0u : 5u;
}

uint32_t bench_check(void) {
    if (refused) {
        return 1u;
    }
    for (int32_t n = 0; n < BENCH_CASE_COUNT; n++) {
        const uint32_t wrong = check_drive(n);
        if (wrong != 0u) {
            return 100u * (uint32_t)n + wrong;
        }
    }
    return bench_blocks_good() ? 0u : 100u * (uint32_t)BENCH_CASE_COUNT + 5u;
}
