#include "lodestar/ring.h"

#include <stddef.h>

lode_status_t lode_ring_init(lode_ring_t *self, const lode_channels_config_t *config,
                             uint32_t *buffer, uint32_t words) {
    if (self == NULL || buffer == NULL) {
        return LODE_ERROR_NULL;
    }
    lode_ring_t ring = {.buffer = buffer};
    const lode_status_t status = lode_channels_init(&ring.channels, config);
    if (status != LODE_OK) {
        return status;
    }
    const uint32_t count = ring.channels.count;
    if (words < (uint32_t)LODE_RING_WORDS(count, 2u)) {
        return LODE_ERROR_BUFFER;
    }
    ring.slot = &buffer[LODE_RING_AT_CHANNEL + count];
    ring.slots = (words - LODE_RING_AT_CHANNEL - count) / (1u + count);
    ring.end = ring.slots * (1u + count);
    buffer[LODE_RING_AT_MAGIC] = LODE_RING_MAGIC;
    buffer[LODE_RING_AT_VERSION] = LODE_RING_VERSION;
    buffer[LODE_RING_AT_CHANNELS] = count;
    buffer[LODE_RING_AT_SLOTS] = ring.slots;
    buffer[LODE_RING_AT_F_PWM] = lode_channel_bits(config->f_pwm_Hz);
    buffer[LODE_RING_AT_DECIMATION] = ring.channels.decimation;
    buffer[LODE_RING_AT_WRITTEN] = 0u;
    buffer[LODE_RING_AT_OVERRUNS] = 0u;
    for (uint32_t n = 0u; n < count; n++) {
        buffer[LODE_RING_AT_CHANNEL + n] = ring.channels.channel[n];
    }
    *self = ring;
    return LODE_OK;
}

LODE_RAMFUNC void lode_ring_step(lode_ring_t *self, const lode_drive_t *drive) {
    if (!lode_channels_due(&self->channels)) {
        return;
    }
    const uint32_t sequence = self->sequence++;
    if (self->written - self->read >= self->slots) {
        self->buffer[LODE_RING_AT_OVERRUNS] = ++self->overruns;
        return;
    }
    uint32_t *slot = &self->slot[self->write_at];
    slot[0] = sequence;
    lode_channels_row(&self->channels, drive, &slot[1]);
    LODE_SIGNAL_FENCE(); // the frame is complete before it is counted
    self->buffer[LODE_RING_AT_WRITTEN] = ++self->written;
    self->write_at += 1u + self->channels.count;
    self->write_at = self->write_at < self->end ? self->write_at : 0u;
}

static uint32_t description(const lode_ring_t *self, uint32_t n) {
    switch (n) {
    case 0u:
        return self->buffer[LODE_RING_AT_F_PWM];
    case 1u:
        return self->channels.decimation;
    case 2u:
        return self->slot[self->read_at];
    case 3u:
        return self->overruns;
    default:
        return self->channels.channel[n - LODE_RING_DESCRIPTION_WORDS];
    }
}

static bool begin_frame(lode_ring_t *self) {
    LODE_SIGNAL_FENCE(); // reads the count before the frame
    if (self->written == self->read) {
        return false;
    }
    LODE_SIGNAL_FENCE();
    const uint16_t count = self->channels.count;
    self->describing = self->until_description == 0u;
    const uint32_t payload = self->describing ? LODE_RING_DESCRIPTION_WORDS + count : count;
    const uint32_t kind = self->describing ? LODE_RING_DESCRIPTION : LODE_RING_DATA;
    self->until_description =
        (uint16_t)((self->describing ? LODE_RING_DESCRIBE_EVERY + 1u : self->until_description) -
                   1u);
    self->size = (uint16_t)(payload + 2u);
    self->at = 1u;
    self->wire.crc = LODE_CRC_START;
    lode_wire_load(&self->wire, LODE_RING_SYNC | (kind | payload) << 8 |
                                    (self->slot[self->read_at] & 0xFFFFu) << 16);
    return true;
}

// After the last word before the CRC the slot is no longer needed.
static void release(lode_ring_t *self) {
    LODE_SIGNAL_FENCE(); // the frame is read before its slot is given back
    self->read++;
    self->read_at += 1u + self->channels.count;
    self->read_at = self->read_at < self->end ? self->read_at : 0u;
}

static bool next_word(lode_ring_t *self) {
    if (self->at == self->size) {
        return begin_frame(self);
    }
    const uint16_t at = self->at++;
    if (self->at == self->size) {
        lode_wire_load(&self->wire, ~self->wire.crc);
        if (!self->describing) {
            release(self);
        }
    } else if (self->describing) {
        lode_wire_load(&self->wire, description(self, at - 1u));
    } else {
        lode_wire_load(&self->wire, self->slot[self->read_at + at]);
    }
    return true;
}

uint32_t lode_ring_drain(lode_ring_t *self, uint16_t *octets, uint32_t count) {
    uint32_t n = 0u;
    while (n < count && (self->wire.left > 0u || next_word(self))) {
        octets[n++] = lode_wire_octet(&self->wire);
    }
    return n;
}

uint32_t lode_ring_overruns(const lode_ring_t *self) {
    LODE_SIGNAL_FENCE();
    return self->overruns;
}
