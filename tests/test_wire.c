// Octets, the lowest first, and the CRC-32 that zip and Ethernet use.
#include "support/check.h"

#include "lodestar/wire.h"

void setUp(void) {}

void tearDown(void) {}

static uint32_t crc_of(const char *text) {
    uint32_t crc = LODE_CRC_START;
    for (const char *at = text; *at != '\0'; ++at) {
        crc = lode_crc_octet(crc, (uint16_t)(unsigned char)*at);
    }
    return ~crc;
}

static void test_published_values(void) {
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926u, crc_of("123456789")); // the check value of CRC-32
    TEST_ASSERT_EQUAL_HEX32(0x414FA339u, crc_of("The quick brown fox jumps over the lazy dog"));
    TEST_ASSERT_EQUAL_HEX32(0x00000000u, crc_of(""));
}

static void test_every_octet_as_bit_by_bit(void) {
    for (uint32_t octet = 0; octet < 256u; octet++) {
        uint32_t crc = 0x12345678u ^ octet;
        for (int n = 0; n < 8; n++) {
            crc = (crc >> 1) ^ ((crc & 1u) != 0u ? 0xEDB88320u : 0u);
        }
        TEST_ASSERT_EQUAL_HEX32(crc, lode_crc_octet(0x12345678u, (uint16_t)octet));
    }
}

static void test_higher_bits_of_an_element_do_not_count(void) {
    TEST_ASSERT_EQUAL_HEX32(lode_crc_octet(7u, 0x34u), lode_crc_octet(7u, 0x1234u));
}

static void test_lowest_octet_first(void) {
    lode_wire_t wire = {.crc = LODE_CRC_START};
    lode_wire_load(&wire, 0x34333231u); // "1234"
    for (uint16_t n = 0; n < 4; n++) {
        TEST_ASSERT_EQUAL_UINT16(4u - n, wire.left);
        TEST_ASSERT_EQUAL_HEX16('1' + n, lode_wire_octet(&wire));
    }
    TEST_ASSERT_EQUAL_UINT16(0, wire.left);
    TEST_ASSERT_EQUAL_HEX32(crc_of("1234"), ~wire.crc);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_published_values);
    RUN_TEST(test_every_octet_as_bit_by_bit);
    RUN_TEST(test_higher_bits_of_an_element_do_not_count);
    RUN_TEST(test_lowest_octet_first);
    return UNITY_END();
}
