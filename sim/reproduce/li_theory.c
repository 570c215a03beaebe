#include "reproduce/li_theory.h"

#include <math.h>

#include "rig/euler_estimate.h"
#include "support/units.h"

li_theory_t li_theory_of(const rig_config_t *base) {
    li_theory_t out = {.euler = euler_estimate_gains(base), .plain = theory_of(base)};
    // Each set carries half of the torque and of the friction.
    out.plain.B *= 0.5;
    return out;
}

double li_theory_rad_s(const li_theory_t *t, double speed_rpm) {
    return t->euler.pole_pairs * rig_rad_s_from_rpm(speed_rpm);
}

// ---- Gains --------------------------------------------------------------------------------------

double complex li_theory_printed(const li_theory_t *t, li_observer_t observer, double w,
                                 double tuned) {
    const euler_config_t *c = &t->euler;
    const double complex s = I * w;
    if (observer == LI_FA) {
        const double complex n = c->k1_rad2_s2 + c->k2_rad_s * s;
        return n / (s * s - I * tuned * s + n);
    }
    double complex stiffness = c->w0_rad_s * c->w0_rad_s;
    if (observer == LI_GI) {
        stiffness += 2.0 * c->gi_Kr * c->gi_wc_rad_s * s /
                     (s * s + 2.0 * c->gi_wc_rad_s * s + tuned * tuned);
    }
    return stiffness / (s * s + 2.0 * c->w0_rad_s * s + stiffness);
}

double complex li_theory_euler(const li_theory_t *t, li_observer_t observer, double w,
                               double tuned) {
    static const euler_emf_t emf[LI_OBSERVERS] = {EULER_C_LESO, EULER_GI_LESO, EULER_FA_LESO};
    euler_config_t config = t->euler;
    config.emf = emf[observer];
    return euler_gain(&config, w, tuned);
}

// From the dead-beat EMF to the estimate (docs/theory/emf.md, E10, E13, E18).
static double complex filter(const euler_config_t *c, li_observer_t observer, double w,
                             double tuned) {
    const double ts = c->ts_s;
    const double complex z = cexp(I * w * ts);
    const double p = exp(-c->w0_rad_s * ts);
    if (observer == LI_C) {
        const double complex stage = (1.0 - p) / (1.0 - p / z);
        return stage * stage;
    }
    if (observer == LI_GI) {
        const double complex s = I * w;
        const double wc = c->gi_wc_rad_s;
        const double complex band = 2.0 * wc * s / (s * s + 2.0 * wc * s + tuned * tuned);
        const double kappa = c->gi_Kr / (c->w0_rad_s * c->w0_rad_s);
        const double complex g = (1.0 - p) * (1.0 - p) * (1.0 + kappa * band);
        return g * z * z / ((z - 1.0) * (z - p * p) + g * z);
    }
    const double complex half = 0.5 * (c->k2_rad_s - I * tuned);
    const double complex root = csqrt(half * half - c->k1_rad2_s2);
    const double complex z1 = cexp(ts * (-half + root)), z2 = cexp(ts * (-half - root));
    const double complex rho = cexp(I * tuned * ts);
    return 1.0 - z1 * z2 / rho * (z - 1.0) * (z - rho) / ((z - z1) * (z - z2));
}

double complex li_theory_exact(const li_theory_t *t, li_observer_t observer, double w,
                               double tuned) {
    const euler_config_t *c = &t->euler;
    const double mu = c->Rs_Ohm / c->Lq_H;
    const double a = exp(-mu * c->ts_s);
    const double b = (1.0 - a) / c->Rs_Ohm;
    const double complex z = cexp(I * w * c->ts_s);
    const double complex gamma = (z - a) / ((mu + I * w) * b * c->Lq_H);
    return gamma / z * filter(c, observer, w, tuned);
}

double li_theory_noise(const li_theory_t *t, li_form_t form, li_observer_t observer, double w,
                       double tuned) {
    const euler_config_t *c = &t->euler;
    const double mu = c->Rs_Ohm / c->Lq_H;
    const double half = 0.5 * w * c->ts_s;
    const double shrinks = fabs(half) > 0.0 ? sin(half) / half : 1.0;
    const double complex z = cexp(I * w * c->ts_s);
    const double a = exp(-mu * c->ts_s);
    switch (form) {
    case LI_EULER: // what the noise would have to be driven by, as the recursion sees it
        return cabs(li_theory_euler(t, observer, w, tuned)) / shrinks * c->Lq_H *
               cabs((z - 1.0) / c->ts_s + mu);
    case LI_SAMPLED:
        return cabs(filter(c, observer, w, tuned) * (1.0 - a / z)) * c->Rs_Ohm / (1.0 - a);
    case LI_CONTINUOUS:
    case LI_FORMS:
    default:
        return cabs(li_theory_printed(t, observer, w, tuned) * (c->Rs_Ohm + I * w * c->Lq_H));
    }
}

double li_theory_noise_variance(const li_theory_t *t, li_form_t form, li_observer_t observer,
                                double tuned) {
    enum { POINTS = 40000 }; // an even number: none of them at w = 0
    const double band = 2.0 * RIG_PI / t->euler.ts_s;
    double sum = 0.0;
    for (int k = 0; k < POINTS; ++k) {
        const double w = band * ((k + 0.5) / (double)POINTS - 0.5);
        sum += pow(li_theory_noise(t, form, observer, w, tuned), 2.0);
    }
    return sum / (double)POINTS;
}

double li_theory_harmonic_pct(const li_theory_t *t, li_gain_t gain, li_observer_t observer,
                              double speed_rpm, int order, double share) {
    const double w = li_theory_rad_s(t, speed_rpm);
    const double turn = order == 5 ? -5.0 : (double)order;
    return 100.0 * share * cabs(gain(t, observer, turn * w, w)) / cabs(gain(t, observer, w, w));
}

// ---- Mismatch -----------------------------------------------------------------------------------

double li_theory_mismatch_deg(double dR_Ohm, double dL_H, double e_V, double id_A, double iq_A,
                              double w) {
    const double d_V = w * dL_H * iq_A - dR_Ohm * id_A;
    const double q_V = e_V - dR_Ohm * iq_A - w * dL_H * id_A;
    return rig_deg_from_rad(atan2(d_V, q_V));
}

double li_theory_Lq_deg(const li_theory_t *t, double speed_rpm, double load_Nm, double factor,
                        double *pull_out_Nm) {
    const double deg =
        theory_mismatch_deg(&t->plain, speed_rpm, 0.5 * load_Nm, factor, pull_out_Nm);
    *pull_out_Nm *= 2.0;
    return deg;
}

// ---- Stability ----------------------------------------------------------------------------------

// Largest magnitude of the roots of z^2 + b z + c.
static double largest(double complex b, double complex c) {
    const double complex root = csqrt(0.25 * b * b - c);
    return fmax(cabs(-0.5 * b + root), cabs(-0.5 * b - root));
}

double li_theory_euler_limit_Hz(const li_theory_t *t) {
    const euler_config_t *c = &t->euler;
    double low = 1.0, high = 0.5 / c->ts_s;
    for (int pass = 0; pass < 60; ++pass) {
        const double middle = 0.5 * (low + high);
        // With d = z - 1: d (d + Ts (k2 - j w)) + Ts^2 k1.
        const double complex k = c->ts_s * (c->k2_rad_s - I * 2.0 * RIG_PI * middle);
        const double slow = c->ts_s * c->ts_s * c->k1_rad2_s2;
        const bool stable = largest(k - 2.0, 1.0 - k + slow) < 1.0;
        low = stable ? middle : low;
        high = stable ? high : middle;
    }
    return low;
}

double li_theory_slowest(double k1, double k2, double w) {
    const double complex half = 0.5 * (k2 - I * w);
    const double complex root = csqrt(half * half - k1);
    return fmax(creal(-half + root), creal(-half - root));
}
