#include "rig/continuous.h"

#include <math.h>

#define PARTS 4 // w0 Ts/4 = 0.1 for the numbers of paper 1: 1e-6 of the state per part

/// The states, or their rates of change.
typedef struct {
    double complex z1, z2, gi_band, gi_low;
    double notch_band, notch_low;
    double theta_rad, omega_rad_s, f_rad_s2;
} state_t;

static state_t state_of(const euler_t *self) {
    return (state_t){
        .z1 = self->z1,
        .z2 = self->z2,
        .gi_band = self->gi.band,
        .gi_low = self->gi.low,
        .notch_band = creal(self->notch.band),
        .notch_low = creal(self->notch.low),
        .theta_rad = self->theta_rad,
        .omega_rad_s = self->omega_rad_s,
        .f_rad_s2 = self->f_rad_s2,
    };
}

static state_t along(const state_t *from, const state_t *rate, double dt) {
    return (state_t){
        .z1 = from->z1 + dt * rate->z1,
        .z2 = from->z2 + dt * rate->z2,
        .gi_band = from->gi_band + dt * rate->gi_band,
        .gi_low = from->gi_low + dt * rate->gi_low,
        .notch_band = from->notch_band + dt * rate->notch_band,
        .notch_low = from->notch_low + dt * rate->notch_low,
        .theta_rad = from->theta_rad + dt * rate->theta_rad,
        .omega_rad_s = from->omega_rad_s + dt * rate->omega_rad_s,
        .f_rad_s2 = from->f_rad_s2 + dt * rate->f_rad_s2,
    };
}

/// Rates of the observer. Returns its EMF.
static double complex observe(const state_t *x, const euler_config_t *c, double complex u_V,
                              double complex i_A, state_t *rate) {
    const double complex error = x->z1 - i_A;
    if (c->emf == EULER_FA_LESO) { // paper 2, eqs. 27, 28
        const double mu = c->Rs_Ohm / c->Lq_H;
        const double complex x2 = -(c->k1_rad2_s2 * x->z2 + c->k2_rad_s * error);
        rate->z1 = x2 + u_V / c->Lq_H - mu * x->z1 + (mu + I * x->omega_rad_s) * error;
        rate->z2 = error;
        return -c->Lq_H * x2;
    }
    double complex extra = 0.0;
    if (c->emf == EULER_GI_LESO) { // paper 2, eq. 30
        extra = x->gi_band;
        rate->gi_band = 2.0 * c->gi_wc_rad_s * (c->gi_Kr * error - x->gi_band) -
                        x->omega_rad_s * x->omega_rad_s * x->gi_low;
        rate->gi_low = x->gi_band;
    }
    rate->z1 = x->z2 + (u_V - c->Rs_Ohm * i_A) / c->Lq_H - 2.0 * c->w0_rad_s * error;
    rate->z2 = -c->w0_rad_s * c->w0_rad_s * error - extra;
    return -c->Lq_H * x->z2;
}

static state_t rates(const state_t *x, const euler_config_t *c, double complex u_V,
                     double complex i_A) {
    state_t rate = {.theta_rad = 0.0};
    const double complex e_V = observe(x, c, u_V, i_A, &rate);
    double error = euler_phase_error(e_V, x->theta_rad);
    if (c->pll == EULER_ENHANCED) { // paper 1, eq. 34
        const double w = 6.0 * fabs(x->omega_rad_s);
        error -= x->notch_band;
        rate.notch_band = w * (c->notch_k * error - x->notch_low);
        rate.notch_low = w * x->notch_band;
    }
    const double s = c->sigma_rad_s;
    if (c->pll == EULER_QPLL) { // paper 1, eqs. 14, 15
        rate.theta_rad = x->omega_rad_s + 2.0 * s * error;
        rate.omega_rad_s = s * s * error;
        return rate;
    }
    const double rotor_rad = x->theta_rad + euler_compensation_rad(c, x->omega_rad_s);
    rate.theta_rad = x->omega_rad_s + 3.0 * s * error; // paper 1, eqs. 19, 20
    rate.omega_rad_s =
        x->f_rad_s2 + euler_acceleration(c, i_A, rotor_rad, x->omega_rad_s) + 3.0 * s * s * error;
    rate.f_rad_s2 = s * s * s * error;
    return rate;
}

/// One part: `i_A` at its start, `di_A` its change.
static state_t part(const state_t *x, const euler_config_t *c, double complex u_V,
                    double complex i_A, double complex di_A, double dt) {
    const state_t k1 = rates(x, c, u_V, i_A);
    const state_t x2 = along(x, &k1, 0.5 * dt);
    const state_t k2 = rates(&x2, c, u_V, i_A + 0.5 * di_A);
    const state_t x3 = along(x, &k2, 0.5 * dt);
    const state_t k3 = rates(&x3, c, u_V, i_A + 0.5 * di_A);
    const state_t x4 = along(x, &k3, dt);
    const state_t k4 = rates(&x4, c, u_V, i_A + di_A);
    state_t next = along(x, &k1, dt / 6.0);
    next = along(&next, &k2, dt / 3.0);
    next = along(&next, &k3, dt / 3.0);
    return along(&next, &k4, dt / 6.0);
}

void continuous_advance(euler_t *self, const euler_config_t *config, double complex u_V,
                        double complex i_A) {
    const double complex di_A = (i_A - self->i_A) / PARTS;
    state_t x = state_of(self);
    for (int k = 0; k < PARTS; ++k) {
        x = part(&x, config, u_V, self->i_A + k * di_A, di_A, config->ts_s / PARTS);
    }
    self->z1 = x.z1;
    self->z2 = x.z2;
    self->gi = (euler_resonator_t){x.gi_band, x.gi_low};
    self->notch = (euler_resonator_t){x.notch_band, x.notch_low};
    self->theta_rad = remainder(x.theta_rad, 2.0 * acos(-1.0));
    self->omega_rad_s = x.omega_rad_s;
    self->f_rad_s2 = x.f_rad_s2;
    self->i_A = i_A;
}
