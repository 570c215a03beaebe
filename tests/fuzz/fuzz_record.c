// Ring and scope: any configuration is refused or works; what they send comes back through the decoder.
#include "decode/decode.h"
#include "support/fuzz.h"

enum { WORDS = 300, OCTETS = 40000 };

static lode_drive_t drive;
static uint32_t buffer[WORDS + 1];
static unsigned char sent[OCTETS];
static size_t count;

/// A drive at rest; designed once, because that takes long.
static bool setup(void) {
    static lode_drive_tuning_t tuning;
    static lode_drive_t fresh;
    const lode_drive_config_t config = {.f_pwm_Hz = 5000.0f,
                                        .motor = fuzz_motor(),
                                        .inverter = {.v_bus_V = 200.0f, .i_max_A = 12.0f},
                                        .sense = {.i_gain_A_count = 0.0125f,
                                                  .i_offset_count = 2048.0f,
                                                  .v_bus_gain_V_count = 0.1f,
                                                  .temperature_gain_degC_count = 0.1f}};
    const bool good = fresh.tuning != NULL || lode_drive_init(&fresh, &tuning, &config) == LODE_OK;
    drive = fresh;
    return good;
}

static void step(uint16_t n) {
    const lode_counts_t counts = {.i = {2048, 2048, 2048}, .v_bus = n, .temperature = n};
    (void)lode_drive_step(&drive, &counts);
}

static lode_channels_config_t channels(fuzz_t *in) {
    lode_channels_config_t config = {.f_pwm_Hz = fuzz_byte(in) < 240u ? 5000.0f : fuzz_float(in),
                                     .decimation = fuzz_byte(in) % 8u,
                                     .count = (uint16_t)(fuzz_byte(in) % 18u)};
    for (int n = 0; n < LODE_CHANNELS_MAX; n++) {
        config.channel[n] = (lode_channel_t)(fuzz_byte(in) % 24u);
    }
    return config;
}

static void take(const uint16_t *octets, uint32_t n) {
    for (uint32_t k = 0; k < n; k++) {
        FUZZ_CHECK(octets[k] <= 255u);
        if (count < OCTETS) {
            sent[count++] = (unsigned char)octets[k];
        }
    }
}

static void ring(fuzz_t *in, uint32_t words) {
    static lode_ring_t ring;
    const lode_channels_config_t config = channels(in);
    if (lode_ring_init(&ring, &config, buffer, words) != LODE_OK) {
        return;
    }
    uint32_t periods = 0u;
    while (fuzz_more(in)) {
        uint16_t octets[256];
        const uint8_t what = fuzz_byte(in);
        for (uint32_t n = 0; n < what % 16u; n++, periods++) {
            step((uint16_t)(periods & 4095u));
            lode_ring_step(&ring, &drive);
        }
        take(octets, lode_ring_drain(&ring, octets, what));
    }
    decode_t decoded;
    if (decode_parse(&decoded, sent, count, DECODE_WANT_RING)) {
        const uint32_t taken = decoded.rows > 0u ? decoded.number[decoded.rows - 1u] + 1u : 0u;
        FUZZ_CHECK(decoded.damaged == 0u && decoded.kind == DECODE_FRAMES);
        FUZZ_CHECK(decoded.rows + decoded.lost >= taken); // more: told by a description at the end
        FUZZ_CHECK(decoded.lost <= lode_ring_overruns(&ring));
        decode_free(&decoded);
    } else {
        FUZZ_CHECK(count < 4u * (6u + LODE_CHANNELS_MAX) * 2u); // no whole frame of data
    }
}

static void scope(fuzz_t *in, uint32_t words) {
    static lode_scope_t scope;
    const lode_scope_config_t config = {.rows = channels(in),
                                        .trigger = (lode_trigger_t)(fuzz_byte(in) % 5u),
                                        .source = (lode_channel_t)(fuzz_byte(in) % 24u),
                                        .level = fuzz_number(in, 100.0f),
                                        .pre_share = fuzz_number(in, 1.0f)};
    if (lode_scope_init(&scope, &config, buffer, words) != LODE_OK) {
        return;
    }
    while (fuzz_more(in)) {
        uint16_t octets[256];
        const uint8_t what = fuzz_byte(in);
        if (what == 255u) {
            lode_scope_stop(&scope);
        } else if (what >= 240u || lode_scope_state(&scope) == LODE_SCOPE_IDLE) {
            lode_scope_arm(&scope);
            count = 0u;
        }
        for (uint32_t n = 0; n < what % 64u; n++) {
            step((uint16_t)(what * n));
            lode_scope_step(&scope, &drive);
        }
        const uint32_t got = lode_scope_drain(&scope, octets, what);
        FUZZ_CHECK(got == 0u || lode_scope_state(&scope) == LODE_SCOPE_DONE);
        take(octets, got);
    }
    decode_t decoded;
    const bool whole = count > 4u * (LODE_SCOPE_WORDS(config.rows.count, scope.rows));
    if (decode_parse(&decoded, sent, count, DECODE_WANT_SCOPE)) {
        FUZZ_CHECK(decoded.kind == DECODE_SCOPE && decoded.checked && decoded.has_event);
        FUZZ_CHECK(decoded.rows - decoded.event == scope.rows_after);
        decode_free(&decoded);
    } else {
        FUZZ_CHECK(!whole || decoded.offset >= count);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_t in = {data, size};
    count = 0u;
    if (!setup()) {
        return 0;
    }
    const uint8_t choice = fuzz_byte(&in);
    const uint32_t words = (fuzz_byte(&in) + 256u * (choice / 2u % 2u)) % (WORDS + 1u);
    buffer[words] = 0x12345678u;
    if ((choice & 1u) != 0u) {
        ring(&in, words);
    } else {
        scope(&in, words);
    }
    FUZZ_CHECK(buffer[words] == 0x12345678u);
    return 0;
}
