#include "record.h"

#include "board.h"

// 115200 baud carry 11520 octets/s; a frame of six channels has 32.
#define RING_CHANNELS 6u
#define RING_FRAMES 64u // buffers a third of a second without the thread
#define RING_RATE_Hz 200.0f
#define RING_WORDS LODE_RING_WORDS(RING_CHANNELS, RING_FRAMES)
#define SCOPE_CHANNELS 8u
#ifndef SCOPE_ROWS      // a chip with little RAM uses fewer
#define SCOPE_ROWS 250u // 12.5 ms at 20 kHz; 8 KB
#endif
#define SCOPE_WORDS LODE_SCOPE_WORDS(SCOPE_CHANNELS, SCOPE_ROWS)
#define SCOPE_PRE_SHARE 0.9f // the cause of a fault lies before it
#define OCTETS_MAX 64u

static const lode_channels_config_t sent_always = {
    .count = RING_CHANNELS,
    .channel = {LODE_CHANNEL_MODE, LODE_CHANNEL_ID, LODE_CHANNEL_IQ, LODE_CHANNEL_OMEGA,
                LODE_CHANNEL_LOCK, LODE_CHANNEL_V_BUS}};
static const lode_channels_config_t seen_closely = {
    .count = SCOPE_CHANNELS,
    .channel = {LODE_CHANNEL_CHECK, LODE_CHANNEL_ID, LODE_CHANNEL_IQ, LODE_CHANNEL_UD,
                LODE_CHANNEL_UQ, LODE_CHANNEL_THETA, LODE_CHANNEL_OMEGA, LODE_CHANNEL_V_BUS}};

static lode_ring_t ring;
static uint32_t ring_words[RING_WORDS];
static lode_scope_t scope;
static uint32_t scope_words[SCOPE_WORDS];

static volatile bool paused; // set by the thread: the interrupt does not use the scope

// Variables of the thread.
static lode_scope_config_t capture;
static bool dumped;
static uint16_t octets[OCTETS_MAX];
static uint32_t count;
static uint32_t sent;

lode_status_t record_init(float f_pwm_Hz) {
    lode_channels_config_t rows = sent_always;
    rows.f_pwm_Hz = f_pwm_Hz;
    rows.decimation = (uint16_t)(int32_t)(f_pwm_Hz / RING_RATE_Hz);
    capture = (lode_scope_config_t){
        .rows = seen_closely, .trigger = LODE_TRIGGER_FAULT, .pre_share = SCOPE_PRE_SHARE};
    capture.rows.f_pwm_Hz = f_pwm_Hz;
    dumped = false;
    count = 0u;
    sent = 0u;
    const lode_status_t status = lode_ring_init(&ring, &rows, ring_words, RING_WORDS);
    return status != LODE_OK ? status : lode_scope_init(&scope, &capture, scope_words, SCOPE_WORDS);
}

LODE_RAMFUNC void record_period(const lode_drive_t *drive) {
    lode_ring_step(&ring, drive);
    if (!paused) {
        lode_scope_step(&scope, drive);
    }
}

void record_arm(lode_trigger_t trigger) {
    capture.trigger = trigger;
    paused = true;
    LODE_SIGNAL_FENCE();
    (void)lode_scope_init(&scope, &capture, scope_words, SCOPE_WORDS);
    lode_scope_arm(&scope);
    LODE_SIGNAL_FENCE();
    paused = false;
    dumped = false;
}

static uint32_t next_octets(link_t link) {
    if (link == LINK_RING) {
        return lode_ring_drain(&ring, octets, OCTETS_MAX);
    }
    if (link != LINK_SCOPE || dumped || lode_scope_state(&scope) != LODE_SCOPE_DONE) {
        return 0u;
    }
    const uint32_t some = lode_scope_drain(&scope, octets, OCTETS_MAX);
    dumped = some == 0u; // the end of the dump; the next call would restart it
    return some;
}

bool record_poll(link_t link) {
    if (sent == count) { // all octets sent: take the next ones
        sent = 0u;
        count = next_octets(link);
    }
    sent += board_send(&octets[sent], count - sent);
    return link != LINK_REPORT || sent < count;
}
