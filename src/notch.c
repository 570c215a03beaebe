#include "notch_inline.h"

// Speed at which the notch begins to fade in, over the span of its fade (P14).
#define LOW (LODE_NOTCH_LOW_SIGMA / (LODE_NOTCH_HIGH_SIGMA - LODE_NOTCH_LOW_SIGMA))

lode_status_t lode_notch_tune(lode_notch_tuning_t *tuning, float order, float k, float sigma_rad_s,
                              float ts_s) {
    const bool none = lode_in_range(k, 0.0f, 0.0f);
#ifdef LODE_WITHOUT_NOTCH
    const bool good = none;
#else
    const bool good = none || lode_in_range(k, 0.01f, 2.0f);
#endif
    if (!good) {
        return LODE_ERROR_NOTCH;
    }
    *tuning = (lode_notch_tuning_t){
        .k = k,
        .order_Ts = order * ts_s,
        .inv_span = 1.0f / ((LODE_NOTCH_HIGH_SIGMA - LODE_NOTCH_LOW_SIGMA) * sigma_rad_s * ts_s),
    };
    return LODE_OK;
}

// Not LODE_RAMFUNC: once in a round.
void lode_notch_adapt(lode_notch_t *self, const lode_notch_tuning_t *tuning, float k,
                      float omega_rad_s) {
    if (!(k > 0.0f)) {
        self->weight = 0.0f;
        return;
    }
    const float centre =
        lode_min(tuning->order_Ts * lode_abs(omega_rad_s), LODE_SOGI_CENTRE_MAX_rad);
    const float in = lode_clamp(centre * tuning->inv_span - LOW, 0.0f, 1.0f);
    self->weight = centre < LODE_SOGI_CENTRE_MAX_rad ? in : 0.0f;
    const lode_sogi_tuning_t tuned = lode_sogi_tune_within(k, centre);
    self->g = tuned.g;
    self->inv_sum = tuned.inv_sum;
}
