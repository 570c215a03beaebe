/// Table 1 of paper 1 by experiment: PLLs on an angle that moves as said.
#ifndef RIG_REPRODUCE_TABLES_H
#define RIG_REPRODUCE_TABLES_H

#include "reproduce/theory.h"

/// Error (estimate - truth) at the end of 0.5 s, mean of the last 10 ms. `motion`: 0 a step of position, 1
/// of speed, 2 a ramp of speed at 2000 rpm/s. `printed`: the papers' form, else the library's.
double tables_tracking_deg(const theory_t *t, bool leso, int motion, bool printed);

#endif
