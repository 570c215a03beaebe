/// Temperature from an NTC in a divider, from the resistance table of its data sheet. Accesses no hardware.
///
/// The result goes into lode_counts_t.temperature, with PORT_NTC_GAIN_degC and PORT_NTC_ZERO_degC as the
/// drive's gain and offset. A count beyond the cold end of the table means a broken wire or a missing sensor,
/// and reads hotter than any limit, so that the drive trips. A count beyond the hot end reads as the hottest
/// point: the drive's limit must be below that.
#ifndef LODESTAR_PORT_COMMON_NTC_H
#define LODESTAR_PORT_COMMON_NTC_H

#include "lodestar/lodestar.h"

#define PORT_NTC_GAIN_degC 0.1f
#define PORT_NTC_ZERO_degC (-100.0f)
#define PORT_NTC_MISSING 65535u ///< 6453.5 degC

/// Spans of a 12-bit ADC's range, 64 counts each. With 10 kOhm against 4.7 kOhm and points every 10 K the error
/// is below 0.6 K from 0 to 90 degC and below 1 K from -20 to 110 degC (tests/port/test_port_ntc.c).
#define PORT_NTC_SPAN 64u
#define PORT_NTC_SPANS 64u

/// One row of the table in the data sheet.
typedef struct {
    float degC;
    float R_Ohm;
} port_ntc_point_t;

typedef struct {
    const port_ntc_point_t *points; ///< coldest first
    uint32_t count;                 ///< at least 2
    float fixed_Ohm;                ///< of the divider's other resistor
    bool to_ground;                 ///< the NTC is connected to ground; else to the ADC's reference
} port_ntc_config_t;

typedef struct {
    uint16_t tenth[PORT_NTC_SPANS +
                   1u]; ///< 0.1 degC above PORT_NTC_ZERO_degC, at the start of every span
} port_ntc_t;

/// Call once, before the first port_ntc_tenths().
void port_ntc_init(port_ntc_t *self, const port_ntc_config_t *config);

/// For a 12-bit count. Interrupt: about ten instructions.
LODE_INLINE uint16_t port_ntc_tenths(const port_ntc_t *self, uint32_t count) {
    const uint32_t n = count / PORT_NTC_SPAN % PORT_NTC_SPANS;
    const int32_t from = (int32_t)self->tenth[n];
    const int32_t to = (int32_t)self->tenth[n + 1u];
    if (from == (int32_t)PORT_NTC_MISSING || to == (int32_t)PORT_NTC_MISSING) {
        return PORT_NTC_MISSING;
    }
    return (uint16_t)(from +
                      (to - from) * (int32_t)(count % PORT_NTC_SPAN) / (int32_t)PORT_NTC_SPAN);
}

#endif
