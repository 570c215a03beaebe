#include "rig/bus.h"

#include <math.h>

#include "support/diag.h"

static float float_or_0(double x) {
    return isnan(x) ? 0.0f : (float)x;
}

static bool init_chopper(bus_t *self, const rig_config_t *config) {
    const rig_chopper_t *given = &config->chopper;
    const double all = given->on_V + given->full_V + given->R_Ohm + given->power_W +
                       given->thermal_s; // NaN if one is unset
    self->chops = !isnan(given->on_V) || !isnan(given->full_V) || !isnan(given->R_Ohm) ||
                  !isnan(given->power_W) || !isnan(given->thermal_s);
    if (!self->chops) {
        return true;
    }
    const lode_chopper_config_t chopper = {
        .on_V = float_or_0(given->on_V),
        .full_V = float_or_0(given->full_V),
        .R_Ohm = float_or_0(given->R_Ohm),
        .power_W = float_or_0(given->power_W),
        .thermal_s = float_or_0(given->thermal_s),
        .period_s = 1.0f / config->drive.f_pwm_Hz,
    };
    const lode_status_t status =
        isnan(all) ? LODE_ERROR_CHOPPER : lode_chopper_tune(&self->chopper_tuning, &chopper);
    if (status != LODE_OK) {
        rig_error(
            "[chopper]: %s: expected all of on_V, full_V above it, R_Ohm, power_W and thermal_s",
            lode_status_name(status));
    }
    lode_chopper_reset(&self->chopper, 0.0f);
    return status == LODE_OK;
}

bool bus_init(bus_t *self, const rig_config_t *config) {
    *self = (bus_t){.v_bus_V_per_count = config->drive.sense.v_bus_gain_V_count};
    return init_chopper(self, config);
}

double bus_chop(bus_t *self, uint16_t v_bus_count) {
    return (double)lode_chopper_step(&self->chopper, &self->chopper_tuning,
                                     self->v_bus_V_per_count * (float)v_bus_count);
}
