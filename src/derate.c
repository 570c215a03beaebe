#include "lodestar/derate.h"
#include "ramp_inline.h"
#include "scalar_inline.h"

#include <stddef.h>

#define WINDING_s 30.0f // small motors: some 10 s; frames of 1 kW: a minute and more
#define STAGE_SPAN_K 20.0f
// The winding's share falls over the last tenth of its heat, so that it does not oscillate.
#define HEAT_FROM 0.9f
// Beyond the continuous heat, what is left falls to none by here.
#define HEAT_TO 1.1f
#define HEAT_MAX 4.0f // limits what the integrator may hold

lode_status_t lode_derate_tune(lode_derate_tuning_t *tuning, const lode_derate_config_t *config) {
    if (tuning == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    const float i_max = config->i_max_A;
    const float continuous = lode_given_or(config->i_continuous_A, i_max);
    const float winding_s = lode_given_or(config->winding_s, WINDING_s);
    const float to = config->to_degC;
    const float from = lode_given_or(config->from_degC, to - STAGE_SPAN_K);
    if (!lode_in_range(i_max, 1.0e-3f, 1.0e5f) ||
        !lode_in_range(continuous, 1.0e-3f * i_max, i_max) ||
        !lode_in_range(winding_s, 0.1f, 1.0e5f) || !lode_in_range(to, -40.0f, 300.0f) ||
        !lode_in_range(from, -100.0f, to - 1.0f)) {
        return LODE_ERROR_DERATE;
    }
    *tuning = (lode_derate_tuning_t){
        .inv_continuous2 = 1.0f / (continuous * continuous),
        .least = continuous / i_max,
        .winding_s = winding_s,
        .winding = {1.0f, 1.0f / (1.0f - HEAT_FROM)},
        .beyond = {HEAT_TO, 1.0f / (HEAT_TO - 1.0f)},
        .stage = {to, 1.0f / (to - from)},
    };
    return LODE_OK;
}

void lode_derate_reset(lode_derate_t *self, float heat) {
    *self = (lode_derate_t){.heat = lode_clamp(heat, 0.0f, HEAT_MAX)};
}

// In FAULT `i_A` keeps its value of the trip. No current flows then, or with all low sides on at most `i_max`.
static float load_of(const lode_derate_tuning_t *tuning, const lode_telemetry_t *telemetry) {
    const lode_dq_t i_A = telemetry->i_A;
    if (telemetry->mode == LODE_MODE_FAULT) {
        return telemetry->shorted ? 1.0f / (tuning->least * tuning->least) : 0.0f;
    }
    return (i_A.d * i_A.d + i_A.q * i_A.q) * tuning->inv_continuous2;
}

// (D1), (D2)
float lode_derate_step(lode_derate_t *self, const lode_derate_tuning_t *tuning,
                       const lode_telemetry_t *telemetry, float dt_s) {
    const float load = load_of(tuning, telemetry);
    const float x = lode_one_minus_exp(dt_s / tuning->winding_s);
    lode_add_small(&self->heat, &self->rest, x * (load - self->heat));
    if (!lode_in_range(self->heat, 0.0f, HEAT_MAX)) {
        lode_derate_reset(self, self->heat < 0.0f ? 0.0f : HEAT_MAX); // NaN: hot
    }
    const float most = lode_fade(&tuning->winding, self->heat);
    const float least = tuning->least * lode_fade(&tuning->beyond, self->heat);
    const float winding = least + (1.0f - tuning->least) * most;
    return lode_min(winding, lode_fade(&tuning->stage, telemetry->temperature_degC));
}
