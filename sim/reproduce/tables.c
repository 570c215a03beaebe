#include "reproduce/tables.h"

#include <complex.h>
#include <math.h>

#include "pll_inline.h"
#include "reproduce/case.h"
#include "rig/euler.h"
#include "support/stats.h"
#include "support/units.h"

#define LENGTH_s 0.5
#define MEAN_s 0.01
#define STEP_rad (RIG_PI / 6.0)
#define STEP_rad_s 10.0
#define START_rad_s 94.25 // 300 rpm

static double angle_at(const theory_t *t, int motion, double t_s) {
    const double steady = START_rad_s * t_s;
    switch (motion) {
    case 0:
        return steady + STEP_rad;
    case 1:
        return steady + STEP_rad_s * t_s;
    default:
        return steady + 0.5 * t->np * rig_rad_s_from_rpm(CASE_RAMP_rpm_s) * t_s * t_s;
    }
}

static double printed_angle(euler_t *self, const euler_config_t *config, double angle_rad) {
    return euler_track(self, config, I * cexp(I * angle_rad)).theta_rad;
}

static double exact_angle(lode_pll_t *self, const lode_pll_tuning_t *tuning, double angle_rad) {
    const lode_pll_motion_t motion = lode_pll_predict(self, tuning);
    const lode_sincos_t frame = lode_angle_add(self->frame, lode_sincos(motion.angle_rad));
    const double theta = atan2((double)frame.sin, (double)frame.cos);
    const lode_pll_gains_t gains = lode_pll_gains(tuning, motion.omega_rad_s);
    const float error = (float)sin(angle_rad - theta);
    lode_pll_correct(self, gains, frame, motion.omega_rad_s, error);
    self->frame = lode_angle_normalise(self->frame);
    lode_pll_correct_disturbance(self, tuning, gains, error, 0.0f);
    return atan2((double)self->frame.sin, (double)self->frame.cos);
}

double tables_tracking_deg(const theory_t *t, bool leso, int motion, bool printed) {
    // Without current and friction there is no known acceleration.
    const euler_config_t euler_config = {.pll = leso ? EULER_LESO_QPLL : EULER_QPLL,
                                         .ts_s = t->ts_s,
                                         .pole_pairs = t->np,
                                         .J_kgm2 = t->J,
                                         .sigma_rad_s = t->sigma};
    lode_pll_config_t config = {.kind = leso ? LODE_PLL_LESO : LODE_PLL_QPLL,
                                .sigma_rad_s = (float)t->sigma};
    lode_pll_tuning_t tuning;
    lode_pll_t pll;
    euler_t euler;
    rig_stats_t error_deg;
    rig_stats_reset(&error_deg);
    lode_pll_design(&config, 471.0f, (float)t->ts_s);
    if (lode_pll_tune(&tuning, &config, (float)t->ts_s) != LODE_OK) {
        return NAN;
    }
    lode_pll_reset(&pll, (float)(-START_rad_s * t->ts_s), (float)START_rad_s);
    euler_reset(&euler, 0.0);
    euler_hold(&euler, &euler_config, -START_rad_s * t->ts_s, START_rad_s);
    const int periods = (int)lround(LENGTH_s / t->ts_s);
    const int mean_from = periods - (int)lround(MEAN_s / t->ts_s);
    for (int k = 0; k < periods; ++k) {
        const double truth = angle_at(t, motion, k * t->ts_s);
        const double seen = printed ? printed_angle(&euler, &euler_config, truth)
                                    : exact_angle(&pll, &tuning, truth);
        if (k >= mean_from) {
            rig_stats_add(&error_deg, rig_angle_error_deg(seen, truth));
        }
    }
    return rig_stats_mean(&error_deg);
}

// ---- Fig. 7 -------------------------------------------------------------------------------------

#define NUDGE_rad (RIG_PI / 180.0)
#define STRETCH_s 1.0
#define STILL_deg 1.0e-3
#define SLOWEST_rpm 20.0
#define FASTEST_rpm 1500.0
enum { BISECTIONS = 12 };

/// True if an oscillation of the angle decays from one second to the next after a deviation.
static bool comes_back(const euler_config_t *config, double omega) {
    euler_t self;
    rig_stats_t first, second;
    const double turn = omega * config->ts_s;
    const double complex mean_V = config->psi_Wb * I * omega * (cexp(I * turn) - 1.0) / (I * turn);
    const int stretch = (int)lround(STRETCH_s / config->ts_s);
    rig_stats_reset(&first);
    rig_stats_reset(&second);
    euler_reset(&self, 0.0);
    for (int k = 0; k < 3 * stretch; ++k) {
        if (k < stretch / 2) { // the observer settles first
            euler_hold(&self, config, k * turn + NUDGE_rad, omega);
        }
        const euler_out_t out = euler_step(&self, config, mean_V * cexp(I * (k * turn)), 0.0);
        if (k >= stretch) {
            rig_stats_add(k < 2 * stretch ? &first : &second,
                          rig_angle_error_deg(out.theta_rad, (k + 1) * turn));
        }
    }
    const double swing_deg = rig_stats_peak_to_peak(&second);
    return swing_deg < STILL_deg || swing_deg < rig_stats_peak_to_peak(&first);
}

double tables_lowest_stable_rpm(const theory_t *t, double notch_k, bool continuous) {
    const euler_config_t config = {.emf = EULER_C_LESO,
                                   .pll = EULER_ENHANCED,
                                   .compensation = EULER_LAG_EQ30,
                                   .ts_s = t->ts_s,
                                   .pole_pairs = t->np,
                                   .Rs_Ohm = t->Rs,
                                   .Ld_H = t->Ld,
                                   .Lq_H = t->Lq,
                                   .psi_Wb = t->psi,
                                   .J_kgm2 = t->J,
                                   .w0_rad_s = t->w0,
                                   .sigma_rad_s = t->sigma,
                                   .notch_k = notch_k,
                                   .continuous = continuous};
    double low = SLOWEST_rpm, high = FASTEST_rpm;
    for (int pass = 0; pass < BISECTIONS; ++pass) {
        const double middle = sqrt(low * high);
        const bool stable = comes_back(&config, t->np * rig_rad_s_from_rpm(middle));
        low = stable ? low : middle;
        high = stable ? middle : high;
    }
    return high;
}
