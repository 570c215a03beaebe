#include "lodestar/sense.h"

// A share of full scale that the offset of a sound amplifier stays within.
#define OFFSET_TOLERANCE 0.05f
#define COUNT_MAX_12_BIT 4095.0f
#define CALIBRATION_TIME_s 0.1f
// So many 16-bit counts fit into a sum of 32 bits.
#define CALIBRATION_SAMPLES_MAX 65536.0f
// Beyond any board: keeps every sample finite.
#define GAIN_MAX 1.0e4f

void lode_sense_design(lode_sense_config_t *config) {
    config->count_max = lode_given_or(config->count_max, COUNT_MAX_12_BIT);
    config->i_offset_tol_count =
        lode_given_or(config->i_offset_tol_count, OFFSET_TOLERANCE * config->count_max);
    config->duty_max = lode_given_or(config->duty_max, 1.0f);
    config->calibrate_s = lode_given_or(config->calibrate_s, CALIBRATION_TIME_s);
}

// From the nominal offset to the nearer rail.
static float headroom_count(const lode_sense_config_t *config) {
    return lode_min(config->i_offset_count, config->count_max - config->i_offset_count);
}

static lode_status_t check_ranges(const lode_sense_config_t *config, float i_max_A, float v_bus_V) {
    if (!lode_in_range(config->count_max, 1.0f, 65535.0f) ||
        !lode_in_range(config->i_offset_count, 0.0f, config->count_max) ||
        !lode_in_range(config->i_offset_tol_count, 0.0f, config->count_max)) {
        return LODE_ERROR_SENSE_OFFSET;
    }
    if (!lode_in_range(config->i_gain_A_count, -GAIN_MAX, GAIN_MAX) ||
        !(headroom_count(config) * lode_abs(config->i_gain_A_count) >= i_max_A)) {
        return LODE_ERROR_SENSE_CURRENT;
    }
    if (!lode_in_range(config->v_bus_gain_V_count, 0.0f, GAIN_MAX) ||
        !(config->count_max * config->v_bus_gain_V_count >= v_bus_V)) {
        return LODE_ERROR_SENSE_BUS;
    }
    if (!lode_in_range(config->temperature_gain_degC_count, -1.0e3f, 1.0e3f) ||
        !lode_in_range(config->temperature_offset_degC, -1.0e6f, 1.0e6f)) {
        return LODE_ERROR_SENSE_TEMPERATURE;
    }
    return LODE_OK;
}

lode_status_t lode_sense_tune(lode_sense_tuning_t *tuning, const lode_sense_config_t *config,
                              float i_max_A, float v_bus_V, float ts_s) {
    if (config->shunts != LODE_SHUNTS_THREE && config->shunts != LODE_SHUNTS_TWO) {
        return LODE_ERROR_SENSE_SHUNTS;
    }
    const lode_status_t status = check_ranges(config, i_max_A, v_bus_V);
    if (status != LODE_OK) {
        return status;
    }
    if (!lode_in_range(config->duty_max, 0.5f, 1.0f)) {
        return LODE_ERROR_SENSE_WINDOW;
    }
    const float periods = config->calibrate_s / ts_s;
    if (!lode_in_range(config->calibrate_s, ts_s, 10.0f)) {
        return LODE_ERROR_SENSE_CALIBRATION;
    }
    *tuning = (lode_sense_tuning_t){
        .i_gain = config->i_gain_A_count,
        .alpha_gain = config->i_gain_A_count / 3.0f,
        .beta_gain = config->i_gain_A_count / LODE_SQRT3,
        .i_offset_nominal = config->i_offset_count,
        .i_offset_tol = config->i_offset_tol_count,
        .v_bus_gain = config->v_bus_gain_V_count,
        .temperature_gain = config->temperature_gain_degC_count,
        .temperature_offset = config->temperature_offset_degC,
        .duty_max = config->duty_max,
        .count_max = (uint16_t)(int32_t)config->count_max,
        .alert_count = headroom_count(config) - config->i_offset_tol_count - 1.0f,
        .calibrate_periods = (uint32_t)lode_clamp(periods, 1.0f, CALIBRATION_SAMPLES_MAX),
        .shunts = config->shunts,
        .windowed = config->shunts == LODE_SHUNTS_TWO || config->duty_max < 1.0f,
    };
    return LODE_OK;
}

void lode_sense_reset(lode_sense_t *self, const lode_sense_tuning_t *tuning) {
    const float nominal = tuning->i_offset_nominal;
    self->offset_count = (lode_abc_t){nominal, nominal, nominal};
}

void lode_sense_begin(lode_sense_sums_t *sums) {
    *sums = (lode_sense_sums_t){.samples = 0u};
}

// The phase whose sample is not used: the third where there are two shunts; else the one with the
// longest duty, where that leaves its low-side shunt no time. LODE_PHASES if all are.
LODE_RAMFUNC int32_t lode_sense_unused(const lode_sense_tuning_t *tuning, lode_abc_t duty) {
    if (tuning->shunts == LODE_SHUNTS_TWO) {
        return 2;
    }
    const float longest = lode_max(lode_max(duty.a, duty.b), duty.c);
    if (!(longest > tuning->duty_max)) {
        return LODE_PHASES;
    }
    return duty.a >= longest ? 0 : (duty.b >= longest ? 1 : 2);
}

LODE_RAMFUNC lode_abc_t lode_sense_completed(lode_abc_t i, int32_t unused) {
    if (unused == 0) {
        i.a = -i.b - i.c;
    } else if (unused == 1) {
        i.b = -i.a - i.c;
    } else {
        i.c = -i.a - i.b;
    }
    return i;
}

static bool at_rail(const lode_sense_tuning_t *tuning, uint16_t count) {
    return count == 0u || count >= tuning->count_max;
}

LODE_RAMFUNC LODE_NOINLINE bool lode_sense_railed(const lode_sense_tuning_t *tuning,
                                          const lode_counts_t *counts, int32_t unused) {
    return (unused != 0 && at_rail(tuning, counts->i[0])) ||
           (unused != 1 && at_rail(tuning, counts->i[1])) ||
           (unused != 2 && at_rail(tuning, counts->i[2]));
}

static float further(float a, float b) {
    return lode_abs(a) > lode_abs(b) ? a : b;
}

lode_calibration_t lode_sense_calibrate(lode_sense_t *self, lode_sense_sums_t *sums,
                                        const lode_sense_tuning_t *tuning,
                                        const lode_counts_t *counts, float *worst_count) {
    for (int32_t i = 0; i < LODE_PHASES; i++) {
        sums->count[i] += counts->i[i];
    }
    sums->samples++;
    *worst_count = 0.0f;
    if (sums->samples < tuning->calibrate_periods) {
        return LODE_CALIBRATION_RUNNING;
    }
    const float nominal = tuning->i_offset_nominal;
    const float share = 1.0f / (float)sums->samples;
    lode_abc_t offset = {(float)sums->count[0] * share, (float)sums->count[1] * share,
                         (float)sums->count[2] * share};
    if (tuning->shunts == LODE_SHUNTS_TWO) {
        offset.c = nominal; // nothing need be wired there
    }
    lode_sense_begin(sums);
    *worst_count = further(further(offset.a - nominal, offset.b - nominal), offset.c - nominal);
    if (!lode_in_range(*worst_count, -tuning->i_offset_tol, tuning->i_offset_tol)) {
        return LODE_CALIBRATION_IMPLAUSIBLE;
    }
    self->offset_count = offset;
    return LODE_CALIBRATION_DONE;
}
