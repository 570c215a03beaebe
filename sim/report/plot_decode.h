/// The picture of a recording: one panel per unit, over time.
#ifndef RIG_PLOT_DECODE_H
#define RIG_PLOT_DECODE_H

#include "decode/decode.h"
#include "support/plot.h"

/// False after a message.
bool plot_decode(const plot_output_t *output, const char *title, const decode_t *decoded);

#endif
