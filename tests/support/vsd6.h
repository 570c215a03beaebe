/// The whole transform of six phases (V3) and its inverse (V4), made of the parts that the core uses.
#ifndef SUPPORT_VSD6_H
#define SUPPORT_VSD6_H

#include "lodestar/vsd.h"

typedef struct {
    lode_ab_t ab;
    lode_ab_t xy;
    float o1; ///< mean of set 1
    float o2; ///< mean of set 2
} vsd6_t;

static inline float vsd6_mean(lode_abc_t x) {
    return (x.a + x.b + x.c) * (1.0f / 3.0f);
}

static inline lode_abc_t vsd6_raised(lode_abc_t x, float by) {
    return (lode_abc_t){x.a + by, x.b + by, x.c + by};
}

static inline vsd6_t vsd6(const lode_abc6_t *x) {
    const lode_sets_t sets = {{lode_clarke(x->set[0]), lode_set2_clarke(x->set[1])}};
    return (vsd6_t){lode_vsd_ab(sets), lode_vsd_xy(sets), vsd6_mean(x->set[0]),
                    vsd6_mean(x->set[1])};
}

static inline lode_abc6_t vsd6_inverse(const vsd6_t *x) {
    const lode_sets_t sets = lode_vsd_sets(x->ab, x->xy);
    const lode_abc_t set_2 = lode_set2_clarke_inverse(sets.set[1]);
    return (lode_abc6_t){
        {vsd6_raised(lode_clarke_inverse(sets.set[0]), x->o1), vsd6_raised(set_2, x->o2)}};
}

#endif
