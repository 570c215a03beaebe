/// Numbered pieces of work spread over several processes; their results come back in order.
#ifndef RIG_WORKERS_H
#define RIG_WORKERS_H

#include <stdbool.h>
#include <stdint.h>

enum { WORKERS_MAX = 256, WORKERS_RESULT_MAX = 2048 };

typedef struct {
    uint64_t first, last; ///< numbers of the pieces
    unsigned processes;   ///< 1 .. WORKERS_MAX; 0: as many as there are processors
    void *user;
    /// Does one piece of work, with a result of at most WORKERS_RESULT_MAX bytes. False after a message if it
    /// cannot be done. The result must depend only on the number, not on the process.
    bool (*work)(void *user, uint64_t number, void *result);
    /// Gets each result in the parent process, in the order of the numbers.
    void (*take)(void *user, uint64_t number, const void *result);
} workers_t;

/// False after a message if a piece could not be done, or the system has no more processes.
bool workers_run(const workers_t *self);

#endif
