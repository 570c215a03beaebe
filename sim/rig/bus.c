#include "rig/bus.h"

#include <math.h>

#include "support/diag.h"

#define LOOP_s 1e-3 // period of the main loop

static float float_or_0(double x) {
    return isnan(x) ? 0.0f : (float)x;
}

static bool init_supply(bus_t *self, const rig_config_t *config) {
    const rig_supply_t *given = &config->supply;
    self->limits = !isnan(given->battery_A) || !isnan(given->regen_A);
    const lode_supply_config_t supply = {
        .battery_A = float_or_0(given->battery_A),
        .regen_A = isinf(given->regen_A) ? LODE_NONE : float_or_0(given->regen_A),
        .correct_s = float_or_0(given->correct_s),
    };
    lode_supply_reset(&self->supply);
    return lode_supply_tune(&self->supply_tuning, &supply, &config->drive) == LODE_OK;
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
    const double f_Hz = (double)config->drive.f_pwm_Hz;
    *self = (bus_t){.every = (uint32_t)fmax(1.0, round(LOOP_s * f_Hz)),
                    .v_bus_V_per_count = config->drive.sense.v_bus_gain_V_count};
    self->dt_s = (float)((double)self->every / f_Hz);
    return init_supply(self, config) && init_chopper(self, config);
}

void bus_limit(bus_t *self, lode_drive_t *drive) {
    lode_telemetry_t now;
    if (!self->limits || drive->steps % self->every != 0u || !lode_drive_telemetry(drive, &now)) {
        return;
    }
    const float i_A = lode_supply_current_A(&self->supply_tuning, &now);
    const lode_shares_t share =
        lode_supply_step(&self->supply, &self->supply_tuning, &now, i_A, self->dt_s);
    lode_drive_limit_torques(drive, share.motoring, share.braking);
}

double bus_chop(bus_t *self, uint16_t v_bus_count) {
    return (double)lode_chopper_step(&self->chopper, &self->chopper_tuning,
                                     self->v_bus_V_per_count * (float)v_bus_count);
}
