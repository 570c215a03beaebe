/// Adaptation in operation with six phases. Choices, bounds and results are those of adaptation.h.
///
///     (void)lode_adaptation6_step(&adaptation, &drive6);
///
/// It pauses while one set drives alone; the values in use remain in use (docs/adaptation.md).
#ifndef LODESTAR_ADAPTATION6_H
#define LODESTAR_ADAPTATION6_H

#include "lodestar/adaptation.h"
#include "lodestar/drive6.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The members are visible for static allocation; only the functions below write them.
typedef struct {
    lode_adaptation_machine_t machine;
    const lode_drive6_tuning_t *base; ///< as commissioned or posted later
    lode_drive6_tuning_t tuning[2];   ///< used in turn for posting
} lode_adaptation6_t;

/// As lode_adaptation_init(). `motor`: of both sets, as in lode_drive6_config_t.
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

/// As lode_adaptation_telemetry(). After lode_drive6_telemetry(), with the `drive` of its result.
void lode_adaptation6_telemetry(const lode_adaptation6_t *self, lode_telemetry_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
