/// The averaged plant with a recorded voltage, with a simple C interface for scripts.
#ifndef PLANT_REPLAY_H
#define PLANT_REPLAY_H

/// Parameters, in this order. v_bus_V only limits the voltage; it must exceed the line-line EMF.
enum {
    PLANT_REPLAY_POLE_PAIRS,
    PLANT_REPLAY_RS_OHM,
    PLANT_REPLAY_LD_H,
    PLANT_REPLAY_LQ_H,
    PLANT_REPLAY_PSI_WB,
    PLANT_REPLAY_J_KGM2,
    PLANT_REPLAY_B_NMS,
    PLANT_REPLAY_V_BUS_V,
    PLANT_REPLAY_PERIOD_S,
    PLANT_REPLAY_THETA_E_RAD,   ///< in row 0
    PLANT_REPLAY_OMEGA_M_RAD_S, ///< in row 0
    PLANT_REPLAY_PARAMETERS
};

/// Columns of a row of the result, values at t_k.
enum {
    PLANT_REPLAY_I_ALPHA_A,
    PLANT_REPLAY_I_BETA_A,
    PLANT_REPLAY_THETA_OUT_RAD,
    PLANT_REPLAY_OMEGA_OUT_RAD_S, ///< mechanical
    PLANT_REPLAY_TORQUE_NM,
    PLANT_REPLAY_COLUMNS
};

/// Starts without current at row 0 and applies u[k] over [t_k, t_k+1) for k = 0..rows-1.
///
/// `omega_m_rad_s` prescribes the mean speed of each period; NULL lets the shaft run against
/// `load_Nm` (signed, one per period; NULL: none). `out` takes rows x PLANT_REPLAY_COLUMNS values.
/// Returns 0, or 1 if the parameters are refused.
int plant_replay(const double parameter[PLANT_REPLAY_PARAMETERS], int rows, const double *u_alpha_V,
                 const double *u_beta_V, const double *omega_m_rad_s, const double *load_Nm,
                 double *out);

#endif
