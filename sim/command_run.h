/// The commands `run` and (without a command) the main job.
#ifndef RIG_COMMAND_RUN_H
#define RIG_COMMAND_RUN_H

#include "diag.h"
#include "options.h"
#include "rig_config.h"

/// Scenario, --set and seed, completed and designed. False after a message.
bool command_run_load(rig_config_t *config, const options_t *options, const char *scenario);

rig_exit_t command_run(const options_t *options);
rig_exit_t command_main_job(const options_t *options);

#endif
