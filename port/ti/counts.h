/// Counts that TI's ePWM and comparators need, the same in F28004x and AM263x. No hardware in here.
#ifndef LODESTAR_PORT_TI_COUNTS_H
#define LODESTAR_PORT_TI_COUNTS_H

#include "lodestar/lodestar.h"

/// Counts of the dead-band unit for at least this dead time; false beyond its 14 bits.
bool ti_dead_time(uint32_t f_timer_Hz, uint32_t dead_time_ns, uint16_t *counts);

/// Compare value for a duty in [0, 1]. At least 1: because the value is loaded at zero, a compare with 0 could
/// lose its edge. Full duty is therefore off for two counts, which the dead-band removes. With double update it
/// is also loaded at the period: there it stays one below `steps`, so that zero duty is on for two counts.
LODE_INLINE uint16_t ti_compare(float duty, uint16_t steps, bool double_update) {
    const float compare = (1.0f - duty) * (float)steps + 0.5f;
    const float most = (float)steps - (double_update ? 1.0f : 0.0f);
    return (uint16_t)(int32_t)lode_clamp(compare, 1.0f, most);
}

#define TI_DAC_MAX 4095u

/// A comparator's threshold in counts of its 12-bit DAC, kept inside its range.
uint16_t ti_threshold(float count);

#endif
