/// The rows of a campaign: storage, writing, reading, and comparison with the bars.
#ifndef MONTECARLO_RESULTS_H
#define MONTECARLO_RESULTS_H

#include <stdint.h>
#include <stdio.h>

#include "montecarlo/trial.h"

enum { MC_MOTORS_MAX = 64 };

/// The definition of a campaign. Equal definitions give equal case numbers.
typedef struct {
    mc_test_t test;
    mc_errors_t errors;
    uint64_t cases; ///< per motor
    uint64_t seed;  ///< the first
    int motors;
    char motor[MC_MOTORS_MAX][NAMES_LENGTH];
    bool named[MC_MOTORS_MAX]; ///< reported by `design` as without usable EMF
    char sets[4096];           ///< the --set options as words of a shell, for the command that
                               ///< repeats a case
} mc_campaign_t;

/// A case without a result has done == 0.
typedef struct {
    uint_least8_t done, passed, listed;
    uint64_t periods;
    float max_error_deg;
    float found_ms; ///< MC_OPEN_PHASE; NaN: not found
    char cause[112];
} mc_row_t;

typedef struct {
    mc_campaign_t campaign;
    mc_row_t *row; ///< campaign.motors times campaign.cases, motor by motor
} mc_results_t;

const char *mc_test_name(mc_test_t test);
const char *mc_errors_name(mc_errors_t errors);

/// False after a message if out of memory. `campaign` must be filled.
bool mc_results_init(mc_results_t *self);
void mc_results_free(mc_results_t *self);

uint64_t mc_results_size(const mc_results_t *self);

void mc_results_take(mc_results_t *self, uint64_t number, const mc_result_t *result);

/// Prints a line for a failed case, with the command that repeats it.
void mc_results_print_failure(FILE *file, const mc_results_t *self, uint64_t number);

/// Prints the table. True if the bars hold; missing cases do not count.
bool mc_results_print(FILE *file, const mc_results_t *self);

/// {test, errors, n, seed, motors, named, rows}, a row per line.
void mc_results_write(FILE *file, const mc_results_t *self);

/// Adds a file to `self`, which the first file creates. False after a message: not such a file, of another
/// campaign, or with a row that `self` already has.
bool mc_results_merge(mc_results_t *self, const char *path);

/// False after a message if a case has no row.
bool mc_results_complete(const mc_results_t *self);

#endif
