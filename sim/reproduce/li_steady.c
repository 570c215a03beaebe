#include "reproduce/li_rows.h"
#include "reproduce/li_work.h"

#include <math.h>
#include <stdio.h>

// ---- Figs. 10 to 12 -----------------------------------------------------------------------------

li_case_t li_steady_case(li_observer_t observer, double load_Nm) {
    li_case_t what = {.observer = observer, .stages = LI_SPEEDS};
    for (int k = 0; k < LI_SPEEDS; ++k) {
        what.stage[k] =
            (li_stage_t){.duration_s = observer == LI_GI ? LI_SETTLES_GI_s : LI_SETTLES_s,
                         .speed_rpm = li_speeds[k],
                         .load_Nm = load_Nm};
    }
    return what;
}

/// Where the claims of Figs. 10 to 12 stand, of one observer; claimed_deg NaN: none.
typedef struct {
    const char *figure;
    double claimed_deg, claimed_pp_deg;
} steady_t;

/// Mean and peak to peak of one observer at one of the li_speeds.
static void steady_rows(li_work_t *work, const steady_t *at_speed, const li_runs_t *runs, int k) {
    const li_theory_t *t = &work->theory;
    const li_observer_t observer = runs->what.observer;
    const double w = li_theory_rad_s(t, li_speeds[k]);
    const bool claims = !isnan(at_speed->claimed_deg);
    const bool claims_pp = !isnan(at_speed->claimed_pp_deg);
    char id[48];
    char what[64];
    const li_place_t at = {at_speed->figure, id, what, "deg"};
    const claim_t size = observer == LI_FA ? CLAIM_AT_MOST : CLAIM_SIZE;
    const words_t mean = {.claim = claims ? size : CLAIM_NONE,
                          .claimed = at_speed->claimed_deg,
                          .theory = li_phase_deg(li_theory_printed(t, observer, w, w)),
                          .formula = "arg H(jw)"};
    (void)snprintf(id, sizeof id, "%s_%s_%.0f_mean", at_speed->figure, li_names[observer],
                   li_speeds[k]);
    (void)snprintf(what, sizeof what, "%s, %.0f rpm: error, mean", li_observers[observer],
                   li_speeds[k]);
    row_t *row = li_fill(work, &at, &mean, runs, k, LI_MEAN);
    if (claims) {
        li_sample(work, row, runs, NULL, k, LI_MEAN, LI_PLL_CHOICES);
    }
    const words_t pp = {.claim = claims_pp ? CLAIM_AT_MOST : CLAIM_NONE,
                        .claimed = at_speed->claimed_pp_deg,
                        .reading = claims_pp ? READING_TENTH : 0.0,
                        .theory = NAN};
    (void)snprintf(id, sizeof id, "%s_%s_%.0f_pp", at_speed->figure, li_names[observer],
                   li_speeds[k]);
    (void)snprintf(what, sizeof what, "%s, %.0f rpm: error, pp", li_observers[observer],
                   li_speeds[k]);
    row = li_fill(work, &at, &pp, runs, k, LI_PP);
    if (claims_pp) {
        li_sample(work, row, runs, NULL, k, LI_PP, LI_PLL_CHOICES);
    }
}

static void figures_10_12(li_work_t *work) {
    static const double claimed[LI_OBSERVERS][LI_SPEEDS] = {
        {14.0, 23.0, 34.0}, {7.0, 10.0, 12.0}, {LI_NEARLY_deg, LI_NEARLY_deg, LI_NEARLY_deg}};
    static const char *const ids[LI_SPEEDS] = {"fig10", "fig11", "fig12"};
    static const char *const titles[LI_SPEEDS] = {"Fig. 10: no load, 300 rpm (25 Hz)",
                                                  "Fig. 11: no load, 600 rpm (50 Hz)",
                                                  "Fig. 12: no load, 840 rpm (70 Hz)"};
    static li_runs_t runs[LI_OBSERVERS];
    for (int o = 0; o < LI_OBSERVERS; ++o) {
        runs[o] = li_run_columns(work, li_steady_case((li_observer_t)o, 0.0), LI_ALL_COLUMNS);
    }
    for (int k = 0; k < LI_SPEEDS; ++k) {
        const double w = li_theory_rad_s(&work->theory, li_speeds[k]);
        figure_t *figure = table_figure(work->table, ids[k], titles[k]);
        (void)snprintf(
            figure->note, sizeof figure->note,
            "Closed forms sampled at 10 kHz: C-LESO %.2f, GI-LESO %.2f, FA-LESO %+.2f deg in "
            "forward Euler; %.2f, %.2f, %.2f deg in the library's form before compensation. The "
            "sign in the paper's figures is not known, so sizes are compared. \"Nearly 0\" is "
            "taken as at most 1 deg. The paper weakens the field here with a current that it does "
            "not give; id* = -2.4 A is one of the variants.",
            li_phase_deg(li_theory_euler(&work->theory, LI_C, w, w)),
            li_phase_deg(li_theory_euler(&work->theory, LI_GI, w, w)),
            li_phase_deg(li_theory_euler(&work->theory, LI_FA, w, w)),
            li_phase_deg(li_theory_exact(&work->theory, LI_C, w, w)),
            li_phase_deg(li_theory_exact(&work->theory, LI_GI, w, w)),
            li_phase_deg(li_theory_exact(&work->theory, LI_FA, w, w)));
        for (int o = 0; o < LI_OBSERVERS; ++o) {
            const steady_t at = {ids[k], claimed[o][k], o == LI_FA ? 2.3 : NAN};
            steady_rows(work, &at, &runs[o], k);
        }
    }
}

static void at_load(li_work_t *work) {
    static const double share[] = {0.8, 0.2};
    static const char *const ids[] = {"load80", "load20"};
    static const char *const titles[] = {"80 % load at three speeds", "20 % load"};
    for (int n = 0; n < 2; ++n) {
        figure_t *figure = table_figure(work->table, ids[n], titles[n]);
        (void)snprintf(
            figure->note, sizeof figure->note,
            "No claim. Column \"corrected\": Lxy is small, so a phase current swings widely "
            "between its samples. Near the zeros of the phase current (%.1f A here) the dead time "
            "then acts on a sign that is not that of the mean current.",
            share[n] * LI_RATED_A);
        for (int o = n == 0 ? 0 : LI_FA; o < LI_OBSERVERS; ++o) {
            const li_runs_t runs =
                li_run_columns(work, li_steady_case((li_observer_t)o, share[n] * LI_RATED_Nm),
                               n == 0 ? LI_ALL_COLUMNS : LI_THREE_COLUMNS);
            for (int k = 0; k < LI_SPEEDS; ++k) {
                const steady_t at = {ids[n], NAN, NAN};
                steady_rows(work, &at, &runs, k);
            }
        }
    }
}

void li_steady(li_work_t *work) {
    figures_10_12(work);
    at_load(work);
}
