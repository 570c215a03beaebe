/// A scenario for a motor that comes without one: start, half and full speed, a load, a stop. There is no half speed
/// where the start ends above it already.
#ifndef RIG_TRIAL_SCENARIO_H
#define RIG_TRIAL_SCENARIO_H

#include <stdio.h>

#include "config/rig_config.h"

/// Of the estimator's limit, at most: room for an overshoot and for a load that lets go.
#define TRIAL_ESTIMATOR_SHARE 0.95

/// Fills the phases of a designed configuration from its own speeds, torque and ramp. A full speed that
/// the estimator could not follow is lowered, and its phase says from where.
/// The load is half of the torque at i_max, as far as the largest step of load allows it (K18).
void trial_scenario(rig_config_t *config);

/// A line that says what the load is, beside the largest step of load at that speed.
void trial_scenario_print(FILE *file, const rig_config_t *config);

#endif
