#include "sense_inline.h"

// Largest offset error of a healthy amplifier, as a share of full scale.
#define OFFSET_TOLERANCE 0.05f
#define COUNT_MAX_12_BIT 4095.0f
#define CALIBRATION_TIME_s 0.1f
// As many 16-bit counts as a 32-bit sum can hold.
#define CALIBRATION_SAMPLES_MAX 65536.0f
// The squared difference of two noise samples has a mean of twice the variance; with half the rms it is a quarter of that. With
// less than 0.4 counts a current in the middle between two counts may stand still by chance, and so may one with fewer than 256
// samples.
#define NOISE_STEPS2 0.5f
#define NOISE_LEAST_count 0.4f
#define NOISE_MOST_count 64.0f
#define NOISE_SAMPLES 256.0f
#define STEP_MAX 255u
// Larger than on any board; keeps every sample finite.
#define GAIN_MAX 1.0e4f
// Least distance between an offset and the end of the range.
#define HEADROOM_MIN_count 1.0f

void lode_sense_design(lode_sense_config_t *config) {
    config->count_max = lode_given_or(config->count_max, COUNT_MAX_12_BIT);
    config->i_offset_tol_count =
        lode_given_or(config->i_offset_tol_count, OFFSET_TOLERANCE * config->count_max);
    config->duty_max = lode_given_or(config->duty_max, 1.0f);
    config->calibrate_s = lode_given_or(config->calibrate_s, CALIBRATION_TIME_s);
}

// Distance from the nominal offset to the nearer rail.
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
        headroom_count(config) < HEADROOM_MIN_count ||
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
#ifdef LODE_WITHOUT_SHUNT_WINDOW
    if (config->shunts == LODE_SHUNTS_TWO || config->duty_max < 1.0f) {
        return LODE_ERROR_SENSE_WINDOW;
    }
#endif
    const float periods = config->calibrate_s / ts_s;
    if (!lode_in_range(config->calibrate_s, ts_s, 10.0f)) {
        return LODE_ERROR_SENSE_CALIBRATION;
    }
    const bool noisy = config->i_noise_count > 0.0f;
    const float least = noisy ? NOISE_LEAST_count : 0.0f;
    if (!lode_in_range(config->i_noise_count, least, NOISE_MOST_count) ||
        (noisy && periods < NOISE_SAMPLES)) {
        return LODE_ERROR_SENSE_CALIBRATION;
    }
    const float samples = lode_clamp(periods, 1.0f, CALIBRATION_SAMPLES_MAX);
    const float steps2 = NOISE_STEPS2 * config->i_noise_count * config->i_noise_count * samples;
    const float fraction = (float)LODE_COUNT_FRACTION;
    const float gain = config->i_gain_A_count / fraction;
    // An offset at the end of the range would look like zero current, and hide a sensor at its rail.
    const float most = headroom_count(config) - HEADROOM_MIN_count;
    const float tol = fraction * lode_min(config->i_offset_tol_count, most);
    const float alert = fraction * most - tol;
    *tuning = (lode_sense_tuning_t){
        .i_gain = gain,
        .alpha_gain = gain / 3.0f,
        .beta_gain = gain / LODE_SQRT3,
        .offset_nominal = (int32_t)(fraction * config->i_offset_count),
        .offset_tol = (int32_t)tol,
        .alert = (uint32_t)(int32_t)alert,
        .v_bus_gain = config->v_bus_gain_V_count,
        .temperature_gain = config->temperature_gain_degC_count,
        .temperature_offset = config->temperature_offset_degC,
        .duty_max = config->shunts == LODE_SHUNTS_TWO ? 1.0f : config->duty_max,
        .calibrate_periods = (uint32_t)samples,
        .noise_least = (uint32_t)(int32_t)steps2,
        .count_max = (uint_least16_t)(int32_t)config->count_max,
        .two_shunts = config->shunts == LODE_SHUNTS_TWO ? 1u : 0u,
    };
    return LODE_OK;
}

void lode_sense_reset(lode_sense_t *self, const lode_sense_tuning_t *tuning) {
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        self->offset[n] = tuning->offset_nominal;
    }
}

void lode_sense_begin(lode_sense_sums_t *sums) {
    *sums = (lode_sense_sums_t){.samples = 0u};
}

#ifndef LODE_WITHOUT_SHUNT_WINDOW

// With two shunts the third phase; else the one with the longest duty, if that leaves its low-side shunt no time.
LODE_RAMFUNC uint_least8_t lode_sense_omitted(const lode_sense_tuning_t *tuning, lode_abc_t duty) {
    if (tuning->two_shunts != 0u) {
        return 2u;
    }
    const float longest = lode_max(lode_max(duty.a, duty.b), duty.c);
    if (!(longest > tuning->duty_max)) {
        return LODE_PHASES;
    }
    return duty.a >= longest ? 0u : (duty.b >= longest ? 1u : 2u);
}

#endif

LODE_NOINLINE void lode_sense_again(const lode_sense_t *self, const lode_counts_t *counts,
                                    uint_least8_t omitted, lode_sample_t *sample) {
    const lode_sense_currents_t i = lode_sense_without(lode_sense_currents(self, counts), omitted);
    sample->i[0] = i.a;
    sample->i[1] = i.b;
    sample->i[2] = i.c;
    sample->stamp = counts->stamp;
    sample->temperature = counts->temperature;
    sample->omitted = omitted;
    sample->trip = counts->trip;
}

// Count as the ADC delivered it.
static int32_t count_of(const lode_sense_t *self, const lode_sample_t *sample, int32_t phase) {
    return (sample->i[phase] + self->offset[phase]) / LODE_COUNT_FRACTION;
}

LODE_NOINLINE bool lode_sense_is_railed(const lode_sense_t *self, const lode_sense_tuning_t *tuning,
                                        const lode_sample_t *sample) {
    bool railed = false;
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        const int32_t count = count_of(self, sample, n);
        railed = railed || ((uint_least8_t)n != sample->omitted &&
                            (count <= 0 || count >= (int32_t)tuning->count_max));
    }
    return railed;
}

static void add_sample(const lode_sense_t *self, lode_sense_sums_t *sums,
                       const lode_sample_t *sample) {
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        const uint32_t count = (uint32_t)count_of(self, sample, n);
        const uint32_t before = sums->samples > 0u ? sums->before[n] : count;
        const uint32_t step = count > before ? count - before : before - count;
        const uint32_t some = step < STEP_MAX ? step : STEP_MAX;
        sums->count[n] += count;
        sums->steps2[n] += some * some;
        sums->before[n] = (uint16_t)count;
    }
    sums->samples++;
}

// The first phase without the expected noise, from 1; 0: none.
static int32_t still_phase(const lode_sense_sums_t *sums, const lode_sense_tuning_t *tuning) {
    int32_t wired = LODE_PHASES;
    if (tuning->two_shunts != 0u) {
        wired = 2;
    }
    for (int32_t n = 0; n < wired; n++) {
        if (sums->steps2[n] < tuning->noise_least) {
            return n + 1;
        }
    }
    return 0;
}

lode_calibration_t lode_sense_calibrate(lode_sense_t *self, lode_sense_sums_t *sums,
                                        const lode_sense_tuning_t *tuning,
                                        const lode_sample_t *sample, float *worst_count) {
    add_sample(self, sums, sample);
    *worst_count = 0.0f;
    if (sums->samples < tuning->calibrate_periods) {
        return LODE_CALIBRATION_RUNNING;
    }
    int32_t off[LODE_PHASES];
    int32_t worst = 0;
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        // Whole counts and remainder separately: 256 times the sum would overflow.
        const uint32_t whole = sums->count[n] / sums->samples;
        const uint32_t rest = sums->count[n] % sums->samples;
        const uint32_t fraction = LODE_COUNT_FRACTION;
        const uint32_t mean = fraction * whole + fraction * rest / sums->samples;
        // Unsigned arithmetic cannot overflow, whatever the sums hold.
        const uint32_t beyond = mean - (uint32_t)tuning->offset_nominal;
        off[n] = (int32_t)beyond;
        if (tuning->two_shunts != 0u && n == 2) {
            off[n] = 0; // may be unconnected
        }
        worst = lode_abs((float)off[n]) > lode_abs((float)worst) ? off[n] : worst;
    }
    const int32_t still = still_phase(sums, tuning);
    lode_sense_begin(sums);
    *worst_count = (float)worst / (float)LODE_COUNT_FRACTION;
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        if (off[n] > tuning->offset_tol || off[n] < -tuning->offset_tol) {
            return LODE_CALIBRATION_IMPLAUSIBLE;
        }
    }
    if (still > 0) {
        *worst_count = (float)still;
        return LODE_CALIBRATION_STUCK;
    }
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        self->offset[n] = tuning->offset_nominal + off[n];
    }
    return LODE_CALIBRATION_DONE;
}
