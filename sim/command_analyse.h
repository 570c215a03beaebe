/// The command `analyse`.
#ifndef RIG_COMMAND_ANALYSE_H
#define RIG_COMMAND_ANALYSE_H

#include "diag.h"
#include "options.h"

rig_exit_t command_analyse(const options_t *options);

#endif
