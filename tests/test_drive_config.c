// What init accepts, what it refuses and by which name; what it computes by itself.
#include "support/fields.h"

#include "design/tuning_fields.h"
#include "drive_inline.h"

void setUp(void) {}

void tearDown(void) {}

static lode_drive_config_t minimal(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 5000.0f,
                                  .motor = paper_motor(),
                                  .inverter = {.v_bus_V = 200.0f, .i_max_A = 12.0f},
                                  .sense = {.i_gain_A_count = 0.0125f,
                                            .i_offset_count = 2048.0f,
                                            .v_bus_gain_V_count = 0.1f}};
    return config;
}

/// Refused, and neither drive nor tuning touched; or accepted.
static lode_status_t try_config(const lode_drive_config_t *config) {
    static lode_drive_t drive;
    static lode_drive_tuning_t tuning;
    static lode_drive_t drive_before;
    static lode_drive_tuning_t tuning_before;
    memset(&drive, 0x5a, sizeof drive);
    memset(&tuning, 0x5a, sizeof tuning);
    memcpy(&drive_before, &drive, sizeof drive);
    memcpy(&tuning_before, &tuning, sizeof tuning);
    const lode_status_t status = lode_drive_init(&drive, &tuning, config);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&drive_before, &drive, sizeof drive);
        TEST_ASSERT_EQUAL_MEMORY(&tuning_before, &tuning, sizeof tuning);
    }
    return status;
}

static lode_status_t try_one(size_t offset, float value) {
    lode_drive_config_t config = minimal();
    config.sense.temperature_gain_degC_count = 0.05f; // a count that may be asked to move
    field_set(&config, offset, value);
    return try_config(&config);
}

#define TS 2.0e-4f
#define F(member) FIELD(lode_drive_config_t, member)
#define NEEDED(member, low, high, name)                                                            \
    { F(member), .lo = (low), .hi = (high), .error = (name), .coupled = true }
#define OPEN(member, low, high, name)                                                              \
    {                                                                                              \
        F(member), .lo = (low), .hi = (high), .error = (name), .coupled = true, .computed = true,  \
                   .zero_is_auto = true                                                            \
    }

/// Fields without a default. The ranges are those that status.h names.
static const field_t needed[] = {
    NEEDED(f_pwm_Hz, 1.0e3f, 2.0e5f, LODE_ERROR_F_PWM),
    NEEDED(motor.Rs_Ohm, 0.0f, 1.0e3f, LODE_ERROR_MOTOR_RS),
    NEEDED(motor.Ld_H, 1.0e-7f, 10.0f, LODE_ERROR_MOTOR_LD),
    NEEDED(motor.Lq_H, 1.0e-7f, 10.0f, LODE_ERROR_MOTOR_LQ),
    NEEDED(motor.psi_Wb, 1.0e-6f, 100.0f, LODE_ERROR_MOTOR_PSI),
    NEEDED(motor.J_kgm2, 1.0e-9f, 1.0e4f, LODE_ERROR_MOTOR_J),
    {F(motor.B_Nms), .lo = 0.0f, .hi = 0.0174f / TS, .error = LODE_ERROR_MOTOR_B, .computed = true},
    NEEDED(inverter.v_bus_V, 1.0f, 2000.0f, LODE_ERROR_V_BUS),
    NEEDED(inverter.i_max_A, 1.0e-3f, 1.0e4f, LODE_ERROR_I_MAX),
    NEEDED(inverter.v_drop_V, 0.0f, 10.0f, LODE_ERROR_V_DROP),
    NEEDED(inverter.r_on_Ohm, 0.0f, 10.0f, LODE_ERROR_R_ON),
    NEEDED(inverter.pwm_ticks, 0.0f, 65535.0f, LODE_ERROR_PWM_TICKS),
    NEEDED(inverter.precharge_s, 0.0f, 1.0f, LODE_ERROR_PRECHARGE),
};

/// Fields of which 0 asks for a default.
static const field_t open_fields[] = {
    OPEN(motor.omega_rated_rad_s, 1.0f, 1.0e5f, LODE_ERROR_MOTOR_OMEGA),
    OPEN(inverter.i_dead_A, 0.012f, 12.0f, LODE_ERROR_I_DEAD),
    OPEN(sense.duty_max, 0.5f, 1.0f, LODE_ERROR_SENSE_WINDOW),
    OPEN(sense.calibrate_s, TS, 10.0f, LODE_ERROR_SENSE_CALIBRATION),
    OPEN(estimator.emf.w0_rad_s, 1.0f, 2.0f / TS, LODE_ERROR_EMF_W0),
    OPEN(estimator.pll.sigma_rad_s, 1.0f, 0.3f / TS, LODE_ERROR_PLL_SIGMA),
    OPEN(estimator.emin_V, 1.0e-4f, 1.0e3f, LODE_ERROR_EMIN),
    OPEN(estimator.omega_max_rad_s, 1.0f, 0.5f / TS, LODE_ERROR_OMEGA_MAX),
    OPEN(estimator.lock_s, TS, 1.0f, LODE_ERROR_LOCK_TIME),
    OPEN(current.bandwidth_rad_s, 1.0f, 0.4f / TS, LODE_ERROR_CURRENT_BANDWIDTH),
    OPEN(current.voltage_use, 0.1f, 1.1547f, LODE_ERROR_CURRENT_VOLTAGE),
    OPEN(start.current_A, 0.012f, 12.0f, LODE_ERROR_START_CURRENT),
    OPEN(guard.i_trip_A, 12.0f, 2047.0f * 0.0125f, LODE_ERROR_GUARD_CURRENT),
    OPEN(guard.v_bus_max_V, 200.0f, 409.5f, LODE_ERROR_GUARD_BUS),
    OPEN(guard.bus_s, TS, 10.0f, LODE_ERROR_GUARD_TIME),
    OPEN(guard.lock_s, TS, 10.0f, LODE_ERROR_GUARD_TIME),
    OPEN(guard.overload_s, TS, 10.0f, LODE_ERROR_GUARD_TIME),
    OPEN(guard.flux_share, 0.1f, 1.0f, LODE_ERROR_GUARD_FLUX),
    OPEN(guard.bus_still_s, 0.0f, 524280.0f * TS, LODE_ERROR_GUARD_TIME),
    OPEN(guard.temperature_still_s, 0.0f, 524280.0f * TS, LODE_ERROR_GUARD_TIME),
};

/// Fields whose limits hang on others: here only that NaN and Inf are refused by name.
static const field_t numbers[] = {
    OPEN(estimator.pll.sigma_low_rad_s, 1.0f, 1.0f, LODE_ERROR_PLL_SIGMA),
    OPEN(estimator.pll.omega_low_rad_s, 1.0f, 1.0f, LODE_ERROR_PLL_SCHEDULE),
    OPEN(references.id_bias_A, 1.0f, 12.0f, LODE_ERROR_ID_BIAS),
    OPEN(references.omega_low_rad_s, 1.0f, 1.0f, LODE_ERROR_ID_BIAS),
    OPEN(current.kp_d_V_A, 1.0f, 1.0f, LODE_ERROR_CURRENT_GAINS),
    OPEN(current.kp_q_V_A, 1.0f, 1.0f, LODE_ERROR_CURRENT_GAINS),
    OPEN(current.ki_d_V_As, 1.0f, 1.0f, LODE_ERROR_CURRENT_GAINS),
    OPEN(current.ki_q_V_As, 1.0f, 1.0f, LODE_ERROR_CURRENT_GAINS),
    OPEN(speed.kp_Nms, 1.0f, 1.0f, LODE_ERROR_SPEED_GAINS),
    OPEN(speed.ki_Nm, 1.0f, 1.0f, LODE_ERROR_SPEED_GAINS),
    OPEN(speed.ramp_rad_s2, 1.0f, 1.0f, LODE_ERROR_SPEED_RAMP),
    OPEN(speed.ramp_down_rad_s2, 1.0f, 1.0f, LODE_ERROR_SPEED_RAMP),
    OPEN(speed.jerk_rad_s3, 1.0f, 1.0f, LODE_ERROR_SPEED_RAMP),
    OPEN(speed.gain_rise, 1.0f, 1.0f, LODE_ERROR_SPEED_GAINS),
    OPEN(speed.dip_gain, 0.0f, 10.0f, LODE_ERROR_SPEED_GAINS),
    OPEN(start.align_s, 0.0f, 10.0f, LODE_ERROR_START_RAMP),
    OPEN(start.catch_s, 0.0f, 10.0f, LODE_ERROR_START_RAMP),
    OPEN(speed.load_feed_forward, 0.0f, 1.0f, LODE_ERROR_SPEED_FEED_FORWARD),
    OPEN(speed.inertia_feed_forward, 0.0f, 1.0f, LODE_ERROR_SPEED_FEED_FORWARD),
    OPEN(speed.omega_min_rad_s, 1.0f, 1.0f, LODE_ERROR_START_SPEED),
    OPEN(start.omega_handover_rad_s, 1.0f, 1.0f, LODE_ERROR_START_SPEED),
    OPEN(start.ramp_rad_s2, 1.0f, 1.0f, LODE_ERROR_START_RAMP),
    OPEN(start.current_last_A, 1.0f, 1.0f, LODE_ERROR_START_CURRENT),
    OPEN(start.current_rise_s, 1.0f, 1.0f, LODE_ERROR_START_RAMP),
    OPEN(start.damping, 0.0f, 2.0f, LODE_ERROR_START_DAMPING),
    OPEN(start.lock_s, 1.0f, 1.0f, LODE_ERROR_START_RAMP),
    OPEN(start.timeout_s, 1.0f, 1.0f, LODE_ERROR_START_RAMP),
    OPEN(start.fade_s, 1.0f, 1.0f, LODE_ERROR_START_RAMP),
    OPEN(sense.i_offset_tol_count, 1.0f, 1.0f, LODE_ERROR_SENSE_OFFSET),
    OPEN(sense.count_max, 1.0f, 1.0f, LODE_ERROR_SENSE_OFFSET),
    OPEN(guard.v_bus_min_V, 1.0f, 1.0f, LODE_ERROR_GUARD_BUS),
    OPEN(guard.temperature_max_degC, 1.0f, 1.0f, LODE_ERROR_GUARD_TEMPERATURE),
    OPEN(guard.omega_max_rad_s, 1.0f, 1.0f, LODE_ERROR_GUARD_SPEED),
    OPEN(guard.stamp_per_period, 1.0f, 1.0f, LODE_ERROR_GUARD_TIME),
};

static void test_only_motor_inverter_sense_and_rate_are_needed(void) {
    const lode_drive_config_t config = minimal();
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(try_config(&config)));
    lode_drive_config_t no_rating = minimal();
    no_rating.motor.omega_rated_rad_s = 0.0f;
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(try_config(&no_rating)));
}

typedef struct {
    const char *name;
    float pole_pairs, R, Ld, Lq, psi, J, v_bus, i_max, f_pwm;
} machine_t;

static void test_motors_of_many_kinds_need_no_more(void) {
    static const machine_t machines[] = {
        {"paper", 3.0f, 0.75f, 3.5e-3f, 9.8e-3f, 0.142f, 0.0174f, 200.0f, 12.0f, 5.0e3f},
        {"paper, 20 kHz", 3.0f, 0.75f, 3.5e-3f, 9.8e-3f, 0.142f, 0.0174f, 200.0f, 12.0f, 2.0e4f},
        {"drone", 7.0f, 0.06f, 18.0e-6f, 22.0e-6f, 1.1e-3f, 9.0e-6f, 16.0f, 30.0f, 4.0e4f},
        {"gimbal", 7.0f, 10.0f, 2.0e-3f, 2.0e-3f, 0.018f, 8.0e-6f, 12.0f, 1.0f, 2.0e4f},
        {"e-bike hub", 23.0f, 0.11f, 0.18e-3f, 0.21e-3f, 0.018f, 0.07f, 36.0f, 25.0f, 2.0e4f},
        {"fan", 4.0f, 3.2f, 6.0e-3f, 6.5e-3f, 0.025f, 8.0e-5f, 24.0f, 2.0f, 1.6e4f},
        {"compressor", 3.0f, 0.9f, 7.0e-3f, 12.0e-3f, 0.11f, 1.0e-3f, 310.0f, 12.0f, 8.0e3f},
        {"servo, 400 V", 4.0f, 1.1f, 5.0e-3f, 5.0e-3f, 0.2f, 8.0e-4f, 560.0f, 10.0f, 1.0e4f},
        {"traction", 4.0f, 8.0e-3f, 0.11e-3f, 0.3e-3f, 0.065f, 0.05f, 350.0f, 400.0f, 1.0e4f},
        {"spindle", 2.0f, 0.4f, 0.9e-3f, 0.9e-3f, 0.03f, 1.0e-4f, 300.0f, 15.0f, 2.0e4f},
    };
    for (int i = 0; i < COUNT_OF(machines); i++) {
        const machine_t *m = &machines[i];
        lode_drive_config_t config = minimal();
        config.f_pwm_Hz = m->f_pwm;
        config.motor = (lode_motor_t){.pole_pairs = m->pole_pairs,
                                      .Rs_Ohm = m->R,
                                      .Ld_H = m->Ld,
                                      .Lq_H = m->Lq,
                                      .psi_Wb = m->psi,
                                      .J_kgm2 = m->J};
        config.inverter = (lode_inverter_config_t){
            .v_bus_V = m->v_bus, .i_max_A = m->i_max, .dead_time_s = 5.0e-7f};
        config.sense.i_gain_A_count = 2.0f * m->i_max / 2047.0f;
        config.sense.v_bus_gain_V_count = 1.5f * m->v_bus / 4095.0f;
        TEST_ASSERT_EQUAL_STRING_MESSAGE("LODE_OK", lode_status_name(try_config(&config)), m->name);
    }
}

static void test_every_needed_field_at_its_limits(void) {
    field_check_all(needed, COUNT_OF(needed), try_one);
    const field_t dead_time = NEEDED(inverter.dead_time_s, 0.0f, 0.2f * TS, LODE_ERROR_DEAD_TIME);
    field_check_numbers(&dead_time, try_one);
    field_accepted(&dead_time, try_one, 0.0f);
    field_accepted(&dead_time, try_one, 0.199f * TS);
    field_refused(&dead_time, try_one, 0.201f * TS);
    field_refused(&dead_time, try_one, -1.0e-9f);
}

static void test_every_open_field_at_its_limits(void) {
    field_check_all(open_fields, COUNT_OF(open_fields), try_one);
}

static void test_no_field_takes_what_is_no_number(void) {
    for (int i = 0; i < COUNT_OF(numbers); i++) {
        field_check_numbers(&numbers[i], try_one);
        field_accepted(&numbers[i], try_one, 0.0f);
    }
    const size_t several[] = {offsetof(lode_drive_config_t, estimator.pll.omega_high_rad_s),
                              offsetof(lode_drive_config_t, references.omega_high_rad_s),
                              offsetof(lode_drive_config_t, speed.bandwidth_rad_s)};
    for (int i = 0; i < COUNT_OF(several); i++) {
        for (int n = 0; n < COUNT_OF(check_not_finite); n++) {
            if (check_not_finite[n] != -INFINITY) {
                TEST_ASSERT_TRUE(try_one(several[i], check_not_finite[n]) != LODE_OK);
            }
        }
    }
}

static void test_negative_values_ask_for_no_default(void) {
    for (int i = 0; i < COUNT_OF(open_fields); i++) {
        field_check_negative(&open_fields[i], try_one);
    }
}

static void test_lode_none_is_for_those_that_may_be_done_without(void) {
    const size_t fields[] = {offsetof(lode_drive_config_t, references.id_bias_A),
                             offsetof(lode_drive_config_t, speed.load_feed_forward),
                             offsetof(lode_drive_config_t, speed.dip_gain),
                             offsetof(lode_drive_config_t, speed.inertia_feed_forward),
                             offsetof(lode_drive_config_t, start.damping),
                             offsetof(lode_drive_config_t, start.catch_s),
                             offsetof(lode_drive_config_t, references.trim_rad_s),
                             offsetof(lode_drive_config_t, guard.i_sum_A),
                             offsetof(lode_drive_config_t, guard.overload_s)};
    for (int i = 0; i < COUNT_OF(fields); i++) {
        TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(try_one(fields[i], LODE_NONE)));
    }
}

static void test_sense_must_fit_the_inverter(void) {
    const size_t i_gain = offsetof(lode_drive_config_t, sense.i_gain_A_count);
    const size_t v_gain = offsetof(lode_drive_config_t, sense.v_bus_gain_V_count);
    const size_t offset = offsetof(lode_drive_config_t, sense.i_offset_count);
    const size_t t_gain = offsetof(lode_drive_config_t, sense.temperature_gain_degC_count);
    const size_t t_offset = offsetof(lode_drive_config_t, sense.temperature_offset_degC);
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_one(i_gain, 0.005f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_one(i_gain, 0.0f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(i_gain, -0.0125f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_BUS, try_one(v_gain, 0.04f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_BUS, try_one(v_gain, 0.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_OFFSET, try_one(offset, 5000.0f));
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        const float x = check_not_finite[i];
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_CURRENT, try_one(i_gain, x));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_BUS, try_one(v_gain, x));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_OFFSET, try_one(offset, x));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_TEMPERATURE, try_one(t_gain, x));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_TEMPERATURE, try_one(t_offset, x));
    }
}

/// Over-speed below the speed at which a start ends, or the least one in RUN, would trip at once. With injection there is
/// neither.
static void test_over_speed_lies_above_the_least_speed(void) {
    static lode_drive_tuning_t tuning;
    lode_drive_config_t config = minimal();
    lode_drive_config_t designed = config;
    lode_drive_design(&designed);
    const float handover = designed.start.omega_handover_rad_s;
    const struct {
        float least, limit;
        lode_status_t status;
    } cases[] = {
        {0.6f, 1.01f, LODE_OK},
        {0.6f, 0.99f, LODE_ERROR_GUARD_SPEED},
        {1.2f, 1.21f, LODE_OK},
        {1.2f, 1.19f, LODE_ERROR_GUARD_SPEED},
    };
    for (int n = 0; n < COUNT_OF(cases); n++) {
        config.speed.omega_min_rad_s = cases[n].least * handover;
        config.guard.omega_max_rad_s = cases[n].limit * handover;
        TEST_ASSERT_EQUAL_INT(cases[n].status, lode_drive_tune(&tuning, &config));
    }
    config.hfi.mode = LODE_HFI_ON;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    config.guard.omega_max_rad_s = 0.99f * handover;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
}

static void test_double_update_needs_currents_from_the_phases(void) {
    lode_drive_config_t config = minimal();
    config.inverter.double_update = LODE_ON;
    config.start.catch_s = 0.02f;
    lode_drive_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    TEST_ASSERT_FALSE(tuning.fly.share_first > 0.0f); // low-side pulses
    config.sense.duty_max = 0.9f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_DOUBLE_UPDATE, lode_drive_tune(&tuning, &config));
    config.inverter.double_update = LODE_AUTO;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    TEST_ASSERT_TRUE(tuning.fly.share_first > 0.0f);
}

// With two low-side shunts no third one can take the place of a phase without time.
static void test_two_shunts_bound_the_voltage(void) {
    lode_drive_config_t config = minimal();
    config.sense.shunts = LODE_SHUNTS_TWO;
    lode_drive_config_t designed = config;
    lode_drive_design(&designed);
    CHECK_CLOSE(1e-6, 0.95, designed.current.voltage_use); // sampled always
    config.sense.duty_max = 0.9f;
    designed = config;
    lode_drive_design(&designed);
    const double room = 2.0 * 50.0e-9 * (double)config.f_pwm_Hz; // what a start finds by chance
    CHECK_CLOSE(1e-5, 0.8 - room, designed.current.voltage_use);
    config.inverter.dead_time_s = 0.02f / config.f_pwm_Hz;
    config.inverter.v_drop_V = 0.01f * config.inverter.v_bus_V;
    designed = config;
    lode_drive_design(&designed);
    CHECK_CLOSE(1e-5, 0.74 - room, designed.current.voltage_use);
    lode_drive_tuning_t tuning;
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(lode_drive_tune(&tuning, &config)));
    config.current.voltage_use = 0.75f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_WINDOW, lode_drive_tune(&tuning, &config));
    // All that is seen may be used, none of it kept for what a start finds.
    config.current.voltage_use = 0.74f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    config.current.voltage_use = 0.75f;
    config.sense.shunts = LODE_SHUNTS_THREE; // the third one helps
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    config.sense.shunts = LODE_SHUNTS_TWO;
    config.sense.duty_max = 0.99f; // nothing to bound
    config.current.voltage_use = 0.0f;
    designed = config;
    lode_drive_design(&designed);
    TEST_ASSERT_TRUE(designed.current.voltage_use < 0.93f);
    // Both always seen: whatever the dead time takes.
    config.sense.duty_max = 1.0f;
    config.inverter.v_drop_V = 0.04f * config.inverter.v_bus_V;
    designed = config;
    lode_drive_design(&designed);
    CHECK_CLOSE(1e-6, 0.95, designed.current.voltage_use);
    config.current.voltage_use = 1.0f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
}

/// The slope of the switches is resistance like that of the windings, for estimator and current control.
static void test_the_slope_of_the_switches_counts_as_resistance(void) {
    static lode_drive_tuning_t tunings[3];
    for (int n = 0; n < 3; n++) {
        lode_drive_config_t config = minimal();
        config.motor.omega_rated_rad_s = 471.0f;
        config.motor.Rs_Ohm = n == 1 ? 1.0f : 0.75f;
        config.inverter.r_on_Ohm = n == 0 ? 0.25f : 0.0f;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tunings[n], &config));
    }
    TEST_ASSERT_EQUAL_MEMORY(&tunings[0].estimator.emf, &tunings[1].estimator.emf,
                             sizeof tunings[0].estimator.emf);
    TEST_ASSERT_EQUAL_MEMORY(&tunings[0].current, &tunings[1].current, sizeof tunings[0].current);
    TEST_ASSERT_TRUE(memcmp(&tunings[0].current, &tunings[2].current, sizeof tunings[0].current) !=
                     0);
}

/// Twice the speed whose EMF is all of the voltage, 2.5 to 5 times rated, 12 periods per turn; where the field is weakened.
static void test_the_highest_speed_with_a_weakened_field(void) {
    const double full = 200.0 / sqrt(3.0) / 0.142;
    const double rated[] = {1.8 / 5.0, 2.2 / 5.0, 1.8 / 2.5, 2.2 / 2.5};
    const double wanted[] = {1.8, 2.0, 2.0, 2.2};
    for (int n = 0; n < COUNT_OF(rated); n++) {
        lode_drive_config_t config = minimal();
        config.motor.omega_rated_rad_s = (float)(rated[n] * full);
        config.references.field_weakening = LODE_ON;
        lode_drive_config_t slow = config;
        lode_drive_design(&config);
        CHECK_CLOSE(1.0e-5, wanted[n] * full, config.estimator.omega_max_rad_s);
        slow.f_pwm_Hz = 1500.0f;
        lode_drive_design(&slow);
        CHECK_CLOSE(1.0e-5, 750.0, slow.estimator.omega_max_rad_s);
        lode_drive_config_t strong = minimal();
        strong.motor.omega_rated_rad_s = (float)(rated[n] * full);
        lode_drive_design(&strong);
        CHECK_CLOSE(1.0e-5, 2.5 * rated[n] * full, strong.estimator.omega_max_rad_s);
    }
}

/// An inertia beyond all machines leaves speed control no gain, and its design no division by it.
static void test_an_absurd_inertia_is_refused(void) {
    lode_drive_config_t config = minimal();
    config.motor.J_kgm2 = 3.0e38f;
    lode_drive_design(&config);
    TEST_ASSERT_TRUE(config.speed.gain_rise >= 1.0f && config.speed.gain_rise <= 10.0f);
    lode_drive_tuning_t tuning;
    TEST_ASSERT_FALSE(lode_drive_tune(&tuning, &config) == LODE_OK);
}

/// A torque that fades with the bus is gone halfway to where the guard trips, unless somebody says where.
static void test_a_torque_that_fades_with_the_bus_is_gone_before_the_guard_trips(void) {
    lode_drive_config_t config = minimal();
    config.guard.v_bus_max_V = 250.0f;
    config.guard.v_bus_min_V = 120.0f;
    config.references.v_regen_V = 220.0f;
    config.references.v_motor_V = 180.0f;
    lode_drive_config_t designed = config;
    lode_drive_design(&designed);
    TEST_ASSERT_EQUAL_FLOAT(235.0f, designed.references.v_bus_max_V);
    TEST_ASSERT_EQUAL_FLOAT(150.0f, designed.references.v_bus_min_V);
    config.references.v_bus_max_V = 249.0f;
    config.references.v_bus_min_V = 121.0f;
    lode_drive_design(&config);
    TEST_ASSERT_EQUAL_FLOAT(249.0f, config.references.v_bus_max_V);
    TEST_ASSERT_EQUAL_FLOAT(121.0f, config.references.v_bus_min_V);
}

/// The voltages that references reckon with are those between which the guard lets it run; the d axis may take nearly all
/// of them where the field is weakened.
static void test_references_know_the_bus_that_the_guard_allows(void) {
    lode_drive_config_t config = minimal();
    lode_drive_tuning_t tuning;
    config.guard.v_bus_max_V = 237.0f;
    config.guard.v_bus_min_V = 121.0f;
    lode_drive_config_t designed = config;
    lode_drive_design(&designed);
    TEST_ASSERT_EQUAL_FLOAT(237.0f, designed.references.v_bus_max_V);
    TEST_ASSERT_EQUAL_FLOAT(121.0f, designed.references.v_bus_min_V);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    TEST_ASSERT_EQUAL_UINT32(0u, tuning.current.weakens);
    config.references.field_weakening = LODE_ON;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    TEST_ASSERT_EQUAL_UINT32(1u, tuning.current.weakens);
}

/// What moves once in a period of speed control moves as fast at every rate of it.
static void test_what_follows_speed_control_has_its_rate(void) {
    static lode_drive_tuning_t tunings[2];
    for (int n = 0; n < 2; n++) {
        lode_drive_config_t config = minimal();
        config.references.field_weakening = LODE_ON;
        config.speed.bandwidth_rad_s = 10.0f;
        config.speed.every_period = n == 0 ? LODE_ON : LODE_OFF;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tunings[n], &config));
    }
    TEST_ASSERT_EQUAL_UINT32(1u, tunings[0].speed_periods);
    const double times = (double)tunings[1].speed_periods;
    TEST_ASSERT_TRUE(times > 1.0);
    CHECK_CLOSE(1.0e-5, times * (double)tunings[0].start.fade_step, tunings[1].start.fade_step);
    CHECK_CLOSE(1.0e-5, times * (double)tunings[0].speed.ramp_step, tunings[1].speed.ramp_step);
    CHECK_CLOSE(1.0e-5, times * (double)tunings[0].references.rise_A, tunings[1].references.rise_A);
    lode_drive_config_t designed = minimal();
    designed.references.field_weakening = LODE_ON;
    lode_drive_design(&designed);
    CHECK_CLOSE(1.0e-4, 12.0 * 2.0e-4 / (double)designed.references.release_s,
                tunings[0].references.rise_A);
}

/// What a start tries before its first vector knows the period, and whether the sum of the currents counts.
static void test_pulses_know_the_period_and_the_sum(void) {
    static lode_drive_tuning_t tuning;
    lode_drive_config_t config = minimal();
    config.inverter.dead_time_s = 2.0e-6f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    CHECK_CLOSE(1.0e-6, 2.0 * 2.0e-6 / 2.0e-4, tuning.fly.share_dead);
    TEST_ASSERT_TRUE(tuning.signal_check.sum_most < 1.0f);
    config.guard.i_sum_A = LODE_NONE;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&tuning, &config));
    TEST_ASSERT_EQUAL_FLOAT(FLT_MAX, tuning.signal_check.sum_most);
}

/// Motor and inverter are looked at before anything is computed of them.
static void test_what_is_given_is_checked_by_itself(void) {
    lode_drive_config_t config = minimal();
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_check_given(&config));
    config.motor.Rs_Ohm = NAN;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_RS, lode_drive_check_given(&config));
    config = minimal();
    config.inverter.v_bus_V = NAN;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_V_BUS, lode_drive_check_given(&config));
    config.f_pwm_Hz = NAN;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_F_PWM, lode_drive_check_given(&config));
}

static void test_enumerators(void) {
    lode_drive_config_t config = minimal();
    config.sense.shunts = (lode_shunts_t)9;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SENSE_SHUNTS, try_config(&config));
    config = minimal();
    config.estimator.emf.kind = LODE_EMF_KINDS;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_EMF_KIND, try_config(&config));
    config = minimal();
    config.estimator.pll.kind = (lode_pll_kind_t)9;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_KIND, try_config(&config));
    config = minimal();
    config.estimator.compensation = (lode_lag_kind_t)9;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_LAG, try_config(&config));
    config = minimal();
    config.estimator.active_flux = (lode_choice_t)9;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, try_config(&config));
    config = minimal();
    config.inverter.dead_time_correction = (lode_choice_t)9;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, try_config(&config));
    config = minimal();
    config.inverter.dead_time_model = (lode_choice_t)9;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, try_config(&config));
    config = minimal();
    config.speed.every_period = (lode_choice_t)9;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, try_config(&config));
    for (int n = 0; n < 3; n++) {
        config = minimal();
        lode_choice_t *const checks[] = {&config.guard.check_stuck, &config.guard.check_gain,
                                         &config.guard.check_half_waves};
        *checks[n] = (lode_choice_t)9;
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, try_config(&config));
    }
}

static void test_pole_pairs(void) {
    const size_t offset = offsetof(lode_drive_config_t, motor.pole_pairs);
    const float bad[] = {0.0f, 0.5f, 1.5f, 101.0f, -3.0f, NAN, INFINITY, -INFINITY, FLT_MAX};
    for (int i = 0; i < COUNT_OF(bad); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_POLE_PAIRS, try_one(offset, bad[i]));
    }
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, 1.0f));
}

static void test_combinations_that_would_not_be_stable(void) {
    lode_drive_config_t config = minimal();
    config.estimator.emf.w0_rad_s = 200.0f; // sigma 100 at half of it
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_PLL_OBSERVER, try_config(&config));
    config = minimal();
    config.speed.kp_Nms = 5.0f; // crossover 287 rad/s above the PLL's 60
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_BANDWIDTH, try_config(&config));
    config = minimal();
    config.speed.kp_Nms = 1.0e-7f * FLT_MIN; // over this inertia: a bandwidth of nothing
    config.speed.gain_rise = 1.0f;
    config.motor.J_kgm2 = 3.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_SPEED_GAINS, try_config(&config));
    config = minimal();
    config.current.kp_q_V_A = 49.0f; // Lq/Ts
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CURRENT_GAINS, try_config(&config));
    config = minimal();
    config.motor.Rs_Ohm = 30.0f; // settles within a period
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_PERIOD, try_config(&config));
}

static void test_least_speed_is_near_or_above_the_hand_over(void) {
    lode_drive_config_t config = minimal();
    lode_drive_design(&config);
    const float handover = config.start.omega_handover_rad_s;
    const size_t least = offsetof(lode_drive_config_t, speed.omega_min_rad_s);
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_START_SPEED, try_one(least, 0.4f * handover));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(least, 0.6f * handover));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(least, 2.0f * handover));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_START_SPEED,
                          try_one(least, 1.01f * config.estimator.omega_max_rad_s));
}

// --- Every float of the tuning of an accepted configuration is a number ------------------------------

#define NAME_OF_FLOAT(type, member) name = lode_is_finite((float)t->member) ? name : #member;
#define NAME_OF_OBSERVER(place, member) NAME_OF_FLOAT(float, member)
#define NAME_OF_WHOLE(type, member)
#define NAME_OF_INTEGER(type, member)
#define NAME_OF_BOOL(type, member)
#define NAME_OF_CHOICE(type, member)
#define NAME_OF(kind, type, member) NAME_OF_##kind(type, member)

/// The last float that is none, or NULL.
static const char *not_finite(const lode_drive_tuning_t *t) {
    const char *name = NULL;
    TUNING_FIELDS(NAME_OF)
    return name;
}

/// What spans and products stumble over: denormals, neighbours, the ends.
static float extreme(int n, float neighbour) {
    static const float values[] = {1.0e-45f, 1.0e-40f, FLT_MIN, 1.0e-20f, 1.0e-6f, 1.0f,
                                   100.0f,   1.0e4f,   1.0e10f, 1.0e30f,  FLT_MAX, -1.0e-45f};
    switch (n - COUNT_OF(values)) {
    case 0:
        return neighbour;
    case 1:
        return nextafterf(neighbour, INFINITY);
    case 2:
        return 2.0f * neighbour;
    default:
        return values[n % COUNT_OF(values)];
    }
}

#define EXTREMES 15  // of which the first 12 have no neighbour
#define NEIGHBOURS 4 // words apart: the ends of a span stand side by side

static int try_pairs(const lode_drive_config_t *base, int word) {
    const int words = (int)(sizeof *base / sizeof(float));
    int accepted = 0;
    for (int n = 0; n < (EXTREMES - 3) * NEIGHBOURS * EXTREMES; n++) {
        const int other = word + 1 + n / EXTREMES % NEIGHBOURS;
        lode_drive_config_t config = *base;
        const float value = extreme(n / EXTREMES / NEIGHBOURS, 0.0f);
        field_set(&config, (size_t)word * sizeof value, value);
        if (other < words) {
            field_set(&config, (size_t)other * sizeof value, extreme(n % EXTREMES, value));
        }
        lode_drive_tuning_t tuning;
        if (lode_drive_tune(&tuning, &config) == LODE_OK) {
            char text[120];
            (void)snprintf(text, sizeof text, "word %d = %g, word %d", word, (double)value, other);
            TEST_ASSERT_NULL_MESSAGE(not_finite(&tuning), text);
            accepted++;
        }
    }
    return accepted;
}

static void test_what_init_accepts_is_made_of_numbers(void) {
    lode_drive_config_t base = minimal();
    base.references.kind = LODE_REFERENCES_MTPA;
    base.references.field_weakening = LODE_ON;
    base.references.v_regen_V = 210.0f;
    base.references.v_motor_V = 190.0f;
    int accepted = 0;
    for (int word = 0; word < (int)(sizeof base / sizeof(float)); word += CHECK_SHARE) {
        accepted += try_pairs(&base, word);
    }
    CHECK_AT_LEAST(1000 / CHECK_SHARE, accepted);
}

static void test_null_pointers(void) {
    const lode_drive_config_t config = minimal();
    static lode_drive_t drive;
    static lode_drive_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_init(NULL, &tuning, &config));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_init(&drive, NULL, &config));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_init(&drive, &tuning, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_tune(NULL, &config));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_drive_tune(&tuning, NULL));
}

static void test_design_of_the_papers_drive(void) {
    lode_drive_config_t config = minimal();
    lode_drive_design(&config);
    // Near what the paper and its simulation chose: w0 2000, 150 rpm, Emin 2 V.
    CHECK_CLOSE(0.06, 2000.0, config.estimator.emf.w0_rad_s);
    CHECK_CLOSE(1.0e-5, 0.1 * PAPER_OMEGA_RATED, config.start.omega_handover_rad_s);
    CHECK_CLOSE(0.01, 2.0, config.estimator.emin_V);
    // A second design leaves a complete configuration alone.
    lode_drive_config_t again = config;
    lode_drive_design(&again);
    TEST_ASSERT_EQUAL_MEMORY(&config, &again, sizeof config);
    // And init makes the same of the open and of the completed one.
    static lode_drive_tuning_t a;
    static lode_drive_tuning_t b;
    const lode_drive_config_t open = minimal();
    memset(&a, 0, sizeof a);
    memset(&b, 0, sizeof b);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&a, &open));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&b, &config));
    TEST_ASSERT_EQUAL_FLOAT(a.estimator.emin_V, b.estimator.emin_V);
    TEST_ASSERT_EQUAL_FLOAT(a.speed.pi.kp, b.speed.pi.kp);
    TEST_ASSERT_EQUAL_FLOAT(a.guard.i_trip, b.guard.i_trip);
}

/// What design makes of paper 1's motor with another inertia and Lq.
static lode_pll_config_t pll_with(double inertia, float Lq_H, lode_references_kind_t kind) {
    lode_drive_config_t config = minimal();
    config.motor.J_kgm2 *= (float)inertia;
    config.motor.Lq_H = Lq_H;
    config.references.kind = kind;
    config.start.omega_handover_rad_s = (float)(0.2 * PAPER_OMEGA_RATED); // no (P28)
    lode_drive_design(&config);
    return config.estimator.pll;
}

/// (K22) of paper 1's motor with half of its inertia and a slow observer, whose speed control has one slot in eight
/// periods and, at `f_pwm_Hz` of a half, one in four.
static double light_bandwidth(double f_pwm_Hz, double periods) {
    lode_drive_config_t config = minimal();
    config.f_pwm_Hz = (float)f_pwm_Hz;
    config.motor.J_kgm2 *= 0.5f;
    config.motor.Ld_H = 3.0e-3f;
    config.motor.Lq_H = 3.0e-3f;
    config.estimator.emf.w0_rad_s = 600.0f;
    config.estimator.pll.sigma_rad_s = 120.0f;
    config.speed.omega_min_rad_s = 1.0e4f; // no load stops a rotor that fast
    lode_drive_design(&config);
    const double kp_Ohm = 0.2 * f_pwm_Hz * 3.0e-3;
    const double r_Ohm = (double)config.motor.Rs_Ohm + kp_Ohm;
    const double x_Ohm = 120.0 * 3.0e-3 - (double)config.motor.Rs_Ohm * 0.2 * f_pwm_Hz / 120.0;
    const double emf_Vs = 3.0 * (double)config.motor.psi_Wb;
    const double damping = 1.5 * emf_Vs * emf_Vs * r_Ohm / (r_Ohm * r_Ohm + x_Ohm * x_Ohm) /
                           (0.25 * (double)config.motor.J_kgm2);
    const double delay_s = 2.0 / 600.0 + (5.0 + periods) / f_pwm_Hz;
    const double wanted = (120.0 + damping) / (1.41 * (0.75 + 4.9 * 120.0 * delay_s));
    return (double)config.speed.bandwidth_rad_s / wanted;
}

static void test_speed_control_knows_its_delays(void) {
    CHECK_CLOSE(1.0e-4, 1.0, light_bandwidth(5000.0, 8.0));
    CHECK_CLOSE(1.0e-4, 1.0, light_bandwidth(2500.0, 3.0));
}

/// (P21), by a hand-over that is given; bounded by the inertia and by the sampling; not where any is given.
/// (P28): a hand-over beyond a fifth of rated speed bounds sigma by five times its speed, up to 0.175 of what the run-up time requires.
/// The observer follows (P10).
static void test_a_late_hand_over_leaves_room_for_sigma(void) {
    static const double inertia[] = {1.0e-2, 1.0e-2, 0.1};
    for (int n = 0; n < 3; n++) {
        const double times = n == 0 ? 1.0 : 1.5;
        lode_drive_config_t config = minimal();
        config.motor.J_kgm2 *= (float)inertia[n];
        config.motor.Lq_H = config.motor.Ld_H;
        config.f_pwm_Hz = 20000.0f;
        config.references.field_weakening = LODE_ON; // no (P21)
        config.start.omega_handover_rad_s = (float)(0.2 * times * PAPER_OMEGA_RATED);
        lode_drive_design(&config);
        // With a tenth of the inertia the run-up time requires 477 rad/s, 0.175 of which is less than rated speed allows.
        const double sigma = 0.66 * (n == 2 ? 1.0 : times) * PAPER_OMEGA_RATED;
        CHECK_CLOSE(1.0e-4, sigma, config.estimator.pll.sigma_low_rad_s);
        CHECK_CLOSE(1.0e-4, sigma, config.estimator.pll.sigma_rad_s);
        CHECK_CLOSE(1.0e-4, 4.25 / 0.66 * sigma, config.estimator.emf.w0_rad_s);
    }
}

/// (P33): from 1.9 times the inertia of paper 1's motor on, sigma at speed is 4 times what the run-up time requires, but no
/// less than at low speed.
static void test_a_heavy_rotor_has_less_sigma(void) {
    static const double inertia[] = {1.0, 3.0, 100.0};
    for (int n = 0; n < COUNT_OF(inertia); n++) {
        lode_drive_config_t config = minimal();
        config.motor.J_kgm2 *= (float)inertia[n];
        lode_drive_design(&config);
        const double kt = 1.5 * (double)config.motor.pole_pairs * (double)config.motor.psi_Wb;
        const double run_up_s =
            (double)config.motor.J_kgm2 * PAPER_OMEGA_RATED /
            ((double)config.motor.pole_pairs * kt * (double)config.inverter.i_max_A);
        const double by_speed = 0.2122 * PAPER_OMEGA_RATED;
        const double by_run_up = 4.0 * 17.0 / run_up_s;
        const double low = 0.1061 * PAPER_OMEGA_RATED;
        TEST_ASSERT_EQUAL(n > 0, by_run_up < by_speed);
        TEST_ASSERT_EQUAL(n > 1, by_run_up < low);
        CHECK_CLOSE(1.0e-4, low, config.estimator.pll.sigma_low_rad_s);
        CHECK_CLOSE(1.0e-4, fmax(fmin(by_speed, by_run_up), low), config.estimator.pll.sigma_rad_s);
    }
}

/// sigma over what `rated` speed allows. The motor loses `lost` of its flux to an error of Lq - Ld, hands over at `late` of rated
/// speed, its run-up time requires `need`, rad/s, and dead time takes `dead_V` from a phase, `drop` of them its drops.
static double times_with_dead_time(double rated, double late, double lost, double need,
                                   double dead_V, double drop) {
    lode_drive_config_t config = minimal();
    lode_motor_t *motor = &config.motor;
    config.f_pwm_Hz = 20000.0f;
    config.references.field_weakening = LODE_ON; // no (P21)
    config.start.current_A = 6.0f;
    motor->omega_rated_rad_s = (float)rated;
    motor->Lq_H = motor->Ld_H + (float)(lost * (double)motor->psi_Wb / 6.0);
    config.start.omega_handover_rad_s = (float)(late * rated);
    motor->J_kgm2 *= (float)(17.0 / need / (double)lode_motor_run_up_s(motor, 12.0f));
    config.inverter.dead_time_s =
        (float)((1.0 - drop) * dead_V / 20000.0 / (double)config.inverter.v_bus_V);
    config.inverter.v_drop_V = (float)(drop * dead_V);
    lode_drive_design(&config);
    return (double)config.estimator.pll.sigma_low_rad_s / (0.66 * (1.0 - 1.2 * lost) * rated);
}

/// With so much dead time that it allows nothing.
static double times_of_sigma(double rated, double late, double lost, double need) {
    return times_with_dead_time(rated, late, lost, need, 500.0, 0.0);
}

/// (P29): with little saliency and a rotor that a rated load does not stop at once, 0.15 takes the place of a fifth and 0.6 that
/// of 0.175.
static void test_a_rotor_that_can_be_held_gets_more_sigma(void) {
    CHECK_CLOSE(1.0e-4, 0.6 * 600.0 / (0.66 * 471.0), times_of_sigma(471.0, 0.25, 0.0, 600.0));
    CHECK_CLOSE(1.0e-4, 1.0, times_of_sigma(471.0, 0.25, 0.0, 17.0 * 0.25 / 0.0065));
    CHECK_CLOSE(1.0e-4, 0.25 / 0.15, times_of_sigma(200.0, 0.25, 0.0, 500.0));
    CHECK_CLOSE(1.0e-4, 0.5 / 0.15, times_of_sigma(200.0, 0.5, 0.0, 1000.0));
    CHECK_CLOSE(1.0e-4, 0.25 / 0.15, times_of_sigma(200.0, 0.25, 0.19, 500.0));
    CHECK_CLOSE(1.0e-4, 1.0, times_of_sigma(200.0, 0.25, 0.21, 500.0));
}

/// (P34): such a rotor has up to 0.6 of what its run-up time requires at any hand-over, but no more than 8 times the hand-over
/// speed and than dead time allows.
static void test_little_dead_time_allows_more_sigma(void) {
    const double by_dead_time =
        cbrt(0.153 * (double)paper_motor().psi_Wb / (17.0 / 600.0 * 0.5)) / 0.66;
    for (int n = 0; n < 3; n++) {
        CHECK_CLOSE(1.0e-4, by_dead_time,
                    times_with_dead_time(200.0, 0.15, 0.0, 600.0, 0.5, 0.5 * n));
    }
    CHECK_CLOSE(1.0e-4, 8.0 * 0.1 / 0.66, times_with_dead_time(200.0, 0.1, 0.0, 600.0, 0.5, 0.0));
    CHECK_CLOSE(1.0e-4, 0.6 * 600.0 / (0.66 * 471.0),
                times_with_dead_time(471.0, 0.15, 0.0, 600.0, 0.5, 0.0));
    CHECK_CLOSE(1.0e-4, by_dead_time / (1.0 - 1.2 * 0.19),
                times_with_dead_time(200.0, 0.15, 0.19, 600.0, 0.5, 0.0));
    CHECK_CLOSE(1.0e-4, 1.0, times_with_dead_time(200.0, 0.15, 0.21, 600.0, 0.5, 0.0));
    // A rotor that reaches its rated speed within 6.6 ms is stopped by its load at any speed.
    CHECK_CLOSE(1.0e-4, 8.0 * 0.15 / 0.66,
                times_with_dead_time(200.0, 0.15, 0.0, 17.0 / 0.0067, 0.5, 0.0));
    CHECK_CLOSE(1.0e-4, 1.0, times_with_dead_time(200.0, 0.15, 0.0, 17.0 / 0.0065, 0.5, 0.0));
}

static void test_a_late_hand_over_stretches_the_schedule(void) {
    const double high = 0.2 * PAPER_OMEGA_RATED;
    lode_drive_config_t config = minimal();
    config.motor.J_kgm2 *= 0.1f;
    config.motor.Lq_H = config.motor.Ld_H + 10.0e-3f; // which leaves sigma_low alone
    config.references.kind = LODE_REFERENCES_ID0;
    config.start.current_A = 11.0f;
    config.start.omega_handover_rad_s = (float)(1.5 * high);
    lode_drive_config_t late = config;
    lode_drive_design(&late);
    CHECK_CLOSE(1.0e-4, 1.5 * high, late.estimator.pll.omega_high_rad_s);
    CHECK_CLOSE(1.0e-4, 0.75 * high, late.estimator.pll.omega_low_rad_s);
    CHECK_CLOSE(1.0e-4, 1.5 * 0.2122 * PAPER_OMEGA_RATED, late.estimator.pll.sigma_rad_s);
    CHECK_CLOSE(1.0e-4, 1.5 * 0.1061 * PAPER_OMEGA_RATED, late.estimator.pll.sigma_low_rad_s);
    lode_drive_config_t weakened = config;
    weakened.references.field_weakening = LODE_ON;
    lode_drive_design(&weakened);
    CHECK_CLOSE(1.0e-4, high, weakened.estimator.pll.omega_high_rad_s);
    lode_drive_config_t heavy = config;
    heavy.motor.J_kgm2 *= 100.0f;
    lode_drive_design(&heavy);
    CHECK_CLOSE(1.0e-4, high, heavy.estimator.pll.omega_high_rad_s);
    lode_drive_config_t slow = config;
    slow.f_pwm_Hz = 1800.0f;
    lode_drive_design(&slow);
    CHECK_CLOSE(1.0e-4, 0.07 * 1800.0, slow.estimator.pll.sigma_rad_s);
    for (int k = 0; k < 4; k++) {
        lode_drive_config_t given = config;
        lode_pll_config_t *pll = &given.estimator.pll;
        float *const one[] = {&pll->omega_low_rad_s, &pll->omega_high_rad_s, &pll->sigma_rad_s,
                              &pll->sigma_low_rad_s};
        const float value[] = {47.0f, 94.0f, 100.0f, 50.0f};
        *one[k] = value[k];
        lode_drive_design(&given);
        TEST_ASSERT_EQUAL_FLOAT(value[k], *one[k]);
        CHECK_NEAR(1.0, high, pll->omega_high_rad_s);
    }
}

/// (P27): with MTPA, and only what the inertia asks for; the speeds stay.
static void test_a_light_rotor_with_mtpa_has_a_tenth_more_sigma(void) {
    const double rule = 0.2122 * PAPER_OMEGA_RATED;
    const double run_up_s = 0.0174 * PAPER_OMEGA_RATED / 3.0 / (1.5 * 3.0 * 0.142 * 12.0);
    lode_drive_config_t config = minimal();
    config.motor.Lq_H = config.motor.Ld_H + 10.0e-3f; // which leaves sigma_low alone
    config.references.kind = LODE_REFERENCES_MTPA;
    config.start.current_A = 11.0f;
    config.start.omega_handover_rad_s = (float)(0.1 * PAPER_OMEGA_RATED);
    const double inertia[] = {0.1, 17.0 / (1.05 * rule * run_up_s), 1.0};
    const double times[] = {1.1, 1.05, 1.0};
    for (int k = 0; k < 3; k++) {
        lode_drive_config_t light = config;
        light.motor.J_kgm2 *= (float)inertia[k];
        lode_drive_design(&light);
        CHECK_CLOSE(1.0e-4, times[k] * rule, light.estimator.pll.sigma_rad_s);
        CHECK_CLOSE(1.0e-4, times[k] * 0.1061 * PAPER_OMEGA_RATED,
                    light.estimator.pll.sigma_low_rad_s);
    }
    config.motor.J_kgm2 *= 0.1f;
    config.start.omega_handover_rad_s = (float)(0.3 * PAPER_OMEGA_RATED);
    lode_drive_design(&config);
    CHECK_CLOSE(1.0e-4, 1.5 * 1.1 * rule, config.estimator.pll.sigma_rad_s);
    CHECK_CLOSE(1.0e-4, 0.2 * PAPER_OMEGA_RATED, config.estimator.pll.omega_high_rad_s);
    CHECK_CLOSE(1.0e-4, 0.1 * PAPER_OMEGA_RATED, config.estimator.pll.omega_low_rad_s);
}

static void test_a_light_rotor_raises_sigma(void) {
    const float Ld_H = minimal().motor.Ld_H;
    const double torque_Nm = 1.5 * 3.0 * 0.142 * 12.0;
    const double run_up_s = 0.0174 * PAPER_OMEGA_RATED / 3.0 / torque_Nm;
    const lode_pll_config_t plain = pll_with(1.0, Ld_H, LODE_REFERENCES_AUTO);
    CHECK_CLOSE(1.0e-3, 0.1061 * PAPER_OMEGA_RATED, plain.sigma_low_rad_s);
    CHECK_CLOSE(1.0e-3, 0.2122 * PAPER_OMEGA_RATED, plain.sigma_rad_s);
    const lode_pll_config_t light = pll_with(0.5, Ld_H, LODE_REFERENCES_AUTO);
    CHECK_CLOSE(1.0e-3, 17.0 / (0.5 * run_up_s), light.sigma_low_rad_s);
    CHECK_CLOSE(1.0e-3, 0.2122 * PAPER_OMEGA_RATED, light.sigma_rad_s);
    const lode_pll_config_t lightest = pll_with(0.01, Ld_H, LODE_REFERENCES_AUTO);
    CHECK_CLOSE(1.0e-3, 0.66 * PAPER_OMEGA_RATED, lightest.sigma_low_rad_s);
    TEST_ASSERT_EQUAL_FLOAT(lightest.sigma_low_rad_s, lightest.sigma_rad_s);
    // Salient, of the 8.4 A of the start: 3.3 mH more take 0.195 of the flux.
    const double left = 1.0 - 1.2 * 3.3e-3 * 8.4 / 0.142;
    const lode_pll_config_t salient = pll_with(0.01, Ld_H + 3.3e-3f, LODE_REFERENCES_ID0);
    CHECK_CLOSE(1.0e-3, 0.66 * left * PAPER_OMEGA_RATED, salient.sigma_low_rad_s);
    // The more so where its d current moves with the torque.
    const lode_pll_config_t moving = pll_with(0.01, Ld_H + 3.3e-3f, LODE_REFERENCES_MTPA);
    CHECK_CLOSE(1.0e-3, 0.66 * left * left * PAPER_OMEGA_RATED, moving.sigma_low_rad_s);
    // Slow sampling, and what somebody gave.
    lode_drive_config_t config = minimal();
    config.motor.J_kgm2 *= 0.01f;
    config.motor.Lq_H = Ld_H;
    config.f_pwm_Hz = 3000.0f;
    config.estimator.pll.sigma_low_rad_s = 30.0f;
    lode_drive_design(&config);
    TEST_ASSERT_EQUAL_FLOAT(30.0f, config.estimator.pll.sigma_low_rad_s);
    config.estimator.pll = (lode_pll_config_t){.sigma_rad_s = 0.0f};
    lode_drive_design(&config);
    CHECK_CLOSE(1.0e-3, 0.07 * 3000.0, config.estimator.pll.sigma_low_rad_s);
}

/// (P22): 1.65 times in all that (P20) and (P21) make, up to what the default observer allows.
static void test_a_qpll_has_more_sigma(void) {
    lode_drive_config_t config = minimal();
    config.estimator.pll.kind = LODE_PLL_QPLL;
    config.motor.Lq_H = config.motor.Ld_H;
    config.start.omega_handover_rad_s = (float)(0.2 * PAPER_OMEGA_RATED); // no (P28)
    const lode_drive_config_t base = config;
    lode_drive_design(&config);
    CHECK_CLOSE(1.0e-3, 1.65 * 0.2122 * PAPER_OMEGA_RATED, config.estimator.pll.sigma_rad_s);
    CHECK_CLOSE(1.0e-3, 0.25, config.speed.bandwidth_rad_s / config.estimator.pll.sigma_low_rad_s);
    config = base;
    config.motor.J_kgm2 *= 0.5f;
    lode_drive_design(&config);
    const double run_up_s = 0.5 * 0.0174 * PAPER_OMEGA_RATED / 3.0 / (1.5 * 3.0 * 0.142 * 12.0);
    CHECK_CLOSE(1.0e-3, 1.65 * 17.0 / run_up_s, config.estimator.pll.sigma_low_rad_s);
    config = base;
    config.motor.J_kgm2 *= 0.01f;
    lode_drive_design(&config);
    CHECK_CLOSE(1.0e-3, 0.84 * PAPER_OMEGA_RATED, config.estimator.pll.sigma_low_rad_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_config(&config));
    config = base;
    config.motor.J_kgm2 *= 0.01f;
    config.f_pwm_Hz = 3000.0f;
    lode_drive_design(&config);
    CHECK_CLOSE(2.0e-3, 0.1 * 3000.0, config.estimator.pll.sigma_low_rad_s);
    config = base;
    config.motor.J_kgm2 *= 0.1f;
    config.motor.Lq_H = config.motor.Ld_H + 10.0e-3f; // which leaves sigma_low alone
    config.start.current_A = 11.0f;
    config.start.omega_handover_rad_s = (float)(0.3 * PAPER_OMEGA_RATED);
    lode_drive_design(&config);
    CHECK_CLOSE(1.0e-3, 1.5 * 1.65 * 0.2122 * PAPER_OMEGA_RATED, config.estimator.pll.sigma_rad_s);
}

/// (E30): by the rotor's time.
static void test_resonance_by_rotor(void) {
    const double run_up_s = 0.0174 * PAPER_OMEGA_RATED / 3.0 / (1.5 * 3.0 * 0.142 * 12.0);
    lode_drive_config_t config = minimal();
    lode_drive_design(&config);
    CHECK_CLOSE(1.0e-3, 17.0 / run_up_s, config.estimator.emf.gi_wc_rad_s);
    config = minimal();
    config.motor.J_kgm2 *= 0.1f;
    lode_drive_design(&config);
    TEST_ASSERT_EQUAL_FLOAT(100.0f, config.estimator.emf.gi_wc_rad_s);
    config = minimal();
    config.motor.J_kgm2 *= 100.0f;
    lode_drive_design(&config);
    CHECK_NEAR(1.0e-5, 2.0 * CHECK_PI, config.estimator.emf.gi_wc_rad_s);
    config = minimal();
    config.estimator.emf.gi_wc_rad_s = 3.0f;
    lode_drive_design(&config);
    TEST_ASSERT_EQUAL_FLOAT(3.0f, config.estimator.emf.gi_wc_rad_s);
}

/// (P23): with field weakening, and where a wave is injected; what is given stays.
static void test_FA_LESO_by_field_weakening_and_injection(void) {
    const lode_hfi_mode_t modes[] = {LODE_HFI_OFF, LODE_HFI_ON, LODE_HFI_AUTO};
    for (int n = 0; n < 6; n++) {
        lode_drive_config_t config = minimal();
        config.estimator.emf.kind = LODE_EMF_FA_LESO;
        config.references.field_weakening = n % 2 == 1 ? LODE_ON : LODE_OFF;
        config.hfi.mode = modes[n / 2];
        lode_drive_config_t given = config;
        lode_drive_design(&config);
        CHECK_CLOSE(1.0e-5, n > 0 ? 10.0 : 3.0,
                    config.estimator.emf.k2_rad_s / config.estimator.pll.sigma_rad_s);
        given.estimator.emf.k2_rad_s = 500.0f;
        lode_drive_design(&given);
        TEST_ASSERT_EQUAL_FLOAT(500.0f, given.estimator.emf.k2_rad_s);
    }
    lode_drive_config_t config = minimal(); // a wave that the machine does not allow
    config.estimator.emf.kind = LODE_EMF_FA_LESO;
    config.motor.Lq_H = config.motor.Ld_H;
    config.hfi.mode = LODE_HFI_AUTO;
    lode_drive_design(&config);
    CHECK_CLOSE(1.0e-5, 3.0, config.estimator.emf.k2_rad_s / config.estimator.pll.sigma_rad_s);
    config = minimal();
    config.estimator.emf.kind = LODE_EMF_FA_LESO;
    config.references.field_weakening = LODE_ON;
    config.estimator.pll.sigma_rad_s = 600.0f;
    lode_drive_design(&config);
    TEST_ASSERT_EQUAL_FLOAT(5000.0f, config.estimator.emf.k2_rad_s); // 1/Ts
}

static void test_field_weakening_has_its_estimators(void) {
    for (int n = 0; n < 8; n++) {
        lode_drive_config_t config = minimal();
        const bool weak = (n & 1) != 0;
        config.references.field_weakening = weak ? LODE_ON : LODE_OFF;
        config.estimator.emf.kind = (n & 2) != 0 ? LODE_EMF_GI_LESO : LODE_EMF_C_LESO;
        config.estimator.pll.kind = (n & 4) != 0 ? LODE_PLL_QPLL : LODE_PLL_LESO;
        TEST_ASSERT_EQUAL_INT(weak && n > 1 ? LODE_ERROR_WEAKENING_ESTIMATOR : LODE_OK,
                              try_config(&config));
    }
    lode_drive_config_t config = minimal(); // the references' own refusal comes first
    config.references.field_weakening = LODE_ON;
    config.references.voltage_use = 2.0f;
    config.estimator.pll.kind = LODE_PLL_QPLL;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_FIELD_WEAKENING, try_config(&config));
}

static void test_rated_speed_follows_from_bus_and_current(void) {
    lode_drive_config_t config = minimal();
    config.motor.omega_rated_rad_s = 0.0f;
    lode_drive_design(&config);
    // Between what half the current with the reactance leaves of the bus, and the EMF alone.
    const double most = 200.0 / sqrt(3.0) / 0.142;
    CHECK_AT_MOST(most, config.motor.omega_rated_rad_s);
    CHECK_AT_LEAST(0.5 * most, config.motor.omega_rated_rad_s);
}

/// The bias of injection is whole up to where the EMF alone tells the angle, and gone at twice that speed.
static void test_the_bias_of_injection_fades_beyond_it(void) {
    lode_drive_config_t config = minimal();
    config.hfi = (lode_hfi_config_t){.mode = LODE_HFI_ON, .V_h_V = 25.0f, .w2_rad_s = 130.0f};
    lode_drive_t drive;
    lode_drive_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&drive, &tuning, &config));
    CHECK_NEAR(1.0e-6, 1.0, lode_fade(&tuning.references.fade, 130.0f));
    CHECK_NEAR(1.0e-6, 0.5, lode_fade(&tuning.references.fade, 195.0f));
    CHECK_NEAR(1.0e-6, 0.0, lode_fade(&tuning.references.fade, 260.0f));
    const float id_A[] = {3.0f, LODE_NONE}; // along the magnet, or none
    for (int n = 0; n < COUNT_OF(id_A); n++) {
        config.hfi.id_A = id_A[n];
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&drive, &tuning, &config));
        CHECK_NEAR(0.0, n == 0 ? -3.0 : 0.0, tuning.references.id_bias_A);
    }
}

/// The wave of injection takes half of the circle at most, of which 0.95 is used by default.
static void test_a_wave_larger_than_half_of_the_circle_is_refused(void) {
    const float half_V = 0.5f * 0.95f * 200.0f / LODE_SQRT3;
    for (int more = 0; more <= 1; more++) {
        lode_drive_config_t config = minimal();
        config.hfi.mode = LODE_HFI_ON;
        config.hfi.V_h_V = (more != 0 ? 1.001f : 0.999f) * half_V;
        lode_drive_t drive;
        lode_drive_tuning_t tuning;
        const lode_status_t status = lode_drive_init(&drive, &tuning, &config);
        TEST_ASSERT_EQUAL_STRING(more != 0 ? "LODE_ERROR_HFI_VOLTAGE" : "LODE_OK",
                                 lode_status_name(status));
    }
}

static float default_bias_A(const lode_drive_config_t *config) {
    lode_drive_config_t designed = *config;
    lode_drive_design(&designed);
    return designed.references.id_bias_A;
}

/// (K31): not in a rotor that is light for its speed, where the bias has a larger drop than the EMF of the hand-over.
static void test_a_bias_above_the_emf_of_a_light_rotor_is_left_out(void) {
    lode_drive_config_t gimbal = minimal();
    gimbal.f_pwm_Hz = 2.0e4f;
    gimbal.motor = (lode_motor_t){.pole_pairs = 11.0f,
                                  .Rs_Ohm = 5.0f,
                                  .Ld_H = 2.2e-3f,
                                  .Lq_H = 2.2e-3f,
                                  .psi_Wb = 8.0e-3f,
                                  .J_kgm2 = 1.5e-5f};
    gimbal.inverter = (lode_inverter_config_t){.v_bus_V = 12.0f, .i_max_A = 1.0f, .r_on_Ohm = 0.1f};
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, default_bias_A(&gimbal));
    lode_drive_config_t given = gimbal;
    given.references.id_bias_A = 0.25f;
    CHECK_NEAR(0.0, 0.25, default_bias_A(&given));
    // At a hand-over that is given: warm, the drop is 1.3 * 5.1 Ohm * 0.25 A = 1.6575 V, the EMF of 207.2 rad/s.
    const float at_rad_s[] = {206.0f, 208.0f};
    for (int n = 0; n < COUNT_OF(at_rad_s); n++) {
        lode_drive_config_t at = gimbal;
        at.start.omega_handover_rad_s = at_rad_s[n];
        at.motor.J_kgm2 = 1.0e-5f;
        CHECK_NEAR(0.0, n == 0 ? (double)LODE_NONE : 0.25, default_bias_A(&at));
    }
    // All the torque, 1.5 * 11 * 8 mWb * 1 A = 0.132 Nm, makes 2 omega^2 of 11 * 0.132 Nm / J: of 111.56 rad/s with
    // 58.3 mg m^2.
    const float J_kgm2[] = {5.8e-5f, 5.9e-5f};
    for (int n = 0; n < COUNT_OF(J_kgm2); n++) {
        lode_drive_config_t heavier = gimbal;
        heavier.start.omega_handover_rad_s = 111.56f;
        heavier.motor.J_kgm2 = J_kgm2[n];
        CHECK_NEAR(0.0, n == 0 ? (double)LODE_NONE : 0.25, default_bias_A(&heavier));
    }
}

/// Each sample from the trip on is looked at, and none that is a count below it.
static void test_the_alert_lies_at_the_trip(void) {
    lode_drive_config_t config = minimal();
    for (int n = 0; n < 2; n++) {
        config.sense.i_gain_A_count = n == 0 ? 0.0125f : -0.0125f;
        config.guard.i_trip_A = 15.0f; // 1200 counts
        lode_drive_t drive;
        lode_drive_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&drive, &tuning, &config));
        CHECK_NEAR((double)LODE_COUNT_FRACTION, 1199.5 * (double)LODE_COUNT_FRACTION,
                   tuning.sense.alert);
    }
}

/// The voltage that is free of a closer look leaves room for the rounding of the correction at the currents of a trip.
static void test_free_voltage_leaves_room_for_rounding(void) {
    float before = FLT_MAX;
    for (int n = 0; n < 3; n++) {
        lode_drive_config_t config = minimal();
        config.inverter.dead_time_s = 2.0e-6f;
        config.inverter.i_dead_A = 0.02f;
        config.guard.i_trip_A = n == 0 ? 12.0f : (n == 1 ? 18.0f : 25.0f);
        lode_drive_t drive;
        lode_drive_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&drive, &tuning, &config));
        TEST_ASSERT_TRUE(tuning.inverter.free < before);
        TEST_ASSERT_TRUE(tuning.current.free <= tuning.inverter.free);
        before = tuning.inverter.free;
    }
}

/// (S54), with and without a wave that noise allows; and (S27).
static void test_what_init_accepts_may_have_warnings(void) {
    lode_drive_config_t config = minimal();
    TEST_ASSERT_EQUAL_UINT32(0u, lode_drive_warnings(&config));
    config.motor.Lq_H = 40.0e-3f;
    config.motor.psi_Wb = 0.1f;
    TEST_ASSERT_EQUAL_UINT32(0u, lode_drive_warnings(&config));
    config.hfi.noise_A = 1.0f;
    TEST_ASSERT_EQUAL_UINT32(LODE_WARNING_INJECTION, lode_drive_warnings(&config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_config(&config));
    config.hfi.noise_A = 0.0f;
    config.hfi.mode = LODE_HFI_OFF; // as chosen
    TEST_ASSERT_EQUAL_UINT32(0u, lode_drive_warnings(&config));
    config = minimal();
    config.motor.Lq_H = config.motor.Ld_H; // cannot have it, but needs none
    TEST_ASSERT_EQUAL_UINT32(0u, lode_drive_warnings(&config));
    config = minimal();
    config.motor.Rs_Ohm = 40.0f;
    TEST_ASSERT_EQUAL_UINT32(LODE_WARNING_EMF, lode_drive_warnings(&config));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_speed_control_knows_its_delays);
    RUN_TEST(test_only_motor_inverter_sense_and_rate_are_needed);
    RUN_TEST(test_a_light_rotor_raises_sigma);
    RUN_TEST(test_a_qpll_has_more_sigma);
    RUN_TEST(test_resonance_by_rotor);
    RUN_TEST(test_FA_LESO_by_field_weakening_and_injection);
    RUN_TEST(test_field_weakening_has_its_estimators);
    RUN_TEST(test_a_late_hand_over_stretches_the_schedule);
    RUN_TEST(test_a_late_hand_over_leaves_room_for_sigma);
    RUN_TEST(test_a_heavy_rotor_has_less_sigma);
    RUN_TEST(test_a_rotor_that_can_be_held_gets_more_sigma);
    RUN_TEST(test_little_dead_time_allows_more_sigma);
    RUN_TEST(test_a_light_rotor_with_mtpa_has_a_tenth_more_sigma);
    RUN_TEST(test_motors_of_many_kinds_need_no_more);
    RUN_TEST(test_every_needed_field_at_its_limits);
    RUN_TEST(test_every_open_field_at_its_limits);
    RUN_TEST(test_no_field_takes_what_is_no_number);
    RUN_TEST(test_negative_values_ask_for_no_default);
    RUN_TEST(test_lode_none_is_for_those_that_may_be_done_without);
    RUN_TEST(test_sense_must_fit_the_inverter);
    RUN_TEST(test_over_speed_lies_above_the_least_speed);
    RUN_TEST(test_double_update_needs_currents_from_the_phases);
    RUN_TEST(test_two_shunts_bound_the_voltage);
    RUN_TEST(test_the_slope_of_the_switches_counts_as_resistance);
    RUN_TEST(test_the_highest_speed_with_a_weakened_field);
    RUN_TEST(test_an_absurd_inertia_is_refused);
    RUN_TEST(test_a_torque_that_fades_with_the_bus_is_gone_before_the_guard_trips);
    RUN_TEST(test_references_know_the_bus_that_the_guard_allows);
    RUN_TEST(test_what_follows_speed_control_has_its_rate);
    RUN_TEST(test_pulses_know_the_period_and_the_sum);
    RUN_TEST(test_what_is_given_is_checked_by_itself);
    RUN_TEST(test_enumerators);
    RUN_TEST(test_pole_pairs);
    RUN_TEST(test_combinations_that_would_not_be_stable);
    RUN_TEST(test_least_speed_is_near_or_above_the_hand_over);
    RUN_TEST(test_what_init_accepts_is_made_of_numbers);
    RUN_TEST(test_null_pointers);
    RUN_TEST(test_design_of_the_papers_drive);
    RUN_TEST(test_the_bias_of_injection_fades_beyond_it);
    RUN_TEST(test_a_wave_larger_than_half_of_the_circle_is_refused);
    RUN_TEST(test_a_bias_above_the_emf_of_a_light_rotor_is_left_out);
    RUN_TEST(test_the_alert_lies_at_the_trip);
    RUN_TEST(test_free_voltage_leaves_room_for_rounding);
    RUN_TEST(test_rated_speed_follows_from_bus_and_current);
    RUN_TEST(test_what_init_accepts_may_have_warnings);
    return UNITY_END();
}
