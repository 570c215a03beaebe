// Every status has its own name.
#include "support/check.h"

#include "lodestar/status.h"

void setUp(void) {}

void tearDown(void) {}

static void test_names_are_distinct_and_prefixed(void) {
    for (int i = 0; i < (int)LODE_STATUS_COUNT; i++) {
        const char *name = lode_status_name((lode_status_t)i);
        const char *prefix = i == 0 ? "LODE_OK" : "LODE_ERROR_";
        TEST_ASSERT_EQUAL_STRING_LEN(prefix, name, strlen(prefix));
        for (int j = 0; j < i; j++) {
            TEST_ASSERT_TRUE(strcmp(name, lode_status_name((lode_status_t)j)) != 0);
        }
    }
}

static void test_names_are_the_enumerators(void) {
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(LODE_OK));
    TEST_ASSERT_EQUAL_STRING("LODE_ERROR_NULL", lode_status_name(LODE_ERROR_NULL));
    TEST_ASSERT_EQUAL_STRING("LODE_ERROR_EMF_W0", lode_status_name(LODE_ERROR_EMF_W0));
    TEST_ASSERT_EQUAL_STRING("LODE_ERROR_COMMAND", lode_status_name(LODE_ERROR_COMMAND));
    TEST_ASSERT_EQUAL_STRING("LODE_ERROR_TUNING", lode_status_name(LODE_ERROR_TUNING));
    TEST_ASSERT_EQUAL_STRING("LODE_ERROR_PRE_SHARE", lode_status_name(LODE_ERROR_PRE_SHARE));
}

static void test_other_values_are_unknown(void) {
    TEST_ASSERT_EQUAL_STRING("LODE_STATUS_UNKNOWN", lode_status_name(LODE_STATUS_COUNT));
    TEST_ASSERT_EQUAL_STRING("LODE_STATUS_UNKNOWN",
                             lode_status_name((lode_status_t)((int)LODE_STATUS_COUNT + 1)));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_names_are_distinct_and_prefixed);
    RUN_TEST(test_names_are_the_enumerators);
    RUN_TEST(test_other_values_are_unknown);
    return UNITY_END();
}
