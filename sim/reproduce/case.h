/// One experiment of a paper: the chain of estimators, the conditions, and the results.
#ifndef RIG_REPRODUCE_CASE_H
#define RIG_REPRODUCE_CASE_H

#include <stdint.h>

#include "config/rig_config.h"
#include "rig/runlog.h"

/// What stands between the sampled signals and the duties. All have the paper's gains.
typedef enum {
    CHAIN_PRINTED,    ///< the paper's own form, forward Euler, as printed
    CHAIN_CONTINUOUS, ///< the same equations integrated in continuous time
    CHAIN_SAMPLED,    ///< the library's exact form, its lag compensated where the paper compensates
    CHAIN_EXACT,      ///< the same with its lag compensated in the QPLL too
    CHAIN_CORRECTED,  ///< the same, with the EMF of the active flux
    CHAIN_LIBRARY,    ///< the library's own design, without the paper's gains
    CHAIN_EQ14,       ///< as printed, with the speed of eq. 14; QPLL only
    CHAINS
} case_chain_t;

/// The inverter, and whether its dead time and drops are corrected.
typedef enum { CASE_IDEAL, CASE_COMPENSATED, CASE_BARE, CASE_INVERTERS } case_inverter_t;

const char *case_chain_name(case_chain_t chain);

typedef enum { METHOD_QPLL, METHOD_ENHANCED, METHODS } case_method_t;

typedef enum {
    CASE_NO_LOAD,
    CASE_RATED,           ///< rated load, then a step to no load
    CASE_STAIRCASE,       ///< 300 .. 1500 rpm without load
    CASE_STAIRCASE_RATED, ///< the same with rated load
    CASE_LQ_DOWN,         ///< rated load, Lq of the firmware 1, 0.75, 0.5 times the true one
    CASE_LQ_UP,           ///< 1, 1.25, 1.5, 2 times
    CASE_RS_DOWN,
    CASE_RS_UP,
    CASE_START,        ///< I-f from standstill, hand-over at 100 rpm, then 300 and 900 rpm; no load
    CASE_START_SPREAD, ///< the same with all random values of start.ini
    CASE_KINDS
} case_kind_t;

#define CASE_PAPER "jiang2022"
#define CASE_RATED_Nm 5.0
#define CASE_WINDOW_s 0.4 // steady values are those of this last part of a phase
// Time until the speed has recovered: ten times 1/(55 rad/s), the loop's crossover
#define CASE_SWING_s 0.2
enum { CASE_STEPS = 5 };   // of the staircase: 300, 600 .. 1500 rpm
enum { CASE_ORDERS = 12 }; // of ripple that are evaluated
#define CASE_STEP_rpm 300.0
#define CASE_RAMP_rpm_s 2000.0

typedef struct {
    case_kind_t kind;
    case_method_t method;
    case_chain_t chain;
    case_inverter_t inverter;
    double speed_rpm; ///< not of a staircase and a start
    double Ld_factor; ///< Ld of the firmware over the true one; 0: 1
    uint64_t seed;    ///< of the noise and all random values
} case_t;

bool case_same(const case_t *a, const case_t *b);

enum { CASE_LEVELS_MAX = 4 };

/// The factors of a mismatch, starting with 1. Returns their number; 0: `kind` has none.
int case_levels(case_kind_t kind, double factor[CASE_LEVELS_MAX]);

/// Angles electrical, estimate - truth. NaN: the chain had lost the rotor, or the case was not run.
typedef struct {
    double dc_deg, pp_deg; ///< steady
    double speed_error_rpm, speed_error_pp_rpm;
    // Load off: largest deviation from the steady mean.
    double swing_deg;         ///< of the angle error, while the speed oscillates
    double step_deg;          ///< of the angle error, to the end of the phase
    double step_speed_rpm;    ///< of the real speed
    double step_estimate_rpm; ///< of the speed error
    double ripple_order; ///< ripples per electrical turn: the largest of orders 1 .. CASE_ORDERS
    // Staircase.
    double stair_dc_deg[CASE_STEPS], stair_pp_deg[CASE_STEPS];
    double level_dc_deg[CASE_LEVELS_MAX], level_pp_deg[CASE_LEVELS_MAX]; ///< mismatch
    double level_speed_rpm[CASE_LEVELS_MAX];                             ///< its speed error
    double ramp_dc_deg;  ///< largest mean error over the second half of a ramp
    double ramp_max_deg; ///< largest deviation from the mean before a ramp, to the end of its phase
    double lost_s;       ///< NaN: never
    double simulated_s;
    double started;   ///< 1: it reached 900 rpm, 0: it did not
    unsigned reseeds; ///< how often the library's supervision reacquired the angle
} case_result_t;

/// Loads motor, drive and plant of the paper, with and without its controllers. False after a message.
typedef struct {
    rig_config_t paper, library;
} case_bases_t;

bool case_load(case_bases_t *bases);

/// Runs the case. `log`, initially empty, takes every period; NULL: not wanted. False after a message.
bool case_run(const case_t *what, const case_bases_t *bases, case_result_t *result, runlog_t *log);

/// Start of the last phase, s: the load is removed, or the last step of the staircase begins.
double case_last_phase_s(const case_t *what);

/// Time at which the rotor is released and the estimator works alone, s.
double case_released_s(void);

#endif
