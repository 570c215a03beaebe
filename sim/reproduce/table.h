/// The claims of a paper, row by row, with the computed and measured values.
#ifndef RIG_REPRODUCE_TABLE_H
#define RIG_REPRODUCE_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    CLAIM_NONE,  ///< the paper gives no figure
    CLAIM_ABOUT, ///< "around", read from a plot: met within 30 % or 1.5 units, the sign as printed
    CLAIM_SIZE,  ///< the same for the magnitude, if the figure's sign convention is not known
    CLAIM_AT_MOST,  ///< a bound on the magnitude, and the accuracy of reading
    CLAIM_AT_LEAST, ///< the same from below, signed
    CLAIM_EXACTLY,  ///< met within 2 %
    CLAIM_FORMULA   ///< the same, met if the theory column meets it: restates a table by arithmetic
} claim_t;

/// "At most" is met up to half a unit of the last printed digit: the paper draws its results instead of
/// tabulating them, so its text is rounded to that digit. The axes of its figures are not available to us, so
/// nothing coarser is assumed. Our own bounds have no such tolerance.
#define READING_WHOLE 0.5
#define READING_TENTH 0.05

enum {
    COLUMNS_MAX = 6,
    ROWS_MAX = 240,
    FIGURES_MAX = 24,
    AXES = 3,
    BODE_MAX = 4,
    CHOICES_MAX = 3,
    VARIANTS_MAX = 27,
    SEEDS_MAX = 20
};

/// A choice that a paper leaves open, with the possible alternatives.
typedef struct {
    const char *name;
    int choices;
    const char *choice[CHOICES_MAX];
} axis_t;

/// A paper and its evaluation: each column is another form of its proposal.
typedef struct {
    const char *name;      ///< on the command line
    const char *reference; ///< publication
    const char *introduction;
    int columns;                      ///< in files
    int shown;                        ///< of these, from the first on, in the table
    const char *heading[COLUMNS_MAX]; ///< at most 9 characters, or 10 of 4 columns
    const char *key[COLUMNS_MAX];     ///< in files
    axis_t axis[AXES];                ///< a claim is judged over all combinations
    const char *bode[BODE_MAX][2];    ///< figures that `analyse --plots` draws, and their files
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
    double reading;            ///< accuracy with which the paper's figure can be read
    const char *lacks;         ///< a datum whose absence prevents the comparison; NULL: none
    double theory;             ///< closed form of the printed method; NaN: none, or no solution
    const char *formula;       ///< of theory; NULL: none
    double value[COLUMNS_MAX]; ///< computed or measured, with the first seed
    const char *missing[COLUMNS_MAX]; ///< why a value is missing
    int seeds;                        ///< of the samples; 0: there are none
    bool ran[VARIANTS_MAX];
    double sample[VARIANTS_MAX][SEEDS_MAX]; ///< NaN: the rotor was lost or stalls
    char because[240];                      ///< computed from the runs; may be empty
} row_t;

typedef struct {
    const char *figure;
    const char *title;
    char note[1200]; ///< lines; may be empty
} figure_t;

typedef struct {
    const paper_t *paper;
    uint64_t first_seed;
    int seeds;
    int rows, figures;
    row_t row[ROWS_MAX];
    figure_t figure[FIGURES_MAX];
    unsigned runs;
    double simulated_s;
} table_t;

/// The words of a row.
typedef struct {
    claim_t claim;
    double claimed;
    double reading;
    double theory;
    const char *formula;
    const char *lacks;
} words_t;

/// An empty table of `paper`.
void table_begin(table_t *self, const paper_t *paper, uint64_t first_seed, int seeds);

row_t *table_row(table_t *self, const char *figure, const char *id, const char *what,
                 const char *unit, const words_t *words);

figure_t *table_figure(table_t *self, const char *figure, const char *title);

words_t table_no_claim(double theory, const char *formula);

/// The variant of these choices, one of each axis.
int table_variant(const paper_t *paper, const int choice[AXES]);

/// The reverse. Returns the number of variants.
int table_choices(const paper_t *paper, int variant, int choice[AXES]);
int table_variants(const paper_t *paper);

#endif
