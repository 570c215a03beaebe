// Counts to amperes, volts and degrees; offset calibration; low-side window.
#include "support/fields.h"

#include "sense_inline.h"

void setUp(void) {}

void tearDown(void) {}

#define I_MAX_A 12.0f

static lode_sense_config_t board(void) {
    return (lode_sense_config_t){.shunts = LODE_SHUNTS_THREE,
                                 .i_gain_A_count = 0.0125f,
                                 .i_offset_count = 2048.0f,
                                 .i_offset_tol_count = 100.0f,
                                 .count_max = 4095.0f,
                                 .v_bus_gain_V_count = 0.1f,
                                 .temperature_gain_degC_count = 0.05f,
                                 .temperature_offset_degC = -40.0f,
                                 .duty_max = 1.0f,
                                 .calibrate_s = 0.01f};
}

static lode_sense_tuning_t tuned(const lode_sense_config_t *config) {
    lode_sense_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_sense_tune(&tuning, config, I_MAX_A, PAPER_V_BUS, PAPER_TS_s));
    return tuning;
}

static const lode_abc_t half = {0.5f, 0.5f, 0.5f};
static lode_sense_sums_t sums; // of the calibration under way

static lode_sample_t sampled(const lode_sense_config_t *config, lode_counts_t counts,
                             lode_abc_t duty) {
    const lode_sense_tuning_t tuning = tuned(config);
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    return lode_sense_step(&sense, &tuning, &counts, lode_sense_omitted(&tuning, duty));
}

/// A phase current of a sample, A.
static double amperes(const lode_sense_config_t *config, lode_sample_t sample, int phase) {
    return (double)config->i_gain_A_count * sample.i[phase] / LODE_COUNT_FRACTION;
}

static bool railed(const lode_sense_config_t *config, lode_counts_t counts, lode_abc_t duty) {
    const lode_sense_tuning_t tuning = tuned(config);
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    const lode_sample_t sample =
        lode_sense_step(&sense, &tuning, &counts, lode_sense_omitted(&tuning, duty));
    return lode_sense_is_railed(&sense, &tuning, &sample);
}

static double degrees(const lode_sense_config_t *config, lode_sample_t sample) {
    const lode_sense_tuning_t tuning = tuned(config);
    return (double)lode_sense_temperature_degC(&tuning, sample.temperature);
}

// Products of counts up to 65535 in float.
#define ROUNDING 1.0e-5

static void test_three_shunts(void) {
    const lode_sense_config_t config = board();
    const lode_counts_t counts = {
        .i = {2148, 1948, 2098}, .v_bus = 2000, .temperature = 1300, .trip = true, .stamp = 77};
    const lode_sample_t s = sampled(&config, counts, half);
    CHECK_NEAR(ROUNDING, 1.25, amperes(&config, s, 0));
    CHECK_NEAR(ROUNDING, -1.25, amperes(&config, s, 1));
    CHECK_NEAR(ROUNDING, 0.625, amperes(&config, s, 2));
    // (2a - b - c)/3 and (b - c)/sqrt(3); what the three have in common drops out.
    CHECK_NEAR(ROUNDING, (2.5 + 1.25 - 0.625) / 3.0, s.i_A.alpha);
    CHECK_NEAR(ROUNDING, (-1.25 - 0.625) / sqrt(3.0), s.i_A.beta);
    CHECK_NEAR(ROUNDING, 200.0, s.v_bus_V);
    CHECK_NEAR(ROUNDING, 25.0, degrees(&config, s));
    TEST_ASSERT_TRUE(s.trip);
    TEST_ASSERT_EQUAL_UINT32(77, s.stamp);
    TEST_ASSERT_FALSE(railed(&config, counts, half));
}

static void test_two_shunts(void) {
    lode_sense_config_t config = board();
    config.shunts = LODE_SHUNTS_TWO;
    // The third ADC channel is not wired: whatever it says does not count.
    const lode_counts_t counts = {.i = {2148, 2088, 0}, .v_bus = 2000};
    const lode_sample_t s = sampled(&config, counts, half);
    CHECK_NEAR(ROUNDING, 1.25, amperes(&config, s, 0));
    CHECK_NEAR(ROUNDING, 0.5, amperes(&config, s, 1));
    CHECK_NEAR(ROUNDING, -1.75, amperes(&config, s, 2));
    CHECK_NEAR(ROUNDING, 1.25, s.i_A.alpha);
    CHECK_NEAR(ROUNDING, (1.25 + 2.0 * 0.5) / sqrt(3.0), s.i_A.beta);
    TEST_ASSERT_FALSE(railed(&config, counts, half));
    TEST_ASSERT_FALSE(s.trip);
}

static void test_an_inverting_amplifier(void) {
    lode_sense_config_t config = board();
    config.i_gain_A_count = -0.0125f;
    const lode_counts_t counts = {.i = {2148, 1948, 2048}};
    const lode_sample_t s = sampled(&config, counts, half);
    CHECK_NEAR(ROUNDING, -1.25, amperes(&config, s, 0));
    CHECK_NEAR(ROUNDING, 1.25, amperes(&config, s, 1));
    CHECK_NEAR(ROUNDING, 0.0, amperes(&config, s, 2));
}

static void test_no_temperature_sensor(void) {
    lode_sense_config_t config = board();
    config.temperature_gain_degC_count = 0.0f;
    config.temperature_offset_degC = 25.0f;
    const lode_counts_t counts = {.temperature = 65535};
    CHECK_NEAR(ROUNDING, 25.0, degrees(&config, sampled(&config, counts, half)));
}

static void test_rails_are_reported(void) {
    const lode_sense_config_t config = board();
    const uint16_t rails[] = {0, 4095, 4096, 65535};
    for (int phase = 0; phase < 3; phase++) {
        for (int r = 0; r < COUNT_OF(rails); r++) {
            lode_counts_t counts = {.i = {2048, 2048, 2048}};
            counts.i[phase] = rails[r];
            TEST_ASSERT_TRUE(railed(&config, counts, half));
        }
        lode_counts_t counts = {.i = {2048, 2048, 2048}};
        counts.i[phase] = 1;
        TEST_ASSERT_FALSE(railed(&config, counts, half));
        counts.i[phase] = 4094;
        TEST_ASSERT_FALSE(railed(&config, counts, half));
    }
}

static void test_rails_of_two_shunts(void) {
    lode_sense_config_t config = board();
    config.shunts = LODE_SHUNTS_TWO;
    const lode_counts_t a = {.i = {4095, 2048, 2048}};
    const lode_counts_t b = {.i = {2048, 0, 2048}};
    const lode_counts_t c = {.i = {2048, 2048, 4095}};
    TEST_ASSERT_TRUE(railed(&config, a, half));
    TEST_ASSERT_TRUE(railed(&config, b, half));
    TEST_ASSERT_FALSE(railed(&config, c, half));
}

static lode_abc_t duty_with(int phase, float value) {
    lode_abc_t duty = {0.4f, 0.3f, 0.35f};
    if (phase == 0) {
        duty.a = value;
    } else if (phase == 1) {
        duty.b = value;
    } else {
        duty.c = value;
    }
    return duty;
}

static void test_a_phase_without_a_window_follows_from_the_others(void) {
    lode_sense_config_t config = board();
    config.duty_max = 0.9f;
    for (int phase = 0; phase < 3; phase++) {
        lode_counts_t counts = {.i = {2148, 2088, 2000}};
        const double currents[] = {1.25, 0.5, -0.6};
        const double other_two = currents[0] + currents[1] + currents[2] - currents[phase];
        const lode_sample_t s = sampled(&config, counts, duty_with(phase, 0.93f));
        CHECK_NEAR(ROUNDING, -other_two, amperes(&config, s, phase));
        // What the blind ADC channel says does not reach the result.
        counts.i[phase] = 3000;
        const lode_sample_t t = sampled(&config, counts, duty_with(phase, 0.93f));
        TEST_ASSERT_EQUAL_MEMORY(s.i, t.i, sizeof s.i);
        TEST_ASSERT_EQUAL_MEMORY(&s.i_A, &t.i_A, sizeof s.i_A);
        // At the limit it is still sampled.
        const lode_sample_t u = sampled(&config, counts, duty_with(phase, 0.9f));
        CHECK_NEAR(ROUNDING, 0.0125 * (3000 - 2048), amperes(&config, u, phase));
    }
}

static void test_of_two_phases_without_a_window_the_longest_is_replaced(void) {
    lode_sense_config_t config = board();
    config.duty_max = 0.9f;
    const lode_counts_t counts = {.i = {2148, 2088, 2000}};
    const lode_sample_t s = sampled(&config, counts, (lode_abc_t){0.91f, 0.95f, 0.1f});
    CHECK_NEAR(ROUNDING, 1.25, amperes(&config, s, 0));
    CHECK_NEAR(ROUNDING, -1.25 + 0.6, amperes(&config, s, 1));
    CHECK_NEAR(ROUNDING, -0.6, amperes(&config, s, 2));
}

static void test_the_rail_of_a_sample_that_is_not_used_does_not_count(void) {
    lode_sense_config_t config = board();
    config.duty_max = 0.9f;
    for (int phase = 0; phase < 3; phase++) {
        lode_counts_t counts = {.i = {2048, 2048, 2048}};
        counts.i[phase] = 4095;
        TEST_ASSERT_FALSE(railed(&config, counts, duty_with(phase, 0.95f)));
        TEST_ASSERT_TRUE(railed(&config, counts, duty_with((phase + 1) % 3, 0.95f)));
    }
}

/// The phase that each of three samples in a row is without.
static void check_row(const lode_sense_tuning_t *tuning, uint_least8_t omitted,
                      const uint_least8_t want[3]) {
    lode_sense_t sense;
    lode_sense_reset(&sense, tuning);
    const lode_counts_t counts = {.i = {2148, 1948, 2098}, .v_bus = 2000};
    for (int k = 0; k < 3; k++) {
        const lode_sample_t next = lode_sense_next(&sense, tuning, &counts, &omitted);
        const lode_sample_t same = lode_sense_step(&sense, tuning, &counts, want[k]);
        TEST_ASSERT_EQUAL_UINT(want[k], next.omitted);
        TEST_ASSERT_EQUAL_MEMORY(same.i, next.i, sizeof same.i);
    }
}

static void test_long_duties_act_on_the_samples_at_both_ends_of_their_period(void) {
    lode_sense_config_t config = board();
    config.duty_max = 0.9f;
    const lode_sense_tuning_t tuning = tuned(&config);
    for (uint_least8_t phase = 0; phase < LODE_PHASES; phase++) {
        const uint_least8_t ends[] = {phase, phase, LODE_PHASES};
        check_row(&tuning, lode_sense_omit_later(OMITTED_NONE, phase), ends);
        for (uint_least8_t other = 0; other < LODE_PHASES; other++) {
            const uint_least8_t after[] = {other, phase, LODE_PHASES};
            check_row(&tuning, lode_sense_omit_later(lode_sense_omit_both(other), phase), after);
        }
        const uint_least8_t both[] = {phase, phase, LODE_PHASES};
        check_row(&tuning, lode_sense_omit_both(phase), both);
    }
    config.shunts = LODE_SHUNTS_TWO;
    const lode_sense_tuning_t two = tuned(&config);
    const uint_least8_t always[] = {2u, 2u, 2u};
    check_row(&two, lode_sense_omit_both(2u), always);
}

static void test_windowed_is_where_a_phase_may_be_missing(void) {
    lode_sense_config_t config = board();
    TEST_ASSERT_EQUAL_FLOAT(1.0f, tuned(&config).duty_max);
    config.duty_max = 0.999f;
    TEST_ASSERT_EQUAL_FLOAT(0.999f, tuned(&config).duty_max);
    config.shunts = LODE_SHUNTS_TWO; // c always, whatever the duties
    TEST_ASSERT_EQUAL_FLOAT(1.0f, tuned(&config).duty_max);
    config.duty_max = 1.0f;
    // All three phases in every period: the duties do not matter.
    config.shunts = LODE_SHUNTS_THREE;
    const lode_counts_t counts = {.i = {2148, 1948, 2098}, .v_bus = 2000};
    const lode_sample_t s = sampled(&config, counts, (lode_abc_t){1.0f, 1.0f, 1.0f});
    const lode_sample_t t = sampled(&config, counts, half);
    TEST_ASSERT_EQUAL_MEMORY(t.i, s.i, sizeof s.i);
    TEST_ASSERT_EQUAL_MEMORY(&t.i_A, &s.i_A, sizeof s.i_A);
}

static void test_vector_is_that_of_the_phases(void) {
    random_t random = random_seed(6);
    const float duty_maxima[] = {1.0f, 0.9f};
    for (int n = 0; n < 20000; n++) {
        lode_sense_config_t config = board();
        config.shunts = n % 2 == 0 ? LODE_SHUNTS_THREE : LODE_SHUNTS_TWO;
        config.duty_max = duty_maxima[n / 2 % 2];
        const lode_counts_t counts = {.i = {(uint16_t)(random_bits(&random) % 4096u),
                                            (uint16_t)(random_bits(&random) % 4096u),
                                            (uint16_t)(random_bits(&random) % 4096u)}};
        const lode_abc_t duty = {random_float(&random, 0.0, 1.0), random_float(&random, 0.0, 1.0),
                                 random_float(&random, 0.0, 1.0)};
        const lode_sample_t s = sampled(&config, counts, duty);
        const double a = amperes(&config, s, 0);
        const double b = amperes(&config, s, 1);
        const double c = amperes(&config, s, 2);
        CHECK_NEAR(ROUNDING, (2.0 * a - b - c) / 3.0, s.i_A.alpha);
        CHECK_NEAR(ROUNDING, (b - c) / sqrt(3.0), s.i_A.beta);
    }
}

static void test_a_current_beyond_the_limit_is_an_alert(void) {
    const lode_sense_config_t config = board();
    lode_sense_tuning_t tuning = tuned(&config);
    tuning.alert = 100u * LODE_COUNT_FRACTION;
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    for (int phase = 0; phase < 3; phase++) {
        for (int count = -2048; count <= 2047; count++) {
            lode_counts_t counts = {.i = {2048, 2048, 2048}};
            counts.i[phase] = (uint16_t)(2048 + count);
            const lode_sample_t s = lode_sense_step(&sense, &tuning, &counts, LODE_PHASES);
            TEST_ASSERT_EQUAL_INT(count < -100 || count > 100, s.alert);
        }
    }
    // A phase that is not sampled counts by what the other two leave for it.
    const lode_counts_t counts = {.i = {2048 + 60, 2048 + 60, 2048}};
    TEST_ASSERT_FALSE(lode_sense_step(&sense, &tuning, &counts, LODE_PHASES).alert);
    TEST_ASSERT_TRUE(lode_sense_step(&sense, &tuning, &counts, 2u).alert);
}

static void test_every_sample_at_a_rail_is_an_alert(void) {
    // The rails are looked at only then: whatever offset a calibration may have found.
    const uint16_t rails[] = {0, 4095, 4096, 65535};
    const lode_sense_config_t config = board();
    const lode_sense_tuning_t tuning = tuned(&config);
    random_t random = random_seed(5);
    for (int n = 0; n < 12000; n++) {
        lode_sense_t sense;
        lode_sense_reset(&sense, &tuning);
        for (int phase = 0; phase < 3; phase++) {
            sense.offset[phase] += (int32_t)(256.0 * random_between(&random, -100.0, 100.0));
        }
        lode_counts_t counts = {.i = {2048, 2048, 2048}};
        TEST_ASSERT_FALSE(lode_sense_step(&sense, &tuning, &counts, LODE_PHASES).alert);
        counts.i[n % 3] = rails[n / 3 % COUNT_OF(rails)];
        const lode_sample_t s = lode_sense_step(&sense, &tuning, &counts, LODE_PHASES);
        TEST_ASSERT_TRUE(s.alert && lode_sense_is_railed(&sense, &tuning, &s));
    }
}

/// Offset in use, counts.
static double offset_of(const lode_sense_t *sense, int phase) {
    return (double)sense->offset[phase] / LODE_COUNT_FRACTION;
}

/// Calibrates on counts that alternate by +-3 about the given means.
static lode_calibration_t calibrate(lode_sense_t *sense, const lode_sense_tuning_t *tuning, int a,
                                    int b, int c, int *steps, float *worst) {
    lode_calibration_t result = LODE_CALIBRATION_RUNNING;
    lode_sense_begin(&sums);
    for (*steps = 0; *steps < 1000 && result == LODE_CALIBRATION_RUNNING; (*steps)++) {
        const int ripple = *steps % 2 == 0 ? 3 : -3;
        const lode_counts_t counts = {
            .i = {(uint16_t)(a + ripple), (uint16_t)(b - ripple), (uint16_t)(c + ripple)}};
        const lode_sample_t sample =
            lode_sense_step(sense, tuning, &counts, lode_sense_omitted(tuning, half));
        result = lode_sense_calibrate(sense, &sums, tuning, &sample, worst);
    }
    return result;
}

static void test_no_offset_at_the_end_of_the_range(void) {
    // A tolerance of the whole range: what hangs at a rail would else pass for no current.
    lode_sense_config_t config = board();
    config.i_offset_tol_count = 4095.0f;
    const lode_sense_tuning_t tuning = tuned(&config);
    const struct {
        uint16_t count;
        lode_calibration_t result;
    } cases[] = {{0, LODE_CALIBRATION_IMPLAUSIBLE},
                 {1, LODE_CALIBRATION_IMPLAUSIBLE}, // 2048 +- 2046: the upper side is the shorter
                 {2, LODE_CALIBRATION_DONE},
                 {4094, LODE_CALIBRATION_DONE},
                 {4095, LODE_CALIBRATION_IMPLAUSIBLE}};
    for (int k = 0; k < COUNT_OF(cases); k++) {
        lode_sense_t sense;
        lode_sense_reset(&sense, &tuning);
        lode_sense_begin(&sums);
        const lode_counts_t counts = {.i = {cases[k].count, 2048, 2048}};
        const lode_sample_t sample = lode_sense_step(&sense, &tuning, &counts, LODE_PHASES);
        lode_calibration_t result = LODE_CALIBRATION_RUNNING;
        float worst;
        for (int n = 0; n < 1000 && result == LODE_CALIBRATION_RUNNING; n++) {
            result = lode_sense_calibrate(&sense, &sums, &tuning, &sample, &worst);
        }
        TEST_ASSERT_EQUAL_INT(cases[k].result, result);
    }
}

static void test_calibration_averages(void) {
    const lode_sense_config_t config = board();
    const lode_sense_tuning_t tuning = tuned(&config);
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    for (int again = 0; again < 2; again++) {
        int steps;
        float worst = NAN;
        TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_DONE,
                              calibrate(&sense, &tuning, 2060, 1990, 2050, &steps, &worst));
        TEST_ASSERT_EQUAL_INT(50, steps); // 0.01 s of 200 us
        CHECK_NEAR(1.0e-3, 2060.0, offset_of(&sense, 0));
        CHECK_NEAR(1.0e-3, 1990.0, offset_of(&sense, 1));
        CHECK_NEAR(1.0e-3, 2050.0, offset_of(&sense, 2));
        CHECK_NEAR(1.0e-3, 58.0, fabsf(worst));
    }
    const lode_counts_t counts = {.i = {2060, 1990, 2150}};
    const lode_sample_t s = lode_sense_step(&sense, &tuning, &counts, LODE_PHASES);
    CHECK_NEAR(ROUNDING, 0.0, amperes(&config, s, 0));
    CHECK_NEAR(ROUNDING, 0.0, amperes(&config, s, 1));
    CHECK_NEAR(ROUNDING, 1.25, amperes(&config, s, 2));
}

static void test_the_first_of_two_equal_deviations_is_reported(void) {
    const lode_sense_config_t config = board();
    const lode_sense_tuning_t tuning = tuned(&config);
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    int steps;
    float worst = 0.0f;
    (void)calibrate(&sense, &tuning, 2048 - 120, 2048 + 120, 2048, &steps, &worst);
    CHECK_NEAR(1.0e-3, -120.0, worst);
}

static void test_a_calibration_takes_one_sample_at_least(void) {
    lode_sense_config_t config = board();
    config.calibrate_s = PAPER_TS_s;
    TEST_ASSERT_EQUAL_UINT32(1u, tuned(&config).calibrate_periods);
}

static void test_implausible_offsets_change_nothing(void) {
    const lode_sense_config_t config = board();
    const lode_sense_tuning_t tuning = tuned(&config);
    for (int phase = 0; phase < 3; phase++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            lode_sense_t sense;
            lode_sense_reset(&sense, &tuning);
            int means[3] = {2050, 2050, 2050};
            means[phase] = 2048 + sign * 101;
            int steps;
            float worst = 0.0f;
            TEST_ASSERT_EQUAL_INT(
                LODE_CALIBRATION_IMPLAUSIBLE,
                calibrate(&sense, &tuning, means[0], means[1], means[2], &steps, &worst));
            CHECK_NEAR(1.0e-3, 101.0, fabsf(worst));
            CHECK_NEAR(0.0, 2048.0, offset_of(&sense, 0));
            CHECK_NEAR(0.0, 2048.0, offset_of(&sense, 1));
            CHECK_NEAR(0.0, 2048.0, offset_of(&sense, 2));
            // The next attempt starts afresh; 100 counts are just plausible.
            means[phase] = 2048 + sign * 100;
            TEST_ASSERT_EQUAL_INT(
                LODE_CALIBRATION_DONE,
                calibrate(&sense, &tuning, means[0], means[1], means[2], &steps, &worst));
        }
    }
}

static void test_calibration_of_two_shunts_ignores_the_third(void) {
    lode_sense_config_t config = board();
    config.shunts = LODE_SHUNTS_TWO;
    const lode_sense_tuning_t tuning = tuned(&config);
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    int steps;
    float worst;
    TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_DONE,
                          calibrate(&sense, &tuning, 2058, 2042, 10, &steps, &worst));
    CHECK_NEAR(1.0e-3, 2058.0, offset_of(&sense, 0));
    CHECK_NEAR(1.0e-3, 2042.0, offset_of(&sense, 1));
    CHECK_NEAR(0.0, 2048.0, offset_of(&sense, 2));
    CHECK_NEAR(1.0e-3, 10.0, worst);
}

/// Fractions of a count count, what is on its way tells no deviation yet, and the next calibration begins anew.
static void test_calibration_of_fractions(void) {
    const lode_sense_config_t config = board();
    const lode_sense_tuning_t tuning = tuned(&config);
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    lode_sense_begin(&sums);
    float worst = 7.0f;
    for (int round = 0; round < 2; round++) {
        uint32_t steps = 0u;
        lode_calibration_t result = LODE_CALIBRATION_RUNNING;
        while (result == LODE_CALIBRATION_RUNNING && steps < 1000u) {
            const lode_counts_t counts = {
                .i = {(uint16_t)(2048u + (steps % 4u == 0u ? 1u : 0u)), 2048u, 2048u}};
            const lode_sample_t sample = lode_sense_step(&sense, &tuning, &counts, LODE_PHASES);
            result = lode_sense_calibrate(&sense, &sums, &tuning, &sample, &worst);
            steps++;
            TEST_ASSERT_TRUE(result != LODE_CALIBRATION_RUNNING || worst == 0.0f);
        }
        TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_DONE, result);
        TEST_ASSERT_EQUAL_UINT(tuning.calibrate_periods, steps);
        CHECK_NEAR(0.01, 2048.25, offset_of(&sense, 0));
        CHECK_NEAR(0.01, 0.25, worst);
    }
    int steps;
    TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_DONE,
                          calibrate(&sense, &tuning, 2048, 2048, 2048, &steps, &worst));
    CHECK_NEAR(0.0, 0.0, worst);
}

/// Each step from one sample to the next is part of the noise.
static void test_noise_is_that_of_all_steps(void) {
    const lode_sense_config_t config = board();
    const lode_sense_tuning_t tuning = tuned(&config);
    static const uint16_t seen[] = {2048u, 2058u, 2055u};
    lode_sense_t sense;
    float worst;
    lode_sense_reset(&sense, &tuning);
    lode_sense_begin(&sums);
    for (int n = 0; n < COUNT_OF(seen); n++) {
        const lode_counts_t counts = {.i = {2048u, seen[n], 2048u}};
        const lode_sample_t sample = lode_sense_step(&sense, &tuning, &counts, LODE_PHASES);
        (void)lode_sense_calibrate(&sense, &sums, &tuning, &sample, &worst);
    }
    TEST_ASSERT_EQUAL_UINT(0u, sums.steps2[0]);
    TEST_ASSERT_EQUAL_UINT(100u + 9u, sums.steps2[1]);
}

/// Of two shunts each has to have its noise; the third current, made of both, need not.
static void test_noise_of_two_shunts(void) {
    lode_sense_config_t config = board();
    config.shunts = LODE_SHUNTS_TWO;
    config.calibrate_s = 0.1f;
    config.i_noise_count = 0.4f;
    const lode_sense_tuning_t tuning = tuned(&config);
    for (int still = 0; still <= 2; still++) { // 0: none
        lode_sense_t sense;
        float worst = 0.0f;
        lode_sense_reset(&sense, &tuning);
        lode_sense_begin(&sums);
        lode_calibration_t result = LODE_CALIBRATION_RUNNING;
        for (unsigned n = 0; n < 500u; n++) {
            const uint16_t a = (uint16_t)(2048u + (still == 1 ? 0u : n % 2u));
            const uint16_t b = (uint16_t)(2048u - (still == 2 ? 0u : n % 2u));
            const lode_counts_t counts = {.i = {a, b, 0u}};
            const lode_sample_t s = lode_sense_step(&sense, &tuning, &counts, 2u);
            result = lode_sense_calibrate(&sense, &sums, &tuning, &s, &worst);
        }
        TEST_ASSERT_EQUAL_INT(still == 0 ? LODE_CALIBRATION_DONE : LODE_CALIBRATION_STUCK, result);
        TEST_ASSERT_TRUE(still == 0 || worst == (float)still);
    }
}

static lode_status_t try_config(const lode_sense_config_t *config);

static void test_calibration_asks_for_noise_where_there_is_some(void) {
    lode_sense_config_t config = board();
    config.calibrate_s = 0.1f; // steps of 6 counts: rms noise of 3 makes 4.2 of them
    config.i_noise_count = 8.0f;
    lode_sense_tuning_t tuning = tuned(&config);
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    int steps;
    float worst;
    TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_DONE,
                          calibrate(&sense, &tuning, 2060, 2048, 2050, &steps, &worst));
    TEST_ASSERT_EQUAL_INT(500, steps);
    config.i_noise_count = 9.0f;
    tuning = tuned(&config);
    lode_sense_reset(&sense, &tuning);
    TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_STUCK,
                          calibrate(&sense, &tuning, 2060, 2048, 2050, &steps, &worst));
    TEST_ASSERT_TRUE(worst == 1.0f);
    CHECK_NEAR(0.0, 2048.0, offset_of(&sense, 0)); // nothing has changed
    // An offset that is wrong is told first. Where nothing is wired nothing is asked for.
    TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_IMPLAUSIBLE,
                          calibrate(&sense, &tuning, 2248, 2048, 2050, &steps, &worst));
    config.shunts = LODE_SHUNTS_TWO;
    config.i_noise_count = 0.4f;
    tuning = tuned(&config);
    lode_sense_begin(&sums);
    lode_calibration_t result = LODE_CALIBRATION_RUNNING;
    for (unsigned n = 0; n < 500u; n++) { // and a step of 300 counts does not overflow
        const lode_counts_t counts = {
            .i = {(uint16_t)(n == 100u ? 2348u : 2048u + n % 2u), (uint16_t)(2048u + n % 2u), 0u}};
        const lode_sample_t s = lode_sense_step(&sense, &tuning, &counts, 2u);
        result = lode_sense_calibrate(&sense, &sums, &tuning, &s, &worst);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_DONE, result);
}

static void test_range_of_the_noise(void) {
    lode_sense_config_t config = board();
    config.calibrate_s = 0.0512f; // 256 samples
    const float good[] = {0.0f, 0.4f, 64.0f};
    const float bad[] = {-0.1f, 0.39f, 64.1f, NAN, INFINITY};
    for (int k = 0; k < COUNT_OF(good); k++) {
        config.i_noise_count = good[k];
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_config(&config));
    }
    for (int k = 0; k < COUNT_OF(bad); k++) {
        config.i_noise_count = bad[k];
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CALIBRATION, try_config(&config));
    }
    config.i_noise_count = 0.4f;
    config.calibrate_s = 0.0509f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CALIBRATION, try_config(&config));
}

static void test_a_long_calibration_keeps_its_precision(void) {
    lode_sense_config_t config = board();
    config.count_max = 65535.0f;
    config.i_offset_count = 32768.0f;
    config.calibrate_s = 10.0f;
    config.i_offset_tol_count = 1000.0f;
    const lode_sense_tuning_t tuning = tuned(&config);
    lode_sense_t sense;
    lode_sense_reset(&sense, &tuning);
    const lode_counts_t counts = {.i = {33700, 31801, 32769}};
    const lode_sample_t sample = lode_sense_step(&sense, &tuning, &counts, LODE_PHASES);
    float worst;
    int steps = 1;
    lode_sense_begin(&sums);
    while (lode_sense_calibrate(&sense, &sums, &tuning, &sample, &worst) ==
               LODE_CALIBRATION_RUNNING &&
           steps < 60000) {
        steps++;
    }
    TEST_ASSERT_EQUAL_INT(50000, steps);
    // Sums of integers are exact, means to 1/256 of a count.
    CHECK_NEAR(0.004, 33700.0, offset_of(&sense, 0));
    CHECK_NEAR(0.004, 31801.0, offset_of(&sense, 1));
    CHECK_NEAR(0.004, 32769.0, offset_of(&sense, 2));
}

// A memory that has flipped: the offset that comes of it does not fit, and is refused, with no overflow on the way.
static void test_sums_of_no_adc_are_refused(void) {
    const lode_sense_config_t config = board();
    const lode_sense_tuning_t tuning = tuned(&config);
    const lode_counts_t counts = {.i = {2048, 2048, 2048}};
    const uint32_t means[] = {0x00800000u, 0x007FFFFFu, 0x00FFFFFFu, 0x00400000u};
    for (int k = 0; k < COUNT_OF(means); k++) {
        for (int phase = 0; phase < LODE_PHASES; phase++) {
            lode_sense_t sense;
            lode_sense_reset(&sense, &tuning);
            const lode_sense_t before = sense;
            const lode_sample_t sample = lode_sense_step(&sense, &tuning, &counts, LODE_PHASES);
            lode_sense_begin(&sums);
            sums.samples = tuning.calibrate_periods - 1u;
            for (int n = 0; n < LODE_PHASES; n++) {
                sums.count[n] = 2048u * tuning.calibrate_periods - 2048u;
            }
            sums.count[phase] = means[k] * tuning.calibrate_periods - 2048u;
            float worst;
            TEST_ASSERT_EQUAL_INT(LODE_CALIBRATION_IMPLAUSIBLE,
                                  lode_sense_calibrate(&sense, &sums, &tuning, &sample, &worst));
            TEST_ASSERT_EQUAL_INT32_ARRAY(before.offset, sense.offset, LODE_PHASES);
        }
    }
}

static void test_reset_forgets_the_calibration(void) {
    const lode_sense_config_t config = board();
    const lode_sense_tuning_t tuning = tuned(&config);
    lode_sense_t sense = {.offset = {1, 2, 3}};
    lode_sense_reset(&sense, &tuning);
    const lode_sense_t expected = {.offset = {2048 * 256, 2048 * 256, 2048 * 256}};
    TEST_ASSERT_EQUAL_MEMORY(&expected, &sense, sizeof sense);
}

static lode_status_t try_config(const lode_sense_config_t *config) {
    lode_sense_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_sense_tuning_t before = tuning;
    const lode_status_t status = lode_sense_tune(&tuning, config, I_MAX_A, PAPER_V_BUS, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_sense_config_t config = board();
    field_set(&config, offset, value);
    return try_config(&config);
}

static void test_every_field_at_its_limits(void) {
    static const field_t fields[] = {
        {FIELD(lode_sense_config_t, duty_max), .lo = 0.5f, .hi = 1.0f,
         .error = LODE_ERROR_SENSE_WINDOW},
        {FIELD(lode_sense_config_t, calibrate_s), .lo = PAPER_TS_s, .hi = 10.0f,
         .error = LODE_ERROR_SENSE_CALIBRATION},
        {FIELD(lode_sense_config_t, i_offset_tol_count), .lo = 0.0f, .hi = 4095.0f,
         .error = LODE_ERROR_SENSE_OFFSET},
    };
    field_check_all(fields, COUNT_OF(fields), try_one);
}

static void test_currents_must_reach_i_max(void) {
    const size_t gain = offsetof(lode_sense_config_t, i_gain_A_count);
    // 12 A within 2047 counts on the shorter side.
    const float least = I_MAX_A / 2047.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(gain, least * 1.001f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(gain, -least * 1.001f));
    const float bad[] = {least * 0.999f, -least * 0.999f, 0.0f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_one(gain, bad[i]));
    }
    const size_t offset = offsetof(lode_sense_config_t, i_offset_count);
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, 961.0f)); // 12 A are 960 counts
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_one(offset, 959.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_one(offset, 4095.0f - 959.0f));
    // To the count: 12 A are 1536 of 1/128 A.
    lode_sense_config_t exact = board();
    exact.i_gain_A_count = 1.0f / 128.0f;
    exact.i_offset_count = 1536.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_config(&exact));
    exact.i_offset_count = 1535.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_config(&exact));
    lode_sense_config_t close = board();
    close.i_gain_A_count = 100.0f;
    close.i_offset_count = 0.9f; // 90 A
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_config(&close));
    close.i_offset_count = 1.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_config(&close));
    const float none[] = {-1.0f, 4096.0f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(none); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_OFFSET, try_one(offset, none[i]));
    }
}

static void test_the_bus_must_reach_its_voltage(void) {
    const size_t gain = offsetof(lode_sense_config_t, v_bus_gain_V_count);
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(gain, 200.5f / 4095.0f));
    lode_sense_config_t exact = board();
    exact.count_max = 4096.0f;
    exact.v_bus_gain_V_count = 200.0f / 4096.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_config(&exact));
    const float bad[] = {199.5f / 4095.0f, 0.0f, -0.1f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_BUS, try_one(gain, bad[i]));
    }
}

static void test_range_of_the_adc(void) {
    const size_t count = offsetof(lode_sense_config_t, count_max);
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(count, 65535.0f));
    const float bad[] = {65536.0f, -4095.0f, NAN, INFINITY, -INFINITY, 2047.0f};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_OFFSET, try_one(count, bad[i]));
    }
    // One of a single count is an ADC, but none that could see a current of either sign.
    lode_sense_config_t least = board();
    least.i_offset_count = 0.5f;
    least.i_offset_tol_count = 0.5f;
    least.count_max = 1.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_config(&least));
    least.count_max = 0.9f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_OFFSET, try_config(&least));
}

static void test_temperature_must_be_finite(void) {
    const size_t gain = offsetof(lode_sense_config_t, temperature_gain_degC_count);
    const size_t offset = offsetof(lode_sense_config_t, temperature_offset_degC);
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_TEMPERATURE, try_one(gain, check_not_finite[i]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_TEMPERATURE, try_one(offset, check_not_finite[i]));
    }
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(gain, -0.05f));
    for (int sign = -1; sign <= 1; sign += 2) {
        const float way = (float)sign;
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(gain, way * 1.0e3f));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_TEMPERATURE, try_one(gain, way * 1.001e3f));
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, way * 1.0e6f));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_TEMPERATURE, try_one(offset, way * 1.001e6f));
    }
}

static void test_shunts_are_an_enumerator(void) {
    lode_sense_config_t config = board();
    config.shunts = (lode_shunts_t)2;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_SHUNTS, try_config(&config));
}

static void test_samples_are_finite_for_any_accepted_gain(void) {
    random_t random = random_seed(4);
    for (int n = 0; n < 20000; n++) {
        lode_sense_config_t config = board();
        config.i_gain_A_count = random_any(&random);
        config.v_bus_gain_V_count = random_any(&random);
        config.temperature_gain_degC_count = random_any(&random);
        config.temperature_offset_degC = random_any(&random);
        if (try_config(&config) == LODE_OK) {
            const lode_counts_t counts = {
                .i = {65535, 0, 65535}, .v_bus = 65535, .temperature = 65535};
            const lode_sample_t s = sampled(&config, counts, half);
            TEST_ASSERT_TRUE(isfinite(s.i_A.alpha) && isfinite(s.i_A.beta));
            TEST_ASSERT_TRUE(isfinite(s.v_bus_V) && isfinite(degrees(&config, s)));
        }
    }
}

static void test_design_fills_what_is_open(void) {
    lode_sense_config_t config = {.i_gain_A_count = 0.01f};
    lode_sense_design(&config);
    TEST_ASSERT_EQUAL_FLOAT(4095.0f, config.count_max);
    CHECK_NEAR(1.0e-3, 0.05 * 4095.0, config.i_offset_tol_count);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, config.duty_max);
    TEST_ASSERT_EQUAL_FLOAT(0.1f, config.calibrate_s);
    const lode_sense_config_t all = board();
    lode_sense_config_t kept = all;
    lode_sense_design(&kept);
    TEST_ASSERT_EQUAL_MEMORY(&all, &kept, sizeof all);
}

/// The counts say nothing of it.
static void test_a_sample_alone_has_no_voltage(void) {
    const lode_sense_config_t config = board();
    const lode_sample_t sample =
        sampled(&config, (lode_counts_t){.i = {2000u, 2100u, 2048u}, .v_bus = 900u}, half);
    CHECK_NEAR(0.0, 0.0, sample.u_V.alpha);
    CHECK_NEAR(0.0, 0.0, sample.u_V.beta);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_three_shunts);
    RUN_TEST(test_two_shunts);
    RUN_TEST(test_an_inverting_amplifier);
    RUN_TEST(test_no_temperature_sensor);
    RUN_TEST(test_rails_are_reported);
    RUN_TEST(test_rails_of_two_shunts);
    RUN_TEST(test_a_phase_without_a_window_follows_from_the_others);
    RUN_TEST(test_of_two_phases_without_a_window_the_longest_is_replaced);
    RUN_TEST(test_the_rail_of_a_sample_that_is_not_used_does_not_count);
    RUN_TEST(test_long_duties_act_on_the_samples_at_both_ends_of_their_period);
    RUN_TEST(test_windowed_is_where_a_phase_may_be_missing);
    RUN_TEST(test_vector_is_that_of_the_phases);
    RUN_TEST(test_a_current_beyond_the_limit_is_an_alert);
    RUN_TEST(test_every_sample_at_a_rail_is_an_alert);
    RUN_TEST(test_no_offset_at_the_end_of_the_range);
    RUN_TEST(test_calibration_averages);
    RUN_TEST(test_the_first_of_two_equal_deviations_is_reported);
    RUN_TEST(test_a_calibration_takes_one_sample_at_least);
    RUN_TEST(test_implausible_offsets_change_nothing);
    RUN_TEST(test_calibration_of_two_shunts_ignores_the_third);
    RUN_TEST(test_calibration_of_fractions);
    RUN_TEST(test_noise_is_that_of_all_steps);
    RUN_TEST(test_noise_of_two_shunts);
    RUN_TEST(test_calibration_asks_for_noise_where_there_is_some);
    RUN_TEST(test_range_of_the_noise);
    RUN_TEST(test_a_long_calibration_keeps_its_precision);
    RUN_TEST(test_reset_forgets_the_calibration);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_currents_must_reach_i_max);
    RUN_TEST(test_the_bus_must_reach_its_voltage);
    RUN_TEST(test_range_of_the_adc);
    RUN_TEST(test_temperature_must_be_finite);
    RUN_TEST(test_sums_of_no_adc_are_refused);
    RUN_TEST(test_shunts_are_an_enumerator);
    RUN_TEST(test_samples_are_finite_for_any_accepted_gain);
    RUN_TEST(test_design_fills_what_is_open);
    RUN_TEST(test_a_sample_alone_has_no_voltage);
    return UNITY_END();
}
