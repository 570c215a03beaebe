/// The command `commission`.
#ifndef RIG_COMMAND_COMMISSION_H
#define RIG_COMMAND_COMMISSION_H

#include "support/diag.h"
#include "support/options.h"

rig_exit_t command_commission(const options_t *options);

#endif
