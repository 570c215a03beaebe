/// The papers' own forms of their estimators: forward Euler, in double, written from their equations.
///
/// For comparison with the library's exact forms, which are not used here. Paper 1: Jiang et al.,
/// Energies 2022, 15, 1943. Paper 2: Li, Hu, Ma, Liu, the frequency-adaptive observer (FA-LESO).
///
/// They act as printed. The phase detector has no sign of speed (paper 1, eq. 13): at negative speed they lock
/// half a turn off. There is no lock quality, no supervision and no limit; a state that diverges goes to
/// infinity. Angles are compensated only in the enhanced PLL, by paper 1, eq. 30.
///
/// Forward Euler means x[k] = x[k-1] + Ts f(x[k-1], u[k-1], i[k-1]): at t_k the observer of the EMF
/// has used the voltage over [t_k-1, t_k) and the current at t_k-1, the PLL the EMF at t_k-1. Only the
/// two resonators differ, the notch (paper 1, eq. 34) and the generalised integrator (paper 2, eq.
/// 30): forward Euler in the first integrator and backward Euler in the second, as it is usually
/// programmed. By forward Euler alone the notch grows without bound where 6 w Ts > k, for the numbers of
/// paper 1 above 1326 rpm.
#ifndef RIG_EULER_H
#define RIG_EULER_H

#include "rig/euler_terms.h"

/// No EMF, no motion; `i_A`: the current at t_k.
void euler_reset(euler_t *self, double complex i_A);

/// Sets the PLL so that its compensated angle is `theta_rad` at t_k; the observer continues.
void euler_hold(euler_t *self, const euler_config_t *config, double theta_rad, double omega_rad_s);

/// Sets the PLL to the present angle and speed of the EMF. The papers start from an open loop instead, which a
/// recording does not have.
void euler_acquire(euler_t *self, const euler_config_t *config);

/// One period. `u_V`: mean voltage over [t_k-1, t_k); `i_A`: current at t_k. In continuous time the
/// EXACT compensation is that of the recursions all the same.
euler_out_t euler_step(euler_t *self, const euler_config_t *config, double complex u_V,
                       double complex i_A);

/// The PLL alone, on the EMF `e_V` at t_k: the second half of euler_step().
euler_out_t euler_track(euler_t *self, const euler_config_t *config, double complex e_V);

#endif
