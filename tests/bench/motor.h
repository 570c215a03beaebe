/// The motor, brake and inverter that the budget's drives are recorded with. For the host only.
#ifndef BENCH_MOTOR_H
#define BENCH_MOTOR_H

#include "drives.h"

typedef struct {
    double id_A;
    double iq_A;
    double omega_rad_s; ///< electrical
    double theta_rad;
    double u_alpha_V; ///< mean of the last period
    double u_beta_V;
} motor_t;

/// Phase currents, A.
void motor_phases(const motor_t *motor, double i_A[3]);

/// What is coupled to the shaft.
typedef enum {
    SHAFT_FREE,    ///< a tenth of the torque of the operating point, while it turns
    SHAFT_DRAGGED, ///< a machine that keeps the rotor a quarter turn behind the current vector
    SHAFT_BRAKED   ///< a brake that takes the torque of the operating point at its speed, steeply
} shaft_t;

/// One PWM period with the output `acting`.
void motor_period(motor_t *motor, lode_drive_out_t acting, double v_bus_V, shaft_t shaft);

#endif
