#include "lodestar/sogi.h"

void lode_sogi_reset(lode_sogi_t *self) {
    *self = (lode_sogi_t){0.0f, 0.0f};
}

lode_sogi_tuning_t lode_sogi_tune(float k, float wn_Ts) {
    const float width = lode_clamp(k, 0.001f, 2.0f);
    const float centre = lode_clamp(wn_Ts, LODE_SOGI_CENTRE_MIN_rad, LODE_SOGI_CENTRE_MAX_rad);
    const lode_sincos_t quarter = lode_sincos_octant(0.25f * centre);
    const lode_sincos_t half = lode_angle_add(quarter, quarter);
    const float g = half.sin / half.cos;
    return (lode_sogi_tuning_t){width, g, 1.0f / (1.0f + g * (width + g))};
}
