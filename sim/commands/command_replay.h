/// The command `replay`.
#ifndef RIG_COMMAND_REPLAY_H
#define RIG_COMMAND_REPLAY_H

#include "support/diag.h"
#include "support/options.h"

rig_exit_t command_replay(const options_t *options);

#endif
