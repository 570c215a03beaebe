#include "lodestar/guard.h"

#define I_TRIP_SHARE 1.5f     // of i_max
#define V_BUS_MAX_SHARE 1.25f // of nominal
#define V_BUS_MIN_SHARE 0.6f
#define TEMPERATURE_MAX_degC 100.0f
#define OMEGA_SHARE 1.3f // of the estimator's highest speed
#define BUS_TIME_s 1.0e-3f
#define LOCK_TIME_s 15.0e-3f  // with the lock's own 3.5 ms it trips in less than 20 ms
#define STAMP_TOLERANCE 0.25f // of a period

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
    if (!lode_in_range(config->temperature_max_degC, -100.0f, 1000.0f)) {
        return LODE_ERROR_GUARD_TEMPERATURE;
    }
    if (!lode_in_range(config->omega_max_rad_s, 1.0f, 1.0e6f)) {
        return LODE_ERROR_GUARD_SPEED;
    }
    return LODE_OK;
}

lode_status_t lode_guard_tune(lode_guard_tuning_t *tuning, const lode_guard_config_t *config,
                              const lode_inverter_config_t *inverter,
                              const lode_sense_config_t *sense, float ts_s) {
    const lode_status_t status = check_limits(config, inverter, sense);
    if (status != LODE_OK) {
        return status;
    }
    if (!lode_in_range(config->bus_s, ts_s, 10.0f) || !lode_in_range(config->lock_s, ts_s, 10.0f) ||
        !lode_in_range(config->stamp_per_period, 0.0f, 1.0e9f)) {
        return LODE_ERROR_GUARD_TIME;
    }
    const float stamp = config->stamp_per_period;
    *tuning = (lode_guard_tuning_t){
        .i_trip = config->i_trip_A,
        .v_bus_max = config->v_bus_max_V,
        .v_bus_min = config->v_bus_min_V,
        .temperature_max = config->temperature_max_degC,
        .omega_max = config->omega_max_rad_s,
        .bus_periods = (int32_t)(config->bus_s / ts_s),
        .lock_periods = (int32_t)(config->lock_s / ts_s),
        .stamp_min = (uint32_t)(int32_t)((1.0f - STAMP_TOLERANCE) * stamp),
        .stamp_max = (uint32_t)(int32_t)((1.0f + STAMP_TOLERANCE) * stamp),
    };
    return LODE_OK;
}

void lode_guard_reset(lode_guard_t *self) {
    *self = (lode_guard_t){.stamped = false};
}

void lode_guard_trip(lode_guard_t *self, uint_least8_t state, lode_check_t check, float measured,
                     float limit) {
    if (self->fault.check == (uint_least8_t)LODE_CHECK_NONE) {
        self->fault = (lode_fault_t){state, (uint_least8_t)check, measured, limit};
    }
}

// Up while bad, down while good: single samples pass, a condition that mostly holds trips.
static bool persists(int32_t *counter, bool bad, int32_t periods) {
    *counter = bad ? *counter + 1 : (*counter > 0 ? *counter - 1 : 0);
    return *counter >= periods;
}

static float largest(lode_abc_t i) {
    const float ab = lode_abs(i.a) > lode_abs(i.b) ? i.a : i.b;
    return lode_abs(i.c) > lode_abs(ab) ? i.c : ab;
}

// Comparisons are written so that NaN is bad.
static void check_power(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                        const lode_sample_t *sample, uint_least8_t state) {
    const lode_abc_t abc = sample->i_abc_A;
    const float i = largest(abc);
    const bool bounded = lode_abs(abc.a) <= tuning->i_trip && lode_abs(abc.b) <= tuning->i_trip &&
                         lode_abs(abc.c) <= tuning->i_trip;
    if (sample->trip) {
        lode_guard_trip(self, state, LODE_CHECK_HARDWARE_TRIP, 1.0f, 0.0f);
    }
    if (!bounded) {
        lode_guard_trip(self, state, LODE_CHECK_OVER_CURRENT, i, tuning->i_trip);
    }
    if (persists(&self->rail, sample->railed, tuning->bus_periods)) {
        lode_guard_trip(self, state, LODE_CHECK_CURRENT_RAIL, i, tuning->i_trip);
    }
    const float v = sample->v_bus_V;
    const bool high = !(v <= tuning->v_bus_max);
    if (persists(&self->bus, high || v < tuning->v_bus_min, tuning->bus_periods)) {
        lode_guard_trip(self, state, high ? LODE_CHECK_OVER_VOLTAGE : LODE_CHECK_UNDER_VOLTAGE, v,
                        high ? tuning->v_bus_max : tuning->v_bus_min);
    }
    const float hot = sample->temperature_degC;
    if (persists(&self->temperature, !(hot <= tuning->temperature_max), tuning->bus_periods)) {
        lode_guard_trip(self, state, LODE_CHECK_OVER_TEMPERATURE, hot, tuning->temperature_max);
    }
}

static void check_timing(lode_guard_t *self, const lode_guard_tuning_t *tuning, uint32_t stamp,
                         uint_least8_t state) {
    const uint32_t passed = stamp - self->stamp;
    if (tuning->stamp_max > 0u && self->stamped &&
        (passed < tuning->stamp_min || passed > tuning->stamp_max)) {
        lode_guard_trip(self, state, LODE_CHECK_TIMING, (float)passed, (float)tuning->stamp_max);
    }
    self->stamp = stamp;
    self->stamped = true;
}

static void check_motion(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                         const lode_estimate_t *estimate, lode_situation_t now) {
    const float omega = estimate->omega_rad_s;
    if (persists(&self->lock, !(estimate->lock >= LODE_LOCK_LOST), tuning->lock_periods)) {
        lode_guard_trip(self, now.state, LODE_CHECK_LOST_LOCK, estimate->lock, LODE_LOCK_LOST);
    }
    if (persists(&self->speed, !(lode_abs(omega) <= tuning->omega_max), tuning->lock_periods)) {
        lode_guard_trip(self, now.state, LODE_CHECK_OVER_SPEED, omega, tuning->omega_max);
    }
    if (persists(&self->direction, !(omega * now.direction >= 0.0f), tuning->lock_periods)) {
        lode_guard_trip(self, now.state, LODE_CHECK_WRONG_WAY, omega, 0.0f);
    }
}

LODE_HOT bool lode_guard_step(lode_guard_t *self, const lode_guard_tuning_t *tuning,
                              const lode_sample_t *sample, const lode_estimate_t *estimate,
                              lode_situation_t now) {
    check_power(self, tuning, sample, now.state);
    check_timing(self, tuning, sample->stamp, now.state);
    if (now.sensorless) {
        check_motion(self, tuning, estimate, now);
    }
    if (!now.finite) {
        lode_guard_trip(self, now.state, LODE_CHECK_NON_FINITE, estimate->omega_rad_s,
                        tuning->omega_max);
    }
    return self->fault.check == (uint_least8_t)LODE_CHECK_NONE;
}
