// The notch at a harmonic, one sample.
#ifndef LODE_NOTCH_INLINE_H
#define LODE_NOTCH_INLINE_H

#include "lodestar/notch.h"
#include "sogi_inline.h"

// The error without its harmonic; unchanged where the notch is blended out. The filter always runs, so that it has settled when
// it is blended in. `k`: as given to lode_notch_adapt().
LODE_INLINE float lode_notch_step(lode_notch_t *self, float k, float error) {
    const lode_sogi_tuning_t tuned = {k, self->g, self->inv_sum};
    return error - self->weight * lode_sogi_step(&self->sogi, &tuned, error).in_phase;
}

#endif
