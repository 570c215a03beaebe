#include <math.h>
#include <stdio.h>

#include "reproduce/work.h"
#include "support/units.h"

// ---- Ramps --------------------------------------------------------------------------------------

static void acceleration(work_t *work) {
    const theory_t *t = work->theory;
    figure_t *figure = work_figure(work, "acceleration", "Acceleration, 300 .. 1500 rpm");
    const double d = t->np * rig_rad_s_from_rpm(CASE_RAMP_rpm_s);
    (void)snprintf(figure->note, sizeof figure->note,
                   "Steps of 300 rpm at 2000 rpm/s; largest mean error over the second half of a "
                   "ramp. The paper gives no slope, so this one is ours.\nThe QPLL lags behind a "
                   "ramp by r/Ki = %.2f deg (Table 1).",
                   rig_deg_from_rad(d / (t->sigma * t->sigma)));
    for (int k = 0; k < 2; ++k) {
        const words_t none = table_no_claim(NAN, NULL);
        const words_t words = {.claim = CLAIM_AT_MOST,
                               .claimed = 2.0,
                               .reading = READING_WHOLE,
                               .theory = NAN,
                               .lacks = "the slope of the ramps"};
        place_t at = {"acceleration",
                      k == 0 ? "no_load" : "rated",
                      k == 0 ? "QPLL, no load" : "QPLL, rated load",
                      "deg",
                      {.kind = k == 0 ? CASE_STAIRCASE : CASE_STAIRCASE_RATED,
                       .speed_rpm = 300.0,
                       .quantity = RAMP_DC}};
        (void)work_measure(work, &at, &none);
        at.text = k == 0 ? "enhanced, no load" : "enhanced, rated load";
        at.source.method = METHOD_ENHANCED;
        (void)work_measure(work, &at, &words);
    }
}

// ---- Figs. 16, 17 -------------------------------------------------------------------------------

/// The claims of Fig. 16 or 17 for one PLL.
typedef struct {
    claim_t claim;
    double angle_deg, estimate_rpm, speed_rpm;
} claims_t;

static void load_step(work_t *work, const char *figure, double rpm, case_method_t method,
                      const claims_t *claims) {
    const theory_t *t = work->theory;
    const bool leso = method == METHOD_ENHANCED;
    const bool speed_claimed = !isnan(claims->speed_rpm);
    const words_t swing = table_no_claim(theory_swing_deg(t, CASE_RATED_Nm, leso),
                                         leso ? "2 exp(-2) d/sigma^2" : "d/sigma^2");
    const words_t angle = {.claim = claims->claim,
                           .claimed = claims->angle_deg,
                           .reading = READING_WHOLE,
                           .theory = swing.theory,
                           .formula = swing.formula};
    const words_t estimate = {.claim = claims->claim,
                              .claimed = claims->estimate_rpm,
                              .reading = READING_WHOLE,
                              .theory = theory_swing_rpm(t, CASE_RATED_Nm, leso),
                              .formula = leso ? "0.840 d/sigma" : "2 d/sigma"};
    const words_t speed = {.claim = speed_claimed ? CLAIM_ABOUT : CLAIM_NONE,
                           .claimed = claims->speed_rpm,
                           .theory = NAN};
    static const char *const what[] = {"angle, first 0.2 s", "angle, to the end", "speed error",
                                       "real speed"};
    static const char *const id[] = {"swing", "step", "estimate", "speed"};
    static const quantity_t quantities[] = {SWING, STEP, STEP_ESTIMATE, STEP_SPEED};
    const words_t *words[] = {&swing, &angle, &estimate, &speed};
    for (int k = 0; k < 4; ++k) {
        char text[64];
        (void)snprintf(text, sizeof text, "%s: %s", leso ? "enhanced" : "QPLL", what[k]);
        const place_t at = {
            figure,
            id[k],
            text,
            k < 2 ? "deg" : "rpm",
            {.kind = CASE_RATED, .method = method, .speed_rpm = rpm, .quantity = quantities[k]}};
        row_t *row = work_measure(work, &at, words[k]);
        const double seen = row->value[COLUMN_PRINTED];
        if (quantities[k] == STEP_ESTIMATE &&
            fabs(seen - estimate.theory) < 0.4 * estimate.theory) {
            (void)snprintf(row->because, sizeof row->because,
                           "J, sigma and 5 Nm give %.3g rpm in closed form (%s)", estimate.theory,
                           estimate.formula);
        }
    }
}

static void figures_16_17(work_t *work) {
    const theory_t *t = work->theory;
    static const claims_t at_300[METHODS] = {{CLAIM_ABOUT, 75.0, 20.0, NAN},
                                             {CLAIM_AT_MOST, 18.0, 5.0, NAN}};
    static const claims_t at_1500[METHODS] = {{CLAIM_ABOUT, 8.0, 5.0, 67.0},
                                              {CLAIM_AT_MOST, 5.0, 2.0, 40.0}};
    figure_t *figure = work_figure(work, "fig16", "Fig. 16: load 5 -> 0 Nm at 300 rpm");
    (void)snprintf(figure->note, sizeof figure->note,
                   "d = np 5 Nm/J = %.0f rad/s^2. While the rotor accelerates by d, the speed of "
                   "the QPLL lags by up to 2 d/sigma = %.1f rpm,\nthat of the LESO-QPLL by up to "
                   "0.840 d/sigma = %.1f rpm.",
                   theory_acceleration(t, CASE_RATED_Nm), theory_swing_rpm(t, CASE_RATED_Nm, false),
                   theory_swing_rpm(t, CASE_RATED_Nm, true));
    for (int m = 0; m < METHODS; ++m) {
        load_step(work, "fig16", 300.0, (case_method_t)m, &at_300[m]);
    }
    (void)work_figure(work, "fig17", "Fig. 17: load 5 -> 0 Nm at 1500 rpm");
    for (int m = 0; m < METHODS; ++m) {
        load_step(work, "fig17", 1500.0, (case_method_t)m, &at_1500[m]);
    }
}

void work_changes(work_t *work) {
    acceleration(work);
    figures_16_17(work);
}

// ---- Figs. 18, 19 -------------------------------------------------------------------------------

typedef struct {
    const char *figure;
    double rpm;
    case_kind_t kind;
    double claimed_deg[2]; ///< Lq: size at the smallest and the largest factor
} knob_t;

static void angle_at(work_t *work, const knob_t *knob, double factor, int level, bool end) {
    const theory_t *t = work->theory;
    const bool Lq = knob->kind == CASE_LQ_DOWN || knob->kind == CASE_LQ_UP;
    const double claimed = Lq ? knob->claimed_deg[factor < 1.0 ? 0 : 1] : WORK_NEARLY_deg;
    const claim_t claim = Lq ? CLAIM_SIZE : CLAIM_AT_MOST;
    double pull_out_Nm = 0.0;
    const double error_deg =
        Lq ? theory_mismatch_deg(t, knob->rpm, CASE_RATED_Nm, factor, &pull_out_Nm) : 0.0;
    const words_t words = {.claim = end ? claim : CLAIM_NONE,
                           .claimed = end ? claimed : NAN,
                           .theory = error_deg,
                           .formula = Lq ? "sin(delta) = (Lq - Lq^) I/psi_a"
                                         : "Rs does not enter at id = 0"};
    char text[64];
    char name[32];
    (void)snprintf(text, sizeof text, "%s x%.2f: angle%s", Lq ? "Lq" : "Rs", factor,
                   Lq ? " error" : ", change");
    (void)snprintf(name, sizeof name, "%s_%.0f", Lq ? "Lq" : "Rs", 100.0 * factor);
    const place_t at = {knob->figure,
                        name,
                        text,
                        "deg",
                        {.kind = knob->kind,
                         .method = METHOD_ENHANCED,
                         .speed_rpm = knob->rpm,
                         .quantity = Lq ? LEVEL_DC : LEVEL_CHANGE,
                         .level = level}};
    row_t *row = work_measure(work, &at, &words);
    if (Lq && isnan(error_deg)) {
        (void)snprintf(row->because, sizeof row->because,
                       "No angle carries %g Nm with this Lq: the most is %.2f Nm", CASE_RATED_Nm,
                       pull_out_Nm);
    }
}

/// "The speed error is nearly the same during the whole process."
static void speed_at(work_t *work, const knob_t *knob, double factor, int level) {
    const bool Lq = knob->kind == CASE_LQ_DOWN || knob->kind == CASE_LQ_UP;
    const words_t words = {.claim = CLAIM_AT_MOST,
                           .claimed = WORK_NEARLY_rpm,
                           .theory = 0.0,
                           .formula = "a PLL's mean speed is that of the angle it follows"};
    char text[64];
    char name[32];
    (void)snprintf(text, sizeof text, "%s x%.2f: speed err., change", Lq ? "Lq" : "Rs", factor);
    (void)snprintf(name, sizeof name, "%s_%.0f_speed", Lq ? "Lq" : "Rs", 100.0 * factor);
    const place_t at = {knob->figure,
                        name,
                        text,
                        "rpm",
                        {.kind = knob->kind,
                         .method = METHOD_ENHANCED,
                         .speed_rpm = knob->rpm,
                         .quantity = LEVEL_SPEED_CHANGE,
                         .level = level}};
    (void)work_measure(work, &at, &words);
}

static void turn(work_t *work, const knob_t *knob) {
    double factor[CASE_LEVELS_MAX];
    const int levels = case_levels(knob->kind, factor);
    const bool Rs = knob->kind == CASE_RS_DOWN || knob->kind == CASE_RS_UP;
    for (int k = knob->kind == CASE_LQ_DOWN || Rs ? 0 : 1; k < levels; ++k) {
        if (!Rs || k > 0) {
            angle_at(work, knob, factor[k], k, k == levels - 1);
        }
    }
    speed_at(work, knob, factor[levels - 1], levels - 1);
}

/// -9 and -25 deg, -12 and -40: the paper has both factors on the same side.
static void same_side(work_t *work, const char *figure, double rpm) {
    static const int at_half = 2, at_quarter_more = 1;
    const words_t words = {.claim = CLAIM_EXACTLY,
                           .claimed = 1.0,
                           .theory = -1.0,
                           .formula = "sin(delta) = (Lq - Lq^) I/psi_a changes sign at Lq^ = Lq"};
    const place_t at = {figure,
                        "Lq_sides",
                        "Lq x0.5, x1.25: same sign (1)",
                        "",
                        {.kind = CASE_LQ_DOWN,
                         .method = METHOD_ENHANCED,
                         .speed_rpm = rpm,
                         .quantity = LEVEL_DC,
                         .level = at_half}};
    source_t up = at.source;
    up.kind = CASE_LQ_UP;
    up.level = at_quarter_more;
    row_t *row = work_measure_pair(work, &at, SAME_SIGN, &up, &words);
    double pull_out_Nm = 0.0;
    const double low = theory_mismatch_deg(work->theory, rpm, CASE_RATED_Nm, 0.5, &pull_out_Nm);
    const double high = theory_mismatch_deg(work->theory, rpm, CASE_RATED_Nm, 1.25, &pull_out_Nm);
    (void)snprintf(row->because, sizeof row->because,
                   "The closed form gives %.1f deg with half Lq, %.1f with 1.25 times", low, high);
}

/// "Obviously strong robustness against d-axis inductance mismatch."
static void Ld_rows(work_t *work, const char *figure, double rpm) {
    static const double factors[] = {0.5, 2.0};
    const words_t words = {.claim = CLAIM_AT_MOST,
                           .claimed = WORK_NEARLY_deg,
                           .theory = 0.0,
                           .formula = "Ld is not in the observer; at id = 0 not in the torque"};
    for (int k = 0; k < 2; ++k) {
        char text[64];
        char name[32];
        (void)snprintf(text, sizeof text, "Ld x%.2f: angle, change", factors[k]);
        (void)snprintf(name, sizeof name, "Ld_%.0f", 100.0 * factors[k]);
        const place_t at = {figure,
                            name,
                            text,
                            "deg",
                            {.kind = CASE_RATED,
                             .method = METHOD_ENHANCED,
                             .speed_rpm = rpm,
                             .quantity = DC,
                             .Ld_factor = factors[k]}};
        source_t right = at.source;
        right.Ld_factor = 0.0;
        (void)work_measure_pair(work, &at, DIFFERENCE, &right, &words);
    }
}

void work_mismatch(work_t *work) {
    static const knob_t knobs[2][4] = {{{"fig18", 300.0, CASE_LQ_DOWN, {9.0, 25.0}},
                                        {"fig18", 300.0, CASE_LQ_UP, {9.0, 25.0}},
                                        {"fig18", 300.0, CASE_RS_DOWN, {0.0, 0.0}},
                                        {"fig18", 300.0, CASE_RS_UP, {0.0, 0.0}}},
                                       {{"fig19", 1500.0, CASE_LQ_DOWN, {12.0, 40.0}},
                                        {"fig19", 1500.0, CASE_LQ_UP, {12.0, 40.0}},
                                        {"fig19", 1500.0, CASE_RS_DOWN, {0.0, 0.0}},
                                        {"fig19", 1500.0, CASE_RS_UP, {0.0, 0.0}}}};
    static const char *const titles[] = {"Fig. 18: wrong Lq, Rs, Ld; 300 rpm, enhanced",
                                         "Fig. 19: wrong Lq, Rs, Ld; 1500 rpm, enhanced"};
    double pull_out_Nm = 0.0;
    (void)theory_mismatch_deg(work->theory, 300.0, CASE_RATED_Nm, 2.0, &pull_out_Nm);
    for (int n = 0; n < 2; ++n) {
        figure_t *figure = work_figure(work, knobs[n][0].figure, titles[n]);
        if (n == 0) {
            (void)snprintf(
                figure->note, sizeof figure->note,
                "With id* = 0 the current I lies on the estimated q axis. The observed EMF lies on "
                "it too if\n    sin(delta) = (Lq - Lq^) I/psi_a, psi_a = psi - (Ld - Lq) I "
                "sin(delta), T = 1.5 np psi_a I cos(delta).\nWith Lq^ = 2 Lq the largest possible "
                "T is %.2f Nm.\nThe sign convention of the figure is not known. The comparison "
                "therefore takes sizes, and checks whether both sides of Lq^ = Lq have the same "
                "sign, as in the paper. \"Almost unchanged\" and \"nearly the same\" are taken as "
                "at most 1 deg and 1 rpm.",
                pull_out_Nm);
        }
        for (int k = 0; k < 4; ++k) {
            turn(work, &knobs[n][k]);
        }
        same_side(work, knobs[n][0].figure, knobs[n][0].rpm);
        Ld_rows(work, knobs[n][0].figure, knobs[n][0].rpm);
    }
}

// ---- The start ----------------------------------------------------------------------------------

enum { STARTS_SHOWN = 20 };

void work_start(work_t *work) {
    const words_t words = {.claim = CLAIM_AT_LEAST, .claimed = 100.0, .theory = NAN};
    const words_t none = table_no_claim(NAN, NULL);
    figure_t *figure = work_figure(work, "start", "I-f start, hand-over at 100 rpm");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "Share of starts from a random angle that reach 900 rpm within 3 s. Each column is of %d "
        "starts; the judged variants have one start per seed. Without load and with the true "
        "parameters. Spread: load 0 .. 2 Nm, Rs +-20 %%, Lq +-15 %%, offsets. Start and control "
        "are the library's; all columns but \"own gains\" use the paper's w0 and sigma.",
        STARTS_SHOWN);
    for (int kind = CASE_START; kind <= CASE_START_SPREAD; ++kind) {
        for (int m = 0; m < METHODS; ++m) {
            char text[64];
            (void)snprintf(text, sizeof text, "%s: starts%s", m == 0 ? "QPLL" : "enhanced",
                           kind == CASE_START ? "" : ", spread");
            const place_t at = {"start",
                                kind == CASE_START ? "plain" : "spread",
                                text,
                                "%",
                                {.kind = (case_kind_t)kind,
                                 .method = (case_method_t)m,
                                 .speed_rpm = 100.0,
                                 .quantity = STARTED}};
            work_share(work_measure(work, &at, kind == CASE_START ? &words : &none), work,
                       &at.source, STARTS_SHOWN);
        }
    }
}
