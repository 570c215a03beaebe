/// Telemetry ring: frames of selected channels from the interrupt to one thread, which sends them.
///
/// Interrupt: lode_ring_step() after lode_drive_step(). It never waits; if the ring is full the frame
///            is dropped and counted as an overrun.
/// Thread:    lode_ring_drain() gives octets for a UART. One thread on the same core, which the interrupt
///            may preempt but which never preempts it.
///
/// Layout in memory and on the wire, version 1: docs/telemetry.md. Nothing in it depends on the size of
/// a char or on the order of octets of the machine.
#ifndef LODESTAR_RING_H
#define LODESTAR_RING_H

#include "lodestar/channel.h"
#include "lodestar/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LODE_RING_MAGIC 0x69526F4Cu ///< "LoRi" where the lowest octet comes first
#define LODE_RING_VERSION 1u

/// Words at the beginning of the buffer, by index. Slots of 1 + channels words follow, each with a
/// sequence number and the row.
enum {
    LODE_RING_AT_MAGIC,
    LODE_RING_AT_VERSION,
    LODE_RING_AT_CHANNELS,   ///< in a row
    LODE_RING_AT_SLOTS,      ///< frames that the buffer holds
    LODE_RING_AT_F_PWM,      ///< Hz, bits of a float
    LODE_RING_AT_DECIMATION, ///< periods from one frame to the next
    LODE_RING_AT_WRITTEN,    ///< frames written since init, modulo 2^32
    LODE_RING_AT_OVERRUNS,   ///< frames dropped since init, modulo 2^32
    LODE_RING_AT_CHANNEL     ///< lode_channel_t of the first one; the others follow
};

/// Words of buffer for `slots` frames of `channels` channels: enough for the longest time
/// between two calls of lode_ring_drain().
#define LODE_RING_WORDS(channels, slots)                                                           \
    ((uint32_t)LODE_RING_AT_CHANNEL + (uint32_t)(channels) +                                       \
     (uint32_t)(slots) * (1u + (uint32_t)(channels)))

/// On the wire every frame begins with this octet; the next one is what follows below.
#define LODE_RING_SYNC 0xA5u
#define LODE_RING_DATA 0x20u        ///< version 1 in bits 5 and 6, words of payload in bits 0 .. 4
#define LODE_RING_DESCRIPTION 0xA0u ///< the same, with bit 7
/// Words of a description before the channels: f_pwm_Hz, decimation, sequence number of the next data
/// frame (all 32 bits), overruns.
#define LODE_RING_DESCRIPTION_WORDS 4u
/// A description goes before the first data frame and then before every so many.
#define LODE_RING_DESCRIBE_EVERY 64u

/// Visible for static allocation; written by its functions only.
typedef struct {
    // Since init.
    uint32_t *buffer;
    uint32_t *slot; ///< the first one
    uint32_t end;   ///< words of all slots
    uint32_t slots;
    // Of the interrupt.
    lode_channels_t channels;
    uint32_t sequence; ///< of the next frame, dropped or not
    uint32_t written;
    uint32_t write_at; ///< word of the next slot
    uint32_t overruns;
    // Of the thread.
    uint32_t read;
    uint32_t read_at;
    lode_wire_t wire;
    uint16_t at;   ///< next word of the frame under way
    uint16_t size; ///< its words with header and check
    bool describing;
    uint16_t until_description; ///< data frames
} lode_ring_t;

/// Takes `words` words at `buffer`, which belong to the ring from then on: at least those of two frames.
/// Errors: NULL, F_PWM, CHANNELS, BUFFER; `self` and the buffer are unchanged. Not while the interrupt
/// steps it.
lode_status_t lode_ring_init(lode_ring_t *self, const lode_channels_config_t *config,
                             uint32_t *buffer, uint32_t words);

/// One period, in bounded time. Its cost: docs/telemetry.md.
void lode_ring_step(lode_ring_t *self, const lode_drive_t *drive);

/// Up to `count` octets, values 0 .. 255, one per element (C28x has no 8-bit type); returns how many.
/// 0: nothing to send. A frame may be cut anywhere; the next call continues.
uint32_t lode_ring_drain(lode_ring_t *self, uint16_t *octets, uint32_t count);

/// Frames dropped since init, because the thread did not keep up.
uint32_t lode_ring_overruns(const lode_ring_t *self);

#ifdef __cplusplus
}
#endif

#endif
