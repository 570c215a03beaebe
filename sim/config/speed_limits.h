/// The speed limits of a drive.
#ifndef RIG_SPEED_LIMITS_H
#define RIG_SPEED_LIMITS_H

#include "lodestar/drive.h"

/// i_max over the current of rated torque: a third is left to control (control.md, K15).
#define SPEED_LIMITS_CONTROL 1.5

/// Electrical rad/s, at the nominal bus voltage.
typedef struct {
    /// the voltage suffices for i_max with the chosen references up to this speed, without field weakening; 0:
    /// not even at standstill
    double base_rad_s;
    double rated_torque_rad_s; ///< the same for i_max/1.5
    double no_load_rad_s;      ///< the EMF of the magnets uses up the voltage at this speed
    /// the same with the largest negative id that the references may use; infinite: at no speed; NaN: no field
    /// weakening
    double weakened_rad_s;
    double estimator_rad_s; ///< omega_max, the limit of the estimator, whatever the voltage
    double least_rad_s;     ///< omega_min: slower commands are raised to it; 0 with injection
} speed_limits_t;

/// Of a configuration that is designed and that the library accepts.
speed_limits_t speed_limits_of(const lode_drive_config_t *config);

/// The largest torque at this electrical speed with the chosen references, whatever the voltage, Nm.
double speed_limits_torque_Nm(const lode_drive_config_t *config, double omega_rad_s);

/// The d current of that torque, A.
double speed_limits_id_A(const lode_drive_config_t *config, double omega_rad_s);

/// The highest speed that both voltage and estimator allow.
double speed_limits_highest_rad_s(const speed_limits_t *limits);

#endif
