/// The plant's own cosine and sine against the C library's of long double.
#include "plant/turn.h"

#include "support/check.h"

#include <math.h>

void setUp(void) {}

void tearDown(void) {}

static void check_turn(double turns, double tolerance) {
    const long double angle = 6.283185307179586476925286766559L * (long double)turns;
    double c, s;
    plant_turn(turns, &c, &s);
    TEST_ASSERT_TRUE(fabsl(cosl(angle) - (long double)c) < (long double)tolerance);
    TEST_ASSERT_TRUE(fabsl(sinl(angle) - (long double)s) < (long double)tolerance);
}

static void test_all_round(void) {
    for (int k = -4000000; k <= 4000000; k += 7) {
        check_turn((double)k / 3999999.0, 4e-16);
    }
}

static void test_many_turns(void) {
    // A turn's parts are exact in binary, so many turns cost nothing.
    for (int k = 0; k < 4096; k++) {
        check_turn((double)k / 4096.0 + 12345678.0, 1e-11); // the tolerance is that of cosl
        double c, s, c_0, s_0;
        plant_turn((double)k / 4096.0, &c_0, &s_0);
        plant_turn((double)k / 4096.0 - 987654321.0, &c, &s);
        TEST_ASSERT_DOUBLE_WITHIN(4e-16, c_0, c);
        TEST_ASSERT_DOUBLE_WITHIN(4e-16, s_0, s);
    }
}

static void test_quarters_are_exact(void) {
    static const double cos_of[4] = {1.0, 0.0, -1.0, 0.0};
    for (int k = -9; k <= 9; k++) {
        double c, s;
        plant_turn(0.25 * k, &c, &s);
        TEST_ASSERT_DOUBLE_WITHIN(0.0, cos_of[(k + 12) % 4], c);
        TEST_ASSERT_DOUBLE_WITHIN(0.0, cos_of[(k + 11) % 4], s);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_all_round);
    RUN_TEST(test_many_turns);
    RUN_TEST(test_quarters_are_exact);
    return UNITY_END();
}
