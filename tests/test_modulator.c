// Min-max modulation against sectors and dwell times; limits, grid, dead-time correction.
#include "support/check.h"

#include "golden/modulator.h"
#include "modulator_inline.h"

void setUp(void) {}

void tearDown(void) {}

static lode_inverter_tuning_t inverter(float dead_time_s, float ticks, lode_choice_t correct,
                                       lode_choice_t model) {
    const lode_inverter_config_t config = {.v_bus_V = 200.0f,
                                           .i_max_A = 12.0f,
                                           .dead_time_s = dead_time_s,
                                           .v_drop_V = dead_time_s > 0.0f ? 1.0f : 0.0f,
                                           .r_on_Ohm = 0.0f,
                                           .i_dead_A = 0.5f,
                                           .pwm_ticks = ticks,
                                           .dead_time_correction = correct,
                                           .dead_time_model = model};
    lode_inverter_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_inverter_tune(&tuning, &config, PAPER_TS_s));
    return tuning;
}

static lode_inverter_tuning_t ideal(void) {
    return inverter(0.0f, 0.0f, LODE_OFF, LODE_OFF);
}

static const lode_ab_t no_current = {0.0f, 0.0f};

/// Largest less smallest duty that a voltage needs at the worst angle: the dead band follows it.
static float span_of(lode_ab_t u, float bus) {
    return lode_clamp(LODE_SQRT3 * lode_ab_length(u) / bus, 0.0f, 1.0f);
}

/// One over a bus voltage, as the drive divides by it.
static float per_volt(const lode_inverter_tuning_t *tuning, float bus) {
    return 1.0f / lode_max(bus, tuning->v_min_V);
}

/// Within what the inverter leaves free, as current control finds it.
static bool is_free(const lode_inverter_tuning_t *tuning, lode_ab_t v) {
    return tuning->free > 0.0f &&
           v.alpha * v.alpha + v.beta * v.beta <= tuning->free * tuning->free;
}

/// One period with the dead-time error of the voltage and the bus of that same period.
static lode_modulator_out_t modulated(const lode_inverter_tuning_t *tuning, lode_ab_t u, float bus,
                                      lode_ab_t i) {
    const float per_V = per_volt(tuning, bus);
    const lode_dead_time_t dead_time =
        lode_inverter_dead_time(tuning, 0.0f, span_of(u, bus), per_V);
    const lode_ab_t v = lode_ab_scale(per_V, u);
    return lode_modulator_step(tuning, &dead_time, v, i, is_free(tuning, v));
}

static bool inside(lode_abc_t d) {
    return lode_in_range(d.a, 0.0f, 1.0f) && lode_in_range(d.b, 0.0f, 1.0f) &&
           lode_in_range(d.c, 0.0f, 1.0f);
}

static lode_ab_t vector(double length, double angle) {
    return (lode_ab_t){(float)(length * cos(angle)), (float)(length * sin(angle))};
}

static void test_duties_are_those_of_space_vectors(void) {
    const lode_inverter_tuning_t tuning = ideal();
    for (int i = 0; i < COUNT_OF(modulator_cases); i++) {
        const modulator_case_t *g = &modulator_cases[i];
        const float bus = 120.0f + (float)i;
        const lode_ab_t u = {(float)(g->alpha * (double)bus), (float)(g->beta * (double)bus)};
        const lode_modulator_out_t out = modulated(&tuning, u, bus, no_current);
        // A few roundings of numbers up to 1.
        CHECK_NEAR(4.0e-7, g->duty[0], out.duty.a);
        CHECK_NEAR(4.0e-7, g->duty[1], out.duty.b);
        CHECK_NEAR(4.0e-7, g->duty[2], out.duty.c);
        CHECK_NEAR(4.0e-7, g->alpha, out.realised.alpha);
        CHECK_NEAR(4.0e-7, g->beta, out.realised.beta);
    }
}

static void test_line_to_line_voltages_are_exact_up_to_the_circle(void) {
    const lode_inverter_tuning_t tuning = ideal();
    for (int i = 0; i < 3600; i++) {
        const double length = 0.99999 * 200.0 / sqrt(3.0) * (i % 7 + 1) / 7.0;
        const lode_ab_t u = vector(length, i * CHECK_PI / 1800.0);
        const lode_abc_t d = modulated(&tuning, u, 200.0f, no_current).duty;
        const lode_abc_t v = lode_clarke_inverse(u);
        // 1e-6 of the bus.
        CHECK_NEAR(2.0e-4, v.a - v.b, 200.0f * (d.a - d.b));
        CHECK_NEAR(2.0e-4, v.b - v.c, 200.0f * (d.b - d.c));
        // Min-max: the outer duties keep the same distance from the rails.
        const float high = lode_max(lode_max(d.a, d.b), d.c);
        const float low = lode_min(lode_min(d.a, d.b), d.c);
        CHECK_NEAR(1.0e-6, 1.0, high + low);
    }
}

static void test_nothing_asked_for_is_half_on(void) {
    const lode_inverter_tuning_t tuning = ideal();
    const lode_modulator_out_t out = modulated(&tuning, no_current, 200.0f, no_current);
    TEST_ASSERT_TRUE(out.duty.a == 0.5f && out.duty.b == 0.5f && out.duty.c == 0.5f);
    TEST_ASSERT_TRUE(out.realised.alpha == 0.0f && out.realised.beta == 0.0f);
}

static void test_beyond_the_hexagon_realised_says_what_is_left(void) {
    const lode_inverter_tuning_t tuning = ideal();
    for (int i = 0; i < 720; i++) {
        const lode_ab_t u = vector(180.0, i * CHECK_PI / 360.0); // 1.56 times the circle
        const lode_modulator_out_t out = modulated(&tuning, u, 200.0f, no_current);
        TEST_ASSERT_TRUE(inside(out.duty));
        const lode_ab_t expected = lode_clarke(out.duty);
        CHECK_NEAR(1.0e-6, expected.alpha, out.realised.alpha);
        CHECK_NEAR(1.0e-6, expected.beta, out.realised.beta);
        const double length = 200.0 * (double)lode_ab_length(out.realised);
        CHECK_AT_MOST(200.0 * 2.0 / 3.0 + 1.0e-3, length);  // corner of the hexagon
        CHECK_AT_LEAST(200.0 / sqrt(3.0) - 1.0e-3, length); // and middle of its side
    }
}

static void test_duties_lie_on_the_grid(void) {
    const float grids[] = {100.0f, 1000.0f, 16384.0f, 65535.0f};
    random_t random = random_seed(1);
    for (int g = 0; g < COUNT_OF(grids); g++) {
        const lode_inverter_tuning_t fine = ideal();
        const lode_inverter_tuning_t tuning = inverter(0.0f, grids[g], LODE_OFF, LODE_OFF);
        const double ticks = (double)grids[g];
        for (int n = 0; n < 2000; n++) {
            const lode_ab_t u = {random_float(&random, -130.0, 130.0),
                                 random_float(&random, -130.0, 130.0)};
            const lode_modulator_out_t out = modulated(&tuning, u, 200.0f, no_current);
            const lode_abc_t exact = modulated(&fine, u, 200.0f, no_current).duty;
            // A whole number of ticks, the nearest: half a tick, and float rounding of the product.
            CHECK_NEAR(0.01, round((double)out.duty.a * ticks), (double)out.duty.a * ticks);
            CHECK_NEAR(0.01, round((double)out.duty.c * ticks), (double)out.duty.c * ticks);
            CHECK_NEAR(0.51 / ticks, exact.a, out.duty.a);
            CHECK_NEAR(0.51 / ticks, exact.b, out.duty.b);
            CHECK_NEAR(0.51 / ticks, exact.c, out.duty.c);
            // What is realised is what the grid leaves.
            CHECK_NEAR(1.0e-6, lode_clarke(out.duty).beta, out.realised.beta);
            TEST_ASSERT_TRUE(inside(out.duty));
        }
    }
}

/// Loss of duty of the inverter above: 4 us of 200 us and 1 V of 200 V, fading in the dead band of
/// the modulation's `span`.
static double loss_of(const lode_inverter_tuning_t *tuning, double i, double span) {
    const double band = (double)tuning->i_dead_min_A + (double)tuning->i_dead_span_A * span;
    return fmax(-1.0, fmin(1.0, i / band)) * (0.02 + 0.005);
}

static void test_correction_adds_the_loss_and_realised_leaves_it_out(void) {
    const lode_inverter_tuning_t off = ideal();
    const lode_inverter_tuning_t on = inverter(4.0e-6f, 0.0f, LODE_ON, LODE_OFF);
    random_t random = random_seed(2);
    for (int n = 0; n < 2000; n++) {
        const lode_ab_t u =
            vector(random_between(&random, 0.0, 90.0), random_between(&random, 0.0, 6.3));
        const lode_ab_t i =
            vector(random_between(&random, 0.0, 3.0), random_between(&random, 0.0, 6.3));
        const lode_abc_t phases = lode_clarke_inverse(i);
        const lode_modulator_out_t plain = modulated(&off, u, 200.0f, i);
        const lode_modulator_out_t out = modulated(&on, u, 200.0f, i);
        const lode_abc_t d = plain.duty;
        // Shaped for the amplitude, not for the angle of the moment: it is renewed now and then.
        const double span = (double)span_of(u, 200.0f);
        CHECK_NEAR(1.0e-6, (double)d.a + loss_of(&on, (double)phases.a, span), out.duty.a);
        CHECK_NEAR(1.0e-6, (double)d.b + loss_of(&on, (double)phases.b, span), out.duty.b);
        CHECK_NEAR(1.0e-6, (double)d.c + loss_of(&on, (double)phases.c, span), out.duty.c);
        // The motor gets what was asked for: the correction covers the loss and no more.
        CHECK_NEAR(1.0e-6, u.alpha / 200.0f, out.realised.alpha);
        CHECK_NEAR(1.0e-6, u.beta / 200.0f, out.realised.beta);
    }
}

static void test_correction_at_the_rail_is_lost_and_realised_says_so(void) {
    const lode_inverter_tuning_t on = inverter(4.0e-6f, 0.0f, LODE_ON, LODE_OFF);
    // Phase a at the upper rail with current out of it: nothing can be added.
    const lode_ab_t u = vector(0.5 * 200.0 * 2.0 / sqrt(3.0), CHECK_PI / 6.0);
    const lode_ab_t i = {5.0f, 0.0f};
    const lode_modulator_out_t out = modulated(&on, u, 200.0f, i);
    CHECK_NEAR(1.0e-6, 1.0, out.duty.a);
    const double a = (double)out.duty.a - 0.025;
    const double b = (double)out.duty.b + 0.025;
    const double c = (double)out.duty.c + 0.025;
    CHECK_NEAR(1.0e-6, (2.0 * a - b - c) / 3.0, out.realised.alpha);
    CHECK_NEAR(1.0e-6, (b - c) / sqrt(3.0), out.realised.beta);
}

static void test_the_model_takes_the_loss_out_of_realised_only(void) {
    const lode_inverter_tuning_t off = ideal();
    const lode_inverter_tuning_t model = inverter(4.0e-6f, 0.0f, LODE_OFF, LODE_ON);
    const lode_ab_t u = {40.0f, -25.0f};
    const lode_ab_t i = {4.0f, 1.0f}; // phases 4, -1.13, -2.87: all beyond the dead band
    const lode_modulator_out_t plain = modulated(&off, u, 200.0f, i);
    const lode_modulator_out_t out = modulated(&model, u, 200.0f, i);
    TEST_ASSERT_EQUAL_MEMORY(&plain.duty, &out.duty, sizeof out.duty);
    // Signs + - -: 4/3 of the loss on alpha, none on beta.
    CHECK_NEAR(1.0e-6, 40.0 / 200.0 - 0.025 * 4.0 / 3.0, out.realised.alpha);
    CHECK_NEAR(1.0e-6, -25.0 / 200.0, out.realised.beta);
}

static void test_a_low_bus_is_not_divided_by(void) {
    const lode_inverter_tuning_t tuning = ideal();
    const float buses[] = {0.0f, -0.0f, -50.0f, 1.0e-40f, 1.0f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(buses); i++) {
        const lode_modulator_out_t out =
            modulated(&tuning, (lode_ab_t){10.0f, 3.0f}, buses[i], no_current);
        TEST_ASSERT_TRUE(inside(out.duty));
        TEST_ASSERT_TRUE(lode_ab_in_range(out.realised, 1.0f));
    }
}

static void test_any_input_gives_duties(void) {
    const lode_inverter_tuning_t tunings[] = {ideal(), inverter(4.0e-6f, 0.0f, LODE_ON, LODE_OFF),
                                              inverter(4.0e-6f, 8400.0f, LODE_ON, LODE_OFF),
                                              inverter(4.0e-6f, 65535.0f, LODE_OFF, LODE_ON)};
    random_t random = random_seed(3);
    for (int n = 0; n < CHECK_TRIES(400000); n++) {
        const lode_ab_t u = {random_any(&random), random_any(&random)};
        // Currents come from counts: finite, and never beyond 65535 of 1e4 A, twice.
        const lode_ab_t i = {lode_clamp(random_any(&random), -1.3e9f, 1.3e9f),
                             lode_clamp(random_any(&random), -1.3e9f, 1.3e9f)};
        const lode_modulator_out_t out =
            modulated(&tunings[n % COUNT_OF(tunings)], u, random_any(&random), i);
        TEST_ASSERT_TRUE(inside(out.duty));
        TEST_ASSERT_TRUE(lode_is_finite(out.realised.alpha) && lode_is_finite(out.realised.beta));
    }
}

static void test_scale_of_bus_and_voltage_alike_changes_nothing(void) {
    const lode_inverter_tuning_t tuning = ideal();
    random_t random = random_seed(4);
    for (int n = 0; n < 10000; n++) {
        const lode_ab_t u = {random_float(&random, -100.0, 100.0),
                             random_float(&random, -100.0, 100.0)};
        const lode_modulator_out_t one = modulated(&tuning, u, 150.0f, no_current);
        const lode_modulator_out_t two =
            modulated(&tuning, lode_ab_scale(2.0f, u), 300.0f, no_current);
        TEST_ASSERT_EQUAL_MEMORY(&one, &two, sizeof one);
    }
}

// --- The fast path -----------------------------------------------------------------------------

/// Inverters whose fast path is used, from ideal to all but none left.
static int plain_inverters(lode_inverter_tuning_t *tunings, int count) {
    const float dead_times[] = {0.0f, 1.0e-6f, 4.0e-6f, 2.0e-5f, 4.0e-5f};
    const float drops[] = {0.0f, 1.0f, 3.0f};
    int n = 0;
    for (int k = 0; k < COUNT_OF(dead_times) * COUNT_OF(drops) && n < count; k++) {
        const lode_inverter_config_t config = {.v_bus_V = 200.0f,
                                               .i_max_A = 12.0f,
                                               .dead_time_s = dead_times[k / COUNT_OF(drops)],
                                               .v_drop_V = drops[k % COUNT_OF(drops)],
                                               .i_dead_A = 0.5f,
                                               .dead_time_correction = LODE_ON,
                                               .dead_time_model = LODE_OFF};
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_inverter_tune(&tunings[n], &config, PAPER_TS_s));
        TEST_ASSERT_TRUE(tunings[n].free > 0.0f);
        n++;
    }
    return n;
}

/// Length of the longest vector of the fast path, V.
static double free_length(const lode_inverter_tuning_t *tuning, double bus) {
    return (double)tuning->free * fmax(bus, (double)tuning->v_min_V);
}

static void test_no_duty_of_the_fast_path_leaves_its_range(void) {
    lode_inverter_tuning_t tunings[20];
    const int count = plain_inverters(tunings, COUNT_OF(tunings));
    random_t random = random_seed(5);
    for (int t = 0; t < count; t++) {
        const lode_inverter_tuning_t *tuning = &tunings[t];
        for (int n = 0; n < 36000; n++) {
            // Every angle and length, mostly the longest; the least bus now and then; a loss that is
            // shaped for another voltage; currents far beyond any trip, where the loss is constant.
            const float bus = n % 3 == 0 ? tuning->v_min_V : random_float(&random, 1.0, 250.0);
            const double length = n % 2 == 0 ? 0.999999 : random_between(&random, 0.0, 1.0);
            const lode_ab_t u =
                vector(length * free_length(tuning, (double)bus), n * CHECK_PI / 1800.0);
            const lode_ab_t i = vector(random_between(&random, 0.0, n % 5 == 0 ? 100.0 : 1.0),
                                       random_between(&random, 0.0, 6.3));
            const float per_V = per_volt(tuning, bus);
            const lode_dead_time_t dead_time = lode_inverter_dead_time(
                tuning, tuning->dead_more_max, random_float(&random, 0.0, 1.0), per_V);
            const lode_modulator_out_t out =
                lode_modulator_step(tuning, &dead_time, lode_ab_scale(per_V, u), i, true);
            TEST_ASSERT_TRUE(inside(out.duty));
        }
    }
}

/// Far beyond i_dead the two terms of the dead-time error are all but equal, and their difference is
/// rounding: without its own room a duty was -0.006.
static void test_rounding_at_large_currents_leaves_duties_in_range(void) {
    const float i_max = 12.0f;
    const lode_inverter_config_t config = {.v_bus_V = 200.0f,
                                           .i_max_A = i_max,
                                           .dead_time_s = 3.0e-5f,
                                           .i_dead_A = 1.0e-3f * i_max,
                                           .dead_time_correction = LODE_ON,
                                           .dead_time_model = LODE_OFF};
    random_t random = random_seed(12);
    for (float i_A = 1.0e2f; i_A < 1.0e7f; i_A *= 10.0f) {
        lode_inverter_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_inverter_tune(&tuning, &config, PAPER_TS_s));
        const float before = tuning.free;
        lode_inverter_bound_current(&tuning, i_A);
        TEST_ASSERT_TRUE(tuning.free < before);
        const float per_V = per_volt(&tuning, 200.0f);
        const lode_dead_time_t dead_time =
            lode_inverter_dead_time(&tuning, tuning.dead_more_max, 0.0f, per_V);
        for (int n = 0; n < CHECK_TRIES(20000); n++) {
            const lode_ab_t u =
                vector(0.999999 * free_length(&tuning, 200.0), n * CHECK_PI / 1800.0);
            const lode_ab_t i = vector((double)i_A * random_between(&random, 0.5, 1.0),
                                       random_between(&random, 0.0, 6.3));
            const lode_ab_t v = lode_ab_scale(per_V, u);
            TEST_ASSERT_TRUE(
                inside(lode_modulator_step(&tuning, &dead_time, v, i, tuning.free > 0.0f).duty));
        }
    }
    lode_inverter_tuning_t none = ideal();
    const float before = none.free;
    lode_inverter_bound_current(&none, 1.0e6f); // nothing is corrected
    TEST_ASSERT_TRUE(none.free == before);
}

static void test_a_duty_is_a_number_from_0_to_1(void) {
    const float sound[] = {0.0f, 1.0e-45f, FLT_MIN, 0.5f, nextafterf(1.0f, 0.0f), 1.0f};
    const float unsound[] = {-0.0f,    -1.0e-45f, nextafterf(1.0f, 2.0f),
                             2.0f,     -1.0f,     -2.0f,
                             FLT_MAX,  -FLT_MAX,  1.0e10f,
                             INFINITY, -INFINITY, NAN,
                             -NAN};
    for (int phase = 0; phase < 3; phase++) {
        for (int n = 0; n < COUNT_OF(sound) + COUNT_OF(unsound); n++) {
            const bool good = n < COUNT_OF(sound);
            float duty[3] = {0.25f, 0.5f, 0.75f};
            duty[phase] = good ? sound[n] : unsound[n - COUNT_OF(sound)];
            TEST_ASSERT_EQUAL_INT(good,
                                  lode_modulator_is_sound((lode_abc_t){duty[0], duty[1], duty[2]}));
        }
    }
    random_t random = random_seed(7);
    for (int n = 0; n < CHECK_TRIES(200000); n++) {
        const float x = random_any(&random);
        TEST_ASSERT_EQUAL_INT(lode_in_range(x, 0.0f, 1.0f) && !signbit(x),
                              lode_modulator_is_sound((lode_abc_t){0.5f, x, 0.0f}));
    }
}

static void test_a_loss_that_leaves_no_room_leaves_no_fast_path(void) {
    // A board of 24 V whose bus has gone: the drops alone are more than half of the least bus. With
    // the bus, the circle of the current control is gone too: what it asks for is 0.
    const lode_inverter_config_t config = {.v_bus_V = 24.0f,
                                           .i_max_A = 12.0f,
                                           .dead_time_s = 4.0e-6f,
                                           .v_drop_V = 1.3f,
                                           .i_dead_A = 0.5f,
                                           .dead_time_correction = LODE_ON,
                                           .dead_time_model = LODE_OFF};
    lode_inverter_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_inverter_tune(&tuning, &config, PAPER_TS_s));
    for (int n = 0; n < 360; n++) {
        const lode_ab_t i = vector(10.0, n * CHECK_PI / 180.0);
        TEST_ASSERT_TRUE(inside(modulated(&tuning, (lode_ab_t){0.0f, 0.0f}, 0.0f, i).duty));
    }
}

static void test_the_fast_path_is_as_long_as_the_loss_leaves(void) {
    // Each rail keeps the largest loss free: 1 - 2 loss of the circle, but for a thousandth.
    const lode_inverter_tuning_t none = ideal();
    CHECK_CLOSE(1.1e-3, 1.0 / sqrt(3.0), none.free);
    const lode_inverter_tuning_t on = inverter(4.0e-6f, 0.0f, LODE_ON, LODE_OFF);
    const double more = 1.5e-6 / PAPER_TS_s; // that the start may find
    const double loss = 0.02 + more + 1.0 / (double)on.v_min_V;
    CHECK_CLOSE(1.1e-3, (1.0 - 2.0 * loss) / sqrt(3.0), on.free);
    // The timer's grid takes nothing: a duty inside the range stays there.
    TEST_ASSERT_TRUE(inverter(4.0e-6f, 8400.0f, LODE_ON, LODE_OFF).free == on.free);
    // With the model what the motor sees is never what was asked for.
    TEST_ASSERT_TRUE(inverter(4.0e-6f, 0.0f, LODE_OFF, LODE_ON).free < 0.0f);
}

static void test_the_fast_path_gives_what_the_limit_gives(void) {
    lode_inverter_tuning_t tunings[20];
    const int count = plain_inverters(tunings, COUNT_OF(tunings));
    random_t random = random_seed(6);
    int fast = 0;
    for (int t = 0; t < count; t++) {
        lode_inverter_tuning_t limit = tunings[t];
        limit.free = -1.0f;
        for (int n = 0; n < 10000; n++) {
            const float bus = random_float(&random, 150.0, 250.0);
            const lode_ab_t u =
                vector(random_between(&random, 0.0, 1.2) * free_length(&tunings[t], (double)bus),
                       random_between(&random, 0.0, 6.3));
            const lode_ab_t i =
                vector(random_between(&random, 0.0, 20.0), random_between(&random, 0.0, 6.3));
            const lode_modulator_out_t one = modulated(&tunings[t], u, bus, i);
            const lode_modulator_out_t two = modulated(&limit, u, bus, i);
            TEST_ASSERT_EQUAL_MEMORY(&two.duty, &one.duty, sizeof one.duty);
            // The way through the duties and back rounds a few times.
            CHECK_NEAR(4.0e-7, two.realised.alpha, one.realised.alpha);
            CHECK_NEAR(4.0e-7, two.realised.beta, one.realised.beta);
            fast +=
                lode_ab_length(u) < 0.99f * (float)free_length(&tunings[t], (double)bus) ? 1 : 0;
        }
    }
    CHECK_AT_LEAST(0.7 * 10000.0 * count, fast); // the comparison was not one of equal paths
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_duties_are_those_of_space_vectors);
    RUN_TEST(test_line_to_line_voltages_are_exact_up_to_the_circle);
    RUN_TEST(test_nothing_asked_for_is_half_on);
    RUN_TEST(test_beyond_the_hexagon_realised_says_what_is_left);
    RUN_TEST(test_duties_lie_on_the_grid);
    RUN_TEST(test_correction_adds_the_loss_and_realised_leaves_it_out);
    RUN_TEST(test_correction_at_the_rail_is_lost_and_realised_says_so);
    RUN_TEST(test_the_model_takes_the_loss_out_of_realised_only);
    RUN_TEST(test_a_low_bus_is_not_divided_by);
    RUN_TEST(test_any_input_gives_duties);
    RUN_TEST(test_scale_of_bus_and_voltage_alike_changes_nothing);
    RUN_TEST(test_no_duty_of_the_fast_path_leaves_its_range);
    RUN_TEST(test_rounding_at_large_currents_leaves_duties_in_range);
    RUN_TEST(test_a_duty_is_a_number_from_0_to_1);
    RUN_TEST(test_a_loss_that_leaves_no_room_leaves_no_fast_path);
    RUN_TEST(test_the_fast_path_is_as_long_as_the_loss_leaves);
    RUN_TEST(test_the_fast_path_gives_what_the_limit_gives);
    return UNITY_END();
}
