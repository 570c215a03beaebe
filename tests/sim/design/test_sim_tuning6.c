// Six phases: the constants in C that the tool has written after a commissioning, to the bit, and a drive that starts
// with either.
#include "config/data_files.h"
#include "config/ini_config.h"
#include "design/tuning_fields.h"
#include "rig/rig.h"

#include "support/check.h"

#include <string.h>

#define SPEED_rad_s 90.0f // MECHANICAL; the drive hands over at 61

void setUp(void) {}

void tearDown(void) {}

/// By `lodestar commission --c`, with the files and keys below: CMakeLists.txt.
extern const lode_drive6_tuning_t commissioned6;
extern const lode_drive6_config_t commissioned6_config;

/// The motor that was measured, which is not the one of its data sheet.
static plant_config_t machine(void) {
    static const char *const differs[] = {"plant.Rs_Ohm=0.22", "plant.Lxy_H=2.4e-3",
                                          "plant.psi_Wb=0.185", "plant.theta0_deg=130"};
    static rig_config_t config;
    plant_config_t plant;
    double load_Nm;
    rig_config_init(&config);
    TEST_ASSERT_TRUE(data_files_load_part(&config, "motors", "ultrazohm6"));
    TEST_ASSERT_TRUE(data_files_load_part(&config, "drives", "ultrazohm6"));
    for (int k = 0; k < COUNT_OF(differs); k++) {
        TEST_ASSERT_TRUE(ini_config_set(&config, "--set", differs[k]));
    }
    TEST_ASSERT_TRUE(rig_config_complete(&config, RIG_NEED_BOARD));
    TEST_ASSERT_TRUE(rig_config_plant(&config, &plant, &load_Nm));
    return plant;
}

static void test_the_tuning_is_that_of_the_configuration(void) {
    static lode_drive6_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_tune(&tuning, &commissioned6_config));
#define COMPARE(kind, type, member)                                                                \
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&tuning.member, &commissioned6.member, sizeof tuning.member,  \
                                     #member);
#define COMPARE_BOTH(kind, type, member) COMPARE(kind, type, drive.member)
#define COMPARE_ALONE(kind, type, member) COMPARE(kind, type, alone.member)
    TUNING_FIELDS(COMPARE_BOTH)
    TUNING_FIELDS(COMPARE_ALONE)
    TUNING6_FIELDS(COMPARE)
    TEST_ASSERT_EQUAL_MEMORY(&tuning, &commissioned6, sizeof tuning); // and there is no other
}

static void test_what_was_measured_is_that_of_the_machine(void) {
    const plant_config_t plant = machine();
    const lode_motor_t *motor = &commissioned6_config.drive.motor;
    const lode_inverter_config_t *inverter = &commissioned6_config.drive.inverter;
    CHECK_CLOSE(0.02, plant.Rs_Ohm + plant.r_on_Ohm,
                (double)motor->Rs_Ohm + (double)inverter->r_on_Ohm);
    CHECK_CLOSE(0.05, plant.dead_time_s, inverter->dead_time_s);
    CHECK_CLOSE(0.05, plant.Ld_H, motor->Ld_H);
    CHECK_CLOSE(0.05, plant.Lq_H, motor->Lq_H);
    CHECK_CLOSE(0.05, 2.4e-3, commissioned6_config.Lxy_H);
    CHECK_CLOSE(0.01, 0.185, motor->psi_Wb);
    CHECK_CLOSE(0.10, plant.J_kgm2, motor->J_kgm2);
    CHECK_NEAR(0.0, 0.0, commissioned6_config.drive.references.Lq_fall);
}

static void test_what_was_told_is_as_it_was_told(void) {
    const lode_drive_config_t *drive = &commissioned6_config.drive;
    CHECK_NEAR(0.0, 10000.0, drive->f_pwm_Hz);
    CHECK_NEAR(0.0, 5.0, drive->motor.pole_pairs);
    CHECK_NEAR(0.0, 2.0, drive->motor.sets);
    CHECK_NEAR(0.0, 565.0, drive->inverter.v_bus_V);
    CHECK_NEAR(0.0, 30.0, drive->inverter.i_max_A);
    CHECK_NEAR(0.0, 120.0 / 4096.0, drive->sense.i_gain_A_count);
    CHECK_NEAR(0.0, 2048.0, drive->sense.i_offset_count);
    TEST_ASSERT_EQUAL_INT(LODE_EMF_FA_LESO, drive->estimator.emf.kind);
    CHECK_NEAR(0.0, LODE_NONE, drive->references.id_bias_A);
    TEST_ASSERT_EQUAL_INT(LODE_ON, drive->references.field_weakening);
    CHECK_NEAR(0.0, 0.08f, commissioned6_config.xy.voltage_share);
    TEST_ASSERT_EQUAL_INT(LODE_OPEN_PHASE_GO_ON, commissioned6_config.open_phase);
    // Nobody told these.
    CHECK_NEAR(0.0, 0.0, drive->current.bandwidth_rad_s);
    CHECK_NEAR(0.0, 0.0, commissioned6_config.xy.bandwidth_rad_s);
}

typedef struct {
    plant_t plant;
    lode_drive6_t drive;
    plant_truth_t truth;
    lode_drive6_out_t out;
} bench_t;

static void begin(bench_t *self, const plant_config_t *plant) {
    const lode_command_t run = {.mode = LODE_MODE_RUN, .speed_rad_s = SPEED_rad_s};
    TEST_ASSERT_NULL(plant_init(&self->plant, plant));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_command(&self->drive.drive, &run));
}

static void step(bench_t *self) {
    plant_counts_t sampled[PLANT_SETS];
    plant_sample(&self->plant, sampled, &self->truth);
    const lode_counts6_t counts = {{rig_counts(&sampled[0]), rig_counts(&sampled[1])}};
    self->out = lode_drive6_step(&self->drive, &counts);
    for (int set = 0; set < PLANT_SETS; set++) {
        rig_write_set(&self->plant, set, &self->out.set[set]);
    }
    plant_advance(&self->plant);
}

/// On the machine that was measured, from standstill to its speed: on the tuning as it lies in flash, and with the
/// configuration on the target.
static void test_a_drive_starts_with_either(void) {
    static bench_t flash, target;
    static lode_drive6_tuning_t tuning;
    const plant_config_t plant = machine();
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_begin(&flash.drive, &commissioned6));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_init(&target.drive, &tuning, &commissioned6_config));
    begin(&flash, &plant);
    begin(&target, &plant);
    do {
        step(&flash);
        step(&target);
        for (int set = 0; set < PLANT_SETS; set++) {
            TEST_ASSERT_EQUAL_MEMORY(&flash.out.set[set].duty, &target.out.set[set].duty,
                                     sizeof flash.out.set[set].duty);
            TEST_ASSERT_EQUAL(flash.out.set[set].gates, target.out.set[set].gates);
        }
    } while (flash.truth.t_s < 4.0);
    lode_telemetry6_t now;
    TEST_ASSERT_TRUE(lode_drive6_telemetry(&flash.drive, &now));
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_NONE", lode_check_name(now.drive.fault.check));
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, now.drive.mode);
    TEST_ASSERT_EQUAL_INT(LODE_SETS_BOTH, now.active);
    CHECK_CLOSE(0.02, SPEED_rad_s, flash.truth.omega_m_rad_s);
    const double off_rad = (double)now.drive.theta_rad - flash.truth.theta_e_rad;
    CHECK_NEAR(2.0 * CHECK_DEG, 0.0, remainder(off_rad, 2.0 * CHECK_PI));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_the_tuning_is_that_of_the_configuration);
    RUN_TEST(test_what_was_measured_is_that_of_the_machine);
    RUN_TEST(test_what_was_told_is_as_it_was_told);
    RUN_TEST(test_a_drive_starts_with_either);
    return UNITY_END();
}
