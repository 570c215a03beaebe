/// The limits that init enforces and related ones, calculated for one drive.
#ifndef RIG_DESIGN_LIMITS_H
#define RIG_DESIGN_LIMITS_H

#include "lodestar/drive.h"

enum { LIMITS_NOTCHES = 3 };

/// The drive's PLL with the full notch, at its sigma.
typedef struct {
    double k;
    double least;    ///< notch frequency over sigma above which the loop is stable; 0: everywhere
    double low_deg;  ///< phase margin where the notch begins to fade in, 6 sigma
    double high_deg; ///< and where it acts fully, 8 sigma
} limits_notch_t;

typedef struct {
    double w0_margin_deg; ///< PLL with the C-LESO in its loop, sigma = w0/5, at its worst speed
    double w0_margin_notch_deg; ///< the same with a notch (k 0.5) that acts fully at 8 sigma
    double sigma_per_w0;        ///< at which no margin is left
    limits_notch_t notch[LIMITS_NOTCHES];
    double gi_sigma_rad_s; ///< least unstable sigma of GI-LESO and PLL up to omega_max; NaN: none
    double gi_omega_rad_s; ///< where
    double gi_filtered_rad_s; ///< the same with the tuning speed filtered at 60 rad/s; NaN: none
    /// random polynomials, and how many of the verdicts their roots contradict
    int routh_cases, routh_wrong;
} limits_t;

limits_t limits_compute(const lode_drive_config_t *drive);

/// Random s^2 + (a1 + j b1) s + (a2 + j b2): how often the generalised Routh condition is wrong.
int limits_routh_wrong(int cases);

#endif
