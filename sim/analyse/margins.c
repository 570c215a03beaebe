#include "analyse/margins.h"

#include <complex.h>
#include <math.h>
#include <stdbool.h>

#include "analyse/joint.h"
#include "analyse/polynomial.h"
#include "observer_inline.h"
#include "support/units.h"

enum { POINTS = 4000, POINTS_COARSE = 800, BISECTIONS = 14 };
#define SWEEP_FROM_SIGMA 0.02
#define SIGMA_TS_MAX 3.0
#define SCAN_RATIO 1.1

typedef struct {
    const lode_estimator_config_t *config;
    double ts_s;
    double omega_rad_s;
    double s; ///< pole of the PLL
    bool third_order;
    bool alone;            ///< without observer and notches
    bool rotates;          ///< the observer rotates with the speed
    bool emf_follows;      ///< the EMF follows the estimated angle; else the fed-back speed acts
    double sigma_of_notch; ///< sigma of its blending
    observer_t observer;
    joint_t joint;          ///< only its observer part
    double complex rho;     ///< exp(j w Ts), the EMF's turn over one period
    double complex per_rho; ///< 1/H(rho)
} loop_t;

typedef struct {
    double crossover_rad_s, phase_deg, gain_up_dB, gain_down_dB;
    int turns; ///< upward crossings of -180 degrees above unity gain that are still missing
} sweep_t;

/// Response from a position error to the prediction of the PLL for the next period.
typedef struct {
    double complex theta, omega;
} prediction_t;

static prediction_t predict(const loop_t *loop, double complex z) {
    const double ts = loop->ts_s;
    const double s = loop->s;
    const double x = 1.0 - s;
    const double l1 = loop->third_order ? 1.0 - s * s * s : 1.0 - s * s;
    const double l2 = (loop->third_order ? 1.5 * x * x * (1.0 + s) : x * x) / ts;
    const double l3 = loop->third_order ? x * x * x / (ts * ts) : 0.0;
    const double complex sum = quotient(1.0, z - 1.0);
    const double complex x3 = l3 * sum;
    const double complex x2 = (l2 + ts * x3) * sum;
    const double complex x1 = (l1 + ts * x2 + 0.5 * ts * ts * x3) * sum;
    return (prediction_t){x1 + ts * x2 + 0.5 * ts * ts * x3, x2 + ts * x3};
}

// ---- The observer, tuned to the speed ---------------------------------------------------------------

/// exp(j x)
static double complex turn(double x) {
    return cos(x) + I * sin(x);
}

/// Its response to an oscillation of the EMF's angle with z = exp(j Omega Ts).
static double complex angle_response(const loop_t *loop, double complex z) {
    const double complex above = observer_response(&loop->observer, loop->rho * z);
    const double complex below = observer_response(&loop->observer, loop->rho * conj(z));
    return 0.5 * (above * loop->per_rho + conj(below * loop->per_rho));
}

/// Notch at a harmonic of the speed, blended in as the firmware does.
static double complex notch(const loop_t *loop, double order, double k, double complex z) {
    const double centre = order * fabs(loop->omega_rad_s) * loop->ts_s;
    const double sigma_Ts = loop->sigma_of_notch * loop->ts_s;
    const double low = (double)LODE_NOTCH_LOW_SIGMA * sigma_Ts;
    const double high = (double)LODE_NOTCH_HIGH_SIGMA * sigma_Ts;
    if (!(k > 0.0) || centre <= low || centre >= (double)LODE_SOGI_CENTRE_MAX_rad) {
        return 1.0;
    }
    const double weight = fmin((centre - low) / (high - low), 1.0);
    const double al = 0.5 * k * sin(centre);
    // z^2 - 2 cos z + 1 over itself plus al (z^2 - 1)
    const double complex top = (z - 2.0 * cos(centre)) * z + 1.0;
    return 1.0 + weight * (quotient(top, top + al * (z * z - 1.0)) - 1.0);
}

static double complex open_loop(const loop_t *loop, double Omega_rad_s) {
    const double complex z = turn(Omega_rad_s * loop->ts_s);
    const prediction_t pll = predict(loop, z);
    if (loop->alone) {
        return pll.theta;
    }
    const double complex filtered = notch(loop, 6.0, (double)loop->config->notch_k, z) *
                                    notch(loop, 12.0, (double)loop->config->notch12_k, z);
    if (loop->emf_follows) {
        return filtered * pll.theta * angle_response(loop, z);
    }
    return filtered * (pll.theta - joint_speed_response(&loop->joint, z) * pll.omega);
}

/// No gain at this or a higher frequency is larger. z - 1 becomes longer with the frequency and only divides
/// positive gains in predict(); a notch passes at most all.
static double most_gain(const loop_t *loop, double peak, double Omega_rad_s) {
    const prediction_t pll = predict(loop, 1.0 + 2.0 * sin(0.5 * Omega_rad_s * loop->ts_s));
    return creal(pll.theta) * (loop->emf_follows ? peak : 1.0) +
           creal(pll.omega) * (loop->emf_follows ? 0.0 : peak);
}

/// A frequency from which on the gain is below 1, or half the sampling frequency.
static double end_of_gain(const loop_t *loop, double peak) {
    double low = 0.0;
    double high = RIG_PI / loop->ts_s;
    for (int k = 0; k < BISECTIONS; ++k) {
        const double middle = 0.5 * (low + high);
        *(most_gain(loop, peak, middle) < 1.0 ? &high : &low) = middle;
    }
    return high;
}

static void set_sigma(loop_t *loop, double sigma_rad_s, double sigma_of_notch) {
    loop->s = exp(-sigma_rad_s * loop->ts_s);
    loop->sigma_of_notch = sigma_of_notch;
}

/// With sigma as it is scheduled at this speed.
static loop_t make_loop(const lode_drive_config_t *config, double omega_rad_s) {
    const double ts_s = 1.0 / (double)config->f_pwm_Hz;
    lode_observer_tuning_t observer = {.kind = (uint32_t)config->estimator.emf.kind};
    (void)lode_observer_tune(&observer, &config->estimator.emf,
                             lode_pll_notch_rad_s(&config->estimator.pll), (float)ts_s);
    loop_t loop = {
        .config = &config->estimator,
        .ts_s = ts_s,
        .omega_rad_s = omega_rad_s,
        .third_order = config->estimator.pll.kind == LODE_PLL_LESO,
        .rotates = lode_observer_rotates(&observer),
        .observer = observer_make(&observer, ts_s, omega_rad_s),
        .rho = turn(omega_rad_s * ts_s),
    };
    loop.per_rho = quotient(1.0, observer_response(&loop.observer, loop.rho));
    joint_observer(&loop.joint, &observer, ts_s, omega_rad_s);
    set_sigma(&loop, margins_sigma(&config->estimator.pll, omega_rad_s, ts_s),
              (double)config->estimator.pll.sigma_rad_s);
    return loop;
}

// ---- Margins --------------------------------------------------------------------------------------

/// One frequency step upwards: counts crossings of unity gain and of -180 degrees.
static void note_crossings(sweep_t *found, double gain_before, double gain, double phase_before,
                           double phase, double Omega_rad_s) {
    const bool rises = phase_before < -RIG_PI && phase >= -RIG_PI;
    const bool falls = phase_before >= -RIG_PI && phase < -RIG_PI;
    if (gain_before >= 1.0 && gain < 1.0) {
        found->crossover_rad_s = Omega_rad_s;
        found->phase_deg = rig_deg_from_rad(phase + RIG_PI);
    }
    if (rises && gain > 1.0) {
        found->gain_down_dB = 20.0 * log10(gain);
    }
    if (falls && gain < 1.0 && isnan(found->gain_up_dB)) {
        found->gain_up_dB = -20.0 * log10(gain);
    }
    if (gain > 1.0) {
        found->turns -= rises ? 1 : 0;
        found->turns += falls ? 1 : 0;
    }
}

/// Goes up in frequency, not beyond `to`; the last crossing of unity gain counts.
static sweep_t sweep(const loop_t *loop, int points, double to_rad_s) {
    const double sigma = -log(loop->s) / loop->ts_s;
    const double low = SWEEP_FROM_SIGMA * sigma;
    const double ratio = pow(RIG_PI / (loop->ts_s * low), 1.0 / points);
    sweep_t found = {NAN, NAN, NAN, NAN, 0};
    double complex before = open_loop(loop, low);
    // The integrators alone, far below sigma.
    double phase = loop->third_order ? -1.5 * RIG_PI : -RIG_PI;
    phase += remainder(carg(before) - phase, 2.0 * RIG_PI);
    found.turns = phase < -RIG_PI ? 1 : 0;
    double gain_before = sqrt(squared_magnitude(before));
    double Omega = low * ratio;
    for (int k = 0; k < points - 1 && Omega <= to_rad_s; ++k, Omega *= ratio) {
        const double complex now = open_loop(loop, Omega);
        const double gain = sqrt(squared_magnitude(now));
        const double phase_before = phase;
        phase += carg(now * conj(before));
        note_crossings(&found, gain_before, gain, phase_before, phase, Omega);
        before = now;
        gain_before = gain;
    }
    return found;
}

/// Nyquist: the phase that the integrators turn below -180 degrees must return above unity gain.
static bool is_stable(loop_t *loop, double peak, double sigma_rad_s) {
    set_sigma(loop, sigma_rad_s, sigma_rad_s);
    return sweep(loop, POINTS_COARSE, end_of_gain(loop, peak)).turns == 0;
}

/// The lowest unstable sigma; NaN if there is none in a sensible range.
static double find_sigma_limit(const loop_t *scheduled) {
    loop_t loop = *scheduled;
    const double peak = loop.emf_follows ? observer_peak(&loop.observer, loop.observer.b) *
                                               sqrt(squared_magnitude(loop.per_rho))
                                         : observer_peak(&loop.joint.observer, loop.joint.g);
    const double last = SIGMA_TS_MAX / loop.ts_s;
    double high = 1.0;
    while (high < last && is_stable(&loop, peak, high)) {
        high *= SCAN_RATIO;
    }
    if (high >= last) {
        return NAN;
    }
    double low = high / SCAN_RATIO;
    for (int k = 0; k < BISECTIONS; ++k) {
        const double middle = 0.5 * (low + high);
        if (is_stable(&loop, peak, middle)) {
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
    loop_t loop = make_loop(config, omega_rad_s);
    loop.emf_follows = !loop.rotates;
    const sweep_t whole = sweep(&loop, POINTS, HUGE_VAL);
    const double sigma_limit_rad_s = find_sigma_limit(&loop);
    loop.alone = true;
    const sweep_t alone = sweep(&loop, POINTS, HUGE_VAL);
    return (margins_t){
        .sigma_rad_s = margins_sigma(&config->estimator.pll, omega_rad_s, loop.ts_s),
        .crossover_rad_s = alone.crossover_rad_s,
        .phase_alone_deg = alone.phase_deg,
        .phase_deg = whole.phase_deg,
        .gain_up_dB = whole.gain_up_dB,
        .gain_down_dB = whole.gain_down_dB,
        .sigma_limit_rad_s = sigma_limit_rad_s,
    };
}

double margins_phase_deg(const lode_drive_config_t *config, double omega_rad_s) {
    loop_t loop = make_loop(config, omega_rad_s);
    loop.emf_follows = !loop.rotates;
    return sweep(&loop, POINTS, HUGE_VAL).phase_deg;
}

void margins_open_loop(const lode_drive_config_t *config, bool alone, double omega_rad_s, int count,
                       const double *Omega_rad_s, double complex *value) {
    loop_t loop = make_loop(config, omega_rad_s);
    loop.alone = alone;
    loop.emf_follows = !loop.rotates;
    for (int k = 0; k < count; ++k) {
        value[k] = open_loop(&loop, Omega_rad_s[k]);
    }
}

void margins_speed_response(const lode_drive_config_t *config, double omega_rad_s, int count,
                            const double *Omega_rad_s, double complex *value) {
    const loop_t loop = make_loop(config, omega_rad_s);
    for (int k = 0; k < count; ++k) {
        const double Omega = Omega_rad_s[k];
        const double complex z = turn(Omega * loop.ts_s);
        const double complex filtered = notch(&loop, 6.0, (double)loop.config->notch_k, z) *
                                        notch(&loop, 12.0, (double)loop.config->notch12_k, z);
        // An oscillation of the speed with amplitude 1 is one of the angle with amplitude 1/(j Omega).
        const double complex seen = filtered * angle_response(&loop, z) / (I * Omega);
        value[k] = predict(&loop, z).omega * seen / (1.0 + open_loop(&loop, Omega));
    }
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
    for (int k = 0; k < 2 * BISECTIONS; ++k) {
        const double middle = 0.5 * (low + high);
        if (accepts(config, middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}
