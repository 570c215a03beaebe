/// Motor and drive as an INI file that the tool reads.
#ifndef RIG_INI_WRITE_H
#define RIG_INI_WRITE_H

#include <stdbool.h>
#include <stdio.h>

#include "config/rig_config.h"
#include "config/schema.h"

/// True for a key of motor and drive, not of plant and scenario; keys of six phases only if there are six.
bool ini_write_is_of_drive(const rig_config_t *config, const rig_key_t *key);

/// Writes every such key that was given, assumed or measured, in SI units and with all digits. Values that are
/// assumed for any motor become comments. The other keys are left out; the library computes them from the same
/// values.
void ini_write(FILE *file, const rig_config_t *config);

#endif
