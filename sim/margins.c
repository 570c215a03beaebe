#include "margins.h"

#include <complex.h>
#include <math.h>
#include <stdbool.h>

#include "units.h"

enum { POINTS = 4000, BISECTIONS = 50 };
#define SWEEP_FROM_SIGMA 0.02
#define SIGMA_TS_MAX 3.0

typedef struct {
    double ts_s;
    double omega_rad_s;
    double p; ///< pole of the C-LESO
    bool third_order;
    bool with_observer;
    double s; ///< pole of the PLL
} loop_t;

typedef struct {
    double crossover_rad_s, phase_deg, gain_up_dB, gain_down_dB;
} sweep_t;

static double complex pll_loop(const loop_t *loop, double complex z) {
    const double ts = loop->ts_s;
    const double s = loop->s;
    const double x = 1.0 - s;
    const double l1 = loop->third_order ? 1.0 - s * s * s : 1.0 - s * s;
    const double l2 = (loop->third_order ? 1.5 * x * x * (1.0 + s) : x * x) / ts;
    const double l3 = loop->third_order ? x * x * x / (ts * ts) : 0.0;
    const double complex d = z - 1.0;
    const double complex x3 = l3 / d;
    const double complex x2 = (l2 + ts * x3) / d;
    const double complex x1 = (l1 + ts * x2 + 0.5 * ts * ts * x3) / d;
    return x1 + ts * x2 + 0.5 * ts * ts * x3;
}

/// The C-LESO on the dead-beat EMF.
static double complex observer(const loop_t *loop, double complex z) {
    const double complex stage = (1.0 - loop->p) / (1.0 - loop->p / z);
    return stage * stage;
}

/// Its answer to a swing of the angle with exp(j Omega Ts).
static double complex angle_response(const loop_t *loop, double Omega_rad_s) {
    const double w = loop->omega_rad_s;
    const double ts = loop->ts_s;
    const double complex carrier = observer(loop, cexp(I * w * ts));
    const double complex above = observer(loop, cexp(I * (w + Omega_rad_s) * ts));
    const double complex below = observer(loop, cexp(I * (w - Omega_rad_s) * ts));
    return 0.5 * (above / carrier + conj(below / carrier));
}

static double complex open_loop(const loop_t *loop, double Omega_rad_s) {
    const double complex alone = pll_loop(loop, cexp(I * Omega_rad_s * loop->ts_s));
    return loop->with_observer ? alone * angle_response(loop, Omega_rad_s) : alone;
}

/// Walks up the frequencies: the last crossing of unity gain counts, and the crossings of -180
/// degrees on either side of it.
static sweep_t sweep(const loop_t *loop) {
    const double sigma = -log(loop->s) / loop->ts_s;
    const double low = SWEEP_FROM_SIGMA * sigma;
    const double ratio = pow(RIG_PI / (loop->ts_s * low), 1.0 / POINTS);
    sweep_t found = {NAN, NAN, NAN, NAN};
    double complex before = open_loop(loop, low);
    // Integrators alone, far below sigma.
    double phase = loop->third_order ? -1.5 * RIG_PI : -RIG_PI;
    phase += remainder(carg(before) - phase, 2.0 * RIG_PI);
    double Omega = low;
    for (int k = 0; k < POINTS - 1; ++k) {
        Omega *= ratio;
        const double complex now = open_loop(loop, Omega);
        const double phase_before = phase;
        phase += remainder(carg(now / before), 2.0 * RIG_PI);
        if (cabs(before) >= 1.0 && cabs(now) < 1.0) {
            found.crossover_rad_s = Omega;
            found.phase_deg = rig_deg_from_rad(phase + RIG_PI);
        }
        if (phase_before < -RIG_PI && phase >= -RIG_PI && cabs(now) > 1.0) {
            found.gain_down_dB = 20.0 * log10(cabs(now));
        }
        if (phase_before >= -RIG_PI && phase < -RIG_PI && cabs(now) < 1.0 &&
            isnan(found.gain_up_dB)) {
            found.gain_up_dB = -20.0 * log10(cabs(now));
        }
        before = now;
    }
    return found;
}

static loop_t make_loop(const lode_drive_config_t *config, double omega_rad_s, double sigma_rad_s) {
    const double ts_s = 1.0 / (double)config->f_pwm_Hz;
    return (loop_t){
        .ts_s = ts_s,
        .omega_rad_s = omega_rad_s,
        .p = exp(-(double)config->estimator.emf.w0_rad_s * ts_s),
        .third_order = config->estimator.pll.kind == LODE_PLL_LESO,
        .with_observer = true,
        .s = exp(-sigma_rad_s * ts_s),
    };
}

static bool has_margin(const lode_drive_config_t *config, double omega_rad_s, double sigma_rad_s) {
    const loop_t loop = make_loop(config, omega_rad_s, sigma_rad_s);
    return sweep(&loop).phase_deg > 0.0;
}

/// NaN where even the fastest PLL that makes sense keeps a margin.
static double find_sigma_limit(const lode_drive_config_t *config, double omega_rad_s) {
    double low = 1.0;
    double high = SIGMA_TS_MAX * (double)config->f_pwm_Hz;
    if (has_margin(config, omega_rad_s, high)) {
        return NAN;
    }
    for (int k = 0; k < BISECTIONS && high - low > 1e-4 * high; ++k) {
        const double middle = sqrt(low * high);
        if (has_margin(config, omega_rad_s, middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

double margins_sigma(const lode_pll_config_t *pll, double omega_rad_s, double ts_s) {
    const double low = (double)pll->omega_low_rad_s;
    const double span = (double)pll->omega_high_rad_s - low;
    const double up = fmin(fmax((fabs(omega_rad_s) - low) / span, 0.0), 1.0);
    const double x_low = -expm1(-(double)pll->sigma_low_rad_s * ts_s);
    const double x_high = -expm1(-(double)pll->sigma_rad_s * ts_s);
    return -log1p(-(x_low + up * (x_high - x_low))) / ts_s;
}

margins_t margins_at(const lode_drive_config_t *config, double omega_rad_s) {
    const double ts_s = 1.0 / (double)config->f_pwm_Hz;
    const double sigma = margins_sigma(&config->estimator.pll, omega_rad_s, ts_s);
    loop_t loop = make_loop(config, omega_rad_s, sigma);
    const sweep_t whole = sweep(&loop);
    loop.with_observer = false;
    const sweep_t alone = sweep(&loop);
    return (margins_t){
        .sigma_rad_s = sigma,
        .crossover_rad_s = alone.crossover_rad_s,
        .phase_alone_deg = alone.phase_deg,
        .phase_deg = whole.phase_deg,
        .gain_up_dB = whole.gain_up_dB,
        .gain_down_dB = whole.gain_down_dB,
        .sigma_limit_rad_s = find_sigma_limit(config, omega_rad_s),
    };
}

static bool accepts(const lode_drive_config_t *config, double sigma_rad_s) {
    lode_estimator_tuning_t tuning;
    lode_estimator_config_t trial = config->estimator;
    trial.pll.sigma_rad_s = (float)sigma_rad_s;
    trial.pll.sigma_low_rad_s = (float)sigma_rad_s;
    return lode_estimator_tune(&tuning, &trial, &config->motor, 1.0f / config->f_pwm_Hz) == LODE_OK;
}

double margins_sigma_accepted(const lode_drive_config_t *config) {
    double low = 1.0;
    double high = SIGMA_TS_MAX * (double)config->f_pwm_Hz;
    if (!accepts(config, low)) {
        return NAN;
    }
    for (int k = 0; k < BISECTIONS && high - low > 1e-5 * high; ++k) {
        const double middle = 0.5 * (low + high);
        if (accepts(config, middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}
