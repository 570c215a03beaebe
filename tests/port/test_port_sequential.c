// Currents sampled one after the other around t_k, on a winding without resistance behind a switched bridge,
// computed exactly: what is left of the error once they are brought to t_k.
#include "sequential.h"
#include "support/check.h"

#define F_PWM 20000.0
#define T_s (1.0 / F_PWM)
#define V_BUS 24.0
#define WINDING_H 0.6e-3
#define GAIN_A (-1.0 / 128.0)
#define ZERO 2048.0
#define AMPLITUDE_A 4.0
#define EMF_V 6.0
#define THIRD_TURN (2.0 * CHECK_PI / 3.0)

static const double delays_s[3] = {-2.0e-6, 0.0, 2.0e-6};

void setUp(void) {}

void tearDown(void) {}

// Current and EMF in phase, as with id = 0.
static double current(double omega, double t, int x) {
    return AMPLITUDE_A * cos(omega * t - x * THIRD_TURN);
}

// Mean voltage of a phase over the period from `t` on: EMF and inductance.
static double mean_V(double omega, double t, int x) {
    return EMF_V * cos(omega * (t + 0.5 * T_s) - x * THIRD_TURN) +
           WINDING_H * (current(omega, t + T_s, x) - current(omega, t, x)) / T_s;
}

static lode_abc_t duties(double omega, double t) {
    return (lode_abc_t){(float)(0.5 + mean_V(omega, t, 0) / V_BUS),
                        (float)(0.5 + mean_V(omega, t, 1) / V_BUS),
                        (float)(0.5 + mean_V(omega, t, 2) / V_BUS)};
}

// In the zero vector only the EMF acts.
static double sampled(double omega, double t, int x) {
    const double delay = delays_s[x];
    return current(omega, t, x) -
           EMF_V * cos(omega * (t + 0.5 * delay) - x * THIRD_TURN) * delay / WINDING_H;
}

static double largest_error_A(double omega, double use_L_H, bool correct) {
    port_sequential_t self;
    port_sequential_config_t config = {.f_pwm_Hz = (float)F_PWM,
                                       .i_gain_A_count = (float)GAIN_A,
                                       .duty_max = 1.0f,
                                       .L_H = (float)use_L_H};
    for (int x = 0; x < 3; x++) {
        config.delay_s[x] = (float)delays_s[x];
    }
    port_sequential_init(&self, &config);
    double worst = 0.0;
    port_sequential_write(&self, duties(omega, -T_s), true);
    for (int k = 0; k < 2000; k++) {
        const double t = k * T_s;
        port_sequential_write(&self, duties(omega, t), true);
        uint16_t count[3];
        for (int x = 0; x < 3; x++) {
            count[x] = (uint16_t)floor(ZERO + sampled(omega, t, x) / GAIN_A + 0.5);
        }
        if (correct) {
            port_sequential_read(&self, (float)V_BUS, count);
        }
        for (int x = 0; x < 3 && k > 1; x++) {
            worst = fmax(worst, fabs((count[x] - ZERO) * GAIN_A - current(omega, t, x)));
        }
    }
    return worst;
}

static void test_error(void) {
    static const double speeds[] = {20.0, 300.0, -1500.0, 3000.0};
    for (int n = 0; n < COUNT_OF(speeds); n++) {
        const double raw = largest_error_A(speeds[n], WINDING_H, false);
        const double left = largest_error_A(speeds[n], WINDING_H, true);
        printf("  %5.0f rad/s: %.3f A as sampled, %.3f A at t_k\n", speeds[n], raw, left);
        CHECK_AT_LEAST(0.019, raw);
        CHECK_AT_MOST(0.013, left); // a count is 0.008 A
    }
    // With a wrong inductance the ripple is off by as much, no more.
    CHECK_AT_MOST(0.6 * largest_error_A(300.0, WINDING_H, false),
                  largest_error_A(300.0, 1.5 * WINDING_H, true));
    CHECK_AT_LEAST(0.015, largest_error_A(300.0, 0.0, true)); // none: the ripple stays
}

static port_sequential_t with(float duty_max) {
    port_sequential_t self;
    port_sequential_init(&self, &(port_sequential_config_t){.f_pwm_Hz = (float)F_PWM,
                                                            .i_gain_A_count = (float)GAIN_A,
                                                            .duty_max = duty_max,
                                                            .L_H = (float)WINDING_H,
                                                            .delay_s = {-2.0e-6f, 0.0f, 2.0e-6f}});
    return self;
}

static void test_without_gates_counts_stay(void) {
    port_sequential_t self = with(1.0f);
    uint16_t count[3] = {100u, 200u, 300u};
    port_sequential_write(&self, (lode_abc_t){0.9f, 0.1f, 0.5f}, false);
    port_sequential_write(&self, (lode_abc_t){0.9f, 0.1f, 0.5f}, false);
    port_sequential_read(&self, (float)V_BUS, count);
    TEST_ASSERT_EQUAL_UINT16(100u, count[0]);
    TEST_ASSERT_EQUAL_UINT16(200u, count[1]);
    TEST_ASSERT_EQUAL_UINT16(300u, count[2]);
    // On from t_k: what was sampled before it is still without ripple.
    port_sequential_write(&self, (lode_abc_t){0.9f, 0.1f, 0.9f}, true);
    port_sequential_read(&self, (float)V_BUS, count);
    TEST_ASSERT_EQUAL_UINT16(100u, count[0]);
    TEST_ASSERT_TRUE(count[2] != 300u);
}

// A shunt that showed nothing gives no slope.
static void test_phase_without_a_window_leaves_no_slope(void) {
    port_sequential_t seen = with(0.95f), unseen = with(0.85f);
    port_sequential_t *const both[] = {&seen, &unseen};
    uint16_t result[2];
    for (int n = 0; n < 2; n++) {
        const lode_abc_t duty = {0.9f, 0.9f, 0.9f}; // no voltage: no ripple
        uint16_t count[3] = {0u, 0u, 0u};
        port_sequential_write(both[n], duty, true);
        port_sequential_write(both[n], duty, true);
        port_sequential_read(both[n], (float)V_BUS, count);
        count[2] = 2000u;
        port_sequential_read(both[n], (float)V_BUS, count);
        result[n] = count[2];
    }
    TEST_ASSERT_EQUAL_UINT16((uint16_t)(2000.0 / (1.0 + 2.0e-6 * F_PWM) + 0.5), result[0]);
    TEST_ASSERT_EQUAL_UINT16(2000u, result[1]);
}

static void test_counts_stay_in_their_range(void) {
    port_sequential_t self = with(1.0f);
    const lode_abc_t duty = {1.0f, 0.0f, 1.0f};
    port_sequential_write(&self, duty, true);
    port_sequential_write(&self, duty, true);
    uint16_t count[3] = {65535u, 0u, 1u};
    port_sequential_read(&self, 1.0e3f, count);
    TEST_ASSERT_EQUAL_UINT16(65535u, count[0]); // up, from the top
    TEST_ASSERT_EQUAL_UINT16(0u, count[2]);     // down, from the foot
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_error);
    RUN_TEST(test_without_gates_counts_stay);
    RUN_TEST(test_phase_without_a_window_leaves_no_slope);
    RUN_TEST(test_counts_stay_in_their_range);
    return UNITY_END();
}
