// Open phases are found in two electrical periods, and sound ones are left alone.
#include "support/check.h"

#include "open_phase_inline.h"

void setUp(void) {}

void tearDown(void) {}

#define TS_s 1.0e-4

#define COUNT_A (0.0125 / 256.0) // of the currents that are noted
static const lode_open_phase_tuning_t tuning = {.i_min = (float)(0.45 / COUNT_A)}; // 3 % of 15 A

typedef struct {
    double amplitude_A; ///< of alpha-beta
    double noise_A;
    double offset_A; ///< of every phase
    int open;        ///< phase without current, 1 .. 6; 7, 8: a whole set
    double omega;    ///< electrical
    double theta;
    lode_open_phase_watch_t watch;
    random_t random;
} scene_t;

static scene_t scene(double amplitude_A, double omega, int open) {
    scene_t s = {
        .amplitude_A = amplitude_A, .omega = omega, .open = open, .random = random_seed(5)};
    lode_open_phase_reset(&s.watch);
    return s;
}

static bool is_open(const scene_t *s, int phase) {
    return s->open == phase + 1 || (s->open == 7 && phase < 3) || (s->open == 8 && phase >= 3);
}

static lode_open_phase_t step(scene_t *s) {
    static const double axis[6] = {0.0, 120.0, 240.0, 30.0, 150.0, 270.0};
    int32_t i[6];
    for (int n = 0; n < 6; n++) {
        const double sound = s->amplitude_A * cos(s->theta + 1.7 - axis[n] * CHECK_DEG);
        const double i_A = (is_open(s, n) ? 0.0 : sound) + s->offset_A +
                           s->noise_A * random_between(&s->random, -1.0, 1.0);
        i[n] = (int32_t)(i_A / COUNT_A);
    }
    s->theta = remainder(s->theta + s->omega * TS_s, 2.0 * CHECK_PI);
    lode_open_phase_note(&s->watch, &i[0], &i[3]);
    return lode_open_phase_step(&s->watch, &tuning, (float)sin(s->theta));
}

/// Electrical periods until something is found, at most `periods`; what is found in `open`.
static double found_after(scene_t *s, double periods, lode_open_phase_t *open) {
    const double period_s = 2.0 * CHECK_PI / fabs(s->omega);
    *open = 0u;
    for (int n = 1; n <= (int)(periods * period_s / TS_s); n++) {
        *open = step(s);
        if (*open > 0u) {
            return n * TS_s / period_s;
        }
    }
    return periods;
}

static void test_every_phase_is_found_within_three_periods(void) {
    const double omegas[] = {30.0, 157.0, 314.0, 1500.0, -157.0, -1500.0};
    for (int w = 0; w < COUNT_OF(omegas); w++) {
        for (int phase = 1; phase <= 8; phase++) {
            scene_t s = scene(5.0, omegas[w], 0);
            lode_open_phase_t open;
            (void)found_after(&s, 3.3, &open);
            s.open = phase;
            s.noise_A = 0.1;
            s.offset_A = 0.1;
            CHECK_AT_MOST(3.0, found_after(&s, 10.0, &open));
            TEST_ASSERT_EQUAL_INT(phase, open);
            TEST_ASSERT_EQUAL_INT(phase <= 3 || phase == 7 ? 0 : 1, lode_open_phase_set(open));
        }
    }
}

static void test_faster_than_the_samples_it_takes_longer(void) {
    scene_t s = scene(5.0, 6000.0, 2); // ten samples a period
    lode_open_phase_t open;
    CHECK_AT_MOST(8.0, found_after(&s, 20.0, &open));
    TEST_ASSERT_EQUAL_INT(2, open);
}

static void test_sound_phases_are_left_alone(void) {
    const double omegas[] = {30.0, 314.0, 1500.0};
    for (int w = 0; w < COUNT_OF(omegas); w++) {
        scene_t s = scene(5.0, omegas[w], 0);
        s.noise_A = 1.0;
        s.offset_A = 0.3;
        lode_open_phase_t open;
        (void)found_after(&s, 1000.0, &open);
        TEST_ASSERT_EQUAL_INT(0, open);
    }
}

/// Held at an angle where phase a1 carries nothing.
static void test_a_rotor_at_rest_has_no_periods(void) {
    const int32_t one[3] = {0, 100000, -100000};
    const int32_t two[3] = {50000, 50000, -100000};
    random_t random = random_seed(7);
    lode_open_phase_watch_t watch;
    lode_open_phase_reset(&watch);
    for (int n = 0; n < 100000; n++) {
        lode_open_phase_note(&watch, one, two);
        const float sine = random_float(&random, -0.4, 0.4);
        TEST_ASSERT_EQUAL_INT(0, lode_open_phase_step(&watch, &tuning, sine));
    }
}

static void test_without_current_nothing_is_said(void) {
    scene_t s = scene(0.3, 314.0, 4); // 0.19 A on average
    s.noise_A = 0.1;
    lode_open_phase_t open;
    (void)found_after(&s, 1000.0, &open);
    TEST_ASSERT_EQUAL_INT(0, open);
}

/// Judged is a current whose mean magnitude, 2/pi of its amplitude, is the least one or more.
static void test_currents_from_the_least_one_on_are_judged(void) {
    const double least_A = 0.45 * CHECK_PI / 2.0;
    for (int phase = 1; phase <= 8; phase++) {
        for (int above = 0; above <= 1; above++) {
            scene_t s = scene((above == 1 ? 1.08 : 0.92) * least_A, 157.0, phase);
            lode_open_phase_t open;
            (void)found_after(&s, 20.0, &open);
            TEST_ASSERT_EQUAL_INT(above == 1 ? phase : 0, open);
        }
    }
}

/// A period of 16 samples is one to judge by, of 15 it takes two.
static void test_sixteen_samples_are_enough(void) {
    for (int samples = 15; samples <= 16; samples++) {
        scene_t s = scene(5.0, 2.0 * CHECK_PI / (samples * TS_s), 0);
        lode_open_phase_t open;
        (void)found_after(&s, 7.5, &open);
        s.open = 5;
        const double periods = found_after(&s, 20.0, &open);
        TEST_ASSERT_EQUAL_INT(5, open);
        CHECK_AT_LEAST(samples == 16 ? 1.0 : 3.1, periods);
        CHECK_AT_MOST(samples == 16 ? 3.0 : 6.0, periods);
    }
}

static void test_the_sets_take_turns(void) {
    const int32_t one[3] = {1, -2, 3};
    const int32_t two[3] = {-10, 20, -30};
    lode_open_phase_watch_t watch;
    lode_open_phase_reset(&watch);
    for (int n = 0; n < 5; n++) {
        lode_open_phase_note(&watch, one, two);
    }
    CHECK_NEAR(0.0, 3.0, watch.sum.set[0].a);
    CHECK_NEAR(0.0, 6.0, watch.sum.set[0].b);
    CHECK_NEAR(0.0, 9.0, watch.sum.set[0].c);
    CHECK_NEAR(0.0, 20.0, watch.sum.set[1].a);
    CHECK_NEAR(0.0, 40.0, watch.sum.set[1].b);
    CHECK_NEAR(0.0, 60.0, watch.sum.set[1].c);
}

static void test_each_period_is_counted_by_itself(void) {
    const double omega = 314.0;
    const int period = (int)(2.0 * CHECK_PI / omega / TS_s);
    scene_t s = scene(5.0, omega, 0);
    for (int n = 0; n < 10 * period; n++) {
        (void)step(&s);
        CHECK_AT_MOST(n < 2 * period ? period * 13 / 12 + 2 : period + 2, s.watch.samples);
    }
}

static void test_one_period_is_not_enough(void) {
    scene_t s = scene(5.0, 314.0, 0);
    for (int n = 0; n < 100; n++) {
        s.open = n % 2 == 0 ? 3 : 0; // sound in every second period
        lode_open_phase_t open;
        (void)found_after(&s, 1.0, &open);
        TEST_ASSERT_EQUAL_INT(0, open);
    }
}

static void test_whatever_the_counts_the_answer_is_a_phase(void) {
    lode_open_phase_watch_t watch;
    lode_open_phase_reset(&watch);
    // Further than 16-bit converters reach, and no sine.
    const int32_t set_1[3] = {INT32_MAX, INT32_MIN, 0};
    const int32_t set_2[3] = {INT32_MIN, INT32_MIN, INT32_MAX};
    for (int n = 0; n < 1000; n++) {
        lode_open_phase_note(&watch, set_1, set_2);
        const lode_open_phase_t open =
            lode_open_phase_step(&watch, &tuning, n % 50 < 25 ? 1.0f : -1.0f);
        CHECK_AT_MOST(8.0, open);
    }
}

/// What two electrical periods make of these sums over twenty samples, ten of either set.
static lode_open_phase_t judged(lode_abc_t set_1, lode_abc_t set_2) {
    const lode_open_phase_tuning_t ten = {.i_min = 10.0f};
    lode_open_phase_watch_t watch;
    lode_open_phase_reset(&watch);
    lode_open_phase_t open = 0u;
    for (int n = 0; n < 2; n++) {
        watch.sum = (lode_abc6_t){{set_1, set_2}};
        watch.samples = 20u;
        open = lode_open_phase_judge(&watch, &ten);
        // The next period is looked at by itself.
        TEST_ASSERT_EQUAL_UINT(0u, watch.samples);
        for (int k = 0; k < 2; k++) {
            const lode_abc_t sum = watch.sum.set[k];
            TEST_ASSERT_TRUE(sum.a == 0.0f && sum.b == 0.0f && sum.c == 0.0f);
        }
    }
    return open;
}

/// A share of 0.15 of the largest sum is little enough, a mean current of i_min is enough.
static void test_just_at_the_bounds(void) {
    const float most = 100.0f; // ten samples of ten
    const float little = 0.15f * most;
    const float more = 15.01f;
    const lode_abc_t all = {most, most, most};
    TEST_ASSERT_EQUAL_UINT(2u, judged((lode_abc_t){most, little, most}, all));
    TEST_ASSERT_EQUAL_UINT(6u, judged(all, (lode_abc_t){most, most, little}));
    TEST_ASSERT_EQUAL_UINT(0u, judged((lode_abc_t){most, more, most}, all));
    TEST_ASSERT_EQUAL_UINT(7u, judged((lode_abc_t){little, little, little}, all));
    TEST_ASSERT_EQUAL_UINT(8u, judged(all, (lode_abc_t){little, little, little}));
    TEST_ASSERT_EQUAL_UINT(3u, judged((lode_abc_t){little, more, 0.0f}, all));
    TEST_ASSERT_EQUAL_UINT(
        0u, judged((lode_abc_t){99.0f, 0.0f, 99.0f}, (lode_abc_t){99.0f, 99.0f, 99.0f}));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_every_phase_is_found_within_three_periods);
    RUN_TEST(test_faster_than_the_samples_it_takes_longer);
    RUN_TEST(test_sound_phases_are_left_alone);
    RUN_TEST(test_a_rotor_at_rest_has_no_periods);
    RUN_TEST(test_without_current_nothing_is_said);
    RUN_TEST(test_currents_from_the_least_one_on_are_judged);
    RUN_TEST(test_sixteen_samples_are_enough);
    RUN_TEST(test_the_sets_take_turns);
    RUN_TEST(test_each_period_is_counted_by_itself);
    RUN_TEST(test_one_period_is_not_enough);
    RUN_TEST(test_whatever_the_counts_the_answer_is_a_phase);
    RUN_TEST(test_just_at_the_bounds);
    return UNITY_END();
}
