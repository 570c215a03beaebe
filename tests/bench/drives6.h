/// The drives for six phases that the budget counts: each of the two sets is the motor of drives.h, and
/// each case is configured like the one for three phases of the same name.
#ifndef BENCH_DRIVES6_H
#define BENCH_DRIVES6_H

#include "drives.h"

#define BENCH_CASES6(X)                                                                            \
    X(c_leso_qpll)                                                                                 \
    X(fa_leso_leso_qpll)                                                                           \
    X(enhanced)

#define BENCH6_ENUMERATOR(name) BENCH6_##name,
enum { BENCH_CASES6(BENCH6_ENUMERATOR) BENCH6_CASE_COUNT };

/// The case for three phases.
int32_t bench6_like(int32_t number);

lode_drive6_config_t bench6_config(int32_t number);

extern lode_drive6_t bench6_drive[BENCH6_CASE_COUNT];

/// As bench_begin() and bench_digest().
bool bench6_begin(int32_t number);
uint32_t bench6_digest(lode_drive6_out_t out);

#endif
