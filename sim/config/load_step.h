/// The largest load step.
#ifndef RIG_LOAD_STEP_H
#define RIG_LOAD_STEP_H

#include <stdbool.h>

#include "lodestar/drive.h"

typedef struct {
    double torque_Nm;
    bool by_current; ///< limited by i_max, not by the speed dip
} load_step_t;

/// (K18) at this electrical speed, for a designed configuration and its tuning.
load_step_t load_step_largest(const lode_drive_config_t *drive, const lode_speed_tuning_t *tuning,
                              double omega_rad_s);

#endif
