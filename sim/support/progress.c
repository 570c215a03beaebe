#include "support/progress.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

#include "support/utf8.h"

#define SHOW_AFTER_s 0.5
#define SHOW_EVERY_s 0.2

static double read_clock_s(clockid_t clock) {
    struct timespec now;
    (void)clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double wall_clock_s(void) {
    return read_clock_s(CLOCK_MONOTONIC);
}

void progress_start(progress_t *self) {
    *self = (progress_t){.terminal = isatty(STDERR_FILENO) == 1,
                         .started_s = read_clock_s(CLOCK_PROCESS_CPUTIME_ID),
                         .shown_s = wall_clock_s() + SHOW_AFTER_s - SHOW_EVERY_s};
}

void progress_show(progress_t *self, double fraction, const char *what) {
    if (!self->terminal || wall_clock_s() < self->shown_s + SHOW_EVERY_s) {
        return;
    }
    self->shown_s = wall_clock_s();
    self->shown = true;
    char words[80]; // a line
    (void)fprintf(stderr, "\r\033[K%3.0f %%  %s", 100.0 * fraction,
                  utf8_copy_shown(words, sizeof words, what));
    (void)fflush(stderr);
}

double progress_end(progress_t *self) {
    if (self->shown) {
        (void)fputs("\r\033[K", stderr);
    }
    return read_clock_s(CLOCK_PROCESS_CPUTIME_ID) - self->started_s;
}
