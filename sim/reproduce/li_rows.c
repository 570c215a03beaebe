#include "reproduce/li_rows.h"

#include "reproduce/li_work.h"
#include "support/workers.h"

typedef char li_result_fits[sizeof(li_result_t) <= WORKERS_RESULT_MAX ? 1 : -1];

// ---- The paper ----------------------------------------------------------------------------------

static const char introduction[] =
    "Li, Hu, Ma, Liu: FA-LESO for a dual three-phase IPMSM, Sections III and V.\n"
    "\n"
    "THE PAPER'S MOTOR TABLE IS NOT AVAILABLE: THE MACHINE IS A STAND-IN with the windings of "
    "Eldeeb et al., IEEE PEDS 2017 (R 0.8 Ohm,\n"
    "Ld 6.4 mH, Lq 17.4 mH, Lxy 0.9 mH, psi 0.1746 Vs, 5 pole pairs). Ours: J = 0.01 kgm2, 300 V, "
    "10 kHz, rated load 6.25 Nm (2.4 A),\n"
    "and sigma = 150 rad/s for the PLL, which the paper does not give. Observers with the "
    "gains of Table II, as those of the\n"
    "experiments are not available either; current and speed control of the library, "
    "with the xy currents controlled to zero.\n"
    "In Figs. 13 to 15, xy and k2 the EMF of each set has 6 % of 5th and 7th harmonic.\n"
    "\n"
    "printed      the paper's equations in forward Euler, lag not compensated; ideal inverter\n"
    "dead time    the same with 2 us of dead time, not corrected\n"
    "exact raw    observer and PLL of the library, lag not compensated; ideal inverter\n"
    "exact        the same with the lag compensated\n"
    "corrected    the same with 2 us of dead time, corrected\n"
    "theory       closed form of what the paper prints\n"
    "\n"
    "Columns are of the first seed, with a LESO-QPLL and id* = 0; files have \"printed\" with a "
    "QPLL too.\n"
    "A claim is judged over what the paper leaves open: the same equations in forward Euler, in "
    "continuous time, or in the library's exact\n"
    "form, never compensated; an ideal inverter, one that is corrected, one that is not; LESO-QPLL "
    "or QPLL, as the paper names none; in\n"
    "Figs. 10 to 12, where the paper weakens the field, also id* = -2.4 A; every seed of noise and "
    "angle. \"reproduced\": in all of them;\n"
    "\"contradicted\": in none; \"depends\": it says on what; \"not comparable\": it says what is "
    "missing; \"identity\": a table restated by\n"
    "arithmetic, not counted. In brackets: held, of how many.\n"
    "\n"
    "The drive starts with an encoder; then the estimator takes over at the true angle and speed. "
    "Angles are electrical, estimate minus\n"
    "truth. Mean and pp (peak to peak): of the last second. Deviation, and angle in load steps: "
    "the "
    "largest distance from the mean before.\n"
    "\"lost\": more than 90 deg off; \"stalls\": the speed is not held. An ideal inverter gives "
    "exactly the mean voltage asked for. \"~\" is met\n"
    "within 30 % or 1.5 units; \"<=\" up to half a unit of the last digit printed, as the paper "
    "reads "
    "it off a figure.\n";

static const paper_t paper = {
    .name = LI_PAPER,
    .reference = "Li, Hu, Ma, Liu: Sensorless Control of Dual Three-Phase IPMSM Based on Frequency "
                 "Adaptive Linear Extended State Observer",
    .introduction = introduction,
    .columns = LI_COLUMNS,
    .shown = LI_CORRECTED + 1,
    .heading = {"printed", "dead time", "exact raw", "exact", "corrected"},
    .key = {"as_printed", "as_printed_dead_time", "exact_uncompensated", "exact", "corrected",
            "as_printed_qpll"},
    .axis = {{"form", LI_FORMS, {"Euler", "continuous", "exact"}},
             {"inverter", CASE_INVERTERS, {"ideal", "corrected", "uncorrected"}},
             {"PLL", LI_PLL_CHOICES, {"LESO-QPLL", "QPLL", "LESO-QPLL with id*"}}},
    .bode = {{"Fig. 1", "li-fig1.svg"}, {"Fig. 2", "li-fig2.svg"}, {"Fig. 4", "li-fig4.svg"}},
    .window_s = LI_WINDOW_s,
};

static bool same(const void *a, const void *b) {
    return li_case_same(a, b);
}

static bool run(void *user, const void *what, void *result) {
    return li_case_run(what, user, result, NULL);
}

static const char *name(const void *what) {
    return li_observers[((const li_case_t *)what)->observer];
}

static void fill(table_t *table, const rig_config_t *base, runs_t *runs,
                 const reproduce_extent_t *extent) {
    static li_work_t work;
    work = (li_work_t){.base = base, .table = table, .runs = runs, .theory = li_theory_of(base)};
    table_begin(table, &paper, extent->first_seed, extent->seeds);
    li_tables(&work);
    li_steady(&work);
    li_harmonics(&work);
    li_changes(&work);
}

bool li_reproduction_run(table_t *table, const rig_config_t *base,
                         const reproduce_extent_t *extent) {
    static rig_config_t user;
    runs_t runs = {.what_size = sizeof(li_case_t),
                   .result_size = sizeof(li_result_t),
                   .same = same,
                   .run = run,
                   .name = name,
                   .user = &user};
    user = *base;
    fill(table, base, &runs, extent);
    const bool good = runs_make(&runs, extent->processes);
    if (good) {
        fill(table, base, &runs, extent);
        table->runs = (unsigned)runs.count;
        for (int k = 0; k < runs.count; ++k) {
            table->simulated_s += ((const li_result_t *)(const void *)runs.result)[k].simulated_s;
        }
    }
    runs_free(&runs);
    return good;
}
