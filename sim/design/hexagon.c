#include "design/hexagon.h"

#include <complex.h>
#include <math.h>

#include "support/units.h"

#define STEPS 360
#define PHASES 3

/// The vector in the frame of the commanded one, which is `use`; both of v_bus/sqrt(3).
static double complex left_of(double use, double angle_rad) {
    double u[PHASES]; // of v_bus
    double least = 1.0;
    double most = -1.0;
    double complex sum = 0.0;
    for (int phase = 0; phase < PHASES; ++phase) {
        u[phase] = use / sqrt(3.0) * cos(angle_rad - 2.0 * RIG_PI * phase / PHASES);
        least = fmin(least, u[phase]);
        most = fmax(most, u[phase]);
    }
    for (int phase = 0; phase < PHASES; ++phase) {
        const double duty = 0.5 + u[phase] - 0.5 * (least + most);
        sum += fmin(fmax(duty, 0.0), 1.0) * cexp(I * (2.0 * RIG_PI * phase / PHASES - angle_rad));
    }
    return 2.0 / PHASES * sqrt(3.0) * sum;
}

hexagon_t hexagon_of(double use) {
    double complex mean = 0.0;
    double ripple = 0.0;
    if (!(use > 1.0)) {
        return (hexagon_t){NAN, NAN};
    }
    for (int k = 0; k < STEPS; ++k) {
        mean += left_of(use, 2.0 * RIG_PI * k / STEPS) / STEPS;
    }
    for (int k = 0; k < STEPS; ++k) {
        ripple = fmax(ripple, cabs(left_of(use, 2.0 * RIG_PI * k / STEPS) - mean));
    }
    return (hexagon_t){cabs(mean), ripple / cabs(mean)};
}
