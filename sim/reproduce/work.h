/// Common parts of the experiments of paper 1: running them variant by variant and filling rows.
#ifndef RIG_REPRODUCE_WORK_H
#define RIG_REPRODUCE_WORK_H

#include "reproduce/case.h"
#include "reproduce/rows.h"
#include "reproduce/runs.h"
#include "reproduce/table.h"
#include "reproduce/theory.h"

/// "Almost unchanged" and "nearly the same" are taken as at most this.
#define WORK_NEARLY_deg 1.0
#define WORK_NEARLY_rpm 1.0

/// The columns of the table.
typedef enum {
    COLUMN_PRINTED,
    COLUMN_PRINTED_CORRECTED,
    COLUMN_EXACT,
    COLUMN_CORRECTED,
    COLUMN_LIBRARY,
    COLUMN_EQ14
} column_t;

/// Axes of the variants.
enum { FORMS = 3, FORM_AXIS = 0, INVERTER_AXIS = 1 };

typedef struct {
    const theory_t *theory;
    table_t *table;
    runs_t *runs;
} work_t;

typedef enum {
    DC,
    PP,
    SPEED_PP,
    RAMP_DC,
    SWING,
    STEP,
    STEP_SPEED,
    STEP_ESTIMATE,
    RIPPLE_ORDER,
    STARTED,
    LEVEL_DC,          ///< at a factor of mismatch
    LEVEL_CHANGE,      ///< the same minus that without mismatch
    LEVEL_SPEED_CHANGE ///< of the mean speed error
} quantity_t;

/// The runs of a row, and the quantity taken from them.
typedef struct {
    case_kind_t kind;
    case_method_t method;
    double speed_rpm;
    quantity_t quantity;
    int level;
    double Ld_factor;
} source_t;

/// The place of a row in the paper, and its quantity.
typedef struct {
    const char *figure;
    const char *name; ///< of the quantity, in ids
    const char *text;
    const char *unit;
    source_t source;
} place_t;

/// Combination of two runs to one value.
typedef enum { ALONE, RATIO, DIFFERENCE, SAME_SIGN } pair_t;

row_t *work_measure(work_t *work, const place_t *at, const words_t *words);

/// The same of two runs with the same choices and seed: `at` and `other`.
row_t *work_measure_pair(work_t *work, const place_t *at, pair_t pair, const source_t *other,
                         const words_t *words);

/// The columns with an ideal inverter; no variants.
row_t *work_measure_ideal(work_t *work, const place_t *at, const words_t *words);

/// Columns become the mean over `seeds` runs.
void work_share(row_t *row, work_t *work, const source_t *of, int seeds);

/// One sample for each form: of what is computed, without an inverter or noise.
void work_form_values(row_t *row, const paper_t *paper, const double value[FORMS]);

figure_t *work_figure(work_t *work, const char *figure, const char *title);

/// The experiments.
void work_tables(work_t *work);
void work_steady(work_t *work);
void work_changes(work_t *work);
void work_mismatch(work_t *work);
void work_start(work_t *work);

#endif
