#include "plant/plant.h"

#include "plant/linear.h"

#include <math.h>
#include <stddef.h>

/// Far above the number of events in a period; ends a chain of events without progress.
enum { EVENTS_PER_PERIOD = 200 };

plant_config_t plant_config_jiang2022(void) {
    return (plant_config_t){
        .pole_pairs = 3,
        .Rs_Ohm = 0.75,
        .Ld_H = 3.5e-3,
        .Lq_H = 9.8e-3,
        .psi_Wb = 0.142,
        .J_kgm2 = 0.0174,
        .B_Nms = 7.5e-4,
        .load_is_passive = true,
        .level = PLANT_SWITCHING,
        .period_s = 200e-6,
        .v_bus_V = 200.0,
        .dead_time_s = 4e-6,
        .pwm_ticks = 16800,
        .adc_bits = 12,
        .i_A_per_count = 50.0 / 4096.0,
        .v_bus_V_per_count = 0.1,
        .temperature_degC_per_count = 0.1,
        .temperature_zero_degC = -50.0,
        .temperature_degC = 25.0,
        .seed = 1,
        .stamp_Hz = 168e6,
        .keeps_accounts = true,
    };
}

static bool within(double value, double low, double high) {
    return value >= low && value <= high;
}

static const char *check_harmonics(const plant_config_t *c) {
    const double ratio[] = {c->emf5_ratio, c->emf7_ratio, c->emf11_ratio, c->emf13_ratio};
    const double phase[] = {c->emf5_phase_rad, c->emf7_phase_rad, c->emf11_phase_rad,
                            c->emf13_phase_rad};
    for (size_t n = 0; n < sizeof ratio / sizeof ratio[0]; n++) {
        if (!within(ratio[n], 0.0, 1.0)) {
            return "emf5_ratio, emf7_ratio, emf11_ratio and emf13_ratio must be 0..1";
        }
        if (!within(phase[n], -100.0, 100.0)) {
            return "the phases of the EMF's harmonics must be -100..100";
        }
    }
    return NULL;
}

static const char *check_motor(const plant_config_t *c) {
    if (c->pole_pairs < 1 || c->pole_pairs > 1000) {
        return "pole_pairs must be 1..1000";
    }
    if (!within(c->Rs_Ohm, 0.0, 1e6)) {
        return "Rs_Ohm must be 0..1e6";
    }
    if (!within(c->Ld_H, 1e-9, 1e3) || !within(c->Lq_H, 1e-9, 1e3)) {
        return "Ld_H and Lq_H must be 1e-9..1e3";
    }
    if (c->sets < 0 || c->sets > PLANT_SETS) {
        return "sets must be 0..2";
    }
    if (c->sets == PLANT_SETS && !within(c->Lxy_H, 1e-9, 1e3)) {
        return "Lxy_H must be 1e-9..1e3";
    }
    if (!within(c->psi_Wb, 0.0, 1e3)) {
        return "psi_Wb must be 0..1e3";
    }
    const char *error = plant_iron_check(c);
    return error != NULL ? error : check_harmonics(c);
}

static const char *check_shaft(const plant_config_t *c) {
    if (!within(c->J_kgm2, 1e-12, 1e6)) {
        return "J_kgm2 must be 1e-12..1e6";
    }
    if (!within(c->B_Nms, 0.0, 1e6)) {
        return "B_Nms must be 0..1e6";
    }
    if (!within(c->load_Nm, -1e6, 1e6)) {
        return "load_Nm must be -1e6..1e6";
    }
    if (!within(c->load_ripple, 0.0, 10.0)) {
        return "load_ripple must be 0..10";
    }
    if (!within(c->stiction_Nm, 0.0, 1e6) || !within(c->fan_Nms2, 0.0, 1e6)) {
        return "stiction_Nm and fan_Nms2 must be 0..1e6";
    }
    if (!within(c->cogging_Nm, 0.0, 1e6) || !within(c->cogging_per_turn, 0.0, 1e4)) {
        return "cogging_Nm must be 0..1e6, cogging_per_turn 0..1e4";
    }
    if (!within(c->load_J_kgm2, 0.0, 1e6) ||
        (c->load_J_kgm2 > 0.0 && !within(c->shaft_Nm_rad, 1e-9, 1e9))) {
        return "load_J_kgm2 must be 0..1e6, with shaft_Nm_rad 1e-9..1e9";
    }
    if (!within(c->shaft_Nms_rad, 0.0, 1e6) || !within(c->backlash_rad, 0.0, 6.3)) {
        return "shaft_Nms_rad must be 0..1e6, backlash_rad 0..6.3";
    }
    if (!within(c->theta_e_rad, -1e6, 1e6)) {
        return "theta_e_rad must be -1e6..1e6";
    }
    if (!within(c->omega_m_rad_s, -1e5, 1e5)) {
        return "omega_m_rad_s must be -1e5..1e5";
    }
    return NULL;
}

static const char *check_inverter(const plant_config_t *c) {
    if (c->level != PLANT_AVERAGED && c->level != PLANT_SWITCHING) {
        return "level must be PLANT_AVERAGED or PLANT_SWITCHING";
    }
    if (!within(c->period_s, 1e-6, 0.1)) {
        return "period_s must be 1e-6..0.1";
    }
    if (!within(c->v_bus_V, 0.0, 1e5)) {
        return "v_bus_V must be 0..1e5";
    }
    if (!within(c->bus_C_F, 0.0, 1e3)) {
        return "bus_C_F must be 0..1e3";
    }
    if (!within(c->chopper_R_Ohm, 0.0, 1e9) || (c->chopper_R_Ohm > 0.0 && !(c->bus_C_F > 0.0))) {
        return "chopper_R_Ohm must be 0..1e9, and needs bus_C_F: a stiff source takes all that "
               "comes";
    }
    if (c->bus_C_F > 0.0 && !c->keeps_accounts) {
        return "bus_C_F needs keeps_accounts";
    }
    if (!within(c->dead_time_s, 0.0, 0.25 * c->period_s)) {
        return "dead_time_s must be 0..a quarter of period_s";
    }
    if (!within(c->v_transistor_V, 0.0, 100.0) || !within(c->v_diode_V, 0.0, 100.0)) {
        return "v_transistor_V and v_diode_V must be 0..100";
    }
    if (!within(c->r_on_Ohm, 0.0, 1e3)) {
        return "r_on_Ohm must be 0..1e3";
    }
    return NULL;
}

static const char *check_adc(const plant_config_t *c) {
    if (c->adc_bits < 4 || c->adc_bits > 16) {
        return "adc_bits must be 4..16";
    }
    if (!within(c->i_A_per_count, 1e-9, 1e6) || !within(c->v_bus_V_per_count, 1e-9, 1e6) ||
        !within(c->temperature_degC_per_count, 1e-9, 1e6)) {
        return "i_A_per_count, v_bus_V_per_count, temperature_degC_per_count must be 1e-9..1e6";
    }
    for (int n = 0; n < PLANT_LEGS; n++) {
        if (!within(c->i_offset_A[n], -1e6, 1e6) || !within(c->i_gain_error[n], -1.0, 1e3)) {
            return "i_offset_A must be -1e6..1e6, i_gain_error -1..1e3";
        }
    }
    if (!within(c->i_noise_A, 0.0, 1e6) || !within(c->v_bus_noise_V, 0.0, 1e6) ||
        !within(c->temperature_noise_degC, 0.0, 1e6)) {
        return "i_noise_A, v_bus_noise_V and temperature_noise_degC must be 0..1e6";
    }
    if (!within(c->temperature_zero_degC, -1e6, 1e6) || !within(c->temperature_degC, -1e6, 1e6)) {
        return "temperature_zero_degC and temperature_degC must be -1e6..1e6";
    }
    if (!within(c->sample_offset_s, -0.5 * c->period_s, 0.5 * c->period_s)) {
        return "sample_offset_s must be within half of period_s";
    }
    if (!within(c->stamp_Hz, 0.0, 1e10)) {
        return "stamp_Hz must be 0..1e10";
    }
    return NULL;
}

const char *plant_init(plant_t *self, const plant_config_t *config) {
    const char *error = check_motor(config);
    if (error == NULL) {
        error = check_shaft(config);
    }
    if (error == NULL) {
        error = check_inverter(config);
    }
    if (error == NULL) {
        error = check_adc(config);
    }
    if (error != NULL) {
        return error;
    }
    *self = (plant_t){
        .sets = config->sets == PLANT_SETS ? PLANT_SETS : 1,
        .period_s = config->period_s,
        .sample_offset_s = config->sample_offset_s,
        .stamp_Hz = config->stamp_Hz,
        .temperature_degC = config->temperature_degC,
        .bus_C_F = config->bus_C_F,
        .source_V = config->v_bus_V,
        .chopper_R_Ohm = config->chopper_R_Ohm,
    };
    plant_motor_init(&self->motor, config);
    plant_inverter_init(&self->inverter, config);
    plant_adc_init(&self->adc, config);
    return NULL;
}

/// Adds the terminal voltages of a set's floating phases to the mean voltage.
static void book_floating(plant_t *self, int set, const plant_float_t *sum) {
    const int leg = self->inverter.drive.floating[set];
    plant_vector_t u_Vs = sum->all_Vs;
    if (leg == PLANT_NONE_FLOATS) {
        return;
    }
    if (leg != PLANT_ALL_FLOAT) {
        u_Vs = (plant_vector_t){2.0 / 3.0 * plant_axis_cos[leg] * sum->u_Vs,
                                2.0 / 3.0 * plant_axis_sin[leg] * sum->u_Vs};
    }
    if (self->sets == PLANT_SETS) {
        plant_sets_add(&self->u_Vs, set, u_Vs);
    } else {
        self->u_Vs.ab.alpha += u_Vs.alpha;
        self->u_Vs.ab.beta += u_Vs.beta;
    }
}

/// Adds the integrals of one stretch to the energies and the mean voltage.
static void book(plant_t *self, const plant_stretch_t *sum, double h_s) {
    const plant_inverter_t *inverter = &self->inverter;
    const plant_drive_t *drive = &inverter->drive;
    const double r_on = drive->R_Ohm - inverter->Rs_Ohm;
    const bool dual = self->sets == PLANT_SETS;
    const plant_planes_t charge = {{sum->i_alpha_As, sum->i_beta_As},
                                   {dual ? sum->i_x_As : 0.0, dual ? sum->i_y_As : 0.0}};
    plant_energy_t *energy = &self->energy;
    double loss_J = self->motor.power * r_on * sum->i_squared_A2s;
    for (int n = 0; n < self->sets * PLANT_PHASES; n++) {
        const plant_leg_t *leg = &inverter->leg[n];
        const plant_vector_t set_As = plant_sets_vector(&charge, n / PLANT_PHASES);
        const double charge_As = plant_axis_cos[n] * set_As.alpha + plant_axis_sin[n] * set_As.beta;
        const double rail_V = leg->rail * inverter->v_bus_V;
        energy->bus_J += rail_V * charge_As;
        loss_J += (rail_V - leg->source_V) * charge_As;
    }
    energy->inverter_J += loss_J;
    energy->copper_J += self->motor.power * inverter->Rs_Ohm * sum->i_squared_A2s;
    energy->shaft_J += sum->shaft_work_J;
    energy->friction_J += sum->friction_J;
    energy->load_J += sum->load_J;

    self->u_Vs.ab.alpha += drive->u_alpha_V * h_s - r_on * charge.ab.alpha;
    self->u_Vs.ab.beta += drive->u_beta_V * h_s - r_on * charge.ab.beta;
    self->u_Vs.xy.alpha += drive->u_x_V * h_s - r_on * charge.xy.alpha;
    self->u_Vs.xy.beta += drive->u_y_V * h_s - r_on * charge.xy.beta;
    for (int set = 0; set < self->sets; set++) {
        book_floating(self, set, &sum->set[set]);
    }
}

/// Slope of a leg's current in the present state of the motor, A/s.
static double slope_now(const plant_t *self, int leg) {
    plant_stretch_t now;
    plant_motor_slopes(&self->motor, &self->inverter.drive, &now);
    return plant_motor_phase_slope(&self->motor, &self->motor.x, &now, leg);
}

/// Moves the motor to the instant in 0..h_s at which a leg's current is zero; returns it.
///
/// One step of Newton's method from a guess, then secants, bracketed between an instant before and one after
/// the crossing: a current that began at zero also has a root at its start, which is not wanted.
static double step_to_zero(plant_t *self, const plant_motor_state_t *before, double guess_s,
                           double h_s, int leg, plant_stretch_t *sum) {
    const int sign = self->inverter.leg[leg].sign;
    double early_s = 0.0, late_s = h_s, at_s = guess_s, last_s = 0.0, last_A = 0.0;
    for (int pass = 0;; pass++) {
        double i_A[PLANT_LEGS];
        self->motor.x = *before;
        plant_motor_step(&self->motor, &self->inverter.drive, at_s, sum);
        plant_motor_phase_currents(&self->motor, &self->motor.x, i_A);
        const double now_A = i_A[leg];
        if (fabs(now_A) < 2e-5 || pass == 20) {
            return at_s; // the remainder, a thousandth of a count, is set to zero
        }
        if (sign * now_A > 0.0) {
            early_s = at_s;
        } else {
            late_s = at_s;
        }
        const double slope = pass == 0 ? slope_now(self, leg) : (now_A - last_A) / (at_s - last_s);
        last_s = at_s;
        last_A = now_A;
        at_s -= now_A / slope;
        if (!(at_s > early_s && at_s < late_s)) {
            at_s = 0.5 * (early_s + late_s);
        }
    }
}

/// Moves the motor by h_s or to the first change of conduction before that. Returns the time moved.
static double step_to_event(plant_t *self, double h_s, plant_stretch_t *sum, bool *has_event,
                            plant_event_t *event) {
    const plant_motor_state_t before = self->motor.x;
    double done_s = h_s;
    *has_event = false;
    plant_motor_step(&self->motor, &self->inverter.drive, h_s, sum);
    // If two events share a stretch the guess may find the later one first; then the search is repeated.
    for (int look = 0; look < PLANT_LEGS && self->events_left > 0; look++) {
        plant_event_t found;
        if (!plant_inverter_find_event(&self->inverter, &self->motor, &before, sum, self->now_s,
                                       done_s, &found) ||
            (*has_event && found.leg == event->leg)) {
            break;
        }
        *event = found;
        *has_event = true;
        if (found.sign == 0 && found.leg != PLANT_ALL_FLOAT) {
            done_s = step_to_zero(self, &before, found.after_s, done_s, found.leg, sum);
        } else {
            // The start of a current needs no exact timing, because the current begins with no slope.
            done_s = found.after_s;
            self->motor.x = before;
            plant_motor_step(&self->motor, &self->inverter.drive, done_s, sum);
        }
    }
    self->events_left -= *has_event ? 1 : 0;
    return done_s;
}

static void note_peak(plant_t *self) {
    double i_A[PLANT_LEGS] = {0.0};
    plant_motor_phase_currents(&self->motor, &self->motor.x, i_A);
    for (int n = 0; n < self->sets * PLANT_PHASES; n++) {
        self->peak_A = fmax(self->peak_A, fabs(i_A[n]));
    }
}

/// Advances to the next gate edge, part of the way there, or to a change of conduction.
static void run_stretch(plant_t *self, double until_s, double longest_s) {
    plant_inverter_t *inverter = &self->inverter;
    const double edge_s = plant_inverter_next_edge(inverter, until_s);
    // Equal parts avoid a very short last step.
    const double gap_s = edge_s - self->now_s;
    const double parts = gap_s > longest_s ? ceil(gap_s / longest_s) : 1.0;
    const double h_s = parts > 1.0 ? gap_s / parts : gap_s;
    plant_stretch_t sum;
    plant_event_t event;
    bool has_event;
    const double done_s = step_to_event(self, h_s, &sum, &has_event, &event);
    if (self->motor.keeps_accounts) {
        book(self, &sum, done_s);
    }
    if (self->watches_peak) {
        note_peak(self);
    }
    self->now_s = parts > 1.0 || has_event ? self->now_s + done_s : edge_s;
    plant_inverter_follow_signs(inverter, &self->motor, self->now_s);
    if (has_event) {
        plant_inverter_take_event(inverter, &self->motor, &event);
        plant_inverter_settle(inverter, &self->motor, self->now_s);
    } else if (self->events_left <= 0) {
        plant_inverter_adopt_signs(inverter, &self->motor);
        plant_inverter_settle(inverter, &self->motor, self->now_s);
    } else if (self->now_s >= edge_s && edge_s < until_s) {
        plant_inverter_switch(inverter, &self->motor, self->now_s);
    }
}

/// Simulates the present period up to `until_s`.
static void run(plant_t *self, double until_s) {
    double longest_s = 0.0; // computed when a stretch needs it
    while (self->now_s < until_s) {
        const double now_s = self->now_s;
        // A peak may lie at any edge, so each edge is checked.
        if (!self->watches_peak && plant_linear_can_run(&self->inverter, &self->motor)) {
            self->now_s =
                plant_linear_run(&self->inverter, &self->motor, now_s, until_s, &self->events_left);
        }
        if (!(self->now_s > now_s)) {
            if (!(longest_s > 0.0)) {
                longest_s = plant_motor_longest_step(&self->motor, self->inverter.drive.R_Ohm);
            }
            run_stretch(self, until_s, longest_s);
        }
    }
}

/// Starts the period that follows t_k.
static void begin_period(plant_t *self) {
    plant_gates_t gates[PLANT_SETS] = {PLANT_GATES_OFF, PLANT_GATES_OFF};
    self->now_s = 0.0;
    self->events_left = EVENTS_PER_PERIOD;
    self->u_Vs = (plant_planes_t){{0.0, 0.0}, {0.0, 0.0}};
    for (int set = 0; set < self->sets; set++) {
        gates[set] = self->trip[set] ? PLANT_GATES_OFF : self->gates[set];
    }
    plant_duty_t duty[PLANT_LEGS];
    for (int n = 0; n < PLANT_LEGS; n++) {
        duty[n] = (plant_duty_t){self->duty[n], self->fall[n]};
    }
    plant_inverter_begin(&self->inverter, &self->motor, duty, gates);
}

static void sample_link(plant_t *self) {
    for (int n = 0; n < PLANT_LINKS; n++) {
        double i_A[PLANT_LEGS] = {0.0};
        run(self, self->link_at[n] * self->period_s);
        plant_motor_phase_currents(&self->motor, &self->motor.x, i_A);
        self->link_A[n] = plant_inverter_link_A(&self->inverter, i_A, 0);
    }
}

/// Energy that the brake resistor takes in a period.
static double chopped_J(const plant_t *self) {
    const double v_V = self->inverter.v_bus_V;
    return self->chopper_R_Ohm > 0.0
               ? self->chopper * v_V * v_V / self->chopper_R_Ohm * self->period_s
               : 0.0;
}

/// Updates the capacitor for the energy that inverter and brake resistor took from it or returned in the period.
static void follow_bus(plant_t *self) {
    if (!(self->bus_C_F > 0.0)) {
        return;
    }
    const double v_V = self->inverter.v_bus_V;
    const double chopper_J = chopped_J(self);
    const double taken_J = self->energy.bus_J - self->drawn_J + chopper_J;
    self->energy.chopper_J += chopper_J;
    const double squared = v_V * v_V - 2.0 * taken_J / self->bus_C_F;
    self->drawn_J = self->energy.bus_J;
    self->inverter.v_bus_V = fmax(self->source_V, sqrt(fmax(squared, 0.0)));
}

void plant_advance(plant_t *self) {
    begin_period(self);
    if (self->link_at[PLANT_LINKS - 1] > 0.0) {
        sample_link(self);
    }
    if (self->sample_offset_s < 0.0) {
        run(self, self->period_s + self->sample_offset_s);
        plant_motor_phase_currents(&self->motor, &self->motor.x, self->i_early_A);
    }
    run(self, self->period_s);
    plant_motor_refresh_angle(&self->motor);
    follow_bus(self);
    plant_inverter_clear(&self->inverter, &self->motor);
    for (int n = 0; n < self->sets * PLANT_PHASES; n++) {
        self->duty[n] = self->next_duty[n];
        self->fall[n] = self->next_fall[n];
        self->gates[n / PLANT_PHASES] = self->next_gates[n / PLANT_PHASES];
    }
    for (int n = 0; n < PLANT_LINKS; n++) {
        self->link_at[n] = self->next_link_at[n];
    }
    self->chopper = self->next_chopper;
    self->periods++;
}

void plant_watch_peak(plant_t *self) {
    self->watches_peak = true;
    self->peak_A = 0.0;
}

double plant_peak_A(const plant_t *self) {
    return self->peak_A;
}

void plant_write_set(plant_t *self, int set, const double duty[PLANT_PHASES], plant_gates_t gates) {
    for (int n = 0; n < PLANT_PHASES; n++) {
        self->next_duty[set * PLANT_PHASES + n] = duty[n];
        self->next_fall[set * PLANT_PHASES + n] = duty[n];
    }
    self->next_gates[set] = gates;
    self->gates[set] = gates == PLANT_GATES_OFF ? PLANT_GATES_OFF : self->gates[set];
}

void plant_write(plant_t *self, const double duty[PLANT_PHASES], plant_gates_t gates) {
    plant_write_set(self, 0, duty, gates);
}

void plant_write_halves(plant_t *self, const double rise[PLANT_PHASES],
                        const double fall[PLANT_PHASES], plant_gates_t gates) {
    plant_write(self, rise, gates);
    for (int n = 0; n < PLANT_PHASES; n++) {
        self->next_fall[n] = fall[n];
    }
}

void plant_write_chopper(plant_t *self, double duty) {
    self->next_chopper = duty;
}

double plant_bus_V(const plant_t *self) {
    return self->inverter.v_bus_V;
}

void plant_set_link_samples(plant_t *self, const double at[PLANT_LINKS]) {
    for (int n = 0; n < PLANT_LINKS; n++) {
        self->next_link_at[n] = at[n];
    }
}

/// Currents at the sampling instant.
static void sampled_currents(const plant_t *self, double i_A[PLANT_LEGS]) {
    if (self->sample_offset_s > 0.0) {
        // The firmware acts at t_k after this sample, so a copy of the plant is run ahead.
        plant_t ahead = *self;
        begin_period(&ahead);
        run(&ahead, self->sample_offset_s);
        plant_motor_phase_currents(&ahead.motor, &ahead.motor.x, i_A);
    } else if (self->sample_offset_s < 0.0) {
        for (int n = 0; n < PLANT_LEGS; n++) {
            i_A[n] = self->i_early_A[n];
        }
    } else {
        plant_motor_phase_currents(&self->motor, &self->motor.x, i_A);
    }
}

static void tell_truth(const plant_t *self, plant_truth_t *truth) {
    const plant_motor_t *motor = &self->motor;
    const plant_motor_state_t *x = &motor->x;
    const plant_planes_t emf = plant_motor_active_emf(motor);
    *truth = (plant_truth_t){
        .t_s = (double)self->periods * self->period_s,
        .theta_e_rad = x->theta_e_rad,
        .omega_e_rad_s = motor->np * x->omega_m_rad_s,
        .omega_m_rad_s = x->omega_m_rad_s,
        .id_A = x->id_A,
        .iq_A = x->iq_A,
        .i_alpha_A = x->id_A * x->cos_theta - x->iq_A * x->sin_theta,
        .i_beta_A = x->id_A * x->sin_theta + x->iq_A * x->cos_theta,
        .i_x_A = x->ix_A,
        .i_y_A = x->iy_A,
        .e_alpha_V = emf.ab.alpha,
        .e_beta_V = emf.ab.beta,
        .e_x_V = emf.xy.alpha,
        .e_y_V = emf.xy.beta,
        .torque_Nm = plant_motor_torque(motor),
        .u_alpha_V = self->u_Vs.ab.alpha / self->period_s,
        .u_beta_V = self->u_Vs.ab.beta / self->period_s,
        .u_x_V = self->u_Vs.xy.alpha / self->period_s,
        .u_y_V = self->u_Vs.xy.beta / self->period_s,
        .energy = self->energy,
    };
    if (motor->keeps_accounts) {
        truth->energy.field_J = plant_motor_field_energy(motor);
        truth->energy.kinetic_J = plant_motor_kinetic_energy(motor);
    } else {
        truth->u_alpha_V = truth->u_beta_V = truth->u_x_V = truth->u_y_V = NAN;
        truth->energy = (plant_energy_t){NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    }
    plant_motor_phase_currents(motor, x, truth->i_abc_A);
    for (int n = 0; n < PLANT_LEGS; n++) {
        truth->open[n] = self->inverter.leg[n].open;
    }
}

void plant_sample(plant_t *self, plant_counts_t *counts, plant_truth_t *truth) {
    if (counts != NULL) {
        double i_A[PLANT_LEGS];
        sampled_currents(self, i_A);
        plant_adc_convert(&self->adc, i_A, self->inverter.v_bus_V, self->temperature_degC, counts);
        for (int n = 0; n < PLANT_LINKS; n++) {
            const bool sampled = self->link_at[n] > 0.0;
            counts->link[n] = sampled ? plant_adc_link(&self->adc, self->link_A[n]) : (uint16_t)0;
        }
        const double ticks = (double)self->periods * self->period_s * self->stamp_Hz + 0.5;
        for (int set = 0; set < self->sets; set++) {
            counts[set].trip = self->trip[set];
            counts[set].stamp = (uint32_t)((uint64_t)ticks & UINT64_C(0xFFFFFFFF));
        }
    }
    if (truth != NULL) {
        tell_truth(self, truth);
    }
}

void plant_set_load(plant_t *self, double load_Nm) {
    self->motor.load_Nm = load_Nm;
}

void plant_set_passive(plant_t *self, bool load_is_passive) {
    self->motor.load_is_passive = load_is_passive;
}

void plant_set_speed(plant_t *self, double omega_m_rad_s) {
    const double before_J = plant_motor_kinetic_energy(&self->motor);
    self->motor.x.omega_m_rad_s = omega_m_rad_s;
    self->motor.speed_is_prescribed = true;
    // The dynamometer supplies the energy of the step.
    self->energy.load_J += before_J - plant_motor_kinetic_energy(&self->motor);
}

void plant_release_speed(plant_t *self) {
    self->motor.speed_is_prescribed = false;
}

void plant_set_bus(plant_t *self, double v_bus_V) {
    self->source_V = v_bus_V;
    if (!(self->bus_C_F > 0.0)) {
        self->inverter.v_bus_V = v_bus_V;
    }
}

void plant_set_temperature(plant_t *self, double temperature_degC) {
    self->temperature_degC = temperature_degC;
}

void plant_set_trip(plant_t *self, bool trip) {
    for (int set = 0; set < self->sets; set++) {
        plant_set_trip_of(self, set, trip);
    }
}

void plant_set_trip_of(plant_t *self, int set, bool trip) {
    self->trip[set] = trip;
}

void plant_open_phase(plant_t *self, int leg) {
    plant_inverter_open(&self->inverter, &self->motor, leg);
}

void plant_fail_switch(plant_t *self, int leg, bool high, bool shorted) {
    plant_inverter_fail(&self->inverter, leg, high, shorted);
}

void plant_set_flux(plant_t *self, double psi_Wb) {
    self->motor.psi_Wb = psi_Wb;
}

void plant_write_through(plant_t *self) {
    for (int n = 0; n < PLANT_LEGS; n++) {
        self->duty[n] = self->next_duty[n];
        self->fall[n] = self->next_fall[n];
    }
}
