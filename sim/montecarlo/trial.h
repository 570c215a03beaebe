/// Runs one case: a start under load; a start followed by load steps, speed changes and reversals; a start and
/// thousands of periods without any reason to trip; or a start, a steady load and a phase that breaks.
#ifndef MONTECARLO_TRIAL_H
#define MONTECARLO_TRIAL_H

#include "montecarlo/draw.h"

/// With this error an angle in RUN is unusable; a drive that does not report it has failed silently.
#define MC_ERROR_MAX_deg 60.0

/// Prefix of the cause of a failure without a fault that telemetry explains: why the speed was not reached.
#define MC_REPORTED "reported: "

/// It passes through a pipe, so it holds no pointers.
typedef struct {
    bool passed;
    bool noticed; ///< failed with a fault, or with a reason in the telemetry
    char cause[96];
    double max_error_deg; ///< in RUN; NaN: never in RUN
    uint64_t periods;     ///< in RUN
    double found_s;       ///< MC_OPEN_PHASE: from the break to a fault; NaN: none
    int listed; ///< load steps left out: without a response they would halve the speed within 10 ms
} mc_result_t;

void mc_trial(mc_result_t *result, const mc_machine_t *machine, const mc_case_t *one,
              mc_test_t test);

#endif
