/// The option --c: a tuning as a constant in C.
#ifndef RIG_COMMAND_SOURCE_H
#define RIG_COMMAND_SOURCE_H

#include <stdbool.h>
#include <stdio.h>

#include "config/rig_config.h"
#include "support/options.h"

#include "lodestar/drive.h"

typedef struct {
    FILE *file; ///< NULL: not asked for
    char name[RIG_NAME_LENGTH * 2];
} command_source_t;

/// Opens the file, if one was asked for. False after a message: it is for three phases.
bool command_source_open(command_source_t *self, const options_t *options,
                         const rig_config_t *config);

/// Writes it. `command`: which one does; `motor`: the file that it was told of, a motor's or a scenario's.
void command_source_print(const command_source_t *self, const char *command, const char *motor,
                          const options_t *options, const rig_config_t *config,
                          const lode_drive_tuning_t *tuning);

#endif
