/// Telemetry ring: frames of selected channels from the interrupt to one thread, which sends them.
///
/// Interrupt: lode_ring_step() after lode_drive_step(). It never waits. If the ring is full, the frame is dropped and counted
///            as an overrun.
/// Main loop: lode_ring_drain() delivers octets for a UART. From ONE thread on the same core, which the interrupt may
///            interrupt and which never interrupts the interrupt.
///
/// Layout in memory and on the wire, version 1: docs/telemetry.md. It does not depend on the machine's char size or byte order.
#ifndef LODESTAR_RING_H
#define LODESTAR_RING_H

#include "lodestar/channel.h"
#include "lodestar/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LODE_RING_MAGIC 0x69526F4Cu ///< "LoRi" with the lowest octet first
#define LODE_RING_VERSION 1u

/// Index of the words at the beginning of the buffer. Slots of 1 + channels words follow, each with a sequence
/// number and a row.
enum {
    LODE_RING_AT_MAGIC,
    LODE_RING_AT_VERSION,
    LODE_RING_AT_CHANNELS,   ///< number of channels in a row
    LODE_RING_AT_SLOTS,      ///< number of frames that the buffer holds
    LODE_RING_AT_F_PWM,      ///< rate of the step, Hz, as the bits of a float
    LODE_RING_AT_DECIMATION, ///< control periods per frame
    LODE_RING_AT_WRITTEN,    ///< frames written since init, modulo 2^32
    LODE_RING_AT_OVERRUNS,   ///< frames dropped since init, modulo 2^32
    LODE_RING_AT_CHANNEL     ///< lode_channel_t of the first channel; the others follow
};

/// Buffer size in words for `slots` frames of `channels` channels. The slots must last for the longest time between
/// two calls of lode_ring_drain().
#define LODE_RING_WORDS(channels, slots)                                                           \
    ((uint32_t)LODE_RING_AT_CHANNEL + (uint32_t)(channels) +                                       \
     (uint32_t)(slots) * (1u + (uint32_t)(channels)))

/// First octet of every frame on the wire. The second one is LODE_RING_DATA or LODE_RING_DESCRIPTION.
#define LODE_RING_SYNC 0xA5u
#define LODE_RING_DATA 0x20u ///< version 1 in bits 5 and 6; number of payload words in bits 0 .. 4
#define LODE_RING_DESCRIPTION 0xA0u ///< the same with bit 7 set
/// Words of a description before its channels: f_pwm_Hz, decimation, sequence number of the next data frame (all 32
/// bits), overruns.
#define LODE_RING_DESCRIPTION_WORDS 4u
/// A description is sent before the first data frame and then before every so many data frames.
#define LODE_RING_DESCRIBE_EVERY 64u

/// The members are visible for static allocation; only the functions below write them.
typedef struct {
    // Set by lode_ring_init().
    uint32_t *buffer;
    uint32_t *slot; ///< the first one
    uint32_t end;   ///< words of all slots
    uint32_t slots;
    // Written by the interrupt.
    lode_channels_t channels;
    uint32_t sequence; ///< of the next frame, dropped frames included
    uint32_t written;
    uint32_t write_at; ///< word index of the next slot
    uint32_t overruns;
    // Written by the thread.
    uint32_t read;
    uint32_t read_at;
    lode_wire_t wire;
    uint16_t at;   ///< next word of the present frame
    uint16_t size; ///< its number of words with header and CRC
    bool describing;
    uint16_t until_description; ///< data frames until the next description
} lode_ring_t;

/// Takes `words` words at `buffer`, which belong to the ring from then on; at least two frames must fit. Errors:
/// NULL, F_PWM, CHANNELS, BUFFER; `self` and the buffer are then left alone. Not while the interrupt calls
/// lode_ring_step().
lode_status_t lode_ring_init(lode_ring_t *self, const lode_channels_config_t *config,
                             uint32_t *buffer, uint32_t words);

/// One control period, in bounded time, from the interrupt. Cost: docs/telemetry.md.
void lode_ring_step(lode_ring_t *self, const lode_drive_t *drive);

/// Writes up to `count` octets to `octets`, one value 0 .. 255 per element (a C28x has no 8-bit type), and returns
/// how many. 0: nothing to send. A frame may be cut anywhere; the next call continues.
uint32_t lode_ring_drain(lode_ring_t *self, uint16_t *octets, uint32_t count);

/// Frames dropped since init because the thread was too slow.
uint32_t lode_ring_overruns(const lode_ring_t *self);

#ifdef __cplusplus
}
#endif

#endif
