/// The library's self-commissioning against the simulated motor.
#ifndef RIG_COMMISSION_H
#define RIG_COMMISSION_H

#include "config/rig_config.h"
#include "lodestar/commission6.h"

typedef struct {
    int sets;
    lode_commission6_t commission; ///< with three phases its machine alone
    lode_drive_t three;
    lode_drive_tuning_t three_tuning[2];
    lode_drive6_t six;
    lode_drive6_tuning_t six_tuning[2];
    plant_config_t plant;
    double truth[LODE_COMMISSION_QUANTITIES]; ///< NaN where there is none
    double took_s;
    double i_max_A; ///< largest length of the current vector
} commission_run_t;

/// False after a message: refused input. Whatever the commissioning came to is its own result.
bool commission_run(commission_run_t *self, const rig_config_t *config);

/// What was found, and how it ended.
const lode_commission_t *commission_of(const commission_run_t *self);

/// `config` with what was found in the place of what was known. Only after LODE_COMMISSION_DONE.
void commission_found(rig_config_t *found, const commission_run_t *self,
                      const rig_config_t *config);

/// The same as commission_run() on a plant of which the configuration does not tell.
bool commission_run_on(commission_run_t *self, const rig_config_t *config,
                       const plant_config_t *truth);

#endif
