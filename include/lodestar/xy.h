/// Control of the xy currents of a dual three-phase winding to zero. They cause losses and no torque.
///
/// In the frame that turns with -theta, the 5th harmonic appears at +6 w and the 7th at -6 w. A PI controller and
/// one resonator at 6 w per axis control both (X1).
#ifndef LODESTAR_XY_H
#define LODESTAR_XY_H

#include "lodestar/inverter.h"
#include "lodestar/pi.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Configuration. A field that is 0 gets its default from lode_xy_design().
typedef struct {
    float bandwidth_rad_s; ///< of the PI controller; 0: 0.1/Ts
    /// rate at which a harmonic decays by its resonator; 0: a thirtieth of the bandwidth; LODE_NONE: no resonators
    float resonance_rad_s;
    float voltage_share; ///< share of v_bus/sqrt(3) for the xy plane, 0 .. 0.5; 0: 0.1
} lode_xy_config_t;

/// All that is derived from the configuration.
typedef struct {
    lode_pi_tuning_t pi;
    float bandwidth_rad_s;
    float corner_rad_s; ///< R/L
    float ts_s;
    float gain_Ohm_s; ///< 2 L resonance Ts
    float omega6_max; ///< largest 6 w of the resonators; above it they are off
    float circle;     ///< largest voltage per bus volt
} lode_xy_tuning_t;

/// Parameters of a resonator at the present speed (X2), (X3).
typedef struct {
    float gain_Ohm;     ///< gain per period
    lode_sincos_t lead; ///< phase lead against the loop's lag
    lode_sincos_t step; ///< 6 w Ts: rotation per period
} lode_xy_aim_t;

/// State of the control.
typedef struct {
    lode_pi_t x;
    lode_pi_t y;
    lode_ab_t resonance_x; ///< state of the x axis, V: rotates by 6 w Ts per period
    lode_ab_t resonance_y;
    lode_xy_aim_t aim;
} lode_xy_t;

/// Fills every zero field that has a default.
void lode_xy_design(lode_xy_config_t *config, float ts_s);

/// Checks a completed configuration and derives the tuning. `R_Ohm`, `L_H`: phase resistance and leakage
/// inductance. On any error `tuning` is left alone.
lode_status_t lode_xy_tune(lode_xy_tuning_t *tuning, const lode_xy_config_t *config, float R_Ohm,
                           float L_H, float ts_s);

/// Clears the state.
void lode_xy_reset(lode_xy_t *self);

/// Adapts the resonators to the electrical speed. Once in LODE_SLOW_PERIODS.
void lode_xy_adapt(lode_xy_t *self, const lode_xy_tuning_t *tuning, float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
