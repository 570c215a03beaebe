/// Scope: the interrupt records rows of selected channels around one event.
///
/// Interrupt: lode_scope_step() after lode_drive_step().
/// Main loop: lode_scope_arm(), lode_scope_stop(), lode_scope_state(), and in state DONE lode_scope_drain(). From ONE thread
///            on the same core, which the interrupt may interrupt and which never interrupts the interrupt. Or a debugger
///            dumps the buffer, in any state.
///
/// Layout of the buffer, version 1: docs/telemetry.md. It does not depend on the machine's char size or byte order.
#ifndef LODESTAR_SCOPE_H
#define LODESTAR_SCOPE_H

#include "lodestar/channel.h"
#include "lodestar/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LODE_SCOPE_MAGIC 0x63536F4Cu ///< "LoSc" with the lowest octet first
#define LODE_SCOPE_VERSION 1u

/// Index of the words at the beginning of the buffer. The rows follow, one word per channel.
enum {
    LODE_SCOPE_AT_MAGIC,
    LODE_SCOPE_AT_VERSION,
    LODE_SCOPE_AT_CHANNELS,   ///< number of channels in a row
    LODE_SCOPE_AT_ROWS,       ///< number of rows that the buffer holds
    LODE_SCOPE_AT_F_PWM,      ///< rate of the step, Hz, as the bits of a float
    LODE_SCOPE_AT_DECIMATION, ///< control periods per row
    LODE_SCOPE_AT_STATE,      ///< lode_scope_state_t; LODE_SCOPE_CHECKED added on the wire
    LODE_SCOPE_AT_FILLED, ///< rows written since the scope was armed, at most the number of rows
    LODE_SCOPE_AT_NEXT, ///< index of the next row to be written; if all are filled, that of the oldest one
    LODE_SCOPE_AT_PERIOD,  ///< number of calls between init and the newest row, modulo 2^32
    LODE_SCOPE_AT_TRIGGER, ///< lode_trigger_t
    LODE_SCOPE_AT_SOURCE,  ///< lode_channel_t that the trigger watches
    LODE_SCOPE_AT_LEVEL,   ///< bits of a float
    LODE_SCOPE_AT_EVENT,   ///< index of the first row after the event; from TRIGGERED on
    LODE_SCOPE_AT_CHANNEL  ///< lode_channel_t of the first channel; the others follow
};

/// Buffer size in words for `rows` rows of `channels` channels.
#define LODE_SCOPE_WORDS(channels, rows)                                                           \
    ((uint32_t)LODE_SCOPE_AT_CHANNEL + (uint32_t)(channels) +                                      \
     (uint32_t)(rows) * (uint32_t)(channels))

/// Bit of the state word on the wire: after the last row comes the CRC-32 over everything before it.
#define LODE_SCOPE_CHECKED 0x100u

/// State of the scope.
typedef enum {
    LODE_SCOPE_IDLE,
    LODE_SCOPE_ARMED,     ///< rows are written in a circle, the trigger is monitored
    LODE_SCOPE_TRIGGERED, ///< the rows after the event are written
    LODE_SCOPE_DONE       ///< nothing is written until the scope is armed again
} lode_scope_state_t;

/// Trigger. It is monitored in every control period, including those without a row.
typedef enum {
    LODE_TRIGGER_IMMEDIATE, ///< the first period
    LODE_TRIGGER_RISING,    ///< the channel was below the level and is not any more
    LODE_TRIGGER_FALLING,   ///< the channel was above the level and is not any more
    LODE_TRIGGER_FAULT      ///< a fault is latched; not one that was latched before
} lode_trigger_t;

/// Configuration of a recording.
typedef struct {
    lode_channels_config_t rows;
    lode_trigger_t trigger;
    lode_channel_t source; ///< RISING, FALLING: monitored channel; it need not be recorded
    float level;           ///< RISING, FALLING: in the unit of the channel
    float pre_share;       ///< rows before the event as a share of all other rows, 0 .. 1
} lode_scope_config_t;

/// The members are visible for static allocation; only the functions below write them.
typedef struct {
    // Set by lode_scope_init().
    uint32_t *buffer;
    uint32_t *row; ///< the first one
    uint32_t rows;
    uint32_t rows_after; ///< from the event on
    lode_trigger_t trigger;
    lode_channel_t source;
    float level;
    // Written by the interrupt.
    lode_channels_t channels;
    uint_least8_t state; ///< lode_scope_state_t
    bool primed;         ///< `before` holds the last period's value
    bool event;          ///< the event has occurred
    float before;
    uint32_t periods; ///< calls since init
    uint32_t filled;
    uint32_t next;
    uint32_t left; ///< TRIGGERED: rows still to be written
    // Mailbox.
    uint_least8_t request;
    // Written by the thread.
    lode_wire_t wire;
    uint32_t sent; ///< words that lode_scope_drain() has delivered
} lode_scope_t;

/// Takes `words` words at `buffer`, which belong to the scope from then on; at least two rows must fit. State:
/// IDLE. Errors: NULL, F_PWM, CHANNELS, BUFFER, TRIGGER, PRE_SHARE; `self` and the buffer are then left alone. May
/// be called again in IDLE and DONE.
lode_status_t lode_scope_init(lode_scope_t *self, const lode_scope_config_t *config,
                              uint32_t *buffer, uint32_t words);

/// One control period, in bounded time, from the interrupt. Cost: docs/telemetry.md.
void lode_scope_step(lode_scope_t *self, const lode_drive_t *drive);

/// Starts a new recording with the next control period, from any state.
void lode_scope_arm(lode_scope_t *self);

/// Goes to IDLE with the next control period. The content of the buffer remains.
void lode_scope_stop(lode_scope_t *self);

/// The present state.
lode_scope_state_t lode_scope_state(const lode_scope_t *self);

/// In DONE: writes up to `count` octets of the buffer and its CRC to `octets`, one value 0 .. 255 per element, and
/// returns how many. The next call continues. The end is reported by one 0; then the same data comes again. In any
/// other state: 0.
uint32_t lode_scope_drain(lode_scope_t *self, uint16_t *octets, uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
