/// Currents that one ADC samples one after the other, brought to t_k. No hardware in here.
///
/// All samples lie in the zero vector around t_k, with all low sides on. There a phase current moves by two
/// things: the ripple, whose slope is minus the mean voltage of the phase over the inductance, and the
/// fundamental, whose slope is that of the last period. Both are taken off. What is left: the saliency of
/// the motor, dead times, and how the fundamental's slope changes within a period.
#ifndef LODESTAR_PORT_COMMON_SEQUENTIAL_H
#define LODESTAR_PORT_COMMON_SEQUENTIAL_H

#include "lodestar/lodestar.h"

typedef struct {
    float f_pwm_Hz;
    float i_gain_A_count; ///< as the drive's
    float duty_max;       ///< beyond it a phase shows nothing; 1: in line
    float L_H;            ///< mean of Ld and Lq; 0: the ripple stays
    float delay_s[3];     ///< of phases a, b, c from t_k to the sample; negative: before it
} port_sequential_config_t;

/// What acts in one period.
typedef struct {
    float duty[3];
    bool on;
} port_sequential_period_t;

typedef struct {
    float share[3];     ///< delays, of the period
    float rise_count_V; ///< that a volt over a period makes of a phase current, counts
    float duty_max;
    float last[3];                   ///< what was handed out, counts
    bool known[3];                   ///< `last` is a current
    port_sequential_period_t before; ///< until t_k
    port_sequential_period_t after;  ///< from t_k on
} port_sequential_t;

void port_sequential_init(port_sequential_t *self, const port_sequential_config_t *config);

/// Turns the three counts as sampled into those at t_k. Without gates they stay as they are. Interrupt.
void port_sequential_read(port_sequential_t *self, float v_bus_V, uint16_t count[3]);

/// The duties of the next period; `on`: all six gates switch by them. Interrupt.
void port_sequential_write(port_sequential_t *self, lode_abc_t duty, bool on);

#endif
