/// The picture of a run: speed, angle error, currents, EMF, state.
#ifndef RIG_PLOT_RUN_H
#define RIG_PLOT_RUN_H

#include "plot.h"
#include "runlog.h"
#include "runner.h"

/// False after a message.
bool plot_run(FILE *svg, const char *title, const runner_result_t *result, const runlog_t *log);

#endif
