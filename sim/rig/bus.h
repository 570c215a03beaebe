/// Limits of the supply: the library's battery and regeneration current limits in the main loop, and its brake
/// chopper in the interrupt.
#ifndef RIG_BUS_H
#define RIG_BUS_H

#include "config/rig_config.h"

#include "lodestar/chopper.h"
#include "lodestar/supply.h"

typedef struct {
    bool limits, chops;
    uint32_t every; ///< periods from one pass of the main loop to the next
    float dt_s;     ///< the same
    lode_supply_tuning_t supply_tuning;
    lode_supply_t supply;
    lode_chopper_tuning_t chopper_tuning;
    lode_chopper_t chopper;
    float v_bus_V_per_count;
} bus_t;

/// False after a message if the library refuses `config`.
bool bus_init(bus_t *self, const rig_config_t *config);

/// Call after each period: in a period with a pass of the main loop it limits the drive's torque.
void bus_limit(bus_t *self, lode_drive_t *drive);

/// Duty of the chopper for a sample of the bus voltage.
double bus_chop(bus_t *self, uint16_t v_bus_count);

#endif
