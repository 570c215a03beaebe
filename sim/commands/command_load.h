/// What commands have in common in reading their input.
#ifndef RIG_COMMAND_LOAD_H
#define RIG_COMMAND_LOAD_H

#include "config/rig_config.h"
#include "support/options.h"

/// Each --set of the command line. False after a message.
bool command_load_sets(rig_config_t *config, const options_t *options);

/// A configuration anew: a motor and a drive, files or names of shipped ones (NULL: none), then each
/// --set. False after a message.
bool command_load_drive(rig_config_t *config, const char *motor, const char *drive,
                        const options_t *options);

/// Scenario, or (NULL) the motor and drive of the options with a trial of their own, --set and seed,
/// completed and designed. False after a message.
bool command_load_run(rig_config_t *config, const options_t *options, const char *scenario);

#endif
