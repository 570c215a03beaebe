#include "scalar_inline.h"

// Not LODE_RAMFUNC: in RUN only for an angle from outside and in options, and small fast memories have no room for it.
lode_sincos_t lode_sincos(float x_rad) {
    const float x =
        lode_in_range(x_rad, -LODE_ANGLE_LIMIT_rad, LODE_ANGLE_LIMIT_rad) ? x_rad : 0.0f;
#ifdef LODE_SINCOS_BOARD
    return lode_sincos_board(x);
#else
    // Rounds to quarter turns; |x| is bounded, so the cast is defined.
    const float quarters = x * 0.636619772367581343f;
    const int32_t n = (int32_t)(quarters + (quarters < 0.0f ? -0.5f : 0.5f));
    // pi/2 in two parts. The first has 15 trailing zero bits, so that n times it is exact (|n| <= 1304).
    const float r = (x - (float)n * 1.5703125f) - (float)n * 4.83826794896619231e-4f;
    const lode_sincos_t near = lode_sincos_octant(r);
    const bool swap = (n & 1) != 0;
    const float sin_abs = swap ? near.cos : near.sin;
    const float cos_abs = swap ? near.sin : near.cos;
    return (lode_sincos_t){(n & 2) != 0 ? -sin_abs : sin_abs,
                           ((n + 1) & 2) != 0 ? -cos_abs : cos_abs};
#endif
}

float lode_wrap(float x_rad) {
    if (!lode_in_range(x_rad, -LODE_ANGLE_LIMIT_rad, LODE_ANGLE_LIMIT_rad)) {
        return 0.0f;
    }
    const float turns = x_rad * (1.0f / LODE_TWO_PI);
    const int32_t n = (int32_t)(turns + (turns < 0.0f ? -0.5f : 0.5f));
    return lode_wrap_once(x_rad - (float)n * LODE_TWO_PI);
}

// Arc tangent for t in [0, 1]. Near-minimax, error 4e-7: tests/golden/gen_minimax.py.
static float arctan_unit(float t) {
    const float u = t * t;
    const float high =
        0.103942618060f + u * (-0.0668908062700f + u * (0.0298522633178f - u * 0.00634397411173f));
    const float low = -0.333332672666f + u * (0.199934678977f + u * (-0.141764298350f + u * high));
    return t + t * u * low;
}

float lode_atan2(float y, float x) {
    const float ax = lode_abs(x);
    const float ay = lode_abs(y);
    const float large = lode_max(ax, ay);
    const float small = lode_min(ax, ay);
    if (!lode_is_finite(x) || !lode_is_finite(y) || !(large > 0.0f)) {
        return 0.0f;
    }
    const float octant = arctan_unit(small / large);
    const float quadrant = ay > ax ? LODE_HALF_PI - octant : octant;
    const float upper = x < 0.0f ? LODE_PI - quadrant : quadrant;
    return y < 0.0f ? -upper : upper;
}

float lode_one_minus_exp(float x) {
    if (!(x > 0.0f)) {
        return 0.0f;
    }
    if (x > 20.0f) {
        return 1.0f; // exp(-20) is below half an ulp of 1
    }
    // With x/2^7 <= 0.16 the relative error of four terms is at most 5e-6, and that only where exp(-x) is too small to show.
    // Then 1 - exp(-2x) = y (2 - y) seven times.
    const float r = x * (1.0f / 128.0f);
    float y = r * (1.0f - r * (0.5f - r * (1.0f / 6.0f - r * (1.0f / 24.0f))));
    for (int32_t i = 0; i < 7; i++) {
        y *= 2.0f - y;
    }
    return y;
}
