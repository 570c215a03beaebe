#include "plant_inverter.h"

#include <math.h>

#define SQRT1_3 0.57735026918962576451

/// A current this small that has the wrong sign is what the search for zero left over, no crossing.
static const double noise_A = 2e-5;
/// The same for a floating terminal at its limit.
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
    };
    for (int n = 0; n < PLANT_PHASES; n++) {
        plant_pwm_init(&self->leg[n].pwm);
    }
}

static double low_limit(const plant_inverter_t *self, plant_gate_t gate) {
    return gate == PLANT_GATE_HIGH ? self->v_bus_V - self->v_transistor_V : -self->v_diode_V;
}

static double high_limit(const plant_inverter_t *self, plant_gate_t gate) {
    return gate == PLANT_GATE_LOW ? self->v_transistor_V : self->v_bus_V + self->v_diode_V;
}

static bool on_high_rail(plant_gate_t gate, int sign) {
    return sign > 0 ? gate == PLANT_GATE_HIGH : gate != PLANT_GATE_LOW;
}

/// Leg sources from gates and signs; then the vector the motor sees.
static void update_drive(plant_inverter_t *self) {
    int idle = 0, floating = PLANT_NONE_FLOATS;
    for (int n = 0; n < PLANT_PHASES; n++) {
        plant_leg_t *leg = &self->leg[n];
        if (leg->sign == 0) {
            leg->source_V = 0.0;
            leg->rail = 0.0;
            floating = n;
            idle++;
            continue;
        }
        const plant_gate_t gate = leg->pwm.gate;
        leg->source_V = leg->sign > 0 ? low_limit(self, gate) : high_limit(self, gate);
        leg->rail = on_high_rail(gate, leg->sign) ? 1.0 : 0.0;
    }
    const double a = self->leg[0].source_V, b = self->leg[1].source_V, c = self->leg[2].source_V;
    self->drive = (plant_drive_t){
        .u_alpha_V = (2.0 * a - b - c) / 3.0,
        .u_beta_V = (b - c) * SQRT1_3,
        .R_Ohm = self->Rs_Ohm + self->r_on_Ohm,
        .floating = idle > 1 ? PLANT_ALL_FLOAT : floating,
    };
}

/// The averaged level: three ideal sources for the whole period.
static void begin_averaged(plant_inverter_t *self, const double duty[PLANT_PHASES]) {
    for (int n = 0; n < PLANT_PHASES; n++) {
        self->leg[n].rail = duty[n];
        self->leg[n].source_V = duty[n] * self->v_bus_V;
        self->leg[n].sign = 1;
        self->leg[n].pwm.edges = 0;
        self->leg[n].pwm.next = 0;
    }
    self->drive = (plant_drive_t){
        .u_alpha_V = (2.0 * duty[0] - duty[1] - duty[2]) / 3.0 * self->v_bus_V,
        .u_beta_V = (duty[1] - duty[2]) * SQRT1_3 * self->v_bus_V,
        .R_Ohm = self->Rs_Ohm,
        .floating = PLANT_NONE_FLOATS,
    };
}

void plant_inverter_begin(plant_inverter_t *self, plant_motor_t *motor,
                          const double duty[PLANT_PHASES], bool gates_on) {
    double realised[PLANT_PHASES];
    for (int n = 0; n < PLANT_PHASES; n++) {
        realised[n] = duty[n] > 0.0 ? fmin(duty[n], 1.0) : 0.0;
        if (self->pwm_ticks > 0) {
            realised[n] = floor(realised[n] * self->pwm_ticks + 0.5) / self->pwm_ticks;
        }
    }
    const bool was_averaging = self->averaging;
    self->averaging = gates_on && self->level == PLANT_AVERAGED;
    if (self->averaging) {
        begin_averaged(self, realised);
        return;
    }
    if (was_averaging) {
        plant_inverter_adopt_signs(self, motor);
    }
    for (int n = 0; n < PLANT_PHASES; n++) {
        plant_pwm_schedule(&self->leg[n].pwm, realised[n], gates_on, self->period_s,
                           self->dead_time_s);
    }
    plant_inverter_settle(self, motor, 0.0);
}

double plant_inverter_next_edge(const plant_inverter_t *self, double limit_s) {
    double soonest = limit_s;
    for (int n = 0; n < PLANT_PHASES; n++) {
        const plant_leg_t *leg = &self->leg[n];
        const plant_pwm_t *pwm = &leg->pwm;
        for (int k = pwm->next; k < pwm->edges && pwm->edge[k].at_s < soonest; k++) {
            if (leg->sign == 0 ||
                on_high_rail(pwm->edge[k].gate, leg->sign) != on_high_rail(pwm->gate, leg->sign)) {
                soonest = pwm->edge[k].at_s;
            }
        }
    }
    return soonest;
}

/// By how much the terminals, moved by the EMF alone, fit between their limits for the best common
/// voltage; negative: phases `first_out` and `first_in` start to conduct.
static double all_float_margin(const plant_inverter_t *self, const plant_motor_t *motor,
                               const plant_motor_state_t *state, int *first_out, int *first_in) {
    double emf[PLANT_PHASES];
    plant_motor_open_emf(motor, state, emf);
    double floor_V = -HUGE_VAL, ceiling_V = HUGE_VAL;
    for (int n = 0; n < PLANT_PHASES; n++) {
        const double low = low_limit(self, self->leg[n].pwm.gate) - emf[n];
        const double high = high_limit(self, self->leg[n].pwm.gate) - emf[n];
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

/// Lets the one floating phase conduct if its terminal lies outside its limits.
static void settle_floating(plant_inverter_t *self, const plant_motor_t *motor) {
    const int n = self->drive.floating;
    double did, dpsi_q;
    const double u = plant_motor_slopes(motor, &self->drive, &did, &dpsi_q);
    if (u < low_limit(self, self->leg[n].pwm.gate) - noise_V) {
        self->leg[n].sign = 1;
    } else if (u > high_limit(self, self->leg[n].pwm.gate) + noise_V) {
        self->leg[n].sign = -1;
    } else {
        return;
    }
    update_drive(self);
}

void plant_inverter_settle(plant_inverter_t *self, plant_motor_t *motor, double now_s) {
    for (int n = 0; n < PLANT_PHASES; n++) {
        plant_pwm_apply(&self->leg[n].pwm, now_s);
    }
    update_drive(self);
    const int signs = self->leg[0].sign + self->leg[1].sign + self->leg[2].sign;
    // Two phases carry one current: of equal sign it is none, both stopped with the third.
    if (self->drive.floating == PLANT_ALL_FLOAT ||
        (self->drive.floating != PLANT_NONE_FLOATS && signs != 0)) {
        int out = 0, in = 0;
        for (int n = 0; n < PLANT_PHASES; n++) {
            self->leg[n].sign = 0;
        }
        motor->x.id_A = 0.0;
        motor->x.iq_A = 0.0;
        if (all_float_margin(self, motor, &motor->x, &out, &in) < -noise_V) {
            self->leg[out].sign = 1;
            self->leg[in].sign = -1;
        }
        update_drive(self);
    }
    if (self->drive.floating >= 0 && self->drive.floating < PLANT_ALL_FLOAT) {
        settle_floating(self, motor);
    }
}

/// When a quadratic through i_0 with slope_0 and through i_1 after h is zero.
static double zero_of_parabola(double i_0, double slope_0, double i_1, double h) {
    const double q = i_1 - i_0 - slope_0 * h; // times (t/h)^2
    const double b = slope_0 * h;             // times (t/h)
    const double root = sqrt(fmax(b * b - 4.0 * q * i_0, 0.0));
    // i_0 and i_1 differ in sign, so exactly one root lies in 0..1; the form that does not cancel.
    const double t = -0.5 * (b + copysign(root, b));
    const double first = t / q, second = i_0 / t;
    const double x = first > 0.0 && first <= 1.0 ? first : second;
    return x > 0.0 && x <= 1.0 ? x * h : h * fabs(i_0) / (fabs(i_0) + fabs(i_1));
}

/// The conducting phase whose current is first through zero.
static bool find_zero_crossing(const plant_inverter_t *self, const plant_motor_t *motor,
                               const plant_motor_state_t *before, const plant_stretch_t *stretch,
                               double h_s, plant_event_t *event) {
    double i_1[PLANT_PHASES];
    bool found = false;
    plant_motor_phase_currents(&motor->x, i_1);
    for (int n = 0; n < PLANT_PHASES; n++) {
        if (self->leg[n].sign * i_1[n] >= -noise_A) {
            continue;
        }
        double i_0[PLANT_PHASES];
        plant_motor_phase_currents(before, i_0);
        if (self->leg[n].sign * i_0[n] < -noise_A) {
            // Two crossings so close that one was passed over: put the sign right.
            *event = (plant_event_t){.after_s = 0.0, .phase = n, .sign = -self->leg[n].sign};
            return true;
        }
        const double slope = plant_motor_phase_slope(motor, before, stretch->did_start_A_s,
                                                     stretch->dpsi_q_start_V, n);
        const double after = zero_of_parabola(i_0[n], slope, i_1[n], h_s);
        if (!found || after < event->after_s) {
            *event = (plant_event_t){.after_s = after, .phase = n, .sign = 0};
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

/// All phases float and the EMF outgrew the limits.
static bool find_rectification(const plant_inverter_t *self, const plant_motor_t *motor,
                               const plant_motor_state_t *before, double h_s,
                               plant_event_t *event) {
    int out = 0, in = 0;
    const double margin = all_float_margin(self, motor, &motor->x, &out, &in);
    if (margin >= -noise_V) {
        return false;
    }
    const double was = all_float_margin(self, motor, before, &out, &in);
    *event = (plant_event_t){
        .after_s = exit_instant(was, margin, h_s), .phase = PLANT_ALL_FLOAT, .sign = 0};
    return true;
}

/// The terminal of the one floating phase left its limits.
static bool find_float_exit(const plant_inverter_t *self, const plant_stretch_t *stretch,
                            double h_s, plant_event_t *event) {
    const int n = self->drive.floating;
    const double low = low_limit(self, self->leg[n].pwm.gate);
    const double high = high_limit(self, self->leg[n].pwm.gate);
    const double was = stretch->u_float_start_V, is = stretch->u_float_end_V;
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

bool plant_inverter_find_event(const plant_inverter_t *self, const plant_motor_t *motor,
                               const plant_motor_state_t *before, const plant_stretch_t *stretch,
                               double h_s, plant_event_t *event) {
    if (self->averaging) {
        return false;
    }
    if (self->drive.floating == PLANT_ALL_FLOAT) {
        return find_rectification(self, motor, before, h_s, event);
    }
    const bool stops = find_zero_crossing(self, motor, before, stretch, h_s, event);
    if (self->drive.floating == PLANT_NONE_FLOATS) {
        return stops;
    }
    plant_event_t start;
    const bool starts = find_float_exit(self, stretch, h_s, &start);
    if (starts && (!stops || start.after_s < event->after_s)) {
        *event = start;
    }
    return stops || starts;
}

void plant_inverter_take_event(plant_inverter_t *self, plant_motor_t *motor,
                               const plant_event_t *event) {
    if (event->phase == PLANT_ALL_FLOAT) {
        return; // settling finds out which
    }
    if (self->leg[event->phase].sign == -event->sign) {
        plant_inverter_adopt_signs(self, motor);
        return;
    }
    self->leg[event->phase].sign = event->sign;
    if (event->sign == 0) {
        plant_motor_clear_phase(&motor->x, event->phase);
    }
}

void plant_inverter_adopt_signs(plant_inverter_t *self, const plant_motor_t *motor) {
    double i[PLANT_PHASES];
    plant_motor_phase_currents(&motor->x, i);
    for (int n = 0; n < PLANT_PHASES; n++) {
        self->leg[n].sign = i[n] > noise_A ? 1 : (i[n] < -noise_A ? -1 : 0);
    }
}
