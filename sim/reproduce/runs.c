#include "reproduce/runs.h"

#include <stdlib.h>
#include <string.h>

#include "support/diag.h"
#include "support/progress.h"
#include "support/workers.h"

enum { FIRST_CAPACITY = 256 };

typedef struct {
    runs_t *runs;
    progress_t progress;
} making_t;

void runs_free(runs_t *self) {
    free(self->what);
    free(self->result);
    self->what = self->result = NULL;
    self->count = self->capacity = 0;
}

static bool grow(runs_t *self) {
    const int capacity = self->capacity > 0 ? 2 * self->capacity : FIRST_CAPACITY;
    unsigned char *what = realloc(self->what, (size_t)capacity * self->what_size);
    if (what != NULL) {
        self->what = what;
    }
    unsigned char *result = realloc(self->result, (size_t)capacity * self->result_size);
    if (result != NULL) {
        self->result = result;
    }
    if (what == NULL || result == NULL) {
        rig_error("out of memory for the experiments");
        self->failed = true;
        return false;
    }
    self->capacity = capacity;
    return true;
}

const void *runs_result(runs_t *self, const void *what) {
    static const double nothing[WORKERS_RESULT_MAX / sizeof(double)] = {0.0};
    for (int k = 0; k < self->count; ++k) {
        if (self->same(what, self->what + (size_t)k * self->what_size)) {
            return self->result + (size_t)k * self->result_size;
        }
    }
    if (self->done || (self->count == self->capacity && !grow(self))) {
        return nothing;
    }
    memcpy(self->what + (size_t)self->count * self->what_size, what, self->what_size);
    memset(self->result + (size_t)self->count * self->result_size, 0, self->result_size);
    self->count++;
    return nothing;
}

static bool work(void *user, uint64_t number, void *result) {
    const runs_t *runs = ((making_t *)user)->runs;
    return runs->run(runs->user, runs->what + number * runs->what_size, result);
}

static void take(void *user, uint64_t number, const void *result) {
    making_t *making = user;
    runs_t *runs = making->runs;
    memcpy(runs->result + number * runs->result_size, result, runs->result_size);
    progress_show(&making->progress, (double)(number + 1u) / runs->count,
                  runs->name(runs->what + number * runs->what_size));
}

bool runs_make(runs_t *self, unsigned processes) {
    making_t making = {.runs = self};
    const workers_t workers = {.first = 0u,
                               .last = (uint64_t)self->count - 1u,
                               .processes = processes,
                               .user = &making,
                               .work = work,
                               .take = take};
    self->done = true;
    if (self->failed || self->count == 0) {
        return !self->failed;
    }
    progress_start(&making.progress);
    const bool good = workers_run(&workers);
    (void)progress_end(&making.progress);
    return good;
}
