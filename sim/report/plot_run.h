/// The picture of a run: speed, angle error, currents, EMF, state.
#ifndef RIG_PLOT_RUN_H
#define RIG_PLOT_RUN_H

#include "rig/runlog.h"
#include "rig/runner.h"
#include "support/plot.h"

/// False after a message.
bool plot_run(const plot_output_t *output, const char *title, const runner_result_t *result,
              const runlog_t *log);

#endif
