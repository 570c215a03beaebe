/// The EMF observers as complex linear systems, found by running the firmware's own step.
///
/// x[k] = A x[k-1] + B m[k], e[k] = c x[k], in the stationary frame, tuned to a constant speed. Each column of
/// A is the result of one period of lode_observer_step() for a unit state, B that for a unit input. So this
/// works for every observer of the table, including the rounding of its floats.
#ifndef RIG_ANALYSE_OBSERVER_H
#define RIG_ANALYSE_OBSERVER_H

#include <complex.h>

#include "lodestar/emf.h"

enum { OBSERVER_MODES_MAX = 1 + (int)sizeof(lode_observer_vectors_t) };

typedef struct {
    int modes;
    double complex a[OBSERVER_MODES_MAX][OBSERVER_MODES_MAX];
    double complex b[OBSERVER_MODES_MAX];
    double complex c[OBSERVER_MODES_MAX];
} observer_t;

observer_t observer_make(const lode_observer_tuning_t *tuning, double ts_s, double omega_rad_s);

/// dA/dw and dB/dw.
observer_t observer_slope(const lode_observer_tuning_t *tuning, double ts_s, double omega_rad_s);

/// e/m at z, in the stationary frame: z = exp(j w Ts) is a vector that turns with w.
double complex observer_response(const observer_t *observer, double complex z);

/// No response c (1 - A/z)^-1 x on the unit circle is larger: the sum of |c A^k x|, x being the input given.
/// Infinite if that does not settle.
double observer_peak(const observer_t *observer, const double complex *input);

/// m/e(t_k) for an EMF that turns with `omega_rad_s`: the exact R-Lq circuit over one period.
double complex observer_circuit(const lode_motor_t *motor, double ts_s, double omega_rad_s);

#endif
