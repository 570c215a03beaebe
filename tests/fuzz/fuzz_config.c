// Configurations: whatever stands in their fields, init refuses and touches nothing, or what it accepts
// drives with duties in range and in numbers.
#include "support/fuzz_drive.h"

#include "design/tuning_fields.h"
#include "lodestar/drive6.h"

// Fields are floats and enumerations: words.
#define WORDS (sizeof(lode_drive6_config_t) / sizeof(float))
#define PERIODS 40u

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
#define IS_FINITE_BOOL(type, member)
#define IS_FINITE_CHOICE(type, member)
#define IS_FINITE(kind, type, member) IS_FINITE_##kind(type, member)

// What init accepts is made of numbers.
static void check_tuning(const lode_drive_tuning_t *tuning) {
    TUNING_FIELDS(IS_FINITE)
}

static void drive_3(const lode_drive_config_t *config, fuzz_t *in) {
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
    const lode_command_t command = fuzz_command(in);
    (void)lode_drive_post_command(&drive, &command);
    for (uint32_t n = 0; n < PERIODS; n++) {
        const lode_counts_t counts = fuzz_counts(in);
        const lode_drive_out_t out = lode_drive_step(&drive, &counts);
        lode_telemetry_t t;
        FUZZ_CHECK(lode_drive_telemetry(&drive, &t));
        fuzz_check_out(out, &t);
        fuzz_check_telemetry(&t);
    }
}

static void drive_6(const lode_drive6_config_t *config, fuzz_t *in) {
    lode_drive6_t drive;
    lode_drive6_tuning_t tuning;
    if (lode_drive6_init(&drive, &tuning, config) != LODE_OK) {
        return;
    }
    check_tuning(&tuning.drive);
    check_tuning(&tuning.alone);
    const lode_command_t command = fuzz_command(in);
    (void)lode_drive_post_command(&drive.drive, &command);
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
    drive_3(&config.drive, &in);
    drive_6(&config, &in);
    return 0;
}
