// From torque to currents: inverse of the torque equation, circle, low-speed bias; MTPA, field weakening
// and MTPV against the best of all currents; limits that follow the bus.
#include "golden/references.h"
#include "support/fields.h"

#include "references_inline.h"

void setUp(void) {}

void tearDown(void) {}

#define I_MAX_A 12.0f

static const lode_inverter_config_t inverter = {.v_bus_V = 200.0f, .i_max_A = I_MAX_A};

#define VOLTAGE_USE 0.95f
#define CALL_s 4.0e-4f

static lode_references_config_t sound(void) {
    lode_references_config_t config = {
        .id_bias_A = 3.0f, .omega_low_rad_s = 60.0f, .omega_high_rad_s = 110.0f};
    const lode_motor_t motor = paper_motor();
    lode_references_design(&config, &inverter, &motor);
    return config;
}

static lode_references_tuning_t tuned(const lode_references_config_t *config) {
    const lode_motor_t motor = paper_motor();
    lode_references_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_references_tune(&tuning, config, &inverter, &motor, VOLTAGE_USE, CALL_s));
    return tuning;
}

/// One call of a drive at rest with all of its bus.
static lode_dq_t step(const lode_references_tuning_t *tuning, float torque_Nm, float omega_rad_s,
                      float id_add_A) {
    lode_references_t self;
    lode_references_reset(&self, 0.0f);
    const lode_references_voltage_t voltage = {200.0f, {0.0f, 0.0f}};
    return lode_references_step(&self, tuning, torque_Nm, omega_rad_s, id_add_A, voltage).i_A;
}

/// Eq. (17) for Table 3's motor.
static double torque_of(double id, double iq) {
    return 4.5 * (0.142 + (3.5e-3 - 9.8e-3) * id) * iq;
}

/// What auto stands for at this largest current.
static int kind_at(float i_max_A, lode_motor_t motor) {
    lode_inverter_config_t limited = inverter;
    limited.i_max_A = i_max_A;
    lode_references_config_t config = {.kind = LODE_REFERENCES_AUTO};
    lode_references_design(&config, &limited, &motor);
    return (int)config.kind;
}

/// What an observer with the Lq of no current takes for the active flux, and where it then stands.
static void test_a_q_axis_that_saturates_turns_the_angle_by_what_its_flux_lacks(void) {
    lode_references_config_t config = sound();
    config.Lq_fall = 0.05f;
    const lode_references_tuning_t tuning = tuned(&config);
    for (int n = 0; n < 30; n++) {
        const double id = -4.0 + (double)(n % 3) * 3.0;
        const double iq = -12.0 + 24.0 / 29.0 * n;
        const double flux_q = 9.8e-3 * iq / (1.0 + 0.05 * fabs(iq));
        const double seen_d = 0.142 + (3.5e-3 - 9.8e-3) * id;
        const double seen_q = flux_q - 9.8e-3 * iq;
        const lode_sincos_t seen = sincos_of(2.0 + atan2(seen_q, seen_d));
        const lode_sincos_t rotor =
            lode_references_saturated(&tuning, seen, (lode_dq_t){(float)id, (float)iq});
        CHECK_NEAR(1e-5, sin(2.0), rotor.sin);
        CHECK_NEAR(1e-5, cos(2.0), rotor.cos);
    }
    // Whatever the current, by an eighth of a turn at most.
    const lode_sincos_t most =
        lode_references_saturated(&tuning, (lode_sincos_t){0.0f, 1.0f}, (lode_dq_t){90.0f, 900.0f});
    CHECK_NEAR(1e-5, sqrt(0.5), most.sin);
    const lode_sincos_t least = lode_references_saturated(&tuning, (lode_sincos_t){0.0f, 1.0f},
                                                          (lode_dq_t){90.0f, -900.0f});
    CHECK_NEAR(1e-5, -sqrt(0.5), least.sin);
}

static void test_much_reluctance_asks_for_mtpa(void) {
    lode_motor_t motor = paper_motor();
    // Half of (R15): 4 0.1 Lq (Lq - Ld) i^2 = psi^2/2
    const float bound_A = 0.142f / lode_sqrt(0.8f * motor.Lq_H * (motor.Lq_H - motor.Ld_H));
    TEST_ASSERT_EQUAL_INT(LODE_REFERENCES_ID0, kind_at(0.99f * bound_A, motor));
    TEST_ASSERT_EQUAL_INT(LODE_REFERENCES_MTPA, kind_at(1.01f * bound_A, motor));
    motor.Ld_H = 2.0f * motor.Lq_H; // reluctance that adds to the flux
    TEST_ASSERT_EQUAL_INT(LODE_REFERENCES_ID0, kind_at(10.0f * bound_A, motor));
    lode_references_config_t given = {.kind = LODE_REFERENCES_ID0};
    const lode_inverter_config_t large = {.v_bus_V = 200.0f, .i_max_A = 1000.0f};
    const lode_motor_t paper = paper_motor();
    lode_references_design(&given, &large, &paper);
    TEST_ASSERT_EQUAL_INT(LODE_REFERENCES_ID0, given.kind);
}

static void test_at_speed_id_is_zero(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    for (int sign = -1; sign <= 1; sign += 2) {
        const lode_dq_t i = step(&tuning, 5.0f * (float)sign, 300.0f, 0.0f);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, i.d);
        CHECK_CLOSE(1.0e-6, sign * 5.0 / 0.639, i.q);
    }
}

static void test_bias_fades_with_speed(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    const double table[][2] = {{0.0, -3.0},   {60.0, -3.0}, {85.0, -1.5},
                               {100.0, -0.6}, {110.0, 0.0}, {500.0, 0.0}};
    for (int i = 0; i < COUNT_OF(table); i++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const float omega = (float)(sign * table[i][0]);
            const lode_dq_t ref = step(&tuning, 2.0f, omega, 0.0f);
            CHECK_NEAR(2.0e-6, table[i][1], ref.d);
            // The torque stays what was asked for, with the reluctance torque of the bias.
            CHECK_NEAR(2.0e-6, 2.0, torque_of((double)ref.d, (double)ref.q));
        }
    }
}

static void test_no_bias(void) {
    lode_references_config_t config = sound();
    config.id_bias_A = LODE_NONE;
    const lode_references_tuning_t tuning = tuned(&config);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, step(&tuning, 2.0f, 0.0f, 0.0f).d);
}

static void test_start_current_is_added_to_d(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    CHECK_NEAR(1.0e-6, 4.5, step(&tuning, 2.0f, 300.0f, 4.5f).d);
    CHECK_NEAR(1.0e-6, 1.5, step(&tuning, 2.0f, 10.0f, 4.5f).d);
    const lode_dq_t i = step(&tuning, -1.0f, 300.0f, 4.5f);
    CHECK_NEAR(2.0e-6, -1.0, torque_of((double)i.d, (double)i.q));
}

static void test_circle_holds_with_d_first(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    random_t random = random_seed(1);
    for (int n = 0; n < CHECK_TRIES(100000); n++) {
        const float torque = random_float(&random, -30.0, 30.0);
        const float omega = random_float(&random, -200.0, 200.0);
        const float add = random_float(&random, -15.0, 15.0);
        const lode_dq_t i = step(&tuning, torque, omega, add);
        const double speed = fabs((double)omega);
        const double share = fmax(0.0, fmin(1.0, (110.0 - speed) / 50.0));
        const double id = fmax(-12.0, fmin(12.0, (double)add - 3.0 * share));
        CHECK_NEAR(5.0e-6, id, i.d);
        CHECK_AT_MOST(12.0 * (1.0 + 1.0e-6), hypot((double)i.d, (double)i.q));
        TEST_ASSERT_TRUE(i.q * torque >= 0.0f);
    }
}

static void test_limit_of_torque(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    CHECK_NEAR(1.0e-5, 12.0, step(&tuning, 100.0f, 300.0f, 0.0f).q);
    CHECK_NEAR(1.0e-5, -12.0, step(&tuning, -100.0f, -300.0f, 0.0f).q);
    CHECK_NEAR(1.0e-5, sqrt(144.0 - 9.0), step(&tuning, 100.0f, 0.0f, 0.0f).q);
    CHECK_NEAR(0.01, 0.0, step(&tuning, 100.0f, 300.0f, 20.0f).q);
}

static void test_torque_is_the_inverse(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    random_t random = random_seed(2);
    for (int n = 0; n < 10000; n++) {
        // Inside the circle for every id from -5 to 5 A.
        const float torque = random_float(&random, -5.0, 5.0);
        const lode_dq_t i = step(&tuning, torque, random_float(&random, -200.0, 200.0),
                                 random_float(&random, -2.0, 5.0));
        CHECK_NEAR(1.0e-5, torque, lode_references_torque_Nm(&tuning, i));
        CHECK_NEAR(1.0e-5, torque_of((double)i.d, (double)i.q),
                   lode_references_torque_Nm(&tuning, i));
    }
}

static void test_any_input_stays_in_the_circle(void) {
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    random_t random = random_seed(3);
    for (int n = 0; n < CHECK_TRIES(300000); n++) {
        const lode_dq_t i =
            step(&tuning, random_any(&random), random_any(&random), random_any(&random));
        CHECK_AT_MOST(12.0 * (1.0 + 1.0e-6), hypot((double)i.d, (double)i.q));
    }
}

/// A drive of a motor of the table, and a circuit that answers with the voltage of its references.
typedef struct {
    lode_references_tuning_t tuning;
    lode_references_t self;
    lode_references_out_t out;
    lode_references_voltage_t voltage;
    double R, Ld, Lq, psi, i_max, V;
    float factor;
} rig_t;

static rig_t rig_of(int number, bool mtpa, const lode_references_config_t *given) {
    const double *m = references_motors[number];
    rig_t rig = {.R = m[0], .Ld = m[1], .Lq = m[2], .psi = m[3], .i_max = m[4], .V = m[5]};
    const lode_motor_t motor = {.pole_pairs = 4.0f,
                                .Rs_Ohm = (float)rig.R,
                                .Ld_H = (float)rig.Ld,
                                .Lq_H = (float)rig.Lq,
                                .psi_Wb = (float)rig.psi,
                                .omega_rated_rad_s = 1.0f};
    const float use = VOLTAGE_USE * 0.95f;
    const lode_inverter_config_t stage = {.v_bus_V = (float)rig.V * LODE_SQRT3 / use,
                                          .i_max_A = (float)rig.i_max};
    lode_references_config_t config = *given;
    config.kind = mtpa ? LODE_REFERENCES_MTPA : LODE_REFERENCES_ID0;
    config.id_bias_A = LODE_NONE;
    lode_references_design(&config, &stage, &motor);
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_references_tune(&rig.tuning, &config, &stage, &motor, VOLTAGE_USE, CALL_s));
    rig.factor = 6.0f;
    rig.voltage.v_bus_V = stage.v_bus_V;
    lode_references_reset(&rig.self, 0.0f);
    return rig;
}

static const lode_references_config_t weakening = {.field_weakening = LODE_ON};

static double rig_voltage(const rig_t *rig, double omega, lode_dq_t i, double Lq) {
    const double ud = rig->R * (double)i.d - omega * Lq * (double)i.q;
    const double uq = rig->R * (double)i.q + omega * (rig->psi + rig->Ld * (double)i.d);
    return hypot(ud, uq);
}

static void rig_step(rig_t *rig, double omega, double tau) {
    const float torque = rig->factor * (float)tau;
    rig->out =
        lode_references_step(&rig->self, &rig->tuning, torque, (float)omega, 0.0f, rig->voltage);
    rig->voltage.u_V = (lode_dq_t){(float)rig_voltage(rig, omega, rig->out.i_A, rig->Lq), 0.0f};
}

/// Long enough for the trim.
static void rig_settle(rig_t *rig, double omega, double tau) {
    for (int n = 0; n < 4000; n++) {
        rig_step(rig, omega, tau);
    }
}

static double rig_tau(const rig_t *rig) {
    const lode_dq_t i = rig->out.i_A;
    return (rig->psi + (rig->Ld - rig->Lq) * (double)i.d) * (double)i.q;
}

static void test_currents_are_the_best_of_all(void) {
    worst_t torque = {0.0};
    worst_t most = {0.0};
    worst_t last = {0.0};
    worst_t amplitude = {0.0};
    worst_t voltage = {0.0};
    worst_t beyond = {0.0}; // where all of the circle is not enough
    for (int n = 0; n < COUNT_OF(references_cases); n++) {
        const references_case_t *c = &references_cases[n];
        rig_t rig = rig_of(c->motor, c->mtpa != 0, &weakening);
        rig_settle(&rig, c->omega_rad_s, c->tau);
        const double best = (rig.psi + (rig.Ld - rig.Lq) * c->id_A) * c->iq_A;
        const lode_dq_t i = rig.out.i_A;
        char text[160];
        (void)snprintf(text, sizeof text, "case %d: (%.4f, %.4f), best (%.4f, %.4f)", n,
                       (double)i.d, (double)i.q, c->id_A, c->iq_A);
        // At the end of the circle, id = -i_max, iq falls from 2 % of i_max to 0 within 0.02 % of id.
        const bool end = c->id_A < -0.98 * rig.i_max;
        const double share = fabs(rig_tau(&rig) - best) / (rig.psi * rig.i_max);
        TEST_ASSERT_TRUE_MESSAGE(share <= (c->reached ? 1.0e-5 : (end ? 0.012 : 1.0e-5)), text);
        TEST_ASSERT_TRUE_MESSAGE(hypot((double)i.d, (double)i.q) <=
                                     1.005 * hypot(c->id_A, c->iq_A) + 0.002 * rig.i_max,
                                 text);
        worst_note(c->reached ? &torque : (end ? &last : &most), share);
        worst_note(&amplitude,
                   (hypot((double)i.d, (double)i.q) - hypot(c->id_A, c->iq_A)) / rig.i_max);
        const double u = rig_voltage(&rig, c->omega_rad_s, i, rig.Lq);
        worst_note(c->reached ? &voltage : &beyond, fmax(0.0, u / rig.V - 1.0));
    }
    printf("worst of %d: torque %.2e, largest torque %.2e (%.2e at id = -i_max) of psi i_max, "
           "amplitude %.2e of i_max, voltage %.2e too high\n",
           COUNT_OF(references_cases), torque.value, most.value, last.value, amplitude.value,
           voltage.value);
    CHECK_AT_MOST(1.0e-3, voltage.value);
    CHECK_AT_MOST(5.0e-3, beyond.value);
}

static void test_feed_forward_alone_is_close(void) {
    lode_references_config_t config = weakening;
    config.trim_rad_s = LODE_NONE;
    worst_t voltage = {0.0};
    worst_t torque = {0.0};
    for (int n = 0; n < COUNT_OF(references_cases); n++) {
        const references_case_t *c = &references_cases[n];
        rig_t rig = rig_of(c->motor, c->mtpa != 0, &config);
        rig_settle(&rig, c->omega_rad_s, c->tau);
        const double best = (rig.psi + (rig.Ld - rig.Lq) * c->id_A) * c->iq_A;
        worst_note(&torque, (rig_tau(&rig) - best) / (rig.psi * rig.i_max));
        const double u = rig_voltage(&rig, c->omega_rad_s, rig.out.i_A, rig.Lq);
        worst_note(&voltage, fmax(0.0, u / rig.V - 1.0));
    }
    printf("feed-forward alone: torque %.2e, voltage %.2e too high\n", torque.value, voltage.value);
    CHECK_AT_MOST(0.03, voltage.value);
}

static void test_mtpa_meets_its_condition(void) {
    // From no saliency at all to a reluctance machine with a little magnet, either way round.
    for (int n = -40; n <= 40; n++) {
        for (int share = 1; share <= 10; share++) {
            const double Lq = n < 0 ? 1.0e-3 : 1.0e-3 * (1.0 + 0.1 * n);
            const double Ld = n < 0 ? 1.0e-3 * (1.0 - 0.1 * n) : 1.0e-3;
            const lode_motor_t motor = {.pole_pairs = 4.0f,
                                        .Ld_H = (float)Ld,
                                        .Lq_H = (float)Lq,
                                        .psi_Wb = 0.01f,
                                        .omega_rated_rad_s = 1.0f};
            lode_references_config_t config = {.kind = LODE_REFERENCES_MTPA,
                                               .id_bias_A = LODE_NONE};
            lode_references_design(&config, &inverter, &motor);
            lode_references_tuning_t tuning;
            TEST_ASSERT_EQUAL_INT(LODE_OK, lode_references_tune(&tuning, &config, &inverter, &motor,
                                                                VOLTAGE_USE, CALL_s));
            const float torque = 0.1f * (float)share * 6.0f * tuning.tau_max;
            const lode_dq_t i = step(&tuning, torque, 300.0f, 0.0f);
            const double id = (double)i.d;
            const double iq = (double)i.q;
            // Along the curve dT/d(angle) = 0: psi id + (Ld - Lq)(id^2 - iq^2) = 0. Off it by x the
            // torque is off its best by x^2: 1e-4 here.
            const double off = 0.01 * id + (Ld - Lq) * (id * id - iq * iq);
            CHECK_NEAR(1.0e-2 * (0.01 + fabs(Ld - Lq) * hypot(id, iq)) * hypot(id, iq), 0.0, off);
            CHECK_CLOSE(1.0e-4, (double)torque, 6.0 * (0.01 + (Ld - Lq) * id) * iq);
            if (share == 10) {
                CHECK_CLOSE(1.0e-3, 12.0, hypot(id, iq));
            }
        }
    }
}

static void test_signs_mirror(void) {
    random_t random = random_seed(5);
    for (int n = 0; n < 300; n++) {
        const int number = n % 3;
        rig_t one = rig_of(number, n % 2 == 0, &weakening);
        rig_t other = one;
        const double omega = random_between(&random, 0.3, 4.0) * one.V / one.psi;
        const double tau = random_between(&random, -1.5, 1.5) * one.psi * one.i_max;
        for (int k = 0; k < 200; k++) {
            rig_step(&one, omega, tau);
            rig_step(&other, -omega, -tau);
        }
        TEST_ASSERT_EQUAL_FLOAT(one.out.i_A.d, other.out.i_A.d);
        TEST_ASSERT_EQUAL_FLOAT(one.out.i_A.q, -other.out.i_A.q);
        TEST_ASSERT_EQUAL_FLOAT(one.out.torque_Nm.max, -other.out.torque_Nm.min);
        TEST_ASSERT_EQUAL_FLOAT(one.out.torque_Nm.min, -other.out.torque_Nm.max);
    }
}

/// Through entry and exit at constant torque the references move as little as the speed does.
static void test_entry_and_exit_are_smooth(void) {
    for (int number = 0; number < 3; number++) {
        for (int kind = 0; kind < 2; kind++) {
            rig_t rig = rig_of(number, kind == 1, &weakening);
            const double tau = (kind == 1 ? -0.25 : 0.25) * rig.psi * rig.i_max;
            const double base = rig.V / rig.psi;
            rig_settle(&rig, 0.5 * base, tau);
            const double id0 = (double)rig.out.i_A.d;
            lode_dq_t before = rig.out.i_A;
            worst_t move = {0.0};
            worst_t off = {0.0};
            double deepest = 0.0;
            const int half = 8000; // 0.5 to 1.3 times base in 3.2 s
            for (int n = 0; n <= 2 * half + 1000; n++) {
                const int k = n <= half ? n : (n <= 2 * half ? 2 * half - n : 0);
                rig_step(&rig, base * (0.5 + 0.8 * (double)k / (double)half), tau);
                worst_note(&move, hypot((double)(rig.out.i_A.d - before.d),
                                        (double)(rig.out.i_A.q - before.q)) /
                                      rig.i_max);
                worst_note(&off, rig_tau(&rig) / tau - 1.0);
                before = rig.out.i_A;
                deepest = fmin(deepest, (double)before.d);
            }
            CHECK_AT_MOST(id0 - 0.1 * rig.i_max, deepest);
            CHECK_NEAR(1.0e-3 * rig.i_max, id0, before.d);
            CHECK_AT_MOST(3.0e-3, move.value);
            CHECK_AT_MOST(1.0e-3, off.value);
        }
    }
}

static void test_torque_limit_is_what_can_be_had(void) {
    for (int number = 0; number < 3; number++) {
        for (int speed = 2; speed <= 12; speed++) {
            rig_t rig = rig_of(number, true, &weakening);
            const double omega = 0.25 * speed * rig.V / rig.psi;
            const double full = 2.0 * rig.psi * rig.i_max;
            rig_settle(&rig, omega, full);
            const lode_range_t limit = rig.out.torque_Nm;
            CHECK_AT_MOST(1.0e-3 * full, fabs((double)limit.max / 6.0 - rig_tau(&rig)));
            TEST_ASSERT_EQUAL_FLOAT(-limit.max, limit.min);
            CHECK_NEAR(1.0e-3 * (double)limit.max, (double)limit.max,
                       (double)lode_references_allowed_Nm(&rig.self, &rig.tuning, rig.out.i_A.d));
            // Exactly that much more asked for: the same.
            rig_settle(&rig, omega, (double)limit.max / 6.0);
            CHECK_NEAR(2.0e-3 * full, (double)limit.max / 6.0, rig_tau(&rig));
        }
    }
}

static void test_trim_absorbs_a_wrong_psi(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = rig_of(0, true, &weakening);
        rig.psi *= 1.0 + 0.08 * sign;
        rig_settle(&rig, 1.3 * rig.V / rig.psi, 0.3 * rig.psi * rig.i_max);
        CHECK_CLOSE(1.0e-3, rig.V, rig_voltage(&rig, 1.3 * rig.V / rig.psi, rig.out.i_A, rig.Lq));
        CHECK_AT_LEAST(0.04, fabs((double)rig.self.trim));
        // Gone below the voltage limit.
        rig_settle(&rig, 0.3 * rig.V / rig.psi, 0.3 * rig.psi * rig.i_max);
        CHECK_NEAR(1.0e-4, 0.0, rig.self.trim);
    }
}

static void test_trim_recovers_at_the_lowest_id(void) {
    rig_t rig = rig_of(0, true, &weakening);
    const double omega = 1.45 * rig.V / rig.psi;
    rig_settle(&rig, omega, 0.1);
    const double id = (double)rig.out.i_A.d;
    rig.self.trim = -0.15f;
    rig.self.id_A = -16.0f;
    rig_settle(&rig, omega, 0.1);
    CHECK_NEAR(0.01, id, rig.out.i_A.d);
}

static void test_torque_waits_for_the_flux(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        rig_t rig = rig_of(2, true, &weakening);
        const double omega = 1.5 * rig.V / rig.psi;
        rig_settle(&rig, omega, 0.0);
        for (int n = 0; n < 20; n++) {
            rig_step(&rig, omega, 10.0 * sign);
            CHECK_AT_MOST(1.03 * rig.V, rig_voltage(&rig, omega, rig.out.i_A, rig.Lq));
        }
        CHECK_CLOSE(1.0e-3, 10.0 * sign, rig_tau(&rig));
    }
}

static void test_id_rises_slowly(void) {
    lode_references_config_t config = weakening;
    config.release_s = 0.2f;
    rig_t rig = rig_of(0, false, &config);
    rig_settle(&rig, 1.6 * rig.V / rig.psi, 0.1);
    const double from = (double)rig.out.i_A.d;
    CHECK_AT_MOST(-8.0, from);
    int calls = 0;
    while (rig.out.i_A.d < 0.0f && calls < 10000) {
        rig_step(&rig, 0.2 * rig.V / rig.psi, 0.1);
        calls++;
    }
    CHECK_NEAR(2.0 * (double)CALL_s, -from / rig.i_max * 0.2, calls * (double)CALL_s);
    // And falls within milliseconds.
    calls = 0;
    while ((double)rig.out.i_A.d > 0.95 * from && calls < 10000) {
        rig_step(&rig, 1.6 * rig.V / rig.psi, 0.1);
        calls++;
    }
    CHECK_AT_MOST(5.0e-3, calls * (double)CALL_s);
}

static void test_without_a_trim_there_is_none(void) {
    lode_references_config_t config = sound();
    config.trim_rad_s = LODE_NONE;
    const lode_references_tuning_t tuning = tuned(&config);
    CHECK_NEAR(0.0, 0.0, tuning.trim_gain);
    CHECK_NEAR(0.0, 0.0, tuning.trim_decay);
}

static void test_bus_limits_braking_and_motoring(void) {
    lode_references_config_t config = sound();
    config.v_regen_V = 220.0f;
    config.v_bus_max_V = 250.0f;
    config.v_motor_V = 160.0f;
    config.v_bus_min_V = 120.0f;
    const lode_references_tuning_t tuning = tuned(&config);
    const double full = 12.0 * 4.5 * 0.142;
    const double table[][3] = {// bus, share of motoring, share of braking torque
                               {200.0, 1.0, 1.0}, {160.0, 1.0, 1.0}, {140.0, 0.5, 1.0},
                               {120.0, 0.0, 1.0}, {90.0, 0.0, 1.0},  {220.0, 1.0, 1.0},
                               {235.0, 1.0, 0.5}, {250.0, 1.0, 0.0}, {300.0, 1.0, 0.0}};
    for (int n = 0; n < COUNT_OF(table); n++) {
        for (int k = 0; k < 10; k++) {
            const float size = k & 4 ? 0.5f : 300.0f; // nearly at rest too
            const float omega = k >= 8 ? 0.0f : (k & 1 ? size : -size);
            const float torque = (k >= 8 ? k & 1 : k & 2) ? 20.0f : -20.0f;
            const bool forward = omega >= 0.0f; // at rest as well
            const double share = forward == (torque > 0.0f) ? table[n][1] : table[n][2];
            lode_references_t self;
            lode_references_reset(&self, 0.0f);
            const lode_references_voltage_t voltage = {(float)table[n][0], {0.0f, 0.0f}};
            const lode_references_out_t out =
                lode_references_step(&self, &tuning, torque, omega, 0.0f, voltage);
            const double wanted = share * (torque > 0.0f ? full : -full);
            CHECK_NEAR(2.0e-5, wanted, torque_of((double)out.i_A.d, (double)out.i_A.q));
            CHECK_NEAR(2.0e-5, wanted, torque > 0.0f ? out.torque_Nm.max : out.torque_Nm.min);
        }
    }
}

static void test_saturating_q_axis(void) {
    lode_references_config_t config = weakening;
    config.Lq_fall = 0.05f;
    const double speeds[] = {0.4, 1.2};
    for (int n = 0; n < COUNT_OF(speeds); n++) {
        rig_t rig = rig_of(0, true, &config);
        const double omega = speeds[n] * rig.V / rig.psi;
        const double Lq0 = rig.Lq;
        for (int k = 0; k < 4000; k++) {
            rig_step(&rig, omega, 0.8);
            rig.Lq = Lq0 / (1.0 + 0.05 * fabs((double)rig.out.i_A.q));
        }
        CHECK_CLOSE(1.0e-3, 0.8, rig_tau(&rig));
        CHECK_AT_MOST(1.002 * rig.V, rig_voltage(&rig, omega, rig.out.i_A, rig.Lq));
    }
    // All of the circle can be asked for.
    rig_t rig = rig_of(0, true, &config);
    rig_settle(&rig, 0.1 * rig.V / rig.psi, 100.0);
    CHECK_CLOSE(1.0e-3, 16.0, hypot((double)rig.out.i_A.d, (double)rig.out.i_A.q));
}

static void test_id_stays_above_its_least(void) {
    lode_references_config_t config = weakening;
    config.id_max_A = 5.0f;
    rig_t rig = rig_of(0, false, &config);
    rig_settle(&rig, 1.8 * rig.V / rig.psi, 0.1);
    TEST_ASSERT_EQUAL_FLOAT(-5.0f, rig.out.i_A.d);
}

static void test_start_from_any_id(void) {
    rig_t rig = rig_of(0, true, &weakening);
    lode_references_reset(&rig.self, -9.0f);
    rig_step(&rig, 0.3 * rig.V / rig.psi, 0.0);
    CHECK_NEAR(0.1, -9.0, rig.out.i_A.d);
    const lode_references_config_t config = sound();
    const lode_references_tuning_t tuning = tuned(&config);
    CHECK_NEAR(1.0e-6, -3.0, lode_references_id_A(&tuning, 1.0f, 0.0f));
    CHECK_NEAR(1.0e-6, 0.0, lode_references_id_A(&tuning, 1.0f, 200.0f));
    lode_references_config_t mtpa = config;
    mtpa.kind = LODE_REFERENCES_MTPA;
    const lode_references_tuning_t best = tuned(&mtpa);
    for (int sign = -1; sign <= 1; sign += 2) {
        const float torque = 4.0f * (float)sign;
        CHECK_NEAR(1.0e-6, step(&best, torque, 300.0f, 0.0f).d,
                   lode_references_id_A(&best, torque, 300.0f));
        CHECK_NEAR(1.0e-6, -3.0, lode_references_id_A(&best, 0.1f * torque, 10.0f));
    }
}

/// A drive that has just come to its references meets the last part first.
static void test_before_the_first_parts_id_stays(void) {
    rig_t rig = rig_of(0, true, &weakening);
    lode_references_reset(&rig.self, -9.0f);
    const float torque = 1.0f;
    const float fast = 3.0f * (float)(rig.V / rig.psi);
    rig.out =
        lode_references_finish(&rig.self, &rig.tuning, torque, fast, 0.0f, rig.voltage.v_bus_V);
    TEST_ASSERT_EQUAL_FLOAT(-9.0f, rig.out.i_A.d);
    CHECK_CLOSE(1.0e-5, (double)torque / 6.0, rig_tau(&rig));
    // The flux is known, and id falls as fast as it may.
    rig_step(&rig, (double)fast, (double)torque / 6.0);
    TEST_ASSERT_EQUAL_FLOAT(-9.0f - rig.tuning.fall_A, rig.out.i_A.d);
    // A tuning without field weakening takes over: what was found for it counts no more.
    rig_settle(&rig, (double)fast, 0.0);
    const rig_t plain = rig_of(0, true, &(lode_references_config_t){.kind = LODE_REFERENCES_MTPA});
    rig.tuning = plain.tuning;
    rig_step(&rig, (double)fast, (double)torque / 6.0);
    CHECK_AT_LEAST(-1.0, rig.out.i_A.d);
    CHECK_CLOSE(1.0e-5, (double)torque / 6.0, rig_tau(&rig));
}

/// Before the first part has found it anew.
static void test_a_flipped_sign_of_the_most_torque(void) {
    rig_t rig = rig_of(0, true, &weakening);
    rig_settle(&rig, 0.5 * rig.V / rig.psi, 0.2 * rig.psi * rig.i_max);
    rig.self.tau_most = -rig.self.tau_most;
    rig.out = lode_references_finish(&rig.self, &rig.tuning, 1.0f, (float)(0.5 * rig.V / rig.psi),
                                     0.0f, rig.voltage.v_bus_V);
    TEST_ASSERT_TRUE(rig.out.torque_Nm.min <= 0.0f && rig.out.torque_Nm.max >= 0.0f);
    CHECK_CLOSE(1.0e-5, 1.0 / 6.0, rig_tau(&rig));
    CHECK_AT_MOST(rig.i_max, hypot((double)rig.out.i_A.d, (double)rig.out.i_A.q));
}

static void test_any_input_of_any_kind_stays_in_the_circle(void) {
    random_t random = random_seed(7);
    for (int number = 0; number < 3; number++) {
        for (int kind = 0; kind < 4; kind++) {
            lode_references_config_t config = weakening;
            config.Lq_fall = kind & 2 ? 0.02f : 0.0f;
            rig_t rig = rig_of(number, (kind & 1) != 0, &config);
            const double bar = rig.i_max * (1.0 + 1.0e-6);
            for (int n = 0; n < 50000; n++) {
                const lode_references_voltage_t voltage = {
                    n % 5 == 0 ? random_any(&random) : rig.voltage.v_bus_V,
                    {random_any(&random), random_any(&random)}};
                const lode_references_out_t out = lode_references_step(
                    &rig.self, &rig.tuning, random_any(&random), random_any(&random),
                    n % 3 == 0 ? random_any(&random) : 0.0f, voltage);
                CHECK_AT_MOST(bar, hypot((double)out.i_A.d, (double)out.i_A.q));
                TEST_ASSERT_TRUE(out.torque_Nm.min <= 0.0f && out.torque_Nm.max >= 0.0f);
                CHECK_AT_MOST(4.0 * 6.0 * (rig.psi + rig.Lq * rig.i_max) * rig.i_max,
                              out.torque_Nm.max - out.torque_Nm.min);
                CHECK_AT_MOST(0.15 + 1.0e-6, fabs((double)rig.self.trim));
            }
            // And forgets all of it.
            rig_settle(&rig, 0.5 * rig.V / rig.psi, 0.2 * rig.psi * rig.i_max);
            CHECK_AT_LEAST(-0.2 * rig.i_max, rig.out.i_A.d);
        }
    }
}

/// What the tuning asks of each call.
static uint32_t options(float Ld_H, float Lq_H, float psi_Wb, float id_max_A, bool weakens) {
    const lode_motor_t motor = {.pole_pairs = 4.0f,
                                .Ld_H = Ld_H,
                                .Lq_H = Lq_H,
                                .psi_Wb = psi_Wb,
                                .omega_rated_rad_s = 1.0f};
    lode_references_config_t config = {.kind = LODE_REFERENCES_ID0,
                                       .field_weakening = weakens ? LODE_ON : LODE_OFF,
                                       .id_max_A = id_max_A};
    lode_references_design(&config, &inverter, &motor);
    lode_references_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_references_tune(&tuning, &config, &inverter, &motor, VOLTAGE_USE, CALL_s));
    return tuning.options;
}

/// Most torque per volt costs a call some time, and is asked for only by who weakens the field and may come to it:
/// beyond id = -psi/Ld where Lq is no smaller than Ld, at any id where it is.
static void test_most_torque_per_volt_only_where_it_is_reached(void) {
    const uint32_t weakens = (uint32_t)LODE_REFERENCES_WEAKEN;
    const uint32_t reaches = weakens | (uint32_t)LODE_REFERENCES_REACH_MTPV;
    const float L = 1.0f / 64.0f; // psi/Ld is 8 A for 1/8 Vs
    const float lower = nextafterf(0.125f, 0.0f);
    TEST_ASSERT_EQUAL_UINT32(weakens, options(L, L, 0.125f, 8.0f, true));
    TEST_ASSERT_EQUAL_UINT32(reaches, options(L, L, lower, 8.0f, true));
    TEST_ASSERT_EQUAL_UINT32(weakens, options(L, 2.0f * L, 0.125f, 8.0f, true));
    TEST_ASSERT_EQUAL_UINT32(reaches, options(L, 2.0f * L, lower, 8.0f, true));
    TEST_ASSERT_EQUAL_UINT32(reaches, options(L, 0.9f * L, 0.125f, 8.0f, true));
    TEST_ASSERT_EQUAL_UINT32(0u, options(L, L, lower, 8.0f, false));
    TEST_ASSERT_EQUAL_UINT32(0u, options(L, 0.9f * L, 0.125f, 8.0f, false));
}

/// All of the circle, at the Lq that its own q current leaves, is what is told as the most.
static void test_most_torque_of_a_saturating_motor(void) {
    lode_references_config_t config = {.Lq_fall = 0.1f};
    rig_t rig = rig_of(0, true, &config);
    double best = 0.0;
    for (int n = 0; n <= 9000; n++) {
        const double angle = 0.01 * n * CHECK_DEG;
        const double iq = rig.i_max * cos(angle);
        const double Lq = rig.Lq / (1.0 + 0.1 * iq);
        best = fmax(best, (rig.psi - (rig.Ld - Lq) * rig.i_max * sin(angle)) * iq);
    }
    rig_step(&rig, 0.1, 0.0);
    CHECK_CLOSE(0.01, 6.0 * best, rig.out.torque_Nm.max);
    // It is told as it is, with the inductance of the present current.
    rig_settle(&rig, 0.1, 0.9 * best);
    CHECK_CLOSE(5.0e-3, (double)rig.out.torque_Nm.max,
                (double)lode_references_allowed_Nm(&rig.self, &rig.tuning, rig.out.i_A.d));
}

/// A call much longer than the times that id takes moves it by i_max at most, and the trim by all that it is off.
static void test_long_calls_do_not_overshoot(void) {
    lode_references_config_t config = sound();
    config.release_s = 1.0e-3f;
    config.trim_rad_s = 1.0e3f;
    const lode_motor_t motor = paper_motor();
    lode_references_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_references_tune(&tuning, &config, &inverter, &motor, VOLTAGE_USE, 0.1f));
    TEST_ASSERT_EQUAL_FLOAT(12.0f, tuning.fall_A);
    TEST_ASSERT_EQUAL_FLOAT(12.0f, tuning.rise_A);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, tuning.trim_decay);
}

/// A rig of feed-forward alone, at rest at this speed and torque over the torque factor.
static rig_t rig_at_rest(int number, double speed_share, double tau) {
    lode_references_config_t config = weakening;
    config.trim_rad_s = LODE_NONE;
    rig_t rig = rig_of(number, true, &config);
    rig_settle(&rig, speed_share * rig.V / rig.psi, tau);
    return rig;
}

/// One call for that torque, of the last part alone: the flux stays.
static void rig_finish(rig_t *rig, double tau) {
    rig->out = lode_references_finish(&rig->self, &rig->tuning, rig->factor * (float)tau, 500.0f,
                                      0.0f, rig->voltage.v_bus_V);
}

/// R10, R11: a Newton step. From a little beside, one call leaves less than a tenth of it.
static void test_one_call_finds_the_flux(void) {
    for (int kind = 0; kind < 2; kind++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const double tau = kind == 0 ? 0.4 : 100.0; // inside the circle, on it
            rig_t rig = rig_at_rest(0, kind == 0 ? 1.3 : 1.1, tau);
            const float id_A = rig.self.id_A;
            TEST_ASSERT_TRUE(id_A < rig.self.id_free_A - 1.0f && id_A > -15.0f);
            rig.self.id_A = id_A + 0.1f * (float)sign;
            rig.tuning.rise_A = 1.0f;
            rig_finish(&rig, tau);
            CHECK_NEAR(0.01, id_A, rig.out.i_A.d);
        }
    }
}

/// At id = -psi/Ld the flux of a motor without saliency depends on id no more. It moves as by a tenth of the slope at no
/// current then, and towards the flux that is wanted.
static void test_where_the_flux_does_not_depend_on_id(void) {
    const float L = 1.0f / 64.0f;
    const lode_motor_t motor = {.pole_pairs = 4.0f,
                                .Ld_H = L,
                                .Lq_H = L,
                                .psi_Wb = 0.125f, // psi/Ld = 8 A
                                .omega_rated_rad_s = 1.0f};
    lode_references_config_t config = weakening;
    config.id_bias_A = LODE_NONE;
    lode_references_design(&config, &inverter, &motor);
    lode_references_tuning_t tuning;
    TEST_ASSERT_EQUAL_INT(
        LODE_OK, lode_references_tune(&tuning, &config, &inverter, &motor, VOLTAGE_USE, CALL_s));
    tuning.rise_A = tuning.fall_A = 10.0f;
    for (int sign = -1; sign <= 1; sign += 2) {
        lode_references_t self;
        lode_references_reset(&self, -8.0f);
        self.id_least_A = -12.0f;
        self.id_free_A = 0.0f;
        const double iq = 3.0;
        self.flux = (float)(0.015625 * (iq + 0.5 * sign));
        const double excess = 0.015625 * 0.015625 * iq * iq - (double)self.flux * (double)self.flux;
        const float torque = tuning.torque_factor * 0.125f * (float)iq;
        const lode_references_out_t out =
            lode_references_finish(&self, &tuning, torque, 500.0f, 0.0f, 200.0f);
        CHECK_NEAR(1.0e-4, -8.0 - excess / (0.1 * 2.0 * 0.125 * 0.015625), out.i_A.d);
    }
}

/// iq does not follow a flux that is 1.5 % less than what id leaves it, as the bus's noise makes it; of 5 % less it
/// takes back what is beyond 2 %.
static void test_torque_does_not_follow_the_noise(void) {
    const double tau = 1.0;
    rig_t rig = rig_at_rest(0, 1.2, tau);
    const float flux = rig.self.flux;
    rig.tuning.fall_A = rig.tuning.rise_A = 0.0f; // id stays
    const float iq = rig.out.i_A.q;
    rig.self.flux = 0.985f * flux;
    rig_finish(&rig, tau);
    CHECK_NEAR(1.0e-5, iq, rig.out.i_A.q);
    rig.self.flux = 0.95f * flux;
    rig_finish(&rig, tau);
    const double psi_d = rig.psi + rig.Ld * (double)rig.out.i_A.d;
    const double psi_q = rig.Lq * (double)rig.out.i_A.q;
    TEST_ASSERT_TRUE(rig.out.i_A.q < 0.9f * iq);
    CHECK_CLOSE(1.0e-4, 1.02 * 0.95 * (double)flux, hypot(psi_d, psi_q));
}

/// R13: beyond most torque per volt more of a negative id costs torque. At high speed that is near id = -psi/Ld.
static void test_id_stays_above_most_torque_per_volt(void) {
    rig_t rig = rig_of(2, true, &weakening);
    TEST_ASSERT_TRUE(rig.psi / rig.Ld < 0.7 * rig.i_max);
    rig.self.id_A = (float)(-0.95 * rig.i_max);
    rig_settle(&rig, 40.0 * rig.V / rig.psi, 100.0);
    CHECK_CLOSE(0.02, -rig.psi / rig.Ld, rig.self.id_least_A);
    CHECK_AT_LEAST((double)rig.self.id_least_A - 1.0e-3, rig.out.i_A.d);
    // Another tuning that does not come to it: what was the most torque then counts no more.
    lode_references_config_t config = weakening;
    config.id_max_A = (float)(0.5 * rig.psi / rig.Ld);
    const rig_t shallow = rig_of(2, true, &config);
    rig.tuning = shallow.tuning;
    rig_settle(&rig, 0.3 * rig.V / rig.psi, 100.0);
    rig_t fresh = shallow;
    rig_settle(&fresh, 0.3 * rig.V / rig.psi, 100.0);
    CHECK_CLOSE(1.0e-5, (double)fresh.out.torque_Nm.max, rig.out.torque_Nm.max);
}

/// What is left of the start current is added where MTPA sets id too.
static void test_start_current_is_added_to_mtpa(void) {
    lode_references_config_t config = sound();
    config.kind = LODE_REFERENCES_MTPA;
    const lode_references_tuning_t tuning = tuned(&config);
    const double id = (double)step(&tuning, 2.0f, 300.0f, 0.0f).d;
    CHECK_AT_MOST(-0.1, id);
    CHECK_NEAR(1.0e-5, id + 4.5, step(&tuning, 2.0f, 300.0f, 4.5f).d);
}

/// Below one rad/s the voltage leaves the flux that it leaves there, whatever a rotor at rest does.
static void test_flux_at_rest_is_finite(void) {
    lode_references_config_t config = sound();
    config.field_weakening = LODE_ON;
    const lode_references_tuning_t tuning = tuned(&config);
    for (int n = 0; n <= 2; n++) {
        lode_references_t self;
        lode_references_reset(&self, 0.0f);
        const lode_references_voltage_t voltage = {0.1f, {0.0f, 0.0f}};
        lode_references_find_flux(&self, &tuning, 0.5f * (float)n, voltage);
        CHECK_NEAR(1.0e-6, 0.1 * 0.95 * 0.95 / sqrt(3.0), self.flux);
    }
}

/// The trim after a call from 0.1, with the field weakened by `weak_A`, id last moved by `moved_A`, and a voltage
/// whose square is `headroom_V2` below what may be used.
static float trim_after(const lode_references_tuning_t *tuning, float id_A, float weak_A,
                        float moved_A, float headroom_V2) {
    const float use_V = tuning->circle * 200.0f;
    const float q_V2 = 0.36f * (use_V * use_V - headroom_V2); // d and q count alike
    const float d_V2 = 0.64f * (use_V * use_V - headroom_V2);
    lode_references_t self;
    lode_references_reset(&self, id_A);
    self.id_free_A = id_A + weak_A;
    self.moved_A = moved_A;
    self.trim = 0.1f;
    const lode_references_voltage_t voltage = {200.0f, {lode_sqrt(d_V2), -lode_sqrt(q_V2)}};
    lode_references_find_flux(&self, tuning, 300.0f, voltage);
    return self.trim;
}

/// R9: of the error of the voltage's square; only while the field is weakened, by a thousandth of i_max at least, and
/// id answers to it. Else it decays.
static void test_when_the_trim_moves(void) {
    lode_references_config_t config = sound();
    config.field_weakening = LODE_ON;
    const lode_references_tuning_t tuning = tuned(&config);
    const double use_V = 0.95 * 0.95 / sqrt(3.0) * 200.0;
    for (int sign = -1; sign <= 1; sign += 2) {
        const double off_V2 = 0.1 * sign * use_V * use_V;
        const double moved = 0.1 + 0.5 * 20.0 * (double)CALL_s * 0.1 * sign;
        const double decayed = 0.1 * (1.0 - 20.0 * (double)CALL_s);
        CHECK_NEAR(1.0e-6, moved, trim_after(&tuning, -5.0f, 0.02f, 0.0f, (float)off_V2));
        CHECK_NEAR(1.0e-6, decayed, trim_after(&tuning, -5.0f, 0.006f, 0.0f, (float)off_V2));
        // At a rate limit id does not answer, nor at its least, but to a trim that lets it rise again.
        CHECK_NEAR(1.0e-6, 0.1,
                   trim_after(&tuning, -5.0f, 0.02f, 0.95f * tuning.rise_A, (float)off_V2));
        CHECK_NEAR(1.0e-6, 0.1,
                   trim_after(&tuning, -5.0f, 0.02f, -0.95f * tuning.rise_A, (float)off_V2));
        CHECK_NEAR(1.0e-6, moved,
                   trim_after(&tuning, -5.0f, 0.02f, 0.85f * tuning.rise_A, (float)off_V2));
        CHECK_NEAR(1.0e-6, sign > 0 ? moved : 0.1,
                   trim_after(&tuning, -12.0f, 0.02f, 0.0f, (float)off_V2));
    }
}

/// Of the two fades each is there alone: braking or motoring torque, at any bus, whatever the other's limits are.
static void test_one_fade_alone(void) {
    for (int k = 0; k < 2; k++) {
        lode_references_config_t config = sound();
        config.v_regen_V = k == 0 ? 0.9f : 0.0f;
        config.v_motor_V = k == 0 ? 0.0f : 0.7f;
        config.v_bus_max_V = 1.0f;
        config.v_bus_min_V = 0.1f;
        const lode_inverter_config_t small = {.v_bus_V = 0.8f, .i_max_A = I_MAX_A};
        const lode_motor_t motor = paper_motor();
        lode_references_tuning_t tuning;
        TEST_ASSERT_EQUAL_INT(
            LODE_OK, lode_references_tune(&tuning, &config, &small, &motor, VOLTAGE_USE, CALL_s));
        const double full = 12.0 * 4.5 * 0.142;
        static const double table[][3] = {// bus, share of motoring, of braking torque
                                          {0.4, 0.5, 1.0},
                                          {0.1, 0.0, 1.0},
                                          {0.8, 1.0, 1.0},
                                          {0.95, 1.0, 0.5},
                                          {1.0, 1.0, 0.0}};
        for (int n = 0; n < COUNT_OF(table); n++) {
            lode_references_t self;
            lode_references_reset(&self, 0.0f);
            const lode_references_voltage_t voltage = {(float)table[n][0], {0.0f, 0.0f}};
            const lode_references_out_t out =
                lode_references_step(&self, &tuning, 0.0f, 300.0f, 0.0f, voltage);
            CHECK_NEAR(1.0e-4, full * (k == 0 ? 1.0 : table[n][1]), out.torque_Nm.max);
            CHECK_NEAR(1.0e-4, -full * (k == 0 ? table[n][2] : 1.0), out.torque_Nm.min);
        }
    }
}

static lode_status_t try_one(size_t offset, float value) {
    lode_references_config_t config = sound();
    field_set(&config, offset, value);
    const lode_motor_t motor = paper_motor();
    lode_references_tuning_t tuning;
    memset(&tuning, 0x5a, sizeof tuning);
    const lode_references_tuning_t before = tuning;
    const lode_status_t status =
        lode_references_tune(&tuning, &config, &inverter, &motor, VOLTAGE_USE, CALL_s);
    if (status != LODE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof tuning);
    }
    return status;
}

static void test_every_field_at_its_limits(void) {
    const size_t bias = offsetof(lode_references_config_t, id_bias_A);
    const size_t low = offsetof(lode_references_config_t, omega_low_rad_s);
    const size_t high = offsetof(lode_references_config_t, omega_high_rad_s);
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(bias, LODE_NONE));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(bias, 0.0f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(bias, I_MAX_A));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS,
                          try_one(bias, -3.0f)); // a bias against the magnets is none
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(bias, -0.5f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(bias, nextafterf(I_MAX_A, INFINITY)));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(low, 109.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(low, 110.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(low, 111.0f));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(high, 61.0f));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(high, 60.0f));
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(bias, check_not_finite[i]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(low, check_not_finite[i]));
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_ID_BIAS, try_one(high, check_not_finite[i]));
    }
}

static void check_range(size_t offset, float lo, float hi, lode_status_t error) {
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, lo));
    TEST_ASSERT_EQUAL_INT(LODE_OK, try_one(offset, hi));
    TEST_ASSERT_EQUAL_INT(error, try_one(offset, nextafterf(lo, -INFINITY)));
    TEST_ASSERT_EQUAL_INT(error, try_one(offset, nextafterf(hi, INFINITY)));
    for (int i = 0; i < COUNT_OF(check_not_finite); i++) {
        TEST_ASSERT_EQUAL_INT(error, try_one(offset, check_not_finite[i]));
    }
}

static void test_every_field_of_weakening_at_its_limits(void) {
    const lode_status_t error = LODE_ERROR_FIELD_WEAKENING;
    check_range(offsetof(lode_references_config_t, voltage_use), 0.1f, 1.0f, error);
    check_range(offsetof(lode_references_config_t, trim_rad_s), 0.1f, 1.0e3f, error);
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          try_one(offsetof(lode_references_config_t, trim_rad_s), LODE_NONE));
    check_range(offsetof(lode_references_config_t, release_s), 1.0e-3f, 10.0f, error);
    check_range(offsetof(lode_references_config_t, id_max_A), 1.0e-3f * I_MAX_A, I_MAX_A, error);
    check_range(offsetof(lode_references_config_t, Lq_fall), 0.0f, 10.0f / I_MAX_A,
                LODE_ERROR_LQ_FALL);
}

static lode_status_t try_config(const lode_references_config_t *config) {
    const lode_motor_t motor = paper_motor();
    lode_references_tuning_t tuning;
    return lode_references_tune(&tuning, config, &inverter, &motor, VOLTAGE_USE, CALL_s);
}

static void test_choices_and_fades(void) {
    lode_references_config_t config = sound();
    config.kind = (lode_references_kind_t)7;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_REFERENCES, try_config(&config));
    config = sound();
    config.field_weakening = (lode_choice_t)7;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_REFERENCES, try_config(&config));
    const struct {
        float regen, max, motor, min;
        lode_status_t status;
    } table[] = {
        {0.0f, 0.0f, 0.0f, 0.0f, LODE_OK},
        {200.0f, 201.0f, 0.0f, 0.0f, LODE_OK},
        {199.0f, 250.0f, 0.0f, 0.0f, LODE_ERROR_BUS_FADE},
        {250.0f, 250.0f, 0.0f, 0.0f, LODE_ERROR_BUS_FADE},
        {NAN, 250.0f, 0.0f, 0.0f, LODE_ERROR_BUS_FADE},
        {210.0f, NAN, 0.0f, 0.0f, LODE_ERROR_BUS_FADE},
        {210.0f, INFINITY, 0.0f, 0.0f, LODE_ERROR_BUS_FADE},
        {-1.0f, 250.0f, 0.0f, 0.0f, LODE_ERROR_BUS_FADE},
        {0.5f, 250.0f, 0.0f, 0.0f, LODE_ERROR_BUS_FADE},
        {INFINITY, INFINITY, 0.0f, 0.0f, LODE_ERROR_BUS_FADE},
        {0.0f, 0.0f, 1.0e-40f, 0.0f, LODE_ERROR_BUS_FADE}, // 1/span is no number
        {0.0f, 0.0f, 200.0f, 0.0f, LODE_OK},
        {0.0f, 0.0f, 201.0f, 100.0f, LODE_ERROR_BUS_FADE},
        {0.0f, 0.0f, 100.0f, 100.0f, LODE_ERROR_BUS_FADE},
        {0.0f, 0.0f, 100.0f, -1.0f, LODE_ERROR_BUS_FADE},
        {0.0f, 0.0f, 100.0f, NAN, LODE_ERROR_BUS_FADE},
        {0.0f, 0.0f, NAN, 90.0f, LODE_ERROR_BUS_FADE},
        {0.0f, 0.0f, -1.0f, 90.0f, LODE_ERROR_BUS_FADE},
    };
    for (int n = 0; n < COUNT_OF(table); n++) {
        config = sound();
        config.v_regen_V = table[n].regen;
        config.v_bus_max_V = table[n].max;
        config.v_motor_V = table[n].motor;
        config.v_bus_min_V = table[n].min;
        TEST_ASSERT_EQUAL_INT(table[n].status, try_config(&config));
    }
}

static void test_design_fills_what_is_open(void) {
    const lode_motor_t motor = paper_motor();
    lode_references_config_t config = {.id_bias_A = 0.0f};
    lode_references_design(&config, &inverter, &motor);
    CHECK_CLOSE(1.0e-6, 0.25 * 12.0, config.id_bias_A);
    CHECK_CLOSE(1.0e-6, 0.2 * PAPER_OMEGA_RATED, config.omega_low_rad_s);
    CHECK_CLOSE(1.0e-6, 0.4 * PAPER_OMEGA_RATED, config.omega_high_rad_s);
    TEST_ASSERT_EQUAL_INT(LODE_OFF, config.field_weakening);
    CHECK_CLOSE(1.0e-6, 0.95, config.voltage_use);
    CHECK_CLOSE(1.0e-6, 20.0, config.trim_rad_s);
    CHECK_CLOSE(1.0e-6, 0.1, config.release_s);
    CHECK_CLOSE(1.0e-6, 12.0, config.id_max_A);
    const lode_references_config_t all = sound();
    lode_references_config_t kept = all;
    lode_references_design(&kept, &inverter, &motor);
    TEST_ASSERT_EQUAL_MEMORY(&all, &kept, sizeof all);
    lode_references_config_t none = {.id_bias_A = LODE_NONE};
    lode_references_design(&none, &inverter, &motor);
    TEST_ASSERT_EQUAL_FLOAT(LODE_NONE, none.id_bias_A);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_q_axis_that_saturates_turns_the_angle_by_what_its_flux_lacks);
    RUN_TEST(test_much_reluctance_asks_for_mtpa);
    RUN_TEST(test_at_speed_id_is_zero);
    RUN_TEST(test_bias_fades_with_speed);
    RUN_TEST(test_no_bias);
    RUN_TEST(test_start_current_is_added_to_d);
    RUN_TEST(test_circle_holds_with_d_first);
    RUN_TEST(test_limit_of_torque);
    RUN_TEST(test_torque_is_the_inverse);
    RUN_TEST(test_any_input_stays_in_the_circle);
    RUN_TEST(test_currents_are_the_best_of_all);
    RUN_TEST(test_feed_forward_alone_is_close);
    RUN_TEST(test_mtpa_meets_its_condition);
    RUN_TEST(test_signs_mirror);
    RUN_TEST(test_entry_and_exit_are_smooth);
    RUN_TEST(test_torque_limit_is_what_can_be_had);
    RUN_TEST(test_trim_absorbs_a_wrong_psi);
    RUN_TEST(test_trim_recovers_at_the_lowest_id);
    RUN_TEST(test_torque_waits_for_the_flux);
    RUN_TEST(test_id_rises_slowly);
    RUN_TEST(test_without_a_trim_there_is_none);
    RUN_TEST(test_bus_limits_braking_and_motoring);
    RUN_TEST(test_saturating_q_axis);
    RUN_TEST(test_id_stays_above_its_least);
    RUN_TEST(test_start_from_any_id);
    RUN_TEST(test_before_the_first_parts_id_stays);
    RUN_TEST(test_a_flipped_sign_of_the_most_torque);
    RUN_TEST(test_any_input_of_any_kind_stays_in_the_circle);
    RUN_TEST(test_most_torque_per_volt_only_where_it_is_reached);
    RUN_TEST(test_most_torque_of_a_saturating_motor);
    RUN_TEST(test_long_calls_do_not_overshoot);
    RUN_TEST(test_one_call_finds_the_flux);
    RUN_TEST(test_where_the_flux_does_not_depend_on_id);
    RUN_TEST(test_torque_does_not_follow_the_noise);
    RUN_TEST(test_id_stays_above_most_torque_per_volt);
    RUN_TEST(test_start_current_is_added_to_mtpa);
    RUN_TEST(test_flux_at_rest_is_finite);
    RUN_TEST(test_when_the_trim_moves);
    RUN_TEST(test_one_fade_alone);
    RUN_TEST(test_every_field_at_its_limits);
    RUN_TEST(test_every_field_of_weakening_at_its_limits);
    RUN_TEST(test_choices_and_fades);
    RUN_TEST(test_design_fills_what_is_open);
    return UNITY_END();
}
