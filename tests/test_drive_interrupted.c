// What the thread posts to a drive and reads of it, with the interrupt between any two of its steps.
#include "support/barriers.h"

#include "../src/drive.c"

#include "support/rig.h"

static lode_drive_tuning_t tuning;
static lode_drive_tuning_t others[2];
static rig_t rig;

static void one_period(void) {
    const lode_counts_t counts = rig_counts(&rig);
    rig.out = lode_drive_step(&rig.drive, &counts);
}

/// A voltage of `u_V` that turns at 100 rad/s.
static lode_command_t voltage(float u_V) {
    return (lode_command_t){
        .mode = LODE_MODE_VOLTAGE, .vector = {u_V, 0.0f}, .omega_rad_s = 100.0f};
}

static void begin(void) {
    const lode_drive_config_t config = rig_config();
    rig_init(&rig, &tuning, &config);
    rig.blocked = true;
    rig_command(&rig, voltage(1.0f));
    rig_run(&rig, 0.01);
    TEST_ASSERT_TRUE(rig.out.gates);
}

/// Of two commands in a row the interrupt takes one or both, each whole, and goes on by the second.
static void test_a_command_is_taken_whole_whenever_the_interrupt_comes(void) {
    uint32_t passed = 1u;
    for (uint32_t at = 0u; at < passed; at++) {
        begin();
        rig_command(&rig, voltage(2.0f));
        interrupt(at, at + 1u);
        rig_command(&rig, voltage(3.0f));
        passed = barriers;
        const float u_V = rig_telemetry(&rig).u_V.d;
        TEST_ASSERT_TRUE(u_V == 1.0f || u_V == 2.0f || u_V == 3.0f);
        rig_step(&rig);
        rig_step(&rig);
        TEST_ASSERT_EQUAL_FLOAT(3.0f, rig_telemetry(&rig).u_V.d);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    }
    TEST_ASSERT_TRUE(passed >= 3u);
}

/// Of two tunings in a row either is watched by its own sum, however long the thread waits, and the second is used in the
/// end.
static void test_a_tuning_is_watched_by_its_own_sum_whenever_the_interrupt_comes(void) {
    uint32_t passed = 1u;
    waits = 5000u; // each word is looked at
    for (int n = 0; n < COUNT_OF(others); n++) {
        lode_drive_config_t config = rig_config();
        config.speed.ramp_rad_s2 = 100.0f * (float)(n + 1);
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&others[n], &config));
    }
    for (uint32_t at = 0u; at < passed; at++) {
        begin();
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &others[0]));
        interrupt(at, at + 1u);
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &others[1]));
        passed = barriers;
        rig_run(&rig, 1.0);
        TEST_ASSERT_TRUE(rig.drive.tuning == &others[1]);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig_telemetry(&rig).fault.check);
    }
    TEST_ASSERT_TRUE(passed >= 3u);
}

static bool is_of_one_period(const lode_telemetry_t *t, const lode_drive_t *drive) {
    return t->steps == drive->steps && t->duty.a == drive->duty.a && t->duty.b == drive->duty.b &&
           t->duty.c == drive->duty.c && t->i_A.d == drive->i_A.d && t->i_A.q == drive->i_A.q;
}

/// Twice the interrupt may come while telemetry is read; three times running is told.
static void test_telemetry_is_of_one_period_or_says_that_it_is_not(void) {
    lode_telemetry_t t;
    begin();
    interrupt(0u, 0u);
    TEST_ASSERT_TRUE(lode_drive_telemetry(&rig.drive, &t));
    const uint32_t each = barriers; // of one try
    TEST_ASSERT_TRUE(each >= 2u);
    for (uint32_t at = 0u; at < each; at++) {
        interrupt(at, at + 1u);
        TEST_ASSERT_TRUE(lode_drive_telemetry(&rig.drive, &t));
        TEST_ASSERT_TRUE(is_of_one_period(&t, &rig.drive));
    }
    interrupt(0u, 2u * each);
    TEST_ASSERT_TRUE(lode_drive_telemetry(&rig.drive, &t));
    TEST_ASSERT_TRUE(is_of_one_period(&t, &rig.drive));
    interrupt(0u, 3u * each);
    TEST_ASSERT_FALSE(lode_drive_telemetry(&rig.drive, &t));
    TEST_ASSERT_EQUAL_UINT32(3u * each, barriers); // and does not hold the thread up any longer
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_command_is_taken_whole_whenever_the_interrupt_comes);
    RUN_TEST(test_a_tuning_is_watched_by_its_own_sum_whenever_the_interrupt_comes);
    RUN_TEST(test_telemetry_is_of_one_period_or_says_that_it_is_not);
    return UNITY_END();
}
