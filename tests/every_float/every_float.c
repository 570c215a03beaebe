// usage: every_float [STRIDE]: the scalar functions over all 2^32 floats, or over each STRIDE-th of their bit
// patterns, against libm in double. Prints for each the largest error as a share of what is allowed, and the float
// that has it; exits 1 where one is above 1.
#include <stdlib.h>
#include <unistd.h>

#include "scalar_inline.h"
#include "support/check.h"
#include "support/workers.h"

// How far a result is off, as a share of what its header allows. NaN and anything out of range: infinite.
typedef double (*share_of_allowed_t)(float x);

static double share(double error, double allowed) {
    return isfinite(error) ? fabs(error) / allowed : (double)INFINITY;
}

static double must(bool good) {
    return good ? 0.0 : (double)INFINITY;
}

static bool is_angle(float x) {
    return x >= -LODE_PI && x <= LODE_PI;
}

static double sincos_of_any(float x) {
    const lode_sincos_t s = lode_sincos(x);
    if (!(fabsf(x) <= LODE_ANGLE_LIMIT_rad)) {
        return must(s.sin == 0.0f && s.cos == 1.0f);
    }
    const double most = fmax(share((double)s.sin - sin((double)x), 1.0e-6),
                             share((double)s.cos - cos((double)x), 1.0e-6));
    return fmax(most, must(fabsf(s.sin) <= 1.0f && fabsf(s.cos) <= 1.0f));
}

static double sincos_octant(float x) {
    if (!(fabsf(x) <= 0.25f * LODE_PI)) {
        return 0.0;
    }
    const lode_sincos_t s = lode_sincos_octant(x);
    return fmax(share((double)s.sin - sin((double)x), 1.0e-7),
                share((double)s.cos - cos((double)x), 1.0e-7));
}

// The turns taken off are as many as the float 2 pi is off: 1.2e-7 of the angle, and roundings near pi.
static double wrap(float x) {
    const float wrapped = lode_wrap(x);
    if (!(fabsf(x) <= LODE_ANGLE_LIMIT_rad)) {
        return must(wrapped == 0.0f);
    }
    const double error = angle_error((double)x, (double)wrapped);
    return fmax(share(error, 1.2e-7 * fabs((double)x) + 3.0e-7), must(is_angle(wrapped)));
}

static double wrap_once(float x) {
    if (!(fabsf(x) <= 3.0f * LODE_PI)) {
        return 0.0;
    }
    const double wrapped = (double)lode_wrap_once(x);
    return fmax(share(angle_error((double)x, wrapped), 1.0e-6),
                must(fabs(wrapped) <= CHECK_PI + 1.0e-6));
}

// Correctly rounded: half a last place.
static double square_root(float x) {
    const float root = lode_sqrt(x);
    return x > 0.0f && isfinite(x) ? share((double)root - sqrt((double)x), 6.0e-8 * sqrt((double)x))
                                   : must(x > 0.0f ? root == INFINITY : root == 0.0f);
}

// One in a million of its value; of what is denormal, 128 of the least float.
static double one_minus_exp(float x) {
    const float y = lode_one_minus_exp(x);
    if (!(x > 0.0f)) {
        return must(y == 0.0f);
    }
    const double expected = -expm1(-(double)x);
    return fmax(share((double)y - expected, 1.0e-6 * expected + 128.0 * 1.5e-45), must(y <= 1.0f));
}

static double angle_of(float y, float x) {
    const float angle = lode_atan2(y, x);
    if (!isfinite(y) || !isfinite(x)) {
        return must(angle == 0.0f);
    }
    const double error = angle_error((double)angle, atan2((double)y, (double)x));
    // The zero vector has the angle 0, whatever the signs of its zeros.
    return fmax(y == 0.0f && x == 0.0f ? must(angle == 0.0f) : share(error, 1.0e-6),
                must(is_angle(angle)));
}

static double atan2_of_y(float x) {
    return angle_of(x, 1.0f);
}

static double atan2_of_x(float x) {
    return angle_of(-1.0f, x);
}

// Each float with one other, as different as a multiplication makes its bits: each is x once, and y once.
static double atan2_of_pairs(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return angle_of(check_from_bits(bits * 2654435761u + 1u), x);
}

static double limits(float x) {
    const float clamped = lode_clamp(x, -2.0f, 3.0f);
    const float expected = isnan(x) ? -2.0f : fminf(fmaxf(x, -2.0f), 3.0f);
    const bool in_range = !isnan(x) && !isless(x, -2.0f) && !isgreater(x, 3.0f);
    return must(clamped == expected && lode_in_range(x, -2.0f, 3.0f) == in_range &&
                lode_is_finite(x) == (isfinite(x) != 0) &&
                lode_sign(x) == (isless(x, 0.0f) ? -1.0f : 1.0f) &&
                (isnan(x) || (lode_min(x, 1.0f) == fminf(x, 1.0f) &&
                              lode_max(x, 1.0f) == fmaxf(x, 1.0f) && lode_abs(x) == fabsf(x))));
}

static const struct {
    const char *name;
    share_of_allowed_t of;
} functions[] = {{"sincos", sincos_of_any},
                 {"sincos_octant", sincos_octant},
                 {"wrap", wrap},
                 {"wrap_once", wrap_once},
                 {"sqrt", square_root},
                 {"one_minus_exp", one_minus_exp},
                 {"atan2(y, 1)", atan2_of_y},
                 {"atan2(-1, x)", atan2_of_x},
                 {"atan2(y, x)", atan2_of_pairs},
                 {"clamp, min, max, ...", limits}};

enum { FUNCTIONS = COUNT_OF(functions), PIECES = 256 };

typedef struct {
    double share[FUNCTIONS];
    float at[FUNCTIONS];
} worst_share_t;

typedef struct {
    uint64_t stride;
    worst_share_t worst;
} all_t;

static void note(worst_share_t *worst, int k, double found, float at) {
    if (!(found <= worst->share[k])) {
        worst->share[k] = found;
        worst->at[k] = at;
    }
}

static bool work(void *user, uint64_t number, void *result) {
    const uint64_t stride = ((const all_t *)user)->stride;
    const uint64_t first = number << 24;
    worst_share_t worst = {.share = {0.0}};
    for (uint64_t bits = (first + stride - 1u) / stride * stride; bits >> 24 == number;
         bits += stride) {
        const float x = check_from_bits((uint32_t)bits);
        for (int k = 0; k < FUNCTIONS; k++) {
            note(&worst, k, functions[k].of(x), x);
        }
    }
    memcpy(result, &worst, sizeof worst);
    return true;
}

static void take(void *user, uint64_t number, const void *result) {
    worst_share_t worst;
    memcpy(&worst, result, sizeof worst);
    for (int k = 0; k < FUNCTIONS; k++) {
        note(&((all_t *)user)->worst, k, worst.share[k], worst.at[k]);
    }
    if (isatty(STDERR_FILENO)) {
        (void)fprintf(stderr, "\r%3d of %d%s", (int)number + 1, PIECES,
                      number + 1u == PIECES ? "\n" : "");
    }
}

int main(int count, char **arguments) {
    char *end = "";
    const long long stride = count > 1 ? strtoll(arguments[1], &end, 10) : 1;
    if (count > 2 || *end != '\0' || stride < 1 || stride > UINT32_MAX) {
        (void)fprintf(stderr, "usage: every_float [STRIDE]; STRIDE is 1 .. %lu\n",
                      (unsigned long)UINT32_MAX);
        return 2;
    }
    all_t all = {.stride = (uint64_t)stride};
    const workers_t workers = {.last = PIECES - 1, .user = &all, .work = work, .take = take};
    if (!workers_run(&workers)) {
        return 1;
    }
    (void)printf("%llu floats\nfunction              largest error, of what is allowed      at\n",
                 (unsigned long long)(UINT32_MAX / all.stride + 1u));
    bool good = true;
    for (int k = 0; k < FUNCTIONS; k++) {
        (void)printf("%-21s %28.3f %17.9g\n", functions[k].name, all.worst.share[k],
                     (double)all.worst.at[k]);
        good = good && all.worst.share[k] <= 1.0;
    }
    return good ? 0 : 1;
}
