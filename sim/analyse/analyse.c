#include "analyse/analyse.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analyse/own_loops.h"
#include "lag_inline.h"
#include "support/units.h"

analyse_row_t *analyse_row(analyse_t *self, const char *table, const char *setting,
                           const char *quantity, const char *unit) {
    // The table's size is a constant that the tests exceed nowhere; the last row then takes it all.
    const int at = self->rows < ANALYSE_ROWS_MAX ? self->rows++ : ANALYSE_ROWS_MAX - 1;
    analyse_row_t *row = &self->row[at];
    *row = (analyse_row_t){.table = table,
                           .quantity = quantity,
                           .unit = unit,
                           .printed = NAN,
                           .as_printed = NAN,
                           .theory = NAN,
                           .sampled = NAN};
    (void)snprintf(row->setting, sizeof row->setting, "%s", setting);
    return row;
}

analyse_curve_t *analyse_curve(analyse_t *self, const char *figure, const char *label, int family,
                               analyse_form_t form) {
    const int at = self->curves < ANALYSE_CURVES_MAX ? self->curves++ : ANALYSE_CURVES_MAX - 1;
    analyse_curve_t *curve = &self->curve[at];
    curve->figure = figure;
    curve->family = family;
    curve->form = form;
    (void)snprintf(curve->label, sizeof curve->label, "%s", label);
    return curve;
}

void analyse_curve_log(analyse_curve_t *curve, double from_rad_s, double to_rad_s) {
    for (int k = 0; k < ANALYSE_POINTS; ++k) {
        const double share = (double)k / (ANALYSE_POINTS - 1);
        curve->omega_rad_s[k] = from_rad_s * pow(to_rad_s / from_rad_s, share);
    }
}

void analyse_curve_two_sided(analyse_curve_t *curve, double from_rad_s, double to_rad_s) {
    const int half = ANALYSE_POINTS / 2;
    for (int k = 0; k <= half; ++k) {
        const double share = (double)k / half;
        const double omega = from_rad_s * pow(to_rad_s / from_rad_s, share);
        curve->omega_rad_s[half + k] = omega;
        curve->omega_rad_s[half - k] = -omega;
    }
}

/// Lags, margins and the joint poles of the drive that was given.
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
