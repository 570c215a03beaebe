#include "figures.h"

#define STEPS_MAX 65535u
#define NS_PER_S 1.0e9f
// With the zero vectors halved, a vector between two legs of equal duty has them at
// 1/2 + sqrt(3)/4 of its share of the circle.
#define TWO_LEGS 0.4330127f

uint32_t port_pwm_steps(uint32_t f_timer_Hz, uint32_t f_pwm_Hz) {
    if (f_pwm_Hz == 0u) {
        return 0u;
    }
    const uint32_t steps = (f_timer_Hz + f_pwm_Hz) / (2u * f_pwm_Hz);
    return steps <= STEPS_MAX ? steps : 0u;
}

float port_duty_max(float f_pwm_Hz, float settle_ns, float sample_ns) {
    return 1.0f - 2.0f * lode_max(settle_ns, sample_ns) / NS_PER_S * f_pwm_Hz;
}

lode_single_shunt_config_t port_link_config(const lode_drive_config_t *config, float settle_ns,
                                            float sample_ns, float L_H) {
    return (lode_single_shunt_config_t){.f_pwm_Hz = config->f_pwm_Hz,
                                        .i_gain_A_count = config->sense.i_gain_A_count,
                                        .window_s = (settle_ns + sample_ns) / NS_PER_S,
                                        .sample_s = sample_ns / NS_PER_S,
                                        .L_H = L_H};
}

// A refused window leaves 0, and the initialisation of the board fails.
static float link_voltage_use(const lode_drive_config_t *config, float settle_ns, float sample_ns) {
    const lode_single_shunt_config_t link = port_link_config(config, settle_ns, sample_ns, 0.0f);
    lode_single_shunt_tuning_t tuning;
    const lode_status_t status = lode_single_shunt_tune(&tuning, &link);
    return status == LODE_OK ? lode_single_shunt_voltage_use(&tuning) : 0.0f;
}

void port_sensing(lode_drive_config_t *config, port_sensing_t sensing, float settle_ns,
                  float sample_ns) {
    const bool two = sensing == PORT_LOW_SIDE_TWO || sensing == PORT_IN_LINE_TWO;
    config->sense.shunts = two ? LODE_SHUNTS_TWO : LODE_SHUNTS_THREE;
    config->sense.duty_max = 1.0f;
    if (sensing == PORT_LINK_ONE) {
        config->start.pulses = LODE_OFF; // a current in the low sides alone cannot be measured
        config->current.voltage_use = link_voltage_use(config, settle_ns, sample_ns);
    }
    if (sensing == PORT_LOW_SIDE_THREE || sensing == PORT_LOW_SIDE_TWO) {
        const float duty_max = port_duty_max(config->f_pwm_Hz, settle_ns, sample_ns);
        const float loss = config->inverter.dead_time_s * config->f_pwm_Hz;
        config->sense.duty_max = duty_max;
        // With two shunts the drive computes the share itself.
        config->current.voltage_use = two ? 0.0f : port_voltage_use(duty_max - loss);
    }
}

float port_trip_A(float wanted_A, float least_A, float most_A) {
    return lode_clamp(wanted_A, least_A, most_A);
}

float port_voltage_use(float duty_max) {
    return lode_clamp((duty_max - 0.5f) / TWO_LEGS, 0.0f, LODE_VOLTAGE_USE);
}
