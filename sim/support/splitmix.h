/// SplitMix64 (Steele, Lea, Flood 2014): one random number per step from any seed.
#ifndef SUPPORT_SPLITMIX_H
#define SUPPORT_SPLITMIX_H

#include <stdint.h>

/// Uniform in 0 .. 1.
static inline double splitmix_uniform(uint64_t *state) {
    *state += UINT64_C(0x9E3779B97F4A7C15);
    uint64_t z = *state;
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1.0p-53;
}

#endif
