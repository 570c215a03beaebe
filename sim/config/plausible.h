/// Whether the figures of a motor fit each other and its drive: a wrong unit brings out what no motor has.
#ifndef RIG_PLAUSIBLE_H
#define RIG_PLAUSIBLE_H

#include <stdbool.h>
#include <stdio.h>

#include "lodestar/drive.h"

enum { PLAUSIBLE_RATIOS = 5 };

/// One that is much the same for small motors and large ones.
typedef struct {
    const char *key; ///< for programs
    const char *name;
    const char *unit;  ///< of value, least and most
    double usual_low;  ///< of the catalogue's motors with their drives
    double usual_high; ///< the same
    double least;      ///< plausible
    double most;
    const char *made_of; ///< which figures, in which units
    double value;        ///< NaN: there is none
} plausible_ratio_t;

typedef struct {
    plausible_ratio_t ratio[PLAUSIBLE_RATIOS];
} plausible_t;

/// Of a configuration that is designed, accepted or not.
plausible_t plausible_of(const lode_drive_config_t *drive);

/// The value is far from every motor of the catalogue.
bool plausible_is_doubtful(const plausible_ratio_t *ratio);

/// A line for each doubtful one. How many there are.
int plausible_print_doubts(FILE *file, const plausible_t *self);

#endif
