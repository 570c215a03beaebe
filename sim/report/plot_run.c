#include "report/plot_run.h"

#include <math.h>
#include <string.h>

#include "report/report_run.h"

enum { WIDTH = 1200, HEIGHT = 1262, TOP = 157, LEGEND = 180, PANELS = 6, POINTS = 2400 };
// With signal injection two more, of the same height.
enum { PANELS_BY_WAVE = 8, HEIGHT_BY_WAVE = 1622 };

/// A value that exists only in RUN, or not at all.
static double shown(bool there, double value) {
    return there ? value : NAN;
}

/// One point of every curve. NaN leaves a gap.
static void send_rows(FILE *script, const runlog_t *log) {
    const size_t every = log->rows / POINTS + 1;
    (void)fputs("$run << END\n", script);
    for (size_t k = 0; k < log->rows; k += every) {
        const runlog_row_t *row = &log->row[k];
        const bool sensorless = row->mode == (double)LODE_MODE_RUN;
        // With the gates off the estimator is reset in every period.
        const bool driven =
            row->mode >= (double)LODE_MODE_VOLTAGE && row->mode <= (double)LODE_MODE_RUN;
        (void)fprintf(
            script,
            "%.6g %.5g %.5g %.5g %.4g %.4g %.4g %.4g %.4g %.4g %.4g %g %.3g %.4g %.4g "
            "%.4g %.4g %.4g %.4g %.5g %.5g\n",
            row->t_s, row->speed_command_rpm, row->speed_rpm, shown(sensorless, row->speed_est_rpm),
            row->id_A, row->iq_A, shown(sensorless, row->i1_ref_A),
            shown(sensorless, row->i2_ref_A), shown(driven, hypot(row->e_alpha_V, row->e_beta_V)),
            hypot(row->e_true_alpha_V, row->e_true_beta_V), row->load_Nm, row->mode,
            shown(driven, row->lock), hypot(row->ix_A, row->iy_A), row->torque_Nm,
            shown(sensorless, row->load_est_Nm), shown(row->w_h > 0.0, row->er_h_deg),
            shown(sensorless, row->er_e_deg), row->w_h, 1e3 * row->Lq_H, 1e3 * row->Lq_est_H);
    }
    (void)fputs("END\n", script);
}

/// Writes the smallest and largest error of each stretch, so that no peak is lost. Returns the largest of all.
static double send_errors(FILE *script, const runlog_t *log) {
    const size_t every = log->rows / POINTS + 1;
    double peak = 0.0;
    (void)fputs("$error << END\n", script);
    for (size_t from = 0; from < log->rows; from += every) {
        rig_stats_t stats;
        rig_stats_reset(&stats);
        for (size_t k = from; k < from + every && k < log->rows; ++k) {
            if (log->row[k].mode == (double)LODE_MODE_RUN) {
                rig_stats_add(&stats, log->row[k].angle_error_deg);
            }
        }
        (void)fprintf(script, "%.6g %.4g\n%.6g %.4g\n", log->row[from].t_s, rig_stats_min(&stats),
                      log->row[from].t_s, rig_stats_max(&stats));
        peak = stats.count > 0 ? fmax(peak, rig_stats_peak(&stats)) : peak;
    }
    (void)fputs("END\n", script);
    return peak;
}

/// Phase boundaries in all panels; names above the first one.
static void send_phases(FILE *script, const runner_result_t *result) {
    for (int k = 0; k < result->phases; ++k) {
        const runner_phase_t *phase = &result->phase[k];
        char name[PLOT_TEXT_LENGTH];
        (void)fprintf(script,
                      "set arrow %d from %.6g, graph 0 to %.6g, graph 1 nohead back lw 0.8 "
                      "lc rgb '#c8ccd0'\n"
                      "set label %d %s at %.6g, graph 1.05 left noenhanced font ',10' "
                      "textcolor rgb '#555555' rotate by 55\n",
                      k + 1, phase->start_s, phase->start_s, k + 1, plot_text(name, phase->name),
                      phase->start_s);
    }
}

/// The QPLL has no estimate of the load.
static bool estimates_load(const runlog_t *log) {
    for (size_t k = 0; k < log->rows; ++k) {
        if (fabs(log->row[k].load_est_Nm) > 0.0) {
            return true;
        }
    }
    return false;
}

static void send_speed(FILE *script, int phases) {
    plot_panel(script, "speed [rpm]");
    (void)fprintf(script,
                  "plot $run using 1:2 with steps lc rgb grey lw 1.4 title 'wanted', "
                  "'' using 1:3 with lines lc rgb blue lw 2 title 'true', "
                  "'' using 1:4 with lines lc rgb red lw 1 title 'estimated'\n"
                  "do for [k=1:%d] { unset label k }\nunset label 1000\n",
                  phases);
}

static void send_error(FILE *script, double peak_deg) {
    const double range_deg = fmax(1.0, ceil(1.1 * peak_deg));
    plot_panel(script, "angle error [deg el.]");
    (void)fprintf(script,
                  "set yrange [-%g:%g]\n"
                  "plot $error using 1:2 with lines lc rgb red lw 1 title \"estimate\\n- truth\"\n"
                  "set yrange [*:*]\n",
                  range_deg, range_deg);
}

static void send_currents(FILE *script, int sets) {
    plot_panel(script, "current [A]");
    (void)fputs("plot $run using 1:8 with lines lc rgb grey lw 2 title 'i_q, wanted', "
                "'' using 1:5 with lines lc rgb green lw 1 title 'i_d', "
                "'' using 1:6 with lines lc rgb blue lw 1 title 'i_q'",
                script);
    if (sets > 1) {
        (void)fputs(", '' using 1:14 with lines lc rgb red lw 0.8 title '|i_{xy}|'", script);
    }
    (void)fputc('\n', script);
}

static void send_torque(FILE *script, bool estimated) {
    plot_panel(script, "torque [Nm]");
    (void)fputs("plot $run using 1:15 with lines lc rgb blue lw 0.8 title 'motor', "
                "'' using 1:11 with steps lc rgb grey lw 2 title 'load'",
                script);
    if (estimated) {
        (void)fputs(", '' using 1:16 with lines lc rgb red lw 1 title 'load, estimated'", script);
    }
    (void)fputc('\n', script);
}

static void send_emf(FILE *script) {
    plot_panel(script, "EMF amplitude [V]");
    (void)fputs("set yrange [0:*]\n"
                "plot $run using 1:10 with lines lc rgb blue lw 2 title 'true', "
                "'' using 1:9 with lines lc rgb red lw 1 title 'raw estimate'\n"
                "set yrange [*:*]\n",
                script);
}

/// Position errors from both sources, and Lq: the value in the drive and the true one.
static void send_injection(FILE *script) {
    plot_panel(script, "position error [deg el.]");
    (void)fputs("set yrange [-30:30]\n"
                "plot $run using 1:18 with lines lc rgb grey lw 1 title 'by EMF, e_e', "
                "'' using 1:17 with lines lc rgb blue lw 0.6 title 'by injection, e_h', "
                "'' using 1:(10*$19) with lines lc rgb red lw 2 title 'w_h (10: alone)'\n"
                "set yrange [*:*]\n",
                script);
    plot_panel(script, "Lq [mH]");
    (void)fputs("set yrange [0:*]\n"
                "plot $run using 1:20 with lines lc rgb blue lw 2 title 'true, psi_q/i_q', "
                "'' using 1:21 with steps lc rgb red lw 1.4 title 'in the drive'\n"
                "set yrange [*:*]\n",
                script);
}

static void send_state(FILE *script) {
    plot_panel(script, "state");
    (void)fputs("set format x '%g'\nset xlabel 'time [s]' offset 0,0.4\nset yrange [-0.4:7.4]\n"
                "set ytics ('off' 0, 'calibrate' 1, 'voltage' 2, 'current' 3, 'start' 4, "
                "'run' 5, 'fault' 6, 'precharge' 7) font ',10'\n"
                "plot $run using 1:12 with steps lc rgb blue lw 2 title 'mode', "
                "'' using 1:(5*$13) with lines lc rgb green lw 1 title 'lock (1: at run)'\n"
                "unset multiplot\n",
                script);
}

bool plot_run(const plot_output_t *output, const char *title, const runner_result_t *result,
              const runlog_t *log) {
    plot_t plot;
    if (log->rows == 0) {
        return true;
    }
    const int height = log->by_wave ? HEIGHT_BY_WAVE : HEIGHT;
    if (!plot_start(&plot, output, title, WIDTH, height)) {
        return false;
    }
    send_rows(plot.script, log);
    const double peak_deg = send_errors(plot.script, log);
    const plot_frame_t frame = {WIDTH,
                                height,
                                TOP,
                                LEGEND,
                                log->by_wave ? PANELS_BY_WAVE : PANELS,
                                0.0,
                                result->simulated_s};
    plot_style(plot.script, title, &frame);
    send_phases(plot.script, result);
    send_speed(plot.script, result->phases);
    send_error(plot.script, peak_deg);
    send_currents(plot.script, log->sets);
    send_torque(plot.script, estimates_load(log));
    send_emf(plot.script);
    if (log->by_wave) {
        send_injection(plot.script);
    }
    send_state(plot.script);
    return plot_finish(&plot);
}
