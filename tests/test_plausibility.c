// The currents' plausibility: an ADC channel that is stuck is found before its phase could have stood still,
// a sound one is never; the sum of the three.
#include "support/check.h"

#include "plausibility_inline.h"

void setUp(void) {}

void tearDown(void) {}

#define I_MAX_A 12.0f
#define GAIN_A 0.0125 // per count
#define LOOK_s (4.0 * (double)PAPER_TS_s)
#define SUM_CHECKS 18u // 15 ms

static lode_guard_config_t sound_config(void) {
    return (lode_guard_config_t){.lock_s = 15.0e-3f,
                                 .i_sum_A = 1.8f,
                                 .plausibility = LODE_ON,
                                 .flux_share = 0.2f,
                                 .check_stuck = LODE_ON,
                                 .check_gain = LODE_ON,
                                 .check_half_waves = LODE_ON};
}

static lode_status_t tune(lode_plausibility_tuning_t *tuning, const lode_guard_config_t *config) {
    const lode_sense_tuning_t sense = {.i_gain = (float)(GAIN_A / LODE_COUNT_FRACTION)};
    return lode_plausibility_tune(tuning, config, I_MAX_A, &sense);
}

/// Currents of an amplitude that turn, seen by ADC channels some of which may be stuck.
typedef struct {
    lode_plausibility_tuning_t tuning;
    lode_plausibility_t state;
    double i_A; ///< amplitude
    double ref_A;
    double omega; ///< electrical
    double theta;
    double offset_A; ///< of phase a
    int stuck;       ///< 1 .. 3; 4: all; 0: none
    int32_t held[3];
} bench_t;

static bench_t bench(double i_A, double omega) {
    const lode_guard_config_t config = sound_config();
    bench_t self = {.i_A = i_A, .ref_A = i_A, .omega = omega};
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&self.tuning, &config));
    lode_plausibility_reset(&self.state);
    return self;
}

#define A_PER_COUNT ((float)(GAIN_A / LODE_COUNT_FRACTION))

/// As the drive does it, but each check in full.
static lode_finding_t judge_held(lode_plausibility_t *state,
                                 const lode_plausibility_tuning_t *tuning,
                                 const int32_t i[LODE_PHASES], float i_A2, float turn_rad,
                                 lode_hold_t hold) {
    const uint32_t again = lode_plausibility_check(state, i);
    const uint32_t doubt =
        lode_plausibility_doubt(state, tuning, again, i_A2, turn_rad, A_PER_COUNT);
    return lode_plausibility_find(state, tuning, doubt, SUM_CHECKS, hold, A_PER_COUNT);
}

static lode_finding_t judge(lode_plausibility_t *state, const lode_plausibility_tuning_t *tuning,
                            const int32_t i[LODE_PHASES], float i_A2, float turn_rad) {
    return judge_held(state, tuning, i, i_A2, turn_rad, (lode_hold_t){10.0f, 0.0f});
}

/// The same with the drive's short ways.
static lode_finding_t judge_shortly(lode_plausibility_t *state,
                                    const lode_plausibility_tuning_t *tuning,
                                    const int32_t i[LODE_PHASES], float i_A2, float turn_rad) {
    const lode_finding_t none = {LODE_CHECK_NONE, 0.0f, 0.0f};
    if (lode_plausibility_all_move(state, tuning, i)) {
        lode_plausibility_note(state, i, 0u);
        return none;
    }
    const uint32_t again = lode_plausibility_check(state, i);
    if (lode_plausibility_is_chance(state, tuning, again, i_A2)) {
        return none;
    }
    const uint32_t doubt =
        lode_plausibility_doubt(state, tuning, again, i_A2, turn_rad, A_PER_COUNT);
    return lode_plausibility_find(state, tuning, doubt, SUM_CHECKS, (lode_hold_t){10.0f, 0.0f},
                                  A_PER_COUNT);
}

static lode_finding_t check(bench_t *self) {
    lode_sample_t sample = {.omitted = LODE_PHASES};
    for (int n = 0; n < 3; n++) {
        const double i_A = self->i_A * cos(self->theta - 2.0 * CHECK_PI / 3.0 * n) +
                           (n == 0 ? self->offset_A : 0.0);
        const bool stuck = self->stuck == n + 1 || self->stuck == 4;
        const int32_t seen = LODE_COUNT_FRACTION * (int32_t)lround(i_A / GAIN_A);
        self->held[n] = stuck ? self->held[n] : seen;
        sample.i[n] = self->held[n];
    }
    const float turn_rad = (float)(LOOK_s * self->omega);
    self->theta = remainder(self->theta + (double)turn_rad, 2.0 * CHECK_PI);
    return judge(&self->state, &self->tuning, sample.i, (float)(self->ref_A * self->ref_A),
                 turn_rad);
}

static void expect_none(bench_t *self, int checks) {
    for (int n = 0; n < checks; n++) {
        const lode_finding_t found = check(self);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_NONE", lode_check_name(found.check));
        TEST_ASSERT_TRUE(found.measured == 0.0f && found.limit == 0.0f);
    }
}

/// Seconds until something is found, at most one.
static double until_found(bench_t *self, lode_finding_t *found) {
    int n = 0;
    do {
        *found = check(self);
        n++;
    } while (found->check == LODE_CHECK_NONE && n < (int)(1.0 / LOOK_s));
    return n * LOOK_s;
}

/// No noise at all, whole counts, any speed and amplitude: the worst for a check that looks for counts that
/// stay.
/// However large a count is in amperes.
static void test_what_is_off_is_off_by_its_sign(void) {
    lode_plausibility_tuning_t checks = {.per_wave_A = 0.1f, .frozen_A2 = 0.0f};
    TEST_ASSERT_TRUE(lode_plausibility_has_waves(&checks));
    TEST_ASSERT_TRUE(lode_plausibility_has_stuck(&checks));
    checks = (lode_plausibility_tuning_t){.per_wave_A = 0.0f, .frozen_A2 = -1.0f};
    TEST_ASSERT_FALSE(lode_plausibility_has_waves(&checks));
    TEST_ASSERT_FALSE(lode_plausibility_has_stuck(&checks));
}

static void test_sound_adc_channels_are_never_stuck(void) {
    for (double omega = 1.0; omega < 2500.0; omega *= 1.37) {
        for (double i_A = 0.05; i_A < 18.0; i_A *= 1.9) {
            bench_t self = bench(i_A, omega);
            self.state.i_A2 = (float)(i_A * i_A);
            expect_none(&self, CHECK_TRIES(4000));
        }
    }
}

static void test_a_stuck_adc_channel_is_found_within_5_ms_from_a_fifth_of_the_speed(void) {
    for (int stuck = 1; stuck <= 4; stuck++) {
        for (double share = 0.2; share < 1.3; share += 0.1) {
            bench_t self = bench(3.6, share * PAPER_OMEGA_RATED);
            lode_finding_t found;
            self.theta = 1.0;
            expect_none(&self, 200);
            self.stuck = stuck;
            CHECK_AT_MOST(share < 0.25 ? 6.5e-3 : 5.0e-3, until_found(&self, &found));
            TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_STUCK", lode_check_name(found.check));
            TEST_ASSERT_TRUE(found.measured == (stuck == 4 ? 0.0f : (float)stuck)); // 0: all
            TEST_ASSERT_TRUE(found.limit == 0.0f);
        }
    }
}

/// One that is stuck at no current at all is found like any other.
static void test_an_adc_channel_may_be_stuck_at_zero(void) {
    for (int stuck = 1; stuck <= 3; stuck++) {
        bench_t self = bench(3.6, 0.5 * PAPER_OMEGA_RATED);
        lode_finding_t found;
        expect_none(&self, 200);
        self.stuck = stuck;
        self.held[stuck - 1] = 0;
        CHECK_AT_MOST(10.0e-3, until_found(&self, &found));
        TEST_ASSERT_TRUE(found.check == LODE_CHECK_CURRENT_STUCK && found.measured == (float)stuck);
    }
}

/// Turns with phase `held` at 4 counts; `balanced`: the others add up to none with it. Returns the turn until found.
static double turn_of_held(int held, bool balanced, float x_Ohm) {
    bench_t self = bench(3.6, 0.0);
    const double step = 0.05;
    lode_finding_t found = {.check = LODE_CHECK_NONE};
    double turned = 0.0;
    for (; turned < 3.0 && found.check == LODE_CHECK_NONE; turned += step) {
        const double a = 3.6 * cos(turned - 1.0) / GAIN_A;
        const int32_t b = LODE_COUNT_FRACTION * (int32_t)lround(a);
        const int32_t c = LODE_COUNT_FRACTION * (int32_t)lround(0.4 * a);
        int32_t i[LODE_PHASES];
        i[held] = 4 * LODE_COUNT_FRACTION;
        i[(held + 1) % 3] = b;
        i[(held + 2) % 3] = balanced ? -b : c;
        found = judge_held(&self.state, &self.tuning, i, (float)(3.6 * 3.6), (float)step,
                           (lode_hold_t){10.0f, x_Ohm});
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_STUCK, found.check);
    TEST_ASSERT_TRUE(found.measured == (float)(held + 1));
    return turned;
}

/// The same whichever phase it is.
static double turn_until_found(bool balanced, float x_Ohm) {
    const double turned = turn_of_held(0, balanced, x_Ohm);
    CHECK_NEAR(0.1, turned, turn_of_held(1, balanced, x_Ohm));
    CHECK_NEAR(0.1, turned, turn_of_held(2, balanced, x_Ohm));
    return turned;
}

/// What holds a phase near zero holds none beside it.
static void test_a_phase_beside_one_near_zero_is_stuck(void) {
    bench_t self = bench(3.6, 0.0);
    lode_finding_t found = {.check = LODE_CHECK_NONE};
    double turned = 0.0;
    for (; turned < 3.0 && found.check == LODE_CHECK_NONE; turned += 0.05) {
        const int32_t b = LODE_COUNT_FRACTION * (int32_t)lround(40.0 * sin(turned));
        const int32_t a = 150 * LODE_COUNT_FRACTION;
        const int32_t i[LODE_PHASES] = {a, b, -a - b};
        found = judge(&self.state, &self.tuning, i, (float)(3.6 * 3.6), 0.05f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_STUCK, found.check);
    CHECK_AT_MOST(1.3, turned);
}

/// Three that keep still, one of them at zero: dead time may hold that one, and the vector has to turn until another
/// would have moved by 8 counts.
static void test_three_that_keep_still_beside_dead_time(void) {
    for (int near_zero = 0; near_zero < 2; near_zero++) {
        bench_t self = bench(3.6, 0.0);
        const int32_t b = (near_zero == 1 ? 1 : 100) * LODE_COUNT_FRACTION;
        const int32_t a = 250 * LODE_COUNT_FRACTION;
        const int32_t i[LODE_PHASES] = {a, b, -a - b};
        lode_finding_t found = {.check = LODE_CHECK_NONE};
        double turned = -0.04; // since the first check
        for (; turned < 2.0 && found.check == LODE_CHECK_NONE; turned += 0.02) {
            found = judge(&self.state, &self.tuning, i, (float)(3.6 * 3.6), 0.02f);
        }
        const double one = sqrt(64.0 * GAIN_A / 3.6); // 3.6 A (1 - cos(turn/2)) are 8 counts
        const double three = 32.0 * GAIN_A / 3.6 / 0.8660254;
        CHECK_NEAR(0.04, near_zero == 1 ? one : three, turned);
    }
}

/// Dead time holds a phase at zero for up to 60 degrees.
static void test_a_phase_that_dead_time_may_hold_has_a_quarter_turn(void) {
    const double open = turn_until_found(false, 0.0f);
    CHECK_AT_LEAST(sqrt(64.0 * GAIN_A / 3.6), open); // 3.6 A (1 - cos(turn/2)) are 8 counts
    CHECK_AT_MOST(0.6, open);
    const double clamped = turn_until_found(true, 0.0f);
    CHECK_NEAR(1.0e-6, clamped, turn_until_found(true, 1.0f)); // 3.6 V of 10 V
    TEST_ASSERT_TRUE(clamped > CHECK_PI / 2.0);
    CHECK_AT_MOST(CHECK_PI / 2.0 + 0.3, clamped);
    // It holds none where the inductance asks for more voltage: then luck alone may, for a sixth of a turn.
    const double lucky = turn_until_found(true, 3.0f);
    TEST_ASSERT_TRUE(lucky > CHECK_PI / 3.0);
    CHECK_AT_MOST(CHECK_PI / 3.0 + 0.3, lucky);
}

/// All three still, and the vector turned by 0.3 rad: stuck, unless the current that is asked for changes as well.
/// By 0.9 rad: stuck.
static void test_three_that_keep_still_may_while_the_current_changes(void) {
    for (int n = 0; n < 4; n++) {
        const bool changes = n == 1 || n == 2;
        const float turn_rad = n == 2 ? 0.9f : 0.3f;
        bench_t self = bench(3.6, 0.0);
        const int32_t i[LODE_PHASES] = {300 * LODE_COUNT_FRACTION, -100 * LODE_COUNT_FRACTION,
                                        -200 * LODE_COUNT_FRACTION};
        lode_finding_t found = {.check = LODE_CHECK_NONE};
        for (int check = 0; check < 3; check++) {
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, found.check);
            const float before_A2 = n == 3 ? 11.0f : 12.0f; // hardly a change
            const float i_A2 = check == 2 ? 12.0f : (changes ? 4.0f : before_A2);
            found = judge(&self.state, &self.tuning, i, i_A2, turn_rad);
        }
        TEST_ASSERT_EQUAL_INT(n == 1 ? LODE_CHECK_NONE : LODE_CHECK_CURRENT_STUCK, found.check);
    }
}

/// What is found in half a turn beside phase `held` at `count`, the sum of the three being `share` of the current.
static lode_check_t beside(bool six, int held, int32_t count, double share) {
    bench_t self = bench(3.6, 0.0);
    lode_finding_t found = {.check = LODE_CHECK_NONE};
    self.tuning.i_still = six ? 4 * LODE_COUNT_FRACTION : 0;
    self.tuning.i_sum = INT32_MAX;
    for (double turned = 0.0; turned < 3.1 && found.check == LODE_CHECK_NONE; turned += 0.05) {
        const int32_t sum = (int32_t)(share * 3.6 / GAIN_A * LODE_COUNT_FRACTION);
        const int32_t b = LODE_COUNT_FRACTION * (int32_t)lround(3.6 * sin(turned) / GAIN_A);
        int32_t i[LODE_PHASES];
        i[held] = count * LODE_COUNT_FRACTION;
        i[(held + 1) % 3] = b;
        i[(held + 2) % 3] = sum - b - i[held];
        found = judge(&self.state, &self.tuning, i, (float)(3.6 * 3.6), 0.05f);
    }
    return found.check;
}

/// A phase near zero may be open instead, where the other two add up to none: with six phases that is another check.
static void test_a_phase_that_stays_near_zero_may_be_left_out(void) {
    static const int32_t counts[] = {-5, -4, -3, 0, 3, 4, 5};
    for (int n = 0; n < 2 * 3 * COUNT_OF(counts); n++) {
        const bool six = n % 2 == 1;
        const int phase = n / 2 % 3;
        const int32_t count = counts[n / 6];
        const lode_check_t open =
            six && count > -4 && count < 4 ? LODE_CHECK_NONE : LODE_CHECK_CURRENT_STUCK;
        TEST_ASSERT_EQUAL_INT(open, beside(six, phase, count, 0.0));
        TEST_ASSERT_EQUAL_INT(open, beside(six, phase, count, 0.19));
        TEST_ASSERT_EQUAL_INT(open, beside(six, phase, count, -0.19));
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_STUCK, beside(six, phase, count, 0.21));
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_STUCK, beside(six, phase, count, -0.21));
    }
}

/// One of three that is found stuck is open where its count is within 4 of its offset, and the sum is none to within 4 counts and 5 %
/// of the current.
static void test_a_phase_without_current_is_open(void) {
    for (int n = 0; n < LODE_PHASES; n++) {
        bench_t self = bench(3.6, 0.0); // 288 counts
        self.state.i_A2 = (float)(3.6 * 3.6);
        for (int sign = -1; sign <= 1; sign += 2) {
            static const struct {
                int count, sum;
                bool open;
            } cases[] = {{0, 0, true}, {4, 0, true}, {5, 0, false}, {0, 17, true}, {0, 20, false}};
            for (int k = 0; k < COUNT_OF(cases); k++) {
                const int32_t a = sign * cases[k].count;
                const int32_t sum = sign * cases[k].sum;
                self.state.i[n] = a * LODE_COUNT_FRACTION;
                self.state.i[(n + 1) % 3] = 200 * LODE_COUNT_FRACTION;
                self.state.i[(n + 2) % 3] = (sum - a - 200) * LODE_COUNT_FRACTION;
                TEST_ASSERT_EQUAL(cases[k].open, lode_plausibility_is_open(
                                                     &self.state, (uint32_t)n + 1u, A_PER_COUNT));
                TEST_ASSERT_FALSE(lode_plausibility_is_open(&self.state, 0u, A_PER_COUNT));
                TEST_ASSERT_FALSE(lode_plausibility_is_open(&self.state, 4u, A_PER_COUNT));
            }
        }
    }
}

/// All six that keep still: 32 counts of the current that is asked for, of 0.05 of i_max at least.
static void test_no_open_phase_explains_that_nothing_flows(void) {
    const lode_plausibility_tuning_t t = bench(0.0, 0.0).tuning;
    const double needed_rad = 32.0 * GAIN_A / (0.5 * sqrt(3.0)); // of an ampere
    for (int sign = -1; sign <= 1; sign += 2) {
        for (double i_A = 0.61; i_A < 12.0; i_A *= 1.5) {
            const float i_A2 = (float)(i_A * i_A);
            const double turn_rad = sign * needed_rad / i_A;
            TEST_ASSERT_TRUE(
                lode_plausibility_none_flows(&t, i_A2, (float)(1.01 * turn_rad), A_PER_COUNT));
            TEST_ASSERT_FALSE(
                lode_plausibility_none_flows(&t, i_A2, (float)(0.99 * turn_rad), A_PER_COUNT));
        }
    }
    TEST_ASSERT_FALSE(lode_plausibility_none_flows(&t, 0.59f * 0.59f, 3.0f, A_PER_COUNT));
}

/// Little current asked for: the dead time may hold phases at zero.
static void test_without_current_nothing_is_stuck(void) {
    bench_t self = bench(0.59, 300.0);
    expect_none(&self, 20);
    self.stuck = 4;
    expect_none(&self, 2000);
    self.ref_A = 0.61; // 0.05 of i_max
    lode_finding_t found;
    // What was kept before says nothing: a sound count moves only after the current has been asked for.
    CHECK_AT_MOST(5.0e-3, until_found(&self, &found));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_STUCK, found.check);
}

/// A motor that idles at a high speed and is told to accelerate: the counts, all alike until then, move a check
/// after the current has been asked for.
static void test_counts_that_were_kept_without_current_may_still_be_good(void) {
    bench_t self = bench(0.0, 1100.0);
    expect_none(&self, 100);
    self.ref_A = I_MAX_A;
    expect_none(&self, 1);
    self.i_A = I_MAX_A;
    expect_none(&self, 100);
}

/// Before the vector turns: the current that is asked for rises and no count moves.
static void test_all_that_do_not_follow_a_rising_current_are_stuck(void) {
    bench_t self = bench(0.0, 0.0);
    lode_finding_t found = {LODE_CHECK_NONE, 0.0f, 0.0f};
    for (int n = 0; n < 200 && found.check == LODE_CHECK_NONE; n++) {
        self.ref_A = 0.05 * n;
        found = check(&self);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_STUCK, found.check);
    TEST_ASSERT_TRUE(found.measured == 0.0f);
    CHECK_NEAR(0.11, 0.1 * (double)I_MAX_A, self.ref_A);
    for (int moving = 0; moving < 3; moving++) { // any count that moves is one that follows
        bench_t sound = bench(0.0, 0.0);
        lode_sample_t sample = {.omitted = LODE_PHASES};
        for (int n = 0; n < 200; n++) {
            sample.i[moving] = n;
            const float i_A = 0.05f * (float)n;
            TEST_ASSERT_EQUAL_INT(
                LODE_CHECK_NONE,
                judge(&sound.state, &sound.tuning, sample.i, i_A * i_A, 0.0f).check);
        }
    }
}

/// At a large current the EMF of a rotor that swings may hold the current while its reference rises a little.
static void test_none_need_follow_a_little_more_of_a_large_current(void) {
    const double held[] = {0.2, 0.5, 0.8};
    for (int k = 0; k < COUNT_OF(held); k++) {
        bench_t self = bench(held[k] * (double)I_MAX_A, 0.0);
        expect_none(&self, 10);
        const double from_A = self.ref_A;
        lode_finding_t found = {LODE_CHECK_NONE, 0.0f, 0.0f};
        for (int n = 0; n < 200 && found.check == LODE_CHECK_NONE; n++) {
            self.ref_A = from_A + 1.0e-3 * (double)I_MAX_A * n;
            found = check(&self);
        }
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_STUCK, found.check);
        CHECK_AT_LEAST(0.05 * (double)I_MAX_A, self.ref_A - from_A);
        CHECK_AT_MOST(0.06 * (double)I_MAX_A, self.ref_A - from_A);
    }
}

/// A load comes on while a phase is on its way to zero: what the current rises by, the phase loses by the turn.
static void test_a_phase_that_a_rising_current_holds_is_not_stuck(void) {
    bench_t self = bench(1.0, 470.0);
    expect_none(&self, 200);
    self.theta = 0.0;
    for (int n = 0; n < 4; n++) { // cos(theta) i stays
        self.i_A = self.ref_A = 1.0 / cos(self.theta);
        expect_none(&self, 1);
    }
    TEST_ASSERT_TRUE(self.i_A > 2.0);
}

/// At high speed the checks lie far apart: a current with ripple may happen on the same count at three of them.
static void test_three_looks_far_apart_are_luck(void) {
    const float far = 1.25f; // between two checks: 20 periods per turn
    for (int equal = 2; equal <= 8; equal++) {
        bench_t self = bench(3.6, 0.0);
        lode_finding_t found = {.check = LODE_CHECK_NONE};
        for (int n = 0; n < equal; n++) {
            const int32_t b = (100 + 40 * n) * LODE_COUNT_FRACTION;
            const int32_t i[LODE_PHASES] = {150 * LODE_COUNT_FRACTION, b,
                                            -150 * LODE_COUNT_FRACTION - b};
            found = judge(&self.state, &self.tuning, i, (float)(3.6 * 3.6), far);
        }
        TEST_ASSERT_EQUAL_INT(equal < 6 ? LODE_CHECK_NONE : LODE_CHECK_CURRENT_STUCK, found.check);
    }
}

/// Turn in which a phase that keeps its count near its peak is named, where the sum of the three is off by a share of the
/// current. Two of three checks lie a tenth of a radian apart.
static double turn_at_a_sum(double share) {
    bench_t self = bench(3.6, 0.0);
    lode_finding_t found = {.check = LODE_CHECK_NONE};
    double turned =
        -0.2; // the first check says nothing, and the second may lie on the other side of a peak
    for (; turned < 2.0 && found.check == LODE_CHECK_NONE; turned += 0.1) {
        const int32_t a = 270 * LODE_COUNT_FRACTION;
        const int32_t b = LODE_COUNT_FRACTION * (int32_t)lround(100.0 * turned);
        const int32_t sum = LODE_COUNT_FRACTION * (int32_t)lround(share * 3.6 / GAIN_A);
        const int32_t i[LODE_PHASES] = {a, b, sum - a - b};
        found = judge(&self.state, &self.tuning, i, (float)(3.6 * 3.6), 0.1f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_STUCK, found.check);
    TEST_ASSERT_TRUE(found.measured == 1.0f);
    return turned;
}

/// Gains that differ leave a sum where nothing is stuck, here up to 2 % and 4 counts of 288: such a phase may keep its count for a
/// sixth of a turn by luck. Beside a larger sum it is stuck once it would have moved by 8 counts.
static void test_gains_that_differ_do_not_make_a_phase_stuck(void) {
    CHECK_NEAR(0.15, 0.5, turn_at_a_sum(0.045));
    CHECK_NEAR(0.15, 0.5, turn_at_a_sum(-0.045));
    CHECK_NEAR(0.15, 1.05, turn_at_a_sum(0.025));
    CHECK_NEAR(0.15, 1.05, turn_at_a_sum(-0.025));
    CHECK_NEAR(0.15, 1.05, turn_at_a_sum(0.0));
}

static void test_a_sum_that_lasts_is_found(void) {
    bench_t self = bench(3.0, 300.0);
    lode_finding_t found;
    self.offset_A = 1.75;
    expect_none(&self, 1000);
    self.offset_A = 1.85;
    const double found_s = until_found(&self, &found);
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_SUM", lode_check_name(found.check));
    CHECK_NEAR(LOOK_s, 15.0e-3, found_s);
    CHECK_NEAR(0.02, 1.85, found.measured);
    CHECK_CLOSE(1.0e-5, 1.8, found.limit);
    bench_t negative = bench(3.0, 300.0);
    negative.offset_A = -1.9;
    (void)until_found(&negative, &found);
    CHECK_NEAR(0.02, -1.9, found.measured);
    // Now and then is not enough, and is forgotten.
    bench_t seldom = bench(3.0, 300.0);
    for (int n = 0; n < 1000; n++) {
        seldom.offset_A = n % 2 == 0 ? 5.0 : 0.0;
        expect_none(&seldom, 1);
    }
    seldom.offset_A = 0.0;
    expect_none(&seldom, 3);
    TEST_ASSERT_EQUAL_INT(0, seldom.state.sum);
    // Check by check: each good one takes back a bad one.
    bench_t partly = bench(3.0, 300.0);
    partly.offset_A = 5.0;
    expect_none(&partly, 10);
    partly.offset_A = 0.0;
    expect_none(&partly, 5);
    partly.offset_A = 5.0;
    expect_none(&partly, (int)SUM_CHECKS - 1 - 5);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_SUM, check(&partly).check);
}

/// Counts whose sum is just the limit, of either sign, are good; one more is not.
static void test_the_limit_itself_is_no_sum(void) {
    const bench_t self = bench(3.0, 300.0);
    const int32_t limit = self.tuning.i_sum;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const int32_t at[LODE_PHASES] = {sign * limit, 5, -5};
        const int32_t beyond[LODE_PHASES] = {sign * (limit + 1), 5, -5};
        TEST_ASSERT_TRUE(lode_plausibility_sum_ok(&self.tuning, at));
        TEST_ASSERT_FALSE(lode_plausibility_sum_ok(&self.tuning, beyond));
    }
}

static void test_reset_forgets(void) {
    bench_t self = bench(3.0, 300.0);
    self.offset_A = 5.0;
    expect_none(&self, 10);
    lode_plausibility_reset(&self.state);
    const lode_plausibility_t fresh = {.sum = 0u};
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &self.state, sizeof fresh);
}

/// Whatever came before: what is chance is noted as by the long way, or all is left to that.
static void test_what_is_chance_is_noted_as_by_the_long_way(void) {
    random_t random = random_seed(7);
    bench_t self = bench(6.0, 100.0);
    const int32_t most_counts = self.tuning.i_sum / LODE_COUNT_FRACTION;
    int chances = 0;
    for (int n = 0; n < 200000; n++) {
        lode_plausibility_t before = {.sum = (uint_least16_t)(random_bits(&random) % 4u == 0u)};
        int32_t i[3];
        for (int k = 0; k < 3; k++) {
            const int32_t wide = random_bits(&random) % 8u == 0u ? most_counts : 2;
            i[k] = LODE_COUNT_FRACTION *
                   ((int32_t)(random_bits(&random) % (uint32_t)(2 * wide + 1)) - wide);
            before.i[k] = random_bits(&random) % 2u == 0u
                              ? i[k]
                              : LODE_COUNT_FRACTION * (int32_t)(random_bits(&random) % 3u);
        }
        before.kept = (uint_least8_t)(random_bits(&random) % 8u);
        before.still = (uint_least8_t)(before.kept & random_bits(&random) % 8u);
        before.still |= before.still != 0u ? (uint_least8_t)(random_bits(&random) % 2u * 8u) : 0u;
        before.turn_rad = random_float(&random, 0.0, 0.1);
        before.i_A2 = random_float(&random, 0.0, 4.0);
        before.moved_A2 = random_float(&random, 0.0, 0.1);
        self.tuning.i_still = (int32_t)(random_bits(&random) % 2u) * LODE_COUNT_FRACTION;
        const float i_A2 = random_float(&random, 0.0, 2.0) * self.tuning.i_min_A2;
        lode_plausibility_t shortly = before;
        lode_plausibility_t whole = before;
        const uint32_t again = lode_plausibility_check(&shortly, i);
        if (lode_plausibility_is_chance(&shortly, &self.tuning, again, i_A2)) {
            const lode_finding_t found = judge(&whole, &self.tuning, i, i_A2, 0.01f);
            TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, found.check);
            chances++;
        } else {
            (void)lode_plausibility_check(&whole, i);
        }
        TEST_ASSERT_EQUAL_MEMORY(&whole, &shortly, sizeof whole);
    }
    CHECK_AT_LEAST(20000, chances);
    CHECK_AT_LEAST(20000, 200000 - chances);
}

/// Counts that are now kept and now not, under currents that now change and now do not: the short ways find what
/// looking at all in full finds, and when that does.
static void test_the_short_ways_find_the_same(void) {
    random_t random = random_seed(11);
    bench_t self = bench(6.0, 100.0);
    lode_plausibility_t shortly = self.state;
    int32_t i[LODE_PHASES] = {0, 0, 0};
    int found[LODE_PHASES + 1] = {0};
    int sums = 0;
    uint32_t moving = 0u;
    float i_A2 = 0.0f;
    for (int n = 0; n < 400000; n++) {
        if (random_bits(&random) % 8u == 0u) { // every few checks
            moving = random_bits(&random) % 8u;
            i_A2 = random_float(&random, 0.0, 6.0) * self.tuning.i_min_A2;
            self.tuning.i_still = (int32_t)(random_bits(&random) % 2u) * 20 * LODE_COUNT_FRACTION;
        }
        for (uint32_t k = 0; k < LODE_PHASES; k++) {
            const int32_t to = (int32_t)(random_bits(&random) % 181u) - 90;
            i[k] = (moving & 1u << k) != 0u ? to * LODE_COUNT_FRACTION : i[k];
        }
        const float turn_rad = random_float(&random, -0.2, 0.8);
        const lode_finding_t whole = judge(&self.state, &self.tuning, i, i_A2, turn_rad);
        const lode_finding_t fast = judge_shortly(&shortly, &self.tuning, i, i_A2, turn_rad);
        TEST_ASSERT_EQUAL_INT(whole.check, fast.check);
        TEST_ASSERT_TRUE(lode_in_range(whole.measured, fast.measured, fast.measured));
        found[whole.check == LODE_CHECK_CURRENT_STUCK ? (int)whole.measured : 0] +=
            whole.check == LODE_CHECK_CURRENT_STUCK ? 1 : 0;
        sums += whole.check == LODE_CHECK_CURRENT_SUM ? 1 : 0;
        if (whole.check != LODE_CHECK_NONE) {
            lode_plausibility_reset(&self.state);
            lode_plausibility_reset(&shortly);
        }
    }
    for (int which = 0; which <= LODE_PHASES; which++) {
        CHECK_AT_LEAST(100, found[which]);
    }
    CHECK_AT_LEAST(10, sums);
}

static void test_configuration(void) {
    lode_plausibility_tuning_t tuning;
    lode_guard_config_t config = sound_config();
    config.plausibility = LODE_OFF;
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&tuning, &config));
    TEST_ASSERT_TRUE(tuning.i_sum < 0);
    CHECK_AT_MOST(0.0, tuning.per_wave_A);
    CHECK_AT_MOST(-1.0, tuning.frozen_A2);
    config.plausibility = LODE_AUTO; // design decides
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, tune(&tuning, &config));
    const float bad[] = {0.0f, 0.0119f, 121.0f, -2.0f, NAN, INFINITY};
    for (int n = 0; n < COUNT_OF(bad); n++) {
        config = sound_config();
        config.i_sum_A = bad[n];
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_CURRENT, tune(&tuning, &config));
    }
    const float good[] = {1.0e-3f * I_MAX_A, 10.0f * I_MAX_A, LODE_NONE};
    for (int n = 0; n < COUNT_OF(good); n++) {
        config.i_sum_A = good[n];
        TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&tuning, &config));
        CHECK_CLOSE(1.0e-5, 0.5 * LODE_COUNT_FRACTION / GAIN_A, tuning.per_wave_A);
    }
    bench_t self = bench(3.0, 300.0);
    self.tuning = tuning;
    self.offset_A = 100.0;
    expect_none(&self, 100);
}

// --- A vector that is frozen ----------------------------------------------------------------------

/// Four times the square of the least current, 0.05 of i_max, are enough.
static void test_what_is_reported_from_elsewhere_counts_in_shares(void) {
    const bench_t self = bench(3.0, 300.0);
    lode_plausibility_t watch = {.moved_A2 = 1.0f};
    lode_plausibility_add(&watch, &self.tuning, 0.25f);
    const double least_A = 0.05 * (double)I_MAX_A;
    CHECK_CLOSE(1.0e-5, 1.0 + least_A * least_A, watch.moved_A2);
}

static void test_noise_does_not_move_a_frozen_vector(void) {
    bench_t self = bench(3.0, 300.0);
    CHECK_CLOSE(1.0e-6, 3.0 * GAIN_A, sqrt((double)self.tuning.frozen_A2));
    CHECK_CLOSE(1.0e-6, 0.05 * (double)I_MAX_A, sqrt((double)self.tuning.moves_A2));
    const lode_guard_config_t config = sound_config();
    const lode_sense_tuning_t coarse = {.i_gain = (float)(-0.1 / LODE_COUNT_FRACTION)};
    lode_plausibility_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_plausibility_tune(&tuning, &config, I_MAX_A, &coarse));
    CHECK_CLOSE(1.0e-6, 0.3, sqrt((double)tuning.frozen_A2));
    CHECK_CLOSE(1.0e-6, 3.7, sqrt((double)tuning.moves_A2));
    // A count of each phase from one end of its noise to the other.
    for (int ends = 0; ends < 8; ends++) {
        const double a = (ends & 1) > 0 ? GAIN_A : -GAIN_A;
        const double b = (ends & 2) > 0 ? GAIN_A : -GAIN_A;
        const double c = (ends & 4) > 0 ? GAIN_A : -GAIN_A;
        const lode_ab_t end = {(float)((2.0 * a - b - c) / 3.0), (float)((b - c) / sqrt(3.0))};
        lode_frozen_t frozen = {.i_A = {-end.alpha, -end.beta}, .checks = 7u};
        TEST_ASSERT_FALSE(lode_frozen_moves(&frozen, &self.tuning, end));
        TEST_ASSERT_EQUAL_UINT(7u, frozen.checks);
        CHECK_NEAR(0.0, -(double)end.alpha, frozen.i_A.alpha);
    }
    for (int axis = 0; axis < 2; axis++) {
        const float beyond = (float)(3.01 * GAIN_A);
        const lode_ab_t i_A = {axis == 0 ? beyond : 0.0f, axis == 0 ? 0.0f : -beyond};
        lode_frozen_t frozen = {.checks = 7u};
        TEST_ASSERT_TRUE(lode_frozen_moves(&frozen, &self.tuning, i_A));
        TEST_ASSERT_EQUAL_UINT(0u, frozen.checks);
        CHECK_NEAR(0.0, (double)i_A.alpha, frozen.i_A.alpha);
        CHECK_NEAR(0.0, (double)i_A.beta, frozen.i_A.beta);
        TEST_ASSERT_TRUE(lode_frozen_moves(&frozen, &self.tuning, (lode_ab_t){NAN, 0.0f}));
    }
    self.tuning.frozen_A2 = -1.0f; // off
    lode_frozen_t off = {.checks = 0u};
    TEST_ASSERT_TRUE(lode_frozen_moves(&off, &self.tuning, off.i_A));
}

/// Checks with a current asked for that turns by `turn_rad` a check, of `i_A`: those until it is frozen, at most `most`.
static int checks_until_frozen(double i_A, double turn_rad, bool follows, int most) {
    const bench_t self = bench(3.0, 300.0);
    lode_frozen_t frozen = {.checks = 0u, .way_A = {1.0f, 1.0f}};
    for (int check = 1; check < most; check++) {
        const double theta = turn_rad * check;
        const lode_ab_t ref_A = {(float)(i_A * cos(theta)), (float)(i_A * sin(theta))};
        if (lode_frozen_check(&frozen, &self.tuning, ref_A) &&
            (follows || lode_frozen_turned(&frozen, (float)turn_rad))) {
            return check;
        }
    }
    return most;
}

static void test_a_vector_that_does_not_follow_is_frozen(void) {
    // 0.6 A of 3 are 0.2003 rad: the third check is that far from the first, and the fourth too.
    TEST_ASSERT_EQUAL_INT(4, checks_until_frozen(3.0, 0.101, true, 100));
    TEST_ASSERT_EQUAL_INT(4, checks_until_frozen(3.0, -0.101, true, 100));
    TEST_ASSERT_EQUAL_INT(5, checks_until_frozen(3.0, 0.099, true, 100));
    TEST_ASSERT_EQUAL_INT(100, checks_until_frozen(3.0, 0.0, true, 100));
    TEST_ASSERT_EQUAL_INT(100, checks_until_frozen(0.29, 0.3, true, 100)); // too little
    // Where the EMF takes the voltage: a turn and 0.2003 rad, and a check from there. Either way.
    TEST_ASSERT_EQUAL_INT(67, checks_until_frozen(3.0, 0.101, false, 100));
    TEST_ASSERT_EQUAL_INT(67, checks_until_frozen(3.0, -0.101, false, 100));
}

static void test_a_frozen_vector_is_missed_at_two_looks_in_a_row(void) {
    const bench_t self = bench(3.0, 300.0);
    lode_frozen_t frozen = {.checks = 0u};
    for (int check = 0; check < 20; check++) { // there and back
        const lode_ab_t ref_A = {check % 2 == 1 ? 2.0f : 0.0f, 0.0f};
        TEST_ASSERT_FALSE(lode_frozen_check(&frozen, &self.tuning, ref_A));
    }
    frozen = (lode_frozen_t){.checks = LODE_FROZEN_CHECKS, .way_A = {1.0f, 0.0f}};
    const lode_ab_t none = {0.0f, 0.0f};
    TEST_ASSERT_FALSE(lode_frozen_check(&frozen, &self.tuning, none));
    TEST_ASSERT_EQUAL_UINT(LODE_FROZEN_CHECKS, frozen.checks);
    CHECK_NEAR(0.0, 0.0, frozen.way_A.alpha);
}

/// A reference that goes to the other side meanwhile: the current may be seen on its way through where it was.
static void test_a_reference_that_alternates_freezes_nothing(void) {
    const bench_t self = bench(3.0, 300.0);
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int angle = 0; angle < 8; angle++) {
            const lode_sincos_t at = lode_sincos(0.7854f * (float)angle);
            lode_frozen_t frozen = {.checks = 0u};
            TEST_ASSERT_FALSE(lode_frozen_check(&frozen, &self.tuning, (lode_ab_t){5.0f, 5.0f}));
            float way = 2.0f;
            for (int check = 0; check < 20; check++, way *= (float)sign) {
                const lode_ab_t ref_A = {5.0f + way * at.cos, 5.0f + way * at.sin};
                const bool frozen_now = lode_frozen_check(&frozen, &self.tuning, ref_A);
                TEST_ASSERT_EQUAL(sign > 0 && check > 0, frozen_now);
            }
        }
    }
}

// --- Load -----------------------------------------------------------------------------------------

#define RISE_rad_s2 100.0f
#define RATED_rad_s 0.001f // so slow that it does not matter
#define ROUND_s (8.0 * 1.0e-4)
#define FASTER_TIMES 2.0

static lode_plausibility_tuning_t load_tuning(float overload_s) {
    lode_guard_config_t config = sound_config();
    config.overload_s = overload_s;
    lode_plausibility_tuning_t tuning = {.i_sum = 0};
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_plausibility_tune_load(&tuning, &config, RISE_rad_s2, RATED_rad_s, 1.0e-4f));
    return tuning;
}

/// (K19): with `times` the torque of i_max as a load, the rounds until that is too much; 0: not within 20 000. `sense` of
/// the torque, which drives a rotor that turns on, or brakes it.
static int overload_rounds(float overload_s, double times, float sense, bool brakes) {
    const lode_plausibility_tuning_t tuning = load_tuning(overload_s);
    double omega = (brakes ? -200.0 : 200.0) * (double)sense;
    lode_load_t load = {.held_rad_s = (float)omega};
    for (int n = 1; n <= 20000; n++) {
        omega -= (double)sense * (times - 1.0) * (double)RISE_rad_s2 * ROUND_s;
        if (lode_load_is_too_large(&load, &tuning, sense, (float)omega)) {
            return n;
        }
    }
    return 0;
}

static void test_a_load_that_no_torque_holds_is_too_large(void) {
    for (int sense = -1; sense <= 1; sense += 2) {
        const float times_s[] = {0.03f, 0.1f};
        for (int n = 0; n < COUNT_OF(times_s); n++) {
            const float s = times_s[n];
            const double twice = (double)s / (2.0 - 1.0 - 0.1) / ROUND_s;
            CHECK_NEAR(1.5, twice, overload_rounds(s, 2.0, (float)sense, false));
            const double half = (double)s / (1.5 - 1.0 - 0.1) / ROUND_s;
            CHECK_NEAR(1.5, half, overload_rounds(s, 1.5, (float)sense, false));
            // Hardly more than the torque may stop a rotor slowly. One that it makes faster is not waited for (K29).
            TEST_ASSERT_EQUAL_INT(0, overload_rounds(s, 1.09, (float)sense, false));
            const double hardly = FASTER_TIMES * (double)s / ROUND_s;
            CHECK_NEAR(1.5, hardly, overload_rounds(s, 1.11, (float)sense, true));
            CHECK_NEAR(1.5, (double)s / 1.5 / ROUND_s, overload_rounds(s, 2.5, (float)sense, true));
            const double least = 0.1 * (double)s / 0.04 / ROUND_s;
            CHECK_NEAR(1.5, least, overload_rounds(s, 1.04, (float)sense, true));
            const double faster = (double)s / (2.0 - 1.0) / ROUND_s;
            CHECK_NEAR(1.5, faster, overload_rounds(s, 2.0, (float)sense, true));
            // Less: the speed goes where it should.
            TEST_ASSERT_EQUAL_INT(0, overload_rounds(s, 0.9, (float)sense, false));
            TEST_ASSERT_EQUAL_INT(0, overload_rounds(s, 0.9, (float)sense, true));
        }
    }
}

/// A speed that comes back is where the next one is counted from.
static void test_a_speed_that_comes_back_was_no_load_too_large(void) {
    const lode_plausibility_tuning_t tuning = load_tuning(0.03f);
    CHECK_CLOSE(1.0e-5, 3.0, tuning.away_rad_s);
    CHECK_CLOSE(1.0e-5, 0.1 * 100.0 * ROUND_s, tuning.away_step);
    lode_load_t load = {.held_rad_s = 10.0f};
    TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, 1.0f, 7.1f));
    CHECK_CLOSE(1.0e-5, 10.0 - (double)tuning.away_step, load.held_rad_s);
    TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, 1.0f, 11.0f));
    CHECK_CLOSE(1.0e-6, 11.0, load.held_rad_s);
    TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, 1.0f, 10.999f));
    CHECK_CLOSE(1.0e-6, 10.999, load.held_rad_s); // no further than the speed
    TEST_ASSERT_TRUE(lode_load_is_too_large(&load, &tuning, 1.0f, 7.9f));
    load = (lode_load_t){.held_rad_s = 10.0f};
    TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, -1.0f, 7.0f));
    TEST_ASSERT_TRUE(lode_load_is_too_large(&load, &tuning, -1.0f, 10.1f));
    TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, 1.0f, NAN));
    TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, 1.0f, 5.0f));
    CHECK_CLOSE(1.0e-6, 5.0, load.held_rad_s);
    for (int n = 0; n < 4; n++) { // a rotor that hardly turns any more, or not, does not get faster
        const float sense = n < 2 ? 1.0f : -1.0f;
        load = (lode_load_t){.held_rad_s = 0.8f * sense};
        TEST_ASSERT_FALSE(
            lode_load_is_too_large(&load, &tuning, sense, n % 2 == 0 ? 0.5f * sense : 0.0f));
        CHECK_CLOSE(1.0e-6, 0.8 - (double)tuning.away_step, load.held_rad_s * sense);
    }
    load = (lode_load_t){.held_rad_s = tuning.away_rad_s}; // so much may be
    TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, 1.0f, 0.0f));
}

/// (K42): how long a rotor may stand still under all the torque. What turns in between begins anew.
static void test_a_rotor_that_hardly_turns_is_stalled(void) {
    const struct {
        float overload_s;
        double stall_s;
    } cases[] = {{0.03f, 0.5}, {3.0f, 9.0}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        lode_guard_config_t config = sound_config();
        config.overload_s = cases[n].overload_s;
        lode_plausibility_tuning_t tuning = {.i_sum = 0};
        TEST_ASSERT_EQUAL_INT(
            LODE_OK, lode_plausibility_tune_load(&tuning, &config, RISE_rad_s2, 50.0f, 1.0e-4f));
        CHECK_NEAR(1.0, cases[n].stall_s / ROUND_s, tuning.stall_rounds);
        CHECK_CLOSE(1.0e-6, 1.5, tuning.stall_rad_s);
        lode_load_t load = {.stalled = 0u};
        for (uint32_t k = 1; k < tuning.stall_rounds; k++) {
            TEST_ASSERT_FALSE(
                lode_load_stalls(&load, &tuning, k % 2u == 0u ? 1.49f : -1.49f, 50.0f));
        }
        TEST_ASSERT_FALSE(lode_load_stalls(&load, &tuning, tuning.stall_rad_s, 50.0f));
        for (uint32_t k = 1; k < tuning.stall_rounds; k++) {
            TEST_ASSERT_FALSE(lode_load_stalls(&load, &tuning, 0.0f, 1.6f));
        }
        lode_load_t held = load;
        TEST_ASSERT_TRUE(lode_load_stalls(&load, &tuning, 0.0f, 1.6f));
        // A rotor that is to stand, or to creep, may be held.
        TEST_ASSERT_FALSE(lode_load_stalls(&held, &tuning, 0.0f, tuning.stall_rad_s));
        TEST_ASSERT_EQUAL_UINT(0u, held.stalled);
    }
    TEST_ASSERT_EQUAL_UINT(0u, load_tuning(LODE_NONE).stall_rounds);
    TEST_ASSERT_EQUAL_UINT(1u, load_tuning(1.0e-4f).stall_rounds); // less than a round
}

/// (K29): by how much a rotor that all the torque brakes is faster, and for how long, running.
static void test_a_braked_rotor_that_gets_faster_for_long(void) {
    const lode_plausibility_tuning_t tuning = load_tuning(0.03f);
    const uint32_t checks = (uint32_t)(FASTER_TIMES * 0.03 / ROUND_s) + 1u;
    const float more = 0.101f * tuning.away_rad_s;
    const float less = 0.099f * tuning.away_rad_s;
    for (int sense = -1; sense <= 1; sense += 2) {
        const float s = (float)sense;
        lode_load_t load = {.held_rad_s = -50.0f * s};
        for (uint32_t n = 1u; n < checks; n++) {
            TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, s, -(50.0f + more) * s));
            TEST_ASSERT_EQUAL_UINT(n, load.faster);
        }
        lode_load_t late = load;
        TEST_ASSERT_FALSE(lode_load_is_too_large(&late, &tuning, s, -(50.0f + less) * s));
        late = load;
        TEST_ASSERT_TRUE(lode_load_is_too_large(&late, &tuning, s, -(50.0f + more) * s));
        // It was back, or did not get faster.
        late = load;
        TEST_ASSERT_FALSE(lode_load_is_too_large(&late, &tuning, s, -49.0f * s));
        TEST_ASSERT_EQUAL_UINT(0u, late.faster);
        load.held_rad_s = 51.0f * s;
        TEST_ASSERT_FALSE(lode_load_is_too_large(&load, &tuning, s, 50.0f * s));
        TEST_ASSERT_EQUAL_UINT(0u, load.faster);
        // As many as the counter holds.
        load = (lode_load_t){.held_rad_s = -50.0f * s, .faster = 65535u};
        TEST_ASSERT_TRUE(lode_load_is_too_large(&load, &tuning, s, -(50.0f + more) * s));
        TEST_ASSERT_EQUAL_UINT(65535u, load.faster);
    }
}

static void test_configuration_of_the_load(void) {
    lode_guard_config_t config = sound_config();
    lode_plausibility_tuning_t tuning = {.i_sum = 0};
    const float bad[] = {0.0f, 0.99e-4f, 10.1f, -2.0f, NAN, INFINITY};
    for (int n = 0; n < COUNT_OF(bad); n++) {
        config.overload_s = bad[n];
        TEST_ASSERT_EQUAL_INT(
            LODE_ERROR_GUARD_TIME,
            lode_plausibility_tune_load(&tuning, &config, RISE_rad_s2, RATED_rad_s, 1.0e-4f));
    }
    const float good[] = {1.0e-4f, 10.0f, LODE_NONE};
    for (int n = 0; n < COUNT_OF(good); n++) {
        CHECK_CLOSE(1.0e-5, n == 2 ? 0.0 : 100.0 * (double)good[n],
                    load_tuning(good[n]).away_rad_s);
    }
    // A heavy rotor: 5 % of rated speed at least.
    config.overload_s = 0.03f;
    for (int n = 0; n < 2; n++) {
        const float rated_rad_s = n == 0 ? 59.0f : 61.0f;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_plausibility_tune_load(&tuning, &config, RISE_rad_s2,
                                                                   rated_rad_s, 1.0e-4f));
        CHECK_CLOSE(1.0e-5, n == 0 ? 3.0 : 3.05, tuning.away_rad_s);
    }
    config.overload_s = 0.1f;
    config.plausibility = LODE_OFF;
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_plausibility_tune_load(&tuning, &config, RISE_rad_s2, RATED_rad_s, 1.0e-4f));
    CHECK_AT_MOST(0.0, tuning.away_rad_s);
}

// --- Half-waves -----------------------------------------------------------------------------------

static const lode_plausibility_tuning_t waves_tuning = {.i_min_A2 = 0.25f, .per_wave_A = 50.0f};

/// One check of a vector of `i_A` in the direction `turns`, of the half-waves of `missing`, a bit each as in
/// lode_waves_t, no more than `left` of i_A. A count of 1/256 is 10 mA.
static uint_least8_t wave_check(lode_waves_t *self, uint32_t missing, float i_A, double turns,
                                int checks_per_turn, double left) {
    int32_t i[LODE_PHASES];
    for (int phase = 0; phase < LODE_PHASES; phase++) {
        i[phase] = (int32_t)(100.0 * (double)i_A * cos(2.0 * CHECK_PI * (turns - phase / 3.0)));
        const int32_t most = (int32_t)lround(100.0 * (double)i_A * left);
        if ((missing & 1u << phase) != 0u && i[phase] > most) {
            i[phase] = most;
        }
        if ((missing & 1u << (phase + LODE_PHASES)) != 0u && i[phase] < -most) {
            i[phase] = -most;
        }
    }
    return lode_waves_step(self, &waves_tuning, i, i_A * i_A,
                           (float)(2.0 * CHECK_PI / checks_per_turn));
}

/// Checks of 30 to a turn until a phase is found whose half-wave `bit` is no more than `left` of what is asked for.
static int checks_until_found(lode_waves_t *self, uint32_t bit, double left) {
    int n = 0;
    uint_least8_t found = 0u;
    for (; n < 200 && found == 0u; n++) {
        found = wave_check(self, 1u << bit, 5.0f, n / 30.0, 30, left);
    }
    TEST_ASSERT_EQUAL_UINT(n < 200 ? 1u + bit % 3u : 0u, found);
    return n;
}

/// Half of the current is not yet a half-wave; more is.
static void test_a_half_wave_is_more_than_half_of_the_current(void) {
    for (uint32_t bit = 0; bit < 6u; bit++) {
        lode_waves_t self = {.turn_rad = 0.0f};
        CHECK_AT_MOST(70, checks_until_found(&self, bit, 0.5));
        self = (lode_waves_t){.turn_rad = 0.0f};
        TEST_ASSERT_EQUAL_INT(200, checks_until_found(&self, bit, 0.52));
    }
}

/// Half-waves from before a stretch with little current do not count, nor does the turn.
static void test_little_current_begins_the_half_waves_anew(void) {
    lode_waves_t fresh = {.turn_rad = 0.0f};
    lode_waves_t self = {.turn_rad = 0.0f};
    for (int n = 0; n < 30; n++) {
        TEST_ASSERT_EQUAL_UINT(0u, wave_check(&self, 0u, 5.0f, n / 30.0, 30, 0.0));
    }
    TEST_ASSERT_EQUAL_UINT(0u, wave_check(&self, 0u, 0.9f, 0.0, 30, 0.0));
    TEST_ASSERT_EQUAL_INT(checks_until_found(&fresh, 0u, 0.0), checks_until_found(&self, 0u, 0.0));
}

/// Three turns of a vector of `i_A` that is to be found, with the half-waves of `missing` left out.
static uint_least8_t after_turns(uint32_t missing, float i_A, int checks_per_turn) {
    lode_waves_t self = {.turn_rad = 0.0f};
    uint_least8_t found = 0u;
    for (int n = 0; n < 3 * checks_per_turn && found == 0u; n++) {
        found = wave_check(&self, missing, i_A, (double)n / checks_per_turn, checks_per_turn, 0.0);
    }
    return found;
}

/// A rotor that falls out of step shifts the currents for a turn.
static void test_a_half_wave_that_is_missing_once_is_none(void) {
    lode_waves_t self = {.turn_rad = 0.0f};
    for (int n = 0; n < 132; n++) { // of 30 to the turn: four times a turn and a tenth
        int32_t i[LODE_PHASES];
        for (int phase = 0; phase < LODE_PHASES; phase++) {
            i[phase] = (int32_t)(500.0 * cos(2.0 * CHECK_PI * (n / 30.0 - phase / 3.0)));
        }
        // In the first window the positive half-wave of a, in the second the negative one.
        i[0] = n < 33 ? (int32_t)lode_min((float)i[0], 0.0f)
                      : (n < 66 ? (int32_t)lode_max((float)i[0], 0.0f) : i[0]);
        TEST_ASSERT_EQUAL_UINT(
            0u, lode_waves_step(&self, &waves_tuning, i, 25.0f, (float)(2.0 * CHECK_PI / 30.0)));
    }
}

static void test_a_phase_without_a_half_wave_is_found(void) {
    for (int checks = 21; checks <= 66; checks += 9) {
        TEST_ASSERT_EQUAL_UINT(0u, after_turns(0u, 5.0f, checks));
        for (uint32_t bit = 0; bit < 6u; bit++) {
            TEST_ASSERT_EQUAL_UINT(1u + bit % 3u, after_turns(1u << bit, 5.0f, checks));
        }
        TEST_ASSERT_EQUAL_UINT(2u, after_turns(2u | 16u, 5.0f, checks)); // open
    }
    // Not with little current, and not where current control may not follow.
    TEST_ASSERT_EQUAL_UINT(1u, after_turns(1u, 1.0f, 30));
    TEST_ASSERT_EQUAL_UINT(0u, after_turns(1u, 0.99f, 30));
    TEST_ASSERT_EQUAL_UINT(0u, after_turns(1u, 5.0f, 20));
}

// --- A current that falls and comes back ----------------------------------------------------------

/// A round as a start has it, with a check in its middle. True: the current fell, and is back.
static bool drop_round(lode_drop_t *drop, double i_A, double ref_A, double e_V, double *change_V) {
    const float i_A2 = (float)(i_A * i_A);
    float change = NAN;
    const bool back = lode_drop_step(drop, i_A2, (float)(ref_A * ref_A),
                                     (lode_dq_t){0.6f * (float)e_V, -0.8f * (float)e_V}, &change);
    *change_V = (double)change;
    lode_drop_check(drop, i_A2);
    return back;
}

/// Rounds until a current of 10 A that has overshot and has then been held for `held` rounds, falls to `fallen_A` in one and is
/// `away_A` at the check after, is told to be back; 0: not within 20. The EMF is 2 V before and 5 V after.
static int rounds_until_back(int held, double fallen_A, double away_A, double back_A,
                             double *change_V) {
    lode_drop_t drop = {.rounds = 0u};
    TEST_ASSERT_FALSE(drop_round(&drop, 13.0, 10.0, 2.0, change_V));
    for (int n = 0; n < held; n++) {
        TEST_ASSERT_FALSE(drop_round(&drop, 10.0, 10.0, 2.0, change_V));
    }
    lode_drop_check(&drop, (float)(fallen_A * fallen_A));
    if (drop_round(&drop, away_A, 10.0, 5.0, change_V)) {
        return 1;
    }
    for (int n = 2; n <= 20; n++) {
        if (drop_round(&drop, back_A, 10.0, 5.0, change_V)) {
            return n;
        }
    }
    return 0;
}

static void test_a_current_that_falls_and_comes_back_tells_the_voltage(void) {
    double change_V = NAN;
    TEST_ASSERT_EQUAL_INT(5, rounds_until_back(8, 4.0, 6.0, 10.0, &change_V));
    CHECK_CLOSE(1.0e-6, 3.0, change_V);
    // The counter of rounds does not wrap.
    TEST_ASSERT_EQUAL_INT(5, rounds_until_back(300, 7.4, 8.4, 8.6, &change_V));
    CHECK_CLOSE(1.0e-6, 3.0, change_V);
    TEST_ASSERT_EQUAL_INT(0, rounds_until_back(7, 4.0, 6.0, 10.0, &change_V)); // not held for long
    TEST_ASSERT_EQUAL_INT(0, rounds_until_back(8, 7.6, 8.0, 10.0, &change_V)); // no fall
    TEST_ASSERT_EQUAL_INT(0, rounds_until_back(8, 4.0, 8.6, 10.0, &change_V)); // back at once
    TEST_ASSERT_EQUAL_INT(0, rounds_until_back(8, 4.0, 6.0, 8.4, &change_V));  // it stays away
}

/// At a round's own check: the next check, in its middle, confirms it. The EMF to go by is that of the round before.
static void test_a_fall_is_confirmed_by_the_next_look(void) {
    for (int again = 0; again < 2; again++) {
        lode_drop_t drop = {.rounds = 0u};
        double change_V = NAN;
        for (int n = 0; n < 8; n++) {
            TEST_ASSERT_FALSE(drop_round(&drop, 10.0, 10.0, 2.0, &change_V));
        }
        TEST_ASSERT_FALSE(
            lode_drop_step(&drop, 49.0f, 100.0f, (lode_dq_t){9.0f, 9.0f}, &(float){0.0f}));
        lode_drop_check(&drop, again == 0 ? 64.0f : 81.0f);
        for (int n = 0; n < 4; n++) {
            TEST_ASSERT_FALSE(drop_round(&drop, 9.5, 10.0, 6.0, &change_V));
        }
        TEST_ASSERT_EQUAL(again == 0, drop_round(&drop, 9.5, 10.0, 6.0, &change_V));
        if (again == 0) {
            CHECK_CLOSE(1.0e-6, 4.0, change_V);
            // The next one must be held for as long again.
            TEST_ASSERT_FALSE(drop_round(&drop, 4.0, 10.0, 6.0, &change_V));
            TEST_ASSERT_EQUAL_UINT(0, drop.rounds);
        }
    }
}

/// Three quarters are no fall, and 0.85 are neither away nor back. What is back at the next check may fall anew.
static void test_a_fall_at_its_limits(void) {
    lode_drop_t drop = {.held = 8u, .i_A2 = 1.0f};
    lode_drop_check(&drop, 0.5625f);
    TEST_ASSERT_EQUAL_UINT(0u, drop.rounds);
    lode_drop_check(&drop, 0.5624f);
    TEST_ASSERT_EQUAL_UINT(1u, drop.rounds);
    lode_drop_check(&drop, 0.7225f);
    TEST_ASSERT_EQUAL_UINT(0u, drop.rounds);
    drop = (lode_drop_t){.held = 8u, .i_A2 = 1.0f, .rounds = 6u};
    float change_V = 0.0f;
    TEST_ASSERT_FALSE(lode_drop_step(&drop, 0.7225f, 1.0f, (lode_dq_t){5.0f, 0.0f}, &change_V));
}

static void test_a_current_that_is_not_asked_for_does_not_fall(void) {
    double change_V = NAN;
    const double bad[] = {7.9, 12.1, NAN};
    for (int k = 0; k < COUNT_OF(bad); k++) {
        lode_drop_t drop = {.rounds = 0u};
        for (int n = 0; n < 20; n++) {
            TEST_ASSERT_FALSE(drop_round(&drop, bad[k], 10.0, 2.0, &change_V));
        }
        TEST_ASSERT_FALSE(drop_round(&drop, 1.0, 10.0, 2.0, &change_V));
        TEST_ASSERT_EQUAL_UINT(0, drop.rounds);
    }
    lode_drop_t drop = {.rounds = 0u};
    for (int n = 0; n < 20; n++) { // nothing is asked for, and noise flows
        TEST_ASSERT_FALSE(drop_round(&drop, n % 2 == 0 ? 0.1 : 0.01, 0.0, 2.0, &change_V));
        TEST_ASSERT_EQUAL_UINT(0, drop.rounds);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_what_is_off_is_off_by_its_sign);
    RUN_TEST(test_sound_adc_channels_are_never_stuck);
    RUN_TEST(test_a_stuck_adc_channel_is_found_within_5_ms_from_a_fifth_of_the_speed);
    RUN_TEST(test_an_adc_channel_may_be_stuck_at_zero);
    RUN_TEST(test_a_phase_beside_one_near_zero_is_stuck);
    RUN_TEST(test_three_that_keep_still_beside_dead_time);
    RUN_TEST(test_a_phase_that_stays_near_zero_may_be_left_out);
    RUN_TEST(test_a_phase_without_current_is_open);
    RUN_TEST(test_no_open_phase_explains_that_nothing_flows);
    RUN_TEST(test_a_phase_that_dead_time_may_hold_has_a_quarter_turn);
    RUN_TEST(test_three_that_keep_still_may_while_the_current_changes);
    RUN_TEST(test_without_current_nothing_is_stuck);
    RUN_TEST(test_counts_that_were_kept_without_current_may_still_be_good);
    RUN_TEST(test_all_that_do_not_follow_a_rising_current_are_stuck);
    RUN_TEST(test_none_need_follow_a_little_more_of_a_large_current);
    RUN_TEST(test_a_phase_that_a_rising_current_holds_is_not_stuck);
    RUN_TEST(test_three_looks_far_apart_are_luck);
    RUN_TEST(test_gains_that_differ_do_not_make_a_phase_stuck);
    RUN_TEST(test_a_sum_that_lasts_is_found);
    RUN_TEST(test_the_limit_itself_is_no_sum);
    RUN_TEST(test_reset_forgets);
    RUN_TEST(test_what_is_chance_is_noted_as_by_the_long_way);
    RUN_TEST(test_the_short_ways_find_the_same);
    RUN_TEST(test_configuration);
    RUN_TEST(test_what_is_reported_from_elsewhere_counts_in_shares);
    RUN_TEST(test_noise_does_not_move_a_frozen_vector);
    RUN_TEST(test_a_vector_that_does_not_follow_is_frozen);
    RUN_TEST(test_a_frozen_vector_is_missed_at_two_looks_in_a_row);
    RUN_TEST(test_a_reference_that_alternates_freezes_nothing);
    RUN_TEST(test_a_load_that_no_torque_holds_is_too_large);
    RUN_TEST(test_a_speed_that_comes_back_was_no_load_too_large);
    RUN_TEST(test_a_rotor_that_hardly_turns_is_stalled);
    RUN_TEST(test_a_braked_rotor_that_gets_faster_for_long);
    RUN_TEST(test_configuration_of_the_load);
    RUN_TEST(test_a_phase_without_a_half_wave_is_found);
    RUN_TEST(test_a_half_wave_that_is_missing_once_is_none);
    RUN_TEST(test_a_half_wave_is_more_than_half_of_the_current);
    RUN_TEST(test_little_current_begins_the_half_waves_anew);
    RUN_TEST(test_a_current_that_falls_and_comes_back_tells_the_voltage);
    RUN_TEST(test_a_fall_is_confirmed_by_the_next_look);
    RUN_TEST(test_a_fall_at_its_limits);
    RUN_TEST(test_a_current_that_is_not_asked_for_does_not_fall);
    return UNITY_END();
}
