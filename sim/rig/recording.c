#include "rig/recording.h"

#include <stdlib.h>

#include "support/diag.h"

bool recording_add(recording_t *self, size_t *capacity, const recording_row_t *row) {
    if (self->rows == *capacity) {
        const size_t more = *capacity > 0 ? 2 * *capacity : 4096;
        recording_row_t *rows = realloc(self->row, more * sizeof *rows);
        if (rows == NULL) {
            rig_error("out of memory for %zu rows of a recording", more);
            return false;
        }
        self->row = rows;
        *capacity = more;
    }
    self->row[self->rows++] = *row;
    return true;
}

void recording_free(recording_t *self) {
    free(self->row);
    *self = (recording_t){0};
}
