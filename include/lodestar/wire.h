/// Serial output of 32-bit words: octet by octet, the lowest one first, with a CRC.
#ifndef LODESTAR_WIRE_H
#define LODESTAR_WIRE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Start value of the CRC.
#define LODE_CRC_START 0xFFFFFFFFu

/// Adds one octet (0 .. 255) to a CRC-32 as in IEEE 802.3 and zip. The final CRC is the complement of the last
/// result. About 20 instructions; for a thread.
uint32_t lode_crc_octet(uint32_t crc, uint16_t octet);

/// State of the output.
typedef struct {
    uint32_t word; ///< remaining octets of the present word, in its lowest bits
    uint32_t crc;  ///< over all octets since it was set to LODE_CRC_START
    uint16_t left; ///< number of remaining octets; 0: call lode_wire_load() next
} lode_wire_t;

/// Begins the output of `word`.
static inline void lode_wire_load(lode_wire_t *self, uint32_t word) {
    self->word = word;
    self->left = 4u;
}

/// The next octet, 0 .. 255. Not to be called with left = 0.
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
