/// One experiment of a paper: which chain of estimators, under what circumstances, and what it showed.
#ifndef RIG_REPRODUCE_CASE_H
#define RIG_REPRODUCE_CASE_H

#include "config/rig_config.h"
#include "rig/runlog.h"

/// What stands between the sampled signals and the duties. All have the paper's gains.
typedef enum {
    CHAIN_PRINTED,   ///< the paper's own form, forward Euler, as printed
    CHAIN_EXACT,     ///< the library's estimator in its place
    CHAIN_CORRECTED, ///< the same, with the EMF of the active flux, and dead-time correction
    CHAIN_LIBRARY,   ///< what the library designs by itself, with nothing of the paper's gains
    CHAIN_PRINTED_CORRECTED, ///< as printed, but with dead-time correction
    CHAIN_EQ14,              ///< as printed, with the speed of eq. 14; QPLL only
    CHAINS
} case_chain_t;

const char *case_chain_name(case_chain_t chain);

typedef enum { METHOD_QPLL, METHOD_ENHANCED, METHODS } case_method_t;

typedef enum {
    CASE_NO_LOAD,
    CASE_RATED,           ///< rated load, then off at once
    CASE_STAIRCASE,       ///< 300 .. 1500 rpm without load
    CASE_STAIRCASE_RATED, ///< the same with rated load
    CASE_LQ_DOWN,         ///< rated load, Lq of the firmware 1, 0.75, 0.5 times the true one
    CASE_LQ_UP,           ///< 1, 1.25, 1.5, 2 times
    CASE_RS_DOWN,
    CASE_RS_UP,
    CASE_KINDS
} case_kind_t;

#define CASE_PAPER "jiang2022"
#define CASE_RATED_Nm 5.0
#define CASE_WINDOW_s 0.4 // steady figures are those of this last part of a phase
#define CASE_SWING_s                                                                               \
    0.2 // by then the speed has come back: ten times 1/(55 rad/s), the loop's crossover
enum { CASE_STEPS = 5 }; // of the staircase: 300, 600 .. 1500 rpm
#define CASE_STEP_rpm 300.0
#define CASE_RAMP_rpm_s 2000.0

typedef struct {
    case_kind_t kind;
    case_method_t method;
    case_chain_t chain;
    double speed_rpm; ///< not of a staircase
    bool ideal;       ///< behind an inverter without dead time, drops and switching
} case_t;

enum { CASE_LEVELS_MAX = 4 };

/// The factors of a mismatch, from 1 on. Returns how many; 0: `kind` has none.
int case_levels(case_kind_t kind, double factor[CASE_LEVELS_MAX]);

/// Angles electrical, estimate - truth. NaN: the chain had lost the rotor, or it was not tried.
typedef struct {
    double dc_deg, pp_deg; ///< steady
    double speed_error_rpm, speed_error_pp_rpm;
    // Load off: largest deviation from the steady mean.
    double swing_deg;         ///< of the angle error, while the speed swings
    double step_deg;          ///< of the angle error, to the end of the phase
    double step_speed_rpm;    ///< of the real speed
    double step_estimate_rpm; ///< of the speed error
    // Staircase.
    double stair_dc_deg[CASE_STEPS], stair_pp_deg[CASE_STEPS];
    double level_dc_deg[CASE_LEVELS_MAX], level_pp_deg[CASE_LEVELS_MAX]; ///< mismatch
    double level_speed_rpm[CASE_LEVELS_MAX];                             ///< its speed error
    double ramp_dc_deg;  ///< largest mean error over the second half of a ramp
    double ramp_max_deg; ///< largest deviation from the mean before a ramp, to the end of its phase
    double lost_s;       ///< NaN: never
    double simulated_s;
    unsigned reseeds; ///< how often the library's supervision acquired the angle anew
} case_result_t;

/// Motor, drive and plant of the paper, with its controllers and without. False after a message.
typedef struct {
    rig_config_t paper, library;
} case_bases_t;

bool case_load(case_bases_t *bases);

/// Runs it. `log`, empty, takes every period; NULL: not wanted. False after a message.
bool case_run(const case_t *what, const case_bases_t *bases, case_result_t *result, runlog_t *log);

/// When the last phase began, s: the load goes off, or the last step of the staircase.
double case_last_phase_s(const case_t *what);

/// When the rotor is released and the estimator on its own, s.
double case_released_s(void);

#endif
