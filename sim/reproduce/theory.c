#include "reproduce/theory.h"

#include <complex.h>
#include <math.h>

#include "support/units.h"

theory_t theory_of(const rig_config_t *paper) {
    const lode_motor_t *motor = &paper->drive.motor;
    const rig_plant_t *plant = &paper->plant;
    const double duty = plant->dead_time_s * (double)paper->drive.f_pwm_Hz;
    return (theory_t){
        .ts_s = 1.0 / (double)paper->drive.f_pwm_Hz,
        .np = (double)motor->pole_pairs,
        .Rs = (double)motor->Rs_Ohm,
        .Ld = (double)motor->Ld_H,
        .Lq = (double)motor->Lq_H,
        .psi = (double)motor->psi_Wb,
        .J = (double)motor->J_kgm2,
        .B = (double)motor->B_Nms,
        .w0 = (double)paper->drive.estimator.emf.w0_rad_s,
        .sigma = (double)paper->drive.estimator.pll.sigma_rad_s,
        .loss_V = 4.0 / RIG_PI * (duty * plant->v_bus_V + plant->v_drop_V),
        .r_on_Ohm = plant->r_on_Ohm,
    };
}

// ---- Angles -------------------------------------------------------------------------------------

static double electrical(const theory_t *t, double speed_rpm) {
    return t->np * rig_rad_s_from_rpm(speed_rpm);
}

double theory_euler_lag_deg(const theory_t *t, double speed_rpm) {
    const double turn = electrical(t, speed_rpm) * t->ts_s;
    const double complex rho = cexp(I * turn);
    return rig_deg_from_rad(2.0 * carg(rho - 1.0 + t->w0 * t->ts_s) - 0.5 * turn);
}

double theory_eq30_deg(const theory_t *t, double speed_rpm) {
    const double w = electrical(t, speed_rpm);
    return rig_deg_from_rad(atan(2.0 * t->w0 * w / (t->w0 * t->w0 - w * w)));
}

/// A current I along the estimated q axis, whose angle is `lag` behind the truth.
typedef struct {
    double I_A, psi_a, torque;
} point_t;

static point_t at(const theory_t *t, double I_A, double lag) {
    const double psi_a = t->psi + (t->Ld - t->Lq) * I_A * sin(lag);
    return (point_t){I_A, psi_a, 1.5 * t->np * psi_a * I_A * cos(lag)};
}

double theory_printed_dc_deg(const theory_t *t, double speed_rpm, double load_Nm, bool eq30) {
    const double w = electrical(t, speed_rpm);
    const double torque = load_Nm + t->B * w / t->np;
    const double left =
        theory_euler_lag_deg(t, speed_rpm) - (eq30 ? theory_eq30_deg(t, speed_rpm) : 0.0);
    const bool loaded = load_Nm > 0.0;
    double lag = rig_rad_from_deg(left);
    double I_A = 0.0;
    // Contracts by V/E per pass.
    for (int pass = 0; loaded && pass < 200; ++pass) {
        const point_t now = at(t, I_A, lag);
        I_A += 0.5 * (torque / (1.5 * t->np * now.psi_a * cos(lag)) - I_A);
        const double phi = rig_rad_from_deg(left) - 0.5 * t->Rs * I_A * t->ts_s / now.psi_a;
        const double loss = t->loss_V + t->r_on_Ohm * I_A;
        lag = phi + asin(loss * sin(phi) / (w * now.psi_a));
    }
    return -rig_deg_from_rad(lag);
}

double theory_mismatch_deg(const theory_t *t, double speed_rpm, double load_Nm, double factor,
                           double *pull_out_Nm) {
    enum { STEPS = 4000 };
    const double torque = load_Nm + t->B * electrical(t, speed_rpm) / t->np;
    const double off_H = (1.0 - factor) * t->Lq;
    double found_deg = NAN;
    *pull_out_Nm = 0.0;
    // The torque rises along the branch that begins at no current, up to the pull-out.
    for (int k = 1; k <= STEPS; ++k) {
        const double I_A = 40.0 * k / (double)STEPS;
        double s = 0.0; // sin of the error
        for (int pass = 0; pass < 40; ++pass) {
            s = fmin(fmax(off_H * I_A / at(t, I_A, asin(-s)).psi_a, -0.999), 0.999);
        }
        const double now_Nm = at(t, I_A, asin(-s)).torque;
        if (!(now_Nm > *pull_out_Nm)) {
            break;
        }
        *pull_out_Nm = now_Nm;
        if (now_Nm >= torque && isnan(found_deg)) {
            found_deg = rig_deg_from_rad(asin(s));
        }
    }
    return found_deg;
}

double theory_acceleration(const theory_t *t, double load_Nm) {
    return t->np * load_Nm / t->J;
}

double theory_swing_deg(const theory_t *t, double load_Nm, bool leso) {
    const double angle = theory_acceleration(t, load_Nm) / (t->sigma * t->sigma);
    return rig_deg_from_rad(leso ? 2.0 * exp(-2.0) * angle : angle);
}

double theory_swing_rpm(const theory_t *t, double load_Nm, bool leso) {
    const double x = 0.5 * (1.0 + sqrt(5.0)); // where (x + x^2) exp(-x) is largest
    const double share = leso ? (x + x * x) * exp(-x) : 2.0;
    return rig_rpm_from_rad_s(share * theory_acceleration(t, load_Nm) / t->sigma) / t->np;
}

// ---- Table 2 ------------------------------------------------------------------------------------

enum { DEGREE_MAX = 5 };

/// Coefficients from the constant one up.
typedef struct {
    int degree;
    double c[DEGREE_MAX + 1];
} poly_t;

static double complex value(const poly_t *p, double complex x) {
    double complex sum = 0.0;
    for (int k = p->degree; k >= 0; --k) {
        sum = sum * x + p->c[k];
    }
    return sum;
}

static poly_t product(poly_t a, poly_t b) {
    poly_t out = {.degree = a.degree + b.degree};
    for (int i = 0; i <= a.degree; ++i) {
        for (int k = 0; k <= b.degree; ++k) {
            out.c[i + k] += a.c[i] * b.c[k];
        }
    }
    return out;
}

static poly_t added(poly_t a, poly_t b) {
    poly_t out = a.degree >= b.degree ? a : b;
    const poly_t *other = a.degree >= b.degree ? &b : &a;
    for (int k = 0; k <= other->degree; ++k) {
        out.c[k] += other->c[k];
    }
    return out;
}

static void roots(poly_t p, double complex root[DEGREE_MAX]) {
    const double radius = pow(fabs(p.c[0] / p.c[p.degree]), 1.0 / p.degree);
    for (int k = 0; k < p.degree; ++k) {
        root[k] = radius * cpow(0.4 + 0.9 * I, k);
    }
    for (int pass = 0; pass < 500; ++pass) { // Durand and Kerner
        for (int k = 0; k < p.degree; ++k) {
            double complex below = p.c[p.degree];
            for (int i = 0; i < p.degree; ++i) {
                below *= i != k ? root[k] - root[i] : 1.0;
            }
            root[k] -= value(&p, root[k]) / below;
        }
    }
}

/// An open loop, in s or (ts_s > 0) in z.
typedef struct {
    poly_t num, den;
    double ts_s;
} loop_t;

static double complex point_at(const loop_t *loop, double w) {
    const double complex x = loop->ts_s > 0.0 ? cexp(I * w * loop->ts_s) : I * w;
    return value(&loop->num, x) / value(&loop->den, x);
}

static theory_loop_t metrics(const loop_t *loop) {
    theory_loop_t out = {NAN, NAN, -HUGE_VAL, 0.0};
    const double top = loop->ts_s > 0.0 ? 0.95 * RIG_PI / loop->ts_s : 1.0e5;
    // The last frequency at which the gain falls through one.
    bool below = false;
    for (double w = top; w > 1.0 && isnan(out.crossover_rad_s); w *= 0.9999) {
        const bool above = cabs(point_at(loop, w)) >= 1.0;
        if (above && below) {
            out.crossover_rad_s = w;
            out.margin_deg = 180.0 + rig_deg_from_rad(carg(point_at(loop, w)));
        }
        below = !above;
    }
    double complex root[DEGREE_MAX];
    const poly_t closed = added(loop->num, loop->den);
    roots(closed, root);
    for (int k = 0; k < closed.degree; ++k) {
        const double complex s = loop->ts_s > 0.0 ? clog(root[k]) / loop->ts_s : root[k];
        if (creal(s) > out.pole_re) {
            out.pole_re = creal(s);
            out.pole_im = fabs(cimag(s));
        }
    }
    return out;
}

theory_loop_t theory_loop(double sigma, double k, double w_re, bool printed) {
    const poly_t cube = {3, {0.0, 0.0, 0.0, 1.0}};
    const double s3 = sigma * sigma * sigma;
    const poly_t gains = {2, {s3, 3.0 * sigma * sigma, 3.0 * sigma}};
    const poly_t notch_num = {2, {w_re * w_re, 0.0, 1.0}};
    const poly_t notch_den = {2, {w_re * w_re, k * w_re, 1.0}};
    const loop_t loop = {product(printed ? added(gains, cube) : gains, notch_num),
                         product(cube, notch_den), 0.0};
    return metrics(&loop);
}

theory_loop_t theory_loop_sampled(double sigma, double k, double w_re, double ts_s) {
    const double q = exp(-sigma * ts_s);
    const double l1 = 1.0 - q * q * q;
    const double l2 = 1.5 * (1.0 - q) * (1.0 - q) * (1.0 + q); // times Ts
    const double l3 = (1.0 - q) * (1.0 - q) * (1.0 - q);       // times Ts^2
    // In powers of d = z - 1: (l1 + l2 + l3/2) d^2 + (l2 + 1.5 l3) d + l3, over d^3.
    const double a = l1 + l2 + 0.5 * l3, b = l2 + 1.5 * l3;
    const poly_t gains = {2, {a - b + l3, b - 2.0 * a, a}};
    const poly_t integrals = {3, {-1.0, 3.0, -3.0, 1.0}};
    const double al = 0.5 * k * sin(w_re * ts_s), c = cos(w_re * ts_s);
    const poly_t notch_num = {2, {1.0, -2.0 * c, 1.0}};
    const poly_t notch_den = {2, {1.0 - al, -2.0 * c, 1.0 + al}};
    const loop_t loop = {product(gains, notch_num), product(integrals, notch_den), ts_s};
    return metrics(&loop);
}
