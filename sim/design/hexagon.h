/// Over-modulation: what the hexagon leaves of a voltage circle beyond it.
#ifndef RIG_DESIGN_HEXAGON_H
#define RIG_DESIGN_HEXAGON_H

/// NaN unless the circle goes beyond the hexagon.
typedef struct {
    double fundamental; ///< of v_bus/sqrt(3)
    double ripple; ///< largest distance of the vector from it, six times per turn, as a share of it
} hexagon_t;

/// `use`: the circle's radius as a share of v_bus/sqrt(3). With the min-max zero sequence each duty is clamped to 0 .. 1 (B11).
hexagon_t hexagon_of(double use);

#endif
