// Configurations: whatever stands in their fields, init refuses and touches nothing, or what it accepts
// drives with duties in range and in numbers.
#include "support/fuzz_drive.h"

#include "design/tuning_fields.h"
#include "lodestar/drive6.h"

// Fields are floats and enumerations: words.
#define WORDS (sizeof(lode_drive6_config_t) / sizeof(float))
#define PERIODS 40u
#define START_PERIODS 400u

static void spoil(fuzz_t *in, lode_drive6_config_t *config) {
    const size_t word = fuzz_word(in) % WORDS;
    const float value = fuzz_number(in, powf(10.0f, (float)(fuzz_byte(in) % 12u) - 6.0f));
    const uint32_t choice = fuzz_byte(in);
    const bool is_choice = (choice & 0x80u) != 0u;
    const uint32_t small = choice % 5u;
    memcpy((char *)config + word * sizeof value, is_choice ? (const void *)&small : &value,
           sizeof value);
}

#define IS_FINITE_FLOAT(type, member) FUZZ_CHECK(lode_is_finite((float)tuning->member));
#define IS_FINITE_OBSERVER(type, member) IS_FINITE_FLOAT(type, member)
#define IS_FINITE_WHOLE(type, member)
#define IS_FINITE_INTEGER(type, member)
#define IS_FINITE(kind, type, member) IS_FINITE_##kind(type, member)

// What init accepts is made of numbers.
static void check_tuning(const lode_drive_tuning_t *tuning) {
    TUNING_FIELDS(IS_FINITE)
}

// Into RUN, with an estimate from outside that holds: the start asks for no more. A configuration may want
// longer for it.
typedef struct {
    const lode_drive_tuning_t *tuning;
    float omega;
    uint16_t zero;
    lode_counts_t counts;
} start_t;

static start_t begin_start(lode_drive_t *drive) {
    const lode_drive_tuning_t *tuning = drive->tuning;
    const float omega = 1.5f * tuning->start.omega_handover;
    const lode_command_t go = {.mode = LODE_MODE_RUN,
                               .speed_rad_s = 2.0f * omega * tuning->speed.inv_pole_pairs};
    const uint16_t zero = (uint16_t)(tuning->sense.offset_nominal / LODE_COUNT_FRACTION);
    const float bus = tuning->guard.v_bus_min / tuning->sense.v_bus_gain + 1.0f;
    drive->known = (uint_least8_t)LODE_KNOWN_OFFSETS;
    (void)lode_drive_post_command(drive, &go);
    return (start_t){.tuning = tuning,
                     .omega = omega,
                     .zero = zero,
                     .counts = {.v_bus = (uint16_t)(int32_t)lode_clamp(bus, 0.0f, 65535.0f)}};
}

// Some current that changes all the time and adds up to none: sensors without any would be stuck.
static const lode_counts_t *next_counts(start_t *start, uint32_t n) {
    const int32_t a = (int32_t)(n * 7u % 31u) - 15;
    const int32_t b = (int32_t)(n * 13u % 31u) - 15;
    const int32_t i[3] = {a, b, -a - b};
    for (int phase = 0; phase < 3; phase++) {
        start->counts.i[phase] = (uint16_t)(start->zero + i[phase]);
    }
    start->counts.stamp += start->tuning->guard.stamp_min + 1u;
    return &start->counts;
}

static lode_estimate_t from_outside(const start_t *start, uint32_t n, lode_dq_t i_A) {
    return (lode_estimate_t){
        .omega_rad_s = start->omega,
        .rotor = lode_sincos((float)n * start->tuning->estimator.pll.ts_s * start->omega),
        .i_A = i_A,
        .lock = 1.0f,
        .source = LODE_ESTIMATE_EXTERNAL};
}

static void start_3(lode_drive_t *drive) {
    start_t start = begin_start(drive);
    for (uint32_t n = 0; n < START_PERIODS && drive->mode != (uint_least8_t)LODE_MODE_RUN; n++) {
        const lode_sample_t sample = lode_drive_sense(drive, next_counts(&start, n));
        const lode_estimate_t own = lode_drive_estimate(drive, &sample);
        const lode_estimate_t from = from_outside(&start, n, own.i_A);
        (void)lode_drive_act(drive, &sample, &from);
    }
}

static void start_6(lode_drive6_t *drive) {
    start_t start = begin_start(&drive->drive);
    for (uint32_t n = 0; n < START_PERIODS && drive->drive.mode != (uint_least8_t)LODE_MODE_RUN;
         n++) {
        const lode_counts_t *set = next_counts(&start, n);
        const lode_counts6_t counts = {{*set, *set}};
        const lode_sample6_t sample = lode_drive6_sense(drive, &counts);
        const lode_estimate_t own = lode_drive6_estimate(drive, &sample);
        const lode_estimate_t from = from_outside(&start, n, own.i_A);
        (void)lode_drive6_act(drive, &sample, &from);
    }
}

static void drive_3(const lode_drive_config_t *config, fuzz_t *in, bool starts) {
    lode_drive_t drive;
    lode_drive_tuning_t tuning;
    memset(&drive, 0x55, sizeof drive);
    memset(&tuning, 0x55, sizeof tuning);
    const lode_drive_t drive_before = drive;
    const lode_drive_tuning_t tuning_before = tuning;
    if (lode_drive_init(&drive, &tuning, config) != LODE_OK) {
        FUZZ_CHECK(memcmp(&drive, &drive_before, sizeof drive) == 0);
        FUZZ_CHECK(memcmp(&tuning, &tuning_before, sizeof tuning) == 0);
        return;
    }
    check_tuning(&tuning);
    if (starts) {
        start_3(&drive);
    } else {
        const lode_command_t command = fuzz_command(in);
        (void)lode_drive_post_command(&drive, &command);
    }
    for (uint32_t n = 0; n < PERIODS; n++) {
        const lode_counts_t counts = fuzz_counts(in);
        const lode_drive_out_t out = lode_drive_step(&drive, &counts);
        lode_telemetry_t t;
        FUZZ_CHECK(lode_drive_telemetry(&drive, &t));
        fuzz_check_out(out, &t);
        fuzz_check_telemetry(&t);
    }
}

static void drive_6(const lode_drive6_config_t *config, fuzz_t *in, bool starts) {
    lode_drive6_t drive;
    lode_drive6_tuning_t tuning;
    if (lode_drive6_init(&drive, &tuning, config) != LODE_OK) {
        return;
    }
    check_tuning(&tuning.drive);
    check_tuning(&tuning.alone);
    if (starts) {
        start_6(&drive);
    } else {
        const lode_command_t command = fuzz_command(in);
        (void)lode_drive_post_command(&drive.drive, &command);
    }
    for (uint32_t n = 0; n < PERIODS; n++) {
        const lode_counts6_t counts = {{fuzz_counts(in), fuzz_counts(in)}};
        const lode_drive6_out_t out = lode_drive6_step(&drive, &counts);
        lode_telemetry6_t t;
        FUZZ_CHECK(lode_drive6_telemetry(&drive, &t));
        fuzz_check_out(out.set[0], &t.drive);
        fuzz_check_out(out.set[1], &t.drive);
        fuzz_check_telemetry(&t.drive);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    lode_drive6_config_t config = {.drive = fuzz_drive_config(fuzz_word(&in)), .Lxy_H = 0.9e-3f};
    for (uint8_t n = fuzz_byte(&in) % 8u + 1u; n > 0u; n--) {
        spoil(&in, &config);
    }
    const uint8_t starts = fuzz_byte(&in);
    drive_3(&config.drive, &in, (starts & 1u) != 0u);
    drive_6(&config, &in, (starts & 2u) != 0u);
    return 0;
}
