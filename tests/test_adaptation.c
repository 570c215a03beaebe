// Adaptation on a drive whose fields are made by hand: torque, speed and EMF of a motor other than the configured one.
#include "support/rig.h"

#include "lag_inline.h"
#include "lodestar/adaptation.h"

#define CALL_STEPS 5u // at 5 kHz: 1 ms
#define CALL_s 1.0e-3
#define HIGH_rad_s 140.0 // mechanical
#define LOW_rad_s 60.0
#define SLOPE_rad_s2 300.0
#define SLOW_rad_s 25.0 // 16 % of the rated speed

void setUp(void) {}

void tearDown(void) {}

static const lode_adaptation_config_t all = {.J = LODE_AUTO, .psi = LODE_ON};

typedef struct {
    lode_drive_t drive;
    lode_drive_tuning_t tuning;
    lode_drive_config_t config;
    lode_adaptation_t adaptation;
    double J, psi, Rs; ///< truth over configured
    double load_Nm, id_A;
    double reference, speed; ///< mechanical
    uint32_t call_steps;
    int posted;
    bool injects;
    double across; ///< share of the EMF along the q axis that is left across it
} bench_t;

static double call_s(const bench_t *self) {
    return (double)self->call_steps * RIG_TS_s;
}

static void bench_of(bench_t *self, const lode_drive_config_t *drive,
                     const lode_adaptation_config_t *config,
                     const lode_adaptation_found_t *stored) {
    *self = (bench_t){.config = *drive, .J = 1.0, .psi = 1.0, .Rs = 1.0, .call_steps = CALL_STEPS};
    lode_drive_design(&self->config);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_init(&self->drive, &self->tuning, &self->config));
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_adaptation_init(&self->adaptation, config, &self->tuning,
                                                        &self->config.motor, stored));
    self->drive.mode = (uint_least8_t)LODE_MODE_RUN;
    self->drive.inverter.v_bus_V = PAPER_V_BUS;
    self->reference = self->speed = LOW_rad_s;
}

static void bench_init(bench_t *self, const lode_adaptation_config_t *config,
                       const lode_adaptation_found_t *stored) {
    const lode_drive_config_t drive = rig_config();
    bench_of(self, &drive, config, stored);
}

static void take(bench_t *self) {
    if (self->drive.posted_tuning != NULL) {
        self->drive.tuning = self->drive.posted_tuning;
        self->drive.posted_tuning = NULL;
    }
}

// The EMF as the observer sees it: by the resistance that is reckoned with.
static float seen_emf_V(const bench_t *self, double iq_A) {
    const lode_motor_t *motor = &self->config.motor;
    const lode_estimator_tuning_t *base = &self->tuning.estimator;
    const double reckoned =
        (double)motor->Rs_Ohm +
        (double)(base->emf.a_over_b - self->drive.tuning->estimator.emf.a_over_b) +
        (double)self->drive.inverter.r_more_Ohm;
    const double omega = (double)motor->pole_pairs * self->speed;
    const double flux = self->psi * (double)motor->psi_Wb + (double)base->salient_H * self->id_A;
    const double along = omega * flux + (self->Rs * (double)motor->Rs_Ohm - reckoned) * iq_A;
    return (float)(along / (1.0 + omega * omega * (double)base->droop_s2));
}

static bool bench_call(bench_t *self, double target) {
    const lode_motor_t *motor = &self->config.motor;
    lode_drive_t *drive = &self->drive;
    take(self);
    const double before = self->speed;
    const double step = SLOPE_rad_s2 * call_s(self);
    self->reference += fmax(-step, fmin(step, target - self->reference));
    // Speed control: a lag of 10 ms.
    self->speed += (self->reference - self->speed) * fmin(call_s(self) / 0.01, 1.0);
    const double acc = (self->speed - before) / call_s(self);
    const double torque = self->J * (double)motor->J_kgm2 * acc + self->load_Nm;
    const double flux =
        self->psi * (double)motor->psi_Wb + (double)self->tuning.estimator.salient_H * self->id_A;
    const double iq_A = torque / ((double)lode_motor_torque_factor(motor) * flux);
    drive->steps += self->call_steps;
    drive->i_A = (lode_dq_t){(float)self->id_A, (float)iq_A};
    drive->estimator.pll.omega_rad_s = (float)(self->speed * (double)motor->pole_pairs);
    const float along_V = seen_emf_V(self, iq_A);
    drive->estimator.emf.observer.e_V = (lode_ab_t){(float)self->across * along_V, along_V};
    drive->estimator.by.hfi.active = self->injects;
    drive->estimator.by.hfi.weight = self->injects ? 1.0f : 0.0f;
    drive->estimator.lag =
        lode_lag_line(&self->tuning.estimator.lag, drive->estimator.pll.omega_rad_s);
    drive->state.run.speed.reference_rad_s = (float)self->reference;
    const bool posted = lode_adaptation_step(&self->adaptation, drive);
    self->posted += posted ? 1 : 0;
    // The one in use may still be read.
    TEST_ASSERT_TRUE(!posted || drive->posted_tuning != drive->tuning);
    return posted;
}

static void bench_run(bench_t *self, double target, double seconds) {
    for (int n = 0; n < (int)(seconds / call_s(self) + 0.5); n++) {
        (void)bench_call(self, target);
    }
}

static void ramps(bench_t *self, int count) {
    for (int n = 0; n < count; n++) {
        bench_run(self, HIGH_rad_s, 1.0);
        bench_run(self, LOW_rad_s, 1.0);
    }
}

// Until the next edge is over, at most 2 s. Its length. A ramp has two: one after its begin, one after its end.
static double edge(bench_t *self, double target) {
    double seconds = 0.0;
    bool begun = false;
    while (seconds < 2.0 && !(begun && self->adaptation.machine.edge.energy <= 0.0f)) {
        (void)bench_call(self, target);
        begun = begun || self->adaptation.machine.edge.energy > 0.0f;
        seconds += begun ? call_s(self) : 0.0;
    }
    TEST_ASSERT_TRUE(begun && seconds < 2.0);
    return seconds;
}

static void expect(double share, double tolerance, float configured, lode_adapted_t found) {
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, share, (double)(found.value / configured));
}

static lode_adaptation_found_t found_by(const bench_t *self) {
    return lode_adaptation_found(&self->adaptation);
}

static void test_bad_configurations_are_refused(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    lode_motor_t motor = bench.config.motor;
    lode_adaptation_t *a = &bench.adaptation;
    const lode_drive_tuning_t *t = &bench.tuning;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_adaptation_init(NULL, &all, t, &motor, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_adaptation_init(a, NULL, t, &motor, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_adaptation_init(a, &all, NULL, &motor, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_adaptation_init(a, &all, t, NULL, NULL));
    const lode_adaptation_config_t choices[] = {
        {.J = (lode_choice_t)3}, {.psi = (lode_choice_t)3}, {.Rs = (lode_choice_t)3}};
    for (int n = 0; n < COUNT_OF(choices); n++) {
        TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE,
                              lode_adaptation_init(a, &choices[n], t, &motor, NULL));
    }
    motor.Rs_Ohm = 0.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_RS, lode_adaptation_init(a, &all, t, &motor, NULL));
    motor = bench.config.motor;
    motor.omega_rated_rad_s = 0.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_OMEGA, lode_adaptation_init(a, &all, t, &motor, NULL));
    motor.omega_rated_rad_s = 1.0f; // the least that a motor may have
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_adaptation_init(a, &all, t, &motor, NULL));
}

static void test_nothing_is_known_at_first(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    const lode_adaptation_found_t found = found_by(&bench);
    const lode_motor_t *motor = &bench.config.motor;
    TEST_ASSERT_TRUE(found.J_kgm2.value == motor->J_kgm2 && found.J_kgm2.confidence == 0.0f);
    TEST_ASSERT_TRUE(found.psi_Wb.value == motor->psi_Wb && found.psi_Wb.confidence == 0.0f);
    TEST_ASSERT_TRUE(found.Rs_Ohm.value == motor->Rs_Ohm && found.Rs_Ohm.confidence == 0.0f);
}

static void test_inertia_is_found_by_ramps(void) {
    static const double shares[] = {0.3, 1.0, 3.0};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        static bench_t bench;
        bench_init(&bench, &all, NULL);
        bench.J = shares[n];
        bench.load_Nm = 1.0;
        bench.id_A = -3.0; // reluctance takes a part of the torque
        ramps(&bench, 4);
        const lode_adaptation_found_t found = found_by(&bench);
        expect(shares[n], 0.02 * shares[n], bench.config.motor.J_kgm2, found.J_kgm2);
        TEST_ASSERT_TRUE(found.J_kgm2.confidence > 0.8f);
    }
}

// Torque and speed begin where they are: the load at the beginning, and the speed, are no change.
static void test_the_first_edge_is_believed_as_it_is(void) {
    static const double shares[] = {0.3, 1.0, 3.0};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        static bench_t bench;
        bench_init(&bench, &all, NULL);
        bench.J = shares[n];
        bench.load_Nm = 3.0;
        bench_run(&bench, LOW_rad_s, 0.01);
        (void)edge(&bench, HIGH_rad_s);
        const lode_adaptation_found_t found = found_by(&bench);
        TEST_ASSERT_TRUE(found.J_kgm2.confidence > 0.0f);
        expect(shares[n], 0.05 * shares[n], bench.config.motor.J_kgm2, found.J_kgm2);
    }
}

static void test_a_constant_speed_is_no_edge(void) {
    // As rated, and a slow motor: each radian per second is more of what its torque makes.
    static const float rated_rad_s[] = {471.0f, 90.0f};
    for (int n = 0; n < COUNT_OF(rated_rad_s); n++) {
        static bench_t bench;
        lode_drive_config_t config = rig_config();
        config.motor.omega_rated_rad_s = rated_rad_s[n];
        config.motor.J_kgm2 *= n == 0 ? 1.0f : 10.0f;
        bench_of(&bench, &config, &all, NULL);
        bench.load_Nm = 3.0;
        bench.reference = bench.speed = SLOW_rad_s;
        for (int k = 0; k < 1000; k++) {
            (void)bench_call(&bench, SLOW_rad_s);
            TEST_ASSERT_TRUE(bench.adaptation.machine.edge.energy <= 0.0f);
        }
        // Torque control has taken it elsewhere; there it goes on.
        bench.drive.command.flags = (uint_least8_t)LODE_ORDER_TORQUE;
        bench.reference = bench.speed = 1.5 * SLOW_rad_s;
        bench_run(&bench, bench.speed, 0.1);
        bench.drive.command.flags = 0u;
        for (int k = 0; k < 1000; k++) {
            (void)bench_call(&bench, bench.speed);
            TEST_ASSERT_TRUE(bench.adaptation.machine.edge.energy <= 0.0f);
        }
    }
}

// The washout is one of time: with fifty times fewer calls an edge lasts as long, but for a call or two.
static void test_an_edge_lasts_as_long_however_seldom_it_is_looked_at(void) {
    double seconds[2];
    for (int n = 0; n < 2; n++) {
        static bench_t bench;
        bench_init(&bench, &all, NULL);
        bench.call_steps = n == 0 ? CALL_STEPS : 50u * CALL_STEPS;
        seconds[n] = edge(&bench, 10.0 * HIGH_rad_s);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.15 * seconds[0], seconds[0], seconds[1]);
}

static void test_an_acceleration_without_torque_is_no_inertia(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 0.0;
    for (int n = 0; n < 2; n++) { // each edge: with the next the first is doubted
        (void)edge(&bench, HIGH_rad_s);
        TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence <= 0.0f);
    }
}

// Seen far too little of it: a reference that creeps.
static void test_a_slope_that_hardly_is_one_shows_no_inertia(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 3.0;
    for (int n = 0; n < 4000; n++) {
        // 4 % of what the torque makes, for as long as the washout takes to show it
        bench.reference += n % 1000 < 250 ? 15.0 * CALL_s : 0.0;
        (void)bench_call(&bench, bench.reference);
    }
    TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence <= 0.0f);
}

// What comes of it: speed control and feed-forward, and nothing else.
static void test_inertia_changes_speed_control_and_feed_forward_only(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 3.0;
    ramps(&bench, 6);
    take(&bench);
    const float J = found_by(&bench).J_kgm2.value / bench.config.motor.J_kgm2;
    const lode_drive_tuning_t *base = &bench.tuning;
    lode_drive_tuning_t now = *bench.drive.tuning;
    TEST_ASSERT_TRUE(bench.drive.tuning != base);
    TEST_ASSERT_FLOAT_WITHIN(0.1f, J, now.speed.inertia_Nm / base->speed.inertia_Nm);
    const float used = now.speed.inertia_Nm / base->speed.inertia_Nm;
    TEST_ASSERT_FLOAT_WITHIN(1.0e-4f, 1.0f / used,
                             now.estimator.acc_per_torque / base->estimator.acc_per_torque);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-4f, 1.0f / used,
                             now.estimator.acc_per_omega / base->estimator.acc_per_omega);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-4f, 1.0f / used,
                             now.estimator.acc_most / base->estimator.acc_most);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-4f, used,
                             now.estimator.load_per_f_Nm / base->estimator.load_per_f_Nm);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-4f, 1.0f / used, now.speed.ramp_step / base->speed.ramp_step);
    // Not in proportion: a rotor three times as heavy would answer the noise of its speed with too much torque.
    const float most = 13.0f * lode_references_most_Nm(&base->references) *
                       bench.config.motor.pole_pairs / bench.config.motor.omega_rated_rad_s;
    TEST_ASSERT_FLOAT_WITHIN(1.0e-3f, 1.0f, now.speed.pi.kp * (1.0f + base->speed.rise) / most);
    TEST_ASSERT_TRUE(now.speed.pi.kp < used * base->speed.pi.kp);
    const float gain = now.speed.pi.kp / base->speed.pi.kp;
    TEST_ASSERT_FLOAT_WITHIN(1.0e-3f, gain * gain / used,
                             now.speed.pi.ki_Ts / base->speed.pi.ki_Ts);
    now.speed = base->speed;
    now.estimator.acc_per_torque = base->estimator.acc_per_torque;
    now.estimator.acc_per_omega = base->estimator.acc_per_omega;
    now.estimator.acc_most = base->estimator.acc_most;
    now.estimator.load_per_f_Nm = base->estimator.load_per_f_Nm;
    now.estimator.emf.a_over_b = base->estimator.emf.a_over_b;
    now.references = base->references;
    TEST_ASSERT_EQUAL_MEMORY(base, &now, sizeof now);
}

// The ramp of a heavier rotor is one that half of the torque is enough for, where that was not so before; a slow one
// stays as it is.
static void test_the_ramp_of_a_heavier_rotor(void) {
    static const float shares[] = {0.4f, 0.05f}; // of what all of the torque makes
    for (int n = 0; n < COUNT_OF(shares); n++) {
        static bench_t bench;
        lode_drive_config_t config = rig_config();
        lode_drive_design(&config);
        lode_drive_tuning_t first;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&first, &config));
        const float most_Nm = lode_references_most_Nm(&first.references);
        config = rig_config();
        config.speed.ramp_rad_s2 = shares[n] * most_Nm / config.motor.J_kgm2;
        bench_of(&bench, &config, &all, NULL);
        bench.J = 4.0;
        ramps(&bench, 12);
        take(&bench);
        const lode_speed_tuning_t *now = &bench.drive.tuning->speed;
        const float J = now->inertia_Nm / bench.tuning.speed.inertia_Nm;
        TEST_ASSERT_FLOAT_WITHIN(0.1f, 4.0f, J);
        TEST_ASSERT_EQUAL_FLOAT(now->ramp_step, now->ramp_down_step);
        const float used = J * shares[n] * now->ramp_step / bench.tuning.speed.ramp_step;
        TEST_ASSERT_FLOAT_WITHIN(1.0e-3f, n == 0 ? 0.5f : J * shares[n], used);
    }
}

// Of a lighter rotor too the tuning follows what was found, as near as of a heavier one.
static void test_a_lighter_rotor_is_followed_as_closely(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 0.25;
    ramps(&bench, 12);
    take(&bench);
    const float used = bench.drive.tuning->speed.inertia_Nm / bench.tuning.speed.inertia_Nm;
    TEST_ASSERT_FLOAT_WITHIN(0.05f * 0.25f, 0.25f, used);
}

static void test_no_step_of_a_tuning_is_large(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 3.0;
    bench.psi = 0.85;
    const lode_drive_tuning_t *before = bench.drive.tuning;
    bench.load_Nm = 3.0;
    int since = 1000;
    for (int n = 0; n < 8000; n++) {
        since++;
        if (!bench_call(&bench, n % 2000 < 1000 ? HIGH_rad_s : LOW_rad_s)) {
            continue;
        }
        TEST_ASSERT_TRUE(since >= 50); // ms between two of them
        since = 0;
        const lode_drive_tuning_t *next = bench.drive.posted_tuning;
        const float J = next->speed.inertia_Nm / before->speed.inertia_Nm;
        TEST_ASSERT_TRUE(lode_in_range(J, 0.899f, 1.101f));
        const float psi = next->references.psi_Wb - before->references.psi_Wb;
        TEST_ASSERT_TRUE(lode_abs(psi) <= 0.0101f * bench.config.motor.psi_Wb);
        before = next;
    }
    TEST_ASSERT_TRUE(bench.posted > 15);
}

static void test_a_load_step_with_the_ramp_is_no_inertia(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    ramps(&bench, 3);
    const lode_adaptation_found_t before = found_by(&bench);
    // More torque than the ramp takes, from its beginning on.
    bench_run(&bench, HIGH_rad_s, 0.05);
    bench.load_Nm = 12.0;
    bench_run(&bench, HIGH_rad_s, 1.0);
    const lode_adaptation_found_t found = found_by(&bench);
    TEST_ASSERT_FLOAT_WITHIN(0.05f, 1.0f, found.J_kgm2.value / before.J_kgm2.value);
}

// One edge alone is doubted, two that agree are another inertia.
static void test_another_inertia_is_believed_when_it_was_seen_twice(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    ramps(&bench, 3);
    bench.J = 2.0;
    lode_adaptation_found_t found = found_by(&bench);
    for (int n = 0; n < 2000 && found.J_kgm2.confidence >= 0.5f; n++) {
        (void)bench_call(&bench, HIGH_rad_s);
        found = found_by(&bench);
    }
    TEST_ASSERT_TRUE(found.J_kgm2.confidence < 0.5f);
    expect(1.0, 0.05, bench.config.motor.J_kgm2, found.J_kgm2);
    bench_run(&bench, HIGH_rad_s, 2.0); // and another one
    expect(2.0, 0.1, bench.config.motor.J_kgm2, found_by(&bench).J_kgm2);
    ramps(&bench, 2);
    TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence > 0.5f);
}

// Doubt by the first edge, whatever it says; less of it by the second, which agrees with the first.
static void test_two_edges_that_agree_take_the_doubt_away(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    ramps(&bench, 4);
    bench_run(&bench, LOW_rad_s, 1.0);
    bench.J = 3.0;
    (void)edge(&bench, HIGH_rad_s);
    TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence < 0.1f);
    (void)edge(&bench, HIGH_rad_s);
    expect(3.0, 0.1, bench.config.motor.J_kgm2, found_by(&bench).J_kgm2);
    TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence > 0.4f);
}

static void test_edges_that_all_differ_are_not_believed(void) {
    static const double shares[] = {2.0, 3.0, 4.5};
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    ramps(&bench, 4);
    for (int n = 0; n < COUNT_OF(shares); n++) {
        bench.J = shares[n];
        const double far =
            100.0 * HIGH_rad_s; // begin and end of a ramp, each alone, begin of another
        bench_run(&bench, n % 2 == 0 ? bench.reference : far, 1.5);
        (void)edge(&bench, n % 2 == 0 ? far : bench.reference);
        expect(1.0, 0.05, bench.config.motor.J_kgm2, found_by(&bench).J_kgm2);
    }
    TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence <= 0.0f);
}

// The past is forgotten: after twenty ramps nothing is left of it, where each differed too little to be doubted.
static void test_an_inertia_that_is_a_little_other_is_followed(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    ramps(&bench, 5);
    bench.J = 1.25;
    ramps(&bench, 20);
    expect(1.25, 0.01, bench.config.motor.J_kgm2, found_by(&bench).J_kgm2);
}

// A single edge that differs says nothing, however often there has been one before.
static void test_each_single_edge_is_doubted_anew(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 2.0;
    ramps(&bench, 3);
    for (int n = 0; n < 3; n++) {
        const double far = 100.0 * HIGH_rad_s; // begin and end of a ramp, each alone
        bench_run(&bench, bench.reference, 1.5);
        bench.J = 1.0;
        (void)edge(&bench, far);
        expect(2.0, 0.1, bench.config.motor.J_kgm2, found_by(&bench).J_kgm2);
        bench.J = 2.0;
        bench_run(&bench, far, 1.5);
        (void)edge(&bench, bench.reference);
        expect(2.0, 0.1, bench.config.motor.J_kgm2, found_by(&bench).J_kgm2);
    }
}

static void test_what_is_beyond_all_reason_is_bounded(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 9.0;
    bench.psi = 0.6;
    bench.load_Nm = 4.0;
    ramps(&bench, 4);
    const lode_adaptation_found_t found = found_by(&bench);
    expect(5.0, 1.0e-3, bench.config.motor.J_kgm2, found.J_kgm2);
    expect(0.8, 1.0e-3, bench.config.motor.psi_Wb, found.psi_Wb);
    TEST_ASSERT_TRUE(bench.drive.tuning->references.psi_Wb >= 0.7999f * bench.config.motor.psi_Wb);
}

static void test_flux_is_found_under_load(void) {
    static const double shares[] = {0.9, 1.1};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        static bench_t bench;
        bench_init(&bench, &all, NULL);
        bench.psi = shares[n];
        bench.id_A = -2.0;
        bench.load_Nm = 3.0;
        bench_run(&bench, HIGH_rad_s, 15.0);
        const lode_adaptation_found_t found = found_by(&bench);
        expect(shares[n], 0.01, bench.config.motor.psi_Wb, found.psi_Wb);
        TEST_ASSERT_TRUE(found.psi_Wb.confidence > 0.7f);
        // Lock and FLUX go by the commissioned one, the torque by what there is.
        const lode_drive_tuning_t *now = bench.drive.tuning;
        TEST_ASSERT_TRUE(now->estimator.psi_Wb == bench.tuning.estimator.psi_Wb);
        TEST_ASSERT_FLOAT_WITHIN(0.01f, (float)shares[n],
                                 now->references.psi_Wb / bench.tuning.references.psi_Wb);
        TEST_ASSERT_TRUE(now->references.tau_max <= bench.tuning.references.tau_max);
    }
}

// What the torque is reckoned by is that of one motor: the whole references as designed for that flux, but for
// the greatest torque, which may be less, and is as before where there is more flux.
static void test_references_are_those_of_the_flux_found(void) {
    static const double shares[] = {0.85, 1.15};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        static bench_t bench;
        bench_init(&bench, &all, NULL);
        bench.psi = shares[n];
        bench.load_Nm = 3.0;
        bench_run(&bench, HIGH_rad_s, 15.0);
        const lode_references_tuning_t *now = &bench.drive.tuning->references;
        const lode_references_tuning_t *base = &bench.tuning.references;
        TEST_ASSERT_FLOAT_WITHIN(1.0e-4f, 1.0f, now->inv_psi2 * now->psi_Wb * now->psi_Wb);
        lode_drive_config_t config = bench.config;
        config.motor.psi_Wb = now->psi_Wb;
        lode_drive_tuning_t other;
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&other, &config));
        if (shares[n] < 1.0) {
            const float most = other.references.tau_max;
            TEST_ASSERT_TRUE(lode_in_range(now->tau_max, 0.95f * most, most));
        } else {
            TEST_ASSERT_EQUAL_FLOAT(base->tau_max, now->tau_max);
        }
    }
}

static const lode_adaptation_config_t flux_only = {LODE_OFF, LODE_ON, LODE_OFF};

// At high speed all the time. The first call but sets the clock.
static float flux_confidence(bench_t *bench, double seconds) {
    bench->reference = bench->speed = HIGH_rad_s;
    bench_run(bench, HIGH_rad_s, seconds + call_s(bench));
    return found_by(bench).psi_Wb.confidence;
}

// A confidence is made by time: a hundred times fewer calls make the same.
static void test_confidence_grows_by_time_and_not_by_calls(void) {
    float psi[2];
    float Rs[2];
    for (int n = 0; n < 2; n++) {
        static bench_t bench;
        bench_init(&bench, &flux_only, NULL);
        bench.call_steps = n == 0 ? CALL_STEPS : 80u * CALL_STEPS;
        bench.load_Nm = 3.0;
        psi[n] = flux_confidence(&bench, 0.4);
        const lode_adaptation_config_t Rs_only = {LODE_OFF, LODE_OFF, LODE_ON};
        bench_init(&bench, &Rs_only, NULL);
        bench.call_steps = n == 0 ? CALL_STEPS : 80u * CALL_STEPS;
        bench.reference = bench.speed = SLOW_rad_s;
        bench.load_Nm = 5.0;
        bench_run(&bench, SLOW_rad_s, 0.8 + call_s(&bench));
        Rs[n] = found_by(&bench).Rs_Ohm.confidence;
    }
    TEST_ASSERT_TRUE(lode_in_range(psi[0], 0.2f, 0.9f) && lode_in_range(Rs[0], 0.2f, 0.9f));
    TEST_ASSERT_FLOAT_WITHIN(0.02f * psi[0], psi[0], psi[1]);
    TEST_ASSERT_FLOAT_WITHIN(0.02f * Rs[0], Rs[0], Rs[1]);
}

// d and q current together turn what an error of the inductances makes further than either alone.
static void test_flux_is_reported_worse_with_current_in_both_axes(void) {
    static const double id_A[] = {0.0, -1.5};
    float confidence[2];
    for (int n = 0; n < 2; n++) {
        static bench_t bench;
        bench_init(&bench, &flux_only, NULL);
        bench.load_Nm = 3.0;
        bench.id_A = id_A[n];
        confidence[n] = flux_confidence(&bench, 2.0);
    }
    TEST_ASSERT_TRUE(confidence[1] < 0.99f * confidence[0]);
}

// Dead time of which a quarter of a microsecond is in doubt anyway: as much of it by small currents makes no
// difference, twice as much does, and so it is whether the current is where that ends or not.
static void test_doubt_of_the_dead_time(void) {
    const float doubt = 0.25e-6f * 5000.0f; // duty
    static bench_t bench;
    float confidence[6];
    const struct {
        float duty, i_dead_A;
        double id_A, load_Nm;
    } cases[] = {
        {0.0f, 0.0f, 0.0, 0.1},         {doubt, 0.5f, 0.0, 0.1}, {2.0f * doubt, 0.5f, 0.0, 0.1},
        {2.0f * doubt, 2.0f, 0.0, 0.1}, {0.0f, 0.0f, -2.0, 1.5}, {40.0f * doubt, 0.5f, -2.0, 1.5},
    };
    for (int n = 0; n < COUNT_OF(cases); n++) {
        bench_init(&bench, &flux_only, NULL);
        bench.load_Nm = cases[n].load_Nm;
        bench.id_A = cases[n].id_A;
        if (cases[n].duty > 0.0f) {
            bench.drive.inverter.dead_time = (lode_dead_time_t){
                .slope_A = 0.5f * cases[n].duty / cases[n].i_dead_A, .i_dead_A = cases[n].i_dead_A};
        }
        confidence[n] = flux_confidence(&bench, 0.1);
    }
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, confidence[0], confidence[1]);
    TEST_ASSERT_TRUE(confidence[2] < 0.99f * confidence[1]);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, confidence[2], confidence[3]);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, confidence[4], confidence[5]); // 3 A: none of it is in doubt
}

// After minutes of the same, another flux is found within the minute that magnets take, another resistance
// within that of a winding, a third of it.
static void test_what_was_sure_is_left_again(void) {
    static bench_t bench;
    bench_init(&bench, &flux_only, NULL);
    bench.call_steps = 10u * CALL_STEPS;
    bench.load_Nm = 3.0;
    bench_run(&bench, HIGH_rad_s, 400.0);
    bench.psi = 0.9;
    bench_run(&bench, HIGH_rad_s, 60.0);
    expect(0.9, 0.01, bench.config.motor.psi_Wb, found_by(&bench).psi_Wb);
    bench_init(&bench, &(lode_adaptation_config_t){LODE_OFF, LODE_OFF, LODE_ON}, NULL);
    bench.call_steps = 10u * CALL_STEPS;
    bench.load_Nm = 5.0;
    bench.reference = bench.speed = SLOW_rad_s;
    bench_run(&bench, SLOW_rad_s, 400.0);
    bench.Rs = 1.3;
    bench_run(&bench, SLOW_rad_s, 20.0);
    expect(1.3, 0.06, bench.config.motor.Rs_Ohm, found_by(&bench).Rs_Ohm);
}

static void test_flux_is_not_learned_at_low_speed(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.reference = bench.speed = SLOW_rad_s;
    bench.psi = 0.9;
    bench.load_Nm = 3.0;
    bench_run(&bench, SLOW_rad_s, 3.0);
    TEST_ASSERT_TRUE(found_by(&bench).psi_Wb.value == bench.config.motor.psi_Wb);
}

// Where the dead time is not known, a flux that only it would explain is not believed soon.
static void test_small_currents_tell_less_of_the_flux(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.load_Nm = 3.0;
    bench_run(&bench, HIGH_rad_s, 2.0);
    const float loaded = found_by(&bench).psi_Wb.confidence;
    bench_init(&bench, &all, NULL);
    bench.drive.inverter.dead_time = (lode_dead_time_t){.slope_A = 0.02f, .i_dead_A = 1.0f};
    bench_run(&bench, HIGH_rad_s, 2.0);
    TEST_ASSERT_TRUE(found_by(&bench).psi_Wb.confidence < 0.5f * loaded);
}

static void test_resistance_is_found_at_low_speed_and_high_current(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.Rs = 1.3;
    bench.load_Nm = -5.0;
    bench.reference = bench.speed = -LOW_rad_s; // whichever way it turns
    bench_run(&bench, -HIGH_rad_s, 20.0);       // the flux first
    bench_run(&bench, -SLOW_rad_s, 60.0);
    const lode_adaptation_found_t found = found_by(&bench);
    // Before, what it makes of the EMF went to the flux in part, some 2 % of it.
    expect(1.3, 0.05, bench.config.motor.Rs_Ohm, found.Rs_Ohm);
    TEST_ASSERT_TRUE(found.Rs_Ohm.confidence > 0.5f);
    const float used =
        bench.tuning.estimator.emf.a_over_b - bench.drive.tuning->estimator.emf.a_over_b;
    TEST_ASSERT_FLOAT_WITHIN(0.06f, 0.3f, used / bench.config.motor.Rs_Ohm);
}

// At rest, a current of no motor leaves hardly any variance, and rounding none at all: a variance below 0 was a confidence above
// 1, which is not taken as a stored one.
static void test_what_is_certain_is_no_more_than_that(void) {
    static bench_t bench;
    int certain = 0;
    for (double load_Nm = 1.0e3; load_Nm < 1.0e6; load_Nm *= 1.1) {
        bench_init(&bench, &all, NULL);
        bench.reference = bench.speed = 0.0;
        bench.load_Nm = load_Nm;
        for (int n = 0; n < 20; n++) {
            (void)bench_call(&bench, 0.0);
            const float confidence = found_by(&bench).Rs_Ohm.confidence;
            TEST_ASSERT_TRUE(lode_in_range(confidence, 0.0f, 1.0f));
            certain += confidence < 1.0f ? 0 : 1;
        }
    }
    CHECK_AT_LEAST(1, certain);
}

// What the start has measured is where it goes on from; it is not reckoned with twice.
static void test_resistance_goes_on_from_what_the_start_measured(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.Rs = 1.3;
    bench.drive.inverter.r_more_Ohm = 0.3f * bench.config.motor.Rs_Ohm;
    bench_run(&bench, LOW_rad_s, 0.1);
    const lode_adaptation_found_t found = found_by(&bench);
    expect(1.3, 0.01, bench.config.motor.Rs_Ohm, found.Rs_Ohm);
    TEST_ASSERT_TRUE(found.Rs_Ohm.confidence > 0.5f);
    TEST_ASSERT_TRUE(bench.posted == 0);
    // And stays there: the EMF says so too.
    bench.load_Nm = 5.0;
    bench_run(&bench, LOW_rad_s, 30.0);
    expect(1.3, 0.03, bench.config.motor.Rs_Ohm, found_by(&bench).Rs_Ohm);
}

static void test_without_a_measurement_the_resistance_is_not_known(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench_run(&bench, LOW_rad_s, 0.1);
    TEST_ASSERT_TRUE(found_by(&bench).Rs_Ohm.confidence < 0.1f);
}

// A start that measures makes an end of what bound the error of the resistance to that of the flux.
static void test_a_measured_resistance_does_not_hang_on_the_flux(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.load_Nm = 5.0;
    bench_run(&bench, HIGH_rad_s, 5.0);
    TEST_ASSERT_TRUE(lode_abs(bench.adaptation.machine.covariance) > 0.0f);
    bench.drive.mode = (uint_least8_t)LODE_MODE_OFF;
    bench_run(&bench, HIGH_rad_s, 0.01);
    bench.drive.mode = (uint_least8_t)LODE_MODE_RUN;
    bench.drive.inverter.r_more_Ohm = 0.1f * bench.config.motor.Rs_Ohm;
    (void)bench_call(&bench, HIGH_rad_s);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.adaptation.machine.covariance);
}

// The EMF along the q axis has a sign at no speed too, where its size has none.
static void test_resistance_is_found_at_rest_while_injecting(void) {
    static const double shares[] = {0.7, 1.3};
    for (int n = 0; n < 2 * COUNT_OF(shares); n++) {
        static bench_t bench;
        bench_init(&bench, &all, NULL);
        bench.injects = true;
        bench.Rs = shares[n / 2];
        bench.load_Nm = n % 2 == 0 ? 5.0 : -5.0;
        bench.reference = bench.speed = 0.0;
        bench_run(&bench, 0.0, 20.0);
        const lode_adaptation_found_t found = found_by(&bench);
        expect(shares[n / 2], 0.02, bench.config.motor.Rs_Ohm, found.Rs_Ohm);
        TEST_ASSERT_TRUE(found.Rs_Ohm.confidence > 0.7f);
        TEST_ASSERT_TRUE(found.psi_Wb.value == bench.config.motor.psi_Wb);
    }
}

// An error of Lq turns the EMF away from the angle that injection gives, and makes it longer.
static void test_flux_is_found_while_Lq_is_not_known(void) {
    static const double speeds[] = {HIGH_rad_s, -HIGH_rad_s};
    for (int n = 0; n < COUNT_OF(speeds); n++) {
        static bench_t bench;
        bench_init(&bench, &all, NULL);
        bench.injects = true;
        bench.psi = 0.9;
        bench.across = 0.4;
        bench.reference = bench.speed = speeds[n];
        bench.load_Nm = 3.0;
        bench_run(&bench, speeds[n], 15.0);
        expect(0.9, 0.01, bench.config.motor.psi_Wb, found_by(&bench).psi_Wb);
    }
}

// Where the EMF itself gives the angle, what is across is that of a PLL on its way: the size counts.
static void test_without_injection_the_size_of_the_EMF_counts(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.psi = 0.9;
    bench.across = 0.4;
    bench.reference = bench.speed = HIGH_rad_s;
    bench.load_Nm = 3.0;
    bench_run(&bench, HIGH_rad_s, 15.0);
    expect(0.9 * sqrt(1.0 + 0.4 * 0.4), 0.01, bench.config.motor.psi_Wb, found_by(&bench).psi_Wb);
}

// What learn.h has made goes on with what was found.
static void test_another_base_keeps_what_was_found(void) {
    static bench_t bench;
    static lode_drive_tuning_t learned;
    bench_init(&bench, &all, NULL);
    bench.J = 2.0;
    bench.psi = 0.9;
    bench.Rs = 1.3;
    bench.load_Nm = 3.0;
    ramps(&bench, 4);
    bench_run(&bench, SLOW_rad_s, 20.0);
    take(&bench);
    const lode_drive_tuning_t before = *bench.drive.tuning;
    lode_drive_config_t config = bench.config;
    config.motor.Lq_H *= 0.8f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_tune(&learned, &config));
    TEST_ASSERT_TRUE(lode_adaptation_post(&bench.adaptation, &bench.drive, &learned));
    TEST_ASSERT_FALSE(lode_adaptation_post(&bench.adaptation, &bench.drive, &bench.tuning));
    take(&bench);
    const lode_drive_tuning_t *now = bench.drive.tuning;
    TEST_ASSERT_TRUE(now->estimator.salient_H == learned.estimator.salient_H);
    TEST_ASSERT_TRUE(now->speed.inertia_Nm == before.speed.inertia_Nm);
    TEST_ASSERT_TRUE(now->references.psi_Wb == before.references.psi_Wb);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-4f, bench.tuning.estimator.emf.a_over_b,
                             before.estimator.emf.a_over_b +
                                 bench.adaptation.machine.Rs_used * config.motor.Rs_Ohm);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-4f, learned.estimator.emf.a_over_b,
                             now->estimator.emf.a_over_b +
                                 bench.adaptation.machine.Rs_used * config.motor.Rs_Ohm);
    TEST_ASSERT_TRUE(bench.adaptation.machine.Rs_used > 0.05f);
    // And it goes on from there.
    const int posted = bench.posted;
    bench.J = 1.0;
    ramps(&bench, 4);
    TEST_ASSERT_TRUE(bench.posted > posted);
    TEST_ASSERT_TRUE(bench.drive.tuning->estimator.salient_H == learned.estimator.salient_H);
    expect(1.0, 0.1, bench.config.motor.J_kgm2, found_by(&bench).J_kgm2);
}

static void test_each_can_be_off(void) {
    static const lode_adaptation_config_t none = {LODE_OFF, LODE_OFF, LODE_OFF};
    static bench_t bench;
    lode_adaptation_found_t stored;
    bench_init(&bench, &all, NULL);
    bench.J = 2.0;
    bench.psi = 0.9;
    bench.load_Nm = 3.0;
    bench.drive.inverter.r_more_Ohm = 0.1f * bench.config.motor.Rs_Ohm;
    ramps(&bench, 4);
    stored = found_by(&bench);
    TEST_ASSERT_TRUE(bench.posted > 0);
    bench_init(&bench, &none, &stored);
    bench.J = 2.0;
    bench.psi = 0.9;
    bench.Rs = 1.3;
    bench.load_Nm = 3.0;
    bench.drive.inverter.r_more_Ohm = 0.1f * bench.config.motor.Rs_Ohm;
    ramps(&bench, 4);
    const lode_adaptation_found_t found = found_by(&bench);
    TEST_ASSERT_EQUAL_INT(0, bench.posted);
    TEST_ASSERT_TRUE(found.J_kgm2.value == bench.config.motor.J_kgm2);
    TEST_ASSERT_TRUE(found.psi_Wb.value == bench.config.motor.psi_Wb);
    TEST_ASSERT_TRUE(found.Rs_Ohm.value == bench.config.motor.Rs_Ohm);
    TEST_ASSERT_TRUE(found.J_kgm2.confidence + found.psi_Wb.confidence + found.Rs_Ohm.confidence <=
                     0.0f);
}

static void test_what_was_found_can_be_kept(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    const lode_motor_t motor = bench.config.motor;
    const lode_adaptation_found_t stored = {.J_kgm2 = {2.0f * motor.J_kgm2, 0.9f},
                                            .psi_Wb = {0.9f * motor.psi_Wb, 0.8f},
                                            .Rs_Ohm = {1.2f * motor.Rs_Ohm, 0.7f}};
    bench_init(&bench, &all, &stored);
    const lode_adaptation_found_t found = found_by(&bench);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, 2.0f, found.J_kgm2.value / motor.J_kgm2);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, 0.9f, found.J_kgm2.confidence);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, 0.9f, found.psi_Wb.value / motor.psi_Wb);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, 0.8f, found.psi_Wb.confidence);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, 1.2f, found.Rs_Ohm.value / motor.Rs_Ohm);
    TEST_ASSERT_FLOAT_WITHIN(1.0e-5f, 0.7f, found.Rs_Ohm.confidence);
}

static void test_a_stored_value_that_makes_no_sense_is_not_taken(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    const lode_motor_t motor = bench.config.motor;
    const lode_adaptation_found_t stored[] = {
        {{NAN, 0.9f}, {NAN, 0.9f}, {NAN, 0.9f}},
        {{2.0f * motor.J_kgm2, NAN}, {0.9f * motor.psi_Wb, 1.5f}, {1.1f * motor.Rs_Ohm, -1.0f}},
        {{0.1f * motor.J_kgm2, 0.9f}, {0.7f * motor.psi_Wb, 0.9f}, {0.4f * motor.Rs_Ohm, 0.9f}},
        {{6.0f * motor.J_kgm2, 0.9f}, {1.3f * motor.psi_Wb, 0.9f}, {1.6f * motor.Rs_Ohm, 0.9f}},
    };
    for (int n = 0; n < COUNT_OF(stored); n++) {
        bench_init(&bench, &all, &stored[n]);
        const lode_adaptation_found_t found = found_by(&bench);
        TEST_ASSERT_TRUE(found.J_kgm2.value == motor.J_kgm2 && found.psi_Wb.value == motor.psi_Wb &&
                         found.Rs_Ohm.value == motor.Rs_Ohm);
    }
}

static void test_it_rests_unless_the_drive_runs_on_its_own_tuning(void) {
    static const struct {
        lode_mode_t mode;
        bool other;
    } cases[] = {{LODE_MODE_START, false}, {LODE_MODE_RUN, true}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        static bench_t bench;
        bench_init(&bench, &all, NULL);
        bench.J = 2.0;
        const lode_drive_tuning_t other = bench.tuning;
        bench.drive.mode = (uint_least8_t)cases[n].mode;
        if (cases[n].other) {
            bench.drive.tuning = &other;
        }
        ramps(&bench, 3);
        TEST_ASSERT_EQUAL_INT(0, bench.posted);
        TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence <= 0.0f);
    }
}

static void test_torque_control_has_no_ramp(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 2.0;
    bench.drive.command.flags = (uint_least8_t)LODE_ORDER_TORQUE;
    ramps(&bench, 3);
    TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence <= 0.0f);
}

static void test_calls_may_come_as_they_like(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    ramps(&bench, 2);
    const lode_adaptation_t before = bench.adaptation;
    TEST_ASSERT_FALSE(lode_adaptation_step(&bench.adaptation, &bench.drive)); // no period later
    TEST_ASSERT_EQUAL_MEMORY(&before, &bench.adaptation, sizeof before);
    bench.drive.posted_tuning = &bench.tuning; // not taken yet
    bench.drive.steps += CALL_STEPS;
    TEST_ASSERT_FALSE(lode_adaptation_step(&bench.adaptation, &bench.drive));
    TEST_ASSERT_EQUAL_MEMORY(&before, &bench.adaptation, sizeof before);
    // After a long pause from another speed: no jump of it passes for an acceleration.
    bench.drive.posted_tuning = NULL;
    bench.drive.steps += 5000u;
    bench.reference = bench.speed = HIGH_rad_s;
    (void)bench_call(&bench, HIGH_rad_s);
    TEST_ASSERT_TRUE(bench.adaptation.machine.edge.energy <= 0.0f);
}

// A reference that swings all the time has no end of an edge.
static void test_a_swinging_reference_is_looked_at_now_and_then(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 2.0;
    for (int n = 0; n < 20000; n++) {
        (void)bench_call(&bench, n % 240 < 120 ? HIGH_rad_s : LOW_rad_s);
    }
    expect(2.0, 0.1, bench.config.motor.J_kgm2, found_by(&bench).J_kgm2);
}

static void test_a_reference_that_never_rests_shows_nothing(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    for (int n = 0; n < 2000; n++) {
        bench.reference = n % 2 == 0 ? 2.0 * HIGH_rad_s : -HIGH_rad_s;
        (void)bench_call(&bench, bench.reference);
        TEST_ASSERT_TRUE(bench.adaptation.machine.edge.energy < 5.0f);
    }
    TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence <= 0.0f);
}

// Less torque, more speed: whatever drives it, it is no inertia.
static void test_an_inertia_below_nothing_is_not_believed(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = -0.5;
    for (int n = 0; n < 2; n++) {
        (void)edge(&bench, HIGH_rad_s);
        TEST_ASSERT_TRUE(found_by(&bench).J_kgm2.confidence <= 0.0f);
    }
}

// Magnets that have cooled down, and then lose a part of their flux: FLUX goes by the commissioned one.
static void test_adaptation_does_not_hide_demagnetisation(void) {
    static const double before[] = {0.85, 1.0, 1.15};
    for (int n = 0; n < COUNT_OF(before); n++) {
        static rig_t rig;
        static lode_drive_tuning_t tuning;
        static lode_adaptation_t adaptation;
        lode_drive_config_t config = rig_config();
        lode_drive_design(&config);
        rig_init(&rig, &tuning, &config);
        const double commissioned = rig.motor.psi;
        rig.motor.psi = before[n] * commissioned;
        TEST_ASSERT_EQUAL_INT(
            LODE_OK, lode_adaptation_init(&adaptation, &all, &tuning, &config.motor, NULL));
        rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = 100.0f});
        for (int ms = 0; ms < 12000; ms++) {
            rig.load_Nm = ms > 2000 ? 3.0 : 0.0;
            rig_run(&rig, CALL_s);
            (void)lode_adaptation_step(&adaptation, &rig.drive);
        }
        rig_expect(&rig, LODE_MODE_RUN);
        const float used = rig.drive.tuning->references.psi_Wb / tuning.references.psi_Wb;
        TEST_ASSERT_FLOAT_WITHIN(0.03f, (float)before[n], used);
        rig.motor.psi = 0.7 * commissioned;
        for (int ms = 0; ms < 100; ms++) {
            rig_run(&rig, CALL_s);
            (void)lode_adaptation_step(&adaptation, &rig.drive);
        }
        TEST_ASSERT_EQUAL_STRING("LODE_CHECK_FLUX",
                                 lode_check_name(rig_telemetry(&rig).fault.check));
    }
}

// The same C on a drive that starts, ramps and is loaded, of a motor with other parameters than configured.
static void test_a_running_drive_finds_its_motor(void) {
    static rig_t rig;
    static lode_drive_tuning_t tuning;
    static lode_adaptation_t adaptation;
    lode_drive_config_t config = rig_config();
    config.motor.J_kgm2 *= 1.5f;
    config.motor.psi_Wb *= 1.05f;
    lode_drive_design(&config);
    rig_init(&rig, &tuning, &config);
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_adaptation_init(&adaptation, &all, &tuning, &config.motor, NULL));
    for (int n = 0; n < 10000; n++) {
        if (n % 1000 == 0) {
            const float speed = n % 2000 == 0 ? 60.0f : 120.0f;
            rig_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = speed});
        }
        rig.load_Nm = n > 2000 ? 3.0 : 0.0;
        rig_run(&rig, CALL_s);
        (void)lode_adaptation_step(&adaptation, &rig.drive);
        TEST_ASSERT_TRUE(rig_telemetry(&rig).mode != LODE_MODE_FAULT);
    }
    const lode_adaptation_found_t found = lode_adaptation_found(&adaptation);
    TEST_ASSERT_FLOAT_WITHIN(0.05f, 1.0f / 1.5f, found.J_kgm2.value / config.motor.J_kgm2);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 1.0f / 1.05f, found.psi_Wb.value / config.motor.psi_Wb);
    TEST_ASSERT_TRUE(found.J_kgm2.confidence > 0.5f);
}

/// Value and confidence of each; the drive's own telemetry has none.
static void test_what_was_found_is_reported(void) {
    static bench_t bench;
    bench_init(&bench, &all, NULL);
    bench.J = 2.0;
    bench.psi = 0.9;
    for (int n = 0; n < 4; n++) {
        bench_run(&bench, HIGH_rad_s, 2.0);
        bench_run(&bench, LOW_rad_s, 2.0);
    }
    lode_telemetry_t now;
    TEST_ASSERT_TRUE(lode_drive_telemetry(&bench.drive, &now));
    CHECK_NEAR(0.0, 0.0, now.motor.J_kgm2.value);
    CHECK_NEAR(0.0, 0.0, now.motor.J_kgm2.confidence);
    lode_telemetry_t wanted = now;
    const lode_adaptation_found_t found = lode_adaptation_found(&bench.adaptation);
    wanted.motor.J_kgm2 = found.J_kgm2;
    wanted.motor.psi_Wb = found.psi_Wb;
    wanted.motor.Rs_Ohm = found.Rs_Ohm;
    lode_adaptation_telemetry(&bench.adaptation, &now);
    TEST_ASSERT_EQUAL_MEMORY(&wanted, &now, sizeof now);
    CHECK_CLOSE(0.1, 2.0 * (double)bench.config.motor.J_kgm2, now.motor.J_kgm2.value);
    CHECK_CLOSE(0.03, 0.9 * (double)bench.config.motor.psi_Wb, now.motor.psi_Wb.value);
    CHECK_AT_LEAST(0.5, (double)now.motor.J_kgm2.confidence);
    CHECK_AT_LEAST(0.5, (double)now.motor.psi_Wb.confidence);
    CHECK_CLOSE(0.01, (double)bench.config.motor.Rs_Ohm, now.motor.Rs_Ohm.value);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_nothing_is_known_at_first);
    RUN_TEST(test_inertia_is_found_by_ramps);
    RUN_TEST(test_the_first_edge_is_believed_as_it_is);
    RUN_TEST(test_a_constant_speed_is_no_edge);
    RUN_TEST(test_an_edge_lasts_as_long_however_seldom_it_is_looked_at);
    RUN_TEST(test_an_acceleration_without_torque_is_no_inertia);
    RUN_TEST(test_a_slope_that_hardly_is_one_shows_no_inertia);
    RUN_TEST(test_inertia_changes_speed_control_and_feed_forward_only);
    RUN_TEST(test_the_ramp_of_a_heavier_rotor);
    RUN_TEST(test_a_lighter_rotor_is_followed_as_closely);
    RUN_TEST(test_no_step_of_a_tuning_is_large);
    RUN_TEST(test_a_load_step_with_the_ramp_is_no_inertia);
    RUN_TEST(test_another_inertia_is_believed_when_it_was_seen_twice);
    RUN_TEST(test_two_edges_that_agree_take_the_doubt_away);
    RUN_TEST(test_edges_that_all_differ_are_not_believed);
    RUN_TEST(test_an_inertia_that_is_a_little_other_is_followed);
    RUN_TEST(test_each_single_edge_is_doubted_anew);
    RUN_TEST(test_what_is_beyond_all_reason_is_bounded);
    RUN_TEST(test_flux_is_found_under_load);
    RUN_TEST(test_references_are_those_of_the_flux_found);
    RUN_TEST(test_confidence_grows_by_time_and_not_by_calls);
    RUN_TEST(test_flux_is_reported_worse_with_current_in_both_axes);
    RUN_TEST(test_doubt_of_the_dead_time);
    RUN_TEST(test_what_was_sure_is_left_again);
    RUN_TEST(test_flux_is_not_learned_at_low_speed);
    RUN_TEST(test_small_currents_tell_less_of_the_flux);
    RUN_TEST(test_resistance_is_found_at_low_speed_and_high_current);
    RUN_TEST(test_what_is_certain_is_no_more_than_that);
    RUN_TEST(test_resistance_goes_on_from_what_the_start_measured);
    RUN_TEST(test_without_a_measurement_the_resistance_is_not_known);
    RUN_TEST(test_a_measured_resistance_does_not_hang_on_the_flux);
    RUN_TEST(test_resistance_is_found_at_rest_while_injecting);
    RUN_TEST(test_flux_is_found_while_Lq_is_not_known);
    RUN_TEST(test_without_injection_the_size_of_the_EMF_counts);
    RUN_TEST(test_another_base_keeps_what_was_found);
    RUN_TEST(test_each_can_be_off);
    RUN_TEST(test_what_was_found_can_be_kept);
    RUN_TEST(test_a_stored_value_that_makes_no_sense_is_not_taken);
    RUN_TEST(test_it_rests_unless_the_drive_runs_on_its_own_tuning);
    RUN_TEST(test_torque_control_has_no_ramp);
    RUN_TEST(test_calls_may_come_as_they_like);
    RUN_TEST(test_a_swinging_reference_is_looked_at_now_and_then);
    RUN_TEST(test_a_reference_that_never_rests_shows_nothing);
    RUN_TEST(test_an_inertia_below_nothing_is_not_believed);
    RUN_TEST(test_adaptation_does_not_hide_demagnetisation);
    RUN_TEST(test_a_running_drive_finds_its_motor);
    RUN_TEST(test_what_was_found_is_reported);
    return UNITY_END();
}
