/// Limits of the supply current, out of the battery and back into it, kept by reducing torque. For the main loop,
/// about 1000 times a second:
///
///     lode_telemetry_t now;
///     (void)lode_drive_telemetry(&drive, &now);
///     const float i_A = lode_supply_current_A(&supply_tuning, &now);
///     const lode_shares_t share = lode_supply_step(&supply, &supply_tuning, &now, i_A, 1.0e-3f);
///     lode_drive_limit_torques(&drive, share.motoring, share.braking);
///
/// docs/theory/control.md has the equations.
#ifndef LODESTAR_SUPPLY_H
#define LODESTAR_SUPPLY_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float battery_A; ///< most current out of the supply, up to 1e5; 0: not limited
    float regen_A;   ///< most current back into it, up to 1e5; 0: not limited; LODE_NONE: none
    float correct_s; ///< time in which the limits follow the current, 1e-3 .. 100; 0: 0.05
} lode_supply_config_t;

/// With the speed, and against it.
enum { LODE_SUPPLY_DRAWN, LODE_SUPPLY_FED_BACK, LODE_SUPPLY_SIDES };

typedef struct {
    float limit_A[LODE_SUPPLY_SIDES]; ///< FLT_MAX: none
    float correct_s;
    float power_factor; ///< 1.5 per winding set
    float inv_pole_pairs;
    float R_Ohm;  ///< of winding and switches
    float drop_V; ///< power per ampere of amplitude that the switches' on-state threshold takes
    float torque_factor;
    float psi_Wb;
    float salient_H; ///< Ld - Lq
    float most_Nm;   ///< torque of i_max at id = 0
} lode_supply_tuning_t;

typedef struct {
    float
        factor[LODE_SUPPLY_SIDES]; ///< of the torque that the model allows, as the current shows it
    float share[LODE_SUPPLY_SIDES]; ///< returned last
} lode_supply_t;

/// Shares of the torque, 0 .. 1, as lode_drive_limit_torques() takes them.
typedef struct {
    float motoring;
    float braking;
} lode_shares_t;

/// `drive`: the configuration of the drive, of which motor and inverter count. LODE_ERROR_SUPPLY where a field is
/// out of range; `tuning` is then unchanged. The motor is not checked: lode_drive_init() does that.
lode_status_t lode_supply_tune(lode_supply_tuning_t *tuning, const lode_supply_config_t *config,
                               const lode_drive_config_t *drive);

void lode_supply_reset(lode_supply_t *self);

/// Mean current out of the supply, A, computed from the motor's voltages and currents, without switching losses;
/// negative: fed back.
float lode_supply_current_A(const lode_supply_tuning_t *tuning, const lode_telemetry_t *telemetry);

/// Call `dt_s` after the last call. `i_A`: the current of lode_supply_current_A(), or one that the board measures. One
/// that is not a number counts as too large.
lode_shares_t lode_supply_step(lode_supply_t *self, const lode_supply_tuning_t *tuning,
                               const lode_telemetry_t *telemetry, float i_A, float dt_s);

#ifdef __cplusplus
}
#endif

#endif
