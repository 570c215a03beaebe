/// The papers' forms (rig/euler.h) in the place of the library's estimator.
#ifndef RIG_EULER_ESTIMATE_H
#define RIG_EULER_ESTIMATE_H

#include "config/rig_config.h"
#include "rig/euler.h"

/// True where [estimator] names one of them.
bool euler_estimate_wanted(const rig_config_t *config);

/// Motor and gains of the designed `config`; which forms is left open.
euler_config_t euler_estimate_gains(const rig_config_t *config);

/// The same with the forms that [estimator] names.
euler_config_t euler_estimate_config(const rig_config_t *config);

/// One period in the form of the drive's own estimate. The lock is 1 throughout: the papers have none.
lode_estimate_t euler_estimate_step(euler_t *self, const euler_config_t *config, lode_ab_t u_V,
                                    lode_ab_t i_A);

#endif
