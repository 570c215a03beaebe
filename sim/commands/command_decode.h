/// The command `decode`.
#ifndef RIG_COMMAND_DECODE_H
#define RIG_COMMAND_DECODE_H

#include "support/diag.h"
#include "support/options.h"

rig_exit_t command_decode(const options_t *options);

#endif
