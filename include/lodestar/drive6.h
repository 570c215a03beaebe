/// The drive of a dual three-phase machine (six phases, 30 degrees apart, isolated neutrals): one call per
/// PWM period, from ADC counts to duties, as in drive.h.
///
/// It holds a lode_drive_t for everything that does not depend on the number of phases. Commands go to that
/// (`lode_drive_post_command(&drive6.drive, ...)`), and lode_drive_telemetry() reads it; its currents and
/// voltages are those of the alpha-beta plane.
#ifndef LODESTAR_DRIVE6_H
#define LODESTAR_DRIVE6_H

#include "lodestar/drive.h"
#include "lodestar/modulator6.h"
#include "lodestar/open_phase.h"
#include "lodestar/xy.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Which voltages and currents the estimator sees in RUN.
typedef enum {
    LODE_SOURCE_VSD,   ///< alpha-beta: free of the 5th and 7th harmonics
    LODE_SOURCE_SET_1, ///< set 1 alone, as of a three-phase machine
    LODE_SOURCE_SET_2
} lode_source_t;

/// Reaction to an open phase.
typedef enum {
    LODE_OPEN_PHASE_TRIP,  ///< a fault
    LODE_OPEN_PHASE_GO_ON, ///< the other set continues alone, with at most half the torque
    LODE_OPEN_PHASE_IGNORE
} lode_open_phase_response_t;

/// A field that may be 0 is then computed from the others.
typedef struct {
    lode_drive_config_t
        drive;   ///< as for three phases; motor and inverter of ONE phase; sets counts as 2
    float Lxy_H; ///< required: inductance of the xy plane, i.e. of the leakage
    lode_source_t source;
    lode_xy_config_t xy;
    lode_open_phase_response_t open_phase;
} lode_drive6_config_t;

/// Everything derived from a configuration, never written by the step.
typedef struct {
    lode_drive_tuning_t drive; ///< both sets
    lode_drive_tuning_t alone; ///< one set, the other without current
    lode_xy_tuning_t xy;
    lode_open_phase_tuning_t watch;
    uint_least16_t source;     ///< lode_source_t
    uint_least16_t open_phase; ///< lode_open_phase_response_t
} lode_drive6_tuning_t;

/// The raw results of one period. Bus voltage and stamp are those of set 1, the hotter power stage
/// counts, and either may trip.
typedef struct {
    lode_counts_t set[LODE_SETS];
} lode_counts6_t;

typedef struct {
    lode_drive_out_t set[LODE_SETS];
} lode_drive6_out_t;

/// Which sets are driven.
typedef enum { LODE_SETS_BOTH, LODE_SETS_ONLY_1, LODE_SETS_ONLY_2 } lode_active_t;

/// A drive. Visible for static allocation; written by its functions only.
typedef struct {
    lode_drive_t drive; ///< with the sensing and the voltages of set 1
    const lode_drive6_tuning_t *tuning;
    const lode_drive6_tuning_t *posted_tuning; ///< mailbox: NULL when taken
    lode_sense_t sense_2;
    lode_inverter_t inverter_2;
    lode_plausibility_t plausibility_2;
    lode_sense_sums_t sums_2;
    lode_abc_t duty_2;
    lode_ab_t i_xy_A;
    lode_ab_t u_xy_V; ///< in the frame that turns with -theta
    lode_xy_t xy;
    lode_open_phase_watch_t watch;
    lode_open_phase_t open;  ///< the phase found open, 0: none
    uint_least8_t active;    ///< lode_active_t
    uint_least8_t still;     ///< rounds since both sets have kept all counts at two looks
    uint_least8_t omitted_2; ///< as in lode_drive_t
} lode_drive6_t;

/// Inputs of a period.
typedef struct {
    lode_sample_t machine; ///< alpha-beta plane, or the set that is driven alone; phases of set 1
    lode_sample_t set_2;
    lode_ab_t u_seen_V; ///< by the estimator: mean voltage over [t_k-1, t_k)
    lode_ab_t i_seen_A;
    lode_sets_t i_A; ///< of each set, stator axes
} lode_sample6_t;

/// A consistent snapshot of one period.
typedef struct {
    lode_telemetry_t drive;
    lode_abc_t duty_2;
    lode_ab_t i_xy_A;
    lode_ab_t u_xy_V;
    lode_active_t active;
    lode_open_phase_t open;
} lode_telemetry6_t;

/// Computes every value that `config` leaves at 0. Used by lode_drive6_tune() and the host tool alike.
void lode_drive6_design(lode_drive6_config_t *config);

/// The machine as one set alone sees it, while the other carries no current: it spans both planes (V8).
lode_motor_t lode_drive6_motor_alone(const lode_motor_t *motor, float Lxy_H);

/// Completes a copy of `config`, checks every field and derives the tuning. On any error `tuning` is
/// unchanged. Not for the interrupt; about 3.7 KB of stack (Cortex-M4F, gcc 12.2).
lode_status_t lode_drive6_tune(lode_drive6_tuning_t *tuning, const lode_drive6_config_t *config);

/// A drive at rest in OFF on a tuning that lode_drive6_tune() has made. Errors as of lode_drive_begin().
lode_status_t lode_drive6_begin(lode_drive6_t *self, const lode_drive6_tuning_t *tuning);

/// lode_drive6_tune(), then lode_drive6_begin(). On any error both are unchanged.
lode_status_t lode_drive6_init(lode_drive6_t *self, lode_drive6_tuning_t *tuning,
                               const lode_drive6_config_t *config);

/// One PWM period. Any input is allowed: it returns in bounded time. No allocation.
lode_drive6_out_t lode_drive6_step(lode_drive6_t *self, const lode_counts6_t *counts);

/// The step is these three calls in a row. A host may put an estimate of its own in place of the second,
/// as in drive.h; its i_A is machine.i_A in the rotor's frame.
lode_sample6_t lode_drive6_sense(lode_drive6_t *self, const lode_counts6_t *counts);
lode_estimate_t lode_drive6_estimate(lode_drive6_t *self, const lode_sample6_t *sample);
lode_drive6_out_t lode_drive6_act(lode_drive6_t *self, const lode_sample6_t *sample,
                                  const lode_estimate_t *estimate);

/// Posts a tuning for the next period. Use it in place of lode_drive_post_tuning().
lode_status_t lode_drive6_post_tuning(lode_drive6_t *self, const lode_drive6_tuning_t *tuning);
bool lode_drive6_tuning_taken(const lode_drive6_t *self);

/// A snapshot of the last period, as lode_drive_telemetry().
bool lode_drive6_telemetry(const lode_drive6_t *self, lode_telemetry6_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
