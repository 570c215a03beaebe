#include "edge.h"

#define FIRST 3u      // sample of the fit: duties that are a period late have acted by then
#define LEAST 4u      // samples
#define LOW 0.15f     // of the level: below it noise and dead time decide
#define BEND_LOW 0.3f // of the level: above it the bend is evaluated, clear of small currents
#define PULL_MAX 1.0f
// The remaining bend, a fifth, moves the edge by n^2/(60 tau) calls: at most a tenth with n = sqrt(6 tau).
#define SAMPLES_TAU 6.0f
#define QUANTUM_count 0.3f // least noise assumed, from rounding
#define SIGMA_MAX 0.15f    // calls

void edge_begin(volatile edge_t *self, uint32_t leg, uint32_t from, float fall) {
    self->wanted = 0u; // from here on the interrupt does not write it
    self->leg = leg;
    self->from = from;
    self->fall = fall;
    self->edges = 0u;
    self->level_sum = 0u;
    self->level_taken = 0u;
    for (uint32_t m = 0u; m < EDGE_SAMPLES; m++) {
        self->sum[m] = 0u;
    }
    edge_ask(self);
}

void edge_ask(volatile edge_t *self) {
    self->wanted = 0u;
    self->taken = 0u;
    self->before = 0u;
    self->wanted = EDGE_SAMPLES;
}

// Runs from flash: outside bring-up it returns at once, and the fast memory is reserved for the step.
void edge_take(volatile edge_t *self, const lode_counts_t *counts, lode_abc_t duty) {
    if (self->taken >= self->wanted) {
        return;
    }
    const float duties[3] = {duty.a, duty.b, duty.c};
    const float now = duties[self->leg];
    const uint32_t count = counts->i[self->from];
    if (self->before == 0u) {
        self->duty = now;
    }
    if (self->taken == 0u && self->duty - now < self->fall) {
        self->level_sum += count;
        self->level_taken++;
        self->before++;
        return;
    }
    self->sum[self->taken] += count;
    self->taken++;
    self->edges += self->taken >= self->wanted ? 1u : 0u;
}

bool edge_ready(const volatile edge_t *self) {
    return self->before >= EDGE_LEVEL;
}

bool edge_done(const volatile edge_t *self) {
    return self->wanted > 0u && self->taken >= self->wanted;
}

// 0 < x: twice the series of the inverse hyperbolic tangent, from 1/sqrt(2) up.
static float logarithm(float x) {
    float halves = 0.0f;
    float reduced = x;
    while (reduced < 0.70710678f) {
        reduced *= 1.41421356f;
        halves += 1.0f;
    }
    const float z = (reduced - 1.0f) / (reduced + 1.0f);
    const float zz = z * z;
    return 2.0f * z * (1.0f + zz * (1.0f / 3.0f + zz * 0.2f)) - halves * 0.34657359f;
}

/// The mean of a call's samples, as a share of the level before the step.
typedef struct {
    const volatile edge_t *edge;
    float offset_count;
    float per_count;
} course_t;

static float share_at(const course_t *course, uint32_t m) {
    const float mean = (float)course->edge->sum[m] / (float)course->edge->edges;
    return (mean - course->offset_count) * course->per_count;
}

// The final value of the current is below zero by this share: dead time acts like the winding's resistance.
// Fall and area of the two halves of the course distinguish it from the time constant.
static float pull(const course_t *course) {
    uint32_t count = 0u;
    while (FIRST + count < EDGE_SAMPLES && share_at(course, FIRST + count) >= BEND_LOW) {
        count++;
    }
    const uint32_t half = count > 0u ? (count - 1u) / 2u : 0u;
    float fall[2] = {0.0f, 0.0f};
    float area[2] = {0.0f, 0.0f};
    for (uint32_t m = 0u; m < 2u * half; m++) {
        const float from = share_at(course, FIRST + m);
        const float to = share_at(course, FIRST + m + 1u);
        fall[m / half] += from - to;
        area[m / half] += 0.5f * (from + to);
    }
    const float more = fall[0] - fall[1];
    if (half < LEAST || !(more > 0.0f)) {
        return half < LEAST ? 0.0f : PULL_MAX;
    }
    const float share = (area[0] * fall[1] - area[1] * fall[0]) / (more * (float)half);
    return lode_clamp(share, 0.0f, PULL_MAX);
}

typedef struct {
    float n, x, y, xx, xy, yy;
} sums_t;

// Fit of the logarithm of the remaining current, which is a straight line and 0 at the level.
static sums_t gather(const course_t *course, float pulled, uint32_t most) {
    sums_t s = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    for (uint32_t m = FIRST; m < FIRST + most && m < EDGE_SAMPLES; m++) {
        const float share = share_at(course, m);
        if (!(share >= LOW)) {
            break;
        }
        const float x = (float)m;
        const float y = logarithm((share + pulled) / (1.0f + pulled));
        s.n += 1.0f;
        s.x += x;
        s.y += y;
        s.xx += x * x;
        s.xy += x * y;
        s.yy += y * y;
    }
    return s;
}

edge_time_t edge_time(const volatile edge_t *self, float offset_count, float tau) {
    edge_time_t time = {0.0f, 0.0f, false};
    const float level_count = (float)self->level_sum / (float)self->level_taken - offset_count;
    const uint32_t most =
        (uint32_t)(int32_t)lode_clamp(sqrtf(SAMPLES_TAU * tau), (float)LEAST, (float)EDGE_SAMPLES);
    const course_t course = {self, offset_count, 1.0f / level_count};
    const sums_t s = gather(&course, pull(&course), most);
    if (s.n < (float)LEAST) {
        return time;
    }
    const float span = s.xx - s.x * s.x / s.n;
    const float slope = (s.xy - s.x * s.y / s.n) / span;
    if (!(slope < 0.0f)) {
        return time;
    }
    const float quantum = QUANTUM_count / lode_abs(level_count);
    const float rest = s.yy - s.y * s.y / s.n - slope * slope * span;
    const float noise = lode_max(sqrtf(lode_max(rest, 0.0f) / (s.n - 2.0f)), quantum);
    const float middle = s.x / s.n;
    time.at = middle - s.y / s.n / slope; // intersection with the level, whose logarithm is 0
    const float away = middle - time.at;
    // The level is rounded as well.
    const float variance = noise * noise * (1.0f / s.n + away * away / span) + quantum * quantum;
    time.sigma = sqrtf(variance) / -slope;
    time.known = time.sigma <= SIGMA_MAX;
    return time;
}
