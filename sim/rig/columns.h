/// The columns of a table: their quantities and units.
#ifndef RIG_COLUMNS_H
#define RIG_COLUMNS_H

#include <stdbool.h>
#include <stddef.h>

#include "support/csv_reader.h"

/// Quantities of a recording. Phases may replace stator axes, and the mechanical speed the electrical one.
typedef enum {
    COLUMN_T,
    COLUMN_U_ALPHA,
    COLUMN_U_BETA,
    COLUMN_I_ALPHA,
    COLUMN_I_BETA,
    COLUMN_THETA_E,
    COLUMN_OMEGA_E,
    COLUMN_U_A,
    COLUMN_U_B,
    COLUMN_U_C,
    COLUMN_I_A,
    COLUMN_I_B,
    COLUMN_I_C, ///< may be missing, because the star point is isolated
    COLUMN_SPEED,
    COLUMN_COUNT
} column_t;

enum { COLUMNS_MAX = 256, COLUMN_NONE = -1 };

typedef struct {
    int count;                   ///< number of columns of the table
    int at[COLUMN_COUNT];        ///< column from 0; COLUMN_NONE: missing or not needed
    double factor[COLUMN_COUNT]; ///< to SI units
} columns_t;

/// Finds the quantities in the header, which the reader has just read: by `map`, "NAME=COLUMN[:UNIT]" of the
/// command line, else by column names NAME_UNIT. `header` false: the line holds data, and only "NAME=#3" can
/// match. False after a message.
bool columns_find(columns_t *self, csv_reader_t *reader, const char *const *map, int maps,
                  bool header);

bool columns_has(const columns_t *self, column_t column);

/// The values of the line that the reader has just read, in SI units; 0 for missing quantities. False after
/// a message.
bool columns_read(const columns_t *self, csv_reader_t *reader, double value[COLUMN_COUNT]);

#endif
