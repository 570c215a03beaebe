/// Self-commissioning with six phases: as commission.h, with the sensors of both sets and the inductance of the xy plane.
///
/// Interrupt: lode_commission6_step() instead of lode_drive6_step().
/// Main loop: lode_commission6_work() repeatedly, as long as it returns RUNNING.
#ifndef LODESTAR_COMMISSION6_H
#define LODESTAR_COMMISSION6_H

#include "lodestar/commission.h"
#include "lodestar/drive6.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifndef LODE_WITHOUT_COMMISSIONING

typedef struct {
    lode_commission_t machine; ///< results, and how the commissioning has ended
    lode_drive6_t *drive;
    lode_drive6_tuning_t *tuning; ///< two tunings, used in turn
    lode_drive6_config_t config;  ///< the given configuration with what has been measured
} lode_commission6_t;

// Its name tells what is left out of the build (options.h).
#define lode_commission6_init LODE_SYMBOL(lode_commission6_init)

/// As lode_commission_init(). Lxy_H must be known within 40 %.
lode_status_t lode_commission6_init(lode_commission6_t *self, lode_drive6_t *drive,
                                    lode_drive6_tuning_t tuning[2],
                                    const lode_drive6_config_t *config);

/// One control period, for the PWM interrupt.
lode_drive6_out_t lode_commission6_step(lode_commission6_t *self, const lode_counts6_t *counts);

/// Does what takes too long for the interrupt; for the main loop. Returns the state.
lode_commission_result_t lode_commission6_work(lode_commission6_t *self);

/// The given configuration with the measured values. Only after LODE_COMMISSION_DONE.
const lode_drive6_config_t *lode_commission6_config(const lode_commission6_t *self);

#endif

#ifdef __cplusplus
}
#endif

#endif
