/// `lodestar reproduce`: repeats the experiments of a paper.
#ifndef RIG_COMMAND_REPRODUCE_H
#define RIG_COMMAND_REPRODUCE_H

#include "support/diag.h"
#include "support/options.h"

rig_exit_t command_reproduce(const options_t *options);

#endif
