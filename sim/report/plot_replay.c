#include "report/plot_replay.h"

#include <math.h>

#include "support/units.h"

enum {
    WIDTH = 1100,
    TOP = 50,
    LEGEND = 180,
    FRAME_HEIGHT = 110,
    PANEL_HEIGHT = 180,
    PANELS = 5,
    POINTS = 2400
};

/// Draws a stretch of rows with estimates as one point of every curve, with both extremes of the error. Without
/// lock no angle and no speed are drawn. Returns the largest error drawn.
static double send_stretch(FILE *script, const recording_t *recording, const replay_t *replay,
                           size_t from, size_t to, double pole_pairs) {
    rig_stats_t error;
    rig_stats_reset(&error);
    for (size_t k = from; k < to; ++k) {
        if (replay->row[k].lock >= LODE_LOCK_LOST) {
            rig_stats_add(&error, replay->error_deg[k]);
        }
    }
    const lode_estimate_t *row = &replay->row[from];
    const recording_row_t *truth = &recording->row[from];
    const double true_rad_s = recording->has_omega ? truth->omega_e_rad_s : NAN;
    const double seen_rad_s = row->lock >= LODE_LOCK_LOST ? (double)row->omega_rad_s : NAN;
    const double errors[] = {rig_stats_min(&error), rig_stats_max(&error)};
    for (int k = 0; k < 2; ++k) {
        (void)fprintf(script, "%.9g %.5g %.5g %.4g %.4g %.4g %.3g\n", truth->t_s,
                      rig_rpm_from_rad_s(true_rad_s) / pole_pairs,
                      rig_rpm_from_rad_s(seen_rad_s) / pole_pairs, errors[k],
                      hypot((double)row->e_V.alpha, (double)row->e_V.beta),
                      hypot(truth->i_alpha_A, truth->i_beta_A), (double)row->lock);
    }
    return error.count > 0 ? rig_stats_peak(&error) : 0.0;
}

/// The lines break where there is no estimate. Returns the largest error drawn.
static double send_rows(FILE *script, const recording_t *recording, const replay_t *replay,
                        double pole_pairs) {
    const size_t every = replay->rows / POINTS + 1;
    double peak_deg = 0.0;
    (void)fputs("$run << END\n", script);
    for (size_t from = 0; from < replay->rows;) {
        if (!replay_is_known(recording, from)) {
            (void)fputc('\n', script);
            ++from;
            continue;
        }
        size_t to = from + 1;
        while (to < from + every && to < replay->rows && replay_is_known(recording, to)) {
            ++to;
        }
        peak_deg = fmax(peak_deg, send_stretch(script, recording, replay, from, to, pole_pairs));
        from = to;
    }
    (void)fputs("END\n", script);
    return peak_deg;
}

static void send_speed(FILE *script, bool has_truth) {
    plot_panel(script, "speed [rpm]");
    (void)fprintf(script, "plot %s$run using 1:3 with lines lc rgb red lw 1 title 'estimated'\n",
                  has_truth ? "$run using 1:2 with lines lc rgb blue lw 2 title 'true', " : "");
    (void)fputs("unset label 1000\n", script);
}

static void send_error(FILE *script, double peak_deg) {
    const double range_deg = fmax(0.1, 1.1 * peak_deg);
    plot_panel(script, "angle error [deg el.]");
    (void)fprintf(
        script,
        "set yrange [-%.3g:%.3g]\n"
        "plot $run using 1:4 with lines lc rgb red lw 1 title \"estimate -\\ntruth, locked\"\n",
        range_deg, range_deg);
}

static void send_amplitudes(FILE *script) {
    plot_panel(script, "EMF amplitude [V]");
    (void)fputs("set yrange [0:*]\n"
                "plot $run using 1:5 with lines lc rgb red lw 1 title 'raw estimate'\n",
                script);
    plot_panel(script, "current amplitude [A]");
    (void)fputs("plot $run using 1:6 with lines lc rgb green lw 1 title 'recorded'\n", script);
    plot_panel(script, "lock quality");
    (void)fputs("set format x '%g'\nset xlabel 'time [s]' offset 0,0.4\nset yrange [0:1.05]\n"
                "plot $run using 1:7 with lines lc rgb green lw 1.4 title 'lock'\n"
                "unset multiplot\n",
                script);
}

bool plot_replay(const plot_output_t *output, const char *title, const rig_config_t *config,
                 const recording_t *recording, const replay_t *replay) {
    plot_t plot;
    const int panels = recording->has_theta ? PANELS : PANELS - 1;
    const plot_frame_t frame = {WIDTH,
                                FRAME_HEIGHT + PANEL_HEIGHT * panels,
                                TOP,
                                LEGEND,
                                panels,
                                recording->row[0].t_s,
                                recording->row[recording->rows - 1].t_s};
    if (!plot_start(&plot, output, title, frame.width, frame.height)) {
        return false;
    }
    const double peak_deg =
        send_rows(plot.script, recording, replay, (double)config->drive.motor.pole_pairs);
    plot_style(plot.script, title, &frame);
    send_speed(plot.script, recording->has_omega);
    if (recording->has_theta) {
        send_error(plot.script, peak_deg);
    }
    send_amplitudes(plot.script);
    return plot_finish(&plot);
}
