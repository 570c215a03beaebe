/// Experiments, each run once even if several claims need it, and spread over all processors.
///
/// The table is filled twice. The first time nothing is run: every experiment that a row needs is noted. Then
/// all are run, and the table is filled again.
#ifndef RIG_REPRODUCE_RUNS_H
#define RIG_REPRODUCE_RUNS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct {
    size_t what_size, result_size;
    bool (*same)(const void *a, const void *b);
    /// False after a message.
    bool (*run)(void *user, const void *what, void *result);
    const char *(*name)(const void *what); ///< for the progress line
    void *user;
    // Written only by runs.c.
    int count, capacity;
    bool done; ///< the experiments have been run
    bool failed;
    unsigned char *what, *result;
} runs_t;

void runs_free(runs_t *self);

/// The result of an experiment; all zero before the experiments have been run.
const void *runs_result(runs_t *self, const void *what);

/// Runs all noted experiments. `processes` 0: as many as there are processors. False after a
/// message.
bool runs_make(runs_t *self, unsigned processes);

#endif
