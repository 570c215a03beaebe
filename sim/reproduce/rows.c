#include "reproduce/rows.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "reproduce/tables.h"
#include "support/progress.h"
#include "support/units.h"

enum { SPEEDS = 5, KNOWN_RUNS = 173 };

// ---- The paper ------------------------------------------------------------------------------------

static const char introduction[] =
    "Jiang et al., Energies 2022, 15, 1943, Section 5, on the simulated machine of its Table 3: 5 "
    "kHz, "
    "200 V, 4 us dead\ntime, the paper's gains, id* = 0. Ours, as the paper does not give it: "
    "drops of "
    "1 V + 0.05 Ohm, 12 bit, noise, ramps.\n\n"
    "as printed   forward Euler; eq. 30 in the enhanced PLL, no compensation in the QPLL; no "
    "dead-time "
    "correction\n"
    "exact        the library's estimator in its place, with exact compensation\n"
    "corrected    the same with the EMF of the active flux, and dead-time correction\n"
    "own gains    what the library designs by itself: id bias at low speed, sigma by speed, "
    "supervision\n"
    "             of the lock, which in the others is slowed down until it stays out, as the paper "
    "has none\n"
    "theory       of what is printed, in closed form\n\n"
    "Every chain is seeded at the true angle and speed at t = 0 of its experiment, after a start "
    "with "
    "an encoder. Angles\nelectrical, estimate - truth; steady: the last 0.4 s; deviation: largest "
    "|error - mean before|. \"lost\": more than 90 deg\noff; \"stalls\": the largest current does "
    "not "
    "hold the speed. A claim \"~\" is met within 30 % or 1.5 units.\n";

static const paper_t reproduction_paper = {
    .name = CASE_PAPER,
    .reference = "Energies 2022, 15, 1943",
    .introduction = introduction,
    .columns = CHAINS,
    .shown = CHAIN_LIBRARY + 1,
    .heading = {"as printed", "exact", "corrected", "own gains"},
    .key =
        {
            [CHAIN_PRINTED] = "as_printed",
            [CHAIN_EXACT] = "exact",
            [CHAIN_CORRECTED] = "corrected",
            [CHAIN_LIBRARY] = "own_gains",
            [CHAIN_PRINTED_CORRECTED] = "as_printed_dead_time_corrected",
            [CHAIN_EQ14] = "as_printed_speed_of_eq14",
        },
    .judged = CHAIN_PRINTED,
    .best = CHAIN_CORRECTED,
    .window_s = CASE_WINDOW_s,
};

// ---- Runs, each made once -----------------------------------------------------------------------

typedef struct {
    const case_bases_t *bases;
    reproduction_t *out;
    progress_t progress;
    bool failed;
    bool done[CASE_KINDS][METHODS][SPEEDS][CHAINS];
    case_result_t result[CASE_KINDS][METHODS][SPEEDS][CHAINS];
} work_t;

static const case_result_t *result_of(work_t *work, const case_t *what) {
    const int speed = (int)lround(what->speed_rpm / CASE_STEP_rpm) - 1;
    bool *done = &work->done[what->kind][what->method][speed][what->chain];
    case_result_t *result = &work->result[what->kind][what->method][speed][what->chain];
    if (!*done && !work->failed) {
        progress_show(&work->progress, fmin(0.99, work->out->table.runs / (double)KNOWN_RUNS),
                      case_chain_name(what->chain));
        work->failed = !case_run(what, work->bases, result, NULL);
        work->out->table.runs++;
        work->out->table.simulated_s += result->simulated_s;
        *done = true;
    }
    return result;
}

// ---- What is measured ---------------------------------------------------------------------------

typedef enum {
    DC,
    PP,
    SPEED_PP,
    RAMP_DC,
    SWING,
    STEP,
    STEP_SPEED,
    STEP_ESTIMATE,
    LEVEL_DC,    ///< at a factor of mismatch
    LEVEL_CHANGE ///< the same less that without mismatch
} quantity_t;

static double quantity(const case_result_t *result, quantity_t what, int level) {
    switch (what) {
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
    case LEVEL_DC:
        return result->level_dc_deg[level];
    case LEVEL_CHANGE:
    default:
        return result->level_dc_deg[level] - result->level_dc_deg[0];
    }
}

// ---- Rows ---------------------------------------------------------------------------------------

/// Where in a paper a row stands, what it shows, and of which run.
typedef struct {
    const char *figure;
    const char *name; ///< of the quantity, in ids
    const char *text;
    const char *unit;
    case_kind_t kind;
    case_method_t method;
    double speed_rpm;
    quantity_t quantity;
    int level;
} place_t;

static row_t *measure(work_t *work, const place_t *at, const words_t *words) {
    static const char *const methods[METHODS] = {"qpll", "enhanced"};
    char id[48];
    char what[64];
    const bool staircase = at->kind == CASE_STAIRCASE || at->kind == CASE_STAIRCASE_RATED;
    (void)snprintf(id, sizeof id, "%s_%s_%.0f_%s", at->figure, methods[at->method], at->speed_rpm,
                   at->name);
    (void)snprintf(what, sizeof what, "%s%.0f rpm, %s", staircase ? "from " : "", at->speed_rpm,
                   at->text);
    row_t *row = table_row(&work->out->table, at->figure, id, what, at->unit, words);
    for (int chain = 0; chain < CHAINS; ++chain) {
        if (chain == CHAIN_EQ14 && strcmp(at->figure, "eq14") != 0) {
            continue;
        }
        const case_t run = {at->kind, at->method, (case_chain_t)chain, at->speed_rpm, false};
        const case_result_t *result = result_of(work, &run);
        row->value[chain] = quantity(result, at->quantity, at->level);
        row->missing[chain] = isnan(result->lost_s) ? "stalls" : "lost";
    }
    return row;
}

/// The enhanced PLL at 300 rpm behind an ideal inverter: how much of a figure is the inverter's.
static void measure_ideal(work_t *work, const char *figure, case_kind_t kind) {
    static const char *const quantities[] = {"mean", "pp"};
    static const char *const names[] = {"dc", "pp"};
    const words_t none = table_no_claim(NAN, NULL);
    row_t *rows[2];
    for (int k = 0; k < 2; ++k) {
        char id[48];
        char what[64];
        (void)snprintf(id, sizeof id, "%s_ideal_300_%s", figure, names[k]);
        (void)snprintf(what, sizeof what, "300 rpm, enh., ideal inverter: %s", quantities[k]);
        rows[k] = table_row(&work->out->table, figure, id, what, "deg", &none);
        rows[k]->improvable = false;
    }
    for (int chain = CHAIN_PRINTED; chain <= CHAIN_LIBRARY && !work->failed; ++chain) {
        const case_t run = {kind, METHOD_ENHANCED, (case_chain_t)chain, 300.0, true};
        case_result_t result;
        work->failed = !case_run(&run, work->bases, &result, NULL);
        work->out->table.runs++;
        work->out->table.simulated_s += result.simulated_s;
        rows[0]->value[chain] = result.dc_deg;
        rows[1]->value[chain] = result.pp_deg;
        rows[0]->missing[chain] = rows[1]->missing[chain] =
            isnan(result.lost_s) ? "stalls" : "lost";
    }
}

// ---- Figures ------------------------------------------------------------------------------------

static const char printed_dc[] = "lag - compensation, with the voltage lost in the inverter";
static const char of_the_lag[] = "lag - compensation";

static figure_t *add_figure(work_t *work, const char *figure, const char *title) {
    return table_figure(&work->out->table, figure, title);
}

static void figure_12_13(work_t *work) {
    const theory_t *t = &work->out->theory;
    static const double no_load_pp[] = {2.0, 2.0};
    static const double rated_dc[] = {-5.0, -22.0};
    static const double rated_pp[] = {6.5, 2.0};
    static const double speeds[] = {300.0, 1500.0};
    static const char *const hunts = "without load and with id* = 0 the current rests in the "
                                     "inverter's dead band: speed loop and "
                                     "angle hunt;\nthe drag of the paper's load machine, which is "
                                     "not given, would take it out of "
                                     "there";
    (void)add_figure(work, "fig12", "Fig. 12: QPLL, no load");
    for (int k = 0; k < 2; ++k) {
        const words_t dc =
            table_no_claim(theory_printed_dc_deg(t, speeds[k], 0.0, false), of_the_lag);
        const words_t pp = {k == 0 ? CLAIM_ABOUT : CLAIM_AT_MOST, no_load_pp[k], NAN, NULL, hunts};
        const place_t at_dc = {
            "fig12", "dc", "angle error, mean", "deg", CASE_NO_LOAD, METHOD_QPLL, speeds[k], DC, 0};
        const place_t at_pp = {
            "fig12", "pp", "angle error, pp", "deg", CASE_NO_LOAD, METHOD_QPLL, speeds[k], PP, 0};
        (void)measure(work, &at_dc, &dc);
        (void)measure(work, &at_pp, &pp);
    }
    figure_t *figure = add_figure(work, "fig13", "Fig. 13: QPLL, rated load");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "lag of the C-LESO in forward Euler, 2 arg(rho - 1 + w0 Ts) - w Ts/2: %.2f deg at "
        "300 rpm, %.2f at 1500.\nThe voltage lost in the inverter, V = %.1f V + %g Ohm I, "
        "lies along the current and turns the observed EMF\ntowards the estimate: "
        "delta = phi + asin(V sin(phi)/(w psi_a)), phi = lag - Rs I Ts/(2 psi_a)",
        theory_euler_lag_deg(t, 300.0), theory_euler_lag_deg(t, 1500.0), t->loss_V, t->r_on_Ohm);
    for (int k = 0; k < 2; ++k) {
        const words_t dc = {CLAIM_ABOUT, rated_dc[k],
                            theory_printed_dc_deg(t, speeds[k], CASE_RATED_Nm, false), printed_dc,
                            "-5 deg is the lag alone: here the voltage lost in the inverter adds "
                            "to it"};
        const words_t pp = {CLAIM_ABOUT, rated_pp[k], NAN, NULL,
                            "a matter of the inverter's drops, which are not given; gone with "
                            "dead-time correction"};
        const place_t at_dc = {
            "fig13", "dc", "angle error, mean", "deg", CASE_RATED, METHOD_QPLL, speeds[k], DC, 0};
        const place_t at_pp = {
            "fig13", "pp", "angle error, pp", "deg", CASE_RATED, METHOD_QPLL, speeds[k], PP, 0};
        (void)measure(work, &at_dc, &dc);
        (void)measure(work, &at_pp, &pp);
    }
}

static const char by_eq30[] =
    "eq. 30 is the lag of the continuous observer, more than that of the sampled one";
static const char dead_band_300[] =
    "the inverter's dead band takes the angle at 300 rpm: behind an ideal one it is held";
static const char dead_band[] = "hunting in the dead band without load, see Fig. 12";
static const char ripple[] = "the paper's 1 deg (Section 6) is for no speed in particular; dead "
                             "time weighs most at low speed";

static void speeds_of(work_t *work, const char *figure, case_kind_t kind) {
    const theory_t *t = &work->out->theory;
    const double load_Nm = kind == CASE_RATED ? CASE_RATED_Nm : 0.0;
    const char *formula = kind == CASE_RATED ? printed_dc : of_the_lag;
    for (int k = 1; k <= SPEEDS; ++k) {
        const double rpm = CASE_STEP_rpm * k;
        const words_t words =
            table_no_claim(theory_printed_dc_deg(t, rpm, load_Nm, false), formula);
        const place_t at = {figure, "dc", "QPLL: angle error, mean", "deg", kind, METHOD_QPLL, rpm,
                            DC,     0};
        (void)measure(work, &at, &words);
    }
    for (int k = 1; k <= SPEEDS; ++k) {
        const double rpm = CASE_STEP_rpm * k;
        const words_t words = {CLAIM_AT_MOST, 2.0, theory_printed_dc_deg(t, rpm, load_Nm, true),
                               formula, k == 1 && load_Nm <= 0.0 ? dead_band_300 : by_eq30};
        const place_t at = {
            figure, "dc", "enhanced: angle error, mean", "deg", kind, METHOD_ENHANCED, rpm, DC, 0};
        (void)measure(work, &at, &words);
    }
    for (int k = 1; k <= SPEEDS; ++k) {
        const double rpm = CASE_STEP_rpm * k;
        const words_t none = table_no_claim(NAN, NULL);
        const words_t words = {CLAIM_AT_MOST, 1.0, NAN, NULL,
                               load_Nm > 0.0 ? ripple : (k == 1 ? dead_band_300 : dead_band)};
        const place_t qpll = {figure, "pp", "QPLL: angle error, pp", "deg", kind, METHOD_QPLL, rpm,
                              PP,     0};
        const place_t enhanced = {
            figure, "pp", "enhanced: angle error, pp", "deg", kind, METHOD_ENHANCED, rpm, PP, 0};
        (void)measure(work, &qpll, &none);
        (void)measure(work, &enhanced, &words);
    }
    measure_ideal(work, figure, kind);
}

static void figure_14_15(work_t *work) {
    const theory_t *t = &work->out->theory;
    figure_t *figure = add_figure(work, "fig14", "Fig. 14: 300 .. 1500 rpm, no load");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "eq. 30 less the lag of the C-LESO in forward Euler: %+.2f deg at 300 rpm, %+.2f at "
        "1500; with rated load\nRs I Ts/(2 psi) = +0.24 on top",
        theory_eq30_deg(t, 300.0) - theory_euler_lag_deg(t, 300.0),
        theory_eq30_deg(t, 1500.0) - theory_euler_lag_deg(t, 1500.0));
    speeds_of(work, "fig14", CASE_NO_LOAD);
    (void)add_figure(work, "fig15", "Fig. 15: 300 .. 1500 rpm, rated load");
    speeds_of(work, "fig15", CASE_RATED);
}

static void acceleration(work_t *work) {
    const theory_t *t = &work->out->theory;
    figure_t *figure = add_figure(work, "acceleration",
                                  "Acceleration, 300 .. 1500 rpm in steps of 300 at 2000 rpm/s");
    const double d = t->np * CASE_RAMP_rpm_s * (RIG_PI / 30.0);
    (void)snprintf(
        figure->note, sizeof figure->note,
        "largest mean error over the second half of a ramp; the slope is ours, the paper "
        "gives none;\nthe QPLL lags behind a ramp by r/Ki = %.2f deg (Table 1)",
        rig_deg_from_rad(d / (t->sigma * t->sigma)));
    for (int k = 0; k < 2; ++k) {
        const case_kind_t kind = k == 0 ? CASE_STAIRCASE : CASE_STAIRCASE_RATED;
        const char *name = k == 0 ? "no_load" : "rated";
        const words_t none = table_no_claim(NAN, NULL);
        const words_t words = {CLAIM_AT_MOST, 2.0, NAN, NULL,
                               k == 0 ? "lost at 300 rpm already, see Fig. 14" : by_eq30};
        const place_t qpll = {
            "acceleration", name,    k == 0 ? "QPLL, no load" : "QPLL, rated load",
            "deg",          kind,    METHOD_QPLL,
            300.0,          RAMP_DC, 0};
        place_t enhanced = qpll;
        enhanced.text = k == 0 ? "enhanced, no load" : "enhanced, rated load";
        enhanced.method = METHOD_ENHANCED;
        (void)measure(work, &qpll, &none);
        (void)measure(work, &enhanced, &words);
    }
}

/// The claims of Fig. 16 or 17 for one PLL.
typedef struct {
    claim_t claim;
    double angle_deg, estimate_rpm, speed_rpm;
} claims_t;

static void load_step(work_t *work, const char *figure, double rpm, case_method_t method,
                      const claims_t *claims) {
    const theory_t *t = &work->out->theory;
    const bool leso = method == METHOD_ENHANCED;
    const bool speed_claimed = !isnan(claims->speed_rpm);
    const char *name = leso ? "enhanced" : "QPLL";
    const char *hunts =
        leso ? "at sigma = 150 5 Nm are not held behind an ideal inverter either, but with the EMF "
               "of the active flux (Fig. 15);\nonce the load is off: the dead band (Fig. 14)"
             : "less than claimed; the swing itself is small, the rest is hunting in "
               "the dead band (Fig. 12)";
    const words_t swing = table_no_claim(theory_swing_deg(t, CASE_RATED_Nm, leso),
                                         leso ? "2 exp(-2) d/sigma^2" : "d/sigma^2");
    const words_t angle = {claims->claim, claims->angle_deg, swing.theory, swing.formula, hunts};
    const words_t estimate = {claims->claim, claims->estimate_rpm,
                              theory_swing_rpm(t, CASE_RATED_Nm, leso),
                              leso ? "0.840 d/sigma" : "2 d/sigma",
                              "J, sigma and 5 Nm allow no less than about the theory column"};
    const words_t speed = {speed_claimed ? CLAIM_ABOUT : CLAIM_NONE, claims->speed_rpm, NAN, NULL,
                           "fits within 25 %: the units of the speed gains are right"};
    char text[4][64];
    static const char *const what[] = {"angle, first 0.2 s", "angle, to the end", "speed error",
                                       "real speed"};
    static const char *const id[] = {"swing", "step", "estimate", "speed"};
    static const quantity_t quantities[] = {SWING, STEP, STEP_ESTIMATE, STEP_SPEED};
    const words_t *words[] = {&swing, &angle, &estimate, &speed};
    for (int k = 0; k < 4; ++k) {
        (void)snprintf(text[k], sizeof text[k], "%s: %s", name, what[k]);
        const place_t at = {figure,     id[k],  text[k], k < 2 ? "deg" : "rpm",
                            CASE_RATED, method, rpm,     quantities[k],
                            0};
        (void)measure(work, &at, words[k]);
    }
}

static void figure_16_17(work_t *work) {
    const theory_t *t = &work->out->theory;
    static const claims_t at_300[METHODS] = {{CLAIM_ABOUT, 75.0, 20.0, NAN},
                                             {CLAIM_AT_MOST, 18.0, 5.0, NAN}};
    static const claims_t at_1500[METHODS] = {{CLAIM_ABOUT, 8.0, 5.0, 67.0},
                                              {CLAIM_AT_MOST, 5.0, 2.0, 40.0}};
    figure_t *figure = add_figure(work, "fig16", "Fig. 16: load 5 -> 0 Nm at 300 rpm");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "d = np 5 Nm/J = %.0f rad/s^2. While it lasts, the QPLL's speed is behind by up to "
        "2 d/sigma = %.1f rpm,\nthe LESO-QPLL's by up to 0.840 d/sigma = %.1f rpm: the "
        "claimed 5 and 2 rpm need another J, another sigma\nor a filter before the plot",
        theory_acceleration(t, CASE_RATED_Nm), theory_swing_rpm(t, CASE_RATED_Nm, false),
        theory_swing_rpm(t, CASE_RATED_Nm, true));
    for (int m = 0; m < METHODS; ++m) {
        load_step(work, "fig16", 300.0, (case_method_t)m, &at_300[m]);
    }
    (void)add_figure(work, "fig17", "Fig. 17: load 5 -> 0 Nm at 1500 rpm");
    for (int m = 0; m < METHODS; ++m) {
        load_step(work, "fig17", 1500.0, (case_method_t)m, &at_1500[m]);
    }
}

static const char *why_mismatched(bool Lq, double factor, double rpm) {
    if (!Lq) {
        return "at 300 rpm the voltage of a second Rs is 44 % of the EMF: with the ripple it "
               "stalls";
    }
    if (factor > 1.0) {
        return "no angle carries 5 Nm with twice Lq, see above";
    }
    return rpm < 600.0
               ? "at 300 rpm the loop through the current does not hold at sigma = 150 with half Lq"
               : "the closed form gives 14 deg, eq. 30 and the inverter some 3 more";
}

static void mismatch_of(work_t *work, const char *figure, double rpm, case_kind_t kind,
                        const double claimed[2]) {
    const theory_t *t = &work->out->theory;
    const bool Lq = kind == CASE_LQ_DOWN || kind == CASE_LQ_UP;
    double factor[CASE_LEVELS_MAX];
    const int levels = case_levels(kind, factor);
    for (int k = kind == CASE_LQ_DOWN || kind == CASE_RS_DOWN ? 0 : 1; k < levels; ++k) {
        char text[64];
        char name[32];
        double pull_out_Nm = 0.0;
        const bool end = k == levels - 1;
        const double bound = claimed[factor[k] < 1.0 ? 0 : 1];
        const double error_deg =
            Lq ? theory_mismatch_deg(t, rpm, CASE_RATED_Nm, factor[k], &pull_out_Nm) : 0.0;
        const claim_t end_claim = Lq ? CLAIM_SIZE : CLAIM_AT_MOST;
        const words_t words = {end ? end_claim : CLAIM_NONE, end ? bound : NAN, error_deg,
                               Lq ? "sin(delta) = (Lq - Lq^) I/psi_a"
                                  : "Rs does not enter at id = 0",
                               end ? why_mismatched(Lq, factor[k], rpm) : NULL};
        (void)snprintf(text, sizeof text, "%s x%.2f: angle error%s", Lq ? "Lq" : "Rs", factor[k],
                       Lq ? "" : ", change");
        (void)snprintf(name, sizeof name, "%s_%.0f", Lq ? "Lq" : "Rs", 100.0 * factor[k]);
        const place_t at = {
            figure, name, text, "deg", kind, METHOD_ENHANCED, rpm, Lq ? LEVEL_DC : LEVEL_CHANGE, k};
        if (Lq || k > 0) {
            measure(work, &at, &words)->improvable = false;
        }
    }
}

static void figure_18_19(work_t *work) {
    const theory_t *t = &work->out->theory;
    static const double Lq_300[] = {9.0, 25.0}, Lq_1500[] = {12.0, 40.0};
    static const double Rs[] = {1.0, 1.0};
    double pull_out_Nm = 0.0;
    figure_t *figure =
        add_figure(work, "fig18", "Fig. 18: wrong Lq and Rs at 300 rpm, rated load, enhanced");
    (void)theory_mismatch_deg(t, 300.0, CASE_RATED_Nm, 2.0, &pull_out_Nm);
    (void)snprintf(
        figure->note, sizeof figure->note,
        "id* = 0 puts the current I on the estimated q axis, so the observed EMF stands there if\n"
        "    sin(delta) = (Lq - Lq^) I/psi_a, psi_a = psi - (Ld - Lq) I sin(delta), T = 1.5 np "
        "psi_a "
        "I cos(delta).\nWith Lq^ = 2 Lq the largest T of all is %.2f Nm: rated load cannot be "
        "held, "
        "whatever the PLL.\nThe sign convention of the figure is not known: sizes are compared. "
        "\"Almost unchanged\" is taken as at most 1 deg",
        pull_out_Nm);
    static const case_kind_t kinds[] = {CASE_LQ_DOWN, CASE_LQ_UP, CASE_RS_DOWN, CASE_RS_UP};
    for (int k = 0; k < 4; ++k) {
        mismatch_of(work, "fig18", 300.0, kinds[k], k < 2 ? Lq_300 : Rs);
    }
    (void)add_figure(work, "fig19", "Fig. 19: wrong Lq and Rs at 1500 rpm, rated load, enhanced");
    for (int k = 0; k < 4; ++k) {
        mismatch_of(work, "fig19", 1500.0, kinds[k], k < 2 ? Lq_1500 : Rs);
    }
}

static void equation_14(work_t *work) {
    const words_t words = table_no_claim(NAN, NULL);
    figure_t *figure = add_figure(work, "eq14", "Eq. 14: which speed the QPLL reports");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "by eq. 14 the output of the PI controller: here in the column \"as printed\". The speed "
        "controller of Section 5 answers to\nthe ripple on it with full current. Everywhere "
        "else here it is the integral part");
    for (int k = 0; k < 2; ++k) {
        const place_t at = {"eq14",     "speed_pp",  "QPLL: speed error, pp", "rpm",
                            CASE_RATED, METHOD_QPLL, k == 0 ? 300.0 : 1500.0, SPEED_PP,
                            0};
        row_t *row = measure(work, &at, &words);
        row->value[CHAIN_PRINTED] = row->value[CHAIN_EQ14];
        row->missing[CHAIN_PRINTED] = row->missing[CHAIN_EQ14];
    }
}

// ---- Tables -------------------------------------------------------------------------------------

static void table_1(work_t *work) {
    static const char *const what[] = {"QPLL: step of position",   "QPLL: step of speed",
                                       "QPLL: ramp of speed",      "LESO-QPLL: step of position",
                                       "LESO-QPLL: step of speed", "LESO-QPLL: ramp of speed"};
    const theory_t *t = &work->out->theory;
    figure_t *figure =
        add_figure(work, "table1", "Table 1: error after 0.5 s behind a moving angle");
    const double r = t->np * rig_rad_s_from_rpm(CASE_RAMP_rpm_s);
    const double lag_deg = -rig_deg_from_rad(r / (t->sigma * t->sigma));
    (void)snprintf(
        figure->note, sizeof figure->note,
        "the PLLs alone on a perfect EMF; steps of 30 deg and 10 rad/s, a ramp of r = %.0f "
        "rad/s^2 (2000 rpm/s)",
        r);
    for (int k = 0; k < 6; ++k) {
        char id[48];
        const double claimed_deg = k == 2 ? lag_deg : 0.0;
        const words_t words = {CLAIM_EXACTLY, claimed_deg, claimed_deg, k == 2 ? "-r/Ki" : "0",
                               NULL};
        (void)snprintf(id, sizeof id, "table1_%d", k + 1);
        row_t *row = table_row(&work->out->table, "table1", id, what[k], "deg", &words);
        row->value[CHAIN_PRINTED] = tables_tracking_deg(t, k >= 3, k % 3, true);
        row->value[CHAIN_EXACT] = tables_tracking_deg(t, k >= 3, k % 3, false);
        row->improvable = false;
    }
}

static double loop_figure(const theory_loop_t *loop, int which) {
    const double figures[] = {loop->crossover_rad_s, loop->margin_deg, loop->pole_re,
                              loop->pole_im};
    return figures[which];
}

static void table_2(work_t *work) {
    static const double claimed[3][4] = {
        {244.0, 68.0, -26.8, 587.7}, {365.0, 66.0, -22.9, 583.2}, {478.0, 58.0, -18.3, 580.1}};
    static const char *const what[] = {"crossover", "phase margin", "dominant pole, real",
                                       "dominant pole, imaginary"};
    static const char *const unit[] = {"rad/s", "deg", "1/s", "1/s"};
    const theory_t *t = &work->out->theory;
    figure_t *figure = add_figure(work, "table2", "Table 2: enhanced PLL, k = 0.1, 600 rad/s");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "eqs. 35 and 36 are misprints: as printed the gain falls through 1 on the way into the "
        "notch, is above 1 again beyond it\nand stays there; theory has notch ((s + sigma)^3 - "
        "s^3)/s^3, as eq. 21 gives, and exact the sampled form at 5 kHz.\nThe margin falls with "
        "sigma, where the text says that it rises");
    for (int s = 0; s < 3; ++s) {
        const double sigma = 80.0 + 40.0 * s;
        const theory_loop_t right = theory_loop(sigma, 0.1, 600.0, false);
        const theory_loop_t printed = theory_loop(sigma, 0.1, 600.0, true);
        const theory_loop_t sampled = theory_loop_sampled(sigma, 0.1, 600.0, t->ts_s);
        for (int k = 0; k < 4; ++k) {
            char id[48];
            char text[64];
            const words_t words = {CLAIM_FORMULA, claimed[s][k], loop_figure(&right, k),
                                   "from notch ((s + sigma)^3 - s^3)/s^3", NULL};
            (void)snprintf(id, sizeof id, "table2_%.0f_%d", sigma, k + 1);
            (void)snprintf(text, sizeof text, "sigma %.0f: %s", sigma, what[k]);
            row_t *row = table_row(&work->out->table, "table2", id, text, unit[k], &words);
            row->value[CHAIN_PRINTED] = loop_figure(&printed, k);
            row->value[CHAIN_EXACT] = loop_figure(&sampled, k);
            row->improvable = false;
        }
    }
}

// ---- All of it ----------------------------------------------------------------------------------

bool reproduction_run(reproduction_t *self, const case_bases_t *bases) {
    static work_t work;
    work = (work_t){.bases = bases, .out = self};
    *self = (reproduction_t){.table = {.paper = &reproduction_paper},
                             .theory = theory_of(&bases->paper)};
    progress_start(&work.progress);
    table_1(&work);
    table_2(&work);
    figure_12_13(&work);
    figure_14_15(&work);
    acceleration(&work);
    figure_16_17(&work);
    figure_18_19(&work);
    equation_14(&work);
    (void)progress_end(&work.progress);
    return !work.failed;
}

bool reproduction_signals(const case_bases_t *bases, const case_t *what, runlog_t *log) {
    case_result_t result;
    return case_run(what, bases, &result, log);
}
