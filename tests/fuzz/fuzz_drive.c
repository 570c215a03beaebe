// The whole drive: any counts and any commands give duties in range, and a picture in numbers.
#include "support/fuzz_drive.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    const lode_drive_config_t config = fuzz_drive_config(fuzz_word(&in));
    lode_drive_t drive;
    lode_drive_tuning_t tuning;
    FUZZ_CHECK(lode_drive_init(&drive, &tuning, &config) == LODE_OK);
    while (fuzz_more(&in)) {
        if (fuzz_byte(&in) < 24u) {
            const lode_command_t command = fuzz_command(&in);
            (void)lode_drive_post_command(&drive, &command);
        }
        const lode_counts_t counts = fuzz_counts(&in);
        const lode_drive_out_t out = lode_drive_step(&drive, &counts);
        lode_telemetry_t t;
        FUZZ_CHECK(lode_drive_telemetry(&drive, &t));
        fuzz_check_out(out, &t);
        fuzz_check_telemetry(&t);
    }
    return 0;
}
