// Shared by several observers.
#ifndef LODESTAR_OBSERVER_COMMON_H
#define LODESTAR_OBSERVER_COMMON_H

#include "lodestar/observer.h"

// Default bandwidth over the rated speed: paper 1 has 2000 rad/s at 471 rad/s. It is not lowered at few periods per turn:
// (E29).
#define W0_PER_OMEGA_RATED 4.25f
#define W0_TS_MAX 2.0f
#define K2_TS_MAX 1.0f
#define OBSERVER_K2_DELAY 1.6f // tuned by the PLL's speed (P32)

// The default of w0.
LODE_INLINE void observer_design_w0(lode_observer_config_t *config, float omega_rated_rad_s,
                                    float ts_s) {
    const float w0 = lode_min(W0_PER_OMEGA_RATED * omega_rated_rad_s, W0_TS_MAX / ts_s);
    config->w0_rad_s = lode_given_or(config->w0_rad_s, w0);
}

LODE_INLINE lode_status_t observer_check_w0(const lode_observer_config_t *config, float ts_s) {
    return lode_in_range(config->w0_rad_s, 1.0f, W0_TS_MAX / ts_s) ? LODE_OK : LODE_ERROR_EMF_W0;
}

// Delay of the observer in (K22), in time constants of its bandwidth.
LODE_INLINE float observer_delay_s(float times, float bandwidth_rad_s) {
    return times / lode_max(bandwidth_rad_s, FLT_MIN);
}

// The default of k2: a multiple of the PLL's sigma.
LODE_INLINE void observer_design_k2(lode_observer_config_t *config, float per_sigma,
                                    float sigma_rad_s, float ts_s) {
    const float k2 = lode_min(per_sigma * sigma_rad_s, K2_TS_MAX / ts_s);
    config->k2_rad_s = lode_given_or(config->k2_rad_s, k2);
}

LODE_INLINE lode_status_t observer_check_k2(const lode_observer_config_t *config, float ts_s) {
    return lode_in_range(config->k2_rad_s, 1.0f, 1.001f * K2_TS_MAX / ts_s) ? LODE_OK
                                                                            : LODE_ERROR_EMF_FA;
}

// exp(-x) of a pole.
LODE_INLINE float observer_pole(float x) {
    return 1.0f - lode_one_minus_exp(x);
}

// arg(exp(j angle) - pole) for a real pole, from 1 - pole, without cancellation.
LODE_INLINE float observer_arg_from_pole(float one_m_pole, float angle_rad) {
    const float half = lode_sincos(0.5f * angle_rad).sin;
    return lode_atan2(lode_sincos(angle_rad).sin, one_m_pole - 2.0f * half * half);
}

#endif
