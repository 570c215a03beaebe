#include "lodestar/pll.h"

// Shares of the rated electrical speed. At 471 rad/s rated, sigma rises from 50 to 100 rad/s between 47 and 94 rad/s: 50 for
// the hand-over, 100 as the largest value that survives all parameter errors at once.
#define SIGMA_LOW_SHARE 0.1061f
#define SIGMA_HIGH_SHARE 0.2122f
#define OMEGA_LOW_SHARE 0.1f
#define OMEGA_HIGH_SHARE 0.2f
// Factor on both sigma for a QPLL: the angle noise is then the same (H20), and the error by an acceleration, which it does not
// know, falls to 1/2.7.
#define QPLL_TIMES 1.65f
// (P31)
#define NOTCH_PER_SIGMA 2.5f
#define NOTCH_PER_SIGMA_QPLL 1.44f
#define SIGMA_TS_MAX 0.3f
// A fifth (P10) of the largest default w0 of an observer, less rounding.
#define SIGMA_TS_DEFAULT_MAX 0.0999f

float lode_pll_times(lode_pll_kind_t kind) {
    return kind == LODE_PLL_QPLL ? QPLL_TIMES : 1.0f;
}

void lode_pll_design(lode_pll_config_t *config, float omega_rated_rad_s, float ts_s) {
    const bool given = config->sigma_rad_s > 0.0f;
    const float most = SIGMA_TS_DEFAULT_MAX / ts_s;
    const float per_share = lode_pll_times(config->kind) * omega_rated_rad_s;
    const float sigma = lode_min(SIGMA_HIGH_SHARE * per_share, most);
    const float sigma_low = lode_min(SIGMA_LOW_SHARE * per_share, most);
    config->sigma_low_rad_s =
        lode_given_or(config->sigma_low_rad_s, given ? config->sigma_rad_s : sigma_low);
    config->sigma_rad_s =
        lode_given_or(config->sigma_rad_s, lode_max(sigma, config->sigma_low_rad_s));
    config->omega_low_rad_s =
        lode_given_or(config->omega_low_rad_s, OMEGA_LOW_SHARE * omega_rated_rad_s);
    config->omega_high_rad_s =
        lode_given_or(config->omega_high_rad_s, OMEGA_HIGH_SHARE * omega_rated_rad_s);
}

lode_status_t lode_pll_tune(lode_pll_tuning_t *tuning, const lode_pll_config_t *config,
                            float ts_s) {
    if (config->kind != LODE_PLL_LESO && config->kind != LODE_PLL_QPLL) {
        return LODE_ERROR_PLL_KIND;
    }
    if (!lode_in_range(config->sigma_rad_s, 1.0f, SIGMA_TS_MAX / ts_s) ||
        !lode_in_range(config->sigma_low_rad_s, 1.0f, config->sigma_rad_s)) {
        return LODE_ERROR_PLL_SIGMA;
    }
    const float span = config->omega_high_rad_s - config->omega_low_rad_s;
    if (!(config->omega_low_rad_s >= 0.0f) || !lode_in_range(span, FLT_MIN, FLT_MAX)) {
        return LODE_ERROR_PLL_SCHEDULE;
    }
    const float x_low = lode_one_minus_exp(config->sigma_low_rad_s * ts_s);
    *tuning = (lode_pll_tuning_t){
        .ts_s = ts_s,
        .inv_ts = 1.0f / ts_s,
        .x_low = x_low,
        .x_rise = lode_one_minus_exp(config->sigma_rad_s * ts_s) - x_low,
        .omega_low = config->omega_low_rad_s,
        .inv_span = 1.0f / span,
        .third_order = config->kind == LODE_PLL_LESO ? 1u : 0u,
    };
    return LODE_OK;
}

float lode_pll_notch_rad_s(const lode_pll_config_t *config) {
    const float times = config->kind == LODE_PLL_QPLL ? NOTCH_PER_SIGMA_QPLL : NOTCH_PER_SIGMA;
    return times * config->sigma_rad_s;
}

void lode_pll_reset(lode_pll_t *self, float theta_rad, float omega_rad_s) {
    *self = (lode_pll_t){lode_sincos(theta_rad), omega_rad_s, 0.0f, 0.0f};
}
