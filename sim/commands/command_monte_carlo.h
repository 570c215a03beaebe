/// `lodestar monte-carlo`: runs the catalogue with wrong parameters and counts the failures.
#ifndef RIG_COMMAND_MONTE_CARLO_H
#define RIG_COMMAND_MONTE_CARLO_H

#include "support/diag.h"
#include "support/options.h"

/// RIG_FAILED if a bar is missed.
rig_exit_t command_monte_carlo(const options_t *options);

#endif
