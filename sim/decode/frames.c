// Received frames: some may be missing, damaged or cut off, with other octets in between.
#include "decode/frames.h"

#include <string.h>

/// Values of the octet after the sync octet.
enum { VERSION = 0x60, PAYLOAD = 0x1F };
enum {
    DESCRIBES = LODE_RING_DESCRIPTION & ~LODE_RING_DATA,
    SETTINGS = LODE_RING_DESCRIPTION_WORDS,
    WORDS_MAX = 2 + LODE_RING_DESCRIPTION_WORDS + LODE_CHANNELS_MAX,
    OCTETS_MAX = 4 * WORDS_MAX
};

typedef struct {
    decode_t *out;
    const decode_source_t *source;
    size_t first; ///< octet after the last frame
    bool any;     ///< frame found
    bool described;
    uint32_t next; ///< expected number of the next data frame
} reader_t;

static uint32_t crc_of(const unsigned char *data, size_t size) {
    uint32_t crc = LODE_CRC_START;
    for (size_t k = 0; k < size; ++k) {
        crc = lode_crc_octet(crc, data[k]);
    }
    return ~crc;
}

/// Length in words of the frame that begins at `at`; 0: no frame, or an incomplete one.
static size_t frame_at(const decode_source_t *source, size_t at) {
    const unsigned char *octet = source->data + at;
    if (source->size - at < 12 || octet[0] != LODE_RING_SYNC || (octet[1] & VERSION) == 0) {
        return 0;
    }
    const bool describes = (octet[1] & DESCRIBES) != 0;
    const int payload = octet[1] & PAYLOAD;
    const int channels = payload - (describes ? (int)SETTINGS : 0);
    const size_t words = (size_t)payload + 2;
    if (channels < 1 || channels > LODE_CHANNELS_MAX || source->size - at < 4 * words) {
        return 0;
    }
    const bool whole = crc_of(octet, 4 * words - 4) == decode_word(source, at + 4 * words - 4);
    return whole ? words : 0;
}

/// Handles the octets between the last frame and `at`.
static void note_damage(reader_t *self, size_t at) {
    decode_t *out = self->out;
    const size_t octets = at - self->first;
    if (octets == 0) {
        return;
    }
    // The recording began or ended within a frame.
    if (octets < OCTETS_MAX && !self->any) {
        out->before = octets;
    } else if (octets < OCTETS_MAX && at == self->source->size) {
        out->after = octets;
    } else {
        if (out->damaged < DECODE_PLACES_MAX) {
            out->damage[out->damaged] = (decode_damage_t){self->first, octets};
        }
        out->damaged++;
    }
}

static bool take_description(reader_t *self, size_t at, size_t words) {
    decode_t now = *self->out;
    decode_t *out = self->out;
    const uint32_t next = decode_word(self->source, at + 12);
    now.channels = (uint32_t)(words - 2 - SETTINGS);
    if (!decode_setup(&now, self->source, at + 4, at + 8, at + 20)) {
        *out = now;
        return false;
    }
    if (self->described &&
        (now.channels != out->channels || now.decimation != out->decimation ||
         memcmp(&now.f_pwm_Hz, &out->f_pwm_Hz, sizeof now.f_pwm_Hz) != 0 ||
         memcmp(now.channel, out->channel, now.channels * sizeof now.channel[0]) != 0)) {
        return decode_refuse(out, at,
                             "other channels, decimation or PWM rate than before; "
                             "expected one setting per file");
    }
    now.overruns = decode_word(self->source, at + 16);
    *out = now;
    // A step back in time means that the drive was restarted.
    const uint32_t ahead = next - self->next;
    if (self->described && ahead > INT32_MAX) {
        out->restarts++;
    } else if (self->described && ahead > 0u) {
        decode_note_gap(out, at, ahead);
    }
    self->described = true;
    self->next = next;
    return true;
}

static bool take_data(reader_t *self, size_t at, size_t words) {
    decode_t *out = self->out;
    if (!self->described) {
        out->undescribed++;
        return true;
    }
    if (words - 2 != out->channels) {
        return decode_refuse(out, at, "a frame of %zu channels; expected %lu as described before",
                             words - 2, (unsigned long)out->channels);
    }
    const uint32_t low = decode_word(self->source, at) >> 16;
    const uint32_t gap = (low - self->next) & UINT16_MAX;
    if (gap > 0u) {
        decode_note_gap(out, at, gap);
    }
    const uint32_t number = self->next + gap;
    self->next = number + 1u;
    decode_add_row(out, self->source, at + 4, number,
                   (double)number * (double)out->decimation / out->f_pwm_Hz);
    return true;
}

static bool take_frame(reader_t *self, size_t at, size_t words) {
    const unsigned kind = self->source->data[at + 1];
    if ((kind & VERSION) != LODE_RING_DATA) {
        return decode_refuse(self->out, at, "a frame of version %u; expected 1",
                             (kind & VERSION) / LODE_RING_DATA);
    }
    return (kind & DESCRIBES) != 0 ? take_description(self, at, words) : take_data(self, at, words);
}

bool decode_frames(decode_t *self, const decode_source_t *source) {
    reader_t reader = {.out = self, .source = source};
    self->kind = DECODE_FRAMES;
    size_t at = 0;
    while (at < source->size) {
        const size_t words = frame_at(source, at);
        if (words == 0) {
            ++at;
            continue;
        }
        note_damage(&reader, at);
        if (!take_frame(&reader, at, words)) {
            return false;
        }
        at += 4 * words;
        reader.first = at;
        reader.any = true;
    }
    if (!reader.any) {
        return decode_refuse(self, 0,
                             "no frame in %zu octets; expected those of lode_ring_drain(), or a "
                             "dump that begins with \"LoRi\" or \"LoSc\"",
                             source->size);
    }
    note_damage(&reader, source->size);
    if (self->rows == 0) {
        return decode_refuse(self, 0,
                             "%zu frames and no description before them; expected one at "
                             "least every %u frames",
                             self->undescribed, LODE_RING_DESCRIBE_EVERY);
    }
    return true;
}
