/// Runs a scenario: the drive's step on the plant, period by period.
#ifndef RIG_RUNNER_H
#define RIG_RUNNER_H

#include "rig/reactions.h"
#include "rig/rig.h"
#include "rig/runlog.h"
#include "support/stats.h"

/// Steady values are those of this last part of a phase.
#define RUNNER_WINDOW_s 0.4

/// Time constant of a cell or a fuse, which does not respond to faster changes.
#define RUNNER_SUPPLY_s 0.01

typedef struct {
    char name[RIG_NAME_LENGTH];
    double start_s, end_s;
    double speed_command_rpm, load_Nm;
    // The last RUNNER_WINDOW_s.
    rig_stats_t speed_rpm;
    rig_stats_t speed_error_rpm; ///< estimate - truth
    rig_stats_t error_deg;       ///< estimate - truth, electrical; only if the drive RAN throughout
    rig_stats_t id_A, iq_A;      ///< true rotor frame
    rig_stats_t load_est_Nm;
    rig_stats_t torque_Nm;
    rig_stats_t i_xy_A; ///< length of the vector; six phases
    // The whole phase, as far as the drive RAN.
    rig_stats_t run_error_deg;
    rig_stats_t run_lock;
    /// The whole phase, in any mode: the largest currents drawn from and fed into the supply, filtered with
    /// RUNNER_SUPPLY_s, and the highest bus voltage. NaN if not needed.
    double battery_A, regen_A, v_bus_V;
    /// The whole phase, NaN without derating: the greatest heat of the winding, as the firmware computes it, and the least share
    /// of the torque.
    double heat, derated_share;
    lode_mode_t mode; ///< at the end
    // At the end, NaN without hfi.learn: deviation of the learned Lq from the motor's at its currents.
    double Lq_off_percent, Lq_confidence;
    uint32_t reseeds;
    char missed[200]; ///< missed bars, in words; empty: none
    /// why the commanded speed or torque was changed or not reached, in words; empty: it was reached
    char warning[200];
    int warnings; ///< number of them in `warning`
    bool refused; ///< the drive has refused the command
} runner_phase_t;

/// One entry of the drive's fault log.
typedef struct {
    double t_s;
    lode_fault_t fault;
} runner_fault_t;

typedef struct {
    int phases;
    runner_phase_t phase[RIG_PHASES_MAX];
    lode_fault_t fault; ///< check NONE: none
    double fault_s;
    bool fault_expected;
    bool supervised; ///< it may be started again
    int faults;      ///< number of entries of the drive's fault log, the oldest first
    runner_fault_t logged[REACTIONS_FAULTS];
    double handover_s; ///< first time in RUN, NaN: never
    int retries;       ///< failed attempts of the last start, from the telemetry
    double simulated_s;
    double processor_s;
    bool adapts;
    bool learns;
    lode_telemetry_t last; ///< at the end, with the adapted and learned values
    bool barred;           ///< the scenario sets a bar, or a mode to end in
    bool missed;           ///< a bar
    bool never_ran;        ///< RUN was commanded and not reached, without a fault that ends the run
    bool starts_yet; ///< RUN was lost: the last phase with a speed ended in another start attempt
} runner_result_t;

/// The estimator that [estimator] names.
runner_estimator_t runner_estimator(const rig_config_t *config);

/// Runs all phases. `config` must be complete and designed. False after a message: refused input.
bool runner_run(const rig_config_t *config, runner_estimator_t estimate, runner_result_t *result,
                runlog_t *log);

#endif
