// For every float there is: a duty that lode_modulator_is_within() takes lies within, and what it refuses of the others is
// -0 alone.
#include "modulator_inline.h"

#include <stdio.h>

int main(void) {
    const float limits[] = {1.0f, 0.9f};
    for (int32_t n = 0; n < 2; n++) {
        const float most = limits[n];
        uint32_t bits = 0u;
        do {
            const union {
                uint32_t bits;
                float value;
            } x = {bits};
            const bool within = x.value >= 0.0f && x.value <= most;
            const bool said = lode_modulator_is_within((lode_abc_t){0.5f, x.value, 0.0f}, most);
            if (said != (within && bits != 0x80000000u)) {
                (void)printf("bits.c: %g of at most %g: %d\n", (double)x.value, (double)most, said);
                return 1;
            }
            bits++;
        } while (bits != 0u);
    }
    return 0;
}
