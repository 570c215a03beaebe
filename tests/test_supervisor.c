// After a fault: which are tried again, when, and how often.
#include "support/rig.h"

#include "lodestar/fault_log.h"
#include "lodestar/supervisor.h"

void setUp(void) {}

void tearDown(void) {}

#define STEP_s 0.1f

static const lode_supervisor_config_t config = {
    .reaction = {[LODE_CHECK_LOST_LOCK] = LODE_REACTION_AGAIN,
                 [LODE_CHECK_MEMORY] = LODE_REACTION_AGAIN,
                 [LODE_CHECK_UNDER_VOLTAGE] = LODE_REACTION_RIDE_THROUGH},
    .attempts = 2u,
    .wait_s = 0.35f,
    .good_s = 1.0f};
static const lode_command_t run = {.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f};
static const lode_command_t off = {.mode = LODE_MODE_OFF};
static const lode_command_t clear = {.mode = LODE_MODE_OFF, .clear_fault = true};

static const lode_drive_tuning_t tuning = {.guard = {.v_bus_min = 100.0f,
                                                     .v_bus_max = 200.0f,
                                                     .temperature_min = -20.0f,
                                                     .temperature_max = 90.0f}};
static lode_attempts_t attempts;

static lode_supervisor_t supervisor_with(uint32_t count) {
    lode_supervisor_t self;
    attempts = (lode_attempts_t){.count = 0u};
    for (uint32_t n = 0u; n < count; n++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK,
                              lode_supervisor_init(&self, &config, &tuning, &attempts, true));
    }
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supervisor_init(&self, &config, &tuning, &attempts, false));
    TEST_ASSERT_EQUAL_UINT(count, attempts.count);
    return self;
}

static uint32_t periods;

static lode_telemetry_t seen(lode_mode_t mode, lode_check_t check) {
    return (lode_telemetry_t){.steps = ++periods,
                              .mode = mode,
                              .fault = {.check = (uint_least8_t)check},
                              .v_bus_V = 150.0f,
                              .temperature_degC = 40.0f};
}

static lode_command_t step(lode_supervisor_t *self, lode_mode_t mode, lode_check_t check) {
    const lode_telemetry_t now = seen(mode, check);
    return lode_supervisor_step(self, &now, run, STEP_s);
}

static void runs(lode_supervisor_t *self, int steps) {
    for (int n = 0; n < steps; n++) {
        TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, step(self, LODE_MODE_RUN, LODE_CHECK_NONE).mode);
    }
}

/// Steps in FAULT until it is cleared, itself among them; 0: it is not.
static int steps_to_attempt(lode_supervisor_t *self, lode_check_t check) {
    for (int n = 1; n <= 100; n++) {
        const lode_command_t command = step(self, LODE_MODE_FAULT, check);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, command.mode);
        if (command.clear_fault) {
            return n;
        }
    }
    const lode_telemetry_t now = seen(LODE_MODE_FAULT, check);
    TEST_ASSERT_TRUE(lode_supervisor_is_latched(self, &now));
    return 0;
}

static void test_attempts_come_after_the_wait_and_end(void) {
    lode_supervisor_t self = supervisor_with(0u);
    for (uint32_t n = 1; n <= 2u; n++) {
        runs(&self, 8); // the time in RUN is not that of the fault
        TEST_ASSERT_EQUAL_INT(5, steps_to_attempt(&self, LODE_CHECK_LOST_LOCK));
        TEST_ASSERT_EQUAL_UINT(n, attempts.count);
        const lode_command_t next = step(&self, LODE_MODE_OFF, LODE_CHECK_NONE);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, next.mode);
        TEST_ASSERT_TRUE(next.speed_rad_s == run.speed_rad_s);
    }
    TEST_ASSERT_EQUAL_INT(0, steps_to_attempt(&self, LODE_CHECK_LOST_LOCK));
}

/// An attempt comes as soon as the wait is over, and the next fault's wait is as long.
static void test_the_wait_ends_with_its_time(void) {
    lode_supervisor_config_t binary = config; // times that floats add up exactly
    binary.wait_s = 0.5f;
    lode_supervisor_t self;
    attempts = (lode_attempts_t){.count = 0u};
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supervisor_init(&self, &binary, &tuning, &attempts, false));
    for (int n = 0; n <= 4; n++) {
        const lode_telemetry_t now = seen(LODE_MODE_FAULT, LODE_CHECK_LOST_LOCK);
        TEST_ASSERT_EQUAL_INT(n == 4, lode_supervisor_step(&self, &now, run, 0.125f).clear_fault);
    }
}

/// Somebody wants OFF while a fault is waited for, and RUN again: the wait begins anew.
static void test_off_ends_the_wait(void) {
    lode_supervisor_t self = supervisor_with(0u);
    for (int n = 0; n < 3; n++) {
        TEST_ASSERT_FALSE(step(&self, LODE_MODE_FAULT, LODE_CHECK_LOST_LOCK).clear_fault);
    }
    const lode_telemetry_t now = seen(LODE_MODE_FAULT, LODE_CHECK_LOST_LOCK);
    (void)lode_supervisor_step(&self, &now, off, STEP_s);
    TEST_ASSERT_EQUAL_INT(5, steps_to_attempt(&self, LODE_CHECK_LOST_LOCK));
}

/// The command is taken a period later: until then the fault is still seen.
static void test_a_fault_that_is_not_cleared_is_another_attempt(void) {
    lode_supervisor_t self = supervisor_with(0u);
    TEST_ASSERT_EQUAL_INT(5, steps_to_attempt(&self, LODE_CHECK_LOST_LOCK));
    TEST_ASSERT_EQUAL_INT(5, steps_to_attempt(&self, LODE_CHECK_LOST_LOCK));
    TEST_ASSERT_EQUAL_INT(0, steps_to_attempt(&self, LODE_CHECK_LOST_LOCK));
}

/// A main loop may look again before the interrupt has taken the command.
static void test_an_attempt_counts_once_until_it_is_taken(void) {
    lode_supervisor_t self = supervisor_with(0u);
    lode_telemetry_t now = seen(LODE_MODE_FAULT, LODE_CHECK_UNDER_VOLTAGE);
    for (int n = 0; n < 5; n++) {
        TEST_ASSERT_TRUE(lode_supervisor_step(&self, &now, run, STEP_s).clear_fault);
    }
    TEST_ASSERT_EQUAL_UINT(1u, attempts.count);
    now.steps++;
    TEST_ASSERT_TRUE(lode_supervisor_step(&self, &now, run, STEP_s).clear_fault);
    TEST_ASSERT_EQUAL_UINT(2u, attempts.count);
}

static void test_other_faults_stay(void) {
    for (int check = LODE_CHECK_NONE + 1; check <= LODE_CHECK_COUNT; check++) {
        lode_supervisor_t self = supervisor_with(0u);
        const bool again = check == LODE_CHECK_LOST_LOCK || check == LODE_CHECK_MEMORY;
        const bool rides = check == LODE_CHECK_UNDER_VOLTAGE;
        TEST_ASSERT_EQUAL_INT(again ? 5 : (rides ? 1 : 0),
                              steps_to_attempt(&self, (lode_check_t)check));
    }
}

static void test_nothing_configured_is_a_fault_that_stays(void) {
    const lode_supervisor_config_t nothing = {.attempts = 0u};
    for (int check = LODE_CHECK_NONE + 1; check < LODE_CHECK_COUNT; check++) {
        lode_supervisor_t self;
        attempts = (lode_attempts_t){.count = 0u};
        TEST_ASSERT_EQUAL_INT(LODE_OK,
                              lode_supervisor_init(&self, &nothing, &tuning, &attempts, false));
        TEST_ASSERT_EQUAL_INT(0, steps_to_attempt(&self, (lode_check_t)check));
    }
}

static void test_it_rides_through_until_bus_and_temperature_are_good(void) {
    static const float bad[][2] = {{99.0f, 40.0f},   {201.0f, 40.0f}, {NAN, 40.0f},
                                   {150.0f, -21.0f}, {150.0f, 91.0f}, {150.0f, NAN}};
    lode_supervisor_t self = supervisor_with(0u);
    lode_telemetry_t now = seen(LODE_MODE_FAULT, LODE_CHECK_UNDER_VOLTAGE);
    for (uint32_t n = 0u; n < sizeof bad / sizeof bad[0]; n++) {
        now.v_bus_V = bad[n][0];
        now.temperature_degC = bad[n][1];
        now.steps++;
        TEST_ASSERT_FALSE(lode_supervisor_step(&self, &now, run, 1.0f).clear_fault);
        TEST_ASSERT_FALSE(lode_supervisor_is_latched(&self, &now));
    }
    TEST_ASSERT_EQUAL_INT(1, steps_to_attempt(&self, LODE_CHECK_UNDER_VOLTAGE));
    TEST_ASSERT_EQUAL_UINT(1u, attempts.count);
}

static void test_the_count_is_kept_over_a_reset(void) {
    lode_supervisor_t self = supervisor_with(1u);
    TEST_ASSERT_EQUAL_INT(5, steps_to_attempt(&self, LODE_CHECK_MEMORY));
    TEST_ASSERT_EQUAL_INT(0, steps_to_attempt(&self, LODE_CHECK_MEMORY));
    self = supervisor_with(200u);
    TEST_ASSERT_EQUAL_INT(0, steps_to_attempt(&self, LODE_CHECK_MEMORY));
}

/// What a power-up leaves in memory is no count, and one that is as large as can be stays so.
static void test_memory_that_was_not_kept_counts_nothing(void) {
    static const uint32_t left[][2] = {
        {0u, 0u}, {UINT32_MAX, UINT32_MAX}, {2u, 0u}, {0xDEADBEEFu, 0xDEADBEEFu}, {1u, 2u}};
    lode_supervisor_t self;
    for (uint32_t n = 0u; n < sizeof left / sizeof left[0]; n++) {
        attempts = (lode_attempts_t){left[n][0], left[n][1]};
        TEST_ASSERT_EQUAL_INT(LODE_OK,
                              lode_supervisor_init(&self, &config, &tuning, &attempts, false));
        TEST_ASSERT_EQUAL_UINT(0u, attempts.count);
    }
    const uint32_t check_of_0 = attempts.check;
    attempts = (lode_attempts_t){UINT32_MAX, check_of_0 ^ UINT32_MAX};
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supervisor_init(&self, &config, &tuning, &attempts, true));
    TEST_ASSERT_EQUAL_UINT(UINT32_MAX, attempts.count);
    attempts.count = 7u; // flipped while it runs: begins anew, rather than with any number
    TEST_ASSERT_EQUAL_INT(5, steps_to_attempt(&self, LODE_CHECK_MEMORY));
    TEST_ASSERT_EQUAL_UINT(1u, attempts.count);
}

/// A reset by the watchdog is an attempt too: after too many of them nothing starts before somebody clears.
static void test_resets_use_up_the_attempts(void) {
    const lode_telemetry_t idle = seen(LODE_MODE_OFF, LODE_CHECK_NONE);
    lode_supervisor_t self = supervisor_with(2u);
    TEST_ASSERT_FALSE(lode_supervisor_is_latched(&self, &idle));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, step(&self, LODE_MODE_OFF, LODE_CHECK_NONE).mode);
    self = supervisor_with(3u);
    TEST_ASSERT_TRUE(lode_supervisor_is_latched(&self, &idle));
    const lode_command_t held = step(&self, LODE_MODE_OFF, LODE_CHECK_NONE);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, held.mode);
    TEST_ASSERT_FALSE(held.clear_fault);
    TEST_ASSERT_TRUE(lode_supervisor_step(&self, &idle, clear, STEP_s).clear_fault);
    TEST_ASSERT_FALSE(lode_supervisor_is_latched(&self, &idle));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, step(&self, LODE_MODE_OFF, LODE_CHECK_NONE).mode);
}

static void test_a_good_run_begins_at_0(void) {
    lode_supervisor_t self = supervisor_with(2u);
    runs(&self, 9);
    TEST_ASSERT_EQUAL_UINT(2u, attempts.count);
    (void)step(&self, LODE_MODE_START, LODE_CHECK_NONE); // in a row
    runs(&self, 9);
    TEST_ASSERT_EQUAL_UINT(2u, attempts.count);
    const lode_telemetry_t still = seen(LODE_MODE_RUN, LODE_CHECK_NONE);
    (void)lode_supervisor_step(&self, &still, off, STEP_s); // it runs still, but is told not to
    runs(&self, 9);
    TEST_ASSERT_EQUAL_UINT(2u, attempts.count);
    runs(&self, 3);
    TEST_ASSERT_EQUAL_UINT(0u, attempts.count);
}

/// The time in FAULT is no time in RUN, where somebody else has cleared it between two steps.
static void test_a_fault_is_no_good_run(void) {
    lode_supervisor_t self = supervisor_with(2u);
    for (int n = 0; n < 20; n++) {
        (void)step(&self, LODE_MODE_FAULT, LODE_CHECK_LOST_LOCK);
    }
    runs(&self, 9);
    TEST_ASSERT_EQUAL_UINT(2u, attempts.count);
    runs(&self, 3);
    TEST_ASSERT_EQUAL_UINT(0u, attempts.count);
}

/// Ten seconds' good run are good at ten.
static void test_a_run_is_good_with_its_time(void) {
    lode_supervisor_t self = supervisor_with(2u);
    for (int n = 1; n <= 8; n++) { // floats add up eighths exactly
        const lode_telemetry_t now = seen(LODE_MODE_RUN, LODE_CHECK_NONE);
        TEST_ASSERT_EQUAL_UINT(2u, attempts.count);
        (void)lode_supervisor_step(&self, &now, run, 0.125f);
    }
    TEST_ASSERT_EQUAL_UINT(0u, attempts.count);
}

static void test_off_is_off_and_a_clear_begins_at_0(void) {
    const lode_telemetry_t fault = seen(LODE_MODE_FAULT, LODE_CHECK_LOST_LOCK);
    lode_supervisor_t self = supervisor_with(2u);
    for (int n = 0; n < 10; n++) {
        const lode_command_t command = lode_supervisor_step(&self, &fault, off, STEP_s);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, command.mode);
        TEST_ASSERT_FALSE(command.clear_fault);
    }
    TEST_ASSERT_EQUAL_UINT(2u, attempts.count);
    TEST_ASSERT_TRUE(lode_supervisor_step(&self, &fault, clear, STEP_s).clear_fault);
    TEST_ASSERT_EQUAL_UINT(0u, attempts.count);
}

static void test_what_is_left_open_is_1_s_and_10_s(void) {
    const lode_supervisor_config_t open = {.reaction = {[LODE_CHECK_START] = LODE_REACTION_AGAIN},
                                           .attempts = 1u};
    lode_supervisor_t self;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supervisor_init(&self, &open, &tuning, &attempts, false));
    TEST_ASSERT_TRUE(self.wait_s == 1.0f);
    TEST_ASSERT_TRUE(self.good_s == 10.0f);
}

static lode_status_t init_with(lode_reaction_t reaction, float wait_s, float good_s) {
    lode_supervisor_config_t wrong = config;
    wrong.reaction[LODE_CHECK_START] = reaction;
    wrong.wait_s = wait_s;
    wrong.good_s = good_s;
    lode_supervisor_t self = {.time_s = 7.0f};
    attempts = (lode_attempts_t){.count = 7u};
    const lode_status_t status = lode_supervisor_init(&self, &wrong, &tuning, &attempts, true);
    TEST_ASSERT_EQUAL_UINT(status == LODE_OK ? 1u : 7u, attempts.count);
    TEST_ASSERT_TRUE(self.time_s == (status == LODE_OK ? 0.0f : 7.0f));
    return status;
}

static void test_wrong_configurations_are_refused(void) {
    const lode_reaction_t none = (lode_reaction_t)(LODE_REACTION_RIDE_THROUGH + 1);
    TEST_ASSERT_EQUAL_INT(LODE_OK, init_with(LODE_REACTION_LATCH, 1.0e-3f, 1.0e-3f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, init_with(LODE_REACTION_RIDE_THROUGH, 1.0e4f, 1.0e5f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPERVISOR, init_with(none, 1.0f, 1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPERVISOR, init_with(LODE_REACTION_AGAIN, 0.9e-3f, 1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPERVISOR, init_with(LODE_REACTION_AGAIN, 1.1e4f, 1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPERVISOR, init_with(LODE_REACTION_AGAIN, NAN, 1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPERVISOR, init_with(LODE_REACTION_AGAIN, 1.0f, -1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPERVISOR, init_with(LODE_REACTION_AGAIN, 1.0f, 1.1e5f));
    lode_supervisor_t self;
    for (int check = 0; check < LODE_CHECK_COUNT; check++) {
        lode_supervisor_config_t wrong = config;
        wrong.reaction[check] = none;
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPERVISOR,
                              lode_supervisor_init(&self, &wrong, &tuning, &attempts, false));
    }
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL,
                          lode_supervisor_init(NULL, &config, &tuning, &attempts, false));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL,
                          lode_supervisor_init(&self, NULL, &tuning, &attempts, false));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL,
                          lode_supervisor_init(&self, &config, NULL, &attempts, false));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL,
                          lode_supervisor_init(&self, &config, &tuning, NULL, false));
}

// ---- Active short -------------------------------------------------------------------------------

// psi/Ld is 50 A; 0.1 Wb reach 150 V between the lines at 866 rad/s.
static lode_drive_tuning_t shortable(void) {
    lode_drive_tuning_t motor = tuning;
    motor.references.psi_Wb = 0.1f;
    motor.references.Ld_H = 2.0e-3f;
    motor.references.i_max_A = 60.0f;
    motor.guard.bus_periods = 5u;
    motor.estimator.pll.ts_s = 1.0e-4f;
    return motor;
}

static const lode_supervisor_config_t shorting = {
    .reaction = {[LODE_CHECK_START] = LODE_REACTION_AGAIN},
    .attempts = 1u,
    .wait_s = 0.35f,
    .active_short = LODE_ON};

static lode_command_t shorts_step(lode_supervisor_t *self, lode_mode_t mode, lode_check_t check,
                                  float omega_rad_s, lode_command_t wanted) {
    lode_telemetry_t now = seen(mode, check);
    now.omega_rad_s = omega_rad_s;
    now.fault.measured = omega_rad_s; // of a shorted switch
    return lode_supervisor_step(self, &now, wanted, STEP_s);
}

/// Whether a fault would short the motor that has run at these speeds.
static bool would_short(lode_supervisor_t *self, float omega_rad_s) {
    return shorts_step(self, LODE_MODE_RUN, LODE_CHECK_NONE, omega_rad_s, run).active_short;
}

static lode_supervisor_t shorter(const lode_drive_tuning_t *motor) {
    lode_supervisor_t self;
    attempts = (lode_attempts_t){.count = 0u};
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supervisor_init(&self, &shorting, motor, &attempts, false));
    return self;
}

static void test_it_shorts_where_the_emf_is_above_the_bus(void) {
    const lode_drive_tuning_t motor = shortable();
    lode_supervisor_t self = shorter(&motor);
    TEST_ASSERT_FALSE(would_short(&self, 860.0f));
    TEST_ASSERT_TRUE(would_short(&self, 870.0f));
    TEST_ASSERT_TRUE(would_short(&self, -785.0f)); // a tenth less
    TEST_ASSERT_FALSE(would_short(&self, -770.0f));
    TEST_ASSERT_FALSE(would_short(&self, 860.0f));
    TEST_ASSERT_TRUE(would_short(&self, -870.0f));
    // With the gates off nobody knows the speed: it stays as it was.
    TEST_ASSERT_TRUE(shorts_step(&self, LODE_MODE_OFF, LODE_CHECK_NONE, 0.0f, run).active_short);
    // OFF is somebody's, and no fault.
    TEST_ASSERT_FALSE(shorts_step(&self, LODE_MODE_OFF, LODE_CHECK_NONE, 0.0f, off).active_short);
    lode_command_t given = run;
    given.active_short = true;
    TEST_ASSERT_FALSE(would_short(&self, 0.0f));
    TEST_ASSERT_TRUE(shorts_step(&self, LODE_MODE_RUN, LODE_CHECK_NONE, 0.0f, given).active_short);
    given.mode = LODE_MODE_OFF;
    TEST_ASSERT_TRUE(shorts_step(&self, LODE_MODE_OFF, LODE_CHECK_NONE, 0.0f, given).active_short);
}

/// Behind a fault that was cleared between two calls comes another one, with a look of its own.
static void test_another_fault_is_looked_at_anew(void) {
    const lode_drive_tuning_t motor = shortable();
    lode_supervisor_t self = shorter(&motor);
    TEST_ASSERT_TRUE(would_short(&self, 900.0f));
    const lode_telemetry_t first = {.steps = 1000u,
                                    .mode = LODE_MODE_FAULT,
                                    .trips = 1u,
                                    .fault = {.check = (uint_least8_t)LODE_CHECK_OVER_CURRENT},
                                    .omega_rad_s = 900.0f};
    TEST_ASSERT_FALSE(lode_supervisor_step(&self, &first, off, STEP_s).active_short);
    lode_telemetry_t later = first;
    later.steps = 1500u;
    lode_supervisor_t same = self;
    TEST_ASSERT_TRUE(lode_supervisor_step(&same, &later, off, STEP_s).active_short);
    later.trips = 2u;
    TEST_ASSERT_FALSE(lode_supervisor_step(&self, &later, off, STEP_s).active_short);
}

/// Where the speed is not known, the look takes as long as for the slowest rotor with so much EMF.
static void test_the_look_ends_at_any_speed(void) {
    const lode_drive_tuning_t motor = shortable();
    const double least = 150.0 / (sqrt(3.0) * 0.1);
    const int half_turn = (int)(CHECK_PI / (least * (double)motor.estimator.pll.ts_s));
    lode_supervisor_t self = shorter(&motor);
    TEST_ASSERT_TRUE(would_short(&self, 900.0f));
    for (int n = 0; n <= 5 * (9 + half_turn); n++) {
        TEST_ASSERT_FALSE(
            shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_OVER_CURRENT, 0.0f, run).active_short);
    }
    TEST_ASSERT_TRUE(
        shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_OVER_CURRENT, 0.0f, run).active_short);
}

/// A rotor that a vector turns charges no bus.
static void test_it_does_not_short_a_start_from_rest(void) {
    const lode_drive_tuning_t motor = shortable();
    for (int n = 0; n < 4; n++) {
        lode_supervisor_t self = shorter(&motor);
        TEST_ASSERT_TRUE(would_short(&self, 900.0f));
        if (n == 0) { // OFF for a moment: it may coast as fast
            (void)shorts_step(&self, LODE_MODE_OFF, LODE_CHECK_NONE, 0.0f, off);
        }
        lode_telemetry_t now = seen(LODE_MODE_START, LODE_CHECK_NONE);
        now.start_stage = n == 3 ? LODE_START_HALF : LODE_START_CATCH;
        const lode_command_t command = lode_supervisor_step(&self, &now, run, STEP_s);
        TEST_ASSERT_EQUAL_INT(n != 3, command.active_short);
    }
}

/// Adding the milliseconds of many hours in one float would stop at 9 hours.
static void test_a_day_is_counted(void) {
    lode_supervisor_t self = supervisor_with(1u);
    self.good_s = 86400.0f;
    self.time_s = 60000.0f;
    self.waits = false;
    const lode_telemetry_t now = seen(LODE_MODE_RUN, LODE_CHECK_NONE);
    for (int n = 0; n < 100000; n++) {
        (void)lode_supervisor_step(&self, &now, run, 1.0e-3f);
    }
    TEST_ASSERT_FLOAT_WITHIN(0.1f, 60100.0f, self.time_s);
}

static void test_it_shorts_nothing_unless_told(void) {
    const lode_drive_tuning_t motor = shortable();
    lode_supervisor_t self;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supervisor_init(&self, &config, &motor, &attempts, false));
    TEST_ASSERT_FALSE(would_short(&self, 5000.0f));
    TEST_ASSERT_FALSE(
        shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_SWITCH_SHORTED, -70.0f, run).active_short);
}

static void test_it_shorts_until_it_starts_again(void) {
    const lode_drive_tuning_t motor = shortable();
    lode_supervisor_t self = shorter(&motor);
    TEST_ASSERT_TRUE(would_short(&self, 900.0f));
    for (int n = 0; n < 4; n++) {
        const lode_command_t command =
            shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_START, 900.0f, run);
        TEST_ASSERT_EQUAL_INT(LODE_MODE_OFF, command.mode);
        TEST_ASSERT_TRUE(command.active_short && !command.clear_fault);
    }
    // Somebody wants OFF: the fault stays, and so does the short.
    TEST_ASSERT_TRUE(
        shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_START, 900.0f, off).active_short);
    int n = 0;
    lode_command_t command = run;
    do {
        command = shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_START, 900.0f, run);
    } while (!command.clear_fault && ++n < 100);
    TEST_ASSERT_TRUE(command.clear_fault && !command.active_short);
}

/// Behind these may be a shorted switch.
static void test_after_a_trip_it_looks_first(void) {
    const lode_drive_tuning_t motor = shortable();
    lode_supervisor_t self = shorter(&motor);
    TEST_ASSERT_TRUE(would_short(&self, 900.0f));
    // A look takes 9 periods and half a turn, five times that at most.
    const int half_turn = (int)(CHECK_PI / (900.0 * (double)motor.estimator.pll.ts_s));
    for (int n = 0; n <= 5 * (9 + half_turn); n++) { // a period each
        TEST_ASSERT_FALSE(
            shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_OVER_CURRENT, 900.0f, n < 5 ? run : off)
                .active_short);
    }
    TEST_ASSERT_TRUE(
        shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_OVER_CURRENT, 900.0f, run).active_short);
    TEST_ASSERT_FALSE(
        shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_HARDWARE_TRIP, 900.0f, run).active_short);
    // A low side that is shorted is joined by the others; a high side is not, at any speed.
    TEST_ASSERT_TRUE(
        shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_SWITCH_SHORTED, -70.0f, run).active_short);
    static const float high[] = {70.0f, 0.5f, 0.0f};
    for (int n = 0; n < COUNT_OF(high); n++) {
        TEST_ASSERT_FALSE(
            shorts_step(&self, LODE_MODE_FAULT, LODE_CHECK_SWITCH_SHORTED, high[n], run)
                .active_short);
    }
}

static void test_a_short_of_more_than_the_largest_current_is_refused(void) {
    lode_drive_tuning_t motor = shortable();
    lode_supervisor_t self;
    motor.references.i_max_A = 50.1f;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_supervisor_init(&self, &shorting, &motor, &attempts, false));
    motor.references.psi_Wb = motor.references.Ld_H * motor.references.i_max_A; // just as much
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_supervisor_init(&self, &shorting, &motor, &attempts, false));
    motor = shortable();
    motor.references.i_max_A = 49.9f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ACTIVE_SHORT,
                          lode_supervisor_init(&self, &shorting, &motor, &attempts, false));
    lode_supervisor_config_t other = shorting;
    other.active_short = LODE_OFF;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supervisor_init(&self, &other, &motor, &attempts, false));
    other.active_short = (lode_choice_t)(LODE_OFF + 1);
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SUPERVISOR,
                          lode_supervisor_init(&self, &other, &motor, &attempts, false));
}

// ---- With a drive -------------------------------------------------------------------------------

#define LOOP_s 1.0e-3
#define LOG_FAULTS 4u
#define LOG_ROWS 3u

static lode_telemetry_t rows[LODE_FAULT_LOG_ROWS(LOG_FAULTS, LOG_ROWS)];

typedef struct {
    rig_t rig;
    lode_drive_tuning_t tuning;
    lode_supervisor_config_t config;
    lode_supervisor_t supervisor;
    lode_fault_log_t log;
} supervised_t;

static void begin(supervised_t *self, lode_check_t check, lode_reaction_t reaction) {
    const lode_drive_config_t drive = rig_config();
    rig_init(&self->rig, &self->tuning, &drive);
    self->config = (lode_supervisor_config_t){.attempts = 2u, .wait_s = 0.3f, .good_s = 5.0f};
    self->config.reaction[check] = reaction;
    attempts = (lode_attempts_t){.count = 0u};
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_supervisor_init(&self->supervisor, &self->config,
                                                        &self->tuning, &attempts, false));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_fault_log_init(&self->log, rows, LOG_FAULTS, LOG_ROWS));
}

/// The interrupt, and the main loop a thousand times a second.
static void run_supervised(supervised_t *self, double seconds) {
    const int passes = (int)(seconds / LOOP_s + 0.5);
    for (int n = 0; n < passes; n++) {
        const lode_telemetry_t now = rig_telemetry(&self->rig);
        (void)lode_fault_log_step(&self->log, &now);
        rig_command(&self->rig, lode_supervisor_step(&self->supervisor, &now, run, (float)LOOP_s));
        rig_run(&self->rig, LOOP_s);
    }
}

/// The rotor is stopped for a tenth of a second.
static void stop_the_rotor(supervised_t *self) {
    self->rig.motor.theta += 0.7 * CHECK_PI;
    self->rig.motor.omega = 0.0;
    self->rig.blocked = true;
    run_supervised(self, 0.1);
    rig_expect(&self->rig, LODE_MODE_FAULT);
    self->rig.blocked = false;
}

static void expect_speed(const supervised_t *self) {
    rig_expect(&self->rig, LODE_MODE_RUN);
    TEST_ASSERT_FLOAT_WITHIN(2.0f, run.speed_rad_s, (float)self->rig.motor.omega / 3.0f);
}

static void test_a_drive_runs_again(void) {
    static supervised_t self;
    begin(&self, LODE_CHECK_OVERLOAD, LODE_REACTION_AGAIN);
    run_supervised(&self, 3.0);
    expect_speed(&self);
    stop_the_rotor(&self);
    run_supervised(&self, 4.0);
    expect_speed(&self);
    TEST_ASSERT_EQUAL_UINT(1u, attempts.count);
    TEST_ASSERT_EQUAL_UINT(1u, lode_fault_log_count(&self.log));
    const lode_telemetry_t *tripped = lode_fault_log_row(&self.log, 0u, 0u);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVERLOAD, tripped->fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, lode_fault_log_row(&self.log, 0u, 1u)->mode);
    run_supervised(&self, 5.0);
    TEST_ASSERT_EQUAL_UINT(0u, attempts.count); // a good run
}

static void test_a_drive_that_fails_again_and_again_stays_off(void) {
    static supervised_t self;
    begin(&self, LODE_CHECK_OVERLOAD, LODE_REACTION_AGAIN);
    run_supervised(&self, 3.0);
    for (uint32_t n = 0u; n < 2u; n++) {
        stop_the_rotor(&self);
        run_supervised(&self, 2.5);
        rig_expect(&self.rig, LODE_MODE_RUN);
    }
    stop_the_rotor(&self);
    run_supervised(&self, 10.0);
    rig_expect(&self.rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_UINT(2u, attempts.count);
    TEST_ASSERT_EQUAL_UINT(3u, lode_fault_log_count(&self.log));
    rig_command(&self.rig, clear);
    rig_run(&self.rig, LOOP_s);
    rig_expect(&self.rig, LODE_MODE_OFF);
}

/// A bus that sags: off at once, and on as soon as it is back, while the rotor still turns.
static void test_a_drive_rides_through_a_sag(void) {
    static supervised_t self;
    begin(&self, LODE_CHECK_UNDER_VOLTAGE, LODE_REACTION_RIDE_THROUGH);
    run_supervised(&self, 3.0);
    expect_speed(&self);
    self.rig.sag_V = 150.0;
    run_supervised(&self, 0.05);
    rig_expect(&self.rig, LODE_MODE_FAULT);
    run_supervised(&self, 0.3);
    rig_expect(&self.rig, LODE_MODE_FAULT); // the bus is not back yet
    const double coasting_rad_s = self.rig.motor.omega;
    self.rig.sag_V = 0.0;
    run_supervised(&self, 0.1);
    rig_expect(&self.rig, LODE_MODE_RUN); // caught: a start from standstill takes longer
    TEST_ASSERT_TRUE(self.rig.motor.omega > 0.9 * coasting_rad_s);
    run_supervised(&self, 1.0);
    expect_speed(&self);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_UNDER_VOLTAGE,
                          lode_fault_log_row(&self.log, 0u, 0u)->fault.check);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_attempts_come_after_the_wait_and_end);
    RUN_TEST(test_the_wait_ends_with_its_time);
    RUN_TEST(test_off_ends_the_wait);
    RUN_TEST(test_a_fault_that_is_not_cleared_is_another_attempt);
    RUN_TEST(test_an_attempt_counts_once_until_it_is_taken);
    RUN_TEST(test_other_faults_stay);
    RUN_TEST(test_nothing_configured_is_a_fault_that_stays);
    RUN_TEST(test_it_rides_through_until_bus_and_temperature_are_good);
    RUN_TEST(test_the_count_is_kept_over_a_reset);
    RUN_TEST(test_memory_that_was_not_kept_counts_nothing);
    RUN_TEST(test_resets_use_up_the_attempts);
    RUN_TEST(test_a_good_run_begins_at_0);
    RUN_TEST(test_a_fault_is_no_good_run);
    RUN_TEST(test_a_run_is_good_with_its_time);
    RUN_TEST(test_off_is_off_and_a_clear_begins_at_0);
    RUN_TEST(test_what_is_left_open_is_1_s_and_10_s);
    RUN_TEST(test_wrong_configurations_are_refused);
    RUN_TEST(test_it_shorts_where_the_emf_is_above_the_bus);
    RUN_TEST(test_another_fault_is_looked_at_anew);
    RUN_TEST(test_the_look_ends_at_any_speed);
    RUN_TEST(test_it_does_not_short_a_start_from_rest);
    RUN_TEST(test_a_day_is_counted);
    RUN_TEST(test_it_shorts_nothing_unless_told);
    RUN_TEST(test_it_shorts_until_it_starts_again);
    RUN_TEST(test_after_a_trip_it_looks_first);
    RUN_TEST(test_a_short_of_more_than_the_largest_current_is_refused);
    RUN_TEST(test_a_drive_runs_again);
    RUN_TEST(test_a_drive_that_fails_again_and_again_stays_off);
    RUN_TEST(test_a_drive_rides_through_a_sag);
    return UNITY_END();
}
