/// The drive of a dual three-phase machine: six phases, 30 degrees between the sets, isolated neutrals. One call per PWM
/// period, from ADC counts to duties, as in drive.h, whose rules for interrupt and main loop apply.
///
/// It contains a lode_drive_t for everything that does not depend on the number of phases. Commands go to that drive
/// (`lode_drive_post_command(&drive6.drive, ...)`), and lode_drive_telemetry() reads it; its currents and voltages are
/// those of the alpha-beta plane.
#ifndef LODESTAR_DRIVE6_H
#define LODESTAR_DRIVE6_H

#include "lodestar/drive.h"
#include "lodestar/modulator6.h"
#include "lodestar/open_phase.h"
#include "lodestar/xy.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Voltages and currents that the estimator uses in RUN.
typedef enum {
    LODE_SOURCE_VSD,   ///< alpha-beta plane: free of the 5th and 7th harmonics
    LODE_SOURCE_SET_1, ///< only set 1, as of a three-phase machine
    LODE_SOURCE_SET_2
} lode_source_t;

/// Reaction to an open phase.
typedef enum {
    LODE_OPEN_PHASE_TRIP,  ///< fault
    LODE_OPEN_PHASE_GO_ON, ///< the other set continues alone, with at most half of the torque
    LODE_OPEN_PHASE_IGNORE
} lode_open_phase_response_t;

/// Configuration of a six-phase drive. lode_drive6_design() computes each field that may be 0, and is, from the
/// others.
typedef struct {
    /// as for three phases; motor and inverter values of ONE phase; motor.sets counts as 2
    lode_drive_config_t drive;
    float Lxy_H; ///< required: inductance of the xy plane, that of the leakage
    lode_source_t source;
    lode_xy_config_t xy;
    lode_open_phase_response_t open_phase;
} lode_drive6_config_t;

/// All that is derived from a configuration. The step never writes it.
typedef struct {
    lode_drive_tuning_t drive; ///< both sets driven
    lode_drive_tuning_t alone; ///< one set driven, the other without current
    lode_xy_tuning_t xy;
    lode_open_phase_tuning_t watch;
    uint_least16_t source;     ///< lode_source_t
    uint_least16_t open_phase; ///< lode_open_phase_response_t
} lode_drive6_tuning_t;

/// ADC results of one period, sampled at t_k. Bus voltage and stamp are taken from set 1, the temperature from the
/// hotter power stage. A trip of either set counts.
typedef struct {
    lode_counts_t set[LODE_SETS];
} lode_counts6_t;

typedef struct {
    lode_drive_out_t set[LODE_SETS];
} lode_drive6_out_t;

/// Which sets are driven.
typedef enum { LODE_SETS_BOTH, LODE_SETS_ONLY_1, LODE_SETS_ONLY_2 } lode_active_t;

/// A drive. The members are visible for static allocation; only the functions below write them.
typedef struct {
    lode_drive_t drive; ///< common part, with sensing and voltages of set 1
    const lode_drive6_tuning_t *tuning;
    const lode_drive6_tuning_t
        *posted_tuning; ///< mailbox: posted tuning; NULL: none, or already taken
    lode_sense_t sense_2;
    lode_shorted_t shorted_2;
    lode_inverter_t inverter_2;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_plausibility_t plausibility_2;
    lode_frozen_t frozen_2;
#endif
    lode_sense_sums_t sums_2;
    lode_abc_t duty_2;
    lode_ab_t i_xy_A;
    lode_ab_t u_xy_V; ///< in the frame that turns with -theta
    lode_xy_t xy;
    lode_open_phase_watch_t watch;
    lode_open_phase_t open;  ///< phase found open; 0: none
    uint_least8_t active;    ///< lode_active_t
    uint_least8_t still;     ///< rounds since both sets have kept all counts at two checks in a row
    uint_least8_t omitted_2; ///< as in lode_drive_t
} lode_drive6_t;

/// Everything that a control period starts from, valid at t_k.
typedef struct {
    lode_sample_t machine; ///< alpha-beta plane, or the only driven set; phase currents of set 1
    lode_sample_t set_2;
    lode_ab_t u_seen_V; ///< voltage that the estimator uses: mean over [t_k-1, t_k)
    lode_ab_t i_seen_A; ///< current that it uses
    lode_sets_t i_A;    ///< current of each set, stator axes
} lode_sample6_t;

/// A consistent snapshot of one control period.
typedef struct {
    lode_telemetry_t drive;
    lode_abc_t duty_2;
    lode_ab_t i_xy_A;
    lode_ab_t u_xy_V;
    lode_active_t active;
    lode_open_phase_t open;
} lode_telemetry6_t;

/// Computes every field of `config` that is left open. lode_drive6_tune() and the host tool call it.
void lode_drive6_design(lode_drive6_config_t *config);

/// The motor that one set sees while the other carries no current. Its inductances are those of both planes
/// together (V8).
lode_motor_t lode_drive6_motor_alone(const lode_motor_t *motor, float Lxy_H);

/// Completes a copy of `config`, checks every field and derives the tuning. On any error `tuning` is left alone.
/// Not for the interrupt; about 3.7 KB of stack (Cortex-M4F, gcc 12.2).
lode_status_t lode_drive6_tune(lode_drive6_tuning_t *tuning, const lode_drive6_config_t *config);

// Their names tell what is left out of the build (options.h).
#define lode_drive6_begin LODE_SYMBOL(lode_drive6_begin)
#define lode_drive6_init LODE_SYMBOL(lode_drive6_init)

/// Initialises a drive in OFF on a tuning from lode_drive6_tune(). Errors as lode_drive_begin().
lode_status_t lode_drive6_begin(lode_drive6_t *self, const lode_drive6_tuning_t *tuning);

/// lode_drive6_tune(), then lode_drive6_begin(). On any error `self` and `tuning` are left alone.
lode_status_t lode_drive6_init(lode_drive6_t *self, lode_drive6_tuning_t *tuning,
                               const lode_drive6_config_t *config);

/// One control period, to be called from the PWM interrupt. Accepts any input: the run time is bounded. No
/// allocation.
lode_drive6_out_t lode_drive6_step(lode_drive6_t *self, const lode_counts6_t *counts);

/// The three parts of the step, to be called in this order instead of it. A host may replace the second one by an
/// estimate of its own, as in drive.h; the i_A of that is machine.i_A in the rotor's frame.
lode_sample6_t lode_drive6_sense(lode_drive6_t *self, const lode_counts6_t *counts);
lode_estimate_t lode_drive6_estimate(lode_drive6_t *self, const lode_sample6_t *sample);
lode_drive6_out_t lode_drive6_act(lode_drive6_t *self, const lode_sample6_t *sample,
                                  const lode_estimate_t *estimate);

/// Posts a tuning for the next control period, with the errors of lode_drive_post_tuning(). Use only this with six
/// phases.
lode_status_t lode_drive6_post_tuning(lode_drive6_t *self, const lode_drive6_tuning_t *tuning);
bool lode_drive6_tuning_taken(const lode_drive6_t *self);

/// Takes a snapshot of the last control period, as lode_drive_telemetry().
bool lode_drive6_telemetry(const lode_drive6_t *self, lode_telemetry6_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
