/// What the rig gives to a drive of six phases.
#include "config/data_files.h"
#include "config/ini_config.h"
#include "config/rig_config.h"

#include "support/check.h"

void setUp(void) {}

void tearDown(void) {}

/// As in firmware, one set alone is designed from what was given: another inductance has other gains. What the tool has
/// designed for both sets meanwhile says nothing about it.
static void test_one_set_alone_has_gains_of_its_own(void) {
    static rig_config_t config;
    char path[RIG_PATH_LENGTH];
    rig_config_init(&config);
    TEST_ASSERT_TRUE(data_files_find("scenarios", "dtp_open_phase", path, sizeof path));
    TEST_ASSERT_TRUE(ini_config_load_scenario(&config, path));
    TEST_ASSERT_TRUE(rig_config_complete(&config, RIG_NEED_DRIVE));
    static lode_drive6_tuning_t firmware;
    const lode_drive6_config_t given = rig_config_six(&config);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_tune(&firmware, &given));
    TEST_ASSERT_TRUE(firmware.alone.current.q.kp < 0.9f * firmware.drive.current.q.kp);
    rig_config_design(&config);
    static lode_drive6_tuning_t rig;
    const lode_drive6_config_t designed = rig_config_six(&config);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_tune(&rig, &designed));
    TEST_ASSERT_EQUAL_MEMORY(&firmware, &rig, sizeof rig);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_one_set_alone_has_gains_of_its_own);
    return UNITY_END();
}
