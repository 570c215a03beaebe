/// Many edges in one loop (linear.h) against a step from edge to edge: every machine of the catalogue both ways, under
/// the same duties. A plant that keeps accounts goes from edge to edge.
#include "config/data_files.h"
#include "plant/plant.h"

#include "support/check.h"

#include <complex.h>
#include <math.h>
#include <stdio.h>

#define PI 3.14159265358979323846

enum { PERIODS = 400 };

void setUp(void) {}

void tearDown(void) {}

/// Where a machine is looked at: the EMF as a share of what the bus gives, the current of the drive's.
typedef struct {
    const char *what;
    double emf, i_q, i_d;
    bool free_shaft;
} point_t;

static plant_config_t machine(const char *name, double *i_max_A) {
    static rig_config_t config;
    plant_config_t plant;
    double load_Nm = 0.0;
    rig_config_init(&config);
    TEST_ASSERT_TRUE(data_files_load_part(&config, "motors", name));
    TEST_ASSERT_TRUE(data_files_load_part(&config, "drives", name));
    TEST_ASSERT_TRUE(rig_config_complete(&config, RIG_NEED_MOTOR));
    rig_config_design(&config);
    TEST_ASSERT_TRUE(rig_config_plant(&config, &plant, &load_Nm));
    plant.level = PLANT_SWITCHING;
    plant.load_is_passive = false;
    plant.dead_time_s = plant.dead_time_s > 0.0 ? plant.dead_time_s : 0.01 * plant.period_s;
    *i_max_A = (double)config.drive.inverter.i_max_A;
    return plant;
}

static void write_voltage(plant_t *plant, double complex u_V) {
    for (int set = 0; set < plant->sets; set++) {
        double duty[PLANT_PHASES];
        for (int n = 0; n < PLANT_PHASES; n++) {
            const int leg = set * PLANT_PHASES + n;
            const double complex axis = plant_axis_cos[leg] - I * plant_axis_sin[leg];
            duty[n] = 0.5 + creal(u_V * axis) / plant->inverter.v_bus_V;
        }
        plant_write_set(plant, set, duty, PLANT_GATES_ON);
    }
}

/// Feed-forward of what the machine needs, and a slow pull to the reference.
static void control(plant_t *plant, const plant_config_t *c, double complex i_ref_A) {
    plant_truth_t t;
    plant_sample(plant, NULL, &t);
    const double w = t.omega_e_rad_s;
    const double d = 0.2 / c->period_s * c->Ld_H * (creal(i_ref_A) - t.id_A);
    const double q = 0.2 / c->period_s * c->Lq_H * (cimag(i_ref_A) - t.iq_A);
    const double ud = c->Rs_Ohm * t.id_A - w * c->Lq_H * t.iq_A + d;
    const double uq = c->Rs_Ohm * t.iq_A + w * (c->psi_Wb + c->Ld_H * t.id_A) + q;
    write_voltage(plant, (ud + I * uq) * cexp(I * (t.theta_e_rad + 1.5 * w * c->period_s)));
}

typedef struct {
    double i_A, theta_rad;
} difference_t;

static difference_t run_both(const plant_config_t *c, double complex i_ref_A) {
    plant_config_t edges = *c;
    plant_t merged, edge;
    difference_t worst = {0.0, 0.0};
    edges.keeps_accounts = true;
    TEST_ASSERT_NULL(plant_init(&merged, c));
    TEST_ASSERT_NULL(plant_init(&edge, &edges));
    // Steps ten times as short: with its own the edge to edge plant is the less accurate of the two.
    edge.motor.iron.smallest_L_H *= 0.01;
    for (int k = 0; k < PERIODS; k++) {
        plant_truth_t a, b;
        control(&edge, c, i_ref_A);
        for (int set = 0; set < edge.sets; set++) {
            plant_write_set(&merged, set, &edge.next_duty[set * PLANT_PHASES], PLANT_GATES_ON);
        }
        plant_advance(&merged);
        plant_advance(&edge);
        plant_sample(&merged, NULL, &a);
        plant_sample(&edge, NULL, &b);
        for (int n = 0; n < edge.sets * PLANT_PHASES; n++) {
            worst.i_A = fmax(worst.i_A, fabs(a.i_abc_A[n] - b.i_abc_A[n]));
        }
        const double off_rad = remainder(a.theta_e_rad - b.theta_e_rad, 2.0 * PI);
        worst.theta_rad = fmax(worst.theta_rad, fabs(off_rad));
    }
    return worst;
}

static bool check_machine(void *user, const char *name) {
    static const point_t points[] = {
        {"slow, half current", 0.05, 0.5, 0.0, false},
        {"fast, no current", 0.5, 0.0, 0.0, false},
        {"fast, half current", 0.5, 0.5, -0.2, false},
        {"free shaft, half current", 0.3, 0.5, 0.0, true},
    };
    double i_max_A = 0.0;
    plant_config_t c = machine(name, &i_max_A);
    (void)user;
    for (size_t n = 0; n < sizeof points / sizeof points[0]; n++) {
        const point_t *at = &points[n];
        const double complex i_ref_A = (at->i_d + I * at->i_q) * i_max_A;
        const double flux = hypot(c.psi_Wb + c.Ld_H * creal(i_ref_A), c.Lq_H * cimag(i_ref_A));
        char text[120];
        c.omega_m_rad_s = at->emf * c.v_bus_V / sqrt(3.0) / flux / c.pole_pairs;
        c.speed_is_prescribed = !at->free_shaft;
        const difference_t worst = run_both(&c, i_ref_A);
        (void)snprintf(text, sizeof text, "%s, %s: %.1e of i_max, %.1e rad", name, at->what,
                       worst.i_A / i_max_A, worst.theta_rad);
        // A tenth of a count of a 12-bit ADC, whose range is 2 i_max or more, and 2e-5 A, to which
        // instants of zero current are found, in both; a third of the hundredth of a degree that pages give.
        TEST_ASSERT_TRUE_MESSAGE(worst.i_A < 5e-5 * i_max_A + 4e-5, text);
        TEST_ASSERT_TRUE_MESSAGE(worst.theta_rad < 5e-5, text);
    }
    return true;
}

static void test_many_edges_at_once_are_the_same(void) {
    TEST_ASSERT_TRUE(data_files_pairs(check_machine, NULL));
}

/// Large drops, and currents that pass zero in every period: what a reversal takes from the voltage, from its instant on.
static void test_reversals_of_currents(void) {
    double i_max_A = 0.0;
    plant_config_t c = machine("jiang2022", &i_max_A);
    c.v_transistor_V = c.v_diode_V = 6.0;
    c.speed_is_prescribed = true;
    for (int k = 1; k <= 7; k++) {
        c.omega_m_rad_s = 0.08 * k * c.v_bus_V / sqrt(3.0) / c.psi_Wb / c.pole_pairs;
        const difference_t worst = run_both(&c, 0.0);
        char text[80];
        (void)snprintf(text, sizeof text, "%g rad/s: %.2e A", c.omega_m_rad_s, worst.i_A);
        // Twice what counts as zero. With the reversal where a straight line has it: 5e-4 A.
        TEST_ASSERT_TRUE_MESSAGE(worst.i_A < 4e-5, text);
    }
}

/// All low sides on, phase a next to zero and with a slope that is 0 but for `more_V`, which the EMF soon takes back.
static void put_at_turning_point(plant_t *plant, double more_V) {
    static const double none[PLANT_PHASES] = {0.0, 0.0, 0.0};
    static const int sign[PLANT_PHASES] = {1, 1, -1};
    plant_motor_state_t *x = &plant->motor.x;
    for (int k = 0; k < 3; k++) {
        plant_write_set(plant, 0, none, PLANT_GATES_ON);
        plant_advance(plant);
    }
    const double w = plant->motor.np * x->omega_m_rad_s;
    // The currents' signs put a and b 1 V below the negative rail and c 1 V above: a has -2/3 V.
    x->theta_e_rad = PI - asin((2.0 / 3.0 + more_V) / (w * plant->motor.psi_Wb));
    plant_motor_refresh_angle(&plant->motor);
    const double ia = 1e-6, ib = 2.0, beta = (ia + 2.0 * ib) / sqrt(3.0);
    x->id_A = ia * x->cos_theta + beta * x->sin_theta;
    x->iq_A = beta * x->cos_theta - ia * x->sin_theta;
    for (int n = 0; n < PLANT_PHASES; n++) {
        plant->inverter.leg[n].sign = sign[n];
    }
}

/// A current that leaves zero and comes back has a second zero: the search must not stay at the first.
static void test_current_comes_back_to_zero(void) {
    plant_config_t c = plant_config_jiang2022();
    c.keeps_accounts = false;
    c.Lq_H = c.Ld_H;
    c.v_transistor_V = c.v_diode_V = 1.0;
    c.speed_is_prescribed = true;
    c.omega_m_rad_s = 20.0;
    for (double more_V = 1e-6; more_V < 0.1; more_V *= 1.2) {
        plant_t merged, edge;
        plant_truth_t a, b;
        TEST_ASSERT_NULL(plant_init(&merged, &c));
        put_at_turning_point(&merged, more_V);
        edge = merged;
        edge.motor.is_plain = false; // so it goes from edge to edge
        plant_advance(&merged);
        plant_advance(&edge);
        plant_sample(&merged, NULL, &a);
        plant_sample(&edge, NULL, &b);
        TEST_ASSERT_TRUE(merged.events_left >= edge.events_left - 2);
        for (int n = 0; n < PLANT_PHASES; n++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, b.i_abc_A[n], a.i_abc_A[n]);
        }
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_many_edges_at_once_are_the_same);
    RUN_TEST(test_reversals_of_currents);
    RUN_TEST(test_current_comes_back_to_zero);
    return UNITY_END();
}
