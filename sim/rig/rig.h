/// A drive of the library on its plant, with one interface for three and six phases.
#ifndef RIG_RIG_H
#define RIG_RIG_H

#include "config/rig_config.h"
#include "rig/bus.h"
#include "rig/euler.h"
#include "rig/limits.h"

#include "lodestar/adaptation6.h"
#include "lodestar/encoder.h"
#include "lodestar/learn.h"

/// State of an estimator other than the drive's own.
typedef struct {
    double seeded_s; ///< until then the true values replace the estimate of `seeded`
    euler_config_t euler_config;
    euler_t euler;
    double counts_per_turn, turns; ///< angle sensor: the shaft's angle
    double theta_e_rad;            ///< one period ago
    lode_encoder_tuning_t encoder_tuning;
    lode_encoder_t encoder;
} runner_memory_t;

/// Source of an estimate; other estimators can be inserted here.
typedef lode_estimate_t (*runner_estimator_t)(lode_drive_t *drive, const lode_sample_t *sample,
                                              const plant_truth_t *truth, runner_memory_t *memory);

/// One period, seen from outside.
typedef struct {
    plant_truth_t truth;
    lode_estimate_t estimate; ///< six phases: the part of it in the telemetry
} rig_moment_t;

/// Not to be copied: `drive` points into it.
typedef struct {
    plant_t plant;
    int sets;
    lode_drive_t *drive; ///< the drive of three phases, or the one within that of six phases
    lode_drive_t three;
    lode_drive_tuning_t three_tuning[2]; ///< in use, and the next one
    lode_adaptation_t adaptation;        ///< where `adapts`
    bool adapts;
    uint32_t adapt_every; ///< periods
    lode_drive6_t six;
    lode_drive6_tuning_t six_tuning[2];
    lode_adaptation6_t adaptation6; ///< where `adapts`
    lode_drive_config_t learning;   ///< the configuration that takes the learned values
    lode_learn_tuning_t learn_tuning;
    lode_learn_t learn;
    bool learns; ///< hfi.learn
    /// tuning that the adaptation shall post as soon as it can; NULL: none
    const lode_drive_tuning_t *posts;
    const lode_drive6_tuning_t *posts6; ///< the same for six phases
    limits_t limits;
    bus_t bus;
} rig_t;

/// LODE_OK, or why the library refuses `config`. plant_init() has accepted `plant`. There are no limits of supply and heat
/// and no chopper until the caller sets `limits` and `bus`.
lode_status_t rig_init(rig_t *self, const rig_config_t *config, const plant_config_t *plant);

/// From the next period on the firmware uses these motor parameters. LODE_OK, or why the library refuses them.
lode_status_t rig_retune(rig_t *self, const rig_config_t *config, const lode_motor_t *motor);

/// The telemetry as that main loop has it, with the learned parameters of the motor.
void rig_tell(const rig_t *self, lode_telemetry_t *telemetry);

/// The firmware's main loop, called in every period: limits the torque, and learns if hfi.learn is on.
void rig_main_loop(rig_t *self);

/// The motor's Lq at its present currents, psi_q/i_q.
double rig_true_Lq_H(const rig_t *self);

/// `to` becomes an independent rig in the same state.
void rig_copy(rig_t *to, const rig_t *from);

/// The samples of the ADC, as the drive takes them.
lode_counts_t rig_counts(const plant_counts_t *plant);

/// Duties and gates of a set, 0 or 1, to the plant.
void rig_write_set(plant_t *plant, int set, const lode_drive_out_t *out);

/// One period: samples, the drive's step, duties, and the plant up to the next sample. Six phases can use only
/// their own estimator.
void rig_step(rig_t *self, runner_estimator_t estimate, runner_memory_t *memory, rig_moment_t *now);

/// The phase that the six-phase drive has found open, 1 .. 6; 7, 8: a whole set; 0: none.
int rig_found_open(const rig_t *self);

/// The current that the estimator has used in this period, and the voltage that acts until the next period,
/// which it will use then. In stator axes; 0 with the gates off, but the current of a trip stays.
lode_ab_t rig_seen_i_A(const rig_t *self);
lode_ab_t rig_next_u_V(const rig_t *self);

/// Duties of the second set, as the last call wrote them.
lode_abc_t rig_duty_2(const rig_t *self);

#endif
