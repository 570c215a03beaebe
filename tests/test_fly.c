// Flying start: what the vectors of short zero vectors tell, on a machine without losses.
#include "support/ipmsm.h"

#include "lodestar/fly.h"

void setUp(void) {}

void tearDown(void) {}

static const lode_inverter_config_t inverter = {
    .v_bus_V = 200.0f, .i_max_A = 12.0f, .dead_time_s = 2.0e-6f};
static const lode_start_config_t start = {.omega_handover_rad_s = 47.0f, .catch_s = 0.05f};
#define OMEGA_MAX 1178.0f
#define STEPS_MAX 1000
#define CATCH_ROUNDS 31u                 // 0.05 s
#define TURN_PERIODS (4u * CATCH_ROUNDS) // half of the time in which a rotor is looked for

static lode_fly_tuning_t tuned(const lode_start_config_t *config, float duty_max) {
    const lode_motor_t motor = paper_motor();
    lode_fly_tuning_t tuning;
    TEST_ASSERT_EQUAL_STRING("LODE_OK",
                             lode_status_name(lode_fly_tune(&tuning, config, &inverter, &motor,
                                                            OMEGA_MAX, duty_max, PAPER_TS_s)));
    return tuning;
}

static lode_fly_given_t given_with(float charge) {
    const lode_motor_t motor = paper_motor();
    return (lode_fly_given_t){
        .ts_s = PAPER_TS_s,
        .i_max_A = inverter.i_max_A,
        .psi_Wb = motor.psi_Wb,
        .Lq_H = motor.Lq_H,
        .inv_Ld = 1.0f / motor.Ld_H,
        .duty_max = 1.0f,
        .omega_handover = start.omega_handover_rad_s,
        .catch_rounds = CATCH_ROUNDS,
        .v_bus_V = inverter.v_bus_V,
        .charge = charge,
    };
}

static void fly_on(lode_fly_t *fly, const lode_fly_tuning_t *tuning, lode_ab_t i_A, float charge) {
    const lode_fly_given_t given = given_with(charge);
    lode_fly_step(fly, tuning, i_A, &given);
}

/// A rotor that coasts behind a bridge.
typedef struct {
    double omega, theta;
    double psi;     ///< true flux, Wb
    double lost_s;  ///< of every pulse, by dead time
    double noise_A; ///< a vector of this length, in a direction that hops about
    double share[2];
    double on_s;   ///< for which the low sides have been on by now
    double peak_A; ///< at the end of a pulse
    int steps;
} coaster_t;

static lode_ab_t sample(coaster_t *self) {
    const bool whole = self->share[1] >= 1.0;
    const double ts_s = (double)PAPER_TS_s;
    self->on_s = whole ? self->on_s + ts_s : 0.5 * self->share[1] * ts_s;
    const double time = fmax(self->on_s - self->lost_s, 0.0);
    const double turned = time * self->omega;
    const lode_dq_t i = {(float)(self->psi * (cos(turned) - 1.0) / 3.5e-3),
                         (float)(-self->psi * sin(turned) / 9.8e-3)};
    const double by_its_end = (whole ? 1.0 : 2.0) * hypot((double)i.d, (double)i.q);
    self->peak_A = fmax(self->peak_A, by_its_end);
    const lode_ab_t seen = lode_park_inverse(i, lode_sincos((float)self->theta));
    const lode_sincos_t hop = lode_sincos((float)(2.4 * self->steps * self->steps));
    return (lode_ab_t){seen.alpha + (float)self->noise_A * hop.cos,
                       seen.beta + (float)self->noise_A * hop.sin};
}

static void step(coaster_t *self, lode_fly_t *fly, const lode_fly_tuning_t *tuning, float charge) {
    fly_on(fly, tuning, sample(self), charge);
    self->share[1] =
        self->share[0]; // a share acts a period later, and is sampled at that period's end
    self->share[0] = (double)fly->share;
    self->theta = remainder(self->theta + (double)PAPER_TS_s * self->omega, 2.0 * CHECK_PI);
    self->steps++;
}

static bool is_over(const lode_fly_t *fly) {
    return fly->stage == (uint_least8_t)LODE_FLY_FOUND ||
           fly->stage == (uint_least8_t)LODE_FLY_SLOW;
}

static lode_fly_t run(coaster_t *self, const lode_fly_tuning_t *tuning, float charge) {
    lode_fly_t fly;
    lode_fly_begin(&fly, tuning);
    while (!is_over(&fly) && self->steps < STEPS_MAX) {
        step(self, &fly, tuning, charge);
    }
    return fly;
}

static coaster_t rotor(double omega) {
    return (coaster_t){.omega = omega, .theta = 0.7, .psi = 0.142};
}

static void test_angle_and_speed_are_found_in_either_direction(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    for (int k = -10; k <= 10; k++) {
        coaster_t self = rotor(80.0 * k);
        const lode_fly_t fly = run(&self, &tuning, 0.0f);
        if (k == 0) {
            TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, fly.stage);
            continue;
        }
        TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
        CHECK_NEAR(1.0, self.omega, fly.omega_rad_s);
        // Of the sample that the last call has had.
        const double at = self.theta - (double)PAPER_TS_s * self.omega;
        CHECK_NEAR(0.02, 0.0, remainder((double)fly.theta_rad - at, 2.0 * CHECK_PI));
        TEST_ASSERT_TRUE(self.peak_A < 0.8 * (double)inverter.i_max_A);
        TEST_ASSERT_TRUE((double)self.steps * (double)PAPER_TS_s < 0.05);
    }
}

#define NOISE_PERIODS 8

/// The periods in which noise is measured, without any.
static lode_fly_t quiet(const lode_fly_tuning_t *tuning) {
    lode_fly_t fly;
    lode_fly_begin(&fly, tuning);
    for (int n = 0; n < NOISE_PERIODS; n++) {
        TEST_ASSERT_EQUAL_INT(LODE_FLY_BEGIN, fly.stage);
        TEST_ASSERT_FALSE(fly.share > 0.0f);
        fly_on(&fly, tuning, (lode_ab_t){0.0f, 0.0f}, 0.0f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_GROW, fly.stage);
    return fly;
}

/// Without a current that is seen: every two periods by the first share, or to three times what dead time and a
/// microsecond leave of it, up to half a period. The vector of the period between is no pulse's of that share.
static void test_pulses_lengthen_every_two_periods(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    CHECK_NEAR(1.0e-7, 0.02, tuning.share_dead);
    static const double shares[] = {0.05, 0.10, 0.03 + 3.0 * 0.07, 0.5};
    lode_fly_t fly = quiet(&tuning);
    for (int n = 0; n < 2 * COUNT_OF(shares); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_FLY_GROW, fly.stage);
        CHECK_NEAR(1.0e-6, shares[n / 2], fly.share);
        fly_on(&fly, &tuning, (lode_ab_t){n % 2 == 1 ? 0.0f : 5.0f, 0.0f}, 0.0f);
    }
    CHECK_NEAR(0.0, 0.0, fly.share); // whole periods come next
    TEST_ASSERT_EQUAL_UINT(1u, fly.span);
}

/// (S51): 2n + 1 periods off, n on, and the window of the shunts at the sample. Without a vector n doubles, up to where the slowest
/// rotor would make one of twice the least current.
static void test_pulses_of_whole_periods(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    lode_fly_given_t given = given_with(0.0f);
    given.omega_handover = 10.0f; // 2 * 0.036 A / (psi * 7.5 * Ts / Lq) = 3.3 and one more
    lode_fly_t fly = quiet(&tuning);
    for (int n = 0; n < 8; n++) {
        fly_on(&fly, &tuning, (lode_ab_t){0.0f, 0.0f}, 0.0f);
    }
    static const uint32_t spans[] = {1u, 2u, 4u};
    for (int n = 0; n < COUNT_OF(spans); n++) {
        const uint32_t last = 3u * spans[n] + 1u;
        for (uint32_t k = 0u; k <= last; k++) {
            TEST_ASSERT_EQUAL_INT(LODE_FLY_GROW, fly.stage);
            const bool off = k <= 2u * spans[n];
            CHECK_NEAR(1.0e-6, off ? 0.0 : (k < last ? 1.0 : 0.05), fly.share);
            // Only the sample at the end of a pulse counts.
            lode_fly_step(&fly, &tuning, (lode_ab_t){0.0f, k == last ? 0.05f : 5.0f}, &given);
        }
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_TURN, fly.stage); // at the longest a vector that is just seen
}

/// A rotor that turns by more than 2 rad in the five periods from one such vector to the next has none.
static void test_a_fast_rotor_has_no_pulses_of_whole_periods(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    lode_fly_given_t given = given_with(0.0f);
    given.psi_Wb = 0.01f;
    for (int n = 0; n < 2; n++) {
        // What 1.9 and 2.1 rad induce, at half a period less dead time: 0.09 and 0.10 A, less than half of the target.
        const double emf_V = (n == 0 ? 1.9 : 2.1) / 5.0 / (double)PAPER_TS_s * 0.01;
        lode_fly_t fly = quiet(&tuning);
        for (int k = 0;
             k < STEPS_MAX && fly.stage == (uint_least8_t)LODE_FLY_GROW && fly.span == 0u; k++) {
            const double acted = fmax((double)fly.share - 0.02, 0.0);
            const float i_A = (float)(emf_V * acted * (double)PAPER_TS_s / (2.0 * 9.8e-3));
            lode_fly_step(&fly, &tuning, (lode_ab_t){0.0f, i_A}, &given);
        }
        TEST_ASSERT_EQUAL_UINT(n == 0 ? 1u : 0u, fly.span);
        TEST_ASSERT_EQUAL_INT(n == 0 ? LODE_FLY_GROW : LODE_FLY_TURN, fly.stage);
    }
}

/// In noise of 1 % of i_max pulses of whole periods still show angle and speed.
static void test_whole_periods_find_a_rotor_in_noise(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    for (int k = -5; k <= 5; k++) {
        coaster_t self = rotor(60.0 * k);
        self.noise_A = 0.12;
        const lode_fly_t fly = run(&self, &tuning, 0.0f);
        if (k == 0) {
            TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, fly.stage);
            TEST_ASSERT_EQUAL_UINT(1u, fly.rests);
            continue;
        }
        TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
        CHECK_NEAR(0.2 * fabs(self.omega), self.omega, fly.omega_rad_s);
        const double at = self.theta - (double)PAPER_TS_s * self.omega;
        CHECK_NEAR(0.25, 0.0, remainder((double)fly.theta_rad - at, 2.0 * CHECK_PI));
        TEST_ASSERT_TRUE(self.peak_A < 0.2 * (double)inverter.i_max_A);
    }
}

/// (S57): vectors that scatter by some 10 degrees are watched for longer than clear ones. Two that are far off, one to either side,
/// lose no turn.
static void test_scattered_vectors_are_watched_for_longer(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    const double step_rad = 0.14;
    for (int scattered = 0; scattered <= 1; scattered++) {
        lode_fly_t fly = quiet(&tuning);
        while (fly.stage == (uint_least8_t)LODE_FLY_GROW) {
            fly_on(&fly, &tuning, (lode_ab_t){1.3f, 0.0f}, 0.0f);
        }
        int k = 0;
        while (fly.stage == (uint_least8_t)LODE_FLY_TURN && k < STEPS_MAX) {
            k++;
            double off_rad = scattered * 0.25 * sin(2.4 * k * k);
            off_rad += scattered * (k == 60 ? 2.5 : (k == 61 ? -1.0 : 0.0));
            const lode_sincos_t at = lode_sincos((float)(step_rad * k + off_rad));
            fly_on(&fly, &tuning, (lode_ab_t){0.051f * at.cos, 0.051f * at.sin}, 0.0f);
        }
        TEST_ASSERT_EQUAL_INT(LODE_FLY_COAST, fly.stage);
        CHECK_AT_LEAST(scattered == 0 ? 20.0 : 62.0, k);
        CHECK_AT_MOST(scattered == 0 ? 23.0 : (double)TURN_PERIODS, k);
        const double omega = step_rad / (double)PAPER_TS_s;
        CHECK_CLOSE(scattered == 0 ? 1.0e-3 : 0.02, omega, fly.omega_rad_s);
        const double theta = step_rad * k + 0.5 * CHECK_PI;
        CHECK_NEAR(0.1, 0.0, remainder((double)fly.theta_rad - theta, 2.0 * CHECK_PI));
    }
}

/// A vector of noise that is taken for the rotor's: the search begins anew, with a larger least current, three times. START looks
/// for the rotor then, as nothing says that it is at rest.
static void test_vectors_of_noise_are_tried_again(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    const lode_fly_given_t given = given_with(0.0f);
    lode_fly_t fly;
    lode_fly_begin(&fly, &tuning);
    for (int n = 0; n < NOISE_PERIODS; n++) {
        fly_on(&fly, &tuning, (lode_ab_t){0.0f, 0.05f}, 0.0f);
    }
    double seen_A = 0.15; // 3 times the noise
    for (unsigned n = 0; n < 3u; n++, seen_A *= 1.5) {
        TEST_ASSERT_EQUAL_INT(LODE_FLY_GROW, fly.stage);
        TEST_ASSERT_EQUAL_UINT(n, fly.tries);
        CHECK_CLOSE(1.0e-5, seen_A, fly.seen_A);
        CHECK_NEAR(1.0e-6, 0.05, fly.share);
        while (fly.stage == (uint_least8_t)LODE_FLY_GROW) {
            fly_on(&fly, &tuning, (lode_ab_t){1.3f, 0.0f}, 0.0f);
        }
        for (int k = 0; fly.stage == (uint_least8_t)LODE_FLY_TURN; k++) {
            TEST_ASSERT_TRUE(k < 24);
            const lode_sincos_t hop = lode_sincos((float)(2.4 * (double)k * (double)k));
            lode_fly_step(&fly, &tuning, (lode_ab_t){0.1f * hop.cos, 0.1f * hop.sin}, &given);
        }
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, fly.stage);
    TEST_ASSERT_EQUAL_UINT(0u, fly.rests);
}

/// Vectors that swing by more than the line allows, after 24 of them: small ones are noise, and tried again; large ones are no
/// rotor's that turns.
static void test_vectors_that_swing(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    for (int large = 0; large < 2; large++) {
        lode_fly_t fly;
        lode_fly_begin(&fly, &tuning);
        for (int n = 0; n < NOISE_PERIODS; n++) {
            fly_on(&fly, &tuning, (lode_ab_t){0.0f, 0.05f}, 0.0f);
        }
        while (fly.stage == (uint_least8_t)LODE_FLY_GROW) {
            fly_on(&fly, &tuning, (lode_ab_t){1.3f, 0.0f}, 0.0f);
        }
        const float i_A = large == 1 ? 0.21f : 0.19f; // about 4 times the noise
        for (int k = 0; k < 24; k++) {
            TEST_ASSERT_EQUAL_INT(LODE_FLY_TURN, fly.stage);
            const lode_sincos_t at = lode_sincos(k % 2 == 0 ? 0.9f : -0.9f);
            fly_on(&fly, &tuning, (lode_ab_t){i_A * at.cos, i_A * at.sin}, 0.0f);
        }
        TEST_ASSERT_EQUAL_INT(large == 1 ? LODE_FLY_SLOW : LODE_FLY_GROW, fly.stage);
        TEST_ASSERT_EQUAL_UINT(large == 1 ? 1u : 0u, fly.rests);
        TEST_ASSERT_EQUAL_UINT(large == 1 ? 0u : 1u, fly.tries);
    }
}

/// Vectors that are too large for the speed: where the pulses leave the current no time to decay, shorter ones are tried; else
/// it is another motor.
static void test_a_current_that_adds_up_is_tried_again(void) {
    static const struct {
        double omega; // line EMF: 246 mV s of it, of the bus's 200 V
        float share;
        uint_least8_t span;
        bool again;
    } cases[] = {{700.0, 0.3f, 0u, true},
                 {200.0, 0.3f, 0u, false},
                 {455.0, 0.5f, 0u, true}, // (S23): 0.35 at most
                 {455.0, 0.0f, 1u, false},
                 {650.0, 0.0f, 1u, true}};
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    for (int n = 0; n < COUNT_OF(cases); n++) {
        lode_fly_t fly = {.stage = (uint_least8_t)LODE_FLY_TURN,
                          .share = cases[n].share,
                          .span = cases[n].span,
                          .seen_A = 0.036f};
        for (int k = 1; fly.stage == (uint_least8_t)LODE_FLY_TURN && k < STEPS_MAX; k++) {
            const lode_sincos_t at =
                lode_sincos((float)remainder(cases[n].omega * (double)PAPER_TS_s * k, 6.28318531));
            fly_on(&fly, &tuning, (lode_ab_t){5.0f * at.cos, 5.0f * at.sin}, 0.0f);
        }
        TEST_ASSERT_EQUAL_INT(cases[n].again ? LODE_FLY_GROW : LODE_FLY_SLOW, fly.stage);
        TEST_ASSERT_EQUAL_UINT(cases[n].again ? 1u : 0u, fly.tries);
        TEST_ASSERT_EQUAL_UINT(0u, fly.rests);
    }
}

/// A current that is seen: by what is missing of a tenth of i_max, to twice the share at most.
static void test_pulses_lengthen_by_what_is_missing(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    lode_fly_given_t given = given_with(0.0f);
    given.v_bus_V = 1.0e6f; // bounds nothing
    static const float seen_A[] = {0.0f, 0.0f, 0.3f, 0.9f, 1.25f};
    static const double shares[] = {0.05, 0.10, 0.20, 0.20 * 1.2 / 0.9, 0.20 * 1.2 / 0.9};
    lode_fly_t fly = quiet(&tuning);
    for (int n = 0; n < COUNT_OF(seen_A); n++) {
        if (n > 0) {
            lode_fly_step(&fly, &tuning, (lode_ab_t){0.0f, 0.0f}, &given);
            lode_fly_step(&fly, &tuning, (lode_ab_t){0.0f, seen_A[n]}, &given);
        }
        CHECK_NEAR(1.0e-6, shares[n], fly.share);
        TEST_ASSERT_EQUAL_INT(n < 4 ? LODE_FLY_GROW : LODE_FLY_TURN, fly.stage);
    }
}

/// (S23): 0.8 of the share after which the current just decays, behind an EMF of 85 V.
static void test_the_bus_bounds_the_pulses(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    const double emf_V = 85.0;
    lode_fly_t fly;
    lode_fly_begin(&fly, &tuning);
    for (int k = 0; k < STEPS_MAX && fly.stage != (uint_least8_t)LODE_FLY_TURN; k++) {
        const double acted = fmax((double)fly.share - 0.02, 0.0);
        const float i_A = (float)(emf_V * acted * (double)PAPER_TS_s / (2.0 * 9.8e-3));
        TEST_ASSERT_TRUE(fly.stage != (uint_least8_t)LODE_FLY_SLOW);
        fly_on(&fly, &tuning, (lode_ab_t){0.0f, i_A}, 0.0f);
    }
    CHECK_NEAR(1.0e-4, 0.8 * (1.0 - sqrt(3.0) * emf_V / 200.0), fly.share);
}

/// Calls in TURN of a rotor that is found.
static int calls_in_turn(double omega) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    coaster_t self = rotor(omega);
    lode_fly_t fly;
    int calls = 0;
    lode_fly_begin(&fly, &tuning);
    while (!is_over(&fly) && self.steps < STEPS_MAX) {
        calls += fly.stage == (uint_least8_t)LODE_FLY_TURN ? 1 : 0;
        step(&self, &fly, &tuning, 0.0f);
        TEST_ASSERT_TRUE(fly.stage < (uint_least8_t)LODE_FLY_COAST || !(fly.share > 0.0f));
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
    CHECK_NEAR(0.02 * omega, omega, fly.omega_rad_s);
    return calls;
}

/// Twelve periods and half a turn, at most half of the time to look.
static void test_how_long_vectors_are_seen_to_turn(void) {
    TEST_ASSERT_EQUAL_INT(12, calls_in_turn(1600.0));
    TEST_ASSERT_EQUAL_INT((int)TURN_PERIODS + 1, calls_in_turn(60.0)); // vectors every 5 periods
}

/// Three quarters of the hand-over speed, with magnets that let so slow a rotor be seen.
static void test_the_slowest_rotor_that_is_caught(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    lode_fly_given_t given = given_with(0.0f);
    given.psi_Wb = 0.5f;
    static const double speeds[] = {36.0, 34.5};
    for (int n = 0; n < COUNT_OF(speeds); n++) {
        coaster_t self = rotor(speeds[n]);
        self.psi = 0.5;
        lode_fly_t fly;
        lode_fly_begin(&fly, &tuning);
        while (!is_over(&fly) && self.steps < STEPS_MAX) {
            lode_fly_step(&fly, &tuning, sample(&self), &given);
            self.share[1] = self.share[0];
            self.share[0] = (double)fly.share;
            self.theta += (double)PAPER_TS_s * self.omega;
            self.steps++;
        }
        TEST_ASSERT_EQUAL_INT(n == 0 ? LODE_FLY_FOUND : LODE_FLY_SLOW, fly.stage);
        CHECK_AT_LEAST((int)TURN_PERIODS, self.steps); // it was seen
    }
}

/// (S24): half of the flux is enough, of what dead time and a microsecond leave.
static void test_weak_magnets_behind_dead_time(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    coaster_t self = rotor(400.0);
    self.lost_s = 0.5 * 0.03 * (double)PAPER_TS_s;
    self.psi = 0.52 * 0.142;
    TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, run(&self, &tuning, 0.0f).stage);
    self = rotor(400.0);
    self.lost_s = 0.5 * 0.03 * (double)PAPER_TS_s;
    self.psi = 0.48 * 0.142;
    TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, run(&self, &tuning, 0.0f).stage);
}

static void test_noise_and_dead_time_leave_angle_and_speed(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    for (int k = -8; k <= 8; k += 4) {
        coaster_t self = rotor(80.0 * k);
        self.lost_s = 3.0e-6;
        self.noise_A = 0.01;
        const lode_fly_t fly = run(&self, &tuning, 0.0f);
        TEST_ASSERT_EQUAL_INT(k == 0 ? LODE_FLY_SLOW : LODE_FLY_FOUND, fly.stage);
        if (k != 0) {
            const double at = self.theta - (double)PAPER_TS_s * self.omega;
            CHECK_NEAR(0.05 * fabs(self.omega), self.omega, fly.omega_rad_s);
            CHECK_NEAR(0.06, 0.0, remainder((double)fly.theta_rad - at, 2.0 * CHECK_PI));
        }
    }
}

static void test_what_is_no_rotor_of_this_motor_is_left_to_the_start(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    static const struct {
        double omega, psi, noise_A;
        unsigned rests;
    } cases[] = {
        {30.0, 0.142, 0.0, 0u}, // slower than the start hands over
        {30.0, 0.40, 0.0, 0u},  // the same, seen
        {15.0, 1.0, 0.0, 1u},   // hardly turns while it is looked at
        {400.0, 0.30, 0.0, 0u}, // too large a flux
        {400.0, 0.05, 0.0, 0u}, // too small a one
        {0.0, 0.142, 0.03, 1u}, // noise, in a direction that hops about
        {900.0, 0.0, 0.02, 1u}, // noise too small to be seen
    };
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        coaster_t self = rotor(cases[n].omega);
        self.psi = cases[n].psi;
        self.noise_A = cases[n].noise_A;
        const lode_fly_t fly = run(&self, &tuning, 0.0f);
        TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, fly.stage);
        TEST_ASSERT_EQUAL_UINT(cases[n].rests, fly.rests);
    }
}

/// Of an ADC channel whose noise is above what is taken for a current.
static void test_noise_is_no_rotor(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    random_t random = random_seed(11);
    for (int n = 0; n < CHECK_TRIES(300); n++) {
        lode_fly_t fly;
        lode_fly_begin(&fly, &tuning);
        for (int k = 0; k < STEPS_MAX && !is_over(&fly); k++) {
            // The first one lets the pulses begin.
            const double most_A = k == 0 ? 0.0 : 0.1;
            const lode_ab_t i = {random_float(&random, -most_A, most_A),
                                 random_float(&random, -most_A, most_A)};
            fly_on(&fly, &tuning, i, 0.0f);
        }
        TEST_ASSERT_EQUAL_UINT(LODE_FLY_SLOW, fly.stage);
        TEST_ASSERT_EQUAL_UINT(1u, fly.rests);
    }
}

static void test_a_current_that_ends_is_no_rotor(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    coaster_t self = rotor(400.0);
    self.noise_A = 0.01;
    lode_fly_t fly;
    lode_fly_begin(&fly, &tuning);
    while (fly.stage != (uint_least8_t)LODE_FLY_TURN && self.steps < STEPS_MAX) {
        step(&self, &fly, &tuning, 0.0f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_TURN, fly.stage);
    self.psi = 0.0;
    for (int n = 0; n < STEPS_MAX && !is_over(&fly); n++) {
        step(&self, &fly, &tuning, 0.0f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, fly.stage);
    TEST_ASSERT_EQUAL_UINT(1u, fly.rests);
}

// With the EMF above the bus the diodes conduct.
static void test_pulses_wait_for_the_diodes(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    lode_fly_t fly;
    lode_fly_begin(&fly, &tuning);
    for (uint32_t k = 0u; k < TURN_PERIODS - TURN_PERIODS % NOISE_PERIODS; k++) {
        fly_on(&fly, &tuning, (lode_ab_t){0.0f, 1.0f}, 0.0f);
        TEST_ASSERT_EQUAL_INT(LODE_FLY_BEGIN, fly.stage);
        TEST_ASSERT_FALSE(fly.share > 0.0f);
    }
    lode_fly_t waited = fly;
    for (int k = 0; k < NOISE_PERIODS; k++) {
        TEST_ASSERT_EQUAL_INT(LODE_FLY_BEGIN, fly.stage);
        TEST_ASSERT_EQUAL_INT(LODE_FLY_BEGIN, waited.stage);
        fly_on(&fly, &tuning, (lode_ab_t){0.0f, 0.0f}, 0.0f);
        fly_on(&waited, &tuning, (lode_ab_t){0.0f, 1.0f}, 0.0f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_GROW, fly.stage);
    CHECK_CLOSE(1.0e-6, 0.003 * (double)inverter.i_max_A, fly.seen_A);
    TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, waited.stage);
}

// However short the time is in which a rotor is looked for.
static void test_pulses_wait_for_a_few_periods_at_least(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    lode_fly_given_t given = given_with(0.0f);
    given.catch_rounds = 1u;
    lode_fly_t fly;
    lode_fly_begin(&fly, &tuning);
    for (int k = 1; k < 2 * NOISE_PERIODS; k++) { // 12, in whole measurements of noise
        lode_fly_step(&fly, &tuning, (lode_ab_t){0.0f, 1.0f}, &given);
        TEST_ASSERT_EQUAL_INT(LODE_FLY_BEGIN, fly.stage);
    }
    lode_fly_step(&fly, &tuning, (lode_ab_t){0.0f, 1.0f}, &given);
    TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, fly.stage);
}

static void test_pulses_are_shorter_where_the_bus_leaves_little(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    lode_fly_t fly;
    lode_fly_begin(&fly, &tuning);
    fly_on(&fly, &tuning, (lode_ab_t){0.0f, 0.0f}, 0.0f);
    // More and more current, as one that does not decay, and then none.
    for (int k = 1; k < 20; k++) {
        const float i_A = fly.share > 0.3f ? 10.0f : 0.03f;
        TEST_ASSERT_TRUE(fly.periods < TURN_PERIODS);
        fly_on(&fly, &tuning, (lode_ab_t){0.0f, i_A}, 0.0f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_GROW, fly.stage);
    TEST_ASSERT_TRUE(fly.share >= 0.05f && fly.share <= 0.5f);
    for (int k = 0; k < STEPS_MAX && !is_over(&fly) && fly.stage != (uint_least8_t)LODE_FLY_TURN;
         k++) { // not for ever
        const float i_A = fly.share > 0.3f ? 10.0f : 0.03f;
        TEST_ASSERT_TRUE(fly.periods < TURN_PERIODS);
        fly_on(&fly, &tuning, (lode_ab_t){0.0f, i_A}, 0.0f);
    }
    TEST_ASSERT_TRUE(fly.stage != (uint_least8_t)LODE_FLY_GROW);
}

static void test_a_current_that_does_not_decay_is_waited_for(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    lode_fly_t fly = {.stage = (uint_least8_t)LODE_FLY_COAST, .omega_rad_s = 100.0f};
    for (int k = 0; k < 10; k++) {
        fly_on(&fly, &tuning, (lode_ab_t){1.0f, 0.0f}, 0.0f);
        TEST_ASSERT_EQUAL_INT(LODE_FLY_COAST, fly.stage);
    }
    fly_on(&fly, &tuning, (lode_ab_t){0.0f, 0.0f}, 0.0f);
    TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
    CHECK_NEAR(1.0e-4, 11.0 * 100.0 * (double)PAPER_TS_s, fly.theta_rad);
    // Two periods at least, until a quarter of a pulse's current is left.
    fly = (lode_fly_t){.stage = (uint_least8_t)LODE_FLY_COAST};
    for (int k = 0; k < 4; k++) {
        TEST_ASSERT_EQUAL_INT(LODE_FLY_COAST, fly.stage);
        fly_on(&fly, &tuning, (lode_ab_t){k == 0 ? 0.0f : (k < 3 ? 0.32f : 0.28f), 0.0f}, 0.0f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
    fly = (lode_fly_t){.stage = (uint_least8_t)LODE_FLY_COAST};
    fly_on(&fly, &tuning, (lode_ab_t){0.0f, 0.0f}, 0.0f);
    fly_on(&fly, &tuning, (lode_ab_t){0.0f, 0.0f}, 0.0f);
    TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
    fly = (lode_fly_t){.stage = (uint_least8_t)LODE_FLY_COAST};
    for (uint32_t k = 0u; k < TURN_PERIODS; k++) {
        fly_on(&fly, &tuning, (lode_ab_t){1.0f, 0.0f}, 0.0f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
    fly_on(&fly, &tuning, (lode_ab_t){1.0f, 0.0f}, 0.0f);
    TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
}

static void test_pulses_go_on_until_capacitors_are_charged(void) {
    const lode_fly_tuning_t tuning = tuned(&start, 1.0f);
    coaster_t self = rotor(400.0);
    const lode_fly_t fly = run(&self, &tuning, 100.0f);
    TEST_ASSERT_EQUAL_INT(LODE_FLY_FOUND, fly.stage);
    TEST_ASSERT_TRUE(fly.charged >= 100.0f && self.steps >= 200);
    CHECK_NEAR(1.0, 400.0, fly.omega_rad_s);
}

static void test_where_there_are_no_pulses(void) {
    lode_start_config_t config = start;
    TEST_ASSERT_TRUE(tuned(&config, 0.97f).share_first > 0.0f);
    CHECK_NEAR(1.0e-6, 0.1, tuned(&config, 0.9f).share_first); // what low-side shunts see
    const lode_motor_t motor = paper_motor();
    lode_fly_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_fly_tune(&tuning, &config, &inverter, &motor,
                                                 20.0f * OMEGA_MAX, 0.9f, PAPER_TS_s));
    TEST_ASSERT_FALSE(tuning.share_first > 0.0f); // too long for the highest speed
    config.pulses = LODE_ON;
    TEST_ASSERT_TRUE(tuned(&config, 1.0f).share_first > 0.0f);
    config.catch_s = LODE_NONE;
    TEST_ASSERT_FALSE(tuned(&config, 1.0f).share_first > 0.0f);
    config.catch_s = 0.0f;
    TEST_ASSERT_FALSE(tuned(&config, 1.0f).share_first > 0.0f);
    config = start;
    config.pulses = LODE_OFF;
    const lode_fly_tuning_t none = tuned(&config, 1.0f);
    TEST_ASSERT_FALSE(none.share_first > 0.0f);
    lode_fly_t fly;
    lode_fly_begin(&fly, &none);
    TEST_ASSERT_EQUAL_INT(LODE_FLY_SLOW, fly.stage);
    config.pulses = (lode_choice_t)7;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, lode_fly_tune(&tuning, &config, &inverter, &motor,
                                                           OMEGA_MAX, 1.0f, PAPER_TS_s));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_angle_and_speed_are_found_in_either_direction);
    RUN_TEST(test_pulses_lengthen_every_two_periods);
    RUN_TEST(test_pulses_of_whole_periods);
    RUN_TEST(test_a_fast_rotor_has_no_pulses_of_whole_periods);
    RUN_TEST(test_whole_periods_find_a_rotor_in_noise);
    RUN_TEST(test_scattered_vectors_are_watched_for_longer);
    RUN_TEST(test_vectors_of_noise_are_tried_again);
    RUN_TEST(test_vectors_that_swing);
    RUN_TEST(test_a_current_that_adds_up_is_tried_again);
    RUN_TEST(test_pulses_lengthen_by_what_is_missing);
    RUN_TEST(test_the_bus_bounds_the_pulses);
    RUN_TEST(test_how_long_vectors_are_seen_to_turn);
    RUN_TEST(test_the_slowest_rotor_that_is_caught);
    RUN_TEST(test_weak_magnets_behind_dead_time);
    RUN_TEST(test_noise_and_dead_time_leave_angle_and_speed);
    RUN_TEST(test_what_is_no_rotor_of_this_motor_is_left_to_the_start);
    RUN_TEST(test_noise_is_no_rotor);
    RUN_TEST(test_a_current_that_ends_is_no_rotor);
    RUN_TEST(test_pulses_wait_for_the_diodes);
    RUN_TEST(test_pulses_wait_for_a_few_periods_at_least);
    RUN_TEST(test_pulses_are_shorter_where_the_bus_leaves_little);
    RUN_TEST(test_a_current_that_does_not_decay_is_waited_for);
    RUN_TEST(test_pulses_go_on_until_capacitors_are_charged);
    RUN_TEST(test_where_there_are_no_pulses);
    return UNITY_END();
}
