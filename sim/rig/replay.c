#include "rig/replay.h"

#include <math.h>
#include <stdlib.h>

#include "rig/euler_estimate.h"
#include "support/diag.h"
#include "support/units.h"

static lode_ab_t vector(double alpha, double beta) {
    return (lode_ab_t){(float)alpha, (float)beta};
}

// There is no estimate at the start, after a gap, and with the gates off.
static const lode_estimate_t nothing_known = {.rotor = {0.0f, 1.0f}};

// Only while the gates are off, the voltage is exactly 0, and the current is exactly 0 or, after a fault, that
// of the previous row. The drive has no estimate then.
static bool is_off(const recording_t *recording, size_t k) {
    if (k == 0) {
        return false;
    }
    const recording_row_t *row = &recording->row[k];
    const double voltage = fabs(row[-1].u_alpha_V) + fabs(row[-1].u_beta_V);
    const double current = fabs(row->i_alpha_A) + fabs(row->i_beta_A);
    const double change =
        fabs(row->i_alpha_A - row[-1].i_alpha_A) + fabs(row->i_beta_A - row[-1].i_beta_A);
    return !(voltage > 0.0) && (!(current > 0.0) || !(change > 0.0));
}

bool replay_is_known(const recording_t *recording, size_t k) {
    return k > 0 && !recording->row[k].after_gap && !is_off(recording, k);
}

static void estimate_rows(replay_t *self, const recording_t *recording,
                          const lode_estimator_tuning_t *tuning) {
    lode_estimator_t estimator;
    for (size_t k = 0; k < recording->rows; ++k) {
        const recording_row_t *row = &recording->row[k];
        const lode_ab_t i_A = vector(row->i_alpha_A, row->i_beta_A);
        if (replay_is_known(recording, k)) {
            const lode_ab_t u_V = vector(row[-1].u_alpha_V, row[-1].u_beta_V);
            self->row[k] = lode_estimator_step(&estimator, tuning, u_V, i_A);
            self->reseeds += self->row[k].reseeded ? 1u : 0u;
        } else {
            // The motor may already run, so the first change of current does not count.
            lode_estimator_reset(&estimator, tuning);
            lode_emf_reset(&estimator.emf, i_A);
            self->row[k] = nothing_known;
        }
    }
}

static void estimate_rows_euler(replay_t *self, const recording_t *recording,
                                const euler_config_t *config) {
    euler_t estimator;
    const size_t acquire = (size_t)llround(REPLAY_ACQUIRE_s / recording->ts_s);
    size_t since = 0;
    for (size_t k = 0; k < recording->rows; ++k) {
        const recording_row_t *row = &recording->row[k];
        if (!replay_is_known(recording, k)) {
            euler_reset(&estimator, row->i_alpha_A + I * row->i_beta_A);
            self->row[k] = nothing_known;
            since = k;
            continue;
        }
        const lode_ab_t u_V = vector(row[-1].u_alpha_V, row[-1].u_beta_V);
        self->row[k] =
            euler_estimate_step(&estimator, config, u_V, vector(row->i_alpha_A, row->i_beta_A));
        if (k - since <= acquire) {
            euler_acquire(&estimator, config);
        }
    }
}

/// Rows up to the last one with an estimate.
static size_t estimates_end(const recording_t *recording) {
    size_t end = recording->rows;
    while (end > 0 && !replay_is_known(recording, end - 1)) {
        --end;
    }
    return end;
}

static void compare(replay_t *self, const recording_t *recording) {
    const size_t rows = recording->rows;
    const size_t end = estimates_end(recording);
    const size_t window = (size_t)llround(REPLAY_WINDOW_s / recording->ts_s);
    const size_t settle = (size_t)llround(REPLAY_SETTLE_s / recording->ts_s);
    size_t close_from = 1;
    size_t since = 0;
    for (size_t k = 0; k < rows; ++k) {
        const recording_row_t *truth = &recording->row[k];
        self->error_deg[k] = NAN;
        self->off += is_off(recording, k) ? 1u : 0u;
        if (!replay_is_known(recording, k)) {
            since = k;
            continue;
        }
        const double error_deg =
            rig_angle_error_deg((double)lode_estimate_theta_rad(&self->row[k]), truth->theta_e_rad);
        const double error_rad_s = (double)self->row[k].omega_rad_s - truth->omega_e_rad_s;
        self->error_deg[k] = recording->has_theta ? error_deg : NAN;
        if (fabs(error_deg) >= REPLAY_CLOSE_deg) {
            close_from = k + 1;
        }
        if (k + window >= end) {
            rig_stats_add(&self->error_window_deg, error_deg);
            rig_stats_add(&self->speed_window_rad_s, error_rad_s);
        }
        if (self->row[k].lock >= LODE_LOCK_LOST) {
            rig_stats_add(&self->error_locked_deg, error_deg);
        }
        if (k - since >= settle) {
            rig_stats_add(&self->error_settled_deg, error_deg);
            rig_stats_add(&self->speed_settled_rad_s, error_rad_s);
        }
    }
    self->close_after_s =
        close_from < end ? recording->row[close_from].t_s - recording->row[0].t_s : NAN;
}

bool replay_run(replay_t *self, const recording_t *recording, const lode_estimator_tuning_t *tuning,
                const euler_config_t *euler) {
    *self = (replay_t){.rows = recording->rows, .close_after_s = NAN};
    self->row = calloc(recording->rows, sizeof *self->row);
    self->error_deg = calloc(recording->rows, sizeof *self->error_deg);
    if (self->row == NULL || self->error_deg == NULL) {
        rig_error("out of memory for %zu rows", recording->rows);
        replay_free(self);
        return false;
    }
    if (euler != NULL) {
        estimate_rows_euler(self, recording, euler);
    } else {
        estimate_rows(self, recording, tuning);
    }
    compare(self, recording);
    if (!recording->has_theta) {
        rig_stats_reset(&self->error_window_deg);
        rig_stats_reset(&self->error_settled_deg);
        rig_stats_reset(&self->error_locked_deg);
        self->close_after_s = NAN;
    }
    if (!recording->has_omega) {
        rig_stats_reset(&self->speed_window_rad_s);
        rig_stats_reset(&self->speed_settled_rad_s);
    }
    return true;
}

void replay_free(replay_t *self) {
    free(self->row);
    free(self->error_deg);
    *self = (replay_t){0};
}
