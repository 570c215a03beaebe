// What outlives a reset, from memory that holds anything: the file itself, to put something there.
#include "kept.c"

#include "support/check.h"

void setUp(void) {}

void tearDown(void) {}

static void power_up(uint32_t left, uint32_t left_check) {
    resets = left;
    check = left_check;
}

static void test_memory_that_no_reset_has_left(void) {
    static const uint32_t garbage[][2] = {
        {0u, 0u}, {0xFFFFFFFFu, 0xFFFFFFFFu}, {12345u, 54321u}, {3u, MAGIC}};
    for (int n = 0; n < COUNT_OF(garbage); n++) {
        power_up(garbage[n][0], garbage[n][1]);
        TEST_ASSERT_EQUAL_UINT32(1u, kept_watchdog_resets(true));
        power_up(garbage[n][0], garbage[n][1]);
        TEST_ASSERT_EQUAL_UINT32(0u, kept_watchdog_resets(false));
    }
}

static void test_counts_on_and_begins_anew(void) {
    power_up(1u, 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, kept_watchdog_resets(false));
    TEST_ASSERT_EQUAL_UINT32(1u, kept_watchdog_resets(true));
    TEST_ASSERT_EQUAL_UINT32(2u, kept_watchdog_resets(true));
    TEST_ASSERT_EQUAL_UINT32(0u, kept_watchdog_resets(false)); // the reset button
    TEST_ASSERT_EQUAL_UINT32(1u, kept_watchdog_resets(true));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_memory_that_no_reset_has_left);
    RUN_TEST(test_counts_on_and_begins_anew);
    return UNITY_END();
}
