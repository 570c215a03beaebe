#include "reproduce/plots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reproduce/panels.h"
#include "support/units.h"

enum { WIDTH = 1300, COLUMNS = 2, POINTS = 900, DRAWN = 3 };

typedef enum { WAVES, RUNS, LEVELS } style_t;

typedef struct {
    const char *file;
    const char *title;
    style_t style;
    case_kind_t kind;
    double speed_rpm;
} drawing_t;

static const drawing_t drawings[REPRODUCE_PLOTS] = {
    {"fig12.svg", "Fig. 12: conventional QPLL, no load", WAVES, CASE_NO_LOAD, 0.0},
    {"fig13.svg", "Fig. 13: conventional QPLL, rated load", WAVES, CASE_RATED, 0.0},
    {"fig14.svg", "Fig. 14: 300 .. 1500 rpm, no load", RUNS, CASE_STAIRCASE, 300.0},
    {"fig15.svg", "Fig. 15: 300 .. 1500 rpm, rated load", RUNS, CASE_STAIRCASE_RATED, 300.0},
    {"fig16.svg", "Fig. 16: load 5 -> 0 Nm at 300 rpm", RUNS, CASE_RATED, 300.0},
    {"fig17.svg", "Fig. 17: load 5 -> 0 Nm at 1500 rpm", RUNS, CASE_RATED, 1500.0},
    {"fig18.svg", "Fig. 18: wrong Lq and Rs at 300 rpm, rated load, enhanced PLL", LEVELS,
     CASE_LQ_DOWN, 300.0},
    {"fig19.svg", "Fig. 19: wrong Lq and Rs at 1500 rpm, rated load, enhanced PLL", LEVELS,
     CASE_LQ_DOWN, 1500.0},
};

/// The library's own gains stand beside the others in Figs. 18 and 19.
static case_t drawn_case(case_kind_t kind, case_method_t method, int drawn, double speed_rpm) {
    static const case_chain_t chains[DRAWN + 1] = {CHAIN_PRINTED, CHAIN_EXACT, CHAIN_CORRECTED,
                                                   CHAIN_LIBRARY};
    return (case_t){.kind = kind,
                    .method = method,
                    .chain = chains[drawn],
                    .inverter = drawn < 2 ? CASE_BARE : CASE_COMPENSATED,
                    .speed_rpm = speed_rpm,
                    .seed = 1};
}

const char *reproduce_plot_file(int k) {
    return drawings[k].file;
}

// ---- Figs. 12 and 13: a few electrical periods --------------------------------------------------

static size_t row_at(const runlog_t *log, double t_s) {
    const double every_s = log->row[1].t_s - log->row[0].t_s;
    const size_t row = (size_t)fmax(0.0, round(t_s / every_s));
    return row < log->rows ? row : log->rows - 1;
}

static void send_waves(FILE *script, const runlog_t *log, int id, double from_s, double to_s) {
    (void)fprintf(script, "$w%d << END\n", id);
    const size_t from = row_at(log, from_s);
    for (size_t k = from; k < row_at(log, to_s); ++k) {
        const runlog_row_t *row = &log->row[k];
        const runlog_row_t *before = &log->row[k > from ? k - 1 : k];
        (void)fprintf(script, "%.6g %.5g %.5g %.5g %.5g %.5g %.5g %.5g\n", row->t_s - from_s,
                      row->e_alpha_V, row->e_beta_V, row->e_true_alpha_V, row->e_true_beta_V,
                      panels_angle_deg(row->theta_est_rad, before->theta_est_rad),
                      panels_angle_deg(row->theta_e_rad, before->theta_e_rad),
                      row->angle_error_deg);
    }
    (void)fputs("END\n", script);
}

static void draw_waves(FILE *script, int first, const char *name) {
    char title[64];
    (void)snprintf(title, sizeof title, "%s", name);
    panels_next(script, "EMF [V]", title, false);
    (void)fprintf(script,
                  "plot $w%d using 1:4 with lines lc rgb grey lw 2 title 'true', "
                  "'' using 1:5 with lines lc rgb grey lw 2 notitle, "
                  "'' using 1:2 with lines lc rgb red lw 1 title 'e_{/Symbol a}', "
                  "'' using 1:3 with lines lc rgb blue lw 1 title 'e_{/Symbol b}'\n",
                  first);
    panels_next(script, "position [deg]", "", false);
    (void)fprintf(script,
                  "set yrange [-180:180]\nset ytics 90\n"
                  "plot $w%d using 1:7 with lines lc rgb grey lw 2 title 'true', "
                  "'' using 1:6 with lines lc rgb red lw 1 title 'estimated, as printed'\n"
                  "set yrange [*:*]\nset ytics autofreq\n",
                  first);
    panels_next(script, "position error [deg]", "", true);
    (void)fprintf(script,
                  "plot $w%d using 1:8 with lines lc rgb red lw 1.2 title 'as printed', "
                  "$w%d using 1:8 with lines lc rgb blue lw 1.2 title 'exact', "
                  "$w%d using 1:8 with lines lc rgb green lw 1.6 title 'corrected'\n",
                  first, first + 1, first + 2);
}

static bool plot_waves(FILE *script, const drawing_t *drawing, const case_bases_t *bases) {
    static const double speeds[] = {300.0, 1500.0};
    panels_begin(script, drawing->title, 3, COLUMNS);
    for (int s = 0; s < 2; ++s) {
        const double length_s = 3.0 * 60.0 / (3.0 * speeds[s]); // three electrical periods
        for (int c = 0; c < DRAWN; ++c) {
            const case_t what = drawn_case(drawing->kind, METHOD_QPLL, c, speeds[s]);
            runlog_t log;
            if (!reproduction_signals(bases, &what, &log)) {
                return false;
            }
            const double end_s =
                what.kind == CASE_RATED ? case_last_phase_s(&what) : log.row[log.rows - 1].t_s;
            send_waves(script, &log, DRAWN * s + c, end_s - length_s, end_s);
            runlog_free(&log);
        }
        draw_waves(script, DRAWN * s, s == 0 ? "(a) 300 rpm" : "(b) 1500 rpm");
    }
    return true;
}

// ---- Figs. 14 to 17: whole runs -----------------------------------------------------------------

/// Smallest and largest value of each stretch, so that no peak is lost. A lost angle is cut off.
static void send_run(FILE *script, const runlog_t *log, int id, double from_s, double to_s) {
    const size_t from = row_at(log, from_s);
    const size_t to = row_at(log, to_s);
    const size_t every = (to - from) / POINTS + 1;
    (void)fprintf(script, "$r%d << END\n", id);
    for (size_t start = from; start < to; start += every) {
        rig_stats_t error_deg = {0}, speed_rpm = {0};
        for (size_t k = start; k < start + every && k < to; ++k) {
            const runlog_row_t *row = &log->row[k];
            rig_stats_add(&error_deg, row->angle_error_deg);
            rig_stats_add(&speed_rpm, row->speed_est_rpm - row->speed_rpm);
        }
        const runlog_row_t *row = &log->row[start];
        (void)fprintf(script, "%.6g %.5g %.5g %.5g\n%.6g %.5g %.5g %.5g\n", row->t_s - from_s,
                      row->speed_rpm, rig_stats_min(&error_deg), rig_stats_min(&speed_rpm),
                      row->t_s - from_s, row->speed_rpm, rig_stats_max(&error_deg),
                      rig_stats_max(&speed_rpm));
    }
    (void)fputs("END\n", script);
}

static void draw_curves(FILE *script, int first, int column, const char *range) {
    (void)fprintf(script,
                  "set yrange [%s]\n"
                  "plot $r%d using 1:%d with lines lc rgb red lw 1 title 'as printed', "
                  "$r%d using 1:%d with lines lc rgb blue lw 1 title 'exact', "
                  "$r%d using 1:%d with lines lc rgb green lw 1.4 title 'corrected'\n"
                  "set yrange [*:*]\n",
                  range, first, column, first + 1, column, first + 2, column);
}

static bool plot_runs(FILE *script, const drawing_t *drawing, const case_bases_t *bases) {
    const bool step = drawing->kind == CASE_RATED;
    panels_begin(script, drawing->title, 3, COLUMNS);
    (void)fputs("set autoscale xfix\n", script);
    for (int m = 0; m < METHODS; ++m) {
        for (int c = 0; c < DRAWN; ++c) {
            const case_t what = drawn_case(drawing->kind, (case_method_t)m, c, drawing->speed_rpm);
            runlog_t log;
            if (!reproduction_signals(bases, &what, &log)) {
                return false;
            }
            const double from_s = step ? case_last_phase_s(&what) - 0.2 : case_released_s();
            const double to_s = step ? from_s + 0.9 : log.row[log.rows - 1].t_s;
            send_run(script, &log, DRAWN * m + c, from_s, to_s);
            runlog_free(&log);
        }
        panels_next(script, "speed [rpm]",
                    m == 0 ? "(a) conventional QPLL" : "(b) enhanced LESO-QPLL", false);
        draw_curves(script, DRAWN * m, 2, "*:*");
        panels_next(script, "position error [deg]", "", false);
        draw_curves(script, DRAWN * m, 3, "-100<*:*<100");
        panels_next(script, "speed error [rpm]", "", true);
        draw_curves(script, DRAWN * m, 4, "-300<*:*<300");
    }
    return true;
}

// ---- Figs. 18 and 19: errors over the factor ----------------------------------------------------

static void send_levels(FILE *script, const drawing_t *drawing, const case_bases_t *bases,
                        case_kind_t down, int id) {
    case_result_t result;
    (void)fprintf(script, "$l%d << END\n", id);
    for (int half = 0; half < 2; ++half) {
        const case_kind_t kind = half == 0 ? down : (case_kind_t)((int)down + 1);
        double factor[CASE_LEVELS_MAX];
        const int levels = case_levels(kind, factor);
        double rows[DRAWN + 1][CASE_LEVELS_MAX][2];
        for (int c = 0; c <= DRAWN; ++c) {
            const case_t what = drawn_case(kind, METHOD_ENHANCED, c, drawing->speed_rpm);
            (void)case_run(&what, bases, &result, NULL);
            for (int k = 0; k < levels; ++k) {
                rows[c][k][0] = result.level_dc_deg[k];
                rows[c][k][1] = result.level_speed_rpm[k];
            }
        }
        for (int n = 0; n < levels; ++n) {
            const int k = half == 0 ? levels - 1 - n : n;
            (void)fprintf(script, "%g", factor[k]);
            for (int c = 0; c <= DRAWN; ++c) {
                (void)fprintf(script, " %.5g %.5g", rows[c][k][0], rows[c][k][1]);
            }
            (void)fputc('\n', script);
        }
    }
    (void)fputs("END\n", script);
}

static void send_closed_form(FILE *script, const theory_t *t, double rpm) {
    (void)fputs("$theory << END\n", script);
    for (int k = 0; k <= 75; ++k) {
        const double factor = 0.5 + 0.02 * k;
        double pull_out_Nm = 0.0;
        (void)fprintf(script, "%g %.5g\n", factor,
                      theory_mismatch_deg(t, rpm, CASE_RATED_Nm, factor, &pull_out_Nm));
    }
    (void)fputs("END\n", script);
}

static void draw_levels(FILE *script, int id, int quantity, const char *extra) {
    static const char *const names[] = {"as printed", "exact", "corrected", "own gains"};
    static const char *const colours[] = {"red", "blue", "green", "'#b07aa1'"};
    (void)fprintf(script, "plot %s", extra);
    for (int c = 0; c <= DRAWN; ++c) {
        (void)fprintf(script,
                      "%s $l%d using 1:%d with linespoints lc rgb %s pt 7 ps 0.6 lw 1.3 title '%s'",
                      c > 0 ? "," : "", id, 2 + 2 * c + quantity, colours[c], names[c]);
    }
    (void)fputc('\n', script);
}

static bool plot_levels(FILE *script, const drawing_t *drawing, const reproduction_t *reproduction,
                        const case_bases_t *bases) {
    const bool fast = drawing->speed_rpm > 1000.0;
    panels_begin(script, drawing->title, 2, COLUMNS);
    send_closed_form(script, &reproduction->theory, drawing->speed_rpm);
    (void)fprintf(script, "$claimed << END\n0.5 %g\n2 %g\nEND\n", fast ? -12.0 : -9.0,
                  fast ? -40.0 : -25.0);
    for (int p = 0; p < 2; ++p) {
        send_levels(script, drawing, bases, p == 0 ? CASE_LQ_DOWN : CASE_RS_DOWN, p);
        panels_next(script, "position error [deg]", p == 0 ? "(a) Lq^/Lq" : "(b) Rs^/Rs", false);
        (void)fputs("set xrange [0.4:2.1]\nset yrange [-45:30]\n", script);
        draw_levels(script, p, 0,
                    p == 0 ? "$theory using 1:2 with lines lc rgb grey lw 3 title 'closed form', "
                             "$claimed using 1:2 with points lc rgb '#000000' pt 2 ps 1.2 title "
                             "'claimed', "
                           : "");
        panels_next(script, "speed error [rpm]", "", true);
        (void)fputs("set xlabel 'factor' offset 0,0.5\nset yrange [-5:5]\n", script);
        draw_levels(script, p, 1, "");
    }
    return true;
}

bool reproduce_plot(const plot_output_t *output, int k, const reproduction_t *reproduction,
                    const case_bases_t *bases) {
    const drawing_t *drawing = &drawings[k];
    const int rows = drawing->style == LEVELS ? 2 : 3;
    plot_t plot;
    if (!plot_start(&plot, output, drawing->title, WIDTH, panels_height(rows))) {
        return false;
    }
    bool good = false;
    switch (drawing->style) {
    case WAVES:
        good = plot_waves(plot.script, drawing, bases);
        break;
    case RUNS:
        good = plot_runs(plot.script, drawing, bases);
        break;
    case LEVELS:
    default:
        good = plot_levels(plot.script, drawing, reproduction, bases);
        break;
    }
    (void)fputs("unset multiplot\n", plot.script);
    return plot_finish(&plot) && good;
}
