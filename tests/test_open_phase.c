// A switch that stays off and a phase that is open are found in one half-wave, and sound phases are left alone.
#include "support/check.h"

#include "open_phase_inline.h"

#include <complex.h>
#include <stdlib.h>

void setUp(void) {}

void tearDown(void) {}

#define TS_s 1.0e-4
#define INTERVAL_s (4.0 * TS_s)
#define I_MAX_A 15.0
#define XY_rad_s 1000.0
#define PHASES 6

typedef double _Complex cplx_t;

/// What a phase cannot carry.
enum { POSITIVE = 1, NEGATIVE = 2, BOTH = 3 };

typedef struct {
    double i_A; ///< of alpha-beta
    double omega;
    double angle; ///< of the current
    double noise_A;
    double fifth_A; ///< in the xy plane
    double has;     ///< share of what is asked for that the phase still carries
    int phase;      ///< that is faulty, 1 .. 6; 7, 8: a whole set; 0: none
    int lacks;
    lode_open_phase_tuning_t tuning;
    lode_open_phase_watch_t watch;
    random_t random;
} scene_t;

static scene_t scene(double i_A, double omega) {
    scene_t s = {.i_A = i_A,
                 .omega = omega,
                 .lacks = BOTH,
                 .tuning = lode_open_phase_tune((float)I_MAX_A, (float)XY_rad_s, (float)INTERVAL_s),
                 .random = random_seed(5)};
    lode_open_phase_reset(&s.watch);
    return s;
}

static double axis(int phase) {
    static const double degrees[PHASES] = {0.0, 120.0, 240.0, 30.0, 150.0, 270.0};
    return degrees[phase] * CHECK_DEG;
}

/// Set 1 carries this less than its share of alpha-beta, set 2 as much more.
static cplx_t missing(const scene_t *s, cplx_t ab) {
    if (s->phase == 0) {
        return 0.0;
    }
    const double sign = s->phase <= 3 || s->phase == 7 ? 1.0 : -1.0;
    if (s->phase > PHASES) {
        return sign * (1.0 - s->has) * ab;
    }
    const cplx_t along = cexp(I * axis(s->phase - 1));
    const double ref = creal(ab * conj(along));
    const bool lacks = (s->lacks & (ref > 0.0 ? POSITIVE : NEGATIVE)) != 0;
    return lacks ? sign * (1.0 - s->has) * ref * along : 0.0;
}

static lode_ab_t vector(scene_t *s, cplx_t x) {
    return (lode_ab_t){(float)(creal(x) + s->noise_A * random_between(&s->random, -1.0, 1.0)),
                       (float)(cimag(x) + s->noise_A * random_between(&s->random, -1.0, 1.0))};
}

/// A look at each set, two periods apart.
static lode_open_phase_t step(scene_t *s) {
    lode_open_phase_t open = 0u;
    for (int set = 0; set < LODE_SETS && open == 0u; set++) {
        const cplx_t ab = s->i_A * cexp(I * s->angle);
        const cplx_t less = missing(s, ab) + s->fifth_A * cexp(-5.0 * I * s->angle);
        const lode_sets_t i_A = {{vector(s, ab - less), vector(s, ab + less)}};
        const lode_ab_t ab_A = lode_vsd_ab(i_A);
        if (lode_open_phase_doubts(&s->watch, &s->tuning, ab_A, lode_vsd_xy(i_A))) {
            open = lode_open_phase_check(&s->watch, &s->tuning, set, i_A.set[set], ab_A,
                                         (float)(INTERVAL_s * s->omega));
        }
        s->angle = remainder(s->angle + 0.5 * INTERVAL_s * s->omega, 2.0 * CHECK_PI);
    }
    return open;
}

/// Turns until something is found, at most `turns`; what is found in `open`.
static double found_after(scene_t *s, double turns, lode_open_phase_t *open) {
    const double turn = INTERVAL_s * fabs(s->omega) / (2.0 * CHECK_PI);
    *open = 0u;
    for (int n = 1; n <= (int)(turns / turn); n++) {
        *open = step(s);
        if (*open > 0u) {
            return n * turn;
        }
    }
    return turns;
}

static void expect_none(scene_t *s, double turns) {
    lode_open_phase_t open;
    (void)found_after(s, turns, &open);
    TEST_ASSERT_EQUAL_INT(0, open);
}

/// Wherever in the turn the switch dies, with noise, either way round.
static void test_a_dead_switch_and_an_open_phase_are_found_within_1_2_turns(void) {
    static const double omegas[] = {5.0, 60.0, 200.0, -5.0, -60.0, -200.0};
    for (int n = 0; n < 6 * PHASES * 3; n++) {
        for (int at = 0; at < 36; at++) {
            scene_t s = scene(n % 2 == 0 ? 1.5 : 15.0, omegas[n % 6]);
            lode_open_phase_t open;
            s.angle = at * 10.0 * CHECK_DEG;
            expect_none(&s, 2.0);
            s.noise_A = 0.05;
            s.phase = n / 6 % PHASES + 1;
            s.lacks = n / 6 / PHASES + 1;
            CHECK_AT_MOST(s.lacks == BOTH ? 0.7 : 1.2, found_after(&s, 3.0, &open));
            TEST_ASSERT_EQUAL_INT(s.phase, open);
            TEST_ASSERT_EQUAL_INT(s.phase <= 3 ? 0 : 1, lode_open_phase_set(open));
        }
    }
}

static void test_a_set_that_is_open_is_reported_as_one(void) {
    for (int set = 0; set < LODE_SETS; set++) {
        for (int at = 0; at < 36; at++) {
            scene_t s = scene(5.0, at % 2 == 0 ? 100.0 : -100.0);
            lode_open_phase_t open;
            s.angle = at * 10.0 * CHECK_DEG;
            expect_none(&s, 1.3);
            s.noise_A = 0.1;
            s.phase = 7 + set;
            CHECK_AT_MOST(0.4, found_after(&s, 3.0, &open));
            TEST_ASSERT_EQUAL_INT(7 + set, open);
            TEST_ASSERT_EQUAL_INT(set, lode_open_phase_set(open));
        }
    }
}

/// Faster than control of the xy plane takes out a current, one half-wave is not enough.
static void test_at_high_speed_it_takes_four_time_constants(void) {
    scene_t s = scene(5.0, 1500.0); // a third of a turn is three checks and a half
    lode_open_phase_t open;
    s.phase = 5;
    s.lacks = NEGATIVE;
    const double turns = found_after(&s, 10.0, &open);
    TEST_ASSERT_EQUAL_INT(5, open);
    CHECK_AT_LEAST(2.0, turns);
    CHECK_AT_MOST(4.5, turns);
    s = scene(5.0, 1500.0);
    s.phase = 8; // two half-waves are lacking at any time
    s.noise_A = 0.1;
    CHECK_AT_MOST(4.0, found_after(&s, 10.0, &open));
    TEST_ASSERT_EQUAL_INT(8, open);
}

static void test_sound_phases_are_left_alone(void) {
    static const double omegas[] = {30.0, 314.0, 1500.0, -314.0};
    for (int w = 0; w < COUNT_OF(omegas); w++) {
        scene_t s = scene(5.0, omegas[w]);
        s.noise_A = 1.0;
        expect_none(&s, 1000.0);
        s.noise_A = 0.1;
        s.fifth_A = 5.0; // as large as the fundamental
        expect_none(&s, 1000.0);
    }
}

/// A phase that carries more than a quarter of what is asked for does not lack it.
static void test_a_quarter_is_not_lacking(void) {
    for (int more = 0; more <= 1; more++) {
        for (int phase = 1; phase <= PHASES; phase++) {
            scene_t s = scene(5.0, 100.0);
            lode_open_phase_t open;
            s.phase = phase;
            s.has = more == 1 ? 0.26 : 0.24;
            (void)found_after(&s, 10.0, &open);
            TEST_ASSERT_EQUAL_INT(more == 1 ? 0 : phase, open);
        }
    }
}

static void test_currents_from_the_least_one_on_are_judged(void) {
    for (int more = 0; more <= 1; more++) {
        scene_t s = scene((more == 1 ? 0.031 : 0.029) * I_MAX_A, 100.0);
        lode_open_phase_t open;
        s.phase = 3;
        (void)found_after(&s, 10.0, &open);
        TEST_ASSERT_EQUAL_INT(more == 1 ? 3 : 0, open);
    }
}

/// Held at an angle where phase a1 should carry its most.
static void test_a_vector_at_rest_tells_nothing(void) {
    scene_t s = scene(5.0, 0.0);
    s.phase = 1;
    for (int n = 0; n < 10000; n++) {
        TEST_ASSERT_EQUAL_INT(0, step(&s));
    }
}

/// What is found in twice 50 degrees of a half-wave that phase a1 lacks, with something else for some degrees in between.
static lode_open_phase_t after_a_pause(double i_A, double has, double angle, double degrees) {
    const double part = 50.0 / 360.0;
    scene_t s = scene(5.0, 50.0);
    lode_open_phase_t open;
    s.phase = 1;
    s.lacks = POSITIVE;
    s.angle = -25.0 * CHECK_DEG;
    expect_none(&s, part);
    s.angle = angle;
    s.i_A = i_A;
    s.has = has;
    expect_none(&s, degrees / 360.0);
    s.angle = -25.0 * CHECK_DEG;
    s.i_A = 5.0;
    s.has = 0.0;
    (void)found_after(&s, part, &open);
    return open;
}

/// What has been lacking is kept until the phase has it, or nothing is asked for during a third of a turn.
static void test_a_half_wave_that_comes_clears_its_phase(void) {
    const double quarter = CHECK_PI / 2.0;
    TEST_ASSERT_EQUAL_INT(1, after_a_pause(5.0, 0.0, quarter, 2.0));  // nothing is ref of it
    TEST_ASSERT_EQUAL_INT(1, after_a_pause(5.0, 0.0, CHECK_PI, 2.0)); // the other half-wave
    TEST_ASSERT_EQUAL_INT(1, after_a_pause(5.0, 0.4, 0.0, 2.0));      // neither has nor lacks
    TEST_ASSERT_EQUAL_INT(0, after_a_pause(5.0, 0.6, 0.0, 2.0));
    TEST_ASSERT_EQUAL_INT(1, after_a_pause(0.3, 0.0, 0.0, 115.0));
    TEST_ASSERT_EQUAL_INT(0, after_a_pause(0.3, 0.0, 0.0, 125.0));
    TEST_ASSERT_EQUAL_INT(0, after_a_pause(0.3, 1.0, 0.0, 2.0)); // a little is enough to clear it
}

/// Four checks are enough, and from 2 A on a phase is judged.
static const lode_open_phase_tuning_t by_checks = {.least_A = 2.0f, .per_rad = 1.0f, .most = 0.25f};

/// The last answer of so many checks of a set that has `has` where `ref` is asked for.
static lode_open_phase_t after_checks(lode_open_phase_watch_t *watch, int checks, int set,
                                      lode_ab_t has, lode_ab_t ref) {
    lode_open_phase_t open = 0u;
    for (int n = 0; n < checks; n++) {
        open = lode_open_phase_check(watch, &by_checks, set, has, ref, 1.0f);
    }
    return open;
}

/// Half of what is asked for is had, a quarter is lacking, a third of the vector and the least current are asked for.
static void test_at_its_limits(void) {
    const lode_ab_t ref = {4.0f, 0.0f};
    const lode_ab_t none = {0.0f, 0.0f};
    for (int set = 0; set < LODE_SETS; set++) {
        lode_open_phase_watch_t watch;
        lode_open_phase_reset(&watch);
        TEST_ASSERT_EQUAL_INT(0, after_checks(&watch, 3, set, (lode_ab_t){1.0f, 0.0f}, ref));
        TEST_ASSERT_TRUE(watch.doubts);
        TEST_ASSERT_EQUAL_INT(7 + set, after_checks(&watch, 1, set, (lode_ab_t){1.0f, 0.0f}, ref));
        lode_open_phase_reset(&watch);
        (void)after_checks(&watch, 1, set, none, ref);
        TEST_ASSERT_TRUE(watch.doubts);
        (void)after_checks(&watch, 1, 1 - set, ref, ref); // says nothing of this one
        TEST_ASSERT_TRUE(watch.doubts);
        (void)after_checks(&watch, 1, set, (lode_ab_t){2.0f, 0.0f}, ref);
        TEST_ASSERT_FALSE(watch.doubts);
    }
    const lode_ab_t least = {2.0f, 0.0f};
    lode_open_phase_watch_t watch;
    lode_open_phase_reset(&watch);
    TEST_ASSERT_EQUAL_INT(0, after_checks(&watch, 3, 0, (lode_ab_t){0.5f, 1.0f}, least));
    TEST_ASSERT_EQUAL_INT(1, after_checks(&watch, 1, 0, (lode_ab_t){0.5f, 1.0f}, least));
    const lode_ab_t aside = {2.0f, 2.0f * sqrtf(8.0f)};
    TEST_ASSERT_EQUAL_FLOAT(6.0f, lode_ab_length(aside));
    lode_open_phase_reset(&watch);
    (void)after_checks(&watch, 1, 0, (lode_ab_t){0.0f, aside.beta}, aside);
    TEST_ASSERT_TRUE(watch.doubts); // of phase a alone
}

/// A vector between two axes that asks less than the least of each of them, whatever the set has.
static void test_less_than_the_least_of_each_phase_tells_nothing(void) {
    const lode_ab_t ref = {2.1f * 0.8660254f, 2.1f * 0.5f};
    lode_open_phase_watch_t watch;
    lode_open_phase_reset(&watch);
    TEST_ASSERT_EQUAL_INT(0, after_checks(&watch, 20, 0, (lode_ab_t){0.0f, 0.0f}, ref));
}

/// A set lacks for half of what is enough, before and after a pause with little current.
static void test_what_was_lacking_is_forgotten_after_a_third_of_a_turn(void) {
    const lode_ab_t ref = {4.0f, 0.0f};
    const lode_ab_t none = {0.0f, 0.0f};
    const lode_ab_t little = {1.0f, 0.0f};
    for (int checks = 7; checks <= 8; checks++) {
        lode_open_phase_watch_t watch;
        lode_open_phase_reset(&watch);
        (void)after_checks(&watch, 2, 0, none, ref);
        (void)after_checks(&watch, checks, 0, none, little);
        TEST_ASSERT_EQUAL_INT(checks < 8, watch.doubts);
        // Forgotten is all but this check's, a quarter of enough.
        TEST_ASSERT_EQUAL_UINT(checks < 8 ? 16384u : 4096u, watch.set[0].all);
        TEST_ASSERT_EQUAL_UINT(checks < 8 ? 14336u : 0u, watch.set[0].waves.idle);
        TEST_ASSERT_EQUAL_INT(checks < 8 ? 7 : 0, after_checks(&watch, 2, 0, none, ref));
        TEST_ASSERT_EQUAL_UINT(0u, watch.set[0].waves.idle);
        (void)after_checks(&watch, 1, 0, ref, ref);
        TEST_ASSERT_EQUAL_UINT(0u, watch.set[0].all);
    }
}

/// A sixth of a turn is 1.047 rad; what is lacking for the least turn that counts is looked at again.
static void test_enough_is_a_sixth_of_a_turn(void) {
    const lode_open_phase_tuning_t tuning = lode_open_phase_tune(15.0f, 1000.0f, 0.01f);
    const lode_ab_t ref = {0.5f, 0.0f}; // of phase a alone as much as the least
    const lode_ab_t has = {0.0f, 0.3f};
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_open_phase_watch_t watch;
        lode_open_phase_reset(&watch);
        int checks = 0;
        lode_open_phase_t open = 0u;
        while (open == 0u && checks < 1000) {
            checks++;
            open = lode_open_phase_check(&watch, &tuning, 0, has, ref, (float)sign * 0.01f);
        }
        TEST_ASSERT_EQUAL_INT(1, open);
        CHECK_NEAR(2.0, 104.7, checks);
        lode_open_phase_reset(&watch);
        (void)lode_open_phase_check(&watch, &tuning, 0, has, ref, (float)sign * 7.0e-5f);
        TEST_ASSERT_TRUE(watch.doubts);
    }
}

/// A quarter of the alpha-beta current in the xy plane, and the least current.
static void test_doubts_at_their_limits(void) {
    lode_open_phase_watch_t watch;
    lode_open_phase_reset(&watch);
    TEST_ASSERT_TRUE(lode_open_phase_doubts(&watch, &by_checks, (lode_ab_t){0.0f, 2.0f},
                                            (lode_ab_t){0.5f, 0.0f}));
    TEST_ASSERT_FALSE(lode_open_phase_doubts(&watch, &by_checks, (lode_ab_t){0.0f, 2.0f},
                                             (lode_ab_t){0.49f, 0.0f}));
    TEST_ASSERT_FALSE(lode_open_phase_doubts(&watch, &by_checks, (lode_ab_t){0.0f, 1.99f},
                                             (lode_ab_t){5.0f, 0.0f}));
}

/// Where there is nothing to doubt, a check would not find a half-wave that is lacking, whatever the currents.
static void test_without_doubt_nothing_is_lacking(void) {
    random_t random = random_seed(3);
    scene_t s = scene(1.0, 100.0);
    int doubts = 0;
    for (int n = 0; n < 200000; n++) {
        lode_sets_t i_A;
        for (int set = 0; set < LODE_SETS; set++) {
            i_A.set[set].alpha = random_float(&random, -5.0, 5.0);
            i_A.set[set].beta = random_float(&random, -5.0, 5.0);
        }
        const lode_ab_t ab_A = lode_vsd_ab(i_A);
        if (lode_open_phase_doubts(&s.watch, &s.tuning, ab_A, lode_vsd_xy(i_A))) {
            doubts++;
            continue;
        }
        lode_open_phase_watch_t seen = s.watch;
        for (int set = 0; set < LODE_SETS; set++) {
            (void)lode_open_phase_check(&seen, &s.tuning, set, i_A.set[set], ab_A, 0.1f);
        }
        TEST_ASSERT_FALSE(seen.doubts);
    }
    CHECK_AT_LEAST(20000, doubts);
    CHECK_AT_LEAST(20000, 200000 - doubts);
}

static void test_whatever_the_currents_the_answer_is_a_phase(void) {
    static const float wild[] = {NAN, INFINITY, -INFINITY, 1.0e30f, 0.0f, 5.0f};
    random_t random = random_seed(9);
    scene_t s = scene(5.0, 100.0);
    for (int n = 0; n < 100000; n++) {
        float x[5];
        for (int k = 0; k < 5; k++) {
            x[k] = wild[random_bits(&random) % (uint32_t)COUNT_OF(wild)];
        }
        CHECK_AT_MOST(8.0,
                      lode_open_phase_check(&s.watch, &s.tuning, n % 2, (lode_ab_t){x[0], x[1]},
                                            (lode_ab_t){x[2], x[3]}, x[4]));
    }
}

static void test_tuning(void) {
    lode_open_phase_tuning_t t = lode_open_phase_tune(10.0f, 1000.0f, 4.0e-4f);
    CHECK_CLOSE(1.0e-6, 0.3, t.least_A);
    CHECK_CLOSE(1.0e-6, 3.0 / CHECK_PI, t.per_rad);
    CHECK_CLOSE(1.0e-6, 0.4 / 4.9, t.most);
    t = lode_open_phase_tune(10.0f, 5000.0f, 4.0e-4f);
    CHECK_CLOSE(1.0e-6, 1.0 / 3.0, t.most); // three checks at least
}

// ---- Three phases -------------------------------------------------------------------------------

/// A current of `i_A` is asked for, and flows but for what a phase cannot carry.
typedef struct {
    double i_A;
    double omega;
    double angle;
    double noise_A;
    cplx_t times; ///< what flows of a sound drive, of what is asked for
    bool answers; ///< all of the voltage makes current
    int phase;    ///< 0: none
    int lacks;
    lode_open_phase_tuning_t tuning;
    lode_half_waves_t waves;
    random_t random;
} three_t;

#define ROUND_s (8.0 * TS_s)
#define CONTROL_rad_s 2000.0

static three_t three(double i_A, double omega) {
    return (three_t){.i_A = i_A,
                     .omega = omega,
                     .times = 1.0,
                     .lacks = BOTH,
                     .tuning =
                         lode_half_waves_tune((float)I_MAX_A, (float)CONTROL_rad_s, (float)ROUND_s),
                     .random = random_seed(11)};
}

static float noisy(three_t *s, double x) {
    return (float)(x + s->noise_A * random_between(&s->random, -1.0, 1.0));
}

#define KP_V_A 10.0f

/// What current control adds for what is missing makes no current.
static lode_half_waves_seen_t seen_of(lode_ab_t ref_A, lode_ab_t i_A, double turn_rad) {
    return (lode_half_waves_seen_t){
        .ref_A = ref_A,
        .before_A = ref_A,
        .i_A = i_A,
        .beyond_V = {KP_V_A * (ref_A.alpha - i_A.alpha), KP_V_A * (ref_A.beta - i_A.beta)},
        .kp_V_A = KP_V_A,
        .turn_rad = (float)turn_rad};
}

static lode_open_phase_t check_at_three(three_t *s) {
    const cplx_t ref = s->i_A * cexp(I * s->angle);
    cplx_t flows = s->times * ref;
    if (s->phase > 0) {
        const cplx_t along = cexp(I * axis(s->phase - 1));
        const double has = creal(flows * conj(along));
        flows -= (s->lacks & (has > 0.0 ? POSITIVE : NEGATIVE)) != 0 ? has * along : 0.0;
    }
    const lode_ab_t ref_A = {(float)creal(ref), (float)cimag(ref)};
    const lode_ab_t i_A = {noisy(s, creal(flows)), noisy(s, cimag(flows))};
    const lode_dq_t any_A = {ref_A.alpha, ref_A.beta}; // any axes will do
    const lode_dq_t error_A = {ref_A.alpha - i_A.alpha, ref_A.beta - i_A.beta};
    s->angle = remainder(s->angle + ROUND_s * s->omega, 2.0 * CHECK_PI);
    lode_half_waves_seen_t seen = seen_of(ref_A, i_A, ROUND_s * s->omega);
    seen.beyond_V = s->answers ? (lode_ab_t){0.0f, 0.0f} : seen.beyond_V;
    if (!lode_half_waves_doubt(&s->waves, &s->tuning, any_A, error_A)) {
        lode_half_waves_t waves = s->waves;
        TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_check(&waves, &s->tuning, &seen));
        TEST_ASSERT_FALSE(waves.doubts);
        return 0u;
    }
    return lode_half_waves_check(&s->waves, &s->tuning, &seen);
}

/// Turns until a phase is found, at most `turns`.
static double three_found_after(three_t *s, double turns, lode_open_phase_t *open) {
    const double turn = ROUND_s * fabs(s->omega) / (2.0 * CHECK_PI);
    *open = 0u;
    for (int n = 1; n <= (int)(turns / turn); n++) {
        *open = check_at_three(s);
        if (*open > 0u) {
            return n * turn;
        }
    }
    return turns;
}

static void expect_no_phase(three_t *s, double turns) {
    lode_open_phase_t open;
    (void)three_found_after(s, turns, &open);
    TEST_ASSERT_EQUAL_INT(0, open);
}

/// From a tenth of i_max on, wherever in the turn, either way round.
static void test_of_three_phases_one_is_found_within_1_2_turns(void) {
    static const double omegas[] = {5.0, 60.0, 200.0, -5.0, -60.0, -200.0};
    for (int n = 0; n < 6 * 3 * 3; n++) {
        for (int at = 0; at < 36; at++) {
            three_t s = three(n % 2 == 0 ? 0.1 * I_MAX_A : I_MAX_A, omegas[n % 6]);
            lode_open_phase_t open;
            s.angle = at * 10.0 * CHECK_DEG;
            s.noise_A = 0.002 * I_MAX_A;
            expect_no_phase(&s, 2.0);
            s.phase = n / 6 % 3 + 1;
            s.lacks = n / 18 + 1;
            CHECK_AT_MOST(1.2, three_found_after(&s, 3.0, &open));
            TEST_ASSERT_EQUAL_INT(s.phase, open);
        }
    }
}

/// At any speed: checks may lie as far apart as they like, as reference and current are those of the same instant.
static void test_of_three_phases_one_is_found_at_any_speed(void) {
    for (int n = 1; n < 40; n++) {
        three_t s = three(5.0, 0.17 * n / ROUND_s);
        lode_open_phase_t open;
        expect_no_phase(&s, 20.0);
        s.phase = n % 3 + 1;
        s.lacks = n % 2 + 1;
        CHECK_AT_MOST(fmax(1.2, 60.0 * ROUND_s * s.omega / (2.0 * CHECK_PI)),
                      three_found_after(&s, 100.0, &open));
        TEST_ASSERT_EQUAL_INT(s.phase, open);
    }
}

/// All phases have as little, or control is behind: by any angle where its voltage makes current, and up to 55 degrees
/// even where it does not.
static void test_control_that_is_behind_lacks_no_phase(void) {
    for (int n = -180; n <= 180; n += 5) {
        for (double length = 0.1; length < 2.0; length += 0.1) {
            three_t s = three(0.5 * I_MAX_A, 100.0);
            s.times = length * cexp(I * (double)n * CHECK_DEG);
            s.answers = abs(n) > 55;
            expect_no_phase(&s, 5.0);
        }
    }
    three_t s = three(I_MAX_A, 100.0);
    s.times = 0.02; // nothing flows
    expect_no_phase(&s, 5.0);
}

/// What is lacking for half of a half-wave is forgotten as soon as the phase is seen to have it.
static void test_a_half_wave_that_is_seen_clears_its_phase(void) {
    three_t s = three(5.0, 60.0);
    s.phase = 1;
    s.angle = -70.0 * CHECK_DEG;
    while (s.angle < -20.0 * CHECK_DEG) {
        TEST_ASSERT_EQUAL_INT(0, check_at_three(&s));
    }
    TEST_ASSERT_GREATER_THAN_UINT(0u, s.waves.lacks[0]);
    TEST_ASSERT_TRUE(s.waves.doubts);
    three_t sound = s;
    sound.phase = 0;
    TEST_ASSERT_EQUAL_INT(0, check_at_three(&sound));
    TEST_ASSERT_EQUAL_UINT(0u, sound.waves.lacks[0]);
    TEST_ASSERT_FALSE(sound.waves.doubts);
    sound = s;
    sound.phase = 0;
    sound.i_A = 0.0; // nothing is asked for, for a third of a turn
    for (int n = 0; n < 60; n++) {
        (void)check_at_three(&sound);
    }
    TEST_ASSERT_FALSE(sound.waves.doubts);
}

/// Of both half-waves half of enough each is not enough, nor what two phases lack.
static void test_one_half_wave_of_one_phase_lacks_enough(void) {
    const lode_open_phase_tuning_t t = three(1.0, 1.0).tuning;
    const lode_half_waves_seen_t none =
        seen_of((lode_ab_t){0.0f, 0.0f}, (lode_ab_t){0.0f, 0.0f}, 0.0);
    lode_half_waves_t waves = {.lacks = {16383u, 0u, 0u, 16383u}};
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_check(&waves, &t, &none));
    waves = (lode_half_waves_t){.lacks = {0u, 16384u}};
    TEST_ASSERT_EQUAL_UINT(2u, lode_half_waves_check(&waves, &t, &none));
    waves = (lode_half_waves_t){.lacks = {0u, 0u, 0u, 0u, 0u, 16384u}};
    TEST_ASSERT_EQUAL_UINT(3u, lode_half_waves_check(&waves, &t, &none));
    waves = (lode_half_waves_t){.lacks = {8191u, 16384u}};
    TEST_ASSERT_EQUAL_UINT(2u, lode_half_waves_check(&waves, &t, &none));
    waves = (lode_half_waves_t){.lacks = {8192u, 16384u}};
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_check(&waves, &t, &none));
    waves = (lode_half_waves_t){.lacks = {4096u, 16384u, 0u, 4096u}};
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_check(&waves, &t, &none));
    waves = (lode_half_waves_t){.lacks = {16384u, 0u, 16384u}}; // two phases as much
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_check(&waves, &t, &none));
    TEST_ASSERT_EQUAL_UINT(1u, waves.doubts);
}

/// (K41): a quarter of enough, of both half-waves together, and twice as much as either other phase.
static void test_a_phase_is_suspect_with_a_quarter_as_much(void) {
    lode_half_waves_t waves = {.lacks = {0u, 4096u}};
    TEST_ASSERT_EQUAL_UINT(2u, lode_half_waves_suspect(&waves));
    waves = (lode_half_waves_t){.lacks = {0u, 4095u}};
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_suspect(&waves));
    waves = (lode_half_waves_t){.lacks = {0u, 0u, 2048u, 0u, 0u, 2048u}};
    TEST_ASSERT_EQUAL_UINT(3u, lode_half_waves_suspect(&waves));
    waves = (lode_half_waves_t){.lacks = {16000u, 7999u, 0u, 0u, 0u, 7999u}};
    TEST_ASSERT_EQUAL_UINT(1u, lode_half_waves_suspect(&waves));
    waves = (lode_half_waves_t){.lacks = {16000u, 8000u, 0u, 0u, 0u, 0u}};
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_suspect(&waves));
    waves = (lode_half_waves_t){.lacks = {16000u, 0u, 4000u, 0u, 0u, 4000u}};
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_suspect(&waves));
    waves = (lode_half_waves_t){.doubts = 1u};
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_suspect(&waves));
}

/// One check of phase 1 that lacks its positive half-wave, or not: `ref_A` along its axis, `has_A` of it, `across_A` of the
/// other two.
static bool lacks_now(float ref_A, float has_A, float across_A) {
    const lode_open_phase_tuning_t t = three(1.0, 1.0).tuning;
    lode_half_waves_t waves = {.lacks = {0u}};
    lode_half_waves_seen_t seen =
        seen_of((lode_ab_t){ref_A, 0.0f}, (lode_ab_t){has_A, across_A}, 0.1);
    seen.beyond_V.beta = 0.0f; // the other two carry what flows across
    (void)lode_half_waves_check(&waves, &t, &seen);
    return waves.lacks[0] > 0u;
}

static bool clears_now(float has_A, float across_A) {
    const lode_open_phase_tuning_t t = three(1.0, 1.0).tuning;
    lode_half_waves_t waves = {.lacks = {100u}};
    const lode_half_waves_seen_t seen =
        seen_of((lode_ab_t){0.0f, 9.0f}, (lode_ab_t){has_A, across_A}, 0.1);
    (void)lode_half_waves_check(&waves, &t, &seen);
    return waves.lacks[0] == 0u;
}

static void test_three_phases_at_their_limits(void) {
    const float least_A = 0.03f * (float)I_MAX_A;
    TEST_ASSERT_TRUE(lacks_now(1.001f * least_A, 0.0f, 2.0f));
    TEST_ASSERT_FALSE(lacks_now(0.999f * least_A, 0.0f, 2.0f));
    TEST_ASSERT_TRUE(lacks_now(4.0f, 0.0f, 1.001f * least_A));
    TEST_ASSERT_FALSE(lacks_now(4.0f, 0.0f, 0.999f * least_A));
    TEST_ASSERT_TRUE(lacks_now(4.0f, 0.999f, 9.0f));
    TEST_ASSERT_FALSE(lacks_now(4.0f, 1.001f, 9.0f));
    TEST_ASSERT_TRUE(lacks_now(4.0f, -3.0f, 2.7f));                      // 0.743 of it
    TEST_ASSERT_FALSE(lacks_now(4.0f, -3.0f, 2.6f));                     // 0.756
    TEST_ASSERT_TRUE(lacks_now(4.0f, -0.99f * least_A, 0.2f * least_A)); // ripple
    TEST_ASSERT_TRUE(clears_now(0.501f * least_A, 0.0f));
    TEST_ASSERT_FALSE(clears_now(0.499f * least_A, 0.0f));
    TEST_ASSERT_TRUE(clears_now(2.6f, 10.0f)); // a quarter of 10.3
    TEST_ASSERT_FALSE(clears_now(2.55f, 10.0f));
}

/// What just is at a limit: the least current that is asked for and that flows, a quarter that is had, as much the other way as
/// may be, and a quarter of the voltage.
static void test_three_phases_exactly_at_their_limits(void) {
    const lode_ab_t least = {2.0f, 0.0f};
    const lode_ab_t ref = {4.0f, 0.0f};
    lode_half_waves_seen_t seen[] = {
        seen_of(least, (lode_ab_t){0.0f, 2.0f}, 1.0), seen_of(ref, (lode_ab_t){1.0f, 9.0f}, 0.7),
        seen_of(ref, (lode_ab_t){-2.0f, 0.0f}, 0.7), seen_of(ref, (lode_ab_t){0.0f, 9.0f}, 0.7)};
    seen[3].beyond_V = (lode_ab_t){0.25f * 4.0f * KP_V_A, 0.0f};
    for (int n = 0; n < COUNT_OF(seen); n++) {
        lode_half_waves_t waves = {.lacks = {0u}, .idle = 16383u};
        seen[n].beyond_V.beta = 0.0f; // the other two carry what flows across
        (void)lode_half_waves_check(&waves, &by_checks, &seen[n]);
        TEST_ASSERT_GREATER_THAN_UINT(0u, waves.lacks[0]);
        TEST_ASSERT_EQUAL_UINT(0u, waves.idle);
    }
    lode_half_waves_t waves = {.lacks = {100u}, .idle = 16383u};
    const lode_half_waves_seen_t has = seen_of(least, (lode_ab_t){1.0f, 3.0f}, 0.1);
    TEST_ASSERT_EQUAL_UINT(0u, lode_half_waves_check(&waves, &by_checks, &has));
    TEST_ASSERT_EQUAL_UINT(0u, waves.lacks[0]); // half of the least current is had
    waves = (lode_half_waves_t){.lacks = {0u, 0u, 0u, 0u, 100u}, .idle = 16383u};
    (void)lode_half_waves_check(&waves, &by_checks, &has);
    TEST_ASSERT_EQUAL_UINT(1u, waves.doubts); // nothing is forgotten, as enough is asked for
    waves.idle = 16383u;
    const lode_half_waves_seen_t little = seen_of((lode_ab_t){1.99f, 0.0f}, least, 0.1);
    (void)lode_half_waves_check(&waves, &by_checks, &little);
    TEST_ASSERT_EQUAL_UINT(0u, waves.doubts);
    TEST_ASSERT_EQUAL_UINT(0u, waves.idle);
}

/// A quarter of what is asked for is missed, and the least current asked for.
static void test_doubts_of_three_phases_at_their_limits(void) {
    static const lode_half_waves_t waves = {.lacks = {0u}};
    const lode_dq_t ref = {0.0f, 2.0f};
    TEST_ASSERT_TRUE(lode_half_waves_doubt(&waves, &by_checks, ref, (lode_dq_t){0.5f, 0.0f}));
    TEST_ASSERT_FALSE(lode_half_waves_doubt(&waves, &by_checks, ref, (lode_dq_t){0.49f, 0.0f}));
    TEST_ASSERT_FALSE(lode_half_waves_doubt(&waves, &by_checks, (lode_dq_t){0.0f, 1.99f},
                                            (lode_dq_t){5.0f, 0.0f}));
}

/// Either half-wave of phase 1, and whether the check counts for it: `before_A` asked for a round ago, `beyond_V` in its axis,
/// `across_V` at right angles to it.
static bool counts_across(float way, float before_A, float beyond_V, float across_V,
                          float turn_rad) {
    const lode_open_phase_tuning_t t = three(1.0, 1.0).tuning;
    lode_half_waves_t waves = {.lacks = {0u}};
    lode_half_waves_seen_t seen =
        seen_of((lode_ab_t){way * 4.0f, 0.0f}, (lode_ab_t){way * 0.5f, 5.0f}, (double)turn_rad);
    seen.before_A = (lode_ab_t){way * before_A, 0.0f};
    seen.beyond_V = (lode_ab_t){way * beyond_V, across_V};
    (void)lode_half_waves_check(&waves, &t, &seen);
    return waves.lacks[way > 0.0f ? 0 : PHASES / 2] > 0u;
}

static bool counts(float way, float before_A, float beyond_V, float turn_rad) {
    return counts_across(way, before_A, beyond_V, -0.99f * beyond_V, turn_rad);
}

/// Control that is behind lacks what it is asked for now, but not what it was asked for a round ago (K24), where a
/// half-wave lasts for some rounds.
static void test_what_was_not_asked_for_a_round_ago_is_not_lacking(void) {
    for (float way = -1.0f; way < 2.0f; way += 2.0f) {
        TEST_ASSERT_TRUE(counts(way, 2.001f, 30.0f, 0.699f)); // has a quarter of it
        TEST_ASSERT_FALSE(counts(way, 1.999f, 30.0f, 0.699f));
        TEST_ASSERT_FALSE(counts(way, 1.999f, 30.0f, -0.699f));
        TEST_ASSERT_FALSE(counts(way, 1.999f, 30.0f, 0.7f));
        TEST_ASSERT_TRUE(counts(way, 1.999f, 30.0f, 0.701f));
        TEST_ASSERT_TRUE(counts(way, -4.0f, 30.0f, -0.701f));
        TEST_ASSERT_TRUE(counts(way, 9.0f, 30.0f, 0.1f)); // what is asked for now is less
    }
}

/// A voltage that makes current is no sign of a phase that carries none (K28): a quarter of 10 V/A for 3.5 A, or for 2 A.
static void test_of_a_phase_that_lacks_the_voltage_is_not_answered(void) {
    for (float way = -1.0f; way < 2.0f; way += 2.0f) {
        TEST_ASSERT_TRUE(counts(way, 4.0f, 8.76f, 0.1f));
        TEST_ASSERT_FALSE(counts(way, 4.0f, 8.74f, 0.1f));
        TEST_ASSERT_FALSE(counts(way, 4.0f, -30.0f, 0.1f));
        TEST_ASSERT_TRUE(counts(way, 2.5f, 5.01f, 0.1f));
        TEST_ASSERT_FALSE(counts(way, 2.5f, 4.99f, 0.1f));
    }
}

/// A rotor that is faster than the estimate has EMF along its own q axis, whichever phase carries none at the moment (K30).
static void test_an_emf_across_a_phase_is_not_of_a_phase_that_lacks(void) {
    for (float way = -1.0f; way < 2.0f; way += 2.0f) {
        for (float side = -1.0f; side < 2.0f; side += 2.0f) {
            TEST_ASSERT_TRUE(counts_across(way, 4.0f, 20.0f, side * 19.99f, 0.1f));
            TEST_ASSERT_FALSE(counts_across(way, 4.0f, 20.0f, side * 20.01f, 0.1f));
        }
    }
    // Of each phase: along its axis, and 44 and 46 degrees off it.
    const lode_open_phase_tuning_t t = three(1.0, 1.0).tuning;
    for (int n = 0; n < 3; n++) {
        for (double off = -46.0; off < 47.0; off += 46.0) {
            for (int k = 0; k < 2; k++) {
                const double off_rad = (off + (off > 0.0 ? -2.0 : 2.0) * k) * CHECK_PI / 180.0;
                const cplx_t ref = 4.0 * cexp(I * axis(n));
                const cplx_t flows = 3.0 * I * cexp(I * axis(n));
                const cplx_t beyond = 80.0 * cexp(I * (axis(n) + off_rad));
                lode_half_waves_t waves = {.lacks = {0u}};
                lode_half_waves_seen_t seen =
                    seen_of((lode_ab_t){(float)creal(ref), (float)cimag(ref)},
                            (lode_ab_t){(float)creal(flows), (float)cimag(flows)}, 0.1);
                seen.beyond_V = (lode_ab_t){(float)creal(beyond), (float)cimag(beyond)};
                (void)lode_half_waves_check(&waves, &t, &seen);
                TEST_ASSERT_EQUAL(fabs(off_rad) < 0.25 * CHECK_PI, waves.lacks[n] > 0u);
            }
        }
    }
}

/// What has been lacking goes on to count, by a twelfth, while there is current (K27), but does not begin to.
static void test_what_is_not_had_again_goes_on_to_count(void) {
    const lode_open_phase_tuning_t t = three(1.0, 1.0).tuning;
    const lode_half_waves_seen_t across =
        seen_of((lode_ab_t){0.0f, 5.0f}, (lode_ab_t){0.0f, 5.0f}, 0.1);
    lode_half_waves_t waves = {.lacks = {0u}};
    (void)lode_half_waves_check(&waves, &t, &across);
    TEST_ASSERT_FALSE(waves.doubts);
    for (uint_least16_t lacks = 1u; lacks <= 100u; lacks = (uint_least16_t)(lacks + 99u)) {
        waves.lacks[0] = lacks;
        (void)lode_half_waves_check(&waves, &t, &across);
        CHECK_NEAR(1.0, lacks + 0.1 * 3.0 / CHECK_PI / 12.0 * 16384.0, waves.lacks[0]);
    }
    const lode_half_waves_seen_t little =
        seen_of((lode_ab_t){0.0f, 5.0f}, (lode_ab_t){0.0f, 0.999f * t.least_A}, 0.1);
    const uint_least16_t before = waves.lacks[0];
    (void)lode_half_waves_check(&waves, &t, &little);
    TEST_ASSERT_EQUAL_UINT(before, waves.lacks[0]);
}

static void test_whatever_three_currents_are_the_answer_is_a_phase(void) {
    static const float wild[] = {NAN, INFINITY, -INFINITY, 1.0e30f, 0.0f, 5.0f};
    random_t random = random_seed(9);
    three_t s = three(5.0, 100.0);
    for (int n = 0; n < 100000; n++) {
        float x[10];
        for (int k = 0; k < COUNT_OF(x); k++) {
            x[k] = wild[random_bits(&random) % (uint32_t)COUNT_OF(wild)];
        }
        const lode_half_waves_seen_t seen = {{x[0], x[1]}, {x[2], x[3]}, {x[4], x[5]},
                                             {x[6], x[7]}, x[8],         x[9]};
        CHECK_AT_MOST(3.0, lode_half_waves_check(&s.waves, &s.tuning, &seen));
    }
}

static void test_tuning_of_three_phases(void) {
    lode_open_phase_tuning_t t = lode_half_waves_tune(10.0f, 1000.0f, 4.0e-4f);
    CHECK_CLOSE(1.0e-6, 0.3, t.least_A);
    CHECK_CLOSE(1.0e-6, 3.0 / CHECK_PI, t.per_rad);
    CHECK_CLOSE(1.0e-6, 0.4 / 4.9, t.most);
    t = lode_half_waves_tune(10.0f, 5000.0f, 4.0e-4f);
    CHECK_CLOSE(1.0e-6, 0.4 / 2.0, t.most);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_dead_switch_and_an_open_phase_are_found_within_1_2_turns);
    RUN_TEST(test_a_set_that_is_open_is_reported_as_one);
    RUN_TEST(test_at_high_speed_it_takes_four_time_constants);
    RUN_TEST(test_sound_phases_are_left_alone);
    RUN_TEST(test_a_quarter_is_not_lacking);
    RUN_TEST(test_currents_from_the_least_one_on_are_judged);
    RUN_TEST(test_a_vector_at_rest_tells_nothing);
    RUN_TEST(test_a_half_wave_that_comes_clears_its_phase);
    RUN_TEST(test_at_its_limits);
    RUN_TEST(test_less_than_the_least_of_each_phase_tells_nothing);
    RUN_TEST(test_what_was_lacking_is_forgotten_after_a_third_of_a_turn);
    RUN_TEST(test_enough_is_a_sixth_of_a_turn);
    RUN_TEST(test_doubts_at_their_limits);
    RUN_TEST(test_without_doubt_nothing_is_lacking);
    RUN_TEST(test_whatever_the_currents_the_answer_is_a_phase);
    RUN_TEST(test_tuning);
    RUN_TEST(test_of_three_phases_one_is_found_within_1_2_turns);
    RUN_TEST(test_of_three_phases_one_is_found_at_any_speed);
    RUN_TEST(test_control_that_is_behind_lacks_no_phase);
    RUN_TEST(test_a_half_wave_that_is_seen_clears_its_phase);
    RUN_TEST(test_one_half_wave_of_one_phase_lacks_enough);
    RUN_TEST(test_a_phase_is_suspect_with_a_quarter_as_much);
    RUN_TEST(test_three_phases_at_their_limits);
    RUN_TEST(test_three_phases_exactly_at_their_limits);
    RUN_TEST(test_doubts_of_three_phases_at_their_limits);
    RUN_TEST(test_what_was_not_asked_for_a_round_ago_is_not_lacking);
    RUN_TEST(test_of_a_phase_that_lacks_the_voltage_is_not_answered);
    RUN_TEST(test_an_emf_across_a_phase_is_not_of_a_phase_that_lacks);
    RUN_TEST(test_what_is_not_had_again_goes_on_to_count);
    RUN_TEST(test_whatever_three_currents_are_the_answer_is_a_phase);
    RUN_TEST(test_tuning_of_three_phases);
    return UNITY_END();
}
