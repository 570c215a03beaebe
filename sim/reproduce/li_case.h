/// One experiment of paper 2 (Li, Hu, Ma, Liu): the observer and its form, the conditions, and the results.
#ifndef RIG_REPRODUCE_LI_CASE_H
#define RIG_REPRODUCE_LI_CASE_H

#include <stddef.h>

#include "config/rig_config.h"
#include "lodestar/drive6.h"
#include "reproduce/case.h"

#define LI_PAPER "li-fa-leso"
/// Motor, drive and plant: a stand-in for the paper's, whose table is not available.
#define LI_MACHINE "eldeeb2017"
/// Our assumption, because the paper gives no rated load: its load steps of 80 % are then 5 Nm.
#define LI_RATED_Nm 6.25
#define LI_STEP_Nm (0.8 * LI_RATED_Nm)
/// That torque over 3 np psi, at id = 0.
#define LI_RATED_A (LI_RATED_Nm / (3.0 * 5.0 * 0.1746))
/// Steady values are those of this last part of a stage: whole turns at 25, 50 and 70 Hz.
#define LI_WINDOW_s 1.0
#define LI_LOAD_RISE_s 2.0e-4

typedef enum { LI_C, LI_GI, LI_FA, LI_OBSERVERS } li_observer_t;

/// The columns of the table.
typedef enum {
    LI_PRINTED,       ///< forward Euler, nothing compensated; ideal inverter
    LI_PRINTED_DEAD,  ///< the same with 2 us of dead time, nothing corrected
    LI_UNCOMPENSATED, ///< the library's observer and PLL; ideal inverter
    LI_EXACT,         ///< the same, compensated
    LI_CORRECTED,     ///< the same with 2 us of dead time, corrected
    LI_PRINTED_QPLL,  ///< LI_PRINTED with a QPLL in place of the LESO-QPLL
    LI_COLUMNS
} li_column_t;

/// The equations of the paper: in forward Euler, integrated in continuous time, in the library's form.
typedef enum { LI_EULER, LI_CONTINUOUS, LI_SAMPLED, LI_FORMS } li_form_t;

enum { LI_STAGES_MAX = 6, LI_ORDERS = 5 };

/// A stage of the experiment; it begins with a change.
typedef struct {
    double duration_s, speed_rpm, load_Nm;
    double Rs_factor, Lq_factor; ///< values of the firmware over the true ones; 0: 1
    double load_rise_s;          ///< 0: LI_LOAD_RISE_s
} li_stage_t;

typedef struct {
    li_observer_t observer;
    li_form_t form;
    case_inverter_t inverter;
    bool compensated; ///< the lag; LI_SAMPLED only, as the paper compensates nothing
    bool qpll;        ///< in place of the LESO-QPLL
    uint64_t seed;    ///< of the noise and all random values
    lode_source_t source;
    double k2_rad_s, sigma_rad_s; ///< 0: of the file
    double id_A;                  ///< magnitude of the negative id*
    double harmonics;             ///< 5th and 7th in the EMF, share of the fundamental
    bool plain_xy;                ///< no resonator on the xy currents
    int stages;
    li_stage_t stage[LI_STAGES_MAX];
} li_case_t;

/// Results of a stage. Angles electrical, estimate - truth. NaN: the rotor was lost, or does not turn at the
/// commanded speed.
typedef struct {
    // Over the last LI_WINDOW_s.
    double mean_deg, pp_deg;
    double speed_rpm;
    double e_V;                     ///< fundamental of the estimated EMF
    double id_A, iq_A;              ///< estimated frame
    double harmonic_pct[LI_ORDERS]; ///< 1st, 5th, 7th, 11th, 13th of the estimated alpha EMF
    double xy_A;                    ///< largest |i_xy|
    // Over the whole stage.
    double peak_deg;  ///< largest error
    double swing_deg; ///< largest deviation from the mean before
    double swing_rpm; ///< of the estimated speed from the real one
} li_stage_result_t;

typedef struct {
    li_stage_result_t stage[LI_STAGES_MAX];
    double lost_s; ///< since the release; NaN: never
    double simulated_s;
} li_result_t;

/// The signals of the plots: every period since the release.
typedef struct {
    double t_s, error_deg, speed_rpm, speed_error_rpm;
    double theta_rad, theta_est_rad;
    double e_alpha_V, e_beta_V; ///< estimated
    double i_xy_A;
} li_row_t;

typedef struct {
    size_t rows, capacity;
    li_row_t *row;
} li_log_t;

bool li_case_same(const li_case_t *a, const li_case_t *b);

/// The form and the inverter of that column.
li_case_t li_case_in(li_case_t what, li_column_t column);

void li_log_free(li_log_t *self);

/// Loads the file and applies `set`. False after a message.
bool li_case_load(rig_config_t *base);

/// Runs the case. `log`, initially empty, takes every period; NULL: not wanted. False after a message.
bool li_case_run(const li_case_t *what, const rig_config_t *base, li_result_t *result,
                 li_log_t *log);

#endif
