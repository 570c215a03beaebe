/// An angle sensor: encoder, resolver or Hall switches. A tracking loop turns its counts into angle and speed, which
/// replace the drive's own estimate from standstill on. Where the EMF is large enough, the drive's estimator
/// checks them.
///
/// In the interrupt, in place of lode_drive_step():
///
///     const lode_sample_t sample = lode_drive_sense(&drive, &counts);
///     const lode_estimate_t own = lode_drive_estimate(&drive, &sample);
///     const lode_estimate_t by_sensor =
///         lode_encoder_estimate(&encoder, &encoder_tuning, &own, sample.i_A, count);
///     const lode_drive_out_t out = lode_drive_act(&drive, &sample, &by_sensor);
#ifndef LODESTAR_ENCODER_H
#define LODESTAR_ENCODER_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    uint32_t counts_per_turn; ///< of one MECHANICAL turn, 6 .. 2^20; Hall switches: 6 per pole pair
    bool reversed;            ///< counts down at positive speed
    float offset_rad;         ///< electrical rotor angle in the middle of count 0, +-pi
    float delay_s;            ///< age of a count at t_k, 0 .. 10 periods
    float bandwidth_rad_s; ///< of the tracking loop, 1 .. 1/Ts; 0: 0.1/Ts, less for coarse counts
    /// ELECTRICAL speed from which the EMF checks the sensor; 0: the least speed of the drive without a sensor
    float omega_check_rad_s;
    float check_s; ///< for which EMF and sensor must disagree, 1 period .. 10 s; 0: 5 ms
    /// if they disagree, run without the sensor from then on; else LOST_LOCK trips
    bool falls_back;
} lode_encoder_config_t;

typedef struct {
    uint32_t counts_per_turn;
    uint32_t pole_pairs;
    uint32_t check_periods;
    uint32_t settle_periods; ///< after the gates have come on, in which the EMF is not used
    float rad_per_count;     ///< electrical, negative if reversed
    float half_rad;          ///< half a count, electrical
    float offset_rad;
    float ts_s;
    float delay_s;
    float angle_gain; ///< rad per rad
    float speed_gain; ///< rad/s per rad
    float omega_check;
    bool falls_back;
    bool coarse;          ///< edges are followed
    float acc_per_torque; ///< coarse counts: 1.5 np^2/J
    float acc_per_omega;  ///< B/J
    float psi_Wb;
    float salient_H; ///< Ld - Lq
    float load_most; ///< electrical acceleration, rad/s^2
} lode_encoder_tuning_t;

typedef struct {
    float
        theta_rad; ///< electrical, at the instant of the count; coarse counts: as if no edge were overdue
    float omega_rad_s;
    float seen_rad;     ///< middle of the last count
    float since_s;      ///< coarse counts: time since the last edge
    float acc_rad_s2;   ///< by torque and friction, electrical
    float load_rad_s2;  ///< by the load, from edge to edge
    uint32_t disagreed; ///< periods running
    uint32_t
        unseen; ///< periods that the EMF, of a drive whose gates have come on, is given to be found
    bool tracks;     ///< a count has been seen
    bool distrusted; ///< the EMF disagreed for check_s; until the next reset
} lode_encoder_t;

/// Checks a configuration for the motor and rate of `drive`. On any error `tuning` is unchanged.
lode_status_t lode_encoder_tune(lode_encoder_tuning_t *tuning, const lode_encoder_config_t *config,
                                const lode_drive_tuning_t *drive);

/// Resets everything: the next count gives the angle, the rotor being assumed at rest.
void lode_encoder_reset(lode_encoder_t *self);

/// The estimate to act on in this period: angle and speed at t_k by the sensor, or `own` where the drive
/// falls back. `i_A`: current at t_k. `count`: 0 .. counts_per_turn - 1; more is reduced.
lode_estimate_t lode_encoder_estimate(lode_encoder_t *self, const lode_encoder_tuning_t *tuning,
                                      const lode_estimate_t *own, lode_ab_t i_A, uint32_t count);

/// What `offset_rad` should have been, from the estimate `own` of a drive that runs without the sensor and
/// the count of the same period. For bring-up: average the differences over some turns.
float lode_encoder_offset_rad(const lode_encoder_tuning_t *tuning, const lode_estimate_t *own,
                              uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
