/// Position PLL with a notch as a rational function: continuous as in paper 1, or sampled.
///
/// The sampled one is written in d = (z - 1)/Ts, which becomes s as Ts goes to 0: both then have
/// coefficients and roots of like size, and roots near z = 1 keep their digits.
#ifndef RIG_ANALYSE_LOOP_H
#define RIG_ANALYSE_LOOP_H

#include <stdbool.h>

#include "analyse/polynomial.h"

#include "lodestar/estimator.h"

typedef struct {
    double ts_s; ///< 0: continuous
    polynomial_t top, bottom;
} loop_ratio_t;

/// (s^2 + wn^2)/(s^2 + k wn s + wn^2): paper 1, eq. (34).
loop_ratio_t loop_notch(double k, double wn_rad_s);

/// The firmware's full notch, with its centre at wn.
loop_ratio_t loop_notch_sampled(double k, double wn_rad_s, double ts_s);

/// From position error to angle: ((s+sigma)^n - s^n)/s^n, n = 3 or 2.
loop_ratio_t loop_pll(double sigma_rad_s, bool third_order);

/// The firmware's recursion, from position error to predicted angle, at and above omega_high.
loop_ratio_t loop_pll_sampled(double sigma_rad_s, bool third_order, double ts_s);

/// (s+sigma)^3/s^3, as eqs. (35) and (36) have it in print.
loop_ratio_t loop_pll_misprint(double sigma_rad_s);

loop_ratio_t loop_product(const loop_ratio_t *a, const loop_ratio_t *b);

/// Its value at the frequency given.
double complex loop_at(const loop_ratio_t *loop, double omega_rad_s);

/// Poles of loop/(1 + loop) as equivalents in s; how many, or -1.
int loop_poles(const loop_ratio_t *loop, double complex *poles);

/// The pair with the least damping, upper half plane; NaN if no pole is complex.
double complex loop_dominant(const loop_ratio_t *loop);

typedef struct {
    double crossover_rad_s, phase_deg; ///< NaN: no crossing of unity gain
    double bandwidth_rad_s;            ///< the closed loop falls to -3 dB; NaN: never
} loop_metrics_t;

loop_metrics_t loop_metrics(const loop_ratio_t *loop, double from_rad_s, double to_rad_s);

#endif
