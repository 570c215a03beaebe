#include "lodestar/vsd.h"

static float mean(lode_abc_t x) {
    return (x.a + x.b + x.c) * (1.0f / 3.0f);
}

static lode_abc_t raised(lode_abc_t x, float by) {
    return (lode_abc_t){x.a + by, x.b + by, x.c + by};
}

lode_vsd_t lode_vsd(const lode_abc6_t *x) {
    const lode_sets_t sets = {{lode_clarke(x->set[0]), lode_set2_clarke(x->set[1])}};
    return (lode_vsd_t){lode_vsd_ab(sets), lode_vsd_xy(sets), mean(x->set[0]), mean(x->set[1])};
}

lode_abc6_t lode_vsd_inverse(const lode_vsd_t *x) {
    const lode_sets_t sets = lode_vsd_sets(x->ab, x->xy);
    const lode_abc_t set_2 = lode_set2_clarke_inverse(sets.set[1]);
    return (lode_abc6_t){{raised(lode_clarke_inverse(sets.set[0]), x->o1), raised(set_2, x->o2)}};
}
