#include "analyse/joint.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analyse/polynomial.h"

enum { SQUARINGS = 20 }; // up to a million periods

typedef double square_t[JOINT_STATES_MAX][JOINT_STATES_MAX];

// ---- Making it ----------------------------------------------------------------------------------

// In coordinates of the turning EMF: A/rho, and B for m and e of length 1.
void joint_observer(joint_t *joint, const lode_observer_tuning_t *tuning, double ts_s,
                    double omega_rad_s) {
    joint_t *j = joint;
    observer_t *o = &j->observer;
    j->ts_s = ts_s;

    matrix_t m = {{0.0}};
    double complex steady[MATRIX_MAX];
    *o = observer_make(tuning, ts_s, omega_rad_s);
    const double complex rho = cexp(I * omega_rad_s * ts_s);
    for (int i = 0; i < o->modes; ++i) {
        for (int k = 0; k < o->modes; ++k) {
            o->a[i][k] /= rho;
            m[i][k] = (i == k ? 1.0 : 0.0) - o->a[i][k];
        }
        steady[i] = o->b[i];
    }
    (void)matrix_solve(o->modes, m, steady);
    double complex e = 0.0;
    for (int i = 0; i < o->modes; ++i) {
        e += o->c[i] * steady[i];
    }
    // d(A x/rho + B)/d omega with x, rho held.
    const observer_t d = observer_slope(tuning, ts_s, omega_rad_s);
    for (int i = 0; i < o->modes; ++i) {
        double complex sum = d.b[i];
        for (int k = 0; k < o->modes; ++k) {
            sum += d.a[i][k] / rho * steady[k];
        }
        j->g[i] = sum / e;
        j->per_m[i] = o->b[i] / e;
    }
}

static joint_notch_t make_notch(const lode_notch_tuning_t *tuning, double k, double omega_rad_s) {
    const double centre = (double)tuning->order_Ts * fabs(omega_rad_s);
    const double low =
        (double)(LODE_NOTCH_LOW_SIGMA / (LODE_NOTCH_HIGH_SIGMA - LODE_NOTCH_LOW_SIGMA));
    const double in = fmin(fmax(centre * (double)tuning->inv_span - low, 0.0), 1.0);
    const double least = (double)LODE_SOGI_CENTRE_MIN_rad;
    const double most = (double)LODE_SOGI_CENTRE_MAX_rad;
    return (joint_notch_t){.on = k > 0.0 && in > 0.0 && centre < most,
                           .width = k,
                           .weight = centre < most ? in : 0.0,
                           .g = tan(0.5 * fmin(fmax(centre, least), most))};
}

static void place_gains(joint_t *j, const lode_pll_tuning_t *pll, double omega_rad_s) {
    const double up = (fabs(omega_rad_s) - (double)pll->omega_low) * (double)pll->inv_span;
    const double x = (double)pll->x_low + (double)pll->x_rise * fmin(fmax(up, 0.0), 1.0);
    const double ts = j->ts_s;
    j->sigma_rad_s = -log1p(-x) / ts;
    j->third_order = pll->third_order != 0u;
    j->l1 = j->third_order ? x * (3.0 - x * (3.0 - x)) : x * (2.0 - x);
    j->l2 = (j->third_order ? 1.5 * (2.0 - x) : 1.0) * x * x / ts;
    j->l3 = j->third_order ? x * x * x / (ts * ts) : 0.0;
}

void joint_retune(joint_t *joint, const lode_estimator_tuning_t *tuning, double omega_rad_s) {
    joint_t *j = joint;
    place_gains(j, &tuning->pll, omega_rad_s);
    j->notch[0] = make_notch(&tuning->notch, (double)tuning->notch.k, omega_rad_s);
    j->notch[1] = make_notch(&tuning->notch, (double)tuning->notch12_k, 2.0 * omega_rad_s);
    j->states = j->pll + 2 + (j->third_order ? 1 : 0) + (j->filtered ? 1 : 0);
    for (int k = 0; k < JOINT_NOTCHES; ++k) {
        j->states += j->notch[k].on ? 2 : 0;
    }
}

joint_t joint_make(const lode_estimator_tuning_t *tuning, double omega_rad_s) {
    joint_t j = {.ts_s = (double)tuning->pll.ts_s, .w_weight = (double)tuning->w_weight};
    joint_observer(&j, &tuning->emf.observer, j.ts_s, omega_rad_s);
    j.filtered = j.w_weight < 1.0;
    j.pll = 2 * j.observer.modes;
    joint_retune(&j, tuning, omega_rad_s);
    return j;
}

lode_estimator_tuning_t joint_with_sigma(const lode_estimator_tuning_t *tuning,
                                         double sigma_rad_s) {
    lode_estimator_tuning_t t = *tuning;
    const float ts = tuning->pll.ts_s;
    const float sigma = (float)sigma_rad_s;
    t.pll.x_low = lode_one_minus_exp(sigma * ts);
    t.pll.x_rise = 0.0f;
    (void)lode_notch_tune(&t.notch, tuning->notch.order_Ts / ts, tuning->notch.k, sigma, ts);
    return t;
}

lode_estimator_tuning_t joint_with_k2(const lode_estimator_tuning_t *tuning,
                                      const lode_emf_config_t *emf, double k2_rad_s) {
    lode_estimator_tuning_t t = *tuning;
    lode_emf_config_t config = *emf;
    config.k2_rad_s = (float)k2_rad_s;
    const lode_pll_tuning_t *pll = &tuning->pll;
    const lode_pll_config_t loop = {
        .kind = pll->third_order != 0u ? LODE_PLL_LESO : LODE_PLL_QPLL,
        .sigma_rad_s = -log1pf(-(pll->x_low + pll->x_rise)) * pll->inv_ts,
    };
    (void)lode_observer_tune(&t.emf.observer, &config, lode_pll_notch_rad_s(&loop), pll->ts_s);
    return t;
}

// ---- Moving it ----------------------------------------------------------------------------------

/// One period of a notch, linearised about zero; updates its two states in place.
static double notch_step(const joint_notch_t *n, double x, const double *from, double *to) {
    const double k = n->width;
    const double g = n->g;
    const double high = (x - (k + g) * from[0] - from[1]) / (1.0 + g * (k + g));
    const double band = from[0] + g * high;
    const double low = from[1] + g * band;
    to[0] = band + g * high;
    to[1] = low + g * band;
    return x + n->weight * (-k * band);
}

/// The observer part; returns the angle of its estimate.
static double observer_step(const joint_t *j, double tuned_rad_s, double complex emf,
                            const double *from, double *to) {
    const observer_t *o = &j->observer;
    double complex e = 0.0;
    for (int i = 0; i < o->modes; ++i) {
        double complex x = j->g[i] * tuned_rad_s + j->per_m[i] * emf;
        for (int k = 0; k < o->modes; ++k) {
            x += o->a[i][k] * (from[2 * k] + I * from[2 * k + 1]);
        }
        to[2 * i] = creal(x);
        to[2 * i + 1] = cimag(x);
        e += o->c[i] * x;
    }
    return cimag(e);
}

void joint_step(const joint_t *joint, const joint_input_t *input, const double *from, double *to) {
    const joint_t *j = joint;
    const double ts = j->ts_s;
    int at = j->pll + 2;
    const double f = j->third_order ? from[at++] : 0.0;
    const double rise = ts * (f - input->acceleration_rad_s2);
    const double theta = from[j->pll] + ts * (from[j->pll + 1] + 0.5 * rise);
    const double omega = from[j->pll + 1] + rise;
    double tuned = omega;
    if (j->filtered) { // the true values also move on
        const double kept = from[at] - ts * input->acceleration_rad_s2;
        tuned = kept + j->w_weight * (omega - kept);
        to[at++] = tuned;
    }
    double error = observer_step(j, tuned, input->emf, from, to) - theta;
    for (int k = 0; k < JOINT_NOTCHES; ++k) {
        if (j->notch[k].on) {
            error = notch_step(&j->notch[k], error, &from[at], &to[at]);
            at += 2;
        }
    }
    to[j->pll] = theta + j->l1 * error;
    to[j->pll + 1] = omega + j->l2 * error;
    if (j->third_order) {
        to[j->pll + 2] = f + j->l3 * error;
    }
}

// ---- What follows -------------------------------------------------------------------------------

/// The motion over one period.
static void motion(const joint_t *j, square_t m) {
    const joint_input_t none = {0.0, 0.0};
    for (int k = 0; k < j->states; ++k) {
        double from[JOINT_STATES_MAX] = {0.0};
        double to[JOINT_STATES_MAX] = {0.0};
        from[k] = 1.0;
        joint_step(j, &none, from, to);
        for (int i = 0; i < j->states; ++i) {
            m[i][k] = to[i];
        }
    }
}

/// (M - 1)/Ts, with eigenvalues close to those of the continuous loop.
static void slope_matrix(const joint_t *j, matrix_t slope) {
    square_t m;
    motion(j, m);
    for (int i = 0; i < j->states; ++i) {
        for (int k = 0; k < j->states; ++k) {
            slope[i][k] = (m[i][k] - (i == k ? 1.0 : 0.0)) / j->ts_s;
        }
    }
}

static bool slopes(const joint_t *j, double complex *values) {
    matrix_t m;
    slope_matrix(j, m);
    return matrix_eigenvalues(j->states, m, values);
}

double joint_damping(double complex pole) {
    return cabs(pole) > 0.0 ? -creal(pole) / cabs(pole) : 0.0;
}

static int by_damping(const void *a, const void *b) {
    const double complex *one = (const double complex *)a;
    const double complex *other = (const double complex *)b;
    const double d = joint_damping(*one) - joint_damping(*other);
    if (fabs(d) > 1.0e-9) {
        return d < 0.0 ? -1 : 1;
    }
    const double e = creal(*other) - creal(*one);
    return e < 0.0 ? -1 : e > 0.0 ? 1 : 0;
}

int joint_poles(const joint_t *joint, double complex *poles) {
    double complex values[MATRIX_MAX];
    int count = 0;
    if (!slopes(joint, values)) {
        return -1;
    }
    for (int k = 0; k < joint->states; ++k) {
        const double complex z = 1.0 + joint->ts_s * values[k];
        if (cabs(z) > 1.0e-9) {
            poles[count++] = clog(z) / joint->ts_s;
        }
    }
    qsort(poles, (size_t)count, sizeof *poles, by_damping);
    return count;
}

double joint_radius(const joint_t *joint) {
    double complex values[MATRIX_MAX];
    double radius = 0.0;
    if (!slopes(joint, values)) {
        return NAN;
    }
    for (int k = 0; k < joint->states; ++k) {
        radius = fmax(radius, cabs(1.0 + joint->ts_s * values[k]));
    }
    return radius;
}

static void square(int n, square_t m) {
    square_t from;
    memcpy(from, m, sizeof from);
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < n; ++k) {
            m[i][k] = 0.0;
            for (int j = 0; j < n; ++j) {
                m[i][k] += from[i][j] * from[j][k];
            }
        }
    }
}

/// The largest sum of a row's magnitudes.
static double norm_of(int n, square_t m) {
    double norm = 0.0;
    for (int i = 0; i < n; ++i) {
        double sum = 0.0;
        for (int k = 0; k < n; ++k) {
            sum += fabs(m[i][k]);
        }
        norm = fmax(norm, sum);
    }
    return norm;
}

static double trace_of(int n, square_t m) {
    double sum = 0.0;
    for (int k = 0; k < n; ++k) {
        sum += m[k][k];
    }
    return sum;
}

// No |z|^p is above the norm of M^p, and the sum of all z^p is its trace.
bool joint_is_stable(const joint_t *joint) {
    const int n = joint->states;
    square_t m = {{0.0}};
    motion(joint, m);
    for (int k = 0; k < SQUARINGS; ++k) {
        if (norm_of(n, m) < 1.0) {
            return true;
        }
        if (fabs(trace_of(n, m)) > n) {
            return false;
        }
        square(n, m);
    }
    return joint_radius(joint) < 1.0;
}

double complex joint_angle_response(const joint_t *joint, double complex z, double complex along,
                                    double complex ahead) {
    matrix_t m;
    double complex x[MATRIX_MAX];
    const double rest[JOINT_STATES_MAX] = {0.0};
    double one[JOINT_STATES_MAX] = {0.0};
    double other[JOINT_STATES_MAX] = {0.0};
    const joint_input_t by_one = {0.0, 1.0};
    const joint_input_t by_other = {0.0, I};
    joint_step(joint, &by_one, rest, one);
    joint_step(joint, &by_other, rest, other);
    slope_matrix(joint, m);
    for (int i = 0; i < joint->states; ++i) {
        for (int k = 0; k < joint->states; ++k) {
            m[i][k] = (i == k ? (z - 1.0) / joint->ts_s : 0.0) - m[i][k];
        }
        x[i] = z * (one[i] * along + other[i] * ahead) / joint->ts_s;
    }
    return matrix_solve(joint->states, m, x) ? x[joint->pll] : NAN;
}

/// c (1 - A/z)^-1 g = z c (z - A)^-1 g: the estimate's complex deviation.
static double complex drag(const joint_t *joint, double complex z) {
    const observer_t *o = &joint->observer;
    matrix_t m;
    double complex x[MATRIX_MAX];
    for (int i = 0; i < o->modes; ++i) {
        for (int k = 0; k < o->modes; ++k) {
            m[i][k] = (i == k ? z : 0.0) - o->a[i][k];
        }
        x[i] = joint->g[i];
    }
    (void)matrix_solve(o->modes, m, x);
    double complex e = 0.0;
    for (int i = 0; i < o->modes; ++i) {
        e += o->c[i] * x[i];
    }
    return z * e;
}

double complex joint_speed_response(const joint_t *joint, double complex z) {
    return (drag(joint, z) - conj(drag(joint, conj(z)))) / (2.0 * I);
}
