#include "reproduce/work.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct {
    case_chain_t chain;
    case_inverter_t inverter;
} setting_t;

static const setting_t columns[COLUMNS_MAX] = {
    [COLUMN_PRINTED] = {CHAIN_PRINTED, CASE_BARE},
    [COLUMN_PRINTED_CORRECTED] = {CHAIN_PRINTED, CASE_COMPENSATED},
    [COLUMN_EXACT] = {CHAIN_EXACT, CASE_BARE},
    [COLUMN_CORRECTED] = {CHAIN_CORRECTED, CASE_COMPENSATED},
    [COLUMN_LIBRARY] = {CHAIN_LIBRARY, CASE_COMPENSATED},
    [COLUMN_EQ14] = {CHAIN_EQ14, CASE_BARE},
};

static double quantity(const case_result_t *result, const source_t *of) {
    switch (of->quantity) {
    case DC:
        return result->dc_deg;
    case PP:
        return result->pp_deg;
    case SPEED_PP:
        return result->speed_error_pp_rpm;
    case RAMP_DC:
        return result->ramp_dc_deg;
    case SWING:
        return result->swing_deg;
    case STEP:
        return result->step_deg;
    case STEP_SPEED:
        return result->step_speed_rpm;
    case STEP_ESTIMATE:
        return result->step_estimate_rpm;
    case RIPPLE_ORDER:
        return result->ripple_order;
    case STARTED:
        return 100.0 * result->started;
    case LEVEL_DC:
        return result->level_dc_deg[of->level];
    case LEVEL_SPEED_CHANGE:
        return result->level_speed_rpm[of->level] - result->level_speed_rpm[0];
    case LEVEL_CHANGE:
    default:
        return result->level_dc_deg[of->level] - result->level_dc_deg[0];
    }
}

static const case_result_t *result_of(work_t *work, const source_t *of, const setting_t *setting,
                                      uint64_t seed) {
    case_t what = {.kind = of->kind,
                   .method = of->method,
                   .chain = setting->chain,
                   .inverter = setting->inverter,
                   .speed_rpm = of->speed_rpm,
                   .Ld_factor = of->Ld_factor,
                   .seed = seed};
    if (what.chain == CHAIN_SAMPLED && what.method == METHOD_ENHANCED) {
        what.chain = CHAIN_EXACT; // the same
    }
    return runs_result(work->runs, &what);
}

static double combine(pair_t pair, double a, double b) {
    switch (pair) {
    case RATIO:
        return a / b;
    case DIFFERENCE:
        return a - b;
    case SAME_SIGN:
        return isnan(a * b) ? NAN : (a * b > 0.0 ? 1.0 : -1.0);
    case ALONE:
    default:
        return a;
    }
}

static double value_of(work_t *work, const source_t *of, pair_t pair, const source_t *other,
                       const setting_t *setting, uint64_t seed) {
    const double a = quantity(result_of(work, of, setting, seed), of);
    if (pair == ALONE || other == NULL) {
        return a;
    }
    return combine(pair, a, quantity(result_of(work, other, setting, seed), other));
}

static void sample(work_t *work, row_t *row, const source_t *of, pair_t pair,
                   const source_t *other) {
    static const case_chain_t forms[FORMS] = {CHAIN_PRINTED, CHAIN_CONTINUOUS, CHAIN_SAMPLED};
    const paper_t *paper = work->table->paper;
    row->seeds = work->table->seeds;
    for (int v = 0; v < table_variants(paper); ++v) {
        int choice[AXES];
        (void)table_choices(paper, v, choice);
        const setting_t setting = {forms[choice[FORM_AXIS]],
                                   (case_inverter_t)choice[INVERTER_AXIS]};
        row->ran[v] = true;
        for (int s = 0; s < row->seeds; ++s) {
            row->sample[v][s] =
                value_of(work, of, pair, other, &setting, work->table->first_seed + (uint64_t)s);
        }
    }
}

static row_t *begin(work_t *work, const place_t *at, const words_t *words) {
    static const char *const methods[METHODS] = {"qpll", "enhanced"};
    char id[48];
    char what[64];
    const source_t *of = &at->source;
    const bool staircase = of->kind == CASE_STAIRCASE || of->kind == CASE_STAIRCASE_RATED;
    (void)snprintf(id, sizeof id, "%s_%s_%.0f_%s", at->figure, methods[of->method], of->speed_rpm,
                   at->name);
    (void)snprintf(what, sizeof what, "%s%.0f rpm, %s", staircase ? "from " : "", of->speed_rpm,
                   at->text);
    return table_row(work->table, at->figure, id, what, at->unit, words);
}

static void show(work_t *work, row_t *row, int column, const setting_t *setting, const source_t *of,
                 pair_t pair, const source_t *other) {
    const uint64_t seed = work->table->first_seed;
    row->value[column] = value_of(work, of, pair, other, setting, seed);
    row->missing[column] = isnan(result_of(work, of, setting, seed)->lost_s) ? "stalls" : "lost";
}

row_t *work_measure_pair(work_t *work, const place_t *at, pair_t pair, const source_t *other,
                         const words_t *words) {
    row_t *row = begin(work, at, words);
    for (int c = 0; c < work->table->paper->columns; ++c) {
        if (c != COLUMN_EQ14 || strcmp(at->figure, "eq14") == 0) {
            show(work, row, c, &columns[c], &at->source, pair, other);
        }
    }
    if (words->claim != CLAIM_NONE && words->lacks == NULL) {
        sample(work, row, &at->source, pair, other);
    }
    return row;
}

row_t *work_measure_ideal(work_t *work, const place_t *at, const words_t *words) {
    row_t *row = begin(work, at, words);
    for (int c = 0; c < COLUMN_EQ14; ++c) {
        if (c != COLUMN_PRINTED_CORRECTED) { // there is nothing to correct
            const setting_t ideal = {columns[c].chain, CASE_IDEAL};
            show(work, row, c, &ideal, &at->source, ALONE, NULL);
        }
    }
    return row;
}

void work_share(row_t *row, work_t *work, const source_t *of, int seeds) {
    for (int c = 0; c < COLUMN_EQ14; ++c) {
        double sum = 0.0;
        for (int s = 0; s < seeds; ++s) {
            sum +=
                value_of(work, of, ALONE, NULL, &columns[c], work->table->first_seed + (uint64_t)s);
        }
        row->value[c] = sum / seeds;
    }
}

row_t *work_measure(work_t *work, const place_t *at, const words_t *words) {
    return work_measure_pair(work, at, ALONE, NULL, words);
}

void work_form_values(row_t *row, const paper_t *paper, const double value[FORMS]) {
    row->seeds = 1;
    for (int form = 0; form < FORMS; ++form) {
        const int variant = table_variant(paper, (const int[AXES]){form, 0, 0});
        row->ran[variant] = true;
        row->sample[variant][0] = value[form];
    }
}

figure_t *work_figure(work_t *work, const char *figure, const char *title) {
    return table_figure(work->table, figure, title);
}
