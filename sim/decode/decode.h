/// Reads the output of the library's recorders: received frames of a ring, or a dump of a ring's or a scope's
/// buffer. No side effects: octets in, rows out. Layouts: docs/telemetry.md.
#ifndef RIG_DECODE_H
#define RIG_DECODE_H

#include "decode/parsed.h"

/// False with `offset` and `message` if the octets cannot be read; then nothing needs to be freed. Damaged or
/// missing frames are not refused but counted.
bool decode_parse(decode_t *self, const unsigned char *data, size_t size, decode_want_t want);

#endif
