/// The motor, brake and inverter that the budget's drives are recorded with. For the host only. With two
/// three-phase sets each of them makes the torque, and has the load and the inertia, of a motor with one.
#ifndef BENCH_MOTOR_H
#define BENCH_MOTOR_H

#include "drives.h"

typedef struct {
    int sets;             ///< 1, or 2 that stand 30 degrees apart
    double Ld_H;          ///< the other inductance is BENCH_L_H
    double Ld_fall_per_A; ///< share of Ld that current along the magnet takes away
    double
        braked_rad_s; ///< electrical speed at which the brake takes the torque of the operating point
    double id_A;
    double iq_A;
    double omega_rad_s; ///< electrical
    double theta_rad;
    double x_A; ///< half the difference between the sets' currents, mirrored; stator axes
    double y_A;
    double u_alpha_V; ///< mean of the last period
    double u_beta_V;
} motor_t;

/// Phase currents of set 0 or 1, A.
void motor_phases(const motor_t *motor, int set, double i_A[3]);

/// What is coupled to the shaft.
typedef enum {
    SHAFT_FREE,    ///< a tenth of the torque of the operating point, while it turns
    SHAFT_DRAGGED, ///< a machine that keeps the rotor a quarter turn behind the current vector
    SHAFT_BRAKED   ///< a brake that takes the torque of the operating point at a speed, steeply
} shaft_t;

/// One PWM period with the outputs `applied` of all sets, whose gates are all on or all off.
void motor_period(motor_t *motor, const lode_drive_out_t *applied, double v_bus_V, shaft_t shaft);

#endif
