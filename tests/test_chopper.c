// The brake chopper's duty, and what its resistor bears.
#include "support/check.h"
#include "support/fields.h"

#include "lodestar/chopper.h"

void setUp(void) {}

void tearDown(void) {}

// 8 kW at 400 V, 500 W for ever.
static const lode_chopper_config_t sound = {.on_V = 420.0f,
                                            .full_V = 460.0f,
                                            .R_Ohm = 20.0f,
                                            .power_W = 500.0f,
                                            .thermal_s = 40.0f,
                                            .period_s = 1.0e-3f};

static lode_chopper_tuning_t tuned(void) {
    lode_chopper_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_chopper_tune(&tuning, &sound));
    return tuning;
}

static void test_bad_configurations_are_refused(void) {
    const lode_chopper_tuning_t before = tuned();
    lode_chopper_tuning_t tuning = before;
    lode_chopper_config_t bad[9];
    for (int n = 0; n < COUNT_OF(bad); n++) {
        bad[n] = sound;
    }
    bad[0].on_V = 0.5f;
    bad[1].full_V = 420.0f;
    bad[2].full_V = NAN;
    bad[3].R_Ohm = 0.0f;
    bad[4].power_W = 0.0f;
    bad[5].thermal_s = 0.0f;
    bad[6].period_s = 0.0f;
    bad[7].period_s = 0.2f;
    bad[8].on_V = NAN;
    for (int n = 0; n < COUNT_OF(bad); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOPPER, lode_chopper_tune(&tuning, &bad[n]));
    }
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_chopper_tune(NULL, &sound));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_chopper_tune(&tuning, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof before);
}

static void test_the_duty_follows_the_bus(void) {
    const lode_chopper_tuning_t tuning = tuned();
    const float bus_V[] = {-10.0f, 0.0f, 419.0f, 420.0f, 430.0f, 450.0f, 460.0f, 700.0f, NAN};
    const double duty[] = {0.0, 0.0, 0.0, 0.0, 0.25, 0.75, 1.0, 1.0, 0.0};
    for (int n = 0; n < COUNT_OF(duty); n++) {
        lode_chopper_t chopper;
        lode_chopper_reset(&chopper, 0.0f);
        CHECK_NEAR(1.0e-6, duty[n], (double)lode_chopper_step(&chopper, &tuning, bus_V[n]));
        TEST_ASSERT_TRUE(lode_is_finite(chopper.heat));
    }
}

// Runs for `seconds` at a bus voltage; the energy in the resistor.
static double burns_J(lode_chopper_t *chopper, const lode_chopper_tuning_t *tuning, double bus_V,
                      double seconds, double *duty) {
    double energy_J = 0.0;
    for (int n = 0; n < (int)(seconds * 1000.0); n++) {
        *duty = (double)lode_chopper_step(chopper, tuning, (float)bus_V);
        energy_J += 1.0e-3 * *duty * bus_V * bus_V / 20.0;
    }
    return energy_J;
}

static void test_the_resistor_is_not_overheated(void) {
    const lode_chopper_tuning_t tuning = tuned();
    lode_chopper_t chopper;
    double duty = 0.0;
    lode_chopper_reset(&chopper, 0.0f);
    // 10.58 kW at 460 V are 21.2 times what it bears: h = 21.2 (1 - exp(-t/40 s)) is 0.9 after 1.74 s.
    (void)burns_J(&chopper, &tuning, 460.0, 1.7, &duty);
    CHECK_NEAR(1.0e-6, 1.0, duty);
    (void)burns_J(&chopper, &tuning, 460.0, 0.3, &duty);
    TEST_ASSERT_TRUE(duty < 0.6);
    (void)burns_J(&chopper, &tuning, 460.0, 200.0, &duty);
    CHECK_NEAR(0.01, 1.0, (double)chopper.heat);
    CHECK_NEAR(10.0, 500.0, burns_J(&chopper, &tuning, 460.0, 1.0, &duty)); // for ever
    // What the bus asks for comes first: in the middle of the range a resistor that bears it goes on.
    lode_chopper_reset(&chopper, 1.0f);
    CHECK_NEAR(1.0e-6, 0.0, burns_J(&chopper, &tuning, 400.0, 40.0, &duty));
    CHECK_NEAR(0.005, exp(-1.0), (double)chopper.heat);
}

static void test_one_that_bears_full_duty_has_it_for_ever(void) {
    lode_chopper_config_t large = sound;
    large.power_W = 20.0e3f;
    lode_chopper_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_chopper_tune(&tuning, &large));
    lode_chopper_t chopper;
    double duty = 0.0;
    lode_chopper_reset(&chopper, 1.0f);
    (void)burns_J(&chopper, &tuning, 460.0, 1.0, &duty);
    CHECK_NEAR(1.0e-6, 1.0, duty);
}

/// A resistor that takes a quarter of an hour to get warm, and a call every 50 us: each adds less than a float of that size holds.
static void test_heat_in_small_portions_adds_up(void) {
    lode_chopper_config_t slow = sound;
    slow.thermal_s = 1000.0f;
    slow.period_s = 50.0e-6f;
    lode_chopper_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_chopper_tune(&tuning, &slow));
    lode_chopper_t chopper;
    lode_chopper_reset(&chopper, 0.85f);
    // (L6) with twice the lasting power: 0.85 + (2 - 0.85) (1 - exp(-20/1000)).
    const double on_V = sqrt(2.0 * (double)slow.power_W * (double)slow.R_Ohm);
    chopper.heat = 0.85f;
    tuning.on_V = 0.0f;
    tuning.inv_span = 1.0f;
    for (int n = 0; n < 400000; n++) {
        (void)lode_chopper_step(&chopper, &tuning, (float)on_V);
    }
    CHECK_NEAR(1.0e-4, 0.85 + 1.15 * (1.0 - exp(-0.02)), (double)chopper.heat);
}

static void test_heat_stays_bounded(void) {
    const lode_chopper_tuning_t tuning = tuned();
    lode_chopper_t chopper;
    lode_chopper_reset(&chopper, NAN);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, chopper.heat);
    lode_chopper_reset(&chopper, 100.0f);
    TEST_ASSERT_EQUAL_FLOAT(4.0f, chopper.heat);
    chopper.heat = 0.0f;
    (void)lode_chopper_step(&chopper, &tuning, 1.0e15f);
    TEST_ASSERT_TRUE(chopper.heat <= 4.0f);
    chopper.heat = 0.0f;
    (void)lode_chopper_step(&chopper, &tuning, INFINITY); // no measurement
    TEST_ASSERT_EQUAL_FLOAT(0.0f, chopper.heat);
}

/// A bad sample of the bus is forgotten: one beyond any bus hardly counts, and what limits the heat leaves nothing behind.
static void test_one_bad_sample_is_forgotten(void) {
    const lode_chopper_tuning_t tuning = tuned();
    const float bad_V[] = {1.0e15f, 3.0e21f, FLT_MAX, -3.0e21f};
    for (int n = 0; n < COUNT_OF(bad_V); n++) {
        lode_chopper_t chopper;
        lode_chopper_reset(&chopper, 0.0f);
        (void)lode_chopper_step(&chopper, &tuning, bad_V[n]);
        // That of 4 kV: 16e6/(20 500) times the weight of a call.
        CHECK_NEAR(1.0e-4, bad_V[n] > 0.0f ? 1600.0 * 1.0e-3 / 40.0 : 0.0, (double)chopper.heat);
        CHECK_NEAR(1.0e-6, 1.0, (double)lode_chopper_step(&chopper, &tuning, 460.0f));
    }
    // A resistor too small by far: the heat ends at its limit, and cools from there.
    lode_chopper_config_t small = sound;
    small.R_Ohm = 1.0e-3f;
    small.power_W = 1.0e-3f;
    lode_chopper_tuning_t weak;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_chopper_tune(&weak, &small));
    lode_chopper_t chopper;
    lode_chopper_reset(&chopper, 0.7f);
    (void)lode_chopper_step(&chopper, &weak, 460.0f);
    TEST_ASSERT_EQUAL_FLOAT(4.0f, chopper.heat);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, chopper.rest);
    // Memory that has changed.
    chopper.heat = -2.0f;
    (void)lode_chopper_step(&chopper, &tuning, 0.0f);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, chopper.heat);
    chopper.heat = NAN;
    (void)lode_chopper_step(&chopper, &tuning, 0.0f);
    TEST_ASSERT_EQUAL_FLOAT(4.0f, chopper.heat);
    chopper.rest = NAN;
    (void)lode_chopper_step(&chopper, &tuning, 0.0f);
    TEST_ASSERT_EQUAL_FLOAT(4.0f, chopper.heat);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, chopper.rest);
}

static lode_status_t try_config(const lode_chopper_config_t *config) {
    const lode_chopper_tuning_t before = tuned();
    lode_chopper_tuning_t tuning = before;
    const lode_status_t status = lode_chopper_tune(&tuning, config);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof before);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_chopper_config_t config = sound;
    field_set(&config, offset, value);
    return try_config(&config);
}

static void test_every_field_at_its_limits(void) {
    static const field_t fields[] = {
        {FIELD(lode_chopper_config_t, R_Ohm), .lo = 1.0e-3f, .hi = 1.0e5f,
         .error = LODE_ERROR_CHOPPER},
        {FIELD(lode_chopper_config_t, power_W), .lo = 1.0e-3f, .hi = 1.0e7f,
         .error = LODE_ERROR_CHOPPER},
        {FIELD(lode_chopper_config_t, thermal_s), .lo = 1.0e-2f, .hi = 1.0e5f,
         .error = LODE_ERROR_CHOPPER},
        {FIELD(lode_chopper_config_t, period_s), .lo = 1.0e-6f, .hi = 0.1f,
         .error = LODE_ERROR_CHOPPER},
    };
    field_check_all(fields, COUNT_OF(fields), try_one);
    // Where it begins, and over which span.
    const struct {
        float on_V, full_V;
        bool good;
    } spans[] = {{1.0f, 2.0f, true},           {0.999f, 2.0f, false},
                 {2.0e3f, 2.001e3f, true},     {2.001e3f, 2.002e3f, false},
                 {1.0f, 1.0f + 1.0e-3f, true}, {1.0f, 1.0009f, false},
                 {1.0f, 2.001e3f, true},       {1.0f, 2.002e3f, false}};
    for (int n = 0; n < COUNT_OF(spans); n++) {
        lode_chopper_config_t config = sound;
        config.on_V = spans[n].on_V;
        config.full_V = spans[n].full_V;
        TEST_ASSERT_EQUAL_INT(spans[n].good ? LODE_OK : LODE_ERROR_CHOPPER, try_config(&config));
    }
}

/// A resistor that is hot bears what it bears for ever, and the share between falls over the last tenth of its heat.
static void test_a_hot_resistor_has_its_lasting_power(void) {
    const lode_chopper_tuning_t tuning = tuned();
    const double load = 460.0 * 460.0 / 20.0 / 500.0; // times what it bears
    const struct {
        float heat;
        double duty;
    } cases[] = {{0.5f, 1.0},
                 {0.9f, 1.0},
                 {0.95f, 0.5 + 0.5 / load},
                 {1.0f, 1.0 / load},
                 {2.0f, 1.0 / load}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        lode_chopper_t chopper;
        lode_chopper_reset(&chopper, cases[n].heat);
        CHECK_NEAR(1.0e-5, cases[n].duty, lode_chopper_step(&chopper, &tuning, 460.0f));
    }
    // A bus that is no number heats nothing.
    lode_chopper_t chopper;
    lode_chopper_reset(&chopper, 0.5f);
    (void)lode_chopper_step(&chopper, &tuning, NAN);
    CHECK_NEAR(1.0e-6, 0.5 * exp(-1.0e-3 / 40.0), chopper.heat);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_the_duty_follows_the_bus);
    RUN_TEST(test_the_resistor_is_not_overheated);
    RUN_TEST(test_one_that_bears_full_duty_has_it_for_ever);
    RUN_TEST(test_heat_in_small_portions_adds_up);
    RUN_TEST(test_heat_stays_bounded);
    RUN_TEST(test_one_bad_sample_is_forgotten);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_a_hot_resistor_has_its_lasting_power);
    return UNITY_END();
}
