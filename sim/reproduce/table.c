#include "reproduce/table.h"

#include <math.h>
#include <stdio.h>

void table_begin(table_t *self, const paper_t *paper, uint64_t first_seed, int seeds) {
    self->paper = paper;
    self->first_seed = first_seed;
    self->seeds = seeds;
    self->rows = self->figures = 0;
    self->runs = 0;
    self->simulated_s = 0.0;
}

row_t *table_row(table_t *self, const char *figure, const char *id, const char *what,
                 const char *unit, const words_t *words) {
    row_t *row = &self->row[self->rows < ROWS_MAX - 1 ? self->rows++ : self->rows];
    *row = (row_t){.figure = figure,
                   .unit = unit,
                   .claim = words->claim,
                   .claimed = words->claimed,
                   .reading = words->reading,
                   .lacks = words->lacks,
                   .theory = words->theory,
                   .formula = words->formula};
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
    return (words_t){.claim = CLAIM_NONE, .claimed = NAN, .theory = theory, .formula = formula};
}

int table_variants(const paper_t *paper) {
    int variants = 1;
    for (int k = 0; k < AXES; ++k) {
        variants *= paper->axis[k].choices;
    }
    return variants;
}

int table_variant(const paper_t *paper, const int choice[AXES]) {
    int variant = 0;
    for (int k = AXES; k-- > 0;) {
        variant = variant * paper->axis[k].choices + choice[k];
    }
    return variant;
}

int table_choices(const paper_t *paper, int variant, int choice[AXES]) {
    for (int k = 0; k < AXES; ++k) {
        choice[k] = variant % paper->axis[k].choices;
        variant /= paper->axis[k].choices;
    }
    return table_variants(paper);
}
