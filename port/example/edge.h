/// Measures when duties act. Voltage steps are followed call by call: call 0 writes the new duties, they act
/// from the sample of call 1 on, and the sample of call 2 is the first that shows them. The intersection of the
/// current's course with its previous level gives the instant at which they began to act.
///
/// If all three legs are one period off, that instant moves by a period; if one leg is, by half a period in its
/// own phase.
#ifndef LODESTAR_PORT_EDGE_H
#define LODESTAR_PORT_EDGE_H

#include "lodestar/lodestar.h"

#define EDGE_SAMPLES 64u
#define EDGE_LEVEL 64u     ///< samples before the step, at least
#define EDGE_COUNT 16u     ///< steps, against noise
#define EDGE_EXPECTED 1.0f ///< call at whose sample the duties begin to act

typedef struct {
    uint32_t wanted; ///< 0: no request
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
    bool known;  ///< else the current changes too little, or too fast, for a result
} edge_time_t;

/// Restarts the measurement. Thread.
void edge_begin(volatile edge_t *self, uint32_t leg, uint32_t from, float fall);
/// Requests one more step: the samples from now on, and those from the next fall of the leg's duty on. Thread.
void edge_ask(volatile edge_t *self);
/// Interrupt: the samples, and the duties computed from them.
void edge_take(volatile edge_t *self, const lode_counts_t *counts, lode_abc_t duty);
/// True if there are enough samples before the step: now the step may come.
bool edge_ready(const volatile edge_t *self);
bool edge_done(const volatile edge_t *self);

/// `tau`: time constant of the winding, calls.
edge_time_t edge_time(const volatile edge_t *self, float offset_count, float tau);

#endif
