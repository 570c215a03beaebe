#include "rig/recording.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

#include "support/diag.h"

enum { COLUMNS_MAX = 256 };
#define STEP_TOLERANCE 0.01

typedef struct {
    const char *name;
    size_t offset; ///< of a double in recording_row_t
    bool needed;
} field_t;

static const field_t fields[] = {
    {"t_s", offsetof(recording_row_t, t_s), true},
    {"u_alpha_V", offsetof(recording_row_t, u_alpha_V), true},
    {"u_beta_V", offsetof(recording_row_t, u_beta_V), true},
    {"i_alpha_A", offsetof(recording_row_t, i_alpha_A), true},
    {"i_beta_A", offsetof(recording_row_t, i_beta_A), true},
    {"theta_e_rad", offsetof(recording_row_t, theta_e_rad), false},
    {"omega_e_rad_s", offsetof(recording_row_t, omega_e_rad_s), false},
};
enum { FIELDS = sizeof fields / sizeof fields[0], THETA = 5, OMEGA = 6 };

typedef struct {
    const char *path;
    FILE *file;
    char *text; ///< of getline
    size_t size;
    size_t line;
    int columns;
    int field[COLUMNS_MAX]; ///< of each column, -1: not of interest
    size_t capacity;
} reader_t;

/// The next line that is not empty, without its end. False at the end of the file.
static bool next_line(reader_t *reader) {
    do {
        if (getline(&reader->text, &reader->size, reader->file) < 0) {
            return false;
        }
        reader->line++;
        reader->text[strcspn(reader->text, "\r\n")] = '\0';
    } while (reader->text[strspn(reader->text, " \t")] == '\0');
    return true;
}

/// Cuts the next cell out of the line, without the blanks around it; NULL behind the last one.
static char *next_cell(char **rest) {
    if (*rest == NULL) {
        return NULL;
    }
    char *cell = *rest + strspn(*rest, " \t");
    char *comma = strchr(cell, ',');
    char *end = comma != NULL ? comma : cell + strlen(cell);
    *rest = comma != NULL ? comma + 1 : NULL;
    while (end > cell && (end[-1] == ' ' || end[-1] == '\t')) {
        --end;
    }
    *end = '\0';
    return cell;
}

static int field_of(const char *name) {
    for (int k = 0; k < FIELDS; ++k) {
        if (strcmp(name, fields[k].name) == 0) {
            return k;
        }
    }
    return -1;
}

static bool check_header(const reader_t *reader, const bool *found) {
    bool good = true;
    for (int k = 0; k < FIELDS; ++k) {
        if (fields[k].needed && !found[k]) {
            rig_error_at(reader->path, (int)reader->line,
                         "no column %s; expected a header line with t_s, u_alpha_V, u_beta_V, "
                         "i_alpha_A and i_beta_A",
                         fields[k].name);
            good = false;
        }
    }
    return good;
}

static bool read_header(reader_t *reader, recording_t *self) {
    bool found[FIELDS] = {false};
    if (!next_line(reader)) {
        rig_error_at(reader->path, 0, "empty; expected a CSV file with a header line");
        return false;
    }
    const char *const mark = "\xEF\xBB\xBF"; // of UTF-8 files from some systems
    char *rest = reader->text + (strncmp(reader->text, mark, 3) == 0 ? 3 : 0);
    for (char *cell = next_cell(&rest); cell != NULL; cell = next_cell(&rest)) {
        const int field = field_of(cell);
        if (reader->columns == COLUMNS_MAX || (field >= 0 && found[field])) {
            rig_error_at(reader->path, (int)reader->line,
                         "column %s: expected each column once, and at most %d of them", cell,
                         COLUMNS_MAX);
            return false;
        }
        if (field >= 0) {
            found[field] = true;
        }
        reader->field[reader->columns++] = field;
    }
    self->has_theta = found[THETA];
    self->has_omega = found[OMEGA];
    return check_header(reader, found);
}

static bool read_cell(const reader_t *reader, int field, const char *cell, recording_row_t *row) {
    char *end = NULL;
    const double value = strtod(cell, &end);
    if (end == cell || *end != '\0' || !isfinite(value)) {
        rig_error_at(reader->path, (int)reader->line, "%s: '%.40s'; expected a finite number",
                     fields[field].name, cell);
        return false;
    }
    memcpy((char *)row + fields[field].offset, &value, sizeof value);
    return true;
}

static bool read_row(reader_t *reader, recording_row_t *row) {
    int column = 0;
    char *rest = reader->text;
    *row = (recording_row_t){.line = reader->line};
    for (char *cell = next_cell(&rest); cell != NULL; cell = next_cell(&rest), ++column) {
        const int field = column < reader->columns ? reader->field[column] : -1;
        if (field >= 0 && !read_cell(reader, field, cell, row)) {
            return false;
        }
    }
    if (column != reader->columns) {
        rig_error_at(reader->path, (int)reader->line, "%d values; expected %d, as in the header",
                     column, reader->columns);
        return false;
    }
    return true;
}

static bool add_row(reader_t *reader, recording_t *self, const recording_row_t *row) {
    if (self->rows == reader->capacity) {
        const size_t capacity = reader->capacity > 0 ? 2 * reader->capacity : 4096;
        recording_row_t *more = realloc(self->row, capacity * sizeof *more);
        if (more == NULL) {
            rig_error_at(reader->path, (int)reader->line, "out of memory");
            return false;
        }
        self->row = more;
        reader->capacity = capacity;
    }
    self->row[self->rows++] = *row;
    return true;
}

// ---- Time steps ---------------------------------------------------------------------------------

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

/// NaN where memory is out.
static double median_step(const recording_t *self) {
    const size_t steps = self->rows - 1;
    double *step = malloc(steps * sizeof *step);
    if (step == NULL) {
        return NAN;
    }
    for (size_t k = 0; k < steps; ++k) {
        step[k] = self->row[k + 1].t_s - self->row[k].t_s;
    }
    qsort(step, steps, sizeof *step, compare);
    const double median = step[steps / 2];
    free(step);
    return median;
}

static bool check_steps(const char *path, recording_t *self) {
    if (self->rows < 3) {
        rig_error_at(path, 0, "%zu rows; expected at least 3", self->rows);
        return false;
    }
    const double median_s = median_step(self);
    if (!(median_s > 0.0)) {
        rig_error_at(path, 0, "t_s does not rise; expected one row per PWM period");
        return false;
    }
    for (size_t k = 1; k < self->rows; ++k) {
        const double step_s = self->row[k].t_s - self->row[k - 1].t_s;
        if (!(fabs(step_s - median_s) <= STEP_TOLERANCE * median_s)) {
            rig_error_at(path, (int)self->row[k].line,
                         "t_s: a step of %.6g s; expected %.6g s (the median) within 1 %%", step_s,
                         median_s);
            return false;
        }
    }
    // Of steps that agree so well the mean is the better one where t_s is rounded.
    self->ts_s = (self->row[self->rows - 1].t_s - self->row[0].t_s) / (double)(self->rows - 1);
    return true;
}

bool recording_load(recording_t *self, const char *path) {
    reader_t reader = {.path = path};
    *self = (recording_t){0};
    reader.file = fopen(path, "r");
    if (reader.file == NULL) {
        rig_error_at(path, 0, "%s; expected a CSV file", strerror(errno));
        return false;
    }
    bool good = read_header(&reader, self);
    while (good && next_line(&reader)) {
        recording_row_t row;
        good = read_row(&reader, &row) && add_row(&reader, self, &row);
    }
    if (good && ferror(reader.file) != 0) {
        rig_error_at(path, 0, "cannot be read; expected a CSV file");
        good = false;
    }
    (void)fclose(reader.file);
    free(reader.text);
    good = good && check_steps(path, self);
    if (!good) {
        recording_free(self);
    }
    return good;
}

void recording_free(recording_t *self) {
    free(self->row);
    *self = (recording_t){0};
}
