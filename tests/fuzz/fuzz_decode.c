// The decoder: any octets are refused with a place inside them, or give rows that are all there.
#include "decode/decode.h"
#include "support/fuzz.h"

// A CRC-32 is out of reach of random octets: make those of frames right, one time in two.
static void repair(unsigned char *data, size_t size) {
    for (size_t at = 0; at + 12 <= size; ++at) {
        const size_t words = (size_t)(data[at + 1] & 31u) + 1u;
        if (data[at] != LODE_RING_SYNC || at + 4u * (words + 1u) > size) {
            continue;
        }
        uint32_t crc = LODE_CRC_START;
        for (size_t k = 0; k < 4u * words; ++k) {
            crc = lode_crc_octet(crc, data[at + k]);
        }
        for (size_t k = 0; k < 4u; ++k) {
            data[at + 4u * words + k] = (unsigned char)(~crc >> (8u * k));
        }
        at += 4u * words + 3u;
    }
}

static void check(const decode_t *decoded, size_t size) {
    FUZZ_CHECK(decoded->rows > 0u);
    FUZZ_CHECK(decoded->channels >= 1u && decoded->channels <= LODE_CHANNELS_MAX);
    FUZZ_CHECK(decoded->rows * decoded->channels <= size / 4u);
    FUZZ_CHECK(!decoded->has_event || decoded->event < decoded->rows);
    FUZZ_CHECK(decoded->before <= size && decoded->after <= size);
    FUZZ_CHECK(decode_order_name(decoded->order)[0] != '\0');
    double sum = 0.0;
    for (size_t row = 0; row < decoded->rows; ++row) {
        FUZZ_CHECK(decoded->t_s[row] >= 0.0);
        for (uint32_t k = 0; k < decoded->channels; ++k) {
            sum += (double)decoded->value[row * decoded->channels + k];
        }
    }
    FUZZ_CHECK(sum > 0.0 || !(sum > 0.0)); // all were read
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 1) {
        return 0;
    }
    const uint8_t choice = data[0];
    unsigned char *copy = malloc(size); // so that a read behind the end is seen
    FUZZ_CHECK(copy != NULL);
    memcpy(copy, data + 1, size - 1);
    if ((choice & 1u) != 0u) {
        repair(copy, size - 1);
    }
    unsigned char *octets = malloc(size > 1 ? size - 1 : 1);
    FUZZ_CHECK(octets != NULL);
    memcpy(octets, copy, size - 1);
    decode_t decoded;
    if (decode_parse(&decoded, octets, size - 1, (decode_want_t)(choice / 2u % 3u))) {
        check(&decoded, size - 1);
        decode_free(&decoded);
    } else {
        FUZZ_CHECK(decoded.offset <= size - 1 && decoded.message[0] != '\0');
    }
    free(octets);
    free(copy);
    return 0;
}
