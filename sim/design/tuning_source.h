/// A drive's tuning as a C constant, for a firmware that needs neither design nor checks.
#ifndef RIG_TUNING_SOURCE_H
#define RIG_TUNING_SOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "config/rig_config.h"

#include "lodestar/drive.h"

/// The constant's name: that of the file, without folders and ending. False after a message where that is
/// no name in C, or longer than `size`.
bool tuning_source_name(char *name, size_t size, const char *path);

/// `from`: by which command and from what it was written; that and what of `config` is assumed stand in a
/// comment.
void tuning_source_print(FILE *file, const char *name, const lode_drive_tuning_t *tuning,
                         const rig_config_t *config, const char *from);

#endif
