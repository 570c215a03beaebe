/// Text for the screen that an HTML page may also show.
#ifndef RIG_SHOWN_H
#define RIG_SHOWN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct {
    FILE *file; ///< to be written to
    char *text; ///< after shown_end()
    size_t size;
} shown_t;

/// False after a message.
bool shown_begin(shown_t *self);

/// Writes the collected text to stdout. False after a message; call shown_free() in either case.
bool shown_end(shown_t *self);

void shown_free(shown_t *self);

#endif
