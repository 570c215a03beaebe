// Checks that a tuning has only finite numbers when posted, and does not change while in use.
#ifndef LODE_TUNING_CHECK_H
#define LODE_TUNING_CHECK_H

#include "lodestar/drive.h"

// A complete tuning as words, of three or of six phases.
typedef struct {
    const unsigned char *from;
    uint32_t words;
} lode_words_t;

static inline lode_words_t lode_tuning_words(const lode_drive_tuning_t *tuning) {
    return (lode_words_t){(const unsigned char *)tuning,
                          (uint32_t)(sizeof *tuning / sizeof(uint32_t))};
}

// Puts the check of a tuning into the mailbox next to it. For a thread.
void lode_tuning_post_check(lode_drive_t *self, lode_words_t tuning);

// From the next period on, watches the tuning whose check is in the mailbox.
void lode_tuning_take_check(lode_drive_t *self);

#ifdef LODE_WITHOUT_TUNING_CHECK

static inline bool lode_tuning_is_finite(const lode_drive_tuning_t *tuning) {
    (void)tuning;
    return true;
}

static inline bool lode_tuning_watch_word(lode_drive_t *self, lode_words_t tuning) {
    (void)self;
    (void)tuning;
    return true;
}

#else

// All of these words are floats, and finite ones. For a thread.
bool lode_words_are_finite(lode_words_t floats);

// All floats of the tuning are finite. For a thread.
bool lode_tuning_is_finite(const lode_drive_tuning_t *tuning);

// Checks one more word of the tuning. False: that was the last one, and the tuning has changed.
bool lode_tuning_watch_word(lode_drive_t *self, lode_words_t tuning);

#endif

#endif
