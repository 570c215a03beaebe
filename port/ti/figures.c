#include "figures.h"

#define STEPS_MAX 65535u
#define DEAD_BAND_MAX 16383u
#define DAC_MAX 4095.0f
#define NS_PER_S 1.0e9f
// The core's default share of the circle; more than the board allows is never asked of it.
#define VOLTAGE_USE 0.95f
// With the zero vectors halved, a vector between two legs of equal duty has them at
// 1/2 + sqrt(3)/4 of its share of the circle.
#define TWO_LEGS 0.4330127f

uint16_t ti_pwm_steps(uint32_t f_timer_Hz, uint32_t f_pwm_Hz) {
    if (f_pwm_Hz == 0u) {
        return 0u;
    }
    const uint32_t steps = (f_timer_Hz + f_pwm_Hz) / (2u * f_pwm_Hz);
    return steps <= STEPS_MAX ? (uint16_t)steps : 0u;
}

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

float ti_duty_max(float f_pwm_Hz, float settle_ns, float sample_ns) {
    return 1.0f - 2.0f * lode_max(settle_ns, sample_ns) / NS_PER_S * f_pwm_Hz;
}

float ti_voltage_use(float duty_max) {
    return lode_clamp((duty_max - 0.5f) / TWO_LEGS, 0.0f, VOLTAGE_USE);
}

uint16_t ti_threshold(float count) {
    return (uint16_t)(int32_t)lode_clamp(count + 0.5f, 0.0f, DAC_MAX);
}
