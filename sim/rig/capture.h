/// The library's recorders with a simulated drive, used as in firmware; their octets go to files.
#ifndef RIG_CAPTURE_H
#define RIG_CAPTURE_H

#include <stdio.h>

#include "support/options.h"

#include "lodestar/ring.h"
#include "lodestar/scope.h"

enum { CAPTURE_RING_SLOTS = 64, CAPTURE_SCOPE_WORDS = 8192 };

typedef struct capture {
    FILE *ring_file; ///< NULL: not wanted
    FILE *scope_file;
    lode_ring_t ring;
    lode_scope_t scope;
    uint32_t ring_buffer[LODE_RING_WORDS(LODE_CHANNELS_MAX, CAPTURE_RING_SLOTS)];
    uint32_t scope_buffer[CAPTURE_SCOPE_WORDS];
} capture_t;

/// True if a recorder is wanted.
bool capture_wanted(const options_t *options);

/// Opens the files and arms the scope. False after a message.
bool capture_start(capture_t *self, const options_t *options, float f_pwm_Hz);

/// One period: first the interrupt's part after lode_drive_step(), then the thread's part.
void capture_step(capture_t *self, const lode_drive_t *drive);

/// Writes the rest of the ring, and the scope: as it is sent if it is complete, else as a dump.
void capture_finish(capture_t *self);

#endif
