/// Geometry of one or two winding sets, and the voltage at floating terminals.
///
/// Set 1 (phases a1 b1 c1) lies on axes 0, 120, 240 degrees, set 2 on 30, 150, 270, each with an
/// isolated neutral. In complex numbers, amplitude invariant:
///     set 1 = alpha-beta + conj(xy)      set 2 = alpha-beta - conj(xy)                   (M5)
/// A phase's quantity is the projection of its set's vector on its axis. One set has no xy.
#ifndef PLANT_SETS_H
#define PLANT_SETS_H

#include "plant/config.h"

#define PLANT_SQRT3_2 0.86602540378443864676

typedef struct {
    double alpha, beta;
} plant_vector_t;

/// Both planes of a machine.
typedef struct {
    plant_vector_t ab, xy;
} plant_planes_t;

/// Phases of a set that carry no current: the number of one leg, or one of these.
enum { PLANT_NONE_FLOATS = -1, PLANT_ALL_FLOAT = PLANT_LEGS };

/// Cosine and sine of the axis of a leg's phase.
extern const double plant_axis_cos[PLANT_LEGS];
extern const double plant_axis_sin[PLANT_LEGS];

/// (M5).
static inline plant_vector_t plant_sets_vector(const plant_planes_t *planes, int set) {
    const double sign = set == 0 ? 1.0 : -1.0;
    return (plant_vector_t){planes->ab.alpha + sign * planes->xy.alpha,
                            planes->ab.beta - sign * planes->xy.beta};
}

/// Adds a vector to one of two sets and leaves the other as it is.
static inline void plant_sets_add(plant_planes_t *planes, int set, plant_vector_t vector) {
    const double sign = set == 0 ? 0.5 : -0.5;
    planes->ab.alpha += 0.5 * vector.alpha;
    planes->ab.beta += 0.5 * vector.beta;
    planes->xy.alpha += sign * vector.alpha;
    planes->xy.beta -= sign * vector.beta;
}

/// Slope of the currents of two sets per volt, 1/H: a symmetric matrix in alpha-beta.
typedef struct {
    double alpha_alpha, alpha_beta, beta_beta, xy;
} plant_compliance_t;

/// The voltage vectors of floating phases of two sets at the terminals: they keep the currents of these phases
/// constant. `rate` (A/s, per set): slope of the currents without these voltages.
void plant_sets_hold(const plant_compliance_t *compliance, const int floating[PLANT_SETS],
                     const plant_vector_t rate[PLANT_SETS], plant_vector_t push_V[PLANT_SETS]);

#endif
