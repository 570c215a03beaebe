#include <math.h>
#include <stdio.h>

#include "reproduce/tables.h"
#include "reproduce/work.h"
#include "support/units.h"

#define NOTCH_K 0.5
#define HANDOVER_rpm 100.0

static void table_1(work_t *work) {
    static const char *const what[] = {"QPLL: step of position",   "QPLL: step of speed",
                                       "QPLL: ramp of speed",      "LESO-QPLL: step of position",
                                       "LESO-QPLL: step of speed", "LESO-QPLL: ramp of speed"};
    const theory_t *t = work->theory;
    figure_t *figure =
        work_figure(work, "table1", "Table 1: error after 0.5 s behind a moving angle");
    const double r = t->np * rig_rad_s_from_rpm(CASE_RAMP_rpm_s);
    const double lag_deg = -rig_deg_from_rad(r / (t->sigma * t->sigma));
    (void)snprintf(figure->note, sizeof figure->note,
                   "The PLLs alone, with a perfect EMF: steps of 30 deg and 10 rad/s, and a ramp "
                   "of r = %.0f rad/s^2 (2000 rpm/s).",
                   r);
    for (int k = 0; k < 6; ++k) {
        char id[48];
        const double claimed_deg = k == 2 ? lag_deg : 0.0;
        const words_t words = {.claim = CLAIM_FORMULA,
                               .claimed = claimed_deg,
                               .theory = claimed_deg,
                               .formula = k == 2 ? "-r/Ki" : "0"};
        (void)snprintf(id, sizeof id, "table1_%d", k + 1);
        row_t *row = table_row(work->table, "table1", id, what[k], "deg", &words);
        row->value[COLUMN_PRINTED] = tables_tracking_deg(t, k >= 3, k % 3, true);
        row->value[COLUMN_EXACT] = tables_tracking_deg(t, k >= 3, k % 3, false);
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
    const theory_t *t = work->theory;
    figure_t *figure = work_figure(work, "table2", "Table 2: enhanced PLL, k = 0.1, 600 rad/s");
    (void)snprintf(figure->note, sizeof figure->note,
                   "Printed: eqs. 35 and 36 as they stand. Theory: the notch with ((s + sigma)^3 - "
                   "s^3)/s^3, as eq. 21 gives. Exact: the sampled form at 5 kHz.");
    for (int s = 0; s < 3; ++s) {
        const double sigma = 80.0 + 40.0 * s;
        const theory_loop_t right = theory_loop(sigma, 0.1, 600.0, false);
        const theory_loop_t printed = theory_loop(sigma, 0.1, 600.0, true);
        const theory_loop_t sampled = theory_loop_sampled(sigma, 0.1, 600.0, t->ts_s);
        for (int k = 0; k < 4; ++k) {
            char id[48];
            char text[64];
            const words_t words = {.claim = CLAIM_FORMULA,
                                   .claimed = claimed[s][k],
                                   .theory = loop_figure(&right, k),
                                   .formula = "from notch ((s + sigma)^3 - s^3)/s^3"};
            (void)snprintf(id, sizeof id, "table2_%.0f_%d", sigma, k + 1);
            (void)snprintf(text, sizeof text, "sigma %.0f: %s", sigma, what[k]);
            row_t *row = table_row(work->table, "table2", id, text, unit[k], &words);
            row->value[COLUMN_PRINTED] = loop_figure(&printed, k);
            row->value[COLUMN_EXACT] = loop_figure(&sampled, k);
        }
    }
}

/// Section 4.4: "as sigma increases, the phase margin increases".
static void margin_rises(work_t *work) {
    const double low = theory_loop(80.0, 0.1, 600.0, false).margin_deg;
    const double high = theory_loop(160.0, 0.1, 600.0, false).margin_deg;
    const words_t words = {.claim = CLAIM_AT_LEAST,
                           .claimed = 0.0,
                           .theory = high - low,
                           .formula = "of the loop that gives Table 2"};
    row_t *row = table_row(work->table, "table2", "table2_margin_rises",
                           "margin, sigma 160 less sigma 80", "deg", &words);
    const double Ts = work->theory->ts_s;
    const double values[FORMS] = {theory_loop(160.0, 0.1, 600.0, true).margin_deg -
                                      theory_loop(80.0, 0.1, 600.0, true).margin_deg,
                                  high - low,
                                  theory_loop_sampled(160.0, 0.1, 600.0, Ts).margin_deg -
                                      theory_loop_sampled(80.0, 0.1, 600.0, Ts).margin_deg};
    row->value[COLUMN_PRINTED] = values[0];
    row->value[COLUMN_EXACT] = values[2];
    work_form_values(row, work->table->paper, values);
    (void)snprintf(row->because, sizeof row->because,
                   "The paper's own Table 2 has 58 for 68 deg. Here \"Euler\" stands for eq. 35 as "
                   "printed");
}

static void figure_7(work_t *work) {
    const theory_t *t = work->theory;
    figure_t *figure = work_figure(work, "fig7", "Fig. 7: observer, notch and PLL as one loop");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "k = %g, no current, rotor at constant speed. The claim is Section 5's: closed loop from "
        "%.0f rpm on, with margins that are \"almost the same\" at every speed (Section 4.4). The "
        "library's exact form is not in this row, because it fades its notch out at such speeds.",
        NOTCH_K, HANDOVER_rpm);
    const double value[FORMS] = {tables_lowest_stable_rpm(t, NOTCH_K, false),
                                 tables_lowest_stable_rpm(t, NOTCH_K, true), NAN};
    const words_t words = {.claim = CLAIM_AT_MOST, .claimed = HANDOVER_rpm, .theory = NAN};
    row_t *row =
        table_row(work->table, "fig7", "fig7_lowest", "stable from this speed on", "rpm", &words);
    row->value[COLUMN_PRINTED] = value[0];
    work_form_values(row, work->table->paper, value);
    row->ran[table_variant(work->table->paper, (const int[AXES]){2, 0, 0})] = false;
}

void work_tables(work_t *work) {
    table_1(work);
    table_2(work);
    margin_rises(work);
    figure_7(work);
}
