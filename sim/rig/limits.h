/// Limits of the torque in the firmware's main loop: the currents of the supply, and derating by heat.
#ifndef RIG_LIMITS_H
#define RIG_LIMITS_H

#include "config/rig_config.h"

#include "lodestar/derate.h"
#include "lodestar/supply.h"

typedef struct {
    bool by_supply, by_heat;
    uint32_t every; ///< periods from one pass of the main loop to the next
    float dt_s;     ///< the same
    lode_supply_tuning_t supply_tuning;
    lode_supply_t supply;
    lode_derate_tuning_t derate_tuning;
    lode_derate_t derate;
    float cool; ///< share of the torque that derating permits
} limits_t;

/// False after a message if the library refuses `config`, which is designed.
bool limits_init(limits_t *self, const rig_config_t *config);

/// Call after each period: in a period with a pass of the main loop it limits the drive's torque.
void limits_apply(limits_t *self, lode_drive_t *drive);

#endif
