#include <math.h>
#include <stdio.h>

#include "reproduce/work.h"
#include "support/units.h"

enum { SPEEDS = 5 };

static const char printed_dc[] = "lag - compensation, with the voltage lost in the inverter";
static const char of_the_lag[] = "lag - compensation";

static const double ends[] = {300.0, 1500.0}; // rpm

// ---- Figs. 12, 13 -------------------------------------------------------------------------------

typedef struct {
    const char *figure;
    case_kind_t kind;
    const double *dc, *pp; ///< claimed at both ends; dc NULL: none
} waves_t;

/// "The position error contains sixth-order fluctuations", more of them at low speed.
static void ripples(work_t *work, const waves_t *of) {
    const words_t six = {.claim = CLAIM_EXACTLY, .claimed = 6.0, .theory = NAN};
    for (int k = 0; k < 2; ++k) {
        const place_t at = {of->figure,
                            "order",
                            "ripples per turn",
                            "",
                            {.kind = of->kind, .speed_rpm = ends[k], .quantity = RIPPLE_ORDER}};
        (void)work_measure(work, &at, &six);
    }
    const words_t more = {.claim = CLAIM_AT_LEAST, .claimed = 1.0, .theory = NAN};
    const place_t at = {of->figure,
                        "pp_over_1500",
                        "pp over that at 1500",
                        "",
                        {.kind = of->kind, .speed_rpm = ends[0], .quantity = PP}};
    const source_t fast = {.kind = of->kind, .speed_rpm = ends[1], .quantity = PP};
    (void)work_measure_pair(work, &at, RATIO, &fast, &more);
}

static void waves(work_t *work, const waves_t *of) {
    const theory_t *t = work->theory;
    const double load_Nm = of->kind == CASE_RATED ? CASE_RATED_Nm : 0.0;
    for (int k = 0; k < 2; ++k) {
        words_t dc = table_no_claim(theory_printed_dc_deg(t, ends[k], load_Nm, false),
                                    of->dc != NULL ? printed_dc : of_the_lag);
        if (of->dc != NULL) {
            dc.claim = CLAIM_ABOUT;
            dc.claimed = of->dc[k];
        }
        const bool around = of->dc != NULL || k == 0; // "larger than that at 1500 rpm"
        const words_t pp = {.claim = around ? CLAIM_ABOUT : CLAIM_AT_MOST,
                            .claimed = of->pp[k],
                            .reading = READING_WHOLE,
                            .theory = NAN};
        const place_t at_dc = {of->figure,
                               "dc",
                               "angle error, mean",
                               "deg",
                               {.kind = of->kind, .speed_rpm = ends[k], .quantity = DC}};
        const place_t at_pp = {of->figure,
                               "pp",
                               "angle error, pp",
                               "deg",
                               {.kind = of->kind, .speed_rpm = ends[k], .quantity = PP}};
        (void)work_measure(work, &at_dc, &dc);
        (void)work_measure(work, &at_pp, &pp);
    }
    ripples(work, of);
}

static void figures_12_13(work_t *work) {
    static const double no_load_pp[] = {2.0, 2.0};
    static const double rated_dc[] = {-5.0, -22.0};
    static const double rated_pp[] = {6.5, 2.0};
    const waves_t fig12 = {"fig12", CASE_NO_LOAD, NULL, no_load_pp};
    const waves_t fig13 = {"fig13", CASE_RATED, rated_dc, rated_pp};
    const theory_t *t = work->theory;
    figure_t *figure = work_figure(work, "fig12", "Fig. 12: QPLL, no load");
    (void)snprintf(figure->note, sizeof figure->note,
                   "Without load and with id* = 0, the current stays in the dead band of a "
                   "non-ideal inverter. The drag of the paper's load machine, which would take the "
                   "current out of the dead band, is not given.");
    waves(work, &fig12);
    figure = work_figure(work, "fig13", "Fig. 13: QPLL, rated load");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "The C-LESO in forward Euler has a lag of 2 arg(rho - 1 + w0 Ts) - w Ts/2: %.2f deg at 300 "
        "rpm, %.2f deg at 1500 rpm.\nThe voltage lost in the inverter, V = %.1f V + %g Ohm I, lies "
        "along the current. It turns the observed EMF\ntowards the estimate: delta = phi + asin(V "
        "sin(phi)/(w psi_a)), with phi = lag - Rs I Ts/(2 psi_a).",
        theory_euler_lag_deg(t, 300.0), theory_euler_lag_deg(t, 1500.0), t->loss_V, t->r_on_Ohm);
    waves(work, &fig13);
}

// ---- Figs. 14, 15 -------------------------------------------------------------------------------

/// The enhanced PLL at 300 rpm with an ideal inverter: how much of a figure is the inverter's.
static void with_ideal(work_t *work, const char *figure, case_kind_t kind) {
    static const quantity_t quantities[] = {DC, PP};
    static const char *const names[] = {"ideal_dc", "ideal_pp"};
    static const char *const texts[] = {"enh., ideal inverter: mean", "enh., ideal inverter: pp"};
    const words_t none = table_no_claim(NAN, NULL);
    for (int k = 0; k < 2; ++k) {
        const place_t at = {figure,
                            names[k],
                            texts[k],
                            "deg",
                            {.kind = kind,
                             .method = METHOD_ENHANCED,
                             .speed_rpm = 300.0,
                             .quantity = quantities[k]}};
        (void)work_measure_ideal(work, &at, &none);
    }
}

static void means(work_t *work, const char *figure, case_kind_t kind) {
    const theory_t *t = work->theory;
    const double load_Nm = kind == CASE_RATED ? CASE_RATED_Nm : 0.0;
    const char *formula = kind == CASE_RATED ? printed_dc : of_the_lag;
    for (int m = 0; m < METHODS; ++m) {
        for (int k = 1; k <= SPEEDS; ++k) {
            const double rpm = CASE_STEP_rpm * k;
            const bool enhanced = m == METHOD_ENHANCED;
            const words_t words = {.claim = enhanced ? CLAIM_AT_MOST : CLAIM_NONE,
                                   .claimed = enhanced ? 2.0 : NAN,
                                   .reading = enhanced ? READING_WHOLE : 0.0,
                                   .theory = theory_printed_dc_deg(t, rpm, load_Nm, enhanced),
                                   .formula = formula};
            const place_t at = {
                figure,
                "dc",
                enhanced ? "enhanced: angle error, mean" : "QPLL: angle error, mean",
                "deg",
                {.kind = kind, .method = (case_method_t)m, .speed_rpm = rpm, .quantity = DC}};
            (void)work_measure(work, &at, &words);
        }
    }
}

/// Section 6: "the fluctuation is reduced to 1 deg", at no speed in particular.
static void fluctuations(work_t *work, const char *figure, case_kind_t kind) {
    const words_t none = table_no_claim(NAN, NULL);
    const words_t words = {
        .claim = CLAIM_AT_MOST, .claimed = 1.0, .reading = READING_WHOLE, .theory = NAN};
    for (int k = 1; k <= SPEEDS; ++k) {
        const double rpm = CASE_STEP_rpm * k;
        place_t at = {figure,
                      "pp",
                      "QPLL: angle error, pp",
                      "deg",
                      {.kind = kind, .speed_rpm = rpm, .quantity = PP}};
        (void)work_measure(work, &at, &none);
        at.text = "enhanced: angle error, pp";
        at.source.method = METHOD_ENHANCED;
        (void)work_measure(work, &at, &words);
    }
}

/// Fig. 15: "fluctuations are significantly smaller than with the conventional method".
static void below_qpll(work_t *work) {
    static const quantity_t quantities[] = {PP, SPEED_PP};
    static const char *const names[] = {"pp_over_qpll", "speed_pp_over_qpll"};
    static const char *const texts[] = {"angle pp, enhanced over QPLL",
                                        "speed error pp, enh. over QPLL"};
    const words_t words = {.claim = CLAIM_AT_MOST, .claimed = 1.0, .theory = NAN};
    for (int q = 0; q < 2; ++q) {
        for (int k = 1; k <= SPEEDS; ++k) {
            const place_t at = {"fig15",
                                names[q],
                                texts[q],
                                "",
                                {.kind = CASE_RATED,
                                 .method = METHOD_ENHANCED,
                                 .speed_rpm = CASE_STEP_rpm * k,
                                 .quantity = quantities[q]}};
            source_t qpll = at.source;
            qpll.method = METHOD_QPLL;
            (void)work_measure_pair(work, &at, RATIO, &qpll, &words);
        }
    }
}

static void figures_14_15(work_t *work) {
    const theory_t *t = work->theory;
    figure_t *figure = work_figure(work, "fig14", "Fig. 14: 300 .. 1500 rpm, no load");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "Theory: eq. 30 minus the lag of the C-LESO in forward Euler, %+.2f deg at 300 rpm and "
        "%+.2f deg at 1500 rpm. Rated load adds\nRs I Ts/(2 psi) = %+.2f deg. In continuous time "
        "the lag is eq. 30.",
        theory_eq30_deg(t, 300.0) - theory_euler_lag_deg(t, 300.0),
        theory_eq30_deg(t, 1500.0) - theory_euler_lag_deg(t, 1500.0),
        rig_deg_from_rad(0.5 * t->Rs * t->ts_s / t->psi * CASE_RATED_Nm / (1.5 * t->np * t->psi)));
    means(work, "fig14", CASE_NO_LOAD);
    fluctuations(work, "fig14", CASE_NO_LOAD);
    with_ideal(work, "fig14", CASE_NO_LOAD);
    (void)work_figure(work, "fig15", "Fig. 15: 300 .. 1500 rpm, rated load");
    means(work, "fig15", CASE_RATED);
    fluctuations(work, "fig15", CASE_RATED);
    with_ideal(work, "fig15", CASE_RATED);
    below_qpll(work);
}

// ---- Eq. 14 -------------------------------------------------------------------------------------

static void equation_14(work_t *work) {
    const words_t words = table_no_claim(NAN, NULL);
    figure_t *figure = work_figure(work, "eq14", "Eq. 14: which speed the QPLL reports");
    (void)snprintf(figure->note, sizeof figure->note,
                   "By eq. 14 the speed is the output of the PI controller: column \"printed\". "
                   "Everywhere else it is the integral part.");
    for (int k = 0; k < 2; ++k) {
        const place_t at = {"eq14",
                            "speed_pp",
                            "QPLL: speed error, pp",
                            "rpm",
                            {.kind = CASE_RATED, .speed_rpm = ends[k], .quantity = SPEED_PP}};
        row_t *row = work_measure(work, &at, &words);
        row->value[COLUMN_PRINTED] = row->value[COLUMN_EQ14];
        row->missing[COLUMN_PRINTED] = row->missing[COLUMN_EQ14];
    }
}

void work_steady(work_t *work) {
    figures_12_13(work);
    figures_14_15(work);
    equation_14(work);
}
