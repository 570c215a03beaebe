/// rpm and degrees are used only in the host tools.
#ifndef RIG_UNITS_H
#define RIG_UNITS_H

#include <math.h>

#define RIG_PI 3.14159265358979323846

static inline double rig_rpm_from_rad_s(double rad_s) {
    return rad_s * (30.0 / RIG_PI);
}

static inline double rig_rad_s_from_rpm(double rpm) {
    return rpm * (RIG_PI / 30.0);
}

static inline double rig_deg_from_rad(double rad) {
    return rad * (180.0 / RIG_PI);
}

static inline double rig_rad_from_deg(double deg) {
    return deg * (RIG_PI / 180.0);
}

/// Difference of two angles, (-180, 180] degrees.
static inline double rig_angle_error_deg(double estimate_rad, double truth_rad) {
    const double off_rad = estimate_rad - truth_rad; // rarely beyond half a turn
    return rig_deg_from_rad(fabs(off_rad) <= RIG_PI ? off_rad : remainder(off_rad, 2.0 * RIG_PI));
}

#endif
