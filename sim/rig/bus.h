/// The firmware's part in the bus: the library's brake chopper, in the interrupt.
#ifndef RIG_BUS_H
#define RIG_BUS_H

#include "config/rig_config.h"

#include "lodestar/chopper.h"

typedef struct {
    bool chops;
    lode_chopper_tuning_t chopper_tuning;
    lode_chopper_t chopper;
    float v_bus_V_per_count;
} bus_t;

/// False after a message if the library refuses `config`.
bool bus_init(bus_t *self, const rig_config_t *config);

/// Duty of the chopper for a sample of the bus voltage.
double bus_chop(bus_t *self, uint16_t v_bus_count);

#endif
