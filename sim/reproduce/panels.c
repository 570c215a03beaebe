#include "reproduce/panels.h"

#include <math.h>

#include "support/plot.h"
#include "support/units.h"

enum { ROW_HEIGHT = 250, MARGIN = 90 };

int panels_height(int rows) {
    return rows * ROW_HEIGHT + MARGIN;
}

double panels_angle_deg(double angle_rad, double before_rad) {
    return fabs(angle_rad - before_rad) > RIG_PI ? NAN : rig_deg_from_rad(angle_rad);
}

void panels_begin(FILE *script, const char *title, int rows, int columns) {
    const double height = panels_height(rows);
    char string[PLOT_TEXT_LENGTH];
    (void)fprintf(
        script,
        "set multiplot layout %d,%d columnsfirst margins screen 0.065, screen 0.985, "
        "screen %.4f, screen %.4f spacing screen 0.08, screen %.4f\n"
        "set grid lc rgb '#e2e5e8' lw 0.6 dt 1\n"
        "set border 3 lc rgb '#606060'\n"
        "set tics nomirror out scale 0.6 textcolor rgb '#303030' font ',11'\n"
        "set key at graph 1.0, graph 1.13 right top horizontal samplen 1 width -0.7 font ',10'\n"
        "blue = '#1f5fa8'; red = '#c8372d'; green = '#2f8f4e'; grey = '#8a8f94'\n"
        "set label 1000 %s at screen 0.065, screen 0.985 left noenhanced font ',14'\n",
        rows, columns, 52.0 / height, 1.0 - 58.0 / height, 34.0 / height, plot_text(string, title));
}

void panels_next(FILE *script, const char *label, const char *title, bool last) {
    char name[PLOT_TEXT_LENGTH];
    char heading[PLOT_TEXT_LENGTH];
    // The figure's title belongs to the first panel only.
    (void)fprintf(script, "%s", title[0] != '\0' ? "" : "unset label 1000\n");
    (void)fprintf(script,
                  "set ylabel %s offset 0.3,0 font ',11'\n"
                  "set label 1001 %s at graph 0.01, graph 1.07 left noenhanced font ',12'\n"
                  "set format x '%s'\nset xlabel '%s' offset 0,0.5\n",
                  plot_text(name, label), plot_text(heading, title), last ? "%g" : "",
                  last ? "time [s]" : "");
}
