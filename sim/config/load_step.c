#include "config/load_step.h"

#include <math.h>

#include "config/speed_limits.h"

// (K18): the speed dip after a load step, the shares of the feed-forward and of (K47) that act in time, and the speed below
// which the inverter's errors hide the EMF, as a share of the hand-over speed.
#define DIP 0.735759 // 2/e (K15)
#define LATE 1.2
#define FED_IN_TIME 0.5
#define DEEP_IN_TIME 0.5
#define FLOOR_SHARE 0.5
#define OVERSHOOT 0.135335 // 1/e^2: of the torque of (K8) after a load step

/// The factor by which the gains rise with the speed (K8).
static double gain_at(const lode_speed_tuning_t *tuning, double omega_rad_s) {
    const double up = omega_rad_s * (double)tuning->inv_span - 1.0;
    return 1.0 + (double)tuning->rise * fmin(fmax(up, 0.0), 1.0);
}

/// The share of the load that is fed forward (K46).
static double fed_at(const lode_speed_tuning_t *tuning, double omega_rad_s) {
    const double up = 2.0 * omega_rad_s * (double)tuning->inv_span - 1.0;
    return (double)tuning->load_feed_forward - (double)tuning->load_fall * fmin(fmax(up, 0.0), 1.0);
}

/// The load step that makes the speed dip to the lowest usable speed; with injection no speed is too low.
static double by_speed_Nm(const lode_drive_config_t *drive, const lode_speed_tuning_t *tuning,
                          double omega_rad_s) {
    const double room =
        fmax(omega_rad_s - FLOOR_SHARE * (double)drive->start.omega_handover_rad_s, 0.0);
    const double deep = fmax(room - (double)LODE_SPEED_DIP_SHARE * omega_rad_s, 0.0); // (K47)
    const double fed = 1.0 - FED_IN_TIME * fed_at(tuning, omega_rad_s);
    const double kp = gain_at(tuning, omega_rad_s) * (double)drive->speed.kp_Nms;
    if (drive->hfi.mode == LODE_HFI_ON) {
        return HUGE_VAL;
    }
    return (room + DEEP_IN_TIME * (double)tuning->dip_gain * deep) * kp /
           (LATE * DIP * (double)drive->motor.pole_pairs * fed);
}

load_step_t load_step_largest(const lode_drive_config_t *drive, const lode_speed_tuning_t *tuning,
                              double omega_rad_s) {
    const double speed_Nm = by_speed_Nm(drive, tuning, omega_rad_s);
    const double current_Nm = speed_limits_torque_Nm(drive, omega_rad_s) / (1.0 + OVERSHOOT);
    return (load_step_t){.torque_Nm = fmin(speed_Nm, current_Nm),
                         .by_current = current_Nm < speed_Nm};
}
