// Vector space decomposition against the written-out matrix, and where harmonics land.
#include "support/check.h"

#include "golden/vsd.h"
#include "support/vsd6.h"

void setUp(void) {}

void tearDown(void) {}

// A few roundings of numbers up to 10.
#define ROUNDING 4.0e-6

static lode_abc6_t phases(const double x[6]) {
    return (lode_abc6_t){
        {{(float)x[0], (float)x[1], (float)x[2]}, {(float)x[3], (float)x[4], (float)x[5]}}};
}

static void check_planes(const double expected[6], const vsd6_t *v) {
    CHECK_NEAR(ROUNDING, expected[0], v->ab.alpha);
    CHECK_NEAR(ROUNDING, expected[1], v->ab.beta);
    CHECK_NEAR(ROUNDING, expected[2], v->xy.alpha);
    CHECK_NEAR(ROUNDING, expected[3], v->xy.beta);
    CHECK_NEAR(ROUNDING, expected[4], v->o1);
    CHECK_NEAR(ROUNDING, expected[5], v->o2);
}

static void test_transform_is_the_matrix(void) {
    for (int n = 0; n < COUNT_OF(vsd_cases); n++) {
        const lode_abc6_t x = phases(vsd_cases[n].phase);
        const vsd6_t v = vsd6(&x);
        check_planes(vsd_cases[n].plane, &v);
    }
}

static void test_inverse_gives_the_phases_back(void) {
    for (int n = 0; n < COUNT_OF(vsd_cases); n++) {
        const lode_abc6_t x = phases(vsd_cases[n].phase);
        const vsd6_t v = vsd6(&x);
        const lode_abc6_t back = vsd6_inverse(&v);
        for (int set = 0; set < LODE_SETS; set++) {
            CHECK_NEAR(2.0 * ROUNDING, x.set[set].a, back.set[set].a);
            CHECK_NEAR(2.0 * ROUNDING, x.set[set].b, back.set[set].b);
            CHECK_NEAR(2.0 * ROUNDING, x.set[set].c, back.set[set].c);
        }
    }
}

/// Harmonic `order` in all six phases, each at its own angle behind `theta`.
static vsd6_t of_harmonic(int order, double theta) {
    static const double axis[6] = {0.0, 120.0, 240.0, 30.0, 150.0, 270.0};
    double x[6];
    for (int n = 0; n < 6; n++) {
        x[n] = cos(order * (theta - axis[n] * CHECK_DEG));
    }
    const lode_abc6_t six = phases(x);
    return vsd6(&six);
}

/// The harmonic turns in `plane` (0: ab, 1: xy, 2: neither) by `turns` angles theta.
static void check_lands(int order, int plane, int turns) {
    for (int n = 0; n < 24; n++) {
        const double theta = 0.1 + n * 0.7;
        const vsd6_t v = of_harmonic(order, theta);
        const double c = cos(turns * theta);
        const double s = sin(turns * theta);
        const double zero = plane == 2 ? cos(order * theta) : 0.0;
        CHECK_NEAR(ROUNDING, plane == 0 ? c : 0.0, v.ab.alpha);
        CHECK_NEAR(ROUNDING, plane == 0 ? s : 0.0, v.ab.beta);
        CHECK_NEAR(ROUNDING, plane == 1 ? c : 0.0, v.xy.alpha);
        CHECK_NEAR(ROUNDING, plane == 1 ? s : 0.0, v.xy.beta);
        CHECK_NEAR(ROUNDING, zero, v.o1);
    }
}

static void test_harmonics_land_where_they_should(void) {
    check_lands(1, 0, 1);
    check_lands(5, 1, 5);
    check_lands(7, 1, -7);
    check_lands(11, 0, -11);
    check_lands(13, 0, 13);
    check_lands(3, 2, 0);
    check_lands(9, 2, 0);
}

static void test_sets_and_planes_are_each_others_inverse(void) {
    random_t random = random_seed(2);
    for (int n = 0; n < 1000; n++) {
        const lode_ab_t ab = {random_float(&random, -10.0, 10.0),
                              random_float(&random, -10.0, 10.0)};
        const lode_ab_t xy = {random_float(&random, -10.0, 10.0),
                              random_float(&random, -10.0, 10.0)};
        const lode_sets_t sets = lode_vsd_sets(ab, xy);
        CHECK_NEAR(ROUNDING, ab.alpha, lode_vsd_ab(sets).alpha);
        CHECK_NEAR(ROUNDING, ab.beta, lode_vsd_ab(sets).beta);
        CHECK_NEAR(ROUNDING, xy.alpha, lode_vsd_xy(sets).alpha);
        CHECK_NEAR(ROUNDING, xy.beta, lode_vsd_xy(sets).beta);
        const lode_ab_t there = lode_set2_clarke(lode_set2_clarke_inverse(ab));
        CHECK_NEAR(ROUNDING, ab.alpha, there.alpha);
        CHECK_NEAR(ROUNDING, ab.beta, there.beta);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_transform_is_the_matrix);
    RUN_TEST(test_inverse_gives_the_phases_back);
    RUN_TEST(test_harmonics_land_where_they_should);
    RUN_TEST(test_sets_and_planes_are_each_others_inverse);
    return UNITY_END();
}
