/// Received frames.
#ifndef RIG_DECODE_FRAMES_H
#define RIG_DECODE_FRAMES_H

#include "decode/parsed.h"

/// Frames of version 1, wherever they begin.
bool decode_frames(decode_t *self, const decode_source_t *source);

#endif
