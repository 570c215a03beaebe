/// What a paper claims, row by row, beside what was computed and measured.
#ifndef RIG_REPRODUCE_TABLE_H
#define RIG_REPRODUCE_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    CLAIM_NONE,  ///< the paper gives no figure
    CLAIM_ABOUT, ///< "around", read from a plot: met within 30 % or 1.5 units, the sign as printed
    CLAIM_SIZE,  ///< the same of the magnitude, where the figure's sign convention is not known
    CLAIM_AT_MOST,  ///< a bound on the magnitude, and the accuracy of reading
    CLAIM_AT_LEAST, ///< the same from below, signed
    CLAIM_EXACTLY,  ///< met within 2 %
    CLAIM_FORMULA   ///< the same, met where the theory column is: restates a table by arithmetic
} claim_t;

/// "At most" is met up to half a unit of the last digit that the paper prints: its figures are drawn, not
/// tabulated, so what it says of them is rounded to that digit. Their axes are not available to us, so
/// nothing coarser is assumed. Bounds of our own have none.
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

/// A choice that a paper leaves open, with what it may have chosen.
typedef struct {
    const char *name;
    int choices;
    const char *choice[CHOICES_MAX];
} axis_t;

/// A paper, and how it was gone through: each column is another form of what it proposes.
typedef struct {
    const char *name;      ///< on the command line
    const char *reference; ///< where it appeared
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
    double reading;                   ///< accuracy with which the paper's figure can be read
    const char *lacks;                ///< a datum without which nothing can be compared; NULL: none
    double theory;                    ///< of what is printed; NaN: no closed form, or no solution
    const char *formula;              ///< of theory; NULL: none
    double value[COLUMNS_MAX];        ///< computed or measured, with the first seed
    const char *missing[COLUMNS_MAX]; ///< why a value is none
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

/// What a row says of itself.
typedef struct {
    claim_t claim;
    double claimed;
    double reading;
    double theory;
    const char *formula;
    const char *lacks;
} words_t;

/// Nothing of `paper` measured yet.
void table_begin(table_t *self, const paper_t *paper, uint64_t first_seed, int seeds);

row_t *table_row(table_t *self, const char *figure, const char *id, const char *what,
                 const char *unit, const words_t *words);

figure_t *table_figure(table_t *self, const char *figure, const char *title);

words_t table_no_claim(double theory, const char *formula);

/// The variant of these choices, one of each axis.
int table_variant(const paper_t *paper, const int choice[AXES]);

/// And back. Returns how many there are.
int table_choices(const paper_t *paper, int variant, int choice[AXES]);
int table_variants(const paper_t *paper);

#endif
