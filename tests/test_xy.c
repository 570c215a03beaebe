// The xy plane's current control on a circuit in double, with the 5th and 7th harmonic of the EMF.
#include "support/check.h"
#include "support/fields.h"

#include "xy_inline.h"

#include <complex.h>

void setUp(void) {}

void tearDown(void) {}

#define TS_s 1.0e-4
#define R_Ohm 0.8
#define L_H 0.9e-3
#define V_BUS 300.0f

typedef struct {
    lode_xy_t xy;
    lode_xy_tuning_t tuning;
    double L;
    double omega;
    double fifth_V;
    double seventh_V;
    double theta;
    double _Complex i;     ///< stator axes
    double _Complex asked; ///< by the last call: acts in this period
} plane_t;

static lode_status_t tune(lode_xy_tuning_t *tuning, const lode_xy_config_t *config, double L) {
    lode_xy_config_t complete = *config;
    lode_xy_design(&complete, (float)TS_s);
    return lode_xy_tune(tuning, &complete, (float)R_Ohm, (float)L, (float)TS_s);
}

static plane_t plane(const lode_xy_config_t *config, double omega) {
    plane_t p = {.L = L_H, .omega = omega};
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&p.tuning, config, L_H));
    lode_xy_reset(&p.xy);
    lode_xy_adapt(&p.xy, &p.tuning, (float)omega);
    return p;
}

static double _Complex emf(const plane_t *p, double theta) {
    return p->fifth_V * cexp(5.0 * I * theta) + p->seventh_V * cexp(-7.0 * I * theta);
}

static void step(plane_t *p) {
    const double _Complex now = p->i * cexp(I * p->theta);
    const lode_ab_t u =
        lode_xy_step(&p->xy, &p->tuning, (lode_ab_t){(float)creal(now), (float)cimag(now)}, V_BUS);
    const double applied = p->theta + 1.5 * p->omega * TS_s;
    for (int part = 0; part < 10; part++) {
        const double h = 0.1 * TS_s;
        const double middle = p->theta + h * (part + 0.5) * p->omega;
        p->i += h / p->L * (p->asked - R_Ohm * p->i - emf(p, middle));
    }
    p->asked = ((double)u.alpha + I * (double)u.beta) * cexp(-I * applied);
    p->theta = remainder(p->theta + p->omega * TS_s, 2.0 * CHECK_PI);
}

/// Largest current over `seconds`, after which the plane has moved on.
static double most(plane_t *p, double seconds) {
    worst_t worst = {0.0};
    for (int n = 0; n < (int)(seconds / TS_s); n++) {
        step(p);
        worst_note(&worst, cabs(p->i));
    }
    return worst.value;
}

static const lode_xy_config_t by_default = {.bandwidth_rad_s = 0.0f};
static const lode_xy_config_t plain = {.resonance_rad_s = LODE_NONE};

static void test_resonators_take_both_harmonics_away(void) {
    // 10 to 100 Hz, both ways: 6 w Ts up to 0.38.
    const double omegas[] = {63.0, 157.0, 314.0, 628.0, -157.0, -628.0};
    for (int n = 0; n < COUNT_OF(omegas); n++) {
        plane_t p = plane(&by_default, omegas[n]);
        p.fifth_V = p.seventh_V = 0.06 * 0.1746 * fabs(omegas[n]);
        (void)most(&p, 0.5);
        // exp(-33 * 0.5) of an ampere or so is left, and single-precision noise.
        CHECK_AT_MOST(1.0e-4, most(&p, 0.1));
    }
}

static void test_plain_pi_leaves_what_it_must(void) {
    plane_t p = plane(&plain, 314.0);
    p.fifth_V = 0.06 * 0.1746 * 314.0;
    (void)most(&p, 0.5);
    // The 5th, seen from the frame, at 6 w: current e/(L d), and the resistance that (X3) leaves out.
    const double _Complex late = cexp(-I * 6.0 * 314.0 * 1.5 * TS_s);
    const double _Complex own = R_Ohm + I * 5.0 * 314.0 * L_H;
    const double _Complex pi = 1000.0 * (L_H + R_Ohm / (I * 6.0 * 314.0));
    // Sampled as it is, with a hold: a few percent off the continuous loop.
    CHECK_CLOSE(0.05, p.fifth_V / cabs(own + pi * late), most(&p, 0.1));
}

static void test_harmonics_die_at_the_rate_asked_for(void) {
    const float rates[] = {20.0f, 50.0f, 100.0f};
    for (int n = 0; n < COUNT_OF(rates); n++) {
        plane_t p = plane(&(lode_xy_config_t){.resonance_rad_s = rates[n]}, 314.0);
        p.fifth_V = 3.0;
        (void)most(&p, 0.03);
        const double before = most(&p, 0.01);
        const double after = most(&p, 0.01);
        // Second-order terms in rate over 6 w and bandwidth.
        CHECK_CLOSE(0.25, (double)rates[n], log(before / after) / 0.01);
    }
}

static void test_stable_with_half_and_twice_the_inductance(void) {
    const double shares[] = {0.5, 2.0};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        plane_t p = plane(&by_default, 314.0);
        p.L = shares[n] * L_H;
        p.fifth_V = p.seventh_V = 3.0;
        (void)most(&p, 1.0);
        CHECK_AT_MOST(1.0e-3, most(&p, 0.1));
    }
}

static void test_voltage_stays_inside_its_share_and_comes_back(void) {
    plane_t p = plane(&by_default, 314.0);
    p.fifth_V = 60.0; // three times the share
    const double radius = 0.1 * 300.0 / sqrt(3.0);
    for (int n = 0; n < 10000; n++) {
        step(&p);
        CHECK_AT_MOST(1.00001 * radius, cabs(p.asked));
    }
    p.fifth_V = 3.0;
    (void)most(&p, 0.5);
    CHECK_AT_MOST(1.0e-3, most(&p, 0.1));
}

/// (X4): what just reaches the circle is put out and taken in, what is beyond it is shortened and not.
static void test_the_circle_itself_is_within(void) {
    const lode_xy_config_t config = {.voltage_share = 0.1f};
    plane_t p = plane(&config, 0.0);
    p.tuning.pi.kp = 1.0f;
    p.tuning.circle = 0.5f;
    const lode_ab_t u_V = lode_xy_step(&p.xy, &p.tuning, (lode_ab_t){-3.0f, -4.0f}, 10.0f);
    TEST_ASSERT_TRUE(u_V.alpha == 3.0f && u_V.beta == 4.0f);
    TEST_ASSERT_TRUE(p.xy.x.integral > 0.0f && p.xy.y.integral > 0.0f);
    p = plane(&config, 0.0);
    p.tuning.pi.kp = 1.0f;
    p.tuning.circle = 0.5f;
    const lode_ab_t cut_V = lode_xy_step(&p.xy, &p.tuning, (lode_ab_t){-6.0f, -8.0f}, 10.0f);
    CHECK_NEAR(1.0e-6, 3.0, cut_V.alpha);
    CHECK_NEAR(1.0e-6, 4.0, cut_V.beta);
    CHECK_NEAR(0.0, 0.0, p.xy.x.integral);
    CHECK_NEAR(0.0, 0.0, p.xy.y.integral);
}

static void test_too_fast_for_a_resonance_the_pi_is_left(void) {
    plane_t p = plane(&by_default, 2700.0); // 6 w Ts = 1.62
    p.fifth_V = 3.0;
    (void)most(&p, 0.2);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, p.xy.aim.gain_Ohm);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, p.xy.resonance_x.alpha);
    CHECK_AT_MOST(1.0, most(&p, 0.1)); // stable
}

/// A speed at which no resonance can be placed ends those that are there, and none builds up.
static void test_too_fast_the_resonances_are_gone(void) {
    plane_t p = plane(&by_default, 314.0);
    p.xy.resonance_x = p.xy.resonance_y = (lode_ab_t){3.0f, -4.0f};
    lode_xy_adapt(&p.xy, &p.tuning, 2700.0f);
    p.xy.x.integral = p.xy.y.integral = 0.0f;
    const lode_ab_t none_V = lode_xy_step(&p.xy, &p.tuning, (lode_ab_t){0.0f, 0.0f}, V_BUS);
    CHECK_NEAR(0.0, 0.0, none_V.alpha);
    CHECK_NEAR(0.0, 0.0, none_V.beta);
    (void)lode_xy_step(&p.xy, &p.tuning, (lode_ab_t){0.1f, 0.1f}, V_BUS);
    CHECK_NEAR(0.0, 0.0, p.xy.resonance_x.alpha);
    CHECK_NEAR(0.0, 0.0, p.xy.resonance_y.alpha);
}

/// Nothing of before is left: no voltage without current, and no resonance before the first speed.
static void test_reset_leaves_nothing(void) {
    plane_t p = plane(&by_default, 314.0);
    p.fifth_V = p.seventh_V = 10.0;
    (void)most(&p, 0.1);
    lode_xy_reset(&p.xy);
    const lode_ab_t none_V = lode_xy_step(&p.xy, &p.tuning, (lode_ab_t){0.0f, 0.0f}, V_BUS);
    CHECK_NEAR(0.0, 0.0, none_V.alpha);
    CHECK_NEAR(0.0, 0.0, none_V.beta);
    (void)lode_xy_step(&p.xy, &p.tuning, (lode_ab_t){0.1f, 0.1f}, V_BUS);
    CHECK_NEAR(0.0, 0.0, p.xy.resonance_x.alpha);
    CHECK_NEAR(0.0, 0.0, p.xy.resonance_y.alpha);
}

/// (X3) At a crawl the integrator of the PI counts four times as much as the loop, and no more: the resonators
/// have sqrt(17) of the gain that they would have without a resistance. Without one, and at rest, it is finite.
static void test_at_a_crawl_the_gain_ends(void) {
    const float omegas[] = {0.0f, 0.01f, 1.0f, -1.0f};
    for (int n = 0; n < COUNT_OF(omegas); n++) {
        plane_t p = plane(&by_default, (double)omegas[n]);
        lode_xy_t pure;
        lode_xy_reset(&pure);
        p.tuning.corner_rad_s = 0.0f;
        lode_xy_adapt(&pure, &p.tuning, omegas[n]);
        CHECK_CLOSE(1.0e-4, sqrt(17.0) * (double)pure.aim.gain_Ohm, p.xy.aim.gain_Ohm);
        CHECK_NEAR(1.0e-5, 1.0, hypot((double)pure.aim.lead.sin, (double)pure.aim.lead.cos));
    }
}

static void test_slow_speeds_do_no_harm(void) {
    plane_t p = plane(&by_default, 0.0);
    p.i = 5.0;
    (void)most(&p, 0.5);
    CHECK_AT_MOST(1.0e-3, most(&p, 0.1));
}

static lode_status_t try_one(size_t offset, float value) {
    lode_xy_config_t config = by_default;
    memcpy((char *)&config + offset, &value, sizeof value);
    lode_xy_tuning_t tuning;
    return tune(&tuning, &config, L_H);
}

static void test_fields(void) {
    const field_t fields[] = {
        {FIELD(lode_xy_config_t, bandwidth_rad_s), .lo = 1.0f, .hi = 4000.0f, .computed = true,
         .zero_is_auto = true, .error = LODE_ERROR_XY_BANDWIDTH}, // 0.4/Ts
        {FIELD(lode_xy_config_t, voltage_share), .lo = 0.0f, .hi = 0.5f, .zero_is_auto = true,
         .error = LODE_ERROR_XY_VOLTAGE},
    };
    field_check_all(fields, COUNT_OF(fields), try_one);
    const size_t rate = offsetof(lode_xy_config_t, resonance_rad_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(rate, LODE_NONE));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(rate, 250.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_XY_BANDWIDTH, try_one(rate, 251.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_XY_BANDWIDTH, try_one(rate, -2.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_XY_BANDWIDTH, try_one(rate, -0.5f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(rate, 0.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_XY_BANDWIDTH, try_one(rate, NAN));
}

static void test_inductance_is_needed(void) {
    lode_xy_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_XY_INDUCTANCE, tune(&tuning, &by_default, 0.0));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_XY_INDUCTANCE, tune(&tuning, &by_default, 0.99e-7));
    TEST_ASSERT_EQUAL_INT(LODE_OK, tune(&tuning, &by_default, 1.01e-7));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_XY_INDUCTANCE, tune(&tuning, &by_default, 11.0));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_XY_INDUCTANCE, tune(&tuning, &by_default, (double)NAN));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_resonators_take_both_harmonics_away);
    RUN_TEST(test_plain_pi_leaves_what_it_must);
    RUN_TEST(test_harmonics_die_at_the_rate_asked_for);
    RUN_TEST(test_stable_with_half_and_twice_the_inductance);
    RUN_TEST(test_voltage_stays_inside_its_share_and_comes_back);
    RUN_TEST(test_the_circle_itself_is_within);
    RUN_TEST(test_too_fast_for_a_resonance_the_pi_is_left);
    RUN_TEST(test_too_fast_the_resonances_are_gone);
    RUN_TEST(test_reset_leaves_nothing);
    RUN_TEST(test_at_a_crawl_the_gain_ends);
    RUN_TEST(test_slow_speeds_do_no_harm);
    RUN_TEST(test_fields);
    RUN_TEST(test_inductance_is_needed);
    return UNITY_END();
}
