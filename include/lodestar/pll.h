/// Phase-locked loops that are observers of the rotor's motion, with gains placed in the z-plane.
///
/// One recursion serves both orders: the QPLL (paper 1, eqs. 13-15) has no disturbance state, the
/// LESO-QPLL (paper 1, eqs. 18-20) has one and is fed with the torque of the measured current.
#ifndef LODESTAR_PLL_H
#define LODESTAR_PLL_H

#include "lodestar/config.h"
#include "lodestar/motor.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LODE_PLL_LESO, ///< third order, disturbance state and torque feed-forward
    LODE_PLL_QPLL  ///< second order
} lode_pll_kind_t;

typedef struct {
    lode_pll_kind_t kind;
    /// triple (double) pole at and above omega_high, 1 .. 0.3/Ts; 0: scheduled, 0.21 of rated speed, QPLL 0.35, at most
    /// 0.1/Ts; in a drive more for a light rotor (P20)
    float sigma_rad_s;
    float sigma_low_rad_s; ///< the same at and below omega_low; 0: as sigma_rad_s if that is given,
                           ///< else 0.11 of rated speed, QPLL 0.18
    float omega_low_rad_s; ///< electrical, as all here; 0: 0.1 of rated speed
    float omega_high_rad_s; ///< above omega_low; 0: 0.2 of rated speed
} lode_pll_config_t;

typedef struct {
    float ts_s;
    float inv_ts;
    float x_low;  ///< 1 - exp(-sigma Ts) at low speed
    float x_rise; ///< its increase up to omega_high
    float omega_low;
    float inv_span;       ///< 1/(omega_high - omega_low)
    uint32_t third_order; ///< 0 or 1
} lode_pll_tuning_t;

typedef struct {
    lode_sincos_t frame; ///< angle of the EMF that it follows, less a quarter turn, at t_k
    float omega_rad_s;   ///< electrical speed at t_k
    float f_rad_s2;      ///< disturbance: -np T_load/J plus whatever the model lacks
    float
        rise_rad_s; ///< of the speed over the period under way: by the disturbance, torque and friction
} lode_pll_t;

/// Bandwidth of a loop of this kind over that of the LESO-QPLL whose angle has the same noise (H20).
float lode_pll_times(lode_pll_kind_t kind);

/// Fills every zero field that has a default.
void lode_pll_design(lode_pll_config_t *config, float omega_rated_rad_s, float ts_s);

lode_status_t lode_pll_tune(lode_pll_tuning_t *tuning, const lode_pll_config_t *config, float ts_s);

/// Takes up the motion given, with no disturbance.
void lode_pll_reset(lode_pll_t *self, float theta_rad, float omega_rad_s);

/// Gains of one period (P5): what an error corrects angle, speed and disturbance by.
typedef struct {
    float theta;   ///< rad per rad
    float omega_s; ///< rad/s per rad
    float f_s2;    ///< rad/s^2 per rad; 0 for the QPLL
} lode_pll_gains_t;

#ifdef __cplusplus
}
#endif

#endif
