/// lodestar faults
#ifndef RIG_COMMAND_FAULTS_H
#define RIG_COMMAND_FAULTS_H

#include "support/diag.h"
#include "support/options.h"

rig_exit_t command_faults(const options_t *options);

#endif
