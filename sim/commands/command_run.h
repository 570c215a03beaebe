/// The commands `run` and (without a command) the main job.
#ifndef RIG_COMMAND_RUN_H
#define RIG_COMMAND_RUN_H

#include "support/diag.h"
#include "support/options.h"

rig_exit_t command_run(const options_t *options);
rig_exit_t command_main_job(const options_t *options);

#endif
