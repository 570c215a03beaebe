#include "config/speed_limits.h"
#include "references_inline.h"

#include <math.h>
#include <stdbool.h>

enum { SETTLING_STEPS = 100, BISECTIONS = 50 };
#define SCAN_FROM_rad_s 1.0
#define SCAN_RATIO 1.01
#define TORQUE_WITHOUT_END_Nm 1.0e9f

static double radius_V(const lode_drive_config_t *config) {
    return (double)config->current.voltage_use * (double)config->inverter.v_bus_V / sqrt(3.0);
}

/// The currents of the largest torque at this speed, without the voltage limit. A saturating Lq follows iq from
/// step to step.
static lode_dq_t most_current(const lode_references_tuning_t *tuning, double omega_rad_s) {
    lode_references_t state;
    lode_references_reset(&state, 0.0f);
    lode_references_out_t out = {{0.0f, 0.0f}, {0.0f, 0.0f}};
    for (int k = 0; k < SETTLING_STEPS; ++k) {
        const lode_references_voltage_t voltage = {.u_V = {0.0f, 0.0f}};
        out = lode_references_step(&state, tuning, TORQUE_WITHOUT_END_Nm, (float)omega_rad_s, 0.0f,
                                   voltage);
    }
    return out.i_A;
}

static double saturated_Lq_H(const lode_drive_config_t *config, lode_dq_t i) {
    return (double)config->motor.Lq_H /
           (1.0 + (double)config->references.Lq_fall * fabs((double)i.q));
}

/// Steady voltage at this speed with the currents of the largest torque.
static double voltage_needed(const lode_drive_config_t *config,
                             const lode_references_tuning_t *tuning, double omega_rad_s) {
    const lode_motor_t *motor = &config->motor;
    const lode_dq_t i = most_current(tuning, omega_rad_s);
    const double R = (double)motor->Rs_Ohm + (double)config->inverter.r_on_Ohm;
    const double Lq = saturated_Lq_H(config, i);
    const double ud = R * (double)i.d - omega_rad_s * Lq * (double)i.q;
    const double flux = (double)motor->psi_Wb + (double)motor->Ld_H * (double)i.d;
    return hypot(ud, R * (double)i.q + omega_rad_s * flux);
}

/// For references without weakening and without the bus limits, which do not act at the nominal bus voltage.
static bool tune_references(lode_references_tuning_t *tuning, const lode_drive_config_t *config) {
    lode_references_config_t references = config->references;
    references.field_weakening = LODE_OFF;
    references.v_regen_V = 0.0f;
    references.v_motor_V = 0.0f;
    return lode_references_tune(tuning, &references, &config->inverter, &config->motor,
                                config->current.voltage_use, 1.0f / config->f_pwm_Hz) == LODE_OK;
}

/// The first speed on the way up at which the voltage is used up.
static double base_speed(const lode_drive_config_t *config, double end_rad_s) {
    lode_references_tuning_t tuning;
    if (!tune_references(&tuning, config)) {
        return NAN;
    }
    const double radius = radius_V(config);
    double high = SCAN_FROM_rad_s;
    while (high < end_rad_s && voltage_needed(config, &tuning, high) < radius) {
        high *= SCAN_RATIO;
    }
    double low = high > SCAN_FROM_rad_s ? high / SCAN_RATIO : 0.0;
    for (int k = 0; k < BISECTIONS; ++k) {
        const double middle = 0.5 * (low + high);
        *(voltage_needed(config, &tuning, middle) < radius ? &low : &high) = middle;
    }
    return low;
}

/// Voltage with id_max against the magnets and no torque.
static double weakened_speed(const lode_drive_config_t *config) {
    const lode_references_config_t *references = &config->references;
    if (references->field_weakening != LODE_ON) {
        return NAN;
    }
    const double id = (double)references->id_max_A;
    const double flux = (double)config->motor.psi_Wb - (double)config->motor.Ld_H * id;
    const double R = (double)config->motor.Rs_Ohm + (double)config->inverter.r_on_Ohm;
    const double used = (double)references->voltage_use * radius_V(config);
    return flux > 0.0 ? sqrt(fmax(used * used - R * id * R * id, 0.0)) / flux : HUGE_VAL;
}

double speed_limits_torque_Nm(const lode_drive_config_t *config, double omega_rad_s) {
    lode_references_tuning_t tuning;
    if (!tune_references(&tuning, config)) {
        return NAN;
    }
    const lode_dq_t i = most_current(&tuning, omega_rad_s);
    lode_motor_t motor = config->motor;
    motor.Lq_H = (float)saturated_Lq_H(config, i);
    return (double)lode_motor_torque_Nm(&motor, i);
}

double speed_limits_id_A(const lode_drive_config_t *config, double omega_rad_s) {
    lode_references_tuning_t tuning;
    return tune_references(&tuning, config) ? (double)most_current(&tuning, omega_rad_s).d : NAN;
}

/// Base speed for the current that is left for a steady load.
static double rated_torque_speed(const lode_drive_config_t *config, double end_rad_s) {
    lode_drive_config_t steady = *config;
    steady.inverter.i_max_A /= (float)SPEED_LIMITS_CONTROL;
    steady.references.id_max_A =
        fminf(steady.references.id_max_A, steady.inverter.i_max_A); // otherwise it would be refused
    return base_speed(&steady, end_rad_s);
}

speed_limits_t speed_limits_of(const lode_drive_config_t *config) {
    const double no_load = radius_V(config) / (double)config->motor.psi_Wb;
    return (speed_limits_t){
        .base_rad_s = base_speed(config, 4.0 * no_load),
        .rated_torque_rad_s = rated_torque_speed(config, 4.0 * no_load),
        .no_load_rad_s = no_load,
        .weakened_rad_s = weakened_speed(config),
        .estimator_rad_s = (double)config->estimator.omega_max_rad_s,
        .least_rad_s =
            config->hfi.mode == LODE_HFI_ON ? 0.0 : (double)config->speed.omega_min_rad_s,
    };
}

double speed_limits_highest_rad_s(const speed_limits_t *limits) {
    const double voltage =
        isnan(limits->weakened_rad_s) ? limits->no_load_rad_s : limits->weakened_rad_s;
    return fmin(voltage, limits->estimator_rad_s);
}
