/// When duties act. Steps of the voltage are followed call by call: the call that writes the new duties is 0, they act
/// from the sample of call 1 on, and that of call 2 is the first that has seen them. Where the current's course meets
/// the level that it had before says when they really began to act.
///
/// Three legs that are a period off move that instant by a whole period, one of three by half of one in its own phase.
#ifndef LODESTAR_PORT_EDGE_H
#define LODESTAR_PORT_EDGE_H

#include "lodestar/lodestar.h"

#define EDGE_SAMPLES 64u
#define EDGE_LEVEL 64u     ///< samples before the step, at least
#define EDGE_COUNT 16u     ///< steps, against noise
#define EDGE_EXPECTED 1.0f ///< call at whose sample the duties begin to act

typedef struct {
    uint32_t wanted; ///< 0: nothing asked
    uint32_t taken;  ///< of this step
    uint32_t leg;    ///< whose duty falls
    uint32_t from;   ///< which current is sampled
    uint32_t before; ///< samples before this step
    float duty;      ///< of the leg before it
    float fall;      ///< of the duty that is the step
    uint32_t edges;  ///< complete
    uint32_t level_sum;
    uint32_t level_taken;
    uint32_t sum[EDGE_SAMPLES];
} edge_t;

typedef struct {
    float at;    ///< when the duties began to act, calls
    float sigma; ///< of that, by noise
    bool known;  ///< else the current changes too little, or too fast, to tell
} edge_time_t;

/// Begins anew. Thread.
void edge_begin(volatile edge_t *self, uint32_t leg, uint32_t from, float fall);
/// One more of them: the samples from now on, and those from the next fall of the leg's duty on. Thread.
void edge_ask(volatile edge_t *self);
/// Interrupt: what has been sampled, and the duties that it led to.
void edge_take(volatile edge_t *self, const lode_counts_t *counts, lode_abc_t duty);
/// Enough is known of what was before: now the step may come.
bool edge_ready(const volatile edge_t *self);
bool edge_done(const volatile edge_t *self);

/// `tau`: time constant of the winding, calls.
edge_time_t edge_time(const volatile edge_t *self, float offset_count, float tau);

#endif
