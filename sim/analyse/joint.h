/// EMF observer, position PLL and notches as one loop, linearised in the frame of a steadily turning rotor: the
/// speed of the PLL is fed back to the observer.
///
/// All quantities are estimate minus truth. The coefficients are those of the tuning, converted to double. The
/// machine is only the EMF: the effect of the angle on the currents is not included
/// (docs/theory/fa_guideline.md).
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
    int pll; ///< index of theta; omega, f and the speed that tunes the observer follow if present
    bool third_order, filtered;
    double ts_s, sigma_rad_s;
    double l1, l2, l3; ///< gains of angle, speed, disturbance
    double w_weight;
    observer_t observer;                      ///< in the rotor's frame
    double complex g[OBSERVER_MODES_MAX];     ///< effect of one rad/s of the tuning speed
    double complex per_m[OBSERVER_MODES_MAX]; ///< effect of a relative deviation of m
    joint_notch_t notch[JOINT_NOTCHES];
} joint_t;

/// The loop at the electrical speed given.
joint_t joint_make(const lode_estimator_tuning_t *tuning, double omega_rad_s);

/// The same loop with the PLL and the notches of another tuning; its observer is kept.
void joint_retune(joint_t *joint, const lode_estimator_tuning_t *tuning, double omega_rad_s);

/// Only the observer part of `joint`: sufficient for joint_speed_response().
void joint_observer(joint_t *joint, const lode_observer_tuning_t *tuning, double ts_s,
                    double omega_rad_s);

/// A copy of `tuning` with the PLL's poles and the fading of the notches at `sigma_rad_s`.
lode_estimator_tuning_t joint_with_sigma(const lode_estimator_tuning_t *tuning, double sigma_rad_s);

/// A copy with the observer of `emf` and this k2. Unchanged if lode_observer_tune() does not accept k2.
lode_estimator_tuning_t joint_with_k2(const lode_estimator_tuning_t *tuning,
                                      const lode_emf_config_t *emf, double k2_rad_s);

/// Inputs of the loop over one period.
typedef struct {
    double acceleration_rad_s2; ///< of the rotor, unknown to the PLL
    double complex emf; ///< relative deviation of m: real part along it, imaginary ahead of it
} joint_input_t;

/// x[k+1] from x[k], both of `states` numbers.
void joint_step(const joint_t *joint, const joint_input_t *input, const double *from, double *to);

/// Poles as equivalents ln(z)/Ts, rad/s, the least damped first, without those at z = 0. Returns their number,
/// or -1.
int joint_poles(const joint_t *joint, double complex *poles);

/// Largest |z|; NaN if it cannot be computed.
double joint_radius(const joint_t *joint);

/// The largest |z| is below 1. Takes less time than joint_radius() unless it is very close to 1.
bool joint_is_stable(const joint_t *joint);

/// Damping of a pole: -Re/|.|
double joint_damping(double complex pole);

/// Deviation of the angle at z for deviations of m along it and ahead of it.
double complex joint_angle_response(const joint_t *joint, double complex z, double complex along,
                                    double complex ahead);

/// Angle of the estimated EMF per rad/s of the speed that the PLL predicts, at z.
double complex joint_speed_response(const joint_t *joint, double complex z);

#endif
