#include "reproduce/li_rows.h"
#include "reproduce/li_work.h"

#include <math.h>
#include <stdio.h>

// ---- Tables -------------------------------------------------------------------------------------

static void table_1(li_work_t *work) {
    const li_theory_t *t = &work->theory;
    figure_t *figure = table_figure(work->table, "table1", "Table I: stability for k1, k2 > 0");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "The roots of eq. 22 for 8 values of k1 (1e-3 to 1e4), 9 of k2 (1 to 1e4, either sign) "
        "and 5 speeds (0 to 1e4 rad/s) lie in the left half-plane exactly where eq. 24 says so. In "
        "forward Euler, "
        "eqs. 27 and 28 are stable only up to the speed in the second row.");
    int wrong = 0;
    for (int n = 0; n < 8 * 9 * 5 * 2; ++n) {
        const double k1 = pow(10.0, n % 8 - 3.0);
        const double k2 = pow(10.0, 0.5 * (n / 8 % 9)) * (n / 360 == 0 ? 1.0 : -1.0);
        const double w = 2500.0 * (n / 72 % 5);
        wrong += (li_theory_slowest(k1, k2, w) < 0.0) != (k2 > 0.0) ? 1 : 0;
    }
    const words_t words = {CLAIM_EXACTLY, 0.0, 0.0, "eq. 24", NULL};
    row_t *row = table_row(work->table, "table1", "table1_routh",
                           "eq. 24: wrong verdicts in 720 cases", "", &words);
    row->value[LI_PRINTED] = wrong;
    row->improvable = false;
    const words_t none = table_no_claim(NAN, NULL);
    row = table_row(work->table, "table1", "table1_euler", "FA-LESO: stable up to", "Hz", &none);
    row->value[LI_PRINTED] = li_theory_euler_limit_Hz(t);
    row->missing[LI_EXACT] = row->missing[LI_UNCOMPENSATED] = "any";
    row->improvable = false;
}

static void table_2(li_work_t *work) {
    const li_theory_t *t = &work->theory;
    static const double claimed[LI_OBSERVERS] = {1.0, 1.0, 1.0}; // eqs. 36, 37, 38
    const double w = li_theory_rad_s(t, 600.0);
    figure_t *figure = table_figure(work->table, "table2", "Table II: transfer functions at 50 Hz");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "From the EMF at t_k to its estimate at t_k. Theory: eqs. 17, 29, 26; printed: the same "
        "in forward Euler at 10 kHz; exact raw: the library's form. Eqs. 36 to 38 claim a gain of"
        " 1 for all three; the C-LESO has %.1f %% less. |G(jw)| in eq. 37 is not infinite but Kr "
        "= 2 w0^2, so the GI-LESO keeps a lag. The sampled FA-LESO is off by half a period, w "
        "Ts/2: ahead in forward Euler, behind in the library's form, which compensates it.",
        100.0 * (1.0 - cabs(li_theory_printed(t, LI_C, w, w))));
    for (int o = 0; o < LI_OBSERVERS; ++o) {
        const li_observer_t observer = (li_observer_t)o;
        char id[48];
        char what[64];
        const words_t gain = {
            CLAIM_FORMULA, claimed[o], cabs(li_theory_printed(t, observer, w, w)), "|H(jw)|",
            "a second-order low-pass loses (w/w0)^2 of its gain, and w/w0 is 0.2 here"};
        (void)snprintf(id, sizeof id, "table2_%s_gain", li_names[o]);
        (void)snprintf(what, sizeof what, "%s: gain", li_observers[o]);
        row_t *row = table_row(work->table, "table2", id, what, "", &gain);
        row->value[LI_PRINTED] = cabs(li_theory_euler(t, observer, w, w));
        row->value[LI_UNCOMPENSATED] = cabs(li_theory_exact(t, observer, w, w));
        row->improvable = false;
        const words_t phase =
            table_no_claim(li_phase_deg(li_theory_printed(t, observer, w, w)), "arg H(jw)");
        (void)snprintf(id, sizeof id, "table2_%s_phase", li_names[o]);
        (void)snprintf(what, sizeof what, "%s: phase", li_observers[o]);
        row = table_row(work->table, "table2", id, what, "deg", &phase);
        row->value[LI_PRINTED] = li_phase_deg(li_theory_euler(t, observer, w, w));
        row->value[LI_UNCOMPENSATED] = li_phase_deg(li_theory_exact(t, observer, w, w));
        row->improvable = false;
    }
}

// ---- Figs. 10 to 12 -----------------------------------------------------------------------------

li_case_t li_steady_case(li_observer_t observer, li_column_t column, double load_Nm) {
    li_case_t what = {.observer = observer, .column = column, .stages = LI_SPEEDS};
    for (int k = 0; k < LI_SPEEDS; ++k) {
        what.stage[k] =
            (li_stage_t){.duration_s = 4.4, .speed_rpm = li_speeds[k], .load_Nm = load_Nm};
    }
    return what;
}

static const char short_of[] =
    "eq. 29 itself gives 3.8, 7.7 and 10.9 deg. What the paper measured beyond that falls with "
    "speed: 3.2, 2.3, 1.1 deg. A further delay would grow with speed; an error of the inverter's "
    "voltage falls, but the paper does not describe its inverter";

static const char euler_leads[] =
    "forward Euler is ahead by half a period, w Ts/2; \"nearly 0\" taken as at most 1 deg is ours";

/// Mean and peak to peak of one observer over the li_speeds, the latter without a claim where NaN.
static void steady_rows(li_work_t *work, const char *figure, li_observer_t observer,
                        const li_runs_t *runs, int k, double claimed_deg, double claimed_pp_deg) {
    const li_theory_t *t = &work->theory;
    char id[48];
    char what[64];
    const double w = li_theory_rad_s(t, li_speeds[k]);
    static const char *const why[LI_OBSERVERS] = {NULL, short_of, euler_leads};
    const claim_t size = observer == LI_FA ? CLAIM_AT_MOST : CLAIM_SIZE;
    const words_t mean = {isnan(claimed_deg) ? CLAIM_NONE : size, claimed_deg,
                          li_phase_deg(li_theory_printed(t, observer, w, w)), "arg H(jw)",
                          why[observer]};
    (void)snprintf(id, sizeof id, "%s_%s_%.0f_mean", figure, li_names[observer], li_speeds[k]);
    (void)snprintf(what, sizeof what, "%s, %.0f rpm: error, mean", li_observers[observer],
                   li_speeds[k]);
    const li_place_t at = {figure, id, what, "deg"};
    (void)li_fill(work, &at, &mean, runs, k, LI_MEAN);
    const words_t pp = {isnan(claimed_pp_deg) ? CLAIM_NONE : CLAIM_AT_MOST, claimed_pp_deg, NAN,
                        NULL, "see the dead time's column"};
    (void)snprintf(id, sizeof id, "%s_%s_%.0f_pp", figure, li_names[observer], li_speeds[k]);
    (void)snprintf(what, sizeof what, "%s, %.0f rpm: error, pp", li_observers[observer],
                   li_speeds[k]);
    li_fill(work, &at, &pp, runs, k, LI_PP)->improvable = false; // noise
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
        runs[o] =
            li_run_columns(work, li_steady_case((li_observer_t)o, LI_PRINTED, 0.0), LI_ALL_COLUMNS);
    }
    for (int k = 0; k < LI_SPEEDS; ++k) {
        const double w = li_theory_rad_s(&work->theory, li_speeds[k]);
        figure_t *figure = table_figure(work->table, ids[k], titles[k]);
        (void)snprintf(
            figure->note, sizeof figure->note,
            "Closed forms sampled at 10 kHz: C-LESO %.2f, GI-LESO %.2f, FA-LESO %+.2f deg in "
            "forward Euler; %.2f, %.2f, %.2f in the library's form before compensation. The sign "
            "in the paper's figures is not known, so sizes are compared. Without load and with "
            "dead time the currents stay near zero, where the voltage of the inverter is known "
            "worst: angle and speed wander, and the correction has little to go by.",
            li_phase_deg(li_theory_euler(&work->theory, LI_C, w, w)),
            li_phase_deg(li_theory_euler(&work->theory, LI_GI, w, w)),
            li_phase_deg(li_theory_euler(&work->theory, LI_FA, w, w)),
            li_phase_deg(li_theory_exact(&work->theory, LI_C, w, w)),
            li_phase_deg(li_theory_exact(&work->theory, LI_GI, w, w)),
            li_phase_deg(li_theory_exact(&work->theory, LI_FA, w, w)));
        for (int o = 0; o < LI_OBSERVERS; ++o) {
            steady_rows(work, ids[k], (li_observer_t)o, &runs[o], k, claimed[o][k],
                        o == LI_FA ? 2.3 : NAN);
        }
    }
}

static void at_load(li_work_t *work) {
    static const double share[] = {0.8, 0.2};
    static const char *const ids[] = {"load80", "load20"};
    static const char *const titles[] = {"80 % load at three speeds", "20 % load"};
    for (int n = 0; n < 2; ++n) {
        figure_t *figure = table_figure(work->table, ids[n], titles[n]);
        (void)snprintf(figure->note, sizeof figure->note, "%s",
                       n == 0 ? "Corrected: as Lxy is only 0.9 mH, the switching ripple of the "
                                "phase currents is of "
                                "the size of the 1.9 A that they carry. Near their zeros the dead "
                                "time then meets a "
                                "current of another sign than the mean, and the correction leaves "
                                "up to 0.7 deg; with "
                                "3.2 mH in motor and plant it leaves 0.13. The paper could not "
                                "load the C-LESO by half "
                                "at 50 Hz with set 1 alone (Section V.B); this machine carries 80 "
                                "% with both sets."
                              : "The switching ripple of the phase currents exceeds what they "
                                "carry: see 80 % load.");
        for (int o = n == 0 ? 0 : LI_FA; o < LI_OBSERVERS; ++o) {
            const li_runs_t runs = li_run_columns(
                work, li_steady_case((li_observer_t)o, LI_PRINTED, share[n] * LI_RATED_Nm),
                n == 0 ? LI_ALL_COLUMNS : LI_THREE_COLUMNS);
            for (int k = 0; k < LI_SPEEDS; ++k) {
                steady_rows(work, ids[n], (li_observer_t)o, &runs, k, NAN, NAN);
            }
        }
    }
}

void li_steady(li_work_t *work) {
    table_1(work);
    table_2(work);
    figures_10_12(work);
    at_load(work);
}
