// Sense: any accepted board, any counts and duties, with calibration in between.
#include "lodestar/sense.h"
#include "support/fuzz.h"

static lode_sense_config_t board(fuzz_t *in) {
    const uint8_t choice = fuzz_byte(in);
    lode_sense_config_t config = {.shunts = (lode_shunts_t)(choice % 3u),
                                  .i_gain_A_count = 0.0125f,
                                  .i_offset_count = 2048.0f,
                                  .v_bus_gain_V_count = 0.1f,
                                  .duty_max = 0.9f,
                                  .calibrate_s = 1.0e-3f};
    if ((choice & 64u) != 0u) {
        config.i_gain_A_count = fuzz_float(in);
        config.i_offset_count = fuzz_number(in, 65535.0f);
        config.i_offset_tol_count = fuzz_number(in, 65535.0f);
        config.count_max = fuzz_number(in, 65535.0f);
        config.v_bus_gain_V_count = fuzz_float(in);
        config.temperature_gain_degC_count = fuzz_float(in);
        config.temperature_offset_degC = fuzz_float(in);
        config.duty_max = fuzz_number(in, 1.0f);
    }
    return config;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    lode_sense_config_t config = board(&in);
    lode_sense_tuning_t tuning;
    lode_sense_design(&config);
    if (lode_sense_tune(&tuning, &config, 12.0f, 200.0f, 2.0e-4f) != LODE_OK) {
        return 0;
    }
    lode_sense_t sense;
    lode_sense_sums_t sums;
    lode_sense_reset(&sense, &tuning);
    lode_sense_begin(&sums);
    while (fuzz_more(&in)) {
        const bool calibrate = (fuzz_byte(&in) & 1u) != 0u;
        const lode_counts_t counts = {.i = {fuzz_word(&in), fuzz_word(&in), fuzz_word(&in)},
                                      .v_bus = fuzz_word(&in),
                                      .temperature = fuzz_word(&in)};
        const lode_abc_t duty = {fuzz_number(&in, 1.0f), fuzz_number(&in, 1.0f),
                                 fuzz_number(&in, 1.0f)};
        float worst = 0.0f;
        if (calibrate) {
            (void)lode_sense_calibrate(&sense, &sums, &tuning, &counts, &worst);
            FUZZ_CHECK(lode_in_range(worst, -65535.0f, 65535.0f));
        }
        const lode_sample_t s =
            lode_sense_step(&sense, &tuning, &counts, lode_sense_unused(&tuning, duty));
        FUZZ_CHECK(lode_ab_in_range(s.i_A, FLT_MAX));
        FUZZ_CHECK(lode_is_finite(s.i_abc_A.a) && lode_is_finite(s.i_abc_A.b) &&
                   lode_is_finite(s.i_abc_A.c));
        FUZZ_CHECK(lode_is_finite(s.v_bus_V));
        FUZZ_CHECK(lode_is_finite(lode_sense_temperature_degC(&tuning, s.temperature_count)));
        FUZZ_CHECK(s.alert || !s.railed);
        FUZZ_CHECK(lode_in_range(sense.offset_count.a, 0.0f, 65535.0f));
    }
    return 0;
}
