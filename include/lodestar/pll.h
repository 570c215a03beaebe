/// Phase-locked loops as observers of the rotor's motion, with gains designed in the z-plane.
///
/// One recursion serves both orders. The QPLL (paper 1, eqs. 13-15) has no disturbance state; the LESO-QPLL (paper
/// 1, eqs. 18-20) has one and uses the torque of the measured current as an input.
#ifndef LODESTAR_PLL_H
#define LODESTAR_PLL_H

#include "lodestar/config.h"
#include "lodestar/motor.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LODE_PLL_LESO, ///< third order: disturbance state and torque feed-forward
    LODE_PLL_QPLL  ///< second order
} lode_pll_kind_t;

/// Configuration. Speeds are electrical. A field that is 0 gets its default from lode_pll_design().
typedef struct {
    lode_pll_kind_t kind;
    /// bandwidth from omega_high on, 1 .. 0.3/Ts: triple pole, with the QPLL double; 0: 0.21 of rated speed, QPLL
    /// 0.35, at most 0.1/Ts; in a drive more for a light rotor (P20)
    float sigma_rad_s;
    /// bandwidth up to omega_low; 0: sigma_rad_s if that is given, otherwise 0.11 of rated speed, QPLL 0.18
    float sigma_low_rad_s;
    float omega_low_rad_s;  ///< end of sigma_low_rad_s; 0: 0.1 of rated speed
    float omega_high_rad_s; ///< start of sigma_rad_s, above omega_low; 0: 0.2 of rated speed
} lode_pll_config_t;

/// All that is derived from the configuration.
typedef struct {
    float ts_s;
    float inv_ts;
    float x_low;  ///< 1 - exp(-sigma Ts) at low speed
    float x_rise; ///< increase of x_low up to omega_high
    float omega_low;
    float inv_span;       ///< 1/(omega_high - omega_low)
    uint32_t third_order; ///< 0 or 1
} lode_pll_tuning_t;

/// State of the loop.
typedef struct {
    lode_sincos_t frame; ///< angle of the tracked EMF minus a quarter turn, at t_k
    float omega_rad_s;   ///< electrical speed at t_k
    float f_rad_s2;      ///< disturbance: -np T_load/J and everything else that the model lacks
    /// change of the speed over the present period by disturbance, torque and friction
    float rise_rad_s;
} lode_pll_t;

/// Bandwidth of a loop of this kind relative to that of a LESO-QPLL with the same noise of the angle (H20).
float lode_pll_times(lode_pll_kind_t kind);

/// Least frequency, rad/s, of a narrow notch on the position error, by which the loop keeps a margin (P31).
float lode_pll_notch_rad_s(const lode_pll_config_t *config);

/// Fills every zero field that has a default.
void lode_pll_design(lode_pll_config_t *config, float omega_rated_rad_s, float ts_s);

/// Checks a completed configuration and derives the tuning.
lode_status_t lode_pll_tune(lode_pll_tuning_t *tuning, const lode_pll_config_t *config, float ts_s);

/// Starts from the given motion, without a disturbance.
void lode_pll_reset(lode_pll_t *self, float theta_rad, float omega_rad_s);

/// Gains for one period (P5): corrections of angle, speed and disturbance per error.
typedef struct {
    float theta;   ///< rad per rad
    float omega_s; ///< rad/s per rad
    float f_s2;    ///< rad/s^2 per rad; 0 for the QPLL
} lode_pll_gains_t;

#ifdef __cplusplus
}
#endif

#endif
