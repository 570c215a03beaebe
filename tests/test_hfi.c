// Signal injection: what is designed, what is refused.
#include "support/fields.h"

#include "lodestar/hfi.h"

void setUp(void) {}

void tearDown(void) {}

typedef struct {
    lode_motor_t motor;
    lode_inverter_config_t inverter;
    lode_hfi_system_t system;
} machine_t;

/// Paper 1's motor and drive. The parts hold on to each other: made in place.
static void set_up(machine_t *machine) {
    machine->motor = paper_motor();
    machine->inverter = (lode_inverter_config_t){
        .v_bus_V = 200.0f, .i_max_A = 12.0f, .dead_time_s = 4.0e-6f, .v_drop_V = 1.0f};
    machine->system = (lode_hfi_system_t){
        .motor = &machine->motor,
        .inverter = &machine->inverter,
        .ts_s = PAPER_TS_s,
        .circle_V = 0.95f * 200.0f / LODE_SQRT3,
        .count_A = 50.0f / 4096.0f,
        .sigma_rad_s = 100.0f,
        .omega_max_rad_s = 1178.0f,
        .third_order = true,
    };
}

static lode_hfi_config_t designed(const machine_t *machine) {
    lode_hfi_config_t config = {.mode = LODE_HFI_ON};
    lode_hfi_design(&config, &machine->system);
    return config;
}

static lode_status_t tried(const lode_hfi_config_t *config, const machine_t *machine) {
    lode_hfi_tuning_t tuning;
    return lode_hfi_tune(&tuning, config, &machine->system);
}

#define CHECK_STATUS(name, got) TEST_ASSERT_EQUAL_STRING(#name, lode_status_name(got))

static void test_each_rule_sizes_the_voltage(void) {
    machine_t machine;
    set_up(&machine);
    // Noise: 1.2247/0.03 n Ld/Ts xi/(xi - 1) (H7).
    const double n = 1.6 * 50.0 / 4096.0;
    const double noise_V = sqrt(6.0) / 2.0 / 0.03 * n * 3.5e-3 / 2.0e-4 * 2.8 / 1.8;
    CHECK_NEAR(1.0e-3 * noise_V, noise_V, designed(&machine).V_h_V);
    // Ripple: 0.08 i_max peak to peak.
    machine.system.count_A = 0.0f;
    CHECK_NEAR(1.0e-4, 0.08 * 12.0 * 3.5e-3 / 2.0e-4, designed(&machine).V_h_V);
    // Dead time (H9): 0.3 V_h (xi - 1) = 200 V 4 us/Ts + 1 V.
    machine.motor.Lq_H = 1.5f * machine.motor.Ld_H;
    CHECK_NEAR(1.0e-3, 5.0 / (0.3 * 0.5), designed(&machine).V_h_V);
}

static void test_speeds_and_bandwidth(void) {
    machine_t machine;
    set_up(&machine);
    // Paper 1: 0.275 of 471.2 rad/s is more than (H10), 10 4/pi 0.2 5 V/psi = 89.7.
    lode_hfi_config_t config = designed(&machine);
    CHECK_NEAR(0.01, 0.275 * 471.23889, config.w2_rad_s);
    CHECK_NEAR(0.01, 0.65 * 0.275 * 471.23889, config.w1_rad_s);
    CHECK_NEAR(1.0e-6, 100.0, config.sigma_rad_s);
    machine.system.ts_s = 5.0e-5f; // 20 kHz: 17 V
    config = designed(&machine);
    CHECK_NEAR(0.1, 10.0 * 4.0 / 3.14159265 * 0.2 * 17.0 / 0.142, config.w2_rad_s);
}

static void test_differential_inductance_of_a_saturating_q_axis(void) {
    machine_t machine;
    set_up(&machine);
    machine.system.Lq_fall = 0.02f;
    CHECK_NEAR(1.0e-8, 9.8e-3 / (1.24 * 1.24), designed(&machine).Lq_i_max_H);
}

static void test_tuning_follows_from_the_configuration(void) {
    machine_t machine;
    set_up(&machine);
    lode_hfi_config_t config = designed(&machine);
    config.V_h_V = 25.0f;
    config.w1_rad_s = 80.0f;
    config.w2_rad_s = 130.0f;
    config.k_x_rad_A = 0.01f;
    lode_hfi_tuning_t tuning;
    CHECK_STATUS(LODE_OK, lode_hfi_tune(&tuning, &config, &machine.system));
    TEST_ASSERT_TRUE(tuning.on);
    CHECK_NEAR(1.0e-4, 2.0 * 25.0 * 1.8, tuning.full_V);
    CHECK_NEAR(1.0e-7, 0.02, tuning.inv_span);
    CHECK_NEAR(1.0e-9, 0.01, tuning.k_x);
    const double s = exp(-100.0 * 2.0e-4);
    CHECK_NEAR(1.0e-6, 1.0 - s * s * s, tuning.gains.theta);
    machine.system.third_order = false;
    CHECK_STATUS(LODE_OK, lode_hfi_tune(&tuning, &config, &machine.system));
    CHECK_NEAR(1.0e-6, 1.0 - s * s, tuning.gains.theta);
}

static void test_refusals(void) {
    machine_t machine;
    set_up(&machine);
    const lode_hfi_config_t good = designed(&machine);
    CHECK_STATUS(LODE_OK, tried(&good, &machine));
    static const struct {
        size_t offset;
        float value;
        lode_status_t error;
    } cases[] = {
        {offsetof(lode_hfi_config_t, Lq_i_max_H), 1.14f * 3.5e-3f, LODE_ERROR_HFI_SALIENCY},
        {offsetof(lode_hfi_config_t, Lq_i_max_H), NAN, LODE_ERROR_HFI_SALIENCY},
        {offsetof(lode_hfi_config_t, V_h_V), -1.0f, LODE_ERROR_HFI_VOLTAGE},
        {offsetof(lode_hfi_config_t, V_h_V), 55.0f, LODE_ERROR_HFI_VOLTAGE},
        {offsetof(lode_hfi_config_t, V_h_V), NAN, LODE_ERROR_HFI_VOLTAGE},
        {offsetof(lode_hfi_config_t, noise_A), -0.1f, LODE_ERROR_HFI_VOLTAGE},
        {offsetof(lode_hfi_config_t, noise_A), NAN, LODE_ERROR_HFI_VOLTAGE},
        {offsetof(lode_hfi_config_t, V_h_V), 5.5f, LODE_ERROR_HFI_DEAD_TIME}, // 0.505
        {offsetof(lode_hfi_config_t, w1_rad_s), 125.0f, LODE_ERROR_HFI_SPEEDS},
        {offsetof(lode_hfi_config_t, w1_rad_s), 0.0f, LODE_ERROR_HFI_SPEEDS},
        {offsetof(lode_hfi_config_t, w2_rad_s), 1200.0f, LODE_ERROR_HFI_SPEEDS},
        {offsetof(lode_hfi_config_t, w2_rad_s), NAN, LODE_ERROR_HFI_SPEEDS},
        {offsetof(lode_hfi_config_t, sigma_rad_s), 0.5f, LODE_ERROR_HFI_SIGMA},
        {offsetof(lode_hfi_config_t, sigma_rad_s), 1501.0f, LODE_ERROR_HFI_SIGMA},
        {offsetof(lode_hfi_config_t, k_x_rad_A), -0.05f, LODE_ERROR_HFI_AXIS},
        {offsetof(lode_hfi_config_t, k_x_rad_A), NAN, LODE_ERROR_HFI_AXIS},
    };
    for (int i = 0; i < COUNT_OF(cases); i++) {
        lode_hfi_config_t config = good;
        field_set(&config, cases[i].offset, cases[i].value);
        TEST_ASSERT_EQUAL_STRING(lode_status_name(cases[i].error),
                                 lode_status_name(tried(&config, &machine)));
        config.mode = LODE_HFI_OFF; // then nothing else matters
        CHECK_STATUS(LODE_OK, tried(&config, &machine));
    }
    lode_hfi_config_t config = good;
    config.mode = (lode_hfi_mode_t)3;
    CHECK_STATUS(LODE_ERROR_HFI_MODE, tried(&config, &machine));
    config = good;
    config.V_h_V = 5.6f; // 0.496
    CHECK_STATUS(LODE_OK, tried(&config, &machine));
    // The nominal inductances too, whatever is said of the differential one.
    machine.motor.Lq_H = machine.motor.Ld_H;
    config.Lq_i_max_H = 9.8e-3f;
    CHECK_STATUS(LODE_ERROR_HFI_SALIENCY, tried(&config, &machine));
}

static void test_auto_is_on_where_the_machine_allows_it(void) {
    machine_t machine;
    set_up(&machine);
    lode_hfi_config_t config = {.mode = LODE_HFI_AUTO};
    lode_hfi_design(&config, &machine.system);
    TEST_ASSERT_EQUAL_INT(LODE_HFI_ON, config.mode);
    machine.motor.Lq_H = 1.1f * machine.motor.Ld_H;
    config = (lode_hfi_config_t){.mode = LODE_HFI_AUTO};
    lode_hfi_design(&config, &machine.system);
    TEST_ASSERT_EQUAL_INT(LODE_HFI_OFF, config.mode);
    lode_hfi_tuning_t tuning;
    CHECK_STATUS(LODE_OK, lode_hfi_tune(&tuning, &config, &machine.system));
    TEST_ASSERT_FALSE(tuning.on);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_each_rule_sizes_the_voltage);
    RUN_TEST(test_speeds_and_bandwidth);
    RUN_TEST(test_differential_inductance_of_a_saturating_q_axis);
    RUN_TEST(test_tuning_follows_from_the_configuration);
    RUN_TEST(test_refusals);
    RUN_TEST(test_auto_is_on_where_the_machine_allows_it);
    return UNITY_END();
}
