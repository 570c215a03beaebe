/// Dumps of a recorder's buffer.
#ifndef RIG_DECODE_IMAGE_H
#define RIG_DECODE_IMAGE_H

#include "decode/parsed.h"

/// The buffer that begins at `offset`.
bool decode_ring_image(decode_t *self, const decode_source_t *source, size_t offset);
bool decode_scope_image(decode_t *self, const decode_source_t *source, size_t offset);

#endif
