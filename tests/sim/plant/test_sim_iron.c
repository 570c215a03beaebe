#include "plant/iron.h"

#include <math.h>
#include <string.h>

#include "plant/adc.h"
#include "plant/plant.h"
#include "unity.h"

void setUp(void) {}

void tearDown(void) {}

/// Uniform in low .. high.
static double uniform(plant_noise_t *noise, double low, double high) {
    return low + (high - low) * 0.5 * erfc(-plant_noise_next(noise) / sqrt(2.0));
}

/// Paper 1's motor with all that saturation can do.
static plant_config_t saturated(void) {
    plant_config_t c = plant_config_jiang2022();
    c.i_sat_A = 12.0;
    c.Lq_sat_H = 2.5e-3;
    c.id_sat_A = 5.0;
    c.Ld_sat_H = 2.3e-3;
    c.i_cross_A = 8.0;
    c.Ldq_H = 0.4e-3;
    return c;
}

static plant_iron_t iron_of(const plant_config_t *c) {
    plant_iron_t iron;
    TEST_ASSERT_NULL(plant_iron_check(c));
    plant_iron_init(&iron, c);
    return iron;
}

/// What the keys promise, each at the current at which it does.
static void test_inductances_are_what_the_keys_say(void) {
    const plant_config_t c = saturated();
    const plant_iron_t iron = iron_of(&c);
    const plant_iron_point_t none = plant_iron_at(&iron, 0.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, c.Ld_H, none.Ldd_H);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, c.Lq_H, none.Lqq_H);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.0, none.Ldq_H);
    TEST_ASSERT_TRUE(none.psi_d_Wb == 0.0 && none.psi_q_Wb == 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, c.Ld_sat_H, plant_iron_at(&iron, 1e5, 0.0).Ldd_H);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 2.0 * c.Ld_H - c.Ld_sat_H,
                              plant_iron_at(&iron, -1e5, 0.0).Ldd_H);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, c.Lq_sat_H, plant_iron_at(&iron, 0.0, 1e5).Lqq_H);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, -c.Ldq_H, plant_iron_at(&iron, 0.0, c.i_cross_A).Ldq_H);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, c.Ldq_H, plant_iron_at(&iron, 0.0, -c.i_cross_A).Ldq_H);
    double largest_H = 0.0;
    for (double id = -30.0; id <= 30.0; id += 0.25) {
        for (double iq = -30.0; iq <= 30.0; iq += 0.25) {
            largest_H = fmax(largest_H, fabs(plant_iron_at(&iron, id, iq).Ldq_H));
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, c.Ldq_H, largest_H);
}

/// Differential inductances against differences of the fluxes, and those against each other.
static void test_inductances_are_the_slopes_of_the_fluxes(void) {
    const plant_config_t c = saturated();
    const plant_iron_t iron = iron_of(&c);
    const double h = 1e-4; // rounding 1e-18/h, curvature of third order h^2
    plant_noise_t noise;
    plant_noise_init(&noise, 14);
    for (int n = 0; n < 2000; n++) {
        const double id = uniform(&noise, -30.0, 30.0), iq = uniform(&noise, -30.0, 30.0);
        const plant_iron_point_t at = plant_iron_at(&iron, id, iq);
        const plant_iron_point_t d1 = plant_iron_at(&iron, id + h, iq),
                                 d0 = plant_iron_at(&iron, id - h, iq),
                                 q1 = plant_iron_at(&iron, id, iq + h),
                                 q0 = plant_iron_at(&iron, id, iq - h);
        // |iq| makes a kink in the slope of Lq at zero: first order there
        const double limit = fabs(iq) < h ? 1e-7 : 1e-11;
        TEST_ASSERT_DOUBLE_WITHIN(1e-11, (d1.psi_d_Wb - d0.psi_d_Wb) / (2.0 * h), at.Ldd_H);
        TEST_ASSERT_DOUBLE_WITHIN(1e-11, (d1.psi_q_Wb - d0.psi_q_Wb) / (2.0 * h), at.Ldq_H);
        TEST_ASSERT_DOUBLE_WITHIN(1e-11, (q1.psi_d_Wb - q0.psi_d_Wb) / (2.0 * h), at.Ldq_H);
        TEST_ASSERT_DOUBLE_WITHIN(limit, (q1.psi_q_Wb - q0.psi_q_Wb) / (2.0 * h), at.Lqq_H);
    }
}

/// The field takes round a closed path what it gives, and holds what its energy says half way.
static void test_field_energy_is_a_function_of_state(void) {
    enum { STEPS = 200000, HALF = STEPS / 2 };
    const double turn = 6.28318530717958647693 / STEPS;
    const plant_config_t c = saturated();
    const plant_iron_t iron = iron_of(&c);
    plant_iron_point_t last = plant_iron_at(&iron, 0.0, 0.0);
    double last_d = 0.0, last_q = 0.0, taken_J = 0.0, moved_J = 0.0;
    for (int n = 1; n <= STEPS; n++) {
        // A path round the plane that leaves zero on one side and comes back on the other.
        const double id = 7.0 - 7.0 * cos(n * turn), iq = -12.0 * sin(n * turn);
        const plant_iron_point_t at = plant_iron_at(&iron, id - 3.0 * sin(n * turn), iq);
        const double d = id - 3.0 * sin(n * turn);
        const double step_J = 0.5 * (d + last_d) * (at.psi_d_Wb - last.psi_d_Wb) +
                              0.5 * (iq + last_q) * (at.psi_q_Wb - last.psi_q_Wb);
        taken_J += step_J;
        moved_J += fabs(step_J);
        last = at;
        last_d = d;
        last_q = iq;
        if (n % (HALF / 5) == 0) { // the trapezoid's own error: 1e-10 of the throughput
            TEST_ASSERT_DOUBLE_WITHIN(1e-8 * moved_J, taken_J, plant_iron_energy(&iron, d, iq));
        }
    }
    TEST_ASSERT_TRUE(moved_J > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8 * moved_J, 0.0, taken_J);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, plant_iron_energy(&iron, 0.0, 0.0));
}

/// Any iron that is accepted: fluxes give the currents back to rounding from near and from far, and no
/// inductance is below the bound.
static void test_currents_follow_from_the_fluxes(void) {
    plant_noise_t noise;
    int refused = 0;
    plant_noise_init(&noise, 2022);
    for (int n = 0; n < 4000; n++) {
        plant_config_t c = saturated();
        c.i_sat_A = uniform(&noise, 0.5, 30.0);
        c.Lq_sat_H = c.Lq_H * uniform(&noise, 0.02, 1.0);
        c.id_sat_A = uniform(&noise, 0.5, 30.0);
        c.Ld_sat_H = c.Ld_H * uniform(&noise, 0.05, 1.0);
        c.i_cross_A = uniform(&noise, 0.5, 30.0);
        c.Ldq_H = uniform(&noise, -1.0, 1.0) * 1e-3;
        if (plant_iron_check(&c) != NULL) {
            refused++;
            continue;
        }
        const plant_iron_t iron = iron_of(&c);
        const double id = uniform(&noise, -60.0, 60.0), iq = uniform(&noise, -60.0, 60.0);
        const plant_iron_point_t at = plant_iron_at(&iron, id, iq);
        const double half = 0.5 * (at.Ldd_H - at.Lqq_H);
        TEST_ASSERT_TRUE(0.5 * (at.Ldd_H + at.Lqq_H) - hypot(half, at.Ldq_H) >=
                         iron.smallest_L_H * (1.0 - 1e-12));
        double d[2] = {id + 0.1, uniform(&noise, -60.0, 60.0)};
        double q[2] = {iq - 0.2, uniform(&noise, -60.0, 60.0)};
        for (int k = 0; k < 2; k++) {
            plant_iron_currents(&iron, at.psi_d_Wb, at.psi_q_Wb, &d[k], &q[k]);
            // A flux known to 1e-16 of 0.6 Wb, over the smallest inductance.
            const double limit = 1e-14 + 1e-15 / iron.smallest_L_H;
            TEST_ASSERT_DOUBLE_WITHIN(limit, id, d[k]);
            TEST_ASSERT_DOUBLE_WITHIN(limit, iq, q[k]);
        }
    }
    TEST_ASSERT_TRUE(refused > 100 && refused < 3000); // both sides were met
}

/// Without its currents the law is the linear machine's, and the motor takes the linear way.
static void test_without_currents_it_is_linear(void) {
    plant_config_t c = plant_config_jiang2022();
    TEST_ASSERT_FALSE(plant_iron_saturates(&c));
    c.Ld_sat_H = 1e-3;
    c.Lq_sat_H = 1e-3;
    c.Ldq_H = 1e-3;
    TEST_ASSERT_FALSE(plant_iron_saturates(&c));
    const plant_iron_t iron = iron_of(&c);
    const plant_iron_point_t at = plant_iron_at(&iron, 5.0, -7.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 5.0 * c.Ld_H, at.psi_d_Wb);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, -7.0 * c.Lq_H, at.psi_q_Wb);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.5 * (25.0 * c.Ld_H + 49.0 * c.Lq_H),
                              plant_iron_energy(&iron, 5.0, -7.0));
    TEST_ASSERT_TRUE(iron.smallest_L_H == c.Ld_H);
}

/// The whole plant with iron that hardly saturates is the linear plant: two ways of integration.
static void test_the_limit_of_no_saturation_is_the_linear_plant(void) {
    plant_config_t c = plant_config_jiang2022();
    c.load_is_passive = false;
    c.omega_m_rad_s = 40.0;
    plant_t linear, iron;
    TEST_ASSERT_NULL(plant_init(&linear, &c));
    c.id_sat_A = 1e6;
    c.Ld_sat_H = 0.5 * c.Ld_H;
    c.i_sat_A = 1e6;
    c.Lq_sat_H = 0.5 * c.Lq_H;
    TEST_ASSERT_NULL(plant_init(&iron, &c));
    for (int k = 0; k < 200; k++) {
        const double duty[3] = {0.5 + 0.03 * sin(0.1 * k), 0.5 + 0.03 * sin(0.07 * k), 0.5};
        plant_truth_t a, b;
        plant_write(&linear, duty, PLANT_GATES_ON);
        plant_write(&iron, duty, PLANT_GATES_ON);
        plant_advance(&linear);
        plant_advance(&iron);
        plant_sample(&linear, NULL, &a);
        plant_sample(&iron, NULL, &b);
        // 20 A of 1e6 A, and the error of two step sizes
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, a.id_A, b.id_A);
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, a.iq_A, b.iq_A);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_inductances_are_what_the_keys_say);
    RUN_TEST(test_inductances_are_the_slopes_of_the_fluxes);
    RUN_TEST(test_field_energy_is_a_function_of_state);
    RUN_TEST(test_currents_follow_from_the_fluxes);
    RUN_TEST(test_without_currents_it_is_linear);
    RUN_TEST(test_the_limit_of_no_saturation_is_the_linear_plant);
    return UNITY_END();
}
