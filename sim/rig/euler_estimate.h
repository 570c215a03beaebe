/// The papers' forms (rig/euler.h) instead of the library's estimator.
#ifndef RIG_EULER_ESTIMATE_H
#define RIG_EULER_ESTIMATE_H

#include "config/rig_config.h"
#include "rig/euler.h"

/// True if [estimator] names one of them.
bool euler_estimate_wanted(const rig_config_t *config);

/// Sets motor and gains of the designed `config`; the caller sets the forms.
euler_config_t euler_estimate_gains(const rig_config_t *config);

/// The same with the forms that [estimator] names.
euler_config_t euler_estimate_config(const rig_config_t *config);

/// One period, with the result as the drive's own estimate. The lock is always 1, because the papers have none.
lode_estimate_t euler_estimate_step(euler_t *self, const euler_config_t *config, lode_ab_t u_V,
                                    lode_ab_t i_A);

#endif
