/// Control of the xy currents of a dual three-phase winding, which make losses and no torque: to zero.
///
/// In the frame that turns with -theta, the 5th harmonic appears at +6 w and the 7th at -6 w: a PI
/// controller and one resonator at 6 w per axis hold both (X1).
#ifndef LODESTAR_XY_H
#define LODESTAR_XY_H

#include "lodestar/inverter.h"
#include "lodestar/pi.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float bandwidth_rad_s; ///< of the PI; 0: 0.1/Ts
    /// rate at which the resonators take up the harmonics; 0: a thirtieth of the bandwidth; LODE_NONE:
    /// none
    float resonance_rad_s;
    float voltage_share; ///< of v_bus/sqrt(3) that the plane may use, 0 .. 0.5; 0: 0.1
} lode_xy_config_t;

typedef struct {
    lode_pi_tuning_t pi;
    float bandwidth_rad_s;
    float corner_rad_s; ///< R/L
    float ts_s;
    float gain_Ohm_s; ///< 2 L resonance Ts
    float omega6_max; ///< of the resonance: beyond it the resonators stay out
    float circle;     ///< largest voltage per bus volt
} lode_xy_tuning_t;

/// What a resonator does at the present speed: gain per period, lead over the loop's lag, rotation.
typedef struct {
    float gain_Ohm;
    lode_sincos_t lead;
    lode_sincos_t step; ///< 6 w Ts: by which a resonator turns in a period
} lode_xy_aim_t;

typedef struct {
    lode_pi_t x;
    lode_pi_t y;
    lode_ab_t resonance_x; ///< state of the x axis, V: turned by 6 w Ts in every period
    lode_ab_t resonance_y;
    lode_xy_aim_t aim;
} lode_xy_t;

void lode_xy_design(lode_xy_config_t *config, float ts_s);

/// `R_Ohm`, `L_H` of the plane: those of a phase, and its leakage inductance.
lode_status_t lode_xy_tune(lode_xy_tuning_t *tuning, const lode_xy_config_t *config, float R_Ohm,
                           float L_H, float ts_s);

void lode_xy_reset(lode_xy_t *self);

/// Follows the speed. Once in LODE_SLOW_PERIODS.
void lode_xy_adapt(lode_xy_t *self, const lode_xy_tuning_t *tuning, float omega_rad_s);

#ifdef __cplusplus
}
#endif

#endif
