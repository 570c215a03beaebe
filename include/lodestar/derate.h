/// Derating: less torque before something gets too hot, by the temperature of the power stage and by the heating of
/// the winding (I2t). For the main loop, about 10 times a second:
///
///     lode_telemetry_t now;
///     (void)lode_drive_telemetry(&drive, &now);
///     lode_drive_limit_torque(&drive, lode_derate_step(&derate, &derate_tuning, &now, 0.1f));
#ifndef LODESTAR_DERATE_H
#define LODESTAR_DERATE_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float i_max_A; ///< that of the inverter's configuration, peak of a phase
    float
        i_continuous_A; ///< continuous current of the winding, peak of a phase, up to i_max_A; 0: i_max_A
    float
        winding_s; ///< thermal time constant of the winding, 0.1 .. 1e5; data sheets give it; 0: 30
    float from_degC; ///< of the power stage: full torque up to here; 0: 20 K below to_degC
    float to_degC;   ///< none from here on, -40 .. 300: at or below the guard's limit
} lode_derate_config_t;

typedef struct {
    float inv_continuous2; ///< 1/A^2
    float least;           ///< share of the torque that is continuous
    float winding_s;
    lode_fade_t winding;
    lode_fade_t stage;
} lode_derate_tuning_t;

typedef struct {
    float heat; ///< temperature rise of the winding; 1: that of i_continuous_A
} lode_derate_t;

/// LODE_ERROR_DERATE where a field is out of range; `tuning` is then unchanged.
lode_status_t lode_derate_tune(lode_derate_tuning_t *tuning, const lode_derate_config_t *config);

/// `heat`: 0 for a cold winding; 1 where it is not known to be cold.
void lode_derate_reset(lode_derate_t *self, float heat);

/// Call `dt_s` after the last call. Returns the share of the torque that may be asked for, 0 .. 1. A temperature or
/// current that is not a number counts as too hot.
float lode_derate_step(lode_derate_t *self, const lode_derate_tuning_t *tuning,
                       const lode_telemetry_t *telemetry, float dt_s);

#ifdef __cplusplus
}
#endif

#endif
