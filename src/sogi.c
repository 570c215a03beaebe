#include "sogi_inline.h"

void lode_sogi_reset(lode_sogi_t *self) {
    *self = (lode_sogi_t){0.0f, 0.0f};
}

lode_sogi_tuning_t lode_sogi_tune(float k, float wn_Ts) {
    return lode_sogi_tune_within(
        lode_clamp(k, 0.001f, 2.0f),
        lode_clamp(wn_Ts, LODE_SOGI_CENTRE_MIN_rad, LODE_SOGI_CENTRE_MAX_rad));
}
