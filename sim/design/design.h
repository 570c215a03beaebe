/// Results for a motor and a drive, beyond the library's own values.
#ifndef RIG_DESIGN_H
#define RIG_DESIGN_H

#include "analyse/margins.h"
#include "config/plausible.h"
#include "config/rig_config.h"
#include "config/speed_limits.h"
#include "design/guide.h"
#include "design/hexagon.h"
#include "design/injection.h"
#include "design/limits.h"
#include "design/verdict.h"

enum { DESIGN_SPEEDS = 10 };

/// Results at one speed.
typedef struct {
    double speed_rpm, omega_rad_s;
    double emf_V;
    double lag_deg;            ///< of the observer, exact
    double lag_polynomial_deg; ///< as the firmware computes it
    double lag_eq30_deg;       ///< paper 1, eq. (30), continuous time: 2 atan(w/w0)
    margins_t margins;
    double complex pole; ///< least damped one of observer, PLL and notches together
    double radius;       ///< largest |z| of these poles
} design_speed_t;

typedef struct {
    design_speed_t at[DESIGN_SPEEDS];
    guide_t guide;
    limits_t limits;
    injection_t injection;
    hexagon_t hexagon;
    plausible_t plausible;
    verdict_t verdict;
    double sigma_accepted_rad_s; ///< largest sigma that the library accepts
    double rated_rpm, handover_rpm;
    speed_limits_t speeds;
    double dead_time_V;         ///< fundamental of the dead-time voltage: 4/pi Td f v_bus
    double dead_time_equal_rpm; ///< speed at which the EMF is as large
    double current_bandwidth_rad_s, speed_bandwidth_rad_s;
    double start_current_torque_Nm, torque_max_Nm;
    double signal_check_V,
        signal_check_A; ///< a pulse of (S37), and its largest current; NAN: none, or six phases
    double angle_per_Lq_percent_deg; ///< angle error at i_max for each percent of error of Lq
} design_t;

/// For a designed configuration and its tuning.
void design_compute(design_t *design, const rig_config_t *config,
                    const lode_drive_tuning_t *tuning);

#endif
