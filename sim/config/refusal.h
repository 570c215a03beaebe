/// Why the library refused a configuration, in terms of INI keys.
#ifndef RIG_REFUSAL_H
#define RIG_REFUSAL_H

#include "config/rig_config.h"

/// Prints "FILE:LINE: [section] key = value: LODE_ERROR_...: what was expected". The key is one that was given:
/// if a default was refused, one from which it was computed. Then prints a line for each implausible value of
/// the motor. `config` is designed.
void refusal_report(const rig_config_t *config, lode_status_t status);

#endif
