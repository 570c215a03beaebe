/// The papers' equations integrated in continuous time, without the lags that discretisation adds.
#ifndef RIG_CONTINUOUS_H
#define RIG_CONTINUOUS_H

#include "rig/euler_terms.h"

/// Integrates from t_k-1 to t_k by the fourth-order Runge-Kutta method, in parts of the period whose error is
/// far below any digit shown. `u_V`: held over that period; the current changes linearly from its value at
/// t_k-1 to `i_A` at t_k.
void continuous_advance(euler_t *self, const euler_config_t *config, double complex u_V,
                        double complex i_A);

#endif
