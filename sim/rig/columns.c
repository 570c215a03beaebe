#include "rig/columns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/diag.h"
#include "support/units.h"

typedef enum { TIME, VOLTAGE, CURRENT, ANGLE, SPEED } kind_t;

/// In the order of column_t, with the unit that messages show for a name without mapping.
static const struct {
    const char *name, *unit;
    kind_t kind;
} fields[COLUMN_COUNT] = {
    {"t", "s", TIME},
    {"u_alpha", "V", VOLTAGE},
    {"u_beta", "V", VOLTAGE},
    {"i_alpha", "A", CURRENT},
    {"i_beta", "A", CURRENT},
    {"theta_e", "rad", ANGLE},
    {"omega_e", "rad_s", SPEED},
    {"u_a", "V", VOLTAGE},
    {"u_b", "V", VOLTAGE},
    {"u_c", "V", VOLTAGE},
    {"i_a", "A", CURRENT},
    {"i_b", "A", CURRENT},
    {"i_c", "A", CURRENT},
    {"speed", "rpm", SPEED},
};

/// The first unit of a kind is the SI unit.
static const struct {
    kind_t kind;
    const char *name;
    double factor;
} units[] = {
    {TIME, "s", 1.0},
    {TIME, "ms", 1e-3},
    {TIME, "us", 1e-6},
    {TIME, "ns", 1e-9},
    {VOLTAGE, "V", 1.0},
    {VOLTAGE, "mV", 1e-3},
    {VOLTAGE, "kV", 1e3},
    {CURRENT, "A", 1.0},
    {CURRENT, "mA", 1e-3},
    {CURRENT, "kA", 1e3},
    {ANGLE, "rad", 1.0},
    {ANGLE, "deg", RIG_PI / 180.0},
    {ANGLE, "turn", 2.0 * RIG_PI},
    {SPEED, "rad_s", 1.0},
    {SPEED, "rad/s", 1.0},
    {SPEED, "rpm", RIG_PI / 30.0},
    {SPEED, "Hz", 2.0 * RIG_PI},
};
enum { UNITS = sizeof units / sizeof units[0], CELL_SHOWN = 40 };

static bool find_unit(kind_t kind, const char *name, double *factor) {
    for (int k = 0; k < UNITS; ++k) {
        if (units[k].kind == kind && strcmp(units[k].name, name) == 0) {
            *factor = units[k].factor;
            return true;
        }
    }
    return false;
}

static void list_units(kind_t kind, char *text, size_t size) {
    text[0] = '\0';
    for (int k = 0; k < UNITS; ++k) {
        const size_t used = strlen(text);
        if (units[k].kind == kind) {
            (void)snprintf(text + used, size - used, "%s%s", used > 0 ? ", " : "", units[k].name);
        }
    }
}

// ---- --column NAME=COLUMN[:UNIT] ------------------------------------------------------------------

static int field_of(const char *name, size_t length) {
    for (int k = 0; k < COLUMN_COUNT; ++k) {
        if (strlen(fields[k].name) == length && strncmp(fields[k].name, name, length) == 0) {
            return k;
        }
    }
    return COLUMN_NONE;
}

static bool refuse_map(const char *map) {
    char names[256] = "";
    for (int k = 0; k < COLUMN_COUNT; ++k) {
        const size_t used = strlen(names);
        (void)snprintf(names + used, sizeof names - used, "%s%s", used > 0 ? ", " : "",
                       fields[k].name);
    }
    rig_error("--column %s: expected NAME=COLUMN or NAME=COLUMN:UNIT, each NAME once, as in "
              "i_alpha=Ialpha:mA; NAME is one of %s",
              map, names);
    return false;
}

/// The unit after the last colon, or a factor to SI units. Removes it from the column's name.
static bool take_unit(const char *map, int field, char *name, double *factor) {
    char *colon = strrchr(name, ':');
    char known[64];
    *factor = 1.0;
    if (colon == NULL) {
        return true;
    }
    char *end = NULL;
    *colon = '\0';
    if (find_unit(fields[field].kind, colon + 1, factor)) {
        return true;
    }
    *factor = strtod(colon + 1, &end);
    if (end != colon + 1 && *end == '\0' && isfinite(*factor) && fabs(*factor) > 0.0) {
        return true;
    }
    list_units(fields[field].kind, known, sizeof known);
    rig_error("--column %s: unit '%s'; expected %s, or a factor to the first of them", map,
              colon + 1, known);
    return false;
}

static bool refuse_name(const csv_reader_t *reader, const char *map, const char *name,
                        char *const *cell, int count) {
    char text[240] = "";
    for (int k = 0; k < count; ++k) {
        const size_t used = strlen(text);
        (void)snprintf(text + used, sizeof text - used, "%s'%.*s'", used > 0 ? ", " : "",
                       CELL_SHOWN, cell[k]);
    }
    rig_error_at(reader->path, (int)reader->line,
                 "no column '%s' (--column %s); expected one of %s%s", name, map, text,
                 strlen(text) + 1 == sizeof text ? "..." : "");
    return false;
}

/// The only column of that name; "#3": the third column.
static int column_of(const char *name, char *const *cell, int count, bool header) {
    if (name[0] == '#') {
        char *end = NULL;
        const long number = strtol(name + 1, &end, 10);
        return *end == '\0' && number >= 1 && number <= count ? (int)number - 1 : COLUMN_NONE;
    }
    int found = COLUMN_NONE;
    for (int k = 0; header && k < count; ++k) {
        if (strcmp(cell[k], name) == 0) {
            found = k;
        }
    }
    return found;
}

static bool take_map(columns_t *self, const csv_reader_t *reader, const char *map,
                     char *const *cell, bool header) {
    char name[256];
    const char *equals = strchr(map, '=');
    const int field = equals != NULL ? field_of(map, (size_t)(equals - map)) : COLUMN_NONE;
    if (field == COLUMN_NONE || self->at[field] != COLUMN_NONE || equals[1] == '\0' ||
        strlen(equals + 1) >= sizeof name) {
        return refuse_map(map);
    }
    (void)snprintf(name, sizeof name, "%s", equals + 1);
    if (!take_unit(map, field, name, &self->factor[field])) {
        return false;
    }
    const int at = column_of(name, cell, self->count, header);
    if (at == COLUMN_NONE) {
        return refuse_name(reader, map, name, cell, self->count);
    }
    if (name[0] != '#' && column_of(name, cell, at, header) != COLUMN_NONE) {
        rig_error_at(reader->path, (int)reader->line,
                     "several columns '%s'; expected one, or its number as in %s=#%d", name,
                     fields[field].name, at + 1);
        return false;
    }
    self->at[field] = at;
    return true;
}

// ---- Names of the header --------------------------------------------------------------------------

/// The quantity of a column named NAME_UNIT, as t_s or i_alpha_mA.
static int field_by_name(const char *cell, double *factor) {
    for (int k = 0; k < COLUMN_COUNT; ++k) {
        const size_t length = strlen(fields[k].name);
        if (strncmp(cell, fields[k].name, length) == 0 && cell[length] == '_' &&
            find_unit(fields[k].kind, cell + length + 1, factor)) {
            return k;
        }
    }
    return COLUMN_NONE;
}

static bool take_names(columns_t *self, const csv_reader_t *reader, char *const *cell) {
    bool mapped[COLUMN_COUNT];
    for (int k = 0; k < COLUMN_COUNT; ++k) {
        mapped[k] = self->at[k] != COLUMN_NONE;
    }
    for (int k = 0; k < self->count; ++k) {
        double factor = 1.0;
        const int field = field_by_name(cell[k], &factor);
        if (field == COLUMN_NONE || mapped[field]) {
            continue;
        }
        if (self->at[field] != COLUMN_NONE) {
            rig_error_at(reader->path, (int)reader->line,
                         "column %s: expected each column once, and at most %d of them", cell[k],
                         COLUMNS_MAX);
            return false;
        }
        self->at[field] = k;
        self->factor[field] = factor;
    }
    return true;
}

static bool has_all(const columns_t *self, column_t first, int count) {
    int found = 0;
    for (int k = 0; k < count; ++k) {
        found += self->at[(int)first + k] != COLUMN_NONE ? 1 : 0;
    }
    return found == count;
}

static bool missing(const columns_t *self, const csv_reader_t *reader, column_t first, int count) {
    for (int k = (int)first; k < (int)first + count; ++k) {
        if (self->at[k] == COLUMN_NONE) {
            rig_error_at(reader->path, (int)reader->line,
                         "no column %s_%s; expected a header line with t_s, u_alpha_V, u_beta_V, "
                         "i_alpha_A and i_beta_A, or phases u_a_V .. i_c_A; --column %s=COLUMN "
                         "selects another one",
                         fields[k].name, fields[k].unit, fields[k].name);
        }
    }
    return false;
}

static void forget(columns_t *self, column_t first, int count) {
    for (int k = 0; k < count; ++k) {
        self->at[(int)first + k] = COLUMN_NONE;
    }
}

/// Uses the stator axes, or else the phases; columns that are not needed are not read. `least`: number of
/// phases that suffice.
static bool settle(columns_t *self, const csv_reader_t *reader, column_t axes, column_t phases,
                   int least) {
    if (has_all(self, axes, 2)) {
        forget(self, phases, 3);
        return true;
    }
    const bool any_axis = self->at[axes] != COLUMN_NONE || self->at[axes + 1] != COLUMN_NONE;
    if (!any_axis && has_all(self, phases, least)) {
        return true;
    }
    const bool any_phase = self->at[phases] != COLUMN_NONE;
    return any_phase && !any_axis ? missing(self, reader, phases, least)
                                  : missing(self, reader, axes, 2);
}

static bool settle_all(columns_t *self, const csv_reader_t *reader) {
    bool good = has_all(self, COLUMN_T, 1) || missing(self, reader, COLUMN_T, 1);
    good = settle(self, reader, COLUMN_U_ALPHA, COLUMN_U_A, 3) && good;
    good = settle(self, reader, COLUMN_I_ALPHA, COLUMN_I_A, 2) && good;
    if (columns_has(self, COLUMN_OMEGA_E)) {
        forget(self, COLUMN_SPEED, 1);
    }
    return good;
}

bool columns_find(columns_t *self, csv_reader_t *reader, const char *const *map, int maps,
                  bool header) {
    char *cell[COLUMNS_MAX] = {NULL};
    *self = (columns_t){0};
    forget(self, COLUMN_T, COLUMN_COUNT);
    for (char *next = csv_reader_cell(reader); next != NULL; next = csv_reader_cell(reader)) {
        if (self->count == COLUMNS_MAX) {
            rig_error_at(reader->path, (int)reader->line, "expected at most %d columns",
                         COLUMNS_MAX);
            return false;
        }
        cell[self->count++] = next;
    }
    for (int k = 0; k < maps; ++k) {
        if (!take_map(self, reader, map[k], cell, header)) {
            return false;
        }
    }
    return (!header || take_names(self, reader, cell)) && settle_all(self, reader);
}

bool columns_has(const columns_t *self, column_t column) {
    return self->at[column] != COLUMN_NONE;
}

bool columns_read(const columns_t *self, csv_reader_t *reader, double value[COLUMN_COUNT]) {
    char *cell[COLUMNS_MAX] = {NULL};
    int count = 0;
    for (char *next = csv_reader_cell(reader); next != NULL; next = csv_reader_cell(reader)) {
        if (count < COLUMNS_MAX) {
            cell[count] = next;
        }
        ++count;
    }
    if (count != self->count) {
        rig_error_at(reader->path, (int)reader->line, "%d values; expected %d, as in the header",
                     count, self->count);
        return false;
    }
    for (int k = 0; k < COLUMN_COUNT; ++k) {
        value[k] = 0.0;
        if (self->at[k] == COLUMN_NONE) {
            continue;
        }
        const bool good = csv_reader_number(reader, cell[self->at[k]], &value[k]);
        value[k] *= self->factor[k];
        if (!good || !isfinite(value[k])) {
            rig_error_at(reader->path, (int)reader->line, "%s_%s: '%.*s'; expected a finite number",
                         fields[k].name, fields[k].unit, CELL_SHOWN, cell[self->at[k]]);
            return false;
        }
    }
    return true;
}
