/// Closed forms for the experiments of paper 1: results of its own formulas with its Table 3.
#ifndef RIG_REPRODUCE_THEORY_H
#define RIG_REPRODUCE_THEORY_H

#include "config/rig_config.h"

/// Angles estimate - truth, electrical degrees.
typedef struct {
    double ts_s, np, Rs, Ld, Lq, psi, J, B;
    double w0, sigma;
    double loss_V;   ///< amplitude of the fundamental lost to dead time and on-state drops
    double r_on_Ohm; ///< the rest of the loss, in proportion to the current
} theory_t;

theory_t theory_of(const rig_config_t *paper);

/// Lag of the C-LESO in forward Euler: 2 arg(rho - 1 + w0 Ts) - w Ts/2, rho = exp(j w Ts).
double theory_euler_lag_deg(const theory_t *t, double speed_rpm);

/// Paper 1, eq. 30.
double theory_eq30_deg(const theory_t *t, double speed_rpm);

/// Mean error as printed. In the frame of the estimate the voltage lost in the inverter lies along the
/// current, which turns the observed EMF towards the estimate, so that a lag phi that is left becomes
///     delta = phi + asin(V sin(phi)/(w psi_a)), psi_a = psi + (Ld - Lq) I sin(delta),
/// phi = lag - compensation - Rs I Ts/(2 psi_a): Euler takes Rs i half a period late.
double theory_printed_dc_deg(const theory_t *t, double speed_rpm, double load_Nm, bool eq30);

/// Mean error of any such observer for a wrong Lq^ with id* = 0: the error that carries the load torque,
///     sin(delta) = (Lq - Lq^) I/psi_a, 1.5 np psi_a I cos(delta) = T;
/// NaN: there is none. `pull_out_Nm`: the largest torque that can be held.
double theory_mismatch_deg(const theory_t *t, double speed_rpm, double load_Nm, double factor,
                           double *pull_out_Nm);

/// The acceleration d = np T/J after a load is removed, electrical rad/s^2.
double theory_acceleration(const theory_t *t, double load_Nm);

/// Largest errors after the start of a constant acceleration d: angle and speed of QPLL (d/sigma^2, 2 d/sigma) and
/// LESO-QPLL (2 exp(-2) d/sigma^2, 0.840 d/sigma).
double theory_swing_deg(const theory_t *t, double load_Nm, bool leso);
double theory_swing_rpm(const theory_t *t, double load_Nm, bool leso);

typedef struct {
    double crossover_rad_s, margin_deg; ///< where the gain last falls through one; NaN: nowhere
    double pole_re, pole_im;            ///< dominant pair
} theory_loop_t;

/// Paper 1, Table 2: LESO-QPLL with a notch k at w_re.
/// `printed`: open loop of eq. 35; else the one that eq. 21 gives, ((s + sigma)^3 - s^3)/s^3.
theory_loop_t theory_loop(double sigma, double k, double w_re, bool printed);

/// The same of the library's sampled forms, poles as s = ln(z)/Ts.
theory_loop_t theory_loop_sampled(double sigma, double k, double w_re, double ts_s);

#endif
