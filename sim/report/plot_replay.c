#include "report/plot_replay.h"

#include <math.h>

#include "support/units.h"

enum { WIDTH = 1100, HEIGHT = 850, POINTS = 2400 };

/// One point of every curve, with both extremes of the error in each stretch.
static void send_rows(FILE *script, const recording_t *recording, const replay_t *replay,
                      double pole_pairs) {
    const size_t every = replay->rows / POINTS + 1;
    (void)fputs("$run << END\n", script);
    for (size_t from = 0; from < replay->rows; from += every) {
        rig_stats_t error;
        rig_stats_reset(&error);
        for (size_t k = from; k < from + every && k < replay->rows; ++k) {
            rig_stats_add(&error, replay->error_deg[k]);
        }
        const lode_estimate_t *row = &replay->row[from];
        const recording_row_t *truth = &recording->row[from];
        const double true_rpm = recording->has_omega ? truth->omega_e_rad_s : NAN;
        const double errors[] = {rig_stats_min(&error), rig_stats_max(&error)};
        for (int k = 0; k < 2; ++k) {
            (void)fprintf(script, "%.6g %.5g %.5g %.4g %.4g %.4g %.3g\n", truth->t_s,
                          rig_rpm_from_rad_s(true_rpm) / pole_pairs,
                          rig_rpm_from_rad_s((double)row->omega_rad_s) / pole_pairs, errors[k],
                          hypot((double)row->e_V.alpha, (double)row->e_V.beta),
                          hypot(truth->i_alpha_A, truth->i_beta_A), (double)row->lock);
        }
    }
    (void)fputs("END\n", script);
}

static void send_speed(FILE *script, bool has_truth) {
    plot_panel(script, "speed [rpm]");
    (void)fprintf(script, "plot %s$run using 1:3 with lines lc rgb red lw 1 title 'estimated'\n",
                  has_truth ? "$run using 1:2 with lines lc rgb blue lw 2 title 'true', " : "");
    (void)fputs("unset label 1000\n", script);
}

static void send_error(FILE *script, double peak_deg) {
    plot_panel(script, "angle error [deg el.]");
    if (isnan(peak_deg)) {
        (void)fputs("set yrange [-1:1]\nplot NaN title \"no true\\nangle\"\n", script);
        return;
    }
    const double range_deg = fmax(0.1, 1.3 * peak_deg);
    (void)fprintf(script,
                  "set yrange [-%.3g:%.3g]\n"
                  "plot $run using 1:4 with lines lc rgb red lw 1 title \"estimate\\n- truth\"\n",
                  range_deg, range_deg);
}

static void send_amplitudes(FILE *script) {
    plot_panel(script, "amplitude");
    (void)fputs("set yrange [0:*]\n"
                "plot $run using 1:5 with lines lc rgb red lw 1 title 'EMF [V]', "
                "'' using 1:6 with lines lc rgb green lw 1 title 'current [A]'\n",
                script);
    plot_panel(script, "lock quality");
    (void)fputs("set format x '%g'\nset xlabel 'time [s]' offset 0,0.4\nset yrange [0:1.05]\n"
                "plot $run using 1:7 with lines lc rgb green lw 1.4 title 'lock'\n"
                "unset multiplot\n",
                script);
}

bool plot_replay(FILE *svg, const char *title, const rig_config_t *config,
                 const recording_t *recording, const replay_t *replay) {
    plot_t plot;
    if (!plot_start(&plot, svg, WIDTH, HEIGHT)) {
        return false;
    }
    send_rows(plot.script, recording, replay, (double)config->drive.motor.pole_pairs);
    plot_style(plot.script, title, 4, recording->row[0].t_s,
               recording->row[recording->rows - 1].t_s);
    send_speed(plot.script, recording->has_omega);
    send_error(plot.script, rig_stats_peak(&replay->error_settled_deg));
    send_amplitudes(plot.script);
    return plot_finish(&plot);
}
