/// Reading of input, common to several commands.
#ifndef RIG_COMMAND_LOAD_H
#define RIG_COMMAND_LOAD_H

#include "config/rig_config.h"
#include "support/options.h"

/// Applies each --set of the command line. False after a message.
bool command_load_sets(rig_config_t *config, const options_t *options);

/// Fills a new configuration from a motor and a drive, files or names of shipped ones (NULL: none), then
/// applies each --set. False after a message.
bool command_load_drive(rig_config_t *config, const char *motor, const char *drive,
                        const options_t *options);

/// Loads a scenario or (NULL) the motor and drive of the options with a trial scenario, applies --set and seed,
/// then completes and designs the configuration. False after a message.
bool command_load_run(rig_config_t *config, const options_t *options, const char *scenario);

#endif
