/// A drive of the library on its plant, with three phases or six behind one face.
#ifndef RIG_RIG_H
#define RIG_RIG_H

#include "config/rig_config.h"
#include "rig/bus.h"
#include "rig/euler.h"

#include "lodestar/adaptation6.h"
#include "lodestar/encoder.h"
#include "lodestar/learn.h"

/// What an estimator other than the drive's own has to remember.
typedef struct {
    double seeded_s; ///< until then `seeded` is driven by the truth
    euler_config_t euler_config;
    euler_t euler;
    double counts_per_turn, turns; ///< of the angle sensor: the shaft's angle
    double theta_e_rad;            ///< one period ago
    lode_encoder_tuning_t encoder_tuning;
    lode_encoder_t encoder;
} runner_memory_t;

/// Where an estimate comes from: the place at which other estimators can be compared.
typedef lode_estimate_t (*runner_estimator_t)(lode_drive_t *drive, const lode_sample_t *sample,
                                              const plant_truth_t *truth, runner_memory_t *memory);

/// One period as seen from outside.
typedef struct {
    plant_truth_t truth;
    lode_estimate_t estimate; ///< of six phases: what telemetry tells of it
} rig_moment_t;

/// Not to be copied: `drive` points into it.
typedef struct {
    plant_t plant;
    int sets;
    lode_drive_t *drive; ///< that of three phases, or the one within that of six
    lode_drive_t three;
    lode_drive_tuning_t three_tuning[2]; ///< in use, and the next one
    lode_adaptation_t adaptation;        ///< where `adapts`
    bool adapts;
    uint32_t adapt_every; ///< periods
    lode_drive6_t six;
    lode_drive6_tuning_t six_tuning[2];
    lode_adaptation6_t adaptation6; ///< where `adapts`
    lode_drive_config_t learning;   ///< what is learned goes into
    lode_learn_tuning_t learn_tuning;
    lode_learn_t learn;
    bool learns; ///< hfi.learn
    const lode_drive_tuning_t
        *posts; ///< what the adaptation shall post as soon as it can; NULL: nothing
    const lode_drive6_tuning_t *posts6; ///< the same of six phases
    bus_t bus;
} rig_t;

/// LODE_OK, or what the library refuses of `config`. `plant` has been accepted by plant_init(). Without limits of the
/// supply and without chopper: the caller sets `bus`.
lode_status_t rig_init(rig_t *self, const rig_config_t *config, const plant_config_t *plant);

/// From the next period on the firmware takes this for its motor. LODE_OK, or why not.
lode_status_t rig_retune(rig_t *self, const rig_config_t *config, const lode_motor_t *motor);

/// The telemetry as that main loop has it: with what it has found of the motor.
void rig_tell(const rig_t *self, lode_telemetry_t *telemetry);

/// The firmware's main loop, in every period: limits the supply's current, and learns, where hfi.learn asks for it.
void rig_main_loop(rig_t *self);

/// The motor's Lq at its present currents, psi_q/i_q.
double rig_true_Lq_H(const rig_t *self);

/// `to` becomes an independent rig in the same state.
void rig_copy(rig_t *to, const rig_t *from);

/// What the ADC has sampled, as the drive takes it.
lode_counts_t rig_counts(const plant_counts_t *plant);

/// Duties and gates of a set, 0 or 1, to the plant.
void rig_write_set(plant_t *plant, int set, const lode_drive_out_t *out);

/// One period: samples, the drive's step, duties, and the plant up to the next sample. Six phases have
/// their own estimator only.
void rig_step(rig_t *self, runner_estimator_t estimate, runner_memory_t *memory, rig_moment_t *now);

/// The phase that the six-phase drive has found open, 1 .. 6, 7 and 8 for a whole set; 0: none.
int rig_found_open(const rig_t *self);

/// What the estimator has seen in this period, and the voltage that acts until the next one, which it will
/// see then. In stator axes; 0 with the gates off, but the current that tripped stays.
lode_ab_t rig_seen_i_A(const rig_t *self);
lode_ab_t rig_next_u_V(const rig_t *self);

/// Duties of the second set, as the last call wrote them.
lode_abc_t rig_duty_2(const rig_t *self);

#endif
