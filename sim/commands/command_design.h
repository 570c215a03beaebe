/// The command `design`.
#ifndef RIG_COMMAND_DESIGN_H
#define RIG_COMMAND_DESIGN_H

#include "support/diag.h"
#include "support/options.h"

rig_exit_t command_design(const options_t *options);

#endif
