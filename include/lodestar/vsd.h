/// Vector space decomposition of a dual three-phase winding with isolated neutrals: phases a1 b1 c1
/// a2 b2 c2 on axes 0, 120, 240, 30, 150, 270 degrees. Amplitude-invariant.
///
/// The fundamental and the 11th and 13th harmonics appear in alpha-beta, which makes the torque. The 5th and 7th
/// appear in xy, which only has losses. The zero sequences o1, o2 cannot flow.
#ifndef LODESTAR_VSD_H
#define LODESTAR_VSD_H

#include "lodestar/frames.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Number of three-phase sets of the winding.
#define LODE_SETS 2

/// Values of the six phases.
typedef struct {
    lode_abc_t set[LODE_SETS];
} lode_abc6_t;

/// Vectors of the two sets, both in stator axes; alpha lies on phase a1.
typedef struct {
    lode_ab_t set[LODE_SETS];
} lode_sets_t;

/// Clarke transform of set 2, whose phases lie 30 degrees ahead of those of set 1, into stator axes, and its
/// inverse.
LODE_INLINE lode_ab_t lode_set2_clarke(lode_abc_t x) {
    const lode_ab_t out = {(x.a - x.b) * (1.0f / LODE_SQRT3),
                           (x.a + x.b - 2.0f * x.c) * (1.0f / 3.0f)};
    return out;
}

LODE_INLINE lode_abc_t lode_set2_clarke_inverse(lode_ab_t x) {
    const float half = 0.5f * x.beta;
    const float side = 0.5f * LODE_SQRT3 * x.alpha;
    const lode_abc_t out = {half + side, half - side, -x.beta};
    return out;
}

/// alpha-beta is the mean of the two sets' vectors; xy is half of their difference, mirrored (V1).
LODE_INLINE lode_ab_t lode_vsd_ab(lode_sets_t x) {
    const lode_ab_t out = {0.5f * (x.set[0].alpha + x.set[1].alpha),
                           0.5f * (x.set[0].beta + x.set[1].beta)};
    return out;
}

LODE_INLINE lode_ab_t lode_vsd_xy(lode_sets_t x) {
    const lode_ab_t out = {0.5f * (x.set[0].alpha - x.set[1].alpha),
                           0.5f * (x.set[1].beta - x.set[0].beta)};
    return out;
}

/// Set 1: ab + conj(xy); set 2: ab - conj(xy) (V2).
LODE_INLINE lode_sets_t lode_vsd_sets(lode_ab_t ab, lode_ab_t xy) {
    const lode_sets_t out = {
        {{ab.alpha + xy.alpha, ab.beta - xy.beta}, {ab.alpha - xy.alpha, ab.beta + xy.beta}}};
    return out;
}

#ifdef __cplusplus
}
#endif

#endif
