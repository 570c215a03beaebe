/// Text on its way to the screen that a page may show as well.
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

/// Writes what has been collected to stdout. False after a message; to be freed either way.
bool shown_end(shown_t *self);

void shown_free(shown_t *self);

#endif
