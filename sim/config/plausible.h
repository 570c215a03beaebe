/// Checks that the values of a motor fit each other and its drive: a wrong unit gives ratios that no motor has.
#ifndef RIG_PLAUSIBLE_H
#define RIG_PLAUSIBLE_H

#include <stdbool.h>
#include <stdio.h>

#include "lodestar/drive.h"

enum { PLAUSIBLE_RATIOS = 5 };

/// A ratio that is similar for small and large motors.
typedef struct {
    const char *key; ///< for programs
    const char *name;
    const char *unit;  ///< of value, least and most
    double usual_low;  ///< range of the catalogue's motors with their drives
    double usual_high; ///< the same
    double least;      ///< plausible
    double most;
    const char *made_of; ///< the values it depends on, with their units
    double value;        ///< NaN: not defined
} plausible_ratio_t;

typedef struct {
    plausible_ratio_t ratio[PLAUSIBLE_RATIOS];
} plausible_t;

/// For a designed configuration, accepted by the library or not.
plausible_t plausible_of(const lode_drive_config_t *drive);

/// True if the value is far from every motor of the catalogue.
bool plausible_is_doubtful(const plausible_ratio_t *ratio);

/// Prints a line for each implausible ratio. Returns their number.
int plausible_print_doubts(FILE *file, const plausible_t *self);

#endif
