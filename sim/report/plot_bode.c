#include "report/plot_bode.h"

#include <math.h>
#include <string.h>

#include "support/plot.h"
#include "support/units.h"

enum { WIDTH = 1180, HEIGHT = 700 };

const plot_bode_t plot_bode_all[PLOT_BODE_COUNT] = {
    {.file = "jiang2022-fig4.svg",
     .title = "Paper 1, Figure 4: angle per unknown acceleration, sigma 200 rad/s",
     .figure = {"fig4", NULL},
     .heading = {"", ""},
     .poles = NULL,
     .two_sided = false,
     .gain_dB = {-160, -80}},
    {.file = "jiang2022-fig5.svg",
     .title = "Paper 1, Figure 5: the notch, centre 600 rad/s",
     .figure = {"fig5", NULL},
     .heading = {"", ""},
     .poles = NULL,
     .two_sided = false,
     .gain_dB = {-40, 5}},
    {.file = "jiang2022-fig8.svg",
     .title = "Paper 1, Figure 8: LESO-QPLL with notch, sigma 100 rad/s, k 0.1",
     .figure = {"fig8a", "fig8b"},
     .heading = {"open loop", "closed loop"},
     .poles = NULL,
     .two_sided = false,
     .gain_dB = {-40, 75},
     .falls_from_270 = true},
    {.file = "jiang2022-fig9.svg",
     .title = "Paper 1, Figure 9: LESO-QPLL with notch at 600 rad/s, k 0.1",
     .figure = {"fig9a", NULL},
     .heading = {"open loop", "closed-loop poles, sigma 60 .. 160 rad/s"},
     .poles = "fig9b",
     .two_sided = false,
     .gain_dB = {-40, 75},
     .falls_from_270 = true},
    {.file = "li-fig1.svg",
     .title = "Paper 2, Figure 1: FA filter at 50 Hz, k2 = 100 pi",
     .figure = {"li-fig1", "li-fig1"},
     .heading = {"negative frequencies", "positive frequencies"},
     .poles = NULL,
     .two_sided = true,
     .gain_dB = {-40, 8}},
    {.file = "li-fig2.svg",
     .title = "Paper 2, Figure 2: FA filter at 50 Hz, k1 = 10 pi",
     .figure = {"li-fig2", "li-fig2"},
     .heading = {"negative frequencies", "positive frequencies"},
     .poles = NULL,
     .two_sided = true,
     .gain_dB = {-40, 8}},
    {.file = "li-fig4.svg",
     .title = "Paper 2, Figure 4: three observers with the gains of Table II, tuned to 50 Hz",
     .figure = {"li-fig4", "li-fig4"},
     .heading = {"negative frequencies", "positive frequencies"},
     .poles = NULL,
     .two_sided = true,
     .gain_dB = {-40, 8}},
    {.file = "own-observer.svg",
     .title = "This drive: EMF observer in alpha-beta, tuned to three speeds",
     .figure = {"own-observer", "own-observer"},
     .heading = {"negative frequencies", "positive frequencies"},
     .poles = NULL,
     .two_sided = true,
     .gain_dB = {-40, 8}},
    {.file = "own-pll.svg",
     .title = "This drive: PLL, open loop",
     .figure = {"own-pll", "own-pll-alone"},
     .heading = {"with observer and notches", "alone"},
     .poles = NULL,
     .two_sided = false,
     .gain_dB = {-40, 60},
     .falls_from_270 = true},
    {.file = "own-current.svg",
     .title = "This drive: current control, open loop",
     .figure = {"own-current", NULL},
     .heading = {"", ""},
     .poles = NULL,
     .two_sided = false,
     .gain_dB = {-40, 60}},
    {.file = "own-speed.svg",
     .title = "This drive: speed control without feed-forwards, open loop",
     .figure = {"own-speed", NULL},
     .heading = {"", ""},
     .poles = NULL,
     .two_sided = false,
     .gain_dB = {-60, 60}},
};

static bool is_in(const analyse_curve_t *curve, const char *figure) {
    return figure != NULL && strcmp(curve->figure, figure) == 0;
}

/// Writes rows "frequency gain phase" of every curve of the picture; frequency in rad/s, or |Hz| with an empty
/// line between the halves.
static void send_curve(FILE *script, int number, const analyse_curve_t *curve,
                       const plot_bode_t *picture) {
    const bool two_sided = picture->two_sided;
    double phase = carg(curve->value[0]);
    phase -= picture->falls_from_270 && phase > RIG_PI / 3.0 ? 2.0 * RIG_PI : 0.0;
    (void)fprintf(script, "$c%d << END\n", number);
    for (int k = 0; k < ANALYSE_POINTS; ++k) {
        if (k > 0) { // the phase rises across a zero on the axis
            const double step = carg(curve->value[k] / curve->value[k - 1]);
            phase += step < -2.6 ? step + 2.0 * RIG_PI : step;
        }
        const double omega = curve->omega_rad_s[k];
        (void)fprintf(script, "%.7g %.5g %.5g\n", two_sided ? omega / (2.0 * RIG_PI) : omega,
                      20.0 * log10(fmax(cabs(curve->value[k]), 1.0e-9)),
                      rig_deg_from_rad(two_sided ? carg(curve->value[k]) : phase));
    }
    (void)fputs("END\n", script);
}

static void send_poles(FILE *script, const analyse_t *analysis, const char *figure) {
    for (analyse_form_t form = ANALYSE_THEORY; form <= ANALYSE_SAMPLED; ++form) {
        (void)fprintf(script, "$p%d << END\n", (int)form);
        for (int k = 0; k < analysis->poles; ++k) {
            const analyse_pole_t *p = &analysis->pole[k];
            if (strcmp(p->figure, figure) == 0 && p->form == form) {
                (void)fprintf(script, "%.6g %.6g %.6g\n", creal(p->pole), cimag(p->pole),
                              p->sigma_rad_s);
            }
        }
        (void)fputs("END\n", script);
    }
}

/// Plots column 2 (gain) or 3 (phase) of every curve of a figure, over the x given.
static void plot_curves(FILE *script, const analyse_t *analysis, const char *figure, const char *x,
                        int column) {
    static const char *const colours[] = {"1f5fa8", "c8372d", "2f8f4e", "d98200"};
    // Theory is broad and pale, sampled curves are thin over it, misprints are dotted.
    static const char *const alpha[] = {"90", "00", "50"};
    static const char *const style[] = {"lw 5 dt 1", "lw 1.4 dt 1", "lw 1.2 dt 3"};
    static const char *const name[] = {"theory", "sampled", "as printed"};
    const char *separator = "plot ";
    for (int c = 0; c < analysis->curves; ++c) {
        const analyse_curve_t *curve = &analysis->curve[c];
        if (is_in(curve, figure)) {
            char label[160];
            char title[PLOT_TEXT_LENGTH];
            (void)snprintf(label, sizeof label, "%s, %s", curve->label, name[curve->form]);
            (void)fprintf(script, "%s$c%d using %s:%d with lines lc rgb '#%s%s' %s title %s",
                          separator, c, x, column, alpha[curve->form], colours[curve->family % 4],
                          style[curve->form], plot_text(title, label));
            separator = ", ";
        }
    }
    (void)fputc('\n', script);
}

/// Frequency range of one column: that of its first curve, which is theory if there is one.
static void set_x(FILE *script, const plot_bode_t *picture, int column, const analyse_t *analysis) {
    const int first = picture->two_sided ? ANALYSE_POINTS / 2 + 1 : 0;
    const double unit = picture->two_sided ? 2.0 * RIG_PI : 1.0;
    for (int c = 0; c < analysis->curves; ++c) {
        const analyse_curve_t *curve = &analysis->curve[c];
        if (is_in(curve, picture->figure[column])) {
            const double from = curve->omega_rad_s[first] / unit;
            const double to = curve->omega_rad_s[ANALYSE_POINTS - 1] / unit;
            const bool backwards = picture->two_sided && column == 0;
            (void)fprintf(script, "set xrange [%.6g:%.6g]\n", backwards ? to : from,
                          backwards ? from : to);
            return;
        }
    }
}

static void place(FILE *script, int column, int row, int columns) {
    const double left = columns == 2 && column == 1 ? 0.47 : 0.075;
    const double right = columns == 2 && column == 0 ? 0.415 : 0.81;
    const double top = row == 0 ? 0.89 : 0.48;
    (void)fprintf(script,
                  "set lmargin at screen %g; set rmargin at screen %g; set tmargin at screen %g; "
                  "set bmargin at screen %g\n",
                  left, right, top, top - 0.385);
}

static void gain_panel(FILE *script, const plot_bode_t *picture, int column) {
    char heading[PLOT_TEXT_LENGTH];
    (void)fprintf(script,
                  "set label 1001 %s at graph 0, graph 1.035 left font ',12'\n"
                  "set ylabel '%s' offset 0.2\nset yrange [%g:%g]\nset ytics autofreq\n"
                  "set format x ''\nset xlabel ''\n",
                  plot_text(heading, picture->heading[column]), column == 0 ? "gain [dB]" : "",
                  picture->gain_dB[0], picture->gain_dB[1]);
    if (picture->poles != NULL) {
        (void)fputs("set key top right reverse Left samplen 1.6 font ',10'\n", script);
    } else if (column == 1 || picture->figure[1] == NULL) {
        (void)fputs(
            "set key at screen 0.825, graph 1 left top reverse Left samplen 1.6 font ',10'\n",
            script);
    } else {
        (void)fputs("unset key\n", script);
    }
}

static void phase_panel(FILE *script, const plot_bode_t *picture, int column) {
    (void)fprintf(script,
                  "unset label 1000; unset label 1001\nunset key\n"
                  "set ylabel '%s' offset 0.2\nset yrange [*:*]\nset ytics 45\n"
                  "set format x '%s'\nset xlabel 'frequency [%s]' offset 0,0.3\n",
                  column == 0 ? "phase [deg]" : "",
                  picture->two_sided && column == 0 ? "-%g" : "%g",
                  picture->two_sided ? "Hz" : "rad/s");
}

static void bode_column(FILE *script, const plot_bode_t *picture, const analyse_t *analysis,
                        int column, int columns) {
    // Negative frequencies by magnitude, on a reversed axis.
    const char *x = picture->two_sided && column == 0 ? "(-$1)" : "1";
    (void)fputs("set logscale x\n", script);
    set_x(script, picture, column, analysis);
    place(script, column, 0, columns);
    gain_panel(script, picture, column);
    plot_curves(script, analysis, picture->figure[column], x, 2);
    place(script, column, 1, columns);
    phase_panel(script, picture, column);
    plot_curves(script, analysis, picture->figure[column], x, 3);
}

static void pole_column(FILE *script, const plot_bode_t *picture) {
    char heading[PLOT_TEXT_LENGTH];
    (void)fprintf(script,
                  "unset logscale x\nset xrange [-260:20]\nset yrange [-700:700]\n"
                  "set format x '%%g'\nset ytics autofreq\nset xlabel 'real [rad/s]' offset 0,0.3\n"
                  "set ylabel ''\nset label 1001 %s at graph 0, graph 1.017 left font ',12'\n"
                  "set lmargin at screen 0.47; set rmargin at screen 0.81\n"
                  "set tmargin at screen 0.89; set bmargin at screen 0.095\n"
                  "set palette defined (60 '#1f5fa8', 110 '#d98200', 160 '#c8372d')\n"
                  "set cbrange [60:160]\nset cblabel 'sigma [rad/s]'\n"
                  "set key at graph 0.05, graph 0.78 left font ',10'\n"
                  "plot $p0 using 1:2:3 with points pt 6 ps 0.9 lc palette title 'theory', "
                  "$p1 using 1:2:3 with points pt 2 ps 0.6 lc palette title 'sampled'\n",
                  plot_text(heading, picture->heading[1]));
}

bool plot_bode(const plot_output_t *output, const plot_bode_t *picture, const analyse_t *analysis) {
    plot_t plot;
    char title[PLOT_TEXT_LENGTH];
    if (!plot_start(&plot, output, picture->title, WIDTH, HEIGHT)) {
        return false;
    }
    FILE *script = plot.script;
    for (int c = 0; c < analysis->curves; ++c) {
        const analyse_curve_t *curve = &analysis->curve[c];
        if (is_in(curve, picture->figure[0]) || is_in(curve, picture->figure[1])) {
            send_curve(script, c, curve, picture);
        }
    }
    (void)fprintf(script,
                  "set multiplot\n"
                  "set grid lc rgb '#e2e5e8' lw 0.6 dt 1\n"
                  "set border 3 lc rgb '#606060'\n"
                  "set tics nomirror out scale 0.6 textcolor rgb '#303030' font ',11'\n"
                  "set label 1000 %s at screen 0.075, screen 0.965 left noenhanced font ',14'\n",
                  plot_text(title, picture->title));
    const int columns = picture->figure[1] != NULL || picture->poles != NULL ? 2 : 1;
    bode_column(script, picture, analysis, 0, columns);
    if (picture->poles != NULL) {
        send_poles(script, analysis, picture->poles);
        pole_column(script, picture);
    } else if (columns == 2) {
        bode_column(script, picture, analysis, 1, columns);
    }
    (void)fputs("unset multiplot\n", script);
    return plot_finish(&plot);
}
