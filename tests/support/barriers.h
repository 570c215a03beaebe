/// The interrupt in place of the compiler barriers, which stand where it could hurt: what the thread posts and reads is
/// tested with the interrupt between any two of its steps. Included before the source that is under test, whose barriers it
/// replaces; the test says in one_period() what the interrupt does.
#ifndef SUPPORT_BARRIERS_H
#define SUPPORT_BARRIERS_H

#include <stdbool.h>
#include <stdint.h>

#define LODE_SIGNAL_FENCE() barrier()

static void one_period(void);

static bool in_interrupt;
static uint32_t barriers;       // passed by the thread
static uint32_t interrupt_from; // from this one on
static uint32_t interrupt_to;   // until before this one
static uint32_t waits;          // for so many periods the thread waits there

static void barrier(void) {
    const uint32_t passed = barriers;
    if (in_interrupt) {
        return;
    }
    barriers++;
    if (passed >= interrupt_from && passed < interrupt_to) {
        in_interrupt = true;
        for (uint32_t n = 0u; n < waits; n++) {
            one_period();
        }
        in_interrupt = false;
    }
}

/// From now on the interrupt comes at the barriers `from` .. `to` - 1 of the thread's.
static void interrupt(uint32_t from, uint32_t to) {
    barriers = 0u;
    interrupt_from = from;
    interrupt_to = to;
}

void setUp(void) {
    interrupt(0u, 0u);
    waits = 1u;
}

void tearDown(void) {}

#endif
