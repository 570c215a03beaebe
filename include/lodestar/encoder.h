/// Angle sensor: encoder, resolver or Hall switches. A tracking loop turns its counts into angle and speed. They
/// replace the drive's own estimate, from standstill on. Where the EMF is large enough, the drive's estimator
/// checks them. docs/theory/encoder.md.
///
/// In the interrupt, instead of lode_drive_step():
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

/// Configuration of the sensor.
typedef struct {
    uint32_t
        counts_per_turn; ///< counts per MECHANICAL turn, 6 .. 2^20; Hall switches: 6 per pole pair
    bool reversed;       ///< it counts down at positive speed
    float offset_rad;    ///< electrical rotor angle in the middle of count 0, -pi .. pi
    float delay_s;       ///< age of a count at t_k, 0 .. 10 control periods
    float bandwidth_rad_s; ///< of the tracking loop, 1 .. 1/Ts; 0: 0.1/Ts, less for coarse counts
    /// ELECTRICAL speed from which the EMF checks the sensor; 0: the drive's lowest speed without a sensor, with
    /// injection the hand-over speed; 1.5 times that for coarse counts (more than 0.2 rad electrical)
    float omega_check_rad_s;
    float check_s; ///< time for which it must disagree, 1 period .. 10 s; 0: 5 ms
    /// on disagreement continue without the sensor; otherwise LOST_LOCK trips
    bool falls_back;
} lode_encoder_config_t;

/// All that is derived from the configuration. Angles and speeds are electrical.
typedef struct {
    uint32_t counts_per_turn;
    uint32_t pole_pairs;
    uint32_t check_periods;  ///< duration of the disagreement
    uint32_t settle_periods; ///< after the gates have come on, before the EMF can be used
    float rad_per_count;     ///< negative if reversed
    float half_rad;          ///< half a count
    float offset_rad;
    float ts_s;
    float delay_s;
    float angle_gain; ///< correction of the angle, rad per rad (A1)
    float speed_gain; ///< correction of the speed, rad/s per rad
    float omega_check;
    bool falls_back;      ///< continue without the sensor on disagreement
    bool coarse;          ///< large counts: the edges are tracked
    float acc_per_torque; ///< coarse counts: 1.5 np^2/J
    float acc_per_omega;  ///< B/J
    float psi_Wb;
    float salient_H; ///< Ld - Lq
    float load_most; ///< largest acceleration by a load, rad/s^2
} lode_encoder_tuning_t;

/// State of the sensor. Angles and speeds are electrical.
typedef struct {
    /// at the instant of the count; coarse counts: without regard to an edge that is overdue
    float theta_rad;
    float omega_rad_s;
    float seen_rad;     ///< angle of the middle of the last count
    float since_s;      ///< coarse counts: time since the last edge
    float acc_rad_s2;   ///< acceleration by torque and friction
    float load_rad_s2;  ///< acceleration by the load, corrected at each edge
    uint32_t disagreed; ///< periods of disagreement in a row
    /// periods that are left, after the gates have come on, until the EMF can be used
    uint32_t unseen;
    bool tracks;     ///< a count has been received
    bool distrusted; ///< the EMF has disagreed for check_s; until the next reset
} lode_encoder_t;

/// Checks a configuration for the motor and the rate of `drive`, and derives the tuning. Errors: NULL, ENCODER_...;
/// `tuning` is then left alone.
lode_status_t lode_encoder_tune(lode_encoder_tuning_t *tuning, const lode_encoder_config_t *config,
                                const lode_drive_tuning_t *drive);

/// Clears the state: the next count gives the angle, and the rotor counts as being at rest.
void lode_encoder_reset(lode_encoder_t *self);

/// The estimate for lode_drive_act() in this period: angle and speed at t_k from the sensor, or `own` if the sensor
/// is no longer used. `own`: from lode_drive_estimate(). `i_A`: current at t_k. `count`: 0 .. counts_per_turn - 1;
/// a larger one is reduced. For the interrupt.
lode_estimate_t lode_encoder_estimate(lode_encoder_t *self, const lode_encoder_tuning_t *tuning,
                                      const lode_estimate_t *own, lode_ab_t i_A, uint32_t count);

/// The correct value of `offset_rad`, from the estimate `own` of a drive that runs without the sensor and the count
/// of the same period. For bring-up: average the deviations over some turns.
float lode_encoder_offset_rad(const lode_encoder_tuning_t *tuning, const lode_estimate_t *own,
                              uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
