#include "analyse/result.h"

#include <math.h>
#include <stdio.h>

analyse_row_t *analyse_row(analyse_t *self, const char *table, const char *setting,
                           const char *quantity, const char *unit) {
    // The size of the table is a constant that no test exceeds; beyond it the last row is overwritten.
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
