/// Progress of a long run, on stderr and only if it is a terminal.
#ifndef RIG_PROGRESS_H
#define RIG_PROGRESS_H

#include <stdbool.h>

typedef struct {
    bool terminal;
    bool shown;
    double started_s; ///< processor time
    double shown_s;   ///< wall clock
} progress_t;

void progress_start(progress_t *self);

/// Shows `fraction` of the work and `what`, a few times a second at most.
void progress_show(progress_t *self, double fraction, const char *what);

/// Clears the line. Returns the processor time since the start, s, without that of other programs.
double progress_end(progress_t *self);

#endif
