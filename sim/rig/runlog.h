/// The log of a run: rows of named columns, and events.
#ifndef RIG_RUNLOG_H
#define RIG_RUNLOG_H

#include <stdbool.h>
#include <stddef.h>

/// One row, in SI units or in the unit of the name.
typedef struct {
    double t_s;
    double phase; ///< index
    double mode;  ///< lode_mode_t
    double speed_command_rpm, speed_ref_rpm, speed_rpm, speed_est_rpm;
    double theta_e_rad, theta_est_rad, angle_error_deg;
    double id_A, iq_A;         ///< in the true rotor frame
    double i1_A, i2_A;         ///< d and q in the frame of control, as measured
    double i1_ref_A, i2_ref_A; ///< their references
    double u1_V, u2_V;
    double i_alpha_A, i_beta_A; ///< input of the estimator: current at t_s,
    double u_alpha_V, u_beta_V; ///< and the mean voltage over the period that begins there
    double e_alpha_V, e_beta_V; ///< observer's raw output
    double e_true_alpha_V, e_true_beta_V;
    double ia_A, ib_A, ic_A;
    double duty_a, duty_b, duty_c;
    // Six phases only.
    double ia2_A, ib2_A, ic2_A;
    double ix_A, iy_A;
    double e_true_x_V, e_true_y_V;
    double duty_a2, duty_b2, duty_c2;
    double open_phase; ///< broken, 1 .. 6; 0: none
    double found_open; ///< found by the drive, lode_open_phase_t
    // All.
    double v_bus_V;
    double lock;
    double torque_Nm, load_Nm, load_est_Nm;
    // With signal injection only.
    double w_h;                  ///< share of injection in the position error
    double er_h_deg, er_e_deg;   ///< position error from injection, and from the EMF
    double Lq_H;                 ///< of the motor at its currents
    double Lq_est_H, psi_est_Wb; ///< as used by the drive
    double Lq_confidence;        ///< confidence in the learned value
    // With adaptation only.
    double adapted_J_kgm2, adapted_J_confidence;
    double adapted_psi_Wb, adapted_psi_confidence;
    double adapted_Rs_Ohm, adapted_Rs_confidence;
    // With derating only.
    double winding_heat;  ///< as derating computes it; 1: that of the continuous current
    double derated_share; ///< of the torque, as permitted by derating
} runlog_row_t;

enum { RUNLOG_ADAPTED = 3, RUNLOG_DERATED };

typedef struct {
    const char *name;
    size_t offset; ///< of a double in runlog_row_t
    int digits;
    int sets;     ///< 2: six phases only; RUNLOG_ADAPTED, RUNLOG_DERATED: with that only
    bool by_wave; ///< with signal injection only
} runlog_column_t;

/// The columns in the order of a file; NULL-terminated by name.
extern const runlog_column_t runlog_columns[];

typedef struct {
    double t_s;
    char text[160];
} runlog_event_t;

enum { RUNLOG_EVENTS_MAX = 100 };

typedef struct {
    runlog_row_t *row;
    size_t rows, capacity;
    int sets;     ///< of windings; 0 counts as 1
    bool by_wave; ///< with signal injection
    bool adapts, derates;
    int events;
    int events_dropped;
    runlog_event_t event[RUNLOG_EVENTS_MAX];
    struct capture *capture; ///< recorders of the library; NULL: none
} runlog_t;

void runlog_init(runlog_t *self);
void runlog_free(runlog_t *self);

/// False after a message if out of memory.
bool runlog_add(runlog_t *self, const runlog_row_t *row);

void runlog_note(runlog_t *self, double t_s, const char *text);

/// True for a column that this log has.
bool runlog_has(const runlog_t *self, const runlog_column_t *column);

double runlog_value(const runlog_row_t *row, const runlog_column_t *column);

#endif
