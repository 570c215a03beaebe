/// Figures and tables of paper 2: as printed, as its formulas have them, and as the firmware's recursions do.
#ifndef RIG_PAPER2_H
#define RIG_PAPER2_H

#include "analyse/result.h"

/// Fills its rows, curves and poles.
void analyse_paper2(analyse_t *self, const lode_motor_t *motor);

#endif
