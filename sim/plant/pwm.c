#include "plant/pwm.h"

void plant_pwm_init(plant_pwm_t *self, bool double_update) {
    *self = (plant_pwm_t){.part = double_update ? PLANT_RISING_HALF : PLANT_PERIOD,
                          .gate = PLANT_GATE_OFF,
                          .wanted = PLANT_GATE_OFF};
}

static void add_edge(plant_pwm_t *self, double at_s, plant_gate_t gate) {
    self->edge[self->edges++] = (plant_edge_t){.at_s = at_s, .gate = gate};
}

/// The modulator requests a gate: the other one turns off now, this one turns on after the dead time.
static void ask(plant_pwm_t *self, double at_s, plant_gate_t gate, double dead_time_s) {
    if (gate == self->wanted) {
        return;
    }
    if (self->waiting && self->ready_s <= at_s) {
        add_edge(self, self->ready_s, self->wanted);
    }
    add_edge(self, at_s, PLANT_GATE_OFF);
    self->wanted = gate;
    self->waiting = true;
    self->ready_s = at_s + dead_time_s;
}

/// The usual period: the low gate on at both ends, and each requested gate turns on before the next turns off.
/// The edges are those of ask(). False for any other period.
static bool schedule_pulse(plant_pwm_t *self, plant_duty_t duty, double period_s,
                           double dead_time_s) {
    const double rise_s = 0.5 * (1.0 - duty.rise) * period_s;
    const double fall_s = 0.5 * (1.0 + duty.fall) * period_s;
    const bool is_usual = self->wanted == PLANT_GATE_LOW && !self->waiting && rise_s > 0.0 &&
                          rise_s + dead_time_s <= fall_s && fall_s + dead_time_s < period_s;
    if (!is_usual) {
        return false;
    }
    self->edge[0] = (plant_edge_t){.at_s = rise_s, .gate = PLANT_GATE_OFF};
    self->edge[1] = (plant_edge_t){.at_s = rise_s + dead_time_s, .gate = PLANT_GATE_HIGH};
    self->edge[2] = (plant_edge_t){.at_s = fall_s, .gate = PLANT_GATE_OFF};
    self->edge[3] = (plant_edge_t){.at_s = fall_s + dead_time_s, .gate = PLANT_GATE_LOW};
    self->edges = 4;
    self->ready_s = fall_s + dead_time_s - period_s;
    return true;
}

/// One half of a carrier period: at most one edge.
static void schedule_half(plant_pwm_t *self, plant_duty_t duty, plant_gate_t high, double period_s,
                          double dead_time_s, plant_part_t part) {
    const bool rises = part == PLANT_RISING_HALF;
    const double share = rises ? duty.rise : duty.fall;
    const bool begins_high = rises ? share >= 1.0 : share > 0.0;
    ask(self, 0.0, begins_high ? high : PLANT_GATE_LOW, dead_time_s);
    if (share > 0.0 && share < 1.0) {
        ask(self, (rises ? 1.0 - share : share) * period_s, rises ? high : PLANT_GATE_LOW,
            dead_time_s);
    }
}

static void schedule_period(plant_pwm_t *self, plant_duty_t duty, plant_gate_t high,
                            double period_s, double dead_time_s) {
    const bool pulse = duty.rise > 0.0 || duty.fall > 0.0;
    ask(self, 0.0, duty.rise >= 1.0 ? high : PLANT_GATE_LOW, dead_time_s);
    if (pulse && duty.rise < 1.0) {
        ask(self, 0.5 * (1.0 - duty.rise) * period_s, high, dead_time_s);
    }
    if (pulse && duty.fall < 1.0) {
        ask(self, 0.5 * (1.0 + duty.fall) * period_s, PLANT_GATE_LOW, dead_time_s);
    }
}

void plant_pwm_schedule(plant_pwm_t *self, plant_duty_t duty, plant_gates_t gates, double period_s,
                        double dead_time_s) {
    const plant_part_t part = self->part;
    if (part != PLANT_PERIOD) {
        self->part = part == PLANT_RISING_HALF ? PLANT_FALLING_HALF : PLANT_RISING_HALF;
    }
    self->edges = 0;
    self->next = 0;
    if (gates == PLANT_GATES_OFF) {
        self->wanted = PLANT_GATE_OFF;
        self->waiting = false;
        add_edge(self, 0.0, PLANT_GATE_OFF);
        return;
    }
    const plant_gate_t high = gates == PLANT_GATES_LOW ? PLANT_GATE_OFF : PLANT_GATE_HIGH;
    if (part != PLANT_PERIOD) {
        schedule_half(self, duty, high, period_s, dead_time_s, part);
    } else if (gates == PLANT_GATES_ON && schedule_pulse(self, duty, period_s, dead_time_s)) {
        return;
    } else {
        schedule_period(self, duty, high, period_s, dead_time_s);
    }
    if (self->waiting && self->ready_s < period_s) {
        add_edge(self, self->ready_s, self->wanted);
        self->waiting = false;
    }
    self->ready_s -= period_s;
}

int plant_pwm_first_after(const plant_pwm_t *self, double at_s) {
    int k = self->next;
    while (k < self->edges && self->edge[k].at_s <= at_s) {
        k++;
    }
    return k;
}

bool plant_pwm_apply(plant_pwm_t *self, double now_s) {
    const int before = self->next;
    while (self->next < self->edges && self->edge[self->next].at_s <= now_s) {
        self->gate = self->edge[self->next++].gate;
    }
    return self->next > before;
}
