// Scope: what is in the buffer in each state, around each trigger, and what goes over the wire.
#include "support/source.h"

#include "lodestar/scope.h"

enum { CHANNELS = 3, ROWS = 20, HEADER = LODE_SCOPE_AT_CHANNEL + CHANNELS };

static source_t source;
static lode_scope_t scope;
static uint32_t buffer[LODE_SCOPE_WORDS(CHANNELS, ROWS)];

void setUp(void) {
    source_init(&source);
    memset(buffer, 0x5A, sizeof buffer);
}

void tearDown(void) {}

static lode_scope_config_t config_of(lode_trigger_t trigger, float level, float pre_share,
                                     uint16_t decimation) {
    return (lode_scope_config_t){.rows = source_channels(decimation),
                                 .trigger = trigger,
                                 .source = LODE_CHANNEL_TEMPERATURE,
                                 .level = level,
                                 .pre_share = pre_share};
}

static void start(lode_trigger_t trigger, float level, float pre_share, uint16_t decimation) {
    const lode_scope_config_t config = config_of(trigger, level, pre_share, decimation);
    TEST_ASSERT_EQUAL_STRING("LODE_OK", lode_status_name(lode_scope_init(
                                            &scope, &config, buffer, (uint32_t)COUNT_OF(buffer))));
}

static void run(int periods) {
    for (int n = 0; n < periods; n++) {
        source_step(&source);
        lode_scope_step(&scope, &source.drive);
    }
}

static void expect(lode_scope_state_t state) {
    TEST_ASSERT_EQUAL_INT(state, lode_scope_state(&scope));
    TEST_ASSERT_EQUAL_UINT32(state, buffer[LODE_SCOPE_AT_STATE]);
}

// Rows in the order of time: one per `decimation` periods, the newest as the header says. Returns how
// many there are; *event is the number of the event's among them.
static uint32_t check_rows(uint32_t decimation, uint32_t *event) {
    const uint32_t filled = buffer[LODE_SCOPE_AT_FILLED];
    const uint32_t oldest = filled < ROWS ? 0u : buffer[LODE_SCOPE_AT_NEXT];
    const uint32_t first =
        buffer[LODE_SCOPE_AT_PERIOD] - (filled > 0u ? filled - 1u : 0u) * decimation;
    for (uint32_t n = 0; n < filled; n++) {
        const uint32_t at = (oldest + n) % ROWS;
        source_check_row(&buffer[HEADER + CHANNELS * at], first + n * decimation);
        if (at == buffer[LODE_SCOPE_AT_EVENT]) {
            *event = n;
        }
    }
    return filled;
}

// ---- States -------------------------------------------------------------------------------------

static void test_header_and_idle(void) {
    start(LODE_TRIGGER_RISING, 7.5f, 0.5f, 4);
    run(10);
    expect(LODE_SCOPE_IDLE);
    const uint32_t header[HEADER] = {0x63536F4Cu, 1u, 3u,  ROWS, 0x459C4000u, 4u,
                                     0u,          0u, 0u,  0u,   1u,          12u,
                                     0x40F00000u, 0u, 12u, 11u,  0u};
    TEST_ASSERT_EQUAL_HEX32_ARRAY(header, buffer, HEADER);
    TEST_ASSERT_EQUAL_HEX32(0x5A5A5A5Au, buffer[HEADER]); // no row yet
}

static void test_armed_it_goes_round_and_round(void) {
    start(LODE_TRIGGER_RISING, 4000.0f, 0.5f, 1);
    run(3);
    lode_scope_arm(&scope);
    TEST_ASSERT_EQUAL_INT(LODE_SCOPE_ARMED, lode_scope_state(&scope)); // before the interrupt
    for (uint32_t n = 1; n < 70u; n++) {
        run(1);
        expect(LODE_SCOPE_ARMED);
        uint32_t event = 0u;
        TEST_ASSERT_EQUAL_UINT32(n < ROWS ? n : ROWS, check_rows(1, &event));
        TEST_ASSERT_EQUAL_UINT32(n + 2u, buffer[LODE_SCOPE_AT_PERIOD]);
    }
    lode_scope_stop(&scope);
    TEST_ASSERT_EQUAL_INT(LODE_SCOPE_IDLE, lode_scope_state(&scope));
    run(1);
    expect(LODE_SCOPE_IDLE);
    const uint32_t newest = buffer[LODE_SCOPE_AT_PERIOD];
    run(5);
    TEST_ASSERT_EQUAL_UINT32(newest, buffer[LODE_SCOPE_AT_PERIOD]);
}

// ---- Triggers -----------------------------------------------------------------------------------

static void test_rows_before_and_after_the_event(void) {
    const struct {
        float pre_share;
        uint32_t before;
    } cases[] = {{0.0f, 0}, {0.1f, 2}, {0.25f, 5}, {0.5f, 10}, {0.96f, 18}, {1.0f, 19}};
    for (int i = 0; i < COUNT_OF(cases); i++) {
        for (uint16_t decimation = 1; decimation < 6u; decimation++) {
            source_init(&source);
            start(LODE_TRIGGER_RISING, 137.5f, cases[i].pre_share, decimation);
            run(2);
            lode_scope_arm(&scope);
            run(138 - 2);
            expect(LODE_SCOPE_ARMED);
            run((int)decimation);
            TEST_ASSERT_TRUE(lode_scope_state(&scope) >= LODE_SCOPE_TRIGGERED);
            run((int)(decimation * (ROWS - cases[i].before)));
            expect(LODE_SCOPE_DONE);
            uint32_t event = 99u;
            TEST_ASSERT_EQUAL_UINT32(ROWS, check_rows(decimation, &event));
            TEST_ASSERT_EQUAL_UINT32(cases[i].before, event);
            // The first row at or after period 138, rows beginning with period 2.
            const uint32_t row = buffer[LODE_SCOPE_AT_PERIOD] - (ROWS - 1u - event) * decimation;
            TEST_ASSERT_EQUAL_UINT32(2u + (136u + decimation - 1u) / decimation * decimation, row);
            const uint32_t newest = buffer[LODE_SCOPE_AT_PERIOD];
            run(50);
            TEST_ASSERT_EQUAL_UINT32(newest, buffer[LODE_SCOPE_AT_PERIOD]); // single shot
        }
    }
}

static void test_event_before_the_buffer_is_full_is_not_missed(void) {
    start(LODE_TRIGGER_RISING, 2.5f, 0.5f, 1);
    lode_scope_arm(&scope);
    run(40);
    expect(LODE_SCOPE_DONE);
    uint32_t event = 99u;
    TEST_ASSERT_EQUAL_UINT32(13u, check_rows(1, &event)); // 0 .. 2, and half the buffer
    TEST_ASSERT_EQUAL_UINT32(3u, event);
}

static void test_falling(void) {
    start(LODE_TRIGGER_FALLING, 100.0f, 0.25f, 1);
    run(50);
    lode_scope_arm(&scope);
    run(4096 - 50); // up to 4095: it only rises
    expect(LODE_SCOPE_ARMED);
    run(1); // to 0
    expect(LODE_SCOPE_TRIGGERED);
    run(ROWS);
    expect(LODE_SCOPE_DONE);
    uint32_t event = 99u;
    TEST_ASSERT_EQUAL_UINT32(ROWS, check_rows(1, &event));
    TEST_ASSERT_EQUAL_UINT32(5u, event);
}

static void test_being_there_is_no_edge(void) {
    const lode_trigger_t triggers[] = {LODE_TRIGGER_RISING, LODE_TRIGGER_FALLING};
    for (int n = 0; n < COUNT_OF(triggers); n++) {
        source_init(&source);
        start(triggers[n], n == 0 ? 5.0f : 900.0f, 0.5f, 1);
        run(6); // it was there before it was armed
        lode_scope_arm(&scope);
        run(500);
        expect(LODE_SCOPE_ARMED);
    }
}

static void test_level_is_reached_exactly(void) {
    start(LODE_TRIGGER_RISING, 30.0f, 0.0f, 1);
    lode_scope_arm(&scope);
    run(30); // up to 29
    expect(LODE_SCOPE_ARMED);
    run(1);
    expect(LODE_SCOPE_TRIGGERED);
}

/// What rests at the level has an edge where it comes to it, and none where it leaves it.
static void test_an_edge_to_the_level_counts_and_one_from_it_does_not(void) {
    const uint32_t values[4][4] = {
        {6u, 5u, 5u, 4u}, {5u, 5u, 4u, 3u}, {4u, 5u, 5u, 6u}, {5u, 5u, 6u, 7u}};
    for (int n = 0; n < 4; n++) {
        start(n < 2 ? LODE_TRIGGER_FALLING : LODE_TRIGGER_RISING, 5.0f, 0.0f, 1);
        lode_scope_arm(&scope);
        for (int k = 0; k < 4; k++) {
            source.periods = values[n][k];
            run(1);
            expect(n % 2 == 0 && k > 0 ? LODE_SCOPE_TRIGGERED : LODE_SCOPE_ARMED);
        }
    }
}

static void test_event_between_two_rows_counts(void) {
    // The step up is seen in period 150, rows are taken in 0, 100, 200: in 200 it might be over.
    start(LODE_TRIGGER_RISING, 149.5f, 0.0f, 100);
    lode_scope_arm(&scope);
    run(200);
    expect(LODE_SCOPE_ARMED);
    run(1);
    expect(LODE_SCOPE_TRIGGERED);
    TEST_ASSERT_EQUAL_UINT32(200u, buffer[LODE_SCOPE_AT_PERIOD]);
    TEST_ASSERT_EQUAL_UINT32(2u, buffer[LODE_SCOPE_AT_EVENT]);
}

static void test_immediate(void) {
    start(LODE_TRIGGER_IMMEDIATE, 0.0f, 0.5f, 1);
    run(5);
    lode_scope_arm(&scope);
    run(1);
    expect(LODE_SCOPE_TRIGGERED);
    run(ROWS / 2 - 2);
    expect(LODE_SCOPE_TRIGGERED);
    run(1);
    expect(LODE_SCOPE_DONE);
    uint32_t event = 99u;
    TEST_ASSERT_EQUAL_UINT32(ROWS / 2, check_rows(1, &event)); // nothing came before
    TEST_ASSERT_EQUAL_UINT32(0u, event);
}

static void step_with(bool trip) {
    const lode_counts_t counts = {.i = {2048u, 2048u, 2048u}, .v_bus = 1600u, .trip = trip};
    (void)lode_drive_step(&source.drive, &counts);
    lode_scope_step(&scope, &source.drive);
}

static void test_fault(void) {
    lode_scope_config_t config = config_of(LODE_TRIGGER_FAULT, NAN, 0.5f, 1);
    config.source = LODE_CHANNEL_COUNT; // neither matters
    config.rows.channel[0] = LODE_CHANNEL_CHECK;
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_scope_init(&scope, &config, buffer, (uint32_t)COUNT_OF(buffer)));
    const lode_command_t go = {.mode = LODE_MODE_CURRENT};
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_command(&source.drive, &go));
    lode_scope_arm(&scope);
    for (int n = 0; n < 33; n++) {
        step_with(false);
    }
    expect(LODE_SCOPE_ARMED);
    step_with(true);
    expect(LODE_SCOPE_TRIGGERED);
    for (int n = 0; n < 9; n++) {
        step_with(false);
    }
    expect(LODE_SCOPE_DONE);
    const uint32_t event = buffer[LODE_SCOPE_AT_EVENT];
    const uint32_t before = (event + ROWS - 1u) % ROWS;
    TEST_ASSERT_EQUAL_FLOAT((float)LODE_CHECK_HARDWARE_TRIP,
                            check_from_bits(buffer[HEADER + CHANNELS * event]));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, check_from_bits(buffer[HEADER + CHANNELS * before]));
    lode_scope_arm(&scope); // the same fault is no new one
    for (int n = 0; n < 50; n++) {
        step_with(false);
    }
    expect(LODE_SCOPE_ARMED);
}

static void test_armed_anew_in_any_state(void) {
    start(LODE_TRIGGER_RISING, 50.0f, 0.5f, 1);
    for (int n = 0; n < 70; n++) { // idle, armed, triggered, done
        source_init(&source);
        start(LODE_TRIGGER_RISING, 50.0f, 0.5f, 1);
        if (n > 0) {
            lode_scope_arm(&scope);
        }
        run(n);
        source.periods = 0u;
        lode_scope_arm(&scope);
        TEST_ASSERT_EQUAL_INT(LODE_SCOPE_ARMED, lode_scope_state(&scope));
        run(1);
        expect(LODE_SCOPE_ARMED);
        TEST_ASSERT_EQUAL_UINT32(1u, buffer[LODE_SCOPE_AT_FILLED]);
        TEST_ASSERT_EQUAL_UINT32(1u, buffer[LODE_SCOPE_AT_NEXT]); // from the first row on
        run(70);
        expect(LODE_SCOPE_DONE);
        const uint32_t event = buffer[LODE_SCOPE_AT_EVENT];
        source_check_row(&buffer[HEADER + CHANNELS * event], 50u);
    }
}

static void test_armed_anew_nothing_of_before_counts(void) {
    start(LODE_TRIGGER_RISING, 50.0f, 0.5f, 10);
    lode_scope_arm(&scope);
    run(14); // below the level, 6 periods before the next row
    lode_scope_stop(&scope);
    run(86);
    lode_scope_arm(&scope); // above it
    run(1);
    expect(LODE_SCOPE_ARMED);
    TEST_ASSERT_EQUAL_UINT32(1u, buffer[LODE_SCOPE_AT_FILLED]); // a row at once
    TEST_ASSERT_EQUAL_UINT32(100u, buffer[LODE_SCOPE_AT_PERIOD]);
    run(300);
    expect(LODE_SCOPE_ARMED);
}

// ---- Wire ---------------------------------------------------------------------------------------

static uint32_t word_of(const uint16_t *o) {
    return o[0] | (uint32_t)o[1] << 8 | (uint32_t)o[2] << 16 | (uint32_t)o[3] << 24;
}

static void check_image(const uint16_t *octets) {
    uint32_t crc = LODE_CRC_START;
    for (uint32_t n = 0; n < (uint32_t)COUNT_OF(buffer); n++) {
        const uint32_t flag = n == LODE_SCOPE_AT_STATE ? 0x100u : 0u;
        TEST_ASSERT_EQUAL_HEX32(buffer[n] | flag, word_of(&octets[4u * n]));
    }
    for (uint32_t n = 0; n < 4u * (uint32_t)COUNT_OF(buffer); n++) {
        crc = lode_crc_octet(crc, octets[n]);
    }
    TEST_ASSERT_EQUAL_HEX32(~crc, word_of(&octets[4 * COUNT_OF(buffer)]));
}

static void test_drain_in_pieces_of_any_size(void) {
    start(LODE_TRIGGER_RISING, 30.0f, 0.5f, 1);
    lode_scope_arm(&scope);
    uint16_t octets[4 * COUNT_OF(buffer) + 4 + 100];
    TEST_ASSERT_EQUAL_UINT32(0u, lode_scope_drain(&scope, octets, 100u));
    run(35);
    expect(LODE_SCOPE_TRIGGERED);
    TEST_ASSERT_EQUAL_UINT32(0u, lode_scope_drain(&scope, octets, 100u));
    run(35);
    expect(LODE_SCOPE_DONE);
    for (uint32_t piece = 1; piece <= 100u; piece++) { // each time the whole again
        uint32_t total = 0u;
        memset(octets, 0, sizeof octets);
        for (uint32_t got = 1u; got > 0u; total += got) {
            got = lode_scope_drain(&scope, &octets[total], piece);
            TEST_ASSERT_TRUE(got <= piece);
        }
        TEST_ASSERT_EQUAL_UINT32(4 * COUNT_OF(buffer) + 4, total);
        check_image(octets);
    }
    // Armed in the middle of it: the next capture begins at its beginning.
    (void)lode_scope_drain(&scope, octets, 41u);
    const uint16_t before = octets[40];
    TEST_ASSERT_EQUAL_UINT32(0u, lode_scope_drain(&scope, octets, 0u)); // no room: not the end
    (void)lode_scope_drain(&scope, &octets[41], 7u);
    TEST_ASSERT_EQUAL_HEX32(buffer[10], word_of(&octets[40]));
    TEST_ASSERT_EQUAL_HEX32(buffer[11], word_of(&octets[44]));
    TEST_ASSERT_EQUAL_HEX16(before, octets[40]);
    (void)lode_scope_drain(&scope, octets, 3u); // and of a word
    source.periods = 0u;
    lode_scope_arm(&scope);
    TEST_ASSERT_EQUAL_UINT32(0u, lode_scope_drain(&scope, octets, 100u));
    run(70);
    TEST_ASSERT_EQUAL_UINT32(4 * COUNT_OF(buffer) + 4,
                             lode_scope_drain(&scope, octets, (uint32_t)COUNT_OF(octets)));
    check_image(octets);
}

// ---- Configuration ------------------------------------------------------------------------------

static void refuses(lode_scope_config_t config, uint32_t words, lode_status_t wanted) {
    memset(&scope, 0x33, sizeof scope);
    const lode_scope_t before = scope;
    TEST_ASSERT_EQUAL_STRING(lode_status_name(wanted),
                             lode_status_name(lode_scope_init(&scope, &config, buffer, words)));
    TEST_ASSERT_EQUAL_MEMORY(&before, &scope, sizeof before);
    TEST_ASSERT_EQUAL_HEX32(0x5A5A5A5Au, buffer[0]);
}

static void test_bad_configurations_are_refused(void) {
    const uint32_t least = LODE_SCOPE_WORDS(CHANNELS, 2);
    const lode_scope_config_t good = config_of(LODE_TRIGGER_RISING, 1.0f, 0.5f, 1);
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_scope_init(NULL, &good, buffer, least));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_scope_init(&scope, NULL, buffer, least));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_scope_init(&scope, &good, NULL, least));
    refuses(good, least - 1u, LODE_ERROR_BUFFER);
    refuses(good, 0u, LODE_ERROR_BUFFER);
    lode_scope_config_t config = good;
    config.rows.f_pwm_Hz = 10.0f;
    refuses(config, least, LODE_ERROR_F_PWM);
    config = good;
    config.rows.count = 0u;
    refuses(config, least, LODE_ERROR_CHANNELS);
    config = good;
    config.source = LODE_CHANNEL_COUNT;
    refuses(config, least, LODE_ERROR_TRIGGER);
    config = good;
    config.trigger = (lode_trigger_t)4;
    refuses(config, least, LODE_ERROR_TRIGGER);
    for (int n = 0; n < COUNT_OF(check_not_finite); n++) {
        config = good;
        config.level = check_not_finite[n];
        refuses(config, least, LODE_ERROR_TRIGGER);
        config = good;
        config.pre_share = check_not_finite[n];
        refuses(config, least, LODE_ERROR_PRE_SHARE);
    }
    config = good;
    config.pre_share = -0.01f;
    refuses(config, least, LODE_ERROR_PRE_SHARE);
    config.pre_share = 1.01f;
    refuses(config, least, LODE_ERROR_PRE_SHARE);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_scope_init(&scope, &good, buffer, least));
}

static void test_spare_words_are_not_touched(void) {
    const lode_scope_config_t config = config_of(LODE_TRIGGER_RISING, 30.0f, 0.5f, 1);
    for (uint32_t spare = 0; spare < (uint32_t)CHANNELS; spare++) {
        setUp();
        const uint32_t words = LODE_SCOPE_WORDS(CHANNELS, 4) + spare;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_scope_init(&scope, &config, buffer, words));
        lode_scope_arm(&scope);
        run(50);
        expect(LODE_SCOPE_DONE);
        TEST_ASSERT_EQUAL_UINT32(4u, buffer[LODE_SCOPE_AT_FILLED]);
        for (uint32_t n = LODE_SCOPE_WORDS(CHANNELS, 4); n < (uint32_t)COUNT_OF(buffer); n++) {
            TEST_ASSERT_EQUAL_HEX32(0x5A5A5A5Au, buffer[n]);
        }
    }
}

static void test_more_rows_than_a_float_counts(void) {
    // Only the header is written, so no such buffer is needed.
    lode_scope_config_t config = config_of(LODE_TRIGGER_RISING, 30.0f, 1.0f, 1);
    config.rows.count = 1u;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_scope_init(&scope, &config, buffer, 0xFFFFFFFFu));
    TEST_ASSERT_EQUAL_UINT32(0x800000u, buffer[LODE_SCOPE_AT_ROWS]);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_header_and_idle);
    RUN_TEST(test_armed_it_goes_round_and_round);
    RUN_TEST(test_rows_before_and_after_the_event);
    RUN_TEST(test_event_before_the_buffer_is_full_is_not_missed);
    RUN_TEST(test_falling);
    RUN_TEST(test_being_there_is_no_edge);
    RUN_TEST(test_level_is_reached_exactly);
    RUN_TEST(test_an_edge_to_the_level_counts_and_one_from_it_does_not);
    RUN_TEST(test_event_between_two_rows_counts);
    RUN_TEST(test_immediate);
    RUN_TEST(test_fault);
    RUN_TEST(test_armed_anew_in_any_state);
    RUN_TEST(test_armed_anew_nothing_of_before_counts);
    RUN_TEST(test_drain_in_pieces_of_any_size);
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_spare_words_are_not_touched);
    RUN_TEST(test_more_rows_than_a_float_counts);
    return UNITY_END();
}
