/// Closed forms for the experiments of paper 2.
#ifndef RIG_REPRODUCE_LI_THEORY_H
#define RIG_REPRODUCE_LI_THEORY_H

#include <complex.h>

#include "reproduce/li_case.h"
#include "reproduce/theory.h"
#include "rig/euler.h"

typedef struct {
    euler_config_t euler; ///< motor and gains; emf, pll and compensation left open
    theory_t plain;       ///< of one set, for the closed forms of paper 1
} li_theory_t;

/// `base` complete.
li_theory_t li_theory_of(const rig_config_t *base);

/// From an EMF that turns at `w` to the estimate of an observer tuned to `tuned`, rad/s: as printed
/// (eqs. 17, 29, 26), in forward Euler, and in the library's form, from t_k to t_k.
double complex li_theory_printed(const li_theory_t *t, li_observer_t observer, double w,
                                 double tuned);
double complex li_theory_euler(const li_theory_t *t, li_observer_t observer, double w,
                               double tuned);
double complex li_theory_exact(const li_theory_t *t, li_observer_t observer, double w,
                               double tuned);

/// Harmonics of the estimated EMF of one set, % of the fundamental, where the EMF has `share` of them:
/// the 5th turns backwards. `gain`: one of the above.
typedef double complex (*li_gain_t)(const li_theory_t *t, li_observer_t observer, double w,
                                    double tuned);
double li_theory_harmonic_pct(const li_theory_t *t, li_gain_t gain, li_observer_t observer,
                              double speed_rpm, int order, double share);

/// What one ampere of noise in the sampled currents, at `w`, adds to the estimated EMF, V/A: of the printed
/// transfer function, in forward Euler, in the library's form.
double li_theory_noise(const li_theory_t *t, li_form_t form, li_observer_t observer, double w,
                       double tuned);

/// Variance of the estimated EMF for white noise of the currents, V^2/A^2.
double li_theory_noise_variance(const li_theory_t *t, li_form_t form, li_observer_t observer,
                                double tuned);

/// Paper 2, eqs. 42 (`dR`) and 43 (`dL`), true less assumed, with the ESTIMATED amplitude: estimate -
/// truth, degrees. `e_V`, id_A, iq_A in the estimated frame at `w`.
double li_theory_mismatch_deg(double dR_Ohm, double dL_H, double e_V, double id_A, double iq_A,
                              double w);

/// The angle at which the rated or another load is held with a wrong Lq and id* = 0, with the current
/// unknown; NaN: at none.
double li_theory_Lq_deg(const li_theory_t *t, double speed_rpm, double load_Nm, double factor,
                        double *pull_out_Nm);

/// Speed up to which the FA-LESO in forward Euler is stable, Hz.
double li_theory_euler_limit_Hz(const li_theory_t *t);

/// Largest real part of the roots of eq. 22.
double li_theory_slowest(double k1, double k2, double w);

double li_theory_rad_s(const li_theory_t *t, double speed_rpm);

#endif
