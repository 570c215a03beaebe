/// Values that are neither given nor computed are assumed, and marked wherever they are printed.
#ifndef RIG_ASSUMPTIONS_H
#define RIG_ASSUMPTIONS_H

#include <stdio.h>

#include "config/rig_config.h"

/// Assumes a PWM frequency, a current and a bus voltage that suit a motor without a drive.
void assumptions_drive(rig_config_t *config);

/// Marks every value of motor, inverter and board that is not given and so has its default.
void assumptions_note(rig_config_t *config);

/// Assumes the harmonics and the noise of a design that [plant] does not give.
void assumptions_disturbances(rig_config_t *config);

/// Prints one line for each assumption, with its value: "assumed: [drive] dead_time_s = 0: no dead time".
void assumptions_print(FILE *file, const rig_config_t *config, const char *before);

#endif
