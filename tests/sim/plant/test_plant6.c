/// The simulated motor with two sets of windings: closed forms, a brute-force simulation in phase
/// quantities (below), phases that break, sets that are switched off.
#include "plant/plant.h"

#include "unity.h"

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PI 3.14159265358979323846
#define SETS PLANT_SETS
#define LEGS PLANT_LEGS

/// Axes a1 b1 c1 a2 b2 c2, degrees.
static const double axis_deg[LEGS] = {0.0, 120.0, 240.0, 30.0, 150.0, 270.0};

void setUp(void) {}

void tearDown(void) {}

// ---------------------------------------------------------------------------------------------
// Helpers

static double axis_rad(int leg) {
    return axis_deg[leg] * PI / 180.0;
}

/// Averaged level, nothing quantised, no drops, speed held.
static plant_config_t bench_config(void) {
    plant_config_t c = plant_config_jiang2022();
    c.sets = 2;
    c.level = PLANT_AVERAGED;
    c.pwm_ticks = 0;
    c.speed_is_prescribed = true;
    c.period_s = 100e-6;
    c.v_bus_V = 300.0;
    c.dead_time_s = 0.0;
    c.pole_pairs = 5;
    c.Rs_Ohm = 0.8;
    c.Ld_H = 6.4e-3;
    c.Lq_H = 17.4e-3;
    c.Lxy_H = 0.9e-3;
    c.psi_Wb = 0.1746;
    c.J_kgm2 = 0.01;
    c.B_Nms = 1e-3;
    return c;
}

static plant_config_t lossy_config(void) {
    plant_config_t c = bench_config();
    c.level = PLANT_SWITCHING;
    c.speed_is_prescribed = false;
    c.load_is_passive = false;
    c.dead_time_s = 2e-6;
    c.v_transistor_V = 1.2;
    c.v_diode_V = 0.9;
    c.r_on_Ohm = 0.05;
    c.theta_e_rad = 0.3;
    c.omega_m_rad_s = 40.0;
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

/// Phase voltages of both planes: written here by phases, not by sets.
static double phase_value(double complex ab, double complex xy, int leg) {
    const double a = axis_rad(leg);
    return creal(ab * cexp(-I * a)) + creal(xy * cexp(-5.0 * I * a));
}

static void write_voltage(plant_t *plant, double complex ab, double complex xy) {
    double duty[LEGS];
    for (int n = 0; n < LEGS; n++) {
        duty[n] = 0.5 + phase_value(ab, xy, n) / plant->inverter.v_bus_V;
    }
    plant_write_set(plant, 0, duty, true);
    plant_write_set(plant, 1, &duty[3], true);
}

static void gates_off(plant_t *plant, int set) {
    plant_write_set(plant, set, &plant->next_duty[set * PLANT_PHASES], false);
}

static void advance(plant_t *plant, int periods) {
    for (int k = 0; k < periods; k++) {
        plant_advance(plant);
    }
}

/// A current controller that knows everything; xy to zero.
static void control_current(plant_t *plant, const plant_config_t *c, double id_ref, double iq_ref) {
    const plant_truth_t t = truth_of(plant);
    const double w = t.omega_e_rad_s;
    const double complex ahead = cexp(I * (t.theta_e_rad + 1.5 * w * c->period_s));
    const double ud = c->Rs_Ohm * id_ref - w * c->Lq_H * t.iq_A + 10.0 * (id_ref - t.id_A);
    const double uq =
        c->Rs_Ohm * iq_ref + w * (c->psi_Wb + c->Ld_H * t.id_A) + 20.0 * (iq_ref - t.iq_A);
    write_voltage(plant, (ud + I * uq) * ahead, -1.5 * (t.i_x_A + I * t.i_y_A));
}

// ---------------------------------------------------------------------------------------------
// A brute-force reference: Euler steps of a few ns of the four fluxes, everything else per phase. A
// leg is one steep characteristic, a broken phase a large resistor: nothing floats as a special case.

typedef struct {
    const plant_config_t *c;
    double psi[4]; // alpha, beta, x, y
    double theta, omega_m;
    double i[LEGS];
    int wanted[LEGS]; // 0 none, 1 low, 2 high
    int wait[LEGS];
    int breaking[LEGS]; // sign of the current that is still to end; 0: none
    bool open[LEGS];
    double torque;
    double u_mean[4]; // at the terminals, over the period
} reference_t;

enum { REFERENCE_STEPS = 10000 }; // per period: 10 ns

/// Row of the transform for a leg: its current from alpha, beta, x, y.
static void row_of(int leg, double row[4]) {
    static double rows[LEGS][4];
    if (!(rows[0][0] > 0.0)) {
        for (int n = 0; n < LEGS; n++) {
            const double a = axis_rad(n);
            rows[n][0] = cos(a);
            rows[n][1] = sin(a);
            rows[n][2] = cos(5.0 * a);
            rows[n][3] = sin(5.0 * a);
        }
    }
    memcpy(row, rows[leg], sizeof rows[leg]);
}

/// A harmonic of the magnet's flux in phase a, projected on the four axes by hand, and its slope by
/// angle.
static void magnet(const plant_config_t *c, double theta, double flux[4], double slope[4]) {
    const double order[5] = {1.0, 5.0, 7.0, 11.0, 13.0};
    const double share[5] = {1.0, c->emf5_ratio, c->emf7_ratio, c->emf11_ratio, c->emf13_ratio};
    const double shift[5] = {0.0, c->emf5_phase_rad, c->emf7_phase_rad, c->emf11_phase_rad,
                             c->emf13_phase_rad};
    for (int m = 0; m < 4; m++) {
        flux[m] = slope[m] = 0.0;
    }
    for (int n = 0; n < LEGS; n++) {
        double row[4];
        row_of(n, row);
        for (int k = 0; k < 5; k++) {
            if (!(share[k] > 0.0)) {
                continue;
            }
            const double x = order[k] * (theta - axis_rad(n)) + shift[k];
            for (int m = 0; m < 4; m++) {
                flux[m] += row[m] / 3.0 * c->psi_Wb * share[k] / order[k] * cos(x);
                slope[m] -= row[m] / 3.0 * c->psi_Wb * share[k] * sin(x);
            }
        }
    }
}

static void reference_currents(reference_t *r) {
    const plant_config_t *c = r->c;
    const double co = cos(r->theta), si = sin(r->theta);
    double flux[4], slope[4], own[4], i[4];
    magnet(c, r->theta, flux, slope);
    for (int m = 0; m < 4; m++) {
        own[m] = r->psi[m] - flux[m];
    }
    const double id = (own[0] * co + own[1] * si) / c->Ld_H;
    const double iq = (own[1] * co - own[0] * si) / c->Lq_H;
    i[0] = id * co - iq * si;
    i[1] = id * si + iq * co;
    i[2] = own[2] / c->Lxy_H;
    i[3] = own[3] / c->Lxy_H;
    for (int n = 0; n < LEGS; n++) {
        double row[4];
        row_of(n, row);
        r->i[n] = row[0] * i[0] + row[1] * i[1] + row[2] * i[2] + row[3] * i[3];
    }
    // Reluctance from the inductances, the rest from the magnet's power at 1 rad/s.
    r->torque = 3.0 * c->pole_pairs *
                ((c->Ld_H - c->Lq_H) * id * iq + slope[0] * i[0] + slope[1] * i[1] +
                 slope[2] * i[2] + slope[3] * i[3]);
}

static reference_t reference_start(const plant_config_t *c) {
    reference_t r = {.c = c, .theta = c->theta_e_rad, .omega_m = c->omega_m_rad_s};
    double slope[4];
    magnet(c, r.theta, r.psi, slope);
    reference_currents(&r);
    return r;
}

static double reference_leg(const reference_t *r, int n) {
    const plant_config_t *c = r->c;
    const int gate = r->wait[n] > 0 ? 0 : r->wanted[n];
    const double low = gate == 2 ? c->v_bus_V - c->v_transistor_V : -c->v_diode_V;
    const double high = gate == 1 ? c->v_transistor_V : c->v_bus_V + c->v_diode_V;
    const double share = fmin(fmax(0.5 - r->i[n] / 2e-3, 0.0), 1.0);
    return r->open[n] ? 0.5 * c->v_bus_V - 5e4 * r->i[n]
                      : low + (high - low) * share - c->r_on_Ohm * r->i[n];
}

static void reference_period(reference_t *r, const double duty[LEGS],
                             const plant_gates_t gates[SETS]) {
    const plant_config_t *c = r->c;
    const double steps = (double)REFERENCE_STEPS, h = c->period_s / steps;
    const int dead = (int)floor(c->dead_time_s / h + 0.5);
    for (int m = 0; m < 4; m++) {
        r->u_mean[m] = 0.0;
    }
    for (int k = 0; k < REFERENCE_STEPS; k++) {
        double v[LEGS], u[4] = {0.0, 0.0, 0.0, 0.0};
        const double x = fabs(k + 0.5 - 0.5 * steps) * 2.0 / steps;
        for (int n = 0; n < LEGS; n++) {
            const int wanted = gates[n / 3] == PLANT_GATES_OFF ? 0 : (x < duty[n] ? 2 : 1);
            r->wait[n] = wanted != r->wanted[n] ? dead : r->wait[n] - (r->wait[n] > 0);
            r->wanted[n] = wanted;
            v[n] = reference_leg(r, n) - c->Rs_Ohm * r->i[n];
        }
        for (int n = 0; n < LEGS; n++) {
            double row[4];
            row_of(n, row);
            const int first = n - n % 3;
            const double neutral = (v[first] + v[first + 1] + v[first + 2]) / 3.0;
            for (int m = 0; m < 4; m++) {
                u[m] += row[m] / 3.0 * (v[n] - neutral);
                r->u_mean[m] += row[m] / 3.0 * (v[n] + c->Rs_Ohm * r->i[n]) / steps;
            }
        }
        const double omega_before = r->omega_m;
        for (int m = 0; m < 4; m++) {
            r->psi[m] += h * u[m];
        }
        reference_currents(r);
        if (!c->speed_is_prescribed) {
            r->omega_m += h / c->J_kgm2 * (r->torque - c->load_Nm - c->B_Nms * r->omega_m);
        }
        r->theta += h * c->pole_pairs * 0.5 * (omega_before + r->omega_m);
        for (int n = 0; n < LEGS; n++) {
            r->open[n] = r->open[n] || r->breaking[n] * r->i[n] < 0.0;
        }
    }
}

typedef struct {
    double iq;
    int periods;
    int off_from;  // set 2's gates off from here on; -1: never
    int open_from; // ... phase `open` breaks
    int open;
    double limit_A;
    const char *name;
} race_t;

/// Runs plant and reference side by side under the same duties.
static void compare_with_reference(const plant_config_t *c, const race_t *race) {
    plant_t plant = new_plant(c);
    reference_t r = reference_start(c);
    double worst = 0.0, peak = 0.0, torque_worst = 0.0, u_worst = 0.0;
    for (int k = 0; k < race->periods; k++) {
        control_current(&plant, c, -1.0, race->iq);
        if (race->off_from >= 0 && k >= race->off_from) {
            gates_off(&plant, 1);
        }
        if (race->open_from >= 0 && k == race->open_from) {
            plant_open_phase(&plant, race->open);
            r.breaking[race->open] = r.i[race->open] > 0.0 ? 1 : -1;
        }
        reference_period(&r, plant.duty, plant.gates);
        plant_advance(&plant);
        const plant_truth_t t = truth_of(&plant);
        for (int n = 0; n < LEGS; n++) {
            worst = fmax(worst, fabs(t.i_abc_A[n] - r.i[n]));
            peak = fmax(peak, fabs(t.i_abc_A[n]));
        }
        const double u[4] = {t.u_alpha_V, t.u_beta_V, t.u_x_V, t.u_y_V};
        for (int m = 0; m < 4; m++) {
            u_worst = fmax(u_worst, fabs(u[m] - r.u_mean[m]));
        }
        torque_worst = fmax(torque_worst, fabs(t.torque_Nm - r.torque));
    }
    TEST_ASSERT_TRUE(race->open_from < 0 || truth_of(&plant).open[race->open]);
    printf("  reference, %s: peak %.3f A, largest difference %.2e A, %.2e Nm, %.2e V\n", race->name,
           peak, worst, torque_worst, u_worst);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.3, 0.0, u_worst, race->name);
    TEST_ASSERT_TRUE(peak > 0.5);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(race->limit_A, 0.0, worst, race->name);
}

/// 10 ns of 300 V on 0.9 mH are 3.3 mA and the legs of the reference are 2 mA wide.
static void test_switching_matches_reference(void) {
    plant_config_t c = lossy_config();
    c.load_Nm = 5.0;
    const race_t loaded = {8.0, 100, -1, -1, 0, 15e-3, "load"};
    compare_with_reference(&c, &loaded);
    c.emf5_ratio = 0.06;
    c.emf5_phase_rad = 0.4;
    c.emf7_ratio = 0.04;
    c.emf7_phase_rad = -0.7;
    c.emf11_ratio = 0.03;
    c.emf11_phase_rad = 0.2;
    c.emf13_ratio = 0.02;
    const race_t harmonics = {-5.0, 100, -1, -1, 0, 15e-3, "harmonics, braking"};
    compare_with_reference(&c, &harmonics);
    c.omega_m_rad_s = 12.0;
    const race_t idle = {0.3, 100, -1, -1, 0, 15e-3, "hardly any current"};
    compare_with_reference(&c, &idle);
}

static void test_set_off_matches_reference(void) {
    plant_config_t c = lossy_config();
    c.load_Nm = 3.0;
    const race_t off = {8.0, 120, 40, -1, 0, 15e-3, "set 2 off"};
    compare_with_reference(&c, &off);
    // One set drives against the rectifier that the other one is.
    c.omega_m_rad_s = 220.0;
    c.speed_is_prescribed = true;
    c.emf5_ratio = 0.05;
    const race_t charging = {2.0, 80, 10, -1, 0, 20e-3, "set 2 off and charging"};
    compare_with_reference(&c, &charging);
}

/// The broken phase of the reference leaks 3 mA.
static void test_open_phase_matches_reference(void) {
    for (int leg = 0; leg < LEGS; leg += 2) {
        char name[32];
        plant_config_t c = lossy_config();
        c.load_Nm = 3.0;
        c.speed_is_prescribed = true;
        (void)snprintf(name, sizeof name, "leg %d breaks", leg);
        const race_t broken = {6.0, 210, -1, 10, leg, 15e-3, name};
        compare_with_reference(&c, &broken);
    }
}

// ---------------------------------------------------------------------------------------------
// Closed forms

/// 8 V on one axis: the current of that axis alone rises with its own L/R.
static void check_rl_step(plant_level_t level, double theta, double complex ab, double complex xy,
                          double L) {
    plant_config_t c = bench_config();
    c.level = level;
    c.theta_e_rad = theta;
    plant_t plant = new_plant(&c);
    write_voltage(&plant, ab, xy);
    plant_advance(&plant);
    for (int k = 1; k <= 300; k++) {
        plant_advance(&plant);
        const double rise = (1.0 - exp(-c.Rs_Ohm * k * c.period_s / L)) / c.Rs_Ohm;
        const plant_truth_t t = truth_of(&plant);
        // A switched voltage gives the same current at t_k up to its ripple's second order.
        const double limit = level == PLANT_AVERAGED ? 5e-5 : 5e-3;
        TEST_ASSERT_DOUBLE_WITHIN(limit, creal(ab) * rise, t.i_alpha_A);
        TEST_ASSERT_DOUBLE_WITHIN(limit, cimag(ab) * rise, t.i_beta_A);
        TEST_ASSERT_DOUBLE_WITHIN(limit, creal(xy) * rise, t.i_x_A);
        TEST_ASSERT_DOUBLE_WITHIN(limit, cimag(xy) * rise, t.i_y_A);
        for (int n = 0; n < LEGS; n++) {
            TEST_ASSERT_DOUBLE_WITHIN(3.0 * limit, phase_value(ab, xy, n) * rise, t.i_abc_A[n]);
        }
    }
}

static void test_rl_step_in_both_planes(void) {
    for (int level = 0; level < 2; level++) {
        const plant_level_t how = level == 0 ? PLANT_AVERAGED : PLANT_SWITCHING;
        check_rl_step(how, 0.0, 8.0, 0.0, 6.4e-3);
        check_rl_step(how, 0.0, 8.0 * I, 0.0, 17.4e-3);
        check_rl_step(how, 0.5 * PI, 8.0, 0.0, 17.4e-3);
        check_rl_step(how, 0.0, 0.0, 8.0, 0.9e-3);
        check_rl_step(how, 0.7, 0.0, 8.0 * I, 0.9e-3);
    }
}

/// Held voltages turn in xy while the rotor turns: the plane has an exact recursion of its own.
static void test_xy_plane_by_exact_recursion(void) {
    plant_config_t c = bench_config();
    c.omega_m_rad_s = 30.0;
    plant_t plant = new_plant(&c);
    const double a = exp(-c.Rs_Ohm * c.period_s / c.Lxy_H), b = (1.0 - a) / c.Rs_Ohm;
    double complex i = 0.0, u = 0.0;
    for (int k = 0; k < 500; k++) {
        const double complex next = 6.0 * cexp(I * (0.3 * k + 0.001 * k * k));
        write_voltage(&plant, 0.0, next);
        plant_advance(&plant);
        i = a * i + b * u;
        u = next;
        const plant_truth_t t = truth_of(&plant);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.0, cabs(t.i_x_A + I * t.i_y_A - i));
    }
}

/// Two sets under one voltage are one set of twice the torque.
static void test_both_sets_alike_are_three_phases(void) {
    plant_config_t c = bench_config();
    c.Lxy_H = c.Lq_H; // the same length of steps
    c.omega_m_rad_s = 60.0;
    plant_t six = new_plant(&c);
    c.sets = 1;
    plant_t three = new_plant(&c);
    for (int k = 0; k < 400; k++) {
        const double complex u = 40.0 * cexp(I * (0.03 * k + 2.0));
        double duty[3];
        for (int n = 0; n < 3; n++) {
            duty[n] = 0.5 + creal(u * cexp(-I * axis_rad(n))) / c.v_bus_V;
        }
        plant_write(&three, duty, true);
        write_voltage(&six, u, 0.0);
        plant_advance(&three);
        plant_advance(&six);
        const plant_truth_t one = truth_of(&three), both = truth_of(&six);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, one.id_A, both.id_A);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, one.iq_A, both.iq_A);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.0 * one.torque_Nm, both.torque_Nm);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, hypot(both.i_x_A, both.i_y_A));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.0 * truth_of(&three).energy.bus_J,
                              truth_of(&six).energy.bus_J);
}

/// Te = 3 np (psi + (Ld - Lq) id) iq, and no part of it from xy without harmonics.
static void test_torque(void) {
    plant_config_t c = bench_config();
    c.omega_m_rad_s = 20.0;
    plant_t plant = new_plant(&c);
    for (int k = 0; k < 600; k++) {
        control_current(&plant, &c, -4.0, 7.0);
        plant_advance(&plant);
    }
    const plant_truth_t t = truth_of(&plant);
    TEST_ASSERT_DOUBLE_WITHIN(0.2, 7.0, t.iq_A);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 15.0 * (0.1746 - 11e-3 * t.id_A) * t.iq_A, t.torque_Nm);
}

static plant_config_t harmonic_config(void) {
    plant_config_t c = bench_config();
    c.omega_m_rad_s = 50.0;
    c.emf5_ratio = 0.06;
    c.emf5_phase_rad = 0.4;
    c.emf7_ratio = 0.04;
    c.emf7_phase_rad = -0.7;
    c.emf11_ratio = 0.03;
    c.emf11_phase_rad = 1.2;
    c.emf13_ratio = 0.02;
    c.emf13_phase_rad = -2.2;
    return c;
}

/// Every phase has the waveform of phase a, turned by its axis.
static void test_emf_of_all_phases(void) {
    const plant_config_t c = harmonic_config();
    plant_t plant = new_plant(&c);
    const double w = 250.0;
    for (int k = 0; k < 200; k++) {
        plant_advance(&plant); // gates off: no current
        const plant_truth_t t = truth_of(&plant);
        for (int n = 0; n < LEGS; n++) {
            const double th = t.theta_e_rad - axis_rad(n);
            const double e = -w * c.psi_Wb *
                             (sin(th) + 0.06 * sin(5.0 * th + 0.4) + 0.04 * sin(7.0 * th - 0.7) +
                              0.03 * sin(11.0 * th + 1.2) + 0.02 * sin(13.0 * th - 2.2));
            const double seen = phase_value(t.e_alpha_V + I * t.e_beta_V, t.e_x_V + I * t.e_y_V, n);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, e, seen);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, t.i_abc_A[n]);
        }
    }
}

/// All legs tied together: the 5th turns at +5w and the 7th at -7w against R and Lxy alone.
static void test_xy_harmonic_currents(void) {
    for (int level = 0; level < 2; level++) {
        plant_config_t c = harmonic_config();
        c.level = level == 0 ? PLANT_AVERAGED : PLANT_SWITCHING;
        plant_t plant = new_plant(&c);
        const double duty[3] = {0.0, 0.0, 0.0};
        plant_write_set(&plant, 0, duty, true);
        plant_write_set(&plant, 1, duty, true);
        advance(&plant, 400); // 35 time constants
        double worst = 0.0, peak = 0.0;
        for (int k = 0; k < 300; k++) {
            plant_advance(&plant);
            const plant_truth_t t = truth_of(&plant);
            const double w = 250.0, th = t.theta_e_rad;
            const double complex e5 = I * w * c.psi_Wb * 0.06 * cexp(I * (5.0 * th + 0.4));
            const double complex e7 = -I * w * c.psi_Wb * 0.04 * cexp(-I * (7.0 * th - 0.7));
            const double complex i =
                -e5 / (c.Rs_Ohm + 5.0 * I * w * c.Lxy_H) - e7 / (c.Rs_Ohm - 7.0 * I * w * c.Lxy_H);
            worst = fmax(worst, cabs(t.i_x_A + I * t.i_y_A - i));
            peak = fmax(peak, cabs(i));
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, creal(e5 + e7), t.e_x_V);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, cimag(e5 + e7), t.e_y_V);
        }
        printf("  xy harmonics: %.3f A, off by %.1e A\n", peak, worst);
        TEST_ASSERT_TRUE(peak > 2.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * peak, 0.0, worst);
    }
}

// ---------------------------------------------------------------------------------------------
// A broken phase

/// Phasors of the four currents, time reference theta = w t, of a motor without saliency whose
/// terminals are tied together, with one phase broken. Row c of the transform: I = (c v - E) / z with
/// v such that c I = 0.
static void broken_phasors(const plant_config_t *c, double w, int leg, double complex i[4]) {
    double row[4];
    const double complex z_ab = c->Rs_Ohm + I * w * c->Ld_H, z_xy = c->Rs_Ohm + I * w * c->Lxy_H;
    const double complex z[4] = {z_ab, z_ab, z_xy, z_xy};
    // E = j w psi exp(j theta): alpha -sin, beta cos; as the real part of phasors times exp(j theta).
    const double complex e[4] = {I * w * c->psi_Wb, w * c->psi_Wb, 0.0, 0.0};
    double complex over = 0.0, under = 0.0;
    row_of(leg, row);
    for (int m = 0; m < 4; m++) {
        over += row[m] * e[m] / z[m];
        under += row[m] * row[m] / z[m];
    }
    for (int m = 0; m < 4; m++) {
        i[m] = (row[m] * over / under - e[m]) / z[m];
    }
}

static void check_broken(plant_level_t level, int leg) {
    plant_config_t c = bench_config();
    c.level = level;
    c.Lq_H = c.Ld_H;
    c.omega_m_rad_s = 50.0;
    plant_t plant = new_plant(&c);
    const double duty[3] = {0.0, 0.0, 0.0}, w = 250.0;
    plant_write_set(&plant, 0, duty, true);
    plant_write_set(&plant, 1, duty, true);
    advance(&plant, 50);
    plant_open_phase(&plant, leg);
    advance(&plant, 2000); // the slow L/R is 8 ms: what is left of the transient is below 1e-10
    TEST_ASSERT_TRUE(truth_of(&plant).open[leg]);
    double complex phasor[4];
    broken_phasors(&c, w, leg, phasor);
    double worst = 0.0, low = HUGE_VAL, high = -HUGE_VAL;
    for (int k = 0; k < 400; k++) {
        plant_advance(&plant);
        const plant_truth_t t = truth_of(&plant);
        const double complex turn = cexp(I * t.theta_e_rad);
        const double alpha = creal(phasor[0] * turn), beta = creal(phasor[1] * turn);
        const double iq = beta * cos(t.theta_e_rad) - alpha * sin(t.theta_e_rad);
        const double torque = 3.0 * c.pole_pairs * c.psi_Wb * iq;
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, t.i_abc_A[leg]);
        TEST_ASSERT_DOUBLE_WITHIN(5e-4, creal(phasor[2] * turn), t.i_x_A);
        TEST_ASSERT_DOUBLE_WITHIN(5e-4, creal(phasor[3] * turn), t.i_y_A);
        worst = fmax(worst, fabs(t.torque_Nm - torque));
        low = fmin(low, torque);
        high = fmax(high, torque);
    }
    // What turns twice per revolution of 3 np psi (beta cos - alpha sin), here through its extremes.
    const double ripple = 1.5 * c.pole_pairs * c.psi_Wb * cabs(phasor[1] + I * phasor[0]);
    TEST_ASSERT_TRUE(ripple > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * ripple, 2.0 * ripple, high - low);
    printf("  leg %d broken: ripple of torque %.3f Nm, off by %.1e Nm\n", leg, ripple, worst);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * ripple, 0.0, worst);
}

static void test_torque_ripple_of_a_broken_phase(void) {
    for (int leg = 0; leg < LEGS; leg++) {
        check_broken(PLANT_AVERAGED, leg);
    }
    check_broken(PLANT_SWITCHING, 1);
    check_broken(PLANT_SWITCHING, 3);
}

/// The wire arcs until the current is zero; before that the break changes nothing, after it there is
/// never any current again, whatever the gates do.
static void test_phase_opens_at_zero_current(void) {
    for (int level = 0; level < 2; level++) {
        plant_config_t c = lossy_config();
        c.level = level == 0 ? PLANT_AVERAGED : PLANT_SWITCHING;
        c.speed_is_prescribed = true;
        plant_t plant = new_plant(&c);
        for (int k = 0; k < 200; k++) {
            control_current(&plant, &c, 0.0, 6.0);
            plant_advance(&plant);
        }
        plant_t sound = plant;
        plant_open_phase(&plant, 4);
        int opened = -1;
        for (int k = 0; k < 600; k++) {
            control_current(&sound, &c, 0.0, 6.0);
            if (opened < 0) {
                for (int set = 0; set < SETS; set++) {
                    plant_write_set(&plant, set, &sound.next_duty[3 * set], true);
                }
            } else {
                control_current(&plant, &c, 0.0, 6.0);
            }
            plant_advance(&sound);
            plant_advance(&plant);
            const plant_truth_t t = truth_of(&plant), as_before = truth_of(&sound);
            if (t.open[4]) {
                opened = opened < 0 ? k : opened;
                TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, t.i_abc_A[4]);
                if (opened == k) { // it was about to cross
                    TEST_ASSERT_DOUBLE_WITHIN(0.6, 0.0, as_before.i_abc_A[4]);
                }
            } else {
                TEST_ASSERT_EQUAL_MEMORY(as_before.i_abc_A, t.i_abc_A, sizeof t.i_abc_A);
            }
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, t.i_abc_A[0] + t.i_abc_A[1] + t.i_abc_A[2]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, t.i_abc_A[3] + t.i_abc_A[4] + t.i_abc_A[5]);
        }
        TEST_ASSERT_TRUE(opened > 0 && opened < 160); // half a wave are 157 periods
        TEST_ASSERT_TRUE(truth_of(&plant).torque_Nm > 5.0);
    }
}

/// A phase without current breaks at once, also before anything has run.
static void test_phase_opens_at_rest(void) {
    plant_config_t c = bench_config();
    plant_t plant = new_plant(&c);
    plant_open_phase(&plant, 0);
    write_voltage(&plant, 10.0, 0.0);
    advance(&plant, 100);
    const plant_truth_t t = truth_of(&plant);
    TEST_ASSERT_TRUE(t.open[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, t.i_abc_A[0]);
    TEST_ASSERT_TRUE(fabs(t.i_abc_A[3]) > 1.0); // set 2 goes on
}

// ---------------------------------------------------------------------------------------------
// Sets apart

/// The diodes put the bus against the currents of the set that is off; the other set works on.
static void test_diodes_empty_a_set_that_is_off(void) {
    for (int level = 0; level < 2; level++) {
        plant_config_t c = lossy_config();
        c.level = level == 0 ? PLANT_AVERAGED : PLANT_SWITCHING;
        c.speed_is_prescribed = true;
        plant_t plant = new_plant(&c);
        for (int k = 0; k < 300; k++) {
            control_current(&plant, &c, 0.0, 8.0);
            plant_advance(&plant);
        }
        const plant_truth_t before = truth_of(&plant);
        for (int k = 0; k < 300; k++) {
            control_current(&plant, &c, 0.0, 4.0);
            gates_off(&plant, 1);
            plant_advance(&plant);
            const plant_truth_t t = truth_of(&plant);
            if (k >= 30) { // 16 A against 100 V and more through some 3 mH: less than a millisecond
                for (int n = 3; n < LEGS; n++) {
                    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, t.i_abc_A[n]);
                }
            }
        }
        const plant_truth_t t = truth_of(&plant);
        TEST_ASSERT_TRUE(fabs(before.i_abc_A[3]) + fabs(before.i_abc_A[4]) > 5.0);
        TEST_ASSERT_TRUE(t.torque_Nm > 3.0); // set 1 alone
        plant_t again = plant;
        for (int k = 0; k < 100; k++) {
            control_current(&again, &c, 0.0, 8.0);
            plant_advance(&again);
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.5, 8.0, truth_of(&again).iq_A);
    }
}

static void test_trip_of_one_set(void) {
    plant_config_t c = bench_config();
    c.level = PLANT_SWITCHING;
    plant_t plant = new_plant(&c);
    plant_counts_t counts[SETS];
    write_voltage(&plant, 8.0, 0.0);
    advance(&plant, 100);
    plant_set_trip_of(&plant, 1, true);
    plant_sample(&plant, counts, NULL);
    TEST_ASSERT_FALSE(counts[0].trip);
    TEST_ASSERT_TRUE(counts[1].trip);
    advance(&plant, 40);
    plant_truth_t t = truth_of(&plant);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, t.i_abc_A[3]);
    TEST_ASSERT_TRUE(t.i_abc_A[0] > 3.0);
    plant_set_trip(&plant, true);
    advance(&plant, 40);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, truth_of(&plant).i_abc_A[0]);
    plant_sample(&plant, counts, NULL);
    TEST_ASSERT_TRUE(counts[0].trip && counts[1].trip);
    plant_set_trip(&plant, false);
    advance(&plant, 100);
    t = truth_of(&plant);
    TEST_ASSERT_TRUE(t.i_abc_A[0] > 3.0 && t.i_abc_A[3] > 3.0);
}

static void test_six_converters_on_one_bus(void) {
    plant_config_t c = bench_config();
    c.adc_bits = 16;
    c.i_A_per_count = 1e-3;
    c.v_bus_noise_V = 0.5;
    c.i_offset_A[4] = 0.25;
    c.i_gain_error[5] = 0.1;
    plant_t plant = new_plant(&c);
    write_voltage(&plant, 6.0 + 3.0 * I, 1.0 - 2.0 * I);
    advance(&plant, 200);
    plant_counts_t counts[SETS];
    plant_truth_t t;
    plant_sample(&plant, counts, &t);
    for (int n = 0; n < LEGS; n++) {
        const double seen = (counts[n / 3].i[n % 3] - 32768) * 1e-3;
        const double gain = n == 5 ? 1.1 : 1.0, offset = n == 4 ? 0.25 : 0.0;
        TEST_ASSERT_DOUBLE_WITHIN(0.51e-3, gain * t.i_abc_A[n] + offset, seen);
    }
    TEST_ASSERT_EQUAL_UINT16(counts[0].v_bus, counts[1].v_bus);
    TEST_ASSERT_EQUAL_UINT16(counts[0].temperature, counts[1].temperature);
    TEST_ASSERT_EQUAL_UINT32(counts[0].stamp, counts[1].stamp);
}

// ---------------------------------------------------------------------------------------------
// Energy

static double balance_error_J(const plant_energy_t *e, double stored_at_start_J) {
    return e->bus_J - e->copper_J - e->inverter_J - e->friction_J - e->load_J -
           (e->field_J + e->kinetic_J - stored_at_start_J);
}

typedef struct {
    plant_level_t level;
    int open_from; // a phase breaks; -1: none
    bool set_off;  // for a while
    const char *name;
} journey_t;

/// Accelerates, carries load, brakes, with all harmonics: what comes out of the bus is found again.
static void check_energy(const journey_t *journey) {
    plant_config_t c = lossy_config();
    c.level = journey->level;
    c.load_is_passive = true;
    c.load_Nm = 1.5;
    c.B_Nms = 0.01;
    c.emf5_ratio = 0.05;
    c.emf7_ratio = 0.04;
    c.emf7_phase_rad = 1.0;
    c.emf11_ratio = 0.02;
    c.i_sat_A = 15.0;
    c.Lq_sat_H = 8e-3;
    c.id_sat_A = 5.0;
    c.Ld_sat_H = 0.8 * c.Ld_H;
    c.i_cross_A = 8.0;
    c.Ldq_H = 0.1 * c.Ld_H;
    plant_t plant = new_plant(&c);
    const double start_J = truth_of(&plant).energy.kinetic_J;
    double throughput_J = 0.0, last_J = 0.0;
    for (int k = 0; k < 6000; k++) {
        control_current(&plant, &c, -2.0, k < 2500 ? 6.0 : (k < 5000 ? -4.0 : 4.0));
        if (journey->set_off && k > 2000 && k < 4000) {
            gates_off(&plant, 1);
        }
        if (k == journey->open_from) {
            plant_open_phase(&plant, 2);
        }
        plant_advance(&plant);
        const plant_energy_t e = truth_of(&plant).energy;
        throughput_J += fabs(e.bus_J - last_J);
        last_J = e.bus_J;
    }
    const plant_energy_t e = truth_of(&plant).energy;
    const double error = fabs(balance_error_J(&e, start_J)) / throughput_J;
    printf("  energy, %s: throughput %.1f J, copper %.2f, inverter %.3f, load %.2f, friction %.2f, "
           "error %.1e\n",
           journey->name, throughput_J, e.copper_J, e.inverter_J, e.load_J, e.friction_J, error);
    TEST_ASSERT_TRUE(throughput_J > 100.0 && e.copper_J > 10.0 && e.load_J > 5.0);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, 0.0, error, journey->name);
    const double electrical_J = e.bus_J - e.inverter_J - e.copper_J - e.field_J - e.shaft_J;
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5 * throughput_J, 0.0, electrical_J, journey->name);
}

static void test_energy_balance(void) {
    const journey_t journeys[] = {
        {PLANT_AVERAGED, -1, false, "averaged"},
        {PLANT_AVERAGED, 1000, false, "averaged, phase broken"},
        {PLANT_AVERAGED, -1, true, "averaged, set off"},
        {PLANT_SWITCHING, -1, false, "switching"},
        {PLANT_SWITCHING, 1000, false, "switching, phase broken"},
        {PLANT_SWITCHING, -1, true, "switching, set off"},
        {PLANT_SWITCHING, 1000, true, "switching, phase broken, set off"},
    };
    for (size_t n = 0; n < sizeof journeys / sizeof journeys[0]; n++) {
        check_energy(&journeys[n]);
    }
}

static double uniform(plant_noise_t *noise, double low, double high) {
    return low + (high - low) * 0.5 * erfc(-plant_noise_next(noise) / sqrt(2.0));
}

static plant_config_t random_config(plant_noise_t *noise) {
    plant_config_t c = lossy_config();
    c.pole_pairs = 1 + (int)uniform(noise, 0.0, 7.99);
    c.period_s = uniform(noise, 50e-6, 200e-6);
    c.Ld_H = 100e-6 * pow(100.0, uniform(noise, 0.0, 1.0));
    c.Lq_H = c.Ld_H * uniform(noise, 0.5, 6.0);
    c.Lxy_H = c.Ld_H * uniform(noise, 0.1, 2.0);
    c.Rs_Ohm = c.Ld_H / uniform(noise, 1e-3, 20e-3);
    c.omega_m_rad_s = uniform(noise, -800.0, 800.0) / c.pole_pairs;
    c.psi_Wb = uniform(noise, 0.01, 1.2) * c.v_bus_V / sqrt(3.0) / 800.0;
    c.J_kgm2 = 2e-4 * pow(100.0, uniform(noise, 0.0, 1.0));
    c.load_is_passive = uniform(noise, 0.0, 1.0) > 0.5;
    c.load_Nm = uniform(noise, -1.0, 1.0);
    c.emf5_ratio = fmax(0.0, uniform(noise, -0.1, 0.1));
    c.emf11_ratio = fmax(0.0, uniform(noise, -0.05, 0.05));
    c.v_diode_V = fmax(0.0, uniform(noise, -2.0, 2.0));
    c.dead_time_s = fmax(0.0, uniform(noise, -0.02, 0.04)) * c.period_s;
    c.theta_e_rad = uniform(noise, -3.0, 3.0);
    return c;
}

/// Whatever motor, duties, gates and breaks: finite, neutrals without current, a closed book.
static void test_random_motors_stay_consistent(void) {
    plant_noise_t noise;
    double worst = 0.0;
    int fewest_left = 1000;
    plant_noise_init(&noise, 20220506);
    for (int motor = 0; motor < 200; motor++) {
        const plant_config_t c = random_config(&noise);
        plant_t plant = new_plant(&c);
        const double start_J = truth_of(&plant).energy.kinetic_J;
        const double swing = motor % 4 == 0 ? 0.0 : uniform(&noise, 0.0, 0.3);
        double throughput_J = start_J;
        plant_energy_t last = truth_of(&plant).energy;
        for (int k = 0; k < 300; k++) {
            double duty[LEGS];
            for (int n = 0; n < LEGS; n++) {
                duty[n] = 0.5 + swing * plant_noise_next(&noise);
            }
            plant_write_set(&plant, 0, duty, (k / 50) % 3 != 2);
            plant_write_set(&plant, 1, &duty[3], (k / 40) % 3 != 1);
            if (k == 60 || k == 160 || k == 240) {
                plant_open_phase(&plant, (motor + k) % LEGS);
            }
            plant_advance(&plant);
            const plant_truth_t t = truth_of(&plant);
            throughput_J +=
                fabs(t.energy.bus_J - last.bus_J) + fabs(t.energy.shaft_J - last.shaft_J);
            last = t.energy;
            fewest_left = plant.events_left < fewest_left ? plant.events_left : fewest_left;
            TEST_ASSERT_TRUE(isfinite(t.id_A) && isfinite(t.i_x_A) && isfinite(t.omega_m_rad_s));
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, t.i_abc_A[0] + t.i_abc_A[1] + t.i_abc_A[2]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, t.i_abc_A[3] + t.i_abc_A[4] + t.i_abc_A[5]);
            for (int n = 0; n < LEGS; n++) {
                TEST_ASSERT_TRUE(!t.open[n] || fabs(t.i_abc_A[n]) < 1e-9);
            }
        }
        const plant_energy_t e = truth_of(&plant).energy;
        TEST_ASSERT_TRUE(e.copper_J >= 0.0 && e.friction_J >= 0.0 && e.inverter_J >= -1e-9);
        worst = fmax(worst, fabs(balance_error_J(&e, start_J)) / throughput_J);
    }
    printf("  random motors: worst energy error %.1e, most events in a period %d\n", worst,
           200 - fewest_left);
    TEST_ASSERT_TRUE(worst < 5e-4);
    TEST_ASSERT_TRUE(fewest_left > 100);
}

// ---------------------------------------------------------------------------------------------
// Configuration

static void check_refused(const plant_config_t *c) {
    plant_t plant, untouched;
    memset(&plant, 0x5A, sizeof plant);
    memcpy(&untouched, &plant, sizeof plant);
    TEST_ASSERT_NOT_NULL(plant_init(&plant, c));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &plant, sizeof plant);
}

static void test_bad_configurations_are_refused(void) {
    plant_config_t c = bench_config();
    c.sets = 3;
    check_refused(&c);
    c = bench_config();
    c.Lxy_H = 0.0;
    check_refused(&c);
    c = bench_config();
    c.emf11_ratio = -0.1;
    check_refused(&c);
    c = bench_config();
    c.emf13_phase_rad = (double)NAN;
    check_refused(&c);
    c = bench_config();
    c.i_offset_A[5] = (double)NAN;
    check_refused(&c);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_rl_step_in_both_planes);
    RUN_TEST(test_xy_plane_by_exact_recursion);
    RUN_TEST(test_both_sets_alike_are_three_phases);
    RUN_TEST(test_torque);
    RUN_TEST(test_emf_of_all_phases);
    RUN_TEST(test_xy_harmonic_currents);
    RUN_TEST(test_torque_ripple_of_a_broken_phase);
    RUN_TEST(test_phase_opens_at_zero_current);
    RUN_TEST(test_phase_opens_at_rest);
    RUN_TEST(test_diodes_empty_a_set_that_is_off);
    RUN_TEST(test_trip_of_one_set);
    RUN_TEST(test_six_converters_on_one_bus);
    RUN_TEST(test_energy_balance);
    RUN_TEST(test_random_motors_stay_consistent);
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_switching_matches_reference);
    RUN_TEST(test_set_off_matches_reference);
    RUN_TEST(test_open_phase_matches_reference);
    return UNITY_END();
}
