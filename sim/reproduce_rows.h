/// What paper 1 claims, experiment by experiment, beside what was measured.
#ifndef RIG_REPRODUCE_ROWS_H
#define RIG_REPRODUCE_ROWS_H

#include "reproduce_case.h"
#include "reproduce_theory.h"

typedef enum {
    CLAIM_NONE,  ///< the paper gives no figure
    CLAIM_ABOUT, ///< "around", read from a plot: met within 30 % or 1.5 units, the sign as printed
    CLAIM_SIZE,  ///< the same of the magnitude, where the figure's sign convention is not known
    CLAIM_AT_MOST, ///< a bound on the magnitude
    CLAIM_EXACTLY, ///< a computed table: met within 2 %
    CLAIM_FORMULA  ///< the same, met where the theory column is
} claim_t;

enum { ROWS_MAX = 160, FIGURES_MAX = 16 };

/// One line of the table.
typedef struct {
    char id[48]; ///< for machines
    const char *figure;
    char what[64];
    const char *unit;
    claim_t claim;
    double claimed;
    double theory;               ///< of what is printed; NaN: no closed form, or no solution
    const char *formula;         ///< of theory; NULL: none
    double value[CHAINS];        ///< measured, in each chain
    const char *missing[CHAINS]; ///< why a value is none
    bool improvable;             ///< less is better
    const char *why;
} row_t;

typedef struct {
    const char *figure;
    const char *title;
    char note[1200]; ///< lines; may be empty
} figure_t;

typedef struct {
    int rows, figures;
    row_t row[ROWS_MAX];
    figure_t figure[FIGURES_MAX];
    theory_t theory;
    unsigned runs;
    double simulated_s;
} reproduction_t;

/// Runs every experiment. False after a message.
bool reproduction_run(reproduction_t *self, const case_bases_t *bases);

/// "reproduced", "contradicted", either with ", improved", "improved" alone, or "".
void row_verdict(const row_t *row, char *text, size_t size);

/// One of the experiments again, with its signals. False after a message.
bool reproduction_signals(const case_bases_t *bases, const case_t *what, runlog_t *log);

#endif
