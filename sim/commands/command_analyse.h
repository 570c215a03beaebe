/// The command `analyse`.
#ifndef RIG_COMMAND_ANALYSE_H
#define RIG_COMMAND_ANALYSE_H

#include "support/diag.h"
#include "support/options.h"

rig_exit_t command_analyse(const options_t *options);

#endif
