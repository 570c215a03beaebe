// Both sets' duties against the three-phase modulator, and the voltage that both planes see of them.
#include "support/check.h"
#include "support/vsd6.h"

#include "modulator6_inline.h"

void setUp(void) {}

void tearDown(void) {}

#define V_BUS 300.0f
#define TS_s 1.0e-4f

static lode_inverter_tuning_t inverter(float dead_time_s, float ticks) {
    lode_inverter_config_t config = {
        .v_bus_V = V_BUS, .i_max_A = 15.0f, .dead_time_s = dead_time_s, .pwm_ticks = ticks};
    const lode_motor_t motor = {.Ld_H = 6.4e-3f, .Lq_H = 17.4e-3f};
    lode_inverter_tuning_t tuning;
    lode_inverter_design(&config, &motor, TS_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_inverter_tune(&tuning, &config, TS_s));
    return tuning;
}

static lode_ab_t vector(double length, double angle) {
    return (lode_ab_t){(float)(length * cos(angle)), (float)(length * sin(angle))};
}

/// The voltage that six legs make, written out phase by phase.
static vsd6_t made_of(const lode_abc6_t *duty) {
    const vsd6_t v = vsd6(duty);
    return (vsd6_t){.ab = lode_ab_scale(V_BUS, v.ab), .xy = lode_ab_scale(V_BUS, v.xy)};
}

static const lode_ab_t no_current = {0.0f, 0.0f};
static const lode_dead_time_t no_dead_time = {0.0f, 1.0f};

/// Volts to the share of the bus that the modulator takes.
static lode_sets_t per_volt(lode_sets_t u) {
    return (lode_sets_t){
        {lode_ab_scale(1.0f / V_BUS, u.set[0]), lode_ab_scale(1.0f / V_BUS, u.set[1])}};
}

static void test_both_planes_get_what_was_asked(void) {
    const lode_inverter_tuning_t tuning = inverter(0.0f, 0.0f);
    for (int n = 0; n < 720; n++) {
        const lode_ab_t ab = vector(140.0, n * CHECK_PI / 360.0);
        const lode_ab_t xy = vector(20.0, 1.0 - 5.0 * n * CHECK_PI / 360.0);
        const lode_modulator6_out_t out = lode_modulator6_step(
            &tuning, &no_dead_time, per_volt(lode_vsd_sets(ab, xy)), no_current,
            n % 2 == 0); // 160 V of 173 V: either way does
        const vsd6_t made = made_of(&out.duty);
        // 1e-6 of the bus.
        CHECK_NEAR(3.0e-4, ab.alpha, made.ab.alpha);
        CHECK_NEAR(3.0e-4, ab.beta, made.ab.beta);
        CHECK_NEAR(3.0e-4, xy.alpha, made.xy.alpha);
        CHECK_NEAR(3.0e-4, xy.beta, made.xy.beta);
        CHECK_NEAR(3.0e-4, xy.alpha, V_BUS * lode_vsd_xy(out.realised).alpha);
        CHECK_NEAR(3.0e-4, ab.beta, V_BUS * lode_vsd_ab(out.realised).beta);
    }
}

static void test_beyond_the_hexagon_realised_is_what_the_duties_make(void) {
    const lode_inverter_tuning_t tuning = inverter(0.0f, 0.0f);
    random_t random = random_seed(3);
    for (int n = 0; n < 2000; n++) {
        const lode_sets_t u = {
            {{random_float(&random, -400.0, 400.0), random_float(&random, -400.0, 400.0)},
             {random_float(&random, -400.0, 400.0), random_float(&random, -400.0, 400.0)}}};
        const lode_modulator6_out_t out =
            lode_modulator6_step(&tuning, &no_dead_time, per_volt(u), no_current, false);
        const vsd6_t made = made_of(&out.duty);
        CHECK_NEAR(6.0e-4, made.ab.alpha, V_BUS * lode_vsd_ab(out.realised).alpha);
        CHECK_NEAR(6.0e-4, made.ab.beta, V_BUS * lode_vsd_ab(out.realised).beta);
        CHECK_NEAR(6.0e-4, made.xy.alpha, V_BUS * lode_vsd_xy(out.realised).alpha);
        CHECK_NEAR(6.0e-4, made.xy.beta, V_BUS * lode_vsd_xy(out.realised).beta);
        for (int set = 0; set < LODE_SETS; set++) {
            TEST_ASSERT_TRUE(lode_in_range(out.duty.set[set].a, 0.0f, 1.0f));
            TEST_ASSERT_TRUE(lode_in_range(out.duty.set[set].b, 0.0f, 1.0f));
            TEST_ASSERT_TRUE(lode_in_range(out.duty.set[set].c, 0.0f, 1.0f));
        }
    }
}

static void test_all_six_legs_are_corrected(void) {
    const float dead = 2.0e-6f;
    const lode_inverter_tuning_t tuning = inverter(dead, 0.0f);
    const lode_dead_time_t dead_time = lode_inverter_dead_time(&tuning, 0.0f, 0.5f, 1.0f / V_BUS);
    const lode_ab_t u = vector(100.0, 0.4);
    const lode_ab_t i = vector(8.0, 0.9); // every phase of both sets well beyond the dead band
    const lode_sets_t v = per_volt((lode_sets_t){{u, u}});
    const lode_modulator6_out_t plain =
        lode_modulator6_step(&tuning, &dead_time, v, no_current, true);
    const lode_modulator6_out_t out = lode_modulator6_step(&tuning, &dead_time, v, i, true);
    static const double axis[6] = {0.0, 120.0, 240.0, 30.0, 150.0, 270.0};
    const double loss = (double)(dead / TS_s);
    for (int n = 0; n < 6; n++) {
        const double current = 8.0 * cos(0.9 - axis[n] * CHECK_DEG);
        const lode_abc_t before = plain.duty.set[n / 3];
        const lode_abc_t after = out.duty.set[n / 3];
        const double added[3] = {(double)(after.a - before.a), (double)(after.b - before.b),
                                 (double)(after.c - before.c)};
        CHECK_NEAR(1.0e-6, current > 0.0 ? loss : -loss, added[n % 3]);
    }
    // The motor sees what was asked.
    CHECK_NEAR(3.0e-4, u.alpha, V_BUS * lode_vsd_ab(out.realised).alpha);
    CHECK_NEAR(3.0e-4, 0.0, V_BUS * lode_vsd_xy(out.realised).beta);
}

static void test_any_voltage_gives_duties(void) {
    const lode_inverter_tuning_t tuning = inverter(0.0f, 1000.0f);
    random_t random = random_seed(4);
    for (int n = 0; n < 20000; n++) {
        const lode_sets_t v = {{{random_any(&random), random_any(&random)},
                                {random_any(&random), random_any(&random)}}};
        const lode_modulator6_out_t out =
            lode_modulator6_step(&tuning, &no_dead_time, v, no_current, false);
        TEST_ASSERT_TRUE(lode_modulator_is_sound(out.duty.set[0]));
        TEST_ASSERT_TRUE(lode_modulator_is_sound(out.duty.set[1]));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_both_planes_get_what_was_asked);
    RUN_TEST(test_beyond_the_hexagon_realised_is_what_the_duties_make);
    RUN_TEST(test_all_six_legs_are_corrected);
    RUN_TEST(test_any_voltage_gives_duties);
    return UNITY_END();
}
