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
    const double turn = 6.28318530717958647693 / (double)STEPS;
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

/// The fluxes of the law on a grid: 33 x 33 nodes over +-24 A, uneven where `uneven`.
static plant_map_t map_of(const plant_iron_t *iron, double psi_Wb, bool uneven,
                          plant_map_node_t node[33 * 33]) {
    static double psi_d[33 * 33], psi_q[33 * 33];
    plant_map_t map = {.rows = 33, .columns = 33, .node = node};
    for (int k = 0; k < 33; k++) {
        map.id_A[k] = 1.5 * (k - 16) + (uneven ? 0.4 * sin(k - 16.0) : 0.0);
        map.iq_A[k] = 1.5 * (k - 16) + (uneven ? 0.3 * sin(2.0 * (k - 16.0)) : 0.0);
    }
    for (int n = 0; n < 33 * 33; n++) {
        const plant_iron_point_t at = plant_iron_at(iron, map.id_A[n / 33], map.iq_A[n % 33]);
        psi_d[n] = psi_Wb + at.psi_d_Wb;
        psi_q[n] = at.psi_q_Wb;
    }
    TEST_ASSERT_NULL(plant_map_init(&map, psi_d, psi_q).why);
    return map;
}

/// A map of the law is the law: exactly at the nodes, by its own smoothness in between; and whatever lies
/// in between is one energy's.
static void test_map_of_the_law_is_the_law(void) {
    static plant_map_node_t node[33 * 33];
    plant_noise_t noise;
    plant_noise_init(&noise, 7);
    for (int uneven = 0; uneven < 2; uneven++) {
        plant_config_t c = saturated();
        const plant_iron_t law = iron_of(&c);
        const plant_map_t map = map_of(&law, c.psi_Wb, uneven != 0, node);
        c.map = &map;
        const plant_iron_t iron = iron_of(&c);
        TEST_ASSERT_TRUE(plant_iron_saturates(&c));
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, c.psi_Wb, map.psi_Wb);
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * c.Ld_H, c.Ld_H, map.Ld_H);
        TEST_ASSERT_TRUE(map.smallest_L_H > 0.5 * law.smallest_L_H);
        for (int n = 0; n < 33 * 33; n++) {
            const double id = map.id_A[n / 33], iq = map.iq_A[n % 33];
            const plant_iron_point_t a = plant_iron_at(&law, id, iq),
                                     b = plant_iron_at(&iron, id, iq);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, a.psi_d_Wb, b.psi_d_Wb);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, a.psi_q_Wb, b.psi_q_Wb);
        }
        for (int n = 0; n < 3000; n++) {
            const double id = uniform(&noise, -23.0, 23.0), iq = uniform(&noise, -23.0, 23.0);
            const plant_iron_point_t a = plant_iron_at(&law, id, iq),
                                     b = plant_iron_at(&iron, id, iq);
            // At most 1.9 A between nodes, scales of 5 to 12 A; near the kink of the law's Lq at no current h^2/32
            // of 2.4 mH/A is 2.7e-4 Wb, a hundredth of the flux's swing in a cell, and Lq' turns by 2.4 mH/A.
            const double kink = fabs(iq) < 4.5 ? 1.0 : 0.3;
            TEST_ASSERT_DOUBLE_WITHIN(2.7e-4 * kink, a.psi_d_Wb, b.psi_d_Wb);
            TEST_ASSERT_DOUBLE_WITHIN(2.7e-4 * kink, a.psi_q_Wb, b.psi_q_Wb);
            TEST_ASSERT_DOUBLE_WITHIN(0.02 * c.Ld_H, a.Ldd_H, b.Ldd_H);
            TEST_ASSERT_DOUBLE_WITHIN(0.06 * kink * c.Lq_H, a.Lqq_H, b.Lqq_H);
            TEST_ASSERT_DOUBLE_WITHIN(0.02 * c.Ld_H, a.Ldq_H, b.Ldq_H);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, plant_iron_energy(&law, id, iq),
                                      plant_iron_energy(&iron, id, iq));
            double d = 0.0, q = 0.0;
            plant_iron_currents(&iron, b.psi_d_Wb, b.psi_q_Wb, &d, &q);
            TEST_ASSERT_DOUBLE_WITHIN(1e-11, id, d);
            TEST_ASSERT_DOUBLE_WITHIN(1e-11, iq, q);
        }
    }
}

/// The field of a map takes round a closed path what it gives, coarse as its nodes may be.
static void test_map_makes_no_energy(void) {
    enum { STEPS = 100000 };
    static plant_map_node_t node[33 * 33];
    plant_config_t c = saturated();
    const plant_iron_t law = iron_of(&c);
    const plant_map_t map = map_of(&law, c.psi_Wb, true, node);
    c.map = &map;
    const plant_iron_t iron = iron_of(&c);
    plant_iron_point_t last = plant_iron_at(&iron, 18.0, 2.0);
    double taken_J = 0.0, moved_J = 0.0, d0 = 18.0, q0 = 2.0;
    for (int n = 1; n <= STEPS; n++) {
        const double turn = n * 6.28318530717958647693 / (double)STEPS;
        const double d = 18.0 * cos(turn), q = 2.0 + 15.0 * sin(turn);
        const plant_iron_point_t at = plant_iron_at(&iron, d, q);
        const double step_J = 0.5 * (d + d0) * (at.psi_d_Wb - last.psi_d_Wb) +
                              0.5 * (q + q0) * (at.psi_q_Wb - last.psi_q_Wb);
        taken_J += step_J;
        moved_J += fabs(step_J);
        last = at;
        d0 = d;
        q0 = q;
    }
    TEST_ASSERT_TRUE(moved_J > 0.3);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8 * moved_J, 0.0, taken_J);
}

/// The whole plant on a map and on the law it was taken from; beyond the map the fluxes go straight on.
static void test_plant_on_a_map(void) {
    static plant_map_node_t node[33 * 33];
    plant_config_t c = saturated();
    c.load_is_passive = false;
    c.omega_m_rad_s = 40.0;
    const plant_iron_t law = iron_of(&c);
    const plant_map_t map = map_of(&law, c.psi_Wb, false, node);
    plant_t by_law, by_map;
    TEST_ASSERT_NULL(plant_init(&by_law, &c));
    c.map = &map;
    TEST_ASSERT_NULL(plant_init(&by_map, &c));
    double largest_A = 0.0;
    for (int k = 0; k < 200; k++) {
        const double duty[3] = {0.5 + 0.03 * sin(0.1 * k), 0.5 + 0.03 * sin(0.07 * k), 0.5};
        plant_truth_t a, b;
        plant_write(&by_law, duty, PLANT_GATES_ON);
        plant_write(&by_map, duty, PLANT_GATES_ON);
        plant_advance(&by_law);
        plant_advance(&by_map);
        plant_sample(&by_law, NULL, &a);
        plant_sample(&by_map, NULL, &b);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, a.id_A, b.id_A);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, a.iq_A, b.iq_A);
        largest_A = fmax(largest_A, hypot(a.id_A, a.iq_A));
    }
    TEST_ASSERT_TRUE(largest_A > 5.0);
    const plant_map_value_t edge = plant_map_at(&map, 24.0, 3.0),
                            out = plant_map_at(&map, 30.0, 3.0);
    TEST_ASSERT_TRUE(plant_map_holds(&map, 24.0, 3.0) && !plant_map_holds(&map, 30.0, 3.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, edge.d + 6.0 * edge.dd, out.d);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, edge.q + 6.0 * edge.dq, out.q);
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
    RUN_TEST(test_map_of_the_law_is_the_law);
    RUN_TEST(test_map_makes_no_energy);
    RUN_TEST(test_plant_on_a_map);
    RUN_TEST(test_without_currents_it_is_linear);
    RUN_TEST(test_the_limit_of_no_saturation_is_the_linear_plant);
    return UNITY_END();
}
