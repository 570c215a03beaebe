// The last faults with the rows before them.
#include "lodestar/fault_log.h"

#include <unity.h>

void setUp(void) {}

void tearDown(void) {}

#define FAULTS 4u
#define ROWS 4u

static lode_telemetry_t buffer[LODE_FAULT_LOG_ROWS(FAULTS, ROWS)];
static uint32_t steps;

static uint_least16_t trips;

static bool step(lode_fault_log_t *log, lode_mode_t mode, lode_check_t check) {
    steps++;
    const lode_telemetry_t now = {
        .steps = steps,
        .mode = mode,
        .fault = {.check = (uint_least8_t)check},
        .trips = trips,
        .omega_rad_s = (float)steps,
    };
    return lode_fault_log_step(log, &now);
}

static lode_fault_log_t new_log(void) {
    lode_fault_log_t log;
    steps = 0u;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_fault_log_init(&log, buffer, FAULTS, ROWS));
    return log;
}

static void runs(lode_fault_log_t *log, int periods) {
    for (int n = 0; n < periods; n++) {
        TEST_ASSERT_FALSE(step(log, LODE_MODE_RUN, LODE_CHECK_NONE));
    }
}

static void faults(lode_fault_log_t *log, lode_check_t check) {
    TEST_ASSERT_TRUE(step(log, LODE_MODE_FAULT, check));
    for (int n = 0; n < 5; n++) {
        TEST_ASSERT_FALSE(step(log, LODE_MODE_FAULT, check)); // the same one
    }
}

static void test_a_fault_has_its_row_and_those_before(void) {
    lode_fault_log_t log = new_log();
    TEST_ASSERT_EQUAL_UINT(0u, lode_fault_log_count(&log));
    TEST_ASSERT_NULL(lode_fault_log_row(&log, 0u, 0u));
    runs(&log, 9);
    TEST_ASSERT_EQUAL_UINT(0u, lode_fault_log_count(&log));
    faults(&log, LODE_CHECK_OVER_VOLTAGE);
    TEST_ASSERT_EQUAL_UINT(1u, lode_fault_log_count(&log));
    for (uint32_t row = 0u; row < ROWS; row++) {
        const lode_telemetry_t *found = lode_fault_log_row(&log, 0u, row);
        TEST_ASSERT_NOT_NULL(found);
        TEST_ASSERT_EQUAL_UINT(10u - row, found->steps);
        TEST_ASSERT_TRUE(found->omega_rad_s == (float)(10u - row));
        TEST_ASSERT_EQUAL_INT(row == 0u ? LODE_MODE_FAULT : LODE_MODE_RUN, found->mode);
        TEST_ASSERT_EQUAL_INT(row == 0u ? LODE_CHECK_OVER_VOLTAGE : LODE_CHECK_NONE,
                              found->fault.check);
    }
    TEST_ASSERT_NULL(lode_fault_log_row(&log, 0u, ROWS));
    TEST_ASSERT_NULL(lode_fault_log_row(&log, 1u, 0u));
}

/// What was before a fault that came soon is not there, and not that of another one.
static void test_rows_that_nobody_saw_are_not_there(void) {
    lode_fault_log_t log = new_log();
    for (int round = 0; round < 8; round++) { // over all blocks, and over again
        if (round % 2 == 1) {                 // for the other ones
            runs(&log, 9);
            faults(&log, LODE_CHECK_START);
        }
        runs(&log, 1);
        faults(&log, LODE_CHECK_START);
        TEST_ASSERT_NOT_NULL(lode_fault_log_row(&log, 0u, 1u));
        for (uint32_t row = 2u; row < ROWS; row++) {
            TEST_ASSERT_NULL(lode_fault_log_row(&log, 0u, row));
        }
        runs(&log, 9);
        faults(&log, LODE_CHECK_START);
        TEST_ASSERT_NOT_NULL(lode_fault_log_row(&log, 0u, ROWS - 1u));
    }
}

static void test_the_last_ones_are_kept(void) {
    lode_fault_log_t log = new_log();
    for (int check = LODE_CHECK_HARDWARE_TRIP; check < LODE_CHECK_COUNT; check++) {
        runs(&log, 2);
        faults(&log, (lode_check_t)check);
        runs(&log, 7); // what comes next does not touch them
        const uint32_t held = lode_fault_log_count(&log);
        TEST_ASSERT_EQUAL_UINT((uint32_t)check < FAULTS ? (uint32_t)check : FAULTS, held);
        TEST_ASSERT_EQUAL_UINT((uint32_t)check, log.total);
        for (uint32_t back = 0u; back < held; back++) {
            TEST_ASSERT_EQUAL_UINT((uint32_t)check - back,
                                   lode_fault_log_row(&log, back, 0u)->fault.check);
            TEST_ASSERT_NULL(lode_fault_log_row(&log, back, ROWS)); // it is another's
        }
        TEST_ASSERT_NULL(lode_fault_log_row(&log, held, 0u));
    }
}

/// A trip whose current flows on is called a shorted switch a millisecond later.
static void test_a_fault_may_get_a_better_name(void) {
    lode_fault_log_t log = new_log();
    runs(&log, 3);
    TEST_ASSERT_TRUE(step(&log, LODE_MODE_FAULT, LODE_CHECK_OVER_CURRENT));
    TEST_ASSERT_FALSE(step(&log, LODE_MODE_FAULT, LODE_CHECK_SWITCH_SHORTED));
    TEST_ASSERT_EQUAL_UINT(1u, lode_fault_log_count(&log));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, lode_fault_log_row(&log, 0u, 0u)->fault.check);
    TEST_ASSERT_EQUAL_UINT(4u, lode_fault_log_row(&log, 0u, 0u)->steps); // of the trip
}

/// Cleared, started and tripped between two calls: a fault of its own.
static void test_a_fault_behind_a_fault_is_another_one(void) {
    lode_fault_log_t log = new_log();
    runs(&log, 3);
    faults(&log, LODE_CHECK_UNDER_VOLTAGE);
    trips++;
    faults(&log, LODE_CHECK_HARDWARE_TRIP);
    TEST_ASSERT_EQUAL_UINT(2u, lode_fault_log_count(&log));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, lode_fault_log_row(&log, 0u, 0u)->fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_UNDER_VOLTAGE, lode_fault_log_row(&log, 1u, 0u)->fault.check);
    TEST_ASSERT_EQUAL_UINT(4u, lode_fault_log_row(&log, 1u, 0u)->steps);
}

static void test_one_row_is_enough(void) {
    lode_fault_log_t log;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_fault_log_init(&log, buffer, 1u, 1u));
    for (int check = LODE_CHECK_HARDWARE_TRIP; check < LODE_CHECK_COUNT; check++) {
        runs(&log, 2);
        faults(&log, (lode_check_t)check);
        TEST_ASSERT_EQUAL_UINT(1u, lode_fault_log_count(&log));
        TEST_ASSERT_EQUAL_INT(check, lode_fault_log_row(&log, 0u, 0u)->fault.check);
    }
}

static void test_erased_it_is_empty(void) {
    lode_fault_log_t log = new_log();
    runs(&log, 9);
    faults(&log, LODE_CHECK_LOST_LOCK);
    lode_fault_log_erase(&log);
    TEST_ASSERT_EQUAL_UINT(0u, lode_fault_log_count(&log));
    TEST_ASSERT_EQUAL_UINT(0u, log.total);
    TEST_ASSERT_NULL(lode_fault_log_row(&log, 0u, 0u));
    TEST_ASSERT_FALSE(step(&log, LODE_MODE_FAULT, LODE_CHECK_LOST_LOCK)); // still the same one
    TEST_ASSERT_EQUAL_UINT(0u, lode_fault_log_count(&log));
}

static void test_wrong_arguments_are_refused(void) {
    lode_fault_log_t log = {.total = 7u};
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_fault_log_init(NULL, buffer, 1u, 1u));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_fault_log_init(&log, NULL, 1u, 1u));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_BUFFER, lode_fault_log_init(&log, buffer, 0u, 1u));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_BUFFER, lode_fault_log_init(&log, buffer, 1u, 0u));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_BUFFER, lode_fault_log_init(&log, buffer, 1001u, 1u));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_BUFFER, lode_fault_log_init(&log, buffer, 1u, 1001u));
    TEST_ASSERT_EQUAL_UINT(7u, log.total);
}

static void test_as_many_as_a_thousand(void) {
    static lode_telemetry_t many[LODE_FAULT_LOG_ROWS(1u, 1000u)];
    lode_fault_log_t log;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_fault_log_init(&log, many, 1000u, 1u));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_fault_log_init(&log, many, 1u, 1000u));
    steps = 0u;
    runs(&log, 1500);
    faults(&log, LODE_CHECK_START);
    TEST_ASSERT_EQUAL_UINT(1501u - 999u, lode_fault_log_row(&log, 0u, 999u)->steps);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_fault_has_its_row_and_those_before);
    RUN_TEST(test_rows_that_nobody_saw_are_not_there);
    RUN_TEST(test_the_last_ones_are_kept);
    RUN_TEST(test_a_fault_may_get_a_better_name);
    RUN_TEST(test_a_fault_behind_a_fault_is_another_one);
    RUN_TEST(test_one_row_is_enough);
    RUN_TEST(test_erased_it_is_empty);
    RUN_TEST(test_wrong_arguments_are_refused);
    RUN_TEST(test_as_many_as_a_thousand);
    return UNITY_END();
}
