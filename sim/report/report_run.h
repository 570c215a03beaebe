/// The results of a run: table, CSV, JSON.
#ifndef RIG_REPORT_RUN_H
#define RIG_REPORT_RUN_H

#include <stdio.h>

#include "rig/runlog.h"
#include "rig/runner.h"

void report_run_table(FILE *file, const rig_config_t *config, const runner_result_t *result,
                      const runlog_t *log);

void report_run_csv(FILE *file, const runlog_t *log);

void report_run_json(FILE *file, const rig_config_t *config, const runner_result_t *result,
                     const runlog_t *log);

/// The first phase whose command the drive has refused, NULL: none.
const runner_phase_t *report_run_refused(const runner_result_t *result);

/// True if the drive faulted unexpectedly or refused a command, a bar was missed, or RUN was commanded and never
/// reached.
bool report_run_failed(const runner_result_t *result);

/// A mode's name without its prefix.
const char *report_mode_name(lode_mode_t mode);

#endif
