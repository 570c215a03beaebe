/// The simulated motor, inverter and ADCs against closed forms, against a brute-force
/// simulation written another way (below), and against recordings of somebody else's simulator.
#include "plant/plant.h"
#include "plant/replay.h"

#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#define PI 3.14159265358979323846
#define SQRT3 1.73205080756887729353

static const double not_a_number = (double)NAN;

void setUp(void) {}

void tearDown(void) {}

// ---------------------------------------------------------------------------------------------
// Helpers

/// Averaged level, no quantisation, ideal ADCs, held at standstill.
static plant_config_t bench_config(void) {
    plant_config_t c = plant_config_jiang2022();
    c.level = PLANT_AVERAGED;
    c.pwm_ticks = 0;
    c.speed_is_prescribed = true;
    return c;
}

static plant_t new_plant(const plant_config_t *config) {
    plant_t plant;
    const char *error = plant_init(&plant, config);
    TEST_ASSERT_NULL_MESSAGE(error, error);
    return plant;
}

static plant_truth_t truth_of(plant_t *plant) {
    plant_truth_t truth;
    plant_sample(plant, NULL, &truth);
    return truth;
}

/// Duties for a voltage, centred on the middle of the bus.
static void duties(double u_alpha, double u_beta, double v_bus, double duty[3]) {
    for (int n = 0; n < 3; n++) {
        duty[n] = 0.5 + (plant_axis_cos[n] * u_alpha + plant_axis_sin[n] * u_beta) / v_bus;
    }
}

static void write_voltage(plant_t *plant, double u_alpha, double u_beta) {
    double duty[3];
    duties(u_alpha, u_beta, plant->inverter.v_bus_V, duty);
    plant_write(plant, duty, true);
}

/// Writes a voltage and lets the period pass after which it acts.
static void start_with_voltage(plant_t *plant, double u_alpha, double u_beta) {
    write_voltage(plant, u_alpha, u_beta);
    plant_advance(plant);
}

static void advance(plant_t *plant, int periods) {
    for (int k = 0; k < periods; k++) {
        plant_advance(plant);
    }
}

/// What a small current controller that knows everything writes.
static void control_current(plant_t *plant, const plant_config_t *c, double id_ref, double iq_ref) {
    const plant_truth_t t = truth_of(plant);
    const double w = t.omega_e_rad_s, angle = t.theta_e_rad + 1.5 * w * c->period_s;
    const double ud = c->Rs_Ohm * id_ref - w * c->Lq_H * t.iq_A + 3.0 * (id_ref - t.id_A);
    const double uq =
        c->Rs_Ohm * iq_ref + w * (c->psi_Wb + c->Ld_H * t.id_A) + 6.0 * (iq_ref - t.iq_A);
    write_voltage(plant, ud * cos(angle) - uq * sin(angle), ud * sin(angle) + uq * cos(angle));
}

static double balance_error_J(const plant_energy_t *e, double stored_at_start_J) {
    return e->bus_J - e->copper_J - e->inverter_J - e->friction_J - e->load_J -
           (e->field_J + e->kinetic_J - stored_at_start_J);
}

// ---------------------------------------------------------------------------------------------
// A brute-force reference: nanosecond Euler steps of the flux in the stationary frame; each leg is
// one steep characteristic instead of modes and events, so a floating phase needs no special case.

typedef struct {
    const plant_config_t *c;
    double psi_alpha, psi_beta, theta, omega_m;
    double i[3];
    int wanted[3]; // 0 none, 1 low, 2 high
    int wait[3];   // steps left of the dead time
    double u_alpha_mean, u_beta_mean;
} reference_t;

enum { REFERENCE_STEPS = 40000 }; // per period: 5 ns at 5 kHz

static double reference_iq(const plant_config_t *c, double psi_q) {
    if (!(c->i_sat_A > 0.0)) {
        return psi_q / c->Lq_H;
    }
    // Lq_sat x + (Lq - Lq_sat) x / (1 + x/a) = |psi|, a quadratic in x.
    const double y = fabs(psi_q), a = c->i_sat_A;
    const double b = c->Lq_H - y / a;
    const double q = c->Lq_sat_H / a;
    return copysign(2.0 * y / (b + sqrt(b * b + 4.0 * q * y)), psi_q);
}

static double reference_id(const plant_config_t *c, double psi_d) {
    if (!(c->id_sat_A > 0.0)) {
        return psi_d / c->Ld_H;
    }
    // x - s (sqrt(1 + x^2) - 1) = psi/(Ld a), a quadratic in x.
    const double s = 1.0 - c->Ld_sat_H / c->Ld_H, y = psi_d / (c->Ld_H * c->id_sat_A) - s;
    return c->id_sat_A * (y + s * sqrt(y * y + 1.0 - s * s)) / (1.0 - s * s);
}

/// Each axis by itself, with what the other one takes from its flux by the currents of a little earlier.
static void reference_dq(const plant_config_t *c, double psi_d, double psi_q, double *id,
                         double *iq) {
    double d_Wb = 0.0, q_Wb = 0.0;
    if (c->i_cross_A > 0.0) {
        const double i = SQRT3 * c->i_cross_A, u = *id / i, v = *iq / i;
        const double size = 8.0 / (3.0 * SQRT3) * c->Ldq_H * i;
        d_Wb = size * pow(1.0 + u * u, -1.5) * v * v / (1.0 + v * v);
        q_Wb = size * u / sqrt(1.0 + u * u) * 2.0 * v / ((1.0 + v * v) * (1.0 + v * v));
    }
    *id = reference_id(c, psi_d + d_Wb);
    *iq = reference_iq(c, psi_q + q_Wb);
}

/// Currents and torque from flux and angle.
static double reference_currents(reference_t *r) {
    const plant_config_t *c = r->c;
    const double co = cos(r->theta), si = sin(r->theta), th = r->theta;
    const double a5 = c->psi_Wb * c->emf5_ratio, a7 = c->psi_Wb * c->emf7_ratio;
    // The magnet's harmonic flux: negative sequence for the 5th, positive for the 7th.
    double h_alpha = 0.0, h_beta = 0.0, e_alpha = 0.0, e_beta = 0.0;
    if (a5 > 0.0 || a7 > 0.0) {
        const double x5 = 5.0 * th + c->emf5_phase_rad, x7 = 7.0 * th + c->emf7_phase_rad;
        h_alpha = a5 / 5.0 * cos(x5) + a7 / 7.0 * cos(x7);
        h_beta = -a5 / 5.0 * sin(x5) + a7 / 7.0 * sin(x7);
        e_alpha = -a5 * sin(x5) - a7 * sin(x7); // EMF per rad/s
        e_beta = -a5 * cos(x5) + a7 * cos(x7);
    }
    const double p_alpha = r->psi_alpha - h_alpha, p_beta = r->psi_beta - h_beta;
    const double psi_d = p_alpha * co + p_beta * si, psi_q = p_beta * co - p_alpha * si;
    double id = r->i[0] * co + (r->i[1] - r->i[2]) / SQRT3 * si;
    double iq = (r->i[1] - r->i[2]) / SQRT3 * co - r->i[0] * si;
    reference_dq(c, psi_d - c->psi_Wb, psi_q, &id, &iq);
    const double alpha = id * co - iq * si, beta = id * si + iq * co;
    r->i[0] = alpha;
    r->i[1] = -0.5 * alpha + 0.5 * SQRT3 * beta;
    r->i[2] = -0.5 * alpha - 0.5 * SQRT3 * beta;
    return 1.5 * c->pole_pairs * (psi_d * iq - psi_q * id + e_alpha * alpha + e_beta * beta);
}

static reference_t reference_start(const plant_config_t *c) {
    reference_t r = {.c = c, .theta = c->theta_e_rad, .omega_m = c->omega_m_rad_s};
    const double x5 = 5.0 * r.theta + c->emf5_phase_rad, x7 = 7.0 * r.theta + c->emf7_phase_rad;
    r.psi_alpha =
        c->psi_Wb * (cos(r.theta) + c->emf5_ratio / 5.0 * cos(x5) + c->emf7_ratio / 7.0 * cos(x7));
    r.psi_beta =
        c->psi_Wb * (sin(r.theta) - c->emf5_ratio / 5.0 * sin(x5) + c->emf7_ratio / 7.0 * sin(x7));
    reference_currents(&r);
    return r;
}

/// Terminal voltage of a leg: its two levels joined by a slope 2 mA wide.
static double reference_leg(const reference_t *r, int n) {
    const plant_config_t *c = r->c;
    const int gate = r->wait[n] > 0 ? 0 : r->wanted[n];
    const double low = gate == 2 ? c->v_bus_V - c->v_transistor_V : -c->v_diode_V;
    const double high = gate == 1 ? c->v_transistor_V : c->v_bus_V + c->v_diode_V;
    const double share = fmin(fmax(0.5 - r->i[n] / 2e-3, 0.0), 1.0);
    return low + (high - low) * share - c->r_on_Ohm * r->i[n];
}

static void reference_period(reference_t *r, const double duty[3], plant_gates_t gates) {
    const plant_config_t *c = r->c;
    const double steps = (double)REFERENCE_STEPS, h = c->period_s / steps;
    const int dead = (int)floor(c->dead_time_s / h + 0.5);
    double sum_alpha = 0.0, sum_beta = 0.0;
    for (int k = 0; k < REFERENCE_STEPS; k++) {
        double v[3];
        const double x = fabs(k + 0.5 - 0.5 * steps) * 2.0 / steps;
        for (int n = 0; n < 3; n++) {
            const int high = gates == PLANT_GATES_ON ? 2 : 0;
            const int wanted = gates == PLANT_GATES_OFF ? 0 : (x < duty[n] ? high : 1);
            r->wait[n] = wanted != r->wanted[n] ? dead : r->wait[n] - (r->wait[n] > 0);
            r->wanted[n] = wanted;
            v[n] = reference_leg(r, n);
        }
        const double u_alpha = (2.0 * v[0] - v[1] - v[2]) / 3.0, u_beta = (v[1] - v[2]) / SQRT3;
        const double i_alpha = r->i[0], i_beta = (r->i[1] - r->i[2]) / SQRT3;
        const double omega_before = r->omega_m;
        r->psi_alpha += h * (u_alpha - c->Rs_Ohm * i_alpha);
        r->psi_beta += h * (u_beta - c->Rs_Ohm * i_beta);
        const double torque = reference_currents(r);
        if (!c->speed_is_prescribed) {
            r->omega_m += h / c->J_kgm2 * (torque - c->load_Nm - c->B_Nms * r->omega_m);
        }
        r->theta += h * c->pole_pairs * 0.5 * (omega_before + r->omega_m);
        sum_alpha += u_alpha;
        sum_beta += u_beta;
    }
    r->u_alpha_mean = sum_alpha / steps;
    r->u_beta_mean = sum_beta / steps;
}

/// Runs plant and reference side by side under the same duties; largest difference of a phase
/// current, and of the mean voltage, at any t_k.
static void compare_with_reference(const plant_config_t *c, double iq, int periods,
                                   plant_gates_t gates, double i_limit_A, double u_limit_V,
                                   const char *name) {
    plant_t plant = new_plant(c);
    reference_t r = reference_start(c);
    double i_worst = 0.0, u_worst = 0.0, i_peak = 0.0;
    for (int k = 0; k < periods; k++) {
        control_current(&plant, c, 0.0, iq);
        if (gates == PLANT_GATES_OFF) {
            plant_write(&plant, plant.next_duty, gates);
        } else if (gates == PLANT_GATES_LOW) {
            plant_write(&plant, (const double[]){0.8, 0.8, 0.8}, gates);
        }
        reference_period(&r, plant.duty, plant.gates[0]);
        plant_advance(&plant);
        const plant_truth_t t = truth_of(&plant);
        for (int n = 0; n < 3; n++) {
            i_worst = fmax(i_worst, fabs(t.i_abc_A[n] - r.i[n]));
            i_peak = fmax(i_peak, fabs(t.i_abc_A[n]));
        }
        u_worst = fmax(u_worst, hypot(t.u_alpha_V - r.u_alpha_mean, t.u_beta_V - r.u_beta_mean));
    }
    printf("  reference, %s: peak %.3f A, largest difference %.2e A, %.2e V\n", name, i_peak,
           i_worst, u_worst);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(i_limit_A, 0.0, i_worst, name);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(u_limit_V, 0.0, u_worst, name);
}

static plant_config_t lossy_config(void) {
    plant_config_t c = plant_config_jiang2022();
    c.pwm_ticks = 0;
    c.v_transistor_V = 1.2;
    c.v_diode_V = 0.9;
    c.r_on_Ohm = 0.08;
    c.load_is_passive = false;
    c.theta_e_rad = 0.3;
    c.omega_m_rad_s = 40.0;
    return c;
}

/// 5 ns of 200 V on 3.5 mH are 0.3 mA: the reference places its gate edges no better than that and
/// its legs are 2 mA wide, so 10 mA (0.1 % of 10 A) and 0.1 V are what it can tell.
static void test_switching_matches_reference_under_load(void) {
    plant_config_t c = lossy_config();
    c.load_Nm = 5.0;
    compare_with_reference(&c, 8.0, 120, PLANT_GATES_ON, 10e-3, 0.1, "rated load");
}

static void test_switching_matches_reference_with_saturation_and_harmonics(void) {
    plant_config_t c = lossy_config();
    c.i_sat_A = 12.0;
    c.Lq_sat_H = 2e-3;
    c.emf5_ratio = 0.06;
    c.emf5_phase_rad = 0.4;
    c.emf7_ratio = 0.03;
    c.emf7_phase_rad = -0.7;
    c.load_Nm = 3.0;
    compare_with_reference(&c, -7.0, 120, PLANT_GATES_ON, 10e-3, 0.1, "saturation and harmonics");
}

/// Both axes saturate, and each takes from the other.
static void saturate(plant_config_t *c) {
    c->i_sat_A = 12.0;
    c->Lq_sat_H = 2.5e-3;
    c->id_sat_A = 5.0;
    c->Ld_sat_H = 2.3e-3;
    c->i_cross_A = 8.0;
    c->Ldq_H = 0.4e-3;
}

static void test_switching_matches_reference_with_cross_saturation(void) {
    plant_config_t c = lossy_config();
    saturate(&c);
    c.load_Nm = 4.0;
    compare_with_reference(&c, 8.0, 120, PLANT_GATES_ON, 10e-3, 0.1, "cross-saturation");
    c.load_Nm = 0.0;
    c.omega_m_rad_s = 12.0;
    compare_with_reference(&c, 1.2, 60, PLANT_GATES_ON, 5e-3, 0.1, "cross-saturation, little load");
}

/// All three currents cross zero several times in each period here; phases float in between.
static void test_switching_matches_reference_without_load(void) {
    plant_config_t c = lossy_config();
    c.omega_m_rad_s = 12.0;
    compare_with_reference(&c, 0.0, 120, PLANT_GATES_ON, 5e-3, 0.1, "no load");
    compare_with_reference(&c, 1.2, 120, PLANT_GATES_ON, 5e-3, 0.1, "little load");
}

/// Low sides alone: a short circuit for a fifth of the period, then the diodes carry the current into the bus.
static void test_low_sides_alone_match_the_reference(void) {
    plant_config_t c = lossy_config();
    c.omega_m_rad_s = 150.0;
    c.speed_is_prescribed = true;
    compare_with_reference(&c, 0.0, 120, PLANT_GATES_LOW, 5e-3, 0.1, "low sides alone");
}

/// At rest there is nothing to short-circuit; turning, the current is what the EMF makes of a fifth of a
/// period, and what it had taken goes back into the bus.
static void test_low_sides_alone_bound_the_current(void) {
    plant_config_t c = plant_config_jiang2022();
    c.speed_is_prescribed = true;
    c.omega_m_rad_s = 0.0;
    for (int turning = 0; turning < 2; turning++) {
        plant_t plant = new_plant(&c);
        double peak = 0.0;
        for (int k = 0; k < 500; k++) {
            plant_write(&plant, (const double[]){0.8, 0.8, 0.8}, PLANT_GATES_LOW);
            plant_advance(&plant);
            for (int n = 0; n < 3; n++) {
                peak = fmax(peak, fabs(truth_of(&plant).i_abc_A[n]));
            }
        }
        // From nothing until t_k, in the middle of the fifth, which begins late by the dead time; by an
        // inductance between Ld and Lq.
        const double flux_Wb =
            3.0 * c.omega_m_rad_s * c.psi_Wb * (0.1 * c.period_s - c.dead_time_s);
        if (turning == 0) {
            TEST_ASSERT_TRUE(peak == 0.0);
        } else {
            TEST_ASSERT_TRUE(peak > 0.98 * flux_Wb / c.Lq_H); // the resistance takes some
            TEST_ASSERT_TRUE(peak < flux_Wb / c.Ld_H);
        }
        TEST_ASSERT_TRUE(turning == 0 || truth_of(&plant).energy.bus_J < 0.0);
        c.omega_m_rad_s = 100.0;
    }
}

/// Currents reverse in the zero vector: between the low gate, on since the last period, and the pulse.
static void test_switching_matches_reference_at_reversals(void) {
    plant_config_t c = lossy_config();
    c.omega_m_rad_s = 120.0;
    c.speed_is_prescribed = true;
    compare_with_reference(&c, 0.5, 200, PLANT_GATES_ON, 5e-3, 0.1, "reversals in the zero vector");
}

/// Without drops a current that passes through zero while a gate is on is no event: the plant goes
/// through it in one stretch. In the dead time it still stops. The ripple here is 3 A, so that each
/// phase passes zero several times a period.
static void test_switching_matches_reference_without_drops(void) {
    plant_config_t c = lossy_config();
    c.Ld_H = 1.5e-3;
    c.Lq_H = 2e-3;
    c.v_transistor_V = 0.0;
    c.v_diode_V = 0.0;
    compare_with_reference(&c, 0.5, 120, PLANT_GATES_ON, 10e-3, 0.1, "no drops, little load");
    compare_with_reference(&c, 4.0, 60, PLANT_GATES_ON, 10e-3, 0.1, "no drops, load");
    c.dead_time_s = 0.0;
    compare_with_reference(&c, 0.5, 60, PLANT_GATES_ON, 10e-3, 0.1, "no drops, no dead time");
    plant_t plant = new_plant(&c);
    plant_write(&plant, (const double[]){0.5, 0.52, 0.49}, true);
    advance(&plant, 2);
    const int untouched = plant.events_left;
    for (int k = 0; k < 50; k++) {
        control_current(&plant, &c, 0.0, 0.0);
        plant_advance(&plant);
        TEST_ASSERT_EQUAL_INT(untouched, plant.events_left);
    }
}

/// Accounts are only kept along: the motion is the same, to the bit where it goes from stretch to stretch without them
/// too. test_plant_linear.c has how far the other loop (linear.h) may be off.
static void test_accounts_change_nothing_else(void) {
    plant_config_t c = lossy_config();
    for (int harmonics = 0; harmonics < 2; harmonics++) {
        c.emf5_ratio = 0.05 * harmonics;
        c.keeps_accounts = true;
        plant_t with = new_plant(&c);
        c.keeps_accounts = false;
        plant_t without = new_plant(&c);
        for (int k = 0; k < 400; k++) {
            control_current(&with, &c, 0.0, 6.0 * sin(0.05 * k));
            plant_write(&without, with.next_duty, k % 100 < 90);
            plant_write(&with, with.next_duty, k % 100 < 90);
            plant_advance(&with);
            plant_advance(&without);
        }
        const plant_motor_state_t *a = &with.motor.x, *b = &without.motor.x;
        if (harmonics > 0) {
            TEST_ASSERT_EQUAL_MEMORY(a, b, sizeof *a);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, a->id_A, b->id_A);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, a->iq_A, b->iq_A);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, a->theta_e_rad, b->theta_e_rad);
        const plant_truth_t t = truth_of(&without);
        TEST_ASSERT_TRUE(isnan(t.u_alpha_V) && isnan(t.u_beta_V) && isnan(t.energy.bus_J) &&
                         isnan(t.energy.kinetic_J) && isfinite(truth_of(&with).u_alpha_V));
    }
}

/// Line-to-line EMF of 246 V against a bus of 200 V: two diodes conduct, then three.
static void test_gates_off_matches_reference_when_rectifying(void) {
    plant_config_t c = lossy_config();
    c.omega_m_rad_s = 333.0;
    c.speed_is_prescribed = true;
    compare_with_reference(&c, 0.0, 60, PLANT_GATES_OFF, 10e-3, 0.2, "rectifying");
}

// ---------------------------------------------------------------------------------------------
// Electrical closed forms

/// The steps are made for 5e-6 of the end value, 8 A.
static void check_rl_step(double theta, double L, plant_level_t level) {
    plant_config_t c = bench_config();
    c.level = level;
    c.dead_time_s = 0.0;
    c.theta_e_rad = theta;
    plant_t plant = new_plant(&c);
    start_with_voltage(&plant, 6.0, 0.0);
    for (int k = 1; k <= 200; k++) {
        plant_advance(&plant);
        const double i = 8.0 * (1.0 - exp(-c.Rs_Ohm * k * c.period_s / L));
        // A switched voltage gives the same current at t_k up to its ripple's second order.
        const double limit = level == PLANT_AVERAGED ? 4e-5 : 2e-3;
        TEST_ASSERT_DOUBLE_WITHIN(limit, i, truth_of(&plant).i_alpha_A);
        TEST_ASSERT_DOUBLE_WITHIN(limit, 0.0, truth_of(&plant).i_beta_A);
    }
}

static void test_rl_step_locked_rotor(void) {
    check_rl_step(0.0, 3.5e-3, PLANT_AVERAGED);
    check_rl_step(0.5 * PI, 9.8e-3, PLANT_AVERAGED);
    check_rl_step(0.0, 3.5e-3, PLANT_SWITCHING);
    check_rl_step(0.5 * PI, 9.8e-3, PLANT_SWITCHING);
}

/// x' = A x + b in dq from zero: x = (I - exp(A t)) x_end with the 2x2 exponential written out.
static void short_circuit(const plant_config_t *c, double w, double t, double *id, double *iq) {
    const double R = c->Rs_Ohm, den = R * R + w * w * c->Ld_H * c->Lq_H;
    const double id_end = -w * w * c->psi_Wb * c->Lq_H / den, iq_end = -w * c->psi_Wb * R / den;
    const double a = -R / c->Ld_H, b = w * c->Lq_H / c->Ld_H;
    const double d = -w * c->Ld_H / c->Lq_H, e = -R / c->Lq_H;
    const double mean = 0.5 * (a + e), disc = 0.25 * (a - e) * (a - e) + b * d;
    TEST_ASSERT_TRUE(disc < 0.0); // oscillatory at the speeds tested
    const double nu = sqrt(-disc), co = cos(nu * t), si = sin(nu * t) / nu, g = exp(mean * t);
    *id = id_end - g * ((co + si * (a - mean)) * id_end + si * b * iq_end);
    *iq = iq_end - g * (si * d * id_end + (co + si * (e - mean)) * iq_end);
}

static void check_short_circuit(plant_level_t level, double omega_m, double duty_of_all) {
    plant_config_t c = bench_config();
    c.level = level; // no drops: all low sides on is a dead short too
    c.dead_time_s = 0.0;
    c.v_bus_V = 400.0; // nothing rectifies before the short circuit
    c.omega_m_rad_s = omega_m;
    const double duty[3] = {duty_of_all, duty_of_all, duty_of_all};
    plant_t plant = new_plant(&c);
    plant_write(&plant, duty, true);
    plant_advance(&plant);
    const double w = 3.0 * omega_m;
    for (int k = 1; k <= 400; k++) {
        double id, iq;
        plant_advance(&plant);
        short_circuit(&c, w, k * c.period_s, &id, &iq);
        const plant_truth_t t = truth_of(&plant);
        // Step error 5e-6 of 40 A per radian, damped: 1 mA is 1/40 of what 0.1 % would be.
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, id, t.id_A);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, iq, t.iq_A);
    }
    const plant_truth_t t = truth_of(&plant);
    const double den = c.Rs_Ohm * c.Rs_Ohm + w * w * c.Ld_H * c.Lq_H;
    // 80 ms are 10 time constants: 5e-5 of the transient is left.
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, -w * w * c.psi_Wb * c.Lq_H / den, t.id_A);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, -w * c.psi_Wb * c.Rs_Ohm / den, t.iq_A);
    const double torque = 1.5 * 3.0 * (c.psi_Wb + (c.Ld_H - c.Lq_H) * t.id_A) * t.iq_A;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, torque, t.torque_Nm); // same formula, other grouping
}

static void test_three_phase_short_circuit(void) {
    check_short_circuit(PLANT_AVERAGED, 157.0, 0.5);
    check_short_circuit(PLANT_AVERAGED, -60.0, 0.5);
    check_short_circuit(PLANT_AVERAGED, 314.0, 0.5);
    check_short_circuit(PLANT_SWITCHING, 157.0, 0.0);
    check_short_circuit(PLANT_SWITCHING, -157.0, 1.0);
}

static void test_open_circuit_emf(void) {
    plant_config_t c = bench_config();
    c.level = PLANT_SWITCHING;
    c.omega_m_rad_s = 200.0;
    plant_t plant = new_plant(&c);
    const double w = 600.0, psi = c.psi_Wb;
    double highest = 0.0;
    for (int k = 0; k < 300; k++) {
        const plant_truth_t before = truth_of(&plant);
        plant_advance(&plant);
        const plant_truth_t t = truth_of(&plant);
        TEST_ASSERT_TRUE(t.id_A == 0.0 && t.iq_A == 0.0); // nothing drives a current: exact
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, -w * psi * sin(t.theta_e_rad), t.e_alpha_V);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, w * psi * cos(t.theta_e_rad), t.e_beta_V);
        // The mean terminal voltage is the change of flux linkage: rounding only.
        const double mean = psi * (cos(t.theta_e_rad) - cos(before.theta_e_rad)) / c.period_s;
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, mean, t.u_alpha_V);
        // Line b to line c is sqrt(3) beta.
        highest = fmax(highest, SQRT3 * fabs(t.e_beta_V));
    }
    // 300 samples 7 deg apart that do not repeat come within 0.1 % of the peak.
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * SQRT3 * w * psi, SQRT3 * w * psi, highest);
    TEST_ASSERT_TRUE(truth_of(&plant).energy.bus_J == 0.0);
}

/// Rectification starts where the line-line EMF passes the bus plus two diodes, not before.
static void test_emf_above_the_bus_charges_it(void) {
    plant_config_t c = bench_config();
    c.level = PLANT_SWITCHING;
    c.v_diode_V = 1.5;
    const double edge = (c.v_bus_V + 3.0) / (SQRT3 * c.psi_Wb * 3.0);
    c.omega_m_rad_s = 0.999 * edge;
    plant_t below = new_plant(&c);
    c.omega_m_rad_s = 1.02 * edge;
    plant_t above = new_plant(&c);
    advance(&below, 500);
    advance(&above, 500);
    TEST_ASSERT_TRUE(truth_of(&below).energy.bus_J == 0.0);
    const plant_energy_t e = truth_of(&above).energy;
    TEST_ASSERT_TRUE(e.bus_J < -0.01);
    TEST_ASSERT_TRUE(e.load_J < e.bus_J); // the dynamometer pays, losses included
    TEST_ASSERT_TRUE(e.inverter_J > 0.0);
}

/// A capacitor that nothing else charges: what the resistor takes is missing in it, until the rectifier has it.
static void test_a_brake_resistor_discharges_the_bus(void) {
    plant_config_t c = bench_config();
    c.keeps_accounts = true;
    c.chopper_R_Ohm = 50.0;
    TEST_ASSERT_NOT_NULL(plant_init(&(plant_t){.periods = 0}, &c)); // no capacitor
    c.bus_C_F = 1e-3;
    plant_t plant = new_plant(&c);
    plant_set_bus(&plant, 0.5 * c.v_bus_V);
    plant_write_chopper(&plant, 0.25);
    advance(&plant, 1); // it acts from the next period on
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, c.v_bus_V, plant_bus_V(&plant));
    const int periods = 250;
    advance(&plant, periods);
    // v = V exp(-d t/RC), a quarter of 1/RC: in steps of a period.
    const double t_s = periods * c.period_s;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * c.v_bus_V, c.v_bus_V * exp(-0.25 * t_s / (50.0 * 1e-3)),
                              plant_bus_V(&plant));
    const double lost_J =
        0.5e-3 * (c.v_bus_V * c.v_bus_V - plant_bus_V(&plant) * plant_bus_V(&plant));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, lost_J, truth_of(&plant).energy.chopper_J);
    plant_write_chopper(&plant, 1.0);
    advance(&plant, 2000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * c.v_bus_V, plant_bus_V(&plant));
}

// ---------------------------------------------------------------------------------------------
// Energy

/// Accelerates, carries load, brakes; every store and loss takes part. The book must close to
/// 0.1 % of the throughput; the steps are made for a tenth of that and less, so 0.02 % is asked.
static void check_energy(plant_level_t level, bool extras, const char *name) {
    plant_config_t c = lossy_config();
    c.level = level;
    c.pwm_ticks = 16800;
    c.load_is_passive = true;
    c.load_Nm = 1.5;
    c.B_Nms = 0.01;
    if (extras) {
        saturate(&c);
        c.emf5_ratio = 0.05;
        c.emf7_ratio = 0.04;
        c.emf7_phase_rad = 1.0;
    }
    plant_t plant = new_plant(&c);
    const double start_J = truth_of(&plant).energy.kinetic_J;
    double throughput_J = 0.0, last_J = 0.0;
    for (int k = 0; k < 6000; k++) {
        const bool coast = k > 4000 && k < 4500;
        control_current(&plant, &c, -2.0, k < 2500 ? 9.0 : (k < 5000 ? -6.0 : 4.0));
        if (coast) {
            plant_write(&plant, plant.next_duty, false);
        }
        plant_advance(&plant);
        const plant_energy_t e = truth_of(&plant).energy;
        throughput_J += fabs(e.bus_J - last_J);
        last_J = e.bus_J;
    }
    const plant_energy_t e = truth_of(&plant).energy;
    const double error_J = balance_error_J(&e, start_J);
    printf("  energy, %s: throughput %.1f J, copper %.2f, inverter %.3f, load %.2f, friction %.2f, "
           "error %.2e\n",
           name, throughput_J, e.copper_J, e.inverter_J, e.load_J, e.friction_J,
           fabs(error_J) / throughput_J);
    TEST_ASSERT_TRUE(throughput_J > 100.0 && e.copper_J > 10.0 && e.load_J > 10.0);
    TEST_ASSERT_TRUE(e.friction_J > 1.0);
    TEST_ASSERT_EQUAL(level == PLANT_SWITCHING, e.inverter_J > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-4 * throughput_J, 0.0, error_J, name);
    // Electrical side alone: what the shaft got is what the terminals gave less copper and field.
    const double electrical_J = e.bus_J - e.inverter_J - e.copper_J - e.field_J - e.shaft_J;
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-4 * throughput_J, 0.0, electrical_J, name);
}

static void test_energy_balance(void) {
    check_energy(PLANT_AVERAGED, false, "averaged");
    check_energy(PLANT_AVERAGED, true, "averaged, saturation and harmonics");
    check_energy(PLANT_SWITCHING, false, "switching");
    check_energy(PLANT_SWITCHING, true, "switching, saturation and harmonics");
}

/// Copper loss of a direct current has a closed form: an anchor for the book's scale.
static void test_energy_scale(void) {
    plant_config_t c = bench_config();
    plant_t plant = new_plant(&c);
    start_with_voltage(&plant, 6.0, 0.0);
    advance(&plant, 1000);
    const plant_energy_t at = truth_of(&plant).energy;
    advance(&plant, 1000);
    const plant_energy_t then = truth_of(&plant).energy;
    // 200 ms are 43 time constants: rounding only.
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5 * 0.75 * 64.0 * 0.2, then.copper_J - at.copper_J);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5 * 6.0 * 8.0 * 0.2, then.bus_J - at.bus_J);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5 * 0.5 * 3.5e-3 * 64.0, then.field_J);
}

static double uniform(plant_noise_t *noise, double low, double high) {
    // The normal distribution folded by its own distribution function.
    return low + (high - low) * 0.5 * erfc(-plant_noise_next(noise) / sqrt(2.0));
}

/// Any motor: 50 uH to 10 mH, saliency 0.5 to 6, slow or fast, above or below the bus's EMF.
static plant_config_t random_config(plant_noise_t *noise) {
    plant_config_t c = lossy_config();
    c.pole_pairs = 1 + (int)uniform(noise, 0.0, 7.99);
    c.period_s = uniform(noise, 50e-6, 200e-6);
    c.Ld_H = 50e-6 * pow(200.0, uniform(noise, 0.0, 1.0));
    c.Lq_H = c.Ld_H * uniform(noise, 0.5, 6.0);
    c.Rs_Ohm = c.Ld_H / uniform(noise, 1e-3, 20e-3);
    const double w = uniform(noise, -800.0, 800.0);
    c.omega_m_rad_s = w / c.pole_pairs;
    c.psi_Wb = uniform(noise, 0.01, 1.2) * c.v_bus_V / SQRT3 / 800.0;
    c.J_kgm2 = 2e-5 * pow(1000.0, uniform(noise, 0.0, 1.0));
    c.load_is_passive = uniform(noise, 0.0, 1.0) > 0.5;
    c.load_Nm = uniform(noise, -1.0, 1.0);
    c.i_sat_A = uniform(noise, 0.0, 1.0) > 0.5 ? uniform(noise, 1.0, 10.0) : 0.0;
    c.Lq_sat_H = c.Lq_H * uniform(noise, 0.2, 1.0);
    c.id_sat_A = uniform(noise, 0.0, 1.0) > 0.5 ? uniform(noise, 1.0, 10.0) : 0.0;
    c.Ld_sat_H = c.Ld_H * uniform(noise, 0.5, 1.0);
    c.i_cross_A = uniform(noise, 0.0, 1.0) > 0.5 ? uniform(noise, 1.0, 10.0) : 0.0;
    c.Ldq_H = 0.15 * fmin(c.Ld_sat_H, c.Lq_sat_H) * uniform(noise, -1.0, 1.0);
    c.emf5_ratio = fmax(0.0, uniform(noise, -0.1, 0.1));
    c.v_transistor_V = fmax(0.0, uniform(noise, -2.0, 2.0));
    c.v_diode_V = fmax(0.0, uniform(noise, -2.0, 2.0));
    c.r_on_Ohm = fmax(0.0, uniform(noise, -0.1, 0.1)) * c.Rs_Ohm;
    c.dead_time_s = fmax(0.0, uniform(noise, -0.02, 0.04)) * c.period_s;
    c.theta_e_rad = uniform(noise, -3.0, 3.0);
    return c;
}

/// Whatever the motor and the duties: finite, currents that add up to zero, no loss that gives
/// energy, a closed book, and never a chain of events that would not end.
static void test_random_motors_stay_consistent(void) {
    plant_noise_t noise;
    double worst = 0.0;
    int fewest_left = 1000;
    plant_noise_init(&noise, 20220506);
    for (int motor = 0; motor < 400; motor++) {
        const plant_config_t c = random_config(&noise);
        plant_t plant = new_plant(&c);
        const double start_J = truth_of(&plant).energy.kinetic_J;
        const double swing = motor % 4 == 0 ? 0.0 : uniform(&noise, 0.0, 0.3);
        double throughput_J = start_J;
        plant_energy_t last = truth_of(&plant).energy;
        for (int k = 0; k < 300; k++) {
            double duty[3];
            for (int n = 0; n < 3; n++) {
                duty[n] = 0.5 + swing * plant_noise_next(&noise);
            }
            plant_write(&plant, duty, (k / 50) % 3 != 2);
            plant_advance(&plant);
            const plant_truth_t t = truth_of(&plant);
            throughput_J +=
                fabs(t.energy.bus_J - last.bus_J) + fabs(t.energy.shaft_J - last.shaft_J);
            last = t.energy;
            fewest_left = plant.events_left < fewest_left ? plant.events_left : fewest_left;
            TEST_ASSERT_TRUE(isfinite(t.id_A) && isfinite(t.iq_A) && isfinite(t.omega_m_rad_s));
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, t.i_abc_A[0] + t.i_abc_A[1] + t.i_abc_A[2]);
            TEST_ASSERT_TRUE(t.theta_e_rad > -PI && t.theta_e_rad <= PI);
        }
        const plant_energy_t e = truth_of(&plant).energy;
        TEST_ASSERT_TRUE(e.copper_J >= 0.0 && e.friction_J >= 0.0 && e.inverter_J >= -1e-9);
        worst = fmax(worst, fabs(balance_error_J(&e, start_J)) / throughput_J);
    }
    printf("  random motors: worst energy error %.1e, most events in a period %d\n", worst,
           200 - fewest_left);
    TEST_ASSERT_TRUE(worst < 5e-4); // half of the 0.1 % promised
    TEST_ASSERT_TRUE(fewest_left > 100);
}

// ---------------------------------------------------------------------------------------------
// Inverter

/// Locked rotor, direct current of 10 A in phase a: signs are (+, -, -) throughout.
static plant_truth_t direct_current(const plant_config_t *c, double *u_alpha) {
    plant_t plant = new_plant(c);
    *u_alpha = 0.0;
    for (int k = 0; k < 400; k++) {
        const double i = truth_of(&plant).i_alpha_A;
        *u_alpha += 0.3 * (10.0 - i);
        write_voltage(&plant, *u_alpha + 3.0 * (10.0 - i), 0.0);
        plant_advance(&plant);
    }
    const plant_truth_t t = truth_of(&plant);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 10.0, t.i_alpha_A); // settled
    return t;
}

/// Each leg loses Td f Vbus against its current; Clarke of (+1, -1, -1) is 4/3 on alpha. Exact
/// while no current changes sign, so only rounding and the controller's last 1e-6 A are allowed.
static void test_dead_time_voltage_loss(void) {
    plant_config_t c = bench_config();
    c.level = PLANT_SWITCHING;
    const double dead_times[3] = {0.0, 1e-6, 4e-6};
    for (int n = 0; n < 3; n++) {
        double u_alpha;
        c.dead_time_s = dead_times[n];
        const plant_truth_t t = direct_current(&c, &u_alpha);
        const double loss = 4.0 / 3.0 * c.dead_time_s / c.period_s * c.v_bus_V;
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, u_alpha - loss, t.u_alpha_V);
        // What 10 A need in the winding. The dead time moves the pulses off the centre by half of
        // itself, so the sample differs from the mean current by up to 4 mA.
        TEST_ASSERT_DOUBLE_WITHIN(4e-3, 7.5, t.u_alpha_V);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, t.u_beta_V);
    }
}

/// Drops: i > 0 flows through the transistor for the realised duty, through the diode otherwise;
/// i < 0 the other way round. The on-state resistance adds to the winding's.
static void test_conduction_drops(void) {
    plant_config_t c = bench_config();
    c.level = PLANT_SWITCHING;
    c.v_transistor_V = 2.0;
    c.v_diode_V = 0.7;
    c.r_on_Ohm = 0.1;
    double u_alpha, duty[3];
    const plant_truth_t t = direct_current(&c, &u_alpha);
    const double lost = c.dead_time_s / c.period_s;
    duties(u_alpha, 0.0, c.v_bus_V, duty);
    double v[3]; // i_a = 10, i_b = i_c = -5
    const double high_a = duty[0] - lost, high_b = duty[1] + lost;
    v[0] = high_a * (200.0 - 2.0) + (1.0 - high_a) * -0.7 - 0.1 * 10.0;
    v[1] = high_b * (200.0 + 0.7) + (1.0 - high_b) * 2.0 + 0.1 * 5.0;
    v[2] = v[1];
    // The 1e-6 A of the controller times its gains, and ripple times r_on: below 1 mV.
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, (2.0 * v[0] - v[1] - v[2]) / 3.0, t.u_alpha_V);
}

static void test_duty_is_quantised(void) {
    for (int level = 0; level < 2; level++) {
        plant_config_t c = bench_config();
        c.level = level == 0 ? PLANT_AVERAGED : PLANT_SWITCHING;
        c.dead_time_s = 0.0;
        c.pwm_ticks = 100;
        plant_t plant = new_plant(&c);
        // Nearest step, and the ends: 0.517 -> 0.52, 0.474 -> 0.47, 0.5049 -> 0.50.
        const double duty[3] = {0.517, 0.474, 0.5049};
        plant_write(&plant, duty, true);
        advance(&plant, 2);
        const plant_truth_t t = truth_of(&plant);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 200.0 * (2.0 * 0.52 - 0.47 - 0.50) / 3.0, t.u_alpha_V);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 200.0 * (0.47 - 0.50) / SQRT3, t.u_beta_V);
    }
}

/// Without quantisation nothing is rounded; outside 0..1 and NaN go to an end.
static void test_duty_range(void) {
    plant_config_t c = bench_config();
    plant_t plant = new_plant(&c);
    const double fine[3] = {0.5000001, 0.5, 0.5};
    plant_write(&plant, fine, true);
    advance(&plant, 2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 200.0 * 2e-7 / 3.0, truth_of(&plant).u_alpha_V);
    const double wild[3] = {1.5, -0.5, not_a_number};
    plant_write(&plant, wild, true);
    advance(&plant, 2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 400.0 / 3.0, truth_of(&plant).u_alpha_V);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, truth_of(&plant).u_beta_V);
}

/// Phase a should carry 0.3 A by its voltage, but the dead time eats that: its current stops at
/// zero in each dead time and the phase floats. Without dead time it flows.
static void test_zero_current_clamping(void) {
    double at_sample[2];
    int exact_zeros = 0;
    for (int n = 0; n < 2; n++) {
        plant_config_t c = bench_config();
        c.level = PLANT_SWITCHING;
        c.dead_time_s = n == 0 ? 0.0 : 4e-6;
        plant_t plant = new_plant(&c);
        start_with_voltage(&plant, 0.3, 8.0);
        double sum = 0.0;
        for (int k = 0; k < 600; k++) {
            plant_advance(&plant);
            const double i_a = truth_of(&plant).i_abc_A[0];
            sum += k >= 400 ? i_a / 200.0 : 0.0;
            exact_zeros += n == 1 && k >= 400 && fabs(i_a) < 1e-12;
        }
        at_sample[n] = sum;
    }
    // 0.3 V over 0.75 ohm; 1 % for the ripple between the sample and the mean.
    TEST_ASSERT_DOUBLE_WITHIN(4e-3, 0.4, at_sample[0]);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.0, at_sample[1]); // an eighth of what would flow
    TEST_ASSERT_TRUE(exact_zeros > 100);                // held, not merely small
}

/// Never both gates of a leg, always the whole dead time between them, order of time kept: also
/// across periods, for pulses shorter than the dead time, and after gates off.
static void check_gate_edges(bool double_update) {
    const double period = 200e-6, dead = 4e-6;
    const double corner[8] = {0.0, 1.0, 0.005, 0.995, 0.02, 0.98, 0.5, 0.039};
    plant_noise_t noise;
    plant_pwm_t pwm;
    double off_since = -1.0, last = -1.0, high_time = 0.0;
    plant_gate_t before = PLANT_GATE_OFF;
    plant_noise_init(&noise, 7);
    plant_pwm_init(&pwm, double_update);
    for (int k = 0; k < 20000; k++) {
        const double pick = fabs(plant_noise_next(&noise));
        const double duty = pick < 1.0 ? corner[(int)(8.0 * pick)] : fmin(pick - 1.0, 1.0);
        const bool on = fabs(plant_noise_next(&noise)) < 1.9;
        plant_pwm_schedule(&pwm, (plant_duty_t){duty, duty}, on, period, dead);
        TEST_ASSERT_TRUE(pwm.edges <= PLANT_EDGES);
        for (int n = 0; n < pwm.edges; n++) {
            const double now = k * period + pwm.edge[n].at_s;
            const plant_gate_t gate = pwm.edge[n].gate;
            TEST_ASSERT_TRUE(pwm.edge[n].at_s >= 0.0 && pwm.edge[n].at_s < period);
            TEST_ASSERT_TRUE(now >= last - 1e-12);
            TEST_ASSERT_FALSE(gate != PLANT_GATE_OFF && before != PLANT_GATE_OFF);
            if (gate != PLANT_GATE_OFF) {
                TEST_ASSERT_TRUE(now - off_since > dead - 1e-9); // rounding of a time near 4 s
            } else if (before != PLANT_GATE_OFF || n == 0) {
                off_since = fmax(off_since, before != PLANT_GATE_OFF ? now : off_since);
                high_time += before == PLANT_GATE_HIGH ? now - last : 0.0;
            }
            before = gate;
            last = now;
        }
        TEST_ASSERT_EQUAL(pwm.edges, (plant_pwm_apply(&pwm, period), pwm.next));
        TEST_ASSERT_TRUE(on || pwm.gate == PLANT_GATE_OFF);
    }
    TEST_ASSERT_TRUE(high_time > 0.1);
}

static void test_gate_edges(void) {
    check_gate_edges(false);
    check_gate_edges(true);
}

/// With double update the pulse is at the end of one half and at the beginning of the other: the edge between them
/// is none, and each half has the dead time of one edge.
static void test_double_update(void) {
    const double at[2][2] = {{75e-6, 77e-6}, {25e-6, 27e-6}};
    const plant_gate_t last[2] = {PLANT_GATE_HIGH, PLANT_GATE_LOW};
    plant_pwm_t pwm;
    plant_pwm_init(&pwm, true);
    for (int half = 0; half < 4; half++) {
        plant_pwm_schedule(&pwm, (plant_duty_t){0.25, 0.25}, true, 100e-6, 2e-6);
        (void)plant_pwm_apply(&pwm, 100e-6);
        if (half >= 2) { // both begin with no gate on
            TEST_ASSERT_EQUAL(2, pwm.edges);
            TEST_ASSERT_EQUAL(PLANT_GATE_OFF, pwm.edge[0].gate);
            TEST_ASSERT_EQUAL(last[half % 2], pwm.edge[1].gate);
            TEST_ASSERT_DOUBLE_WITHIN(1e-15, at[half % 2][0], pwm.edge[0].at_s);
            TEST_ASSERT_DOUBLE_WITHIN(1e-15, at[half % 2][1], pwm.edge[1].at_s);
        }
    }
    // No duty, and all of it: no edges, whatever the half.
    for (int all = 0; all < 2; all++) {
        for (int half = 0; half < 4; half++) {
            plant_pwm_schedule(&pwm, (plant_duty_t){all, all}, true, 100e-6, 2e-6);
            (void)plant_pwm_apply(&pwm, 100e-6);
            TEST_ASSERT_EQUAL(half == 0 ? pwm.edges : 0, pwm.edges);
        }
        TEST_ASSERT_EQUAL(all ? PLANT_GATE_HIGH : PLANT_GATE_LOW, pwm.gate);
    }
}

/// The high side is on in the middle of the period: realised by the edges themselves.
static void test_pwm_is_centred(void) {
    plant_pwm_t pwm;
    plant_pwm_init(&pwm, false);
    plant_pwm_schedule(&pwm, (plant_duty_t){0.25, 0.25}, true, 100e-6, 2e-6);
    plant_pwm_schedule(&pwm, (plant_duty_t){0.25, 0.25}, true, 100e-6, 2e-6);
    TEST_ASSERT_EQUAL(4, pwm.edges);
    const double at[4] = {37.5e-6, 39.5e-6, 62.5e-6, 64.5e-6};
    const plant_gate_t gate[4] = {PLANT_GATE_OFF, PLANT_GATE_HIGH, PLANT_GATE_OFF, PLANT_GATE_LOW};
    for (int n = 0; n < 4; n++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, at[n], pwm.edge[n].at_s);
        TEST_ASSERT_EQUAL(gate[n], pwm.edge[n].gate);
    }
}

/// A dead time that began at the end of a period ends in the next one.
static void test_dead_time_carries_over(void) {
    plant_pwm_t pwm;
    plant_pwm_init(&pwm, false);
    plant_pwm_schedule(&pwm, (plant_duty_t){0.98, 0.98}, true, 100e-6, 2e-6); // falls at 99 us
    plant_pwm_schedule(&pwm, (plant_duty_t){0.50, 0.50}, true, 100e-6, 2e-6);
    TEST_ASSERT_EQUAL(5, pwm.edges);
    TEST_ASSERT_EQUAL(PLANT_GATE_LOW, pwm.edge[0].gate);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1e-6, pwm.edge[0].at_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 25e-6, pwm.edge[1].at_s);
    // From full duty the low side waits from the boundary on.
    plant_pwm_schedule(&pwm, (plant_duty_t){1.0, 1.0}, true, 100e-6, 2e-6);
    plant_pwm_schedule(&pwm, (plant_duty_t){0.0, 0.0}, true, 100e-6, 2e-6);
    TEST_ASSERT_EQUAL(2, pwm.edges);
    TEST_ASSERT_EQUAL(PLANT_GATE_OFF, pwm.edge[0].gate);
    TEST_ASSERT_EQUAL(PLANT_GATE_LOW, pwm.edge[1].gate);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 2e-6, pwm.edge[1].at_s);
}

/// Turning motor and currents by 120 degrees permutes the phases and changes nothing else.
static void test_phases_are_alike(void) {
    plant_config_t c = lossy_config();
    plant_t first = new_plant(&c);
    c.theta_e_rad += 2.0 * PI / 3.0;
    plant_t second = new_plant(&c);
    for (int k = 0; k < 300; k++) {
        control_current(&first, &c, -1.0, k < 150 ? 2.0 : 0.0);
        const double *d = first.next_duty;
        const double turned[3] = {d[2], d[0], d[1]};
        plant_write(&second, turned, true);
        plant_advance(&first);
        plant_advance(&second);
    }
    // Rounding, magnified by 300 periods of zero crossings: far below any real asymmetry.
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, truth_of(&first).id_A, truth_of(&second).id_A);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, truth_of(&first).iq_A, truth_of(&second).iq_A);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, truth_of(&first).i_abc_A[0], truth_of(&second).i_abc_A[1]);
}

// ---------------------------------------------------------------------------------------------
// Timing

static void test_duty_acts_one_period_late(void) {
    for (int level = 0; level < 2; level++) {
        plant_config_t c = bench_config();
        c.level = level == 0 ? PLANT_AVERAGED : PLANT_SWITCHING;
        plant_t plant = new_plant(&c);
        start_with_voltage(&plant, 0.0, 0.0);
        plant_advance(&plant);
        plant_t other = plant; // a copy is an independent plant
        write_voltage(&plant, 40.0, 10.0);
        write_voltage(&other, -40.0, 20.0);
        plant_advance(&plant);
        plant_advance(&other);
        TEST_ASSERT_EQUAL_MEMORY(&plant.motor, &other.motor, sizeof plant.motor); // t_k+1: none
        plant_advance(&plant);
        plant_advance(&other);
        TEST_ASSERT_TRUE(truth_of(&plant).i_alpha_A > 1.0); // t_k+2: 40 V in 3.5 mH
        TEST_ASSERT_TRUE(truth_of(&other).i_alpha_A < -1.0);
    }
}

/// Both edges of it.
static void test_duty_without_a_shadow_acts_at_once(void) {
    for (int level = 0; level < 2; level++) {
        plant_config_t c = bench_config();
        c.level = level == 0 ? PLANT_AVERAGED : PLANT_SWITCHING;
        plant_t shadowed = new_plant(&c);
        start_with_voltage(&shadowed, 0.0, 0.0);
        plant_advance(&shadowed);
        plant_t through = shadowed;
        write_voltage(&shadowed, 40.0, 10.0);
        plant_advance(&shadowed);
        plant_advance(&shadowed);
        write_voltage(&through, 40.0, 10.0);
        plant_write_through(&through);
        plant_advance(&through);
        TEST_ASSERT_TRUE(truth_of(&through).i_alpha_A > 1.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, truth_of(&shadowed).i_alpha_A,
                                  truth_of(&through).i_alpha_A);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, truth_of(&shadowed).i_beta_A, truth_of(&through).i_beta_A);
    }
}

/// The shadowed voltage loses to gates off at once; gates on comes with its duties a period later.
static void test_gates_off_acts_at_once(void) {
    for (int level = 0; level < 2; level++) {
        plant_config_t c = bench_config();
        c.level = level == 0 ? PLANT_AVERAGED : PLANT_SWITCHING;
        plant_t plant = new_plant(&c);
        start_with_voltage(&plant, 40.0, 0.0);
        advance(&plant, 5);
        const double peak = truth_of(&plant).i_alpha_A;
        TEST_ASSERT_TRUE(peak > 8.0);
        const double duty[3] = {0.9, 0.1, 0.1};
        plant_write(&plant, duty, false);
        plant_advance(&plant);
        // 133 V of the bus against the current through 3.5 mH: 7.6 A per period.
        TEST_ASSERT_DOUBLE_WITHIN(0.6, peak - 7.6, truth_of(&plant).i_alpha_A);
        advance(&plant, 3);
        TEST_ASSERT_TRUE(truth_of(&plant).i_alpha_A == 0.0); // blocked, not reversed
        plant_write(&plant, duty, true);
        plant_advance(&plant);
        TEST_ASSERT_TRUE(truth_of(&plant).i_alpha_A == 0.0);
        plant_advance(&plant);
        TEST_ASSERT_TRUE(truth_of(&plant).i_alpha_A > 4.0);
    }
}

static void test_trip_cuts_the_gates_and_is_seen(void) {
    plant_config_t c = bench_config();
    plant_t plant = new_plant(&c);
    plant_counts_t counts;
    start_with_voltage(&plant, 10.0, 0.0);
    plant_advance(&plant);
    plant_sample(&plant, &counts, NULL);
    TEST_ASSERT_FALSE(counts.trip);
    plant_set_trip(&plant, true);
    plant_sample(&plant, &counts, NULL);
    TEST_ASSERT_TRUE(counts.trip);
    write_voltage(&plant, 10.0, 0.0);
    plant_advance(&plant); // off at once: the bus takes half an ampere in a tenth of a period
    TEST_ASSERT_TRUE(truth_of(&plant).i_alpha_A == 0.0);
    advance(&plant, 3);
    TEST_ASSERT_TRUE(truth_of(&plant).i_alpha_A == 0.0);
    plant_set_trip(&plant, false);
    advance(&plant, 3);
    TEST_ASSERT_TRUE(truth_of(&plant).i_alpha_A > 0.5); // the last write is in force again
}

static void test_bus_can_change(void) {
    plant_config_t c = bench_config();
    plant_t plant = new_plant(&c);
    start_with_voltage(&plant, 10.0, 0.0);
    plant_set_bus(&plant, 100.0);
    plant_advance(&plant);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 5.0, truth_of(&plant).u_alpha_V);
    plant_counts_t counts;
    plant_sample(&plant, &counts, NULL);
    TEST_ASSERT_EQUAL(1000, counts.v_bus);
}

// ---------------------------------------------------------------------------------------------
// Harmonics and torque

/// Amplitude of the n-th harmonic of a record over whole turns.
static double harmonic(const double *x, const double *theta, int count, int n) {
    double re = 0.0, im = 0.0;
    for (int k = 0; k < count; k++) {
        re += x[k] * cos(n * theta[k]);
        im += x[k] * sin(n * theta[k]);
    }
    return 2.0 * hypot(re, im) / count;
}

enum { TURN = 360 };

/// EMF of the harmonics in a phase, V, straight from the configuration's definition.
static double harmonic_emf(const plant_config_t *c, double theta, double w) {
    return -w * c->psi_Wb *
           (c->emf5_ratio * sin(5.0 * theta + c->emf5_phase_rad) +
            c->emf7_ratio * sin(7.0 * theta + c->emf7_phase_rad));
}

static void test_harmonics(void) {
    static double e_alpha[TURN], torque[TURN], theta[TURN];
    plant_config_t c = bench_config();
    c.emf5_ratio = 0.08;
    c.emf5_phase_rad = 0.5;
    c.emf7_ratio = 0.03;
    c.emf7_phase_rad = -0.9;
    // One electrical turn in exactly TURN periods.
    c.omega_m_rad_s = 2.0 * PI / ((double)TURN * c.period_s * 3.0);
    plant_t plant = new_plant(&c);
    const double w = 3.0 * c.omega_m_rad_s, w_psi = w * c.psi_Wb;
    for (int k = 0; k < 3 * TURN; k++) {
        control_current(&plant, &c, 0.0, 8.0);
        plant_advance(&plant);
        const plant_truth_t t = truth_of(&plant);
        // The share of id in the active flux comes off: the current loop lets some id through.
        const double e_id = -w * (c.Ld_H - c.Lq_H) * t.id_A * sin(t.theta_e_rad);
        const double e = -w_psi * sin(t.theta_e_rad) + harmonic_emf(&c, t.theta_e_rad, w);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, e, t.e_alpha_V - e_id); // a definition: rounding only
        // Power of the phases' harmonic EMFs is power of the shaft.
        double power = 1.5 * w * (c.psi_Wb + (c.Ld_H - c.Lq_H) * t.id_A) * t.iq_A;
        for (int n = 0; n < 3; n++) {
            power += harmonic_emf(&c, t.theta_e_rad - 2.0 * PI / 3.0 * n, w) * t.i_abc_A[n];
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, power, t.torque_Nm * t.omega_m_rad_s);
        e_alpha[k % TURN] = t.e_alpha_V - e_id;
        theta[k % TURN] = t.theta_e_rad;
        torque[k % TURN] = t.torque_Nm;
    }
    // A sum over exactly one turn: rounding only.
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.08 * w_psi, harmonic(e_alpha, theta, TURN, 5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.03 * w_psi, harmonic(e_alpha, theta, TURN, 7));
    // 5th and 7th both end as 6th in the torque: r7 exp(j p7) - r5 exp(-j p5) as phasors. The loop
    // also lets 6th-order current through, whose torque is a tenth to a third of that.
    const double expected =
        1.5 * 3.0 * c.psi_Wb * 8.0 *
        hypot(0.03 * cos(0.9) - 0.08 * cos(0.5), -0.03 * sin(0.9) + 0.08 * sin(0.5));
    TEST_ASSERT_DOUBLE_WITHIN(0.4 * expected, expected, harmonic(torque, theta, TURN, 6));
    TEST_ASSERT_TRUE(harmonic(torque, theta, TURN, 5) < 0.01 * expected);
}

/// Mean terminal voltage of an open machine: the change of the harmonic flux too.
static void test_harmonics_of_an_open_machine(void) {
    plant_config_t c = bench_config();
    c.level = PLANT_SWITCHING;
    c.emf5_ratio = 0.1;
    c.emf7_ratio = 0.05;
    c.emf7_phase_rad = 0.8;
    c.omega_m_rad_s = 100.0;
    plant_t plant = new_plant(&c);
    for (int k = 0; k < 50; k++) {
        const double a = truth_of(&plant).theta_e_rad;
        plant_advance(&plant);
        const double b = a + 300.0 * c.period_s;
        const double flux = cos(b) - cos(a) + 0.1 / 5.0 * (cos(5.0 * b) - cos(5.0 * a)) +
                            0.05 / 7.0 * (cos(7.0 * b + 0.8) - cos(7.0 * a + 0.8));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, c.psi_Wb * flux / c.period_s, truth_of(&plant).u_alpha_V);
        TEST_ASSERT_TRUE(truth_of(&plant).torque_Nm == 0.0);
    }
}

/// q flux of a direct current against the documented law, by integrating the voltage.
static void test_saturation_law(void) {
    plant_config_t c = bench_config();
    c.theta_e_rad = 0.5 * PI; // phase a on q
    c.i_sat_A = 6.0;
    c.Lq_sat_H = 2.5e-3;
    const double signs[2] = {1.0, -1.0};
    for (int n = 0; n < 2; n++) {
        plant_t plant = new_plant(&c);
        double flux = 0.0;
        start_with_voltage(&plant, -signs[n] * 9.0, 0.0); // q points along -alpha at 90 degrees
        for (int k = 0; k < 100; k++) {
            const plant_truth_t before = truth_of(&plant);
            plant_advance(&plant);
            const plant_truth_t t = truth_of(&plant);
            flux += c.period_s * (-t.u_alpha_V - c.Rs_Ohm * 0.5 * (before.iq_A + t.iq_A));
            const double law = t.iq_A * (2.5e-3 + 7.3e-3 / (1.0 + fabs(t.iq_A) / 6.0));
            // The trapezoid's error at 200 us against a 5 ms time constant: below 1e-4 of the flux.
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, law, flux);
        }
        TEST_ASSERT_TRUE(signs[n] * truth_of(&plant).iq_A > 9.0); // well into saturation
    }
}

// ---------------------------------------------------------------------------------------------
// Shaft

static void test_coast_down_time_constant(void) {
    plant_config_t c = bench_config();
    c.speed_is_prescribed = false;
    c.B_Nms = 0.02;
    c.omega_m_rad_s = 80.0;
    c.level = PLANT_SWITCHING;
    plant_t plant = new_plant(&c);
    for (int k = 1; k <= 5000; k++) {
        plant_advance(&plant);
        const double omega = 80.0 * exp(-c.B_Nms / c.J_kgm2 * k * c.period_s);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, omega, truth_of(&plant).omega_m_rad_s); // rounding
    }
    // The angle is the integral, wrapped.
    const double turned = 3.0 * 80.0 * c.J_kgm2 / c.B_Nms * (1.0 - exp(-c.B_Nms / c.J_kgm2 * 1.0));
    const double error = truth_of(&plant).theta_e_rad - turned;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, error - 2.0 * PI * floor(error / (2.0 * PI) + 0.5));
}

/// Dry friction brakes at Nm/J and then holds; it never turns the shaft round. An active load does.
static void test_passive_and_active_load(void) {
    plant_config_t c = bench_config();
    c.speed_is_prescribed = false;
    c.B_Nms = 0.0;
    c.omega_m_rad_s = -20.0;
    c.load_Nm = 2.0;
    plant_t passive = new_plant(&c);
    c.load_is_passive = false;
    plant_t active = new_plant(&c);
    advance(&passive, 500);
    advance(&active, 500);
    const double change = 2.0 / c.J_kgm2 * 0.1;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -20.0 + change, truth_of(&passive).omega_m_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -20.0 - change, truth_of(&active).omega_m_rad_s);
    advance(&passive, 1000);
    TEST_ASSERT_TRUE(truth_of(&passive).omega_m_rad_s == 0.0);
    const double theta = truth_of(&passive).theta_e_rad;
    advance(&passive, 100);
    TEST_ASSERT_TRUE(truth_of(&passive).theta_e_rad == theta);
    // All kinetic energy went into the load, the last bit of a step included.
    const plant_energy_t e = truth_of(&passive).energy;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * c.J_kgm2 * 400.0, e.load_J);
}

/// A shaft that coasts, gates off.
static plant_config_t coasting(void) {
    plant_config_t c = bench_config();
    c.speed_is_prescribed = false;
    c.B_Nms = 0.0;
    c.omega_m_rad_s = 80.0;
    c.load_is_passive = false;
    return c;
}

/// dw/dt = -F/J w^2 has w0/(1 + F w0 t/J) as its solution, in either sense of rotation.
static void test_fan_law(void) {
    plant_config_t c = coasting();
    c.fan_Nms2 = 2e-4;
    for (int direction = -1; direction <= 1; direction += 2) {
        c.omega_m_rad_s = 80.0 * direction;
        plant_t plant = new_plant(&c);
        for (int k = 1; k <= 5000; k++) {
            plant_advance(&plant);
            const double omega =
                c.omega_m_rad_s / (1.0 + c.fan_Nms2 / c.J_kgm2 * 80.0 * k * c.period_s);
            TEST_ASSERT_DOUBLE_WITHIN(2e-3, omega, truth_of(&plant).omega_m_rad_s);
        }
    }
}

/// Mechanical angle gone through since the start, from the wrapped electrical one.
static double mechanical_angle(const plant_truth_t *now, const plant_truth_t *before, double at) {
    const double turned = now->theta_e_rad - before->theta_e_rad;
    return at + remainder(turned, 2.0 * PI) / 3.0;
}

/// The work of T (1 + r cos a) is T (a + r sin a); of C sin(n a) it is C/n (1 - cos(n a)).
static void check_work_over_angle(const plant_config_t *c) {
    plant_t plant = new_plant(c);
    plant_truth_t before = truth_of(&plant);
    double angle = 0.0;
    for (int k = 0; k < 2000; k++) {
        plant_advance(&plant);
        const plant_truth_t now = truth_of(&plant);
        angle = mechanical_angle(&now, &before, angle);
        before = now;
        const double cogging = c->cogging_Nm > 0.0 ? c->cogging_Nm / c->cogging_per_turn *
                                                         (1.0 - cos(c->cogging_per_turn * angle))
                                                   : 0.0;
        const double work = c->load_Nm * (angle + c->load_ripple * sin(angle)) + cogging;
        const double omega2 = c->omega_m_rad_s * c->omega_m_rad_s - 2.0 * work / c->J_kgm2;
        TEST_ASSERT_DOUBLE_WITHIN(5e-3, sqrt(omega2), now.omega_m_rad_s);
    }
    TEST_ASSERT_TRUE(angle > 4.0 * PI); // through several turns, so that they were told apart
}

static void test_ripple_once_per_turn(void) {
    plant_config_t c = coasting();
    c.load_Nm = 0.5;
    c.load_ripple = 0.6;
    check_work_over_angle(&c);
}

static void test_cogging_over_the_angle(void) {
    plant_config_t c = coasting();
    c.cogging_Nm = 0.8;
    c.cogging_per_turn = 7.0; // no multiple of the pole pairs: the mechanical angle counts
    check_work_over_angle(&c);
}

/// Cogging pulls at a shaft at rest: it stays up to friction plus stiction, and beyond them begins with
/// what is above friction alone.
static void test_stiction_holds_and_lets_go(void) {
    plant_config_t c = coasting();
    c.omega_m_rad_s = 0.0;
    c.load_is_passive = true;
    c.load_Nm = 0.5;
    c.stiction_Nm = 0.4;
    c.cogging_per_turn = 3.0;
    c.theta_e_rad = -0.5 * PI; // a quarter of cogging's period
    c.cogging_Nm = 0.89;
    plant_t held = new_plant(&c);
    advance(&held, 100);
    TEST_ASSERT_TRUE(truth_of(&held).omega_m_rad_s == 0.0);
    c.cogging_Nm = 0.91;
    plant_t loose = new_plant(&c);
    plant_advance(&loose);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, (0.91 - 0.5) / c.J_kgm2 * c.period_s,
                              truth_of(&loose).omega_m_rad_s);
}

/// Two masses, pushed apart by their speeds, swing at sqrt(K (1/J1 + 1/J2)) about their common speed.
static void test_two_masses_swing(void) {
    plant_config_t c = coasting();
    c.load_J_kgm2 = 2.0 * c.J_kgm2;
    c.shaft_Nm_rad = 100.0;
    plant_t plant = new_plant(&c);
    plant.motor.x.load_omega_rad_s = 60.0;
    const double mean = (80.0 + 2.0 * 60.0) / 3.0;
    const double swing = sqrt(c.shaft_Nm_rad * 1.5 / c.J_kgm2);
    for (int k = 1; k <= 2000; k++) {
        plant_advance(&plant);
        const double away = 20.0 * cos(swing * k * c.period_s);
        TEST_ASSERT_DOUBLE_WITHIN(0.2, mean + 2.0 / 3.0 * away, truth_of(&plant).omega_m_rad_s);
        const double momentum =
            truth_of(&plant).omega_m_rad_s + 2.0 * plant.motor.x.load_omega_rad_s;
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 200.0, momentum);
    }
}

/// Inside the gap neither mass feels the other; it is crossed at the difference of the speeds. The damped
/// shaft then brings both to the common speed, and friction on the second mass holds both at last.
static void test_backlash_and_friction_behind_it(void) {
    plant_config_t c = coasting();
    c.load_J_kgm2 = 2.0 * c.J_kgm2;
    c.shaft_Nm_rad = 1000.0;
    c.shaft_Nms_rad = 1.0;
    c.backlash_rad = 0.2;
    plant_t plant = new_plant(&c);
    plant.motor.x.load_omega_rad_s = 60.0;
    const int gap = (int)(0.1 / 20.0 / c.period_s); // from the middle to a flank
    advance(&plant, gap - 1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 80.0, truth_of(&plant).omega_m_rad_s);
    advance(&plant, 11);
    TEST_ASSERT_TRUE(truth_of(&plant).omega_m_rad_s < 79.0);
    advance(&plant, 5000);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 200.0 / 3.0, plant.motor.x.load_omega_rad_s);
    c.load_is_passive = true;
    c.load_Nm = 5.0;
    c.load_ripple = 0.0;
    plant_t braked = new_plant(&c);
    advance(&braked, 5000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, braked.motor.x.load_omega_rad_s);
}

/// A dynamometer stands no load of any kind.
static void test_dynamometer_overrules_loads(void) {
    plant_config_t c = coasting();
    c.fan_Nms2 = 1e-3;
    c.cogging_Nm = 1.0;
    c.cogging_per_turn = 6.0;
    c.speed_is_prescribed = true;
    plant_t plant = new_plant(&c);
    advance(&plant, 100);
    TEST_ASSERT_TRUE(truth_of(&plant).omega_m_rad_s == 80.0);
}

/// Locked by a load above the motor's torque, released by one below it.
static void test_passive_load_holds_at_standstill(void) {
    plant_config_t c = bench_config();
    c.speed_is_prescribed = false;
    c.theta_e_rad = -0.5 * PI; // current in phase a is q current, positive
    c.load_Nm = -3.0;          // the sign does not matter
    plant_t plant = new_plant(&c);
    start_with_voltage(&plant, 3.0, 0.0);
    advance(&plant, 1500); // 23 time constants: rounding only
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5 * 3.0 * 0.142 * 4.0, truth_of(&plant).torque_Nm);
    TEST_ASSERT_TRUE(truth_of(&plant).omega_m_rad_s == 0.0);
    TEST_ASSERT_TRUE(truth_of(&plant).energy.load_J == 0.0);
    plant_set_load(&plant, 1.0);
    advance(&plant, 20);
    TEST_ASSERT_TRUE(truth_of(&plant).omega_m_rad_s > 0.3); // (2.56 - 1) Nm for 4 ms
}

static void test_dynamometer(void) {
    plant_config_t c = bench_config();
    c.speed_is_prescribed = false;
    c.B_Nms = 0.01;
    plant_t plant = new_plant(&c);
    plant_set_speed(&plant, 50.0);
    advance(&plant, 100);
    TEST_ASSERT_TRUE(truth_of(&plant).omega_m_rad_s == 50.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 150.0, truth_of(&plant).omega_e_rad_s);
    const plant_energy_t e = truth_of(&plant).energy;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, balance_error_J(&e, 0.0)); // it paid for jump and friction
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -0.5 * c.J_kgm2 * 2500.0 - 0.01 * 2500.0 * 0.02, e.load_J);
    plant_set_speed(&plant, 80.0);
    plant_set_speed(&plant, 50.0); // gets back what the jump up took
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, e.load_J, truth_of(&plant).energy.load_J);
    plant_release_speed(&plant);
    advance(&plant, 100);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 50.0 * exp(-0.01 / c.J_kgm2 * 0.02),
                              truth_of(&plant).omega_m_rad_s);
}

// ---------------------------------------------------------------------------------------------
// ADCs

/// A plant that carries 8, -4, -4 A and stays there.
static plant_t carrying_8_A(const plant_config_t *c) {
    plant_t plant = new_plant(c);
    start_with_voltage(&plant, 6.0, 0.0);
    advance(&plant, 600); // 26 time constants
    return plant;
}

static void test_adc_scale_offset_and_gain(void) {
    plant_config_t c = bench_config();
    c.i_offset_A[0] = 0.5;
    c.i_offset_A[1] = -0.25;
    c.i_gain_error[1] = 0.1;
    c.i_gain_error[2] = -0.05;
    c.temperature_degC = 61.7;
    plant_t plant = carrying_8_A(&c);
    plant_counts_t counts;
    plant_sample(&plant, &counts, NULL);
    const double per_A = 4096.0 / 50.0;
    // Exact: the nearest count of gain times current plus offset.
    TEST_ASSERT_EQUAL(2048 + (int)floor(8.5 * per_A + 0.5), counts.i[0]);
    TEST_ASSERT_EQUAL(2048 + (int)floor((-4.4 - 0.25) * per_A + 0.5), counts.i[1]);
    TEST_ASSERT_EQUAL(2048 + (int)floor(-3.8 * per_A + 0.5), counts.i[2]);
    TEST_ASSERT_EQUAL(2000, counts.v_bus);
    TEST_ASSERT_EQUAL(1117, counts.temperature);
    plant_set_temperature(&plant, -80.0);
    plant_sample(&plant, &counts, NULL);
    TEST_ASSERT_EQUAL(0, counts.temperature);
}

static void test_adc_saturates(void) {
    plant_config_t c = bench_config();
    c.i_A_per_count = 5.0 / 1024.0; // +-2.5 A
    c.adc_bits = 10;
    plant_t plant = carrying_8_A(&c);
    plant_counts_t counts;
    plant_sample(&plant, &counts, NULL);
    TEST_ASSERT_EQUAL(1023, counts.i[0]);
    TEST_ASSERT_EQUAL(0, counts.i[1]);
    TEST_ASSERT_EQUAL(1023, counts.v_bus);
    c.adc_bits = 16;
    plant = carrying_8_A(&c);
    plant_sample(&plant, &counts, NULL);
    TEST_ASSERT_EQUAL(32768 + (int)floor(8.0 / 5.0 * 1024.0 + 0.5), counts.i[0]);
}

static void test_adc_noise_statistics(void) {
    const int draws = 40000;
    plant_config_t c = bench_config();
    c.adc_bits = 16;
    c.i_A_per_count = 1e-3;
    c.i_noise_A = 0.05;
    c.v_bus_noise_V = 0.7;
    c.seed = 42;
    plant_t plant = carrying_8_A(&c);
    double sum[3] = {0}, square[3] = {0}, v_sum = 0.0, v_square = 0.0, cross = 0.0, fourth = 0.0;
    for (int k = 0; k < draws; k++) {
        plant_counts_t counts;
        plant_sample(&plant, &counts, NULL);
        double e[3];
        for (int n = 0; n < 3; n++) {
            e[n] = (counts.i[n] - 32768.0) * 1e-3 - (n == 0 ? 8.0 : -4.0);
            sum[n] += e[n];
            square[n] += e[n] * e[n];
        }
        const double v = counts.v_bus * 0.1 - 200.0;
        v_sum += v;
        v_square += v * v;
        cross += e[0] * e[1];
        fourth += pow(e[2], 4.0);
    }
    // Standard errors: mean s/sqrt(N) = 0.5 %, rms s/sqrt(2N) = 0.35 %, correlation 0.5 %,
    // kurtosis sqrt(24/N) = 0.024; five of each.
    for (int n = 0; n < 3; n++) {
        TEST_ASSERT_DOUBLE_WITHIN(0.025 * 0.05, 0.0, sum[n] / draws);
        TEST_ASSERT_DOUBLE_WITHIN(0.018 * 0.05, 0.05, sqrt(square[n] / draws));
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.025 * 0.7, 0.0, v_sum / draws);
    TEST_ASSERT_DOUBLE_WITHIN(0.018 * 0.7, 0.7, sqrt(v_square / draws));
    TEST_ASSERT_DOUBLE_WITHIN(0.025, 0.0, cross / draws / (0.05 * 0.05));
    TEST_ASSERT_DOUBLE_WITHIN(0.12, 3.0, fourth / draws / pow(square[2] / draws, 2.0));
}

static void test_noise_is_reproducible(void) {
    plant_config_t c = bench_config();
    c.i_noise_A = 0.1;
    plant_t one = new_plant(&c), same = new_plant(&c);
    c.seed = 2;
    plant_t other = new_plant(&c);
    int differences = 0;
    for (int k = 0; k < 50; k++) {
        plant_counts_t a, b, d;
        plant_sample(&one, &a, NULL);
        plant_sample(&same, &b, NULL);
        plant_sample(&other, &d, NULL);
        TEST_ASSERT_EQUAL_UINT16_ARRAY(a.i, b.i, 3);
        differences += memcmp(a.i, d.i, sizeof a.i) != 0;
    }
    TEST_ASSERT_TRUE(differences > 45);
}

static void test_stamp_runs_freely_and_wraps(void) {
    plant_config_t c = bench_config();
    c.stamp_Hz = 4e9; // 800 000 per period: wraps after 5369 of them
    plant_t plant = new_plant(&c);
    uint32_t last = 0;
    for (int k = 0; k < 6000; k++) {
        plant_counts_t counts;
        plant_sample(&plant, &counts, NULL);
        TEST_ASSERT_EQUAL_UINT32(k == 0 ? 0U : 800000U, counts.stamp - last);
        last = counts.stamp;
        plant_advance(&plant);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.2, truth_of(&plant).t_s);
}

/// The first period of an RL step, seen at t_k plus and minus a quarter period.
static void test_sampling_instant(void) {
    const double offsets[3] = {-50e-6, 0.0, 50e-6};
    for (int n = 0; n < 3; n++) {
        plant_config_t c = bench_config();
        c.adc_bits = 16;
        c.i_A_per_count = 1e-3;
        c.sample_offset_s = offsets[n];
        plant_t plant = new_plant(&c);
        start_with_voltage(&plant, 20.0, 0.0);
        for (int k = 0; k < 5; k++) {
            plant_counts_t counts;
            plant_sample(&plant, &counts, NULL);
            const double t = k * c.period_s + offsets[n];
            const double i = t > 0.0 ? 20.0 / 0.75 * (1.0 - exp(-0.75 * t / 3.5e-3)) : 0.0;
            TEST_ASSERT_DOUBLE_WITHIN(0.6e-3, i, (counts.i[0] - 32768) * 1e-3); // half a count
            plant_advance(&plant);
        }
    }
}

/// Centred pulses: at t_k the current is its mean; 40 us later, still in the zero vector, it has
/// decayed with L/R.
static void test_ripple_is_not_seen_at_t_k(void) {
    plant_config_t c = bench_config();
    c.level = PLANT_SWITCHING;
    c.dead_time_s = 0.0;
    c.adc_bits = 16;
    c.i_A_per_count = 1e-3;
    double seen[2];
    for (int n = 0; n < 2; n++) {
        c.sample_offset_s = n * 40e-6;
        plant_t plant = new_plant(&c);
        plant_counts_t counts;
        start_with_voltage(&plant, 10.0, 0.0);
        advance(&plant, 400);
        plant_sample(&plant, &counts, NULL);
        seen[n] = (counts.i[0] - 32768) * 1e-3;
    }
    // Half a count each.
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 10.0 / 0.75, seen[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, seen[0] * exp(-40e-6 * 0.75 / 3.5e-3), seen[1]);
}

// ---------------------------------------------------------------------------------------------
// Configuration

typedef void (*spoil_t)(plant_config_t *);

static void spoil_pole_pairs(plant_config_t *c) {
    c->pole_pairs = 0;
}
static void spoil_Rs(plant_config_t *c) {
    c->Rs_Ohm = -0.1;
}
static void spoil_Ld(plant_config_t *c) {
    c->Ld_H = 0.0;
}
static void spoil_Lq(plant_config_t *c) {
    c->Lq_H = not_a_number;
}
static void spoil_psi(plant_config_t *c) {
    c->psi_Wb = -1.0;
}
static void spoil_i_sat(plant_config_t *c) {
    c->i_sat_A = -1.0;
}
static void spoil_Lq_sat(plant_config_t *c) {
    c->i_sat_A = 5.0;
    c->Lq_sat_H = 0.02;
}
static void spoil_id_sat(plant_config_t *c) {
    c->id_sat_A = not_a_number;
}
static void spoil_Ld_sat(plant_config_t *c) {
    c->id_sat_A = 5.0;
    c->Ld_sat_H = 4e-3;
}
static void spoil_cross(plant_config_t *c) {
    c->i_cross_A = -1.0;
}
static void spoil_Ldq(plant_config_t *c) {
    c->i_cross_A = 5.0;
    c->Ldq_H = 2e-3; // no longer convex
}
static void spoil_emf(plant_config_t *c) {
    c->emf5_ratio = 2.0;
}
static void spoil_phase(plant_config_t *c) {
    c->emf7_phase_rad = HUGE_VAL;
}
static void spoil_J(plant_config_t *c) {
    c->J_kgm2 = 0.0;
}
static void spoil_B(plant_config_t *c) {
    c->B_Nms = -1.0;
}
static void spoil_load(plant_config_t *c) {
    c->load_Nm = not_a_number;
}
static void spoil_ripple(plant_config_t *c) {
    c->load_ripple = -0.1;
}
static void spoil_stiction(plant_config_t *c) {
    c->stiction_Nm = -1.0;
}
static void spoil_fan(plant_config_t *c) {
    c->fan_Nms2 = not_a_number;
}
static void spoil_cogging(plant_config_t *c) {
    c->cogging_per_turn = -6.0;
}
static void spoil_second_mass(plant_config_t *c) {
    c->load_J_kgm2 = 0.1; // without a shaft
}
static void spoil_shaft(plant_config_t *c) {
    c->backlash_rad = 7.0;
}
static void spoil_theta(plant_config_t *c) {
    c->theta_e_rad = not_a_number;
}
static void spoil_omega(plant_config_t *c) {
    c->omega_m_rad_s = 1e9;
}
static void spoil_level(plant_config_t *c) {
    c->level = (plant_level_t)3;
}
static void spoil_period(plant_config_t *c) {
    c->period_s = 0.0;
}
static void spoil_bus(plant_config_t *c) {
    c->v_bus_V = -1.0;
}
static void spoil_dead_time(plant_config_t *c) {
    c->dead_time_s = 60e-6;
}
static void spoil_drop(plant_config_t *c) {
    c->v_diode_V = -0.7;
}
static void spoil_r_on(plant_config_t *c) {
    c->r_on_Ohm = -0.7;
}
static void spoil_bits(plant_config_t *c) {
    c->adc_bits = 17;
}
static void spoil_gain(plant_config_t *c) {
    c->i_A_per_count = 0.0;
}
static void spoil_offset(plant_config_t *c) {
    c->i_offset_A[2] = not_a_number;
}
static void spoil_noise(plant_config_t *c) {
    c->i_noise_A = -1.0;
}
static void spoil_temperature(plant_config_t *c) {
    c->temperature_degC = not_a_number;
}
static void spoil_instant(plant_config_t *c) {
    c->sample_offset_s = 150e-6;
}
static void spoil_stamp(plant_config_t *c) {
    c->stamp_Hz = -1.0;
}

static void test_bad_configurations_are_refused(void) {
    static const spoil_t spoil[] = {
        spoil_pole_pairs, spoil_Rs,          spoil_Ld,        spoil_Lq,       spoil_psi,
        spoil_i_sat,      spoil_Lq_sat,      spoil_emf,       spoil_phase,    spoil_J,
        spoil_B,          spoil_load,        spoil_theta,     spoil_omega,    spoil_level,
        spoil_period,     spoil_bus,         spoil_dead_time, spoil_drop,     spoil_r_on,
        spoil_bits,       spoil_gain,        spoil_offset,    spoil_noise,    spoil_temperature,
        spoil_instant,    spoil_stamp,       spoil_ripple,    spoil_stiction, spoil_fan,
        spoil_cogging,    spoil_second_mass, spoil_shaft,     spoil_id_sat,   spoil_Ld_sat,
        spoil_cross,      spoil_Ldq};
    for (size_t n = 0; n < sizeof spoil / sizeof spoil[0]; n++) {
        plant_config_t c = plant_config_jiang2022();
        plant_t plant, untouched;
        memset(&plant, 0x5A, sizeof plant);
        memcpy(&untouched, &plant, sizeof plant);
        spoil[n](&c);
        TEST_ASSERT_NOT_NULL(plant_init(&plant, &c));
        TEST_ASSERT_EQUAL_MEMORY(&untouched, &plant, sizeof plant);
    }
}

// ---------------------------------------------------------------------------------------------
// Recordings of another simulator

#ifdef RECORDINGS_DIR

enum { ROWS_MAX = 12000 };

typedef struct {
    int rows;
    double u_alpha[ROWS_MAX], u_beta[ROWS_MAX], i_alpha[ROWS_MAX], i_beta[ROWS_MAX];
    double theta[ROWS_MAX], omega_e[ROWS_MAX];
} recording_t;

static recording_t rec;
static double replayed[ROWS_MAX * PLANT_REPLAY_COLUMNS];

static void read_recording(const char *name) {
    char path[512], line[256];
    snprintf(path, sizeof path, "%s/%s.csv", RECORDINGS_DIR, name);
    FILE *file = fopen(path, "r");
    TEST_ASSERT_NOT_NULL_MESSAGE(file, path);
    TEST_ASSERT_NOT_NULL(fgets(line, sizeof line, file));
    double t;
    int n = 0;
    while (n < ROWS_MAX &&
           fscanf(file, "%lf,%lf,%lf,%lf,%lf,%lf,%lf", &t, &rec.u_alpha[n], &rec.u_beta[n],
                  &rec.i_alpha[n], &rec.i_beta[n], &rec.theta[n], &rec.omega_e[n]) == 7) {
        n++;
    }
    fclose(file);
    rec.rows = n;
    TEST_ASSERT_TRUE(n > 2000);
}

static double wrapped(double angle) {
    return angle - 2.0 * PI * floor(angle / (2.0 * PI) + 0.5);
}

static void replay(const double *omega_m, const double *load) {
    const double parameter[PLANT_REPLAY_PARAMETERS] = {3.0,
                                                       0.75,
                                                       3.5e-3,
                                                       9.8e-3,
                                                       0.142,
                                                       0.0174,
                                                       7.5e-4,
                                                       1000.0,
                                                       200e-6,
                                                       rec.theta[0],
                                                       rec.omega_e[0] / 3.0};
    TEST_ASSERT_EQUAL(
        0, plant_replay(parameter, rec.rows, rec.u_alpha, rec.u_beta, omega_m, load, replayed));
}

/// Largest difference of the current vector, A.
static double current_error(void) {
    double worst = 0.0;
    for (int k = 0; k < rec.rows; k++) {
        const double *row = &replayed[k * PLANT_REPLAY_COLUMNS];
        worst = fmax(worst, hypot(row[PLANT_REPLAY_I_ALPHA_A] - rec.i_alpha[k],
                                  row[PLANT_REPLAY_I_BETA_A] - rec.i_beta[k]));
    }
    return worst;
}

/// The recorded voltage on a shaft that follows the recorded angle.
static void check_recorded_currents(const char *name, double limit_A) {
    static double omega_m[ROWS_MAX];
    read_recording(name);
    for (int k = 0; k < rec.rows; k++) {
        omega_m[k] = k + 1 < rec.rows ? wrapped(rec.theta[k + 1] - rec.theta[k]) / 200e-6 / 3.0
                                      : rec.omega_e[k] / 3.0;
    }
    replay(omega_m, NULL);
    const double worst = current_error();
    printf("  %s, recorded speed: largest difference %.2e A\n", name, worst);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(limit_A, 0.0, worst, name);
}

/// Nine digits of voltage and angle and two solvers' step errors leave well under 1 mA of 10 A;
/// one part in a thousand of any parameter would show 5 mA or more.
static void test_recorded_currents(void) {
    check_recorded_currents("steady-300rpm-5Nm", 1e-3);
    check_recorded_currents("steady-1500rpm-5Nm", 1e-3);
    check_recorded_currents("load-step-300rpm", 1e-3);
    check_recorded_currents("ramp-300-1500-300rpm-1Nm", 1e-3);
}

/// The flux at t_k follows from the mean voltage and from R times the mean current: its carrier's
/// one edge per period makes that mean differ by some 1 A of ripple, R Ts 1 A / Ld = 43 mA.
static void test_recorded_currents_with_carrier(void) {
    check_recorded_currents("carrier-pwm-300rpm-5Nm", 60e-3);
}

/// The same with the shaft free: torque, inertia, friction and load decide speed and angle.
static void test_recorded_load_step_with_free_shaft(void) {
    static double load[ROWS_MAX];
    read_recording("load-step-300rpm");
    for (int k = 0; k < rec.rows; k++) {
        load[k] = k >= 1500 && k < 4500 ? 5.0 : 0.0;
    }
    replay(NULL, load);
    double omega_worst = 0.0, theta_worst = 0.0;
    for (int k = 0; k < rec.rows; k++) {
        const double *row = &replayed[k * PLANT_REPLAY_COLUMNS];
        omega_worst =
            fmax(omega_worst, fabs(3.0 * row[PLANT_REPLAY_OMEGA_OUT_RAD_S] - rec.omega_e[k]));
        theta_worst =
            fmax(theta_worst, fabs(wrapped(row[PLANT_REPLAY_THETA_OUT_RAD] - rec.theta[k])));
    }
    printf("  load step, free shaft: largest differences %.2e A, %.2e rad/s, %.2e rad\n",
           current_error(), omega_worst, theta_worst);
    // The recording dips by some 50 rad/s and turns 130 rad; it tells the load's instants only to a
    // solver step (of 1.4 mrad/s per us), and a free shaft under given voltages adds all up.
    TEST_ASSERT_DOUBLE_WITHIN(20e-3, 0.0, current_error());
    TEST_ASSERT_DOUBLE_WITHIN(50e-3, 0.0, omega_worst);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, theta_worst);
}

#endif

// ---------------------------------------------------------------------------------------------
// Speed

/// Simulated over processor time for one second at rated load, sampling and noise included.
static double times_real_time(plant_level_t level, double iq) {
    plant_config_t c = lossy_config();
    c.level = level;
    c.i_noise_A = 0.02;
    c.speed_is_prescribed = true;
    c.omega_m_rad_s = 60.0;
    plant_t plant = new_plant(&c);
    const clock_t start = clock();
    for (int k = 0; k < 5000; k++) {
        plant_counts_t counts;
        plant_sample(&plant, &counts, NULL);
        control_current(&plant, &c, 0.0, iq);
        plant_advance(&plant);
    }
    const double spent_s = (double)(clock() - start) / CLOCKS_PER_SEC;
    return 5000.0 * c.period_s / fmax(spent_s, 1e-6);
}

static double best_of_five(plant_level_t level, double iq) {
    double best = 0.0;
    for (int n = 0; n < 5; n++) {
        best = fmax(best, times_real_time(level, iq));
    }
    return best;
}

/// 100 times is the aim and is exceeded on an ordinary machine; the gate leaves room for a slow or
/// busy one. Without optimisation the figure is only printed.
// gcc says so by a macro, clang by a feature.
#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED
#endif
#endif

static void test_speed(void) {
    const double loaded = best_of_five(PLANT_SWITCHING, 8.0);
    printf("  speed: switching %.0f x real time under load, %.0f x without; averaged %.0f x\n",
           loaded, best_of_five(PLANT_SWITCHING, 0.0), best_of_five(PLANT_AVERAGED, 8.0));
#if defined(__OPTIMIZE__) && !defined(SANITIZED)
    TEST_ASSERT_TRUE(loaded > 30.0);
#endif
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_rl_step_locked_rotor);
    RUN_TEST(test_three_phase_short_circuit);
    RUN_TEST(test_open_circuit_emf);
    RUN_TEST(test_emf_above_the_bus_charges_it);
    RUN_TEST(test_energy_balance);
    RUN_TEST(test_a_brake_resistor_discharges_the_bus);
    RUN_TEST(test_energy_scale);
    RUN_TEST(test_random_motors_stay_consistent);
    RUN_TEST(test_dead_time_voltage_loss);
    RUN_TEST(test_conduction_drops);
    RUN_TEST(test_duty_is_quantised);
    RUN_TEST(test_duty_range);
    RUN_TEST(test_zero_current_clamping);
    RUN_TEST(test_gate_edges);
    RUN_TEST(test_double_update);
    RUN_TEST(test_pwm_is_centred);
    RUN_TEST(test_dead_time_carries_over);
    RUN_TEST(test_phases_are_alike);
    RUN_TEST(test_duty_acts_one_period_late);
    RUN_TEST(test_duty_without_a_shadow_acts_at_once);
    RUN_TEST(test_gates_off_acts_at_once);
    RUN_TEST(test_trip_cuts_the_gates_and_is_seen);
    RUN_TEST(test_bus_can_change);
    RUN_TEST(test_harmonics);
    RUN_TEST(test_harmonics_of_an_open_machine);
    RUN_TEST(test_saturation_law);
    RUN_TEST(test_coast_down_time_constant);
    RUN_TEST(test_passive_and_active_load);
    RUN_TEST(test_fan_law);
    RUN_TEST(test_ripple_once_per_turn);
    RUN_TEST(test_cogging_over_the_angle);
    RUN_TEST(test_stiction_holds_and_lets_go);
    RUN_TEST(test_two_masses_swing);
    RUN_TEST(test_backlash_and_friction_behind_it);
    RUN_TEST(test_dynamometer_overrules_loads);
    RUN_TEST(test_passive_load_holds_at_standstill);
    RUN_TEST(test_dynamometer);
    RUN_TEST(test_adc_scale_offset_and_gain);
    RUN_TEST(test_adc_saturates);
    RUN_TEST(test_adc_noise_statistics);
    RUN_TEST(test_noise_is_reproducible);
    RUN_TEST(test_stamp_runs_freely_and_wraps);
    RUN_TEST(test_sampling_instant);
    RUN_TEST(test_ripple_is_not_seen_at_t_k);
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_switching_matches_reference_under_load);
    RUN_TEST(test_switching_matches_reference_with_saturation_and_harmonics);
    RUN_TEST(test_switching_matches_reference_with_cross_saturation);
    RUN_TEST(test_switching_matches_reference_without_load);
    RUN_TEST(test_switching_matches_reference_at_reversals);
    RUN_TEST(test_low_sides_alone_match_the_reference);
    RUN_TEST(test_low_sides_alone_bound_the_current);
    RUN_TEST(test_switching_matches_reference_without_drops);
    RUN_TEST(test_accounts_change_nothing_else);
    RUN_TEST(test_gates_off_matches_reference_when_rectifying);
#ifdef RECORDINGS_DIR
    RUN_TEST(test_recorded_currents);
    RUN_TEST(test_recorded_currents_with_carrier);
    RUN_TEST(test_recorded_load_step_with_free_shaft);
#endif
    RUN_TEST(test_speed);
    return UNITY_END();
}
