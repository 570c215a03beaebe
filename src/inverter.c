#include "inverter_inline.h"

// Least bus voltage as a divisor, as a share of nominal: below it the guard has tripped.
#define V_MIN_SHARE 0.1f
// Share of i_dead at zero modulation: there is almost no ripple, but noise in the current.
#define I_DEAD_MIN_SHARE 0.05f

// Longer than any bootstrap capacitor needs.
#define PRECHARGE_MAX_s 1.0f

// Dead time that the start may find beyond the configured one.
#define DEAD_MORE_MAX_s 1.5e-6f

// Margin for rounding.
#define ROUNDING 0.999f

void lode_inverter_design(lode_inverter_config_t *config, const lode_motor_t *motor, float ts_s) {
    // One leg switching against the other two at half duty makes a ripple of v_bus Ts/(6 L) peak to peak. The default is three
    // quarters of that, with L the mean of both axes. Simulated without load: half as much hunts at 1500 rpm, twice as much
    // leaves 2 degrees at 300 rpm.
    const float L_H = lode_max(motor->Ld_H + motor->Lq_H, FLT_MIN);
    const float carrier_Hz = lode_inverter_carrier_Hz(config, 1.0f / ts_s);
    const float ripple_A = config->v_bus_V / (3.0f * carrier_Hz * L_H);
    const float i_dead_A = lode_clamp(0.75f * ripple_A, 0.01f * config->i_max_A, config->i_max_A);
    config->i_dead_A = lode_given_or(config->i_dead_A, i_dead_A);
    if (config->dead_time_correction == LODE_AUTO) {
        config->dead_time_correction = LODE_ON;
    }
    if (config->dead_time_model == LODE_AUTO) {
        config->dead_time_model = LODE_OFF;
    }
}

lode_status_t lode_inverter_check_given(const lode_inverter_config_t *config) {
    if (!lode_in_range(config->v_bus_V, 1.0f, 2000.0f)) {
        return LODE_ERROR_V_BUS;
    }
    return lode_in_range(config->i_max_A, 1.0e-3f, 1.0e4f) ? LODE_OK : LODE_ERROR_I_MAX;
}

static lode_status_t check(const lode_inverter_config_t *config, float ts_s) {
    const lode_status_t given = lode_inverter_check_given(config);
    if (given != LODE_OK) {
        return given;
    }
    if (!lode_in_range(config->dead_time_s, 0.0f, 0.2f * ts_s)) {
        return LODE_ERROR_DEAD_TIME;
    }
    if (!lode_in_range(config->v_drop_V, 0.0f, 10.0f)) {
        return LODE_ERROR_V_DROP;
    }
    if (!lode_in_range(config->r_on_Ohm, 0.0f, 10.0f)) {
        return LODE_ERROR_R_ON;
    }
    if (!lode_in_range(config->i_dead_A, 1.0e-3f * config->i_max_A, config->i_max_A)) {
        return LODE_ERROR_I_DEAD;
    }
    if (!lode_in_range(config->pwm_ticks, 0.0f, 65535.0f)) {
        return LODE_ERROR_PWM_TICKS;
    }
    if (!lode_in_range(config->precharge_s, 0.0f, PRECHARGE_MAX_s)) {
        return LODE_ERROR_PRECHARGE;
    }
#ifdef LODE_WITHOUT_PRECHARGE
    if (config->precharge_s > 0.0f) {
        return LODE_ERROR_PRECHARGE;
    }
#endif
    if (!lode_is_on_or_off(config->dead_time_correction) ||
        !lode_is_on_or_off(config->dead_time_model) ||
        (!lode_is_on_or_off(config->double_update) && config->double_update != LODE_AUTO)) {
        return LODE_ERROR_CHOICE;
    }
    return LODE_OK;
}

lode_status_t lode_inverter_tune(lode_inverter_tuning_t *tuning,
                                 const lode_inverter_config_t *config, float ts_s) {
    const lode_status_t status = check(config, ts_s);
    if (status != LODE_OK) {
        return status;
    }
    const float ticks = (float)(int32_t)config->pwm_ticks;
    const bool correct = config->dead_time_correction == LODE_ON;
    const bool model = !correct && config->dead_time_model == LODE_ON;
    const float v_min_V = V_MIN_SHARE * config->v_bus_V;
    const float carrier_Hz = lode_inverter_carrier_Hz(config, 1.0f / ts_s);
    const float dead_duty = config->dead_time_s * carrier_Hz;
    // Min-max centring leaves half of the unused span at each rail; the correction uses a part of it.
    const float dead_more = DEAD_MORE_MAX_s * carrier_Hz;
    const float most_error = correct ? dead_duty + dead_more + config->v_drop_V / v_min_V : 0.0f;
    const float precharge = config->precharge_s / ts_s + 0.5f;
    const float headroom = (1.0f - 2.0f * most_error) / LODE_SQRT3;
    *tuning = (lode_inverter_tuning_t){
        .v_min_V = v_min_V,
        .dead_duty = correct || model ? dead_duty : 0.0f,
        .dead_more_max = correct || model ? dead_more : 0.0f,
        .v_drop_V = correct || model ? config->v_drop_V : 0.0f,
        .i_dead_min_A = I_DEAD_MIN_SHARE * config->i_dead_A,
        .i_dead_span_A = (1.0f - I_DEAD_MIN_SHARE) * config->i_dead_A,
        .ticks = ticks,
        .inv_ticks = ticks > 0.0f ? 1.0f / ticks : 0.0f,
        .free = model ? -1.0f : ROUNDING * headroom,
        .precharge_periods = (uint32_t)(int32_t)precharge,
        .correct = correct ? 1u : 0u,
        .grid = ticks > 0.0f ? 1u : 0u,
    };
    return LODE_OK;
}

float lode_inverter_taken_V(const lode_inverter_config_t *config, float ts_s) {
    const float dead_s = config->dead_time_s + DEAD_MORE_MAX_s;
    return dead_s * lode_inverter_carrier_Hz(config, 1.0f / ts_s) * config->v_bus_V +
           2.0f * config->v_drop_V;
}

// In |i + i_dead| - |i - i_dead| both terms are rounded by half the spacing of floats at 2 i.
void lode_inverter_bound_current(lode_inverter_tuning_t *tuning, float i_A) {
    const float slope_A =
        0.5f * (tuning->dead_duty + tuning->dead_more_max + tuning->v_drop_V / tuning->v_min_V) /
        lode_max(tuning->i_dead_min_A, FLT_MIN);
    if (tuning->correct != 0u) {
        tuning->free -= 2.0f / LODE_SQRT3 * slope_A * FLT_EPSILON * 2.0f * i_A;
    }
}

#ifndef LODE_WITHOUT_START_MEASUREMENT

void lode_inverter_correct(lode_inverter_t *self, const lode_inverter_tuning_t *tuning, float r_Ohm,
                           float dead_V, float current_A) {
    const float before = self->dead_more;
    const float wanted = before + dead_V * self->per_V / FOUR_PER_PI;
    self->dead_more = lode_clamp(wanted, -lode_min(tuning->dead_duty, tuning->dead_more_max),
                                 tuning->dead_more_max);
    const float left_V = dead_V - (self->dead_more - before) * FOUR_PER_PI * self->v_bus_V;
    self->r_more_Ohm += r_Ohm + left_V / current_A;
}

#endif

void lode_inverter_reset(lode_inverter_t *self) {
    *self = (lode_inverter_t){.v_bus_V = 0.0f};
}
