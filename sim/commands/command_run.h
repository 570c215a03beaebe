/// The commands `run` and (without a command) the main job.
#ifndef RIG_COMMAND_RUN_H
#define RIG_COMMAND_RUN_H

#include "config/rig_config.h"
#include "support/diag.h"
#include "support/options.h"

/// Scenario, or (NULL) the motor and drive of the options with a trial of their own, --set and seed,
/// completed and designed. False after a message.
bool command_run_load(rig_config_t *config, const options_t *options, const char *scenario);

rig_exit_t command_run(const options_t *options);
rig_exit_t command_main_job(const options_t *options);

#endif
