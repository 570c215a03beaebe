// Shared by the start and its design.
#ifndef LODE_START_PARTS_H
#define LODE_START_PARTS_H

#include "start_inline.h"

// (S35): the ramp at rest is that at omega_handover/STEEP by the share that grows with speed.
#define STEEP 64.0f
// Current of the last attempt over the start current, limited to CURRENT_SHARE of i_max .. i_max. A rotor that needs so
// much is loaded, and lags so far that reluctance adds to its torque.
#define CURRENT_LAST 2.0f
// Corner of the swing's filter over omega_n. A higher one would let an error in Lq close a loop.
#define SWING_CORNER 3.0f
// Share of the current at which resistance and dead time are measured first.
#define LEVEL_SHARE 0.5f

// Electrical hand-over speed that is needed even where resistance and dead time are known: for current sensors whose gains
// differ, and for a light rotor (S18).
float lode_start_least_rad_s(const lode_start_config_t *config,
                             const lode_inverter_config_t *inverter, const lode_motor_t *motor);

#endif
