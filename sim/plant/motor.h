/// Interior permanent-magnet motor and shaft, integrated over stretches of constant source voltage.
///
/// States id, iq, omega_m, theta_e. With Rt = winding plus on-state resistance, w = np omega_m:
///     dpsi_d/dt = ud - Rt id + w (psi_q - h_d)                                               (M1)
///     dpsi_q/dt = uq - Rt iq - w (psi_d + h_q)                                               (M2)
///     Te = 1.5 np ((psi_d + h_q) iq - (psi_q - h_d) id)                                      (M3)
///     J domega/dt = Te - load - B omega                                                      (M4)
/// with the loads of load.h on the shaft.
/// psi_d = psi + Ld id, psi_q = Lq iq, or of iron that saturates (iron.h); there both fluxes are
/// integrated within a step and the currents follow from them. h is the EMF of the 5th and 7th
/// harmonic per rad/s, in dq; it depends on the angle only, so (M3) takes from the shaft exactly what
/// (M1), (M2) give to the terminals.
///
/// Two sets of windings (plant/sets.h) double (M3) and add states ix, iy in the stationary xy plane,
/// with Lxy and the harmonics h_x, h_y of 5th and 7th order:
///     Lxy dix/dt = ux - Rt ix - w h_x, the same for y;  Te += 3 np (h_x ix + h_y iy)      (M6)
#ifndef PLANT_MOTOR_H
#define PLANT_MOTOR_H

#include "plant/iron.h"
#include "plant/sets.h"

typedef struct {
    double id_A, iq_A;
    double ix_A, iy_A; ///< 0 with one set
    double omega_m_rad_s;
    double theta_e_rad;          ///< not wrapped within a period
    double cos_theta, sin_theta; ///< kept by small rotations, refreshed once a period
    double load_omega_rad_s;     ///< of the second mass
    double twist_rad;            ///< the rotor's mechanical angle less the second mass'
} plant_motor_state_t;

/// See load.h. A field that is 0 switches its effect off.
typedef struct {
    double fan_Nms2, stiction_Nm, load_ripple, cogging_Nm, cogging_per_turn;
    double J_kgm2, shaft_Nm_rad, shaft_Nms_rad, half_gap_rad;
} plant_load_t;

typedef struct {
    double d, q;
} plant_vector_dq_t;

/// psi r exp(j phase), Wb.
typedef struct {
    double re, im;
} plant_harmonic_t;

/// h_d, h_q as sums of a sine and a cosine, Wb.
typedef struct {
    double d_sin, d_cos, q_sin, q_cos;
} plant_ripple_t;

typedef struct {
    plant_motor_state_t x;
    bool speed_is_prescribed;
    bool load_is_passive;
    double load_Nm;
    int turns; ///< electrical, completed: theta + 2 pi turns is np times the mechanical angle
    // Constants from here on.
    bool has_load; ///< any of `load`
    plant_load_t load;
    int sets;
    double power; ///< of two vectors' product: 1.5 per set
    double np, Rs_Ohm, Ld_H, Lq_H, Lxy_H, psi_Wb;
    double inv_Ld, inv_Lq, inv_Lxy, inv_J, J_kgm2, B_Nms;
    plant_iron_t iron; ///< in use where `saturates`
    bool saturates, has_dq_harmonics, has_xy_harmonics;
    bool keeps_accounts;
    bool is_plain;                    ///< one set, linear iron, sinusoidal EMF, no accounts
    plant_ripple_t ripple6, ripple12; ///< h in terms of 6 and 12 theta
    plant_harmonic_t harmonic5, harmonic7, harmonic11, harmonic13;
} plant_motor_t;

/// Voltages on the windings during one stretch; constant in it.
typedef struct {
    /// Source vectors behind the on-state resistance. A single floating phase counts as 0 V in them.
    double u_alpha_V, u_beta_V;
    double u_x_V, u_y_V;
    double R_Ohm;             ///< winding plus on-state resistance
    int floating[PLANT_SETS]; ///< a leg, PLANT_NONE_FLOATS or PLANT_ALL_FLOAT
} plant_drive_t;

/// Terminal voltage that the motor itself gives to a set that floats: integral over a stretch, and
/// at its ends.
typedef struct {
    double u_Vs, u_start_V, u_end_V;               ///< of the single floating phase
    plant_vector_t all_Vs, all_start_V, all_end_V; ///< of the set, when all of it floats
} plant_float_t;

/// Results of one stretch: integrals of the same order as the states ...
typedef struct {
    double i_alpha_As, i_beta_As, i_x_As, i_y_As;
    double i_squared_A2s; ///< of both planes
    double shaft_work_J;  ///< torque times speed
    double friction_J;
    double load_J; ///< into the load or dynamometer
    plant_float_t set[PLANT_SETS];
    // ... and the slopes of the currents, for the search for a change of conduction.
    double did_start_A_s, diq_start_A_s, dix_start_A_s, diy_start_A_s;
} plant_stretch_t;

void plant_motor_init(plant_motor_t *self, const plant_config_t *config);

/// Advances by h_s under `drive`. Third order; h_s at most plant_motor_longest_step.
void plant_motor_step(plant_motor_t *self, const plant_drive_t *drive, double h_s,
                      plant_stretch_t *sum);

/// The longest step that keeps the error far below the resolution of any test, s.
double plant_motor_longest_step(const plant_motor_t *self, double R_Ohm);

/// Brings theta into (-pi, pi] and renews its cosine and sine.
void plant_motor_refresh_angle(plant_motor_t *self);

/// Electrical torque now, Nm.
double plant_motor_torque(const plant_motor_t *self);

/// Slopes and terminal voltages now, in the fields of a stretch's start.
void plant_motor_slopes(const plant_motor_t *self, const plant_drive_t *drive,
                        plant_stretch_t *now);

/// Rate of change of a leg's current from the slopes at a stretch's start, A/s.
double plant_motor_phase_slope(const plant_motor_t *self, const plant_motor_state_t *state,
                               const plant_stretch_t *stretch, int leg);

/// EMF of the active flux plus the harmonics (as observed by an extended-EMF observer); in xy the harmonics. V.
plant_planes_t plant_motor_active_emf(const plant_motor_t *self);

/// The six of two sets.
void plant_motor_leg_currents(const plant_motor_state_t *state, double i_A[PLANT_LEGS]);

/// Fills as many as there are legs.
static inline void plant_motor_phase_currents(const plant_motor_t *self,
                                              const plant_motor_state_t *state,
                                              double i_A[PLANT_LEGS]) {
    if (self->sets == PLANT_SETS) {
        plant_motor_leg_currents(state, i_A);
        return;
    }
    const double alpha = state->id_A * state->cos_theta - state->iq_A * state->sin_theta;
    const double beta = state->id_A * state->sin_theta + state->iq_A * state->cos_theta;
    i_A[0] = alpha;
    i_A[1] = PLANT_SQRT3_2 * beta - 0.5 * alpha;
    i_A[2] = -PLANT_SQRT3_2 * beta - 0.5 * alpha;
}

/// Removes the rounding error of the current of a phase, or of a set, that stopped conducting.
void plant_motor_clear_phase(plant_motor_t *self, int leg);
void plant_motor_clear_set(plant_motor_t *self, int set);

double plant_motor_field_energy(const plant_motor_t *self);
double plant_motor_kinetic_energy(const plant_motor_t *self);

#endif
