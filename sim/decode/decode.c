#include "decode/decode.h"

#include <stdlib.h>

#include "decode/frames.h"
#include "decode/image.h"

/// True for a buffer with the magic word and a plausible header. Sets the order of the octets.
static bool find_image(decode_source_t *source, uint32_t magic, size_t *offset) {
    for (size_t at = 0; at + 12 <= source->size; ++at) {
        for (source->order = 0; source->order < DECODE_ORDERS; ++source->order) {
            if (decode_word(source, at) == magic && decode_word(source, at + 4) - 1u < 255u &&
                decode_word(source, at + 8) - 1u < LODE_CHANNELS_MAX) {
                *offset = at;
                return true;
            }
        }
    }
    source->order = 0;
    return false;
}

static bool parse(decode_t *self, decode_source_t *source, decode_want_t want) {
    size_t offset = 0;
    if (want != DECODE_WANT_RING && find_image(source, LODE_SCOPE_MAGIC, &offset)) {
        return decode_scope_image(self, source, offset);
    }
    if (want == DECODE_WANT_SCOPE) {
        return decode_refuse(self, 0,
                             "no scope in %zu octets; expected a dump of its buffer, beginning "
                             "with \"LoSc\", or the octets of lode_scope_drain()",
                             source->size);
    }
    if (find_image(source, LODE_RING_MAGIC, &offset)) {
        return decode_ring_image(self, source, offset);
    }
    return decode_frames(self, source);
}

bool decode_parse(decode_t *self, const unsigned char *data, size_t size, decode_want_t want) {
    decode_source_t source = {data, size, 0};
    *self = (decode_t){0};
    // Every value of every row is a word of its own in the file.
    self->t_s = calloc(size / 4 + 1, sizeof self->t_s[0]);
    self->number = calloc(size / 4 + 1, sizeof self->number[0]);
    self->value = calloc(size / 4 + 1, sizeof self->value[0]);
    if (self->t_s == NULL || self->number == NULL || self->value == NULL) {
        decode_free(self);
        return decode_refuse(self, 0, "out of memory for %zu octets", size);
    }
    if (!parse(self, &source, want)) {
        decode_free(self);
        return false;
    }
    self->order = source.order;
    return true;
}
