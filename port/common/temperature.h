/// Temperature of a board with a header of values: from the table of its NTC (VARIANT_NTC_POINTS), or the plain
/// count for a linear sensor or none. Included by one source of a port, after the board's header.
#ifndef LODESTAR_PORT_COMMON_TEMPERATURE_H
#define LODESTAR_PORT_COMMON_TEMPERATURE_H

#include "ntc.h"

#ifdef VARIANT_NTC_POINTS

static port_ntc_t port_temperature_ntc;

static void port_temperature_init(void) {
    static const port_ntc_point_t points[] = {VARIANT_NTC_POINTS};
    port_ntc_init(&port_temperature_ntc,
                  &(port_ntc_config_t){.points = points,
                                       .count = sizeof points / sizeof points[0],
                                       .fixed_Ohm = VARIANT_NTC_FIXED_Ohm,
                                       .to_ground = VARIANT_NTC_TO_GROUND});
}

static inline uint16_t port_temperature(uint32_t count) {
    return port_ntc_tenths(&port_temperature_ntc, count);
}

#else

static void port_temperature_init(void) {}

static inline uint16_t port_temperature(uint32_t count) {
    return (uint16_t)count;
}

#endif

#endif
