#include "rig/recording_load.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rig/columns.h"
#include "rig/recording_time.h"
#include "support/csv_reader.h"
#include "support/diag.h"

typedef struct {
    bool has_header;
    size_t header, data; ///< first line that may be the header, or may hold data
} layout_t;

static bool take_line(const char *option, const char *text, size_t *line) {
    char *end = NULL;
    if (text == NULL) {
        return true;
    }
    errno = 0;
    const unsigned long number = strtoul(text, &end, 10);
    if (text[0] < '0' || text[0] > '9' || *end != '\0' || errno != 0 || number < 1) {
        rig_error("%s %s: expected a line number, 1 or more", option, text);
        return false;
    }
    *line = number;
    return true;
}

static bool take_layout(layout_t *self, const recording_format_t *format) {
    *self = (layout_t){.has_header = true};
    if (format->header != NULL && strcmp(format->header, "none") == 0) {
        self->has_header = false;
    } else if (!take_line("--header", format->header, &self->header)) {
        return false;
    }
    return take_line("--data", format->data, &self->data);
}

static void to_axes(double *alpha, double *beta, double a, double b, double c) {
    *alpha = (2.0 * a - b - c) / 3.0;
    *beta = (b - c) / sqrt(3.0);
}

static recording_row_t row_of(const columns_t *columns, const double *value, double pole_pairs) {
    recording_row_t row = {.t_s = value[COLUMN_T],
                           .u_alpha_V = value[COLUMN_U_ALPHA],
                           .u_beta_V = value[COLUMN_U_BETA],
                           .i_alpha_A = value[COLUMN_I_ALPHA],
                           .i_beta_A = value[COLUMN_I_BETA],
                           .theta_e_rad = value[COLUMN_THETA_E],
                           .omega_e_rad_s = columns_has(columns, COLUMN_SPEED)
                                                ? pole_pairs * value[COLUMN_SPEED]
                                                : value[COLUMN_OMEGA_E]};
    if (columns_has(columns, COLUMN_U_A)) {
        to_axes(&row.u_alpha_V, &row.u_beta_V, value[COLUMN_U_A], value[COLUMN_U_B],
                value[COLUMN_U_C]);
    }
    if (columns_has(columns, COLUMN_I_A)) {
        const double c = columns_has(columns, COLUMN_I_C) ? value[COLUMN_I_C]
                                                          : -value[COLUMN_I_A] - value[COLUMN_I_B];
        to_axes(&row.i_alpha_A, &row.i_beta_A, value[COLUMN_I_A], value[COLUMN_I_B], c);
    }
    return row;
}

/// Reads the header, or a first line of data to count its columns; that line is then read again.
static bool read_header(csv_reader_t *reader, columns_t *columns, const layout_t *layout,
                        const recording_format_t *format) {
    if (!csv_reader_line(reader, layout->has_header ? layout->header : layout->data)) {
        if (!reader->failed) {
            rig_error_at(reader->path, 0, "empty%s; expected a CSV file with a header line",
                         layout->header + layout->data > 0 ? " from the given line on" : "");
        }
        return false;
    }
    csv_reader_guess(reader);
    if (!columns_find(columns, reader, format->map, format->maps, layout->has_header)) {
        return false;
    }
    if (!layout->has_header) {
        reader->line = 0;
        rewind(reader->file);
    }
    return true;
}

static bool read_rows(recording_t *self, csv_reader_t *reader, const recording_format_t *format) {
    layout_t layout;
    columns_t columns;
    size_t capacity = 0;
    if (!take_layout(&layout, format) || !read_header(reader, &columns, &layout, format)) {
        return false;
    }
    self->has_theta = columns_has(&columns, COLUMN_THETA_E);
    self->has_omega = columns_has(&columns, COLUMN_OMEGA_E) || columns_has(&columns, COLUMN_SPEED);
    while (csv_reader_line(reader, layout.data)) {
        double value[COLUMN_COUNT];
        if (!columns_read(&columns, reader, value)) {
            return false;
        }
        recording_row_t row = row_of(&columns, value, format->pole_pairs);
        row.line = reader->line;
        if (!recording_add(self, &capacity, &row)) {
            return false;
        }
    }
    return !reader->failed;
}

bool recording_load(recording_t *self, const char *path, const recording_format_t *format) {
    csv_reader_t reader;
    *self = (recording_t){0};
    bool good = csv_reader_open(&reader, path, format->separator);
    good = good && read_rows(self, &reader, format) && recording_time(self, path, format);
    csv_reader_close(&reader);
    if (!good) {
        recording_free(self);
    }
    return good;
}
