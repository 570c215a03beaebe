/// Limits of the supply current, out of the battery and back into it, by a reduced torque. For the main loop, about
/// 1000 times per second:
///
///     lode_telemetry_t now;
///     (void)lode_drive_telemetry(&drive, &now);
///     const float i_A = lode_supply_current_A(&supply_tuning, &now);
///     const lode_shares_t share = lode_supply_step(&supply, &supply_tuning, &now, i_A, 1.0e-3f);
///     lode_drive_limit_torques(&drive, share.motoring, share.braking);
///
/// The last limits given to the drive count: with derate.h as well, give the smaller share of each direction.
///
/// Equations (L1)-(L4), (L8): docs/theory/control.md.
#ifndef LODESTAR_SUPPLY_H
#define LODESTAR_SUPPLY_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Configuration of the limits.
typedef struct {
    float battery_A; ///< largest current out of the supply, up to 1e5; 0: no limit
    /// largest current back into it, up to 1e5; 0: no limit; LODE_NONE: none, but that of a sixteenth of the
    /// winding's losses, so that a load is held at rest (L8)
    float regen_A;
    float
        correct_s; ///< time constant with which the limits follow the measured current (L3), 1e-3 .. 100; 0: 0.05
} lode_supply_config_t;

/// Index of the two limits: motoring, and braking.
enum { LODE_SUPPLY_DRAWN, LODE_SUPPLY_FED_BACK, LODE_SUPPLY_SIDES };

/// All that is derived from the configuration.
typedef struct {
    float limit_A[LODE_SUPPLY_SIDES]; ///< FLT_MAX: no limit
    float correct_s;
    float power_factor; ///< 1.5 per winding set
    float inv_pole_pairs;
    float R_Ohm;         ///< winding and switches
    float drop_V;        ///< power per ampere of amplitude lost to the switches' on-state threshold
    float torque_factor; ///< torque per Wb and A
    float psi_Wb;
    float salient_H; ///< Ld - Lq
    float most_Nm;   ///< torque of i_max at id = 0
} lode_supply_tuning_t;

/// State.
typedef struct {
    /// correction of the model's torque by the current (L3); 1: none
    float factor[LODE_SUPPLY_SIDES];
    float share[LODE_SUPPLY_SIDES]; ///< returned last
} lode_supply_t;

/// Shares of the torque, 0 .. 1, for lode_drive_limit_torques().
typedef struct {
    float motoring;
    float braking;
} lode_shares_t;

/// Derives the tuning. `drive`: configuration of the drive, of which motor and inverter are used; it is not checked
/// here, lode_drive_init() does that. Errors: NULL, SUPPLY; `tuning` is then left alone.
lode_status_t lode_supply_tune(lode_supply_tuning_t *tuning, const lode_supply_config_t *config,
                               const lode_drive_config_t *drive);

/// Clears the state: no correction.
void lode_supply_reset(lode_supply_t *self);

/// Mean current out of the supply, A, computed from the motor's voltages and currents; negative: fed back.
/// Switching losses are not included.
float lode_supply_current_A(const lode_supply_tuning_t *tuning, const lode_telemetry_t *telemetry);

/// Returns the shares, `dt_s` after the last call. `i_A`: result of lode_supply_current_A(), or a current measured
/// by the board; NaN counts as too large.
lode_shares_t lode_supply_step(lode_supply_t *self, const lode_supply_tuning_t *tuning,
                               const lode_telemetry_t *telemetry, float i_A, float dt_s);

#ifdef __cplusplus
}
#endif

#endif
