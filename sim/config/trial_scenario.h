/// A scenario for a motor without one: start, half and full speed, a load, a stop. Half speed is left out if
/// the start ends above it.
#ifndef RIG_TRIAL_SCENARIO_H
#define RIG_TRIAL_SCENARIO_H

#include <stdbool.h>
#include <stdio.h>

#include "config/rig_config.h"

/// Largest share of the estimator's limit: leaves room for an overshoot and for a load that drops.
#define TRIAL_ESTIMATOR_SHARE 0.95

/// Fills the phases of a designed configuration from its own speeds, torque and ramp. A full speed that the
/// estimator could not follow is lowered, and its phase keeps the original value.
/// The load is half of the torque at i_max, or the largest load step (K18) if that is smaller. False: the voltage allows no
/// speed at i_max.
bool trial_scenario(rig_config_t *config);

/// The start lasts as long as it takes, and `duration_s` at most. A duration that was set since lasts whole.
void trial_scenario_keep_start(rig_config_t *config, double duration_s);

/// Prints a line with the load and the largest load step at that speed, before it one with the full speed if the voltage
/// keeps it below rated speed.
void trial_scenario_print(FILE *file, const rig_config_t *config);

#endif
