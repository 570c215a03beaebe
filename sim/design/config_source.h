/// A drive's configuration as a C constant.
#ifndef RIG_CONFIG_SOURCE_H
#define RIG_CONFIG_SOURCE_H

#include <stdio.h>

#include "config/rig_config.h"

/// Writes every field that is given, and marks the measured ones. The fields that are left out are 0, as in `config`.
void config_source_print(FILE *file, const char *name, const rig_config_t *config);

#endif
