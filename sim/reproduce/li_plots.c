#include "reproduce/li_plots.h"

#include <complex.h>
#include <math.h>
#include <string.h>

#include "reproduce/panels.h"
#include "support/plot.h"
#include "support/stats.h"
#include "support/units.h"

enum { WIDTH = 1500, POINTS = 700, DRAWN = 2, ORDERS = 25 };

typedef enum { WAVES, RUNS, KNOBS, SWEEP } style_t;

typedef struct {
    const char *file;
    const char *title;
    style_t style;
    li_case_t what; ///< but observer, form and inverter
    double turns;   ///< waves: electrical periods; runs: from when on, s
} drawing_t;

#define WAVE(rpm, load)                                                                            \
    {                                                                                              \
        .stages = 1, .stage = { {.duration_s = 3.0, .speed_rpm = (rpm), .load_Nm = (load)} }       \
    }
#define SET_1(rpm, load)                                                                           \
    {                                                                                              \
        .source = LODE_SOURCE_SET_1, .harmonics = 0.06, .stages = 1, .stage = {                    \
            {.duration_s = 3.0, .speed_rpm = (rpm), .load_Nm = (load)}                             \
        }                                                                                          \
    }

static const drawing_t drawings[LI_PLOTS] = {
    {"fig10.svg", "Fig. 10: no load, 300 rpm (25 Hz), ideal inverter", WAVES, WAVE(300.0, 0.0),
     3.0},
    {"fig11.svg", "Fig. 11: no load, 600 rpm (50 Hz), ideal inverter", WAVES, WAVE(600.0, 0.0),
     3.0},
    {"fig12.svg", "Fig. 12: no load, 840 rpm (70 Hz), ideal inverter", WAVES, WAVE(840.0, 0.0),
     3.0},
    {"fig13.svg", "Fig. 13: set 1 alone, half load, 300 rpm, 6 % of 5th and 7th", WAVES,
     SET_1(300.0, 0.5 * LI_RATED_Nm), 3.0},
    {"fig14.svg", "Fig. 14: set 1 alone, 40 % load, 600 rpm, 6 % of 5th and 7th", WAVES,
     SET_1(600.0, 0.4 * LI_RATED_Nm), 3.0},
    {"fig15.svg",
     "Fig. 15: VSD, 80 % load, 600 rpm, 6 % of 5th and 7th",
     WAVES,
     {.harmonics = 0.06,
      .stages = 1,
      .stage = {{.duration_s = 3.0, .speed_rpm = 600.0, .load_Nm = 0.8 * LI_RATED_Nm}}},
     3.0},
    {"fig16.svg",
     "Fig. 16: 300-600-840-600-300 rpm at 1000 rpm/s, no load",
     RUNS,
     {.stages = 0},
     2.0},
    {"fig17.svg", "Fig. 17: 80 % load (5 Nm) on and off at 600 rpm", RUNS, {.stages = 1}, 2.8},
    {"fig18.svg",
     "Fig. 18: wrong Rs and Lq, FA-LESO, 300 rpm, rated load",
     KNOBS,
     {.stages = 0},
     0.0},
    {"k2.svg", "Which k2 would give Fig. 13?", SWEEP, {.stages = 0}, 0.0},
};

// Of speed, position error and speed error, the same for every observer.
static const double ramp_axes[3][2] = {{200.0, 900.0}, {-35.0, 10.0}, {-5.0, 5.0}};
static const double step_axes[3][2] = {{500.0, 700.0}, {-30.0, 10.0}, {-40.0, 40.0}};
static const double knob_axes[2][2] = {{-10.0, 10.0}, {-2.0, 2.0}};

static const li_column_t drawn[DRAWN] = {LI_PRINTED, LI_EXACT};
static const char *const heads[LI_OBSERVERS] = {"(a) C-LESO", "(b) GI-LESO", "(c) FA-LESO"};

const char *li_plot_file(int k) {
    return drawings[k].file;
}

// ---- Data ---------------------------------------------------------------------------------------

static size_t row_at(const li_log_t *log, double t_s) {
    const double every_s = log->rows > 1 ? log->row[1].t_s - log->row[0].t_s : 1.0;
    const size_t row = (size_t)fmax(0.0, round(t_s / every_s));
    return row < log->rows ? row : log->rows;
}

static bool signals(const rig_config_t *base, const li_case_t *what, li_log_t *log) {
    li_result_t result;
    li_case_t seeded = *what;
    seeded.seed = 1;
    *log = (li_log_t){0, 0, NULL};
    return li_case_run(&seeded, base, &result, log);
}

static void send_waves(FILE *script, const li_log_t *log, int id, double length_s) {
    const double end_s = log->rows > 0 ? log->row[log->rows - 1].t_s : 0.0;
    (void)fprintf(script, "$w%d << END\n", id);
    const size_t from = row_at(log, end_s - length_s);
    for (size_t k = from; k < log->rows; ++k) {
        const li_row_t *row = &log->row[k];
        const li_row_t *before = &log->row[k > from ? k - 1 : k];
        (void)fprintf(script, "%.6g %.5g %.5g %.5g %.5g %.5g\n", row->t_s - (end_s - length_s),
                      row->e_alpha_V, row->e_beta_V,
                      panels_angle_deg(row->theta_est_rad, before->theta_est_rad),
                      panels_angle_deg(row->theta_rad, before->theta_rad), row->error_deg);
    }
    (void)fputs("END\n", script);
}

/// Smallest and largest value of each stretch, so that no peak is lost.
static void send_run(FILE *script, const li_log_t *log, int id, double from_s) {
    const size_t from = row_at(log, from_s);
    const size_t every = (log->rows - from) / POINTS + 1;
    (void)fprintf(script, "$r%d << END\n", id);
    for (size_t start = from; start < log->rows; start += every) {
        rig_stats_t error_deg = {0}, speed_rpm = {0};
        for (size_t k = start; k < start + every && k < log->rows; ++k) {
            rig_stats_add(&error_deg, log->row[k].error_deg);
            rig_stats_add(&speed_rpm, log->row[k].speed_error_rpm);
        }
        const li_row_t *row = &log->row[start];
        (void)fprintf(script, "%.6g %.5g %.5g %.5g\n%.6g %.5g %.5g %.5g\n", row->t_s - from_s,
                      row->speed_rpm, rig_stats_min(&error_deg), rig_stats_min(&speed_rpm),
                      row->t_s - from_s, row->speed_rpm, rig_stats_max(&error_deg),
                      rig_stats_max(&speed_rpm));
    }
    (void)fputs("END\n", script);
}

/// Harmonics of the estimated alpha EMF over the last LI_WINDOW_s, in % of the fundamental.
static void send_spectrum(FILE *script, const li_log_t *log, int id) {
    double complex sum[ORDERS + 1] = {0.0};
    const double end_s = log->rows > 0 ? log->row[log->rows - 1].t_s : 0.0;
    for (size_t k = row_at(log, end_s - LI_WINDOW_s) + 1; k < log->rows; ++k) {
        for (int n = 0; n <= ORDERS; ++n) {
            sum[n] += log->row[k].e_alpha_V * cexp(-I * (double)n * log->row[k].theta_rad);
        }
    }
    (void)fprintf(script, "$s%d << END\n", id);
    for (int n = 2; n <= ORDERS; ++n) {
        (void)fprintf(script, "%d %.5g\n", n, 100.0 * cabs(sum[n]) / cabs(sum[1]));
    }
    (void)fputs("END\n", script);
}

// ---- Figs. 10 to 15 -----------------------------------------------------------------------------

/// Figs. 13 to 15, whose motor has harmonics.
static bool has_spectrum(const drawing_t *drawing) {
    return drawing->what.harmonics > 0.0;
}

static void draw_spectrum(FILE *script, int first) {
    panels_next(script, "harmonics of e_{/Symbol a} [%]", "", true);
    (void)fprintf(script,
                  "set xlabel 'order' offset 0,0.5\n"
                  "set xrange [1:%d]\nset xtics (5,7,11,13,17,19,23,25)\nset yrange [0:7]\n"
                  "plot $s%d using ($1-0.2):2:(0.36) with boxes fs solid lc rgb red title "
                  "'printed', "
                  "$s%d using ($1+0.2):2:(0.36) with boxes fs solid lc rgb blue title 'exact'\n"
                  "set xtics autofreq\nset yrange [*:*]\n",
                  ORDERS + 1, first, first + 1);
}

static void draw_waves(FILE *script, int first, const char *head, double emf_V) {
    panels_next(script, "EMF, printed [V]", head, false);
    (void)fprintf(script,
                  "set yrange [%g:%g]\n"
                  "plot $w%d using 1:2 with lines lc rgb red lw 1.2 title 'e_{/Symbol a}', "
                  "'' using 1:3 with lines lc rgb blue lw 1.2 title 'e_{/Symbol b}'\n",
                  -emf_V, emf_V, first);
    panels_next(script, "position [deg]", "", false);
    (void)fprintf(script,
                  "set yrange [-180:180]\nset ytics 90\n"
                  "plot $w%d using 1:5 with lines lc rgb grey lw 2.4 title 'true', "
                  "'' using 1:4 with lines lc rgb red lw 1 title 'estimated, printed'\n"
                  "set yrange [*:*]\nset ytics autofreq\n",
                  first);
    panels_next(script, "position error [deg]", "", true);
    (void)fprintf(script,
                  "set yrange [-40:10]\n"
                  "plot $w%d using 1:6 with lines lc rgb red lw 1.4 title 'printed', "
                  "$w%d using 1:6 with lines lc rgb blue lw 1.4 title 'exact'\n"
                  "set yrange [*:*]\n",
                  first, first + 1);
}

static bool plot_waves(FILE *script, const drawing_t *drawing, const rig_config_t *base) {
    const double rpm = drawing->what.stage[0].speed_rpm;
    const double w = (double)base->drive.motor.pole_pairs * rig_rad_s_from_rpm(rpm);
    const double length_s = drawing->turns * 2.0 * RIG_PI / w;
    panels_begin(script, drawing->title, has_spectrum(drawing) ? 4 : 3, LI_OBSERVERS);
    for (int o = 0; o < LI_OBSERVERS; ++o) {
        for (int c = 0; c < DRAWN; ++c) {
            li_case_t what = drawing->what;
            li_log_t log;
            what.observer = (li_observer_t)o;
            what = li_case_in(what, drawn[c]);
            if (!signals(base, &what, &log)) {
                return false;
            }
            send_waves(script, &log, DRAWN * o + c, length_s);
            send_spectrum(script, &log, DRAWN * o + c);
            li_log_free(&log);
        }
        (void)fprintf(script, "set xrange [0:%g]\n", length_s);
        draw_waves(script, DRAWN * o, heads[o], 1.2 * w * (double)base->drive.motor.psi_Wb);
        if (has_spectrum(drawing)) {
            draw_spectrum(script, DRAWN * o);
        }
    }
    return true;
}

// ---- Figs. 16, 17 -------------------------------------------------------------------------------

static void draw_curves(FILE *script, int first, int column, const double axis[2],
                        const char *third) {
    (void)fprintf(script, "set yrange [%g:%g]\n", axis[0], axis[1]);
    (void)fprintf(script,
                  "plot $r%d using 1:%d with lines lc rgb red lw 1 title 'printed', "
                  "$r%d using 1:%d with lines lc rgb blue lw 1.2 title 'exact'",
                  first, column, first + 1, column);
    if (third[0] != '\0') {
        (void)fprintf(script, ", $r%d using 1:%d with lines lc rgb green lw 1.2 title '%s'",
                      first + DRAWN, column, third);
    }
    (void)fputc('\n', script);
}

static li_case_t run_case(bool ramps, li_observer_t observer, li_column_t column, double k2_rad_s) {
    return li_case_in(ramps ? li_ramp_case(observer) : li_step_case(observer, k2_rad_s), column);
}

static bool plot_runs(FILE *script, const drawing_t *drawing, const rig_config_t *base) {
    const bool ramps = drawing->what.stages == 0;
    const double(*axes)[2] = ramps ? ramp_axes : step_axes;
    panels_begin(script, drawing->title, 3, LI_OBSERVERS);
    (void)fputs("set autoscale xfix\n", script);
    for (int o = 0; o < LI_OBSERVERS; ++o) {
        const bool more = !ramps && o == LI_FA;
        for (int c = 0; c < DRAWN + (more ? 1 : 0); ++c) {
            const li_case_t what = run_case(
                ramps, (li_observer_t)o, c < DRAWN ? drawn[c] : LI_EXACT, c < DRAWN ? 0.0 : 600.0);
            li_log_t log;
            if (!signals(base, &what, &log)) {
                return false;
            }
            send_run(script, &log, (DRAWN + 1) * o + c, drawing->turns);
            li_log_free(&log);
        }
        const char *third = more ? "k2 = 600" : "";
        panels_next(script, "speed [rpm]", heads[o], false);
        draw_curves(script, (DRAWN + 1) * o, 2, axes[0], third);
        panels_next(script, "position error [deg]", "", false);
        draw_curves(script, (DRAWN + 1) * o, 3, axes[1], third);
        panels_next(script, "speed error [rpm]", "", true);
        draw_curves(script, (DRAWN + 1) * o, 4, axes[2], third);
    }
    return true;
}

// ---- Fig. 18 ------------------------------------------------------------------------------------

static bool plot_knobs(FILE *script, const drawing_t *drawing, const rig_config_t *base) {
    static const double factor[] = {1.0, 0.5, 1.0, 1.5};
    panels_begin(script, drawing->title, 2, 2);
    (void)fputs("set autoscale xfix\n", script);
    for (int Lq = 0; Lq < 2; ++Lq) {
        for (int c = 0; c < DRAWN; ++c) {
            li_case_t what = li_case_in((li_case_t){.observer = LI_FA, .stages = 4}, drawn[c]);
            li_log_t log;
            for (int k = 0; k < what.stages; ++k) {
                what.stage[k] = (li_stage_t){.duration_s = k == 0 ? 2.0 : 1.5,
                                             .speed_rpm = 300.0,
                                             .load_Nm = LI_RATED_Nm,
                                             .Rs_factor = Lq == 1 ? 1.0 : factor[k],
                                             .Lq_factor = Lq == 1 ? factor[k] : 1.0};
            }
            if (!signals(base, &what, &log)) {
                return false;
            }
            send_run(script, &log, DRAWN * Lq + c, 1.5);
            li_log_free(&log);
        }
        panels_next(script, "position error [deg]",
                    Lq == 1 ? "(b) assumed over true Lq: 1, 0.5, 1, 1.5"
                            : "(a) assumed over true Rs: 1, 0.5, 1, 1.5",
                    false);
        draw_curves(script, DRAWN * Lq, 3, knob_axes[0], "");
        panels_next(script, "speed error [rpm]", "", true);
        draw_curves(script, DRAWN * Lq, 4, knob_axes[1], "");
    }
    return true;
}

// ---- The sweep of k2 ----------------------------------------------------------------------------

static const row_t *find(const table_t *table, const char *id) {
    for (int k = 0; k < table->rows; ++k) {
        if (strcmp(table->row[k].id, id) == 0) {
            return &table->row[k];
        }
    }
    return NULL;
}

static void plot_sweep(FILE *script, const drawing_t *drawing, const table_t *table) {
    static const char *const quantities[] = {"5", "7", "step"};
    panels_begin(script, drawing->title, 2, 1);
    (void)fputs("$k << END\n", script);
    for (int k = 0; k < LI_SWEEP; ++k) {
        (void)fprintf(script, "%g", li_sweep_k2[k]);
        for (int n = 0; n < 3; ++n) {
            char id[48];
            (void)snprintf(id, sizeof id, "k2_%.0f_%s", li_sweep_k2[k], quantities[n]);
            const row_t *row = find(table, id);
            (void)fprintf(script, " %.5g %.5g", row != NULL ? row->theory : NAN,
                          row != NULL ? row->value[LI_EXACT] : NAN);
        }
        (void)fputc('\n', script);
    }
    (void)fputs(
        "END\nset logscale x\nset xrange [55:650]\nset xtics (60,75,112,150,200,314,450,600)\n",
        script);
    panels_next(script, "FA-LESO over C-LESO [%]",
                "set 1, half load, 300 rpm; dotted: the paper's, with k2 = 314", false);
    (void)fputs(
        "plot $k using 1:2 with lines lc rgb red lw 1 title '5th, theory', "
        "'' using 1:3 with linespoints lc rgb red pt 7 ps 0.7 title 'measured', "
        "'' using 1:4 with lines lc rgb blue lw 1 title '7th, theory', "
        "'' using 1:5 with linespoints lc rgb blue pt 7 ps 0.7 title 'measured', "
        "14.8 with lines dt 3 lc rgb red notitle, 11.9 with lines dt 3 lc rgb blue notitle\n",
        script);
    (void)fputs("unset label 1000\n", script);
    panels_next(script, "5 Nm at 600 rpm: angle [deg]",
                "largest deviation in the load step; no point: the rotor is lost", true);
    (void)fputs("set xlabel 'k2 [rad/s]' offset 0,0.5\n"
                "plot $k using 1:7 with linespoints lc rgb green pt 7 ps 0.7 notitle\n",
                script);
}

bool li_plot(const plot_output_t *output, int k, const table_t *table, const rig_config_t *base) {
    const drawing_t *drawing = &drawings[k];
    const int rows =
        drawing->style == KNOBS || drawing->style == SWEEP ? 2 : (has_spectrum(drawing) ? 4 : 3);
    plot_t plot;
    if (!plot_start(&plot, output, drawing->title, WIDTH, panels_height(rows))) {
        return false;
    }
    bool good = true;
    switch (drawing->style) {
    case WAVES:
        good = plot_waves(plot.script, drawing, base);
        break;
    case RUNS:
        good = plot_runs(plot.script, drawing, base);
        break;
    case KNOBS:
        good = plot_knobs(plot.script, drawing, base);
        break;
    case SWEEP:
    default:
        plot_sweep(plot.script, drawing, table);
        break;
    }
    (void)fputs("unset multiplot\n", plot.script);
    return plot_finish(&plot) && good;
}
