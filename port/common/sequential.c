#include "sequential.h"

#define PHASES 3
#define THIRD (1.0f / 3.0f)
#define COUNT_MAX 65535.0f

void port_sequential_init(port_sequential_t *self, const port_sequential_config_t *config) {
    const float volt_seconds = config->L_H > 0.0f ? 1.0f / (config->L_H * config->f_pwm_Hz) : 0.0f;
    *self = (port_sequential_t){
        .rise_count_V = volt_seconds / config->i_gain_A_count,
        .duty_max = config->duty_max,
    };
    for (int n = 0; n < PHASES; n++) {
        self->share[n] = config->delay_s[n] * config->f_pwm_Hz;
    }
}

// A count at t_k: i = sample + ripple - share (i - last); i - last is the fundamental's slope.
static float at_tk(const port_sequential_t *self, int n, float sample, float ripple) {
    const float share = self->share[n];
    const float now = sample + ripple;
    return self->known[n] ? (now + share * self->last[n]) / (1.0f + share) : now;
}

LODE_RAMFUNC void port_sequential_read(port_sequential_t *self, float v_bus_V, uint16_t count[3]) {
    for (int n = 0; n < PHASES; n++) {
        const port_sequential_period_t *acts = self->share[n] < 0.0f ? &self->before : &self->after;
        if (!acts->on) {
            self->known[n] = false;
            continue;
        }
        const float centre = THIRD * (acts->duty[0] + acts->duty[1] + acts->duty[2]);
        const float ripple =
            self->rise_count_V * v_bus_V * (acts->duty[n] - centre) * self->share[n];
        self->last[n] = at_tk(self, n, (float)count[n], ripple);
        self->known[n] = acts->duty[n] <= self->duty_max;
        count[n] = (uint16_t)(int32_t)(lode_clamp(self->last[n], 0.0f, COUNT_MAX) + 0.5f);
    }
}

LODE_RAMFUNC void port_sequential_write(port_sequential_t *self, lode_abc_t duty, bool on) {
    self->before = self->after;
    self->after = (port_sequential_period_t){.duty = {duty.a, duty.b, duty.c}, .on = on};
}
