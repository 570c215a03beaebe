/// Reads what the library's recorders wrote: frames of a ring as they came over a wire, or a dump of a
/// ring's or a scope's buffer. Pure: octets in, rows out. Layouts: docs/telemetry.md.
#ifndef RIG_DECODE_H
#define RIG_DECODE_H

#include "decode/parsed.h"

/// False with `offset` and `message` where the octets cannot be read; nothing needs to be freed then.
/// Frames that are damaged or missing are no reason to refuse: they are counted.
bool decode_parse(decode_t *self, const unsigned char *data, size_t size, decode_want_t want);

#endif
