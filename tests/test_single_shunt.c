// One shunt in the DC link: where the edges and the samples lie, and what becomes of them.
#include "lodestar/single_shunt.h"
#include "support/check.h"

#define F_PWM 20000.0
#define WINDOW_s 4.0e-6
#define SAMPLE_s 0.5e-6
#define GAIN_A 0.01
#define ZERO 2048
#define V_BUS 24.0
#define INDUCTANCE_H 0.5e-3

void setUp(void) {}

void tearDown(void) {}

static lode_single_shunt_config_t sound(void) {
    return (lode_single_shunt_config_t){.f_pwm_Hz = (float)F_PWM,
                                        .i_gain_A_count = (float)GAIN_A,
                                        .window_s = (float)WINDOW_s,
                                        .sample_s = (float)SAMPLE_s,
                                        .L_H = 0.0f};
}

static lode_single_shunt_tuning_t tuned(const lode_single_shunt_config_t *config) {
    lode_single_shunt_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_single_shunt_tune(&tuning, config));
    return tuning;
}

static void expect_refused(lode_single_shunt_config_t config, lode_status_t status) {
    lode_single_shunt_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(status, lode_single_shunt_tune(&tuning, &config));
}

static void test_refusals(void) {
    static const float windows_s[] = {-1.0e-6f, 13.0e-6f}, samples_s[] = {-1.0e-7f, 5.0e-6f};
    static const float gains[] = {0.0f, (float)NAN, 2.0e4f, -2.0e4f};
    static const float inductances_H[] = {-1.0f, 100.0f, (float)NAN};
    lode_single_shunt_config_t config = sound();
    for (int n = 0; n < COUNT_OF(windows_s); n++) {
        config.window_s = windows_s[n];
        expect_refused(config, LODE_ERROR_SENSE_WINDOW);
    }
    config = sound();
    for (int n = 0; n < COUNT_OF(samples_s); n++) {
        config.sample_s = samples_s[n];
        expect_refused(config, LODE_ERROR_SENSE_WINDOW);
    }
    config = sound();
    for (int n = 0; n < COUNT_OF(gains); n++) {
        config.i_gain_A_count = gains[n];
        expect_refused(config, LODE_ERROR_SENSE_CURRENT);
    }
    config = sound();
    for (int n = 0; n < COUNT_OF(inductances_H); n++) {
        config.L_H = inductances_H[n];
        expect_refused(config, LODE_ERROR_SENSE_CURRENT);
    }
}

static void test_voltage_use(void) {
    lode_single_shunt_config_t config = sound();
    config.window_s = 6.0e-6f;
    lode_single_shunt_tuning_t tuning = tuned(&config);
    CHECK_CLOSE(1e-5, (0.5 - 6.0e-6 * F_PWM) / (sqrt(3.0) / 4.0),
                lode_single_shunt_voltage_use(&tuning));
    config.window_s = 1.0e-6f;
    tuning = tuned(&config);
    CHECK_CLOSE(1e-6, 0.95, lode_single_shunt_voltage_use(&tuning));
}

static void by_phase(lode_abc_t x, double out[3]) {
    out[0] = (double)x.a;
    out[1] = (double)x.b;
    out[2] = (double)x.c;
}

// The mean stays, both halves can be made, and each sample stands at the end of its vector, which lasts for
// the window at least.
static void expect_plan(const lode_single_shunt_plan_t *plan, lode_abc_t duty) {
    double rise[3], fall[3], d[3];
    by_phase(plan->rise, rise);
    by_phase(plan->fall, fall);
    by_phase(duty, d);
    const int middle = 3 - plan->most - plan->least;
    TEST_ASSERT_TRUE(middle != plan->most && middle != plan->least && plan->most != plan->least);
    TEST_ASSERT_TRUE(d[plan->most] >= d[middle] && d[middle] >= d[plan->least]);
    for (int x = 0; x < 3; x++) {
        CHECK_NEAR(1e-6, d[x], 0.5 * (rise[x] + fall[x]));
        CHECK_AT_LEAST(0.0, rise[x]);
        CHECK_AT_LEAST(0.0, fall[x]);
        CHECK_AT_MOST(1.000001, rise[x]);
        CHECK_AT_MOST(1.000001, fall[x]);
    }
    if (!plan->blind) {
        CHECK_AT_LEAST(2.0 * WINDOW_s * F_PWM - 1e-6, fall[middle] - fall[plan->least]);
        CHECK_AT_LEAST(2.0 * WINDOW_s * F_PWM - 1e-6, fall[plan->most] - fall[middle]);
        CHECK_NEAR(1e-6, 0.5 * (1.0 + fall[middle]) - SAMPLE_s * F_PWM, plan->sample[0]);
        CHECK_NEAR(1e-6, 0.5 * (1.0 + fall[plan->most]) - SAMPLE_s * F_PWM, plan->sample[1]);
    }
}

static void test_edges(void) {
    const lode_single_shunt_config_t config = sound();
    const lode_single_shunt_tuning_t tuning = tuned(&config);
    static const lode_abc_t duties[] = {{0.5f, 0.5f, 0.5f}, {0.9f, 0.5f, 0.1f}, {0.9f, 0.1f, 0.5f},
                                        {0.5f, 0.9f, 0.1f}, {0.1f, 0.9f, 0.5f}, {0.5f, 0.1f, 0.9f},
                                        {0.1f, 0.5f, 0.9f}, {0.7f, 0.7f, 0.3f}, {0.7f, 0.3f, 0.7f},
                                        {0.3f, 0.7f, 0.7f}, {0.3f, 0.3f, 0.7f}, {0.3f, 0.7f, 0.3f},
                                        {0.7f, 0.3f, 0.3f}};
    lode_single_shunt_t shunt;
    lode_single_shunt_reset(&shunt);
    for (int n = 0; n < COUNT_OF(duties); n++) {
        const lode_single_shunt_plan_t plan =
            lode_single_shunt_write(&shunt, &tuning, duties[n], LODE_GATES_ON);
        TEST_ASSERT_FALSE(plan.blind);
        expect_plan(&plan, duties[n]);
    }
    random_t random = random_seed(3);
    int blind = 0;
    for (int n = 0; n < 20000; n++) {
        const lode_abc_t duty = {random_float(&random, 0.0, 1.0), random_float(&random, 0.0, 1.0),
                                 random_float(&random, 0.0, 1.0)};
        const lode_single_shunt_plan_t plan =
            lode_single_shunt_write(&shunt, &tuning, duty, LODE_GATES_ON);
        expect_plan(&plan, duty);
        blind += plan.blind ? 1 : 0;
    }
    TEST_ASSERT_TRUE(blind > 0 && blind < 10000);
    // A wide pulse leaves its edges alone.
    const lode_single_shunt_plan_t wide =
        lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.8f, 0.5f, 0.2f}, LODE_GATES_ON);
    CHECK_NEAR(1e-6, 0.8, wide.fall.a);
    CHECK_NEAR(1e-6, 0.5, wide.rise.b);
}

/// Near either end of the period the edge in the middle gives way to the others.
static void test_duties_near_the_ends_are_seen(void) {
    const lode_single_shunt_config_t config = sound();
    const lode_single_shunt_tuning_t tuning = tuned(&config);
    static const lode_abc_t duties[] = {{0.95f, 0.9f, 0.8f}, {0.2f, 0.1f, 0.05f}};
    lode_single_shunt_t shunt;
    memset(&shunt, 0xff, sizeof shunt);
    lode_single_shunt_reset(&shunt);
    for (int x = 0; x < 3; x++) {
        TEST_ASSERT_EQUAL_UINT16(0u, shunt.count[x]);
    }
    for (int n = 0; n < COUNT_OF(duties); n++) {
        const lode_single_shunt_plan_t plan =
            lode_single_shunt_write(&shunt, &tuning, duties[n], LODE_GATES_ON);
        TEST_ASSERT_FALSE(plan.blind);
        expect_plan(&plan, duties[n]);
    }
}

// What the link carries at the two instants, from the phase currents.
static void link_of(const lode_single_shunt_plan_t *plan, const double i_A[3], double gain,
                    uint16_t link[2]) {
    link[0] = (uint16_t)(ZERO - floor(i_A[plan->least] / gain + 0.5));
    link[1] = (uint16_t)(ZERO + floor(i_A[plan->most] / gain + 0.5));
}

static void test_currents(void) {
    const double gains[] = {GAIN_A, -GAIN_A};
    const double i_A[3] = {5.0, -3.0, -2.0};
    static const lode_abc_t duties[] = {{0.2f, 0.6f, 0.4f}, {0.2f, 0.4f, 0.6f}, {0.4f, 0.2f, 0.6f},
                                        {0.4f, 0.6f, 0.2f}, {0.6f, 0.2f, 0.4f}, {0.6f, 0.4f, 0.2f}};
    for (int g = 0; g < 2 * COUNT_OF(duties); g++) {
        lode_single_shunt_config_t config = sound();
        config.i_gain_A_count = (float)gains[g % 2];
        const lode_single_shunt_tuning_t tuning = tuned(&config);
        lode_single_shunt_t shunt;
        lode_single_shunt_reset(&shunt);
        const lode_single_shunt_plan_t plan =
            lode_single_shunt_write(&shunt, &tuning, duties[g / 2], LODE_GATES_ON);
        (void)lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.9f, 0.1f, 0.5f},
                                      LODE_GATES_ON);
        uint16_t link[2], count[3];
        link_of(&plan, i_A, gains[g % 2], link);
        lode_single_shunt_read(&shunt, &tuning, link, ZERO * LODE_COUNT_FRACTION, (float)V_BUS,
                               count);
        for (int x = 0; x < 3; x++) { // of the period that ends, not of the one that begins
            CHECK_NEAR(1.0, (double)ZERO + i_A[x] / gains[g % 2], count[x]);
        }
    }
}

// A phase voltage beyond its mean moves the current until t_k.
static void test_samples_are_brought_to_the_start_of_the_period(void) {
    lode_single_shunt_config_t config = sound();
    config.L_H = (float)INDUCTANCE_H;
    const lode_single_shunt_tuning_t tuning = tuned(&config);
    lode_single_shunt_t shunt;
    lode_single_shunt_reset(&shunt);
    const double d[3] = {0.8, 0.5, 0.2};
    const lode_single_shunt_plan_t plan =
        lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.8f, 0.5f, 0.2f}, LODE_GATES_ON);
    (void)lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.8f, 0.5f, 0.2f}, LODE_GATES_ON);
    // In steps: the phase's voltage from the switches, less its mean.
    const int steps = 100000;
    double moved[2] = {0.0, 0.0};
    for (int n = 0; n < steps; n++) {
        const double at = (n + 0.5) / steps;
        double high[3], mean = 0.0;
        for (int x = 0; x < 3; x++) {
            high[x] = fabs(at - 0.5) < 0.5 * d[x] ? 1.0 : 0.0;
            mean += high[x] / 3.0;
        }
        const double step = V_BUS / F_PWM / INDUCTANCE_H / steps;
        moved[0] += at > (double)plan.sample[0] ? step * (high[2] - mean - (d[2] - 0.5)) : 0.0;
        moved[1] += at > (double)plan.sample[1] ? step * (high[0] - mean - (d[0] - 0.5)) : 0.0;
    }
    const uint16_t link[2] = {ZERO, ZERO};
    uint16_t count[3];
    lode_single_shunt_read(&shunt, &tuning, link, ZERO * LODE_COUNT_FRACTION, (float)V_BUS, count);
    CHECK_NEAR(0.6, (double)ZERO + moved[0] / GAIN_A, count[2]);
    CHECK_NEAR(0.6, (double)ZERO + moved[1] / GAIN_A, count[0]);
    TEST_ASSERT_TRUE(fabs(moved[1]) > 5.0 * GAIN_A);
}

static void test_gates_off_shows_the_offset_in_all_three(void) {
    const lode_single_shunt_config_t config = sound();
    const lode_single_shunt_tuning_t tuning = tuned(&config);
    static const lode_gates_t gates[] = {LODE_GATES_OFF, LODE_GATES_LOW};
    for (int g = 0; g < COUNT_OF(gates); g++) {
        lode_single_shunt_t shunt;
        lode_single_shunt_reset(&shunt);
        const lode_abc_t duty = {0.9f, 0.5f, 0.1f};
        (void)lode_single_shunt_write(&shunt, &tuning, duty, LODE_GATES_ON);
        const lode_single_shunt_plan_t plan = // at once, whatever was planned for this period
            lode_single_shunt_write(&shunt, &tuning, duty, gates[g]);
        TEST_ASSERT_FALSE(plan.driven);
        CHECK_CLOSE(1e-6, 0.9, plan.rise.a);
        CHECK_CLOSE(1e-6, 0.9, plan.fall.a);
        CHECK_AT_LEAST((double)plan.sample[0], plan.sample[1]);
        CHECK_AT_MOST(1.0, plan.sample[1]);
        CHECK_CLOSE(1e-6, 0.5, plan.sample[0]); // triggers that no other call moves
        CHECK_CLOSE(1e-6, 1.0 - SAMPLE_s * F_PWM, plan.sample[1]);
        const uint16_t link[2] = {2000, 2010};
        uint16_t count[3];
        lode_single_shunt_read(&shunt, &tuning, link, 0, (float)V_BUS, count);
        for (int x = 0; x < 3; x++) {
            TEST_ASSERT_EQUAL_UINT16(2010, count[x]);
        }
    }
}

static void test_blind_periods_keep_the_last_counts(void) {
    const lode_single_shunt_config_t config = sound();
    const lode_single_shunt_tuning_t tuning = tuned(&config);
    lode_single_shunt_t shunt;
    lode_single_shunt_reset(&shunt);
    const uint16_t link[2] = {2100, 2300};
    uint16_t first[3], then[3];
    (void)lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.9f, 0.5f, 0.1f}, LODE_GATES_ON);
    TEST_ASSERT_TRUE(
        lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){1.0f, 1.0f, 0.0f}, LODE_GATES_ON)
            .blind);
    lode_single_shunt_read(&shunt, &tuning, link, ZERO * LODE_COUNT_FRACTION, (float)V_BUS, first);
    (void)lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.9f, 0.5f, 0.1f}, LODE_GATES_ON);
    const uint16_t nonsense[2] = {0, 4095};
    lode_single_shunt_read(&shunt, &tuning, nonsense, ZERO * LODE_COUNT_FRACTION, (float)V_BUS,
                           then);
    TEST_ASSERT_EQUAL_UINT16_ARRAY(first, then, 3);
}

// Counts stay counts, whatever the ADC delivers.
static void test_counts_stay_in_range(void) {
    const lode_single_shunt_config_t config = sound();
    const lode_single_shunt_tuning_t tuning = tuned(&config);
    lode_single_shunt_t shunt;
    lode_single_shunt_reset(&shunt);
    (void)lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.9f, 0.5f, 0.1f}, LODE_GATES_ON);
    (void)lode_single_shunt_write(&shunt, &tuning, (lode_abc_t){0.9f, 0.5f, 0.1f}, LODE_GATES_ON);
    const uint16_t link[2] = {65535, 65535};
    uint16_t count[3];
    lode_single_shunt_read(&shunt, &tuning, link, 0, (float)V_BUS, count);
    TEST_ASSERT_EQUAL_UINT16(65535, count[0]);
    TEST_ASSERT_EQUAL_UINT16(0, count[2]);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_refusals);
    RUN_TEST(test_voltage_use);
    RUN_TEST(test_edges);
    RUN_TEST(test_duties_near_the_ends_are_seen);
    RUN_TEST(test_currents);
    RUN_TEST(test_samples_are_brought_to_the_start_of_the_period);
    RUN_TEST(test_gates_off_shows_the_offset_in_all_three);
    RUN_TEST(test_blind_periods_keep_the_last_counts);
    RUN_TEST(test_counts_stay_in_range);
    return UNITY_END();
}
