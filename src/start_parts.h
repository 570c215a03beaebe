// What the design of a start and the start itself share.
#ifndef LODE_START_PARTS_H
#define LODE_START_PARTS_H

#include "start_inline.h"

// Of the speed of the hand-over: from rest the ramp is as steep as if the vector turned with that (S35).
#define STEEP 64.0f
// Of the start current, in the last attempt; from CURRENT_SHARE of i_max up to i_max. A rotor that needs so much is
// loaded, and lags by so much that reluctance adds to its torque.
#define CURRENT_LAST 2.0f
#define SWING_CORNER 3.0f // of its deviation: above, an error in Lq would close a loop
// Of the current, with which resistance and dead time are measured first.
#define LEVEL_SHARE 0.5f

#endif
