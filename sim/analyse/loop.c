#include "analyse/loop.h"

#include <math.h>

#include "support/units.h"

enum { SCAN_POINTS = 4000, BISECTIONS = 60 };

static double complex argument(const loop_ratio_t *loop, double omega_rad_s) {
    const double ts = loop->ts_s;
    return ts > 0.0 ? (cexp(I * omega_rad_s * ts) - 1.0) / ts : I * omega_rad_s;
}

loop_ratio_t loop_notch(double k, double wn_rad_s) {
    const double w2 = wn_rad_s * wn_rad_s;
    return (loop_ratio_t){
        .top = {2, {w2, 0.0, 1.0}},
        .bottom = {2, {w2, k * wn_rad_s, 1.0}},
    };
}

loop_ratio_t loop_notch_sampled(double k, double wn_rad_s, double ts_s) {
    lode_notch_tuning_t tuning;
    const double order = 6.0;
    (void)lode_notch_tune(&tuning, (float)order, (float)k, 1.0f, (float)ts_s);
    // From the firmware's recursion: z^2 - 2 c z + 1 over itself plus al (z^2 - 1).
    const double centre = (double)tuning.order_Ts * wn_rad_s / order;
    const double half = sin(0.5 * centre);
    const double lift = 4.0 * half * half / ts_s; // 2 (1 - c)/Ts
    const double al = 0.5 * (double)tuning.k * sin(centre);
    return (loop_ratio_t){
        .ts_s = ts_s,
        .top = {2, {lift / ts_s, lift, 1.0}},
        .bottom = {2, {lift / ts_s, lift + 2.0 * al / ts_s, 1.0 + al}},
    };
}

loop_ratio_t loop_pll(double sigma_rad_s, bool third_order) {
    const double s = sigma_rad_s;
    if (!third_order) {
        return (loop_ratio_t){.top = {1, {s * s, 2.0 * s}}, .bottom = {2, {0.0, 0.0, 1.0}}};
    }
    return (loop_ratio_t){.top = {2, {s * s * s, 3.0 * s * s, 3.0 * s}},
                          .bottom = {3, {0.0, 0.0, 0.0, 1.0}}};
}

loop_ratio_t loop_pll_sampled(double sigma_rad_s, bool third_order, double ts_s) {
    const lode_pll_config_t config = {.kind = third_order ? LODE_PLL_LESO : LODE_PLL_QPLL,
                                      .sigma_rad_s = (float)sigma_rad_s,
                                      .sigma_low_rad_s = (float)sigma_rad_s,
                                      .omega_high_rad_s = 1.0f};
    lode_pll_tuning_t tuning;
    if (lode_pll_tune(&tuning, &config, (float)ts_s) != LODE_OK) {
        return (loop_ratio_t){.ts_s = ts_s, .top = {0, {NAN}}, .bottom = {0, {1.0}}};
    }
    const double x = (double)tuning.x_low;
    if (!third_order) { // L1/n + L2 z/n^2
        const double l1 = x * (2.0 - x) / ts_s;
        const double l2 = x * x / (ts_s * ts_s);
        return (loop_ratio_t){
            .ts_s = ts_s, .top = {1, {l2, l1 + ts_s * l2}}, .bottom = {2, {0.0, 0.0, 1.0}}};
    }
    const double l1 = x * (3.0 - x * (3.0 - x)) / ts_s;
    const double l2 = 1.5 * (2.0 - x) * x * x / (ts_s * ts_s);
    const double l3 = x * x * x / (ts_s * ts_s * ts_s);
    // L1/n + L2 z/n^2 + L3 z (z + 1)/(2 n^3)
    return (loop_ratio_t){
        .ts_s = ts_s,
        .top = {2, {l3, l2 + 1.5 * ts_s * l3, l1 + ts_s * l2 + 0.5 * ts_s * ts_s * l3}},
        .bottom = {3, {0.0, 0.0, 0.0, 1.0}}};
}

loop_ratio_t loop_pll_misprint(double sigma_rad_s) {
    loop_ratio_t loop = loop_pll(sigma_rad_s, true);
    loop.top.degree = 3;
    loop.top.c[3] = 1.0;
    return loop;
}

loop_ratio_t loop_product(const loop_ratio_t *a, const loop_ratio_t *b) {
    return (loop_ratio_t){
        .ts_s = a->ts_s,
        .top = polynomial_product(&a->top, &b->top),
        .bottom = polynomial_product(&a->bottom, &b->bottom),
    };
}

double complex loop_at(const loop_ratio_t *loop, double omega_rad_s) {
    const double complex x = argument(loop, omega_rad_s);
    return polynomial_at(&loop->top, x) / polynomial_at(&loop->bottom, x);
}

int loop_poles(const loop_ratio_t *loop, double complex *poles) {
    const polynomial_t sum = polynomial_sum(&loop->top, &loop->bottom);
    if (!polynomial_roots(&sum, poles)) {
        return -1;
    }
    for (int k = 0; k < sum.degree && loop->ts_s > 0.0; ++k) {
        poles[k] = clog(1.0 + loop->ts_s * poles[k]) / loop->ts_s;
    }
    return sum.degree;
}

double complex loop_dominant(const loop_ratio_t *loop) {
    double complex poles[MATRIX_MAX];
    double complex found = NAN;
    double least = 2.0;
    const int count = loop_poles(loop, poles);
    for (int k = 0; k < count; ++k) {
        const double damping = -creal(poles[k]) / cabs(poles[k]);
        // Rounding splits a multiple real pole; that does not count as a pair.
        if (cimag(poles[k]) > 1.0e-3 * cabs(poles[k]) && damping < least) {
            least = damping;
            found = poles[k];
        }
    }
    return found;
}

static double open_gain(const loop_ratio_t *loop, double omega_rad_s) {
    return cabs(loop_at(loop, omega_rad_s));
}

/// Relative to -3 dB.
static double closed_gain(const loop_ratio_t *loop, double omega_rad_s) {
    const double complex open = loop_at(loop, omega_rad_s);
    return sqrt(2.0) * cabs(open / (1.0 + open));
}

/// The lowest frequency at which `gain` falls below 1.
static double first_fall(double (*gain)(const loop_ratio_t *, double), const loop_ratio_t *loop,
                         double from, double to) {
    const double ratio = pow(to / from, 1.0 / (double)SCAN_POINTS);
    double low = from;
    for (int k = 0; k < SCAN_POINTS; ++k) {
        double high = low * ratio;
        if (gain(loop, low) >= 1.0 && gain(loop, high) < 1.0) {
            for (int n = 0; n < BISECTIONS; ++n) {
                const double middle = 0.5 * (low + high);
                *(gain(loop, middle) >= 1.0 ? &low : &high) = middle;
            }
            return low;
        }
        low = high;
    }
    return NAN;
}

loop_metrics_t loop_metrics(const loop_ratio_t *loop, double from_rad_s, double to_rad_s) {
    loop_metrics_t m = {
        .crossover_rad_s = first_fall(open_gain, loop, from_rad_s, to_rad_s),
        .phase_deg = NAN,
        .bandwidth_rad_s = first_fall(closed_gain, loop, from_rad_s, to_rad_s),
    };
    if (!isnan(m.crossover_rad_s)) {
        m.phase_deg = rig_deg_from_rad(carg(-loop_at(loop, m.crossover_rad_s)));
    }
    return m;
}
