// From torque to currents: inverse of the torque equation, circle, low-speed bias.
#include "support/fields.h"

#include "lodestar/references.h"

void setUp(void) {}

void tearDown(void) {}

#define I_MAX_A 12.0f

static const lode_inverter_config_t inverter = {.v_bus_V = 200.0f, .i_max_A = I_MAX_A};

static lode_references_config_t sound(void) {
    return (lode_references_config_t){
        .id_bias_A = 3.0f, .omega_low_rad_s = 60.0f, .omega_high_rad_s = 110.0f};
}

static lode_references_tuning_t tuned(const lode_references_config_t *config) {
    const lode_motor_t motor = paper_motor();
    lode_references_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_references_tune(&tuning, config, &inverter, &motor));
    return tuning;
}

/// Eq. (17) for Table 3's motor.
static double torque_of(double id, double iq) {
    return 4.5 * (0.142 + (3.5e-3 - 9.8e-3) * id) * iq;
}

static void test_at_speed_id_is_zero(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        const lode_dq_t i = lode_references_step(&tuning, 5.0f * (float)sign, 300.0f, 0.0f);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, i.d);
        CHECK_CLOSE(1.0e-6, sign * 5.0 / 0.639, i.q);
    }
}

static void test_bias_fades_with_speed(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    const double table[][2] = {{0.0, -3.0},   {60.0, -3.0}, {85.0, -1.5},
                               {100.0, -0.6}, {110.0, 0.0}, {500.0, 0.0}};
    for (int i = 0; i < COUNT_OF(table); i++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const float omega = (float)(sign * table[i][0]);
            const lode_dq_t ref = lode_references_step(&tuning, 2.0f, omega, 0.0f);
            CHECK_NEAR(2.0e-6, table[i][1], ref.d);
            // The torque stays what was asked for, with the reluctance torque of the bias.
            CHECK_NEAR(2.0e-6, 2.0, torque_of((double)ref.d, (double)ref.q));
        }
    }
}

static void test_no_bias(void) {
    lode_references_config_t config = sound();
    config.id_bias_A = LODE_NONE;
    const lode_references_tuning_t tuning = tuned(&config);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_references_step(&tuning, 2.0f, 0.0f, 0.0f).d);
}

static void test_start_current_is_added_to_d(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    CHECK_NEAR(1.0e-6, 4.5, lode_references_step(&tuning, 2.0f, 300.0f, 4.5f).d);
    CHECK_NEAR(1.0e-6, 1.5, lode_references_step(&tuning, 2.0f, 10.0f, 4.5f).d);
    const lode_dq_t i = lode_references_step(&tuning, -1.0f, 300.0f, 4.5f);
    CHECK_NEAR(2.0e-6, -1.0, torque_of((double)i.d, (double)i.q));
}

static void test_circle_holds_with_d_first(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    random_t random = random_seed(1);
    for (int n = 0; n < CHECK_TRIES(100000); n++) {
        const float torque = random_float(&random, -30.0, 30.0);
        const float omega = random_float(&random, -200.0, 200.0);
        const float add = random_float(&random, -15.0, 15.0);
        const lode_dq_t i = lode_references_step(&tuning, torque, omega, add);
        const double speed = fabs((double)omega);
        const double share = fmax(0.0, fmin(1.0, (110.0 - speed) / 50.0));
        const double id = fmax(-12.0, fmin(12.0, (double)add - 3.0 * share));
        CHECK_NEAR(5.0e-6, id, i.d);
        CHECK_AT_MOST(12.0 * (1.0 + 1.0e-6), hypot((double)i.d, (double)i.q));
        TEST_ASSERT_TRUE(i.q * torque >= 0.0f);
    }
}

static void test_limit_of_torque(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    CHECK_NEAR(1.0e-5, 12.0, lode_references_step(&tuning, 100.0f, 300.0f, 0.0f).q);
    CHECK_NEAR(1.0e-5, -12.0, lode_references_step(&tuning, -100.0f, -300.0f, 0.0f).q);
    CHECK_NEAR(1.0e-5, sqrt(144.0 - 9.0), lode_references_step(&tuning, 100.0f, 0.0f, 0.0f).q);
    CHECK_NEAR(0.01, 0.0, lode_references_step(&tuning, 100.0f, 300.0f, 20.0f).q);
}

static void test_torque_is_the_inverse(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    random_t random = random_seed(2);
    for (int n = 0; n < 10000; n++) {
        // Inside the circle for every id from -5 to 5 A.
        const float torque = random_float(&random, -5.0, 5.0);
        const lode_dq_t i =
            lode_references_step(&tuning, torque, random_float(&random, -200.0, 200.0),
                                 random_float(&random, -2.0, 5.0));
        CHECK_NEAR(1.0e-5, torque, lode_references_torque_Nm(&tuning, i));
        CHECK_NEAR(1.0e-5, torque_of((double)i.d, (double)i.q),
                   lode_references_torque_Nm(&tuning, i));
    }
}

static void test_any_input_stays_in_the_circle(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    random_t random = random_seed(3);
    for (int n = 0; n < CHECK_TRIES(300000); n++) {
        const lode_dq_t i = lode_references_step(&tuning, random_any(&random), random_any(&random),
                                                 random_any(&random));
        CHECK_AT_MOST(12.0 * (1.0 + 1.0e-6), hypot((double)i.d, (double)i.q));
    }
}

static lode_status_t try_one(size_t offset, float value) {
    lode_references_config_t config = sound();
    field_set(&config, offset, value);
    const lode_motor_t motor = paper_motor();
    lode_references_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_references_tuning_t before = tuning;
    const lode_status_t status = lode_references_tune(&tuning, &config, &inverter, &motor);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static void test_every_field_at_its_limits(void) {
    const size_t bias = offsetof(lode_references_config_t, id_bias_A);
    const size_t low = offsetof(lode_references_config_t, omega_low_rad_s);
    const size_t high = offsetof(lode_references_config_t, omega_high_rad_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(bias, LODE_NONE));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(bias, 0.0f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(bias, I_MAX_A));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(bias, nextafterf(I_MAX_A, INFINITY)));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(low, 109.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(low, 110.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(low, 111.0f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(high, 61.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(high, 60.0f));
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(bias, check_not_finite[i]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(low, check_not_finite[i]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(high, check_not_finite[i]));
    }
}

static void test_design_fills_what_is_open(void) {
    const lode_motor_t motor = paper_motor();
    lode_references_config_t config = {.id_bias_A = 0.0f};
    lode_references_design(&config, &inverter, &motor);
    CHECK_CLOSE(1.0e-6, 0.25 * 12.0, config.id_bias_A);
    CHECK_CLOSE(1.0e-6, 0.2 * PAPER_OMEGA_RATED, config.omega_low_rad_s);
    CHECK_CLOSE(1.0e-6, 0.4 * PAPER_OMEGA_RATED, config.omega_high_rad_s);
    const lode_references_config_t all = sound();
    lode_references_config_t kept = all;
    lode_references_design(&kept, &inverter, &motor);
    TEST_ASSERT_EQUAL_MEMORY(&all, &kept, sizeof all);
    lode_references_config_t none = {.id_bias_A = LODE_NONE};
    lode_references_design(&none, &inverter, &motor);
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, none.id_bias_A);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_at_speed_id_is_zero);
    RUN_TEST(test_bias_fades_with_speed);
    RUN_TEST(test_no_bias);
    RUN_TEST(test_start_current_is_added_to_d);
    RUN_TEST(test_circle_holds_with_d_first);
    RUN_TEST(test_limit_of_torque);
    RUN_TEST(test_torque_is_the_inverse);
    RUN_TEST(test_any_input_stays_in_the_circle);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_design_fills_what_is_open);
    return UNITY_END();
}
