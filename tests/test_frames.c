// Transforms: inverses, invariances, linearity.
#include "support/check.h"

#include "lodestar/frames.h"

void setUp(void) {}

void tearDown(void) {}

#define CASES CHECK_TRIES(20000)
// A handful of float roundings of numbers up to 100.
#define ROUNDING 5.0e-5

static random_t source;

static float some(void) {
    return random_float(&source, -100.0, 100.0);
}

static lode_ab_t some_ab(void) {
    return (lode_ab_t){some(), some()};
}

static lode_sincos_t some_angle(double *angle) {
    *angle = random_between(&source, -CHECK_PI, CHECK_PI);
    return sincos_of(*angle);
}

static double length_of(lode_sincos_t x) {
    return hypot((double)x.sin, (double)x.cos);
}

static void check_ab(double alpha, double beta, lode_ab_t actual) {
    CHECK_NEAR(ROUNDING, alpha, actual.alpha);
    CHECK_NEAR(ROUNDING, beta, actual.beta);
}

static void test_clarke_of_balanced_phases_keeps_the_amplitude(void) {
    source = random_seed(1);
    for (int i = 0; i < CASES; i++) {
        const double amplitude = random_between(&source, 0.0, 100.0);
        const double angle = random_between(&source, -CHECK_PI, CHECK_PI);
        const double third = 2.0 * CHECK_PI / 3.0;
        const lode_abc_t x = {(float)(amplitude * cos(angle)),
                              (float)(amplitude * cos(angle - third)),
                              (float)(amplitude * cos(angle + third))};
        check_ab(amplitude * cos(angle), amplitude * sin(angle), lode_clarke(x));
        CHECK_NEAR(ROUNDING, amplitude, lode_ab_length(lode_clarke(x)));
    }
}

static void test_clarke_known_values(void) {
    check_ab(1.0, 0.0, lode_clarke((lode_abc_t){1.0f, -0.5f, -0.5f}));
    check_ab(0.0, 2.0 / sqrt(3.0), lode_clarke((lode_abc_t){0.0f, 1.0f, -1.0f}));
    check_ab(2.0 / 3.0, 0.0, lode_clarke((lode_abc_t){1.0f, 0.0f, 0.0f}));
}

static void test_clarke_common_mode_drops_out(void) {
    source = random_seed(2);
    for (int i = 0; i < CASES; i++) {
        const lode_abc_t x = {some(), some(), some()};
        const float common = some();
        const lode_ab_t expected = lode_clarke(x);
        check_ab((double)expected.alpha, (double)expected.beta,
                 lode_clarke((lode_abc_t){x.a + common, x.b + common, x.c + common}));
    }
}

static void test_clarke_and_its_inverse(void) {
    source = random_seed(3);
    for (int i = 0; i < CASES; i++) {
        const lode_ab_t x = some_ab();
        const lode_abc_t phases = lode_clarke_inverse(x);
        CHECK_NEAR(ROUNDING, 0.0, phases.a + phases.b + phases.c);
        check_ab((double)x.alpha, (double)x.beta, lode_clarke(phases));
    }
}

static void test_park_turns_by_minus_theta(void) {
    source = random_seed(4);
    for (int i = 0; i < CASES; i++) {
        double theta;
        const lode_sincos_t turn = some_angle(&theta);
        const double length = random_between(&source, 0.0, 100.0);
        const double angle = random_between(&source, -CHECK_PI, CHECK_PI);
        const lode_ab_t x = {(float)(length * cos(angle)), (float)(length * sin(angle))};
        const lode_dq_t dq = lode_park(x, turn);
        CHECK_NEAR(ROUNDING, length * cos(angle - theta), dq.d);
        CHECK_NEAR(ROUNDING, length * sin(angle - theta), dq.q);
        check_ab((double)x.alpha, (double)x.beta, lode_park_inverse(dq, turn));
    }
}

static void test_power_is_three_halves(void) {
    source = random_seed(5);
    for (int i = 0; i < CASES; i++) {
        const lode_ab_t u = some_ab();
        const lode_ab_t j = some_ab();
        const lode_abc_t up = lode_clarke_inverse(u);
        const lode_abc_t ip = lode_clarke_inverse(j);
        double theta;
        const lode_sincos_t turn = some_angle(&theta);
        const lode_dq_t ur = lode_park(u, turn);
        const lode_dq_t ir = lode_park(j, turn);
        const double phases = (double)(up.a * ip.a + up.b * ip.b + up.c * ip.c);
        // Sums of products up to 3e4: a few roundings of 6e-8 of it.
        CHECK_NEAR(0.02, phases, 1.5f * (u.alpha * j.alpha + u.beta * j.beta));
        CHECK_NEAR(0.02, phases, 1.5f * (ur.d * ir.d + ur.q * ir.q));
    }
}

static void test_transforms_are_linear(void) {
    source = random_seed(6);
    for (int i = 0; i < CASES; i++) {
        const lode_abc_t x = {some(), some(), some()};
        const lode_abc_t y = {some(), some(), some()};
        const float k = random_float(&source, -2.0, 2.0);
        const lode_ab_t cx = lode_clarke(x);
        const lode_ab_t cy = lode_clarke(y);
        const lode_abc_t sum = {x.a + k * y.a, x.b + k * y.b, x.c + k * y.c};
        check_ab((double)(cx.alpha + k * cy.alpha), (double)(cx.beta + k * cy.beta),
                 lode_clarke(sum));
        double theta;
        const lode_sincos_t turn = some_angle(&theta);
        const lode_dq_t px = lode_park(cx, turn);
        const lode_dq_t py = lode_park(cy, turn);
        const lode_dq_t p = lode_park(lode_ab_add_scaled(cx, k, cy), turn);
        CHECK_NEAR(ROUNDING, px.d + k * py.d, p.d);
        CHECK_NEAR(ROUNDING, px.q + k * py.q, p.q);
    }
}

static void test_sums_and_differences_of_angles(void) {
    source = random_seed(7);
    for (int i = 0; i < CASES; i++) {
        double a;
        double b;
        const lode_sincos_t x = some_angle(&a);
        const lode_sincos_t y = some_angle(&b);
        const lode_sincos_t sum = lode_angle_add(x, y);
        const lode_sincos_t difference = lode_angle_subtract(x, y);
        // Two products and a sum of numbers up to 1.
        CHECK_NEAR(3.0e-7, sin(a + b), sum.sin);
        CHECK_NEAR(3.0e-7, cos(a + b), sum.cos);
        CHECK_NEAR(3.0e-7, sin(a - b), difference.sin);
        CHECK_NEAR(3.0e-7, cos(a - b), difference.cos);
    }
}

static void test_multiples_of_an_angle(void) {
    source = random_seed(8);
    for (int i = 0; i < CASES; i++) {
        double a;
        const lode_sincos_t x = some_angle(&a);
        const lode_sincos_t two = lode_angle_double(x);
        const lode_sincos_t three = lode_angle_triple(x);
        // A few roundings of numbers up to 2 and 3.
        CHECK_NEAR(4.0e-7, sin(2.0 * a), two.sin);
        CHECK_NEAR(4.0e-7, cos(2.0 * a), two.cos);
        CHECK_NEAR(1.0e-6, sin(3.0 * a), three.sin);
        CHECK_NEAR(1.0e-6, cos(3.0 * a), three.cos);
    }
}

static void test_a_rotated_vector(void) {
    source = random_seed(9);
    for (int i = 0; i < CASES; i++) {
        double a;
        const lode_sincos_t turn = some_angle(&a);
        const lode_ab_t x = some_ab();
        const double alpha = (double)x.alpha;
        const double beta = (double)x.beta;
        check_ab(alpha * cos(a) - beta * sin(a), alpha * sin(a) + beta * cos(a),
                 lode_ab_rotate(x, turn));
    }
}

static void test_an_angle_rotated_by_a_small_one(void) {
    source = random_seed(10);
    for (int i = 0; i < CASES; i++) {
        double a;
        const lode_sincos_t x = some_angle(&a);
        const double move = random_between(&source, -0.3, 0.3);
        const lode_sincos_t moved = lode_angle_rotate_small(x, (float)move);
        // By the arc tangent, at most 3 % less than the move itself at 0.3 rad.
        const double turned = angle_error(atan2((double)moved.sin, (double)moved.cos), a);
        CHECK_NEAR(3.0e-7, atan(move), turned);
        CHECK_NEAR(0.03 * fabs(move) + 3.0e-7, move, turned);
        CHECK_NEAR(3.0e-7, hypot(1.0, move), length_of(moved));
        // A step of Newton's towards 1 leaves 3/8 of the square of what is off.
        CHECK_NEAR(0.4 * pow(move, 4.0) + 3.0e-7, 1.0, length_of(lode_angle_normalise(moved)));
    }
}

static void test_a_length_that_is_off_comes_back(void) {
    for (int i = 0; i < 10; i++) {
        const float length = 0.5f + 0.1f * (float)i; // 0.5 .. 1.4
        lode_sincos_t x = {0.6f * length, 0.8f * length};
        for (int n = 0; n < 8; n++) {
            x = lode_angle_normalise(x);
            CHECK_NEAR(2.0e-7, atan2(0.6, 0.8), atan2((double)x.sin, (double)x.cos));
        }
        CHECK_NEAR(3.0e-7, 1.0, length_of(x));
    }
}

static void test_an_angle_shortened_before_it_is_rotated(void) {
    source = random_seed(12);
    for (int i = 0; i < CASES; i++) {
        double a;
        const lode_sincos_t x = some_angle(&a);
        const double move = random_between(&source, -0.6, 0.6);
        const lode_sincos_t shorter = lode_angle_shorten(x, (float)move);
        CHECK_NEAR(3.0e-7, 0.0, angle_error(a, atan2((double)shorter.sin, (double)shorter.cos)));
        const lode_sincos_t moved = lode_angle_rotate_small(shorter, (float)move);
        CHECK_NEAR(0.013 * pow(move / 0.6, 4.0) + 3.0e-7, 1.0, length_of(moved));
    }
}

static void test_rounding_does_not_pile_up(void) {
    // A frame that is rotated in every period and normalised in every eighth, for seven minutes of
    // 200 us: its length stays near 1, and its angle is off by what the roundings leave of a random
    // walk.
    source = random_seed(11);
    lode_sincos_t x = {0.0f, 1.0f};
    double angle = 0.0;
    worst_t length = {0.0};
    worst_t off = {0.0};
    for (int i = 0; i < 2000000; i++) {
        const float step = random_float(&source, -0.2, 0.2);
        const float move = random_float(&source, -0.02, 0.02);
        x = lode_angle_rotate_small(lode_angle_add(x, lode_sincos(step)), move);
        x = i % 8 == 7 ? lode_angle_normalise(x) : x;
        angle = remainder(angle + (double)step + atan((double)move), 2.0 * CHECK_PI);
        worst_note(&length, length_of(x) - 1.0);
        worst_note(&off, angle_error(atan2((double)x.sin, (double)x.cos), angle));
    }
    CHECK_AT_MOST(8.0 * 0.5 * 0.02 * 0.02, length.value); // x^2/2 of each rotation
    CHECK_AT_MOST(1.0e-3, off.value); // 1e-7 a step, times the root of 2e6, and a bias of 5e-10
}

static void test_vector_arithmetic(void) {
    const lode_ab_t x = {3.0f, -4.0f};
    const lode_ab_t y = {1.0f, 2.0f};
    check_ab(2.0, -6.0, lode_ab_subtract(x, y));
    check_ab(1.0, -8.0, lode_ab_add_scaled(x, -2.0f, y));
    check_ab(-1.5, 2.0, lode_ab_scale(-0.5f, x));
    CHECK_NEAR(1.0e-6, 5.0, lode_ab_length(x));
    TEST_ASSERT_TRUE(lode_ab_length((lode_ab_t){NAN, 1.0f}) == 0.0f);
}

static void test_range_of_a_vector(void) {
    TEST_ASSERT_TRUE(lode_ab_in_range((lode_ab_t){4.0f, -4.0f}, 4.0f));
    TEST_ASSERT_FALSE(lode_ab_in_range((lode_ab_t){4.1f, 0.0f}, 4.0f));
    TEST_ASSERT_FALSE(lode_ab_in_range((lode_ab_t){-4.1f, 0.0f}, 4.0f));
    TEST_ASSERT_FALSE(lode_ab_in_range((lode_ab_t){0.0f, 4.1f}, 4.0f));
    TEST_ASSERT_FALSE(lode_ab_in_range((lode_ab_t){0.0f, -4.1f}, 4.0f));
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        TEST_ASSERT_FALSE(lode_ab_in_range((lode_ab_t){check_not_finite[i], 0.0f}, FLT_MAX));
        TEST_ASSERT_FALSE(lode_ab_in_range((lode_ab_t){0.0f, check_not_finite[i]}, FLT_MAX));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_clarke_of_balanced_phases_keeps_the_amplitude);
    RUN_TEST(test_clarke_known_values);
    RUN_TEST(test_clarke_common_mode_drops_out);
    RUN_TEST(test_clarke_and_its_inverse);
    RUN_TEST(test_park_turns_by_minus_theta);
    RUN_TEST(test_power_is_three_halves);
    RUN_TEST(test_transforms_are_linear);
    RUN_TEST(test_sums_and_differences_of_angles);
    RUN_TEST(test_multiples_of_an_angle);
    RUN_TEST(test_a_rotated_vector);
    RUN_TEST(test_an_angle_rotated_by_a_small_one);
    RUN_TEST(test_a_length_that_is_off_comes_back);
    RUN_TEST(test_an_angle_shortened_before_it_is_rotated);
    RUN_TEST(test_rounding_does_not_pile_up);
    RUN_TEST(test_vector_arithmetic);
    RUN_TEST(test_range_of_a_vector);
    return UNITY_END();
}
