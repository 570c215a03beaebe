// Dumps of a recorder's buffer.
#include "decode/image.h"

#include <string.h>

/// True if the file has `words` words from `offset` on.
static bool has_words(decode_t *self, const decode_source_t *source, size_t offset,
                      uint64_t words) {
    if (words <= (source->size - offset) / 4) {
        return true;
    }
    return decode_refuse(self, source->size,
                         "the file ends; expected %llu octets from offset %zu on",
                         4ull * (unsigned long long)words, offset);
}

/// True if the header without the channels is complete, the version is 1 and the channels are possible.
static bool take_header(decode_t *self, const decode_source_t *source, size_t offset,
                        uint32_t words) {
    if (!has_words(self, source, offset, words)) {
        return false;
    }
    const uint32_t version = decode_word(source, offset + 4 * LODE_RING_AT_VERSION);
    if (version != LODE_RING_VERSION) {
        return decode_refuse(self, offset + 4 * LODE_RING_AT_VERSION,
                             "a buffer of version %lu; expected 1", (unsigned long)version);
    }
    self->before = offset;
    self->channels = decode_word(source, offset + 4 * LODE_RING_AT_CHANNELS);
    return has_words(self, source, offset, (uint64_t)words + self->channels) &&
           decode_setup(self, source, offset + 4 * LODE_RING_AT_F_PWM,
                        offset + 4 * LODE_RING_AT_DECIMATION, offset + 4 * (size_t)words);
}

// ---- Ring ---------------------------------------------------------------------------------------

bool decode_ring_image(decode_t *self, const decode_source_t *source, size_t offset) {
    self->kind = DECODE_RING;
    if (!take_header(self, source, offset, LODE_RING_AT_CHANNEL)) {
        return false;
    }
    const size_t slots_at = offset + 4 * LODE_RING_AT_SLOTS;
    const uint32_t slots = decode_word(source, slots_at);
    const uint32_t written = decode_word(source, offset + 4 * LODE_RING_AT_WRITTEN);
    const size_t slot_octets = 4 * (1 + (size_t)self->channels);
    const size_t first = offset + 4 * (LODE_RING_AT_CHANNEL + (size_t)self->channels);
    if (slots < 2u || written == 0u) {
        return decode_refuse(self, slots_at,
                             "%lu frames, %lu written; expected a ring of at least "
                             "2 that has been written to",
                             (unsigned long)slots, (unsigned long)written);
    }
    if (!has_words(self, source, first, (uint64_t)slots * (1 + (uint64_t)self->channels))) {
        return false;
    }
    self->overruns = decode_word(source, offset + 4 * LODE_RING_AT_OVERRUNS);
    const uint32_t used = written < slots ? written : slots;
    uint32_t oldest = 0;
    for (uint32_t k = 1; k < used; ++k) {
        const uint32_t ahead = decode_word(source, first + k * slot_octets) -
                               decode_word(source, first + oldest * slot_octets);
        oldest = ahead > INT32_MAX ? k : oldest;
    }
    uint32_t next = decode_word(source, first + oldest * slot_octets);
    for (uint32_t k = 0; k < used; ++k) {
        const size_t at = first + (oldest + (size_t)k) % used * slot_octets;
        const uint32_t number = decode_word(source, at);
        if (number - next > INT32_MAX) {
            return decode_refuse(self, at, "frame number %lu; expected at least %lu",
                                 (unsigned long)number, (unsigned long)next);
        }
        if (number != next) {
            decode_note_gap(self, at, number - next);
        }
        next = number + 1u;
        decode_add_row(self, source, at + 4, number,
                       (double)number * (double)self->decimation / self->f_pwm_Hz);
    }
    return true;
}

// ---- Scope --------------------------------------------------------------------------------------

typedef struct {
    uint32_t rows, filled, next, event;
    size_t first; ///< octet of the first row
} scope_t;

/// A number of the header that must be less than `limit`.
static bool limited(decode_t *self, const decode_source_t *source, size_t at, const char *what,
                    uint32_t limit, uint32_t *value) {
    *value = decode_word(source, at);
    return *value < limit || decode_refuse(self, at, "%s %lu; expected at most %lu", what,
                                           (unsigned long)*value, (unsigned long)limit - 1);
}

static bool take_state(decode_t *self, const decode_source_t *source, size_t offset,
                       scope_t *scope) {
    const size_t state_at = offset + 4 * LODE_SCOPE_AT_STATE;
    const uint32_t word = decode_word(source, state_at);
    self->checked = (word & LODE_SCOPE_CHECKED) != 0;
    self->state = word & ~LODE_SCOPE_CHECKED;
    if (self->state > (uint32_t)LODE_SCOPE_DONE) {
        return decode_refuse(self, state_at, "state %lu; expected 0 .. 3",
                             (unsigned long)self->state);
    }
    self->level = decode_float(decode_word(source, offset + 4 * LODE_SCOPE_AT_LEVEL));
    self->source = decode_word(source, offset + 4 * LODE_SCOPE_AT_SOURCE);
    if (!limited(self, source, offset + 4 * LODE_SCOPE_AT_TRIGGER, "trigger", 4u, &self->trigger) ||
        !limited(self, source, offset + 4 * LODE_SCOPE_AT_FILLED, "rows written", scope->rows + 1u,
                 &scope->filled) ||
        !limited(self, source, offset + 4 * LODE_SCOPE_AT_NEXT, "next row", scope->rows,
                 &scope->next)) {
        return false;
    }
    if (scope->filled == 0u) {
        return decode_refuse(self, offset + 4 * LODE_SCOPE_AT_FILLED,
                             "no row was written; expected a scope that had been armed");
    }
    self->has_event = self->state >= (uint32_t)LODE_SCOPE_TRIGGERED;
    return !self->has_event || limited(self, source, offset + 4 * LODE_SCOPE_AT_EVENT,
                                       "row of the event", scope->filled, &scope->event);
}

/// The CRC-32 over all words before it, the lowest octet first.
static bool check(decode_t *self, const decode_source_t *source, size_t offset, size_t end) {
    if (!self->checked) {
        return true;
    }
    if (source->size - end < 4) {
        return decode_refuse(self, source->size, "the file ends; expected a CRC-32 at offset %zu",
                             end);
    }
    uint32_t crc = LODE_CRC_START;
    for (size_t at = offset; at < end; at += 4) {
        const uint32_t word = decode_word(source, at);
        for (int k = 0; k < 32; k += 8) {
            crc = lode_crc_octet(crc, (uint16_t)(word >> k & 0xFFu));
        }
    }
    const uint32_t found = decode_word(source, end);
    if (found != ~crc) {
        return decode_refuse(self, end,
                             "CRC-32 %08lx; expected %08lx: an octet from %zu on was changed or "
                             "lost on the way",
                             (unsigned long)found, (unsigned long)(uint32_t)~crc, offset);
    }
    return true;
}

static void take_rows(decode_t *self, const decode_source_t *source, size_t offset,
                      const scope_t *scope) {
    const uint32_t newest = decode_word(source, offset + 4 * LODE_SCOPE_AT_PERIOD);
    const uint32_t oldest = scope->filled < scope->rows ? 0u : scope->next;
    for (uint32_t k = 0; k < scope->filled; ++k) {
        const uint32_t row = (uint32_t)(((uint64_t)oldest + k) % scope->rows);
        const uint32_t back = (scope->filled - 1u - k) * self->decimation;
        if (self->has_event && row == scope->event) {
            self->event = k;
        }
        decode_add_row(self, source, scope->first + 4 * (size_t)row * self->channels, newest - back,
                       (double)(newest - back) / self->f_pwm_Hz);
    }
}

bool decode_scope_image(decode_t *self, const decode_source_t *source, size_t offset) {
    scope_t scope = {0};
    self->kind = DECODE_SCOPE;
    if (!take_header(self, source, offset, LODE_SCOPE_AT_CHANNEL)) {
        return false;
    }
    scope.rows = decode_word(source, offset + 4 * LODE_SCOPE_AT_ROWS);
    scope.first = offset + 4 * (LODE_SCOPE_AT_CHANNEL + (size_t)self->channels);
    if (scope.rows < 2u || scope.rows == UINT32_MAX) {
        return decode_refuse(self, offset + 4 * LODE_SCOPE_AT_ROWS, "%lu rows; expected at least 2",
                             (unsigned long)scope.rows);
    }
    if (!has_words(self, source, scope.first, (uint64_t)scope.rows * self->channels)) {
        return false;
    }
    const size_t end = scope.first + 4 * (size_t)scope.rows * self->channels;
    if (!take_state(self, source, offset, &scope) || !check(self, source, offset, end)) {
        return false;
    }
    take_rows(self, source, offset, &scope);
    return true;
}
