#include "design/design.h"

#include <math.h>

#include "lag_inline.h"
#include "support/units.h"

/// Shares of the rated speed for the tables; the highest speed replaces the last one.
static const double shares[DESIGN_SPEEDS] = {0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.5, 0.0};

static void at_speed(design_speed_t *at, const lode_drive_config_t *drive,
                     const lode_drive_tuning_t *tuning, double omega_rad_s) {
    const double np = (double)drive->motor.pole_pairs;
    const float w = (float)omega_rad_s;
    at->omega_rad_s = omega_rad_s;
    at->speed_rpm = rig_rpm_from_rad_s(omega_rad_s) / np;
    at->emf_V = omega_rad_s * (double)drive->motor.psi_Wb;
    at->lag_deg = rig_deg_from_rad(
        (double)lode_emf_lag_rad(&drive->estimator.emf, &drive->motor, 1.0f / drive->f_pwm_Hz, w));
    at->lag_polynomial_deg = rig_deg_from_rad((double)lode_lag_rad(&tuning->estimator.lag, w));
    at->lag_eq30_deg =
        rig_deg_from_rad(2.0 * atan(omega_rad_s / (double)drive->estimator.emf.w0_rad_s));
    at->margins = margins_at(drive, omega_rad_s);
    const joint_t joint = joint_make(&tuning->estimator, omega_rad_s);
    double complex poles[JOINT_STATES_MAX];
    at->pole = joint_poles(&joint, poles) > 0 ? poles[0] : NAN;
    at->radius = joint_radius(&joint);
}

static void pulse_of(design_t *design, const lode_drive_config_t *drive,
                     const lode_drive_tuning_t *tuning) {
    const lode_motor_t *motor = &drive->motor;
    const bool tries = tuning->signal_check.pulses > 0u && !(motor->sets > 1.0f);
    const double L_H = fmin((double)motor->Ld_H, (double)motor->Lq_H);
    design->signal_check_V =
        tries ? (double)tuning->signal_check.pulse * (double)drive->inverter.v_bus_V : NAN;
    design->signal_check_A = design->signal_check_V / ((double)drive->f_pwm_Hz * L_H);
}

void design_compute(design_t *design, const rig_config_t *config,
                    const lode_drive_tuning_t *tuning) {
    const lode_drive_config_t *drive = &config->drive;
    const lode_motor_t *motor = &drive->motor;
    guide_compute(&design->guide, config);
    design->limits = limits_compute(drive);
    design->injection = injection_of(drive);
    design->hexagon = hexagon_of((double)drive->current.voltage_use);
    const double np = (double)motor->pole_pairs;
    const double rated = (double)motor->omega_rated_rad_s;
    const double highest = (double)drive->estimator.omega_max_rad_s;
    const double kt = (double)lode_motor_kt_Nm_A(motor);
    for (int k = 0; k < DESIGN_SPEEDS; ++k) {
        at_speed(&design->at[k], drive, tuning,
                 k == DESIGN_SPEEDS - 1 ? highest : shares[k] * rated);
    }
    design->sigma_accepted_rad_s = margins_sigma_accepted(drive);
    design->rated_rpm = rig_rpm_from_rad_s(rated) / np;
    design->speeds = speed_limits_of(drive);
    design->plausible = plausible_of(drive);
    verdict_compute(&design->verdict, drive, tuning, &design->speeds);
    design->handover_rpm = rig_rpm_from_rad_s((double)drive->start.omega_handover_rad_s) / np;
    design->dead_time_V = 4.0 / RIG_PI * (double)drive->inverter.dead_time_s *
                          (double)drive->f_pwm_Hz * (double)drive->inverter.v_bus_V;
    design->dead_time_equal_rpm =
        rig_rpm_from_rad_s(design->dead_time_V / (double)motor->psi_Wb) / np;
    pulse_of(design, drive, tuning);
    design->current_bandwidth_rad_s = (double)drive->current.kp_q_V_A / (double)motor->Lq_H;
    design->speed_bandwidth_rad_s = (double)drive->speed.kp_Nms / (double)motor->J_kgm2;
    design->start_current_torque_Nm = kt * (double)drive->start.current_A;
    design->torque_max_Nm = kt * (double)drive->inverter.i_max_A;
    design->angle_per_Lq_percent_deg = rig_deg_from_rad(
        0.01 * (double)motor->Lq_H * (double)drive->inverter.i_max_A / (double)motor->psi_Wb);
}
