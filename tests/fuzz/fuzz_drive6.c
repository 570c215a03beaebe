// The six-phase drive: any counts and any commands give duties in range, and a picture in numbers.
#include "support/fuzz_drive.h"

#include "lodestar/drive6.h"

static void check(const lode_drive6_t *drive, const lode_drive6_out_t *out) {
    lode_telemetry6_t t;
    FUZZ_CHECK(lode_drive6_telemetry(drive, &t));
    fuzz_check_telemetry(&t.drive);
    for (int set = 0; set < LODE_SETS; set++) {
        fuzz_check_out(out->set[set], &t.drive);
    }
    FUZZ_CHECK(lode_is_finite(t.i_xy_A.alpha) && lode_is_finite(t.i_xy_A.beta));
    FUZZ_CHECK(lode_is_finite(t.u_xy_V.alpha) && lode_is_finite(t.u_xy_V.beta));
    FUZZ_CHECK(t.open <= 6u);
    // A set that is left out stays off.
    FUZZ_CHECK(!(t.active == LODE_SETS_ONLY_2 && out->set[0].gates));
    FUZZ_CHECK(!(t.active == LODE_SETS_ONLY_1 && out->set[1].gates));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    const lode_drive6_config_t config = {
        .drive = fuzz_drive_config(fuzz_word(&in)),
        .Lxy_H = 0.9e-3f,
        .source = (lode_source_t)(fuzz_byte(&in) % 3u),
        .open_phase = (lode_open_phase_answer_t)(fuzz_byte(&in) % 3u),
    };
    lode_drive6_t drive;
    lode_drive6_tuning_t tuning;
    FUZZ_CHECK(lode_drive6_init(&drive, &tuning, &config) == LODE_OK);
    while (fuzz_more(&in)) {
        if (fuzz_byte(&in) < 24u) {
            const lode_command_t command = fuzz_command(&in);
            (void)lode_drive_post_command(&drive.drive, &command);
        }
        const lode_counts6_t counts = {{fuzz_counts(&in), fuzz_counts(&in)}};
        const lode_drive6_out_t out = lode_drive6_step(&drive, &counts);
        check(&drive, &out);
    }
    return 0;
}
