#include "lodestar/motor.h"

#include "lodestar/config.h"

#include <stddef.h>

// Line-line RMS of a sine to phase amplitude: sqrt(2) / sqrt(3).
#define PEAK_PHASE_PER_RMS_LINE 0.816496580927726f
#define RPM_TO_RAD_S (LODE_TWO_PI / 60.0f)

static bool is_whole(float x) {
    const float difference = x - (float)(int32_t)x;
    return lode_in_range(difference, 0.0f, 0.0f);
}

lode_status_t lode_motor_check(const lode_motor_t *motor) {
    if (motor == NULL) {
        return LODE_ERROR_NULL;
    }
    if (!lode_in_range(motor->pole_pairs, 1.0f, 100.0f) || !is_whole(motor->pole_pairs)) {
        return LODE_ERROR_MOTOR_POLE_PAIRS;
    }
    if (!lode_in_range(motor->Rs_Ohm, 0.0f, 1.0e3f)) {
        return LODE_ERROR_MOTOR_RS;
    }
    if (!lode_in_range(motor->Ld_H, 1.0e-7f, 10.0f)) {
        return LODE_ERROR_MOTOR_LD;
    }
    if (!lode_in_range(motor->Lq_H, 1.0e-7f, 10.0f)) {
        return LODE_ERROR_MOTOR_LQ;
    }
    if (!lode_in_range(motor->psi_Wb, 1.0e-6f, 100.0f)) {
        return LODE_ERROR_MOTOR_PSI;
    }
    if (!lode_in_range(motor->J_kgm2, 1.0e-9f, 1.0e4f)) {
        return LODE_ERROR_MOTOR_J;
    }
    if (!lode_in_range(motor->B_Nms, 0.0f, 1.0e3f)) {
        return LODE_ERROR_MOTOR_B;
    }
    if (!lode_in_range(lode_given_or(motor->omega_rated_rad_s, 1.0f), 1.0f, 1.0e5f)) {
        return LODE_ERROR_MOTOR_OMEGA;
    }
    if (!lode_in_range(motor->sets, 0.0f, 2.0f) || !is_whole(motor->sets)) {
        return LODE_ERROR_MOTOR_SETS;
    }
    return LODE_OK;
}

float lode_motor_torque_Nm(const lode_motor_t *motor, lode_dq_t i_A) {
    return lode_motor_torque_factor(motor) * lode_motor_active_flux_Wb(motor, i_A.d) * i_A.q;
}

float lode_motor_kt_Nm_A(const lode_motor_t *motor) {
    return lode_motor_torque_factor(motor) * motor->psi_Wb;
}

float lode_motor_run_up_s(const lode_motor_t *motor, float current_A) {
    const float torque = lode_motor_kt_Nm_A(motor) * current_A * motor->pole_pairs;
    return motor->J_kgm2 * motor->omega_rated_rad_s / lode_max(torque, FLT_MIN);
}

float lode_phase_from_line_line(float line_line) {
    return 0.5f * line_line;
}

float lode_phase_from_winding(float winding, lode_winding_t connection) {
    return connection == LODE_DELTA ? winding * (1.0f / 3.0f) : winding;
}

float lode_psi_from_Vrms_krpm(float Vrms_krpm, float pole_pairs) {
    return Vrms_krpm * PEAK_PHASE_PER_RMS_LINE / (1000.0f * RPM_TO_RAD_S * pole_pairs);
}

float lode_psi_from_V_Hz(float V_Hz) {
    return V_Hz * (1.0f / LODE_TWO_PI);
}

float lode_psi_from_KV(float rpm_V, float pole_pairs) {
    return 1.0f / (LODE_SQRT3 * RPM_TO_RAD_S * rpm_V * pole_pairs);
}

float lode_psi_from_kt(float Nm_A, float pole_pairs) {
    return Nm_A / (1.5f * pole_pairs);
}

float lode_psi_to_Vrms_krpm(float psi_Wb, float pole_pairs) {
    return psi_Wb * (1000.0f * RPM_TO_RAD_S * pole_pairs) / PEAK_PHASE_PER_RMS_LINE;
}

float lode_psi_to_V_Hz(float psi_Wb) {
    return psi_Wb * LODE_TWO_PI;
}

float lode_psi_to_KV(float psi_Wb, float pole_pairs) {
    return 1.0f / (LODE_SQRT3 * RPM_TO_RAD_S * psi_Wb * pole_pairs);
}

float lode_omega_from_rpm(float rpm, float pole_pairs) {
    return rpm * RPM_TO_RAD_S * pole_pairs;
}

float lode_omega_to_rpm(float omega_rad_s, float pole_pairs) {
    return omega_rad_s / (RPM_TO_RAD_S * pole_pairs);
}
