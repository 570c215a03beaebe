// Sense: any accepted board, any counts and duties, with calibration in between.
#include "sense_inline.h"
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
        const lode_sample_t s =
            lode_sense_step(&sense, &tuning, &counts, lode_sense_omitted(&tuning, duty));
        FUZZ_CHECK(lode_ab_in_range(s.i_A, FLT_MAX));
        FUZZ_CHECK(lode_is_finite(s.v_bus_V));
        FUZZ_CHECK(lode_is_finite(lode_sense_temperature_degC(&tuning, s.temperature)));
        FUZZ_CHECK(s.alert || !lode_sense_is_railed(&sense, &tuning, &s));
        float worst = 0.0f;
        if (calibrate) {
            const lode_sample_t off = lode_sense_step( // with the gates off, every leg at half duty
                &sense, &tuning, &counts,
                lode_sense_omitted(&tuning, (lode_abc_t){0.5f, 0.5f, 0.5f}));
            (void)lode_sense_calibrate(&sense, &sums, &tuning, &off, &worst);
            FUZZ_CHECK(lode_in_range(worst, -65535.0f, 65535.0f));
        }
        for (int32_t n = 0; n < LODE_PHASES; n++) {
            FUZZ_CHECK(sense.offset[n] >= 0 && sense.offset[n] <= 65535 * LODE_COUNT_FRACTION);
        }
    }
    return 0;
}
