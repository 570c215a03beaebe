#include "report/plot_decode.h"

#include <math.h>
#include <string.h>

#include "support/channels.h"

enum { WIDTH = 1100, FRAME_HEIGHT = 110, PANEL_HEIGHT = 170, POINTS = 2400 };

// Apart from each other on white, also where red and green look alike.
static const char *const colours[] = {"#1f5fa8", "#c8372d", "#2f8f4e", "#101010",
                                      "#d08a1d", "#7a4fa3", "#3aa6b9", "#8a8f94"};
enum { COLOURS = sizeof colours / sizeof colours[0] };

/// Time on the axis: since the event where there is one.
static double time_of(const decode_t *decoded, size_t row) {
    const double from_s = decoded->has_event ? decoded->t_s[decoded->event] : 0.0;
    return decoded->t_s[row] - from_s;
}

/// What has no unit is an enumerator or a share of 1: two panels.
static const char *group_of(uint32_t channel) {
    const bool state =
        channel == (uint32_t)LODE_CHANNEL_MODE || channel == (uint32_t)LODE_CHANNEL_CHECK;
    const char *unit = channels_unit(channel);
    return state ? "number" : unit[0] != '\0' ? unit : "share";
}

static bool is_first_of_group(const decode_t *decoded, uint32_t channel) {
    for (uint32_t k = 0; k < channel; ++k) {
        if (strcmp(group_of(decoded->channel[k]), group_of(decoded->channel[channel])) == 0) {
            return false;
        }
    }
    return true;
}

static void send_value(FILE *script, double value) {
    (void)fprintf(script, isfinite(value) ? " %.6g" : " nan", value);
}

/// Least and largest value of each channel in each stretch, so that no peak gets lost.
static void send_stretch(FILE *script, const decode_t *decoded, size_t from, size_t to) {
    for (int side = 0; side < 2; ++side) {
        (void)fprintf(script, "%.9g", time_of(decoded, from));
        for (uint32_t k = 0; k < decoded->channels; ++k) {
            double value = (double)decoded->value[from * decoded->channels + k];
            for (size_t row = from + 1; row < to; ++row) {
                const double next = (double)decoded->value[row * decoded->channels + k];
                value = side == 0 ? fmin(value, next) : fmax(value, next);
            }
            send_value(script, value);
        }
        (void)fputc('\n', script);
        if (to == from + 1) {
            return;
        }
    }
}

static void send_rows(FILE *script, const decode_t *decoded) {
    const size_t every = decoded->rows / POINTS + 1;
    const double step_s = (double)decoded->decimation / decoded->f_pwm_Hz;
    (void)fputs("$rows << END\n", script);
    for (size_t from = 0; from < decoded->rows; from += every) {
        const size_t to = from + every < decoded->rows ? from + every : decoded->rows;
        const double gap_s = from > 0 ? decoded->t_s[from] - decoded->t_s[from - 1] : step_s;
        if (!(fabs(gap_s - step_s) < 0.5 * step_s)) {
            (void)fputc('\n', script); // the line breaks where frames are missing
        }
        send_stretch(script, decoded, from, to);
    }
    (void)fputs("END\n", script);
}

/// All finite values of a panel, and some room: gnuplot warns of a range without extent.
static void send_range(FILE *script, const decode_t *decoded, const char *group) {
    double low = INFINITY;
    double high = -INFINITY;
    for (size_t k = 0; k < decoded->rows * decoded->channels; ++k) {
        const double value = (double)decoded->value[k];
        const uint32_t channel = decoded->channel[k % decoded->channels];
        if (isfinite(value) && strcmp(group_of(channel), group) == 0) {
            low = fmin(low, value);
            high = fmax(high, value);
        }
    }
    if (!(low <= high)) {
        low = high = 0.0;
    }
    const double room = high > low ? 0.05 * (high - low) : fmax(0.5, 0.05 * fabs(high));
    (void)fprintf(script, "set yrange [%.6g:%.6g]\n", low - room, high + room);
}

/// gnuplot warns of a curve without a point.
static void send_curve(FILE *script, const decode_t *decoded, uint32_t channel) {
    for (size_t row = 0; row < decoded->rows; ++row) {
        if (isfinite(decoded->value[row * decoded->channels + channel])) {
            (void)fprintf(script, "$rows using 1:%lu", (unsigned long)channel + 2);
            return;
        }
    }
    (void)fputs("NaN", script);
}

static void send_panel(FILE *script, const decode_t *decoded, uint32_t first, bool last) {
    const char *group = group_of(decoded->channel[first]);
    const char *separator = "plot ";
    int colour = 0;
    plot_panel(script, group);
    send_range(script, decoded, group);
    if (last) {
        (void)fprintf(script, "set format x '%%g'\nset xlabel 'time%s [s]' offset 0,0.4\n",
                      decoded->has_event ? " since the event" : "");
    }
    for (uint32_t k = first; k < decoded->channels; ++k) {
        if (strcmp(group_of(decoded->channel[k]), group) == 0) {
            (void)fputs(separator, script);
            send_curve(script, decoded, k);
            char name[PLOT_TEXT_LENGTH];
            (void)fprintf(script, " with lines lc rgb '%s' lw 1.2 title %s noenhanced",
                          colours[colour++ % COLOURS],
                          plot_text(name, channels_name(decoded->channel[k])));
            separator = ", ";
        }
    }
    (void)fputs("\nunset label 1000\n", script);
}

bool plot_decode(FILE *svg, const char *title, const decode_t *decoded) {
    plot_t plot;
    int panels = 0;
    for (uint32_t k = 0; k < decoded->channels; ++k) {
        panels += is_first_of_group(decoded, k) ? 1 : 0;
    }
    if (!plot_start(&plot, svg, WIDTH, FRAME_HEIGHT + PANEL_HEIGHT * panels)) {
        return false;
    }
    double from_s = time_of(decoded, 0);
    double to_s = from_s;
    for (size_t row = 1; row < decoded->rows; ++row) {
        from_s = fmin(from_s, time_of(decoded, row));
        to_s = fmax(to_s, time_of(decoded, row));
    }
    send_rows(plot.script, decoded);
    plot_style(plot.script, title, panels, from_s, to_s > from_s ? to_s : from_s + 1.0);
    if (decoded->has_event) {
        (void)fputs(
            "set arrow 1 from 0, graph 0 to 0, graph 1 nohead back lw 1.2 lc rgb grey dt 2\n",
            plot.script);
    }
    for (uint32_t k = 0; k < decoded->channels; ++k) {
        if (is_first_of_group(decoded, k)) {
            send_panel(plot.script, decoded, k, --panels == 0);
        }
    }
    (void)fputs("unset multiplot\n", plot.script);
    return plot_finish(&plot);
}
