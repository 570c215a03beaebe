/// What the experiments of paper 2 have in common: running them column by column and filling rows.
#ifndef RIG_REPRODUCE_LI_WORK_H
#define RIG_REPRODUCE_LI_WORK_H

#include "reproduce/li_case.h"
#include "reproduce/li_theory.h"
#include "reproduce/table.h"
#include "support/progress.h"

enum { LI_SPEEDS = 3 };

/// Assumed share of 5th and 7th harmonic in the EMF of each set.
#define LI_HARMONICS 0.06
/// "Nearly 0" and "does not change" are taken as at most this.
#define LI_NEARLY_deg 1.0

extern const char *const li_observers[LI_OBSERVERS]; ///< for people
extern const char *const li_names[LI_OBSERVERS];     ///< in ids
extern const double li_speeds[LI_SPEEDS];            ///< rpm
extern const char li_not_table_II[]; ///< a reason of both Figs. 13, 14 and the sweep

typedef struct {
    const rig_config_t *base;
    table_t *table;
    progress_t progress;
    li_theory_t theory;
    bool failed;
} li_work_t;

/// One experiment, column by column.
typedef struct {
    unsigned columns; ///< a bit for each that was run
    li_result_t column[LI_COLUMNS];
} li_runs_t;

#define LI_ALL_COLUMNS (~0u)
#define LI_ALL_BUT_DEAD_TIME (~(1u << LI_PRINTED_DEAD))
#define LI_THREE_COLUMNS ((1u << LI_PRINTED) | (1u << LI_EXACT) | (1u << LI_CORRECTED))

typedef enum {
    LI_MEAN,
    LI_CHANGE, ///< of the mean since the first stage
    LI_PP,
    LI_SWING,
    LI_SWING_RPM,
    LI_FIFTH,
    LI_SEVENTH,
    LI_XY
} li_quantity_t;

/// Where a row stands.
typedef struct {
    const char *figure, *id, *what, *unit;
} li_place_t;

/// After a failure, of which there was a message, nothing is run any more.
li_result_t li_run(li_work_t *work, const li_case_t *what);
li_runs_t li_run_columns(li_work_t *work, li_case_t what, unsigned columns);
bool li_has(const li_runs_t *runs, int column);

double li_quantity(const li_result_t *result, int stage, li_quantity_t what);

row_t *li_fill(li_work_t *work, const li_place_t *at, const words_t *words, const li_runs_t *runs,
               int stage, li_quantity_t what);

double li_phase_deg(double complex gain);

/// The experiments: Tables I, II and Figs. 10 to 12, with load; harmonics, Figs. 13 to 15, and the
/// sweep of k2; all that changes, Figs. 16 to 18 and eqs. 42, 43, and the xy currents.
void li_steady(li_work_t *work);
void li_harmonics(li_work_t *work);
void li_changes(li_work_t *work);

#endif
