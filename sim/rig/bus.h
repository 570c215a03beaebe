/// What keeps to the limits of the supply: the library's battery and regeneration current limits, as a main loop has
/// them beside the drive, and its brake chopper, in the interrupt.
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

/// False after a message: what the library refuses of `config`.
bool bus_init(bus_t *self, const rig_config_t *config);

/// After a period: in those of the main loop the drive's torque is limited.
void bus_limit(bus_t *self, lode_drive_t *drive);

/// Duty of the chopper that follows from a sample of the bus.
double bus_chop(bus_t *self, uint16_t v_bus_count);

#endif
