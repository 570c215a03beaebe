// The state machine's transitions, called by themselves: what each of them leaves behind, and what it clears.
#include "mode_parts.h"
#include "schedule.h"
#include "support/drive_cases.h"

void setUp(void) {}
void tearDown(void) {}

/// Two thirds of the guard's checks, rounded up; more stay.
static void test_a_rotor_that_is_lost_has_two_thirds_of_the_checks(void) {
    static const struct {
        uint_least16_t checks;
        uint32_t least;
    } cases[] = {{9u, 6u}, {10u, 7u}, {11u, 8u}, {12u, 8u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        rig_t rig = fresh();
        lode_drive_tuning_t other = tuning;
        other.guard.lock_checks = cases[n].checks;
        rig.drive.tuning = &other;
        lode_mode_lose_rotor(&rig.drive);
        TEST_ASSERT_EQUAL_UINT(cases[n].least, rig.drive.guard.lock);
        rig.drive.guard.lock = (uint_least16_t)(cases[n].least + 1u);
        lode_mode_lose_rotor(&rig.drive);
        TEST_ASSERT_EQUAL_UINT(cases[n].least + 1u, rig.drive.guard.lock);
    }
}

static void test_gates_that_switch_on_begin_without_a_past(void) {
    rig_t rig = fresh();
    rig.drive.sensored = 5u;
    rig.drive.frozen.checks = 3u;
    rig.drive.jump.stage = (uint_least8_t)LODE_JUMP_GONE;
    lode_mode_switch_on(&rig.drive, LODE_MODE_START);
    rig_expect(&rig, LODE_MODE_START);
    TEST_ASSERT_TRUE(rig.drive.gates);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.sensored);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.frozen.checks);
    TEST_ASSERT_EQUAL_UINT(LODE_JUMP_NONE, rig.drive.jump.stage);
}

/// A drive in RUN whose counters have all counted.
static rig_t having_counted(void) {
    rig_t rig = steady();
    rig.drive.guard.lock = 3u;
    rig.drive.guard.speed = 4u;
    rig.drive.guard.flux_rounds = 5u;
    rig.drive.state.run.off = 6u;
    rig.drive.state.run.waves.idle = 7u;
    return rig;
}

static void expect_no_counts(const rig_t *rig) {
    TEST_ASSERT_EQUAL_UINT(0u, rig->drive.guard.lock);
    TEST_ASSERT_EQUAL_UINT(0u, rig->drive.guard.speed);
    TEST_ASSERT_EQUAL_UINT(0u, rig->drive.guard.flux_rounds);
    TEST_ASSERT_EQUAL_UINT(0u, rig->drive.state.run.off);
    TEST_ASSERT_EQUAL_UINT(0u, rig->drive.state.run.waves.idle);
}

static void test_run_begins_with_no_counts(void) {
    rig_t rig = having_counted();
    lode_mode_run_at_once(&rig.drive);
    expect_no_counts(&rig);
    rig = having_counted();
    rig.drive.i_A = (lode_dq_t){3.0f, 1.0f};
    lode_start_reset(&rig.drive.state.start, (lode_sincos_t){0.0f, 1.0f}, 100.0f, 5.0f);
    lode_mode_hand_over(&rig.drive);
    expect_no_counts(&rig);
    CHECK_NEAR(0.0, 3.0, rig.drive.ref_A.d); // until the references have their slot
    CHECK_NEAR(0.0, 1.0, rig.drive.ref_A.q);
}

/// (S34), (S36) count with those of RUN.
static void test_a_vector_that_takes_the_rotor_back_begins_with_no_counts(void) {
    rig_t rig = having_counted();
    lode_mode_hand_back(&rig.drive);
    rig_expect(&rig, LODE_MODE_START);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.lock);
    TEST_ASSERT_EQUAL_UINT(0u, rig.drive.guard.speed);
}

/// (S11), (S55), (S56), worked out anew: the vector's angle ahead of the rotor, the voltage that it takes over, the EMF.
static void test_what_the_vector_takes_over_with_the_rotor(void) {
    rig_t rig = steady();
    lode_drive_t *drive = &rig.drive;
    drive->current.d.integral = 2.0f;
    drive->current.q.integral = -3.0f;
    const double I = (double)tuning.start.current_A;
    const double omega = (double)drive->estimator.pll.omega_rad_s;
    drive->i_A = (lode_dq_t){0.5f, (float)(0.6 * I)};
    const double Ld = (double)tuning.references.Ld_H;
    const double Lq = (double)drive->current.Lq_H;
    const double next_d = 0.8 * I; // of the same length, with the same torque component
    const double u_d = 2.0 - omega * Lq * 0.6 * I;
    const double u_q = -3.0 + omega * (Ld * next_d + (double)tuning.references.psi_Wb);
    const lode_sincos_t rotor = lode_estimator_rotor(&drive->estimator);
    const double more_V = omega * (Ld - (double)tuning.references.Lq_H) * (next_d - 0.5);
    const lode_ab_t e_V = drive->estimator.emf.observer.e_V;
    const double e_alpha = (double)e_V.alpha - more_V * (double)rotor.sin;
    const double e_beta = (double)e_V.beta + more_V * (double)rotor.cos;
    lode_mode_hand_back(drive);
    CHECK_NEAR(1e-3, 0.8 * u_d + 0.6 * u_q, drive->current.d.integral);
    CHECK_NEAR(1e-3, 0.8 * u_q - 0.6 * u_d, drive->current.q.integral);
    const lode_start_t *start = &drive->state.start;
    const double ahead = atan2((double)start->at.sin, (double)start->at.cos) -
                         atan2((double)rotor.sin, (double)rotor.cos);
    CHECK_NEAR(1e-5, asin(0.6), remainder(ahead, 2.0 * CHECK_PI));
    const double by_size = (double)start->by_size;
    const double across = e_beta * (double)start->at.cos - e_alpha * (double)start->at.sin;
    const double mean = (1.0 - fabs(by_size)) * across + by_size * hypot(e_alpha, e_beta);
    TEST_ASSERT_TRUE(fabs(more_V) > 0.1 * hypot(e_alpha, e_beta)); // it shows
    CHECK_NEAR(1e-3 * fabs(mean), mean, start->mean_V);
}

/// A tuning with another dead time: what was measured beyond the configured one is less by what that has come closer.
static void test_a_longer_dead_time_leaves_less_beyond_it(void) {
    rig_t rig = fresh();
    lode_drive_tuning_t other = tuning;
    const float most = tuning.inverter.dead_more_max;
    TEST_ASSERT_TRUE(most > 0.0f);
    other.inverter.dead_duty += 0.25f * most;
    rig.drive.inverter.dead_more = 0.5f * most;
    rig.drive.tuning = &other;
    lode_mode_retune(&rig.drive, &tuning);
    CHECK_NEAR(1e-4 * (double)most, 0.25 * (double)most, rig.drive.inverter.dead_more);
    rig.drive.tuning = &tuning;
    lode_mode_retune(&rig.drive, &other);
    CHECK_NEAR(1e-4 * (double)most, 0.5 * (double)most, rig.drive.inverter.dead_more);
}

/// Where no start has measured, other values of a tuning count as they are.
static void test_what_was_not_measured_is_not_kept(void) {
    rig_t rig = fresh();
    lode_drive_tuning_t other = tuning;
    other.inverter.dead_duty *= 1.5f;
    other.start.R_Ohm *= 2.0f;
    rig.drive.inverter.dead_more = 0.0f;
    rig.drive.inverter.r_more_Ohm = 0.0f;
    rig.drive.tuning = &other;
    lode_mode_retune(&rig.drive, &tuning);
    CHECK_NEAR(0.0, 0.0, rig.drive.inverter.dead_more);
    CHECK_NEAR(0.0, 0.0, rig.drive.inverter.r_more_Ohm);
    rig.drive.inverter.r_more_Ohm = 0.25f;
    rig.drive.tuning = &tuning;
    lode_mode_retune(&rig.drive, &other);
    CHECK_NEAR(1e-6, 0.25 + (double)tuning.start.R_Ohm, rig.drive.inverter.r_more_Ohm);
}

static void test_a_lower_limit_bounds_the_speed_reference(void) {
    rig_t rig = steady(); // at 80 rad/s, 3 pole pairs
    lode_drive_tuning_t other = tuning;
    other.estimator.omega_limit = 120.0f;
    rig.drive.tuning = &other;
    lode_mode_retune(&rig.drive, &tuning);
    CHECK_NEAR(1e-4, 40.0, rig.drive.state.run.speed.reference_rad_s);
}

/// Without options nothing keeps the references' state up to date.
static void test_references_begin_anew_where_they_were_not_kept(void) {
    for (uint32_t options = 0u; options < 2u; options++) {
        rig_t rig = steady();
        lode_drive_tuning_t before = tuning;
        before.references.options = options;
        rig.drive.ref_A.d = -2.0f;
        rig.drive.state.run.references.id_A = -1.0f;
        lode_mode_retune(&rig.drive, &before);
        CHECK_NEAR(0.0, options == 0u ? -2.0 : -1.0, rig.drive.state.run.references.id_A);
    }
}

/// The guard's slots are long: a start leaves what it does to the others.
static void test_a_start_follows_in_all_slots_but_the_guards(void) {
    for (uint32_t n = 0u; n < (uint32_t)SLOT_COUNT; n++) {
        rig_t rig = fresh();
        lode_mode_switch_on(&rig.drive, LODE_MODE_START); // the command is OFF
        rig.drive.steps = n;
        lode_mode_follow(&rig.drive);
        const lode_slot_t slot = lode_slot_of(n);
        const bool guards = slot == SLOT_GUARD || slot == SLOT_GUARD_2;
        rig_expect(&rig, guards ? LODE_MODE_START : LODE_MODE_OFF);
    }
}

/// Below half of the speed from which it may take over, the estimator is set to the vector.
static void test_the_estimator_is_set_to_a_slow_vector(void) {
    static const float shares[] = {-0.49f, 0.49f, LODE_START_HOLD, 0.6f, 1.0f, -1.0f};
    for (size_t n = 0; n < sizeof shares / sizeof shares[0]; n++) {
        rig_t rig = fresh();
        lode_mode_switch_on(&rig.drive, LODE_MODE_START);
        const float omega = shares[n] * tuning.start.omega_ready;
        lode_start_reset(&rig.drive.state.start, (lode_sincos_t){0.6f, 0.8f}, omega, 1.0f);
        TEST_ASSERT_FALSE(lode_mode_seed(&rig.drive));
        const bool held = lode_abs(shares[n]) < LODE_START_HOLD;
        CHECK_NEAR(1e-3, held ? (double)omega : 0.0, rig.drive.estimator.pll.omega_rad_s);
        CHECK_NEAR(1e-3, held ? 0.6 : 0.0, lode_estimator_rotor(&rig.drive.estimator).sin);
    }
}

static void test_a_start_with_nothing_to_do_before_has_no_precharge(void) {
    lode_drive_config_t config = rig_config();
    config.start.pulses = LODE_OFF;
    config.start.signal_check = LODE_OFF;
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    rig_command(&rig, run_at(80.0));
    lode_mode_t before = LODE_MODE_OFF;
    for (int n = 0; n < 2000 && rig_telemetry(&rig).mode != LODE_MODE_START; n++) {
        before = rig_telemetry(&rig).mode;
        rig_step(&rig);
    }
    rig_expect(&rig, LODE_MODE_START);
    TEST_ASSERT_EQUAL_STRING("LODE_MODE_OFF", lode_mode_name(before));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_rotor_that_is_lost_has_two_thirds_of_the_checks);
    RUN_TEST(test_gates_that_switch_on_begin_without_a_past);
    RUN_TEST(test_run_begins_with_no_counts);
    RUN_TEST(test_a_vector_that_takes_the_rotor_back_begins_with_no_counts);
    RUN_TEST(test_what_the_vector_takes_over_with_the_rotor);
    RUN_TEST(test_a_longer_dead_time_leaves_less_beyond_it);
    RUN_TEST(test_what_was_not_measured_is_not_kept);
    RUN_TEST(test_a_lower_limit_bounds_the_speed_reference);
    RUN_TEST(test_references_begin_anew_where_they_were_not_kept);
    RUN_TEST(test_a_start_follows_in_all_slots_but_the_guards);
    RUN_TEST(test_the_estimator_is_set_to_a_slow_vector);
    RUN_TEST(test_a_start_with_nothing_to_do_before_has_no_precharge);
    return UNITY_END();
}
