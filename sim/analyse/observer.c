#include "analyse/observer.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "analyse/polynomial.h"
#include "emf_inline.h"

// The slope in the speed is taken over a share of it, so that k2/w in fa-multi stays smooth, and over no
// more than this angle of a period, where its fourth-order differences are good to 1e-7.
#define SLOPE_SHARE 0.05
#define SLOPE_MAX_rad 0.01
#define SETTLED 1.0e-9
enum { SETTLE_MAX = 10000 }; // periods

static const int vectors_of[] = {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) vectors,
#include "lodestar/observers.def"
#undef LODE_OBSERVER
};

static lode_ab_t *state_of(lode_observer_t *observer, int mode) {
    return mode == 0 ? &observer->e_V : &observer->own[mode - 1];
}

/// One period from a state and an input: the firmware's own step.
static void probe(const lode_observer_tuning_t *tuning, double ts_s, double omega_rad_s,
                  lode_observer_t *state, lode_ab_t m_V, double complex *column) {
    const double angle = omega_rad_s * ts_s;
    const lode_sincos_t step_angle = {(float)sin(angle), (float)cos(angle)};
    (void)lode_observer_step(state, tuning, m_V, step_angle, (float)omega_rad_s);
    for (int i = 0; i < 1 + vectors_of[tuning->kind]; ++i) {
        const lode_ab_t *x = state_of(state, i);
        column[i] = (double)x->alpha + I * (double)x->beta;
    }
}

/// All modes, also those that this tuning does not use.
static observer_t make_whole(const lode_observer_tuning_t *tuning, double ts_s,
                             double omega_rad_s) {
    observer_t o = {.modes = 1 + vectors_of[tuning->kind]};
    double complex column[OBSERVER_MODES_MAX];
    for (int k = 0; k < o.modes; ++k) {
        lode_observer_t unit;
        lode_observer_reset(&unit);
        state_of(&unit, k)->alpha = 1.0f;
        probe(tuning, ts_s, omega_rad_s, &unit, (lode_ab_t){0.0f, 0.0f}, column);
        for (int i = 0; i < o.modes; ++i) {
            o.a[i][k] = column[i];
        }
    }
    lode_observer_t rest;
    lode_observer_reset(&rest);
    probe(tuning, ts_s, omega_rad_s, &rest, (lode_ab_t){1.0f, 0.0f}, o.b);
    o.c[0] = 1.0; // e is the first state
    return o;
}

/// The modes that the input reaches.
static void find_reached(const observer_t *o, bool *reached) {
    for (int i = 0; i < o->modes; ++i) {
        reached[i] = cabs(o->b[i]) > 0.0;
    }
    for (int pass = 1; pass < o->modes; ++pass) {
        for (int i = 0; i < o->modes; ++i) {
            for (int k = 0; k < o->modes; ++k) {
                reached[i] = reached[i] || (reached[k] && cabs(o->a[i][k]) > 0.0);
            }
        }
    }
}

static observer_t only(const observer_t *whole, const bool *reached) {
    observer_t o = {.modes = 0};
    int from[OBSERVER_MODES_MAX] = {0};
    for (int i = 0; i < whole->modes; ++i) {
        if (reached[i]) {
            from[o.modes++] = i;
        }
    }
    for (int i = 0; i < o.modes; ++i) {
        o.b[i] = whole->b[from[i]];
        o.c[i] = whole->c[from[i]];
        for (int k = 0; k < o.modes; ++k) {
            o.a[i][k] = whole->a[from[i]][from[k]];
        }
    }
    return o;
}

observer_t observer_make(const lode_observer_tuning_t *tuning, double ts_s, double omega_rad_s) {
    bool reached[OBSERVER_MODES_MAX];
    const observer_t whole = make_whole(tuning, ts_s, omega_rad_s);
    find_reached(&whole, reached);
    return only(&whole, reached);
}

observer_t observer_slope(const lode_observer_tuning_t *tuning, double ts_s, double omega_rad_s) {
    const double most = SLOPE_MAX_rad / ts_s;
    const double share = SLOPE_SHARE * fabs(omega_rad_s);
    const double h = share > 0.0 ? fmin(share, most) : most;
    // (-f(w + 2h) + 8 f(w + h) - 8 f(w - h) + f(w - 2h))/12h
    const double at[] = {2.0, 1.0, -1.0, -2.0};
    const double weight[] = {-1.0, 8.0, -8.0, 1.0};
    const observer_t here = make_whole(tuning, ts_s, omega_rad_s);
    observer_t d = {.modes = here.modes};
    for (int n = 0; n < 4; ++n) {
        const observer_t near = make_whole(tuning, ts_s, omega_rad_s + at[n] * h);
        for (int i = 0; i < d.modes; ++i) {
            d.b[i] += weight[n] / (12.0 * h) * near.b[i];
            for (int k = 0; k < d.modes; ++k) {
                d.a[i][k] += weight[n] / (12.0 * h) * near.a[i][k];
            }
        }
    }
    bool reached[OBSERVER_MODES_MAX];
    find_reached(&here, reached);
    return only(&d, reached);
}

// c (1 - A/z)^-1 b as z c (z - A)^-1 b, which needs no division by z.
double complex observer_response(const observer_t *observer, double complex z) {
    matrix_t m;
    double complex x[MATRIX_MAX];
    const int n = observer->modes;
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < n; ++k) {
            m[i][k] = (i == k ? z : 0.0) - observer->a[i][k];
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
    return z * e;
}

double observer_peak(const observer_t *observer, const double complex *input) {
    const int n = observer->modes;
    double complex x[OBSERVER_MODES_MAX];
    double sum = 0.0;
    double largest = 0.0;
    for (int i = 0; i < n; ++i) {
        x[i] = input[i];
    }
    for (int step = 0; step < SETTLE_MAX; ++step) {
        double complex e = 0.0;
        double size = 0.0;
        double complex next[OBSERVER_MODES_MAX] = {0.0};
        for (int i = 0; i < n; ++i) {
            e += observer->c[i] * x[i];
            size += cabs(x[i]);
            for (int k = 0; k < n; ++k) {
                next[i] += observer->a[i][k] * x[k];
            }
        }
        sum += cabs(e);
        largest = fmax(largest, size);
        if (size <= SETTLED * largest) {
            return sum + (double)SETTLE_MAX * SETTLED * largest; // more than what is still to come
        }
        memcpy(x, next, sizeof x);
    }
    return HUGE_VAL;
}

double complex observer_circuit(const lode_motor_t *motor, double ts_s, double omega_rad_s) {
    const double mu_Ts = (double)motor->Rs_Ohm / (double)motor->Lq_H * ts_s;
    const double complex x = mu_Ts + I * omega_rad_s * ts_s;
    // Mean of exp(-(mu + j w) t) over the period, weighted as the current weights it.
    const double own = mu_Ts > 0.0 ? -expm1(-mu_Ts) / mu_Ts : 1.0;
    return cabs(x) > 0.0 ? (1.0 - cexp(-x)) / x / own : 1.0;
}
