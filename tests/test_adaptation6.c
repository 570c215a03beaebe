// Adaptation with six phases on a dual three-phase machine in double: what is found, what comes of it, one set alone.
#include "support/rig6.h"

#include "drive_inline.h"
#include "lodestar/adaptation6.h"

#define CALL_STEPS 10 // 1 ms
#define RAMP_Nm 10.0  // a quarter of all torque
#define SLOW_rpm 20.0
#define LOW_rpm 450.0
#define HIGH_rpm 1200.0
#define LOAD_Nm 6.0
#define MOST_Nm 20.0

void setUp(void) {}

void tearDown(void) {}

static rig6_t rig;
static lode_drive6_config_t config;
static lode_drive6_tuning_t tuning;
static lode_adaptation6_t adaptation;
static int posted;

static const lode_adaptation_config_t all = {.J = LODE_AUTO, .psi = LODE_ON};

/// Truth over configured.
typedef struct {
    double J, psi, Rs;
} shares_t;

static const shares_t as_configured = {1.0, 1.0, 1.0};

/// What the drive is told of the rig's machine.
static lode_drive6_config_t config_of(shares_t truth) {
    lode_drive6_config_t c = rig6_config();
    c.drive.motor.J_kgm2 = (float)(RIG6_J / truth.J);
    c.drive.motor.psi_Wb = (float)(RIG6_PSI / truth.psi);
    c.drive.motor.Rs_Ohm = (float)(RIG6_R / truth.Rs);
    c.drive.speed.ramp_rad_s2 = (float)(RAMP_Nm * truth.J / RIG6_J);
    c.drive.start.omega_handover_rad_s = 0.0f; // as designed
    c.open_phase = LODE_OPEN_PHASE_GO_ON;
    return c;
}

static void begin_with(const lode_drive6_config_t *given, const lode_adaptation_config_t *choices,
                       const lode_adaptation_found_t *stored) {
    config = *given;
    lode_drive6_design(&config);
    rig6_init(&rig, &tuning, &config);
    rig.theta = CHECK_PI; // as in test_drive6.c
    posted = 0;
    TEST_ASSERT_EQUAL_STRING("LODE_OK",
                             lode_status_name(lode_adaptation6_init(&adaptation, choices, &tuning,
                                                                    &config.drive.motor, stored)));
}

static void begin(shares_t truth, const lode_adaptation_config_t *choices,
                  const lode_adaptation_found_t *stored) {
    const lode_drive6_config_t given = config_of(truth);
    begin_with(&given, choices, stored);
}

static void run(double rpm, double load_Nm, double seconds) {
    const double omega = rpm * 2.0 * CHECK_PI / 60.0;
    rig6_command(&rig, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = (float)omega});
    rig.load_Nm = load_Nm;
    for (int n = 0; n < (int)(seconds / RIG6_TS_s + 0.5); n++) {
        rig6_step(&rig);
        if (n % CALL_STEPS == 0 && lode_adaptation6_step(&adaptation, &rig.drive)) {
            posted++;
            TEST_ASSERT_TRUE(rig.drive.posted_tuning != rig.drive.tuning); // it may still be read
        }
    }
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_RUN", lode_mode_name(rig6_telemetry(&rig).drive.mode));
}

static void ramps(int count) {
    for (int n = 0; n < count; n++) {
        run(HIGH_rpm, 1.0, 1.0);
        run(HIGH_rpm, LOAD_Nm, 1.0);
        run(HIGH_rpm, 1.0, 1.0);
        run(LOW_rpm, 1.0, 1.0);
    }
}

static lode_adaptation_found_t found(void) {
    return lode_adaptation6_found(&adaptation);
}

static lode_status_t init_with(const lode_adaptation_config_t *choices, const lode_motor_t *motor) {
    return lode_adaptation6_init(&adaptation, choices, &tuning, motor, NULL);
}

static void test_bad_configurations_are_refused(void) {
    begin(as_configured, &all, NULL);
    lode_motor_t motor = config.drive.motor;
    lode_adaptation6_t *a = &adaptation;
    const lode_adaptation6_t before = adaptation;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL,
                          lode_adaptation6_init(NULL, &all, &tuning, &motor, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_adaptation6_init(a, NULL, &tuning, &motor, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_adaptation6_init(a, &all, NULL, &motor, NULL));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, init_with(&all, NULL));
    const lode_adaptation_config_t bad = {.psi = (lode_choice_t)3};
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_CHOICE, init_with(&bad, &motor));
    motor.Rs_Ohm = 0.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_RS, init_with(&all, &motor));
    motor = config.drive.motor;
    motor.omega_rated_rad_s = 0.0f;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_OMEGA, init_with(&all, &motor));
    const lode_drive6_tuning_t other = tuning;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_MOTOR_OMEGA,
                          lode_adaptation6_init(a, &all, &other, &motor, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&before, a, sizeof before);
}

/// The bounds are those that tests/sim/rig holds three phases to.
static void test_inertia_and_flux_are_found(void) {
    static const shares_t cases[] = {
        {0.5, 1.0, 1.0}, {2.0, 1.0, 1.0}, {1.0, 0.9, 1.0}, {1.0, 1.1, 1.0}};
    for (int n = 0; n < COUNT_OF(cases); n++) {
        begin(cases[n], &all, NULL);
        run(LOW_rpm, 0.0, 2.0);
        ramps(3);
        const lode_adaptation_found_t now = found();
        CHECK_CLOSE(0.08, RIG6_J, now.J_kgm2.value);
        CHECK_AT_LEAST(0.5, now.J_kgm2.confidence);
        CHECK_CLOSE(0.015, RIG6_PSI, now.psi_Wb.value);
        CHECK_AT_LEAST(0.5, now.psi_Wb.confidence);
    }
}

/// Slowly, with injection: the EMF is free to show it.
static void test_resistance_is_found(void) {
    static const double shares[] = {0.7, 1.3};
    for (int n = 0; n < COUNT_OF(shares); n++) {
        lode_drive6_config_t given = config_of((shares_t){1.0, 1.0, shares[n]});
        given.drive.hfi = (lode_hfi_config_t){.mode = LODE_HFI_ON, .V_h_V = 70.0f};
        begin_with(&given, &all, NULL);
        run(LOW_rpm, 0.0, 2.0); // this iron tells no polarity: a turning vector starts it
        run(SLOW_rpm, 0.0, 1.0);
        run(SLOW_rpm, MOST_Nm, 10.0);
        CHECK_CLOSE(0.1, RIG6_R, found().Rs_Ohm.value);
        CHECK_AT_LEAST(0.5, found().Rs_Ohm.confidence);
    }
}

static void expect_changed_only_by(const lode_drive_tuning_t *base, lode_drive_tuning_t now) {
    const lode_adaptation_machine_t *used = &adaptation.machine;
    CHECK_CLOSE(1.0e-5, (double)used->J_used, now.speed.inertia_Nm / base->speed.inertia_Nm);
    CHECK_CLOSE(1.0e-5, (double)used->J_used,
                now.estimator.load_per_f_Nm / base->estimator.load_per_f_Nm);
    CHECK_CLOSE(1.0e-5, 1.0 / (double)used->J_used,
                now.estimator.acc_per_torque / base->estimator.acc_per_torque);
    CHECK_CLOSE(1.0e-5, 1.0 / (double)used->J_used,
                now.estimator.acc_per_omega / base->estimator.acc_per_omega);
    CHECK_CLOSE(1.0e-5, 1.0 + (double)used->psi_used,
                now.references.psi_Wb / base->references.psi_Wb);
    CHECK_NEAR(1.0e-4, (double)(used->Rs_used * config.drive.motor.Rs_Ohm),
               base->estimator.emf.a_over_b - now.estimator.emf.a_over_b);
    TEST_ASSERT_TRUE(now.speed.pi.kp > base->speed.pi.kp);
    now.speed = base->speed;
    now.references = base->references;
    now.estimator.load_per_f_Nm = base->estimator.load_per_f_Nm;
    now.estimator.acc_per_torque = base->estimator.acc_per_torque;
    now.estimator.acc_per_omega = base->estimator.acc_per_omega;
    now.estimator.acc_most = base->estimator.acc_most;
    now.estimator.emf.a_over_b = base->estimator.emf.a_over_b;
    TEST_ASSERT_EQUAL_MEMORY(base, &now, sizeof now);
}

static const lode_adaptation_found_t kept = {
    {(float)(1.5 * RIG6_J), 0.9f}, {(float)(0.95 * RIG6_PSI), 0.9f}, {(float)(1.2 * RIG6_R), 0.9f}};

/// Both sets' tuning and that of one set alone, each from its own base; the xy plane stays as it was designed.
static void test_both_tunings_have_what_is_in_use(void) {
    lode_drive6_config_t given = config_of(as_configured);
    given.drive.start.measure = LODE_OFF; // which would take its place
    begin_with(&given, &all, &kept);
    CHECK_CLOSE(1.0e-5, (double)kept.J_kgm2.value, found().J_kgm2.value);
    CHECK_CLOSE(1.0e-5, (double)kept.psi_Wb.value, found().psi_Wb.value);
    CHECK_CLOSE(1.0e-5, (double)kept.Rs_Ohm.value, found().Rs_Ohm.value);
    TEST_ASSERT_TRUE(lode_adaptation6_post(&adaptation, &rig.drive, &tuning));
    // In the mailbox.
    TEST_ASSERT_FALSE(lode_adaptation6_post(&adaptation, &rig.drive, &tuning));
    rig6_init(&rig, &tuning, &config);
    run(LOW_rpm, 0.0, 3.0);
    TEST_ASSERT_TRUE(posted > 2);
    rig6_run(&rig, 2.0 * RIG6_TS_s);
    const lode_drive6_tuning_t *now = rig.drive.tuning;
    TEST_ASSERT_TRUE(now != &tuning && rig.drive.drive.tuning == &now->drive);
    TEST_ASSERT_TRUE(adaptation.machine.J_used > 1.2f && adaptation.machine.psi_used < -0.03f &&
                     adaptation.machine.Rs_used > 0.1f);
    expect_changed_only_by(&tuning.drive, now->drive);
    expect_changed_only_by(&tuning.alone, now->alone);
    TEST_ASSERT_TRUE(tuning.alone.speed.inertia_Nm != tuning.drive.speed.inertia_Nm ||
                     tuning.alone.references.tau_max != tuning.drive.references.tau_max);
    lode_drive6_tuning_t rest = *now;
    rest.drive = tuning.drive;
    rest.alone = tuning.alone;
    TEST_ASSERT_EQUAL_MEMORY(&tuning, &rest, sizeof rest);
}

static void expect_same(lode_adaptation_found_t before) {
    const lode_adaptation_found_t now = found();
    TEST_ASSERT_EQUAL_MEMORY(&before, &now, sizeof now);
}

/// A phase breaks: what is known stays, and the set that is left goes on with it. After a repair it is followed again.
static void test_it_rests_while_a_set_is_out(void) {
    begin((shares_t){2.0, 0.95, 1.0}, &all, NULL);
    run(LOW_rpm, 0.0, 2.0);
    ramps(2);
    run(HIGH_rpm, LOAD_Nm, 2.0);
    const float J_used = adaptation.machine.J_used;
    CHECK_CLOSE(0.1, 2.0, J_used);
    rig.open = 2;
    run(HIGH_rpm, LOAD_Nm, 0.1);
    TEST_ASSERT_EQUAL_INT(LODE_SETS_ONLY_2, rig6_telemetry(&rig).active);
    const lode_adaptation_found_t before = found();
    const int posts = posted;
    const lode_drive_tuning_t *alone = &rig.drive.tuning->alone;
    TEST_ASSERT_EQUAL_PTR(alone, rig.drive.drive.tuning);
    CHECK_CLOSE(1.0e-5, (double)J_used, alone->speed.inertia_Nm / tuning.alone.speed.inertia_Nm);
    run(LOW_rpm, 1.0, 1.0);
    run(HIGH_rpm, 1.0, 1.0);
    TEST_ASSERT_EQUAL_INT(posts, posted);
    expect_same(before);
    rig.open = 0;
    for (int n = 0; n < 40000; n++) {
        if (n % 20000 == 0) { // switched off, then cleared
            rig6_command(&rig, (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true});
        }
        rig6_step(&rig);
        (void)lode_adaptation6_step(&adaptation, &rig.drive);
    }
    expect_same(before);
    run(LOW_rpm, 0.0, 3.0);
    TEST_ASSERT_EQUAL_INT(LODE_SETS_BOTH, rig6_telemetry(&rig).active);
    run(HIGH_rpm, LOAD_Nm, 1.0);
    TEST_ASSERT_TRUE(lode_abs(found().psi_Wb.value - before.psi_Wb.value) > 0.0f);
}

static void test_each_can_be_off(void) {
    static const lode_adaptation_config_t none = {LODE_OFF, LODE_OFF, LODE_OFF};
    begin((shares_t){2.0, 0.9, 1.3}, &none, &kept);
    run(LOW_rpm, 0.0, 2.0);
    ramps(2);
    const lode_adaptation_found_t now = found();
    TEST_ASSERT_EQUAL_INT(0, posted);
    TEST_ASSERT_EQUAL_PTR(&tuning, rig.drive.tuning);
    CHECK_NEAR(0.0, config.drive.motor.J_kgm2, now.J_kgm2.value);
    CHECK_NEAR(0.0, config.drive.motor.psi_Wb, now.psi_Wb.value);
    CHECK_NEAR(0.0, config.drive.motor.Rs_Ohm, now.Rs_Ohm.value);
    CHECK_NEAR(0.0, 0.0, now.J_kgm2.confidence + now.psi_Wb.confidence + now.Rs_Ohm.confidence);
}

/// Another tuning of the same motor, with what was found; and none of somebody else's is looked at.
static void test_another_base_keeps_what_was_found(void) {
    static lode_drive6_tuning_t other;
    lode_drive6_config_t changed = config_of((shares_t){2.0, 0.95, 1.0});
    begin_with(&changed, &all, NULL);
    run(LOW_rpm, 0.0, 2.0);
    ramps(2);
    run(HIGH_rpm, LOAD_Nm, 0.5);
    const float J_used = adaptation.machine.J_used;
    changed.drive.motor.Lq_H *= 0.9f;
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_tune(&other, &changed));
    TEST_ASSERT_TRUE(lode_adaptation6_post(&adaptation, &rig.drive, &other));
    rig6_run(&rig, 2.0 * RIG6_TS_s);
    TEST_ASSERT_TRUE(lode_drive6_tuning_taken(&rig.drive));
    const lode_drive6_tuning_t *now = rig.drive.tuning;
    TEST_ASSERT_TRUE(now != &other &&
                     now->drive.estimator.salient_H == other.drive.estimator.salient_H);
    TEST_ASSERT_TRUE(now->alone.estimator.salient_H == other.alone.estimator.salient_H);
    CHECK_CLOSE(1.0e-5, (double)J_used, now->drive.speed.inertia_Nm / other.drive.speed.inertia_Nm);
    TEST_ASSERT_TRUE(adaptation.machine.base == &other.drive);
    // Its own still: it goes on.
    const float psi_Wb = found().psi_Wb.value;
    run(HIGH_rpm, LOAD_Nm, 0.5);
    TEST_ASSERT_TRUE(lode_abs(found().psi_Wb.value - psi_Wb) > 0.0f);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_post_tuning(&rig.drive, &tuning));
    rig6_run(&rig, 2.0 * RIG6_TS_s);
    const lode_adaptation_found_t before = found();
    run(LOW_rpm, LOAD_Nm, 0.5);
    expect_same(before);
}

/// As with three phases: nothing twice for one period, nothing while a tuning lies in the mailbox.
static void test_calls_may_come_as_they_like(void) {
    begin(as_configured, &all, NULL);
    run(LOW_rpm, 0.0, 2.0);
    const lode_adaptation6_t before = adaptation;
    rig6_step(&rig);
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive6_post_tuning(&rig.drive, &tuning));
    TEST_ASSERT_FALSE(lode_adaptation6_step(&adaptation, &rig.drive));
    TEST_ASSERT_EQUAL_MEMORY(&before, &adaptation, sizeof before);
}

/// Value and confidence of each, into the telemetry as a log takes it.
static void test_what_was_found_is_reported(void) {
    begin(as_configured, &all, &kept);
    lode_telemetry6_t now = rig6_telemetry(&rig);
    lode_telemetry6_t wanted = now;
    wanted.drive.motor.J_kgm2 = found().J_kgm2;
    wanted.drive.motor.psi_Wb = found().psi_Wb;
    wanted.drive.motor.Rs_Ohm = found().Rs_Ohm;
    lode_adaptation6_telemetry(&adaptation, &now.drive);
    TEST_ASSERT_EQUAL_MEMORY(&wanted.drive.motor, &now.drive.motor, sizeof now.drive.motor);
    CHECK_CLOSE(1.0e-5, (double)kept.Rs_Ohm.value, now.drive.motor.Rs_Ohm.value);
    CHECK_AT_LEAST(0.8, now.drive.motor.Rs_Ohm.confidence);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_inertia_and_flux_are_found);
    RUN_TEST(test_resistance_is_found);
    RUN_TEST(test_both_tunings_have_what_is_in_use);
    RUN_TEST(test_it_rests_while_a_set_is_out);
    RUN_TEST(test_each_can_be_off);
    RUN_TEST(test_another_base_keeps_what_was_found);
    RUN_TEST(test_calls_may_come_as_they_like);
    RUN_TEST(test_what_was_found_is_reported);
    return UNITY_END();
}
