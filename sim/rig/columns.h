/// Which column of a table holds which quantity, and in which unit.
#ifndef RIG_COLUMNS_H
#define RIG_COLUMNS_H

#include <stdbool.h>
#include <stddef.h>

#include "support/csv_reader.h"

/// Quantities of a recording. What stands in stator axes may come as phases in its place, the electrical
/// speed as the mechanical one.
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
    COLUMN_I_C, ///< may be missing: the star point is isolated
    COLUMN_SPEED,
    COLUMN_COUNT
} column_t;

enum { COLUMNS_MAX = 256, COLUMN_NONE = -1 };

typedef struct {
    int count;                   ///< of the table
    int at[COLUMN_COUNT];        ///< from 0; COLUMN_NONE: the quantity is not there, or not needed
    double factor[COLUMN_COUNT]; ///< to SI units
} columns_t;

/// Finds the quantities in the header, which the reader has just read: `map`: "NAME=COLUMN[:UNIT]" of the
/// command line, else columns of the name NAME_UNIT. `header` false: the line is one of data, and only
/// "NAME=#3" finds anything. False after a message.
bool columns_find(columns_t *self, csv_reader_t *reader, const char *const *map, int maps,
                  bool header);

bool columns_has(const columns_t *self, column_t column);

/// The values of the line that the reader has just read, in SI units; 0 for what is not there. False after
/// a message.
bool columns_read(const columns_t *self, csv_reader_t *reader, double value[COLUMN_COUNT]);

#endif
