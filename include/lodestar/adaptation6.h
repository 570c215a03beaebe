/// Adaptation while the drive runs, with six phases: as adaptation.h, whose choices, bounds and values these are.
///
///     (void)lode_adaptation6_step(&adaptation, &drive6);
///
/// It rests while one set drives alone; what is in use by then stays in use (docs/adaptation.md).
#ifndef LODESTAR_ADAPTATION6_H
#define LODESTAR_ADAPTATION6_H

#include "lodestar/adaptation.h"
#include "lodestar/drive6.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Visible for static allocation; written by its functions only.
typedef struct {
    lode_adaptation_machine_t machine;
    const lode_drive6_tuning_t *base; ///< as commissioned, or posted since
    lode_drive6_tuning_t tuning[2];   ///< posted in turn
} lode_adaptation6_t;

/// As lode_adaptation_init(); `motor`: of both sets, as in lode_drive6_config_t.
lode_status_t lode_adaptation6_init(lode_adaptation6_t *self,
                                    const lode_adaptation_config_t *config,
                                    const lode_drive6_tuning_t *tuning, const lode_motor_t *motor,
                                    const lode_adaptation_found_t *stored);

/// As lode_adaptation_step().
bool lode_adaptation6_step(lode_adaptation6_t *self, lode_drive6_t *drive);

/// As lode_adaptation_post().
bool lode_adaptation6_post(lode_adaptation6_t *self, lode_drive6_t *drive,
                           const lode_drive6_tuning_t *tuning);

lode_adaptation_found_t lode_adaptation6_found(const lode_adaptation6_t *self);

/// As lode_adaptation_tell(): after lode_drive6_telemetry() into the `drive` of that.
void lode_adaptation6_tell(const lode_adaptation6_t *self, lode_telemetry_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
