#include "plant/inverter.h"

#include <math.h>

#define SQRT1_3 0.57735026918962576451

/// As PLANT_NOISE_A, for a floating terminal at its limit.
static const double noise_V = 1e-9;

void plant_inverter_init(plant_inverter_t *self, const plant_config_t *config) {
    const bool real = config->level == PLANT_SWITCHING;
    *self = (plant_inverter_t){
        .v_bus_V = config->v_bus_V,
        .period_s = config->period_s,
        .dead_time_s = real ? config->dead_time_s : 0.0,
        .v_transistor_V = real ? config->v_transistor_V : 0.0,
        .v_diode_V = real ? config->v_diode_V : 0.0,
        .r_on_Ohm = real ? config->r_on_Ohm : 0.0,
        .Rs_Ohm = config->Rs_Ohm,
        .pwm_ticks = config->pwm_ticks,
        .level = config->level,
        .has_drops = !real || config->v_transistor_V > 0.0 || config->v_diode_V > 0.0,
        .sets = config->sets == PLANT_SETS ? PLANT_SETS : 1,
        .drive = {.R_Ohm = config->Rs_Ohm + (real ? config->r_on_Ohm : 0.0),
                  .floating = {PLANT_NONE_FLOATS, PLANT_NONE_FLOATS}},
    };
    for (int n = 0; n < PLANT_LEGS; n++) {
        plant_pwm_init(&self->leg[n].pwm, config->double_update);
    }
}

static int legs_of(const plant_inverter_t *self) {
    return self->sets * PLANT_PHASES;
}

/// Without current the terminal's limits change at every edge; an open phase has no limits.
static void find_next_edge(plant_leg_t *leg) {
    const plant_pwm_t *pwm = &leg->pwm;
    const bool high = plant_inverter_on_high_rail(pwm->gate, leg->sign);
    int k = leg->open ? pwm->edges : pwm->next;
    while (k < pwm->edges && leg->sign != 0 &&
           plant_inverter_on_high_rail(pwm->edge[k].gate, leg->sign) == high) {
        k++;
    }
    leg->next_s = k < pwm->edges ? pwm->edge[k].at_s : HUGE_VAL;
}

static inline void update_source(const plant_inverter_t *self, int n, plant_leg_t *leg) {
    if (leg->sign == 0) {
        leg->source_V = 0.0;
        leg->rail = 0.0;
    } else if (!self->averaging[n / PLANT_PHASES]) {
        const plant_gate_t gate = leg->pwm.gate;
        leg->source_V = plant_inverter_source_V(self, gate, leg->sign);
        leg->rail = plant_inverter_on_high_rail(gate, leg->sign) ? 1.0 : 0.0;
    }
}

static void update_leg(const plant_inverter_t *self, int n, plant_leg_t *leg) {
    find_next_edge(leg);
    update_source(self, n, leg);
}

/// The legs of a set that carry no current.
static int floating_of(const plant_inverter_t *self, int set) {
    int idle = 0, floating = PLANT_NONE_FLOATS;
    for (int n = set * PLANT_PHASES; n < (set + 1) * PLANT_PHASES; n++) {
        if (self->leg[n].sign == 0) {
            floating = n;
            idle++;
        }
    }
    return idle > 1 ? PLANT_ALL_FLOAT : floating;
}

/// Vector of a set's leg sources.
static plant_vector_t sources_of(const plant_inverter_t *self, int set) {
    const plant_leg_t *leg = &self->leg[set * PLANT_PHASES];
    const double a = leg[0].source_V, b = leg[1].source_V, c = leg[2].source_V;
    const double u = (2.0 * a - b - c) / 3.0, v = (b - c) * SQRT1_3; // on the set's own axes
    if (set == 0) {
        return (plant_vector_t){u, v};
    }
    const double co = plant_axis_cos[PLANT_PHASES], si = plant_axis_sin[PLANT_PHASES];
    return (plant_vector_t){u * co - v * si, u * si + v * co};
}

/// The vectors of the leg sources at the motor.
static void update_vectors(plant_inverter_t *self) {
    const plant_vector_t first = sources_of(self, 0);
    self->drive.u_alpha_V = first.alpha;
    self->drive.u_beta_V = first.beta;
    if (self->sets == PLANT_SETS) {
        plant_planes_t u = {{0.0, 0.0}, {0.0, 0.0}};
        plant_sets_add(&u, 0, first);
        plant_sets_add(&u, 1, sources_of(self, 1));
        self->drive.u_alpha_V = u.ab.alpha;
        self->drive.u_beta_V = u.ab.beta;
        self->drive.u_x_V = u.xy.alpha;
        self->drive.u_y_V = u.xy.beta;
    }
}

/// Leg sources from gates and signs, then the vectors.
static void update_drive(plant_inverter_t *self) {
    for (int n = 0; n < legs_of(self); n++) {
        update_leg(self, n, &self->leg[n]);
    }
    self->has_next = true;
    for (int set = 0; set < self->sets; set++) {
        self->drive.floating[set] = floating_of(self, set);
    }
    update_vectors(self);
}

static int sign_of(double i_A) {
    return i_A > PLANT_NOISE_A ? 1 : (i_A < -PLANT_NOISE_A ? -1 : 0);
}

/// The averaged level: three ideal sources for the whole period. The sign matters only for a phase
/// that is to open at the end of its half wave.
static void begin_averaged(plant_inverter_t *self, const double i_A[PLANT_LEGS], int set,
                           const plant_duty_t duty[PLANT_LEGS]) {
    for (int n = set * PLANT_PHASES; n < (set + 1) * PLANT_PHASES; n++) {
        plant_leg_t *leg = &self->leg[n];
        leg->rail = 0.5 * (duty[n].rise + duty[n].fall);
        leg->source_V = leg->rail * self->v_bus_V;
        leg->pwm.edges = 0;
        leg->pwm.next = 0;
        leg->sign = leg->open ? 0 : (leg->opening ? sign_of(i_A[n]) : 1);
    }
}

/// The effective gate of a leg with broken switches for the requested `gate`.
static plant_gate_t of_broken(const plant_leg_t *leg, plant_gate_t gate) {
    if (leg->shorted[0] || leg->shorted[1]) {
        return leg->shorted[1] ? PLANT_GATE_HIGH : PLANT_GATE_LOW;
    }
    const bool dead =
        (gate == PLANT_GATE_LOW && leg->dead[0]) || (gate == PLANT_GATE_HIGH && leg->dead[1]);
    return dead ? PLANT_GATE_OFF : gate;
}

static void break_edges(plant_leg_t *leg) {
    plant_pwm_t *pwm = &leg->pwm;
    if (!leg->dead[0] && !leg->dead[1] && !leg->shorted[0] && !leg->shorted[1]) {
        return;
    }
    pwm->gate = of_broken(leg, pwm->gate);
    for (int k = 0; k < pwm->edges; k++) {
        pwm->edge[k].gate = of_broken(leg, pwm->edge[k].gate);
    }
}

void plant_inverter_fail(plant_inverter_t *self, int leg, bool high, bool shorted) {
    (shorted ? self->leg[leg].shorted : self->leg[leg].dead)[high ? 1 : 0] = true;
}

static void begin_switched(plant_inverter_t *self, const double i_A[PLANT_LEGS], int set,
                           const plant_duty_t duty[PLANT_LEGS], plant_gates_t gates,
                           bool was_averaging) {
    for (int n = set * PLANT_PHASES; n < (set + 1) * PLANT_PHASES; n++) {
        plant_leg_t *leg = &self->leg[n];
        if (was_averaging) {
            leg->sign = leg->open ? 0 : sign_of(i_A[n]);
        }
        // Edges that changed no terminal voltage are still pending.
        plant_pwm_finish(&leg->pwm);
        plant_pwm_schedule(&leg->pwm, duty[n], gates, self->period_s, self->dead_time_s);
        break_edges(leg);
    }
}

/// The duty after quantisation by the timer.
static double realised(const plant_inverter_t *self, double duty) {
    const double within = duty > 0.0 ? (duty < 1.0 ? duty : 1.0) : 0.0;
    return self->pwm_ticks > 0 ? (double)(int64_t)(within * self->pwm_ticks + 0.5) / self->pwm_ticks
                               : within;
}

/// True if all phases of a set carry current, also at the end of the previous period.
static bool conducts(const plant_inverter_t *self, int set) {
    const plant_leg_t *leg = &self->leg[set * PLANT_PHASES];
    return self->drive.floating[set] == PLANT_NONE_FLOATS && leg[0].sign != 0 && leg[1].sign != 0 &&
           leg[2].sign != 0;
}

/// Starts a period in which all phases conduct as before.
static void go_on(plant_inverter_t *self) {
    for (int n = 0; n < legs_of(self); n++) {
        (void)plant_pwm_apply(&self->leg[n].pwm, 0.0);
        update_source(self, n, &self->leg[n]);
    }
    self->has_next = false;
    update_vectors(self);
}

void plant_inverter_begin(plant_inverter_t *self, plant_motor_t *motor,
                          const plant_duty_t duty[PLANT_LEGS],
                          const plant_gates_t gates[PLANT_SETS]) {
    plant_duty_t share[PLANT_LEGS] = {{0.0, 0.0}};
    double i_A[PLANT_LEGS] = {0.0};
    for (int n = 0; n < legs_of(self); n++) {
        const double rise = realised(self, duty[n].rise);
        const bool is_even = duty[n].fall == duty[n].rise;
        share[n] = (plant_duty_t){rise, is_even ? rise : realised(self, duty[n].fall)};
    }
    plant_motor_phase_currents(motor, &motor->x, i_A);
    bool goes_on = true;
    for (int set = 0; set < self->sets; set++) {
        const bool was_averaging = self->averaging[set];
        self->averaging[set] = gates[set] == PLANT_GATES_ON && self->level == PLANT_AVERAGED;
        if (self->averaging[set]) {
            begin_averaged(self, i_A, set, share);
        } else {
            begin_switched(self, i_A, set, share, gates[set], was_averaging);
        }
        goes_on = goes_on && conducts(self, set) && !was_averaging && !self->averaging[set];
    }
    if (goes_on) {
        go_on(self);
    } else {
        plant_inverter_settle(self, motor, 0.0);
    }
}

double plant_inverter_link_A(const plant_inverter_t *self, const double i_A[PLANT_LEGS], int set) {
    double sum_A = 0.0;
    for (int n = set * PLANT_PHASES; n < (set + 1) * PLANT_PHASES; n++) {
        sum_A += self->leg[n].rail * i_A[n];
    }
    return sum_A;
}

void plant_inverter_open(plant_inverter_t *self, const plant_motor_t *motor, int leg) {
    double i_A[PLANT_LEGS];
    plant_motor_phase_currents(motor, &motor->x, i_A);
    self->leg[leg].opening = !self->leg[leg].open;
    if (self->averaging[leg / PLANT_PHASES]) {
        self->leg[leg].sign = sign_of(i_A[leg]);
    }
}

double plant_inverter_next_edge(plant_inverter_t *self, double limit_s) {
    double soonest = limit_s;
    for (int n = 0; !self->has_next && n < legs_of(self); n++) {
        find_next_edge(&self->leg[n]);
    }
    self->has_next = true;
    for (int n = 0; n < legs_of(self); n++) {
        soonest = self->leg[n].next_s < soonest ? self->leg[n].next_s : soonest;
    }
    return soonest;
}

/// By how much the terminals of a set, at this vector of the motor's own, fit between their limits
/// for the best common voltage; negative: legs `first_out` and `first_in` start to conduct.
static double all_float_margin(const plant_inverter_t *self, int set, const plant_vector_t *u,
                               int *first_out, int *first_in) {
    double floor_V = -HUGE_VAL, ceiling_V = HUGE_VAL;
    for (int n = set * PLANT_PHASES; n < (set + 1) * PLANT_PHASES; n++) {
        if (self->leg[n].open) {
            continue;
        }
        const double emf = plant_axis_cos[n] * u->alpha + plant_axis_sin[n] * u->beta;
        const double low = plant_inverter_low_V(self, self->leg[n].pwm.gate) - emf;
        const double high = plant_inverter_high_V(self, self->leg[n].pwm.gate) - emf;
        if (low > floor_V) {
            floor_V = low;
            *first_out = n;
        }
        if (high < ceiling_V) {
            ceiling_V = high;
            *first_in = n;
        }
    }
    return ceiling_V - floor_V;
}

/// Lets the one floating phase of a set conduct if its terminal lies outside its limits.
static void settle_floating(plant_inverter_t *self, const plant_motor_t *motor, int set) {
    plant_leg_t *leg = &self->leg[self->drive.floating[set]];
    plant_stretch_t now;
    if (leg->open) {
        return;
    }
    plant_motor_slopes(motor, &self->drive, &now);
    const double u = now.set[set].u_start_V;
    if (u < plant_inverter_low_V(self, leg->pwm.gate) - noise_V) {
        leg->sign = 1;
    } else if (u > plant_inverter_high_V(self, leg->pwm.gate) + noise_V) {
        leg->sign = -1;
    } else {
        return;
    }
    update_drive(self);
}

/// A set without current, in which two legs may start.
static void settle_idle(plant_inverter_t *self, plant_motor_t *motor, int set) {
    int out = 0, in = 0;
    plant_stretch_t now;
    for (int n = 0; n < PLANT_PHASES; n++) {
        self->leg[set * PLANT_PHASES + n].sign = 0;
    }
    plant_motor_clear_set(motor, set);
    update_drive(self);
    plant_motor_slopes(motor, &self->drive, &now);
    if (all_float_margin(self, set, &now.set[set].all_start_V, &out, &in) < -noise_V) {
        self->leg[out].sign = 1;
        self->leg[in].sign = -1;
        update_drive(self);
    }
}

/// Finds which legs of a set conduct.
static void settle_set(plant_inverter_t *self, plant_motor_t *motor, int set) {
    const plant_leg_t *leg = &self->leg[set * PLANT_PHASES];
    const int *floating = &self->drive.floating[set];
    const int signs = leg[0].sign + leg[1].sign + leg[2].sign;
    // Two phases carry one current: of equal sign it is none, both stopped with the third.
    if (*floating == PLANT_ALL_FLOAT || (*floating != PLANT_NONE_FLOATS && signs != 0)) {
        settle_idle(self, motor, set);
    }
    if (*floating != PLANT_NONE_FLOATS && *floating != PLANT_ALL_FLOAT) {
        settle_floating(self, motor, set);
    }
}

void plant_inverter_clear(const plant_inverter_t *self, plant_motor_t *motor) {
    for (int set = 0; set < self->sets; set++) {
        const int floating = self->drive.floating[set];
        if (floating == PLANT_ALL_FLOAT) {
            plant_motor_clear_set(motor, set);
        } else if (floating != PLANT_NONE_FLOATS && self->leg[floating].open) {
            plant_motor_clear_phase(motor, floating);
        }
    }
}

void plant_inverter_settle(plant_inverter_t *self, plant_motor_t *motor, double now_s) {
    for (int n = 0; n < legs_of(self); n++) {
        plant_leg_t *leg = &self->leg[n];
        plant_pwm_apply(&leg->pwm, now_s);
        if (leg->opening && leg->sign == 0) {
            leg->opening = false;
            leg->open = true;
        }
    }
    update_drive(self);
    plant_inverter_clear(self, motor);
    // A change in set 2 moves the floating terminals of set 1; the next stretch takes this into account at its start.
    for (int set = 0; set < self->sets; set++) {
        if (!self->averaging[set]) {
            settle_set(self, motor, set);
        }
    }
}

static bool floats(const plant_inverter_t *self) {
    return self->drive.floating[0] != PLANT_NONE_FLOATS ||
           self->drive.floating[1] != PLANT_NONE_FLOATS;
}

void plant_inverter_switch(plant_inverter_t *self, plant_motor_t *motor, double now_s) {
    if (floats(self)) {
        plant_inverter_settle(self, motor, now_s);
        return;
    }
    for (int n = 0; n < legs_of(self); n++) {
        plant_leg_t *leg = &self->leg[n];
        if (leg->next_s <= now_s) {
            (void)plant_pwm_apply(&leg->pwm, now_s);
            update_leg(self, n, leg);
        }
    }
    update_vectors(self);
}

/// When a quadratic through i_0 with slope_0 and through i_1 after h is zero.
static double zero_of_parabola(double i_0, double slope_0, double i_1, double h) {
    const double q = i_1 - i_0 - slope_0 * h; // times (t/h)^2
    const double b = slope_0 * h;             // times (t/h)
    const double root = sqrt(fmax(b * b - 4.0 * q * i_0, 0.0));
    // i_0 and i_1 differ in sign, so exactly one root lies in 0..1; this form avoids cancellation.
    const double t = -0.5 * (b + copysign(root, b));
    const double first = t / q, second = i_0 / t;
    const double x = first > 0.0 && first <= 1.0 ? first : second;
    return x > 0.0 && x <= 1.0 ? x * h : h * fabs(i_0) / (fabs(i_0) + fabs(i_1));
}

/// A current that passes through zero after `after_s` while a gate is on and there are no drops
/// changes no voltage. True if the leg stays so to the end of the stretch; otherwise the stretch has
/// to end at the leg's next edge, which acts according to the sign.
static bool passes_zero(const plant_inverter_t *self, const plant_leg_t *leg, double now_s,
                        double h_s, plant_event_t *event) {
    const plant_pwm_t *pwm = &leg->pwm;
    const int after = plant_pwm_first_after(pwm, now_s + event->after_s);
    const plant_gate_t gate = after > pwm->next ? pwm->edge[after - 1].gate : pwm->gate;
    if (self->has_drops || leg->opening || gate == PLANT_GATE_OFF) {
        return false;
    }
    if (after == pwm->edges || pwm->edge[after].at_s >= now_s + h_s) {
        return true;
    }
    event->after_s = pwm->edge[after].at_s - now_s;
    event->sign = -leg->sign;
    return false;
}

/// True if the leg's current may pass zero anywhere in the stretch and no voltage changes: no drops,
/// and one gate is on all the time.
static bool is_driven(const plant_inverter_t *self, const plant_leg_t *leg, double now_s,
                      double h_s) {
    const plant_pwm_t *pwm = &leg->pwm;
    const int after = plant_pwm_first_after(pwm, now_s);
    const plant_gate_t gate = after > pwm->next ? pwm->edge[after - 1].gate : pwm->gate;
    return !self->has_drops && !leg->opening && gate != PLANT_GATE_OFF &&
           (after == pwm->edges || pwm->edge[after].at_s >= now_s + h_s);
}

/// The conducting leg whose current crosses zero first.
static bool find_zero_crossing(const plant_inverter_t *self, const plant_motor_t *motor,
                               const plant_motor_state_t *before, const plant_stretch_t *stretch,
                               double now_s, double h_s, plant_event_t *event) {
    double i_1[PLANT_LEGS];
    bool found = false;
    plant_motor_phase_currents(motor, &motor->x, i_1);
    for (int n = 0; n < legs_of(self); n++) {
        const int sign = self->leg[n].sign;
        if (sign * i_1[n] >= -PLANT_NOISE_A ||
            (self->averaging[n / PLANT_PHASES] && !self->leg[n].opening) ||
            is_driven(self, &self->leg[n], now_s, h_s)) {
            continue;
        }
        double i_0[PLANT_LEGS];
        plant_motor_phase_currents(motor, before, i_0);
        if (sign * i_0[n] < -PLANT_NOISE_A) {
            // Two crossings were so close that one was missed: correct the sign.
            *event = (plant_event_t){.after_s = 0.0, .leg = n, .sign = -sign};
            return true;
        }
        const double slope = plant_motor_phase_slope(motor, before, stretch, n);
        plant_event_t zero = {zero_of_parabola(i_0[n], slope, i_1[n], h_s), n, 0};
        if (!passes_zero(self, &self->leg[n], now_s, h_s, &zero) &&
            (!found || zero.after_s < event->after_s)) {
            *event = zero;
            found = true;
        }
    }
    return found;
}

/// Instant at which a quantity that went from inside (> 0) to outside (< 0) was zero, a little
/// late so that it is outside for certain: the current that begins there begins with no slope.
static double exit_instant(double inside, double outside, double h_s) {
    const double x = fmax(inside, 0.0) / (fmax(inside, 0.0) - outside);
    return fmin(x + 1e-3, 1.0) * h_s;
}

/// All phases of a set float and the motor's own voltage outgrew the limits.
static bool find_rectification(const plant_inverter_t *self, int set, const plant_float_t *motor,
                               double h_s, plant_event_t *event) {
    int out = 0, in = 0;
    const double margin = all_float_margin(self, set, &motor->all_end_V, &out, &in);
    if (margin >= -noise_V) {
        return false;
    }
    const double was = all_float_margin(self, set, &motor->all_start_V, &out, &in);
    *event = (plant_event_t){
        .after_s = exit_instant(was, margin, h_s), .leg = PLANT_ALL_FLOAT, .sign = 0};
    return true;
}

/// The terminal of the one floating phase of a set left its limits.
static bool find_float_exit(const plant_inverter_t *self, int set, const plant_float_t *motor,
                            double h_s, plant_event_t *event) {
    const int n = self->drive.floating[set];
    const double low = plant_inverter_low_V(self, self->leg[n].pwm.gate);
    const double high = plant_inverter_high_V(self, self->leg[n].pwm.gate);
    const double was = motor->u_start_V, is = motor->u_end_V;
    if (self->leg[n].open) {
        return false;
    }
    if (is > high + noise_V) {
        *event = (plant_event_t){exit_instant(high - was, high - is, h_s), n, -1};
        return true;
    }
    if (is < low - noise_V) {
        *event = (plant_event_t){exit_instant(was - low, is - low, h_s), n, 1};
        return true;
    }
    return false;
}

/// A set in which something floats starts to conduct.
static bool find_start(const plant_inverter_t *self, int set, const plant_float_t *motor,
                       double h_s, plant_event_t *event) {
    const int floating = self->drive.floating[set];
    if (self->averaging[set] || floating == PLANT_NONE_FLOATS) {
        return false;
    }
    return floating == PLANT_ALL_FLOAT ? find_rectification(self, set, motor, h_s, event)
                                       : find_float_exit(self, set, motor, h_s, event);
}

bool plant_inverter_find_event(const plant_inverter_t *self, const plant_motor_t *motor,
                               const plant_motor_state_t *before, const plant_stretch_t *stretch,
                               double now_s, double h_s, plant_event_t *event) {
    bool found = find_zero_crossing(self, motor, before, stretch, now_s, h_s, event);
    for (int set = 0; set < self->sets; set++) {
        plant_event_t start;
        if (find_start(self, set, &stretch->set[set], h_s, &start) &&
            (!found || start.after_s < event->after_s)) {
            *event = start;
            found = true;
        }
    }
    return found;
}

void plant_inverter_take_event(plant_inverter_t *self, plant_motor_t *motor,
                               const plant_event_t *event) {
    if (event->leg == PLANT_ALL_FLOAT) {
        return; // the settling determines which
    }
    if (self->leg[event->leg].sign == -event->sign) {
        plant_inverter_adopt_signs(self, motor);
        return;
    }
    self->leg[event->leg].sign = event->sign;
    if (event->sign == 0) {
        plant_motor_clear_phase(motor, event->leg);
    }
}

void plant_inverter_follow_signs(plant_inverter_t *self, const plant_motor_t *motor, double now_s) {
    double i_A[PLANT_LEGS];
    bool turned = false;
    if (self->has_drops) {
        return; // every zero crossing was an event
    }
    plant_motor_phase_currents(motor, &motor->x, i_A);
    for (int n = 0; n < legs_of(self); n++) {
        plant_leg_t *leg = &self->leg[n];
        if (leg->sign * i_A[n] < -PLANT_NOISE_A && !self->averaging[n / PLANT_PHASES]) {
            // The sign decides which edges still count, and the effect of an edge at this instant.
            (void)plant_pwm_apply(&leg->pwm, now_s);
            leg->sign = -leg->sign;
            update_leg(self, n, leg);
            turned = true;
        }
    }
    if (turned) {
        update_vectors(self);
    }
}

void plant_inverter_adopt_signs(plant_inverter_t *self, const plant_motor_t *motor) {
    double i_A[PLANT_LEGS];
    plant_motor_phase_currents(motor, &motor->x, i_A);
    for (int n = 0; n < legs_of(self); n++) {
        plant_leg_t *leg = &self->leg[n];
        if (!leg->open && (leg->opening || !self->averaging[n / PLANT_PHASES])) {
            leg->sign = sign_of(i_A[n]);
        }
    }
}
