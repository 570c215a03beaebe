// The template with the example on top: it has every function of a board, and a board that is not filled
// in never starts.
#include "app.h"
#include "board.h"
#include "support/check.h"

#define TRIP_A 15.0f

void setUp(void) {}

void tearDown(void) {}

static void test_configuration_is_accepted_and_the_board_does_not_come_up(void) {
    TEST_ASSERT_FALSE(app_start());
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(app_status()));
}

static void test_every_function_of_a_board_is_there(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    lode_counts_t counts = {.trip = true};
    static const uint16_t octet[] = {0u};
    board_describe(&config);
    TEST_ASSERT_TRUE(config.f_pwm_Hz > 0.0f);
    TEST_ASSERT_FALSE(board_reset_by_watchdog());
    TEST_ASSERT_FALSE(board_init(TRIP_A));
    board_start();
    board_read(&counts);
    board_write(&(lode_drive_out_t){.gates = false});
    board_gates_off();
    TEST_ASSERT_FALSE(board_clear_trip());
    TEST_ASSERT_FALSE(board_test_trip());
    board_feed_watchdog();
    TEST_ASSERT_EQUAL_UINT32(0u, board_cycles());
    TEST_ASSERT_EQUAL_UINT32(0u, board_send(octet, 1u));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_configuration_is_accepted_and_the_board_does_not_come_up);
    RUN_TEST(test_every_function_of_a_board_is_there);
    return UNITY_END();
}
