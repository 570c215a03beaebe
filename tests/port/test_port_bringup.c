// The example application on a simulated board and motor: every bring-up step passes on a sound board,
// and every wiring mistake is found by the step that is there to find it, under its name.
#include "app.h"
#include "board.h"
#include "motor.h"
#include "plant/plant.h"
#include "record.h"
#include "support/check.h"

#ifndef APP_RESTARTS
#define APP_RESTARTS 0u
#endif

#ifndef APP_V_BUS_V
#define APP_V_BUS_V 0.0f
#endif

#ifndef DOUBLE_UPDATE // two calls in a period of the PWM
#define DOUBLE_UPDATE false
#endif

#define F_PWM (DOUBLE_UPDATE ? 40000.0 : 20000.0) // of the calls
#define V_BUS 24.0
#define GAIN_A (1.0 / 128.0) // A per count: +-16 A
#define GAIN_V (40.0 / 4096.0)
#define CYCLES_PER_PERIOD (DOUBLE_UPDATE ? 4250u : 8500u) // of 170 MHz
#define WORK_CYCLES 2000u

/// What is wrong with the board.
typedef struct {
    int channel[3]; ///< which phase's current ADC channel x reads
    double sign[3]; ///< 0: dead
    double offset_count[3];
    double noise_count;
    double random_count; ///< rms, beside it
    bool two_sensors;    ///< of phases a and b
    float ticks;         ///< of the timer; 0: 4250
    int leg[3];          ///< which leg PWM channel x switches
    int late_legs;       ///< bits: their duties act a period late
    bool early;          ///< all duties act a period early
    int stuck_legs;      ///< bits: their duties stay where they are
    double stuck_duty;   ///< there
    bool dead_gates;
    uint32_t cycles_per_period;
    uint32_t jitter; ///< every other period comes late by this
    uint32_t work;
    double v_bus;
    bool trip; ///< the trip input is active
    bool dead_comparator;
    double dead_time_s; ///< of the inverter, and configured
    double unknown_s;   ///< more of it, not configured
    double r_on_Ohm;
    double precharge_s;
    lode_pll_config_t pll; ///< given, not designed
    lode_speed_config_t speed;
} mistakes_t;

static const mistakes_t sound = {.channel = {0, 1, 2},
                                 .sign = {1.0, 1.0, 1.0},
                                 .leg = {0, 1, 2},
                                 .cycles_per_period = CYCLES_PER_PERIOD,
                                 .work = WORK_CYCLES,
                                 .v_bus = V_BUS};

static mistakes_t with;
static plant_t plant;
static bool gates, latched;
static int low_periods; // with the low sides alone
static uint32_t cycles, feeds, stamp, periods;
static uint32_t
    poll_every; // the thread is slower than the interrupt and not in step with it, or faster
static bool working;
static float i_trip_A;   // asked of the hardware
static bool refused;     // a configuration that is none
static bool by_watchdog; // the last reset
static bool started;
static char sent[32768];
static size_t sent_length;

// --- board.h ---

void board_describe(lode_drive_config_t *config) {
    config->f_pwm_Hz = refused ? -1.0f : (float)F_PWM;
    config->inverter =
        (lode_inverter_config_t){.v_bus_V = (float)V_BUS,
                                 .i_max_A = 10.0f,
                                 .dead_time_s = (float)with.dead_time_s,
                                 .r_on_Ohm = (float)with.r_on_Ohm,
                                 .precharge_s = (float)with.precharge_s,
                                 .pwm_ticks = with.ticks > 0.0f ? with.ticks : 4250.0f,
                                 .double_update = DOUBLE_UPDATE ? LODE_ON : LODE_OFF};
    config->sense = (lode_sense_config_t){.i_gain_A_count = (float)GAIN_A,
                                          .i_offset_count = 2048.0f,
                                          .v_bus_gain_V_count = (float)GAIN_V};
    if (with.two_sensors) {
        config->sense.shunts = LODE_SHUNTS_TWO;
        config->sense.duty_max = 1.0f;
    }
    config->guard.stamp_per_period = (float)CYCLES_PER_PERIOD;
    config->estimator.pll = with.pll;
    config->speed = with.speed;
}

bool board_reset_by_watchdog(void) {
    return by_watchdog;
}

bool board_init(float i_trip) {
    i_trip_A = i_trip;
    return true;
}

void board_start(void) {
    started = true;
}

static uint64_t random_state = 1u;

void board_read(lode_counts_t *counts) {
    plant_counts_t raw;
    plant_sample(&plant, &raw, NULL);
    *counts = (lode_counts_t){.v_bus = raw.v_bus, .trip = latched, .stamp = stamp};
    for (int x = 0; x < 3; x++) {
        const double noise = with.noise_count * ((periods & 1u) != 0u ? 0.5 : -0.5);
        random_state = random_state * 6364136223846793005u + 1442695040888963407u;
        const double random = ((double)(random_state >> 33) / 2147483648.0 - 0.5) * sqrt(12.0);
        const double i =
            with.random_count * random + with.sign[x] * ((double)raw.i[with.channel[x]] - 2048.0);
        counts->i[x] = (uint16_t)fmax(0.0, fmin(4095.0, 2048.0 + i + with.offset_count[x] + noise));
    }
    counts->i[2] = with.two_sensors ? 0u : counts->i[2];
}

void board_write(const lode_drive_out_t *out) {
    const float duty[3] = {out->duty.a, out->duty.b, out->duty.c};
    static double before[3];
    double legs[3];
    for (int x = 0; x < 3; x++) {
        const bool late = (with.late_legs >> x & 1) != 0;
        const bool stuck = (with.stuck_legs >> x & 1) != 0;
        legs[with.leg[x]] = stuck ? with.stuck_duty : late ? before[x] : (double)duty[x];
        before[x] = (double)duty[x];
    }
    gates = out->gates != LODE_GATES_OFF && !latched;
    low_periods += out->gates == LODE_GATES_LOW ? 1 : 0;
    plant_write(&plant, legs,
                gates && !with.dead_gates ? (plant_gates_t)out->gates : PLANT_GATES_OFF);
    if (with.early) {
        plant_write_through(&plant);
    }
}

void board_gates_off(void) {
    gates = false;
}

bool board_clear_trip(void) {
    latched = with.trip;
    return !latched;
}

bool board_test_trip(void) {
    return !with.dead_comparator;
}

void board_feed_watchdog(void) {
    feeds++;
}

uint32_t board_cycles(void) {
    const uint32_t now = cycles + (working ? with.work : 0u);
    working = !working;
    return now;
}

uint32_t board_send(const uint16_t *octets, uint32_t count) {
    const uint32_t room = 3u; // takes a few at a time
    uint32_t taken = 0u;
    while (taken < count && taken < room && sent_length + 1u < sizeof sent) {
        sent[sent_length++] = (char)octets[taken++];
    }
    return taken;
}

// --- bench ---

static plant_config_t plant_of_motor(void) {
    const lode_motor_t motor = motor_data();
    return (plant_config_t){.pole_pairs = (int)motor.pole_pairs,
                            .Rs_Ohm = (double)motor.Rs_Ohm,
                            .Ld_H = (double)motor.Ld_H,
                            .Lq_H = (double)motor.Lq_H,
                            .psi_Wb = (double)motor.psi_Wb,
                            .J_kgm2 = (double)motor.J_kgm2,
                            .B_Nms = (double)motor.B_Nms,
                            .load_is_passive = true,
                            .level =
                                DOUBLE_UPDATE ? PLANT_SWITCHING : PLANT_AVERAGED, // with its edges
                            .period_s = 1.0 / F_PWM,
                            .double_update = DOUBLE_UPDATE,
                            .v_bus_V = V_BUS,
                            .adc_bits = 12,
                            .i_A_per_count = GAIN_A,
                            .v_bus_V_per_count = GAIN_V,
                            .temperature_degC_per_count = 1.0,
                            .stamp_Hz = 1.0e6};
}

static void power_up(const mistakes_t *mistakes, plant_config_t config) {
    with = *mistakes;
    config.v_bus_V = with.v_bus;
    if (with.dead_time_s + with.unknown_s > 0.0) {
        config.level = PLANT_SWITCHING;
        config.dead_time_s = with.dead_time_s + with.unknown_s;
        config.r_on_Ohm = with.r_on_Ohm;
    }
    TEST_ASSERT_NULL(plant_init(&plant, &config));
    random_state = 1u; // whatever ran before
    app_mode = APP_MODE_OFF;
    app_speed_rad_s = MOTOR_SPEED_rad_s;
    app_link = LINK_REPORT;
    app_trigger = LODE_TRIGGER_FAULT;
    latched = with.trip;
    working = false;
    started = false;
    gates = false;
    sent_length = 0;
    TEST_ASSERT_TRUE(app_start());
    app_armed = 1u;
}

static void period(void) {
    periods++;
    cycles += with.cycles_per_period + ((periods & 1u) != 0u ? with.jitter : 0u) -
              ((periods & 1u) != 0u ? 0u : with.jitter);
    stamp += CYCLES_PER_PERIOD;
    working = false;
    app_period();
    plant_advance(&plant);
    if (periods % poll_every == 0u) {
        app_poll();
    }
}

static void run_for(double seconds) {
    for (int n = 0; n < (int)(seconds * F_PWM); n++) {
        period();
    }
}

static bringup_result_t bring_up(uint32_t mode, double most_s) {
    app_mode = mode;
    app_armed = 1u;
    for (int n = 0; n < (int)(most_s * F_PWM); n++) {
        period();
        const bringup_result_t result = app_result();
        if (result.mode == mode && result.state != (uint_least8_t)BRINGUP_RUNNING) {
            return result;
        }
    }
    TEST_FAIL_MESSAGE("no end");
    return app_result();
}

static void expect(bringup_result_t result, bringup_reason_t reason, int phase) {
    TEST_ASSERT_EQUAL_STRING(bringup_reason_name((uint_least8_t)reason),
                             bringup_reason_name(result.reason));
    TEST_ASSERT_EQUAL_INT(reason == BRINGUP_OK ? BRINGUP_PASS : BRINGUP_FAIL, result.state);
    if (phase >= 0) {
        TEST_ASSERT_EQUAL_INT(phase, result.phase);
    }
}

void setUp(void) {
    poll_every = 7u;
}

void tearDown(void) {}

// --- tests ---

static void test_sound_board_passes_every_step(void) {
    power_up(&sound, plant_of_motor());
    for (uint32_t mode = BRINGUP_PWM; mode < (uint32_t)BRINGUP_COUNT; mode++) {
        const bringup_result_t result = bring_up(mode, 20.0);
        expect(result, BRINGUP_OK, -1);
        if (mode == (uint32_t)BRINGUP_PWM) {
            CHECK_CLOSE(1e-3, CYCLES_PER_PERIOD, result.measured);
        } else if (mode == (uint32_t)BRINGUP_VOLTAGE) {
            CHECK_CLOSE(0.05, motor_data().Rs_Ohm, result.measured);
        }
        if (mode != (uint32_t)BRINGUP_RUN) {
            run_for(0.01);
            TEST_ASSERT_FALSE(gates); // each step ends with the gates off
        }
    }
    plant_truth_t truth;
    plant_sample(&plant, NULL, &truth);
    CHECK_CLOSE(0.02, MOTOR_SPEED_rad_s, truth.omega_m_rad_s);
    app_mode = APP_MODE_OFF;
    run_for(0.01);
    TEST_ASSERT_FALSE(gates);
}

// Every step that switches charges the bootstrap capacitors first, and passes as without.
static void test_bootstrap_capacitors_are_charged_first(void) {
    mistakes_t m = sound;
    m.precharge_s = 0.01;
    power_up(&m, plant_of_motor());
    for (uint32_t mode = BRINGUP_SIGNS; mode < (uint32_t)BRINGUP_COUNT; mode++) {
        low_periods = 0;
        expect(bring_up(mode, 20.0), BRINGUP_OK, -1);
        // A start begins with pulses of its own; longer ones that find the rotor turning charge as much.
        TEST_ASSERT_TRUE(mode < (uint32_t)BRINGUP_START
                             ? low_periods >= 200 && low_periods % 200 == 0
                             : low_periods >= 80);
    }
}

// A thread that sees every period sees the first one of current control too, with voltage and no current yet.
static void test_steps_pass_before_a_fast_thread(void) {
    poll_every = 1u;
    power_up(&sound, plant_of_motor());
    for (uint32_t mode = BRINGUP_SIGNS; mode < (uint32_t)BRINGUP_COUNT; mode++) {
        expect(bring_up(mode, 20.0), BRINGUP_OK, -1);
    }
}

#ifndef APP_WITHOUT_COMMISSIONING

// The text that the board has sent has this line, with a number after it; what is that?
static double sent_value(const char *key) {
    const char *line = strstr(sent, key);
    TEST_ASSERT_NOT_NULL(line);
    double value = NAN;
    TEST_ASSERT_EQUAL_INT(1, sscanf(line + strlen(key), " = %lf ; confidence", &value));
    return value;
}

// The drive is given 20 % too much resistance and inductance, measures the motor, and runs with what it has found.
static void test_commissioning_measures_and_is_used(void) {
    plant_config_t config = plant_of_motor();
    config.Rs_Ohm *= 0.8;
    config.Ld_H *= 0.8;
    config.Lq_H *= 0.8;
    config.psi_Wb *= 1.05;
    power_up(&sound, config);
    expect(bring_up(APP_MODE_COMMISSION, 20.0), BRINGUP_OK, -1);
    run_for(0.2);
    TEST_ASSERT_FALSE(gates);
    sent[sent_length] = '\0';
    TEST_ASSERT_NOT_NULL(strstr(sent, "9 PASS"));
    TEST_ASSERT_NOT_NULL(strstr(sent, "[motor]\r\npole_pairs = 4.0000e+00 ; given\r\n"));
    CHECK_CLOSE(0.02, config.Rs_Ohm, sent_value("Rs_Ohm"));
    CHECK_CLOSE(0.05, config.Ld_H, sent_value("Ld_H"));
    CHECK_CLOSE(0.05, config.Lq_H, sent_value("Lq_H"));
    CHECK_CLOSE(0.01, config.psi_Wb, sent_value("psi_Wb"));
    CHECK_CLOSE(0.1, config.J_kgm2, sent_value("J_kgm2"));
    app_mode = APP_MODE_APPLICATION;
    run_for(5.0);
    TEST_ASSERT_EQUAL_INT(LODE_MODE_RUN, app_telemetry().mode);
    CHECK_CLOSE(0.01, config.psi_Wb, app_motor().psi_Wb);
}

static void test_commissioning_ends_when_it_is_disarmed(void) {
    power_up(&sound, plant_of_motor());
    app_mode = APP_MODE_COMMISSION;
    run_for(1.0);
    TEST_ASSERT_TRUE(gates);
    app_armed = 0u;
    run_for(0.01);
    TEST_ASSERT_FALSE(gates);
    CHECK_CLOSE(1e-6, motor_data().psi_Wb, app_motor().psi_Wb);
    expect(bring_up(BRINGUP_START, 20.0), BRINGUP_OK, -1); // as if it had not been
}

static void test_commissioning_names_what_is_wrong(void) {
    mistakes_t m = sound;
    m.dead_gates = true;
    power_up(&m, plant_of_motor());
    expect(bring_up(APP_MODE_COMMISSION, 20.0), BRINGUP_UNSURE, -1);
    run_for(0.1);
    TEST_ASSERT_FALSE(gates);
    sent[sent_length] = '\0';
    TEST_ASSERT_NOT_NULL(strstr(sent, "UNSURE signals 6\r\n9 FAIL UNSURE"));
    plant_config_t held = plant_of_motor();
    held.load_Nm = 10.0; // the shaft is clamped
    power_up(&sound, held);
    expect(bring_up(APP_MODE_COMMISSION, 60.0), BRINGUP_NO_START, -1);
}

// Gains that the motor of the header just takes, and a lighter rotor does not.
static void test_commissioning_whose_values_are_refused(void) {
    power_up(&sound, plant_of_motor());
    lode_drive_config_t config = {.f_pwm_Hz = 0.0f};
    board_describe(&config);
    config.motor = motor_data();
    lode_drive_design(&config);
    mistakes_t m = sound;
    m.pll = config.estimator.pll;
    lode_drive_tuning_t tuning;
    while (lode_drive_tune(&tuning, &config) == LODE_OK) {
        m.speed = (lode_speed_config_t){.kp_Nms = config.speed.kp_Nms,
                                        .bandwidth_rad_s = config.speed.bandwidth_rad_s};
        config.speed.kp_Nms *= 1.02f;
    }
    plant_config_t lighter = plant_of_motor();
    lighter.J_kgm2 *= 0.9;
    power_up(&m, lighter);
    expect(bring_up(APP_MODE_COMMISSION, 20.0), BRINGUP_REFUSED, -1);
    run_for(0.1);
    sent[sent_length] = '\0';
    TEST_ASSERT_NOT_NULL(strstr(sent, "REFUSED LODE_ERROR_SPEED_BANDWIDTH "));
    TEST_ASSERT_NOT_NULL(strstr(sent, "9 FAIL REFUSED"));
    TEST_ASSERT_NULL(strstr(sent, "[motor]"));
    expect(bring_up(BRINGUP_START, 20.0), BRINGUP_OK, -1); // as if it had not been
    CHECK_CLOSE(1e-6, motor_data().J_kgm2, app_motor().J_kgm2);
}

// A winding with 20 times the resistance: the voltage reaches its limit first, and the current that flowed is told.
static void test_commissioning_without_enough_voltage(void) {
    mistakes_t m = sound;
    plant_config_t config = plant_of_motor();
    config.Rs_Ohm *= 20.0;
    power_up(&m, config);
    const bringup_result_t result = bring_up(APP_MODE_COMMISSION, 20.0);
    expect(result, BRINGUP_NO_CURRENT, -1);
    TEST_ASSERT_TRUE(result.measured > 0.02f * result.limit);
    TEST_ASSERT_TRUE(result.measured < result.limit);
}

#else

// In its place: the mode says so, the watchdog is fed, and the other modes are as ever.
static void test_commissioning_that_is_left_out(void) {
    power_up(&sound, plant_of_motor());
    expect(bring_up(APP_MODE_COMMISSION, 1.0), BRINGUP_REFUSED, -1);
    const uint32_t fed = feeds;
    run_for(0.1);
    TEST_ASSERT_TRUE(feeds - fed > 200u);
    TEST_ASSERT_FALSE(gates);
    for (uint32_t mode = BRINGUP_SIGNS; mode <= (uint32_t)BRINGUP_CURRENT; mode++) {
        expect(bring_up(mode, 20.0), BRINGUP_OK, -1);
    }
}

#endif

static bringup_result_t signs_of(const mistakes_t *m, double L_share) {
    plant_config_t config = plant_of_motor();
    config.Ld_H *= L_share;
    config.Lq_H *= L_share;
    power_up(m, config);
    return bring_up(BRINGUP_SIGNS, 10.0);
}

static void expect_late(const mistakes_t *m, double L_share, double wanted) {
    const bringup_result_t result = signs_of(m, L_share);
    expect(result, BRINGUP_LATENCY, -1);
    CHECK_NEAR(0.4, wanted, result.measured);
}

// With an inductance that is off by a half, noise, two sensors and a dead time that is known or not.
static void test_duties_that_act_early_or_late(void) {
    static const double shares[] = {0.5, 0.75, 1.0};
    for (int n = 0; n < 4 * COUNT_OF(shares); n++) {
        mistakes_t m = sound;
        m.two_sensors = n % 2 == 1;
        m.random_count = n % 4 < 2 ? 0.0 : 1.0;
        m.late_legs = 7;
        expect_late(&m, shares[n / 4], 1.0);
        m.late_legs = 0;
        m.early = true;
        expect_late(&m, shares[n / 4], -1.0);
    }
    mistakes_t m = sound;
    m.dead_time_s = 550.0e-9;
    m.late_legs = 7;
    expect_late(&m, 1.0, 1.0);
    m = sound;
    m.unknown_s = 500.0e-9;
    m.late_legs = 7;
    expect_late(&m, 1.0, 1.0);
}

static void test_one_leg_of_three_that_acts_late(void) {
    for (int x = 0; x < 3; x++) {
        mistakes_t m = sound;
        m.late_legs = 1 << x;
        expect_late(&m, 1.0, 0.5);
    }
}

// Noise takes the judgement away, and makes none.
static void test_duties_in_time_are_never_late(void) {
    static const double shares[] = {0.5, 1.0, 1.5};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        for (int noise = 0; noise < 5; noise++) {
            mistakes_t m = sound;
            m.random_count = noise;
            m.two_sensors = noise % 2 == 1;
            expect(signs_of(&m, shares[n]), BRINGUP_OK, -1);
        }
    }
    mistakes_t m = sound;
    m.dead_time_s = 550.0e-9;
    expect(signs_of(&m, 1.0), BRINGUP_OK, -1);
    m = sound;
    m.unknown_s = 500.0e-9;
    expect(signs_of(&m, 1.0), BRINGUP_OK, -1);
}

// Nor is what a coarse timer makes of a step.
static void test_steps_of_few_ticks_are_not_judged(void) {
    mistakes_t m = sound;
    m.late_legs = 7;
    m.ticks = 400.0f;
    expect_late(&m, 1.0, 1.0);
    m.ticks = 150.0f;
    expect(signs_of(&m, 1.0), BRINGUP_OK, -1);
}

// Registers that do not take a value: the steps that follow never get a board on which one leg is stuck.
static void test_legs_that_do_not_follow(void) {
    static const double duties[] = {0.0, 0.4, 0.45, 0.49, 0.5, 0.51, 0.55, 0.6, 1.0};
    for (int n = 0; n < COUNT_OF(duties); n++) {
        for (int legs = 1; legs < 8; legs++) {
            mistakes_t m = sound;
            m.stuck_legs = legs;
            m.stuck_duty = duties[n];
            const bringup_result_t result = signs_of(&m, 1.0);
            TEST_ASSERT_EQUAL_INT(BRINGUP_FAIL, result.state);
            if (legs == 7) {
                expect(result, BRINGUP_NO_CURRENT, -1);
            }
        }
    }
}

static void test_angle_and_turning_vector(void) {
    power_up(&sound, plant_of_motor());
    app_angle_rad = 1.0f;
    app_turn_rad_s = 6.0f;
    expect(bring_up(BRINGUP_CURRENT, 3.0), BRINGUP_OK, -1);
    app_angle_rad = 0.0f;
    app_turn_rad_s = 0.0f;
}

static void test_clock_and_pwm(void) {
    mistakes_t m = sound;
    m.cycles_per_period = CYCLES_PER_PERIOD / 2u; // a factor of two in the timer
    power_up(&m, plant_of_motor());
    expect(bring_up(BRINGUP_PWM, 2.0), BRINGUP_PERIOD, -1);
    m = sound;
    m.jitter = 500u;
    power_up(&m, plant_of_motor());
    expect(bring_up(BRINGUP_PWM, 2.0), BRINGUP_JITTER, -1);
    m = sound;
    m.work = 7000u;
    power_up(&m, plant_of_motor());
    expect(bring_up(BRINGUP_PWM, 2.0), BRINGUP_TOO_SLOW, -1);
    m = sound;
    m.trip = true;
    power_up(&m, plant_of_motor());
    expect(bring_up(BRINGUP_PWM, 2.0), BRINGUP_TRIP, -1);
}

static void test_offsets(void) {
    mistakes_t m = sound;
    m.offset_count[1] = -150.0;
    power_up(&m, plant_of_motor());
    bringup_result_t result = bring_up(BRINGUP_OFFSETS, 2.0);
    expect(result, BRINGUP_OK, 1);
    CHECK_NEAR(2.0, -150.0, result.measured);
    m.offset_count[1] = -250.0;
    power_up(&m, plant_of_motor());
    result = bring_up(BRINGUP_OFFSETS, 2.0);
    expect(result, BRINGUP_FAULT, -1); // the drive's own calibration refuses it first
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_OFFSET, result.check);
    m = sound;
    m.noise_count = 120.0;
    power_up(&m, plant_of_motor());
    expect(bring_up(BRINGUP_OFFSETS, 2.0), BRINGUP_NOISE, 0);
    m = sound;
    m.v_bus = 8.0;
    power_up(&m, plant_of_motor());
    expect(bring_up(BRINGUP_OFFSETS, 2.0), BRINGUP_BUS, -1);
}

static void signs(const mistakes_t *m, bringup_reason_t reason, int phase) {
    power_up(m, plant_of_motor());
    expect(bring_up(BRINGUP_SIGNS, 10.0), reason, phase);
}

static void test_signs(void) {
    for (int x = 0; x < 3; x++) {
        mistakes_t m = sound;
        m.sign[x] = -1.0;
        signs(&m, BRINGUP_SIGN, x);
        m.sign[x] = 0.0;
        signs(&m, x == 0 ? BRINGUP_NO_SIGNAL : BRINGUP_RATIO, x);
    }
    mistakes_t m = sound;
    m.sign[0] = m.sign[1] = m.sign[2] = -1.0;
    signs(&m, BRINGUP_SIGN, 0);
    m = sound;
    m.channel[1] = 2; // ADC channels of b and c exchanged
    m.channel[2] = 1;
    signs(&m, BRINGUP_ORDER, 1);
    m = sound;
    m.leg[0] = 1; // gate signals of a and b exchanged
    m.leg[1] = 0;
    signs(&m, BRINGUP_ORDER, 0);
    m = sound;
    m.dead_gates = true;
    signs(&m, BRINGUP_NO_CURRENT, -1);
}

static void test_motor_wires_in_any_order_pass(void) {
    mistakes_t m = sound; // exchanged behind the sensors: it turns the other way, and that is all
    m.channel[1] = m.leg[1] = 2;
    m.channel[2] = m.leg[2] = 1;
    signs(&m, BRINGUP_OK, -1);
}

static void test_resistance_is_named(void) {
    plant_config_t config = plant_of_motor();
    config.Rs_Ohm *= 2.5;
    power_up(&sound, config);
    expect(bring_up(BRINGUP_VOLTAGE, 5.0), BRINGUP_RESISTANCE, -1);
    power_up(&sound, config);
    const bringup_result_t result = bring_up(BRINGUP_CURRENT, 5.0);
    expect(result, BRINGUP_RESISTANCE, -1);
    CHECK_CLOSE(0.1, config.Rs_Ohm, result.measured);
}

// Dead amplifiers: what is not seen must stay bounded by what the voltage can drive.
static double largest_current(const mistakes_t *m, uint32_t mode, bringup_reason_t reason,
                              bringup_reason_t or_reason) {
    power_up(m, plant_of_motor());
    app_mode = mode;
    double largest = 0.0;
    for (int n = 0; n < (int)(5.0 * F_PWM); n++) {
        period();
        plant_truth_t truth;
        plant_sample(&plant, NULL, &truth);
        largest = fmax(largest, hypot(truth.id_A, truth.iq_A));
        const bringup_result_t result = app_result();
        if (result.mode == mode && result.state != (uint_least8_t)BRINGUP_RUNNING) {
            expect(result, result.reason == (uint_least8_t)or_reason ? or_reason : reason, -1);
            return largest;
        }
    }
    TEST_FAIL_MESSAGE("no end");
    return largest;
}

static void test_currents_that_are_not_seen_stay_bounded(void) {
    poll_every = 2u;
    mistakes_t m = sound;
    for (int x = 0; x < 3; x++) {
        m.sign[x] = 0.0;
        CHECK_AT_MOST(0.5 * (double)MOTOR_I_MAX_A,
                      largest_current(&m, BRINGUP_VOLTAGE, BRINGUP_BALANCE, BRINGUP_BALANCE));
        CHECK_AT_MOST(0.5 * (double)MOTOR_I_MAX_A,
                      largest_current(&m, BRINGUP_CURRENT, BRINGUP_BALANCE, BRINGUP_CURRENT_OFF));
        m.sign[x] = 1.0;
    }
    m.sign[0] = m.sign[1] = m.sign[2] = 0.0; // nothing shows anything
    CHECK_AT_MOST(0.5 * (double)MOTOR_I_MAX_A,
                  largest_current(&m, BRINGUP_SIGNS, BRINGUP_NO_CURRENT, BRINGUP_NO_CURRENT));
    CHECK_AT_MOST(0.5 * (double)MOTOR_I_MAX_A,
                  largest_current(&m, BRINGUP_VOLTAGE, BRINGUP_NO_CURRENT, BRINGUP_NO_CURRENT));
    CHECK_AT_MOST((double)MOTOR_I_MAX_A,
                  largest_current(&m, BRINGUP_CURRENT, BRINGUP_CURRENT_OFF, BRINGUP_CURRENT_OFF));
}

// Switches of more resistance than the winding, and a dead time that takes more voltage than either.
static void test_resistance_behind_switches_and_dead_time(void) {
    mistakes_t m = sound;
    m.dead_time_s = 550.0e-9;
    m.r_on_Ohm = 0.7;
    power_up(&m, plant_of_motor());
    const bringup_result_t result = bring_up(BRINGUP_VOLTAGE, 5.0);
    expect(result, BRINGUP_OK, -1);
    CHECK_CLOSE(0.1, (double)motor_data().Rs_Ohm + m.r_on_Ohm, result.measured);
    expect(bring_up(BRINGUP_CURRENT, 5.0), BRINGUP_OK, -1);
}

// A dead time that nobody has configured takes as much voltage at either current: the two points do not see it.
static void test_resistance_behind_an_unknown_dead_time(void) {
    mistakes_t m = sound;
    m.unknown_s = 500.0e-9;
    power_up(&m, plant_of_motor());
    const bringup_result_t result = bring_up(BRINGUP_VOLTAGE, 5.0);
    expect(result, BRINGUP_OK, -1);
    CHECK_CLOSE(0.1, (double)motor_data().Rs_Ohm, result.measured);
}

static void test_current_that_never_comes(void) {
    mistakes_t m = sound;
    m.dead_gates = true;
    power_up(&m, plant_of_motor());
    expect(bring_up(BRINGUP_CURRENT, 5.0), BRINGUP_CURRENT_OFF, -1);
}

static void test_start_that_cannot_succeed_is_a_fault_with_its_check(void) {
    plant_config_t config = plant_of_motor();
    config.load_Nm = 2.0; // far beyond the start torque
    power_up(&sound, config);
    const bringup_result_t result = bring_up(BRINGUP_START, 60.0);
    expect(result, BRINGUP_FAULT, -1);
    TEST_ASSERT_EQUAL_INT(LODE_CHECK_START, result.check);
}

static void test_report_is_one_line(void) {
    power_up(&sound, plant_of_motor());
    (void)bring_up(BRINGUP_PWM, 2.0);
    run_for(0.1);
    sent[sent_length] = '\0';
    // A line of the test before this one may still stand in front of it.
    TEST_ASSERT_NOT_NULL(
        strstr(sent, DOUBLE_UPDATE ? "1 PASS OK phase 0 measured 4250.000 limit 4250.000\r\n"
                                   : "1 PASS OK phase 0 measured 8500.000 limit 8500.000\r\n"));
}

static bool was_sent(const char *text) {
    sent[sent_length] = '\0';
    return strstr(sent, text) != NULL;
}

static void test_nothing_switches_before_it_is_armed(void) {
    for (uint32_t mode = BRINGUP_SIGNS; mode <= APP_MODE_APPLICATION; mode++) {
        power_up(&sound, plant_of_motor());
        TEST_ASSERT_TRUE(app_armed != 0u);
        TEST_ASSERT_TRUE(app_start()); // a reset takes it back
        app_mode = mode;
        for (int n = 0; n < (int)(2.0 * F_PWM); n++) {
            period();
            TEST_ASSERT_FALSE(gates);
        }
        char line[] = "WAIT ARM 0\r\n";
        line[9] = (char)('0' + (int)mode);
        TEST_ASSERT_TRUE(was_sent(line));
        app_armed = 1u;
        for (int n = 0; n < (int)(2.0 * F_PWM) && !gates; n++) {
            period();
        }
        TEST_ASSERT_TRUE(gates);
        app_armed = 0u; // and this switches off
        run_for(0.01);
        TEST_ASSERT_FALSE(gates);
    }
}

static void test_nothing_switches_behind_a_dead_trip_path(void) {
    mistakes_t m = sound;
    m.dead_comparator = true;
    for (uint32_t mode = BRINGUP_SIGNS; mode <= APP_MODE_APPLICATION; mode++) {
        power_up(&m, plant_of_motor());
        app_mode = mode;
        for (int n = 0; n < (int)F_PWM; n++) {
            period();
            TEST_ASSERT_FALSE(gates);
        }
        TEST_ASSERT_EQUAL_UINT32(0u, app_armed);
        char line[] = "FAIL TRIP_PATH 0\r\n";
        line[15] = (char)('0' + (int)mode);
        TEST_ASSERT_TRUE(was_sent(line));
    }
}

// By the hardware above the drive's own over-current trip, which is 1.5 times the lower limit of both.
static void test_hardware_trip_follows_the_motor(void) {
    power_up(&sound, plant_of_motor());
    CHECK_CLOSE(1e-6, 1.2f * 1.5f * MOTOR_I_MAX_A, i_trip_A);
}

static void test_mode_off_takes_the_arming_back(void) {
    power_up(&sound, plant_of_motor());
    app_mode = APP_MODE_OFF;
    run_for(0.01);
    app_mode = APP_MODE_APPLICATION;
    run_for(1.0);
    TEST_ASSERT_FALSE(gates);
}

static void test_watchdog_resets_are_counted_and_start_nothing(void) {
    power_up(&sound, plant_of_motor());
    by_watchdog = true;
    for (int n = 1; n <= 3; n++) {
        TEST_ASSERT_TRUE(app_start());
        app_mode = APP_MODE_APPLICATION;
        run_for(1.0);
        TEST_ASSERT_FALSE(gates);
    }
    TEST_ASSERT_TRUE(was_sent("START WATCHDOG_RESETS 3\r\n"));
    by_watchdog = false; // somebody has pressed the reset button
    TEST_ASSERT_TRUE(app_start());
    by_watchdog = true;
    sent_length = 0;
    TEST_ASSERT_TRUE(app_start());
    by_watchdog = false;
    run_for(0.1);
    TEST_ASSERT_TRUE(was_sent("START WATCHDOG_RESETS 1\r\n"));
}

static void test_refused_configuration_is_reported(void) {
    power_up(&sound, plant_of_motor());
    refused = true;
    started = false;
    TEST_ASSERT_FALSE(app_start());
    refused = false;
    TEST_ASSERT_FALSE(started);
    const uint32_t fed = feeds;
    for (int n = 0; n < 100; n++) {
        app_poll();
    }
    TEST_ASSERT_TRUE(was_sent("START FAIL LODE_ERROR_F_PWM 0\r\n"));
    TEST_ASSERT_EQUAL_UINT32(fed, feeds);
}

static void test_watchdog_is_fed_only_while_periods_come(void) {
    power_up(&sound, plant_of_motor());
    run_for(0.1);
    const uint32_t fed = feeds;
    TEST_ASSERT_TRUE(fed > 0u);
    app_poll(); // may still see the last period
    const uint32_t last = feeds;
    for (int n = 0; n < 1000; n++) {
        app_poll();
    }
    TEST_ASSERT_EQUAL_UINT32(last, feeds);
}

static void test_application_runs_and_restarts_after_a_trip(void) {
    power_up(&sound, plant_of_motor());
    app_mode = APP_MODE_APPLICATION;
    run_for(6.0);
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_RUN", lode_mode_name(app_telemetry().mode));
    latched = true; // one spike
    period();
    TEST_ASSERT_FALSE(gates);
    run_for(0.5);
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_FAULT", lode_mode_name(app_telemetry().mode));
    run_for(8.0);
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_RUN", lode_mode_name(app_telemetry().mode));
    with.trip = true; // and one that stays: it never starts again
    latched = true;
    run_for(8.0);
    TEST_ASSERT_FALSE(gates);
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_FAULT", lode_mode_name(app_telemetry().mode));
}

static void test_application_gives_up_after_some_restarts(void) {
    power_up(&sound, plant_of_motor());
    app_mode = APP_MODE_APPLICATION;
    int starts = 0;
    bool before = false;
    for (int n = 0; n < (int)(12.0 * F_PWM); n++) {
        period();
        starts += gates && !before ? 1 : 0;
        before = gates;
        latched = latched || gates; // trips as soon as the gates are on
    }
    TEST_ASSERT_EQUAL_INT(1 + 3, starts);
}

// A reset by the watchdog is an attempt as well: the motor that was armed starts again, three times. What is not the
// watchdog's, or was not armed, waits for somebody.
static void test_application_goes_on_after_resets_by_the_watchdog(void) {
    power_up(&sound, plant_of_motor());
    app_mode = APP_MODE_APPLICATION;
    run_for(1.0);
    TEST_ASSERT_TRUE(gates);
    by_watchdog = true;
    for (int n = 1; n <= 4; n++) {
        TEST_ASSERT_TRUE(app_start());
        TEST_ASSERT_EQUAL_UINT32(n <= (int)APP_RESTARTS ? 1u : 0u, app_armed);
        run_for(1.0);
        TEST_ASSERT_EQUAL_INT(n <= (int)APP_RESTARTS, gates);
    }
    // They count with the faults, which are not restarted any more either, until somebody arms.
    app_armed = 1u;
    run_for(1.0);
    TEST_ASSERT_TRUE(gates);
    TEST_ASSERT_TRUE(app_start());
    by_watchdog = false;
    int starts = 0;
    bool before = false;
    for (int n = 0; n < (int)(12.0 * F_PWM); n++) {
        period();
        starts += gates && !before ? 1 : 0;
        before = gates;
        latched = latched || gates;
    }
    TEST_ASSERT_EQUAL_INT(APP_RESTARTS > 0u ? (int)APP_RESTARTS : 0, starts);
}

static void test_only_an_armed_application_goes_on(void) {
    power_up(&sound, plant_of_motor());
    app_mode = APP_MODE_APPLICATION;
    run_for(1.0);
    TEST_ASSERT_TRUE(app_start()); // the reset button
    run_for(1.0);
    TEST_ASSERT_FALSE(gates);
    by_watchdog = true;
    TEST_ASSERT_TRUE(app_start()); // was not armed any more
    run_for(1.0);
    TEST_ASSERT_FALSE(gates);
    app_armed = 1u;
    run_for(1.0);
    TEST_ASSERT_TRUE(gates);
    app_mode = BRINGUP_CURRENT;
    TEST_ASSERT_TRUE(app_start()); // another mode comes up
    run_for(1.0);
    TEST_ASSERT_FALSE(gates);
    by_watchdog = false;
}

static uint32_t word_at(size_t at) {
    uint32_t word = 0u;
    for (size_t n = 0; n < 4u; n++) {
        word |= (uint32_t)(unsigned char)sent[at + n] << (8u * n);
    }
    return word;
}

static void test_ring_goes_over_the_line_without_a_gap(void) {
    power_up(&sound, plant_of_motor());
    app_link = LINK_RING;
    app_mode = APP_MODE_APPLICATION;
    run_for(1.0);
    size_t at = 0;
    uint32_t frames = 0u;
    while (at + 64u < sent_length) {
        const uint32_t head = word_at(at);
        TEST_ASSERT_EQUAL_HEX32(LODE_RING_SYNC, head & 0xFFu);
        if ((head & 0x8000u) == 0u) { // data
            TEST_ASSERT_EQUAL_UINT32(frames, head >> 16);
            frames++;
        }
        at += 4u * (2u + (head >> 8 & 31u));
    }
    TEST_ASSERT_INT_WITHIN(5, 200, frames); // a second of them
}

static void test_scope_sends_the_fault_once(void) {
    power_up(&sound, plant_of_motor());
    app_link = LINK_SCOPE;
    app_mode = APP_MODE_APPLICATION;
    run_for(3.0);
    TEST_ASSERT_EQUAL_UINT32(0u, sent_length); // no fault, nothing to say
    latched = true;
    run_for(2.0);
    const size_t octets = 4u * (LODE_SCOPE_WORDS(8, 250) + 1u);
    TEST_ASSERT_EQUAL_UINT32(octets, sent_length);
    TEST_ASSERT_EQUAL_HEX32(LODE_SCOPE_MAGIC, word_at(0));
    // The first channel of the event's row is the check.
    const uint32_t row = word_at(4u * (uint32_t)LODE_SCOPE_AT_EVENT);
    TEST_ASSERT_EQUAL_HEX32(lode_channel_bits((float)LODE_CHECK_HARDWARE_TRIP),
                            word_at(4u * (LODE_SCOPE_WORDS(8, 0) + 8u * row)));
    TEST_ASSERT_EQUAL_HEX32(0u,
                            word_at(4u * (LODE_SCOPE_WORDS(8, 0) + 8u * ((row + 249u) % 250u))));
}

static void test_scope_of_what_happens_now(void) {
    power_up(&sound, plant_of_motor());
    app_trigger = LODE_TRIGGER_IMMEDIATE;
    app_link = LINK_SCOPE;
    app_mode = BRINGUP_CURRENT;
    run_for(2.0);
    TEST_ASSERT_EQUAL_UINT32(4u * (LODE_SCOPE_WORDS(8, 250) + 1u), sent_length);
}

static void test_stopped_interrupt_switches_the_gates_off(void) {
    power_up(&sound, plant_of_motor());
    app_mode = APP_MODE_APPLICATION;
    run_for(1.0);
    TEST_ASSERT_TRUE(gates);
    app_poll(); // may still see the last period
    cycles += 7u * CYCLES_PER_PERIOD;
    app_poll();
    TEST_ASSERT_TRUE(gates); // a thread that looks often sees few periods missing
    cycles += 2u * CYCLES_PER_PERIOD;
    app_poll();
    TEST_ASSERT_FALSE(gates);
}

static void test_cycles_are_recorded(void) {
    power_up(&sound, plant_of_motor());
    run_for(0.1);
    const bringup_cycles_t c = app_cycles();
    TEST_ASSERT_EQUAL_UINT32(WORK_CYCLES, c.work_max);
    TEST_ASSERT_EQUAL_UINT32(WORK_CYCLES, c.work_min);
    TEST_ASSERT_EQUAL_UINT32(CYCLES_PER_PERIOD, c.interval_min);
    TEST_ASSERT_EQUAL_UINT32(CYCLES_PER_PERIOD, c.interval_max);
}

// The board is made for V_BUS; the supply gives less, on purpose.
static void test_bring_up_at_a_lower_bus_voltage(void) {
    mistakes_t m = sound;
    m.v_bus = (double)APP_V_BUS_V;
    power_up(&m, plant_of_motor());
    for (uint32_t mode = BRINGUP_PWM; mode <= (uint32_t)BRINGUP_CURRENT; mode++) {
        expect(bring_up(mode, 20.0), BRINGUP_OK, -1);
    }
    TEST_ASSERT_TRUE(was_sent("START LOW_BUS 10\r\n"));
#ifdef MOTOR_LQ_FALL_1_A // what commissioning has measured, in the motor's header
    const lode_drive_tuning_t *tuning = app_drive()->tuning;
    CHECK_CLOSE(1e-6, (double)MOTOR_LQ_FALL_1_A, (double)tuning->references.Lq_fall);
    CHECK_CLOSE(1e-5, (double)MOTOR_DEAD_TIME_s * F_PWM, (double)tuning->inverter.dead_duty);
#endif
}

int main(void) {
    UNITY_BEGIN();
    if (APP_V_BUS_V > 0.0f) {
        RUN_TEST(test_bring_up_at_a_lower_bus_voltage);
        return UNITY_END();
    }
    RUN_TEST(test_sound_board_passes_every_step);
    RUN_TEST(test_bootstrap_capacitors_are_charged_first);
    RUN_TEST(test_steps_pass_before_a_fast_thread);
#ifdef APP_WITHOUT_COMMISSIONING
    RUN_TEST(test_commissioning_that_is_left_out);
#else
    RUN_TEST(test_commissioning_measures_and_is_used);
    RUN_TEST(test_commissioning_ends_when_it_is_disarmed);
    RUN_TEST(test_commissioning_names_what_is_wrong);
    RUN_TEST(test_commissioning_whose_values_are_refused);
    RUN_TEST(test_commissioning_without_enough_voltage);
#endif
    RUN_TEST(test_duties_that_act_early_or_late);
    RUN_TEST(test_one_leg_of_three_that_acts_late);
    RUN_TEST(test_duties_in_time_are_never_late);
    RUN_TEST(test_steps_of_few_ticks_are_not_judged);
    RUN_TEST(test_legs_that_do_not_follow);
    RUN_TEST(test_angle_and_turning_vector);
    RUN_TEST(test_clock_and_pwm);
    RUN_TEST(test_offsets);
    RUN_TEST(test_signs);
    RUN_TEST(test_motor_wires_in_any_order_pass);
    RUN_TEST(test_resistance_is_named);
    RUN_TEST(test_currents_that_are_not_seen_stay_bounded);
    RUN_TEST(test_resistance_behind_switches_and_dead_time);
    RUN_TEST(test_resistance_behind_an_unknown_dead_time);
    RUN_TEST(test_current_that_never_comes);
    RUN_TEST(test_start_that_cannot_succeed_is_a_fault_with_its_check);
    RUN_TEST(test_report_is_one_line);
    RUN_TEST(test_nothing_switches_before_it_is_armed);
    RUN_TEST(test_nothing_switches_behind_a_dead_trip_path);
    RUN_TEST(test_hardware_trip_follows_the_motor);
    RUN_TEST(test_mode_off_takes_the_arming_back);
    RUN_TEST(test_watchdog_resets_are_counted_and_start_nothing);
    RUN_TEST(test_refused_configuration_is_reported);
    RUN_TEST(test_watchdog_is_fed_only_while_periods_come);
    RUN_TEST(test_application_runs_and_restarts_after_a_trip);
    RUN_TEST(test_application_gives_up_after_some_restarts);
    RUN_TEST(test_application_goes_on_after_resets_by_the_watchdog);
    RUN_TEST(test_only_an_armed_application_goes_on);
    RUN_TEST(test_ring_goes_over_the_line_without_a_gap);
    RUN_TEST(test_scope_sends_the_fault_once);
    RUN_TEST(test_scope_of_what_happens_now);
    RUN_TEST(test_stopped_interrupt_switches_the_gates_off);
    RUN_TEST(test_cycles_are_recorded);
    return UNITY_END();
}
