#include "support/shown.h"

#include <stdlib.h>

#include "support/diag.h"

static bool complain(bool good) {
    if (!good) {
        rig_error("out of memory for the table");
    }
    return good;
}

bool shown_begin(shown_t *self) {
    *self = (shown_t){NULL, NULL, 0};
    self->file = open_memstream(&self->text, &self->size);
    return complain(self->file != NULL);
}

bool shown_end(shown_t *self) {
    const bool good = fclose(self->file) == 0 && self->text != NULL;
    if (good) {
        (void)fwrite(self->text, 1, self->size, stdout);
        (void)fflush(stdout);
    }
    return complain(good);
}

void shown_free(shown_t *self) {
    free(self->text);
    *self = (shown_t){NULL, NULL, 0};
}
