#include "lag_inline.h"

#define CHECK_POINTS 48

// The lag to be compensated, as a function of speed.
typedef struct {
    lode_lag_kind_t kind;
    const lode_emf_config_t *config;
    const lode_motor_t *motor;
    float ts_s;
} wanted_t;

static float lag_at(const wanted_t *wanted, float omega) {
    return wanted->kind == LODE_LAG_EQ30
               ? 2.0f * lode_atan2(omega, wanted->config->w0_rad_s)
               : lode_emf_lag_rad(wanted->config, wanted->motor, wanted->ts_s, omega);
}

// Interpolates at the Chebyshev nodes of [0, 1]: Newton's divided differences, then expanded. Expects coefficients of 0.
static void fit(lode_lag_t *lag, const wanted_t *wanted, float range) {
    float node[LODE_LAG_TERMS];
    float newton[LODE_LAG_TERMS];
    for (int32_t i = 0; i < LODE_LAG_TERMS; i++) {
        const float angle = LODE_PI * ((float)i + 0.5f) / (float)LODE_LAG_TERMS;
        node[i] = 0.5f - 0.5f * lode_sincos(angle).cos;
        const float omega = range * lode_sqrt(node[i]);
        newton[i] = lag_at(wanted, omega) / omega; // lag per speed, s
    }
    for (int32_t order = 1; order < LODE_LAG_TERMS; order++) {
        for (int32_t i = LODE_LAG_TERMS - 1; i >= order; i--) {
            newton[i] = (newton[i] - newton[i - 1]) / (node[i] - node[i - order]);
        }
    }
    float *c = lag->coefficient;
    for (int32_t i = LODE_LAG_TERMS - 1; i >= 0; i--) { // c(v) = c(v) (v - node) + newton
        for (int32_t j = LODE_LAG_TERMS - 1; j > 0; j--) {
            c[j] = c[j - 1] - node[i] * c[j];
        }
        c[0] = newton[i] - node[i] * c[0];
    }
}

lode_status_t lode_lag_tune(lode_lag_t *lag, lode_lag_kind_t kind, const lode_emf_config_t *config,
                            const lode_motor_t *motor, float ts_s, float omega_max_rad_s) {
    lode_lag_t fitted = {1.0f / (omega_max_rad_s * omega_max_rad_s), {0.0f}};
    if (kind == LODE_LAG_EXACT || kind == LODE_LAG_EQ30) {
        const wanted_t wanted = {kind, config, motor, ts_s};
        fit(&fitted, &wanted, omega_max_rad_s);
        for (int32_t i = 1; i <= CHECK_POINTS; i++) {
            const float omega = omega_max_rad_s * (float)i / (float)CHECK_POINTS;
            const float error = lode_lag_rad(&fitted, omega) - lag_at(&wanted, omega);
            if (!lode_in_range(error, -LODE_LAG_TOLERANCE_rad, LODE_LAG_TOLERANCE_rad)) {
                return LODE_ERROR_LAG;
            }
        }
    } else if (kind != LODE_LAG_NONE) {
        return LODE_ERROR_LAG;
    } else {
        // no compensation
    }
    *lag = fitted;
    return LODE_OK;
}
