/// Self-commissioning with six phases: as commission.h, with the sensors of each set, and the inductance of the xy
/// plane.
///
/// Interrupt: lode_commission6_step() in place of lode_drive6_step().
/// Thread:    lode_commission6_work() again and again until it no longer returns RUNNING.
#ifndef LODESTAR_COMMISSION6_H
#define LODESTAR_COMMISSION6_H

#include "lodestar/commission.h"
#include "lodestar/drive6.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifndef LODE_WITHOUT_COMMISSIONING

typedef struct {
    lode_commission_t machine; ///< what was found, and how it ended
    lode_drive6_t *drive;
    lode_drive6_tuning_t *tuning; ///< two
    lode_drive6_config_t config;  ///< as given, then with what was found
} lode_commission6_t;

/// As lode_commission_init(); Lxy within 40 %.
lode_status_t lode_commission6_init(lode_commission6_t *self, lode_drive6_t *drive,
                                    lode_drive6_tuning_t tuning[2],
                                    const lode_drive6_config_t *config);

/// One PWM period.
lode_drive6_out_t lode_commission6_step(lode_commission6_t *self, const lode_counts6_t *counts);

/// Does what takes too long for the interrupt. Returns the present state or result.
lode_commission_result_t lode_commission6_work(lode_commission6_t *self);

/// The configuration with what was found in it. Only after LODE_COMMISSION_DONE.
const lode_drive6_config_t *lode_commission6_config(const lode_commission6_t *self);

#endif

#ifdef __cplusplus
}
#endif

#endif
