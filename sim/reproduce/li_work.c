#include "reproduce/li_work.h"

#include <math.h>
#include <string.h>

#include "support/units.h"

enum { KNOWN_RUNS = 137 }; // for the progress line

const char *const li_observers[LI_OBSERVERS] = {"C-LESO", "GI-LESO", "FA-LESO"};
const char *const li_names[LI_OBSERVERS] = {"c", "gi", "fa"};
const double li_speeds[LI_SPEEDS] = {300.0, 600.0, 840.0};

li_result_t li_run(li_work_t *work, const li_case_t *what) {
    li_result_t result;
    memset(&result, 0, sizeof result);
    if (!work->failed) {
        progress_show(&work->progress, fmin(0.99, work->table->runs / (double)KNOWN_RUNS),
                      li_observers[what->observer]);
        work->failed = !li_case_run(what, work->base, &result, NULL);
        work->table->runs++;
        work->table->simulated_s += result.simulated_s;
    }
    return result;
}

bool li_has(const li_runs_t *runs, int column) {
    return (runs->columns >> column & 1u) != 0u;
}

li_runs_t li_run_columns(li_work_t *work, li_case_t what, unsigned columns) {
    li_runs_t runs = {.columns = columns};
    for (int c = 0; c < LI_COLUMNS; ++c) {
        what.column = (li_column_t)c;
        if (li_has(&runs, c)) {
            runs.column[c] = li_run(work, &what);
        }
    }
    return runs;
}

double li_quantity(const li_result_t *result, int stage, li_quantity_t what) {
    const li_stage_result_t *s = &result->stage[stage];
    switch (what) {
    case LI_MEAN:
        return s->mean_deg;
    case LI_CHANGE:
        return s->mean_deg - result->stage[0].mean_deg;
    case LI_PP:
        return s->pp_deg;
    case LI_SWING:
        return s->swing_deg;
    case LI_SWING_RPM:
        return s->swing_rpm;
    case LI_FIFTH:
        return s->harmonic_pct[1];
    case LI_SEVENTH:
        return s->harmonic_pct[2];
    case LI_XY:
    default:
        return s->xy_A;
    }
}

row_t *li_fill(li_work_t *work, const li_place_t *at, const words_t *words, const li_runs_t *runs,
               int stage, li_quantity_t what) {
    row_t *row = table_row(work->table, at->figure, at->id, at->what, at->unit, words);
    for (int c = 0; c < LI_COLUMNS; ++c) {
        if (!li_has(runs, c)) {
            continue;
        }
        row->value[c] = li_quantity(&runs->column[c], stage, what);
        row->missing[c] = isnan(runs->column[c].lost_s) ? "stalls" : "lost";
    }
    return row;
}

double li_phase_deg(double complex gain) {
    return rig_deg_from_rad(carg(gain));
}
