/// The papers' equations integrated in continuous time: what is left of them when no discretisation adds
/// to their lags.
#ifndef RIG_CONTINUOUS_H
#define RIG_CONTINUOUS_H

#include "rig/euler_terms.h"

/// From t_k-1 to t_k by Runge and Kutta's rule of fourth order, in parts of the period in which the
/// error is far below that of any figure shown. `u_V`: held over that period; the current runs straight
/// from that at t_k-1 to `i_A` at t_k.
void continuous_advance(euler_t *self, const euler_config_t *config, double complex u_V,
                        double complex i_A);

#endif
