/// Gate timing of one inverter leg: centre-aligned PWM with dead time.
///
/// The high side is requested in [(1-d)/2, (1+d)/2) of the period, with a separate d for each end, and the low
/// side in the rest. The
/// gate that turns off does so at once, the one that turns on waits for the dead time; a request
/// shorter than the dead time leaves both off. Requests and waits carry over the period's boundary.
#ifndef PLANT_PWM_H
#define PLANT_PWM_H

#include <stdbool.h>

typedef enum { PLANT_GATE_OFF, PLANT_GATE_LOW, PLANT_GATE_HIGH } plant_gate_t;

/// Switches that may be on. LOW: the low sides alone, in their share of the period.
typedef enum { PLANT_GATES_OFF, PLANT_GATES_ON, PLANT_GATES_LOW } plant_gates_t;

typedef struct {
    double at_s; ///< from the start of the period
    plant_gate_t gate;
} plant_edge_t;

enum { PLANT_EDGES = 8 };

/// The scheduled part of a carrier period: all of it, or with double update the first half, whose pulse lies at
/// its end, or the second half, whose pulse lies at its start.
typedef enum { PLANT_PERIOD, PLANT_RISING_HALF, PLANT_FALLING_HALF } plant_part_t;

typedef struct {
    plant_part_t part;              ///< that is scheduled next
    plant_edge_t edge[PLANT_EDGES]; ///< of this period, in order of time
    int edges;
    int next;            ///< first edge still to come
    plant_gate_t gate;   ///< on now
    plant_gate_t wanted; ///< requested last
    bool waiting;        ///< the wanted gate is not on yet ...
    double ready_s;      ///< ... and turns on at this time
} plant_pwm_t;

void plant_pwm_init(plant_pwm_t *self, bool double_update);

/// Duties of the two halves of a period; equal where the pulse lies in its middle.
typedef struct {
    double rise, fall;
} plant_duty_t;

/// Schedules the edges of the period that begins now; with double update, of the next half. A duty of 0 or 1
/// has no edges.
void plant_pwm_schedule(plant_pwm_t *self, plant_duty_t duty, plant_gates_t gates, double period_s,
                        double dead_time_s);

/// Applies all remaining edges.
static inline void plant_pwm_finish(plant_pwm_t *self) {
    if (self->next < self->edges) {
        self->next = self->edges;
        self->gate = self->edge[self->edges - 1].gate;
    }
}

/// First edge after this time; the number of edges if there is none.
int plant_pwm_first_after(const plant_pwm_t *self, double at_s);

/// Applies all edges up to this time; true if there was any.
bool plant_pwm_apply(plant_pwm_t *self, double now_s);

#endif
