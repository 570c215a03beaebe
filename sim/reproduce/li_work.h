/// Common parts of the experiments of paper 2: running them column by column and filling rows.
#ifndef RIG_REPRODUCE_LI_WORK_H
#define RIG_REPRODUCE_LI_WORK_H

#include "reproduce/li_case.h"
#include "reproduce/li_theory.h"
#include "reproduce/runs.h"
#include "reproduce/table.h"

enum { LI_SPEEDS = 3 };

/// Length of a stage: its change settles, then LI_WINDOW_s follow. The GI-LESO needs 1 to 3 s.
#define LI_SETTLES_s 2.6
#define LI_SETTLES_GI_s 4.4

/// Assumed share of 5th and 7th harmonic in the EMF of each set.
#define LI_HARMONICS 0.06
/// "Nearly 0" and "does not change" are taken as at most this.
#define LI_NEARLY_deg 1.0

extern const char *const li_observers[LI_OBSERVERS]; ///< for texts
extern const char *const li_names[LI_OBSERVERS];     ///< in ids
extern const double li_speeds[LI_SPEEDS];            ///< rpm

/// Axes of the variants. The third covers PLL and d current, which the paper does not give.
enum { LI_FORM_AXIS, LI_INVERTER_AXIS, LI_PLL_AXIS };
enum { LI_WITH_LESO_QPLL, LI_WITH_QPLL, LI_WITH_ID, LI_PLL_CHOICES };

/// The paper weakens the field in Figs. 10 to 12, by a current that it does not give: this one, or none.
#define LI_WEAKENING_A LI_RATED_A

typedef struct {
    const rig_config_t *base;
    table_t *table;
    runs_t *runs;
    li_theory_t theory;
} li_work_t;

/// One experiment, column by column, with the first seed.
typedef struct {
    li_case_t what;
    unsigned columns; ///< a bit for each that was run
    li_result_t column[LI_COLUMNS];
} li_runs_t;

#define LI_ALL_COLUMNS (~0u)
#define LI_ALL_BUT_DEAD_TIME (~(1u << LI_PRINTED_DEAD))
#define LI_THREE_COLUMNS                                                                           \
    ((1u << LI_PRINTED) | (1u << LI_PRINTED_QPLL) | (1u << LI_EXACT) | (1u << LI_CORRECTED))

typedef enum {
    LI_MEAN,
    LI_CHANGE, ///< of the mean since the first stage
    LI_PP,
    LI_SWING,
    LI_SWING_RPM,
    LI_FIFTH,
    LI_SEVENTH,
    LI_ELEVENTH,
    LI_THIRTEENTH,
    LI_EMF_CHANGE, ///< of the amplitude since the first stage, %
    LI_HELD,       ///< 1: the stage was completed, 0: it was not
    LI_XY
} li_quantity_t;

/// The place of a row.
typedef struct {
    const char *figure, *id, *what, *unit;
} li_place_t;

li_result_t li_run(li_work_t *work, const li_case_t *what);
li_runs_t li_run_columns(li_work_t *work, li_case_t what, unsigned columns);
bool li_has(const li_runs_t *runs, int column);

double li_quantity(const li_result_t *result, int stage, li_quantity_t what);

/// Without variants.
row_t *li_fill(li_work_t *work, const li_place_t *at, const words_t *words, const li_runs_t *runs,
               int stage, li_quantity_t what);

/// Runs `runs` in all variants for a claim on one stage; with `over`, as a percentage of the same value of `over`.
/// `choices`: how many of LI_PLL_CHOICES.
void li_sample(li_work_t *work, row_t *row, const li_runs_t *runs, const li_runs_t *over, int stage,
               li_quantity_t what, int choices);

double li_phase_deg(double complex gain);

/// The experiments: Tables I, II and Figs. 10 to 12, with load; harmonics, Figs. 13 to 15, and the
/// sweep of k2; all that changes, Figs. 16 to 18 and eqs. 42, 43, and the xy currents.
void li_tables(li_work_t *work);
void li_steady(li_work_t *work);
void li_harmonics(li_work_t *work);
void li_changes(li_work_t *work);

#endif
