/// What nobody gave and nothing computes: assumed, and marked wherever it is printed.
#ifndef RIG_ASSUMPTIONS_H
#define RIG_ASSUMPTIONS_H

#include <stdio.h>

#include "config/rig_config.h"

/// A motor alone says nothing of its drive: a PWM frequency, a current and a bus voltage that suit it.
void assumptions_drive(rig_config_t *config);

/// Marks every property of motor, inverter and board that is still open, and so has its default.
void assumptions_note(rig_config_t *config);

/// Harmonics and noise that a design has to stand, where [plant] says nothing of them.
void assumptions_disturbances(rig_config_t *config);

/// One line for each, with its value: "assumed: [drive] dead_time_s = 0: no dead time".
void assumptions_print(FILE *file, const rig_config_t *config, const char *before);

#endif
