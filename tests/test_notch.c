// Notch at a harmonic of the speed: depth, the speeds at which it is out, in and between, limits.
#include "support/fields.h"

#include "lodestar/config.h"
#include "notch_inline.h"

void setUp(void) {}

void tearDown(void) {}

// sigma = 100 rad/s: out up to 600 rad/s at the harmonic, in full from 800 rad/s on.
#define SIGMA 100.0

static lode_notch_tuning_t tuned(double order, double k) {
    lode_notch_tuning_t tuning;
    TEST_ASSERT_EQUAL_STRING("LODE_OK",
                             lode_status_name(lode_notch_tune(&tuning, (float)order, (float)k,
                                                              (float)SIGMA, PAPER_TS_s)));
    return tuning;
}

/// A notch that has seen nothing yet.
static lode_notch_t empty(void) {
    lode_notch_t notch = {.weight = 0.0f};
    lode_sogi_reset(&notch.sogi);
    return notch;
}

/// One period at the speed `omega`.
static float stepped(lode_notch_t *notch, const lode_notch_tuning_t *tuning, float omega,
                     float error) {
    lode_notch_adapt(notch, tuning, tuning->k, omega);
    return lode_notch_step(notch, tuning->k, error);
}

/// Largest output over the last 1000 of `steps` calls with cos(turn k) + dc at the speed `omega`.
static double worst_output(const lode_notch_tuning_t *tuning, double omega, double turn, double dc,
                           int steps) {
    lode_notch_t notch = empty();
    worst_t worst = {0.0};
    for (int k = 0; k < steps; k++) {
        const float error = (float)(cos(turn * k) + dc);
        const float out = stepped(&notch, tuning, (float)omega, error);
        worst_note(&worst, k >= steps - 1000 ? (double)out - dc : 0.0);
    }
    return worst.value;
}

static void test_harmonic_is_gone_where_the_notch_is_in(void) {
    const double orders[] = {6.0, 12.0};
    const double widths[] = {0.1, 0.5, 1.4};
    const double centres[] = {810.0, 1800.0, 2827.0, 6000.0, 12400.0}; // the last: 2.48 rad
    for (int n = 0; n < COUNT_OF(orders) * COUNT_OF(widths) * COUNT_OF(centres); n++) {
        const double order = orders[n % 2];
        const double k = widths[n / 2 % 3];
        const double omega = centres[n / 6] / order;
        const lode_notch_tuning_t tuning = tuned(order, k);
        for (int sign = -1; sign <= 1; sign += 2) {
            // The float centre is off by 1e-7 of itself against half the width k, as the phase that
            // the test itself makes; settled by exp(-k wn t/2) within 2 s: e^-80 at the least.
            const double turn = order * omega * (double)PAPER_TS_s;
            CHECK_AT_MOST(5.0e-6 / k, worst_output(&tuning, sign * omega, turn, 0.0, 11000));
            CHECK_AT_MOST(5.0e-6 / k + 2.0e-6, // and an offset passes
                          worst_output(&tuning, sign * omega, turn, 0.3, 11000));
        }
    }
}

static void test_between_it_is_blended(void) {
    const lode_notch_tuning_t tuning = tuned(6.0, 0.5);
    for (int n = 0; n <= 20; n++) {
        const double centre = SIGMA * (6.0 + 0.1 * n);
        for (int sign = -1; sign <= 1; sign += 2) {
            const double omega = sign * centre / 6.0;
            const double turn = centre * (double)PAPER_TS_s;
            // Samples of a cosine miss its peak by (turn/2)^2/2 at most.
            const double left = 1.0 - 0.05 * n;
            CHECK_NEAR(0.125 * turn * turn * left + 2.0e-5, left,
                       worst_output(&tuning, omega, turn, 0.0, 11000));
        }
    }
}

/// Every sample comes out as it went in, bit by bit.
static void check_unchanged(const lode_notch_tuning_t *tuning, double omega) {
    lode_notch_t notch = empty();
    random_t random = random_seed(1);
    for (int k = 0; k < 1000; k++) {
        const float error = random_float(&random, -1.0, 1.0);
        TEST_ASSERT_TRUE(stepped(&notch, tuning, (float)omega, error) == error);
    }
}

static void test_it_stays_out_at_low_speed(void) {
    const lode_notch_tuning_t sixth = tuned(6.0, 0.5);
    const lode_notch_tuning_t twelfth = tuned(12.0, 0.5);
    for (int n = 0; n < 100; n++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            check_unchanged(&sixth, sign * 6.0 * SIGMA / 6.0 * n / 100.0);
            check_unchanged(&twelfth, sign * 6.0 * SIGMA / 12.0 * n / 100.0);
        }
    }
}

static void test_it_is_bypassed_short_of_nyquist(void) {
    const lode_notch_tuning_t sixth = tuned(6.0, 0.5);
    const lode_notch_tuning_t twelfth = tuned(12.0, 0.5);
    const double first = 2.5 / (double)PAPER_TS_s; // rad/s at the harmonic
    for (int n = 0; n < 20; n++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            check_unchanged(&sixth, sign * first / 6.0 * (1.0 + 1.0e-5 + 0.1 * n));
            check_unchanged(&twelfth, sign * first / 12.0 * (1.0 + 1.0e-5 + 0.1 * n));
        }
    }
    // Just short of it the notch is in.
    CHECK_AT_MOST(1.0e-4, worst_output(&sixth, 0.9999 * first / 6.0, 0.9999 * 2.5, 0.0, 3000));
}

static void test_without_width_there_is_no_notch(void) {
    const lode_notch_tuning_t none = tuned(6.0, 0.0);
    check_unchanged(&none, 300.0);
    check_unchanged(&none, -300.0);
    lode_notch_t notch = empty();
    // The estimator does not even call it; it is empty and stays so.
    random_t random = random_seed(2);
    const lode_notch_t before = notch;
    for (int i = 0; i < 1000; i++) {
        const float error = random_float(&random, -1.0, 1.0);
        TEST_ASSERT_TRUE(stepped(&notch, &none, 300.0f, error) == error);
        TEST_ASSERT_EQUAL_MEMORY(&before, &notch, sizeof notch);
    }
}

/// Of a notch that was in, none is left where it has lost its width.
static void test_a_notch_that_loses_its_width_is_out(void) {
    const lode_notch_tuning_t tuning = tuned(6.0, 0.5);
    lode_notch_t notch = empty();
    for (int k = 0; k < 100; k++) {
        (void)stepped(&notch, &tuning, 300.0f, (float)cos(0.3 * k));
    }
    lode_notch_adapt(&notch, &tuning, 0.0f, 300.0f);
    TEST_ASSERT_TRUE(lode_notch_step(&notch, 0.5f, 0.7f) == 0.7f);
}

static void test_no_jump_while_the_speed_changes(void) {
    // Twice up and down through the blend, sigma = 100: the harmonic at 500 .. 900 rad/s.
    const lode_notch_tuning_t tuning = tuned(6.0, 0.5);
    lode_notch_t notch = empty();
    double angle = 0.0;
    double before = 0.0;
    worst_t jump = {0.0};
    worst_t size = {0.0};
    for (int k = 0; k < 20000; k++) {
        const double centre = 700.0 - 200.0 * cos(2.0 * CHECK_PI * k / 10000.0);
        angle += centre * (double)PAPER_TS_s;
        const float error = (float)(0.1 + 0.05 * cos(angle));
        const double out = (double)stepped(&notch, &tuning, (float)(centre / 6.0), error);
        worst_note(&jump, k > 0 ? out - before : 0.0);
        worst_note(&size, out - 0.1);
        before = out;
    }
    // The input itself moves by 0.05 wn Ts = 0.009 per sample; the sweep, 0.13 rad/s per sample, adds
    // less than a tenth.
    CHECK_AT_MOST(1.1 * 0.05 * 900.0 * (double)PAPER_TS_s, jump.value);
    CHECK_AT_MOST(1.1 * 0.05, size.value);
}

static void test_an_offset_alone_never_moves(void) {
    // The filter runs before it is blended in: a constant passes at whatever speed.
    const lode_notch_tuning_t tuning = tuned(6.0, 0.5);
    lode_notch_t notch = empty();
    for (int k = 0; k < 40000; k++) {
        const double omega = 3000.0 * sin(2.0 * CHECK_PI * k / 20000.0);
        const float out = stepped(&notch, &tuning, (float)omega, 0.25f);
        // From reset the first blend begins after 21 ms and 1.6 time constants 2/(k wn): 3 % are
        // left of the start.
        CHECK_NEAR(k < 1000 ? 1.0e-2 : 2.0e-6, 0.25, out);
    }
}

// An error that is no number never gets here: the estimator starts anew instead. Speeds may be any.
static void test_adapting_is_total(void) {
    const lode_notch_tuning_t tuning = tuned(6.0, 0.5);
    random_t random = random_seed(3);
    lode_notch_t notch = empty();
    for (int n = 0; n < CHECK_TRIES(200000); n++) {
        const float speed = n < 3 ? check_not_finite[n] : random_any(&random);
        lode_notch_adapt(&notch, &tuning, tuning.k, speed);
        TEST_ASSERT_TRUE(lode_in_range(notch.weight, 0.0f, 1.0f));
        TEST_ASSERT_TRUE(
            lode_is_finite(lode_notch_step(&notch, tuning.k, random_float(&random, -1.0, 1.0))));
    }
}

static void test_adapting_now_and_then_is_enough(void) {
    // A ramp of 628 rad/s^2 moves the speed by 1 rad/s in LODE_SLOW_PERIODS; the notch is 150 rad/s
    // wide at 900 rpm.
    const lode_notch_tuning_t tuning = tuned(6.0, 0.5);
    lode_notch_t often = empty();
    lode_notch_t seldom = empty();
    double angle = 0.0;
    worst_t apart = {0.0};
    for (int k = 0; k < 5000; k++) {
        const double omega = 150.0 + 628.0 * (double)PAPER_TS_s * k;
        angle += 6.0 * omega * (double)PAPER_TS_s;
        const float error = (float)cos(angle);
        if (k % (int)LODE_SLOW_PERIODS == 0) {
            lode_notch_adapt(&seldom, &tuning, tuning.k, (float)omega);
        }
        worst_note(&apart, (double)stepped(&often, &tuning, (float)omega, error) -
                               (double)lode_notch_step(&seldom, tuning.k, error));
    }
    CHECK_AT_MOST(0.02, apart.value);
}

static lode_status_t try_width(size_t offset, float value) {
    (void)offset;
    lode_notch_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_notch_tuning_t before = tuning;
    const lode_status_t status = lode_notch_tune(&tuning, 6.0f, value, (float)SIGMA, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static void test_width_at_its_limits(void) {
    static const field_t width = {
        .name = "k", .lo = 0.01f, .hi = 2.0f, .zero_is_auto = true, .error = LODE_ERROR_NOTCH};
    field_check(&width, try_width);
    field_check_negative(&width, try_width);
    field_accepted(&width, try_width, -0.0f);
    field_refused(&width, try_width, FLT_MIN);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_harmonic_is_gone_where_the_notch_is_in);
    RUN_TEST(test_between_it_is_blended);
    RUN_TEST(test_it_stays_out_at_low_speed);
    RUN_TEST(test_it_is_bypassed_short_of_nyquist);
    RUN_TEST(test_without_width_there_is_no_notch);
    RUN_TEST(test_a_notch_that_loses_its_width_is_out);
    RUN_TEST(test_no_jump_while_the_speed_changes);
    RUN_TEST(test_an_offset_alone_never_moves);
    RUN_TEST(test_adapting_is_total);
    RUN_TEST(test_adapting_now_and_then_is_enough);
    RUN_TEST(test_width_at_its_limits);
    return UNITY_END();
}
