#include "config/flux_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/csv_reader.h"
#include "support/diag.h"

enum { ID, IQ, PSI_D, PSI_Q, COLUMNS };
static const char *const column_names[COLUMNS] = {"i_d", "i_q", "psi_d", "psi_q"};

enum { NODES_MOST = PLANT_MAP_MOST * PLANT_MAP_MOST, MAPS_MOST = 8 };

/// Currents closer than this share of the largest belong to one node, to allow for rounding in the file.
static const double same_share = 1e-6;
/// Largest flux across the magnet's axis without current, as a share of the largest flux; more is not a map of
/// dq currents.
static const double off_axis_max = 0.01;

typedef struct {
    double value[COLUMNS];
    int line;
} sample_t;

typedef struct {
    const char *path;
    sample_t *sample;
    int samples;
    int place[COLUMNS]; ///< column of each quantity in a line
    plant_map_t *map;
} reading_t;

static bool read_header(reading_t *self, csv_reader_t *csv) {
    if (!csv_reader_line(csv, 0)) {
        if (!csv->failed) {
            rig_error_at(self->path, 0, "empty; expected a line with i_d, i_q, psi_d, psi_q");
        }
        return false;
    }
    csv_reader_guess(csv);
    for (int k = 0; k < COLUMNS; ++k) {
        self->place[k] = -1;
    }
    int place = 0;
    for (const char *cell = csv_reader_cell(csv); cell != NULL;
         cell = csv_reader_cell(csv), ++place) {
        for (int k = 0; k < COLUMNS; ++k) {
            if (strcmp(cell, column_names[k]) == 0) {
                self->place[k] = place;
            }
        }
    }
    for (int k = 0; k < COLUMNS; ++k) {
        if (self->place[k] < 0) {
            rig_error_at(self->path, (int)csv->line,
                         "no column %s; expected a header with i_d, i_q, psi_d, psi_q",
                         column_names[k]);
            return false;
        }
    }
    return true;
}

static bool read_sample(const reading_t *self, csv_reader_t *csv, sample_t *sample) {
    int found = 0, place = 0;
    sample->line = (int)csv->line;
    for (const char *cell = csv_reader_cell(csv); cell != NULL;
         cell = csv_reader_cell(csv), ++place) {
        for (int k = 0; k < COLUMNS; ++k) {
            if (self->place[k] == place && !csv_reader_number(csv, cell, &sample->value[k])) {
                rig_error_at(self->path, (int)csv->line, "%s = %s: expected a number",
                             column_names[k], cell);
                return false;
            }
            found += self->place[k] == place ? 1 : 0;
        }
    }
    if (found < COLUMNS) {
        rig_error_at(self->path, (int)csv->line, "%d columns; expected as many as in the header",
                     place);
    }
    return found == COLUMNS;
}

static bool read_samples(reading_t *self, csv_reader_t *csv) {
    while (csv_reader_line(csv, 0)) {
        if (self->samples == NODES_MOST) {
            rig_error_at(self->path, (int)csv->line, "expected at most %d nodes", NODES_MOST);
            return false;
        }
        if (!read_sample(self, csv, &self->sample[self->samples])) {
            return false;
        }
        self->samples++;
    }
    return !csv->failed;
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : (x > y ? 1 : 0);
}

/// Collects the different values of a current in rising order; returns their number, 0 after a message.
static int axis_of(const reading_t *self, int column, double at_A[PLANT_MAP_MOST]) {
    double *all = malloc((size_t)self->samples * sizeof *all);
    int nodes = 0;
    if (all == NULL) {
        rig_error("out of memory");
        return 0;
    }
    for (int n = 0; n < self->samples; ++n) {
        all[n] = self->sample[n].value[column];
    }
    qsort(all, (size_t)self->samples, sizeof *all, by_size);
    const double same_A = same_share * fmax(fabs(all[0]), fabs(all[self->samples - 1]));
    for (int n = 0; n < self->samples && nodes <= PLANT_MAP_MOST; ++n) {
        if (nodes == 0 || all[n] - all[nodes - 1] > same_A) {
            all[nodes++] = all[n];
        }
    }
    const bool fits = nodes >= PLANT_MAP_LEAST && nodes <= PLANT_MAP_MOST;
    if (!fits) {
        rig_error_at(self->path, 0, "%d values of %s; expected a grid with %d .. %d", nodes,
                     column_names[column], PLANT_MAP_LEAST, PLANT_MAP_MOST);
    } else if (all[0] > same_A || all[nodes - 1] < -same_A) {
        rig_error_at(self->path, 0, "%s from %g to %g A; expected a grid around zero current",
                     column_names[column], all[0], all[nodes - 1]);
        nodes = 0;
    } else {
        memcpy(at_A, all, (size_t)nodes * sizeof *all);
    }
    free(all);
    return fits ? nodes : 0;
}

static int nearest(const double *at_A, int nodes, double i_A) {
    int best = 0;
    for (int k = 1; k < nodes; ++k) {
        best = fabs(at_A[k] - i_A) < fabs(at_A[best] - i_A) ? k : best;
    }
    return best;
}

/// Brings the samples into the order of the grid; `line` 0 marks a missing one.
static bool place_samples(const reading_t *self, sample_t *grid) {
    const plant_map_t *map = self->map;
    for (int n = 0; n < self->samples; ++n) {
        const sample_t *from = &self->sample[n];
        const int row = nearest(map->id_A, map->rows, from->value[ID]);
        const int column = nearest(map->iq_A, map->columns, from->value[IQ]);
        sample_t *to = &grid[row * map->columns + column];
        if (to->line > 0) {
            rig_error_at(self->path, from->line,
                         "i_d = %g, i_q = %g is in line %d too; expected each pair once",
                         from->value[ID], from->value[IQ], to->line);
            return false;
        }
        *to = *from;
    }
    for (int n = 0; n < map->rows * map->columns; ++n) {
        if (grid[n].line == 0) {
            rig_error_at(
                self->path, 0,
                "no row with i_d = %g, i_q = %g; expected each of %d i_d with each of %d i_q",
                map->id_A[n / map->columns], map->iq_A[n % map->columns], map->rows, map->columns);
            return false;
        }
    }
    return true;
}

/// Extends a map of one half plane to the other: psi_d is even in i_q, psi_q is odd.
static bool mirror(reading_t *self) {
    double largest = 0.0, least = 0.0;
    for (int n = 0; n < self->samples; ++n) {
        largest = fmax(largest, self->sample[n].value[IQ]);
        least = fmin(least, self->sample[n].value[IQ]);
    }
    const double zero_A = same_share * fmax(largest, -least);
    if (largest > zero_A && least < -zero_A) {
        return true;
    }
    const int half = self->samples;
    for (int n = 0; n < half; ++n) {
        sample_t other = self->sample[n];
        if (fabs(other.value[IQ]) <= zero_A) {
            continue;
        }
        if (self->samples == NODES_MOST) {
            rig_error_at(self->path, other.line,
                         "expected at most %d nodes, mirrored ones included", NODES_MOST);
            return false;
        }
        other.value[IQ] = -other.value[IQ];
        other.value[PSI_Q] = -other.value[PSI_Q];
        self->sample[self->samples++] = other;
    }
    return true;
}

static bool judge(const reading_t *self, const sample_t *grid, const plant_map_fault_t *fault) {
    const plant_map_t *map = self->map;
    if (fault->why != NULL) {
        rig_error_at(self->path, grid[fault->row * map->columns + fault->column].line,
                     "expected %s; found %.3g H between i_d = %g and %g, i_q = %g and %g A",
                     fault->why, fault->found, map->id_A[fault->row], map->id_A[fault->row + 1],
                     map->iq_A[fault->column], map->iq_A[fault->column + 1]);
        return false;
    }
    double largest_Wb = 0.0;
    for (int n = 0; n < map->rows * map->columns; ++n) {
        largest_Wb = fmax(largest_Wb, hypot(grid[n].value[PSI_D], grid[n].value[PSI_Q]));
    }
    const double off_Wb = off_axis_max * largest_Wb;
    if (map->psi_Wb < -off_Wb || fabs(map->psi_q_Wb) > off_Wb) {
        rig_error_at(
            self->path, 0,
            "without current psi_d = %g, psi_q = %g Wb; expected the magnet's flux on the d axis",
            map->psi_Wb, map->psi_q_Wb);
        return false;
    }
    return true;
}

static bool build(reading_t *self) {
    plant_map_t *map = self->map;
    map->rows = axis_of(self, ID, map->id_A);
    map->columns = map->rows > 0 ? axis_of(self, IQ, map->iq_A) : 0;
    if (map->columns == 0) {
        return false;
    }
    const size_t nodes = (size_t)map->rows * (size_t)map->columns;
    sample_t *grid = calloc(nodes, sizeof *grid);
    double *psi = calloc(2 * nodes, sizeof *psi);
    map->node = calloc(nodes, sizeof *map->node);
    bool good = grid != NULL && psi != NULL && map->node != NULL;
    if (!good) {
        rig_error("out of memory");
    }
    good = good && place_samples(self, grid);
    for (size_t n = 0; good && n < nodes; ++n) {
        psi[n] = grid[n].value[PSI_D];
        psi[nodes + n] = grid[n].value[PSI_Q];
    }
    if (good) {
        const plant_map_fault_t fault = plant_map_init(map, psi, psi + nodes);
        good = judge(self, grid, &fault);
    }
    free(grid);
    free(psi);
    return good;
}

static bool read_map(reading_t *self) {
    csv_reader_t csv;
    if (!csv_reader_open(&csv, self->path, NULL)) {
        return false;
    }
    bool good = read_header(self, &csv) && read_samples(self, &csv);
    csv_reader_close(&csv);
    if (good && self->samples == 0) {
        rig_error_at(self->path, 0, "no rows; expected one for each node of a grid");
        good = false;
    }
    return good && mirror(self) && build(self);
}

const plant_map_t *flux_map_find(const char *path) {
    // Campaigns and trials make many plants from one configuration.
    static struct {
        char *path;
        plant_map_t *map;
    } known[MAPS_MOST];
    static int maps;
    for (int k = 0; k < maps; ++k) {
        if (strcmp(known[k].path, path) == 0) {
            return known[k].map;
        }
    }
    if (maps == MAPS_MOST) {
        rig_error("%s: expected at most %d flux maps", path, MAPS_MOST);
        return NULL;
    }
    reading_t reading = {.path = path};
    reading.sample = calloc(NODES_MOST, sizeof *reading.sample);
    reading.map = calloc(1, sizeof *reading.map);
    char *name = strdup(path);
    bool good = reading.sample != NULL && reading.map != NULL && name != NULL;
    if (!good) {
        rig_error("out of memory");
    }
    good = good && read_map(&reading);
    free(reading.sample);
    if (!good) {
        if (reading.map != NULL) {
            free(reading.map->node);
        }
        free(reading.map);
        free(name);
        return NULL;
    }
    known[maps].path = name;
    known[maps].map = reading.map;
    return known[maps++].map;
}
