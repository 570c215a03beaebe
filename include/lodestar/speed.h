/// Speed control: ramped reference, PI controller with a torque as output, feed-forward of load torque and inertia
/// (K7).
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

/// Share of the reference that a load takes before dip_gain acts (K47).
#define LODE_SPEED_DIP_SHARE 0.3f

/// Factor of both gains, until OFF, each time that speed control has swung (K48) or may have lost the rotor (K51); twice at
/// most.
#define LODE_SPEED_CALM 0.5f

/// Configuration of speed control. Speeds are MECHANICAL unless they are called electrical.
typedef struct {
    float kp_Nms; ///< torque per rad/s; 0: from the bandwidth
    float ki_Nm;  ///< torque per rad; 0: kp times bandwidth/4
    /// crossover of the loop; 0: a quarter of the PLL's sigma at low speed, more where a rated load would stop the rotor (K37),
    /// at most 13 over the run-up time, and what a lighter rotor and an error of Lq leave (K44)
    float bandwidth_rad_s;
    /// factor by which both gains rise with the PLL's sigma, 1 .. 10; 0: as sigma does, less by (K44); if kp_Nms is given: 1,
    /// they do not rise
    float gain_rise;
    /// slope of the speed reference; 0: at most half of the torque limit over J
    float ramp_rad_s2;
    float ramp_down_rad_s2; ///< slope while the reference slows down; 0: ramp_rad_s2
    float jerk_rad_s3;      ///< largest rate of change of the slope (S-curve, K33); 0: no limit
    /// share of the torque that the inertia J needs along the ramp, 0 .. 1; 0: 1; LODE_NONE: none
    float inertia_feed_forward;
    /// share of the estimated load torque that is fed forward at low speed, 0 .. 1; less as the PLL's sigma rises (K46).
    /// LODE_NONE: none. 0: none, but up to 0.5 with injection, and where a rated load stops the rotor within 10 ms (K40)
    float load_feed_forward;
    /// gain beyond kp_Nms, over kp_Nms, where a load has taken more than LODE_SPEED_DIP_SHARE of the speed (K47), 0 .. 10;
    /// 0: 2, or less, so that kp with it makes a bandwidth of at most the PLL's sigma at low speed; none with injection.
    /// LODE_NONE: none
    float dip_gain;
    /// amplitude of torque with which the correction of the speed swings until both gains are halved, twice at most (K48);
    /// 0: 3 % of the torque at i_max/1.5, and never with injection; LODE_NONE: never
    float swing_Nm;
    /// lowest ELECTRICAL speed that is held without an angle sensor; 0: hand-over speed
    float omega_min_rad_s;
    lode_choice_t
        every_period; ///< on: speed control in every control period, whatever the bandwidth; auto: off
} lode_speed_config_t;

/// All that is derived from the configuration. "Per call" means per call of speed control.
typedef struct {
    lode_pi_tuning_t pi;
    float rise; ///< gain_rise - 1
    /// 1/(electrical speed up to which the gains do not rise); they have risen in full at twice that speed
    float inv_span;
    float inv_pole_pairs;
    float ramp_step; ///< largest change of the reference, mechanical rad/s per call
#ifndef LODE_WITHOUT_SHAPED_RAMP
    float ramp_down_step; ///< the same while the reference slows down
    float
        jerk_step; ///< largest change of the step, per call; 0: no limit, and ramp_down_step is not used
#endif
    float dip_gain;    ///< on the error by which a load has slowed the rotor, over pi.kp (K47)
    float dip_least;   ///< smallest reference with it, mechanical rad/s
    float swing_Nm;    ///< amplitude of a half-wave (K48)
    float swing_calls; ///< most calls between two half-waves of a swing
    float load_feed_forward; ///< share up to half of that electrical speed
    float load_fall;         ///< what is missing of it from that speed on (K46)
    float inertia_Nm;        ///< torque per mechanical rad/s of a step of the reference
} lode_speed_tuning_t;

/// What speed control keeps twice, so that a flipped bit is found.
typedef struct {
    float integral_Nm;
    float reference_rad_s;
} lode_speed_copy_t;

/// State of speed control.
typedef struct {
    lode_pi_t pi;
    float reference_rad_s; ///< ramped reference, mechanical
    float left_rad_s;      ///< what rounding has left out of it (K35)
    lode_speed_copy_t copy;
#ifndef LODE_WITHOUT_SHAPED_RAMP
    float step_rad_s; ///< last step of a ramp with jerk_step
#endif
    float torque_Nm;          ///< torque reference
    uint_least16_t swing_age; ///< calls since the last half-wave, at most swing_calls
    uint_least8_t swings;     ///< half-waves of the present swing
    uint_least8_t swung_up;   ///< not 0: the last one was positive
    uint_least8_t calmed;     ///< how often the gains have been halved: 0 .. 2 (K48), (K51)
    lode_range_t limit_Nm;    ///< limits of the torque reference; kept up to date by the drive
} lode_speed_t;

/// The rest of the loop that speed control closes (K22).
typedef struct {
    float delay_s; ///< delay of observer, current control and speed control together
    float
        damping_rad_s; ///< rate at which the EMF brakes a rotor four times lighter than configured
} lode_speed_loop_t;

/// Factor of both gains: 1, LODE_SPEED_CALM or its square (K48). Not kept as a float, of which a flipped bit could be a
/// gain of any size and sign.
static inline float lode_speed_calm(const lode_speed_t *self) {
    const float twice = LODE_SPEED_CALM * LODE_SPEED_CALM;
    return self->calmed == 0u ? 1.0f : (self->calmed == 1u ? LODE_SPEED_CALM : twice);
}

/// `calmed` after a further halving.
static inline uint_least8_t lode_speed_calmer(uint_least8_t calmed) {
    return calmed == 0u ? 1u : 2u;
}

/// Fills every zero field that has a default. `injects`: the drive uses injection and holds the rotor at standstill
/// too.
void lode_speed_design(lode_speed_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_motor_t *motor, const lode_pll_config_t *pll,
                       const lode_speed_loop_t *loop, float omega_handover_rad_s, bool injects);

/// Checks a completed configuration and derives the tuning. `ts_s`: time between two calls of speed control.
lode_status_t lode_speed_tune(lode_speed_tuning_t *tuning, const lode_speed_config_t *config,
                              const lode_motor_t *motor, const lode_pll_config_t *pll, float ts_s);

/// Starts from the MECHANICAL speed `omega_rad_s` and the torque `torque_Nm` without a jump, limited to
/// +-`most_Nm`. `load_Nm`: present load torque; the share of it that is fed forward is part of `torque_Nm`.
void lode_speed_reset(lode_speed_t *self, const lode_speed_tuning_t *tuning, float omega_rad_s,
                      float torque_Nm, float load_Nm, float most_Nm);

#ifdef __cplusplus
}
#endif

#endif
