/// Converts currents that one ADC samples one after the other to their values at t_k. Accesses no hardware.
///
/// All samples lie in the zero vector around t_k, with all low sides on. A phase current changes there for two
/// reasons: the ripple, whose slope is minus the mean voltage of the phase over the inductance, and the
/// fundamental, whose slope is that of the last period. Both are corrected. The remaining errors come from the
/// saliency of the motor, dead times, and the change of the fundamental's slope within a period.
#ifndef LODESTAR_PORT_COMMON_SEQUENTIAL_H
#define LODESTAR_PORT_COMMON_SEQUENTIAL_H

#include "lodestar/lodestar.h"

typedef struct {
    float f_pwm_Hz;
    float i_gain_A_count; ///< the same as in the drive
    float duty_max;       ///< a phase cannot be sampled beyond this duty; 1: in-line shunts
    float L_H;            ///< mean of Ld and Lq; 0: no correction of the ripple
    float delay_s[3];     ///< of phases a, b, c from t_k to the sample; negative: before it
} port_sequential_config_t;

/// The values of one period.
typedef struct {
    float duty[3];
    bool on;
} port_sequential_period_t;

typedef struct {
    float share[3];     ///< delays as shares of the period
    float rise_count_V; ///< change of a phase current per volt over a period, counts
    float duty_max;
    float last[3];                   ///< last result, counts
    bool known[3];                   ///< `last` is valid
    port_sequential_period_t before; ///< until t_k
    port_sequential_period_t after;  ///< from t_k on
} port_sequential_t;

void port_sequential_init(port_sequential_t *self, const port_sequential_config_t *config);

/// Converts the three sampled counts to those at t_k. With the gates off they stay unchanged. Interrupt.
void port_sequential_read(port_sequential_t *self, float v_bus_V, uint16_t count[3]);

/// Takes the duties of the next period; `on`: all six gates switch with them. Interrupt.
void port_sequential_write(port_sequential_t *self, lode_abc_t duty, bool on);

#endif
