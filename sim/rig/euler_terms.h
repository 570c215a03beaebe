/// Common parts of the papers' equations for every integration method: settings, states, and single terms.
#ifndef RIG_EULER_TERMS_H
#define RIG_EULER_TERMS_H

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
    double sets; ///< winding sets, 2 with the currents of the alpha-beta plane; 0: 1
    double pole_pairs, Rs_Ohm, Ld_H, Lq_H, psi_Wb, J_kgm2, B_Nms;
    double w0_rad_s;             ///< C, GI
    double gi_Kr, gi_wc_rad_s;   ///< GI
    double k1_rad2_s2, k2_rad_s; ///< FA
    double sigma_rad_s;
    double notch_k; ///< enhanced
    /// QPLL: the speed is the output of the PI controller, as in eq. 14. No drive runs on that with the speed
    /// controller of Section 5: its ripple alone makes the controller request the largest current.
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
    double omega_out_rad_s;     ///< output speed of the PLL
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

/// Response from an EMF that turns at `omega_rad_s` to the estimate of an observer tuned to `tuned_rad_s`, both
/// at t_k, without resistance.
double complex euler_gain(const euler_config_t *config, double omega_rad_s, double tuned_rad_s);

/// Lag of the observer's output behind the EMF in steady rotation, rad, without resistance.
double euler_lag_rad(const euler_config_t *config, double omega_rad_s);

/// Compensation that `config` adds to the angle of the PLL, rad.
double euler_compensation_rad(const euler_config_t *config, double omega_rad_s);

/// Paper 1, eq. 13, normalised as in eq. 33.
double euler_phase_error(double complex e_V, double theta_rad);

/// Paper 1, eqs. 16-18: the acceleration that the measured current explains, rad/s^2.
double euler_acceleration(const euler_config_t *config, double complex i_A, double rotor_rad,
                          double omega_rad_s);

/// Paper 1, eq. 30, continued beyond w0, where its arctangent jumps.
double euler_eq30_rad(double w0_rad_s, double omega_rad_s);

#endif
