// Signal injection: what is designed, what is refused; the position error by it, and the drive at no speed.
#include "support/fields.h"
#include "support/rig.h"

#include "drive_inline.h"
#include "drive_slots_inline.h"
#include "emf_inline.h"
#include "estimator_inline.h"
#include "hfi_inline.h"
#include "mode.h"
#include "modulator_inline.h"

#include <complex.h>

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
        .active_flux = true,
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
    // The mean current of two windings has less noise.
    machine.motor.sets = 2.0f;
    CHECK_CLOSE(1.0e-5, n / sqrt(2.0), designed(&machine).noise_A);
    machine.motor.sets = 1.0f;
    // Ripple: 0.08 i_max peak to peak.
    machine.system.count_A = 0.0f;
    CHECK_NEAR(1.0e-4, 0.08 * 12.0 * 3.5e-3 / 2.0e-4, designed(&machine).V_h_V);
    // A silent wave does without: dead time (H9), 0.3 V_h (xi - 1) = 5 V.
    lode_hfi_config_t silent = {.mode = LODE_HFI_ON, .silent = LODE_ON};
    lode_hfi_design(&silent, &machine.system);
    CHECK_NEAR(1.0e-3, 5.0 / (0.3 * 1.8), silent.V_h_V);
    // However little that is.
    machine_t quick;
    set_up(&quick);
    quick.system.count_A = 0.0f;
    quick.inverter.dead_time_s = 0.0f;
    quick.inverter.v_drop_V = 0.1f;
    lode_hfi_config_t little = {.mode = LODE_HFI_ON, .silent = LODE_ON};
    lode_hfi_design(&little, &quick.system);
    CHECK_NEAR(1.0e-4, 0.1 / (0.3 * 1.8), little.V_h_V);
    // Dead time (H9): 0.3 V_h (xi - 1) = 200 V 4 us/Ts + 1 V.
    machine.motor.Lq_H = 1.5f * machine.motor.Ld_H;
    CHECK_NEAR(1.0e-3, 5.0 / (0.3 * 0.5), designed(&machine).V_h_V);
}

/// Half of the circle at most, as long as noise gets half of what it asks for.
static void test_the_circle_limits_the_voltage(void) {
    machine_t machine;
    set_up(&machine);
    const double half_V = 0.5 * (double)machine.system.circle_V;
    const double per_V = sqrt(6.0) / 2.0 / 0.03 * 3.5e-3 / 2.0e-4 * 2.8 / 1.8;
    const double times[] = {0.99, 1.01, 1.99, 2.01};
    for (int n = 0; n < COUNT_OF(times); n++) {
        lode_hfi_config_t config = {.mode = LODE_HFI_AUTO};
        config.noise_A = (float)(times[n] * half_V / per_V);
        lode_hfi_design(&config, &machine.system);
        CHECK_CLOSE(1.0e-4, times[n] < 2.0 ? fmin(times[n], 1.0) * half_V : times[n] * half_V,
                    config.V_h_V);
        TEST_ASSERT_EQUAL_INT(times[n] < 2.0 ? LODE_HFI_ON : LODE_HFI_OFF, config.mode);
    }
    machine.motor.Lq_H = machine.motor.Ld_H; // no voltage shows a round rotor
    CHECK_NEAR(0.0, 0.0, designed(&machine).V_h_V);
    set_up(&machine);
    machine.system.count_A = 0.0f; // the dead band asks for 16.8 V
    machine.system.circle_V = 20.0f;
    machine.inverter.dead_time_s = 0.0f;
    CHECK_NEAR(1.0e-4, 10.0, designed(&machine).V_h_V);
}

static void test_speeds_and_bandwidth(void) {
    machine_t machine;
    set_up(&machine);
    // Paper 1: 0.275 of 471.2 rad/s is more than (H10), 10 4/pi 0.2 5 V/psi = 89.7.
    lode_hfi_config_t config = designed(&machine);
    CHECK_NEAR(0.01, 0.275 * 471.23889, config.w2_rad_s);
    CHECK_NEAR(0.01, 0.65 * 0.275 * 471.23889, config.w1_rad_s);
    CHECK_NEAR(1.0e-6, 100.0, config.sigma_rad_s);
    machine.system.sigma_rad_s = 165.0f; // that of the PLL
    CHECK_NEAR(1.0e-4, 165.0, designed(&machine).sigma_rad_s);
    machine.system.ts_s = 5.0e-5f; // 20 kHz: 17 V
    config = designed(&machine);
    CHECK_NEAR(0.1, 10.0 * 4.0 / 3.14159265 * 0.2 * 17.0 / 0.142, config.w2_rad_s);
}

static void test_learning_raises_the_speeds(void) {
    machine_t machine;
    set_up(&machine);
    lode_hfi_config_t config = {.mode = LODE_HFI_ON, .learn = LODE_ON};
    lode_hfi_design(&config, &machine.system);
    CHECK_NEAR(0.02, 0.65 * 471.23889, config.w2_rad_s);
    CHECK_NEAR(0.02, 0.65 * 0.65 * 471.23889, config.w1_rad_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, tried(&config, &machine));
    // Where the wave takes half of the circle, the rest of it is left to the EMF: 0.4 of 109.7 V, 0.154 Wb.
    config = (lode_hfi_config_t){.mode = LODE_HFI_ON, .learn = LODE_ON, .V_h_V = 54.8f};
    lode_hfi_design(&config, &machine.system);
    CHECK_NEAR(0.5, (0.9 * 109.70 - 54.8) / sqrt(0.142 * 0.142 + 0.0588 * 0.0588), config.w2_rad_s);
    config.learn = (lode_choice_t)7;
    CHECK_STATUS(LODE_ERROR_HFI_LEARN, tried(&config, &machine));
    config.mode = LODE_HFI_OFF;
    CHECK_STATUS(LODE_ERROR_HFI_LEARN, tried(&config, &machine));
    config.learn = LODE_ON; // there is nothing to learn from
    CHECK_STATUS(LODE_ERROR_HFI_LEARN, tried(&config, &machine));
    config = (lode_hfi_config_t){.mode = LODE_HFI_AUTO, .learn = LODE_ON};
    lode_hfi_design(&config, &machine.system);
    TEST_ASSERT_EQUAL_INT(LODE_ON, config.learn);
    machine.motor.Lq_H = machine.motor.Ld_H;
    config = (lode_hfi_config_t){.mode = LODE_HFI_AUTO, .learn = LODE_ON};
    lode_hfi_design(&config, &machine.system);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, config.learn);
    TEST_ASSERT_EQUAL_INT(LODE_OK, tried(&config, &machine));
    machine.motor = paper_motor();
    config = designed(&machine);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, config.learn);
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
    TEST_ASSERT_TRUE(lode_hfi_is_on(&tuning));
    const double full_V = 2.0 * 25.0 * 1.8;
    CHECK_NEAR(1.0e-8, 1.0 / full_V, tuning.inv_full);
    CHECK_NEAR(1.0e-3, 0.09 * full_V * full_V, tuning.least_V2);
    CHECK_NEAR(1.0e-7, 0.02, tuning.inv_span);
    CHECK_NEAR(1.0e-9, 0.01, tuning.k_x);
    const double s = exp(-100.0 * 2.0e-4);
    CHECK_NEAR(1.0e-6, 1.0 - s, tuning.find_gain);
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
        {offsetof(lode_hfi_config_t, sigma_rad_s), 501.0f, LODE_ERROR_HFI_SIGMA},
        {offsetof(lode_hfi_config_t, id_A), 12.1f, LODE_ERROR_ID_BIAS},
        {offsetof(lode_hfi_config_t, id_A), -1.1f, LODE_ERROR_ID_BIAS},
        {offsetof(lode_hfi_config_t, id_A), -0.9f, LODE_ERROR_ID_BIAS},
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
    TEST_ASSERT_EQUAL_INT(LODE_OFF, LODE_HFI_OFF); // one may be taken for the other
    TEST_ASSERT_EQUAL_INT(LODE_ON, LODE_HFI_ON);
    const int others[] = {LODE_HFI_DEFAULT, LODE_HFI_AUTO, 4}; // not completed, or none of them
    for (int n = 0; n < COUNT_OF(others); n++) {
        config.mode = (lode_hfi_mode_t)others[n];
        CHECK_STATUS(LODE_ERROR_HFI_MODE, tried(&config, &machine));
    }
    config = good;
    config.silent = (lode_choice_t)3;
    CHECK_STATUS(LODE_ERROR_CHOICE, tried(&config, &machine));
    config.silent = LODE_ON;
    CHECK_STATUS(LODE_OK, tried(&config, &machine));
    machine.system.active_flux = false;
    CHECK_STATUS(LODE_ERROR_HFI_FLUX, tried(&good, &machine));
    machine.system.active_flux = true;
    config = good;
    config.V_h_V = 5.6f; // 0.496
    CHECK_STATUS(LODE_OK, tried(&config, &machine));
    // The nominal inductances too, whatever is said of the differential one.
    machine.motor.Lq_H = machine.motor.Ld_H;
    config.Lq_i_max_H = 9.8e-3f;
    CHECK_STATUS(LODE_ERROR_HFI_SALIENCY, tried(&config, &machine));
}

/// The least and the largest that is taken.
static void test_limits_are_taken(void) {
    machine_t machine;
    set_up(&machine);
    static const struct {
        float w1_rad_s, w2_rad_s, sigma_rad_s;
        lode_status_t status;
    } cases[] = {
        {0.1f, 1.0f, 1.0f, LODE_OK},
        {0.95f * 1178.0f, 1178.0f, 100.0f, LODE_OK},
        {0.1f, 0.99f, 1.0f, LODE_ERROR_HFI_SPEEDS},
        {0.099f, 1.0f, 1.0f, LODE_ERROR_HFI_SPEEDS},
        {0.1f, 1.0f, 0.99f, LODE_ERROR_HFI_SIGMA},
    };
    for (int n = 0; n < COUNT_OF(cases); n++) {
        lode_hfi_config_t config = designed(&machine);
        config.w1_rad_s = cases[n].w1_rad_s;
        config.w2_rad_s = cases[n].w2_rad_s;
        config.sigma_rad_s = cases[n].sigma_rad_s;
        TEST_ASSERT_EQUAL_STRING(lode_status_name(cases[n].status),
                                 lode_status_name(tried(&config, &machine)));
    }
}

static void test_auto_is_on_where_the_machine_allows_it(void) {
    machine_t machine;
    set_up(&machine);
    lode_hfi_config_t config = {.mode = LODE_HFI_AUTO};
    lode_hfi_design(&config, &machine.system);
    TEST_ASSERT_EQUAL_INT(LODE_HFI_ON, config.mode);
    const float small[] = {1.1f, 1.0f, 0.9f};
    for (int k = 0; k < COUNT_OF(small); k++) {
        machine.motor.Lq_H = small[k] * machine.motor.Ld_H;
        config = (lode_hfi_config_t){.mode = LODE_HFI_AUTO};
        lode_hfi_design(&config, &machine.system);
        TEST_ASSERT_EQUAL_INT(LODE_HFI_OFF, config.mode);
    }
    lode_hfi_tuning_t tuning;
    CHECK_STATUS(LODE_OK, lode_hfi_tune(&tuning, &config, &machine.system));
    TEST_ASSERT_FALSE(lode_hfi_is_on(&tuning));
}

/// (S54): where a current vector starts the rotor, nothing is injected by default; nor where the machine does not allow it.
static void test_the_default_is_on_where_a_vector_is_weak(void) {
    machine_t machine;
    set_up(&machine);
    const float limit_Wb =
        1.5f * 0.8f * 2.0f / 3.0f * 12.0f * 6.3e-3f; // load current times Lq - Ld
    const struct {
        float psi_Wb, Lq_H;
        lode_hfi_mode_t mode;
    } cases[] = {{1.01f * limit_Wb, 9.8e-3f, LODE_HFI_OFF},
                 {0.99f * limit_Wb, 9.8e-3f, LODE_HFI_ON},
                 {1.0e-4f, 3.6e-3f, LODE_HFI_OFF}, // too little saliency
                 {1.0e-4f, 3.5e-3f, LODE_HFI_OFF}};
    for (int k = 0; k < COUNT_OF(cases); k++) {
        machine.motor.psi_Wb = cases[k].psi_Wb;
        machine.motor.Lq_H = cases[k].Lq_H;
        lode_hfi_config_t config = {.V_h_V = 25.0f, .w1_rad_s = 80.0f, .w2_rad_s = 130.0f};
        lode_hfi_design(&config, &machine.system);
        TEST_ASSERT_EQUAL_INT(cases[k].mode, config.mode);
    }
}

static void test_id_that_saturates_the_d_axis_where_saliency_is_small(void) {
    machine_t machine;
    set_up(&machine);
    CHECK_NEAR(0.0, (double)LODE_NONE, designed(&machine).id_A);
    machine.motor.Lq_H = 1.4f * machine.motor.Ld_H;
    CHECK_NEAR(1.0e-5, 3.6, designed(&machine).id_A);
}

/// A linear machine at rest on held mean voltages, seen from an angle that is off.
typedef struct {
    ipmsm_t motor;
    lode_emf_t emf;
    lode_emf_tuning_t emf_tuning;
    lode_hfi_t hfi;
    lode_hfi_tuning_t tuning;
    lode_sincos_t seen; ///< the drive's angle
    float swing_V;      ///< H in the last period
} bench_t;

static void bench_init(bench_t *b, double xi, double V_h, double Ld_factor, double off_rad) {
    machine_t machine;
    set_up(&machine);
    b->motor = ipmsm_paper(0.0);
    b->motor.Lq = xi * b->motor.Ld;
    machine.motor.Lq_H = (float)b->motor.Lq;
    machine.motor.Ld_H = (float)(Ld_factor * b->motor.Ld);
    machine.inverter.dead_time_s = machine.inverter.v_drop_V = 0.0f;
    machine.system.circle_V = 1000.0f;
    lode_hfi_config_t config = {
        .mode = LODE_HFI_ON, .V_h_V = (float)V_h, .Lq_i_max_H = 9.8e-3f, .noise_A = 0.01f};
    lode_hfi_design(&config, &machine.system);
    CHECK_STATUS(LODE_OK, lode_hfi_tune(&b->tuning, &config, &machine.system));
    lode_emf_config_t emf = {.kind = LODE_EMF_C_LESO};
    lode_emf_design(&emf, &machine.motor, 100.0f, PAPER_TS_s);
    CHECK_STATUS(LODE_OK,
                 lode_emf_tune(&b->emf_tuning, &emf, &machine.motor, 0.0f, true, PAPER_TS_s));
    lode_emf_reset(&b->emf, (lode_ab_t){0.0f, 0.0f});
    b->hfi = (lode_hfi_t){.signs = 0u};
    b->seen = lode_sincos((float)(b->motor.theta - off_rad));
}

/// A period of the wave on top of (ud, uq) as the drive sees it.
static void bench_step(bench_t *b, double ud, double uq) {
    const lode_dq_t u_dq =
        lode_hfi_add_wave(&b->hfi, &b->tuning, (lode_dq_t){(float)ud, (float)uq});
    const lode_ab_t u = lode_park_inverse(u_dq, b->seen);
    ipmsm_step(&b->motor, (double)u.alpha, (double)u.beta, (double)PAPER_TS_s);
    const lode_ab_t i = ipmsm_current(&b->motor);
    const lode_ab_t m = lode_emf_dead_beat(&b->emf, &b->emf_tuning, u, i);
    b->hfi.sum_V = 0.0f;
    lode_hfi_demodulate(&b->hfi, &b->tuning, b->emf_tuning.salient_Ohm, lode_park(m, b->seen),
                        lode_park(i, b->seen));
    b->swing_V = b->hfi.sum_V;
    (void)lode_hfi_less_ripple(&b->hfi, lode_park(i, b->seen));
}

/// Steps of the voltage on both axes at random, as current control would make them; least and largest e_h/off
/// of the periods with enough excitation, and their mean.
typedef struct {
    double least, most, mean;
} gains_t;

static gains_t bench_gains(bench_t *b, double off_rad, double step_V) {
    gains_t gains = {1.0e9, -1.0e9, 0.0};
    random_t random = random_seed(1u);
    int count = 0;
    for (int k = 0; k < 2000; k++) {
        // Less what brings the currents back: the steps would add up.
        bench_step(b, random_between(&random, -step_V, step_V) - 2.0 * b->motor.id,
                   random_between(&random, -step_V, step_V) - 2.0 * b->motor.iq);
        if (k < 10 || (double)(b->swing_V * b->tuning.inv_full) < 0.3) {
            continue;
        }
        const double gain = (double)b->hfi.error / off_rad;
        gains.least = fmin(gains.least, gain);
        gains.most = fmax(gains.most, gain);
        gains.mean += gain;
        count++;
    }
    gains.mean /= count;
    return gains;
}

static const double saliencies[] = {1.2, 1.5, 2.0, 2.8, 3.0};
static const double waves_V[] = {10.0, 30.0, 100.0};

static void test_no_error_shows_at_the_right_angle_whatever_the_voltage_does(void) {
    for (int s = 0; s < COUNT_OF(saliencies); s++) {
        for (int v = 0; v < COUNT_OF(waves_V); v++) {
            bench_t b;
            bench_init(&b, saliencies[s], waves_V[v], 1.0, 0.0);
            const gains_t gains = bench_gains(&b, 1.0, 30.0);
            // What rounding leaves of some 500 V in the dead-beat EMF, beside the least H that counts.
            const double bound = 4.0e-5 / 0.3 * (double)b.tuning.inv_full;
            CHECK_NEAR(bound, 0.0, gains.least);
            CHECK_NEAR(bound, 0.0, gains.most);
        }
    }
}

static void test_gain_of_the_position_error(void) {
    for (int s = 0; s < COUNT_OF(saliencies); s++) {
        for (int v = 0; v < COUNT_OF(waves_V); v++) {
            bench_t b;
            bench_init(&b, saliencies[s], waves_V[v], 1.0, 0.05);
            const gains_t gains = bench_gains(&b, 0.05, 30.0);
            CHECK_NEAR(0.005, 1.0, gains.mean);
            // The term of second order: off times the second difference of iq over that of id.
            const double spread = 0.05 * 1.5 * (1.0 + 60.0 / waves_V[v]) / 0.3;
            TEST_ASSERT_TRUE(gains.least > 1.0 - spread && gains.most < 1.0 + spread);
        }
    }
}

static void test_wrong_Ld_scales_the_gain(void) {
    for (int s = 0; s < COUNT_OF(saliencies); s++) {
        for (int v = 0; v < 2; v++) {
            bench_t b;
            const double factor = v == 0 ? 0.95 : 1.05;
            bench_init(&b, saliencies[s], 50.0, factor, 0.05);
            const gains_t gains = bench_gains(&b, 0.05, 30.0);
            CHECK_NEAR(0.005, (saliencies[s] - 1.0) / (saliencies[s] - factor), gains.mean);
        }
    }
}

static void test_without_excitation_there_is_no_error(void) {
    bench_t b;
    bench_init(&b, 2.8, 25.0, 1.0, 0.05);
    b.tuning.V_h_V = 0.0f;
    for (int k = 0; k < 10; k++) {
        bench_step(&b, 0.0, 0.0);
        CHECK_NEAR(1.0e-7, 0.0, b.hfi.error);
    }
}

static lode_hfi_tuning_t paper_tuning(void) {
    machine_t machine;
    set_up(&machine);
    lode_hfi_config_t config = designed(&machine);
    config.V_h_V = 25.0f;
    config.w1_rad_s = 80.0f;
    config.w2_rad_s = 130.0f;
    config.k_x_rad_A = 0.01f;
    lode_hfi_tuning_t tuning;
    CHECK_STATUS(LODE_OK, lode_hfi_tune(&tuning, &config, &machine.system));
    return tuning;
}

static void test_begins_and_ends_with_the_speed(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    const lode_dq_t none = {0.0f, 0.0f};
    lode_hfi_t hfi = {.active = false};
    TEST_ASSERT_FALSE(lode_hfi_follow(&hfi, &tuning, none, 131.0f));
    TEST_ASSERT_FALSE(hfi.active);
    TEST_ASSERT_TRUE(lode_hfi_follow(&hfi, &tuning, none, -129.0f));
    TEST_ASSERT_TRUE(hfi.active);
    CHECK_NEAR(1.0e-6, 0.02, hfi.weight);
    (void)lode_hfi_follow(&hfi, &tuning, none, 105.0f);
    CHECK_NEAR(1.0e-6, 0.5, hfi.weight);
    (void)lode_hfi_follow(&hfi, &tuning, none, -70.0f);
    CHECK_NEAR(0.0, 1.0, hfi.weight);
    (void)lode_hfi_follow(&hfi, &tuning, none, 136.0f); // within 5 %
    TEST_ASSERT_TRUE(hfi.active);
    CHECK_NEAR(0.0, 0.0, hfi.weight);
    TEST_ASSERT_FALSE(lode_hfi_follow(&hfi, &tuning, none, 137.0f));
    (void)lode_hfi_follow(&hfi, &tuning, none, 0.0f);
    TEST_ASSERT_FALSE(lode_hfi_follow(&hfi, &tuning, none, NAN));
}

/// Begun by the speed, cross-saturation counts from the current that flows.
static void test_begins_with_the_axis_of_its_current(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    lode_hfi_t hfi = {.active = false};
    TEST_ASSERT_TRUE(lode_hfi_follow(&hfi, &tuning, (lode_dq_t){1.0f, 6.0f}, 50.0f));
    CHECK_NEAR(1.0e-4, tan(0.01 * 6.0), hfi.axis);
    hfi.i_A.q = -2.0f; // which it follows
    TEST_ASSERT_TRUE(lode_hfi_follow(&hfi, &tuning, (lode_dq_t){0.0f, 0.0f}, 50.0f));
    const double iq_A = -2.0 + 8.0 * exp(-500.0 * (double)LODE_SLOW_PERIODS * (double)PAPER_TS_s);
    CHECK_NEAR(1.0e-4, tan(0.01 * iq_A), hfi.axis);
}

/// Seen from half a turn on, currents and voltages change their signs; the error of the position is the same.
static void test_half_a_turn_on_the_error_is_the_same(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    lode_hfi_t ahead;
    lode_hfi_begin(&ahead, &tuning, (lode_dq_t){1.0f, 2.0f});
    lode_hfi_demodulate(&ahead, &tuning, 20.0f, (lode_dq_t){3.0f, 4.0f}, (lode_dq_t){1.7f, 2.2f});
    (void)lode_hfi_less_ripple(&ahead, (lode_dq_t){1.7f, 2.2f});
    ahead.of.iq_A = 2.5f;
    lode_hfi_t behind = ahead;
    lode_hfi_turn_round(&behind);
    CHECK_NEAR(0.0, -2.5, behind.of.iq_A);
    lode_hfi_demodulate(&ahead, &tuning, 20.0f, (lode_dq_t){-2.0f, 9.0f}, (lode_dq_t){0.8f, 1.9f});
    lode_hfi_demodulate(&behind, &tuning, 20.0f, (lode_dq_t){2.0f, -9.0f},
                        (lode_dq_t){-0.8f, -1.9f});
    CHECK_AT_LEAST(0.01, fabs((double)ahead.error));
    CHECK_NEAR(1.0e-7, ahead.error, behind.error);
    const lode_dq_t a = lode_hfi_less_ripple(&ahead, (lode_dq_t){0.8f, 1.9f});
    const lode_dq_t b = lode_hfi_less_ripple(&behind, (lode_dq_t){-0.8f, -1.9f});
    CHECK_NEAR(0.0, -a.d, b.d);
    CHECK_NEAR(0.0, -a.q, b.q);
}

static void test_both_errors_are_weighted(void) {
    lode_hfi_t hfi = {.error = 0.1f, .weight = 0.75f};
    CHECK_NEAR(1.0e-7, 0.75 * 0.1 - 0.25 * 0.2, lode_hfi_blend(&hfi, -0.2f));
    CHECK_NEAR(1.0e-7, 0.75 * 0.1 + 0.25 * 0.3, lode_hfi_blend(&hfi, 0.3f));
}

static void test_the_ripple_drops_out(void) {
    lode_hfi_t hfi = {.i_A = {1.5f, 4.0f}};
    const lode_dq_t mean = lode_hfi_less_ripple(&hfi, (lode_dq_t){0.5f, 4.0f});
    CHECK_NEAR(1.0e-7, 1.0, mean.d);
    CHECK_NEAR(1.0e-7, 4.0, mean.q);
    CHECK_NEAR(0.0, 0.5, hfi.i_A.d);
}

/// Of a pair the current is taken at its ends, and the error from its middle to its end (H22).
static void test_pairs_of_waves(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    lode_hfi_t hfi = {.signs = LODE_HFI_FIRST | 1u, .i_A = {0.5f, 4.0f}};
    lode_dq_t i_A = lode_hfi_less_ripple(&hfi, (lode_dq_t){0.6f, 4.1f}); // between two pairs
    CHECK_NEAR(1.0e-7, 0.6, i_A.d);
    CHECK_NEAR(1.0e-7, 4.1, i_A.q);
    lode_hfi_demodulate(&hfi, &tuning, 1.0f, (lode_dq_t){0.0f, -2.0f}, (lode_dq_t){-99.4f, 4.1f});
    CHECK_NEAR(1.0e-6, 0.02, hfi.error); // 2 V of 100
    CHECK_NEAR(1.0e-4, 200.0, hfi.sum_V);
    hfi.signs = 1u; // in its middle
    i_A = lode_hfi_less_ripple(&hfi, (lode_dq_t){2.0f, 4.2f});
    CHECK_NEAR(1.0e-7, 0.6, i_A.d);
    const float held = hfi.error;
    lode_hfi_demodulate(&hfi, &tuning, 1.0f, (lode_dq_t){0.0f, 5.0f}, (lode_dq_t){50.0f, 4.0f});
    TEST_ASSERT_EQUAL_FLOAT(held, hfi.error);
    CHECK_NEAR(1.0e-4, 200.0, hfi.sum_V);
    CHECK_NEAR(1.0e-4, 5.0, hfi.q_V); // what the next one is compared with
}

/// Share of the wave's power in the strongest of 128 bands of it.
static double strongest_band(bool silent) {
    enum { BANDS = 128, SPAN = 2 * BANDS, SPANS = 128 };
    double power[BANDS + 1] = {0.0};
    machine_t machine;
    set_up(&machine);
    lode_hfi_config_t config = designed(&machine);
    config.V_h_V = 25.0f;
    config.silent = silent ? LODE_ON : LODE_OFF;
    lode_hfi_tuning_t tuning;
    CHECK_STATUS(LODE_OK, lode_hfi_tune(&tuning, &config, &machine.system));
    lode_hfi_t hfi;
    lode_hfi_begin(&hfi, &tuning, (lode_dq_t){0.0f, 0.0f});
    double sum = 0.0;
    for (int n = 0; n < SPANS; n++) {
        double wave[SPAN];
        for (int k = 0; k < SPAN; k++) {
            wave[k] = (double)lode_hfi_add_wave(&hfi, &tuning, (lode_dq_t){0.0f, 0.0f}).d;
            CHECK_NEAR(1.0e-5, 25.0, fabs(wave[k]));
            // The second of a pair takes back what the first has done.
            CHECK_NEAR(1.0e-5, 0.0, k % 2 == 0 ? 0.0 : wave[k] + wave[k - 1]);
        }
        for (int f = 0; f <= BANDS; f++) {
            double _Complex at = 0.0;
            for (int k = 0; k < SPAN; k++) {
                at += wave[k] * cexp(-I * CHECK_PI * f * k / (double)BANDS);
            }
            power[f] += creal(at * conj(at));
            sum += creal(at * conj(at));
        }
    }
    double most = 0.0;
    for (int f = 0; f <= BANDS; f++) {
        most = fmax(most, power[f]);
    }
    return most / sum;
}

static void test_no_tone_stands_out_of_a_silent_wave(void) {
    CHECK_NEAR(1.0e-9, 1.0, strongest_band(false));
    CHECK_AT_MOST(0.03, strongest_band(true)); // of 129 bands, 0.016 at the middle of (H23)
}

/// How many of 40 waves have the sign of the one before.
static int repeats(lode_hfi_t *hfi, const lode_hfi_tuning_t *tuning) {
    int count = 0;
    float before = 0.0f;
    for (int k = 0; k < 40; k++) {
        const float wave = lode_hfi_add_wave(hfi, tuning, (lode_dq_t){0.0f, 0.0f}).d;
        count += wave * before > 0.0f ? 1 : 0;
        before = wave;
    }
    return count;
}

/// A tuning that is taken while the wave runs decides whether it is a tone, in either direction; the same one changes nothing.
static void test_a_running_wave_takes_another_tuning(void) {
    lode_hfi_tuning_t tone = paper_tuning();
    lode_hfi_tuning_t silent = tone;
    tone.silent = 0u;
    silent.silent = 1u;
    const lode_dq_t none_A = {0.0f, 0.0f};
    lode_hfi_t hfi;
    lode_hfi_begin(&hfi, &tone, none_A);
    TEST_ASSERT_EQUAL_INT(0, repeats(&hfi, &tone));
    TEST_ASSERT_TRUE(lode_hfi_follow(&hfi, &silent, none_A, 1.0f));
    TEST_ASSERT_TRUE(repeats(&hfi, &silent) > 5);
    const uint32_t signs = hfi.signs;
    TEST_ASSERT_TRUE(lode_hfi_follow(&hfi, &silent, none_A, 1.0f));
    TEST_ASSERT_EQUAL_UINT32(signs, hfi.signs);
    // In the middle of a pair too: the wave goes on with the other sign.
    for (int odd = 0; odd <= 1; odd++) {
        hfi.signs = LODE_HFI_NEGATIVE | (odd == 1 ? LODE_HFI_FIRST : 0u) | 1u;
        TEST_ASSERT_TRUE(lode_hfi_follow(&hfi, &tone, none_A, 1.0f));
        TEST_ASSERT_EQUAL_UINT32(LODE_HFI_NEGATIVE, hfi.signs);
        TEST_ASSERT_EQUAL_INT(0, repeats(&hfi, &tone));
        TEST_ASSERT_TRUE(lode_hfi_follow(&hfi, &tone, none_A, 1.0f));
        TEST_ASSERT_EQUAL_INT(0, repeats(&hfi, &tone));
    }
}

static void test_cross_saturation_turns_the_axis(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    lode_hfi_t hfi = {.active = false};
    const lode_dq_t i_A = {0.0f, -8.0f};
    for (int k = 0; k < 100; k++) {
        (void)lode_hfi_follow(&hfi, &tuning, i_A, 0.0f);
    }
    CHECK_NEAR(1.0e-6, tan(-0.08), hfi.axis);
    const lode_dq_t u_V = lode_hfi_add_wave(&hfi, &tuning, (lode_dq_t){1.0f, 2.0f});
    CHECK_NEAR(1.0e-5, 1.0 - 25.0, u_V.d);
    CHECK_NEAR(1.0e-4, 2.0 - 25.0 * tan(-0.08), u_V.q);
    CHECK_NEAR(1.0e-5, 1.0 + 25.0, lode_hfi_add_wave(&hfi, &tuning, (lode_dq_t){1.0f, 2.0f}).d);
    // Regressor and error are seen along it and across: only their ratio counts.
    hfi = (lode_hfi_t){.axis = hfi.axis, .h_V = 0.0f, .i_A = i_A};
    const float turn = 0.02f;
    const lode_dq_t now_A = {i_A.d + cosf(-0.08f), i_A.q + sinf(-0.08f)}; // an ampere more
    lode_hfi_demodulate(&hfi, &tuning, 60.0f,
                        (lode_dq_t){60.0f * cosf(-0.08f + turn), 60.0f * sinf(-0.08f + turn)},
                        now_A);
    CHECK_NEAR(2.0e-5, tan(0.02) * cos(0.02), hfi.error);
}

static void test_an_error_that_none_can_be_is_limited(void) {
    lode_estimator_t estimator = {.by.hfi = {.active = true}};
    CHECK_NEAR(0.0, 0.5, lode_estimator_limit(&estimator, 7.0f));
    CHECK_NEAR(0.0, -0.5, lode_estimator_limit(&estimator, -7.0f));
    estimator.emf.observer.e_V.beta = 2.0e6f; // more than any motor's
    TEST_ASSERT_TRUE(lode_estimator_limit(&estimator, 0.1f) > 1.1f);
    estimator.emf.observer.e_V.beta = NAN;
    TEST_ASSERT_TRUE(lode_estimator_limit(&estimator, NAN) > 1.1f);
}

static void test_quality_falls_with_the_response_and_with_the_error(void) {
    const lode_hfi_tuning_t tuning = paper_tuning(); // H0 is 90 V
    lode_hfi_t hfi = {.sum_V = 8.0f * 90.0f};
    CHECK_NEAR(1.0e-6, 1.0, lode_hfi_quality(&hfi, &tuning, 0.2f));
    CHECK_NEAR(1.0e-5, 90.0, hfi.swing_V);
    hfi.sum_V = 8.0f * 120.0f;
    CHECK_NEAR(1.0e-6, 1.0, lode_hfi_quality(&hfi, &tuning, 0.2f));
    hfi.sum_V = 8.0f * 45.0f;
    CHECK_NEAR(1.0e-6, 0.5, lode_hfi_quality(&hfi, &tuning, 0.2f));
    hfi.sum_V = 8.0f * 45.0f;
    hfi.error = -0.35f;
    CHECK_NEAR(1.0e-6, 0.5 * 0.8, lode_hfi_quality(&hfi, &tuning, 0.2f));
    // Where nothing answers any more there is none.
    CHECK_NEAR(0.0, 0.0, lode_hfi_quality(&hfi, &tuning, 0.2f));
    hfi.error = 0.5f;
    for (int k = 0; k < 100; k++) {
        (void)lode_hfi_quality(&hfi, &tuning, 0.2f);
    }
    hfi.sum_V = 8.0f * 90.0f;
    CHECK_NEAR(0.0, 0.0, lode_hfi_quality(&hfi, &tuning, 0.2f));
}

/// Paper 1's motor with injection in RUN at 300 rpm, from an I-f start.
static lode_drive_tuning_t rig_tuning;

static void rig_running_with(rig_t *rig, lode_pll_kind_t pll, lode_choice_t plausibility) {
    lode_drive_config_t config = rig_config();
    config.hfi.mode = LODE_HFI_ON;
    config.hfi.V_h_V = 25.0f;
    config.estimator.pll.kind = pll;
    config.guard.plausibility = plausibility;
    rig_init(rig, &rig_tuning, &config);
    rig_command(rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 31.4f});
    rig_run(rig, 2.0);
    rig_expect(rig, LODE_MODE_RUN);
    CHECK_NEAR(1.0, 31.4, rig->motor.omega / 3.0);
}

static void rig_running(rig_t *rig, lode_pll_kind_t pll) {
    rig_running_with(rig, pll, LODE_ON);
}

/// Worst position error (rad) of the next `seconds`.
static double rig_worst(rig_t *rig, double seconds) {
    worst_t worst = {0.0};
    for (int k = 0; k < (int)(seconds / RIG_TS_s); k++) {
        rig_step(rig);
        worst_note(&worst, rig->angle_error);
    }
    return worst.value;
}

static void rig_ask(rig_t *rig, float speed_rad_s) {
    rig_command(rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = speed_rad_s});
}

static void test_full_torque_at_no_speed_and_reversal(void) {
    static rig_t rig;
    // Without a disturbance state a step of the load turns the angle by A/sigma^2 (P7): 1.8 degrees and more.
    static const struct {
        lode_pll_kind_t pll;
        double step_deg;
    } kinds[] = {{LODE_PLL_LESO, 3.6}, {LODE_PLL_QPLL, 6.5}};
    for (int k = 0; k < COUNT_OF(kinds); k++) {
        rig_running(&rig, kinds[k].pll);
        rig_ask(&rig, 0.0f);
        rig_run(&rig, 1.0);
        CHECK_AT_MOST(1.0 * CHECK_DEG, rig_worst(&rig, 0.5));
        for (int sign = -1; sign <= 1; sign += 2) {
            rig.pull_Nm = 5.0 * sign;
            CHECK_AT_MOST(kinds[k].step_deg * CHECK_DEG, rig_worst(&rig, 0.7));
            CHECK_AT_MOST(1.0 * CHECK_DEG, rig_worst(&rig, 0.5));
        }
        CHECK_NEAR(2.0, 0.0, rig.motor.omega / 3.0); // and comes back
        rig_ask(&rig, -6.3f);
        CHECK_AT_MOST(6.0 * CHECK_DEG, rig_worst(&rig, 1.0));
        rig_ask(&rig, -62.8f); // the EMF takes over
        CHECK_AT_MOST(8.0 * CHECK_DEG, rig_worst(&rig, 2.0));
        TEST_ASSERT_FALSE(rig.drive.estimator.by.hfi.active);
        CHECK_NEAR(1.0, -62.8, rig.motor.omega / 3.0);
        rig_expect(&rig, LODE_MODE_RUN);
    }
}

static void test_a_silent_drive_holds_the_rotor(void) {
    static rig_t rig;
    lode_drive_config_t config = rig_config();
    config.hfi = (lode_hfi_config_t){.mode = LODE_HFI_ON, .V_h_V = 25.0f, .silent = LODE_ON};
    rig_init(&rig, &rig_tuning, &config);
    rig.motor.Ld_per_A = -0.05 * rig.motor.Ld / 8.0;
    rig.motor.theta = 2.5;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 0.0f});
    rig_run(&rig, 0.5);
    rig_expect(&rig, LODE_MODE_RUN);
    double worst = 0.0;
    for (int sign = -1; sign <= 1; sign += 2) {
        rig.pull_Nm = 5.0 * sign;
        for (int k = 0; k < 5000; k++) {
            rig_step(&rig);
            worst = fmax(worst, fabs(rig.angle_error));
        }
        CHECK_NEAR(0.2, (double)rig.drive.ref_A.d, (double)rig.drive.i_A.d); // no ripple of 1.4 A
    }
    CHECK_AT_MOST(3.6 * CHECK_DEG, worst); // as where the signs alternate
    CHECK_NEAR(2.0, 0.0, rig.motor.omega / 3.0);
}

/// Duties for the voltage of the last period, whose dead time is corrected by the current `i_A`.
static lode_abc_t duties_by(const lode_drive_t *drive, const lode_drive_t *before, lode_dq_t i_A) {
    const lode_sincos_t applied =
        lode_angle_add(lode_estimator_rotor(&drive->estimator), before->lead);
    const bool negative = (drive->estimator.by.hfi.signs & LODE_HFI_NEGATIVE) != 0u;
    const float wave_V = (negative ? -1.0f : 1.0f) * drive->tuning->estimator.hfi.V_h_V;
    const lode_dq_t u_V = {drive->u_V.d + wave_V, drive->u_V.q};
    const lode_ab_t v = lode_ab_scale(drive->inverter.per_V, lode_park_inverse(u_V, applied));
    return lode_modulator_step(&drive->tuning->inverter, &before->inverter.dead_time, v,
                               lode_park_inverse(i_A, applied), false)
        .duty;
}

static double apart(lode_abc_t x, lode_abc_t y) {
    return fmax(fabs((double)(x.a - y.a)),
                fmax(fabs((double)(x.b - y.b)), fabs((double)(x.c - y.c))));
}

// (H19): the measured current is two periods old.
static void test_dead_time_by_the_current_that_is_asked_for(void) {
    static rig_t rig;
    lode_drive_config_t config = rig_config();
    config.hfi.mode = LODE_HFI_ON;
    config.hfi.V_h_V = 25.0f;
    config.inverter.dead_time_s = 1.0e-6f; // the motor has none ...
    config.start.measure = LODE_OFF;       // ... and the start is not to find that out
    rig_init(&rig, &rig_tuning, &config);
    rig_ask(&rig, 31.4f); // the way of a linear motor, by an I-f start
    rig_run(&rig, 3.0);
    rig_ask(&rig, 10.0f);
    rig_run(&rig, 1.0);
    rig_expect(&rig, LODE_MODE_RUN);
    TEST_ASSERT_TRUE(rig.drive.estimator.by.hfi.active);
    double far = 0.0;
    for (int k = 0; k < 2000; k++) {
        const lode_drive_t before = rig.drive;
        rig_step(&rig);
        const lode_drive_t *drive = &rig.drive;
        // Lock and lag renew the angle after the duties, fast speed control the reference before them.
        const lode_slot_t slot = lode_slot_of(before.steps);
        if (slot != SLOT_LOCK && slot != SLOT_LAG && slot % 4 != 3) {
            CHECK_AT_MOST(1.0e-5, apart(drive->duty, duties_by(drive, &before, before.ref_A)));
            far = fmax(far, apart(drive->duty, duties_by(drive, &before, drive->i_A)));
        }
    }
    TEST_ASSERT_TRUE(rig.drive.estimator.by.hfi.active);
    TEST_ASSERT_TRUE(far > 1.0e-3); // of 5e-3
}

// Injection cannot tell north from south: the load takes the rotor along, until the EMF finds the angle anew.
static void test_a_magnet_the_wrong_way_round_is_found_by_its_EMF(void) {
    static rig_t rig;
    rig_running(&rig, LODE_PLL_LESO);
    rig_ask(&rig, 0.0f);
    rig_run(&rig, 1.0);
    rig.motor.theta += CHECK_PI;
    rig.motor.id = -rig.motor.id;
    rig.motor.iq = -rig.motor.iq;
    rig.pull_Nm = 5.0;
    CHECK_AT_LEAST(3.0, rig_worst(&rig, 0.05));
    rig_run(&rig, 0.15);
    CHECK_AT_MOST(2.0 * CHECK_DEG, rig_worst(&rig, 0.8));
    CHECK_NEAR(1.0, 0.0, rig.motor.omega / 3.0);
    rig_expect(&rig, LODE_MODE_RUN);
}

/// Without the check of the sensors it counts as a lost rotor, is looked for again, and has no axis.
static void test_no_response_to_the_wave_trips(void) {
    static rig_t rig;
    rig_running_with(&rig, LODE_PLL_LESO, LODE_OFF);
    rig_ask(&rig, 0.0f);
    rig_run(&rig, 1.0);
    rig.motor.Ld = 9.8e-3; // 0.36 of it is left
    rig_run(&rig, 0.02);
    rig_expect(&rig, LODE_MODE_START);
    rig_run(&rig, 0.4);
    rig_expect(&rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_CRITERION_POLARITY, rig_telemetry(&rig).fault.criterion);
}

/// (H29): rounds until a swing of `share` of the expected one is a fault; 0: it is none. `good`: rounds with a whole one before.
static int weak_rounds(float share, int good, bool searches, float off_rad) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    lode_hfi_t hfi = {.off_rad = off_rad, .swing_V = 90.0f};
    for (int n = 0; n < good; n++) {
        TEST_ASSERT_TRUE(lode_hfi_shows_wave(&hfi, &tuning, searches, 1.0f / 2.8f));
    }
    for (int n = 1; n < 100; n++) {
        hfi.swing_V = 90.0f * share;
        if (!lode_hfi_shows_wave(&hfi, &tuning, searches, 1.0f / 2.8f)) {
            return n;
        }
    }
    return 0;
}

static void test_a_wave_that_the_currents_do_not_show(void) {
    // Less than a wrong axis leaves, which is found at once.
    for (int good = 0; good <= 1; good++) {
        TEST_ASSERT_EQUAL_INT(2, weak_rounds(0.0f, good, false, 0.0f));
        TEST_ASSERT_EQUAL_INT(2, weak_rounds(0.0f, good, true, 0.0f));
        TEST_ASSERT_EQUAL_INT(2, weak_rounds(0.49f / 2.8f, good, true, 0.5f));
    }
    // Less than half, after it has been shown, and of an axis that is known.
    TEST_ASSERT_EQUAL_INT(8, weak_rounds(0.49f, 1, false, 0.0f));
    TEST_ASSERT_EQUAL_INT(8, weak_rounds(0.51f / 2.8f, 1, false, 0.34f));
    TEST_ASSERT_EQUAL_INT(0, weak_rounds(0.49f, 0, false, 0.0f));
    TEST_ASSERT_EQUAL_INT(0, weak_rounds(0.49f, 1, true, 0.0f));
    TEST_ASSERT_EQUAL_INT(0, weak_rounds(0.49f, 1, false, 0.35f));
    TEST_ASSERT_EQUAL_INT(0, weak_rounds(0.51f, 1, false, 0.0f));
    TEST_ASSERT_EQUAL_INT(0, weak_rounds(0.51f / 2.8f, 1, true, 0.0f));
}

/// Injection that has begun anew has shown nothing yet: a motor whose wave is always this small is not taken for a failure.
static void test_a_wave_that_was_never_shown(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    lode_hfi_t hfi;
    lode_hfi_begin(&hfi, &tuning, (lode_dq_t){0.0f, 0.0f});
    for (int n = 0; n < 50; n++) {
        TEST_ASSERT_TRUE(lode_hfi_shows_wave(&hfi, &tuning, false, 1.0f / 2.8f));
        hfi.swing_V = 90.0f * 0.45f;
    }
    lode_hfi_begin(&hfi, &tuning, (lode_dq_t){0.0f, 0.0f});
    int rounds = 0;
    for (; rounds < 50 && lode_hfi_shows_wave(&hfi, &tuning, false, 1.0f / 2.8f); rounds++) {
    }
    TEST_ASSERT_EQUAL_INT(2 + 1, rounds); // two early ones, then two without it
}

/// What is not in a row does not count.
static void test_a_wave_that_is_shown_again(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    lode_hfi_t hfi = {.swing_V = 90.0f};
    for (int n = 0; n < 50; n++) {
        hfi.swing_V = n % 2 == 0 ? 90.0f : 0.0f;
        TEST_ASSERT_TRUE(lode_hfi_shows_wave(&hfi, &tuning, false, 1.0f / 2.8f));
    }
}

/// At rest at the angle `theta`, with an Ld that falls by `share` from -4 to 4 A; asked for `speed_rad_s`.
static void rig_at_rest(rig_t *rig, double theta, double share, float speed_rad_s) {
    lode_drive_config_t config = rig_config();
    config.hfi.mode = LODE_HFI_ON;
    config.hfi.V_h_V = 25.0f;
    rig_init(rig, &rig_tuning, &config);
    rig->motor.theta = theta;
    rig->motor.Ld_per_A = -share * rig->motor.Ld / 8.0;
    rig_ask(rig, speed_rad_s);
}

static void test_start_at_rest_from_any_angle(void) {
    static rig_t rig;
    for (int k = 0; k < 24; k++) {
        rig_at_rest(&rig, k * 15.0 * CHECK_DEG, 0.05, 0.0f);
        rig_run(&rig, 0.4);
        rig_expect(&rig, LODE_MODE_RUN);
        CHECK_AT_MOST(1.0 * CHECK_DEG, rig_worst(&rig, 0.1));
        // It has turned by a few degrees at most, and holds from here on.
        CHECK_AT_MOST(6.0 * CHECK_DEG,
                      fabs(remainder(rig.motor.theta - k * 15.0 * CHECK_DEG, 2.0 * CHECK_PI)));
        rig.pull_Nm = 5.0;
        CHECK_AT_MOST(3.6 * CHECK_DEG, rig_worst(&rig, 0.5));
        CHECK_NEAR(3.0, 0.0, rig.motor.omega / 3.0);
    }
}

/// A run that begins at rest goes on from the current that flows: no torque, no fade of a start that turned a vector, and
/// what the start's memory held is nothing to it.
static void test_a_run_from_rest_begins_without_torque(void) {
    static rig_t rig;
    rig_at_rest(&rig, 200.0 * CHECK_DEG, 0.05, 0.0f);
    for (int n = 0; n < 4000 && rig.drive.mode != LODE_MODE_RUN; n++) {
        if (rig.drive.estimator.by.hfi.step == (uint_least8_t)LODE_HFI_RIGHT) {
            lode_start_t *start = &rig.drive.state.start; // what it may have left
            memset(&start->seen, 0x41, sizeof start->seen);
            start->mean_V = start->swing_V = start->by_size = start->give = 1.5f;
            rig.drive.state.run.proving = 2u; // beyond the start's state
        }
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_RUN);
    const lode_running_t *run = &rig.drive.state.run;
    lode_references_t fresh;
    lode_references_reset(&fresh, rig.drive.i_A.d);
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &run->references, sizeof fresh);
    CHECK_NEAR(0.0, 0.0, run->fade);
    CHECK_NEAR(0.0, 0.0, run->id_A);
    TEST_ASSERT_EQUAL_UINT(0u, run->proving); // nothing is to be proven
    CHECK_NEAR(0.0, 0.0, run->speed.torque_Nm);
    CHECK_NEAR(0.0, 0.0, rig.drive.ref_A.d);
    CHECK_NEAR(0.0, 0.0, rig.drive.ref_A.q);
}

/// Where north turns out to be south only the names change: the current stays where it flows, the voltage goes on, and
/// current control with it.
static void test_the_frame_turns_round_and_the_vectors_stay(void) {
    static rig_t rig;
    rig_at_rest(&rig, 200.0 * CHECK_DEG, 0.05, 0.0f);
    double turned = 0.0;
    for (int n = 0; n < 4000 && !(turned > 2.0); n++) {
        const double before = (double)lode_estimator_theta_rad(&rig.drive.estimator);
        rig_step(&rig);
        turned = fabs(remainder((double)lode_estimator_theta_rad(&rig.drive.estimator) - before,
                                2.0 * CHECK_PI));
    }
    TEST_ASSERT_TRUE(turned > 2.0);
    const lode_drive_t *drive = &rig.drive;
    const lode_sincos_t rotor = lode_estimator_rotor(&drive->estimator);
    const lode_ab_t i_A = lode_park_inverse(drive->i_A, rotor);
    const lode_ab_t flows_A = ipmsm_current(&rig.motor); // a period later
    CHECK_AT_LEAST(3.0, hypot((double)i_A.alpha, (double)i_A.beta));
    CHECK_NEAR(2.0, flows_A.alpha, i_A.alpha);
    CHECK_NEAR(2.0, flows_A.beta, i_A.beta);
    CHECK_NEAR(1.5, 4.0, drive->estimator.id_A); // along the magnet
    CHECK_NEAR(0.3, 0.75 * 3.96, drive->u_V.d);
    CHECK_NEAR(0.3, 0.0, drive->u_V.q);
    CHECK_NEAR(1.0e-6, drive->u_V.d, drive->current.d.integral);
    CHECK_NEAR(1.0e-6, drive->u_V.q, drive->current.q.integral);
}

/// In START, with a wave whose response has settled.
static void rig_searching(rig_t *rig) {
    rig_at_rest(rig, 200.0 * CHECK_DEG, 0.05, 0.0f);
    for (int n = 0; n < 2000 && !rig->drive.estimator.by.hfi.active; n++) {
        rig_step(rig);
    }
    rig_run(rig, 0.01);
    rig_expect(rig, LODE_MODE_START);
    TEST_ASSERT_EQUAL_INT(LODE_HFI_FIND, rig->drive.estimator.by.hfi.step);
}

/// The same, of every state.
static void test_all_that_the_frame_carries_turns_round(void) {
    static rig_t rig;
    rig_searching(&rig);
    lode_drive_t *drive = &rig.drive;
    lode_hfi_t *hfi = &drive->estimator.by.hfi;
    hfi->step = (uint_least8_t)LODE_HFI_WRONG;
    drive->i_A = (lode_dq_t){1.0f, 2.0f};
    drive->u_V = (lode_dq_t){3.0f, 4.0f};
    drive->estimator.id_A = 5.0f;
    hfi->i_A = (lode_dq_t){6.0f, 7.0f};
    hfi->h_V = 8.0f;
    hfi->q_V = 9.0f;
    const lode_sincos_t rotor = lode_estimator_rotor(&drive->estimator);
    TEST_ASSERT_TRUE(lode_mode_inject(drive));
    const double seen[] = {
        (double)drive->i_A.d,
        (double)drive->i_A.q,
        (double)drive->u_V.d,
        (double)drive->u_V.q,
        (double)drive->estimator.id_A,
        (double)hfi->i_A.d,
        (double)hfi->i_A.q,
        (double)hfi->h_V,
        (double)hfi->q_V,
    };
    for (int n = 0; n < 9; n++) {
        CHECK_NEAR(1.0e-6, -(n + 1.0), seen[n]);
    }
    CHECK_NEAR(1.0e-6, -rotor.sin, lode_estimator_rotor(&drive->estimator).sin);
    CHECK_NEAR(1.0e-6, -rotor.cos, lode_estimator_rotor(&drive->estimator).cos);
    CHECK_NEAR(1.0e-6, -3.0, drive->current.d.integral);
    CHECK_NEAR(1.0e-6, -4.0, drive->current.q.integral);
    TEST_ASSERT_EQUAL_INT(LODE_HFI_RIGHT, hfi->step);
}

/// (H14): the loop has no speed and no acceleration while the axis is searched for.
static void test_the_search_has_no_speed(void) {
    static rig_t rig;
    rig_searching(&rig);
    lode_pll_t *pll = &rig.drive.estimator.pll;
    pll->omega_rad_s = 1.0f;
    pll->f_rad_s2 = 2.0f;
    pll->rise_rad_s = 3.0f;
    TEST_ASSERT_TRUE(lode_mode_inject(&rig.drive));
    CHECK_NEAR(0.0, 0.0, pll->omega_rad_s);
    CHECK_NEAR(0.0, 0.0, pll->f_rad_s2);
    CHECK_NEAR(0.0, 0.0, pll->rise_rad_s);
}

/// (H29): only with the axis found does a wave count as one that has been seen in full.
static void test_a_wave_on_any_axis_is_not_one_seen_in_full(void) {
    for (int found = 0; found < 2; found++) {
        static rig_t rig;
        rig_searching(&rig);
        lode_hfi_t *hfi = &rig.drive.estimator.by.hfi;
        hfi->step = (uint_least8_t)(found ? LODE_HFI_NORTH : LODE_HFI_FIND);
        hfi->shown = false;
        hfi->early = 0u;
        hfi->off_rad = 0.0f;
        hfi->swing_V = 500.0f; // more than the wave gives
        TEST_ASSERT_TRUE(lode_mode_inject(&rig.drive));
        rig_expect(&rig, LODE_MODE_START);
        TEST_ASSERT_EQUAL_INT(found, hfi->shown);
    }
}

/// A search begins with the q axis of no current.
static void test_a_search_takes_the_q_axis_anew(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    rig_expect(&rig, LODE_MODE_RUN);
    rig.drive.guard.lock = (uint_least16_t)rig_tuning.guard.lock_checks;
    rig.drive.current.Lq_H *= 0.5f;
    lode_mode_find_lost(&rig.drive);
    rig_expect(&rig, LODE_MODE_START);
    CHECK_NEAR(1.0e-9, rig_tuning.references.Lq_H, rig.drive.current.Lq_H);
}

/// The rotor jumps by `turn_rad` at rest.
static void rig_jump(rig_t *rig, double turn_rad) {
    rig->motor.theta += turn_rad;
    rig_run(rig, 0.02);
}

static void test_a_rotor_that_is_lost_is_found_again(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    for (int k = 1; k <= 3; k++) {
        rig_expect(&rig, LODE_MODE_RUN);
        rig.drive.start_rounds = 77u;
        rig.drive.state.run.speed.calmed = 1u; // until OFF
        rig_jump(&rig, 1.5);
        rig_expect(&rig, LODE_MODE_START);
        TEST_ASSERT_EQUAL_INT(k, rig.drive.losses);
        TEST_ASSERT_EQUAL_INT(k, rig.drive.state.start.failed);
        TEST_ASSERT_EQUAL_UINT32(
            0u, rig.drive.start_rounds); // of the vector, which may follow, all of it is left
        rig_run(&rig, 0.5);
        CHECK_AT_MOST(1.0 * CHECK_DEG, rig_worst(&rig, 0.1));
        TEST_ASSERT_TRUE(rig_telemetry(&rig).gains_halved);
    }
    rig_expect(&rig, LODE_MODE_RUN);
    rig_jump(&rig, 1.5); // that is too often
    rig_expect(&rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_LOST_LOCK, rig_telemetry(&rig).fault.check);
}

/// Also where the lock counts as lost at the check before it trips.
static void test_a_rotor_that_is_lost_soon_is_found_again(void) {
    for (int n = 0; n < 16; n++) {
        static rig_t rig;
        rig_at_rest(&rig, 1.0, 0.05, 0.0f);
        rig_run(&rig, 0.5 + n * RIG_TS_s);
        static lode_drive_tuning_t quick;
        quick = *rig.drive.tuning;
        quick.guard.lock_checks = 3u;
        rig.drive.tuning = &quick;
        lode_tuning_post_check(&rig.drive, lode_tuning_words(&quick));
        lode_tuning_take_check(&rig.drive);
        rig_jump(&rig, 1.5);
        rig_expect(&rig, LODE_MODE_START);
        TEST_ASSERT_EQUAL_INT(1, rig.drive.losses);
    }
}

/// What the same check has found besides stays latched.
static void test_a_rotor_that_is_lost_hides_no_fault(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    static const lode_check_t found[] = {LODE_CHECK_OVER_VOLTAGE, LODE_CHECK_NONE,
                                         LODE_CHECK_LOST_LOCK};
    for (int n = 0; n < COUNT_OF(found); n++) {
        lode_drive_t drive = rig.drive;
        drive.guard.lock = (uint_least16_t)drive.tuning->guard.lock_checks;
        drive.guard.fault.check = (uint_least8_t)found[n];
        lode_mode_find_lost(&drive);
        TEST_ASSERT_EQUAL_INT(n == 0 ? LODE_MODE_RUN : LODE_MODE_START, drive.mode);
        TEST_ASSERT_EQUAL_INT(n == 0 ? LODE_CHECK_OVER_VOLTAGE : LODE_CHECK_NONE,
                              drive.guard.fault.check);
    }
    lode_drive_t sensored = rig.drive; // no search finds another angle than the sensor's
    sensored.guard.lock = (uint_least16_t)sensored.tuning->guard.lock_checks;
    sensored.sensored = 1u;
    lode_mode_find_lost(&sensored);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, sensored.mode);
}

/// No search where a phase may be open (K41), or a load has stopped the rotor (K45); nor without injection, nor where the EMF
/// alone gives the position.
static void test_a_lost_lock_that_is_explained_is_not_searched_for(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    for (int n = 0; n < 5; n++) {
        lode_drive_t drive = rig.drive;
        drive.guard.lock = 8u;
        static lode_drive_tuning_t tuning;
        tuning = *rig.drive.tuning;
        tuning.guard.lock_checks = 8u;
        tuning.estimator.hfi.find_rounds = n == 3 ? 0u : tuning.estimator.hfi.find_rounds;
        drive.tuning = &tuning;
        drive.state.run.waves.lacks[0] = n == 1 ? 9000u : 0u;
        drive.guard.stopped = n == 2 ? 2u : 1u;
        if (n == 4) {
            drive.estimator.pll.omega_rad_s = 2.1f * tuning.estimator.hfi.omega_high;
        }
        lode_mode_find_lost(&drive);
        TEST_ASSERT_EQUAL_INT(n == 0 ? LODE_MODE_START : LODE_MODE_RUN, drive.mode);
    }
}

/// With injection the rotor may turn either way: its direction, noted once per round, is none that WRONG_WAY holds it to.
static void test_either_direction_is_right(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    lode_drive_t drive = rig.drive;
    drive.estimator.pll.omega_rad_s = -0.1f;
    drive.direction = 1.0f;
    TEST_ASSERT_EQUAL_FLOAT(0.1f, lode_drive_condition(&drive).omega_rad_s);
    drive.estimator.by.hfi.active = false;
    TEST_ASSERT_EQUAL_FLOAT(-0.1f, lode_drive_condition(&drive).omega_rad_s);
}

/// A load a little beyond all the torque that turns a held rotor, with the wave first and with the EMF then.
static void test_a_load_that_turns_a_held_rotor(void) {
    static const float speeds[] = {0.0f, 1.0f};
    const double most_Nm = 0.66 * 12.0; // at i_max
    for (int k = 0; k < 4; k++) {
        static rig_t rig;
        rig_at_rest(&rig, 1.0, 0.05, speeds[k / 2]);
        rig_run(&rig, 0.5);
        rig_expect(&rig, LODE_MODE_RUN);
        rig.pull_Nm = (k % 2 == 0 ? 1.1 : -1.1) * most_Nm;
        rig_run(&rig, 1.0);
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OVERLOAD",
                                 lode_check_name(rig_telemetry(&rig).fault.check));
    }
}

/// (K41): a rotor that is lost because a phase is open is not looked for.
static void test_a_loss_by_an_open_phase_trips(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    rig.motor.theta += 1.5;
    for (int n = 0; n < 500 && rig.drive.mode == LODE_MODE_RUN; n++) {
        rig.drive.state.run.waves.lacks[2] = 9000u;
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OPEN_PHASE, rig_telemetry(&rig).fault.check);
    CHECK_NEAR(0.0, 3.0, (double)rig_telemetry(&rig).fault.measured);
    TEST_ASSERT_EQUAL_INT(0, rig.drive.losses);
}

/// Periods with the same counts until the fault; 0: there is none.
static int frozen_periods(rig_t *rig) {
    const lode_counts_t counts = rig_counts(rig);
    for (int n = 1; n <= 100; n++) {
        rig->out = lode_drive_step(&rig->drive, &counts);
        rig_move(rig);
        if (rig->out.gates != LODE_GATES_ON) {
            return n;
        }
    }
    return 0;
}

/// (H29): in the search, which commands no current, and at rest.
static void test_sensors_that_freeze_while_it_injects(void) {
    for (int runs = 0; runs <= 1; runs++) {
        static rig_t rig;
        rig_at_rest(&rig, 1.0, 0.05, 0.0f);
        for (int n = 0; n < 2000 && !rig.drive.estimator.by.hfi.active; n++) {
            rig_step(&rig);
        }
        rig_run(&rig, runs == 1 ? 0.5 : 0.02);
        rig_expect(&rig, runs == 1 ? LODE_MODE_RUN : LODE_MODE_START);
        const int periods = frozen_periods(&rig);
        CHECK_AT_LEAST(17, periods);
        CHECK_AT_MOST(28, periods); // 5.6 ms
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_STUCK",
                                 lode_check_name(rig_telemetry(&rig).fault.check));
        CHECK_NEAR(0.0, 0.0, (double)rig_telemetry(&rig).fault.measured); // all phases
        CHECK_NEAR(0.0, 0.0, (double)rig_telemetry(&rig).fault.limit);
    }
}

/// (H29) and its options: what is not checked has no name of its own.
static void test_checks_of_the_wave_are_a_choice(void) {
    for (int n = 0; n < 4; n++) {
        const bool stuck = n / 2 == 0;
        const bool off = n % 2 == 1;
        static rig_t rig;
        rig_running(&rig, LODE_PLL_LESO);
        rig_ask(&rig, 0.0f);
        rig_run(&rig, 2.0);
        TEST_ASSERT_TRUE(rig_telemetry(&rig).injected);
        static lode_drive_tuning_t chosen;
        chosen = *rig.drive.tuning;
        chosen.plausibility.frozen_A2 = stuck && off ? -1.0f : chosen.plausibility.frozen_A2;
        chosen.plausibility.jump_V2 = !stuck && off ? FLT_MAX : chosen.plausibility.jump_V2;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_tuning(&rig.drive, &chosen));
        rig_run(&rig, 0.1);
        if (stuck) {
            (void)frozen_periods(&rig);
        } else {
            rig.motor.Ld = 9.8e-3;
            rig_run(&rig, 0.02);
        }
        const lode_check_t check = stuck ? LODE_CHECK_CURRENT_STUCK : LODE_CHECK_CURRENT_GAIN;
        TEST_ASSERT_EQUAL_INT(!off, rig_telemetry(&rig).fault.check == check);
    }
}

static void check_gain(const rig_t *rig, double factor) {
    const lode_fault_t fault = rig_telemetry(rig).fault;
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_CURRENT_GAIN", lode_check_name(fault.check));
    CHECK_NEAR(0.15, factor, (double)fault.measured);
    CHECK_NEAR(0.0, 1.0, (double)fault.limit);
}

/// (H29): a response of 0.36 is that of gains, and told as such, whether injection began at rest or in RUN.
static void test_a_response_that_falls_is_of_the_gains(void) {
    const float before_rad_s[] = {0.0f, 100.0f};
    for (int n = 0; n < COUNT_OF(before_rad_s); n++) {
        static rig_t rig;
        rig_running(&rig, LODE_PLL_LESO);
        rig_ask(&rig, before_rad_s[n]);
        rig_run(&rig, 2.0);
        rig_ask(&rig, 0.0f);
        rig_run(&rig, 2.0);
        TEST_ASSERT_TRUE(rig_telemetry(&rig).injected);
        rig.motor.Ld = 9.8e-3;
        rig_run(&rig, 0.02);
        check_gain(&rig, 0.36);
    }
}

/// In the search a wrong axis leaves 0.36 of the wave. Less is of the gains, more may be the axis.
static void test_a_response_in_the_search(void) {
    const double gains[] = {1.0 / 7.0, 1.0 / 1.5};
    for (int n = 0; n < COUNT_OF(gains); n++) {
        static rig_t rig;
        rig_at_rest(&rig, 0.0, 0.0, 0.0f);
        for (int k = 0; k < 2000 && !rig.drive.estimator.by.hfi.active; k++) {
            rig_step(&rig);
        }
        rig.motor.Ld /= gains[n];
        rig.motor.Lq /= gains[n];
        rig_run(&rig, 0.008);
        if (n == 0) {
            check_gain(&rig, gains[n]);
        } else {
            rig_expect(&rig, LODE_MODE_START);
        }
    }
}

/// (K42): injection still has the angle of a rotor that jams.
static void test_a_rotor_that_jams_is_an_overload(void) {
    static rig_t rig;
    rig_running(&rig, LODE_PLL_LESO);
    rig.motor.omega = 0.0;
    rig.blocked = true;
    const double limit_s =
        (double)rig_tuning.plausibility.stall_rounds * LODE_SLOW_PERIODS * RIG_TS_s;
    rig_run(&rig, limit_s);
    rig_expect(&rig, LODE_MODE_RUN);
    rig_run(&rig, 0.3); // speed control asks for all the torque
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OVERLOAD",
                             lode_check_name(rig_telemetry(&rig).fault.check));
    CHECK_NEAR(1.0, 3.0 * 31.4, (double)rig_telemetry(&rig).fault.limit);
}

/// (H29): where a phase is suspected to be open, the wave that is not shown is its.
static void test_a_wave_that_an_open_phase_does_not_let_pass(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    rig.motor.Ld *= 30.0;
    int periods = 0;
    for (; periods < 500 && rig.drive.mode == LODE_MODE_RUN; periods++) {
        rig.drive.state.run.waves.lacks[0] = 9000u;
        rig_step(&rig);
    }
    CHECK_AT_MOST(28, periods); // as frozen sensors, and before the lock is lost
    TEST_ASSERT_EQUAL_STRING("LODE_CHECK_OPEN_PHASE",
                             lode_check_name(rig_telemetry(&rig).fault.check));
    CHECK_NEAR(0.0, 1.0, (double)rig_telemetry(&rig).fault.measured);
    CHECK_NEAR(0.0, 0.0, (double)rig_telemetry(&rig).fault.limit);
}

static void test_a_loss_at_speed_trips(void) {
    static rig_t rig;
    rig_running(&rig, LODE_PLL_LESO);
    rig_ask(&rig, 100.0f); // 300 rad/s; injection ends at 130
    rig_run(&rig, 2.0);
    rig_expect(&rig, LODE_MODE_RUN);
    rig.motor.psi = 0.03;
    rig_run(&rig, 0.05);
    rig_expect(&rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_INT(0, rig.drive.losses);
}

/// A load that comes to turn the rotor while its axis is searched for: it is caught by its EMF.
static void test_a_rotor_that_begins_to_turn_is_caught(void) {
    for (int k = -1; k <= 1; k += 2) {
        static rig_t rig;
        rig_at_rest(&rig, 1.0, 0.05, 20.0f);
        for (int n = 0; n < 2000 && !rig.drive.estimator.by.hfi.active; n++) {
            rig_step(&rig);
        }
        rig.motor.omega = 250.0 * k;
        rig.blocked = true; // it keeps this speed
        for (int n = 0; n < 5000 && rig.drive.mode != LODE_MODE_OFF; n++) {
            rig_step(&rig);
        }
        const lode_fault_t why = rig_telemetry(&rig).fault;
        TEST_ASSERT_EQUAL_UINT(1u, rig.drive.losses);
        TEST_ASSERT_EQUAL_INT(LODE_CHECK_NONE, why.check);
        TEST_ASSERT_EQUAL_INT(LODE_CRITERION_SPEED, why.criterion);
        CHECK_NEAR(50.0, 250.0, (double)why.measured); // the observer lets less of the EMF pass
        CHECK_NEAR(1.0e-3, (double)rig.drive.tuning->start.omega_ready, (double)why.limit);
        rig_run(&rig, 0.02);
        rig_expect(&rig, LODE_MODE_RUN);
        CHECK_NEAR(20.0, 250.0 * k, (double)rig.drive.estimator.pll.omega_rad_s);
        CHECK_AT_MOST(10.0 * CHECK_DEG, fabs(rig.angle_error));
    }
}

/// It stands still whenever it is to be caught, and turns as soon as its axis is searched for.
static void test_a_rotor_that_is_never_caught_trips(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 20.0f);
    rig.blocked = true;
    for (int n = 0; n < 20000 && rig.drive.mode != LODE_MODE_FAULT; n++) {
        rig.motor.omega = rig.drive.estimator.by.hfi.active ? 250.0 : 0.0;
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_FAULT);
    const lode_fault_t why = rig_telemetry(&rig).fault;
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_WRONG_WAY, why.check);
    CHECK_NEAR(50.0, 250.0, (double)why.measured);
    TEST_ASSERT_EQUAL_UINT(3u, rig.drive.losses);
}

static void test_a_loss_is_forgotten(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    rig_jump(&rig, 1.5);
    rig_run(&rig, 0.5);
    TEST_ASSERT_EQUAL_INT(1, rig.drive.losses);
    rig_run(&rig, 3.3);
    TEST_ASSERT_EQUAL_INT(0, rig.drive.losses);
    rig_expect(&rig, LODE_MODE_RUN);
}

static void test_iron_that_tells_no_polarity(void) {
    static rig_t rig;
    rig_at_rest(&rig, 2.0, 0.0, 0.0f);
    rig_run(&rig, 0.5);
    rig_expect(&rig, LODE_MODE_FAULT); // pushed, it would leave the speed that is asked for
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_CRITERION_POLARITY, rig_telemetry(&rig).fault.criterion);
    // From any angle, under load and without.
    for (int k = 0; k < 24; k++) {
        const double from = k * 15.0 * CHECK_DEG;
        const double direction = k % 2 == 0 ? 1.0 : -1.0;
        rig_at_rest(&rig, from, 0.0, (float)(31.4 * direction));
        rig.load_Nm = k % 3;
        double turned = 0.0;
        double back = 0.0;
        for (int n = 0; n < 600; n++) {
            rig_run(&rig, 0.001);
            turned += 0.001 * direction * rig.motor.omega;
            back = fmax(back, -turned);
        }
        rig_expect(&rig, LODE_MODE_RUN);
        TEST_ASSERT_EQUAL_INT(LODE_HFI_RIGHT, rig.drive.estimator.by.hfi.step);
        CHECK_AT_MOST(45.0 * CHECK_DEG, back);
        rig_run(&rig, 1.5);
        CHECK_NEAR(1.0, 31.4 * direction, rig.motor.omega / 3.0);
        CHECK_AT_MOST(3.0 * CHECK_DEG, rig_worst(&rig, 0.1));
    }
}

/// The currents stay within those of a start, and the loop reckons with no torque whose sign is not known.
static void test_a_push_and_its_end(void) {
    static rig_t rig;
    rig_at_rest(&rig, 2.0, 0.0, -31.4f);
    rig.blocked = true;
    while (rig.drive.estimator.by.hfi.step != (uint_least8_t)LODE_HFI_PUSH) {
        rig_run(&rig, RIG_TS_s);
    }
    const lode_start_tuning_t *start = &rig.drive.tuning->start;
    const double along_A =
        fmin(0.33 * (double)start->current_last_A, 0.5 / (double)start->lost_per_A);
    rig_run(&rig, (double)LODE_SLOW_PERIODS * RIG_TS_s); // asked for from its first round on
    float most_A = 0.0f;
    while (rig.drive.estimator.by.hfi.step == (uint_least8_t)LODE_HFI_PUSH) {
        rig_run(&rig, RIG_TS_s);
        const lode_pll_t *pll = &rig.drive.estimator.pll;
        const lode_dq_t ref_A = rig.drive.ref_A;
        if (rig.drive.estimator.by.hfi.step == (uint_least8_t)LODE_HFI_PUSH) {
            // (H25): against the axis as much as takes the phases from their zeros, and half the flux at most.
            CHECK_NEAR(1.0e-4, -along_A, ref_A.d);
            CHECK_NEAR(1.0e-6 + 1.0e-6 * fabs((double)pll->rise_rad_s),
                       (double)(RIG_TS_s * pll->f_rad_s2), pll->rise_rad_s);
            most_A = lode_max(most_A, lode_ab_length((lode_ab_t){ref_A.d, ref_A.q}));
            TEST_ASSERT_TRUE(!(ref_A.q > 0.0f));
        }
    }
    CHECK_NEAR(0.01, (double)rig.drive.tuning->start.current_last_A, most_A);
    // Nothing moved: the vector has its try.
    rig_expect(&rig, LODE_MODE_START);
    TEST_ASSERT_EQUAL_INT(LODE_HFI_UNDECIDED, rig.drive.estimator.by.hfi.step);
    TEST_ASSERT_FALSE(rig.drive.estimator.by.hfi.active);
    CHECK_NEAR(0.0, 0.0, rig.drive.current.d.integral); // from where it would have begun
    CHECK_NEAR(0.0, 0.0, rig.drive.current.q.integral);
    rig.blocked = false;
    rig_run(&rig, 2.0);
    rig_expect(&rig, LODE_MODE_RUN);
    CHECK_NEAR(1.0, -31.4, rig.motor.omega / 3.0);
    // Called off on its way.
    rig_at_rest(&rig, 2.0, 0.0, 31.4f);
    rig.blocked = true;
    rig_run(&rig, 0.35);
    TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, rig.drive.estimator.by.hfi.step);
    rig_ask(&rig, 0.0f);
    rig_run(&rig, 0.01);
    rig_expect(&rig, LODE_MODE_FAULT);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, rig_telemetry(&rig).fault.check);
    TEST_ASSERT_EQUAL_INT(LODE_CRITERION_POLARITY, rig_telemetry(&rig).fault.criterion);
    CHECK_NEAR(0.0, 0.0, rig.drive.ref_A.d); // nothing is asked for any more
    CHECK_NEAR(0.0, 0.0, rig.drive.ref_A.q);
}

/// (H28): the bandwidth of injection where the wave alone counts, that of the EMF where the EMF does.
static void test_the_bandwidth_is_blended_too(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 31.4f);
    rig_run(&rig, 0.5);
    rig_expect(&rig, LODE_MODE_RUN);
    const lode_estimator_tuning_t *tuning = &rig.drive.tuning->estimator;
    lode_estimator_t *estimator = &rig.drive.estimator;
    const double w1 = (double)(tuning->hfi.omega_high - 1.0f / tuning->hfi.inv_span);
    const double w2 = (double)tuning->hfi.omega_high;
    for (int n = -1; n <= 5; n++) {
        const double omega = w1 + 0.2 * n * (w2 - w1);
        const double weight = fmin(1.0 - 0.2 * n, 1.0);
        estimator->pll.omega_rad_s = (float)omega;
        TEST_ASSERT_TRUE(lode_mode_inject(&rig.drive));
        const double by_emf =
            1.0 - cbrt(1.0 - (double)lode_pll_gains(&tuning->pll, (float)omega).theta);
        const double x = by_emf + weight * ((double)tuning->hfi.find_gain - by_emf);
        CHECK_NEAR(1.0e-6, x * (3.0 - x * (3.0 - x)), (double)estimator->gains.theta);
    }
}

/// (H14): while the axis is looked for the loop is of first order: it has no speed and no disturbance to wind up.
static void test_the_loop_that_looks_for_the_axis_has_no_speed(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.2, 0.05, 0.0f);
    while (!rig.drive.estimator.by.hfi.active) {
        rig_step(&rig);
    }
    const lode_estimator_t *estimator = &rig.drive.estimator;
    const lode_estimator_t before = *estimator; // as after a restart
    CHECK_NEAR(0.0, 0.0, before.lock);
    int rounds = 0;
    for (; estimator->by.hfi.step == (uint_least8_t)LODE_HFI_FIND; rounds++) {
        CHECK_NEAR(0.0, rig.drive.tuning->estimator.hfi.find_gain, estimator->gains.theta);
        CHECK_NEAR(0.0, 0.0, estimator->gains.omega_s);
        CHECK_NEAR(0.0, 0.0, estimator->gains.f_s2);
        if (lode_slot_of(rig.drive.steps - 1u) == SLOT_GAINS) { // what a round adds is forgotten
            CHECK_NEAR(0.0, 0.0, estimator->pll.omega_rad_s);
            CHECK_NEAR(0.0, 0.0, estimator->pll.f_rad_s2);
            CHECK_NEAR(0.0, 0.0, estimator->pll.rise_rad_s);
        }
        rig_step(&rig);
    }
    TEST_ASSERT_TRUE(rounds > 100);
}

/// When a push has shown the polarity the torque is known for which the disturbance stood: that begins anew.
static void test_a_push_leaves_no_disturbance(void) {
    static rig_t rig;
    rig_at_rest(&rig, 2.0, 0.0, 31.4f);
    rig.load_Nm = 1.0;
    const uint_least8_t *step = &rig.drive.estimator.by.hfi.step;
    while (*step != (uint_least8_t)LODE_HFI_PUSH) {
        rig_step(&rig);
    }
    double before = 0.0;
    while (*step == (uint_least8_t)LODE_HFI_PUSH) {
        before = (double)rig.drive.estimator.pll.f_rad_s2;
        rig_step(&rig);
    }
    CHECK_AT_LEAST(1.0, fabs(before));
    CHECK_NEAR(0.0, 0.0, rig.drive.estimator.pll.f_rad_s2);
}

/// A rotor that is lost is looked for as from OFF: with no voltage of before, and a lock that is counted from nothing.
static void test_a_search_begins_anew(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    rig_expect(&rig, LODE_MODE_RUN);
    const lode_pll_gains_t gains = lode_pll_gains_of(&rig.drive.tuning->estimator.pll,
                                                     rig.drive.tuning->estimator.hfi.find_gain);
    TEST_ASSERT_EQUAL_MEMORY(&gains, &rig.drive.estimator.gains, sizeof gains);
    rig.motor.theta += 1.5;
    for (int n = 0; n < 500 && rig.drive.mode == LODE_MODE_RUN; n++) {
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_START);
    lode_drive_t *drive = &rig.drive;
    TEST_ASSERT_EQUAL_UINT(0u, drive->guard.lock);
    CHECK_NEAR(0.0, 0.0, drive->current.d.integral);
    CHECK_NEAR(0.0, 0.0, drive->current.q.integral);
    lode_estimator_t fresh = drive->estimator;
    lode_estimator_restart(&fresh, &drive->tuning->estimator);
    CHECK_NEAR(0.0, fresh.pll.omega_rad_s, drive->estimator.pll.omega_rad_s);
    CHECK_NEAR(0.0, fresh.lock, drive->estimator.lock);
}

/// A sensor's estimate ends injection in the period in which it comes, and nothing is left to be found by it.
static void test_a_sensor_ends_injection_at_once(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.5);
    TEST_ASSERT_TRUE(rig.drive.estimator.by.hfi.active);
    while (lode_slot_of(rig.drive.steps) == SLOT_GAINS) { // where it is looked at anyway
        rig_step(&rig);
    }
    const lode_counts_t counts = rig_counts(&rig);
    const lode_sample_t sample = lode_drive_sense(&rig.drive, &counts);
    lode_estimate_t estimate = lode_drive_estimate(&rig.drive, &sample);
    estimate.source = LODE_ESTIMATE_SENSOR;
    estimate.omega_rad_s = 500.0f;
    lode_mode_adopt(&rig.drive, &estimate);
    TEST_ASSERT_FALSE(rig.drive.estimator.by.hfi.active);
    TEST_ASSERT_EQUAL_INT(LODE_HFI_UNDECIDED, rig.drive.estimator.by.hfi.step);
    // Its speed leads the duties, too.
    CHECK_NEAR(1.0e-4, 1.5 * RIG_TS_s * 500.0,
               atan2((double)rig.drive.lead.sin, (double)rig.drive.lead.cos));
}

static void test_torque_through_zero(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 10.0f);
    lode_command_t command = {.mode = LODE_MODE_RUN,
                              .control = LODE_CONTROL_TORQUE,
                              .torque_Nm = 1.0f,
                              .speed_rad_s = 10.0f};
    rig_command(&rig, command);
    rig_run(&rig, 1.5);
    CHECK_NEAR(0.5, 10.0, rig.motor.omega / 3.0); // the speed is a limit
    command.torque_Nm = -1.0f;
    rig_command(&rig, command);
    rig_run(&rig, 0.17); // 57 rad/s^2
    CHECK_NEAR(2.0, 0.0, rig.motor.omega / 3.0);
    CHECK_NEAR(0.05, -1.0, ipmsm_torque(&rig.motor));
    rig_run(&rig, 1.0);
    CHECK_NEAR(0.5, -10.0, rig.motor.omega / 3.0);
    rig_expect(&rig, LODE_MODE_RUN);
}

static void test_an_estimate_from_outside_takes_its_place(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 10.0f);
    for (int k = 0; k < 3000; k++) {
        rig.stamp += 1000u;
        const lode_counts_t counts = rig_counts(&rig);
        const lode_sample_t sample = lode_drive_sense(&rig.drive, &counts);
        lode_estimate_t estimate = lode_drive_estimate(&rig.drive, &sample);
        estimate.rotor = lode_sincos((float)rig.motor.theta);
        estimate.i_A = lode_park(sample.i_A, estimate.rotor);
        estimate.omega_rad_s = (float)rig.motor.omega;
        estimate.lock = 1.0f;
        estimate.source = LODE_ESTIMATE_SENSOR;
        rig.out = lode_drive_act(&rig.drive, &sample, &estimate);
        TEST_ASSERT_FALSE(rig.drive.estimator.by.hfi.active);
        rig_move(&rig);
    }
    rig_expect(&rig, LODE_MODE_RUN);
    CHECK_NEAR(1.0, 10.0, rig.motor.omega / 3.0);
}

/// Of a loop of second order no load can be told to the own estimator, nor is one made up.
static void test_a_QPLL_takes_no_acceleration_from_outside(void) {
    static rig_t rig;
    lode_drive_config_t config = rig_config();
    config.estimator.pll.kind = LODE_PLL_QPLL;
    rig_init(&rig, &rig_tuning, &config);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {1.0f, 0.0f}});
    rig_run(&rig, 0.1);
    rig_expect(&rig, LODE_MODE_CURRENT);
    const lode_counts_t counts = rig_counts(&rig);
    const lode_sample_t sample = lode_drive_sense(&rig.drive, &counts);
    lode_estimate_t estimate = lode_drive_estimate(&rig.drive, &sample);
    estimate.source = LODE_ESTIMATE_SENSOR;
    estimate.omega_rad_s = 100.0f;
    estimate.load_torque_Nm = 1.0f;
    lode_mode_adopt(&rig.drive, &estimate);
    CHECK_NEAR(0.0, 100.0, rig.drive.estimator.pll.omega_rad_s);
    CHECK_NEAR(0.0, 0.0, rig.drive.estimator.pll.f_rad_s2);
    CHECK_NEAR(0.0, 0.0, rig.drive.estimator.pll.rise_rad_s);
}

/// Injection belongs to RUN and to a start at rest: in any other mode it ends with the next round.
static void test_in_other_modes_nothing_is_injected(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.25);
    TEST_ASSERT_TRUE(rig.drive.estimator.by.hfi.active);
    rig.drive.mode = (uint_least8_t)LODE_MODE_CURRENT;
    TEST_ASSERT_FALSE(lode_mode_inject(&rig.drive));
    TEST_ASSERT_FALSE(rig.drive.estimator.by.hfi.active);
}

static void test_start_at_rest_can_be_called_off(void) {
    static rig_t rig;
    rig_at_rest(&rig, 1.0, 0.05, 0.0f);
    rig_run(&rig, 0.25);
    rig_expect(&rig, LODE_MODE_START);
    TEST_ASSERT_TRUE(rig.drive.estimator.by.hfi.active);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF});
    rig_run(&rig, 0.01);
    rig_expect(&rig, LODE_MODE_OFF);
    TEST_ASSERT_FALSE(rig.drive.estimator.by.hfi.active);
}

/// Its state takes the place of theirs; above w2 they begin anew.
static void test_notches_rest_while_it_injects(void) {
    static rig_t rig;
    lode_drive_config_t config = rig_config();
    config.hfi.mode = LODE_HFI_ON;
    config.hfi.V_h_V = 25.0f;
    config.estimator.notch_k = 0.5f;
    rig_init(&rig, &rig_tuning, &config);
    rig_ask(&rig, 31.4f);
    rig_run(&rig, 2.0);
    rig_ask(&rig, 0.0f);
    rig_run(&rig, 1.0);
    TEST_ASSERT_TRUE(rig.drive.estimator.by.hfi.active);
    CHECK_AT_MOST(1.0 * CHECK_DEG, rig_worst(&rig, 0.5));
    rig_ask(&rig, 100.0f);
    rig_run(&rig, 2.0);
    rig_expect(&rig, LODE_MODE_RUN);
    TEST_ASSERT_FALSE(rig.drive.estimator.by.hfi.active);
    TEST_ASSERT_TRUE(rig.drive.estimator.by.alone.notch.g > 0.0f);
    CHECK_NEAR(1.0, 100.0, rig.motor.omega / 3.0);
}

// A corrupted one would push its prediction for as long as it injects.
static void test_a_QPLL_has_no_acceleration_while_it_injects(void) {
    static rig_t rig;
    lode_drive_config_t config = rig_config();
    config.hfi.mode = LODE_HFI_ON;
    config.hfi.V_h_V = 25.0f;
    config.estimator.pll.kind = LODE_PLL_QPLL;
    rig_init(&rig, &rig_tuning, &config);
    rig_ask(&rig, 31.4f);
    rig_run(&rig, 2.0);
    rig_ask(&rig, 0.0f);
    rig_run(&rig, 1.0);
    lode_estimator_t *estimator = &rig.drive.estimator;
    TEST_ASSERT_TRUE(estimator->by.hfi.active);
    estimator->pll.rise_rad_s = 0.1f;
    estimator->pll.f_rad_s2 = 0.1f;
    rig_run(&rig, 2.0 * (double)LODE_SLOW_PERIODS * RIG_TS_s);
    TEST_ASSERT_TRUE(estimator->by.hfi.active);
    CHECK_NEAR(0.0, 0.0, estimator->pll.rise_rad_s);
    CHECK_NEAR(0.0, 0.0, estimator->pll.f_rad_s2);
}

static void test_a_drive_that_cannot_inject_is_refused(void) {
    static lode_drive_t drive;
    lode_drive_config_t config = rig_config();
    config.hfi.mode = LODE_HFI_ON;
    config.motor.Lq_H = config.motor.Ld_H;
    CHECK_STATUS(LODE_ERROR_HFI_SALIENCY, lode_drive_init(&drive, &rig_tuning, &config));
    config.hfi.mode = LODE_HFI_AUTO;
    CHECK_STATUS(LODE_OK, lode_drive_init(&drive, &rig_tuning, &config));
}

static void test_an_axis_that_is_not_found_is_given_up(void) {
    const lode_hfi_tuning_t tuning = paper_tuning(); // 51 rounds of 1.6 ms
    lode_hfi_t hfi = {.off_rad = 0.2f};
    for (int k = 1; k < 3 * 51; k++) {
        CHECK_NEAR(0.0, 0.0, lode_hfi_find(&hfi, &tuning, 12.0f));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_FIND, hfi.step);
    }
    CHECK_NEAR(0.0, 0.0, lode_hfi_find(&hfi, &tuning, 12.0f));
    TEST_ASSERT_EQUAL_INT(LODE_HFI_UNDECIDED, hfi.step);
    hfi = (lode_hfi_t){.off_rad = 0.1f};
    for (int k = 1; k < 51; k++) {
        (void)lode_hfi_find(&hfi, &tuning, 12.0f);
    }
    CHECK_NEAR(1.0e-5, 0.33 * 12.0, lode_hfi_find(&hfi, &tuning, 12.0f));
}

/// What is just at a bound: the dead time and the axis that are taken, the axis that is found, the speed at which it does
/// not begin, and the motion that decides nothing.
static void test_at_the_bounds(void) {
    machine_t machine;
    set_up(&machine);
    machine.motor.Lq_H = 2.0f * machine.motor.Ld_H;
    machine.inverter.dead_time_s = 0.0f;
    machine.inverter.v_drop_V = 5.0f; // half of 10 V, which one of (xi - 1) makes 0.5 rad
    machine.inverter.i_max_A = 8.0f;
    lode_hfi_config_t config = designed(&machine);
    config.V_h_V = 10.0f;
    config.k_x_rad_A = 0.0625f;
    CHECK_STATUS(LODE_OK, tried(&config, &machine));
    config.k_x_rad_A = 0.0626f;
    CHECK_STATUS(LODE_ERROR_HFI_AXIS, tried(&config, &machine));
    machine.inverter.v_drop_V = 5.01f;
    CHECK_STATUS(LODE_ERROR_HFI_DEAD_TIME, tried(&config, &machine));
    lode_hfi_tuning_t tuning = paper_tuning();
    lode_hfi_t hfi = {.active = false};
    TEST_ASSERT_FALSE(lode_hfi_follow(&hfi, &tuning, (lode_dq_t){0.0f, 0.0f}, 130.0f));
    hfi = (lode_hfi_t){.off_rad = 0.15f};
    for (int k = 0; k < 51; k++) {
        (void)lode_hfi_find(&hfi, &tuning, 12.0f);
    }
    TEST_ASSERT_EQUAL_INT(LODE_HFI_NORTH, hfi.step);
    tuning.find_gain = 1.0f; // a step is the share of it
    const struct {
        uint_least16_t rounds;
        float step_rad, off_rad;
    } cases[] = {{0u, 0.1f, 0.0f},  {1u, 0.1f, 0.2f},   {1u, 0.2f, 0.15f},
                 {0u, -0.1f, 0.0f}, {1u, -0.1f, -0.2f}, {1u, -0.2f, -0.15f}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        hfi = (lode_hfi_t){.step = LODE_HFI_PUSH};
        hfi.of.push.rounds = cases[n].rounds;
        hfi.of.push.from = (lode_sincos_t){0.0f, 1.0f};
        const lode_sincos_t rotor = {cases[n].off_rad,
                                     sqrtf(1.0f - cases[n].off_rad * cases[n].off_rad)};
        (void)lode_hfi_push(&hfi, &tuning, rotor, cases[n].step_rad, 1.0f);
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, hfi.step);
    }
}

/// Half of the time for the axis, rounded up.
static void test_time_for_either_current(void) {
    lode_hfi_tuning_t tuning = paper_tuning();
    for (uint_least16_t rounds = 49u; rounds <= 52u; rounds++) {
        tuning.find_rounds = rounds;
        lode_hfi_t hfi = {.step = LODE_HFI_NORTH};
        int took = 0;
        while (hfi.step == (uint_least8_t)LODE_HFI_NORTH && took < 100) {
            (void)lode_hfi_find(&hfi, &tuning, 12.0f);
            took++;
        }
        TEST_ASSERT_EQUAL_INT(rounds < 51u ? 25 : 26, took);
    }
}

/// What is made of responses to current along the axis and against it, that move by `noise_V` from round to round.
static int decided_in_noise(const lode_hfi_tuning_t *tuning, float along_V, float against_V,
                            float noise_V) {
    lode_hfi_t hfi = {.step = LODE_HFI_NORTH};
    for (int k = 0; k < 26; k++) {
        hfi.swing_V = along_V + (k % 2 == 0 ? 0.5f : -0.5f) * noise_V;
        CHECK_NEAR(1.0e-5, k < 25 ? 3.96 : -3.96, lode_hfi_find(&hfi, tuning, 12.0f));
    }
    for (int k = 0; k < 26; k++) {
        TEST_ASSERT_EQUAL_INT(LODE_HFI_SOUTH, hfi.step);
        hfi.swing_V = against_V + (k % 2 == 0 ? 0.5f : -0.5f) * noise_V;
        (void)lode_hfi_find(&hfi, tuning, 12.0f);
    }
    return hfi.step;
}

static int decided(const lode_hfi_tuning_t *tuning, float along_V, float against_V) {
    return decided_in_noise(tuning, along_V, against_V, 0.0f);
}

static void test_polarity_by_the_difference_of_the_responses(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    TEST_ASSERT_EQUAL_INT(LODE_HFI_RIGHT, decided(&tuning, 101.7f, 100.0f));
    TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, decided(&tuning, 101.5f, 100.0f));
    TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, decided(&tuning, 100.0f, 101.5f));
    TEST_ASSERT_EQUAL_INT(LODE_HFI_WRONG, decided(&tuning, 100.0f, 101.7f));
    TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, decided(&tuning, 0.0f, 0.0f));
    TEST_ASSERT_EQUAL_INT(LODE_HFI_RIGHT, decided(&tuning, 0.021f, 0.02f)); // of small voltages too
    TEST_ASSERT_EQUAL_INT(LODE_HFI_WRONG, decided(&tuning, 0.02f, 0.021f));
    // (H21): a difference of 13 times 3 V, against four times the root of 26 squares of 1.9 V.
    TEST_ASSERT_EQUAL_INT(LODE_HFI_RIGHT, decided_in_noise(&tuning, 103.0f, 100.0f, 3.7f));
    TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, decided_in_noise(&tuning, 103.0f, 100.0f, 4.0f));
    TEST_ASSERT_EQUAL_INT(LODE_HFI_WRONG, decided_in_noise(&tuning, 100.0f, 103.0f, 3.7f));
}

/// The step after `rounds` rounds of a push that have turned the rotor to `at_rad`, the last one of them at `share` of
/// the loop's bandwidth.
static int pushed(const lode_hfi_tuning_t *tuning, int rounds, double at_rad, float share,
                  float direction) {
    lode_hfi_t hfi = {.step = LODE_HFI_PUSH, .i_A = {1.0f, 2.0f}};
    for (int k = 1; k <= rounds; k++) {
        const lode_sincos_t rotor = lode_sincos(k > 1 ? (float)(1.0 + at_rad) : 1.0f);
        const float step_rad = k == rounds ? share * tuning->find_gain : 0.0f;
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, hfi.step);
        // 153 rounds to all of the current
        CHECK_NEAR(1.0e-5, fmin(k / 153.0, 1.0),
                   lode_hfi_push(&hfi, tuning, rotor, step_rad, direction));
    }
    const bool done =
        hfi.step != (uint_least8_t)LODE_HFI_PUSH && hfi.step != (uint_least8_t)LODE_HFI_UNDECIDED;
    if (done) { // by which cross-saturation turns the axis
        TEST_ASSERT_EQUAL_FLOAT(2.0f, hfi.of.iq_A);
    }
    return hfi.step;
}

/// (H27): speed and angle, both.
static void test_polarity_by_motion(void) {
    const lode_hfi_tuning_t tuning = paper_tuning();
    for (int sign = -1; sign <= 1; sign += 2) {
        const float direction = (float)sign;
        TEST_ASSERT_EQUAL_INT(LODE_HFI_RIGHT, pushed(&tuning, 9, 0.16 * sign, 0.11f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_WRONG, pushed(&tuning, 9, -0.16 * sign, -0.11f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, pushed(&tuning, 9, 0.14 * sign, 0.11f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, pushed(&tuning, 9, -0.14 * sign, -0.11f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, pushed(&tuning, 9, 0.16 * sign, 0.09f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, pushed(&tuning, 9, -0.16 * sign, -0.09f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, pushed(&tuning, 9, -0.16 * sign, 0.11f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, pushed(&tuning, 9, 0.16 * sign, -0.11f, direction));
        // It turns already, or it does not for long.
        TEST_ASSERT_EQUAL_INT(LODE_HFI_UNDECIDED, pushed(&tuning, 1, 0.0, -0.11f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_UNDECIDED, pushed(&tuning, 1, 0.0, 0.11f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, pushed(&tuning, 1, 0.0, 0.09f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_PUSH, pushed(&tuning, 305, 0.0, 0.0f, direction));
        TEST_ASSERT_EQUAL_INT(LODE_HFI_UNDECIDED, pushed(&tuning, 306, 0.0, 0.0f, direction));
    }
}

/// Of a period that does not inject the same members are read by either name.
static void test_what_both_states_share_lies_in_one_place(void) {
    TEST_ASSERT_EQUAL_INT(offsetof(lode_hfi_t, active), offsetof(lode_estimator_alone_t, active));
    TEST_ASSERT_EQUAL_INT(offsetof(lode_hfi_t, step), offsetof(lode_estimator_alone_t, step));
    TEST_ASSERT_EQUAL_INT(offsetof(lode_hfi_t, reserve_V),
                          offsetof(lode_estimator_alone_t, reserve_V));
}

static void test_off_is_off_to_the_bit(void) {
    static rig_t plain;
    static rig_t rig;
    static lode_drive_tuning_t tunings[2];
    lode_drive_config_t config = rig_config();
    rig_init(&plain, &tunings[0], &config);
    config.hfi = (lode_hfi_config_t){
        .V_h_V = 25.0f, .w1_rad_s = 80.0f, .w2_rad_s = 130.0f, .sigma_rad_s = 50.0f, .id_A = 3.0f};
    rig_init(&rig, &tunings[1], &config);
    rig_ask(&plain, 31.4f);
    rig_ask(&rig, 31.4f);
    for (int k = 0; k < 10000; k++) {
        if (k == 8000) {
            rig_expect(&rig, LODE_MODE_RUN);
            rig_ask(&plain, -31.4f);
            rig_ask(&rig, -31.4f);
        }
        rig_step(&plain);
        rig_step(&rig);
        TEST_ASSERT_EQUAL_MEMORY(&plain.out.duty, &rig.out.duty, sizeof rig.out.duty);
    }
}

static void test_what_is_not_finite_is_left_behind(void) {
    static rig_t rig;
    rig_running(&rig, LODE_PLL_LESO);
    rig_ask(&rig, 0.0f);
    rig_run(&rig, 1.0);
    lode_estimator_t *estimator = &rig.drive.estimator;
    for (int k = 0; k < COUNT_OF(check_not_finite); k++) {
        const lode_ab_t u_V = {0.0f, 0.0f};
        estimator->by.hfi.active = true;
        const lode_estimate_t bad = lode_estimator_step(estimator, &rig_tuning.estimator, u_V,
                                                        (lode_ab_t){check_not_finite[k], 0.0f});
        TEST_ASSERT_TRUE(bad.reseeded);
        TEST_ASSERT_FALSE(estimator->by.hfi.active);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_each_rule_sizes_the_voltage);
    RUN_TEST(test_the_circle_limits_the_voltage);
    RUN_TEST(test_speeds_and_bandwidth);
    RUN_TEST(test_learning_raises_the_speeds);
    RUN_TEST(test_differential_inductance_of_a_saturating_q_axis);
    RUN_TEST(test_tuning_follows_from_the_configuration);
    RUN_TEST(test_refusals);
    RUN_TEST(test_limits_are_taken);
    RUN_TEST(test_auto_is_on_where_the_machine_allows_it);
    RUN_TEST(test_the_default_is_on_where_a_vector_is_weak);
    RUN_TEST(test_id_that_saturates_the_d_axis_where_saliency_is_small);
    RUN_TEST(test_no_error_shows_at_the_right_angle_whatever_the_voltage_does);
    RUN_TEST(test_gain_of_the_position_error);
    RUN_TEST(test_wrong_Ld_scales_the_gain);
    RUN_TEST(test_without_excitation_there_is_no_error);
    RUN_TEST(test_begins_and_ends_with_the_speed);
    RUN_TEST(test_begins_with_the_axis_of_its_current);
    RUN_TEST(test_half_a_turn_on_the_error_is_the_same);
    RUN_TEST(test_both_errors_are_weighted);
    RUN_TEST(test_the_ripple_drops_out);
    RUN_TEST(test_pairs_of_waves);
    RUN_TEST(test_no_tone_stands_out_of_a_silent_wave);
    RUN_TEST(test_a_running_wave_takes_another_tuning);
    RUN_TEST(test_a_silent_drive_holds_the_rotor);
    RUN_TEST(test_the_bandwidth_is_blended_too);
    RUN_TEST(test_cross_saturation_turns_the_axis);
    RUN_TEST(test_an_error_that_none_can_be_is_limited);
    RUN_TEST(test_quality_falls_with_the_response_and_with_the_error);
    RUN_TEST(test_full_torque_at_no_speed_and_reversal);
    RUN_TEST(test_dead_time_by_the_current_that_is_asked_for);
    RUN_TEST(test_a_magnet_the_wrong_way_round_is_found_by_its_EMF);
    RUN_TEST(test_no_response_to_the_wave_trips);
    RUN_TEST(test_a_wave_that_the_currents_do_not_show);
    RUN_TEST(test_a_wave_that_was_never_shown);
    RUN_TEST(test_a_wave_that_is_shown_again);
    RUN_TEST(test_sensors_that_freeze_while_it_injects);
    RUN_TEST(test_checks_of_the_wave_are_a_choice);
    RUN_TEST(test_a_response_that_falls_is_of_the_gains);
    RUN_TEST(test_a_response_in_the_search);
    RUN_TEST(test_a_rotor_that_jams_is_an_overload);
    RUN_TEST(test_start_at_rest_from_any_angle);
    RUN_TEST(test_a_run_from_rest_begins_without_torque);
    RUN_TEST(test_the_frame_turns_round_and_the_vectors_stay);
    RUN_TEST(test_all_that_the_frame_carries_turns_round);
    RUN_TEST(test_the_search_has_no_speed);
    RUN_TEST(test_a_wave_on_any_axis_is_not_one_seen_in_full);
    RUN_TEST(test_a_search_takes_the_q_axis_anew);
    RUN_TEST(test_a_rotor_that_is_lost_is_found_again);
    RUN_TEST(test_a_rotor_that_is_lost_soon_is_found_again);
    RUN_TEST(test_a_rotor_that_is_lost_hides_no_fault);
    RUN_TEST(test_a_lost_lock_that_is_explained_is_not_searched_for);
    RUN_TEST(test_either_direction_is_right);
    RUN_TEST(test_a_load_that_turns_a_held_rotor);
    RUN_TEST(test_a_loss_by_an_open_phase_trips);
    RUN_TEST(test_a_wave_that_an_open_phase_does_not_let_pass);
    RUN_TEST(test_a_loss_at_speed_trips);
    RUN_TEST(test_a_rotor_that_begins_to_turn_is_caught);
    RUN_TEST(test_a_rotor_that_is_never_caught_trips);
    RUN_TEST(test_a_loss_is_forgotten);
    RUN_TEST(test_iron_that_tells_no_polarity);
    RUN_TEST(test_a_push_and_its_end);
    RUN_TEST(test_the_loop_that_looks_for_the_axis_has_no_speed);
    RUN_TEST(test_a_push_leaves_no_disturbance);
    RUN_TEST(test_a_search_begins_anew);
    RUN_TEST(test_a_sensor_ends_injection_at_once);
    RUN_TEST(test_torque_through_zero);
    RUN_TEST(test_an_estimate_from_outside_takes_its_place);
    RUN_TEST(test_a_QPLL_takes_no_acceleration_from_outside);
    RUN_TEST(test_in_other_modes_nothing_is_injected);
    RUN_TEST(test_start_at_rest_can_be_called_off);
    RUN_TEST(test_notches_rest_while_it_injects);
    RUN_TEST(test_a_QPLL_has_no_acceleration_while_it_injects);
    RUN_TEST(test_a_drive_that_cannot_inject_is_refused);
    RUN_TEST(test_an_axis_that_is_not_found_is_given_up);
    RUN_TEST(test_at_the_bounds);
    RUN_TEST(test_time_for_either_current);
    RUN_TEST(test_polarity_by_the_difference_of_the_responses);
    RUN_TEST(test_polarity_by_motion);
    RUN_TEST(test_what_both_states_share_lies_in_one_place);
    RUN_TEST(test_off_is_off_to_the_bit);
    RUN_TEST(test_what_is_not_finite_is_left_behind);
    return UNITY_END();
}
