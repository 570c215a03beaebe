// Scalar arithmetic against libm in double, over all floats.
#include "support/check.h"

#include "golden/minimax.h"
#include "scalar_inline.h"

void setUp(void) {}

void tearDown(void) {}

// Documented error of sine and cosine up to 8 pi.
#define SINCOS_ERROR 1.0e-6
// Documented error of the arc tangent, rad.
#define ATAN2_ERROR 1.0e-6

static void note_sincos(worst_t *worst, float x) {
    const lode_sincos_t s = lode_sincos(x);
    worst_note(worst, (double)s.sin - sin((double)x));
    worst_note(worst, (double)s.cos - cos((double)x));
}

static void test_sincos_error_up_to_8_pi(void) {
    worst_t worst = {0.0};
    const double end = 8.0 * CHECK_PI;
    for (int i = -1000000; i <= 1000000; i += CHECK_SHARE) {
        note_sincos(&worst, (float)(end * i / 1.0e6));
    }
    CHECK_AT_MOST(SINCOS_ERROR, worst.value);
}

static void test_sincos_error_where_quadrants_change(void) {
    worst_t worst = {0.0};
    for (int n = -32; n <= 32; n++) {
        const float x = (float)(n * CHECK_PI / 4.0);
        float low = x;
        float high = x;
        for (int i = 0; i < 50; i++) {
            note_sincos(&worst, low);
            note_sincos(&worst, high);
            low = nextafterf(low, -INFINITY);
            high = nextafterf(high, INFINITY);
        }
    }
    CHECK_AT_MOST(SINCOS_ERROR, worst.value);
}

static void test_sincos_known_values(void) {
    const lode_sincos_t zero = lode_sincos(0.0f);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, zero.sin);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, zero.cos);
    // The float next to pi/6 is off by up to 3e-8.
    CHECK_NEAR(1.5e-7, 0.5, lode_sincos((float)(CHECK_PI / 6.0)).sin);
    CHECK_NEAR(1.5e-7, 0.5, lode_sincos((float)(CHECK_PI / 3.0)).cos);
    CHECK_NEAR(1.5e-7, -1.0, lode_sincos((float)(-CHECK_PI / 2.0)).sin);
    CHECK_NEAR(1.5e-7, -1.0, lode_sincos((float)CHECK_PI).cos);
}

static void test_sine_is_odd_and_cosine_even(void) {
    random_t random = random_seed(1);
    for (int i = 0; i < CHECK_TRIES(100000); i++) {
        const float x = random_float(&random, -3000.0, 3000.0);
        const lode_sincos_t plus = lode_sincos(x);
        const lode_sincos_t minus = lode_sincos(-x);
        TEST_ASSERT_TRUE(plus.sin == -minus.sin && plus.cos == minus.cos);
    }
}

static void test_sincos_of_any_float_lies_within_one(void) {
    bool inside = true;
    for (uint64_t bits = 0; bits <= UINT32_MAX; bits += 1021 * CHECK_SHARE) {
        const lode_sincos_t s = lode_sincos(check_from_bits((uint32_t)bits));
        inside = inside && s.sin >= -1.0f && s.sin <= 1.0f && s.cos >= -1.0f && s.cos <= 1.0f;
    }
    for (int i = 0; i < COUNT_OF(check_odd_floats); i++) {
        const lode_sincos_t s = lode_sincos(check_odd_floats[i]);
        inside = inside && fabsf(s.sin) <= 1.0f && fabsf(s.cos) <= 1.0f;
    }
    TEST_ASSERT_TRUE(inside);
}

static void test_sincos_beyond_the_limit_is_that_of_zero(void) {
    const float beyond[] = {nextafterf(LODE_ANGLE_LIMIT_rad, INFINITY),
                            -2049.0f,
                            1.0e30f,
                            FLT_MAX,
                            NAN,
                            INFINITY,
                            -INFINITY};
    for (int i = 0; i < COUNT_OF(beyond); i++) {
        const lode_sincos_t s = lode_sincos(beyond[i]);
        TEST_ASSERT_TRUE(s.sin == 0.0f && s.cos == 1.0f);
    }
    // Inside the limit it is still the angle's: 1e-4 is the spacing of floats there.
    CHECK_NEAR(1.0e-4, sin(2047.5), lode_sincos(2047.5f).sin);
    CHECK_NEAR(1.0e-4, cos(-2048.0), lode_sincos(-LODE_ANGLE_LIMIT_rad).cos);
}

static void test_sincos_of_an_octant(void) {
    worst_t worst = {0.0};
    for (int i = -200000; i <= 200000; i += CHECK_SHARE) {
        const float x = (float)(i * CHECK_PI / 800000.0);
        const lode_sincos_t s = lode_sincos_octant(x);
        worst_note(&worst, (double)s.sin - sin((double)x));
        worst_note(&worst, (double)s.cos - cos((double)x));
        // Within the octant there is nothing to reduce: the same to the bit. At its end either may be.
        const lode_sincos_t whole = lode_sincos(x);
        TEST_ASSERT_TRUE((s.sin == whole.sin && s.cos == whole.cos) || i <= -199999 || i >= 199999);
    }
    CHECK_AT_MOST(1.0e-7, worst.value);
}

static void test_sincos_of_a_small_angle(void) {
    worst_t at_quarter = {0.0};
    for (int i = -100000; i <= 100000; i += CHECK_SHARE) {
        const float x = 0.5f * (float)i / 100000.0f;
        const double a = fabs((double)x);
        const lode_sincos_t s = lode_sincos_small(x);
        const double angle = angle_error(atan2((double)s.sin, (double)s.cos), (double)x);
        // x^5/30 of angle and x^4/24 of length, with the next terms of both series, and rounding.
        CHECK_NEAR(1.3 * pow(a, 5.0) / 30.0 + 1.0e-7, 0.0, angle);
        CHECK_NEAR(1.3 * pow(a, 4.0) / 24.0 + 2.0e-7, 1.0, hypot((double)s.sin, (double)s.cos));
        worst_note(&at_quarter, a <= 0.25 ? angle : 0.0);
    }
    CHECK_AT_MOST(3.5e-5, at_quarter.value); // as documented, to its one digit
    const lode_sincos_t zero = lode_sincos_small(0.0f);
    TEST_ASSERT_TRUE(zero.sin == 0.0f && zero.cos == 1.0f);
}

static double horner(const double *c, int count, double t) {
    double value = 0.0;
    for (int i = count - 1; i >= 0; i--) {
        value = value * t + c[i];
    }
    return value;
}

static void test_polynomials_are_the_generated_ones(void) {
    // Four roundings of numbers up to 1 (6e-8 each) lie between the code and exact arithmetic.
    const double rounding = 2.4e-7;
    for (int i = -1000; i <= 1000; i++) {
        const float x = (float)(i * CHECK_PI / 4000.0);
        const double r = (double)x;
        const double t = r * r;
        const double s = r + r * t * horner(minimax_sin, COUNT_OF(minimax_sin), t);
        const double c = 1.0 + t * horner(minimax_cos, COUNT_OF(minimax_cos), t);
        CHECK_NEAR(rounding, s, lode_sincos(x).sin);
        CHECK_NEAR(rounding, c, lode_sincos(x).cos);
        CHECK_NEAR(minimax_sin_error, sin(r), s);
        CHECK_NEAR(minimax_cos_error, cos(r), c);
        const float tangent = (float)i / 1000.0f;
        const double q = (double)tangent;
        const double a = q + q * q * q * horner(minimax_atan, COUNT_OF(minimax_atan), q * q);
        CHECK_NEAR(rounding, a, lode_atan2(tangent, 1.0f));
        CHECK_NEAR(minimax_atan_error, atan(q), a);
    }
    CHECK_AT_MOST(SINCOS_ERROR, minimax_sin_error + rounding);
    CHECK_AT_MOST(ATAN2_ERROR, minimax_atan_error + rounding);
}

static void test_atan2_error_in_all_octants(void) {
    worst_t worst = {0.0};
    random_t random = random_seed(2);
    for (int i = 0; i < CHECK_TRIES(1000000); i++) {
        const double angle = random_between(&random, -CHECK_PI, CHECK_PI);
        // Squares of these over- and underflow; the ratio does not.
        const double length = pow(10.0, random_between(&random, -30.0, 38.0));
        const float y = (float)(length * sin(angle));
        const float x = (float)(length * cos(angle));
        worst_note(&worst, angle_error((double)lode_atan2(y, x), atan2((double)y, (double)x)));
    }
    CHECK_AT_MOST(ATAN2_ERROR, worst.value);
}

static void test_atan2_on_axes_diagonals_and_denormals(void) {
    const float sizes[] = {1.0e-45f, 3.0e-40f, FLT_MIN, 1.0f, FLT_MAX};
    for (int i = 0; i < COUNT_OF(sizes); i++) {
        for (int sx = -1; sx <= 1; sx++) {
            for (int sy = -1; sy <= 1; sy++) {
                const float y = (float)sy * sizes[i];
                const float x = (float)sx * sizes[i];
                const double expected = sx == 0 && sy == 0 ? 0.0 : atan2((double)sy, (double)sx);
                CHECK_NEAR(ATAN2_ERROR, 0.0, angle_error(expected, (double)lode_atan2(y, x)));
            }
        }
    }
    CHECK_NEAR(ATAN2_ERROR, CHECK_PI, lode_atan2(0.0f, -1.0f)); // not -pi
    CHECK_NEAR(ATAN2_ERROR, CHECK_PI / 2.0, lode_atan2(FLT_MAX, 1.0e-45f));
    CHECK_NEAR(ATAN2_ERROR, 0.0, lode_atan2(1.0e-45f, FLT_MAX));
    CHECK_NEAR(ATAN2_ERROR, 0.0, lode_atan2(-0.0f, 1.0f));
}

static void test_atan2_of_any_pair_is_an_angle(void) {
    random_t random = random_seed(3);
    for (int i = 0; i < CHECK_TRIES(1000000); i++) {
        const float angle = lode_atan2(random_any(&random), random_any(&random));
        TEST_ASSERT_TRUE(angle >= -LODE_PI && angle <= LODE_PI);
    }
    for (int i = 0; i < COUNT_OF(check_odd_floats); i++) {
        TEST_ASSERT_TRUE(lode_atan2(NAN, check_odd_floats[i]) == 0.0f);
        TEST_ASSERT_TRUE(lode_atan2(check_odd_floats[i], NAN) == 0.0f);
        for (int j = 0; j < COUNT_OF(check_odd_floats); j++) {
            const float angle = lode_atan2(check_odd_floats[i], check_odd_floats[j]);
            TEST_ASSERT_TRUE(angle >= -LODE_PI && angle <= LODE_PI);
        }
    }
}

static void test_wrap_keeps_the_angle(void) {
    random_t random = random_seed(4);
    for (int i = 0; i < CHECK_TRIES(1000000); i++) {
        const float x = random_float(&random, -2048.0, 2048.0);
        const float wrapped = lode_wrap(x);
        TEST_ASSERT_TRUE(wrapped >= -LODE_PI && wrapped <= LODE_PI);
        // n 2 pi is off by the rounding of 2 pi and of the product: 1.2e-7 of x.
        CHECK_NEAR(1.2e-7 * fabs((double)x) + 3.0e-7, 0.0, angle_error((double)x, (double)wrapped));
    }
    TEST_ASSERT_EQUAL_FLOAT(1.0f, lode_wrap(1.0f));
    TEST_ASSERT_EQUAL_FLOAT(-3.0f, lode_wrap(-3.0f));
}

static void test_wrap_of_any_float_is_an_angle(void) {
    bool inside = true;
    for (uint64_t bits = 0; bits <= UINT32_MAX; bits += 1021 * CHECK_SHARE) {
        const float wrapped = lode_wrap(check_from_bits((uint32_t)bits));
        inside = inside && wrapped >= -LODE_PI && wrapped <= LODE_PI;
    }
    TEST_ASSERT_TRUE(inside);
    const float beyond[] = {2048.5f, -2048.5f, FLT_MAX, NAN, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT_OF(beyond); i++) {
        TEST_ASSERT_TRUE(lode_wrap(beyond[i]) == 0.0f);
    }
}

static void test_wrap_once_takes_one_turn(void) {
    random_t random = random_seed(5);
    for (int i = 0; i < CHECK_TRIES(100000); i++) {
        const float x = random_float(&random, -3.0 * CHECK_PI + 1.0e-5, 3.0 * CHECK_PI - 1.0e-5);
        const float wrapped = lode_wrap_once(x);
        // The last bit of 3 pi and of 2 pi: 5e-7 and 1.8e-7.
        CHECK_AT_MOST(CHECK_PI + 1.0e-6, fabs((double)wrapped));
        CHECK_NEAR(1.0e-6, 0.0, angle_error((double)x, (double)wrapped));
    }
    CHECK_NEAR(1.0e-5, 100.0 - 2.0 * CHECK_PI, lode_wrap_once(100.0f));
    CHECK_NEAR(1.0e-5, -100.0 + 2.0 * CHECK_PI, lode_wrap_once(-100.0f));
    TEST_ASSERT_TRUE(lode_wrap_once(LODE_PI) == LODE_PI);
    TEST_ASSERT_TRUE(lode_wrap_once(-LODE_PI) == -LODE_PI);
}

static void test_range_and_finiteness(void) {
    TEST_ASSERT_TRUE(lode_in_range(1.0f, 1.0f, 2.0f) && lode_in_range(2.0f, 1.0f, 2.0f));
    TEST_ASSERT_FALSE(lode_in_range(nextafterf(1.0f, 0.0f), 1.0f, 2.0f));
    TEST_ASSERT_FALSE(lode_in_range(nextafterf(2.0f, 3.0f), 1.0f, 2.0f));
    TEST_ASSERT_FALSE(lode_in_range(NAN, -INFINITY, INFINITY));
    TEST_ASSERT_FALSE(lode_in_range(INFINITY, -FLT_MAX, FLT_MAX));
    for (int i = 0; i < COUNT_OF(check_odd_floats); i++) {
        TEST_ASSERT_EQUAL_INT(isfinite(check_odd_floats[i]) != 0,
                              lode_is_finite(check_odd_floats[i]));
    }
}

static void test_clamp_min_max_abs_sign(void) {
    TEST_ASSERT_TRUE(lode_clamp(0.5f, -1.0f, 1.0f) == 0.5f);
    TEST_ASSERT_TRUE(lode_clamp(2.0f, -1.0f, 1.0f) == 1.0f);
    TEST_ASSERT_TRUE(lode_clamp(-2.0f, -1.0f, 1.0f) == -1.0f);
    TEST_ASSERT_TRUE(lode_clamp(INFINITY, -1.0f, 1.0f) == 1.0f);
    TEST_ASSERT_TRUE(lode_clamp(-INFINITY, -1.0f, 1.0f) == -1.0f);
    TEST_ASSERT_TRUE(lode_clamp(NAN, -1.0f, 1.0f) == -1.0f);
    TEST_ASSERT_TRUE(lode_clamp(-NAN, 0.25f, 1.0f) == 0.25f);
    TEST_ASSERT_TRUE(lode_min(1.0f, 2.0f) == 1.0f && lode_min(2.0f, 1.0f) == 1.0f);
    TEST_ASSERT_TRUE(lode_max(1.0f, 2.0f) == 2.0f && lode_max(2.0f, 1.0f) == 2.0f);
    TEST_ASSERT_TRUE(lode_abs(-3.0f) == 3.0f && lode_abs(3.0f) == 3.0f);
    TEST_ASSERT_TRUE(lode_abs(-INFINITY) == INFINITY);
    TEST_ASSERT_TRUE(lode_sign(-1.0e-45f) == -1.0f && lode_sign(-INFINITY) == -1.0f);
    TEST_ASSERT_TRUE(lode_sign(0.0f) == 1.0f && lode_sign(7.0f) == 1.0f);
    TEST_ASSERT_TRUE(lode_sign(NAN) == 1.0f);
}

static void test_sqrt_is_total(void) {
    random_t random = random_seed(6);
    for (int i = 0; i < CHECK_TRIES(100000); i++) {
        const float x = check_from_bits(random_bits(&random) & 0x7f7fffffu);
        // Correctly rounded: half a last place.
        CHECK_CLOSE(6.0e-8, sqrt((double)x), lode_sqrt(x));
    }
    const float none[] = {0.0f, -0.0f, -1.0e-45f, -1.0f, -FLT_MAX, -INFINITY, NAN};
    for (int i = 0; i < COUNT_OF(none); i++) {
        TEST_ASSERT_TRUE(lode_sqrt(none[i]) == 0.0f);
    }
}

static void test_one_minus_exp_against_expm1(void) {
    random_t random = random_seed(7);
    for (int i = 0; i < CHECK_TRIES(200000); i++) {
        const float x = (float)pow(10.0, random_between(&random, -37.0, 3.0));
        // Seven squarings of 1 - y in float: a few last places, relative, however small x is.
        CHECK_CLOSE(1.0e-6, -expm1(-(double)x), lode_one_minus_exp(x));
    }
    CHECK_NEAR(0.0, 1.0, lode_one_minus_exp(INFINITY));
    CHECK_NEAR(0.0, 1.0, lode_one_minus_exp(FLT_MAX));
    const float none[] = {0.0f, -0.0f, -1.0f, -FLT_MAX, -INFINITY, NAN};
    for (int i = 0; i < COUNT_OF(none); i++) {
        TEST_ASSERT_TRUE(lode_one_minus_exp(none[i]) == 0.0f);
    }
}

static void test_one_minus_exp_of_any_float_is_a_share(void) {
    for (uint64_t bits = 0; bits <= UINT32_MAX; bits += 10007 * CHECK_SHARE) {
        const float y = lode_one_minus_exp(check_from_bits((uint32_t)bits));
        TEST_ASSERT_TRUE(y >= 0.0f && y <= 1.0f);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_sincos_error_up_to_8_pi);
    RUN_TEST(test_sincos_error_where_quadrants_change);
    RUN_TEST(test_sincos_known_values);
    RUN_TEST(test_sine_is_odd_and_cosine_even);
    RUN_TEST(test_sincos_of_any_float_lies_within_one);
    RUN_TEST(test_sincos_beyond_the_limit_is_that_of_zero);
    RUN_TEST(test_sincos_of_an_octant);
    RUN_TEST(test_sincos_of_a_small_angle);
    RUN_TEST(test_polynomials_are_the_generated_ones);
    RUN_TEST(test_atan2_error_in_all_octants);
    RUN_TEST(test_atan2_on_axes_diagonals_and_denormals);
    RUN_TEST(test_atan2_of_any_pair_is_an_angle);
    RUN_TEST(test_wrap_keeps_the_angle);
    RUN_TEST(test_wrap_of_any_float_is_an_angle);
    RUN_TEST(test_wrap_once_takes_one_turn);
    RUN_TEST(test_range_and_finiteness);
    RUN_TEST(test_clamp_min_max_abs_sign);
    RUN_TEST(test_sqrt_is_total);
    RUN_TEST(test_one_minus_exp_against_expm1);
    RUN_TEST(test_one_minus_exp_of_any_float_is_a_share);
    return UNITY_END();
}
