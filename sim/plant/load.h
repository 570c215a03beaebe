/// Loads on the shaft other than a constant torque: a fan, stiction, once-per-turn ripple, cogging, and
/// a second mass on an elastic shaft with backlash.
///
/// With the load's mechanical angle a and speed w, T the constant torque (config.h):
///     T_load = T (1 + r cos a) + F w |w|                                                     (M8)
/// A passive T opposes motion, and at standstill holds up to T (1 + r cos a) + stiction. Cogging acts on
/// the rotor, at its mechanical angle a_m:
///     T_cog = C sin(n a_m)                                                                   (M9)
/// A second mass takes the load from the rotor and gives back, with the twist e = a_m - a beyond half of
/// the gap b on either side,
///     T_shaft = K (e -+ b/2) + D de/dt, 0 inside the gap                                     (M10)
#ifndef PLANT_LOAD_H
#define PLANT_LOAD_H

#include "plant/motor.h"

/// Torque on the rotor other than the motor's torque and viscous friction; constant in one step.
typedef struct {
    double load_Nm;
    double inv_J; ///< 0 if a dynamometer, or the load at standstill, holds the speed
} plant_shaft_t;

void plant_load_init(plant_motor_t *motor, const plant_config_t *config);

/// For a step of h_s, with the motor's torque at its start. Only if motor->has_load.
plant_shaft_t plant_load_shaft(const plant_motor_t *motor, double torque_Nm, double h_s);

/// Moves the second mass, which must exist, through a step, after the rotor, which was at `before`.
void plant_load_follow(plant_motor_t *motor, const plant_motor_state_t *before, double h_s);

/// The load stops the rotor when its speed passes zero.
bool plant_load_stops(const plant_motor_t *motor);

/// Square of the fastest natural frequency of the loads on the shaft, 1/s2.
double plant_load_swing2(const plant_motor_t *motor);

#endif
