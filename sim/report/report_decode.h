/// The contents of a recorder's octets: summary, CSV, JSON.
#ifndef RIG_REPORT_DECODE_H
#define RIG_REPORT_DECODE_H

#include <stdio.h>

#include "decode/decode.h"

void report_decode_table(FILE *file, const char *path, const decode_t *decoded);

/// frame or period, t_s, for a scope t_event_s (time since the event), then the channels.
void report_decode_csv(FILE *file, const decode_t *decoded);

void report_decode_json(FILE *file, const char *path, const decode_t *decoded);

#endif
