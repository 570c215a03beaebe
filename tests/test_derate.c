// Derating by temperature and by the heat of the winding.
#include "support/fields.h"
#include "support/rig.h"

#include "lodestar/derate.h"

void setUp(void) {}

void tearDown(void) {}

static const lode_derate_config_t sound = {
    .i_max_A = 12.0f, .i_continuous_A = 6.0f, .winding_s = 20.0f, .to_degC = 100.0f};

static lode_derate_tuning_t tuned(void) {
    lode_derate_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_derate_tune(&tuning, &sound));
    return tuning;
}

static lode_telemetry_t at(float current_A, float temperature_degC) {
    return (lode_telemetry_t){.i_A = {-0.6f * current_A, 0.8f * current_A},
                              .temperature_degC = temperature_degC};
}

static void test_bad_configurations_are_refused(void) {
    const lode_derate_tuning_t before = tuned();
    lode_derate_tuning_t tuning = before;
    lode_derate_config_t bad[9];
    for (int n = 0; n < COUNT_OF(bad); n++) {
        bad[n] = sound;
    }
    bad[0].i_max_A = 0.0f;
    bad[1].i_continuous_A = 12.1f;
    bad[2].i_continuous_A = -1.0f;
    bad[3].winding_s = 0.05f;
    bad[4].winding_s = NAN;
    bad[5].to_degC = 301.0f;
    bad[6].from_degC = 99.5f;
    bad[7].from_degC = NAN;
    bad[8].i_max_A = NAN;
    for (int n = 0; n < COUNT_OF(bad); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_DERATE, lode_derate_tune(&tuning, &bad[n]));
    }
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_derate_tune(NULL, &sound));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_derate_tune(&tuning, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof before);
}

static void test_the_winding_heats_up_to_its_continuous_current(void) {
    const lode_derate_tuning_t tuning = tuned();
    lode_derate_t derate;
    lode_derate_reset(&derate, 0.0f);
    // i_max from cold: h = 4 (1 - exp(-t/20 s)) reaches 0.9 after 5.1 s.
    double first_s = 0.0;
    float share = 1.0f;
    for (int n = 1; n <= 3000; n++) {
        const lode_telemetry_t now = at(12.0f * share, 25.0f);
        share = lode_derate_step(&derate, &tuning, &now, 0.1f);
        if (!(first_s > 0.0) && share < 1.0f) {
            first_s = 0.1 * n;
        }
    }
    CHECK_NEAR(0.15, 5.1, first_s);
    CHECK_NEAR(0.005, 0.5, (double)share); // i_continuous, and there it stays
    CHECK_NEAR(0.005, 1.0, (double)derate.heat);
    // It cools with the same time constant.
    const lode_telemetry_t idle = at(0.0f, 25.0f);
    for (int n = 0; n < 200; n++) {
        share = lode_derate_step(&derate, &tuning, &idle, 0.1f);
    }
    CHECK_NEAR(0.005, 0.368, (double)derate.heat);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, share);
}

/// (D3). With reluctance torque the current goes with a root of the torque, and a bias of id stays: the continuous heat is
/// exceeded by less than a tenth, without oscillation.
static void test_a_current_that_falls_less_than_the_torque_heats_little_more(void) {
    const lode_derate_tuning_t tuning = tuned();
    const struct {
        double exponent, bias_A;
    } cases[] = {{0.5, 0.0}, {0.7, 0.0}, {1.0, 4.0}, {1.0, 5.9}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        lode_derate_t derate;
        lode_derate_reset(&derate, 0.0f);
        double share = 1.0;
        float heat = 0.0f;
        float most = 0.0f;
        for (int k = 0; k < 6000; k++) {
            const double iq_A = 12.0 * pow(share, cases[n].exponent);
            const lode_telemetry_t now = at((float)hypot(iq_A, cases[n].bias_A), 25.0f);
            heat = derate.heat;
            share = (double)lode_derate_step(&derate, &tuning, &now, 0.1f);
            most = derate.heat > most ? derate.heat : most;
        }
        CHECK_AT_MOST(1.1, (double)most);
        CHECK_NEAR(1.0e-5, (double)heat, (double)derate.heat); // and at rest
        // Where it stays is where the current of the share heats as much.
        const double iq_A = 12.0 * pow(share, cases[n].exponent);
        const double load = (iq_A * iq_A + cases[n].bias_A * cases[n].bias_A) / 36.0;
        CHECK_NEAR(1.0e-3, load, (double)derate.heat);
        CHECK_NEAR(1.0e-3, 0.5 * (1.1 - (double)derate.heat) / 0.1, share);
    }
}

static void test_the_share_over_the_heat(void) {
    const lode_derate_tuning_t tuning = tuned();
    const float heats[] = {0.0f, 0.9f, 0.95f, 1.0f, 1.05f, 1.1f, 4.0f};
    const double shares[] = {1.0, 1.0, 0.75, 0.5, 0.25, 0.0, 0.0};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        lode_derate_t derate;
        lode_derate_reset(&derate, heats[n]);
        const lode_telemetry_t now = at(1.0f, 25.0f);
        CHECK_NEAR(1.0e-5, shares[n], (double)lode_derate_step(&derate, &tuning, &now, 0.0f));
    }
}

/// A slow winding and a fast caller: what a call adds is less than the last digit of the heat.
static void test_a_slow_winding_heats_up_in_fast_calls(void) {
    lode_derate_tuning_t tuning = tuned();
    tuning.winding_s = 1.0e4f;
    lode_derate_t derate;
    lode_derate_reset(&derate, 0.9f);
    const lode_telemetry_t now = at(1.04f * 6.0f, 25.0f);
    for (int n = 0; n < 100000; n++) {
        (void)lode_derate_step(&derate, &tuning, &now, 1.0e-3f);
    }
    const double load = 1.04 * 1.04;
    CHECK_NEAR(2.0e-5, load - (load - 0.9) * exp(-0.01), (double)derate.heat);
}

/// In FAULT the current that is told is that of the trip, and none flows; with all low sides on there is one of up to `i_max`.
static void test_a_trip_heats_no_winding(void) {
    const lode_derate_tuning_t tuning = tuned();
    for (int shorted = 0; shorted <= 1; shorted++) {
        lode_derate_t derate;
        lode_derate_reset(&derate, 0.3f);
        lode_telemetry_t tripped = at(36.0f, 25.0f);
        tripped.mode = LODE_MODE_FAULT;
        tripped.shorted = shorted == 1;
        for (int n = 0; n < 100; n++) {
            (void)lode_derate_step(&derate, &tuning, &tripped, 0.1f);
        }
        // i_max is twice what may flow for good.
        const double load = shorted == 1 ? 4.0 : 0.0;
        CHECK_NEAR(0.001, load + (0.3 - load) * exp(-10.0 / (double)tuning.winding_s),
                   (double)derate.heat);
    }
}

static void test_a_hot_power_stage_has_less_torque(void) {
    const lode_derate_tuning_t tuning = tuned();
    const float temperatures[] = {25.0f, 80.0f, 90.0f, 100.0f, 140.0f};
    const double shares[] = {1.0, 1.0, 0.5, 0.0, 0.0};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        lode_derate_t derate;
        lode_derate_reset(&derate, 0.0f);
        const lode_telemetry_t now = at(1.0f, temperatures[n]);
        CHECK_NEAR(1.0e-6, shares[n], (double)lode_derate_step(&derate, &tuning, &now, 0.1f));
    }
}

static void test_what_is_no_number_counts_as_hot(void) {
    const lode_derate_tuning_t tuning = tuned();
    lode_derate_t derate;
    lode_derate_reset(&derate, 0.0f);
    const lode_telemetry_t blind = at(1.0f, NAN);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_derate_step(&derate, &tuning, &blind, 0.1f));
    const lode_telemetry_t wild = at(NAN, 25.0f);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_derate_step(&derate, &tuning, &wild, 0.1f));
    TEST_ASSERT_TRUE(lode_is_finite(derate.heat));
    derate.heat = -2.0f; // memory that has changed
    CHECK_NEAR(1.0e-6, 1.0,
               (double)lode_derate_step(&derate, &tuning,
                                        &(lode_telemetry_t){.mode = LODE_MODE_OFF}, 1.0e-3f));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, derate.heat);
    lode_derate_reset(&derate, NAN);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, derate.heat);
    const lode_telemetry_t back = at(0.0f, 25.0f);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, lode_derate_step(&derate, &tuning, &back, -0.1f));
}

/// With plain references, and with those of more than i_d* = 0.
static void test_a_drive_keeps_to_its_share(void) {
    static lode_drive_tuning_t tuning;
    lode_drive_config_t config = rig_config();
    rig_t rig;
    for (int weakens = 0; weakens <= 1; weakens++) {
        config.references.field_weakening = weakens != 0 ? LODE_ON : LODE_OFF;
        rig_init(&rig, &tuning, &config);
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 60.0f});
        rig_run(&rig, 4.0);
        rig_expect(&rig, LODE_MODE_RUN);
        lode_drive_limit_torque(&rig.drive, 0.25f);
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 150.0f});
        rig_run(&rig, 0.2);
        const double most = (double)lode_references_most_Nm(&tuning.references);
        CHECK_NEAR(0.02 * most, 0.25 * most, (double)rig_telemetry(&rig).torque_ref_Nm);
        TEST_ASSERT_TRUE(rig_telemetry(&rig).torque_limited);
    }
    // Any number will do, to the nearest part.
    const float shares[] = {NAN, -1.0f, 2.0f, 0.3f, 0.7f};
    const uint32_t taken[] = {0u, 0u, LODE_TORQUE_SHARE_ONE | LODE_TORQUE_SHARE_PARITY, 9831u,
                              22938u};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        lode_drive_limit_torque(&rig.drive, shares[n]);
        TEST_ASSERT_EQUAL_UINT32(taken[n], rig.drive.torque_share[0]);
        TEST_ASSERT_EQUAL_UINT32(taken[n], rig.drive.torque_share[1]);
    }
}

static lode_status_t try_config(const lode_derate_config_t *config) {
    const lode_derate_tuning_t before = tuned();
    lode_derate_tuning_t tuning = before;
    const lode_status_t status = lode_derate_tune(&tuning, config);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof before);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_derate_config_t config = sound;
    field_set(&config, offset, value);
    return try_config(&config);
}

static void test_every_field_at_its_limits(void) {
    static const field_t fields[] = {
        {FIELD(lode_derate_config_t, i_continuous_A), .lo = 1.0e-3f * 12.0f, .hi = 12.0f,
         .error = LODE_ERROR_DERATE},
        {FIELD(lode_derate_config_t, winding_s), .lo = 0.1f, .hi = 1.0e5f,
         .error = LODE_ERROR_DERATE},
        {FIELD(lode_derate_config_t, to_degC), .lo = -40.0f, .hi = 300.0f,
         .error = LODE_ERROR_DERATE},
        {FIELD(lode_derate_config_t, from_degC), .lo = -100.0f, .hi = 99.0f,
         .error = LODE_ERROR_DERATE},
    };
    field_check_all(fields, COUNT_OF(fields), try_one);
    const float currents[] = {1.0e-3f, 1.0e5f, nextafterf(1.0e-3f, 0.0f),
                              nextafterf(1.0e5f, INFINITY)};
    for (int k = 0; k < COUNT_OF(currents); k++) {
        lode_derate_config_t config = sound;
        config.i_max_A = currents[k];
        config.i_continuous_A = 0.5f * currents[k];
        TEST_ASSERT_EQUAL_INT(k < 2 ? LODE_OK : LODE_ERROR_DERATE, try_config(&config));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_the_winding_heats_up_to_its_continuous_current);
    RUN_TEST(test_a_current_that_falls_less_than_the_torque_heats_little_more);
    RUN_TEST(test_the_share_over_the_heat);
    RUN_TEST(test_a_slow_winding_heats_up_in_fast_calls);
    RUN_TEST(test_a_trip_heats_no_winding);
    RUN_TEST(test_a_hot_power_stage_has_less_torque);
    RUN_TEST(test_what_is_no_number_counts_as_hot);
    RUN_TEST(test_a_drive_keeps_to_its_share);
    RUN_TEST(test_every_field_at_its_limits);
    return UNITY_END();
}
