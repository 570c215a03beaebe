/// Interior permanent-magnet motor and shaft, integrated over stretches of constant source voltage.
///
/// States id, iq, omega_m, theta_e. With Rt = winding plus on-state resistance, w = np omega_m:
///     Ld did/dt = ud - Rt id + w (psi_q - h_d)                                               (M1)
///     dpsi_q/dt = uq - Rt iq - w (psi_d + h_q)                                               (M2)
///     Te = 1.5 np ((psi_d + h_q) iq - (psi_q - h_d) id)                                      (M3)
///     J domega/dt = Te - load - B omega                                                      (M4)
/// psi_d = psi + Ld id, psi_q = Lq_sat iq + (Lq - Lq_sat) iq / (1 + |iq|/i_sat), so each flux
/// depends on its own current only: the field energy is a function of state. h is the EMF of the
/// 5th and 7th harmonic per rad/s, in dq; it depends on the angle only, so (M3) takes from the
/// shaft exactly what (M1), (M2) give to the terminals.
#ifndef PLANT_MOTOR_H
#define PLANT_MOTOR_H

#include "plant_config.h"

typedef struct {
    double id_A, iq_A;
    double omega_m_rad_s;
    double theta_e_rad;          ///< not wrapped within a period
    double cos_theta, sin_theta; ///< kept by small rotations, refreshed once a period
} plant_motor_state_t;

typedef struct {
    plant_motor_state_t x;
    bool speed_is_prescribed;
    bool load_is_passive;
    double load_Nm;
    // Constants from here on.
    double np, Rs_Ohm, Ld_H, Lq_H, Lq_sat_H, psi_Wb, i_sat_A;
    double inv_Ld, inv_Lq, inv_i_sat, inv_J, J_kgm2, B_Nms;
    bool saturates, has_harmonics;
    double h_d_sin, h_d_cos, h_q_sin, h_q_cos; ///< h in terms of sin and cos of 6 theta, Wb
    double harmonic5_re, harmonic5_im, harmonic7_re, harmonic7_im; ///< psi r exp(j phase), Wb
} plant_motor_t;

/// Which phases carry no current.
enum { PLANT_NONE_FLOATS = -1, PLANT_ALL_FLOAT = PLANT_PHASES };

/// What acts on the windings during one stretch; constant in it.
typedef struct {
    /// Source vector behind the on-state resistance. A single floating phase counts as 0 V in it.
    double u_alpha_V, u_beta_V;
    double R_Ohm; ///< winding plus on-state resistance
    int floating; ///< 0..2: this phase; or one of the enumerators above
} plant_drive_t;

/// What happened in one stretch: integrals of the same order as the states ...
typedef struct {
    double i_alpha_As, i_beta_As;
    double i_squared_A2s;
    double shaft_work_J; ///< torque times speed
    double friction_J;
    double load_J;                          ///< into the load or dynamometer
    double u_float_Vs;                      ///< terminal voltage of the single floating phase
    double u_open_alpha_Vs, u_open_beta_Vs; ///< terminal voltage when all float
    // ... and what the search for a change of conduction needs.
    double did_start_A_s, dpsi_q_start_V;  ///< slopes of (M1), (M2)
    double u_float_start_V, u_float_end_V; ///< terminal voltage of the single floating phase
} plant_stretch_t;

void plant_motor_init(plant_motor_t *self, const plant_config_t *config);

/// Advances by h_s under `drive`. Third order; h_s at most plant_motor_longest_step.
void plant_motor_step(plant_motor_t *self, const plant_drive_t *drive, double h_s,
                      plant_stretch_t *sum);

/// The longest step that keeps the error far below what a test could see, s.
double plant_motor_longest_step(const plant_motor_t *self, double R_Ohm);

/// Brings theta into (-pi, pi] and renews its cosine and sine.
void plant_motor_refresh_angle(plant_motor_t *self);

/// Electrical torque now, Nm.
double plant_motor_torque(const plant_motor_t *self);

/// Slopes of id, A/s, and of the q flux, V, now; returns the terminal voltage of the single
/// floating phase, V, or 0 if there is none.
double plant_motor_slopes(const plant_motor_t *self, const plant_drive_t *drive, double *did_A_s,
                          double *dpsi_q_V);

/// Rate of change of a phase's current from those two, A/s.
double plant_motor_phase_slope(const plant_motor_t *self, const plant_motor_state_t *state,
                               double did_A_s, double dpsi_q_V, int phase);

/// Phase EMFs with no current, V, in the state given; they sum to zero.
void plant_motor_open_emf(const plant_motor_t *self, const plant_motor_state_t *state,
                          double emf_V[PLANT_PHASES]);

/// EMF of the active flux plus the harmonics (what an extended-EMF observer sees), V.
void plant_motor_active_emf(const plant_motor_t *self, double *e_alpha_V, double *e_beta_V);

void plant_motor_phase_currents(const plant_motor_state_t *state, double i_A[PLANT_PHASES]);

/// Removes what rounding left of the current of a phase that stopped conducting.
void plant_motor_clear_phase(plant_motor_state_t *state, int phase);

double plant_motor_field_energy(const plant_motor_t *self);
double plant_motor_kinetic_energy(const plant_motor_t *self);

/// Cosine and sine of the axis of a phase.
extern const double plant_axis_cos[PLANT_PHASES];
extern const double plant_axis_sin[PLANT_PHASES];

#endif
