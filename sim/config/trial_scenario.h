/// A scenario for a motor that comes without one: start, half and full speed, a load, a stop.
#ifndef RIG_TRIAL_SCENARIO_H
#define RIG_TRIAL_SCENARIO_H

#include "config/rig_config.h"

/// Fills the phases of a designed configuration from its own speeds, torque and ramp.
void trial_scenario(rig_config_t *config);

#endif
