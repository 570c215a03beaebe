/// Why the library refused a configuration, in terms of INI keys.
#ifndef RIG_REFUSAL_H
#define RIG_REFUSAL_H

#include "config/rig_config.h"

/// Prints "FILE:LINE: [section] key: LODE_ERROR_...: what was expected".
void refusal_report(const rig_config_t *config, lode_status_t status);

#endif
