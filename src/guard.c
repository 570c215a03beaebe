#include "guard_inline.h"

#include "sense_inline.h"

#define I_TRIP_SHARE 1.5f     // of i_max
#define V_BUS_MAX_SHARE 1.25f // of nominal
#define V_BUS_MIN_SHARE 0.6f
#define TEMPERATURE_MAX_degC 100.0f
#define TEMPERATURE_MIN_degC (-40.0f) // lower limit of most parts: below it the sensor is broken
#define I_SUM_SHARE 0.15f // of i_max: gain errors of 5 % each, plus offsets of some per cent
#define OMEGA_SHARE 1.3f  // of the estimator's highest speed
#define BUS_TIME_s 1.0e-3f
#define LOCK_TIME_s 15.0e-3f // with the lock's own 3.5 ms: trips within 20 ms
#define COUNTER_MAX 65535.0f
#define COUNTER_LAST 65535u
#define STAMP_TOLERANCE 0.25f // of a period
// with the time until all the torque is requested, in less than 0.1 s
#define OVERLOAD_s 0.03f
#define FLUX_SHARE 0.2f // more than a tuning and a hot magnet explain
#define HALF_TURN_rad 3.1415927f
#define PERIODS_MAX 32768.0f // of half a turn: slower than any EMF above the bus
#define MIDDLE_SHARE 0.1f    // of the largest current: well above offsets, noise and gain errors

#define NAME(check)                                                                                \
    case check:                                                                                    \
        return #check

const char *lode_check_name(lode_check_t check) {
    switch (check) {
        NAME(LODE_CHECK_NONE);
        NAME(LODE_CHECK_HARDWARE_TRIP);
        NAME(LODE_CHECK_OVER_CURRENT);
        NAME(LODE_CHECK_CURRENT_RAIL);
        NAME(LODE_CHECK_OVER_VOLTAGE);
        NAME(LODE_CHECK_UNDER_VOLTAGE);
        NAME(LODE_CHECK_OVER_TEMPERATURE);
        NAME(LODE_CHECK_TIMING);
        NAME(LODE_CHECK_NON_FINITE);
        NAME(LODE_CHECK_OVER_SPEED);
        NAME(LODE_CHECK_LOST_LOCK);
        NAME(LODE_CHECK_WRONG_WAY);
        NAME(LODE_CHECK_START);
        NAME(LODE_CHECK_OFFSET);
        NAME(LODE_CHECK_OPEN_PHASE);
        NAME(LODE_CHECK_CURRENT_STUCK);
        NAME(LODE_CHECK_CURRENT_SUM);
        NAME(LODE_CHECK_UNDER_TEMPERATURE);
        NAME(LODE_CHECK_MEMORY);
        NAME(LODE_CHECK_TEMPERATURE_STUCK);
        NAME(LODE_CHECK_BUS_STUCK);
        NAME(LODE_CHECK_FLUX);
        NAME(LODE_CHECK_RESISTANCE);
        NAME(LODE_CHECK_SWITCH_SHORTED);
        NAME(LODE_CHECK_SIGNALS);
        NAME(LODE_CHECK_INDUCTANCE);
        NAME(LODE_CHECK_OVERLOAD);
        NAME(LODE_CHECK_CURRENT_GAIN);
        NAME(LODE_CHECK_CURRENT_CONTROL);
    case LODE_CHECK_COUNT:
    default:
        return "LODE_CHECK_UNKNOWN";
    }
}

void lode_guard_design(lode_guard_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_estimator_config_t *estimator) {
    config->i_trip_A = lode_given_or(config->i_trip_A, I_TRIP_SHARE * inverter->i_max_A);
    config->v_bus_max_V = lode_given_or(config->v_bus_max_V, V_BUS_MAX_SHARE * inverter->v_bus_V);
    config->v_bus_min_V = lode_given_or(config->v_bus_min_V, V_BUS_MIN_SHARE * inverter->v_bus_V);
    config->temperature_max_degC =
        lode_given_or(config->temperature_max_degC, TEMPERATURE_MAX_degC);
    config->omega_max_rad_s =
        lode_given_or(config->omega_max_rad_s, OMEGA_SHARE * estimator->omega_max_rad_s);
    config->bus_s = lode_given_or(config->bus_s, BUS_TIME_s);
    config->lock_s = lode_given_or(config->lock_s, LOCK_TIME_s);
    config->temperature_min_degC =
        lode_given_or(config->temperature_min_degC, TEMPERATURE_MIN_degC);
    config->i_sum_A = lode_given_or(config->i_sum_A, I_SUM_SHARE * inverter->i_max_A);
    if (config->plausibility == LODE_AUTO) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
        config->plausibility = LODE_OFF;
#else
        config->plausibility = LODE_ON;
#endif
    }
#ifdef LODE_WITHOUT_PLAUSIBILITY
    config->overload_s = lode_given_or(config->overload_s, LODE_NONE);
    config->flux_share = lode_given_or(config->flux_share, LODE_NONE);
#else
    config->overload_s = lode_given_or(config->overload_s, OVERLOAD_s);
    config->flux_share = lode_given_or(config->flux_share, FLUX_SHARE);
#endif
    config->check_stuck =
        config->check_stuck == LODE_AUTO ? config->plausibility : config->check_stuck;
    config->check_gain =
        config->check_gain == LODE_AUTO ? config->plausibility : config->check_gain;
    config->check_half_waves =
        config->check_half_waves == LODE_AUTO ? config->plausibility : config->check_half_waves;
}

static bool has_no_sensor(const lode_sense_config_t *sense) {
    return lode_in_range(sense->temperature_gain_degC_count, 0.0f, 0.0f);
}

static lode_status_t check_limits(const lode_guard_config_t *config,
                                  const lode_inverter_config_t *inverter,
                                  const lode_sense_config_t *sense) {
    const float i_range = lode_abs(sense->i_gain_A_count) *
                          lode_min(sense->i_offset_count, sense->count_max - sense->i_offset_count);
    if (!lode_in_range(config->i_trip_A, inverter->i_max_A, i_range)) {
        return LODE_ERROR_GUARD_CURRENT;
    }
    if (!lode_in_range(config->v_bus_max_V, inverter->v_bus_V,
                       sense->v_bus_gain_V_count * sense->count_max) ||
        !lode_in_range(config->v_bus_min_V, 0.0f, inverter->v_bus_V)) {
        return LODE_ERROR_GUARD_BUS;
    }
    if (!lode_in_range(config->temperature_max_degC, -100.0f, 1000.0f) ||
        !lode_in_range(config->temperature_min_degC, -300.0f, config->temperature_max_degC)) {
        return LODE_ERROR_GUARD_TEMPERATURE;
    }
    const float offset = sense->temperature_offset_degC;
    if (has_no_sensor(sense) &&
        !lode_in_range(offset, config->temperature_min_degC, config->temperature_max_degC)) {
        return LODE_ERROR_GUARD_TEMPERATURE; // it would always trip
    }
    if (!lode_in_range(config->omega_max_rad_s, 1.0f, 1.0e6f)) {
        return LODE_ERROR_GUARD_SPEED;
    }
    return LODE_OK;
}

static lode_status_t check_times(const lode_guard_config_t *config,
                                 const lode_sense_config_t *sense, float ts_s) {
    const float still_max_s = COUNTER_MAX * (float)LODE_SLOW_PERIODS * ts_s;
    // Without a sensor the count stands still.
    const float temperature_max_s = has_no_sensor(sense) ? 0.0f : still_max_s;
    const float stamp = config->stamp_per_period;
    if (!lode_in_range(config->bus_s, ts_s, 10.0f) || !lode_in_range(config->lock_s, ts_s, 10.0f) ||
        !(lode_in_range(stamp, 0.0f, 0.0f) || lode_in_range(stamp, 1.0f, 1.0e9f)) ||
        !lode_in_range(config->temperature_still_s, 0.0f, temperature_max_s) ||
        !lode_in_range(config->bus_still_s, 0.0f, still_max_s)) {
        return LODE_ERROR_GUARD_TIME;
    }
#ifdef LODE_WITHOUT_PLAUSIBILITY
    if (config->temperature_still_s > 0.0f || config->bus_still_s > 0.0f) {
        return LODE_ERROR_GUARD_TIME;
    }
#endif
    return LODE_OK;
}

// At least two, so that a single bad sample passes; at most what the counters hold.
static uint32_t periods_in(float time_s, float period_s) {
    return (uint32_t)(int32_t)lode_clamp(time_s / period_s, 2.0f, COUNTER_MAX);
}

// 0: not checked.
static uint_least16_t rounds_in(float time_s, float round_s) {
    return (uint_least16_t)(time_s > 0.0f ? periods_in(time_s, round_s) : 0u);
}

lode_status_t lode_guard_tune(lode_guard_tuning_t *tuning, const lode_guard_config_t *config,
                              const lode_inverter_config_t *inverter,
                              const lode_sense_config_t *sense, float ts_s) {
    lode_status_t status = check_limits(config, inverter, sense);
    if (status == LODE_OK) {
        status = check_times(config, sense, ts_s);
    }
    if (status != LODE_OK) {
        return status;
    }
    const uint32_t round_periods = LODE_SLOW_PERIODS;
    const float round_s = (float)round_periods * ts_s;
    const float stamp = config->stamp_per_period;
    const uint32_t stamp_min = (uint32_t)(int32_t)((1.0f - STAMP_TOLERANCE) * stamp);
    const uint32_t stamp_max = (uint32_t)(int32_t)((1.0f + STAMP_TOLERANCE) * stamp);
    const uint32_t interval_periods = LODE_GUARD_PERIODS;
    const float interval_s = (float)interval_periods * ts_s;
    *tuning = (lode_guard_tuning_t){
        .i_trip = config->i_trip_A,
        .v_bus_max = config->v_bus_max_V,
        .v_bus_min = config->v_bus_min_V,
        .temperature_max = config->temperature_max_degC,
        .temperature_min = config->temperature_min_degC,
        .omega_max = config->omega_max_rad_s,
        .bus_periods = (uint_least16_t)lode_clamp(
            config->bus_s / ts_s, 2.0f, COUNTER_MAX - (float)(int32_t)LODE_GUARD_DECAY_PERIODS),
        .lock_checks = (uint_least16_t)periods_in(config->lock_s, interval_s),
        .still_rounds = rounds_in(config->temperature_still_s, round_s),
        .bus_still_rounds = rounds_in(config->bus_still_s, round_s),
        .stamp_min = stamp_min,
        .stamp_span = stamp_max > 0u ? stamp_max - stamp_min : UINT32_MAX,
    };
    return LODE_OK;
}

void lode_guard_reset(lode_guard_t *self) {
    *self = (lode_guard_t){.stamp = self->stamp, .trips = self->trips};
}

LODE_SMALL_CALL void lode_guard_trip(lode_guard_t *self, uint_least8_t state, lode_check_t check,
                                     float measured, float limit) {
    if (self->fault.check == (uint_least8_t)LODE_CHECK_NONE) {
        self->fault = (lode_fault_t){
            .state = state, .check = (uint_least8_t)check, .measured = measured, .limit = limit};
        self->trips = (uint_least16_t)(self->trips + 1u);
    }
}

// Counts up while something is wrong and down while all is well: single bad samples pass, what mostly persists trips. True when
// `periods` is reached.
static bool persists(lode_guard_t *self, uint_least16_t *counter, bool bad, uint32_t periods) {
    const uint32_t before = *counter;
    const uint32_t next = bad ? before + 1u : (before > 0u ? before - 1u : 0u);
    *counter = (uint_least16_t)next;
    self->pending = self->pending || next > 0u;
    return bad && next >= periods;
}

// Phase current of the largest magnitude, A.
static float largest_A(const lode_sense_tuning_t *sense, const lode_sample_t *sample) {
    int32_t largest = 0;
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        const bool larger = lode_abs((float)sample->i[n]) > lode_abs((float)largest);
        largest = larger ? sample->i[n] : largest;
    }
    return (float)largest * sense->i_gain;
}

LODE_NOINLINE void lode_guard_diagnose(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                                       const lode_sense_t *sense,
                                       const lode_sense_tuning_t *sense_tuning,
                                       const lode_sample_t *sample, uint_least8_t state) {
    const float i_A = largest_A(sense_tuning, sample);
    const bool railed = lode_sense_is_railed(sense, sense_tuning, sample);
    const uint32_t passed = sample->stamp - self->stamp;
    if (sample->trip) {
        lode_guard_trip(self, state, LODE_CHECK_HARDWARE_TRIP, 1.0f, 0.0f);
    }
    // Before over-current: duties that were not renewed in time are what causes it.
    if (passed - tuning->stamp_min > tuning->stamp_span) {
        const uint32_t latest = tuning->stamp_min + tuning->stamp_span;
        lode_guard_trip(self, state, LODE_CHECK_TIMING, (float)passed, (float)latest);
    }
    if (!(lode_abs(i_A) <= tuning->i_trip)) {
        lode_guard_trip(self, state, LODE_CHECK_OVER_CURRENT, i_A, tuning->i_trip);
    }
    self->railed = self->railed || railed; // lode_guard_check_slow() clears it
    if (railed && persists(self, &self->rail, true, tuning->bus_periods)) {
        lode_guard_trip(self, state, LODE_CHECK_CURRENT_RAIL, i_A, tuning->i_trip);
    }
}

uint32_t lode_guard_half_turn(float step_rad) {
    const float periods = HALF_TURN_rad / lode_max(lode_abs(step_rad), HALF_TURN_rad / PERIODS_MAX);
    return (uint32_t)periods;
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// Current of the phase with a shorted switch; 0: not visible now. With a low side shorted, current leaves the motor through
// that phase alone and returns through the diodes of both others; with a high side it is the other way round. The phase with
// the middle current tells which, since samples of the other two may be at the rails.
static float shorted_A(const lode_sense_tuning_t *sense, const lode_sample_t *sample) {
    const float a = (float)sample->i[0] * sense->i_gain;
    const float b = (float)sample->i[1] * sense->i_gain;
    const float c = (float)sample->i[2] * sense->i_gain;
    const float most = lode_max(lode_max(a, b), c);
    const float least = lode_min(lode_min(a, b), c);
    const float middle = a + b + c - most - least;
    if (!(lode_abs(middle) > MIDDLE_SHARE * most)) {
        return 0.0f;
    }
    return middle > 0.0f ? least : most;
}

LODE_NOINLINE void lode_guard_suspect(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                                      const lode_sense_tuning_t *sense_tuning,
                                      const lode_sample_t *sample, lode_shorted_t *shorted,
                                      uint32_t half_turn) {
    const float i_A = shorted_A(sense_tuning, sample);
    if (!lode_guard_suspects(self->fault.check) || !(lode_abs(i_A) > tuning->i_trip)) {
        return;
    }
    // Above the bus voltage the other phases may be the largest for a part of each turn.
    const bool low = i_A < 0.0f;
    const uint32_t before = shorted->periods;
    const bool same = before == 0u || low == shorted->low;
    const uint32_t more = before < COUNTER_LAST ? before + 1u : before;
    const uint32_t periods = same ? more : before - 1u;
    *shorted = (lode_shorted_t){.periods = (uint_least16_t)periods,
                                .low = before == 0u ? low : shorted->low};
    const uint32_t needed = (uint32_t)tuning->bus_periods + LODE_GUARD_DECAY_PERIODS + half_turn;
    if (same && (periods >= needed || periods >= COUNTER_LAST)) {
        self->fault.check = (uint_least8_t)LODE_CHECK_SWITCH_SHORTED;
        self->fault.measured = i_A;
        self->fault.limit = tuning->i_trip;
    }
}

#endif

// `wrong`: LODE_CHECK_NONE if all is well.
static void count(lode_guard_t *self, uint_least16_t *counter, uint32_t checks, lode_check_t wrong,
                  float measured, float limit) {
    if (persists(self, counter, wrong != LODE_CHECK_NONE, checks)) {
        lode_guard_trip(self, 0u, wrong, measured, limit);
    }
}

static void count_power(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                        lode_condition_t condition) {
    const uint32_t least = 2u; // a single sample passes
    const uint32_t whole = tuning->bus_periods / LODE_GUARD_PERIODS;
    const uint32_t checks = whole > least ? whole : least;
    const float v = condition.v_bus_V;
    const float hot = condition.temperature_degC;
    const bool high = !(v <= tuning->v_bus_max);
    const lode_check_t low = v < tuning->v_bus_min ? LODE_CHECK_UNDER_VOLTAGE : LODE_CHECK_NONE;
    count(self, &self->bus, checks, high ? LODE_CHECK_OVER_VOLTAGE : low, v,
          high ? tuning->v_bus_max : tuning->v_bus_min);
    const bool heat = !(hot <= tuning->temperature_max);
    const lode_check_t cold =
        hot < tuning->temperature_min ? LODE_CHECK_UNDER_TEMPERATURE : LODE_CHECK_NONE;
    count(self, &self->temperature, checks, heat ? LODE_CHECK_OVER_TEMPERATURE : cold, hot,
          heat ? tuning->temperature_max : tuning->temperature_min);
    if (!self->railed) {
        (void)persists(self, &self->rail, false, tuning->bus_periods);
    }
    self->railed = false;
}

static void count_motion(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                         lode_condition_t condition) {
    const float omega = condition.omega_rad_s;
    const uint32_t checks = tuning->lock_checks;
    count(self, &self->lock, checks,
          condition.lock >= LODE_LOCK_LOST ? LODE_CHECK_NONE : LODE_CHECK_LOST_LOCK, condition.lock,
          LODE_LOCK_LOST);
    const bool fast = !(lode_abs(omega) <= tuning->omega_max);
    const lode_check_t back = omega < 0.0f ? LODE_CHECK_WRONG_WAY : LODE_CHECK_NONE;
    count(self, &self->speed, checks, fast ? LODE_CHECK_OVER_SPEED : back, omega,
          fast ? tuning->omega_max : 0.0f);
}

void lode_guard_check_slow(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                           lode_condition_t condition, lode_situation_t now) {
    const bool good = lode_guard_is_good(self);
    self->pending = self->rail > 0u;
    count_power(self, tuning, condition);
    if (now.runs) {
        count_motion(self, tuning, condition);
    }
    if (good && !lode_guard_is_good(self)) {
        self->fault.state = now.state;
    }
}
