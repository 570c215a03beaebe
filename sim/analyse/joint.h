/// EMF observer, position PLL and notches as one loop, linearised in the frame of a rotor that turns
/// steadily: the speed that the PLL finds comes back into the observer that feeds it.
///
/// All of it is estimate minus truth. Coefficients are those of the tuning, taken to double. The
/// machine is the EMF alone: what the angle does to the currents is not in it (docs/theory/fa_guideline.md).
#ifndef RIG_DESIGN_JOINT_H
#define RIG_DESIGN_JOINT_H

#include <complex.h>
#include <stdbool.h>

#include "analyse/observer.h"

#include "lodestar/estimator.h"

enum { JOINT_NOTCHES = 2, JOINT_STATES_MAX = 2 * OBSERVER_MODES_MAX + 4 + 2 * JOINT_NOTCHES };

/// A notch, its input's share that passes it, and the trapezoidal rule's gain.
typedef struct {
    bool on;
    double width, weight, g;
} joint_notch_t;

typedef struct {
    int states;
    int pll; ///< index of theta; omega, f and the speed that tunes the observer follow as they are
    bool third_order, filtered;
    double ts_s, sigma_rad_s;
    double l1, l2, l3; ///< gains of angle, speed, disturbance
    double w_weight;
    observer_t observer;                      ///< in the rotor's frame
    double complex g[OBSERVER_MODES_MAX];     ///< what one rad/s of the tuning speed adds
    double complex per_m[OBSERVER_MODES_MAX]; ///< what a relative deviation of m adds
    joint_notch_t notch[JOINT_NOTCHES];
} joint_t;

/// The loop at the electrical speed given.
joint_t joint_make(const lode_estimator_tuning_t *tuning, double omega_rad_s);

/// Only the observer's part of `joint`: enough for joint_speed_response().
void joint_observer(joint_t *joint, const lode_observer_tuning_t *tuning, double ts_s,
                    double omega_rad_s);

/// A copy of `tuning` with the PLL's poles and the fading of the notches at `sigma_rad_s`.
lode_estimator_tuning_t joint_with_sigma(const lode_estimator_tuning_t *tuning, double sigma_rad_s);

/// A copy with the observer of `emf` and this k2. Beyond what lode_observer_tune() takes: unchanged.
lode_estimator_tuning_t joint_with_k2(const lode_estimator_tuning_t *tuning,
                                      const lode_emf_config_t *emf, double omega_rated_rad_s,
                                      double k2_rad_s);

/// What acts on it over a period.
typedef struct {
    double acceleration_rad_s2; ///< of the rotor, unknown to the PLL
    double complex emf; ///< relative deviation of m: real part along it, imaginary ahead of it
} joint_input_t;

/// x[k+1] from x[k], both of `states` numbers.
void joint_step(const joint_t *joint, const joint_input_t *input, const double *from, double *to);

/// Poles as equivalents ln(z)/Ts, rad/s, the least damped first; those at z = 0 are left out. How
/// many, or -1.
int joint_poles(const joint_t *joint, double complex *poles);

/// Largest |z|; NaN where it cannot be found.
double joint_radius(const joint_t *joint);

/// Damping of a pole: -Re/|.|
double joint_damping(double complex pole);

/// Angle's deviation at z for deviations of m along it and ahead of it.
double complex joint_angle_response(const joint_t *joint, double complex z, double complex along,
                                    double complex ahead);

/// Angle of the estimated EMF per rad/s of the speed that the PLL predicts, at z.
double complex joint_speed_response(const joint_t *joint, double complex z);

#endif
