#include "reproduce/table.h"

#include <math.h>
#include <stdio.h>

row_t *table_row(table_t *self, const char *figure, const char *id, const char *what,
                 const char *unit, const words_t *words) {
    row_t *row = &self->row[self->rows < ROWS_MAX - 1 ? self->rows++ : self->rows];
    *row = (row_t){.figure = figure,
                   .unit = unit,
                   .claim = words->claim,
                   .claimed = words->claimed,
                   .theory = words->theory,
                   .formula = words->formula,
                   .improvable = true,
                   .why = words->why != NULL ? words->why : ""};
    (void)snprintf(row->id, sizeof row->id, "%s", id);
    (void)snprintf(row->what, sizeof row->what, "%s", what);
    for (int k = 0; k < COLUMNS_MAX; ++k) {
        row->value[k] = NAN;
        row->missing[k] = "-";
    }
    return row;
}

figure_t *table_figure(table_t *self, const char *figure, const char *title) {
    figure_t *now =
        &self->figure[self->figures < FIGURES_MAX - 1 ? self->figures++ : self->figures];
    *now = (figure_t){.figure = figure, .title = title};
    return now;
}

words_t table_no_claim(double theory, const char *formula) {
    return (words_t){CLAIM_NONE, NAN, theory, formula, NULL};
}

static bool meets(const table_t *self, const row_t *row) {
    const double value =
        row->claim == CLAIM_FORMULA ? row->theory : row->value[self->paper->judged];
    const double size = fabs(row->claimed);
    const double about = fmax(1.5, 0.3 * size);
    switch (row->claim) {
    case CLAIM_ABOUT:
        return fabs(value - row->claimed) <= about;
    case CLAIM_SIZE:
        return fabs(fabs(value) - size) <= about;
    case CLAIM_AT_MOST:
        return fabs(value) <= size;
    case CLAIM_EXACTLY:
    case CLAIM_FORMULA:
        return fabs(value - row->claimed) <= fmax(0.01, 0.02 * size);
    case CLAIM_NONE:
    default:
        return false;
    }
}

void table_verdict(const table_t *self, const row_t *row, char *text, size_t size) {
    const double printed = row->value[self->paper->judged];
    const double best = row->value[self->paper->best];
    const bool better =
        row->improvable && (isnan(printed) ? !isnan(best) : fabs(best) <= 0.7 * fabs(printed));
    const char *claim = meets(self, row) ? "reproduced" : "contradicted";
    const bool claimed = row->claim != CLAIM_NONE;
    (void)snprintf(text, size, "%s%s%s", claimed ? claim : "", claimed && better ? ", " : "",
                   better ? "improved" : "");
}
