#include "analyse/analyse.h"

#include <math.h>
#include <string.h>

#include "analyse/own_loops.h"
#include "analyse/paper1.h"
#include "analyse/paper2.h"
#include "lag_inline.h"
#include "support/units.h"

/// Lags, margins and the joint poles of the given drive.
static void at_speed(analyse_speed_t *at, const lode_drive_config_t *drive,
                     const lode_estimator_tuning_t *tuning, double omega_rad_s) {
    const double ts = 1.0 / (double)drive->f_pwm_Hz;
    const observer_t observer =
        observer_make(&tuning->emf.observer, (double)tuning->pll.ts_s, omega_rad_s);
    const double complex estimate = observer_response(&observer, cexp(I * omega_rad_s * ts)) *
                                    observer_circuit(&drive->motor, ts, omega_rad_s);
    const joint_t joint = joint_make(tuning, omega_rad_s);
    at->omega_rad_s = omega_rad_s;
    at->speed_rpm = rig_rpm_from_rad_s(omega_rad_s) / (double)drive->motor.pole_pairs;
    at->gain = cabs(estimate);
    at->lag_deg = -rig_deg_from_rad(carg(estimate));
    at->lag_firmware_deg = rig_deg_from_rad((double)lode_lag_rad(&tuning->lag, (float)omega_rad_s));
    at->margins = margins_at(drive, omega_rad_s);
    at->poles = joint_poles(&joint, at->pole);
}

lode_status_t analyse_compute(analyse_t *self, const rig_config_t *config) {
    static const double shares[ANALYSE_SPEEDS] = {0.1, 0.2, 0.4, 0.7, 1.0, 0.0};
    const lode_drive_config_t *drive = &config->drive;
    lode_drive_tuning_t tuning;
    const lode_status_t status = lode_drive_tune(&tuning, drive);
    if (status != LODE_OK) {
        return status;
    }
    memset(self, 0, sizeof *self);
    self->ts_s = 1.0 / (double)drive->f_pwm_Hz;
    analyse_paper1(self);
    analyse_paper2(self, &drive->motor);
    own_loops(self, drive, &tuning);
    for (int k = 0; k < ANALYSE_SPEEDS; ++k) {
        const bool last = k == ANALYSE_SPEEDS - 1;
        const double rated = (double)drive->motor.omega_rated_rad_s;
        at_speed(&self->at[k], drive, &tuning.estimator,
                 last ? (double)drive->estimator.omega_max_rad_s : shares[k] * rated);
    }
    return LODE_OK;
}
