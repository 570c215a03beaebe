/// Numbers that TI's ePWM and ADC need, the same in F28004x and AM263x. No hardware in here.
#ifndef LODESTAR_PORT_TI_FIGURES_H
#define LODESTAR_PORT_TI_FIGURES_H

#include "lodestar/lodestar.h"

/// Timer steps from duty 0 to 1 of a counter that runs up and down; 0 where 16 bits do not hold them.
uint16_t ti_pwm_steps(uint32_t f_timer_Hz, uint32_t f_pwm_Hz);

/// Counts of the dead-band unit for at least this dead time; false beyond its 14 bits.
bool ti_dead_time(uint32_t f_timer_Hz, uint32_t dead_time_ns, uint16_t *counts);

/// Compare value for a duty in [0, 1]. At least 1: with the value taken over at zero, a compare with 0
/// could lose its edge. Full duty is therefore off for two counts, which the dead-band swallows.
LODE_INLINE uint16_t ti_compare(float duty, uint16_t steps) {
    const float compare = (1.0f - duty) * (float)steps + 0.5f;
    return (uint16_t)(int32_t)lode_clamp(compare, 1.0f, (float)steps);
}

/// Largest duty with which a low-side shunt can still be sampled. `settle_ns`: from the low side's
/// turn-on to a settled amplifier, dead time included. `sample_ns`: from t_k to the end of the last
/// current's sampling. The low side is on for (1 - duty)/2 of the period before t_k and after it.
float ti_duty_max(float f_pwm_Hz, float settle_ns, float sample_ns);

/// Largest share of the voltage circle with which the second largest duty stays at or below `duty_max`,
/// so that two phases can be sampled at any angle; at most the core's default. 0 where there is none.
float ti_voltage_use(float duty_max);

/// A comparator's threshold in counts of its 12-bit DAC, kept inside its range.
uint16_t ti_threshold(float count);

#endif
