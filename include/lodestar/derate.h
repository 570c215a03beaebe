/// Derating: reduces the torque before something becomes too hot, by the temperature of the power stage and the
/// heat of the winding (I2t). For the main loop, about 10 times per second:
///
///     lode_telemetry_t now;
///     (void)lode_drive_telemetry(&drive, &now);
///     lode_drive_limit_torque(&drive, lode_derate_step(&derate, &derate_tuning, &now, 0.1f));
///
/// The last limit given to the drive counts. With supply.h as well, give the smaller share of each direction to
/// lode_drive_limit_torques().
#ifndef LODESTAR_DERATE_H
#define LODESTAR_DERATE_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Configuration of derating.
typedef struct {
    float i_max_A; ///< inverter.i_max_A, peak of a phase current
    /// continuous current of the winding, peak of a phase current, up to i_max_A; 0: i_max_A
    float i_continuous_A;
    /// thermal time constant of the winding, from the data sheet, 0.1 .. 1e5; 0: 30
    float winding_s;
    /// temperature of the power stage up to which there is full torque; 0: 20 K below to_degC
    float from_degC;
    /// temperature from which there is no torque, -40 .. 300; at or below the guard's limit
    float to_degC;
} lode_derate_config_t;

/// All that is derived from the configuration.
typedef struct {
    float inv_continuous2; ///< 1/A^2
    float least;           ///< share of the torque at the continuous heat
    float winding_s;
    lode_fade_t winding; ///< of what is beyond `least`, over the heat of the winding
    lode_fade_t beyond;  ///< of `least`, over the heat beyond the continuous one
    lode_fade_t stage;   ///< over the temperature of the power stage
} lode_derate_tuning_t;

typedef struct {
    float heat; ///< temperature rise of the winding (D1); 1: that of i_continuous_A
    float rest; ///< of it, less than its last digit: lode_add_small()
} lode_derate_t;

/// Checks `config` and derives the tuning. Errors: NULL, DERATE; `tuning` is then left alone.
lode_status_t lode_derate_tune(lode_derate_tuning_t *tuning, const lode_derate_config_t *config);

/// `heat`: 0 for a cold winding, 1 if its temperature is not known.
void lode_derate_reset(lode_derate_t *self, float heat);

/// Permitted share of the torque, 0 .. 1 (D2), `dt_s` after the last call. A temperature or current that is NaN
/// counts as too hot.
float lode_derate_step(lode_derate_t *self, const lode_derate_tuning_t *tuning,
                       const lode_telemetry_t *telemetry, float dt_s);

#ifdef __cplusplus
}
#endif

#endif
