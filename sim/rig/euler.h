/// The papers' own forms of their estimators: forward Euler, in double, written from their equations.
///
/// For comparison with the library's exact forms, of which nothing is used here. Paper 1: Jiang et al.,
/// Energies 2022, 15, 1943. Paper 2: Li, Hu, Ma, Liu, the frequency-adaptive observer (FA-LESO).
///
/// They act as printed, which has consequences. There is no sign of speed in the phase detector (paper
/// 1, eq. 13): at negative speed they lock half a turn off. There is no lock quality, no supervision
/// and no range; what diverges goes on to infinity. Angles are not compensated but in the
/// enhanced PLL, by paper 1, eq. 30.
///
/// Forward Euler means x[k] = x[k-1] + Ts f(x[k-1], u[k-1], i[k-1]): at t_k the observer of the EMF
/// has used the voltage over [t_k-1, t_k) and the current at t_k-1, the PLL the EMF at t_k-1. Only the
/// two resonators differ, the notch (paper 1, eq. 34) and the generalised integrator (paper 2, eq.
/// 30): forward Euler in the first integrator and backward Euler in the second, as it is usually
/// programmed. By forward Euler alone the notch grows without bound where 6 w Ts > k, for the numbers of
/// paper 1 above 1326 rpm.
#ifndef RIG_EULER_H
#define RIG_EULER_H

#include <complex.h>
#include <stdbool.h>

typedef enum {
    EULER_C_LESO,  ///< paper 1, eqs. 11, 12
    EULER_GI_LESO, ///< paper 2, eqs. 9, 16, 29, 30
    EULER_FA_LESO  ///< paper 2, eqs. 27, 28
} euler_emf_t;

typedef enum {
    EULER_LESO_QPLL, ///< paper 1, eqs. 17-20
    EULER_QPLL,      ///< paper 1, eqs. 13-15; the speed is the integral part, see speed_of_eq14
    EULER_ENHANCED   ///< paper 1, Fig. 7: the LESO-QPLL with the notch of eq. 34 on its error
} euler_pll_t;

/// What is added to the angle of the PLL.
typedef enum {
    EULER_LAG_NONE,
    EULER_LAG_EQ30, ///< paper 1, eq. 30: that of the continuous C-LESO
    EULER_LAG_EXACT ///< that of the recursions below; no part of the papers
} euler_lag_t;

typedef struct {
    euler_emf_t emf;
    euler_pll_t pll;
    euler_lag_t compensation;
    double ts_s;
    double sets; ///< of windings, 2 with the currents of the alpha-beta plane; 0: 1
    double pole_pairs, Rs_Ohm, Ld_H, Lq_H, psi_Wb, J_kgm2, B_Nms;
    double w0_rad_s;             ///< C, GI
    double gi_Kr, gi_wc_rad_s;   ///< GI
    double k1_rad2_s2, k2_rad_s; ///< FA
    double sigma_rad_s;
    double notch_k; ///< enhanced
    /// QPLL: the speed is the output of the PI controller, as eq. 14 says. No drive runs on that with the
    /// speed controller of Section 5: its ripple alone asks for the largest current.
    bool speed_of_eq14;
    /// The same equations integrated in continuous time (rig/continuous.h), not in forward Euler.
    bool continuous;
} euler_config_t;

/// The two integrators of a resonator.
typedef struct {
    double complex band, low;
} euler_resonator_t;

typedef struct {
    double complex i_A; ///< at t_k-1
    double complex z1;  ///< estimated current, A
    double complex z2;  ///< C, GI: the same of -e/Lq, A/s. FA: integral of the current error, As
    euler_resonator_t gi;
    euler_resonator_t notch;
    double theta_rad;           ///< of the PLL
    double omega_rad_s;         ///< QPLL: the integral part
    double f_rad_s2;            ///< third order: the disturbance
    double omega_out_rad_s;     ///< what it says
    double complex e_V;         ///< estimated EMF
    double complex rotation_V2; ///< mean of e[k] conj(e[k-1])
} euler_t;

/// At t_k.
typedef struct {
    double theta_rad; ///< compensated, not wrapped
    double omega_rad_s;
    double complex e_V;
    double f_rad_s2;
} euler_out_t;

/// No EMF, no motion; `i_A`: the current at t_k.
void euler_reset(euler_t *self, double complex i_A);

/// Puts the PLL where its compensated angle is `theta_rad` at t_k; the observer goes on.
void euler_hold(euler_t *self, const euler_config_t *config, double theta_rad, double omega_rad_s);

/// Puts the PLL on the EMF as it stands and turns. The papers start from an open loop instead, which a
/// recording does not have.
void euler_acquire(euler_t *self, const euler_config_t *config);

/// One period. `u_V`: mean voltage over [t_k-1, t_k); `i_A`: current at t_k. In continuous time the
/// EXACT compensation is that of the recursions all the same.
euler_out_t euler_step(euler_t *self, const euler_config_t *config, double complex u_V,
                       double complex i_A);

/// The PLL alone, on the EMF `e_V` at t_k: the second half of euler_step().
euler_out_t euler_track(euler_t *self, const euler_config_t *config, double complex e_V);

/// From an EMF that turns at `omega_rad_s` to the estimate of an observer that is tuned to
/// `tuned_rad_s`, both at t_k, with no resistance.
double complex euler_gain(const euler_config_t *config, double omega_rad_s, double tuned_rad_s);

/// Phase of the observer's output behind the EMF in steady rotation, rad, with no resistance.
double euler_lag_rad(const euler_config_t *config, double omega_rad_s);

/// What `config` adds to the angle of the PLL, rad.
double euler_compensation_rad(const euler_config_t *config, double omega_rad_s);

/// Paper 1, eq. 13, normalised as in eq. 33.
double euler_phase_error(double complex e_V, double theta_rad);

/// Paper 1, eqs. 16-18: the acceleration that the measured current explains, rad/s^2.
double euler_acceleration(const euler_config_t *config, double complex i_A, double rotor_rad,
                          double omega_rad_s);

/// Paper 1, eq. 30, continued beyond w0, where its arc tangent jumps.
double euler_eq30_rad(double w0_rad_s, double omega_rad_s);

#endif
