#include "counts.h"

#define DEAD_BAND_MAX 16383u

bool ti_dead_time(uint32_t f_timer_Hz, uint32_t dead_time_ns, uint16_t *counts) {
    // In thousandths of a timer period, so that 32 bits hold up to 20 us at 200 MHz.
    const uint32_t f_kHz = f_timer_Hz / 1000u;
    if (f_kHz == 0u || dead_time_ns > (UINT32_MAX - 999999u) / f_kHz) {
        return false;
    }
    const uint32_t ticks = (dead_time_ns * f_kHz + 999999u) / 1000000u;
    if (ticks > DEAD_BAND_MAX) {
        return false;
    }
    *counts = (uint16_t)ticks;
    return true;
}

uint16_t ti_threshold(float count) {
    return (uint16_t)(int32_t)lode_clamp(count + 0.5f, 0.0f, (float)TI_DAC_MAX);
}
