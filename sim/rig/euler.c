#include "rig/euler.h"

#include <math.h>

#include "rig/continuous.h"
#include "support/units.h"

#define ROTATION_TIME_s 5.0e-3

// ---- EMF observers ------------------------------------------------------------------------------

// y'' + 2 wc y' + w^2 y = gain x' (paper 2, eq. 30): forward Euler, then backward.
static double complex generalised(euler_resonator_t *self, const euler_config_t *c, double w,
                                  double complex x) {
    const double complex out = self->band;
    const double gain = 2.0 * c->gi_Kr * c->gi_wc_rad_s;
    self->band += c->ts_s * (gain * x - 2.0 * c->gi_wc_rad_s * self->band - w * w * self->low);
    self->low += c->ts_s * self->band;
    return out;
}

// Paper 1, eqs. 11, 12; the same as eqs. 9, 16 of paper 2, whose G(s) adds to w0^2.
static double complex conventional(euler_t *self, const euler_config_t *c, double complex u_V,
                                   double complex i_A) {
    const double complex error = self->z1 - self->i_A;
    const double complex known = (u_V - c->Rs_Ohm * self->i_A) / c->Lq_H;
    const double complex extra =
        c->emf == EULER_GI_LESO ? generalised(&self->gi, c, self->omega_out_rad_s, error) : 0.0;
    self->z1 += c->ts_s * (self->z2 + known - 2.0 * c->w0_rad_s * error);
    self->z2 -= c->ts_s * (c->w0_rad_s * c->w0_rad_s * error + extra);
    self->i_A = i_A;
    return -c->Lq_H * self->z2;
}

// Paper 2, eqs. 27, 28. F there is -mu x1 of the ESTIMATED current, as in eq. 9: with the measured one,
// as eq. 7 has it, the printed mu E1 would be counted twice and eq. 26 would not follow.
static double complex adaptive(euler_t *self, const euler_config_t *c, double complex u_V,
                               double complex i_A) {
    const double mu = c->Rs_Ohm / c->Lq_H;
    const double complex before = self->z1 - self->i_A;
    const double complex x2 = -(c->k1_rad2_s2 * self->z2 + c->k2_rad_s * before);
    const double complex turn = mu + I * self->omega_out_rad_s;
    self->z1 += c->ts_s * (x2 + u_V / c->Lq_H - mu * self->z1 + turn * before);
    self->z2 += c->ts_s * before;
    self->i_A = i_A;
    return c->Lq_H * (c->k1_rad2_s2 * self->z2 + c->k2_rad_s * (self->z1 - i_A));
}

// Paper 1, eq. 34: x minus its band-pass at w.
static double notch(euler_resonator_t *self, double k, double w, double ts_s, double x) {
    const double left = x - creal(self->band);
    self->band += ts_s * w * (k * left - self->low);
    self->low += ts_s * w * self->band;
    return left;
}

static void advance(euler_t *self, const euler_config_t *c, double error, double rotor_rad) {
    const double s = c->sigma_rad_s;
    if (c->pll == EULER_QPLL) {
        self->theta_rad += c->ts_s * (self->omega_rad_s + 2.0 * s * error);
        self->omega_rad_s += c->ts_s * s * s * error;
        return;
    }
    const double known = euler_acceleration(c, self->i_A, rotor_rad, self->omega_rad_s);
    self->theta_rad += c->ts_s * (self->omega_rad_s + 3.0 * s * error);
    self->omega_rad_s += c->ts_s * (self->f_rad_s2 + known + 3.0 * s * s * error);
    self->f_rad_s2 += c->ts_s * s * s * s * error;
}

void euler_reset(euler_t *self, double complex i_A) {
    *self = (euler_t){.i_A = i_A, .z1 = i_A};
}

void euler_hold(euler_t *self, const euler_config_t *config, double theta_rad, double omega_rad_s) {
    // In forward Euler the state is already that of t_k+1.
    const double ahead_s = config->continuous ? 0.0 : config->ts_s;
    self->theta_rad =
        theta_rad - euler_compensation_rad(config, omega_rad_s) + ahead_s * omega_rad_s;
    self->omega_rad_s = omega_rad_s;
    self->omega_out_rad_s = omega_rad_s;
    self->f_rad_s2 = 0.0;
    self->notch = (euler_resonator_t){0.0, 0.0};
}

void euler_acquire(euler_t *self, const euler_config_t *config) {
    const double omega = carg(self->rotation_V2) / config->ts_s;
    const double quarter = copysign(0.5 * RIG_PI, omega);
    euler_hold(self, config, 0.0, omega);
    self->theta_rad = carg(self->e_V) - quarter + config->ts_s * omega;
}

euler_out_t euler_track(euler_t *self, const euler_config_t *config, double complex e_V) {
    self->rotation_V2 +=
        config->ts_s / ROTATION_TIME_s * (e_V * conj(self->e_V) - self->rotation_V2);
    self->e_V = e_V;
    double error = euler_phase_error(e_V, self->theta_rad);
    if (config->pll == EULER_ENHANCED) {
        error = notch(&self->notch, config->notch_k, 6.0 * fabs(self->omega_rad_s), config->ts_s,
                      error);
    }
    const bool pi = config->pll == EULER_QPLL && config->speed_of_eq14;
    self->omega_out_rad_s = self->omega_rad_s + (pi ? 2.0 * config->sigma_rad_s * error : 0.0);
    const euler_out_t out = {
        .theta_rad = self->theta_rad + euler_compensation_rad(config, self->omega_out_rad_s),
        .omega_rad_s = self->omega_out_rad_s,
        .e_V = e_V,
        .f_rad_s2 = config->pll == EULER_QPLL ? 0.0 : self->f_rad_s2,
    };
    advance(self, config, error, out.theta_rad);
    self->theta_rad = remainder(self->theta_rad, 2.0 * RIG_PI);
    return out;
}

/// The outputs follow from the state of t_k: the EMF, the speed of eq. 14.
static euler_out_t continuous_step(euler_t *self, const euler_config_t *config, double complex u_V,
                                   double complex i_A) {
    continuous_advance(self, config, u_V, i_A);
    const double complex slow =
        config->emf == EULER_FA_LESO
            ? config->k1_rad2_s2 * self->z2 + config->k2_rad_s * (self->z1 - i_A)
            : -self->z2;
    self->e_V = config->Lq_H * slow;
    self->omega_out_rad_s = self->omega_rad_s;
    if (config->pll == EULER_QPLL && config->speed_of_eq14) {
        self->omega_out_rad_s +=
            2.0 * config->sigma_rad_s * euler_phase_error(self->e_V, self->theta_rad);
    }
    return (euler_out_t){
        .theta_rad = self->theta_rad + euler_compensation_rad(config, self->omega_out_rad_s),
        .omega_rad_s = self->omega_out_rad_s,
        .e_V = self->e_V,
        .f_rad_s2 = config->pll == EULER_QPLL ? 0.0 : self->f_rad_s2,
    };
}

euler_out_t euler_step(euler_t *self, const euler_config_t *config, double complex u_V,
                       double complex i_A) {
    if (config->continuous) {
        return continuous_step(self, config, u_V, i_A);
    }
    const double complex e_V = config->emf == EULER_FA_LESO ? adaptive(self, config, u_V, i_A)
                                                            : conventional(self, config, u_V, i_A);
    return euler_track(self, config, e_V);
}
