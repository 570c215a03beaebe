#include "lodestar/scope.h"

#include <stddef.h>

enum { REQUEST_NONE, REQUEST_ARM, REQUEST_STOP };

// Between LODE_CHECK_NONE and all others.
#define FAULT_LEVEL 0.5f
// A float counts this many exactly in halves; the rest of a larger buffer is not used.
#define ROWS_MAX 0x800000u

static lode_status_t take_trigger(lode_scope_t *self, const lode_scope_config_t *config) {
    self->trigger = config->trigger;
    self->source = config->source;
    self->level = config->level;
    switch (config->trigger) {
    case LODE_TRIGGER_IMMEDIATE:
    case LODE_TRIGGER_FAULT:
        self->source = LODE_CHANNEL_CHECK;
        self->level = FAULT_LEVEL;
        return LODE_OK;
    case LODE_TRIGGER_RISING:
    case LODE_TRIGGER_FALLING:
        return (uint32_t)config->source < (uint32_t)LODE_CHANNEL_COUNT &&
                       lode_is_finite(config->level)
                   ? LODE_OK
                   : LODE_ERROR_TRIGGER;
    default:
        return LODE_ERROR_TRIGGER;
    }
}

static void write_header(const lode_scope_t *self, float f_pwm_Hz) {
    uint32_t *to = self->buffer;
    to[LODE_SCOPE_AT_MAGIC] = LODE_SCOPE_MAGIC;
    to[LODE_SCOPE_AT_VERSION] = LODE_SCOPE_VERSION;
    to[LODE_SCOPE_AT_CHANNELS] = self->channels.count;
    to[LODE_SCOPE_AT_ROWS] = self->rows;
    to[LODE_SCOPE_AT_F_PWM] = lode_channel_bits(f_pwm_Hz);
    to[LODE_SCOPE_AT_DECIMATION] = self->channels.decimation;
    to[LODE_SCOPE_AT_STATE] = (uint32_t)LODE_SCOPE_IDLE;
    to[LODE_SCOPE_AT_FILLED] = 0u;
    to[LODE_SCOPE_AT_NEXT] = 0u;
    to[LODE_SCOPE_AT_PERIOD] = 0u;
    to[LODE_SCOPE_AT_TRIGGER] = (uint32_t)self->trigger;
    to[LODE_SCOPE_AT_SOURCE] = (uint32_t)self->source;
    to[LODE_SCOPE_AT_LEVEL] = lode_channel_bits(self->level);
    to[LODE_SCOPE_AT_EVENT] = 0u;
    for (uint16_t n = 0u; n < self->channels.count; n++) {
        to[LODE_SCOPE_AT_CHANNEL + n] = self->channels.channel[n];
    }
}

lode_status_t lode_scope_init(lode_scope_t *self, const lode_scope_config_t *config,
                              uint32_t *buffer, uint32_t words) {
    if (self == NULL || config == NULL || buffer == NULL) {
        return LODE_ERROR_NULL;
    }
    lode_scope_t scope = {.buffer = buffer};
    lode_status_t status = lode_channels_init(&scope.channels, &config->rows);
    if (status != LODE_OK) {
        return status;
    }
    const uint32_t count = scope.channels.count;
    if (words < (uint32_t)LODE_SCOPE_WORDS(count, 2u)) {
        return LODE_ERROR_BUFFER;
    }
    status = take_trigger(&scope, config);
    if (status != LODE_OK) {
        return status;
    }
    if (!lode_in_range(config->pre_share, 0.0f, 1.0f)) {
        return LODE_ERROR_PRE_SHARE;
    }
    scope.row = &buffer[LODE_SCOPE_AT_CHANNEL + count];
    const uint32_t rows = (words - LODE_SCOPE_AT_CHANNEL - count) / count;
    scope.rows = rows < ROWS_MAX ? rows : ROWS_MAX;
    const uint32_t others = scope.rows - 1u; // all but the event's own row
    const float before = config->pre_share * (float)others + 0.5f;
    scope.rows_after = scope.rows - (uint32_t)before;
    write_header(&scope, config->rows.f_pwm_Hz);
    *self = scope;
    return LODE_OK;
}

static void set_state(lode_scope_t *self, lode_scope_state_t state) {
    self->buffer[LODE_SCOPE_AT_STATE] = (uint32_t)state;
    LODE_SIGNAL_FENCE(); // all rows are written before the thread sees the state
    self->state = (uint_least8_t)state;
}

static void take_request(lode_scope_t *self) {
    if (self->request == (uint_least8_t)REQUEST_ARM) {
        self->filled = 0u;
        self->next = 0u;
        self->channels.wait = 0u; // this period writes a row, and with it the header
        self->primed = false;
        self->event = false;
        set_state(self, LODE_SCOPE_ARMED);
    } else {
        set_state(self, LODE_SCOPE_IDLE);
    }
    self->request = (uint_least8_t)REQUEST_NONE;
}

static bool sees_event(lode_scope_t *self, const lode_drive_t *drive) {
    const float value = lode_channel_read(drive, self->source);
    const float before = self->before;
    const bool primed = self->primed;
    self->before = value;
    self->primed = true;
    if (self->trigger == LODE_TRIGGER_IMMEDIATE) {
        return true;
    }
    if (self->trigger == LODE_TRIGGER_FALLING) {
        return primed && before > self->level && value <= self->level;
    }
    return primed && before < self->level && value >= self->level;
}

static void write_row(lode_scope_t *self, const lode_drive_t *drive) {
    const uint32_t at = self->next;
    lode_channels_row(&self->channels, drive, &self->row[at * self->channels.count]);
    self->filled += self->filled < self->rows ? 1u : 0u;
    self->next = at + 1u < self->rows ? at + 1u : 0u;
    self->buffer[LODE_SCOPE_AT_FILLED] = self->filled;
    self->buffer[LODE_SCOPE_AT_NEXT] = self->next;
    self->buffer[LODE_SCOPE_AT_PERIOD] = self->periods;
    if (self->state == (uint_least8_t)LODE_SCOPE_ARMED && self->event) {
        self->buffer[LODE_SCOPE_AT_EVENT] = at;
        self->left = self->rows_after;
        set_state(self, LODE_SCOPE_TRIGGERED);
    }
    if (self->state == (uint_least8_t)LODE_SCOPE_TRIGGERED) {
        self->left--;
        if (self->left == 0u) {
            set_state(self, LODE_SCOPE_DONE);
        }
    }
}

LODE_RAMFUNC void lode_scope_step(lode_scope_t *self, const lode_drive_t *drive) {
    if (self->request != (uint_least8_t)REQUEST_NONE) {
        take_request(self);
    }
    const bool armed = self->state == (uint_least8_t)LODE_SCOPE_ARMED;
    if (armed || self->state == (uint_least8_t)LODE_SCOPE_TRIGGERED) {
        if (armed && !self->event) {
            self->event = sees_event(self, drive);
        }
        if (lode_channels_due(&self->channels)) {
            write_row(self, drive);
        }
    }
    self->periods++;
}

void lode_scope_arm(lode_scope_t *self) {
    self->sent = 0u;
    self->wire.left = 0u;
    LODE_SIGNAL_FENCE();
    self->request = (uint_least8_t)REQUEST_ARM;
    LODE_SIGNAL_FENCE();
}

void lode_scope_stop(lode_scope_t *self) {
    LODE_SIGNAL_FENCE();
    self->request = (uint_least8_t)REQUEST_STOP;
    LODE_SIGNAL_FENCE();
}

lode_scope_state_t lode_scope_state(const lode_scope_t *self) {
    LODE_SIGNAL_FENCE();
    const uint_least8_t request = self->request;
    LODE_SIGNAL_FENCE();
    switch (request) {
    case REQUEST_ARM:
        return LODE_SCOPE_ARMED;
    case REQUEST_STOP:
        return LODE_SCOPE_IDLE;
    default:
        return (lode_scope_state_t)self->state;
    }
}

static bool next_word(lode_scope_t *self) {
    const uint32_t words = LODE_SCOPE_WORDS(self->channels.count, self->rows);
    const uint32_t at = self->sent;
    if (at > words) {
        return false;
    }
    if (at == 0u) {
        self->wire.crc = LODE_CRC_START;
    }
    uint32_t word = at == words ? ~self->wire.crc : self->buffer[at];
    if (at == LODE_SCOPE_AT_STATE) {
        word |= LODE_SCOPE_CHECKED;
    }
    lode_wire_load(&self->wire, word);
    self->sent++;
    return true;
}

uint32_t lode_scope_drain(lode_scope_t *self, uint16_t *octets, uint32_t count) {
    if (lode_scope_state(self) != LODE_SCOPE_DONE) {
        return 0u;
    }
    uint32_t n = 0u;
    while (n < count && (self->wire.left > 0u || next_word(self))) {
        octets[n++] = lode_wire_octet(&self->wire);
    }
    if (n == 0u && count > 0u) {
        self->sent = 0u; // the end was reported: start again
    }
    return n;
}
