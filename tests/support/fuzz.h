/// What the fuzz targets share: floats out of the input's bytes, and a check that ends the program.
#ifndef SUPPORT_FUZZ_H
#define SUPPORT_FUZZ_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lodestar/motor.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define FUZZ_CHECK(condition)                                                                      \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            (void)fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                  \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

typedef struct {
    const uint8_t *data;
    size_t left;
} fuzz_t;

/// The next bytes; zeros when there are no more.
static inline void fuzz_take(fuzz_t *self, void *out, size_t size) {
    memset(out, 0, size);
    const size_t count = size < self->left ? size : self->left;
    memcpy(out, self->data, count);
    self->data += count;
    self->left -= count;
}

static inline bool fuzz_more(const fuzz_t *self) {
    return self->left > 0;
}

static inline float fuzz_float(fuzz_t *self) {
    float x;
    fuzz_take(self, &x, sizeof x);
    return x;
}

static inline uint8_t fuzz_byte(fuzz_t *self) {
    uint8_t x;
    fuzz_take(self, &x, sizeof x);
    return x;
}

static inline uint16_t fuzz_word(fuzz_t *self) {
    uint16_t x;
    fuzz_take(self, &x, sizeof x);
    return x;
}

/// A number of ordinary size, or any float.
static inline float fuzz_number(fuzz_t *self, float size) {
    if (fuzz_byte(self) < 16) {
        return fuzz_float(self);
    }
    return size * ((float)(int16_t)fuzz_word(self) / 32768.0f);
}

/// The motor of paper 1, Table 3.
static inline lode_motor_t fuzz_motor(void) {
    return (lode_motor_t){.pole_pairs = 3.0f,
                          .Rs_Ohm = 0.75f,
                          .Ld_H = 3.5e-3f,
                          .Lq_H = 9.8e-3f,
                          .psi_Wb = 0.142f,
                          .J_kgm2 = 0.0174f,
                          .B_Nms = 7.5e-4f,
                          .omega_rated_rad_s = 471.24f};
}

#endif
