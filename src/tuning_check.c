#include "tuning_check.h"

#include <stddef.h>

#ifdef LODE_WITHOUT_TUNING_CHECK

void lode_tuning_post_check(lode_drive_t *self, lode_words_t tuning) {
    (void)self;
    (void)tuning;
}

void lode_tuning_take_check(lode_drive_t *self) {
    (void)self;
}

#else

#define WORD_BITS 32u
#define EXPONENT 0x7f800000u // of a float: all ones for infinity and NaN
#define CRC_BEGIN 0xffffffffu

// Byte `n` of a word, which has up to four; a byte may have more than eight bits.
static inline uint32_t byte_of(const unsigned char *word, uint32_t n) {
    const uint32_t bytes = (uint32_t)sizeof(uint32_t);
    return n < bytes ? (uint32_t)word[n] << (WORD_BITS / bytes * n) : 0u;
}

// A word of a tuning, read as bytes: that is allowed for any object, and compilers make one load of it.
static inline uint32_t word_at(lode_words_t tuning, uint32_t n) {
    const unsigned char *word = tuning.from + n * sizeof(uint32_t);
    return byte_of(word, 0u) | byte_of(word, 1u) | byte_of(word, 2u) | byte_of(word, 3u);
}

bool lode_words_are_finite(lode_words_t floats) {
    for (uint32_t word = 0u; word < floats.words; word++) {
        if ((word_at(floats, word) & EXPONENT) == EXPONENT) {
            return false;
        }
    }
    return true;
}

bool lode_tuning_is_finite(const lode_drive_tuning_t *tuning) {
    // Offsets of the integers in ascending order; of a pair of integers in one word, only one. All other words are floats.
    static const uint_least16_t integers[] = {
        offsetof(lode_drive_tuning_t, speed_periods),
        offsetof(lode_drive_tuning_t, sense.offset_nominal),
        offsetof(lode_drive_tuning_t, sense.offset_tol),
        offsetof(lode_drive_tuning_t, sense.alert),
        offsetof(lode_drive_tuning_t, sense.calibrate_periods),
        offsetof(lode_drive_tuning_t, sense.noise_least),
        offsetof(lode_drive_tuning_t, sense.count_max),
        offsetof(lode_drive_tuning_t, inverter.precharge_periods),
        offsetof(lode_drive_tuning_t, inverter.correct),
        offsetof(lode_drive_tuning_t, estimator.options),
        offsetof(lode_drive_tuning_t, estimator.emf.observer.kind),
        offsetof(lode_drive_tuning_t, estimator.pll.third_order),
#ifndef LODE_WITHOUT_HFI
        offsetof(lode_drive_tuning_t, estimator.hfi.find_rounds),
#endif
        offsetof(lode_drive_tuning_t, estimator.settle_rounds),
        offsetof(lode_drive_tuning_t, references.options),
        offsetof(lode_drive_tuning_t, current.weakens),
        offsetof(lode_drive_tuning_t, start.catch_rounds),
        offsetof(lode_drive_tuning_t, start.timeout_rounds),
        offsetof(lode_drive_tuning_t, start.patience_rounds),
#ifndef LODE_WITHOUT_SIGNAL_CHECK
        offsetof(lode_drive_tuning_t, signal_check.pulses),
#endif
        offsetof(lode_drive_tuning_t, guard.bus_periods),
        offsetof(lode_drive_tuning_t, guard.still_rounds),
        offsetof(lode_drive_tuning_t, guard.stamp_min),
        offsetof(lode_drive_tuning_t, guard.stamp_span),
#ifndef LODE_WITHOUT_PLAUSIBILITY
        offsetof(lode_drive_tuning_t, plausibility.i_still),
        offsetof(lode_drive_tuning_t, plausibility.i_sum),
        offsetof(lode_drive_tuning_t, plausibility.stall_rounds),
#endif
        sizeof(lode_drive_tuning_t), // the end
    };
    const lode_words_t all = lode_tuning_words(tuning);
    uint32_t from = 0u;
    for (uint32_t n = 0u; n < (uint32_t)(sizeof integers / sizeof integers[0]); n++) {
        const uint32_t to = integers[n] / (uint32_t)sizeof(uint32_t);
        const lode_words_t floats = {&all.from[from * sizeof(uint32_t)], to - from};
        if (!lode_words_are_finite(floats)) {
            return false;
        }
        from = to + 1u;
    }
    return true;
}

// Adds a word to the CRC, least significant bit first. The polynomial x^32 + x^12 + x^8 + x^4 + x^3 + 1 has few and low powers:
// a remainder times x^32 is the remainder shifted by 12, 8, 4, 3 and 0, and the overflow once more. It is x + 1, which detects
// any odd number of bits, times an irreducible one. Of all such polynomials with six terms and no power from 17 to 31 it
// detects any four bits in the longest data, 4856 bits.
static uint32_t add_word(uint32_t crc, uint32_t word) {
    const uint32_t left = crc ^ word;
    const uint32_t all = left ^ left << 20u ^ left << 24u ^ left << 28u ^ left << 29u;
    return all ^ all >> 3u ^ all >> 4u ^ all >> 8u ^ all >> 12u;
}

void lode_tuning_post_check(lode_drive_t *self, lode_words_t tuning) {
    uint32_t crc = CRC_BEGIN;
    for (uint32_t word = 0u; word < tuning.words; word++) {
        crc = add_word(crc, word_at(tuning, word));
    }
    self->posted_check = crc;
}

void lode_tuning_take_check(lode_drive_t *self) {
    self->watch = (lode_tuning_watch_t){.check = self->posted_check, .crc = CRC_BEGIN};
}

LODE_NOINLINE bool lode_tuning_watch_word(lode_drive_t *self, lode_words_t tuning) {
    lode_tuning_watch_t *watch = &self->watch;
    const uint32_t word = watch->word;
    if (word < tuning.words) {
        watch->crc = add_word(watch->crc, word_at(tuning, word));
        watch->word = word + 1u;
        return true;
    }
    const bool same = watch->crc == watch->check;
    watch->crc = CRC_BEGIN;
    watch->word = 0u;
    return same;
}

#endif
