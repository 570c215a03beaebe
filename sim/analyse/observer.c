#include "analyse/observer.h"

#include <math.h>

#include "analyse/polynomial.h"

// The constants of src/leso.c.
#define MULTI_KH_MAX_rad_s 20.0
#define MULTI_KH_SHARE 0.15
#define MULTI_LEAK_rad_s 20.0

static void make_c(observer_t *o, const lode_leso_tuning_t *t) {
    const double x = (double)t->one_m_p;
    o->modes = 2; // y, e
    o->a[0][0] = 1.0 - x;
    o->a[1][0] = x * (1.0 - x);
    o->a[1][1] = 1.0 - x;
    o->b[0] = x;
    o->b[1] = x * x;
    o->c[1] = 1.0;
}

static void make_gi(observer_t *o, const lode_leso_tuning_t *t, double omega_rad_s) {
    const double turn = tan(0.5 * omega_rad_s * (double)t->ts_s);
    const double al = (double)t->gi_al * (1.0 + turn * turn);
    const double all = 1.0 + al + turn * turn;
    const double g = (double)t->one_m_p * (double)t->one_m_p;
    const double kappa = (double)t->gi_kappa;
    const double p2 = (double)t->p2;
    o->modes = 4; // e, error, and the two integrators B and L of the band-pass
    // error = m - e + p2 error; band = (B + al error - turn L)/all
    const double error[] = {-1.0, p2, 0.0, 0.0};
    const double band[] = {-al / all, al * p2 / all, 1.0 / all, -turn / all};
    for (int k = 0; k < o->modes; ++k) {
        o->a[0][k] = (k == 0 ? 1.0 : 0.0) + g * (error[k] + kappa * band[k]);
        o->a[1][k] = error[k];
        o->a[2][k] = 2.0 * band[k] - (k == 2 ? 1.0 : 0.0);
        o->a[3][k] = 2.0 * turn * band[k] + (k == 3 ? 1.0 : 0.0);
    }
    o->b[0] = g * (1.0 + kappa * al / all);
    o->b[1] = 1.0;
    o->b[2] = 2.0 * al / all;
    o->b[3] = 2.0 * turn * al / all;
    o->c[0] = 1.0;
}

static void make_fa(observer_t *o, const lode_leso_tuning_t *t, double omega_rad_s) {
    const double q = (double)t->q;
    o->modes = 1;
    o->a[0][0] = q * cexp(I * omega_rad_s * (double)t->ts_s);
    o->b[0] = 1.0 - q;
    o->c[0] = 1.0;
}

/// k1 > 0: two modes in parallel, the slow one by the firmware's series.
static void make_fa_slow(observer_t *o, const lode_leso_tuning_t *t, double omega_rad_s) {
    const double q = (double)t->q;
    const double turn = omega_rad_s * (double)t->ts_s;
    const double complex q_rho = q * cexp(I * turn);
    const double complex x = (double)t->half_k2_Ts - 0.5 * I * turn;
    const double complex series = 1.0 + x * x / 6.0 * (1.0 + 0.05 * x * x);
    const double complex d = (double)t->k1_Ts2 * (double)t->sqrt_q * cexp(0.5 * I * turn) * series;
    const double complex all = 1.0 - q_rho + d;
    const double complex u = d / (all * all);
    const double complex away = d / all * (1.0 + u * (1.0 + u * (2.0 + 5.0 * u)));
    const double complex z2 = 1.0 - away;
    const double complex z1 = q_rho / z2;
    const double complex slow = (d - (1.0 - q) * away) / (z2 - z1);
    o->modes = 2; // fast, slow
    o->a[0][0] = z1;
    o->a[1][1] = z2;
    o->b[0] = 1.0 - q - slow;
    o->b[1] = slow;
    o->c[0] = 1.0;
    o->c[1] = 1.0;
}

static void make_multi(observer_t *o, const lode_leso_tuning_t *t, double omega_rad_s) {
    const double ts = (double)t->ts_s;
    const double speed = fabs(omega_rad_s);
    const double in = fmin(fmax((speed - (double)t->omega_low) * (double)t->inv_span, 0.0), 1.0);
    const double keep = 1.0 - (1.0 - in) * fmin(MULTI_LEAK_rad_s * ts, 1.0);
    const double kh = in * fmin(MULTI_KH_MAX_rad_s, MULTI_KH_SHARE * speed) * ts;
    const double lead = in > 0.0 ? (double)t->k2_rad_s / omega_rad_s : 0.0;
    const double order[] = {1.0, 0.0, -5.0, 7.0};
    const double complex gain[] = {1.0 - (double)t->q, 0.5 * kh * (1.0 + I * lead),
                                   kh * (1.0 + I * lead / 6.0), kh * (1.0 - I * lead / 6.0)};
    o->modes = 4; // w, 0, -5 w, 7 w
    for (int i = 0; i < o->modes; ++i) {
        for (int k = 0; k < o->modes; ++k) {
            const double complex turned =
                (k == 0 ? 1.0 : keep) * cexp(I * order[k] * omega_rad_s * ts);
            o->a[i][k] = (i == k ? turned : 0.0) - gain[i] * turned;
        }
        o->b[i] = gain[i];
    }
    o->c[0] = 1.0;
}

observer_t observer_make(const lode_leso_tuning_t *tuning, double omega_rad_s) {
    observer_t o = {.modes = 0};
    switch (tuning->kind) {
    case LODE_EMF_GI_LESO:
        make_gi(&o, tuning, omega_rad_s);
        break;
    case LODE_EMF_FA_LESO:
        if (tuning->k1_Ts2 > 0.0f) {
            make_fa_slow(&o, tuning, omega_rad_s);
        } else {
            make_fa(&o, tuning, omega_rad_s);
        }
        break;
    case LODE_EMF_FA_MULTI:
        make_multi(&o, tuning, omega_rad_s);
        break;
    case LODE_EMF_C_LESO:
    default:
        make_c(&o, tuning);
        break;
    }
    return o;
}

double complex observer_response(const observer_t *observer, double complex z) {
    matrix_t m;
    double complex x[MATRIX_MAX];
    const int n = observer->modes;
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < n; ++k) {
            m[i][k] = (i == k ? 1.0 : 0.0) - observer->a[i][k] / z;
        }
        x[i] = observer->b[i];
    }
    if (!matrix_solve(n, m, x)) {
        return NAN;
    }
    double complex e = 0.0;
    for (int i = 0; i < n; ++i) {
        e += observer->c[i] * x[i];
    }
    return e;
}

double complex observer_circuit(const lode_motor_t *motor, double ts_s, double omega_rad_s) {
    const double mu_Ts = (double)motor->Rs_Ohm / (double)motor->Lq_H * ts_s;
    const double complex x = mu_Ts + I * omega_rad_s * ts_s;
    // Mean of exp(-(mu + j w) t) over the period, weighted as the current weights it.
    const double own = mu_Ts > 0.0 ? -expm1(-mu_Ts) / mu_Ts : 1.0;
    return cabs(x) > 0.0 ? (1.0 - cexp(-x)) / x / own : 1.0;
}
