/// A drive's tuning as a C constant, for a firmware that needs neither design nor checks, and the configuration from
/// which it was made, for one that does.
#ifndef RIG_TUNING_SOURCE_H
#define RIG_TUNING_SOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "config/rig_config.h"

#include "lodestar/drive6.h"

/// The constant's name: that of the file, without folders and extension. False after a message if that is not a
/// C identifier, is taken, or is longer than `size`.
bool tuning_source_name(char *name, size_t size, const char *path);

/// `tuning`: of rig_config_tune(). `from`: the command that wrote it and its input files; this and the assumed values
/// of `config` are written as a comment. The configuration is called NAME_config.
void tuning_source_print(FILE *file, const char *name, const lode_drive6_tuning_t *tuning,
                         const rig_config_t *config, const char *from);

#endif
