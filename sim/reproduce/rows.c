#include "reproduce/rows.h"

#include "reproduce/work.h"
#include "support/workers.h"

typedef char case_result_fits[sizeof(case_result_t) <= WORKERS_RESULT_MAX ? 1 : -1];

static const char introduction[] =
    "Jiang et al., Energies 2022, 15, 1943, Section 5, on the simulated machine of its Table 3: 5 "
    "kHz, 200 V, 4 us dead time, the paper's\n"
    "gains, id* = 0. Ours, as the paper does not give it: drops of 1 V + 0.05 Ohm, 12 bit, noise, "
    "ramps.\n"
    "\n"
    "printed      forward Euler; eq. 30 in the enhanced PLL, no compensation in the QPLL; dead "
    "time "
    "not corrected\n"
    "p. corr.     the same with dead-time correction\n"
    "exact        the library's estimator in its place, with exact compensation; not corrected\n"
    "corrected    the same with the EMF of the active flux, and dead-time correction\n"
    "own gains    what the library designs by itself: id bias at low speed, sigma by speed, "
    "supervision of the lock, which in the others\n"
    "             is slowed down until it stays out, as the paper has none\n"
    "theory       of what is printed, in closed form\n"
    "\n"
    "Columns are of the first seed. A claim is judged over what the paper leaves open: the same "
    "equations in forward Euler, in continuous\n"
    "time, or in the library's exact form, its lag compensated where the paper compensates; an "
    "ideal inverter, one that is corrected, one\n"
    "that is not; every seed of noise and angle. \"reproduced\": in all of them; \"contradicted\": "
    "in none; \"depends\": it says on what;\n"
    "\"not comparable\": it says what is missing; \"identity\": a table restated by arithmetic, "
    "not counted. In brackets: held, of how many.\n"
    "\n"
    "Every chain is seeded at the true angle and speed, after a start with an encoder. Angles "
    "electrical, estimate - truth; steady: the\n"
    "last 0.4 s; deviation: largest |error - mean before|. \"lost\": more than 90 deg off; "
    "\"stalls\": the largest current does not hold the\n"
    "speed. \"~\" is met within 30 % or 1.5 units; \"<=\" up to half a unit of the last digit "
    "printed, as the paper reads it off a figure.\n";

static const paper_t reproduction_paper = {
    .name = CASE_PAPER,
    .reference = "Energies 2022, 15, 1943",
    .introduction = introduction,
    .columns = COLUMN_EQ14 + 1,
    .shown = COLUMN_LIBRARY + 1,
    .heading = {"printed", "p. corr.", "exact", "corrected", "own gains"},
    .key =
        {
            [COLUMN_PRINTED] = "as_printed",
            [COLUMN_PRINTED_CORRECTED] = "as_printed_dead_time_corrected",
            [COLUMN_EXACT] = "exact",
            [COLUMN_CORRECTED] = "corrected",
            [COLUMN_LIBRARY] = "own_gains",
            [COLUMN_EQ14] = "as_printed_speed_of_eq14",
        },
    .axis = {{"form", FORMS, {"Euler", "continuous", "exact"}},
             {"inverter", CASE_INVERTERS, {"ideal", "corrected", "uncorrected"}},
             {"", 1, {""}}},
    .bode = {{"Fig. 4", "jiang2022-fig4.svg"},
             {"Fig. 5", "jiang2022-fig5.svg"},
             {"Fig. 8", "jiang2022-fig8.svg"},
             {"Fig. 9", "jiang2022-fig9.svg"}},
    .window_s = CASE_WINDOW_s,
};

static bool same(const void *a, const void *b) {
    return case_same(a, b);
}

static bool run(void *user, const void *what, void *result) {
    return case_run(what, user, result, NULL);
}

static const char *name(const void *what) {
    return case_chain_name(((const case_t *)what)->chain);
}

static void fill(reproduction_t *self, runs_t *runs, const reproduce_extent_t *extent) {
    work_t work = {.theory = &self->theory, .table = &self->table, .runs = runs};
    table_begin(&self->table, &reproduction_paper, extent->first_seed, extent->seeds);
    work_tables(&work);
    work_steady(&work);
    work_changes(&work);
    work_mismatch(&work);
    work_start(&work);
}

bool reproduction_run(reproduction_t *self, const case_bases_t *bases,
                      const reproduce_extent_t *extent) {
    case_bases_t user = *bases;
    runs_t runs = {.what_size = sizeof(case_t),
                   .result_size = sizeof(case_result_t),
                   .same = same,
                   .run = run,
                   .name = name,
                   .user = &user};
    self->theory = theory_of(&bases->paper);
    fill(self, &runs, extent);
    const bool good = runs_make(&runs, extent->processes);
    if (good) {
        fill(self, &runs, extent);
        self->table.runs = (unsigned)runs.count;
        for (int k = 0; k < runs.count; ++k) {
            self->table.simulated_s +=
                ((const case_result_t *)(const void *)runs.result)[k].simulated_s;
        }
    }
    runs_free(&runs);
    return good;
}

bool reproduction_signals(const case_bases_t *bases, const case_t *what, runlog_t *log) {
    case_result_t result;
    return case_run(what, bases, &result, log);
}
