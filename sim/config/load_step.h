/// The largest load that may come at once.
#ifndef RIG_LOAD_STEP_H
#define RIG_LOAD_STEP_H

#include <stdbool.h>

#include "lodestar/drive.h"

typedef struct {
    double torque_Nm;
    bool by_current; ///< i_max bounds it, not the speed that it takes
} load_step_t;

/// (K18) at this electrical speed, of a designed configuration and its tuning.
load_step_t load_step_largest(const lode_drive_config_t *drive, const lode_speed_tuning_t *tuning,
                              double omega_rad_s);

#endif
