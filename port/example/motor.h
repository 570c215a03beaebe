/// The motor on the bench. The values are those of a small 24 V servo motor (4 pole pairs, 3000 rpm, 0.2 Nm
/// class): replace them by those of your motor, or give your own file with -DLODE_MOTOR_H=<path>.
/// docs/configuration.md has the ranges; lodestar/motor.h converts from data sheets' units.
#ifndef LODESTAR_PORT_MOTOR_H
#define LODESTAR_PORT_MOTOR_H

#include "lodestar/lodestar.h"

static inline lode_motor_t motor_data(void) {
    return (lode_motor_t){
        .pole_pairs = 4.0f,
        .Rs_Ohm = 0.6f,    ///< per phase, star: half of the resistance between two terminals
        .Ld_H = 0.6e-3f,   ///< phase
        .Lq_H = 0.6e-3f,   ///< phase
        .psi_Wb = 6.5e-3f, ///< peak EMF of a phase per electrical rad/s
        .J_kgm2 = 3.0e-5f, ///< rotor and load
        .B_Nms = 1.0e-5f,  ///< viscous friction
    };
}

/// Optional, from commissioning: how Lq falls with the current, 1/A, and the dead time that acts, in place of the board's.
// #define MOTOR_LQ_FALL_1_A 0.02f
// #define MOTOR_DEAD_TIME_s 0.5e-6f

/// Largest amplitude of the phase current; the board's own limit applies if it is lower.
#define MOTOR_I_MAX_A 5.0f
/// Speed that the modes "run" and the application command at first, mechanical.
#define MOTOR_SPEED_rad_s 150.0f

#endif
