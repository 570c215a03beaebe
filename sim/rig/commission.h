/// The library's self-commissioning against the simulated motor.
#ifndef RIG_COMMISSION_H
#define RIG_COMMISSION_H

#include "config/rig_config.h"
#include "lodestar/commission6.h"

typedef struct {
    int sets;
    lode_commission6_t commission; ///< with three phases only its member for them is used
    lode_drive_t three;
    lode_drive_tuning_t three_tuning[2];
    lode_drive6_t six;
    lode_drive6_tuning_t six_tuning[2];
    plant_config_t plant;
    double truth[LODE_COMMISSION_QUANTITIES]; ///< NaN: not defined
    double took_s;
    double i_max_A; ///< largest length of the current vector
    /// rated speed that the drive was told, electrical, because the voltage does not reach the given one; NaN: the given one
    double lowered_rad_s;
} commission_run_t;

/// False after a message for refused input. A commissioning that fails returns true with its own result.
bool commission_run(commission_run_t *self, const rig_config_t *config);

/// The measured values and the result.
const lode_commission_t *commission_of(const commission_run_t *self);

/// `config` with the measured values in place of the previous ones. Only after LODE_COMMISSION_DONE.
void commission_found(rig_config_t *found, const commission_run_t *self,
                      const rig_config_t *config);

/// The same as commission_run() on a plant that differs from the configuration.
bool commission_run_on(commission_run_t *self, const rig_config_t *config,
                       const plant_config_t *truth);

#endif
