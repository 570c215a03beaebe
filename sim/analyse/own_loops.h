/// The control loops of the given drive: sampled open loops and margins.
///
/// Current: (K2) with the R-L circuit held over the period and the voltage one period late. Estimator: the
/// PLL with observer and notches (margins.h). Speed: the PI controller, current control in closed loop, the
/// inertia, and the speed from the estimator, without the feed-forwards of load and inertia.
#ifndef RIG_OWN_LOOPS_H
#define RIG_OWN_LOOPS_H

#include "analyse/result.h"

/// Fills the figures "own-..." and the loops of `self`.
void own_loops(analyse_t *self, const lode_drive_config_t *drive,
               const lode_drive_tuning_t *tuning);

/// The three loops of a drive at one speed.
typedef struct {
    analyse_loop_t current; ///< of the axis with less margin; the same at any speed
    analyse_loop_t pll;     ///< with observer and notches
    analyse_loop_t speed;
} own_margins_t;

/// At this electrical speed, with the EMF.
own_margins_t own_loops_at(const lode_drive_config_t *drive, const lode_drive_tuning_t *tuning,
                           double omega_rad_s);

#endif
