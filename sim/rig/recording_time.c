#include "rig/recording_time.h"

#include <math.h>
#include <stdlib.h>

#include "support/diag.h"
#include "support/units.h"

// Allows for jitter, rounding of t_s, and a clock that differs slightly from that of the drive's file.
#define STEP_TOLERANCE 0.01
// From this step on, a row is missing.
#define GAP_STEPS 1.5

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

/// NaN if out of memory.
static double median_step(const recording_t *self) {
    const size_t steps = self->rows - 1;
    double *step = malloc(steps * sizeof *step);
    if (step == NULL) {
        return NAN;
    }
    for (size_t k = 0; k < steps; ++k) {
        step[k] = self->row[k + 1].t_s - self->row[k].t_s;
    }
    qsort(step, steps, sizeof *step, compare);
    const double median = step[steps / 2];
    free(step);
    return median;
}

static double step_to(const recording_t *self, size_t row) {
    return self->row[row].t_s - self->row[row - 1].t_s;
}

static bool is_even(double step_s, double wanted_s) {
    return fabs(step_s - wanted_s) <= STEP_TOLERANCE * wanted_s;
}

/// Checks that the rows are one period of the drive apart. Slower rows cannot be resampled.
static bool check_rate(const recording_t *self, const char *path, const recording_format_t *format,
                       double median_s) {
    const int line = (int)self->row[1].line;
    if (!(format->f_pwm_Hz > 0.0) || is_even(median_s, 1.0 / format->f_pwm_Hz)) {
        return true;
    }
    const double period_s = 1.0 / format->f_pwm_Hz;
    if (median_s > period_s) {
        rig_error_at(path, line,
                     "t_s: a row every %.6g s; expected one per PWM period, every %.6g s by "
                     "f_pwm_Hz = %g. Missing rows cannot be restored: record every period "
                     "(ring and scope: decimation 1; run: --set scenario.log_s=%.6g)",
                     median_s, period_s, format->f_pwm_Hz, period_s);
        return false;
    }
    if (!format->resample) {
        rig_error_at(path, line,
                     "t_s: a row every %.6g s; expected one per PWM period, every %.6g s by "
                     "f_pwm_Hz = %g; use --resample",
                     median_s, period_s, format->f_pwm_Hz);
    }
    return format->resample;
}

static bool check_rising(const recording_t *self, const char *path) {
    for (size_t k = 1; k < self->rows; ++k) {
        if (!(step_to(self, k) > 0.0)) {
            rig_error_at(path, (int)self->row[k].line,
                         "t_s: a step of %.6g s; expected rising times (use a new file after a "
                         "restart of the drive)",
                         step_to(self, k));
            return false;
        }
    }
    return true;
}

/// Checks that all steps are equal. For equal steps the mean is more exact if t_s is rounded.
static bool check_even(recording_t *self, const char *path, double median_s) {
    for (size_t k = 1; k < self->rows; ++k) {
        if (!is_even(step_to(self, k), median_s)) {
            rig_error_at(path, (int)self->row[k].line,
                         "t_s: a step of %.6g s; expected %.6g s (the median) within 1 %%; "
                         "--resample continues after gaps and evens out the other steps",
                         step_to(self, k), median_s);
            return false;
        }
    }
    self->ts_s = (self->row[self->rows - 1].t_s - self->row[0].t_s) / (double)(self->rows - 1);
    return true;
}

// ---- Resampling ---------------------------------------------------------------------------------

/// Marks the rows after gaps. Returns true if all other steps already are PWM periods, and sets ts_s to their
/// mean.
static bool find_gaps(recording_t *self, double median_s, double period_s) {
    bool even = is_even(median_s, period_s);
    double sum_s = 0.0;
    size_t count = 0;
    for (size_t k = 1; k < self->rows; ++k) {
        const double step_s = step_to(self, k);
        if (step_s > GAP_STEPS * fmax(median_s, period_s)) {
            self->row[k].after_gap = true;
            self->gaps++;
            self->gaps_s += step_s - period_s;
            continue;
        }
        even = even && is_even(step_s, median_s);
        sum_s += step_s;
        ++count;
    }
    self->ts_s = even ? sum_s / (double)count : period_s;
    return even;
}

/// The row at `t_s`, between `from` and the next one: linear interpolation of currents, angle and speed.
static recording_row_t row_at(const recording_row_t *from, double t_s) {
    const recording_row_t *to = from + 1;
    const double share = (t_s - from->t_s) / (to->t_s - from->t_s);
    recording_row_t row = *from;
    row.t_s = t_s;
    row.i_alpha_A += share * (to->i_alpha_A - from->i_alpha_A);
    row.i_beta_A += share * (to->i_beta_A - from->i_beta_A);
    row.theta_e_rad += share * remainder(to->theta_e_rad - from->theta_e_rad, 2.0 * RIG_PI);
    row.omega_e_rad_s += share * (to->omega_e_rad_s - from->omega_e_rad_s);
    return row;
}

/// Mean voltage over the period from `row->t_s` on: the voltage of each row acts until the next row.
static void set_voltage(recording_row_t *row, const recording_row_t *at,
                        const recording_row_t *last, double period_s) {
    const double end_s = row->t_s + period_s;
    double alpha_Vs = 0.0;
    double beta_Vs = 0.0;
    for (double from_s = row->t_s; from_s < end_s; ++at) {
        const double until_s = at < last ? fmin(at[1].t_s, end_s) : end_s;
        alpha_Vs += (until_s - from_s) * at->u_alpha_V;
        beta_Vs += (until_s - from_s) * at->u_beta_V;
        from_s = fmax(until_s, from_s);
        if (at == last) {
            break;
        }
    }
    row->u_alpha_V = alpha_Vs / period_s;
    row->u_beta_V = beta_Vs / period_s;
}

/// Resamples the rows first .. last, without a gap, to even times.
static bool resample_stretch(const recording_t *from, size_t first, size_t last, recording_t *to,
                             size_t *capacity) {
    size_t at = first;
    for (size_t n = 0;; ++n) {
        const double t_s = from->row[first].t_s + (double)n * to->ts_s;
        while (at < last && from->row[at + 1].t_s <= t_s) {
            ++at;
        }
        if (at == last && from->row[at].t_s < t_s) {
            return true;
        }
        recording_row_t row = at < last ? row_at(&from->row[at], t_s) : from->row[at];
        set_voltage(&row, &from->row[at], &from->row[last], to->ts_s);
        row.after_gap = n == 0 && from->row[first].after_gap;
        if (!recording_add(to, capacity, &row)) {
            return false;
        }
    }
}

static bool resample(recording_t *self) {
    recording_t even = *self;
    size_t capacity = 0;
    bool good = true;
    even.row = NULL;
    even.rows = 0;
    even.resampled = self->rows;
    for (size_t first = 0; good && first < self->rows;) {
        size_t last = first;
        while (last + 1 < self->rows && !self->row[last + 1].after_gap) {
            ++last;
        }
        good = resample_stretch(self, first, last, &even, &capacity);
        first = last + 1;
    }
    free(self->row);
    *self = even;
    return good;
}

bool recording_time(recording_t *self, const char *path, const recording_format_t *format) {
    if (self->rows < 3) {
        rig_error_at(path, 0, "%zu rows; expected at least 3", self->rows);
        return false;
    }
    if (!check_rising(self, path)) {
        return false;
    }
    const double median_s = median_step(self);
    if (isnan(median_s)) {
        rig_error_at(path, 0, "out of memory; expected fewer rows");
        return false;
    }
    if (!check_rate(self, path, format, median_s)) {
        return false;
    }
    if (!format->resample) {
        return check_even(self, path, median_s);
    }
    const double period_s = format->f_pwm_Hz > 0.0 ? 1.0 / format->f_pwm_Hz : median_s;
    return find_gaps(self, median_s, period_s) || resample(self);
}
