/// What every port shows of one call or two in a period. Included once, by the test of a chip, behind its fake; that test
/// has next_turn(), to the next turning point of its timer, next_call(), change_compare(), which changes the lowest
/// bit of the compare register of phase 0 .. 2, and TRIP_A.
#ifndef CALLS_CASES_H
#define CALLS_CASES_H

#include "board.h"
#include "support/check.h"

/// All places of an edge, and neither, from one call to the next.
static const lode_abc_t duty_of_call[] = {{0.0f, 0.5f, 1.0f}, {1.0f, 0.25f, 0.0f},
                                          {0.9f, 0.1f, 0.3f}, {0.2f, 0.8f, 0.7f},
                                          {1.0f, 0.0f, 0.5f}, {0.0f, 1.0f, 0.5f}};

static bool trip_now(void) {
    lode_counts_t counts;
    board_read(&counts);
    return counts.trip;
}

static bool trip_in_next_call(void) {
    next_call();
    return trip_now();
}

// One call: it comes half a period late, or the trigger sits at the wrong end. Two: one of either half is missing, or
// late by a half.
static void test_sample_at_the_wrong_end_is_a_trip(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    for (int half = 0; half < 2; half++) {
        for (int n = 0; n < 4; n++) {
            next_call();
            TEST_ASSERT_FALSE(trip_now());
        }
        (void)next_turn();
        if (VARIANT_DOUBLE_UPDATE) {
            (void)next_turn();
        }
        TEST_ASSERT_TRUE(trip_now());
        if (VARIANT_DOUBLE_UPDATE) {
            next_call();
            TEST_ASSERT_FALSE(trip_now()); // in step again, now in the other half
        }
    }
}

// A register that does not take a value, or that something else writes.
static void test_compare_value_that_does_not_stay_is_a_trip(void) {
    TEST_ASSERT_TRUE(board_init(TRIP_A));
    board_start();
    TEST_ASSERT_FALSE(trip_in_next_call());
    for (int x = 0; x < 3; x++) {
        board_write(&(lode_drive_out_t){.duty = duty_of_call[2], .gates = LODE_GATES_ON});
        TEST_ASSERT_FALSE(trip_in_next_call());
        change_compare(x);
        TEST_ASSERT_TRUE(trip_in_next_call());
        board_write(&(lode_drive_out_t){.duty = duty_of_call[3], .gates = LODE_GATES_OFF});
        TEST_ASSERT_FALSE(trip_in_next_call());
    }
}

#endif
