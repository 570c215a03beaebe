/// Motor and drive as an INI file that the tool reads.
#ifndef RIG_INI_WRITE_H
#define RIG_INI_WRITE_H

#include <stdbool.h>
#include <stdio.h>

#include "config/rig_config.h"
#include "config/schema.h"

/// True of a key that says something of this motor and drive: not of plant and scenario, and of six phases only
/// where there are six.
bool ini_write_is_of_drive(const rig_config_t *config, const rig_key_t *key);

/// Every such key that was given, assumed or measured, in SI units and to the last bit. What was
/// assumed of whatever motor is a comment. What is left open is what the library computes of the same values.
void ini_write(FILE *file, const rig_config_t *config);

#endif
