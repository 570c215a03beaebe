#include "reproduce/li_rows.h"
#include "reproduce/li_work.h"

#include <math.h>
#include <stdio.h>

#include "support/units.h"

#define K2_FAST 600.0
#define ID_A 3.0
#define LI_HARDLY_pct 5.0

// ---- Figs. 16, 17 -------------------------------------------------------------------------------

li_case_t li_ramp_case(li_observer_t observer) {
    static const double rpm[] = {300.0, 600.0, 840.0, 600.0, 300.0};
    li_case_t what = {.observer = observer, .stages = 5};
    for (int k = 0; k < what.stages; ++k) {
        what.stage[k] = (li_stage_t){.duration_s = k == 0 ? 3.0 : 2.0, .speed_rpm = rpm[k]};
    }
    return what;
}

static const char slope[] = "the slope of the ramps, J and the PLL with its bandwidth";

static void worst_of_ramps(row_t *row, const li_runs_t *runs, li_quantity_t what) {
    for (int c = 0; c < LI_COLUMNS; ++c) {
        for (int k = 1; k < 5 && li_has(runs, c); ++k) {
            const double now = li_quantity(&runs->column[c], k, what);
            row->value[c] = isnan(now) ? now : fmax(row->value[c], now);
        }
    }
}

static void figure_16(li_work_t *work) {
    figure_t *figure =
        table_figure(work->table, "fig16", "Fig. 16: 300-600-840-600-300 rpm, no load");
    (void)snprintf(figure->note, sizeof figure->note,
                   "Largest of the four ramps. Their slope, 1000 rpm/s, is our choice. The PLL "
                   "knows J and the torque of the measured current, so it can follow a ramp at "
                   "once. The GI-LESO's integrator needs 1/wc = 0.3 s to follow the speed.");
    for (int o = 0; o < LI_OBSERVERS; ++o) {
        const li_runs_t runs =
            li_run_columns(work, li_ramp_case((li_observer_t)o), LI_THREE_COLUMNS);
        char id[48];
        char text[64];
        const words_t angle = {.claim = o == LI_FA ? CLAIM_AT_MOST : CLAIM_NONE,
                               .claimed = o == LI_FA ? 4.5 : NAN,
                               .reading = o == LI_FA ? READING_TENTH : 0.0,
                               .theory = NAN,
                               .lacks = slope};
        const words_t speed = {.claim = CLAIM_AT_MOST,
                               .claimed = 13.0,
                               .reading = READING_WHOLE,
                               .theory = NAN,
                               .lacks = slope};
        (void)snprintf(id, sizeof id, "fig16_%s_swing", li_names[o]);
        (void)snprintf(text, sizeof text, "%s: angle, deviation", li_observers[o]);
        const li_place_t at_angle = {"fig16", id, text, "deg"};
        worst_of_ramps(li_fill(work, &at_angle, &angle, &runs, 1, LI_SWING), &runs, LI_SWING);
        (void)snprintf(id, sizeof id, "fig16_%s_rpm", li_names[o]);
        (void)snprintf(text, sizeof text, "%s: speed error, largest", li_observers[o]);
        const li_place_t at_speed = {"fig16", id, text, "rpm"};
        worst_of_ramps(li_fill(work, &at_speed, &speed, &runs, 1, LI_SWING_RPM), &runs,
                       LI_SWING_RPM);
    }
}

li_case_t li_step_case(li_observer_t observer, double k2_rad_s) {
    return (li_case_t){
        .observer = observer,
        .k2_rad_s = k2_rad_s,
        .stages = 3,
        .stage = {{.duration_s = 3.0, .speed_rpm = 600.0},
                  {.duration_s = 1.5, .speed_rpm = 600.0, .load_Nm = LI_STEP_Nm},
                  {.duration_s = 1.5, .speed_rpm = 600.0}},
    };
}

static const char other_machine[] =
    "J, the rated load and the PLL with its bandwidth: the angle moves with np T/J";

static void step_rows(li_work_t *work, li_observer_t observer, double k2) {
    const li_runs_t runs = li_run_columns(work, li_step_case(observer, k2), LI_ALL_BUT_DEAD_TIME);
    const theory_t *t = &work->theory.plain;
    char name[24];
    char id[48];
    char text[64];
    (void)snprintf(name, sizeof name, k2 > 0.0 ? "%s k2 %.0f" : "%s", li_observers[observer], k2);
    const bool of_paper = k2 <= 0.0;
    const claim_t bound = of_paper ? CLAIM_AT_MOST : CLAIM_NONE;
    const bool claims = of_paper && observer == LI_FA;
    const words_t angle = {.claim = claims ? CLAIM_AT_MOST : CLAIM_NONE,
                           .claimed = claims ? 3.2 : NAN,
                           .reading = claims ? READING_TENTH : 0.0,
                           .theory = observer == LI_C ? theory_swing_deg(t, LI_STEP_Nm, true) : NAN,
                           .formula = "2 exp(-2) d/sigma^2, of the PLL alone",
                           .lacks = other_machine};
    const words_t speed = {.claim = bound,
                           .claimed = of_paper ? 5.0 : NAN,
                           .reading = of_paper ? READING_WHOLE : 0.0,
                           .theory = observer == LI_C ? theory_swing_rpm(t, LI_STEP_Nm, true) : NAN,
                           .formula = "0.840 d/sigma, of the PLL alone",
                           .lacks = other_machine};
    for (int n = 0; n < 2; ++n) {
        const char *when = n == 0 ? "on" : "off";
        (void)snprintf(id, sizeof id, "fig17_%s%s_%s", li_names[observer], k2 > 0.0 ? "_fast" : "",
                       when);
        (void)snprintf(text, sizeof text, "%s: angle, load %s", name, when);
        const li_place_t at = {"fig17", id, text, "deg"};
        (void)li_fill(work, &at, &angle, &runs, 1 + n, LI_SWING);
    }
    (void)snprintf(id, sizeof id, "fig17_%s%s_rpm", li_names[observer], k2 > 0.0 ? "_fast" : "");
    (void)snprintf(text, sizeof text, "%s: speed error, load on", name);
    const li_place_t at = {"fig17", id, text, "rpm"};
    (void)li_fill(work, &at, &speed, &runs, 1, LI_SWING_RPM);
}

/// Where a PLL errs by a d/sigma^2 in angle and b d/sigma in speed: sigma = a/b times speed over angle.
static double sigma_of(const li_work_t *work, double a_over_b) {
    const double speed_rad_s = work->theory.euler.pole_pairs * rig_rad_s_from_rpm(5.0);
    return a_over_b * speed_rad_s / rig_rad_from_deg(3.2);
}

static void figure_17(li_work_t *work) {
    figure_t *figure = table_figure(work->table, "fig17", "Fig. 17: load 0 - 80 % - 0 at 600 rpm");
    const double d = work->theory.euler.pole_pairs * LI_STEP_Nm / work->theory.euler.J_kgm2;
    (void)snprintf(
        figure->note, sizeof figure->note,
        "The load changes within 0.2 ms: d = np T/J = %.0f rad/s^2. After a step of d the error of "
        "the LESO-QPLL is 2 exp(-2) d/sigma^2 in angle and 0.840 d/sigma in speed; that of a QPLL "
        "is d/sigma^2 and 2 d/sigma. The claimed 3.2 deg and 5 rpm together would require sigma = "
        "%.0f rad/s with a LESO-QPLL or %.0f rad/s with a QPLL, whatever d is.",
        d, sigma_of(work, 2.0 * exp(-2.0) / 0.840), sigma_of(work, 0.5));
    for (int o = 0; o < LI_OBSERVERS; ++o) {
        step_rows(work, (li_observer_t)o, 0.0);
    }
    step_rows(work, LI_FA, K2_FAST);
}

// ---- Fig. 18, eqs. 42 and 43 --------------------------------------------------------------------

/// Factors that the drive takes for true one after the other, at 300 rpm.
typedef struct {
    double Rs, Lq;
} factors_t;

static li_case_t mismatch_case(const factors_t *factors, int stages, double load_Nm, double id_A) {
    li_case_t what = {.observer = LI_FA, .stages = stages, .id_A = id_A};
    for (int k = 0; k < what.stages; ++k) {
        what.stage[k] = (li_stage_t){.duration_s = 3.0, // of which the factors move at most 1 s
                                     .speed_rpm = 300.0,
                                     .load_Nm = load_Nm,
                                     .Rs_factor = factors[k].Rs,
                                     .Lq_factor = factors[k].Lq};
    }
    return what;
}

/// "The estimated EMF of the alpha axis hardly changes."
static void emf_row(li_work_t *work, const char *what, double factor, const li_runs_t *runs,
                    int stage) {
    char id[48];
    char text[64];
    const words_t words = {.claim = CLAIM_AT_MOST,
                           .claimed = LI_HARDLY_pct,
                           .theory = NAN,
                           .lacks = "the motor: its Rs I and w Lq I as shares of the EMF"};
    (void)snprintf(id, sizeof id, "fig18_%s_%.0f_emf", what, 100.0 * factor);
    (void)snprintf(text, sizeof text, "%s at %.0f %%: EMF, change", what, 100.0 * factor);
    const li_place_t at = {"fig18", id, text, "%"};
    (void)li_fill(work, &at, &words, runs, stage, LI_EMF_CHANGE);
}

static void Rs_rows(li_work_t *work) {
    static const factors_t factors[] = {{1.0, 1.0}, {0.5, 1.0}, {1.5, 1.0}};
    const li_runs_t runs =
        li_run_columns(work, mismatch_case(factors, 3, LI_RATED_Nm, 0.0), LI_THREE_COLUMNS);
    for (int n = 1; n <= 2; ++n) {
        const char *factor = n == 1 ? "50" : "150";
        char id[48];
        char text[64];
        const words_t words = {.claim = CLAIM_AT_MOST,
                               .claimed = LI_NEARLY_deg,
                               .theory = 0.0,
                               .formula = "eq. 42 at id = 0"};
        (void)snprintf(id, sizeof id, "fig18_Rs_%s", factor);
        (void)snprintf(text, sizeof text, "Rs at %s %%: change of the error", factor);
        const li_place_t at = {"fig18", id, text, "deg"};
        li_sample(work, li_fill(work, &at, &words, &runs, n, LI_CHANGE), &runs, NULL, n, LI_CHANGE,
                  LI_WITH_ID);
    }
    for (int n = 1; n <= 2; ++n) {
        emf_row(work, "Rs", n == 1 ? 0.5 : 1.5, &runs, n);
    }
}

static void Lq_rows(li_work_t *work, double share) {
    static const factors_t factors[] = {{1.0, 1.0}, {1.0, 0.8}, {1.0, 0.5}, {1.0, 1.2}, {1.0, 1.5}};
    const double load_Nm = share * LI_RATED_Nm;
    const li_runs_t runs =
        li_run_columns(work, mismatch_case(factors, 5, load_Nm, 0.0), LI_THREE_COLUMNS);
    for (int n = 1; n < 5; ++n) {
        const double factor = factors[n].Lq;
        char id[48];
        char text[64];
        double pull_out_Nm = 0.0;
        const words_t words =
            table_no_claim(li_theory_Lq_deg(&work->theory, 300.0, load_Nm, factor, &pull_out_Nm),
                           "sin(delta) = (Lq - Lq^) I/psi_a, with the current that the load takes");
        (void)snprintf(id, sizeof id, "fig18_Lq_%.0f_load_%.0f", 100.0 * factor, 100.0 * share);
        (void)snprintf(text, sizeof text, "Lq x%.2f, %.0f %% load: error", factor, 100.0 * share);
        const li_place_t at = {"fig18", id, text, "deg"};
        (void)li_fill(work, &at, &words, &runs, n, LI_MEAN);
        if (share >= 1.0 && fabs(factor - 1.0) > 0.4) {
            emf_row(work, "Lq", factor, &runs, n);
        }
    }
}

static void figure_18(li_work_t *work) {
    figure_t *figure =
        table_figure(work->table, "fig18", "Fig. 18: wrong Rs and Lq, FA-LESO, 300 rpm");
    double pull_out_Nm = 0.0;
    (void)li_theory_Lq_deg(&work->theory, 300.0, LI_RATED_Nm, 1.5, &pull_out_Nm);
    (void)snprintf(figure->note, sizeof figure->note,
                   "Rs: rated load, id* = 0. The paper gives no figures for Lq. \"Does not "
                   "change\" is taken as at most 1 deg. Theory includes the larger current that "
                   "the wrong angle requires. With Lq x1.50 the drive can hold at most %.1f Nm. "
                   "\"Hardly changes\" is taken as at most %g %%.",
                   pull_out_Nm, LI_HARDLY_pct);
    Rs_rows(work);
    Lq_rows(work, 1.0);
    Lq_rows(work, 0.5);
}

/// By the formula from what the exact run knows, beside what came out.
static void formula_row(li_work_t *work, const char *id, const char *text, const li_runs_t *runs,
                        int stage, double dR_Ohm, double dL_H) {
    const li_stage_result_t *seen = &runs->column[LI_EXACT].stage[stage];
    const double w = li_theory_rad_s(&work->theory, seen->speed_rpm);
    const words_t words =
        table_no_claim(li_theory_mismatch_deg(dR_Ohm, dL_H, seen->e_V, seen->id_A, seen->iq_A, w),
                       "eqs. 42, 43 with the estimated amplitude and currents");
    const li_place_t at = {"eq42", id, text, "deg"};
    (void)li_fill(work, &at, &words, runs, stage, LI_MEAN);
}

static void equations_42_43(li_work_t *work) {
    static const factors_t factors[] = {{0.5, 1.0}, {1.5, 1.0}, {1.0, 0.8}, {1.0, 1.2}};
    const euler_config_t *c = &work->theory.euler;
    figure_t *figure =
        table_figure(work->table, "eq42", "Eqs. 42, 43: rated load, 300 rpm, id* = -3 A");
    (void)snprintf(figure->note, sizeof figure->note,
                   "Theory: the formulas, with what the drive of column \"exact\" sees. They hold "
                   "with the ESTIMATED amplitude of the EMF in place of E_ex, and with currents in "
                   "the estimated frame.");
    const li_runs_t runs =
        li_run_columns(work, mismatch_case(factors, 4, LI_RATED_Nm, ID_A), LI_THREE_COLUMNS);
    formula_row(work, "eq42_Rs_50", "eq. 42, Rs x0.50: error", &runs, 0, 0.5 * c->Rs_Ohm, 0.0);
    formula_row(work, "eq42_Rs_150", "eq. 42, Rs x1.50: error", &runs, 1, -0.5 * c->Rs_Ohm, 0.0);
    formula_row(work, "eq43_Lq_80", "eq. 43, Lq x0.80: error", &runs, 2, 0.0, 0.2 * c->Lq_H);
    formula_row(work, "eq43_Lq_120", "eq. 43, Lq x1.20: error", &runs, 3, 0.0, -0.2 * c->Lq_H);
}

// ---- Beyond the paper ---------------------------------------------------------------------------

static void xy_plane(li_work_t *work) {
    figure_t *figure =
        table_figure(work->table, "xy", "xy current, 6 % of 5th and of 7th, 80 % load");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "FA-LESO. Largest |i_xy| at the sampling instants; 3 %% of the rated current is %.2f A.",
        0.03 * LI_RATED_A);
    for (int plain = 1; plain >= 0; --plain) {
        li_case_t what = li_steady_case(LI_FA, 0.8 * LI_RATED_Nm);
        what.harmonics = LI_HARMONICS;
        what.plain_xy = plain == 1;
        const li_runs_t runs = li_run_columns(work, what, LI_THREE_COLUMNS);
        const words_t none = table_no_claim(NAN, NULL);
        for (int k = 0; k < LI_SPEEDS; ++k) {
            char id[48];
            char text[64];
            (void)snprintf(id, sizeof id, "xy_%s_%.0f", plain == 1 ? "pi" : "resonator",
                           li_speeds[k]);
            (void)snprintf(text, sizeof text, "%s, %.0f rpm",
                           plain == 1 ? "PI alone" : "PI and resonators", li_speeds[k]);
            const li_place_t at = {"xy", id, text, "A"};
            (void)li_fill(work, &at, &none, &runs, k, LI_XY);
        }
    }
}

void li_changes(li_work_t *work) {
    figure_16(work);
    figure_17(work);
    figure_18(work);
    equations_42_43(work);
    xy_plane(work);
}
