#include "reproduce/li_work.h"

#include <math.h>
#include <string.h>

#include "support/units.h"

const char *const li_observers[LI_OBSERVERS] = {"C-LESO", "GI-LESO", "FA-LESO"};
const char *const li_names[LI_OBSERVERS] = {"c", "gi", "fa"};
const double li_speeds[LI_SPEEDS] = {300.0, 600.0, 840.0};

li_result_t li_run(li_work_t *work, const li_case_t *what) {
    li_case_t seeded = *what;
    seeded.seed = work->table->first_seed;
    li_result_t result;
    memcpy(&result, runs_result(work->runs, &seeded), sizeof result);
    return result;
}

bool li_has(const li_runs_t *runs, int column) {
    return (runs->columns >> column & 1u) != 0u;
}

li_runs_t li_run_columns(li_work_t *work, li_case_t what, unsigned columns) {
    li_runs_t runs = {.what = what, .columns = columns};
    for (int c = 0; c < LI_COLUMNS; ++c) {
        what = li_case_in(what, (li_column_t)c);
        if (li_has(&runs, c)) {
            runs.column[c] = li_run(work, &what);
        }
    }
    return runs;
}

static li_case_t variant(const li_work_t *work, const li_case_t *what, const int choice[AXES],
                         int seed) {
    li_case_t out = *what;
    out.form = (li_form_t)choice[LI_FORM_AXIS];
    out.compensated = false;
    out.inverter = (case_inverter_t)choice[LI_INVERTER_AXIS];
    out.qpll = choice[LI_PLL_AXIS] == LI_WITH_QPLL;
    out.id_A = choice[LI_PLL_AXIS] == LI_WITH_ID ? LI_WEAKENING_A : what->id_A;
    out.seed = work->table->first_seed + (uint64_t)seed;
    return out;
}

static double sample_of(li_work_t *work, const li_case_t *what, int stage, li_quantity_t quantity) {
    return li_quantity(runs_result(work->runs, what), stage, quantity);
}

void li_sample(li_work_t *work, row_t *row, const li_runs_t *runs, const li_runs_t *over, int stage,
               li_quantity_t what, int choices) {
    const paper_t *paper = work->table->paper;
    row->seeds = work->table->seeds;
    for (int v = 0; v < table_variants(paper); ++v) {
        int choice[AXES];
        (void)table_choices(paper, v, choice);
        row->ran[v] = choice[LI_PLL_AXIS] < choices;
        for (int s = 0; s < row->seeds && row->ran[v]; ++s) {
            const li_case_t one = variant(work, &runs->what, choice, s);
            row->sample[v][s] = sample_of(work, &one, stage, what);
            if (over != NULL) {
                const li_case_t base = variant(work, &over->what, choice, s);
                row->sample[v][s] *= 100.0 / sample_of(work, &base, stage, what);
            }
        }
    }
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
    case LI_ELEVENTH:
        return s->harmonic_pct[3];
    case LI_THIRTEENTH:
        return s->harmonic_pct[4];
    case LI_EMF_CHANGE:
        return 100.0 * (s->e_V / result->stage[0].e_V - 1.0);
    case LI_HELD:
        return isnan(s->mean_deg) ? 0.0 : 1.0;
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
