#include "lodestar/sense.h"

// A share of full scale that the offset of a sound amplifier stays within.
#define OFFSET_TOLERANCE 0.05f
#define COUNT_MAX_12_BIT 4095.0f
#define CALIBRATION_TIME_s 0.1f
// From here on a sum of 16-bit counts in a float still resolves a tenth of a count on average.
#define CALIBRATION_SAMPLES_MAX 65536.0f

void lode_sense_design(lode_sense_config_t *config) {
    config->count_max = lode_given_or(config->count_max, COUNT_MAX_12_BIT);
    config->i_offset_tol_count =
        lode_given_or(config->i_offset_tol_count, OFFSET_TOLERANCE * config->count_max);
    config->duty_max = lode_given_or(config->duty_max, 1.0f);
    config->calibrate_s = lode_given_or(config->calibrate_s, CALIBRATION_TIME_s);
}

static lode_status_t check_ranges(const lode_sense_config_t *config, float i_max_A, float v_bus_V) {
    if (!lode_in_range(config->count_max, 1.0f, 65535.0f) ||
        !lode_in_range(config->i_offset_count, 0.0f, config->count_max) ||
        !lode_in_range(config->i_offset_tol_count, 0.0f, config->count_max)) {
        return LODE_ERROR_SENSE_OFFSET;
    }
    const float headroom =
        lode_min(config->i_offset_count, config->count_max - config->i_offset_count);
    if (!lode_is_finite(config->i_gain_A_count) ||
        !(headroom * lode_abs(config->i_gain_A_count) >= i_max_A)) {
        return LODE_ERROR_SENSE_CURRENT;
    }
    if (!lode_is_finite(config->v_bus_gain_V_count) ||
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
        .i_offset_nominal = config->i_offset_count,
        .i_offset_tol = config->i_offset_tol_count,
        .v_bus_gain = config->v_bus_gain_V_count,
        .temperature_gain = config->temperature_gain_degC_count,
        .temperature_offset = config->temperature_offset_degC,
        .duty_max = config->duty_max,
        .count_max = config->count_max,
        .calibrate_periods = lode_min(periods, CALIBRATION_SAMPLES_MAX),
        .shunts = config->shunts,
    };
    return LODE_OK;
}

void lode_sense_reset(lode_sense_t *self, const lode_sense_tuning_t *tuning) {
    const float nominal = tuning->i_offset_nominal;
    *self = (lode_sense_t){{nominal, nominal, nominal}, {0.0f, 0.0f, 0.0f}, 0.0f};
}

static bool at_rail(const lode_sense_tuning_t *tuning, uint16_t count) {
    return count == 0u || (float)count >= tuning->count_max;
}

// Where the longest duty leaves a low-side shunt no time, that phase follows from the other two.
static lode_abc_t reconstruct(lode_abc_t i, lode_abc_t duty, float duty_max) {
    if (duty.a > duty_max && duty.a >= duty.b && duty.a >= duty.c) {
        i.a = -i.b - i.c;
    } else if (duty.b > duty_max && duty.b >= duty.c) {
        i.b = -i.a - i.c;
    } else if (duty.c > duty_max) {
        i.c = -i.a - i.b;
    }
    return i;
}

LODE_HOT lode_sample_t lode_sense_step(const lode_sense_t *self, const lode_sense_tuning_t *tuning,
                                       const lode_counts_t *counts, lode_abc_t duty) {
    lode_abc_t i = {((float)counts->i[0] - self->offset_count.a) * tuning->i_gain,
                    ((float)counts->i[1] - self->offset_count.b) * tuning->i_gain, 0.0f};
    lode_ab_t i_A;
    bool railed = at_rail(tuning, counts->i[0]) || at_rail(tuning, counts->i[1]);
    if (tuning->shunts == LODE_SHUNTS_TWO) {
        i.c = -i.a - i.b;
        i_A = lode_clarke_two(i.a, i.b);
    } else {
        i.c = ((float)counts->i[2] - self->offset_count.c) * tuning->i_gain;
        i = reconstruct(i, duty, tuning->duty_max);
        i_A = lode_clarke(i);
        railed = railed || at_rail(tuning, counts->i[2]);
    }
    return (lode_sample_t){
        .i_abc_A = i,
        .i_A = i_A,
        .v_bus_V = (float)counts->v_bus * tuning->v_bus_gain,
        .temperature_degC =
            tuning->temperature_offset + (float)counts->temperature * tuning->temperature_gain,
        .stamp = counts->stamp,
        .trip = counts->trip,
        .railed = railed,
    };
}

static float offset_error(float offset, float nominal, float worst) {
    const float error = offset - nominal;
    return lode_abs(error) > lode_abs(worst) ? error : worst;
}

lode_calibration_t lode_sense_calibrate(lode_sense_t *self, const lode_sense_tuning_t *tuning,
                                        const lode_counts_t *counts, float *worst_count) {
    // Sums of deviations from nominal stay small, so a float loses nothing.
    const float nominal = tuning->i_offset_nominal;
    self->sum_count.a += (float)counts->i[0] - nominal;
    self->sum_count.b += (float)counts->i[1] - nominal;
    // A third converter that is not wired must not fail the plausibility check.
    self->sum_count.c += tuning->shunts == LODE_SHUNTS_TWO ? 0.0f : (float)counts->i[2] - nominal;
    self->samples += 1.0f;
    *worst_count = 0.0f;
    if (self->samples < tuning->calibrate_periods) {
        return LODE_CALIBRATION_RUNNING;
    }
    const float share = 1.0f / self->samples;
    const lode_abc_t offset = {nominal + self->sum_count.a * share,
                               nominal + self->sum_count.b * share,
                               nominal + self->sum_count.c * share};
    self->sum_count = (lode_abc_t){0.0f, 0.0f, 0.0f};
    self->samples = 0.0f;
    *worst_count =
        offset_error(offset.c, nominal, offset_error(offset.b, nominal, offset.a - nominal));
    if (!lode_in_range(*worst_count, -tuning->i_offset_tol, tuning->i_offset_tol)) {
        return LODE_CALIBRATION_IMPLAUSIBLE;
    }
    self->offset_count = offset;
    return LODE_CALIBRATION_DONE;
}
