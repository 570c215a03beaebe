// Speed control: ramped reference, PI in torque, load feed-forward, limits.
#include "support/fields.h"

#include <string.h>

#include "speed_inline.h"

void setUp(void) {}

void tearDown(void) {}

static const lode_inverter_config_t inverter = {.v_bus_V = 200.0f, .i_max_A = 12.0f};
static const lode_pll_config_t pll = {.sigma_rad_s = 150.0f,
                                      .sigma_low_rad_s = 100.0f,
                                      .omega_low_rad_s = 150.0f,
                                      .omega_high_rad_s = 200.0f};
#define TORQUE_MAX (12.0 * 0.639) // 1.5 np psi i_max

// To rated speed with all of it.
#define RUN_UP_s (0.0174 * PAPER_OMEGA_RATED / 3.0 / TORQUE_MAX)

static lode_speed_config_t sound(void) {
    return (lode_speed_config_t){.kp_Nms = 0.8f,
                                 .ki_Nm = 6.0f,
                                 .bandwidth_rad_s = 46.0f,
                                 .gain_rise = 1.0f,
                                 .ramp_rad_s2 = 200.0f,
                                 .inertia_feed_forward = LODE_NONE,
                                 .dip_gain = LODE_NONE,
                                 .swing_Nm = LODE_NONE,
                                 .load_feed_forward = 0.5f,
                                 .every_period = LODE_OFF,
                                 .omega_min_rad_s = 47.0f};
}

static lode_speed_tuning_t tuned(const lode_speed_config_t *config) {
    const lode_motor_t motor = paper_motor();
    lode_speed_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_speed_tune(&tuning, config, &motor, &pll, PAPER_TS_s));
    return tuning;
}

/// (K46) of that configuration: half of the load up to 100 rad/s, and from 200 on what a sigma of 150 instead of 100 leaves.
static double fed_at(double omega) {
    return 0.5 - 0.5 * (1.0 - 1.0 / 2.25) * fmin(fmax(omega / 100.0 - 1.0, 0.0), 1.0);
}

static void test_reference_is_a_mechanical_ramp(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 20.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
    for (int n = 1; n <= 3000; n++) {
        (void)lode_speed_step(&speed, &tuning, 100.0f, 60.0f, 0.0f);
        // 200 rad/s^2; 2500 additions of 0.04 in float.
        CHECK_NEAR(0.02, fmin(100.0, 20.0 + 200.0 * 2.0e-4 * n), speed.reference_rad_s);
    }
    TEST_ASSERT_EQUAL_FLOAT(100.0f, speed.reference_rad_s);
}

static void test_torque_is_pi_and_feed_forward(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 50.0f, 1.5f, 2.0f, (float)TORQUE_MAX);
    for (int n = 0; n < 50; n++) {
        // The rotor, 3 pole pairs, is 1 rad/s slow; the load rises to 3 Nm, a share of it is fed.
        const float torque = lode_speed_step(&speed, &tuning, 50.0f, 147.0f, 3.0f);
        const double integral = 1.5 - fed_at(150.0) * 2.0 + 6.0 * 2.0e-4 * n;
        CHECK_NEAR(1.0e-5, 0.8 * 1.0 + integral + fed_at(147.0) * 3.0, torque);
    }
}

/// (K47): where more than 30 % of the speed is gone; not where the rotor is too fast, nor below the lowest speed.
static void test_a_deep_dip_has_more_gain(void) {
    lode_speed_config_t config = sound();
    config.load_feed_forward = LODE_NONE;
    config.gain_rise = 1.5f;
    config.dip_gain = 2.0f;
    const lode_speed_tuning_t tuning = tuned(&config);
    const double least = (double)tuning.dip_least;
    CHECK_CLOSE(1.0e-6, 47.0 / 3.0, least);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, tuning.dip_gain);
    const struct {
        double reference, omega, more; // mechanical, and of the error that counts twice more
    } cases[] = {
        {30.0, 21.001, 0.0},       {30.0, 20.0, 1.0},         {30.0, 5.0, 16.0},
        {30.0, -3.0, 24.0},        {30.0, 60.0, 0.0},         {15.7, 8.0, 2.99},
        {15.6, 8.0, 0.0},          {200.0, 135.0, 5.0 * 1.5}, {100.0, 0.0, 70.0},
        {least, 0.0, 0.7 * least}, {200.0, 140.1, 0.0},       {200.0, 139.0, 1.5},
    };
    for (int n = 0; n < 2 * COUNT_OF(cases); n++) {
        const double sign = n % 2 == 0 ? 1.0 : -1.0;
        const double reference = sign * cases[n / 2].reference;
        const double omega = sign * cases[n / 2].omega;
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, (float)reference, 0.5f, 0.0f, 1.0e4f);
        const double gain = 1.0 + 0.5 * fmin(fmax(fabs(3.0 * omega) / 200.0 - 1.0, 0.0), 1.0);
        const double torque = 0.8 * (gain * (reference - omega) + 2.0 * sign * cases[n / 2].more);
        CHECK_NEAR(2.0e-3, 0.5 + torque,
                   lode_speed_step(&speed, &tuning, (float)reference, 3.0f * (float)omega, 0.0f));
    }
}

/// (K47) takes no room from the integral, as the proportional part does not.
static void test_a_deep_dip_leaves_the_integral_alone(void) {
    lode_speed_config_t config = sound();
    float integral[2];
    for (int n = 0; n < 2; n++) {
        config.dip_gain = n == 0 ? LODE_NONE : 5.0f;
        const lode_speed_tuning_t tuning = tuned(&config);
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, 30.0f, 2.0f, 0.0f, 3.0f);
        TEST_ASSERT_EQUAL_FLOAT(3.0f, lode_speed_step(&speed, &tuning, 30.0f, 30.0f, 0.0f));
        integral[n] = speed.pi.integral;
    }
    TEST_ASSERT_EQUAL_FLOAT(integral[0], integral[1]);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, integral[1]);
}

// Corrections of +-`torque_Nm` in turn, each for `calls`.
static void swing(lode_speed_t *speed, const lode_speed_tuning_t *tuning, double torque_Nm,
                  int calls, int half_waves) {
    for (int n = 0; n < half_waves * calls; n++) {
        const double error = (n / calls % 2 == 0 ? 1.0 : -1.0) * torque_Nm / 0.8;
        (void)lode_speed_step(speed, tuning, 50.0f, 3.0f * (float)(50.0 - error), 0.0f);
    }
}

// Half a period of sigma at low speed, 100 rad/s, in calls.
#define HALF_WAVE_CALLS (CHECK_PI / (100.0 * (double)PAPER_TS_s))

static lode_speed_config_t watched(void) {
    lode_speed_config_t config = sound();
    config.load_feed_forward = LODE_NONE;
    config.swing_Nm = 0.5f;
    return config;
}

/// (K48)
static void test_a_swing_halves_the_gains(void) {
    const lode_speed_config_t config = watched();
    const lode_speed_tuning_t tuning = tuned(&config);
    CHECK_CLOSE(1.0e-6, 1.5 * HALF_WAVE_CALLS, tuning.swing_calls);
    const int longest = (int)ceil(1.5 * HALF_WAVE_CALLS) + 1;
    const struct {
        double torque_Nm;
        int calls, half_waves;
        double gain;
    } cases[] = {
        {0.51, longest, 15, 1.0}, {0.51, longest, 16, 0.5},     {0.51, 1, 16, 0.5},
        {1.01, 40, 31, 0.5},      {1.01, 40, 32, 0.25},         {9.0, 40, 90, 0.25},
        {0.99, 40, 60, 0.5},      {0.51, longest + 1, 60, 1.0}, {0.49, 40, 60, 1.0},
        {50.0, 1000, 30, 1.0}, // of loads
    };
    for (int n = 0; n < COUNT_OF(cases); n++) {
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, 50.0f, 0.0f, 0.0f, 1.0e4f);
        swing(&speed, &tuning, cases[n].torque_Nm, cases[n].calls, cases[n].half_waves);
        TEST_ASSERT_EQUAL_UINT(cases[n].gain > 0.9 ? 0u : (cases[n].gain > 0.4 ? 1u : 2u),
                               speed.calmed);
        TEST_ASSERT_LESS_OR_EQUAL_UINT(1u, speed.swung_up);
        const double integral = (double)speed.pi.integral;
        CHECK_NEAR(1.0e-4, integral + cases[n].gain * 0.8 * 3.0,
                   lode_speed_step(&speed, &tuning, 50.0f, 3.0f * 47.0f, 0.0f));
        CHECK_NEAR(1.0e-4, cases[n].gain * 6.0 * 3.0 * PAPER_TS_s,
                   (double)speed.pi.integral - integral);
        lode_speed_reset(&speed, &tuning, 50.0f, 0.0f, 0.0f, 1.0e4f); // the next start
        CHECK_NEAR(1.0e-4, 0.8 * 3.0, lode_speed_step(&speed, &tuning, 50.0f, 3.0f * 47.0f, 0.0f));
    }
}

/// A swing that pauses begins anew.
static void test_half_waves_of_two_swings_do_not_add(void) {
    const lode_speed_config_t config = watched();
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 50.0f, 0.0f, 0.0f, 1.0e4f);
    for (int n = 0; n < 10; n++) {
        swing(&speed, &tuning, 1.0, 40, 14);
        swing(&speed, &tuning, 0.0, (int)ceil(1.5 * HALF_WAVE_CALLS) + 2, 1);
    }
    TEST_ASSERT_EQUAL_FLOAT(1.0f, lode_speed_calm(&speed));
    swing(&speed, &tuning, 1.0, 40, 16);
    TEST_ASSERT_EQUAL_FLOAT(LODE_SPEED_CALM, lode_speed_calm(&speed));
}

/// (K48): the ramp's torque is halved with the gains, that of a deep dip is not.
static void test_what_halved_gains_leave(void) {
    lode_speed_config_t config = watched();
    config.inertia_feed_forward = 1.0f;
    config.dip_gain = 2.0f;
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed[3];
    for (int n = 0; n < 3; n++) {
        lode_speed_reset(&speed[n], &tuning, 50.0f, 0.0f, 0.0f, 1.0e4f);
        speed[n].calmed = (uint_least8_t)n;
    }
    // 0.04 rad/s per call
    CHECK_NEAR(1.0e-4, 0.8 * 0.04 + 0.0174 * 200.0,
               lode_speed_step(&speed[0], &tuning, 80.0f, 150.0f, 0.0f));
    CHECK_NEAR(1.0e-4, 0.5 * (0.8 * 0.04 + 0.0174 * 200.0),
               lode_speed_step(&speed[1], &tuning, 80.0f, 150.0f, 0.0f));
    CHECK_NEAR(1.0e-4, 0.25 * (0.8 * 0.04 + 0.0174 * 200.0),
               lode_speed_step(&speed[2], &tuning, 80.0f, 150.0f, 0.0f));
    // at the border of a dip as much less torque; beyond it the same slope, half of it after the second halving
    static const double before[] = {1.0, 0.5, 0.25};
    static const double beyond[] = {1.0, 1.0, 0.5};
    for (int n = 0; n < 3; n++) {
        lode_speed_reset(&speed[n], &tuning, 50.0f, 0.0f, 0.0f, 1.0e4f);
        speed[n].calmed = (uint_least8_t)n;
        CHECK_NEAR(2.0e-3, before[n] * 0.8 * 15.0 + beyond[n] * 0.8 * 3.0 * 10.0,
                   lode_speed_step(&speed[n], &tuning, 50.0f, 3.0f * 25.0f, 0.0f));
    }
}

/// (K46): all of the share at low speed, and with the full sigma as much less as keeps its part in the loop.
static void test_less_of_a_load_is_fed_forward_at_speed(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    for (int n = -30; n <= 30; n++) {
        CHECK_CLOSE(1.0e-6, fed_at(fabs(10.0 * n)), lode_speed_fed(&tuning, 10.0f * (float)n));
    }
    CHECK_CLOSE(1.0e-6, 0.5, fed_at(100.0));
    CHECK_CLOSE(1.0e-6, 0.5 * 100.0 * 100.0, 150.0 * 150.0 * fed_at(200.0));
    lode_pll_config_t steady = pll;
    steady.sigma_low_rad_s = steady.sigma_rad_s;
    const lode_motor_t motor = paper_motor();
    lode_speed_tuning_t flat;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_speed_tune(&flat, &config, &motor, &steady, PAPER_TS_s));
    TEST_ASSERT_EQUAL_FLOAT(0.5f, lode_speed_fed(&flat, 1000.0f));
}

// One call of torque control between 20 and 80 rad/s.
static float torque_control(lode_speed_t *speed, const lode_speed_tuning_t *tuning, float torque,
                            float omega, float load) {
    const lode_range_t between = {20.0f, 80.0f};
    const float target = lode_speed_torque_target(speed, tuning, torque, between, omega, load);
    return lode_speed_step(speed, tuning, target, omega, load);
}

static void test_torque_is_followed_between_two_speeds(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 50.0f, 1.0f, 2.0f, (float)TORQUE_MAX);
    CHECK_NEAR(1.0e-6, 3.0, torque_control(&speed, &tuning, 3.0f, 150.0f, 2.0f));
    TEST_ASSERT_EQUAL_FLOAT(50.0f, speed.reference_rad_s);
    // Speed control goes on with it.
    CHECK_NEAR(1.0e-5, 3.0, lode_speed_step(&speed, &tuning, 50.0f, 150.0f, 2.0f));
    // Within the limits.
    speed.limit_Nm = (lode_range_t){-2.5f, 2.0f};
    CHECK_NEAR(1.0e-6, 2.0, torque_control(&speed, &tuning, 3.0f, 150.0f, 0.0f));
    CHECK_NEAR(1.0e-6, -2.5, torque_control(&speed, &tuning, -3.0f, 150.0f, 0.0f));
    // Beyond an end speed control holds that end.
    lode_speed_reset(&speed, &tuning, 50.0f, 1.0f, 0.0f, (float)TORQUE_MAX);
    CHECK_NEAR(1.0e-5, 0.4 - 0.8 * 2.0, torque_control(&speed, &tuning, 1.0f, 246.0f, 0.4f));
    TEST_ASSERT_EQUAL_FLOAT(80.0f, speed.reference_rad_s);
    CHECK_NEAR(1.0e-5, 0.4 - 0.8 * 2.0 - 6.0 * 2.0e-4 * 2.0,
               torque_control(&speed, &tuning, 1.0f, 246.0f, 0.4f)); // by its integral from then on
    lode_speed_reset(&speed, &tuning, 50.0f, -3.0f, 0.0f, (float)TORQUE_MAX);
    CHECK_NEAR(1.0e-5, -0.4 + 0.8 * 2.0, torque_control(&speed, &tuning, -3.0f, 54.0f, -0.4f));
    TEST_ASSERT_EQUAL_FLOAT(20.0f, speed.reference_rad_s);
    // And by its own integral from then on.
    const double next = -0.4 + 0.8 * 2.0 + 6.0 * 2.0e-4 * 2.0;
    CHECK_NEAR(1.0e-5, next, torque_control(&speed, &tuning, -3.0f, 54.0f, -0.4f));
    // Until the torque points inwards again.
    CHECK_NEAR(1.0e-5, 3.0, torque_control(&speed, &tuning, 3.0f, 54.0f, -0.4f));
    TEST_ASSERT_EQUAL_FLOAT(18.0f, speed.reference_rad_s);
}

/// An end of the range that is held takes no more than the commanded torque with (K47) either.
static void test_a_dip_does_not_exceed_the_commanded_torque(void) {
    lode_speed_config_t config = sound();
    config.dip_gain = 2.0f;
    const lode_speed_tuning_t tuning = tuned(&config);
    for (int n = 0; n < 2; n++) {
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, 80.0f, -20.0f, 0.0f, 100.0f);
        // (80 - 50) 0.8 - 20 = 4 from the PI, and 0.8 times 2 times 6 from the dip
        const float commanded = n == 0 ? 5.0f : 15.0f;
        CHECK_NEAR(1.0e-4, n == 0 ? 5.0 : 13.6,
                   torque_control(&speed, &tuning, commanded, 150.0f, 0.0f));
        TEST_ASSERT_EQUAL_FLOAT(n == 0 ? 50.0f : 80.0f, speed.reference_rad_s);
    }
}

/// (K13): with the load known, either end is overrun by less than a sixth of the 6 rad/s of (K15); the same torque where it is met.
static void test_an_end_of_the_range_is_not_overrun(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        const float wanted = 5.0f * (float)sign;
        const float load = 1.5f;
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, 50.0f, load, load, (float)TORQUE_MAX);
        double omega = 50.0;
        double before = (double)wanted;
        for (int n = 0; n < 10000; n++) {
            const float torque =
                torque_control(&speed, &tuning, wanted, (float)(3.0 * omega), load);
            CHECK_NEAR(0.1, before, torque);
            before = (double)torque;
            omega += 2.0e-4 * ((double)torque - (double)load) / 0.0174;
            CHECK_AT_LEAST(19.0, omega);
            CHECK_AT_MOST(81.0, omega);
        }
        CHECK_NEAR(0.01, sign > 0 ? 80.0 : 20.0, omega);
    }
}

static void test_reset_is_bumpless(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    random_t random = random_seed(1);
    for (int n = 0; n < 2000; n++) {
        const float omega = random_float(&random, -150.0, 150.0);
        const float torque = random_float(&random, -7.0, 7.0);
        const float load = random_float(&random, -7.0, 7.0);
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, omega, torque, load, (float)TORQUE_MAX);
        // One rounding of 3 omega times a third, times kp.
        CHECK_NEAR(5.0e-5, torque, lode_speed_step(&speed, &tuning, omega, 3.0f * omega, load));
    }
}

static void test_torque_is_limited_by_the_current(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 0.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
    CHECK_CLOSE(1.0e-6, -TORQUE_MAX, lode_speed_step(&speed, &tuning, 0.0f, 3000.0f, 0.0f));
    lode_speed_reset(&speed, &tuning, 0.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
    CHECK_CLOSE(1.0e-6, TORQUE_MAX, lode_speed_step(&speed, &tuning, 0.0f, -3000.0f, 0.0f));
}

/// The shaft of paper 1: J domega/dt = T - load - B omega; returns the mechanical speed.
static double shaft(double omega, double torque, double load) {
    return omega + 2.0e-4 * (torque - load - 7.5e-4 * omega) / 0.0174;
}

static void test_closed_loop_holds_against_a_load(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, 0.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
        double omega = 0.0;
        for (int n = 0; n < 20000; n++) {
            const double load = n < 10000 ? 0.0 : 4.0 * sign;
            const float torque =
                lode_speed_step(&speed, &tuning, 100.0f * (float)sign, (float)(3.0 * omega), 0.0f);
            omega = shaft(omega, (double)torque, load);
        }
        CHECK_NEAR(0.01, 100.0 * sign, omega); // 2 s are 15 time constants of kp/ki
    }
}

static void test_no_windup_in_a_second_of_saturation(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 100.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
    double omega = 100.0;
    for (int n = 0; n < 5000; n++) { // 10 Nm of load beat the 7.67 Nm that the current allows
        const float torque = lode_speed_step(&speed, &tuning, 100.0f, (float)(3.0 * omega), 0.0f);
        omega = shaft(omega, (double)torque, 10.0);
        CHECK_AT_MOST(TORQUE_MAX * 1.000001, torque);
    }
    CHECK_AT_MOST(-20.0, omega);
    double peak = omega;
    for (int n = 0; n < 10000; n++) {
        const float torque = lode_speed_step(&speed, &tuning, 100.0f, (float)(3.0 * omega), 0.0f);
        omega = shaft(omega, (double)torque, 0.0);
        peak = fmax(peak, omega);
    }
    // The linear loop overshoots a step by 12 % of kp/ki's tail; windup would add some 40 rad/s.
    CHECK_AT_MOST(112.0, peak);
    CHECK_NEAR(0.5, 100.0, omega);
}

static void test_any_input_gives_a_torque_in_range(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 0.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
    random_t random = random_seed(2);
    for (int n = 0; n < CHECK_TRIES(300000); n++) {
        const float torque = lode_speed_step(&speed, &tuning, random_any(&random),
                                             random_any(&random), random_any(&random));
        CHECK_AT_MOST(TORQUE_MAX * 1.000001, fabs((double)torque));
    }
}

static void test_a_target_that_is_no_number_is_ignored(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t tuning = tuned(&config);
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, 40.0f, 1.0f, 0.0f, (float)TORQUE_MAX);
        const float torque = lode_speed_step(&speed, &tuning, check_not_finite[i], 120.0f, 0.0f);
        CHECK_NEAR(1.0e-5, 1.0, torque);
        TEST_ASSERT_EQUAL_FLOAT(40.0f, speed.reference_rad_s);
    }
}

static lode_status_t try_config(const lode_speed_config_t *config) {
    const lode_motor_t motor = paper_motor();
    lode_speed_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_speed_tuning_t before = tuning;
    const lode_status_t status = lode_speed_tune(&tuning, config, &motor, &pll, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_speed_config_t config = sound();
    field_set(&config, offset, value);
    return try_config(&config);
}

static void test_every_field_at_its_limits(void) {
    static const field_t fields[] = {
        {FIELD(lode_speed_config_t, ki_Nm), .lo = 0.0f, .hi = 1.0e6f,
         .error = LODE_ERROR_SPEED_GAINS},
    };
    field_check_all(fields, COUNT_OF(fields), try_one);
    const size_t kp = offsetof(lode_speed_config_t, kp_Nms);
    const float none[] = {0.0f, -0.1f, 2.0e6f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(none); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_GAINS, try_one(kp, none[i]));
    }
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(kp, 1.01e-9f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_GAINS, try_one(kp, 0.99e-9f));
    // kp/J is the crossover: not beyond the 100 rad/s of the PLL.
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(kp, 0.99f * 100.0f * 0.0174f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_BANDWIDTH, try_one(kp, 1.01f * 100.0f * 0.0174f));
    const size_t ramp = offsetof(lode_speed_config_t, ramp_rad_s2);
    const float slopes[] = {0.0f, -1.0f, 1.0e9f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(slopes); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_RAMP, try_one(ramp, slopes[i]));
    }
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(ramp, 0.5f));
}

static void test_range_of_the_gain_in_a_dip(void) {
    const size_t dip_gain = offsetof(lode_speed_config_t, dip_gain);
    const float sizes[] = {LODE_NONE, 0.0f, 2.0f, 10.0f};
    const float wrong[] = {10.00001f, -1.00001f, -0.1f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(sizes); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(dip_gain, sizes[i]));
    }
    for (int i = 0; i < COUNT_OF(wrong); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_GAINS, try_one(dip_gain, wrong[i]));
    }
}

/// The bound is no way around the check: what has changed by itself still shows.
static void test_a_bound_leaves_what_has_changed(void) {
    const lode_speed_config_t config = sound();
    const lode_speed_tuning_t t = tuned(&config);
    lode_speed_t whole;
    lode_speed_reset(&whole, &t, 50.0f, 0.2f, 0.0f, 1.0f);
    lode_speed_t other = whole;
    lode_speed_bound(&whole, 20.0f);
    TEST_ASSERT_EQUAL_FLOAT(20.0f, whole.reference_rad_s);
    TEST_ASSERT_TRUE(lode_speed_is_whole(&whole));
    other.reference_rad_s = -50.0f;
    lode_speed_bound(&other, 20.0f);
    TEST_ASSERT_FALSE(lode_speed_is_whole(&other));
}

static void test_range_of_the_swing(void) {
    const size_t swing_Nm = offsetof(lode_speed_config_t, swing_Nm);
    const float sizes[] = {LODE_NONE, 1.0e-6f, 0.5f, 1.0e6f};
    const float wrong[] = {1.0001e6f, -1.00001f, -0.1f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(sizes); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(swing_Nm, sizes[i]));
    }
    for (int i = 0; i < COUNT_OF(wrong); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_GAINS, try_one(swing_Nm, wrong[i]));
    }
    lode_speed_config_t config = sound();
    TEST_ASSERT_EQUAL_FLOAT(FLT_MAX, tuned(&config).swing_Nm);
    config.swing_Nm = 0.5f;
    TEST_ASSERT_EQUAL_FLOAT(0.5f, tuned(&config).swing_Nm);
}

static void test_shares_of_the_feed_forwards(void) {
    const size_t fields[] = {offsetof(lode_speed_config_t, load_feed_forward),
                             offsetof(lode_speed_config_t, inertia_feed_forward)};
    const float shares[] = {LODE_NONE, 0.0f, 0.3f, 1.0f};
    const float wrong[] = {1.00001f, -1.00001f, -0.99999f, -0.1f, NAN, INFINITY, -INFINITY};
    for (int f = 0; f < COUNT_OF(fields); f++) {
        for (int i = 0; i < COUNT_OF(shares); i++) {
            TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(fields[f], shares[i]));
        }
        for (int i = 0; i < COUNT_OF(wrong); i++) {
            TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_FEED_FORWARD, try_one(fields[f], wrong[i]));
        }
    }
}

static void test_gains_rise_with_the_pll(void) {
    lode_speed_config_t config = sound();
    config.gain_rise = 1.5f;
    const lode_speed_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        float before = 0.0f;
        for (int omega = 0; omega <= 900; omega += 30) {
            lode_speed_t speed;
            const float electrical = (float)(sign * omega);
            lode_speed_reset(&speed, &tuning, electrical / 3.0f + 1.0f, 0.0f, 0.0f,
                             (float)TORQUE_MAX);
            // An error of 1 rad/s shows the gain: torque and integral alike.
            const float target = electrical / 3.0f + 1.0f;
            const float torque = lode_speed_step(&speed, &tuning, target, electrical, 0.0f);
            const double gain = (double)torque / 0.8;
            CHECK_AT_LEAST((double)before - 1.0e-4, gain);
            CHECK_NEAR(1.0e-6, gain * 6.0 * 2.0e-4, speed.pi.integral);
            if (omega <= 150) { // where the PLL has its low bandwidth
                CHECK_NEAR(1.0e-4, 1.0, gain);
            }
            before = (float)gain;
        }
        CHECK_NEAR(1.0e-4, 1.5, before); // well above
    }
}

static void test_range_of_the_gain_rise(void) {
    const size_t rise = offsetof(lode_speed_config_t, gain_rise);
    const float bad[] = {0.999f, 10.01f, 0.0f, -1.0f, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_GAINS, try_one(rise, bad[i]));
    }
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(rise, 1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(rise, 1.5f));
    // kp/J is 46 rad/s: five times that is above the PLL's 150, where the gains are in full.
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_BANDWIDTH, try_one(rise, 5.0f));
}

static void test_the_ramp_brings_the_torque_of_the_inertia(void) {
    lode_speed_config_t config = sound();
    config.inertia_feed_forward = 0.6f;
    const lode_speed_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, 0.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
        for (int n = 1; n <= 100; n++) {
            // A rotor that follows exactly: 0.6 J ramp, 2.088 Nm, and nothing of the PI. The steps
            // of the reference carry float rounding, kp = 0.8 and 1/Ts times J multiply it.
            const double omega = sign * 200.0 * 2.0e-4 * n;
            const float torque =
                lode_speed_step(&speed, &tuning, 50.0f * (float)sign, (float)(3.0 * omega), 0.0f);
            CHECK_NEAR(2.0e-3, sign * 0.6 * 0.0174 * 200.0, torque);
        }
        // At its end the torque goes too.
        lode_speed_reset(&speed, &tuning, 50.0f * (float)sign, 0.0f, 0.0f, (float)TORQUE_MAX);
        CHECK_NEAR(
            1.0e-4, 0.0,
            lode_speed_step(&speed, &tuning, 50.0f * (float)sign, 150.0f * (float)sign, 0.0f));
    }
}

/// (K7): the ramp's torque is given as far as the rotor is not ahead of it: less by what the controller asks against it,
/// never the other way.
static void test_a_rotor_ahead_of_its_ramp_gets_less_of_its_torque(void) {
    const float ramps[] = {200.0f, 20.0f};
    const float ahead[] = {-1.0f, 0.0f, 0.2f, 1.0f, 10.0f}; // mechanical rad/s
    for (int n = 0; n < COUNT_OF(ramps) * COUNT_OF(ahead) * 2; n++) {
        lode_speed_config_t config = sound();
        config.ramp_rad_s2 = ramps[n / 2 / COUNT_OF(ahead)];
        config.inertia_feed_forward = 1.0f;
        const lode_speed_tuning_t tuning = tuned(&config);
        const double way = n % 2 == 0 ? 1.0 : -1.0;
        const double before = (double)ahead[n / 2 % COUNT_OF(ahead)] * way;
        lode_speed_t speed;
        lode_speed_reset(&speed, &tuning, 30.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
        const double reference = 30.0 + way * (double)tuning.ramp_step;
        const float omega = (float)(3.0 * (reference + before));
        const double push = 0.0174 * (double)config.ramp_rad_s2;
        const double given = fmax(0.0, fmin(push, push - 0.8 * way * before));
        const double torque = -0.8 * before + way * given;
        CHECK_NEAR(2.0e-3, fmax(-TORQUE_MAX, fmin(TORQUE_MAX, torque)),
                   lode_speed_step(&speed, &tuning, (float)(30.0 + 20.0 * way), omega, 0.0f));
    }
}

/// The gains' factor rises from one span of the speed to two.
static void test_the_gain_rises_over_one_span(void) {
    const lode_speed_tuning_t tuning = {.inv_span = 0.01f, .rise = 0.5f};
    const double at[][2] = {{0.0, 1.0},    {100.0, 1.0}, {125.0, 1.125},
                            {150.0, 1.25}, {200.0, 1.5}, {300.0, 1.5}};
    for (int n = 0; n < COUNT_OF(at); n++) {
        CHECK_NEAR(1.0e-6, at[n][1], lode_speed_gain(&tuning, (float)at[n][0]));
        CHECK_NEAR(1.0e-6, at[n][1], lode_speed_gain(&tuning, (float)-at[n][0]));
    }
}

static void test_a_bandwidth_that_is_no_number_is_refused(void) {
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        TEST_ASSERT_EQUAL_INT(
            LODE_ERROR_SPEED_BANDWIDTH,
            try_one(offsetof(lode_speed_config_t, bandwidth_rad_s), check_not_finite[i]));
    }
    const float bounds[] = {1.0e-3f, 1.0e5f, 0.9e-3f, 1.1e5f};
    for (int i = 0; i < COUNT_OF(bounds); i++) {
        TEST_ASSERT_EQUAL_INT(i < 2 ? LODE_OK : LODE_ERROR_SPEED_BANDWIDTH,
                              try_one(offsetof(lode_speed_config_t, bandwidth_rad_s), bounds[i]));
    }
}

static void test_bounds_that_are_just_met_are_accepted(void) {
    const size_t ramp = offsetof(lode_speed_config_t, ramp_rad_s2);
    const float ramps[] = {1.0e-3f, 1.0e7f, 0.9e-3f, 1.1e7f};
    for (int i = 0; i < COUNT_OF(ramps); i++) {
        TEST_ASSERT_EQUAL_INT(i < 2 ? LODE_OK : LODE_ERROR_SPEED_RAMP, try_one(ramp, ramps[i]));
    }
    lode_speed_config_t config = sound();
    const lode_motor_t motor = paper_motor();
    lode_pll_config_t slow = pll;
    slow.sigma_low_rad_s = slow.sigma_rad_s = 100.0f;
    config.kp_Nms = slow.sigma_rad_s * motor.J_kgm2;
    lode_speed_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_speed_tune(&tuning, &config, &motor, &slow, PAPER_TS_s));
}

static void test_no_feed_forward(void) {
    lode_speed_config_t config = sound();
    config.load_feed_forward = LODE_NONE;
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 10.0f, 2.0f, 5.0f, (float)TORQUE_MAX);
    CHECK_NEAR(1.0e-5, 2.0, lode_speed_step(&speed, &tuning, 10.0f, 30.0f, -7.0f));
}

/// A rated load takes all of 25 rad/s with this bandwidth, and of another speed with as much less (K15).
static const double stopped_rad_s =
    3.0 * 2.0 / 2.718281828 * (2.0 / 3.0) * TORQUE_MAX / 25.0 / 0.0174;

#define FAST 10000.0 // no load stops a rotor that fast

/// What a drive with paper 1's motor differs in.
typedef struct {
    double J, Lq;     // factors; 0: 1
    double omega_min; // 0: FAST
    double delay_s, damping_rad_s;
    bool injects, qpll;
    lode_speed_config_t config;
} with_t;

static double or_else(double given, double otherwise) {
    return given > 0.0 ? given : otherwise;
}

static lode_speed_config_t designed(with_t with) {
    lode_motor_t motor = paper_motor();
    motor.J_kgm2 *= (float)or_else(with.J, 1.0);
    motor.Lq_H *= (float)or_else(with.Lq, 1.0);
    lode_pll_config_t loop = pll;
    loop.kind = with.qpll ? LODE_PLL_QPLL : LODE_PLL_LESO;
    const lode_speed_loop_t late = {.delay_s = (float)with.delay_s,
                                    .damping_rad_s = (float)with.damping_rad_s};
    lode_speed_design(&with.config, &inverter, &motor, &loop, &late,
                      (float)or_else(with.omega_min, FAST), with.injects);
    return with.config;
}

/// (K16): of a bandwidth of 1 rad/s, what the loop through an error of Lq takes of its margin; s.
static double turned_s(with_t with, double sigma) {
    const double turned_rad_Nm = 0.2 * or_else(with.Lq, 1.0) * 9.8e-3 / 0.142 / 0.639;
    return 1.37 * sigma * turned_rad_Nm * or_else(with.J, 1.0) * 0.0174 / 3.0;
}

/// (K22): the same of the loop with a rotor four times lighter.
static double light_s(with_t with, double sigma) {
    return (0.75 + 4.9 * sigma * with.delay_s) / (sigma + with.damping_rad_s);
}

/// (K22), (K44): with `fed` of the load fed forward.
static double most_rad_s(with_t with, double sigma, double fed) {
    const double light = light_s(with, sigma) * (1.0 + 2.7 * sigma * with.delay_s * fed);
    const double left = 0.9 - fed * sigma / 3.0 * turned_s(with, sigma);
    return fmin(1.0 / (1.41 * light), left / (light + turned_s(with, sigma)));
}

static void test_design_fills_what_is_open(void) {
    // As documented: kp = bandwidth J, ki = kp bandwidth/4.
    const lode_speed_config_t config = designed((with_t){.omega_min = 60.0});
    const double bandwidth = 2.4 * stopped_rad_s * 25.0 / 60.0; // (K44)
    CHECK_CLOSE(1.0e-5, bandwidth, config.bandwidth_rad_s);
    CHECK_CLOSE(1.0e-5, bandwidth * 0.0174, config.kp_Nms);
    CHECK_CLOSE(1.0e-5, bandwidth * bandwidth / 4.0 * 0.0174, config.ki_Nm);
    CHECK_CLOSE(1.0e-5, most_rad_s((with_t){.J = 1.0}, 150.0, 0.0) / bandwidth, config.gain_rise);
    CHECK_CLOSE(1.0e-6, 0.5 * TORQUE_MAX / 0.0174, config.ramp_rad_s2);
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, config.load_feed_forward);
    CHECK_CLOSE(1.0e-6, 1.0, config.inertia_feed_forward);
    CHECK_CLOSE(1.0e-6, 60.0, config.omega_min_rad_s);
    CHECK_CLOSE(1.0e-6, 0.03 * TORQUE_MAX / 1.5, config.swing_Nm);
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, designed((with_t){.injects = true}).swing_Nm);
    const lode_speed_config_t all = sound();
    const lode_speed_config_t kept = designed((with_t){.config = all, .omega_min = 30.0});
    TEST_ASSERT_EQUAL_MEMORY(&all, &kept, sizeof all);
    const lode_speed_config_t by_gain = designed((with_t){.config = {.kp_Nms = 0.5f}});
    CHECK_CLOSE(1.0e-6, 0.5 / 0.0174, by_gain.bandwidth_rad_s);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, by_gain.kp_Nms);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, by_gain.gain_rise);
    // The gains rise as far as a bandwidth that is given leaves it.
    const lode_speed_config_t by_bandwidth =
        designed((with_t){.config = {.bandwidth_rad_s = 27.0f}});
    CHECK_CLOSE(1.0e-5, 27.0 * 0.0174, by_bandwidth.kp_Nms);
    CHECK_CLOSE(1.0e-5, most_rad_s((with_t){.J = 1.0}, 150.0, 0.0) / 27.0, by_bandwidth.gain_rise);
}

static void test_design_follows_the_inertia(void) {
    // Light: the loop is slow for the rotor, and the ramp waits for it.
    const lode_speed_config_t light = designed((with_t){.J = 0.1, .omega_min = 25.0});
    CHECK_CLOSE(1.0e-6, 25.0, light.bandwidth_rad_s);
    CHECK_CLOSE(1.0e-6, 1.5, light.gain_rise); // as sigma rises
    CHECK_CLOSE(1.0e-5, 0.114 * 25.0 * 0.1 * RUN_UP_s * TORQUE_MAX / 0.00174, light.ramp_rad_s2);
    // Heavy: the bandwidth does not use all of the PLL's, and noise is not fed forward for a load.
    const lode_speed_config_t heavy = designed((with_t){.J = 3.0, .Lq = 0.1, .injects = true});
    CHECK_CLOSE(1.0e-5, 13.0 / (3.0 * RUN_UP_s), heavy.bandwidth_rad_s);
    CHECK_CLOSE(1.0e-6, 1.0, heavy.gain_rise);
    CHECK_CLOSE(1.0e-5, 0.5 * TORQUE_MAX / (3.0 * 0.0174), heavy.ramp_rad_s2);
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, heavy.load_feed_forward);
    const double noisy = 78.0 / 100.0 / RUN_UP_s;
    TEST_ASSERT_EQUAL_FLOAT(
        0.5f, designed((with_t){.J = 0.99 * noisy, .Lq = 0.1, .injects = true}).load_feed_forward);
    TEST_ASSERT_EQUAL_FLOAT(
        LODE_NONE,
        designed((with_t){.J = 1.01 * noisy, .Lq = 0.1, .injects = true}).load_feed_forward);
}

static void test_an_error_of_Lq_bounds_the_gains(void) {
    const double factors[] = {0.3, 1.0, 1.2, 2.0};
    for (int n = 0; n < COUNT_OF(factors); n++) {
        const with_t with = {.Lq = factors[n]};
        const lode_speed_config_t config = designed(with);
        const double low = fmin(25.0, most_rad_s(with, 100.0, 0.0));
        const double high = fmin(13.0 / RUN_UP_s, most_rad_s(with, 150.0, 0.0));
        CHECK_CLOSE(1.0e-5, low, config.bandwidth_rad_s);
        CHECK_CLOSE(1.0e-5, fmax(fmin(high / low, 1.5), 1.0), config.gain_rise);
    }
}

/// (K40), (K44): 3/sigma of what is fed forward acts like kp, and delays the light rotor's loop.
static void test_a_load_fed_forward_with_injection_keeps_the_gain(void) {
    const double factors[] = {0.1, 0.3, 0.5, 0.6, 0.7, 2.0};
    int bounded = 0;
    for (int n = 0; n < 2 * COUNT_OF(factors); n++) {
        const with_t with = {.Lq = factors[n / 2],
                             .delay_s = n % 2 == 0 ? 0.0 : 3.0e-3,
                             .injects = true,
                             .omega_min = 25.0};
        const lode_speed_config_t config = designed(with);
        const double fed = (double)config.load_feed_forward;
        const double bandwidth = (double)config.bandwidth_rad_s;
        CHECK_CLOSE(1.0e-5, fmin(25.0, most_rad_s(with, 100.0, 0.0)), bandwidth);
        const double low = most_rad_s(with, 100.0, fed);
        const double high = most_rad_s(with, 150.0, fed / 2.25); // (K46)
        if (fed > 0.0) {
            TEST_ASSERT_TRUE(fed <= 0.5 && fed >= 0.01);
            TEST_ASSERT_TRUE(bandwidth <= 1.0001 * low && bandwidth <= 1.0001 * high);
            CHECK_CLOSE(1.0e-4, fmin(fmin(high, 13.0 / RUN_UP_s) / bandwidth, 1.5),
                        config.gain_rise);
            const bool bound = fed < 0.499;
            bounded += bound ? 1 : 0;
            TEST_ASSERT_TRUE(!bound || fmin(low, high) < 1.0001 * bandwidth);
        } else {
            TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, config.load_feed_forward);
            TEST_ASSERT_TRUE(bandwidth > fmin(most_rad_s(with, 150.0, 0.01 / 2.25),
                                              most_rad_s(with, 100.0, 0.01)));
        }
    }
    TEST_ASSERT_TRUE(bounded >= 4);
}

/// A load that stops the rotor within 10 ms is fed forward, as far as the margins allow it: no bandwidth holds it.
static void test_a_sudden_load_is_fed_forward(void) {
    with_t with = {.J = 0.4, .Lq = 0.1, .delay_s = 1.0e-3};
    with.omega_min = 1.01 * stopped_rad_s / 0.4 * 25.0 / 74.0;
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, designed(with).load_feed_forward);
    with.omega_min = 0.99 * stopped_rad_s / 0.4 * 25.0 / 74.0;
    TEST_ASSERT_EQUAL_FLOAT(0.5f, designed(with).load_feed_forward);
    CHECK_CLOSE(1.0e-6, 25.0, designed(with).bandwidth_rad_s);
    with.qpll = true; // which estimates none
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, designed(with).load_feed_forward);
    with.qpll = false;
    with.Lq = 4.0; // no margin is left
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, designed(with).load_feed_forward);
}

/// (K47): three times the gain, or sigma at low speed; none where a wave holds the rotor.
static void test_design_of_the_gain_in_a_dip(void) {
    const float J = paper_motor().J_kgm2;
    const struct {
        double bandwidth, gain;
    } cases[] = {{20.0, 2.0}, {33.0, 2.0}, {50.0, 1.0}, {80.0, 0.25}, {100.0, LODE_NONE}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        const with_t with = {.config = {.kp_Nms = (float)cases[n].bandwidth * J}};
        CHECK_NEAR(1.0e-5, cases[n].gain, designed(with).dip_gain);
    }
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, designed((with_t){.injects = true}).dip_gain);
    TEST_ASSERT_EQUAL_FLOAT(3.0f, designed((with_t){.config = {.dip_gain = 3.0f}}).dip_gain);
    lode_speed_config_t small = sound();
    TEST_ASSERT_EQUAL_FLOAT(0.0f, tuned(&small).dip_gain);
    small.dip_gain = 0.5f;
    TEST_ASSERT_EQUAL_FLOAT(0.5f, tuned(&small).dip_gain);
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE,
                            designed((with_t){.config = {.dip_gain = LODE_NONE}}).dip_gain);
}

/// A share that is given leaves the gains less of a rise.
static void test_a_load_fed_forward_leaves_less_of_a_rise(void) {
    const with_t with = {.Lq = 0.5, .delay_s = 2.0e-3, .config = {.load_feed_forward = 0.4f}};
    const double most = most_rad_s(with, 150.0, 0.4 / 2.25);
    CHECK_CLOSE(1.0e-5, fmin(most, 13.0 / RUN_UP_s) / 25.0, designed(with).gain_rise);
    TEST_ASSERT_TRUE(most < 13.0 / RUN_UP_s && most > 25.0);
}

static void test_a_loop_that_is_late_has_less_gain(void) {
    const with_t late = {.Lq = 0.1, .delay_s = 7.0e-3};
    const double held = 1.0 / (1.41 * light_s(late, 100.0));
    CHECK_CLOSE(1.0e-5, held, designed(late).bandwidth_rad_s);
    CHECK_CLOSE(1.0e-5, fmax(1.0 / (1.41 * light_s(late, 150.0)) / held, 1.0),
                designed(late).gain_rise);
    // What the EMF damps may have more, up to a quarter of sigma.
    const with_t damped = {.Lq = 0.1, .delay_s = 7.0e-3, .damping_rad_s = 40.0};
    CHECK_CLOSE(1.0e-5, 1.0 / (1.41 * light_s(damped, 100.0)), designed(damped).bandwidth_rad_s);
    const with_t more = {.Lq = 0.1, .delay_s = 7.0e-3, .damping_rad_s = 80.0};
    CHECK_CLOSE(1.0e-5, 25.0, designed(more).bandwidth_rad_s);
}

/// (K44), (K37).
static void test_a_load_that_would_stop_the_rotor_asks_for_more_gain(void) {
    // So much that half of the speed is left, as far as the margins allow it, and half of sigma.
    const with_t prompt_one = {.Lq = 0.3, .omega_min = 55.0};
    CHECK_CLOSE(1.0e-5, 2.4 * stopped_rad_s * 25.0 / 55.0, designed(prompt_one).bandwidth_rad_s);
    const with_t by_light = {.Lq = 0.1, .delay_s = 3.0e-3, .omega_min = 36.0};
    CHECK_CLOSE(1.0e-5, most_rad_s(by_light, 100.0, 0.0), designed(by_light).bandwidth_rad_s);
    const with_t by_Lq = {.Lq = 1.1, .omega_min = 36.0}; // with the sigma at speed
    CHECK_CLOSE(1.0e-5, most_rad_s(by_Lq, 150.0, 0.0), designed(by_Lq).bandwidth_rad_s);
    const with_t half = {.J = 0.4, .Lq = 0.3, .damping_rad_s = 500.0, .omega_min = 25.0};
    CHECK_CLOSE(1.0e-5, 50.0, designed(half).bandwidth_rad_s);
    // Where they allow less, a tenth of the speed, with a margin for a rotor three times lighter.
    const with_t late = {.Lq = 0.3, .delay_s = 7.0e-3, .omega_min = 25.0};
    CHECK_CLOSE(1.0e-5, 100.0 / (1.41 * (0.38 + 3.4 * 100.0 * 7.0e-3)),
                designed(late).bandwidth_rad_s);
    const with_t damped = {.Lq = 0.3, .delay_s = 7.0e-3, .damping_rad_s = 10.0, .omega_min = 25.0};
    CHECK_CLOSE(1.0e-5, 110.0 / (1.41 * (0.38 + 3.4 * 100.0 * 7.0e-3)),
                designed(damped).bandwidth_rad_s);
    const with_t slower = {.Lq = 0.3, .delay_s = 7.0e-3, .omega_min = 40.0};
    CHECK_CLOSE(1.0e-5, 1.35 * stopped_rad_s * 25.0 / 40.0, designed(slower).bandwidth_rad_s);
    const double held = most_rad_s(late, 100.0, 0.0);
    const with_t fast = {.Lq = 0.3, .delay_s = 7.0e-3, .omega_min = 60.0};
    CHECK_CLOSE(1.0e-5, held, designed(fast).bandwidth_rad_s);
    CHECK_CLOSE(1.0e-6, 1.0, designed(late).gain_rise);
    // Not of a rotor that the load stops within 10 ms.
    with_t sudden = late;
    sudden.omega_min = 1.01 * stopped_rad_s * 25.0 / 74.0;
    TEST_ASSERT_TRUE(designed(sudden).bandwidth_rad_s > 1.2f * (float)held);
    sudden.omega_min = 0.99 * stopped_rad_s * 25.0 / 74.0;
    CHECK_CLOSE(1.0e-5, held, designed(sudden).bandwidth_rad_s);
    // Nor behind a QPLL, which is later by the torque that it does not know, nor with injection.
    with_t other = late;
    other.qpll = true;
    CHECK_CLOSE(1.0e-5, held, designed(other).bandwidth_rad_s);
    other.qpll = false;
    other.injects = true;
    CHECK_CLOSE(1.0e-5, held, designed(other).bandwidth_rad_s);
    // But an error of Lq does not lower it so far that a rated load takes more than two thirds of the speed (K15).
    with_t firm = {.Lq = 4.0, .omega_min = 60.0, .qpll = true};
    const double firm_rad_s = 1.5 * stopped_rad_s * 25.0 / 60.0;
    TEST_ASSERT_TRUE(1.2 * most_rad_s(firm, 100.0, 0.0) < firm_rad_s && firm_rad_s < 25.0);
    CHECK_CLOSE(1.0e-5, firm_rad_s, designed(firm).bandwidth_rad_s);
    firm.injects = true;
    CHECK_CLOSE(1.0e-5, most_rad_s(firm, 100.0, 0.0), designed(firm).bandwidth_rad_s);
    firm.Lq = 400.0;
    TEST_ASSERT_TRUE(most_rad_s(firm, 100.0, 0.0) < 1.0);
    CHECK_CLOSE(1.0e-5, most_rad_s(firm, 100.0, 0.0), designed(firm).bandwidth_rad_s);
    firm.Lq = 4.0;
    firm.injects = false;
    firm.delay_s = 20.0e-3; // but what a lighter rotor leaves does
    CHECK_CLOSE(1.0e-5, 1.0 / (1.41 * light_s(firm, 100.0)), designed(firm).bandwidth_rad_s);
}

/// A rotor `light` times as light as the drive believes, whose torque turns the EMF's angle by `turned` (s^2) times the
/// acceleration that the drive believes in.
typedef struct {
    double light, turned;
    double bandwidth, fed; // of speed control
    double sigma, delay_s;
} swinging_t;

/// How its speed has changed over the second half of 80/sigma, after a push. PLL (P4), two poles of an observer, one of current
/// control and a dead time, which share the delay.
static double swing_of(swinging_t the) {
    enum { DEAD = 256 };
    const double dt = 0.3 * the.delay_s / (double)DEAD;
    const double sigma = the.sigma;
    const int steps = (int)(80.0 / sigma / dt);
    static double acting[DEAD];
    memset(acting, 0, sizeof acting);
    double omega = 1.0, theta = 0.0, one = 0.0, seen = 0.0, acc = 0.0, integral = 0.0;
    double angle = 0.0, speed = 0.0, load = 0.0;
    double early = 0.0;
    double late = 0.0;
    for (int n = 0; n < steps; n++) {
        const double error = seen - angle;
        angle += dt * (speed + 3.0 * sigma * error);
        speed += dt * (acc + load + 3.0 * sigma * sigma * error);
        load += dt * sigma * sigma * sigma * error;
        integral += dt * 0.25 * the.bandwidth * the.bandwidth * speed;
        acc += dt / (0.3 * the.delay_s) * (acting[n % DEAD] - acc);
        acting[n % DEAD] = -the.bandwidth * speed - integral - the.fed * load;
        omega += dt * the.light * acc;
        theta += dt * omega;
        one += dt / (0.2 * the.delay_s) * (theta + the.turned * acc - one);
        seen += dt / (0.2 * the.delay_s) * (one - seen);
        if (2 * n < steps) {
            early = fmax(early, 4 * n > steps ? fabs(omega) : 0.0);
        } else {
            late = fmax(late, 4 * n > 3 * steps ? fabs(omega) : 0.0);
        }
    }
    return late / early;
}

static bool swings(swinging_t the, double times) {
    the.bandwidth *= times;
    the.fed *= times;
    return swing_of(the) > 1.0;
}

static void test_a_rotor_four_times_lighter_is_held(void) {
    for (int k = 5; k <= 10; k++) {
        const with_t late = {.Lq = 0.1, .delay_s = 1.0e-3 * k};
        const double most = (double)designed(late).bandwidth_rad_s;
        const swinging_t light = {4.0, 0.0, most, 0.0, 100.0, late.delay_s};
        TEST_ASSERT_FALSE(swings(light, 1.2));
        TEST_ASSERT_TRUE(swings(light, 1.7));
        // What (K8) alone would give, half of every load fed forward.
        TEST_ASSERT_TRUE(swing_of((swinging_t){4.0, 0.0, 25.0, 0.5, 100.0, late.delay_s}) > 1.0);
    }
    // Where a load would stop the rotor it is held if it is three times lighter.
    const with_t held = {.Lq = 0.1, .delay_s = 7.0e-3, .omega_min = 25.0};
    const swinging_t three = {3.0, 0.0, (double)designed(held).bandwidth_rad_s, 0.0, 100.0, 7.0e-3};
    TEST_ASSERT_FALSE(swings(three, 1.2));
    TEST_ASSERT_TRUE(swings(three, 1.7));
}

/// (K44): and Lq is configured a fifth too large, with a share of the load fed forward or without.
static void test_a_light_rotor_is_held_with_a_wrong_Lq(void) {
    for (int k = 1; k <= 5; k++) {
        for (int n = 1; n <= 4; n++) {
            const with_t with = {.Lq = 0.5 * n, .delay_s = 1.0e-3 * k};
            const double kappa = 0.2 * with.Lq * 9.8e-3 / 0.142 / 0.639 * 0.0174 / 3.0; // s^2
            const swinging_t both = {4.0, -kappa, most_rad_s(with, 150.0, 0.0),
                                     0.0, 150.0,  with.delay_s};
            TEST_ASSERT_FALSE(swings(both, 1.0));
            TEST_ASSERT_TRUE(swings(both, 1.5));
            const double fed = 0.5 * 0.9 / (150.0 / 3.0 * turned_s(with, 150.0) + 0.5);
            const swinging_t feeds = {4.0, -kappa, most_rad_s(with, 150.0, fed),
                                      fed, 150.0,  with.delay_s};
            TEST_ASSERT_FALSE(swings(feeds, 0.95));
            TEST_ASSERT_TRUE(swings(feeds, 1.6));
        }
    }
}

// ---- Two slopes and a jerk (K33)-(K35) ------------------------------------------------------------

static void test_any_jerk_is_a_limit(void) {
    lode_speed_config_t config = sound();
    config.ramp_rad_s2 = 5.0f;
    config.jerk_rad_s3 = 0.5f;
    CHECK_CLOSE(1.0e-5, 0.5 * (double)PAPER_TS_s * (double)PAPER_TS_s, tuned(&config).jerk_step);
    config.jerk_rad_s3 = 0.0f;
    TEST_ASSERT_EQUAL_FLOAT(0.0f, tuned(&config).jerk_step);
}

/// A share of the jerk is left to rounding, as the code has it.
#define PLANNED 0.96875

/// Of steps that get smaller by `less` each.
static double stopping_way(double step, double less) {
    const double more = floor(step / less);
    return step > 0.0 ? (more + 1.0) * (step - 0.5 * more * less) : 0.0;
}

/// A call of a reference with two slopes and a jerk, and what is to hold of it.
typedef struct {
    lode_speed_t speed;
    lode_speed_tuning_t tuning;
    double sum;    ///< of the steps
    double moved;  ///< of their sizes, since the sum was last exact
    double last;   ///< step
    float target;  ///< since aim():
    double sign;   ///< of the way to it
    double excess; ///< by which it must be passed, as the step was too large for it
    bool passed;   ///< it was, and the way is back now
} shaped_t;

/// At `omega`, at rest.
static shaped_t shaped(float up, float down, float jerk, float omega) {
    lode_speed_config_t config = sound();
    config.ramp_rad_s2 = up;
    config.ramp_down_rad_s2 = down;
    config.jerk_rad_s3 = jerk;
    shaped_t s = {.tuning = tuned(&config), .sum = (double)omega, .target = omega, .sign = 1.0};
    lode_speed_reset(&s.speed, &s.tuning, omega, 0.0f, 0.0f, (float)TORQUE_MAX);
    return s;
}

/// Another target: how far it must be passed where the present step is too large for it.
static void aim(shaped_t *s, float target) {
    const double way = (double)target - s->sum;
    const double sign = way < 0.0 ? -1.0 : 1.0;
    const double jerk = (double)s->tuning.jerk_step;
    s->target = target;
    s->sign = sign;
    s->passed = false;
    const double least = stopping_way(sign * s->last - jerk, PLANNED * jerk);
    s->excess = fmax(0.0, least - sign * way);
}

/// The float's last bit at `x`.
static double bit_of(double x) {
    return fmax(fabs(x), 1.0e-30) * 1.2e-7;
}

static void shaped_call(shaped_t *s) {
    const double before = (double)s->speed.reference_rad_s;
    const double step = (double)lode_speed_ramp(&s->speed, &s->tuning, s->target);
    const double after = (double)s->speed.reference_rad_s;
    const double up = (double)s->tuning.ramp_step;
    const double down = (double)s->tuning.ramp_down_step;
    CHECK_AT_MOST((double)s->tuning.jerk_step * 1.000001 + bit_of(step), fabs(step - s->last));
    CHECK_AT_MOST((step * before < 0.0 ? down : up) * 1.000001, fabs(step));
    s->sum += step;
    s->moved += fabs(step);
    s->last = step;
    // Nothing of a step is lost, however small it is beside the reference.
    CHECK_NEAR(bit_of(fmax(fabs(after), s->moved)), s->sum, after);
    if (lode_in_range(s->speed.reference_rad_s, s->target, s->target)) {
        s->sum = after; // without the roundings of all steps
        s->moved = 0.0;
    }
    const double beyond = s->sign * (after - (double)s->target);
    CHECK_AT_MOST(s->excess + bit_of(after) * (s->excess > 0.0 ? 1.0 : 0.0), beyond);
    s->passed = s->passed || beyond > 0.0;
    if (s->passed) { // and not once more
        CHECK_AT_MOST(0.0, -beyond);
    }
}

static bool is_there(const shaped_t *s) {
    return lode_in_range(s->speed.reference_rad_s, s->target, s->target) &&
           lode_in_range(s->speed.step_rad_s, 0.0f, 0.0f);
}

/// Calls until it is at rest at its target.
static int calls_to_rest(shaped_t *s, int most) {
    int calls = 0;
    while (!is_there(s) && calls <= most) {
        shaped_call(s);
        calls++;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(most, calls);
    for (int n = 0; n < 5; n++) {
        shaped_call(s);
        TEST_ASSERT_TRUE(is_there(s));
    }
    return calls;
}

/// From any state to any target, at whatever speed, also where the target changes on the way.
static void test_a_shaped_reference_comes_to_rest_at_its_target(void) {
    random_t random = random_seed(7);
    for (int n = 0; n < CHECK_TRIES(1000); n++) {
        const float up = (float)pow(10.0, random_between(&random, 0.0, 4.0));
        const float down = up * (float)pow(10.0, random_between(&random, -1.0, 1.0));
        // A slope is reached in 1 to 3000 calls, or in less than one.
        const double calls = pow(10.0, random_between(&random, -0.5, 3.5));
        const float jerk = n % 10 == 0 ? 0.0f : (float)((double)up / (calls * 2.0e-4));
        const double far = (double)up * 2.0e-4 * pow(10.0, random_between(&random, -2.0, 3.5));
        const double base = pow(10.0, random_between(&random, -1.0, 3.5)); // large beside its steps
        shaped_t s = shaped(up, down, jerk, random_float(&random, -base, base));
        for (int k = 0; k < 4; k++) {
            const double from = (double)s.speed.reference_rad_s;
            const bool back = fabs(from) < far; // through zero
            aim(&s, (float)(back ? -from : from + random_between(&random, -far, far)));
            const int changes = (int)random_between(&random, 0.0, 300.0);
            for (int m = 0; m < changes; m++) {
                shaped_call(&s);
            }
        }
        aim(&s, (float)(s.sum + random_between(&random, -far, far)));
        const double slow = fmin((double)s.tuning.ramp_step, (double)s.tuning.ramp_down_step);
        const double to_slope =
            fmax(slow, fmax((double)up, (double)down) * 2.0e-4) / (double)s.tuning.jerk_step;
        const double way = fabs((double)s.target - s.sum) + s.excess;
        (void)calls_to_rest(&s, (int)(2.0 * way / slow + 8.0 * to_slope + 20.0));
    }
}

/// As long as a ramp with this slope and jerk takes, and what its end is planned with less.
static void test_a_jerk_takes_no_more_time_than_it_must(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        shaped_t s = shaped(200.0f, 50.0f, 2000.0f, 0.0f);
        aim(&s, 100.0f * (float)sign);
        // 100/200 + 200/2000 s of 0.2 ms, half of the second 1/0.96875 times as long.
        const int up = calls_to_rest(&s, 4000);
        CHECK_NEAR(3.0, 3000.0 + 250.0 / PLANNED - 250.0, up);
        aim(&s, 0.0f);
        const int down = calls_to_rest(&s, 20000); // 100/50 + 50/2000 s
        CHECK_NEAR(3.0, 10125.0 + 62.5 / PLANNED - 62.5, down);
    }
}

static void test_two_slopes_without_a_jerk(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        shaped_t s = shaped(200.0f, 100.0f, 0.0f, 10.0f * (float)sign);
        aim(&s, 20.0f * (float)sign);
        CHECK_NEAR(2.0, 250.0, calls_to_rest(&s, 300));
        aim(&s, -10.0f * (float)sign);
        CHECK_NEAR(2.0, 1000.0 + 250.0, calls_to_rest(&s, 1300));
    }
    // One slope and no jerk: the ramp that there is anyway.
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shaped(200.0f, 0.0f, 0.0f, 0.0f).tuning.jerk_step);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, shaped(200.0f, 200.0f, 0.0f, 0.0f).tuning.jerk_step);
    TEST_ASSERT_EQUAL_FLOAT(0.04f, shaped(200.0f, 0.0f, 9.0e3f, 0.0f).tuning.ramp_down_step);
}

/// From rest either way is up, and its slope the one up.
static void test_from_rest_either_way_is_up(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        shaped_t s = shaped(100.0f, 25.0f, 1.0e6f, 0.0f);
        const float step = lode_speed_ramp(&s.speed, &s.tuning, 50.0f * (float)sign);
        CHECK_CLOSE(1.0e-5, sign * (double)s.tuning.ramp_step, step);
    }
}

/// A steep way down does not go on past zero.
static void test_a_reversal_has_the_other_slope_from_zero_on(void) {
    shaped_t s = shaped(100.0f, 400.0f, 1000.0f, 100.0f);
    aim(&s, -100.0f);
    double most = 0.0;
    double through = 0.0;
    while (!is_there(&s)) {
        const float before = s.speed.reference_rad_s;
        shaped_call(&s);
        most = fmax(most, -s.last);
        through = before > 0.0f ? -s.last : through;
    }
    CHECK_CLOSE(0.2, 400.0 * 2.0e-4, most); // 100 rad/s are nearly enough for it
    CHECK_CLOSE(0.01, 100.0 * 2.0e-4, through);
}

static void test_the_inertia_is_given_its_torque_by_the_limited_slope(void) {
    lode_speed_config_t config = sound();
    config.inertia_feed_forward = 1.0f;
    config.jerk_rad_s3 = 2000.0f;
    const lode_speed_tuning_t tuning = tuned(&config);
    lode_speed_t speed;
    lode_speed_reset(&speed, &tuning, 50.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
    double reference = 50.0;
    for (int n = 1; n <= 500; n++) {
        reference += 2000.0 * 2.0e-4 * 2.0e-4 * n; // a rotor that follows
        const float torque =
            lode_speed_step(&speed, &tuning, 200.0f, (float)(3.0 * reference), 0.0f);
        CHECK_NEAR(1.0e-3, 0.0174 * 2000.0 * 2.0e-4 * n, torque); // up to 200 rad/s^2
    }
}

static void test_what_takes_the_reference_along_ends_its_ramp(void) {
    shaped_t s = shaped(200.0f, 50.0f, 2000.0f, 30.0f);
    aim(&s, 90.0f);
    for (int n = 0; n < 200; n++) {
        shaped_call(&s);
    }
    lode_speed_t other = s.speed;
    TEST_ASSERT_TRUE(other.step_rad_s > 0.0f && lode_abs(other.left_rad_s) > 0.0f);
    lode_speed_reset(&other, &s.tuning, 40.0f, 0.0f, 0.0f, (float)TORQUE_MAX);
    (void)lode_speed_ramp(&other, &s.tuning, 40.0f);
    TEST_ASSERT_EQUAL_FLOAT(40.0f, other.reference_rad_s);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, other.left_rad_s);
    other = s.speed;
    (void)torque_control(&other, &s.tuning, 1.0f, 150.0f, 0.0f); // at 50 rad/s
    TEST_ASSERT_EQUAL_FLOAT(50.0f, other.reference_rad_s);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, other.left_rad_s);
}

static void test_no_target_brings_a_shaped_reference_to_rest(void) {
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        shaped_t s = shaped(200.0f, 50.0f, 2000.0f, 30.0f);
        aim(&s, 90.0f);
        for (int n = 0; n < 200; n++) {
            shaped_call(&s);
        }
        for (int n = 0; n < 500; n++) {
            const float step = lode_speed_ramp(&s.speed, &s.tuning, check_not_finite[i]);
            CHECK_AT_MOST((double)s.tuning.jerk_step * 1.000001 + bit_of((double)step),
                          fabs((double)step - s.last));
            s.last = (double)step;
        }
        CHECK_NEAR(1.0e-5, 0.0, s.last);
        CHECK_NEAR(0.01, 33.2, s.speed.reference_rad_s);
    }
}

static void test_ranges_of_two_slopes_and_a_jerk(void) {
    const size_t down = offsetof(lode_speed_config_t, ramp_down_rad_s2);
    const size_t jerk = offsetof(lode_speed_config_t, jerk_rad_s3);
    // The steeper slope, 200 rad/s^2, in 65536 calls of 0.2 ms.
    const float least = 200.0f / (65536.0f * 2.0e-4f);
    const float good[][2] = {{0.0f, 0.0f}, {1.0e-3f, 1.001f * least}, {1.0e7f, 1.0e12f}};
    const float bad[][2] = {
        {0.9e-3f, 0.999f * least}, {1.1e7f, 1.1e12f},     {-1.0f, -1.0f}, {NAN, NAN},
        {INFINITY, INFINITY},      {-INFINITY, -INFINITY}};
    for (int n = 0; n < COUNT_OF(good); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(down, good[n][0]));
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(jerk, good[n][1]));
    }
    for (int n = 0; n < COUNT_OF(bad); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_RAMP, try_one(down, bad[n][0]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_RAMP, try_one(jerk, bad[n][1]));
    }
    lode_speed_config_t config = sound();
    config.ramp_down_rad_s2 = 400.0f; // is the steeper one now
    config.jerk_rad_s3 = 1.5f * least;
    const lode_motor_t motor = paper_motor();
    lode_speed_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_RAMP,
                          lode_speed_tune(&tuning, &config, &motor, &pll, PAPER_TS_s));
    config.jerk_rad_s3 = 2.01f * least;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_speed_tune(&tuning, &config, &motor, &pll, PAPER_TS_s));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_design_follows_the_inertia);
    RUN_TEST(test_an_error_of_Lq_bounds_the_gains);
    RUN_TEST(test_a_load_fed_forward_with_injection_keeps_the_gain);
    RUN_TEST(test_a_loop_that_is_late_has_less_gain);
    RUN_TEST(test_a_load_that_would_stop_the_rotor_asks_for_more_gain);
    RUN_TEST(test_any_jerk_is_a_limit);
    RUN_TEST(test_a_sudden_load_is_fed_forward);
    RUN_TEST(test_a_load_fed_forward_leaves_less_of_a_rise);
    RUN_TEST(test_a_rotor_four_times_lighter_is_held);
    RUN_TEST(test_a_light_rotor_is_held_with_a_wrong_Lq);
    RUN_TEST(test_reference_is_a_mechanical_ramp);
    RUN_TEST(test_torque_is_pi_and_feed_forward);
    RUN_TEST(test_less_of_a_load_is_fed_forward_at_speed);
    RUN_TEST(test_torque_is_followed_between_two_speeds);
    RUN_TEST(test_a_dip_does_not_exceed_the_commanded_torque);
    RUN_TEST(test_an_end_of_the_range_is_not_overrun);
    RUN_TEST(test_reset_is_bumpless);
    RUN_TEST(test_torque_is_limited_by_the_current);
    RUN_TEST(test_closed_loop_holds_against_a_load);
    RUN_TEST(test_no_windup_in_a_second_of_saturation);
    RUN_TEST(test_any_input_gives_a_torque_in_range);
    RUN_TEST(test_a_target_that_is_no_number_is_ignored);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_a_deep_dip_has_more_gain);
    RUN_TEST(test_a_deep_dip_leaves_the_integral_alone);
    RUN_TEST(test_range_of_the_gain_in_a_dip);
    RUN_TEST(test_a_swing_halves_the_gains);
    RUN_TEST(test_half_waves_of_two_swings_do_not_add);
    RUN_TEST(test_what_halved_gains_leave);
    RUN_TEST(test_a_bound_leaves_what_has_changed);
    RUN_TEST(test_range_of_the_swing);
    RUN_TEST(test_design_of_the_gain_in_a_dip);
    RUN_TEST(test_shares_of_the_feed_forwards);
    RUN_TEST(test_gains_rise_with_the_pll);
    RUN_TEST(test_range_of_the_gain_rise);
    RUN_TEST(test_the_ramp_brings_the_torque_of_the_inertia);
    RUN_TEST(test_a_rotor_ahead_of_its_ramp_gets_less_of_its_torque);
    RUN_TEST(test_the_gain_rises_over_one_span);
    RUN_TEST(test_a_bandwidth_that_is_no_number_is_refused);
    RUN_TEST(test_bounds_that_are_just_met_are_accepted);
    RUN_TEST(test_no_feed_forward);
    RUN_TEST(test_design_fills_what_is_open);
    RUN_TEST(test_a_shaped_reference_comes_to_rest_at_its_target);
    RUN_TEST(test_a_jerk_takes_no_more_time_than_it_must);
    RUN_TEST(test_two_slopes_without_a_jerk);
    RUN_TEST(test_from_rest_either_way_is_up);
    RUN_TEST(test_a_reversal_has_the_other_slope_from_zero_on);
    RUN_TEST(test_the_inertia_is_given_its_torque_by_the_limited_slope);
    RUN_TEST(test_what_takes_the_reference_along_ends_its_ramp);
    RUN_TEST(test_no_target_brings_a_shaped_reference_to_rest);
    RUN_TEST(test_ranges_of_two_slopes_and_a_jerk);
    return UNITY_END();
}
