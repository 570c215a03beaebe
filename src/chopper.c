#include "lodestar/chopper.h"
#include "ramp_inline.h"
#include "scalar_inline.h"

#include <stddef.h>

#define HEAT_FROM 0.9f // the duty falls over the last tenth of the heat, against oscillation
#define HEAT_MAX 4.0f  // limits what the integrator may hold
#define V_MAX_V 4.0e3f // largest full_V: more is a bad sample

lode_status_t lode_chopper_tune(lode_chopper_tuning_t *tuning,
                                const lode_chopper_config_t *config) {
    if (tuning == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    const float span_V = config->full_V - config->on_V;
    if (!lode_in_range(config->on_V, 1.0f, 2.0e3f) || !lode_in_range(span_V, 1.0e-3f, 2.0e3f) ||
        !lode_in_range(config->R_Ohm, 1.0e-3f, 1.0e5f) ||
        !lode_in_range(config->power_W, 1.0e-3f, 1.0e7f) ||
        !lode_in_range(config->thermal_s, 1.0e-2f, 1.0e5f) ||
        !lode_in_range(config->period_s, 1.0e-6f, 0.1f)) {
        return LODE_ERROR_CHOPPER;
    }
    *tuning = (lode_chopper_tuning_t){
        .on_V = config->on_V,
        .inv_span = 1.0f / span_V,
        .load = 1.0f / (config->R_Ohm * config->power_W),
        .weight = lode_one_minus_exp(config->period_s / config->thermal_s),
        .cool = {1.0f, 1.0f / (1.0f - HEAT_FROM)},
    };
    return LODE_OK;
}

void lode_chopper_reset(lode_chopper_t *self, float heat) {
    *self = (lode_chopper_t){.heat = lode_clamp(heat, 0.0f, HEAT_MAX)};
}

// (L5) to (L7)
float lode_chopper_step(lode_chopper_t *self, const lode_chopper_tuning_t *tuning, float v_bus_V) {
    const float wanted = lode_clamp((v_bus_V - tuning->on_V) * tuning->inv_span, 0.0f, 1.0f);
    const float v_V = lode_is_finite(v_bus_V) ? lode_clamp(v_bus_V, 0.0f, V_MAX_V) : 0.0f;
    const float load = tuning->load * v_V * v_V;
    const float borne = 1.0f / lode_max(load, 1.0f);
    const float most = borne + (1.0f - borne) * lode_fade(&tuning->cool, self->heat);
    const float duty = lode_min(wanted, most);
    lode_add_small(&self->heat, &self->rest, tuning->weight * (duty * load - self->heat));
    if (!lode_in_range(self->heat, 0.0f, HEAT_MAX)) { // with what `rest` keeps of it
        lode_chopper_reset(self, self->heat < 0.0f ? 0.0f : HEAT_MAX);
    }
    return duty;
}
