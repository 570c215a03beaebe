/// Figures and tables of paper 1: as printed, as its formulas have them, and as the firmware's recursions do.
#ifndef RIG_PAPER1_H
#define RIG_PAPER1_H

#include "analyse/result.h"

/// Fills its rows, curves and poles.
void analyse_paper1(analyse_t *self);

#endif
