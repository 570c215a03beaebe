/// Numbers of a three-phase PWM with low-side shunts, whatever the chip. No hardware in here.
///
/// The timer counts up and down. The low side of a phase is on for (1 - duty)/2 of the period before t_k
/// and as long after it.
#ifndef LODESTAR_PORT_COMMON_FIGURES_H
#define LODESTAR_PORT_COMMON_FIGURES_H

#include "lodestar/lodestar.h"

/// Timer steps from duty 0 to 1; 0 where 16 bits do not hold them.
uint32_t port_pwm_steps(uint32_t f_timer_Hz, uint32_t f_pwm_Hz);

/// Largest duty with which a low-side shunt can still be sampled. `settle_ns`: from the low side's
/// turn-on to a settled amplifier, dead time included. `sample_ns`: from t_k to the end of the last
/// current's sampling.
float port_duty_max(float f_pwm_Hz, float settle_ns, float sample_ns);

/// A trip threshold, not below what offsets allow and not above what board and amplifier bear.
float port_trip_A(float wanted_A, float least_A, float most_A);

/// Largest share of the voltage circle with which the second largest duty stays at or below `duty_max`,
/// so that two phases can be sampled at any angle; at most the core's default. 0 where there is none.
float port_voltage_use(float duty_max);

#endif
