/// Table 1 and Fig. 7 of paper 1 by experiment: its loops on a perfect motor.
#ifndef RIG_REPRODUCE_TABLES_H
#define RIG_REPRODUCE_TABLES_H

#include "reproduce/theory.h"

/// Error (estimate - truth) at the end of 0.5 s, mean of the last 10 ms. `motion`: 0 a step of position, 1
/// of speed, 2 a ramp of speed at 2000 rpm/s. `printed`: the papers' form, else the library's.
double tables_tracking_deg(const theory_t *t, bool leso, int motion, bool printed);

/// Fig. 7, observer, eq. 30, notch and PLL as one loop on a steadily turning rotor without current: the lowest
/// speed above which an angle error of 1 deg decays, rpm. `continuous`: in continuous time,
/// else in forward Euler.
double tables_lowest_stable_rpm(const theory_t *t, double notch_k, bool continuous);

#endif
