/// Scope: rows of selected channels around an event, taken by the interrupt, once.
///
/// Interrupt: lode_scope_step() after lode_drive_step().
/// Thread:    lode_scope_arm(), lode_scope_stop(), lode_scope_state(), and in state DONE
///            lode_scope_drain(). One thread on the same core, which the interrupt may preempt but
///            which never preempts it. Or a debugger that dumps the buffer, in any state.
///
/// Layout of the buffer, version 1: docs/telemetry.md. Nothing in it depends on the size of a char or
/// on the order of octets of the machine.
#ifndef LODESTAR_SCOPE_H
#define LODESTAR_SCOPE_H

#include "lodestar/channel.h"
#include "lodestar/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LODE_SCOPE_MAGIC 0x63536F4Cu ///< "LoSc" where the lowest octet comes first
#define LODE_SCOPE_VERSION 1u

/// Words at the beginning of the buffer, by index. The rows follow, one word per channel.
enum {
    LODE_SCOPE_AT_MAGIC,
    LODE_SCOPE_AT_VERSION,
    LODE_SCOPE_AT_CHANNELS,   ///< in a row
    LODE_SCOPE_AT_ROWS,       ///< that the buffer holds
    LODE_SCOPE_AT_F_PWM,      ///< Hz, bits of a float
    LODE_SCOPE_AT_DECIMATION, ///< periods from one row to the next
    LODE_SCOPE_AT_STATE,      ///< lode_scope_state_t; LODE_SCOPE_CHECKED added on the wire
    LODE_SCOPE_AT_FILLED,     ///< rows written since it was armed, at most those it holds
    LODE_SCOPE_AT_NEXT,       ///< index of the row that is written next: with all filled the oldest
    LODE_SCOPE_AT_PERIOD,     ///< of the newest row: calls since init before it, modulo 2^32
    LODE_SCOPE_AT_TRIGGER,    ///< lode_trigger_t
    LODE_SCOPE_AT_SOURCE,     ///< lode_channel_t that the trigger watches
    LODE_SCOPE_AT_LEVEL,      ///< bits of a float
    LODE_SCOPE_AT_EVENT,      ///< index of the first row after the event; from TRIGGERED on
    LODE_SCOPE_AT_CHANNEL     ///< lode_channel_t of the first one; the others follow
};

/// Words of buffer for `rows` rows of `channels` channels.
#define LODE_SCOPE_WORDS(channels, rows)                                                           \
    ((uint32_t)LODE_SCOPE_AT_CHANNEL + (uint32_t)(channels) +                                      \
     (uint32_t)(rows) * (uint32_t)(channels))

/// In the word of the state, on the wire: after the last row follows the CRC-32 over all before it.
#define LODE_SCOPE_CHECKED 0x100u

typedef enum {
    LODE_SCOPE_IDLE,
    LODE_SCOPE_ARMED,     ///< rows are written cyclically, the trigger is watched
    LODE_SCOPE_TRIGGERED, ///< the rows after the event are being written
    LODE_SCOPE_DONE       ///< nothing is written until it is armed again
} lode_scope_state_t;

/// Watched in every period, also in those without a row.
typedef enum {
    LODE_TRIGGER_IMMEDIATE, ///< with the first period
    LODE_TRIGGER_RISING,    ///< the channel comes from below the level
    LODE_TRIGGER_FALLING,   ///< the channel comes from above the level
    LODE_TRIGGER_FAULT      ///< a fault is latched that was not before
} lode_trigger_t;

typedef struct {
    lode_channels_config_t rows;
    lode_trigger_t trigger;
    lode_channel_t source; ///< RISING, FALLING: channel, which need not be one of the rows
    float level;           ///< RISING, FALLING: in the channel's unit
    float pre_share;       ///< rows before the event, as a share of all others, 0 .. 1
} lode_scope_config_t;

/// Visible for static allocation; written by its functions only.
typedef struct {
    // Since init.
    uint32_t *buffer;
    uint32_t *row; ///< the first one
    uint32_t rows;
    uint32_t rows_after; ///< from the event on
    lode_trigger_t trigger;
    lode_channel_t source;
    float level;
    // Of the interrupt.
    lode_channels_t channels;
    uint_least8_t state; ///< lode_scope_state_t
    bool primed;         ///< `before` holds the last period's value
    bool event;          ///< has been seen
    float before;
    uint32_t periods; ///< calls since init
    uint32_t filled;
    uint32_t next;
    uint32_t left; ///< rows still to come, once triggered
    // Mailbox.
    uint_least8_t request;
    // Of the thread.
    lode_wire_t wire;
    uint32_t sent; ///< words
} lode_scope_t;

/// Takes `words` words at `buffer`, which belong to the scope from then on: at least those of two rows.
/// State IDLE. Errors: NULL, F_PWM, CHANNELS, BUFFER, TRIGGER, PRE_SHARE; `self` and the buffer are
/// unchanged. May be called again in IDLE and DONE.
lode_status_t lode_scope_init(lode_scope_t *self, const lode_scope_config_t *config,
                              uint32_t *buffer, uint32_t words);

/// One period, in bounded time. Its cost: docs/telemetry.md.
void lode_scope_step(lode_scope_t *self, const lode_drive_t *drive);

/// Restarts with the next period, in any state.
void lode_scope_arm(lode_scope_t *self);

/// From the next period on: IDLE. The buffer is kept.
void lode_scope_stop(lode_scope_t *self);

lode_scope_state_t lode_scope_state(const lode_scope_t *self);

/// In DONE: up to `count` octets of the buffer and a check, values 0 .. 255, one per element; returns
/// how many. The next call continues; at the end comes one 0, and then the same again. In any other
/// state 0.
uint32_t lode_scope_drain(lode_scope_t *self, uint16_t *octets, uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
