/// Speed control: a ramped reference, a PI controller in torque, load-torque feed-forward.
#ifndef LODESTAR_SPEED_H
#define LODESTAR_SPEED_H

#include "lodestar/inverter.h"
#include "lodestar/motor.h"
#include "lodestar/pi.h"
#include "lodestar/pll.h"
#include "lodestar/ramp.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float kp_Nms; ///< torque per mechanical rad/s; 0: from the bandwidth
    float ki_Nm;  ///< torque per mechanical rad; 0: kp times bandwidth/4
    /// crossover; 0: a quarter of the PLL's sigma at low speed, at most 13 over the run-up time, less by (K16) and (K22)
    float bandwidth_rad_s;
    /// factor by which both gains rise with the PLL's sigma, 1 .. 10; 0: as sigma does, less by (K16) and (K22), or 1
    /// (not at all) where kp_Nms is given
    float gain_rise;
    float
        ramp_rad_s2; ///< slope of the MECHANICAL speed reference; 0: up to half the torque limit over J
    float ramp_down_rad_s2;     ///< the same while it slows down; 0: ramp_rad_s2
    float jerk_rad_s3;          ///< largest rate of change of that slope; 0: at once
    float inertia_feed_forward; ///< share of the torque that the ramp needs for J, 0 .. 1; 0: 1;
                                ///< LODE_NONE: none
    /// share of the estimated load torque, 0 .. 1; 0: 0.25 to 0.5, less by (K23), where a rated load would otherwise stop
    /// the rotor at its least speed, 0.5 with injection, otherwise none; LODE_NONE: none
    float load_feed_forward;
    /// least ELECTRICAL speed that is controlled without a sensor; 0: hand-over
    float omega_min_rad_s;
    lode_choice_t every_period; ///< on: control in every period, whatever the bandwidth; auto: off
} lode_speed_config_t;

typedef struct {
    lode_pi_tuning_t pi;
    float rise; ///< gain_rise - 1
    float
        inv_span; ///< 1/(electrical speed up to which the gains are not raised; they are in full at twice that)
    float inv_pole_pairs;
    float ramp_step; ///< mechanical rad/s per period
#ifndef LODE_WITHOUT_SHAPED_RAMP
    float ramp_down_step; ///< of a reference that slows down
    float jerk_step; ///< change of a step, per period; 0: any, and ramp_down_step is not looked at
#endif
    float load_feed_forward;
    float inertia_Nm; ///< torque per mechanical rad/s and period
} lode_speed_tuning_t;

typedef struct {
    lode_pi_t pi;
    float reference_rad_s; ///< ramped reference, mechanical
#ifndef LODE_WITHOUT_SHAPED_RAMP
    float step_rad_s; ///< the last step of a ramp with jerk_step
    float left_rad_s; ///< what its sum is more than a float can tell
#endif
    float torque_Nm;       ///< torque reference
    lode_range_t limit_Nm; ///< within which it stays; the drive keeps it up to date
} lode_speed_t;

/// What else is in the loop that speed control closes (K22).
typedef struct {
    float delay_s;       ///< by which observer, current control and speed control itself are late
    float damping_rad_s; ///< by which the EMF slows down a rotor four times lighter than configured
} lode_speed_loop_t;

/// `injects`: by injection the rotor is held at standstill too.
void lode_speed_design(lode_speed_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_motor_t *motor, const lode_pll_config_t *pll,
                       const lode_speed_loop_t *loop, float omega_handover_rad_s, bool injects);

lode_status_t lode_speed_tune(lode_speed_tuning_t *tuning, const lode_speed_config_t *config,
                              const lode_motor_t *motor, const lode_pll_config_t *pll, float ts_s);

/// Starts from the MECHANICAL speed `omega_rad_s` with the torque `torque_Nm`, without a step, and within
/// `most_Nm` of either sign. `load_Nm`: the present load torque; the share of it that is fed forward is a part of
/// `torque_Nm`.
void lode_speed_reset(lode_speed_t *self, const lode_speed_tuning_t *tuning, float omega_rad_s,
                      float torque_Nm, float load_Nm, float most_Nm);

#ifdef __cplusplus
}
#endif

#endif
