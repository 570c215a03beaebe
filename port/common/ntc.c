#include "ntc.h"

#define PER_degC 10.0f
#define ROUND 0.5f

// Output of the divider as a share of the reference, with the NTC at `R_Ohm`.
static float share_of(const port_ntc_config_t *config, float R_Ohm) {
    const float lower = config->to_ground ? R_Ohm : config->fixed_Ohm;
    return lower / (R_Ohm + config->fixed_Ohm);
}

static uint16_t tenths(float degC) {
    return (uint16_t)(int32_t)((degC - PORT_NTC_ZERO_degC) * PER_degC + ROUND);
}

// Between two points the temperature is interpolated over the share, not over the resistance, because that
// curve is nearly linear.
static uint16_t look_up(const port_ntc_config_t *config, float share) {
    const port_ntc_point_t *points = config->points;
    const float colder = config->to_ground ? 1.0f : -1.0f; // sign of the share of a colder NTC
    if (colder * (share - share_of(config, points[0].R_Ohm)) > 0.0f) {
        return PORT_NTC_MISSING;
    }
    for (uint32_t n = 1u; n < config->count; n++) {
        const float cold = share_of(config, points[n - 1u].R_Ohm);
        const float hot = share_of(config, points[n].R_Ohm);
        if (colder * (share - hot) >= 0.0f) {
            const float part = (share - cold) / (hot - cold);
            return tenths(points[n - 1u].degC + part * (points[n].degC - points[n - 1u].degC));
        }
    }
    return tenths(points[config->count - 1u].degC);
}

void port_ntc_init(port_ntc_t *self, const port_ntc_config_t *config) {
    for (uint32_t n = 0u; n <= PORT_NTC_SPANS; n++) {
        self->tenth[n] = look_up(config, (float)n / (float)PORT_NTC_SPANS);
    }
}
