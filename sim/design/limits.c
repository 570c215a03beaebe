#include "design/limits.h"

#include <math.h>
#include <stdint.h>

#include "analyse/joint.h"
#include "analyse/loop.h"
#include "analyse/margins.h"

#define SIGMA_PER_W0 0.2
#define SIGMA_RATIO 1.05
#define OMEGA_RATIO 1.3
#define FILTER_rad_s 60.0f
#define PAPER_K 0.5
enum { ROUTH_CASES = 10000, BISECTIONS = 50 };

// ---- Notch ------------------------------------------------------------------------------------------

typedef struct {
    double k, sigma_rad_s, ts_s;
    bool third_order;
} notched_t;

/// The margin with the notch at a multiple of sigma.
static loop_ratio_t with_notch(const notched_t *n, double per_sigma) {
    const loop_ratio_t notch = loop_notch_sampled(n->k, per_sigma * n->sigma_rad_s, n->ts_s);
    const loop_ratio_t pll = loop_pll_sampled(n->sigma_rad_s, n->third_order, n->ts_s);
    return loop_product(&notch, &pll);
}

static bool is_stable(const loop_ratio_t *loop) {
    double complex poles[MATRIX_MAX];
    const int count = loop_poles(loop, poles);
    for (int k = 0; k < count; ++k) {
        if (!(creal(poles[k]) < 0.0)) {
            return false;
        }
    }
    return count > 0;
}

static double margin_deg(const notched_t *n, double per_sigma) {
    const loop_ratio_t loop = with_notch(n, per_sigma);
    return loop_metrics(&loop, 0.1 * n->sigma_rad_s, 50.0 * n->sigma_rad_s).phase_deg;
}

static limits_notch_t notch_limits(const notched_t *notched) {
    double low = 0.1;
    double high = 6.0;
    for (int n = 0; n < BISECTIONS; ++n) {
        const double middle = 0.5 * (low + high);
        const loop_ratio_t loop = with_notch(notched, middle);
        *(is_stable(&loop) ? &high : &low) = middle;
    }
    return (limits_notch_t){
        .k = notched->k,
        .least = high > 0.11 ? high : 0.0,
        .low_deg = margin_deg(notched, (double)LODE_NOTCH_LOW_SIGMA),
        .high_deg = margin_deg(notched, (double)LODE_NOTCH_HIGH_SIGMA),
    };
}

// ---- sigma against w0 -------------------------------------------------------------------------------

static void observer_limits(limits_t *limits, const lode_drive_config_t *drive) {
    lode_drive_config_t trial = *drive;
    const double w0 = (double)drive->estimator.emf.w0_rad_s;
    const double sigma = SIGMA_PER_W0 * w0;
    const double shares[] = {0.02, 0.2, 1.0};
    trial.estimator.emf.kind = LODE_EMF_C_LESO;
    trial.estimator.pll.sigma_rad_s = (float)sigma;
    trial.estimator.pll.sigma_low_rad_s = (float)sigma;
    trial.estimator.notch_k = 0.0f;
    trial.estimator.notch12_k = 0.0f;
    limits->w0_margin_deg = HUGE_VAL;
    limits->sigma_per_w0 = HUGE_VAL;
    for (int k = 0; k < 3; ++k) {
        const double omega = shares[k] * (double)drive->motor.omega_rated_rad_s;
        const margins_t m = margins_at(&trial, omega);
        limits->w0_margin_deg = fmin(limits->w0_margin_deg, m.phase_deg);
        limits->sigma_per_w0 = fmin(limits->sigma_per_w0, m.sigma_limit_rad_s / w0);
    }
    // The speed at which 6 w is 8 sigma.
    trial.estimator.notch_k = (float)PAPER_K;
    limits->w0_margin_notch_deg =
        margins_phase_deg(&trial, (double)LODE_NOTCH_HIGH_SIGMA * sigma / 6.0);
}

// ---- GI-LESO ----------------------------------------------------------------------------------------

/// The least sigma up to w0/5 that is unstable at some speed, the lowest such speed.
static double gi_limit(const lode_estimator_tuning_t *tuning, double most, double omega_max,
                       double *where) {
    double least = NAN;
    *where = NAN;
    for (double omega = 0.01 * omega_max; omega <= omega_max; omega *= OMEGA_RATIO) {
        joint_t joint = joint_make(tuning, omega);
        for (double sigma = 5.0; sigma <= most && !(sigma >= least); sigma *= SIGMA_RATIO) {
            const lode_estimator_tuning_t t = joint_with_sigma(tuning, sigma);
            joint_retune(&joint, &t, omega);
            if (!joint_is_stable(&joint)) {
                least = sigma;
                *where = omega;
            }
        }
    }
    return least;
}

static void gi_limits(limits_t *limits, const lode_drive_config_t *drive) {
    const float ts = 1.0f / drive->f_pwm_Hz;
    const double most = SIGMA_PER_W0 * (double)drive->estimator.emf.w0_rad_s;
    const double omega_max = (double)drive->estimator.omega_max_rad_s;
    lode_emf_config_t emf = drive->estimator.emf;
    lode_estimator_tuning_t tuning = {.w_weight = 1.0f};
    double ignored = 0.0;
    emf.kind = LODE_EMF_GI_LESO;
    limits->gi_sigma_rad_s = NAN;
    limits->gi_omega_rad_s = NAN;
    limits->gi_filtered_rad_s = NAN;
    if (lode_pll_tune(&tuning.pll, &drive->estimator.pll, ts) == LODE_OK &&
        lode_observer_tune(&tuning.emf.observer, &emf, lode_pll_notch_rad_s(&drive->estimator.pll),
                           ts) == LODE_OK) {
        limits->gi_sigma_rad_s = gi_limit(&tuning, most, omega_max, &limits->gi_omega_rad_s);
        tuning.w_weight = lode_one_minus_exp(FILTER_rad_s * ts);
        limits->gi_filtered_rad_s = gi_limit(&tuning, most, omega_max, &ignored);
    }
}

// ---- Routh ------------------------------------------------------------------------------------------

static double random_signed(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 11) / 4503599627370496.0 - 1.0;
}

int limits_routh_wrong(int cases) {
    uint64_t state = UINT64_C(88172645463325252);
    int wrong = 0;
    for (int k = 0; k < cases; ++k) {
        const double a1 = 300.0 * random_signed(&state);
        const double b1 = 300.0 * random_signed(&state);
        const double a2 = 3.0e4 * random_signed(&state);
        const double b2 = 3.0e4 * random_signed(&state);
        const double complex half = 0.5 * (a1 + I * b1);
        const double complex root = csqrt(half * half - (a2 + I * b2));
        const double last = fmax(creal(-half + root), creal(-half - root));
        // At the limit rounding decides.
        if (fabs(last) > 1.0e-6) {
            wrong += routh_complex_second_order(a1, b1, a2, b2) != (last < 0.0) ? 1 : 0;
        }
    }
    return wrong;
}

limits_t limits_compute(const lode_drive_config_t *drive) {
    const double ks[LIMITS_NOTCHES] = {0.1, 0.5, 2.0};
    const double ts = 1.0 / (double)drive->f_pwm_Hz;
    limits_t limits = {.routh_cases = ROUTH_CASES, .routh_wrong = limits_routh_wrong(ROUTH_CASES)};
    for (int k = 0; k < LIMITS_NOTCHES; ++k) {
        const notched_t notched = {ks[k], (double)drive->estimator.pll.sigma_rad_s, ts,
                                   drive->estimator.pll.kind == LODE_PLL_LESO};
        limits.notch[k] = notch_limits(&notched);
    }
    observer_limits(&limits, drive);
    gi_limits(&limits, drive);
    return limits;
}
