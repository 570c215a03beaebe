/// Cosine and sine by series: the same digits on every machine, unlike the functions of the C library, and at
/// half their cost.
#ifndef PLANT_TURN_H
#define PLANT_TURN_H

#include <stdint.h>

/// For an angle in turns, up to 1e9; the error is below 1e-15 plus the rounding of the angle itself.
static inline void plant_turn(double turns, double *c, double *s) {
    // The nearest quarter turn.
    static const double cos_quarter[4] = {1.0, 0.0, -1.0, 0.0};
    static const double sin_quarter[4] = {0.0, 1.0, 0.0, -1.0};
    const int64_t quarter = (int64_t)(4.0 * turns + (turns < 0.0 ? -0.5 : 0.5));
    const double x = 6.28318530717958647693 * (turns - 0.25 * (double)quarter);
    // At most (pi/4)^2, for which the series end below 1e-16. Each series is split in two halves, for shorter
    // chains of operations.
    const double x2 = x * x, x4 = x2 * x2;
    const double c_even =
        1.0 + x4 * (1.0 / 24 +
                    x4 * (1.0 / 40320 + x4 * (1.0 / 479001600 + x4 * (1.0 / 20922789888000.0))));
    const double c_odd =
        1.0 / 2 + x4 * (1.0 / 720 + x4 * (1.0 / 3628800 + x4 * (1.0 / 87178291200.0)));
    const double s_even = 1.0 + x4 * (1.0 / 120 + x4 * (1.0 / 362880 + x4 * (1.0 / 6227020800.0)));
    const double s_odd =
        1.0 / 6 + x4 * (1.0 / 5040 + x4 * (1.0 / 39916800 + x4 * (1.0 / 1307674368000.0)));
    const double c_x = c_even - x2 * c_odd, s_x = x * (s_even - x2 * s_odd);
    const double c_quarter = cos_quarter[quarter & 3], s_quarter = sin_quarter[quarter & 3];
    *c = c_x * c_quarter - s_x * s_quarter;
    *s = s_x * c_quarter + c_x * s_quarter;
}

#endif
