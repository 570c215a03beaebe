// Whether a tuning is numbers when it is posted, and stays what it was while it is in use.
#ifndef LODE_TUNING_CHECK_H
#define LODE_TUNING_CHECK_H

#include "lodestar/drive.h"

// A tuning as words: that of three phases, or all of that of six.
typedef struct {
    const unsigned char *from;
    uint32_t words;
} lode_words_t;

static inline lode_words_t lode_tuning_words(const lode_drive_tuning_t *tuning) {
    return (lode_words_t){(const unsigned char *)tuning,
                          (uint32_t)(sizeof *tuning / sizeof(uint32_t))};
}

// Leaves the check of a tuning beside it in the mailbox. For a thread.
void lode_tuning_post_check(lode_drive_t *self, lode_words_t tuning);

// From the next period on the tuning whose check lies in the mailbox is watched.
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

// One more word of the tuning. False: that was all of it, and it is not what it was.
bool lode_tuning_watch_word(lode_drive_t *self, lode_words_t tuning);

#endif

#endif
