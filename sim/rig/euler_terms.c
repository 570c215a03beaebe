#include "rig/euler_terms.h"

#include <math.h>

// ---- Lags ---------------------------------------------------------------------------------------

double euler_eq30_rad(double w0_rad_s, double omega_rad_s) {
    return atan2(2.0 * w0_rad_s * omega_rad_s, w0_rad_s * w0_rad_s - omega_rad_s * omega_rad_s);
}

// From the mean of -e/Lq over [t_k, t_k+1) to z2 (FA: x2) at t_k, at z = exp(j w Ts).
static double complex response(const euler_config_t *c, double w, double tuned) {
    const double ts = c->ts_s;
    const double complex z = cexp(I * w * ts);
    const double complex d = z - 1.0;
    if (c->emf == EULER_FA_LESO) {
        const double complex slow = c->k1_rad2_s2 * ts; // times 1/d, kept apart for w = 0
        const double complex n = ts * (slow + c->k2_rad_s * d);
        return n / (n + d * (d - I * tuned * ts));
    }
    double complex stiffness = c->w0_rad_s * c->w0_rad_s;
    if (c->emf == EULER_GI_LESO) {
        const double wc = c->gi_wc_rad_s;
        stiffness += 2.0 * c->gi_Kr * wc * ts * d /
                     (d * d + 2.0 * wc * ts * d + tuned * tuned * ts * ts * z);
    }
    const double complex n = ts * ts * stiffness;
    return n / (d * (d + 2.0 * c->w0_rad_s * ts) + n);
}

double complex euler_gain(const euler_config_t *config, double omega_rad_s, double tuned_rad_s) {
    // The mean over the coming period is half a period ahead.
    const double half = 0.5 * omega_rad_s * config->ts_s;
    const double shrinks = fabs(half) > 0.0 ? sin(half) / half : 1.0;
    return shrinks * cexp(I * half) * response(config, omega_rad_s, tuned_rad_s);
}

double euler_lag_rad(const euler_config_t *config, double omega_rad_s) {
    return fabs(omega_rad_s) > 0.0 ? -carg(euler_gain(config, omega_rad_s, omega_rad_s)) : 0.0;
}

double euler_compensation_rad(const euler_config_t *config, double omega_rad_s) {
    switch (config->compensation) {
    case EULER_LAG_EQ30:
        return euler_eq30_rad(config->w0_rad_s, omega_rad_s);
    case EULER_LAG_EXACT:
        return euler_lag_rad(config, omega_rad_s);
    case EULER_LAG_NONE:
    default:
        return 0.0;
    }
}

// ---- PLLs ---------------------------------------------------------------------------------------

// Paper 1, eq. 13, normalised as in eq. 33.
double euler_phase_error(double complex e_V, double theta_rad) {
    const double length = cabs(e_V);
    const double seen = -creal(e_V) * cos(theta_rad) - cimag(e_V) * sin(theta_rad);
    return length > 0.0 ? seen / length : 0.0;
}

// Paper 1, eqs. 16-18: np/J Te - B/J w, with the torque of the measured current; the reference of
// the torque cancels in eq. 19.
double euler_acceleration(const euler_config_t *c, double complex i_A, double rotor_rad,
                          double omega_rad_s) {
    const double complex i_dq = i_A * cexp(-I * rotor_rad);
    const double flux = c->psi_Wb + (c->Ld_H - c->Lq_H) * creal(i_dq);
    const double torque = 1.5 * fmax(c->sets, 1.0) * c->pole_pairs * flux * cimag(i_dq);
    return (c->pole_pairs * torque - c->B_Nms * omega_rad_s) / c->J_kgm2;
}
