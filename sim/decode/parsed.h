/// The contents of a recorder's octets, and functions that add to them.
#ifndef RIG_DECODE_PARSED_H
#define RIG_DECODE_PARSED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "support/diag.h"

#include "lodestar/ring.h"
#include "lodestar/scope.h"

typedef enum {
    DECODE_FRAMES, ///< octets of lode_ring_drain()
    DECODE_RING,   ///< dump of a ring's buffer
    DECODE_SCOPE   ///< dump of a scope's buffer, or octets of lode_scope_drain()
} decode_kind_t;

typedef enum { DECODE_WANT_ANY, DECODE_WANT_RING, DECODE_WANT_SCOPE } decode_want_t;

enum { DECODE_PLACES_MAX = 20, DECODE_MESSAGE_LENGTH = 200 };

/// A gap.
typedef struct {
    size_t offset; ///< in the file, of the next row
    size_t row;    ///< the next row
    uint32_t lost; ///< rows
} decode_gap_t;

/// Octets that cannot be read.
typedef struct {
    size_t offset, octets;
} decode_damage_t;

typedef struct {
    decode_kind_t kind;
    int order; ///< of the octets in a word, index for decode_order_name()
    uint32_t channels;
    uint32_t channel[LODE_CHANNELS_MAX]; ///< numbers; a newer library may have more of them
    double f_pwm_Hz;
    uint32_t decimation;
    size_t rows;
    double *t_s;      ///< since the recorder's init
    uint32_t *number; ///< of the frame; scope: of the period
    float *value;     ///< rows x channels
    size_t before;    ///< octets before the first frame, or before the buffer
    size_t after;     ///< octets after the last frame: a frame that is cut off
    // Frames.
    uint32_t overruns;  ///< last number reported by the drive
    size_t undescribed; ///< frames before the first description
    size_t restarts;    ///< of the drive
    uint64_t lost;      ///< frames
    size_t gaps;        ///< places; the first ones in gap[]
    decode_gap_t gap[DECODE_PLACES_MAX];
    size_t damaged; ///< places; the first ones in damage[]
    decode_damage_t damage[DECODE_PLACES_MAX];
    // Scope.
    uint32_t state;   ///< lode_scope_state_t
    uint32_t trigger; ///< lode_trigger_t
    uint32_t source;
    float level;
    bool checked;   ///< its CRC-32 is present and correct
    bool has_event; ///< `event` is the row of it
    size_t event;
    // A refusal: the place, and the expectation in words.
    size_t offset;
    char message[DECODE_MESSAGE_LENGTH];
} decode_t;

void decode_free(decode_t *self);

/// Known orders of the octets in a word.
enum { DECODE_ORDERS = 4 };

const char *decode_order_name(int order);

// ---- For the readers ---------------------------------------------------------------------------

/// The octets of a file with the order of those in a word.
typedef struct {
    const unsigned char *data;
    size_t size;
    int order;
} decode_source_t;

/// The word at `offset`, which lies at least 4 octets before the end.
uint32_t decode_word(const decode_source_t *source, size_t offset);

float decode_float(uint32_t bits);

/// Notes the refusal; returns false.
bool decode_refuse(decode_t *self, size_t offset, const char *format, ...) RIG_PRINTF(3, 4);

/// Reads rate, decimation and channels from the words at these offsets; refuses impossible values.
bool decode_setup(decode_t *self, const decode_source_t *source, size_t f_pwm_at,
                  size_t decimation_at, size_t channels_at);

/// Adds a row whose words begin at `offset`.
void decode_add_row(decode_t *self, const decode_source_t *source, size_t offset, uint32_t number,
                    double t_s);

void decode_note_gap(decode_t *self, size_t offset, uint32_t lost);

#endif
