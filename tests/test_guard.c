// Every check fires at its limit and not just inside; debounce; the first cause stays.
#include "support/fields.h"

#include "guard_inline.h"
#include "sense_inline.h"

void setUp(void) {}

void tearDown(void) {}

#define STATE 5         // any number: the record repeats it
#define RAIL_PERIODS 5  // 1 ms of 200 us
#define WATCH_PERIODS 4 // the slow checks: twice in LODE_SLOW_PERIODS
#define BUS_CHECKS 2    // 1 ms of 800 us: two at least
#define LOCK_CHECKS 18  // 15 ms
#define BUS_PERIODS (BUS_CHECKS * WATCH_PERIODS)
#define LOCK_PERIODS (LOCK_CHECKS * WATCH_PERIODS)

static const lode_inverter_config_t inverter = {.v_bus_V = 200.0f, .i_max_A = 12.0f};
// A count of 12.5 mA; i_trip is 1440 of them, the rails are 2048 and 2047 away.
static const lode_sense_config_t board = {.i_gain_A_count = 0.0125f,
                                          .i_offset_count = 2048.0f,
                                          .i_offset_tol_count = 100.0f,
                                          .count_max = 4095.0f,
                                          .v_bus_gain_V_count = 0.1f,
                                          .temperature_gain_degC_count = 0.05f,
                                          .duty_max = 1.0f,
                                          .calibrate_s = 0.01f};
#define TRIP_COUNT 1440
#define ALERT_COUNT 1946

static lode_guard_config_t sound(void) {
    return (lode_guard_config_t){.i_trip_A = 18.0f,
                                 .v_bus_max_V = 250.0f,
                                 .v_bus_min_V = 120.0f,
                                 .temperature_max_degC = 90.0f,
                                 .temperature_min_degC = -30.0f,
                                 .i_sum_A = 1.8f,
                                 .overload_s = 0.05f,
                                 .flux_share = 0.3f,
                                 .plausibility = LODE_OFF,
                                 .check_stuck = LODE_ON,
                                 .check_gain = LODE_OFF,
                                 .check_half_waves = LODE_ON,
                                 .omega_max_rad_s = 1500.0f,
                                 .bus_s = 1.0e-3f,
                                 .lock_s = 15.0e-3f,
                                 .stamp_per_period = 1000.0f};
}

static lode_guard_tuning_t tuned(const lode_guard_config_t *config) {
    lode_guard_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_guard_tune(&tuning, config, &inverter, &board, PAPER_TS_s));
    return tuning;
}

/// A guard with everything that it looks at.
typedef struct {
    lode_guard_tuning_t tuning;
    lode_sense_tuning_t sensing;
    lode_sense_t sense;
    lode_guard_t guard;
    lode_counts_t counts;
    lode_condition_t condition;
    lode_situation_t now;
    int periods;
} bench_t;

static bench_t bench(void) {
    bench_t b = {.counts = {.i = {2128, 1888, 2128}},
                 .condition = {.v_bus_V = 200.0f,
                               .temperature_degC = 40.0f,
                               .omega_rad_s = 300.0f,
                               .lock = 0.95f},
                 .now = {.state = STATE, .runs = true}};
    const lode_guard_config_t config = sound();
    b.tuning = tuned(&config);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_sense_tune(&b.sensing, &board, 12.0f, 200.0f, PAPER_TS_s));
    b.sensing.alert = TRIP_COUNT * LODE_COUNT_FRACTION; // as the drive sets it
    lode_sense_reset(&b.sense, &b.sensing);
    lode_guard_reset(&b.guard);
    return b;
}

/// The fast checks of a period, as the drive has them: where something is wrong with the sample it is
/// looked at.
static bool fast(bench_t *b) {
    const lode_sample_t sample = lode_sense_step(&b->sense, &b->sensing, &b->counts, LODE_PHASES);
    if (!lode_guard_all_ok(&b->guard, &b->tuning, &sample)) {
        lode_guard_diagnose(&b->guard, &b->tuning, &b->sense, &b->sensing, &sample, STATE);
    }
    b->guard.stamp = sample.stamp;
    return lode_guard_is_good(&b->guard);
}

/// A period with a sample at a rail, or without one.
static void set_railed(bench_t *b, bool railed) {
    // The largest offset that a calibration may have found, and a trip beyond the rail: no over-current.
    b->sense.offset[0] = 2148 * LODE_COUNT_FRACTION;
    b->counts.i[0] = railed ? 4095u : 2148u;
    b->tuning.i_trip = 25.0f;
    b->sensing.alert = ALERT_COUNT * LODE_COUNT_FRACTION;
}

/// The same, a period after the last one.
static bool fast_on_time(bench_t *b) {
    b->counts.stamp += 1000u;
    return fast(b);
}

/// The slow checks.
static bool slow(bench_t *b) {
    lode_guard_check_slow(&b->guard, &b->tuning, b->condition, b->now);
    return lode_guard_is_good(&b->guard);
}

/// A period as the drive has it: the slow checks in every fourth.
static bool step(bench_t *b) {
    b->periods++;
    (void)fast_on_time(b);
    return b->periods % WATCH_PERIODS == 0 ? slow(b) : lode_guard_is_good(&b->guard);
}

/// Steps until the guard trips, at most `limit` times; how many it took, or `limit`.
static int steps_to_trip(bench_t *b, int limit) {
    for (int n = 1; n < limit; n++) {
        if (!step(b)) {
            return n;
        }
    }
    return limit;
}

static void check_fault(const bench_t *b, lode_check_t check, double measured, double limit) {
    TEST_ASSERT_EQUAL_STRING(lode_check_name(check),
                             lode_check_name((lode_check_t)b->guard.fault.check));
    TEST_ASSERT_EQUAL_INT(STATE, b->guard.fault.state);
    CHECK_NEAR(1.0e-4 * fabs(limit) + 1.0e-6, measured, b->guard.fault.measured);
    CHECK_NEAR(1.0e-4 * fabs(limit) + 1.0e-6, limit, b->guard.fault.limit);
}

static void test_a_sound_period_passes(void) {
    bench_t b = bench();
    TEST_ASSERT_EQUAL_INT(10000, steps_to_trip(&b, 10000));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, b.guard.fault.check);
}

/// A phase current in counts, the others without.
static void set_phase(bench_t *b, int phase, int count) {
    for (int n = 0; n < 3; n++) {
        b->counts.i[n] = (uint16_t)(2048 + (n == phase ? count : 0));
    }
}

static void test_over_current_of_every_phase_and_sign_at_once(void) {
    for (int phase = 0; phase < 3; phase++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            bench_t b = bench();
            set_phase(&b, phase, sign * TRIP_COUNT);
            TEST_ASSERT_EQUAL_INT(200, steps_to_trip(&b, 200));
            const int beyond = sign * (TRIP_COUNT + 1);
            set_phase(&b, phase, beyond);
            TEST_ASSERT_FALSE(step(&b));
            check_fault(&b, LODE_CHECK_OVER_CURRENT, 0.0125 * beyond, 18.0);
        }
    }
}

static void test_a_limit_that_is_no_number_trips_at_once(void) {
    bench_t b = bench();
    b.tuning.i_trip = NAN;
    set_phase(&b, 0, TRIP_COUNT + 1);
    TEST_ASSERT_FALSE(step(&b));
}

static void test_hardware_trip_at_once(void) {
    bench_t b = bench();
    b.counts.trip = true;
    TEST_ASSERT_FALSE(step(&b));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_HARDWARE_TRIP, b.guard.fault.check);
    CHECK_NEAR(0.0, 1.0, b.guard.fault.measured);
    CHECK_NEAR(0.0, 0.0, b.guard.fault.limit);
}

/// A debounced condition: passes one check of the slow checks short of `checks`, trips in the last one;
/// half-way down it counts back.
static void check_debounce(bench_t good, bench_t bad, int checks, lode_check_t check) {
    bench_t b = bad;
    TEST_ASSERT_EQUAL_INT(checks * WATCH_PERIODS, steps_to_trip(&b, 1000));
    TEST_ASSERT_EQUAL_STRING(lode_check_name(check),
                             lode_check_name((lode_check_t)b.guard.fault.check));
    b = good;
    TEST_ASSERT_EQUAL_INT(1000, steps_to_trip(&b, 1000));
    // Bad and good in turn never trips.
    b = bad;
    for (int n = 0; n < 1000; n++) {
        b.condition = n % 2 == 0 ? bad.condition : good.condition;
        TEST_ASSERT_TRUE(slow(&b));
    }
    // Two bad ones for every good one get there three times as slowly.
    b = bad;
    int n = 0;
    bool runs = true;
    for (; n < 1000 && runs; n++) {
        b.condition = n % 3 < 2 ? bad.condition : good.condition;
        runs = slow(&b);
    }
    CHECK_NEAR(4.0, 3.0 * checks - 2.0, n);
}

static void test_over_voltage(void) {
    bench_t good = bench();
    good.condition.v_bus_V = 250.0f;
    bench_t bad = good;
    bad.condition.v_bus_V = nextafterf(250.0f, 300.0f);
    check_debounce(good, bad, BUS_CHECKS, LODE_CHECK_OVER_VOLTAGE);
    (void)steps_to_trip(&bad, 100);
    check_fault(&bad, LODE_CHECK_OVER_VOLTAGE, 250.0, 250.0);
}

static void test_under_voltage(void) {
    bench_t good = bench();
    good.condition.v_bus_V = 120.0f;
    bench_t bad = good;
    bad.condition.v_bus_V = nextafterf(120.0f, 0.0f);
    check_debounce(good, bad, BUS_CHECKS, LODE_CHECK_UNDER_VOLTAGE);
    (void)steps_to_trip(&bad, 100);
    check_fault(&bad, LODE_CHECK_UNDER_VOLTAGE, 120.0, 120.0);
}

static void test_over_temperature(void) {
    bench_t good = bench();
    good.condition.temperature_degC = 90.0f;
    bench_t bad = good;
    bad.condition.temperature_degC = nextafterf(90.0f, 100.0f);
    check_debounce(good, bad, BUS_CHECKS, LODE_CHECK_OVER_TEMPERATURE);
    (void)steps_to_trip(&bad, 100);
    check_fault(&bad, LODE_CHECK_OVER_TEMPERATURE, 90.0, 90.0);
}

static void test_under_temperature(void) {
    bench_t good = bench();
    good.condition.temperature_degC = -30.0f;
    bench_t bad = good;
    bad.condition.temperature_degC = nextafterf(-30.0f, -31.0f);
    check_debounce(good, bad, BUS_CHECKS, LODE_CHECK_UNDER_TEMPERATURE);
    (void)steps_to_trip(&bad, 100);
    check_fault(&bad, LODE_CHECK_UNDER_TEMPERATURE, -30.0, -30.0);
}

// Rails are met in the fast part and forgotten in the slow one: up per period, down per check without.
static void test_current_rail(void) {
    bench_t b = bench();
    set_railed(&b, true);
    TEST_ASSERT_EQUAL_INT(RAIL_PERIODS, steps_to_trip(&b, 1000));
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_CURRENT_RAIL, b.guard.fault.check);
    // A single one, and then a round of checks without, for ever.
    b = bench();
    for (int n = 0; n < 1000; n++) {
        set_railed(&b, n % (2 * WATCH_PERIODS) == 1);
        TEST_ASSERT_TRUE(step(&b));
    }
    // One between any two checks is not forgotten.
    b = bench();
    int n = 0;
    do {
        set_railed(&b, n % WATCH_PERIODS == 1);
        n++;
    } while (step(&b) && n < 1000);
    TEST_ASSERT_EQUAL_INT((RAIL_PERIODS - 1) * WATCH_PERIODS + 2, n);
    // One short of the limit is forgotten in as many checks, and no sooner.
    for (int rest = 0; rest < RAIL_PERIODS; rest++) {
        b = bench();
        set_railed(&b, true);
        for (int k = 0; k < RAIL_PERIODS - 1; k++) {
            TEST_ASSERT_TRUE(fast_on_time(&b));
        }
        set_railed(&b, false);
        for (int k = 0; k <= rest; k++) { // the first check still sees it
            TEST_ASSERT_TRUE(slow(&b));
        }
        set_railed(&b, true);
        for (int k = 0; k < rest; k++) {
            TEST_ASSERT_TRUE(fast_on_time(&b));
        }
        TEST_ASSERT_FALSE(fast_on_time(&b));
    }
}

static void test_lost_lock(void) {
    bench_t good = bench();
    good.condition.lock = LODE_LOCK_LOST;
    bench_t bad = good;
    bad.condition.lock = nextafterf(LODE_LOCK_LOST, 0.0f);
    check_debounce(good, bad, LOCK_CHECKS, LODE_CHECK_LOST_LOCK);
    (void)steps_to_trip(&bad, 100);
    check_fault(&bad, LODE_CHECK_LOST_LOCK, 0.5, 0.5);
}

// The drive counts the speed in the commanded sense of rotation.
static void test_over_speed_both_ways(void) {
    bench_t good = bench();
    good.condition.omega_rad_s = 1500.0f;
    bench_t bad = good;
    bad.condition.omega_rad_s = 1500.1f;
    check_debounce(good, bad, LOCK_CHECKS, LODE_CHECK_OVER_SPEED);
    (void)steps_to_trip(&bad, 100);
    check_fault(&bad, LODE_CHECK_OVER_SPEED, 1500.1, 1500.0);
    bench_t back = bench();
    back.condition.omega_rad_s = -1500.1f;
    TEST_ASSERT_EQUAL_INT(LOCK_PERIODS, steps_to_trip(&back, 100));
    check_fault(&back, LODE_CHECK_OVER_SPEED, -1500.1, 1500.0);
}

static void test_wrong_way(void) {
    bench_t good = bench();
    good.condition.omega_rad_s = 100.0f;
    bench_t bad = good;
    bad.condition.omega_rad_s = -100.0f;
    check_debounce(good, bad, LOCK_CHECKS, LODE_CHECK_WRONG_WAY);
    (void)steps_to_trip(&bad, 100);
    TEST_ASSERT_EQUAL_FLOAT(-100.0f, bad.guard.fault.measured);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bad.guard.fault.limit);
    // Slow is not back, and neither is standing.
    const float slow_rad_s[] = {0.5f, 0.0f};
    for (int n = 0; n < COUNT_OF(slow_rad_s); n++) {
        good.condition.omega_rad_s = slow_rad_s[n];
        TEST_ASSERT_EQUAL_INT(1000, steps_to_trip(&good, 1000));
    }
}

/// A current as large as the trip is allowed, and one that is larger by the least that can be told is not.
static void test_the_trip_itself_is_allowed(void) {
    bench_t b = bench();
    b.counts.i[0] = 2048u + TRIP_COUNT + 1u;
    b.tuning.i_trip =
        (float)((TRIP_COUNT + 1) * LODE_COUNT_FRACTION) * b.sensing.i_gain; // as it is computed
    TEST_ASSERT_TRUE(fast_on_time(&b));
    b.tuning.i_trip = nextafterf(b.tuning.i_trip, 0.0f);
    TEST_ASSERT_FALSE(fast_on_time(&b));
}

static void test_motion_is_watched_only_without_a_sensor(void) {
    bench_t b = bench();
    b.now.runs = false;
    b.condition.lock = 0.0f;
    b.condition.omega_rad_s = -9000.0f;
    TEST_ASSERT_EQUAL_INT(1000, steps_to_trip(&b, 1000));
}

static void test_samples_that_are_no_number_trip(void) {
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        const float x = check_not_finite[i];
        bench_t bus = bench();
        bus.condition.v_bus_V = x;
        TEST_ASSERT_EQUAL_INT(BUS_PERIODS, steps_to_trip(&bus, 1000));
        bench_t lock = bench();
        lock.condition.lock = NAN;
        TEST_ASSERT_EQUAL_INT(LOCK_PERIODS, steps_to_trip(&lock, 1000));
        bench_t speed = bench();
        speed.condition.omega_rad_s = x;
        TEST_ASSERT_EQUAL_INT(LOCK_PERIODS, steps_to_trip(&speed, 1000));
    }
    bench_t hot = bench();
    hot.condition.temperature_degC = NAN;
    TEST_ASSERT_EQUAL_INT(BUS_PERIODS, steps_to_trip(&hot, 1000));
}

/// Trips on the second stamp after `passed` counts?
static bool late(uint32_t first, uint32_t passed) {
    bench_t b = bench();
    b.counts.stamp = first;
    b.guard.stamp = first - 1000u;
    TEST_ASSERT_TRUE(fast(&b));
    b.counts.stamp = first + passed;
    const bool runs = fast(&b);
    if (!runs) {
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_TIMING, b.guard.fault.check);
    }
    return !runs;
}

/// The fast check passes a call in time, and no other, wherever the counter stands.
static void test_the_fast_check_of_the_stamp(void) {
    static const uint32_t before[] = {0u, 200u, 500u, 1000000u, UINT32_MAX - 400u};
    static const uint32_t passed[] = {0u, 600u, 749u, 750u, 1000u, 1250u, 1251u, 60000u};
    for (int n = 0; n < COUNT_OF(before); n++) {
        for (int k = 0; k < COUNT_OF(passed); k++) {
            bench_t b = bench();
            b.guard.stamp = before[n];
            const lode_sample_t sample = {.stamp = before[n] + passed[k]};
            TEST_ASSERT_EQUAL_INT(passed[k] >= 750u && passed[k] <= 1250u,
                                  lode_guard_all_ok(&b.guard, &b.tuning, &sample));
        }
    }
}

static void test_timing_by_the_stamp(void) {
    // Starts include some that wrap round on the way.
    const uint32_t starts[] = {0u, 12345u, UINT32_MAX - 3u, 1000u};
    for (int i = 0; i < COUNT_OF(starts); i++) {
        TEST_ASSERT_FALSE(late(starts[i], 1000u));
        TEST_ASSERT_FALSE(late(starts[i], 800u));
        TEST_ASSERT_FALSE(late(starts[i], 1200u));
        TEST_ASSERT_TRUE(late(starts[i], 2000u)); // one period missed
        TEST_ASSERT_TRUE(late(starts[i], 0u));    // called twice
        TEST_ASSERT_TRUE(late(starts[i], 500u));
    }
}

/// Calls that were missed are the cause of a current that is too large; what the hardware has tripped by comes before both.
static void test_a_missed_call_is_named_before_its_current(void) {
    for (int n = 0; n < 4; n++) {
        bench_t b = bench();
        TEST_ASSERT_TRUE(fast_on_time(&b));
        b.counts.i[0] = 4095u;
        b.counts.trip = n >= 2;
        b.counts.stamp += n % 2 == 0 ? 1000u : 100000u;
        TEST_ASSERT_FALSE(fast(&b));
        static const lode_check_t wanted[] = {LODE_CHECK_OVER_CURRENT, LODE_CHECK_TIMING,
                                              LODE_CHECK_HARDWARE_TRIP, LODE_CHECK_HARDWARE_TRIP};
        TEST_ASSERT_EQUAL_INT(wanted[n], b.guard.fault.check);
    }
}

/// A quarter of a period late is in time, however close the sample is looked at.
static void test_the_latest_stamp_is_in_time(void) {
    for (uint32_t more = 0u; more <= 1u; more++) {
        bench_t b = bench();
        set_railed(&b, false);
        TEST_ASSERT_TRUE(fast_on_time(&b));
        set_railed(&b, true);
        b.counts.stamp += 1250u + more;
        TEST_ASSERT_EQUAL_INT(more == 0u, fast(&b));
        TEST_ASSERT_EQUAL_INT(more == 0u ? LODE_CHECK_NONE : LODE_CHECK_TIMING,
                              b.guard.fault.check);
        CHECK_NEAR(0.0, more == 0u ? 0.0 : 1251.0, b.guard.fault.measured);
        CHECK_NEAR(0.0, more == 0u ? 0.0 : 1250.0, b.guard.fault.limit);
    }
}

/// What is at a limit is within it: nothing is looked at.
static void test_at_the_limits_nothing_is_looked_at(void) {
    const lode_condition_t conditions[] = {
        {.v_bus_V = 250.0f,
         .temperature_degC = 90.0f,
         .omega_rad_s = 1500.0f,
         .lock = LODE_LOCK_LOST},
        {.v_bus_V = 120.0f, .temperature_degC = -30.0f, .omega_rad_s = 0.0f, .lock = 1.0f}};
    for (int n = 0; n < COUNT_OF(conditions); n++) {
        const bench_t b = bench();
        TEST_ASSERT_TRUE(lode_guard_slow_ok(&b.guard, &b.tuning, &conditions[n], true));
    }
}

/// The slow checks are asked for until what they have counted has come down.
static void test_what_was_counted_is_pending(void) {
    bench_t b = bench();
    TEST_ASSERT_TRUE(lode_guard_slow_ok(&b.guard, &b.tuning, &b.condition, true));
    const lode_condition_t good = b.condition;
    for (int n = 0; n < 3; n++) {
        b.condition.v_bus_V = n == 0 ? 300.0f : good.v_bus_V;
        b.condition.lock = n == 1 ? 0.1f : good.lock;
        b.condition.temperature_degC = n == 2 ? 100.0f : good.temperature_degC;
        TEST_ASSERT_TRUE(slow(&b));
        b.condition = good;
        TEST_ASSERT_FALSE(lode_guard_slow_ok(&b.guard, &b.tuning, &b.condition, true));
        TEST_ASSERT_TRUE(slow(&b));
        TEST_ASSERT_TRUE(lode_guard_slow_ok(&b.guard, &b.tuning, &b.condition, true));
    }
    set_railed(&b, true);
    TEST_ASSERT_TRUE(fast_on_time(&b));
    TEST_ASSERT_TRUE(slow(&b));
    set_railed(&b, false);
    TEST_ASSERT_FALSE(lode_guard_slow_ok(&b.guard, &b.tuning, &b.condition, true));
}

static void test_timing_is_not_watched_unless_configured(void) {
    lode_guard_config_t config = sound();
    config.stamp_per_period = 0.0f;
    bench_t b = bench();
    b.tuning = tuned(&config);
    random_t random = random_seed(1);
    for (int n = 0; n < 1000; n++) {
        b.counts.stamp = random_bits(&random);
        TEST_ASSERT_TRUE(fast(&b));
    }
}

static void test_the_first_cause_stays(void) {
    bench_t b = bench();
    set_phase(&b, 0, TRIP_COUNT + 1);
    TEST_ASSERT_FALSE(step(&b));
    const lode_fault_t first = b.guard.fault;
    set_phase(&b, 0, -TRIP_COUNT - 100);
    b.counts.trip = true;
    TEST_ASSERT_EQUAL_INT(1, steps_to_trip(&b, 100));
    lode_guard_trip(&b.guard, 1, LODE_CHECK_START, 1.0f, 2.0f);
    TEST_ASSERT_EQUAL_INT(first.check, b.guard.fault.check);
    TEST_ASSERT_EQUAL_INT(first.state, b.guard.fault.state);
    TEST_ASSERT_TRUE(first.measured == b.guard.fault.measured &&
                     first.limit == b.guard.fault.limit);
    // Also against what is counted, in another state.
    b.condition.v_bus_V = 300.0f;
    b.now.state = 1;
    for (int n = 0; n < 100; n++) {
        TEST_ASSERT_FALSE(slow(&b));
    }
    TEST_ASSERT_EQUAL_INT(first.check, b.guard.fault.check);
    TEST_ASSERT_EQUAL_INT(first.state, b.guard.fault.state);
    // Sound again: the fault stays until it is reset.
    b = bench();
    lode_guard_trip(&b.guard, 3, LODE_CHECK_START, 0.25f, 0.7f);
    TEST_ASSERT_FALSE(step(&b));
    const lode_fault_t expected = {
        .state = 3, .check = LODE_CHECK_START, .measured = 0.25f, .limit = 0.7f};
    TEST_ASSERT_EQUAL_UINT(expected.check, b.guard.fault.check);
    TEST_ASSERT_EQUAL_UINT(expected.state, b.guard.fault.state);
    TEST_ASSERT_EQUAL_FLOAT(expected.measured, b.guard.fault.measured);
    TEST_ASSERT_EQUAL_FLOAT(expected.limit, b.guard.fault.limit);
}

static void test_reset_forgets_fault_and_counts(void) {
    bench_t b = bench();
    b.condition.v_bus_V = 300.0f;
    TEST_ASSERT_EQUAL_INT(BUS_PERIODS - 1, steps_to_trip(&b, BUS_PERIODS - 1));
    b.counts.trip = true;
    TEST_ASSERT_FALSE(step(&b));
    lode_guard_reset(&b.guard);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, b.guard.fault.check);
    b.counts.trip = false;
    b.periods = 0;
    TEST_ASSERT_EQUAL_INT(BUS_PERIODS, steps_to_trip(&b, 1000));
}

static void test_names_are_distinct(void) {
    for (int i = 0; i < (int)LODE_CHECK_COUNT; i++) {
        TEST_ASSERT_EQUAL_STRING_LEN("LODE_CHECK_", lode_check_name((lode_check_t)i), 11);
        for (int j = 0; j <= i; j++) {
            TEST_ASSERT_EQUAL_INT(i == j, strcmp(lode_check_name((lode_check_t)i),
                                                 lode_check_name((lode_check_t)j)) == 0);
        }
    }
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_LOST_LOCK", lode_check_name(LODE_CHECK_LOST_LOCK));
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_UNKNOWN", lode_check_name(LODE_CHECK_COUNT));
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_UNKNOWN", lode_check_name((lode_check_t)99));
}

static lode_status_t try_one(size_t offset, float value) {
    lode_guard_config_t config = sound();
    field_set(&config, offset, value);
    lode_guard_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_guard_tuning_t before = tuning;
    const lode_status_t status = lode_guard_tune(&tuning, &config, &inverter, &board, PAPER_TS_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static void test_every_field_at_its_limits(void) {
    // The sensor reaches 2047 * 0.0125 A and 409.5 V.
    static const field_t fields[] = {
        {FIELD(lode_guard_config_t, i_trip_A), .lo = 12.0f, .hi = 2047.0f * 0.0125f,
         .computed = true, .error = LODE_ERROR_GUARD_CURRENT},
        {FIELD(lode_guard_config_t, v_bus_max_V), .lo = 200.0f, .hi = 409.5f, .computed = true,
         .error = LODE_ERROR_GUARD_BUS},
        {FIELD(lode_guard_config_t, v_bus_min_V), .lo = 0.0f, .hi = 200.0f,
         .error = LODE_ERROR_GUARD_BUS},
        {FIELD(lode_guard_config_t, bus_s), .lo = PAPER_TS_s, .hi = 10.0f,
         .error = LODE_ERROR_GUARD_TIME},
        {FIELD(lode_guard_config_t, lock_s), .lo = PAPER_TS_s, .hi = 10.0f,
         .error = LODE_ERROR_GUARD_TIME},
    };
    field_check_all(fields, COUNT_OF(fields), try_one);
    const size_t speed = offsetof(lode_guard_config_t, omega_max_rad_s);
    const size_t hot = offsetof(lode_guard_config_t, temperature_max_degC);
    const size_t cold = offsetof(lode_guard_config_t, temperature_min_degC);
    const size_t stamp = offsetof(lode_guard_config_t, stamp_per_period);
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(cold, 90.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TEMPERATURE, try_one(cold, 90.1f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TEMPERATURE, try_one(cold, -300.1f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(speed, 1.0e6f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_SPEED, try_one(speed, 1.1e6f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_SPEED, try_one(speed, -1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TIME, try_one(stamp, -1.0f));
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_SPEED, try_one(speed, check_not_finite[i]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TEMPERATURE, try_one(hot, check_not_finite[i]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TEMPERATURE, try_one(cold, check_not_finite[i]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TIME, try_one(stamp, check_not_finite[i]));
    }
}

static void test_the_sensors_shorter_side_bounds_the_trip(void) {
    const float offsets[] = {1448.0f, 4095.0f - 1448.0f};
    for (int n = 0; n < 2 * COUNT_OF(offsets); n++) {
        lode_sense_config_t shifted = board;
        lode_guard_config_t config = sound();
        lode_guard_tuning_t tuning;
        shifted.i_offset_count = offsets[n / 2];
        config.i_trip_A = n % 2 == 0 ? 18.09f : 18.11f; // 18.1 A
        TEST_ASSERT_EQUAL_INT(n % 2 == 0 ? LODE_OK : LODE_ERROR_GUARD_CURRENT,
                              lode_guard_tune(&tuning, &config, &inverter, &shifted, PAPER_TS_s));
    }
}

static void test_temperatures_and_speeds_between_which_limits_lie(void) {
    const size_t hottest = offsetof(lode_guard_config_t, temperature_max_degC);
    const size_t fastest = offsetof(lode_guard_config_t, omega_max_rad_s);
    const size_t stamp = offsetof(lode_guard_config_t, stamp_per_period);
    lode_guard_config_t cold = sound();
    lode_guard_tuning_t tuning;
    cold.temperature_min_degC = -300.0f;
    cold.temperature_max_degC = -100.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_guard_tune(&tuning, &cold, &inverter, &board, PAPER_TS_s));
    cold.temperature_max_degC = -101.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TEMPERATURE,
                          lode_guard_tune(&tuning, &cold, &inverter, &board, PAPER_TS_s));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(hottest, 1000.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TEMPERATURE, try_one(hottest, 1001.0f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(fastest, 1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_SPEED, try_one(fastest, 0.99f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(stamp, 1.0e9f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(stamp, 1.0f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(stamp, 0.0f)); // not watched
    const float none[] = {0.999f, 0.7f, 1.0e-6f};         // nothing to watch
    for (int n = 0; n < COUNT_OF(none); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TIME, try_one(stamp, none[n]));
    }
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TIME, try_one(stamp, 1.01e9f));
    // A stamp that counts periods is watched too.
    lode_guard_config_t config = sound();
    config.stamp_per_period = 1.0f;
    TEST_ASSERT_TRUE(tuned(&config).stamp_span < 2u);
}

/// A board without a temperature sensor reads its offset: it must lie between the limits, and cannot be asked to move.
static void test_without_a_sensor_no_check_of_it_is_taken(void) {
    lode_sense_config_t bare = board;
    bare.temperature_gain_degC_count = 0.0f;
    const struct {
        float offset_degC, still_s;
        lode_status_t status;
    } cases[] = {{0.0f, 0.0f, LODE_OK},
                 {-30.0f, 0.0f, LODE_OK},
                 {90.0f, 0.0f, LODE_OK},
                 {-30.1f, 0.0f, LODE_ERROR_GUARD_TEMPERATURE},
                 {90.1f, 0.0f, LODE_ERROR_GUARD_TEMPERATURE},
                 {0.0f, 0.5f, LODE_ERROR_GUARD_TIME}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        lode_guard_config_t config = sound();
        lode_guard_tuning_t tuning;
        config.temperature_still_s = cases[n].still_s;
        bare.temperature_offset_degC = cases[n].offset_degC;
        TEST_ASSERT_EQUAL_INT(cases[n].status,
                              lode_guard_tune(&tuning, &config, &inverter, &bare, PAPER_TS_s));
        // With one, of either sign, they are.
        bare.temperature_gain_degC_count = n % 2 == 0 ? 0.05f : -0.05f;
        TEST_ASSERT_EQUAL_INT(LODE_OK,
                              lode_guard_tune(&tuning, &config, &inverter, &bare, PAPER_TS_s));
        bare.temperature_gain_degC_count = 0.0f;
    }
}

/// In rounds of eight periods, two at least, and none where none are asked for; up to what the counters hold.
static void test_times_of_standing_still(void) {
    const float round_s = 8.0f * PAPER_TS_s;
    const float times_s[] = {0.0f, 0.1f * PAPER_TS_s, 2.5f * round_s, 0.1f, 2.0f};
    const uint32_t rounds[] = {0u, 2u, 2u, 62u, 1250u};
    for (int n = 0; n < COUNT_OF(times_s); n++) {
        lode_guard_config_t config = sound();
        config.temperature_still_s = times_s[n];
        config.bus_still_s = times_s[COUNT_OF(times_s) - 1 - n];
        const lode_guard_tuning_t tuning = tuned(&config);
        TEST_ASSERT_EQUAL_UINT32(rounds[n], tuning.still_rounds);
        TEST_ASSERT_EQUAL_UINT32(rounds[COUNT_OF(rounds) - 1 - n], tuning.bus_still_rounds);
    }
    const size_t both[] = {offsetof(lode_guard_config_t, temperature_still_s),
                           offsetof(lode_guard_config_t, bus_still_s)};
    for (int n = 0; n < COUNT_OF(both); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(both[n], 40.0f));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TIME, try_one(both[n], 1.0e4f));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_GUARD_TIME, try_one(both[n], -1.0f));
    }
}

/// The counters of 16 bits come to what is asked for with the periods after it too.
static void test_the_longest_times_still_end(void) {
    lode_guard_config_t config = sound();
    config.bus_s = 10.0f;
    lode_guard_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_guard_tune(&tuning, &config, &inverter, &board, 1.0e-4f));
    TEST_ASSERT_EQUAL_UINT(65535u - LODE_GUARD_DECAY_PERIODS, tuning.bus_periods);
}

static void test_times_become_periods_and_looks(void) {
    // In checks of the slow checks, 0.8 ms, two at least: a single sample passes.
    const float times[] = {2.0e-4f, 4.0e-4f, 6.0e-4f, 1.0e-3f, 3.0e-3f, 15.0e-3f, 0.1f};
    const int periods[] = {2, 2, 3, 5, 15, 75, 500};
    const int checks[] = {2, 2, 2, 2, 3, 18, 125};
    for (int i = 0; i < COUNT_OF(times); i++) {
        lode_guard_config_t config = sound();
        config.bus_s = times[i];
        config.lock_s = times[i];
        const lode_guard_tuning_t tuning = tuned(&config);
        TEST_ASSERT_EQUAL_INT(periods[i], tuning.bus_periods);
        TEST_ASSERT_EQUAL_INT(checks[i], tuning.lock_checks);
        bench_t b = bench();
        b.tuning = tuning;
        b.condition.v_bus_V = 300.0f;
        for (int check = 1; check < checks[i]; check++) {
            TEST_ASSERT_TRUE(slow(&b));
        }
        TEST_ASSERT_FALSE(slow(&b));
    }
}

static void test_the_fast_part_has_no_eye_on_what_is_slow(void) {
    bench_t b = bench();
    b.condition = (lode_condition_t){NAN, NAN, NAN, NAN};
    for (int n = 0; n < 1000; n++) {
        TEST_ASSERT_TRUE(fast_on_time(&b));
    }
    // Nor the slow part on what is fast.
    b = bench();
    b.counts.trip = true;
    set_phase(&b, 0, 2047);
    for (int n = 0; n < 1000; n++) {
        TEST_ASSERT_TRUE(slow(&b));
    }
}

static void test_counters_come_down_when_all_is_sound_again(void) {
    // One check short of a trip, then sound for as many: a new start from nothing.
    bench_t b = bench();
    for (int again = 0; again < 5; again++) {
        b.condition.lock = 0.1f;
        for (int n = 0; n < LOCK_CHECKS - 1; n++) {
            TEST_ASSERT_TRUE(slow(&b));
        }
        b.condition.lock = 0.9f;
        for (int n = 0; n < LOCK_CHECKS - 1; n++) {
            TEST_ASSERT_TRUE(slow(&b));
        }
        TEST_ASSERT_EQUAL_UINT(0, b.guard.lock);
    }
    (void)slow(&b);
    TEST_ASSERT_FALSE(b.guard.pending);
    b.condition.lock = 0.1f;
    for (int n = 1; n < LOCK_CHECKS; n++) {
        TEST_ASSERT_TRUE(slow(&b));
    }
    TEST_ASSERT_FALSE(slow(&b));
}

/// Debounces may be longer than the counter of a shorted switch is: its last value counts as long enough, and it never wraps.
static void test_a_shorted_switch_is_named_by_the_last_count(void) {
    bench_t b = bench();
    b.tuning.bus_periods = UINT16_MAX - LODE_GUARD_DECAY_PERIODS;
    lode_guard_trip(&b.guard, STATE, LODE_CHECK_OVER_CURRENT, 20.0f, 18.0f);
    const float A = 1.0f / b.sensing.i_gain;
    const lode_sample_t sample = {
        .i = {(int32_t)(-30.0f * A), (int32_t)(17.0f * A), (int32_t)(13.0f * A)}};
    lode_shorted_t shorted = {.periods = 0u};
    for (uint32_t n = 1u; n <= UINT16_MAX; n++) {
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_OVER_CURRENT, b.guard.fault.check);
        lode_guard_suspect(&b.guard, &b.tuning, &b.sensing, &sample, &shorted, UINT16_MAX);
        TEST_ASSERT_EQUAL_UINT(n, shorted.periods);
    }
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_SWITCH_SHORTED, b.guard.fault.check);
    b.guard.fault.check = LODE_CHECK_OVER_CURRENT;
    lode_guard_suspect(&b.guard, &b.tuning, &b.sensing, &sample, &shorted, UINT16_MAX);
    TEST_ASSERT_EQUAL_UINT(UINT16_MAX, shorted.periods);
}

static void test_debounces_do_not_mix(void) {
    // Each of the six in turn: every counter rises once in six checks and falls five times.
    bench_t b = bench();
    for (int n = 0; n < 6000; n++) {
        b.condition = bench().condition;
        set_railed(&b, n % 6 == 0);
        b.condition.v_bus_V = n % 6 == 1 ? 300.0f : b.condition.v_bus_V;
        b.condition.temperature_degC = n % 6 == 2 ? 95.0f : b.condition.temperature_degC;
        b.condition.lock = n % 6 == 3 ? 0.1f : b.condition.lock;
        b.condition.omega_rad_s = n % 6 == 4 ? 1600.0f : (n % 6 == 5 ? -10.0f : 300.0f);
        TEST_ASSERT_TRUE(fast_on_time(&b));
        TEST_ASSERT_TRUE(slow(&b));
    }
}

static void test_design_fills_what_is_open(void) {
    const lode_estimator_config_t estimator = {.omega_max_rad_s = 1000.0f};
    lode_guard_config_t config = {.i_trip_A = 0.0f};
    lode_guard_design(&config, &inverter, &estimator);
    CHECK_CLOSE(1.0e-6, 18.0, config.i_trip_A);
    CHECK_CLOSE(1.0e-6, 250.0, config.v_bus_max_V);
    CHECK_CLOSE(1.0e-6, 120.0, config.v_bus_min_V);
    CHECK_CLOSE(1.0e-6, 100.0, config.temperature_max_degC);
    CHECK_CLOSE(1.0e-6, 1300.0, config.omega_max_rad_s);
    CHECK_CLOSE(1.0e-6, 1.0e-3, config.bus_s);
    CHECK_CLOSE(1.0e-6, 15.0e-3, config.lock_s);
    CHECK_CLOSE(1.0e-6, -40.0, config.temperature_min_degC);
    CHECK_CLOSE(1.0e-6, 0.15 * 12.0, config.i_sum_A);
    CHECK_CLOSE(1.0e-6, 0.03, config.overload_s);
    CHECK_CLOSE(1.0e-6, 0.2, config.flux_share);
    TEST_ASSERT_EQUAL_INT(LODE_ON, config.plausibility);
    TEST_ASSERT_EQUAL_INT(LODE_ON, config.check_stuck);
    TEST_ASSERT_EQUAL_INT(LODE_ON, config.check_gain);
    TEST_ASSERT_EQUAL_INT(LODE_ON, config.check_half_waves);
    lode_guard_config_t without = {.plausibility = LODE_OFF};
    lode_guard_design(&without, &inverter, &estimator);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, without.check_stuck);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, without.check_gain);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, without.check_half_waves);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, config.stamp_per_period);
    const lode_guard_config_t all = sound();
    lode_guard_config_t kept = all;
    lode_guard_design(&kept, &inverter, &estimator);
    TEST_ASSERT_EQUAL_MEMORY(&all, &kept, sizeof all);
}

/// (K45): at one of four checks of a lock that is being lost.
static void test_how_often_a_rotor_stands(void) {
    static const uint_least16_t checks[] = {0u, 4u, 5u, 8u, 9u};
    for (int n = 0; n < COUNT_OF(checks); n++) {
        const lode_guard_t guard = {.lock = checks[n],
                                    .stopped = (uint_least16_t)(n == 0 ? 0 : (n + 1) / 2)};
        TEST_ASSERT_EQUAL(n == 1 || n == 3, lode_guard_saw_rotor_stopped(&guard));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_sound_period_passes);
    RUN_TEST(test_how_often_a_rotor_stands);
    RUN_TEST(test_over_current_of_every_phase_and_sign_at_once);
    RUN_TEST(test_a_limit_that_is_no_number_trips_at_once);
    RUN_TEST(test_hardware_trip_at_once);
    RUN_TEST(test_over_voltage);
    RUN_TEST(test_under_voltage);
    RUN_TEST(test_over_temperature);
    RUN_TEST(test_under_temperature);
    RUN_TEST(test_current_rail);
    RUN_TEST(test_lost_lock);
    RUN_TEST(test_over_speed_both_ways);
    RUN_TEST(test_wrong_way);
    RUN_TEST(test_the_latest_stamp_is_in_time);
    RUN_TEST(test_a_missed_call_is_named_before_its_current);
    RUN_TEST(test_at_the_limits_nothing_is_looked_at);
    RUN_TEST(test_what_was_counted_is_pending);
    RUN_TEST(test_the_trip_itself_is_allowed);
    RUN_TEST(test_the_sensors_shorter_side_bounds_the_trip);
    RUN_TEST(test_temperatures_and_speeds_between_which_limits_lie);
    RUN_TEST(test_without_a_sensor_no_check_of_it_is_taken);
    RUN_TEST(test_times_of_standing_still);
    RUN_TEST(test_motion_is_watched_only_without_a_sensor);
    RUN_TEST(test_samples_that_are_no_number_trip);
    RUN_TEST(test_the_fast_check_of_the_stamp);
    RUN_TEST(test_timing_by_the_stamp);
    RUN_TEST(test_timing_is_not_watched_unless_configured);
    RUN_TEST(test_the_first_cause_stays);
    RUN_TEST(test_reset_forgets_fault_and_counts);
    RUN_TEST(test_names_are_distinct);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_the_longest_times_still_end);
    RUN_TEST(test_times_become_periods_and_looks);
    RUN_TEST(test_the_fast_part_has_no_eye_on_what_is_slow);
    RUN_TEST(test_counters_come_down_when_all_is_sound_again);
    RUN_TEST(test_debounces_do_not_mix);
    RUN_TEST(test_a_shorted_switch_is_named_by_the_last_count);
    RUN_TEST(test_design_fills_what_is_open);
    return UNITY_END();
}
