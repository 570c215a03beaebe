/// Experiments, each made once however many claims ask for it, and spread over all processors.
///
/// What is needed is found by filling the table twice. The first time nothing is run: every experiment
/// that a row asks for is noted. Then all are run, and the table is filled again.
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
    // Written here only.
    int count, capacity;
    bool done; ///< they have been run
    bool failed;
    unsigned char *what, *result;
} runs_t;

void runs_free(runs_t *self);

/// The result of an experiment; all zero as long as they have not been run.
const void *runs_result(runs_t *self, const void *what);

/// Runs all that has been asked for. `processes` 0: as many as there are processors. False after a
/// message.
bool runs_make(runs_t *self, unsigned processes);

#endif
