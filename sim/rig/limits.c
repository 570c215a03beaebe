#include "rig/limits.h"

#include <math.h>

#include "support/diag.h"

#define LOOP_s 1e-3 // period of the main loop

static float float_or_0(double x) {
    return isnan(x) ? 0.0f : (float)x;
}

static bool init_supply(limits_t *self, const rig_config_t *config) {
    const rig_supply_t *given = &config->supply;
    self->by_supply = !isnan(given->battery_A) || !isnan(given->regen_A);
    const lode_supply_config_t supply = {
        .battery_A = float_or_0(given->battery_A),
        .regen_A = isinf(given->regen_A) ? LODE_NONE : float_or_0(given->regen_A),
        .correct_s = float_or_0(given->correct_s),
    };
    lode_supply_reset(&self->supply);
    return lode_supply_tune(&self->supply_tuning, &supply, &config->drive) == LODE_OK;
}

static bool init_derate(limits_t *self, const rig_config_t *config) {
    const rig_derate_t *given = &config->derate;
    const double most_degC = (double)config->drive.guard.temperature_max_degC;
    const double to_degC = isnan(given->to_degC) ? most_degC : given->to_degC;
    self->by_heat = !isnan(given->i_continuous_A) || !isnan(given->winding_s) ||
                    !isnan(given->from_degC) || !isnan(given->to_degC) || !isnan(given->heat);
    self->cool = 1.0f;
    if (!self->by_heat) {
        return true;
    }
    const lode_derate_config_t derate = {
        .i_max_A = config->drive.inverter.i_max_A,
        .i_continuous_A = float_or_0(given->i_continuous_A),
        .winding_s = float_or_0(given->winding_s),
        .from_degC = float_or_0(given->from_degC),
        .to_degC = (float)to_degC,
    };
    const lode_status_t status = lode_derate_tune(&self->derate_tuning, &derate);
    if (status != LODE_OK || to_degC > most_degC) {
        rig_error("[derate]: %s: expected i_continuous_A up to i_max_A = %g, from_degC below "
                  "to_degC = %g, and that at most [guard] temperature_max_degC = %g",
                  lode_status_name(LODE_ERROR_DERATE), (double)derate.i_max_A, to_degC, most_degC);
        return false;
    }
    lode_derate_reset(&self->derate, float_or_0(given->heat));
    return true;
}

bool limits_init(limits_t *self, const rig_config_t *config) {
    const double f_Hz = (double)config->drive.f_pwm_Hz;
    *self = (limits_t){.every = (uint32_t)fmax(1.0, round(LOOP_s * f_Hz))};
    self->dt_s = (float)((double)self->every / f_Hz);
    return init_supply(self, config) && init_derate(self, config);
}

void limits_apply(limits_t *self, lode_drive_t *drive) {
    const bool limits = self->by_supply || self->by_heat;
    lode_telemetry_t now;
    if (!limits || drive->steps % self->every != 0u || !lode_drive_telemetry(drive, &now)) {
        return;
    }
    lode_shares_t share = {1.0f, 1.0f};
    if (self->by_supply) {
        const float i_A = lode_supply_current_A(&self->supply_tuning, &now);
        share = lode_supply_step(&self->supply, &self->supply_tuning, &now, i_A, self->dt_s);
    }
    if (self->by_heat) {
        self->cool = lode_derate_step(&self->derate, &self->derate_tuning, &now, self->dt_s);
    }
    lode_drive_limit_torques(drive, fminf(share.motoring, self->cool),
                             fminf(share.braking, self->cool));
}
