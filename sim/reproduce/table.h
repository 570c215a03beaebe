/// What a paper claims, row by row, beside what was computed and measured.
#ifndef RIG_REPRODUCE_TABLE_H
#define RIG_REPRODUCE_TABLE_H

#include <stdbool.h>
#include <stddef.h>

typedef enum {
    CLAIM_NONE,  ///< the paper gives no figure
    CLAIM_ABOUT, ///< "around", read from a plot: met within 30 % or 1.5 units, the sign as printed
    CLAIM_SIZE,  ///< the same of the magnitude, where the figure's sign convention is not known
    CLAIM_AT_MOST, ///< a bound on the magnitude
    CLAIM_EXACTLY, ///< a computed table: met within 2 %
    CLAIM_FORMULA  ///< the same, met where the theory column is
} claim_t;

enum { COLUMNS_MAX = 6, ROWS_MAX = 200, FIGURES_MAX = 20 };

/// A paper, and how it was gone through: each column is another form of what it proposes.
typedef struct {
    const char *name;      ///< on the command line
    const char *reference; ///< where it appeared
    const char *introduction;
    int columns;                      ///< in files
    int shown;                        ///< of these, from the first on, in the table
    const char *heading[COLUMNS_MAX]; ///< at most 9 characters, or 10 of 4 columns
    const char *key[COLUMNS_MAX];     ///< in files
    int judged;                       ///< the column that a claim is held against
    int best;                         ///< the one that may improve on it
    double window_s;                  ///< over which steady figures are taken
} paper_t;

/// One line of the table.
typedef struct {
    char id[48]; ///< for machines
    const char *figure;
    char what[64];
    const char *unit;
    claim_t claim;
    double claimed;
    double theory;                    ///< of what is printed; NaN: no closed form, or no solution
    const char *formula;              ///< of theory; NULL: none
    double value[COLUMNS_MAX];        ///< computed or measured
    const char *missing[COLUMNS_MAX]; ///< why a value is none
    bool improvable;                  ///< less is better
    const char *why;                  ///< it is not as claimed
} row_t;

typedef struct {
    const char *figure;
    const char *title;
    char note[1200]; ///< lines; may be empty
} figure_t;

typedef struct {
    const paper_t *paper;
    int rows, figures;
    row_t row[ROWS_MAX];
    figure_t figure[FIGURES_MAX];
    unsigned runs;
    double simulated_s;
} table_t;

/// What a row says of itself.
typedef struct {
    claim_t claim;
    double claimed;
    double theory;
    const char *formula;
    const char *why;
} words_t;

/// Nothing measured yet.
row_t *table_row(table_t *self, const char *figure, const char *id, const char *what,
                 const char *unit, const words_t *words);

figure_t *table_figure(table_t *self, const char *figure, const char *title);

words_t table_no_claim(double theory, const char *formula);

/// "reproduced", "contradicted", either with ", improved", "improved" alone, or "".
void table_verdict(const table_t *self, const row_t *row, char *text, size_t size);

#endif
