/// The picture of a replay: speed, angle error, observed EMF, lock quality.
#ifndef RIG_PLOT_REPLAY_H
#define RIG_PLOT_REPLAY_H

#include "config/rig_config.h"
#include "rig/replay.h"
#include "support/plot.h"

/// False after a message.
bool plot_replay(const plot_output_t *output, const char *title, const rig_config_t *config,
                 const recording_t *recording, const replay_t *replay);

#endif
