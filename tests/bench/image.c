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
#define LODE_OBSERVER(ID, id, name, step, vectors, numbers) STEP(id##_leso_qpll, )
#include "lodestar/observers.def"
#undef LODE_OBSERVER

static lode_drive6_out_t out6[BENCH6_CASE_COUNT];

#define STEP6(name, ...)                                                                           \
    void bench_step6_##name(uint32_t call);                                                        \
    void bench_step6_##name(uint32_t call) {                                                       \
        out6[BENCH6_##name] = lode_drive6_step(&bench6_drive[BENCH6_##name],                       \
                                               &bench6_counted[BENCH6_##name][call % BENCH_ROWS]); \
    }
BENCH_CASES6(STEP6)

void setup(void) {
    refused = !bench_blocks_setup();
    for (int32_t n = 0; n < BENCH_CASE_COUNT; n++) {
        refused = !bench_begin(n) || refused;
        for (int32_t k = 0; k < bench_settle(n); k++) {
            out[n] = lode_drive_step(&bench_drive[n], &bench_settling[n][k]);
        }
        bench_settled(n);
    }
    for (int32_t n = 0; n < BENCH6_CASE_COUNT; n++) {
        refused = !bench6_begin(n) || refused;
        for (int32_t k = 0; k < BENCH_SETTLE; k++) {
            out6[n] = lode_drive6_step(&bench6_drive[n], &bench6_settling[n][k]);
        }
    }
}

// `number` is that of the case for three phases.
static uint32_t check(int32_t number, const lode_drive_t *drive, uint32_t digest,
                      const bench_truth_t *truths) {
    lode_telemetry_t telemetry;
    (void)lode_drive_telemetry(drive, &telemetry);
    const uint32_t calls = telemetry.steps - (uint32_t)bench_settle(number);
    if (calls > BENCH_ROWS) {
        return 2u;
    }
    const bench_truth_t *truth = &truths[calls];
    if (telemetry.mode != truth->mode) {
        return 3u;
    }
    if (digest != truth->digest) {
        return 4u;
    }
    const bool good = telemetry.mode != LODE_MODE_RUN ||
                      bench_estimate_is_good(number, &telemetry, truth->theta_rad);
    return good ? 0u : 5u;
}

static uint32_t check_case(int32_t n) {
    if (n < BENCH_CASE_COUNT) {
        return check(n, &bench_drive[n], bench_digest(out[n]), bench_truth[n]);
    }
    const int32_t six = n - BENCH_CASE_COUNT;
    return check(bench6_like(six), &bench6_drive[six].drive, bench6_digest(out6[six]),
                 bench6_truth[six]);
}

uint32_t bench_check(void) {
    if (refused) {
        return 1u;
    }
    const int32_t cases = BENCH_CASE_COUNT + BENCH6_CASE_COUNT;
    for (int32_t n = 0; n < cases; n++) {
        const uint32_t wrong = check_case(n);
        if (wrong != 0u) {
            return 100u * (uint32_t)n + wrong;
        }
    }
    return bench_blocks_good() ? 0u : 100u * (uint32_t)cases + 5u;
}
