// SOGI: golden notch, gains at DC, at the centre and at the edges of the band, quadrature pair.
#include "support/check.h"

#include "golden/sogi.h"
#include "sogi_inline.h"

void setUp(void) {}

void tearDown(void) {}

/// Tuned and stepped in one.
static lode_sogi_out_t stepped(lode_sogi_t *sogi, float k, float wn_Ts, float x) {
    const lode_sogi_tuning_t tuning = lode_sogi_tune(k, wn_Ts);
    return lode_sogi_step(sogi, &tuning, x);
}

static void test_notch_against_the_direct_form(void) {
    for (int c = 0; c < COUNT_OF(sogi_cases); c++) {
        const sogi_case_t *golden = &sogi_cases[c];
        lode_sogi_t sogi;
        lode_sogi_reset(&sogi);
        for (int n = 0; n < COUNT_OF(golden->input); n++) {
            const lode_sogi_out_t out =
                stepped(&sogi, (float)golden->k, (float)golden->wn_Ts, (float)golden->input[n]);
            // Inputs up to 1; a float centre is off by 6e-8 and its error adds up over 120 steps.
            CHECK_NEAR(3.0e-6, golden->notch[n], out.notch);
            CHECK_NEAR(1.0e-6, golden->input[n], out.notch + out.in_phase);
        }
    }
}

/// A phasor: amplitude and phase of an output in answer to cos(W n).
typedef struct {
    double re;
    double im;
} phasor_t;

typedef struct {
    phasor_t notch;
    phasor_t in_phase;
    phasor_t quadrature;
} response_t;

static void correlate(phasor_t *sum, double angle, double x, double share) {
    sum->re += share * x * cos(angle);
    sum->im -= share * x * sin(angle);
}

/// Steady response at W = 2 pi m / 4000 by correlation over whole turns, after settling.
static response_t respond(float k, float wn_Ts, double turn, int settle) {
    lode_sogi_t sogi;
    lode_sogi_reset(&sogi);
    response_t response = {{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}};
    for (int n = 0; n < settle + 4000; n++) {
        const double angle = turn * n;
        const lode_sogi_out_t out = stepped(&sogi, k, wn_Ts, (float)cos(angle));
        if (n >= settle) {
            correlate(&response.notch, angle, (double)out.notch, 2.0 / 4000.0);
            correlate(&response.in_phase, angle, (double)out.in_phase, 2.0 / 4000.0);
            correlate(&response.quadrature, angle, (double)out.quadrature, 2.0 / 4000.0);
        }
    }
    return response;
}

static double gain_of(phasor_t x) {
    return sqrt(x.re * x.re + x.im * x.im);
}

// Centres of whole turns in 4000 samples.
static const int centres[] = {40, 360, 900, 1500};
static const float widths[] = {0.1f, 0.5f, 1.4f};

static void test_at_the_centre_the_notch_is_zero_and_the_pair_in_quadrature(void) {
    for (int c = 0; c < COUNT_OF(centres); c++) {
        for (int w = 0; w < COUNT_OF(widths); w++) {
            const double turn = 2.0 * CHECK_PI * centres[c] / 4000.0;
            const response_t r = respond(widths[w], (float)turn, turn, 20000);
            // The centre in float is off by some 2.5e-7 of it, against half the relative width.
            const double off = 5.0e-7 / (double)widths[w] + 1.0e-6;
            CHECK_NEAR(off, 0.0, gain_of(r.notch));
            CHECK_NEAR(off, 1.0, r.in_phase.re);
            CHECK_NEAR(off, 0.0, r.in_phase.im);
            CHECK_NEAR(off, 0.0, r.quadrature.re);
            CHECK_NEAR(off, -1.0, r.quadrature.im);
        }
    }
}

static void test_edges_of_the_band(void) {
    for (int c = 0; c < COUNT_OF(centres); c++) {
        for (int w = 0; w < COUNT_OF(widths); w++) {
            const double wn = 2.0 * CHECK_PI * centres[c] / 4000.0;
            const double half_k = 0.5 * (double)widths[w];
            for (int sign = -1; sign <= 1; sign += 2) {
                // Prewarped at wn: tan(W/2)/tan(wn/2) = sqrt(1 + k^2/4) +- k/2, eq. (34) at -3 dB.
                const double edge = sqrt(1.0 + half_k * half_k) + sign * half_k;
                const double turn = 2.0 * atan(edge * tan(0.5 * wn));
                // The edge is no whole turn in the window: take the nearest one within reach of
                // the slope and compare with the transfer function there.
                const double bin = round(turn * 4000.0 / (2.0 * CHECK_PI));
                const double near = 2.0 * CHECK_PI * bin / 4000.0;
                const double x = tan(0.5 * near) / tan(0.5 * wn);
                const double expected = fabs(1.0 - x * x) / sqrt((1.0 - x * x) * (1.0 - x * x) +
                                                                 4.0 * half_k * half_k * x * x);
                const response_t r = respond(widths[w], (float)wn, near, 20000);
                CHECK_NEAR(2.0e-5, expected, gain_of(r.notch)); // floats over 4000 samples
                if (widths[w] > 0.2f && centres[c] > 300) {
                    CHECK_NEAR(0.005, sqrt(0.5), gain_of(r.notch)); // half a bin off the edge
                }
            }
        }
    }
}

static void test_dc_passes(void) {
    for (int c = 0; c < COUNT_OF(centres); c++) {
        lode_sogi_t sogi;
        lode_sogi_reset(&sogi);
        lode_sogi_out_t out = {0.0f, 0.0f, 0.0f};
        for (int n = 0; n < 20000; n++) {
            out = stepped(&sogi, 0.5f, (float)(2.0 * CHECK_PI * centres[c] / 4000.0), 3.0f);
        }
        CHECK_NEAR(1.0e-5, 3.0, out.notch); // rounding of the integrators
        CHECK_NEAR(1.0e-5, 0.0, out.in_phase);
    }
}

static void test_width_and_centre_are_clamped(void) {
    lode_sogi_t a;
    lode_sogi_t b;
    lode_sogi_reset(&a);
    lode_sogi_reset(&b);
    random_t random = random_seed(1);
    const float cases[][4] = {{5.0f, 1.0f, 2.0f, 1.0f},
                              {-1.0f, 1.0f, 0.001f, 1.0f},
                              {NAN, 1.0f, 0.001f, 1.0f},
                              {0.5f, 9.0f, 0.5f, LODE_SOGI_CENTRE_MAX_rad},
                              {0.5f, -1.0f, 0.5f, LODE_SOGI_CENTRE_MIN_rad},
                              {0.5f, NAN, 0.5f, LODE_SOGI_CENTRE_MIN_rad}};
    for (int n = 0; n < 600; n++) {
        const float *c = cases[n % COUNT_OF(cases)];
        const float x = random_float(&random, -1.0, 1.0);
        const lode_sogi_out_t asked = stepped(&a, c[0], c[1], x);
        const lode_sogi_out_t clamped = stepped(&b, c[2], c[3], x);
        TEST_ASSERT_EQUAL_MEMORY(&clamped, &asked, sizeof asked);
    }
}

/// Down to 0.001 the width is what is asked for, and no less.
static void test_narrow_bands_are_taken_as_they_are(void) {
    const double wide = (double)lode_sogi_tune(0.002f, 0.5f).inv_sum;
    CHECK_AT_LEAST(1.0e-4, (double)lode_sogi_tune(0.001f, 0.5f).inv_sum - wide);
    CHECK_NEAR(0.0, lode_sogi_tune(0.001f, 0.5f).inv_sum, lode_sogi_tune(0.0005f, 0.5f).inv_sum);
}

static void test_a_moving_centre_stays_bounded(void) {
    lode_sogi_t sogi;
    lode_sogi_reset(&sogi);
    random_t random = random_seed(2);
    worst_t worst = {0.0};
    for (int n = 0; n < CHECK_TRIES(500000); n++) {
        const float centre = random_float(&random, 1.0e-4, 2.5);
        const lode_sogi_out_t out = stepped(&sogi, 0.5f, centre, random_float(&random, -1.0, 1.0));
        worst_note(&worst, (double)out.notch);
        worst_note(&worst, (double)out.quadrature);
    }
    // The trapezoidal integrators do not gain energy band^2 + low^2 but from the input, which puts
    // in at most |band| |x| while the damping takes out k band^2; measured 3.
    CHECK_AT_MOST(8.0, worst.value);
}

static void test_a_slow_sweep_follows_the_input(void) {
    lode_sogi_t sogi;
    lode_sogi_reset(&sogi);
    double angle = 0.0;
    worst_t worst = {0.0};
    for (int n = 0; n < 200000; n++) {
        const double turn = 0.05 + 1.5 * n / 200000.0;
        angle += turn;
        const lode_sogi_out_t out = stepped(&sogi, 0.5f, (float)turn, (float)cos(angle));
        if (n > 2000) {
            worst_note(&worst, (double)out.notch);
        }
    }
    // The centre moves by 7.5e-6 rad per sample; over the 4/(k wn) samples of memory at the slow
    // end (160) it lags by 1.2e-3 rad of a half-width of 0.0125.
    CHECK_AT_MOST(0.05, worst.value);
}

static void test_tuning_is_total(void) {
    random_t random = random_seed(3);
    for (int n = 0; n < CHECK_TRIES(500000); n++) {
        const lode_sogi_tuning_t t = lode_sogi_tune(random_any(&random), random_any(&random));
        TEST_ASSERT_TRUE(lode_in_range(t.width, 0.001f, 2.0f));
        // The prewarped gain at 1e-4 and 2.5 rad per sample: 5e-5 and 3.01.
        CHECK_AT_LEAST(4.9e-5, (double)t.g);
        CHECK_AT_MOST(3.02, (double)t.g);
        TEST_ASSERT_TRUE(t.inv_sum > 0.0f && t.inv_sum <= 1.0f);
    }
}

// What is no number is kept out by the caller, and the step no longer looks: its input is bounded.
static void test_outputs_are_finite_for_any_input_in_bounds(void) {
    lode_sogi_t sogi;
    lode_sogi_reset(&sogi);
    random_t random = random_seed(4);
    for (int n = 0; n < CHECK_TRIES(500000); n++) {
        const float x = lode_clamp(random_any(&random), -1.0e12f, 1.0e12f);
        const lode_sogi_out_t out = stepped(&sogi, random_any(&random), random_any(&random), x);
        TEST_ASSERT_TRUE(lode_is_finite(out.notch) && lode_is_finite(out.in_phase) &&
                         lode_is_finite(out.quadrature));
    }
}

static void test_the_narrowest_band_in_resonance_stays_finite(void) {
    // The largest input at the centre of the narrowest band: the pair builds up to that input.
    const float centres_rad[] = {LODE_SOGI_CENTRE_MIN_rad, 0.3f, LODE_SOGI_CENTRE_MAX_rad};
    for (int c = 0; c < COUNT_OF(centres_rad); c++) {
        lode_sogi_t sogi;
        lode_sogi_reset(&sogi);
        const lode_sogi_tuning_t tuning = lode_sogi_tune(0.0f, centres_rad[c]);
        for (int n = 0; n < 300000; n++) {
            const float x =
                1.0e12f * lode_sign(cosf((float)fmod((double)centres_rad[c] * n, 2.0 * CHECK_PI)));
            const lode_sogi_out_t out = lode_sogi_step(&sogi, &tuning, x);
            // A square wave has 4/pi of its fundamental.
            CHECK_AT_MOST(1.5e12, fabsf(out.in_phase));
            CHECK_AT_MOST(1.5e12, fabsf(out.quadrature));
        }
    }
}

static void test_reset_empties_both_integrators(void) {
    lode_sogi_t sogi = {1.0f, NAN};
    lode_sogi_reset(&sogi);
    TEST_ASSERT_TRUE(sogi.band == 0.0f && sogi.low == 0.0f);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_notch_against_the_direct_form);
    RUN_TEST(test_at_the_centre_the_notch_is_zero_and_the_pair_in_quadrature);
    RUN_TEST(test_edges_of_the_band);
    RUN_TEST(test_dc_passes);
    RUN_TEST(test_width_and_centre_are_clamped);
    RUN_TEST(test_narrow_bands_are_taken_as_they_are);
    RUN_TEST(test_a_moving_centre_stays_bounded);
    RUN_TEST(test_a_slow_sweep_follows_the_input);
    RUN_TEST(test_tuning_is_total);
    RUN_TEST(test_outputs_are_finite_for_any_input_in_bounds);
    RUN_TEST(test_the_narrowest_band_in_resonance_stays_finite);
    RUN_TEST(test_reset_empties_both_integrators);
    return UNITY_END();
}
