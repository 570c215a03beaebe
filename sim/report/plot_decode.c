#include "report/plot_decode.h"

#include <math.h>
#include <string.h>

#include "support/channels.h"
#include "support/units.h"

enum {
    WIDTH = 1150,
    TOP = 50,
    LEGEND = 200,
    FRAME_HEIGHT = 110,
    PANEL_HEIGHT = 150,
    PANEL_WIDTH = 850,
    TURN_PIXELS = 3, ///< pixels per turn that an angle needs to be drawn as lines
    POINTS = 2400
};

// Distinct colours on white, also for colour-blind readers.
static const char *const colours[] = {"#1f5fa8", "#c8372d", "#2f8f4e", "#101010",
                                      "#d08a1d", "#7a4fa3", "#3aa6b9", "#8a8f94"};
enum { COLOURS = sizeof colours / sizeof colours[0] };

/// Time on the axis: since the event if there is one.
static double time_of(const decode_t *decoded, size_t row) {
    const double from_s = decoded->has_event ? decoded->t_s[decoded->event] : 0.0;
    return decoded->t_s[row] - from_s;
}

/// Channels of a group share an axis: those of one unit, except those with much larger values or another
/// meaning.
static const char *group_of(uint32_t channel) {
    const char *unit = channels_unit(channel);
    switch (channel) {
    case LODE_CHANNEL_MODE:
        return "mode";
    case LODE_CHANNEL_CHECK:
        return "check";
    case LODE_CHANNEL_DUTY_A:
    case LODE_CHANNEL_DUTY_B:
    case LODE_CHANNEL_DUTY_C:
        return "duty";
    case LODE_CHANNEL_LOCK:
        return "lock";
    case LODE_CHANNEL_V_BUS:
        return "bus [V]";
    case LODE_CHANNEL_I_ALPHA:
    case LODE_CHANNEL_I_BETA:
        return "A, stator";
    case LODE_CHANNEL_U_ALPHA:
    case LODE_CHANNEL_U_BETA:
    case LODE_CHANNEL_E_ALPHA:
    case LODE_CHANNEL_E_BETA:
        return "V, stator";
    case LODE_CHANNEL_SPEED_REF:
        return "rad/s, mech.";
    default:
        return unit[0] != '\0' ? unit : "share";
    }
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

/// Sends points, one value per channel.
typedef struct {
    FILE *script;
    const decode_t *decoded;
    bool drawn; ///< there is a previous point
    bool band;  ///< angles turn too fast for lines: the range that they pass through is filled
    double before[LODE_CHANNELS_MAX];
} pen_t;

static bool jumps(const pen_t *pen, uint32_t k, double value) {
    return pen->decoded->channel[k] == (uint32_t)LODE_CHANNEL_THETA && pen->drawn && !pen->band &&
           fabs(value - pen->before[k]) > RIG_PI;
}

/// No line is drawn where an angle wraps from one end of its range to the other.
static void send_point(pen_t *pen, double t_s, const double value[LODE_CHANNELS_MAX]) {
    const uint32_t channels = pen->decoded->channels;
    bool breaks = false;
    for (uint32_t k = 0; k < channels; ++k) {
        breaks = breaks || jumps(pen, k, value[k]);
    }
    for (int line = breaks ? 0 : 1; line < 2; ++line) {
        (void)fprintf(pen->script, "%.9g", t_s);
        for (uint32_t k = 0; k < channels; ++k) {
            send_value(pen->script, line == 0 && jumps(pen, k, value[k]) ? NAN : value[k]);
        }
        (void)fputc('\n', pen->script);
    }
    memcpy(pen->before, value, channels * sizeof value[0]);
    pen->drawn = true;
}

/// True if frames are missing before a row, or the drive was restarted.
static bool is_behind_gap(const decode_t *decoded, size_t row) {
    const double step_s = (double)decoded->decimation / decoded->f_pwm_Hz;
    return !(fabs(decoded->t_s[row] - decoded->t_s[row - 1] - step_s) < 0.5 * step_s);
}

/// From one row to the one before another.
typedef struct {
    size_t from, to;
} rows_t;

/// TURN_PIXELS wide around the middle of a stretch, and not across a gap.
static rows_t rows_about(const decode_t *decoded, size_t from, size_t to) {
    const size_t half = decoded->rows * TURN_PIXELS / (2u * PANEL_WIDTH);
    const size_t middle = from + (to - from) / 2u;
    rows_t rows = {middle, middle + 1u};
    while (rows.from > 0u && middle - rows.from < half && !is_behind_gap(decoded, rows.from)) {
        rows.from--;
    }
    while (rows.to < decoded->rows && rows.to - middle < half && !is_behind_gap(decoded, rows.to)) {
        rows.to++;
    }
    return rows;
}

/// True if an angle turns once or more in these rows: the lines of such turns would merge.
static bool turns_fast(const decode_t *decoded, uint32_t channel, rows_t rows) {
    double moved_rad = 0.0;
    for (size_t row = rows.from + 1u; row < rows.to; ++row) {
        const float *value = &decoded->value[row * decoded->channels + channel];
        const double before = (double)*(value - decoded->channels);
        moved_rad += fabs(remainder((double)*value - before, 2.0 * RIG_PI));
    }
    return moved_rad > 2.0 * RIG_PI;
}

/// Smallest and largest value of each channel in a stretch, so that no peak is lost; for an angle the first and
/// the last value, or the whole range if it turns too fast for lines.
static void send_stretch(pen_t *pen, size_t from, size_t to) {
    const decode_t *decoded = pen->decoded;
    double low[LODE_CHANNELS_MAX];
    double high[LODE_CHANNELS_MAX];
    pen->band = false;
    for (uint32_t k = 0; k < decoded->channels; ++k) {
        const bool angle = decoded->channel[k] == (uint32_t)LODE_CHANNEL_THETA;
        const rows_t about = angle ? rows_about(decoded, from, to) : (rows_t){from, to};
        const bool band = angle && turns_fast(decoded, k, about);
        const bool ends = angle && !band;
        const rows_t rows = band ? about : (rows_t){from, to};
        pen->band = pen->band || band;
        low[k] = high[k] = (double)decoded->value[rows.from * decoded->channels + k];
        for (size_t row = rows.from + 1u; row < rows.to; ++row) {
            const double next = (double)decoded->value[row * decoded->channels + k];
            low[k] = ends ? low[k] : fmin(low[k], next);
            high[k] = ends ? next : fmax(high[k], next);
        }
    }
    send_point(pen, time_of(decoded, from), low);
    if (to > from + 1 || pen->band) {
        send_point(pen, time_of(decoded, to - 1), high);
    }
}

static void send_rows(FILE *script, const decode_t *decoded) {
    const size_t every = decoded->rows / POINTS + 1;
    pen_t pen = {.script = script, .decoded = decoded};
    (void)fputs("$rows << END\n", script);
    for (size_t from = 0; from < decoded->rows;) {
        size_t to = from + 1;
        while (to < from + every && to < decoded->rows && !is_behind_gap(decoded, to)) {
            ++to;
        }
        if (from > 0 && is_behind_gap(decoded, from)) {
            (void)fputc('\n', script); // the line breaks
            pen.drawn = false;
        }
        send_stretch(&pen, from, to);
        from = to;
    }
    (void)fputs("END\n", script);
}

/// Range of all finite values of a panel plus a margin, because gnuplot warns of an empty range.
static void send_range(FILE *script, const decode_t *decoded, const char *group) {
    const bool share = strcmp(group, "duty") == 0 || strcmp(group, "lock") == 0;
    double low = share ? 0.0 : INFINITY;
    double high = share ? 1.0 : -INFINITY;
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

/// Skips a curve without a point, because gnuplot warns of it.
static void send_curve(FILE *script, const decode_t *decoded, uint32_t channel) {
    for (size_t row = 0; row < decoded->rows; ++row) {
        if (isfinite(decoded->value[row * decoded->channels + channel])) {
            (void)fprintf(script, "$rows using 1:%lu", (unsigned long)channel + 2);
            return;
        }
    }
    (void)fputs("NaN", script);
}

/// Labels the axis with the names that occur.
static void send_names(FILE *script, const decode_t *decoded, uint32_t channel) {
    bool seen[UINT8_MAX + 1] = {false};
    const char *separator = "set ytics (";
    for (size_t row = 0; row < decoded->rows; ++row) {
        const double value = (double)decoded->value[row * decoded->channels + channel];
        const char *name = channels_value_name(decoded->channel[channel], value);
        if (name != NULL && !seen[(int)value]) {
            char text[PLOT_TEXT_LENGTH];
            seen[(int)value] = true;
            (void)fprintf(script, "%s%s %d", separator, plot_text(text, name), (int)value);
            separator = ", ";
        }
    }
    (void)fputs(separator[0] == ',' ? ") font ',9'\n" : "set ytics autofreq\n", script);
}

static void send_panel(FILE *script, const decode_t *decoded, uint32_t first, bool last) {
    const char *group = group_of(decoded->channel[first]);
    const char *separator = "plot ";
    int colour = 0;
    plot_panel(script, group);
    send_range(script, decoded, group);
    const bool named = channels_is_named(decoded->channel[first]);
    if (named) {
        send_names(script, decoded, first);
    }
    if (last) {
        (void)fprintf(script, "set format x '%%g'\nset xlabel 'time%s [s]' offset 0,0.4\n",
                      decoded->has_event ? " since the event" : "");
    }
    for (uint32_t k = first; k < decoded->channels; ++k) {
        if (strcmp(group_of(decoded->channel[k]), group) == 0) {
            (void)fputs(separator, script);
            send_curve(script, decoded, k);
            char name[PLOT_TEXT_LENGTH];
            (void)fprintf(script, " with %s lc rgb '%s' lw 1.2 title %s noenhanced",
                          named ? "steps" : "lines", colours[colour++ % COLOURS],
                          plot_text(name, channels_name(decoded->channel[k])));
            separator = ", ";
        }
    }
    (void)fputs("\nunset label 1000\n", script);
    if (named) {
        (void)fputs("set ytics autofreq font ',11'\n", script);
    }
}

bool plot_decode(const plot_output_t *output, const char *title, const decode_t *decoded) {
    plot_t plot;
    int panels = 0;
    for (uint32_t k = 0; k < decoded->channels; ++k) {
        panels += is_first_of_group(decoded, k) ? 1 : 0;
    }
    double from_s = time_of(decoded, 0);
    double to_s = from_s;
    for (size_t row = 1; row < decoded->rows; ++row) {
        from_s = fmin(from_s, time_of(decoded, row));
        to_s = fmax(to_s, time_of(decoded, row));
    }
    const plot_frame_t frame = {WIDTH,  FRAME_HEIGHT + PANEL_HEIGHT * panels, TOP, LEGEND, panels,
                                from_s, to_s > from_s ? to_s : from_s + 1.0};
    if (!plot_start(&plot, output, title, frame.width, frame.height)) {
        return false;
    }
    send_rows(plot.script, decoded);
    plot_style(plot.script, title, &frame);
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
