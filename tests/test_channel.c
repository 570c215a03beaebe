// Channels: each one is its field of the telemetry; what a row holds and when one is due.
#include "support/rig.h"

#include "lodestar/channel.h"

void setUp(void) {}

void tearDown(void) {}

// The fields in the order of the channels' numbers, NAN where the telemetry has none: the estimator's inputs.
static void fields_of(const lode_telemetry_t *t, float value[LODE_CHANNEL_COUNT]) {
    const float fields[] = {(float)t->mode,
                            (float)t->fault.check,
                            t->duty.a,
                            t->duty.b,
                            t->duty.c,
                            t->i_A.d,
                            t->i_A.q,
                            t->ref_A.d,
                            t->ref_A.q,
                            t->u_V.d,
                            t->u_V.q,
                            t->v_bus_V,
                            t->temperature_degC,
                            t->theta_rad,
                            t->omega_rad_s,
                            t->speed_ref_rad_s,
                            t->load_torque_Nm,
                            t->lock,
                            t->e_V.alpha,
                            t->e_V.beta,
                            t->fault.measured,
                            t->fault.limit,
                            NAN,
                            NAN,
                            NAN,
                            NAN,
                            (float)t->start_stage,
                            (float)t->retries,
                            (float)t->fault.criterion,
                            (float)t->signals_checked,
                            (t->torque_limited ? 1.0f : 0.0f) + (t->speed_raised ? 2.0f : 0.0f) +
                                (t->speed_held ? 4.0f : 0.0f) + (t->gains_halved ? 8.0f : 0.0f)};
    TEST_ASSERT_EQUAL_INT(LODE_CHANNEL_COUNT, COUNT_OF(fields));
    memcpy(value, fields, sizeof fields);
}

static void check_channels(const rig_t *rig) {
    const lode_telemetry_t t = rig_telemetry(rig);
    float wanted[LODE_CHANNEL_COUNT];
    fields_of(&t, wanted);
    for (uint32_t n = 0; n < (uint32_t)LODE_CHANNEL_COUNT; n++) {
        const float value = lode_channel_read(&rig->drive, (lode_channel_t)n);
        if (!isnan(wanted[n])) {
            TEST_ASSERT_EQUAL_HEX32(lode_channel_bits(wanted[n]), lode_channel_bits(value));
        }
    }
}

// All but the temperature, which this board has no sensor for, differ from 0 somewhere.
static void note_used(const rig_t *rig, bool used[LODE_CHANNEL_COUNT]) {
    for (uint32_t n = 0; n < (uint32_t)LODE_CHANNEL_COUNT; n++) {
        const float value = lode_channel_read(&rig->drive, (lode_channel_t)n);
        used[n] = used[n] || value > 0.0f || value < 0.0f;
    }
}

static void test_channels_are_the_fields_of_the_telemetry(void) {
    rig_t rig;
    lode_drive_tuning_t tuning;
    lode_drive_config_t config = rig_config();
    config.sense.temperature_offset_degC = 25.0f;
    rig_init(&rig, &tuning, &config);
    rig.load_Nm = 1.0;
    rig.blocked = true; // for the first attempt
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 60.0f});
    bool used[LODE_CHANNEL_COUNT] = {false};
    for (int n = 0; n < 40000; n++) {
        rig.blocked = rig.blocked && rig_telemetry(&rig).retries == 0u;
        rig_step(&rig);
        check_channels(&rig);
        note_used(&rig, used);
    }
    rig_expect(&rig, LODE_MODE_RUN);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 0.5f}); // is raised
    rig_run(&rig, 0.5);
    check_channels(&rig);
    note_used(&rig, used);
    rig.trip = true;
    rig_step(&rig);
    rig_expect(&rig, LODE_MODE_FAULT);
    check_channels(&rig);
    note_used(&rig, used);
    TEST_ASSERT_EQUAL_FLOAT((float)LODE_CHECK_HARDWARE_TRIP,
                            lode_channel_read(&rig.drive, LODE_CHANNEL_CHECK));
    for (uint32_t n = 0; n < (uint32_t)LODE_CHANNEL_COUNT; n++) {
        TEST_ASSERT_TRUE_MESSAGE(used[n], "a channel that stays 0");
    }
}

static void check_bits(float wanted, const lode_drive_t *drive, lode_channel_t channel) {
    TEST_ASSERT_EQUAL_HEX32(lode_channel_bits(wanted),
                            lode_channel_bits(lode_channel_read(drive, channel)));
}

// To the bit, so that a replay of the record makes the same estimate: the current of this period's sample,
// and the voltage that the next period takes to have acted. The bus moves.
static void check_inputs_of_the_estimator(rig_t *rig) {
    const bool gates = rig->drive.gates;
    lode_counts_t counts = rig_counts(rig);
    lode_drive_t seen = rig->drive;
    const lode_ab_t i_A = lode_drive_sense(&seen, &counts).i_A;
    rig_step(rig);
    check_bits(gates ? i_A.alpha : 0.0f, &rig->drive, LODE_CHANNEL_I_ALPHA);
    check_bits(gates ? i_A.beta : 0.0f, &rig->drive, LODE_CHANNEL_I_BETA);
    counts = rig_counts(rig);
    counts.v_bus = 1000u; // of t_k+1: not the one that this voltage is made from
    seen = rig->drive;
    const lode_ab_t u_V = lode_drive_sense(&seen, &counts).u_V;
    check_bits(u_V.alpha, &rig->drive, LODE_CHANNEL_U_ALPHA);
    check_bits(u_V.beta, &rig->drive, LODE_CHANNEL_U_BETA);
}

static void test_stator_axes_are_what_the_estimator_sees(void) {
    rig_t rig;
    lode_drive_tuning_t tuning;
    const lode_drive_config_t config = rig_config();
    rig_init(&rig, &tuning, &config);
    rig.load_Nm = 1.0;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 60.0f});
    for (int n = 0; n < 15000; n++) {
        check_inputs_of_the_estimator(&rig);
    }
    rig_expect(&rig, LODE_MODE_RUN);
    // After a trip nothing is on its way; the current of the tripping step stays until the fault is
    // cleared.
    rig.trip = true;
    const lode_counts_t counts = rig_counts(&rig);
    lode_drive_t seen = rig.drive;
    const float last_A = lode_drive_sense(&seen, &counts).i_A.alpha;
    TEST_ASSERT_TRUE(last_A != 0.0f);
    rig_run(&rig, 0.01);
    rig_expect(&rig, LODE_MODE_FAULT);
    check_bits(0.0f, &rig.drive, LODE_CHANNEL_U_ALPHA);
    check_bits(last_A, &rig.drive, LODE_CHANNEL_I_ALPHA);
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true});
    rig_step(&rig);
    check_inputs_of_the_estimator(&rig);
    check_bits(0.0f, &rig.drive, LODE_CHANNEL_I_ALPHA);
}

static void test_other_numbers_read_0(void) {
    rig_t rig;
    lode_drive_tuning_t tuning;
    const lode_drive_config_t config = rig_config();
    rig_init(&rig, &tuning, &config);
    const uint32_t numbers[] = {(uint32_t)LODE_CHANNEL_COUNT, 100u, 65535u};
    for (int n = 0; n < COUNT_OF(numbers); n++) {
        TEST_ASSERT_EQUAL_FLOAT(0.0f, lode_channel_read(&rig.drive, (lode_channel_t)numbers[n]));
    }
}

static void test_bits_are_ieee_754(void) {
    TEST_ASSERT_EQUAL_HEX32(0x3F800000u, lode_channel_bits(1.0f));
    TEST_ASSERT_EQUAL_HEX32(0xC0490FDBu, lode_channel_bits(-LODE_PI));
    TEST_ASSERT_EQUAL_HEX32(0x7F800000u, lode_channel_bits(INFINITY));
    TEST_ASSERT_EQUAL_HEX32(0x80000000u, lode_channel_bits(-0.0f));
}

#define NUMBER(channel, number, name, unit) TEST_ASSERT_EQUAL_INT(number, LODE_CHANNEL_##channel);
static void test_numbers_are_those_of_the_table_without_gaps(void) {
    LODE_CHANNELS(NUMBER)
    TEST_ASSERT_EQUAL_INT(31, LODE_CHANNEL_COUNT);
}
#undef NUMBER

static const lode_channels_config_t good = {
    .f_pwm_Hz = 5000.0f, .decimation = 3, .count = 2, .channel = {LODE_CHANNEL_IQ}};

static void refuses(lode_channels_config_t config, lode_status_t wanted) {
    lode_channels_t channels = {.wait = 7u};
    const lode_channels_t before = channels;
    TEST_ASSERT_EQUAL_STRING(lode_status_name(wanted),
                             lode_status_name(lode_channels_init(&channels, &config)));
    TEST_ASSERT_EQUAL_MEMORY(&before, &channels, sizeof before);
}

static void test_bad_configurations_are_refused(void) {
    lode_channels_t channels;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_channels_init(NULL, &good));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_channels_init(&channels, NULL));
    const float rates[] = {0.0f, 999.9f, 2.0001e5f, NAN, INFINITY, -5000.0f};
    for (int n = 0; n < COUNT_OF(rates); n++) {
        lode_channels_config_t config = good;
        config.f_pwm_Hz = rates[n];
        refuses(config, LODE_ERROR_F_PWM);
    }
    lode_channels_config_t config = good;
    config.f_pwm_Hz = 1.0e3f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_channels_init(&channels, &config));
    config.f_pwm_Hz = 2.0e5f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_channels_init(&channels, &config));
    config.count = 0u;
    refuses(config, LODE_ERROR_CHANNELS);
    config.count = LODE_CHANNELS_MAX + 1u;
    refuses(config, LODE_ERROR_CHANNELS);
    config = good;
    config.channel[1] = LODE_CHANNEL_COUNT;
    refuses(config, LODE_ERROR_CHANNELS);
    config.count = 1u; // the wrong one is not in use
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_channels_init(&channels, &config));
}

static void test_rows_are_due_by_the_decimation(void) {
    const uint16_t decimations[] = {0u, 1u, 2u, 3u, 100u, 65535u};
    for (int i = 0; i < COUNT_OF(decimations); i++) {
        lode_channels_config_t config = good;
        config.decimation = decimations[i];
        lode_channels_t channels;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_channels_init(&channels, &config));
        const uint32_t every = decimations[i] > 0u ? decimations[i] : 1u;
        for (uint32_t n = 0; n < 3u * every; n++) {
            TEST_ASSERT_EQUAL_INT(n % every == 0u, lode_channels_due(&channels));
        }
    }
}

static void test_a_row_holds_the_channels_in_their_order(void) {
    rig_t rig;
    lode_drive_tuning_t tuning;
    const lode_drive_config_t drive = rig_config();
    rig_init(&rig, &tuning, &drive);
    rig_step(&rig);
    const lode_channels_config_t config = {
        .f_pwm_Hz = 5000.0f,
        .count = 3,
        .channel = {LODE_CHANNEL_V_BUS, LODE_CHANNEL_MODE, LODE_CHANNEL_DUTY_A}};
    lode_channels_t channels;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_channels_init(&channels, &config));
    uint32_t row[4] = {9u, 9u, 9u, 9u};
    lode_channels_row(&channels, &rig.drive, row);
    CHECK_NEAR(0.1, PAPER_V_BUS, check_from_bits(row[0]));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, check_from_bits(row[1]));
    TEST_ASSERT_EQUAL_FLOAT(0.5f, check_from_bits(row[2]));
    TEST_ASSERT_EQUAL_UINT32(9u, row[3]);
}

static void test_a_drive_that_is_off_asks_for_no_speed(void) {
    rig_t rig;
    lode_drive_tuning_t tuning;
    const lode_drive_config_t drive = rig_config();
    rig_init(&rig, &tuning, &drive);
    rig_step(&rig);
    CHECK_NEAR(0.0, 0.0, lode_drive_speed_ref_rad_s(&rig.drive));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_channels_are_the_fields_of_the_telemetry);
    RUN_TEST(test_stator_axes_are_what_the_estimator_sees);
    RUN_TEST(test_other_numbers_read_0);
    RUN_TEST(test_bits_are_ieee_754);
    RUN_TEST(test_numbers_are_those_of_the_table_without_gaps);
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_rows_are_due_by_the_decimation);
    RUN_TEST(test_a_row_holds_the_channels_in_their_order);
    RUN_TEST(test_a_drive_that_is_off_asks_for_no_speed);
    return UNITY_END();
}
