/// The claims of paper 1, experiment by experiment, with the measured values.
#ifndef RIG_REPRODUCE_ROWS_H
#define RIG_REPRODUCE_ROWS_H

#include "reproduce/case.h"
#include "reproduce/table.h"
#include "reproduce/theory.h"

typedef struct {
    table_t table;
    theory_t theory;
} reproduction_t;

/// Extent of the runs.
typedef struct {
    uint64_t first_seed;
    int seeds;          ///< 1 .. SEEDS_MAX
    unsigned processes; ///< 0: as many as there are processors
} reproduce_extent_t;

/// Runs every experiment. False after a message.
bool reproduction_run(reproduction_t *self, const case_bases_t *bases,
                      const reproduce_extent_t *extent);

/// Runs one of the experiments again, with its signals. False after a message.
bool reproduction_signals(const case_bases_t *bases, const case_t *what, runlog_t *log);

#endif
