// Limits of the current out of the supply, and back into it.
#include "support/rig.h"

#include "lodestar/supply.h"

void setUp(void) {}

void tearDown(void) {}

#define STEP_s 1.0e-3f

static const lode_supply_config_t sound = {.battery_A = 4.0f, .regen_A = 2.0f, .correct_s = 0.1f};

// The paper's motor, with switches that take something.
static lode_drive_config_t drive_config(void) {
    lode_drive_config_t config = rig_config();
    config.inverter.v_drop_V = 1.0f;
    config.inverter.r_on_Ohm = 0.05f;
    return config;
}

static lode_supply_tuning_t tuned(const lode_supply_config_t *config) {
    const lode_drive_config_t drive = drive_config();
    lode_supply_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supply_tune(&tuning, config, &drive));
    return tuning;
}

static void test_bad_configurations_are_refused(void) {
    const lode_drive_config_t drive = drive_config();
    const lode_supply_tuning_t before = tuned(&sound);
    lode_supply_tuning_t tuning = before;
    lode_supply_config_t bad[8];
    for (int n = 0; n < COUNT_OF(bad); n++) {
        bad[n] = sound;
    }
    bad[0].battery_A = -1.0f;
    bad[1].battery_A = NAN;
    bad[2].battery_A = 2.0e5f;
    bad[3].regen_A = -2.0f;
    bad[4].regen_A = NAN;
    bad[5].regen_A = 2.0e5f;
    bad[6].correct_s = 0.5e-3f;
    bad[7].correct_s = NAN;
    for (int n = 0; n < COUNT_OF(bad); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPPLY, lode_supply_tune(&tuning, &bad[n], &drive));
    }
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_supply_tune(NULL, &sound, &drive));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_supply_tune(&tuning, NULL, &drive));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_supply_tune(&tuning, &sound, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof before);
}

static lode_telemetry_t at(float omega_rad_s, lode_dq_t i_A) {
    return (lode_telemetry_t){.mode = LODE_MODE_RUN,
                              .v_bus_V = 200.0f,
                              .omega_rad_s = omega_rad_s,
                              .i_A = i_A,
                              .ref_A = i_A,
                              .torque_most_Nm = 10.0f};
}

static void test_voltages_and_currents_tell_the_current(void) {
    const lode_supply_tuning_t tuning = tuned(&sound);
    lode_telemetry_t now = at(300.0f, (lode_dq_t){-3.0f, 4.0f});
    now.u_V = (lode_dq_t){-20.0f, 60.0f};
    // 1.5 (60 + 240) W in the motor, 6/pi V A in the switches at 5 A.
    const double power_W = 450.0 + 6.0 / CHECK_PI * 5.0;
    const lode_mode_t on[] = {LODE_MODE_RUN, LODE_MODE_START, LODE_MODE_CURRENT, LODE_MODE_VOLTAGE};
    for (int n = 0; n < COUNT_OF(on); n++) {
        now.mode = on[n];
        CHECK_NEAR(1.0e-5, power_W / 200.0, (double)lode_supply_current_A(&tuning, &now));
    }
    const lode_mode_t off[] = {LODE_MODE_OFF, LODE_MODE_CALIBRATE, LODE_MODE_PRECHARGE,
                               LODE_MODE_FAULT};
    for (int n = 0; n < COUNT_OF(off); n++) {
        now.mode = off[n]; // FAULT keeps what was there when it tripped
        TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_supply_current_A(&tuning, &now));
    }
    now.mode = LODE_MODE_RUN;
    now.v_bus_V = 0.5f;
    CHECK_NEAR(1.0e-2, power_W / 0.5, (double)lode_supply_current_A(&tuning, &now));
    now.v_bus_V = 0.0f;
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_supply_current_A(&tuning, &now));
}

/// Switches of 0.25 V take a quarter of that.
static void test_the_drop_counts(void) {
    lode_drive_config_t drive = drive_config();
    const lode_telemetry_t now = at(0.0f, (lode_dq_t){-3.0f, 4.0f}); // no voltage of the motor's
    lode_supply_tuning_t tuning;
    drive.inverter.v_drop_V = 0.25f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supply_tune(&tuning, &sound, &drive));
    CHECK_NEAR(1.0e-6, 0.25 * 6.0 / CHECK_PI * 5.0 / 200.0,
               (double)lode_supply_current_A(&tuning, &now));
}

static void test_two_windings_draw_twice_as_much(void) {
    lode_drive_config_t drive = drive_config();
    drive.motor.sets = 2.0f;
    lode_supply_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supply_tune(&tuning, &sound, &drive));
    const lode_supply_tuning_t one = tuned(&sound);
    lode_telemetry_t now = at(300.0f, (lode_dq_t){-3.0f, 4.0f});
    now.u_V = (lode_dq_t){-20.0f, 60.0f};
    CHECK_NEAR(1.0e-5, 2.0 * (double)lode_supply_current_A(&one, &now),
               (double)lode_supply_current_A(&tuning, &now));
}

// Shares without correction: the current is at neither limit.
static lode_shares_t shares(const lode_supply_tuning_t *tuning, const lode_telemetry_t *now) {
    lode_supply_t supply;
    lode_supply_reset(&supply);
    return lode_supply_step(&supply, tuning, now, 0.0f, STEP_s);
}

// Power at the supply, of a torque at the mechanical speed `omega`, with `id`; positive: drawn.
static double power_W(double torque_Nm, double omega, double id) {
    const double active = 0.142 + (3.5e-3 - 9.8e-3) * id;
    const double iq = torque_Nm / (4.5 * active);
    return torque_Nm * omega + 1.5 * (0.75 + 0.05) * (id * id + iq * iq);
}

static void test_the_torque_allowed_draws_the_limit(void) {
    const lode_supply_tuning_t tuning = tuned(&sound);
    const double id = -2.0;
    const double drop_W = 6.0 / CHECK_PI * 2.0;
    for (int sign = -1; sign <= 1; sign += 2) { // either sense of rotation
        const lode_telemetry_t now = at((float)sign * 3.0f * 120.0f, (lode_dq_t){(float)id, 0.0f});
        const lode_shares_t share = shares(&tuning, &now);
        CHECK_NEAR(0.5, 800.0 - drop_W, power_W(10.0 * (double)share.motoring, 120.0, id));
        CHECK_NEAR(0.5, -400.0 - drop_W, power_W(-10.0 * (double)share.braking, 120.0, id));
    }
    // At rest a battery feeds the winding.
    const lode_telemetry_t rest = at(0.0f, (lode_dq_t){0.0f, 0.0f});
    lode_supply_config_t little = sound;
    little.battery_A = 0.5f;
    const lode_supply_tuning_t small = tuned(&little);
    CHECK_NEAR(0.5, 100.0, power_W(10.0 * (double)shares(&small, &rest).motoring, 0.0, 0.0));
    // Slowly turning, the winding takes all that braking gives.
    const lode_telemetry_t slow = at(3.0f * 5.0f, (lode_dq_t){0.0f, 0.0f});
    TEST_ASSERT_EQUAL_FLOAT(1.0f, shares(&tuning, &slow).braking);
}

static void test_a_side_without_limit_is_free(void) {
    const lode_telemetry_t now = at(900.0f, (lode_dq_t){0.0f, 0.0f});
    const lode_supply_config_t none = {.battery_A = 0.0f};
    const lode_supply_tuning_t free = tuned(&none);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, shares(&free, &now).motoring);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, shares(&free, &now).braking);
    // Nothing goes back: what the d axis loses can be braked with, and without it nothing.
    const lode_supply_config_t nothing = {.regen_A = LODE_NONE};
    const lode_supply_tuning_t closed = tuned(&nothing);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, shares(&closed, &now).motoring);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shares(&closed, &now).braking);
    const lode_telemetry_t weakened = at(900.0f, (lode_dq_t){-6.0f, 0.0f});
    CHECK_NEAR(0.1, -6.0 / CHECK_PI * 6.0,
               power_W(-10.0 * (double)shares(&closed, &weakened).braking, 300.0, -6.0));
    // Nor is there torque where the d axis alone draws the limit.
    lode_supply_config_t little = sound;
    little.battery_A = 0.1f;
    const lode_supply_tuning_t small = tuned(&little);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shares(&small, &weakened).motoring);
    const lode_telemetry_t rest = at(0.0f, (lode_dq_t){-6.0f, 0.0f});
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shares(&small, &rest).motoring);
    // A current that leaves no active flux is bounded all the same.
    const lode_supply_tuning_t usual = tuned(&sound);
    const lode_telemetry_t odd = at(900.0f, (lode_dq_t){22.0f, 0.0f});
    TEST_ASSERT_TRUE(shares(&usual, &odd).motoring < 0.3f);
}

/// (L8). A load is held at rest although nothing may go back: the winding takes what braking gives there. It is let go where a
/// good part of the torque would give more.
static void test_a_held_load_is_not_let_go(void) {
    const lode_supply_config_t nothing = {.regen_A = LODE_NONE};
    const lode_supply_tuning_t closed = tuned(&nothing);
    const double c = 1.5 * 0.8 / (4.5 * 0.142 * 4.5 * 0.142); // W/Nm^2
    const struct {
        double braked_Nm; // by the current that flows
        double beyond_Nm; // torque from which braking takes power, of 10 Nm
        float share;
    } cases[] = {
        {0.0, 0.0, 1.0f}, {0.0, 4.9, 1.0f}, {0.0, 5.1, 0.0f},  {4.0, 4.9, 1.0f},
        {8.0, 7.9, 1.0f}, {8.0, 8.1, 0.0f}, {-8.0, 7.9, 0.0f},
    };
    for (int n = 0; n < COUNT_OF(cases); n++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const float omega = (float)(sign * 3.0 * c * cases[n].beyond_Nm);
            const float iq_A = (float)(-sign * cases[n].braked_Nm / (4.5 * 0.142));
            const lode_telemetry_t now = at(omega, (lode_dq_t){0.0f, iq_A});
            lode_supply_tuning_t without_drop = closed;
            without_drop.drop_V = 0.0f;
            TEST_ASSERT_EQUAL_FLOAT(cases[n].share, shares(&without_drop, &now).braking);
        }
    }
    // With a current that may go back, from where the torque takes more again: 6 Nm, of which 5.4 Nm is the other root.
    const lode_supply_tuning_t usual = tuned(&sound);
    const double rest_W = 0.9 * c * 36.0;
    lode_supply_tuning_t some = usual;
    some.drop_V = 0.0f;
    some.limit_A[LODE_SUPPLY_FED_BACK] = (float)(rest_W / 200.0);
    const double omega = 6.0 * c + rest_W / 6.0; // (L2) at 6 Nm
    lode_telemetry_t now = at((float)(3.0 * omega), (lode_dq_t){0.0f, 0.0f});
    CHECK_NEAR(1.0e-3, rest_W / c / 6.0 / 10.0, (double)shares(&some, &now).braking);
    now.i_A.q = (float)(-6.01 / (4.5 * 0.142));
    TEST_ASSERT_EQUAL_FLOAT(1.0f, shares(&some, &now).braking);
}

static void test_before_RUN_the_torque_of_i_max_counts(void) {
    const lode_supply_tuning_t tuning = tuned(&sound);
    lode_telemetry_t now = at(360.0f, (lode_dq_t){0.0f, 0.0f});
    const double in_run = (double)shares(&tuning, &now).motoring;
    now.torque_most_Nm = 0.0f;
    CHECK_NEAR(1.0e-4, in_run * 10.0 / (4.5 * 0.142 * 12.0),
               (double)shares(&tuning, &now).motoring);
}

/// The torque that a drive gives at most may be small.
static void test_the_share_of_a_small_torque(void) {
    lode_supply_config_t little = sound;
    little.battery_A = 0.05f;
    const lode_supply_tuning_t tuning = tuned(&little);
    lode_telemetry_t now = at(360.0f, (lode_dq_t){0.0f, 0.0f});
    now.torque_most_Nm = 0.5f;
    const double share = (double)shares(&tuning, &now).motoring;
    CHECK_NEAR(0.05, 10.0, power_W(0.5 * share, 120.0, 0.0));
}

// The current of a motor whose torque constant is `psi` times the believed one, at the limit.
static float drawn_A(const lode_shares_t *share, double psi, bool drives) {
    const double torque = drives ? 10.0 * (double)share->motoring : -10.0 * (double)share->braking;
    return (float)(power_W(psi * torque, 120.0, 0.0) / 200.0);
}

static void test_the_current_corrects_the_model(void) {
    const lode_supply_tuning_t tuning = tuned(&sound);
    for (int drives = 0; drives <= 1; drives++) {
        lode_telemetry_t now = at(360.0f, (lode_dq_t){0.0f, drives == 1 ? 7.0f : -5.0f});
        now.torque_ref_Nm = drives == 1 ? 5.0f : -3.0f;
        now.torque_limited = true;
        const double limit_A = drives == 1 ? 4.0 : -2.0;
        const double psi[] = {0.9, 1.15};
        for (int n = 0; n < COUNT_OF(psi); n++) {
            lode_supply_t supply;
            lode_supply_reset(&supply);
            lode_shares_t share = lode_supply_step(&supply, &tuning, &now, 0.0f, STEP_s);
            for (int k = 0; k < 1000; k++) {
                share = lode_supply_step(&supply, &tuning, &now,
                                         drawn_A(&share, psi[n], drives == 1), STEP_s);
            }
            CHECK_NEAR(0.01, limit_A, (double)drawn_A(&share, psi[n], drives == 1));
        }
        // Bounded, and forgotten where the limit does not decide.
        lode_supply_t supply;
        lode_supply_reset(&supply);
        for (int k = 0; k < 1000; k++) {
            (void)lode_supply_step(&supply, &tuning, &now, 0.0f, STEP_s);
        }
        const int side = drives == 1 ? LODE_SUPPLY_DRAWN : LODE_SUPPLY_FED_BACK;
        TEST_ASSERT_EQUAL_FLOAT(1.25f, supply.factor[side]);
        now.torque_limited = false;
        for (int k = 0; k < 1000; k++) {
            (void)lode_supply_step(&supply, &tuning, &now, 0.0f, STEP_s);
        }
        CHECK_NEAR(1.0e-3, 1.0, (double)supply.factor[side]);
        // Exceeded counts in any case, and so does what is no number.
        for (int k = 0; k < 1000; k++) {
            (void)lode_supply_step(&supply, &tuning, &now, 100.0f * (drives == 1 ? 1.0f : -1.0f),
                                   STEP_s);
        }
        TEST_ASSERT_EQUAL_FLOAT(0.75f, supply.factor[side]);
        lode_supply_reset(&supply);
        (void)lode_supply_step(&supply, &tuning, &now, NAN, STEP_s);
        TEST_ASSERT_EQUAL_FLOAT(0.75f, supply.factor[side]);
        // Just the limit, which does not decide: forgotten too.
        const float at_limit_A = drives == 1 ? 4.0f : -2.0f;
        for (int k = 0; k < 1000; k++) {
            (void)lode_supply_step(&supply, &tuning, &now, at_limit_A, STEP_s);
        }
        CHECK_NEAR(1.0e-3, 1.0, (double)supply.factor[side]);
    }
}

/// Current control is there when it is off by a twentieth at most, and the smallest torque has a way.
static void test_a_current_that_is_nearly_there_corrects(void) {
    const lode_supply_tuning_t tuning = tuned(&sound);
    for (int n = 0; n < 2; n++) {
        lode_telemetry_t now = at(360.0f, (lode_dq_t){0.0f, 7.0f});
        now.i_A.q = n == 0 ? 6.7f : 7.0f;
        now.torque_ref_Nm = n == 0 ? 5.0f : 0.002f;
        now.torque_limited = true;
        lode_supply_t supply;
        lode_supply_reset(&supply);
        for (int k = 0; k < 10; k++) {
            (void)lode_supply_step(&supply, &tuning, &now, 1.0f, STEP_s);
        }
        TEST_ASSERT_TRUE(supply.factor[LODE_SUPPLY_DRAWN] > 1.01f);
    }
}

// The current tells nothing of the model while it is not that of the limit.
static void test_a_current_on_its_way_corrects_nothing(void) {
    const lode_supply_tuning_t tuning = tuned(&sound);
    lode_telemetry_t now[5];
    for (int n = 0; n < COUNT_OF(now); n++) {
        now[n] = at(360.0f, (lode_dq_t){0.0f, 7.0f});
        now[n].torque_ref_Nm = 5.0f;
        now[n].torque_limited = true;
    }
    now[0].i_A.q = 6.0f;          // current control is not there yet
    now[1].torque_ref_Nm = -3.0f; // braking
    now[2].torque_limited = false;
    now[3].omega_rad_s = 30.0f; // full torque draws less
    now[4].torque_ref_Nm = 0.0f;
    for (int n = 0; n < COUNT_OF(now); n++) {
        lode_supply_t supply;
        lode_supply_reset(&supply);
        for (int k = 0; k < 10; k++) {
            (void)lode_supply_step(&supply, &tuning, &now[n], 1.0f, STEP_s);
        }
        TEST_ASSERT_EQUAL_FLOAT(1.0f, supply.factor[LODE_SUPPLY_DRAWN]);
    }
    // At rest there is no power that the limit would be reached by.
    lode_supply_config_t little = sound;
    little.battery_A = 0.5f;
    const lode_supply_tuning_t small = tuned(&little);
    now[0] = now[4];
    now[0].torque_ref_Nm = 5.0f;
    now[0].omega_rad_s = 0.0f;
    lode_supply_t supply;
    lode_supply_reset(&supply);
    for (int k = 0; k < 10; k++) {
        (void)lode_supply_step(&supply, &small, &now[0], 0.1f, STEP_s);
    }
    TEST_ASSERT_EQUAL_FLOAT(1.0f, supply.factor[LODE_SUPPLY_DRAWN]);
}

/// Either side's first call after a reset knows no limit yet that could have decided.
static void test_the_first_call_corrects_nothing(void) {
    const lode_supply_tuning_t tuning = tuned(&sound);
    for (int drives = 0; drives <= 1; drives++) {
        lode_telemetry_t now = at(360.0f, (lode_dq_t){0.0f, drives == 1 ? 7.0f : -5.0f});
        now.torque_ref_Nm = drives == 1 ? 5.0f : -3.0f;
        now.torque_limited = true;
        lode_supply_t supply;
        lode_supply_reset(&supply);
        (void)lode_supply_step(&supply, &tuning, &now, 0.0f, STEP_s);
        TEST_ASSERT_EQUAL_FLOAT(
            1.0f, supply.factor[drives == 1 ? LODE_SUPPLY_DRAWN : LODE_SUPPLY_FED_BACK]);
    }
}

// Either sense of rotation: motoring and braking torque have each their share.
static void test_a_drive_keeps_to_both_shares(void) {
    static lode_drive_tuning_t tuning;
    const lode_drive_config_t config = rig_config();
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig;
        const float way = (float)sign;
        rig_init(&rig, &tuning, &config);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, rig_telemetry(&rig).torque_most_Nm);
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = way * 60.0f});
        rig_run(&rig, 4.0);
        rig_expect(&rig, LODE_MODE_RUN);
        const double most = (double)lode_references_most_Nm(&tuning.references);
        CHECK_NEAR(0.05 * most, most, (double)rig_telemetry(&rig).torque_most_Nm);
        lode_drive_limit_torques(&rig.drive, 0.25f, 0.125f);
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = way * 150.0f});
        rig_run(&rig, 0.2);
        CHECK_NEAR(0.02 * most, (double)way * 0.25 * most,
                   (double)rig_telemetry(&rig).torque_ref_Nm);
        CHECK_NEAR(0.05 * most, most, (double)rig_telemetry(&rig).torque_most_Nm);
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = way * 40.0f});
        rig_run(&rig, 0.2);
        CHECK_NEAR(0.02 * most, (double)way * -0.125 * most,
                   (double)rig_telemetry(&rig).torque_ref_Nm);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_voltages_and_currents_tell_the_current);
    RUN_TEST(test_the_drop_counts);
    RUN_TEST(test_two_windings_draw_twice_as_much);
    RUN_TEST(test_the_torque_allowed_draws_the_limit);
    RUN_TEST(test_a_side_without_limit_is_free);
    RUN_TEST(test_a_held_load_is_not_let_go);
    RUN_TEST(test_before_RUN_the_torque_of_i_max_counts);
    RUN_TEST(test_the_share_of_a_small_torque);
    RUN_TEST(test_the_current_corrects_the_model);
    RUN_TEST(test_a_current_that_is_nearly_there_corrects);
    RUN_TEST(test_the_first_call_corrects_nothing);
    RUN_TEST(test_a_current_on_its_way_corrects_nothing);
    RUN_TEST(test_a_drive_keeps_to_both_shares);
    return UNITY_END();
}
