// A tuning that the tool wrote as a constant in C: every member to the bit, and a drive that runs on it.
#include "config/data_files.h"
#include "config/ini_config.h"
#include "design/tuning_fields.h"
#include "design/tuning_source.h"

#include "support/check.h"

#include <string.h>

void setUp(void) {}

void tearDown(void) {}

/// By `lodestar design --c`, with the files and keys below: CMakeLists.txt.
extern const lode_drive_tuning_t tuning_in_flash;
extern const lode_drive_config_t tuning_in_flash_config;

static lode_drive_config_t config_of_the_files(void) {
    static rig_config_t config;
    rig_config_init(&config);
    TEST_ASSERT_TRUE(data_files_load_part(&config, "motors", "traction_400V"));
    TEST_ASSERT_TRUE(data_files_load_part(&config, "drives", "traction_400V"));
    TEST_ASSERT_TRUE(ini_config_set(&config, "--set", "estimator.emf=fa-leso"));
    TEST_ASSERT_TRUE(ini_config_set(&config, "--set", "estimator.pll=enhanced"));
    TEST_ASSERT_TRUE(rig_config_complete(&config, RIG_NEED_MOTOR));
    return config.drive;
}

static void test_every_member_is_that_of_the_library(void) {
    const lode_drive_config_t config = config_of_the_files();
    lode_drive_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    int members = 0;
#define COMPARE(kind, type, member)                                                                \
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&tuning.member, &tuning_in_flash.member,                      \
                                     sizeof tuning.member, #member);                               \
    members++;
    TUNING_FIELDS(COMPARE)
    CHECK_AT_LEAST(150.0, members);
    TEST_ASSERT_EQUAL_INT(LODE_EMF_FA_LESO, tuning_in_flash.estimator.emf.observer.kind);
    TEST_ASSERT_TRUE(tuning_in_flash.estimator.notch.k > 0.0f);
}

static void test_its_configuration_is_that_of_the_files(void) {
    const lode_drive_config_t config = config_of_the_files();
    int fields = 0;
#define COMPARE_FIELD(kind, type, field)                                                           \
    TEST_ASSERT_TRUE_MESSAGE(config.field == tuning_in_flash_config.field, #field);                \
    fields++;
    CONFIG_FIELDS(COMPARE_FIELD)
    CHECK_AT_LEAST(110.0, fields);
    TEST_ASSERT_EQUAL_INT(LODE_EMF_FA_LESO, tuning_in_flash_config.estimator.emf.kind);
}

/// No byte is padding, whose value nobody knows.
static void test_every_byte_belongs_to_a_member(void) {
    static bool covered[sizeof(lode_drive_tuning_t)];
#define COVER(kind, type, member)                                                                  \
    for (size_t k = 0; k < sizeof tuning_in_flash.member; k++) {                                   \
        covered[offsetof(lode_drive_tuning_t, member) + k] = true;                                 \
    }
    TUNING_FIELDS(COVER)
    for (size_t k = 0; k < sizeof covered; k++) {
        TEST_ASSERT_TRUE(covered[k]);
    }
}

static void test_a_drive_runs_on_it(void) {
    const lode_drive_config_t config = config_of_the_files();
    lode_drive_tuning_t tuning;
    lode_drive_t drives[2];
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&drives[0], &tuning, &config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_begin(&drives[1], &tuning_in_flash));
    const lode_command_t run = {.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f};
    random_t random = random_seed(1);
    bool gates = false;
    for (int d = 0; d < 2; d++) {
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_command(&drives[d], &run));
    }
    for (int n = 0; n < 5000; n++) {
        lode_counts_t counts = {.v_bus = 2730, .temperature = 0};
        for (int k = 0; k < 3; k++) {
            counts.i[k] = (uint16_t)(2046u + random_bits(&random) % 5u);
        }
        const lode_drive_out_t a = lode_drive_step(&drives[0], &counts);
        const lode_drive_out_t b = lode_drive_step(&drives[1], &counts);
        TEST_ASSERT_EQUAL_MEMORY(&a.duty, &b.duty, sizeof a.duty);
        TEST_ASSERT_EQUAL(a.gates, b.gates);
        gates = gates || a.gates;
    }
    TEST_ASSERT_TRUE(gates);
}

static void test_the_name_comes_from_the_file(void) {
    char name[16];
    TEST_ASSERT_TRUE(tuning_source_name(name, sizeof name, "some.where/my_motor2.c"));
    TEST_ASSERT_EQUAL_STRING("my_motor2", name);
    TEST_ASSERT_TRUE(tuning_source_name(name, sizeof name, "m"));
    const char *const none[] = {"",           "folder/", "2motors.c",
                                "my-motor.c", ".c",      "sixteen_letters_.c"};
    for (int k = 0; k < COUNT_OF(none); k++) {
        TEST_ASSERT_FALSE(tuning_source_name(name, sizeof name, none[k]));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_every_member_is_that_of_the_library);
    RUN_TEST(test_its_configuration_is_that_of_the_files);
    RUN_TEST(test_every_byte_belongs_to_a_member);
    RUN_TEST(test_a_drive_runs_on_it);
    RUN_TEST(test_the_name_comes_from_the_file);
    return UNITY_END();
}
