/// One run of a drive, replayed from its counts: the same on the host and on every target, to the bit.
#ifndef TARGET_REPLAY_H
#define TARGET_REPLAY_H

#include "lodestar/lodestar.h"

/// The drives that are replayed: as designed, and with every option that adds arithmetic.
#define REPLAY_CASES 2
/// 1.8 s: offsets, start, hand-over, ramp.
#define REPLAY_ROWS 9000

typedef struct {
    uint16_t i[3];
    uint16_t v_bus;
} replay_row_t;

/// Written by the recorder.
extern const replay_row_t replay_rows[REPLAY_CASES][REPLAY_ROWS];

/// A drive under way and what it has done.
typedef struct {
    lode_drive_t drive;
    lode_drive_tuning_t tuning;
    uint32_t periods;
    uint32_t running; ///< of them in RUN
    uint64_t digest;  ///< FNV-1a of outputs and telemetry of every period
} replay_t;

/// A drive of case `number`, commanded to run. `digest`: of the cases before, or REPLAY_DIGEST.
bool replay_begin(replay_t *self, int32_t number, uint64_t digest);
/// Offset basis of FNV-1a in 64 bits.
#define REPLAY_DIGEST 14695981039346656037u

/// One period.
lode_drive_out_t replay_step(replay_t *self, const replay_row_t *row);

/// All cases, from the recorded rows. `flip`: with the least bit of one current in one row the other way.
/// False: a drive refused its configuration or was not in RUN at its end.
bool replay_all(const replay_row_t rows[REPLAY_CASES][REPLAY_ROWS], bool flip, uint64_t *digest);

#endif
