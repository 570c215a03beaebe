/// Motor parameters, and their conversion from the values in data sheets and other tools.
#ifndef LODESTAR_MOTOR_H
#define LODESTAR_MOTOR_H

#include "lodestar/frames.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Values of one phase of the star equivalent; peak values. Example: paper 1, Table 3.
typedef struct {
    float pole_pairs; ///< 1 .. 100, a whole number
    float Rs_Ohm;     ///< phase resistance at working temperature, 0 .. 1e3
    float Ld_H;       ///< d-axis inductance, 1e-7 .. 10
    float Lq_H;       ///< q-axis inductance, 1e-7 .. 10
    float psi_Wb;     ///< peak flux linkage of the magnets per phase, 1e-6 .. 100
    /// inertia of rotor and load, 1e-9 .. 1e4; in doubt enter less: a rotor with ten times this value starts, one
    /// with less than half of it may lose the lock in a load step
    float J_kgm2;
    float B_Nms;             ///< viscous friction, Nm per mechanical rad/s, 0 .. 1e3
    float omega_rated_rad_s; ///< rated ELECTRICAL speed; 0: from bus voltage and current
    float sets;              ///< three-phase windings on the stator: 1 or 2; 0: 1
} lode_motor_t;

/// Torque of a rated load, as a share of that at i_max with id = 0: what defaults are made for.
#define LODE_RATED_SHARE (2.0f / 3.0f)
/// Relative uncertainty of Lq and Ld that defaults and checks allow for.
#define LODE_L_UNSURE 0.2f

/// Returns LODE_OK or the first parameter out of range.
lode_status_t lode_motor_check(const lode_motor_t *motor);

/// Torque per Wb of active flux and A of q current: 1.5 pole pairs per winding (C5, V5).
static inline float lode_motor_torque_factor(const lode_motor_t *motor) {
    return 1.5f * lode_max(motor->sets, 1.0f) * motor->pole_pairs;
}

/// Active flux psi + (Ld - Lq) id, Wb (paper 1, eq. 8; C3).
static inline float lode_motor_active_flux_Wb(const lode_motor_t *motor, float id_A) {
    return motor->psi_Wb + (motor->Ld_H - motor->Lq_H) * id_A;
}

/// Electromagnetic torque, Nm (paper 1, eq. 17; C5).
float lode_motor_torque_Nm(const lode_motor_t *motor, lode_dq_t i_A);

/// Torque per q-axis ampere at id = 0, Nm/A.
float lode_motor_kt_Nm_A(const lode_motor_t *motor);

/// Time from rest to rated speed with the torque of this current at id = 0, s.
float lode_motor_run_up_s(const lode_motor_t *motor, float current_A);

typedef enum { LODE_STAR, LODE_DELTA } lode_winding_t;

/// Phase value of the star equivalent from a resistance or inductance between two terminals: half, for star and
/// delta, which the terminals cannot tell apart.
float lode_phase_from_line_line(float line_line);

/// The same from the value of one winding; for a delta winding a third.
float lode_phase_from_winding(float winding, lode_winding_t connection);

/// psi from the voltage constant, V RMS line to line per 1000 rpm (mechanical).
float lode_psi_from_Vrms_krpm(float Vrms_krpm, float pole_pairs);

/// psi from the peak phase voltage per electrical hertz, V/Hz.
float lode_psi_from_V_Hz(float V_Hz);

/// psi from KV: mechanical rpm per volt of peak line-to-line EMF, as printed on hobby motors.
float lode_psi_from_KV(float rpm_V, float pole_pairs);

/// psi from the torque constant, Nm per A of phase current amplitude.
float lode_psi_from_kt(float Nm_A, float pole_pairs);

/// The inverse conversions, for display: V RMS line to line per 1000 rpm, V/Hz and rpm/V.
float lode_psi_to_Vrms_krpm(float psi_Wb, float pole_pairs);
float lode_psi_to_V_Hz(float psi_Wb);
float lode_psi_to_KV(float psi_Wb, float pole_pairs);

/// Electrical rad/s from mechanical rpm, and back.
float lode_omega_from_rpm(float rpm, float pole_pairs);
float lode_omega_to_rpm(float omega_rad_s, float pole_pairs);

#ifdef __cplusplus
}
#endif

#endif
