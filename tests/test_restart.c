// After a fault: which are tried again, when, and how often.
#include "support/rig.h"

#include "lodestar/restart.h"

void setUp(void) {}

void tearDown(void) {}

#define STEP_s 0.1f

static const lode_restart_config_t config = {.again = LODE_RESTART_AFTER(LODE_CHECK_LOST_LOCK) |
                                                      LODE_RESTART_AFTER(LODE_CHECK_MEMORY),
                                             .attempts = 2u,
                                             .wait_s = 0.35f,
                                             .good_s = 1.0f};
static const lode_command_t run = {.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f};
static const lode_command_t clear = {.mode = LODE_MODE_OFF, .clear_fault = true};

static lode_command_t step(lode_restart_t *self, lode_mode_t mode, lode_check_t check) {
    const lode_telemetry_t now = {.mode = mode, .fault = {.check = (uint_least8_t)check}};
    return lode_restart_step(self, &config, &now, run, STEP_s);
}

/// Steps in FAULT until it is cleared, itself among them; 0: it is not.
static int steps_to_attempt(lode_restart_t *self, lode_check_t check) {
    for (int n = 1; n <= 100; n++) {
        const lode_command_t command = step(self, LODE_MODE_FAULT, check);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, command.mode);
        if (command.clear_fault) {
            return n;
        }
    }
    return 0;
}

static void test_attempts_come_after_the_wait_and_end(void) {
    lode_restart_t restart;
    lode_restart_begin(&restart, 0u);
    for (uint32_t n = 1; n <= 2u; n++) {
        TEST_ASSERT_EQUAL_INT(4, steps_to_attempt(&restart, LODE_CHECK_LOST_LOCK));
        TEST_ASSERT_EQUAL_UINT(n, restart.count);
        const lode_command_t next = step(&restart, LODE_MODE_OFF, LODE_CHECK_NONE);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, next.mode);
        TEST_ASSERT_TRUE(next.speed_rad_s == run.speed_rad_s);
    }
    TEST_ASSERT_EQUAL_INT(0, steps_to_attempt(&restart, LODE_CHECK_LOST_LOCK));
}

static void test_other_faults_stay(void) {
    for (int check = LODE_CHECK_NONE + 1; check < LODE_CHECK_COUNT; check++) {
        lode_restart_t restart;
        lode_restart_begin(&restart, 0u);
        const bool again = check == LODE_CHECK_LOST_LOCK || check == LODE_CHECK_MEMORY;
        TEST_ASSERT_EQUAL_INT(again ? 4 : 0, steps_to_attempt(&restart, (lode_check_t)check));
    }
}

static void test_the_count_is_kept_over_a_reset(void) {
    lode_restart_t restart;
    lode_restart_begin(&restart, 1u);
    TEST_ASSERT_EQUAL_INT(4, steps_to_attempt(&restart, LODE_CHECK_MEMORY));
    TEST_ASSERT_EQUAL_INT(0, steps_to_attempt(&restart, LODE_CHECK_MEMORY));
    lode_restart_begin(&restart, 200u);
    TEST_ASSERT_EQUAL_INT(0, steps_to_attempt(&restart, LODE_CHECK_MEMORY));
}

static void test_a_good_run_begins_at_0(void) {
    lode_restart_t restart;
    lode_restart_begin(&restart, 2u);
    for (int n = 0; n < 9; n++) {
        (void)step(&restart, LODE_MODE_RUN, LODE_CHECK_NONE);
    }
    TEST_ASSERT_EQUAL_UINT(2u, restart.count);
    (void)step(&restart, LODE_MODE_START, LODE_CHECK_NONE); // in a row
    for (int n = 0; n < 9; n++) {
        (void)step(&restart, LODE_MODE_RUN, LODE_CHECK_NONE);
    }
    TEST_ASSERT_EQUAL_UINT(2u, restart.count);
    for (int n = 0; n < 3; n++) {
        (void)step(&restart, LODE_MODE_RUN, LODE_CHECK_NONE);
    }
    TEST_ASSERT_EQUAL_UINT(0u, restart.count);
}

static void test_off_is_off_and_a_clear_begins_at_0(void) {
    const lode_telemetry_t fault = {.mode = LODE_MODE_FAULT,
                                    .fault = {.check = (uint_least8_t)LODE_CHECK_LOST_LOCK}};
    const lode_command_t off = {.mode = LODE_MODE_OFF};
    lode_restart_t restart;
    lode_restart_begin(&restart, 2u);
    for (int n = 0; n < 10; n++) {
        const lode_command_t command = lode_restart_step(&restart, &config, &fault, off, STEP_s);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, command.mode);
        TEST_ASSERT_FALSE(command.clear_fault);
    }
    TEST_ASSERT_EQUAL_UINT(2u, restart.count);
    TEST_ASSERT_TRUE(lode_restart_step(&restart, &config, &fault, clear, STEP_s).clear_fault);
    TEST_ASSERT_EQUAL_UINT(0u, restart.count);
}

/// With a drive: the rotor is stopped for a tenth of a second.
static void test_a_drive_runs_again(void) {
    static lode_drive_tuning_t tuning;
    const lode_drive_config_t drive = rig_config();
    rig_t rig;
    rig_init(&rig, &tuning, &drive);
    lode_restart_t restart;
    lode_restart_begin(&restart, 0u);
    rig_command(&rig, run);
    rig_run(&rig, 3.0);
    rig_expect(&rig, LODE_MODE_RUN);
    rig.motor.theta += 0.7 * CHECK_PI;
    rig.motor.omega = 0.0;
    rig.blocked = true;
    rig_run(&rig, 0.1);
    rig_expect(&rig, LODE_MODE_FAULT);
    rig.blocked = false;
    lode_restart_config_t every = config;
    every.again = UINT32_MAX;
    for (int n = 0; n < 40; n++) {
        const lode_telemetry_t now = rig_telemetry(&rig);
        rig_command(&rig, lode_restart_step(&restart, &every, &now, run, STEP_s));
        rig_run(&rig, (double)STEP_s);
    }
    rig_expect(&rig, LODE_MODE_RUN);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_attempts_come_after_the_wait_and_end);
    RUN_TEST(test_other_faults_stay);
    RUN_TEST(test_the_count_is_kept_over_a_reset);
    RUN_TEST(test_a_good_run_begins_at_0);
    RUN_TEST(test_off_is_off_and_a_clear_begins_at_0);
    RUN_TEST(test_a_drive_runs_again);
    return UNITY_END();
}
