/// Words of 32 bits on their way out: octet by octet, the lowest first, with a check over them.
#ifndef LODESTAR_WIRE_H
#define LODESTAR_WIRE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Where a check begins.
#define LODE_CRC_START 0xFFFFFFFFu

/// CRC-32 as in IEEE 802.3 and zip, one octet (0 .. 255) further. Its value is the complement of the
/// last one. About 20 instructions, for a thread.
uint32_t lode_crc_octet(uint32_t crc, uint16_t octet);

typedef struct {
    uint32_t word; ///< what is left of the one under way, in its lowest bits
    uint32_t crc;  ///< over all octets since it was set to LODE_CRC_START
    uint16_t left; ///< octets left of the word; 0: lode_wire_load() comes next
} lode_wire_t;

static inline void lode_wire_load(lode_wire_t *self, uint32_t word) {
    self->word = word;
    self->left = 4u;
}

/// The next octet, 0 .. 255. Not with left = 0.
static inline uint16_t lode_wire_octet(lode_wire_t *self) {
    const uint16_t octet = (uint16_t)(self->word & 0xFFu);
    self->word >>= 8;
    self->left--;
    self->crc = lode_crc_octet(self->crc, octet);
    return octet;
}

#ifdef __cplusplus
}
#endif

#endif
