// What the thread posts to a six-phase drive and reads of it, with the interrupt between any two of its steps.
#include "support/barriers.h"

#include "../src/drive6.c"

#include "support/rig6.h"

static lode_drive6_tuning_t tuning;
static lode_drive6_tuning_t others[2];
static rig6_t rig;

static void one_period(void) {
    const lode_counts6_t counts = rig6_counts(&rig);
    rig.out = lode_drive6_step(&rig.drive, &counts);
}

static void begin(void) {
    const lode_drive6_config_t config = rig6_config();
    const lode_command_t turns = {
        .mode = LODE_MODE_VOLTAGE, .vector = {1.0f, 0.0f}, .omega_rad_s = 100.0f};
    rig6_init(&rig, &tuning, &config);
    rig6_command(&rig, turns);
    rig6_run(&rig, 0.01);
    TEST_ASSERT_TRUE(rig.out.set[0].gates);
}

/// Of two tunings in a row either is watched by its own sum, however long the thread waits, and the second is used in the
/// end.
static void test_a_tuning_is_watched_by_its_own_sum_whenever_the_interrupt_comes(void) {
    uint32_t passed = 1u;
    for (int n = 0; n < COUNT_OF(others); n++) {
        lode_drive6_config_t config = rig6_config();
        config.drive.speed.ramp_rad_s2 = 100.0f * (float)(n + 1);
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_tune(&others[n], &config));
    }
    for (uint32_t at = 0u; at < passed; at++) {
        begin();
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_post_tuning(&rig.drive, &others[0]));
        waits = 10000u; // each word is looked at
        interrupt(at, at + 1u);
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_post_tuning(&rig.drive, &others[1]));
        passed = barriers;
        interrupt(0u, 0u);
        rig6_run(&rig, 1.0);
        TEST_ASSERT_TRUE(rig.drive.tuning == &others[1]);
        TEST_ASSERT_TRUE(lode_drive6_tuning_taken(&rig.drive));
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, rig6_telemetry(&rig).drive.fault.check);
    }
    TEST_ASSERT_TRUE(passed >= 2u);
}

static bool is_of_one_period(const lode_telemetry6_t *t, const lode_drive6_t *drive) {
    return t->drive.steps == drive->drive.steps && t->drive.duty.a == drive->drive.duty.a &&
           t->duty_2.a == drive->duty_2.a && t->duty_2.b == drive->duty_2.b &&
           t->i_xy_A.alpha == drive->i_xy_A.alpha && t->u_xy_V.beta == drive->u_xy_V.beta;
}

/// Twice the interrupt may come while telemetry is read; three times running is told.
static void test_telemetry_is_of_one_period_or_says_that_it_is_not(void) {
    lode_telemetry6_t t;
    begin();
    interrupt(0u, 0u);
    TEST_ASSERT_TRUE(lode_drive6_telemetry(&rig.drive, &t));
    const uint32_t each = barriers; // of one try
    TEST_ASSERT_TRUE(each >= 1u);
    interrupt(0u, 2u * each);
    TEST_ASSERT_TRUE(lode_drive6_telemetry(&rig.drive, &t));
    TEST_ASSERT_TRUE(is_of_one_period(&t, &rig.drive));
    interrupt(0u, 3u * each);
    TEST_ASSERT_FALSE(lode_drive6_telemetry(&rig.drive, &t));
    TEST_ASSERT_EQUAL_UINT32(3u * each, barriers); // and does not hold the thread up any longer
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_tuning_is_watched_by_its_own_sum_whenever_the_interrupt_comes);
    RUN_TEST(test_telemetry_is_of_one_period_or_says_that_it_is_not);
    return UNITY_END();
}
