/// The option --c: tuning and configuration as constants in C.
#ifndef RIG_COMMAND_SOURCE_H
#define RIG_COMMAND_SOURCE_H

#include <stdbool.h>
#include <stdio.h>

#include "config/rig_config.h"
#include "support/options.h"

#include "lodestar/drive6.h"

typedef struct {
    FILE *file; ///< NULL: not wanted
    char name[RIG_NAME_LENGTH * 2];
} command_source_t;

/// Opens the file if --c is given. False after a message.
bool command_source_open(command_source_t *self, const options_t *options);

/// Writes the constants. `tuning`: of rig_config_tune(). `command`: the name of the calling command; `motor`: the file of the motor or the scenario.
void command_source_print(const command_source_t *self, const char *command, const char *motor,
                          const options_t *options, const rig_config_t *config,
                          const lode_drive6_tuning_t *tuning);

#endif
